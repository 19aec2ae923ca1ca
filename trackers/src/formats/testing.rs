//! What the tests of several readers share.

use super::Input;
use crate::recording::Recording;
use glam::DVec2;
use std::path::Path;

/// A file in memory.
pub(crate) fn input(content: impl AsRef<[u8]>) -> Input {
    Input::of_bytes(Path::new("test"), content.as_ref().to_vec()).expect("not compressed")
}

/// How the points of the combined gaze go with the directions of the left eye, from -1 to 1, in x and y.
/// Points count y down and directions up: axes that are right give nearly (1, -1).
pub(crate) fn agreement(recording: &Recording) -> DVec2 {
    let told = |sample: crate::sample::GazeSample| {
        Some((sample.combined.point?, sample.left.direction.filter(|_| sample.left.valid)?.truncate()))
    };
    let pairs: Vec<_> = recording.samples().filter_map(told).collect();
    let count = pairs.len() as f64;
    let (points, directions) =
        pairs.iter().fold((DVec2::ZERO, DVec2::ZERO), |sums, pair| (sums.0 + pair.0, sums.1 + pair.1));
    let (point, direction) = (points / count, directions / count);
    let sum = |part: fn(DVec2, DVec2) -> DVec2| {
        pairs.iter().map(|pair| part(pair.0 - point, pair.1 - direction)).sum::<DVec2>()
    };
    let spread = (sum(|a, _| a * a) * sum(|_, b| b * b)).powf(0.5);
    sum(|a, b| a * b) / spread
}
