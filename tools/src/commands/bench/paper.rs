//! Published figures: kernel foveated rendering on a GTX 1080, sigma 1.8, alpha 4 (thesis of 2018,
//! tables 4.1 and 4.2).

use serde::Serialize;

/// Kinds of scene in table 4.2.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SceneKind {
    /// Textured meshes, there the Bistro with 1.02 million triangles.
    Triangles,
    /// Ray casting of primitives.
    RayMarched,
}

/// One row of table 4.2.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PublishedRate {
    /// What was rendered.
    pub scene: SceneKind,
    /// Display size, px.
    pub size: [u32; 2],
    /// Frames per second with full shading.
    pub full_fps: u32,
    /// Frames per second with KFR.
    pub kfr_fps: u32,
    /// The speed-up as printed.
    pub speedup: f64,
}

const fn rate(scene: SceneKind, size: [u32; 2], full_fps: u32, kfr_fps: u32, speedup: f64) -> PublishedRate {
    PublishedRate { scene, size, full_fps, kfr_fps, speedup }
}

/// Table 4.2.
pub const RATES: [PublishedRate; 6] = [
    rate(SceneKind::Triangles, [1920, 1080], 55, 110, 2.0),
    rate(SceneKind::Triangles, [2560, 1440], 31, 67, 2.2),
    rate(SceneKind::Triangles, [3840, 2160], 8, 23, 2.8),
    rate(SceneKind::RayMarched, [1920, 1080], 20, 57, 2.9),
    rate(SceneKind::RayMarched, [2560, 1440], 10, 30, 3.0),
    rate(SceneKind::RayMarched, [3840, 2160], 5, 16, 3.2),
];

/// One row of table 4.1: a frame of textured meshes at 1920x1080, milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PublishedPass {
    /// The pass as the table has it.
    pub name: &'static str,
    /// With full shading.
    pub full_ms: Option<f64>,
    /// With KFR.
    pub kfr_ms: Option<f64>,
}

const fn pass(name: &'static str, full_ms: f64, kfr_ms: f64) -> PublishedPass {
    PublishedPass { name, full_ms: Some(full_ms), kfr_ms: Some(kfr_ms) }
}

/// Table 4.1.
pub const PASSES: [PublishedPass; 7] = [
    pass("depth", 0.327, 0.309),
    pass("shadow", 3.744, 4.503),
    pass("G-buffer", 2.985, 3.034),
    pass("sky", 0.039, 0.039),
    pass("shading", 22.043, 6.674),
    PublishedPass { name: "inverse", full_ms: None, kfr_ms: Some(0.090) },
    pass("total", 29.138, 14.649),
];

/// The published speed-up at a size, where there is one.
pub fn speedup(scene: SceneKind, size: [u32; 2]) -> Option<f64> {
    RATES.iter().find(|rate| rate.scene == scene && rate.size == size).map(|rate| rate.speedup)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn printed_speedups_follow_from_the_rates() {
        for rate in RATES {
            let ratio = f64::from(rate.kfr_fps) / f64::from(rate.full_fps);
            // The rates are printed as whole numbers, hence the tolerance.
            assert!((ratio - rate.speedup).abs() < 0.11, "{rate:?}");
        }
        assert_eq!(speedup(SceneKind::RayMarched, [3840, 2160]), Some(3.2));
        assert_eq!(speedup(SceneKind::Triangles, [640, 480]), None);
    }
}
