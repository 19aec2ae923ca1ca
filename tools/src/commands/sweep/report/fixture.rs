//! A made-up sweep for tests: shaped like a real one, measured nowhere.

use super::{Pictures, Thumbnails};
use crate::commands::sweep::record::{
    EffectCost, Effects, Errors, Figures, Machine, Manifest, Outcome, Pass, Path, Record, Ring, Spread,
    Temporal, TemporalRing, Times, VERSION, View,
};
use macula::knobs::{Setting, Value};

const SIZES: [[u32; 2]; 2] = [[1280, 720], [1920, 1080]];
const RING_STARTS_DEG: [f64; 6] = [0.0, 2.0, 5.0, 10.0, 20.0, 40.0];

/// Settings with their share of the reference's samples and what scales their error.
fn settings() -> Vec<(Setting, f64, f64)> {
    let of = |method: &str, knob: &str, value: Value| {
        let setting = Setting::default().with("method", method).expect("a method");
        setting.with(knob, value).expect("a value")
    };
    let mut all = Vec::new();
    for sigma in [1.0, 1.4, 1.8, 2.4, 3.0, 4.0_f64] {
        all.push((of("kfr", "sigma", sigma.into()), 1.0 / sigma.powi(2), 1.0));
    }
    for alpha in [1.0, 2.0, 3.0] {
        all.push((of("kfr", "alpha", alpha.into()), 0.31, 1.5 - alpha / 8.0));
    }
    for scale in [0.4, 0.6, 0.8, 1.0, 1.4, 2.0_f64] {
        all.push((of("vafr", "acuity-scale", scale.into()), (0.17 * scale.powi(2)).min(0.9), 0.55));
    }
    for scale in [0.8, 1.0_f64] {
        all.push((of("vafr-planar", "acuity-scale", scale.into()), 0.2 * scale.powi(2), 0.62));
    }
    for delta in [1.5, 2.5_f64] {
        all.push((of("lafr", "lafr-delta", delta.into()), 1.0 / delta.powi(2), 1.1));
        all.push((of("rmfr", "rmfr-delta", delta.into()), 1.0 / delta.powi(2), 1.3));
    }
    all.push((of("visual-polar", "visual-polar-columns", 512.0.into()), 0.28, 1.4));
    all.push((of("guenter3", "guenter-slope", 1.3.into()), 0.24, 1.7));
    for texels in [512.0, 2048.0_f64] {
        all.push((of("full", "shadow-map-size", texels.into()), 0.9 + texels / 40_000.0, 0.02));
    }
    for filter in ["none", "fxaa"] {
        all.push((of("kfr", "lp-filter", filter.into()), if filter == "none" { 0.3 } else { 0.34 }, 0.9));
    }
    all
}

/// What the sweep was asked for.
pub fn manifest() -> Manifest {
    let view = |path, gaze: [f64; 2], yaw_deg| View { path, gaze, yaw_deg, step_mm: 0.0 };
    let gazes = [[0.5, 0.5], [0.22, 0.72], [0.8, 0.25]].map(|gaze| view(Path::Gaze, gaze, 0.0));
    let camera = (0..4).map(|step| view(Path::Camera, [0.5, 0.5], f64::from(step) * 0.1));
    let gaze = (0..4).map(|step| view(Path::GazeMove, [0.5 + f64::from(step) * 0.01, 0.5], 0.0));
    let base = Setting::default().with("sigma", 1.8).and_then(|base| base.with("lp-filter", "gaussian"));
    Manifest {
        version: VERSION,
        program: "0.1.0".into(),
        command: ["sweep", "hall", "--knob", "sigma=1,1.4,1.8", "-o", "out/a sweep"]
            .map(str::to_owned)
            .to_vec(),
        scene: "generated hall, 60 000 triangles, 64 lights".into(),
        sizes: SIZES.to_vec(),
        hfov_deg: 100.0,
        acuity: "40, 10, 6, 5, 4 cpd at 0, 10, 20, 30, 60 degrees".into(),
        base: base.and_then(|base| base.with("alpha", 4.0)).expect("a base"),
        reference: Setting::most_accurate(),
        settings: settings().into_iter().map(|(setting, ..)| setting).collect(),
        views: gazes.into_iter().chain(camera).chain(gaze).collect(),
        runs: 3,
        fvvdp: false,
    }
}

/// All settings at all sizes; at each size one has failed.
pub fn records() -> Vec<Record> {
    let settings = settings();
    let of_size = |size: [u32; 2]| {
        let record = move |(index, (setting, share, scale)): (usize, &(Setting, f64, f64))| Record {
            version: VERSION,
            index,
            size,
            setting: setting.clone(),
            machine: machine(),
            outcome: if index == 20 {
                Outcome::Failed("the LP-buffer needs 9.1 GiB <more than there is>; raise sigma".into())
            } else {
                Outcome::Measured(Box::new(figures(size, index, *share, *scale)))
            },
        };
        settings.iter().enumerate().map(record).collect::<Vec<_>>()
    };
    SIZES.into_iter().flat_map(of_size).collect()
}

fn machine() -> Machine {
    Machine {
        device: "llvmpipe (LLVM 19.1.7, 256 bits)".into(),
        driver: "llvmpipe Mesa 25.0.7".into(),
        cpu: "a processor with a \"name\" & more".into(),
        threads: 2,
        system: "Linux 6.1".into(),
    }
}

/// Figures of a setting that shades this share of the samples.
pub fn figures(size: [u32; 2], index: usize, share: f64, scale: f64) -> Figures {
    let pixels = f64::from(size[0]) * f64::from(size[1]);
    let wobble = ((index * 7919) % 13) as f64 / 13.0 - 0.5;
    let ratio = (0.09 + 0.92 * share) * (1.0 + 0.03 * wobble);
    let reference_ms = pixels / 921_600.0 * 82.0;
    // Even at all the reference's samples a foveated picture differs: the least that these make.
    let least = if scale > 0.1 { 4e-4 * scale } else { 0.0 };
    let acuity_rmse = least + 0.021 * scale * (1.0 - share.min(0.999)).powf(1.6) * (0.25 / (share + 0.12));
    let spread =
        |median: f64, by: f64| Spread { median, least: median * (1.0 - by), greatest: median * (1.0 + by) };
    let ms = ratio * reference_ms;
    let pass = |name: &str, gpu_ms: f64| Pass { name: name.into(), gpu_ms };
    let shared = ["culling", "shadow maps", "g-buffer"];
    let foveated = ["lp_shade", "lp_filter", "inverse", "native disc", "taa", "output", "clear"];
    let shares = [0.5, 0.1, 0.2, 0.1, 0.06, 0.03, 0.01];
    let common = shared.iter().zip([0.5, 3.1, 5.4]).map(|(name, ms)| pass(name, ms)).collect::<Vec<_>>();
    let own = foveated.iter().zip(shares).map(|(name, share)| pass(name, (ms - 9.0).max(0.5) * share));
    let full = [pass("full_shade", reference_ms - 12.0), pass("output", 3.0)];
    let ring = |at: usize| Ring {
        from_deg: RING_STARTS_DEG[at],
        to_deg: RING_STARTS_DEG.get(at + 1).copied(),
        rmse: Some(acuity_rmse * 0.5 * (at + 1) as f64),
        flip: (at < 5).then_some(acuity_rmse * 0.9 * (at + 1) as f64),
        acuity_rmse: Some(acuity_rmse * 0.3 * (at + 1) as f64),
    };
    let temporal = |ratio: Option<f64>| {
        let ring = |at: usize| TemporalRing {
            from_deg: RING_STARTS_DEG[at],
            to_deg: RING_STARTS_DEG.get(at + 1).copied(),
            variance: Some(acuity_rmse * 1e-3 * (at + 1) as f64),
            ratio: ratio.map(|ratio| ratio + 0.1 * at as f64),
        };
        (0..RING_STARTS_DEG.len()).map(ring).collect()
    };
    Figures {
        times: Times {
            pairs: 9,
            setting_ms: spread(ms, 0.05),
            reference_ms: spread(reference_ms, 0.04),
            ratio: spread(ratio, 0.05),
            ratio_interval: [ratio * 0.975, ratio * 1.03],
            ratio_confidence: 0.960_937_5,
            passes: common.iter().cloned().chain(own).collect(),
            reference_passes: common.iter().cloned().chain(full).collect(),
        },
        errors: Errors {
            rmse: acuity_rmse * 2.4,
            flip: acuity_rmse * 3.1,
            acuity_rmse,
            seam_residual: (index < 15).then_some(0.0007 * scale),
            rings: (0..RING_STARTS_DEG.len()).map(ring).collect(),
        },
        temporal: Temporal { camera: temporal(Some(1.1)), gaze: temporal(None) },
        samples_shaded: (pixels * share) as u64,
        memory_bytes: (pixels * 40.0 * (0.5 + share)) as u64,
        non_finite: 0,
        jod: None,
    }
}

/// Two effects that run and two left out.
pub fn effects() -> Effects {
    let effect = |name: &str, why: &str, runs, ms: f64| EffectCost {
        name: name.into(),
        why: why.into(),
        runs,
        gpu_ms: Spread { median: ms, least: ms - 0.2, greatest: ms + 0.3 },
        pairs: 9,
        most_changed: if runs { 212 } else { 0 },
    };
    Effects {
        effects: vec![
            effect("shadows", "64 lights, 4 of which cast shadows", true, 3.4),
            effect("reflections", "the floor's roughness is 0.08", true, 5.2),
            effect("fog", "the scene has no medium", false, 1.9),
            effect("depth of field", "the aperture is 0", false, 4.6),
        ],
        planned_ms: 33.4,
        forced_ms: 39.8,
    }
}

/// Small pictures for all settings.
pub fn thumbnails() -> Thumbnails {
    let mut thumbnails = Thumbnails::default();
    for (at, size) in SIZES.into_iter().enumerate() {
        thumbnails.references.insert(at, png(size, 0));
        for index in (0..settings().len()).filter(|index| *index != 20) {
            let pictures =
                Pictures { picture: png(size, index as u32), difference: png(size, 200 + index as u32) };
            thumbnails.settings.insert((at, index), pictures);
        }
    }
    thumbnails
}

fn png([width, height]: [u32; 2], seed: u32) -> Vec<u8> {
    let [width, height] = [width / 8, height / 8];
    let picture = image::RgbImage::from_fn(width, height, |x, y| {
        let dim = if seed >= 200 { 8 } else { 1 };
        image::Rgb(
            [x * 255 / width, y * 255 / height, (x / 10 + y / 10) % 2 * 90 + seed % 100]
                .map(|v| (v / dim) as u8),
        )
    });
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png).expect("a PNG");
    bytes.into_inner()
}
