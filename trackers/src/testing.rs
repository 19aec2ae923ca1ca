//! What the unit tests of several modules share.

use std::path::{Path, PathBuf};

/// A file or folder of the shared data: in `MACULA_SHARED`, or else in `shared` beside the workspace or
/// a folder above it. `None`, with a printed line, where it is absent.
pub fn shared(relative: &str) -> Option<PathBuf> {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    let named = std::env::var_os("MACULA_SHARED").map(PathBuf::from);
    let beside = manifest.ancestors().skip(2).take(2).map(|folder| folder.join("shared"));
    let found =
        named.into_iter().chain(beside).map(|folder| folder.join(relative)).find(|path| path.exists());
    if found.is_none() {
        println!("skipped: no {relative} in the shared data; MACULA_SHARED says where that lies");
    }
    found
}

/// Share of a saccade covered at a share of its duration, by a velocity profile of the gamma shape
/// x exp(-x / fall) of van Opstal and van Gisbergen (1987), brought down to 0 at the end; summed up
/// step by step. With a `fall` of 0.9 the peak lies at 0.37 of the duration, 1.57 times the mean speed; with
/// 0.5 at 0.29 and 1.70 times.
pub fn gamma_saccade(share: f64, fall: f64) -> f64 {
    let speed = |x: f64| x * (-x / fall).exp() * (1.0 - x);
    let sum = |to: f64| (0..200).map(|step| speed(to * (f64::from(step) + 0.5) / 200.0)).sum::<f64>() * to;
    sum(share.clamp(0.0, 1.0)) / sum(1.0)
}
