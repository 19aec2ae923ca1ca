//! Published figures of VaFR (2025, GTX 2080 SUPER, both eyes).

use crate::commands::bench::paper::SceneKind;
use serde::Serialize;

/// A row of the published table I: shading samples for each eye, thousands. The display sizes are the
/// ones whose pixels the table's last column counts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PublishedSamples {
    /// Display size for each eye, px.
    pub size: [u32; 2],
    /// VaFR with the right eye reprojected, mean of both eyes.
    pub vafr_rep_k: u32,
    /// VaFR.
    pub vafr_k: u32,
    /// LaFR at delta 2.2.
    pub lafr_2_2_k: u32,
    /// LaFR at delta 1.8.
    pub lafr_1_8_k: u32,
    /// Full shading.
    pub full_k: u32,
}

const fn samples(size: [u32; 2], [rep, vafr, lafr_2_2, lafr_1_8, full]: [u32; 5]) -> PublishedSamples {
    PublishedSamples {
        size,
        vafr_rep_k: rep,
        vafr_k: vafr,
        lafr_2_2_k: lafr_2_2,
        lafr_1_8_k: lafr_1_8,
        full_k: full,
    }
}

/// Table I.
pub const SAMPLES: [PublishedSamples; 5] = [
    samples([2560, 1440], [637, 1_061, 761, 1_137, 3_686]),
    samples([3840, 2160], [743, 1_061, 1_713, 2_560, 8_294]),
    samples([5760, 3240], [849, 1_061, 3_855, 5_760, 18_662]),
    samples([7680, 4320], [955, 1_061, 6_854, 10_240, 33_177]),
    samples([11520, 6480], [1_035, 1_061, 15_423, 23_040, 74_649]),
];

/// The published range of VaFR's speed-ups over the paper's scenes (its text, and figures 11 and 16), where
/// it states one for a size.
pub fn speedups(kind: SceneKind, size: [u32; 2]) -> Option<[f64; 2]> {
    match (kind, size) {
        (SceneKind::Triangles, [7680, 4320]) => Some([7.6, 7.6]),
        (SceneKind::Triangles, [11520, 6480]) => Some([6.5, 9.29]),
        (SceneKind::RayMarched, [7680, 4320]) => Some([7.2, 10.6]),
        (SceneKind::RayMarched, [11520, 6480]) => Some([10.4, 16.4]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_s_last_column_counts_the_sizes_pixels() {
        for row in SAMPLES {
            let pixels = f64::from(row.size[0]) * f64::from(row.size[1]);
            assert!((pixels / 1000.0 - f64::from(row.full_k)).abs() <= 1.0, "{row:?}");
            // LaFR's buffer is the display's over delta, both ways.
            let lafr = pixels / (1.8 * 1.8) / 1000.0;
            assert!((lafr / f64::from(row.lafr_1_8_k) - 1.0).abs() < 2e-3, "{row:?}");
        }
    }
}
