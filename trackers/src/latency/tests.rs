//! Runs against closed forms.

use super::*;
use crate::recording::{Recording, RecordingInfo};
use crate::sample::{EyeSample, GazeSample};
use glam::DVec3;

pub(super) const MS: i64 = 1_000_000;

pub(super) fn turned(azimuth_deg: f64) -> DVec3 {
    let azimuth = azimuth_deg.to_radians();
    DVec3::new(azimuth.sin(), 0.0, -azimuth.cos())
}

/// A session of equal steps in which the eye looks where `azimuth_deg` says by time in seconds.
pub(super) fn session(seconds: f64, step_ns: i64, azimuth_deg: impl Fn(f64) -> f64) -> SessionGaze {
    SessionGaze::new(&recording(seconds, step_ns, azimuth_deg)).expect("a session")
}

pub(super) fn recording(seconds: f64, step_ns: i64, azimuth_deg: impl Fn(f64) -> f64) -> Recording {
    let mut recording = Recording::new(RecordingInfo::default());
    for index in 0..(seconds * 1e9 / step_ns as f64) as i64 {
        let time_ns = index * step_ns;
        recording.push(&looking(time_ns, azimuth_deg(time_ns as f64 * 1e-9)));
    }
    recording
}

pub(super) fn looking(time_ns: i64, azimuth_deg: f64) -> GazeSample {
    let direction = Some(turned(azimuth_deg));
    GazeSample {
        combined: EyeSample { valid: true, direction, ..EyeSample::default() },
        ..GazeSample::at(time_ns)
    }
}

pub(super) fn constant(model: &mut LatencyModel, stage: Stage, ms: f64) {
    let time = StageTime { delay: Delay::Constant { ms }, source: "a test".into(), guess: false };
    model.set(stage, time).expect("a time");
}

/// 100 Hz, the first refresh at the first sample.
pub(super) fn steady() -> LatencyModel {
    LatencyModel { display_phase: Some(0.0), ..LatencyModel::instant(100.0) }
}

#[test]
fn no_latency_no_error() {
    let session = session(2.0, MS, |time| 30.0 * time);
    let run = run(&session, &steady(), &RunSettings::default(), 1).expect("a run");
    assert_eq!(run.frames.len(), 200);
    assert_eq!((run.age_ms().max, run.error_deg().max), (0.0, 0.0));
    assert_eq!(run.outside_fraction(), Some(0.0));
}

#[test]
fn at_constant_velocity_the_error_is_velocity_times_latency() {
    let session = session(2.0, MS, |time| 40.0 * time - 40.0);
    let mut model = steady();
    model.frames_ahead = 2.0;
    // Half of the exposure counts: the sample's time is its middle. All in whole samples of 1 ms.
    for (stage, ms) in [
        (Stage::Exposure, 6.0),
        (Stage::Readout, 5.0),
        (Stage::TrackerProcessing, 4.0),
        (Stage::Polling, 1.0),
        (Stage::Wakeup, 2.0),
        (Stage::FilterDelay, 7.5),
        (Stage::Cpu, 3.0),
        (Stage::Gpu, 8.0),
        (Stage::Compositor, 2.0),
        (Stage::Scanout, 4.0),
        (Stage::Panel, 2.0),
    ] {
        constant(&mut model, stage, ms);
    }
    let run = run(&session, &model, &RunSettings::default(), 1).expect("a run");
    // 15 ms until the sample is there, no wait, two frames of 10 ms, 6 ms of display, 7.5 ms of filter.
    let age_ms = 15.0 + 20.0 + 6.0 + 7.5;
    let known: Vec<&Frame> = run.frames.iter().filter(|frame| frame.latch_ns >= 30 * MS).collect();
    assert!(known.len() > 180);
    for frame in known {
        assert_eq!(frame.age_ns, Some((age_ms * 1e6) as i64));
        let error = frame.error_deg.expect("an error");
        assert!((error - 40.0 * age_ms * 1e-3).abs() < 1e-9, "{error}");
    }
    // The parts: pacing is what the two frames leave over.
    let share = |stage: Stage| run.stage_ms[stage as usize];
    assert!((share(Stage::Exposure) - 3.0).abs() < 1e-9);
    assert!((share(Stage::Pacing) - (20.0 - 13.0)).abs() < 1e-9);
    assert!((share(Stage::SamplingWait)).abs() < 1e-9);
    let sum: f64 = run.stage_ms.iter().sum();
    assert!((sum - run.age_ms().mean).abs() < 1e-6, "{sum}");
}

#[test]
fn the_sampling_wait_is_uniform_when_the_rates_do_not_meet() {
    // 120.07 samples and 100 refreshes a second drift through all phases.
    let step_ns = 8_328_475;
    let session = session(100.0, step_ns, |_| 0.0);
    let run = run(&session, &steady(), &RunSettings::default(), 1).expect("a run");
    let mut waits: Vec<f64> =
        run.frames.iter().filter_map(|frame| frame.age_ns).map(|ns| ns as f64).collect();
    waits.sort_by(f64::total_cmp);
    let step = step_ns as f64;
    assert!(waits.iter().all(|wait| (0.0..step).contains(wait)));
    // Kolmogorov and Smirnov: the largest distance from the straight line.
    let count = waits.len() as f64;
    let distance =
        (0..waits.len()).map(|rank| (waits[rank] / step - rank as f64 / count).abs()).fold(0.0, f64::max);
    assert!(distance < 0.01, "{distance}");
    assert!((run.stage_ms[Stage::SamplingWait as usize] - step * 0.5e-6).abs() < 0.05);
}
