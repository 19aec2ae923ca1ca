//! How often the true gaze lies within the stated radius, of a synthetic eye whose truth is known.

use super::*;
use crate::synthetic::{SyntheticEye, SyntheticSettings, TrackerSettings};
use std::collections::BTreeMap;

const MS: i64 = 1_000_000;
/// A display of 90 Hz.
const FRAME_NS: i64 = 11_111_111;

/// Error over radius of every answer, by kind and state.
type Ratios = BTreeMap<String, Vec<f64>>;

/// Two minutes of an eye, asked at every frame for `ahead_ms` after it with what has arrived by then.
fn asked(preset: &str, tracker: &str, aim: Aim, ahead_ms: i64, ratios: &mut Ratios) {
    let tracker = TrackerSettings::preset(tracker).expect("a tracker");
    let rate_hz = tracker.rate_hz;
    let settings = SyntheticSettings { tracker, ..SyntheticSettings::preset(preset).expect("a preset") };
    let mut eye = SyntheticEye::new(settings, 5).expect("an eye");
    let (recording, _) = eye.record(120_000 * MS, rate_hz).expect("a recording");
    let mut estimator = Estimator::new(EstimatorSettings { aim, ..EstimatorSettings::default() });
    let mut samples = recording.samples().peekable();
    // The first second is for learning the noise.
    for now_ns in (0..10_700).map(|frame| 1_000 * MS + frame * FRAME_NS) {
        while let Some(sample) = samples.next_if(|sample| sample.received_ns <= now_ns) {
            estimator.push(&sample);
        }
        let display_ns = now_ns + ahead_ms * MS;
        let Some(told) = estimator.estimate_at(display_ns) else { continue };
        let error_rad = told.direction_view.angle_between(eye.tracker().truth_at(display_ns).direction);
        let key = format!("{:?}, {}", told.kind, told.eye_state.name());
        ratios.entry(key).or_default().push(error_rad / told.error_radius_rad);
    }
}

/// At one standard deviation 63 % of a Gaussian error of two dimensions lie within, and that must hold for
/// whatever the eye does. Beyond, saccades that began unnoticed make the tail longer than its 98 %.
#[test]
fn the_true_gaze_lies_within_the_radius_as_often_as_stated() {
    for aim in [Aim::Landing, Aim::Trajectory] {
        let mut ratios = Ratios::new();
        for (preset, tracker) in [
            ("free-viewing", "eyelink"),
            ("free-viewing", "vive-pro-eye"),
            ("vr-exploration", "vive-pro-eye"),
            ("reading", "vive-pro-eye"),
            ("pursuit", "vive-pro-eye"),
        ] {
            for ahead_ms in [5, 25] {
                asked(preset, tracker, aim, ahead_ms, &mut ratios);
            }
        }
        for (key, ratios) in ratios.iter().filter(|(_, ratios)| ratios.len() >= 200) {
            let within = |radii: f64| {
                ratios.iter().filter(|ratio| **ratio <= radii).count() as f64 / ratios.len() as f64
            };
            let shares = [1.0, 2.0, 3.0].map(within);
            println!("{aim:?}: {key} ({}): {shares:.3?} within 1, 2, 3 radii", ratios.len());
            assert!(shares[0] >= 0.63 && shares[1] >= 0.85 && shares[2] >= 0.9, "{key}: {shares:?}");
        }
    }
}
