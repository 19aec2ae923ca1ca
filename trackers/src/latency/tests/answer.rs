//! The estimator in a run.

use super::*;
use crate::estimator::{EstimatorSettings, FilterKind};
use crate::predict::PredictorKind;
use crate::recording::Screen;
use glam::DVec2;

fn raw(predictor: PredictorKind) -> EstimatorSettings {
    EstimatorSettings { predictor, filter: FilterKind::None, ..EstimatorSettings::default() }
}

/// 7 ms until the sample is there, a frame of 10 ms, 3 ms of display.
fn model() -> LatencyModel {
    let mut model = steady();
    model.frames_ahead = 1.0;
    for (stage, ms) in [(Stage::Readout, 7.0), (Stage::Gpu, 5.0), (Stage::Panel, 3.0)] {
        constant(&mut model, stage, ms);
    }
    model
}

#[test]
fn an_estimator_that_holds_is_the_run_without_one() {
    let recording = recording(2.0, MS, |time| 25.0 * time - 20.0);
    let session = SessionGaze::new(&recording).expect("a session");
    let settings = RunSettings::default();
    let mut answer = EstimatorAnswer::new(raw(PredictorKind::Hold), &recording);
    let asked = run_with(&session, &model(), &settings, 1, &mut answer).expect("a run");
    let held = run(&session, &model(), &settings, 1).expect("a run");
    assert_eq!(asked.frames.len(), held.frames.len());
    for (asked, held) in asked.frames.iter().zip(&held.frames) {
        assert_eq!((asked.sample, asked.age_ns), (held.sample, held.age_ns));
        let both = asked.direction.zip(held.direction);
        assert!(both.is_none_or(|(asked, held)| asked.abs_diff_eq(held, 1e-12)));
    }
    assert!((asked.error_deg().p50 - 25.0 * 20.0 * 1e-3).abs() < 1e-9, "{}", asked.error_deg().p50);
}

#[test]
fn an_estimator_is_asked_for_the_display_time_and_knows_no_later_sample() {
    let recording = recording(2.0, MS, |time| 25.0 * time - 20.0);
    let session = SessionGaze::new(&recording).expect("a session");
    let settings = RunSettings::default();
    let mut answer = EstimatorAnswer::new(raw(PredictorKind::ConstantVelocity), &recording);
    let asked = run_with(&session, &model(), &settings, 1, &mut answer).expect("a run");
    // An even movement: straight on is right, but for the first pictures and the rounding of an arc cosine.
    assert!(asked.error_deg().p95 < 1e-5, "{}", asked.error_deg().p95);
    let newest = answer.estimator().history().newest().map(|entry| entry.time_ns);
    let latch_ns = asked.frames.last().map(|frame| frame.latch_ns).expect("a frame");
    assert!(newest.is_some_and(|newest_ns| newest_ns <= latch_ns), "{newest:?} {latch_ns}");
    // Another run begins with nothing seen.
    answer.begin();
    assert_eq!(answer.direction_at(&Question { latch_ns: 0, display_ns: 0 }), None);
}

#[test]
fn points_on_a_known_display_are_directions() {
    let screen = Screen { size_px: DVec2::ONE, size_m: DVec2::new(0.5, 0.3), distance_m: 0.6 };
    let mut recording = Recording::new(RecordingInfo { screen: Some(screen), ..RecordingInfo::default() });
    let point = Some(DVec2::new(0.75, 0.5));
    for index in 0..200 {
        recording.push(&GazeSample {
            combined: EyeSample { valid: true, point, ..EyeSample::default() },
            ..GazeSample::at(index * MS)
        });
    }
    let session = SessionGaze::new(&recording).expect("a session");
    let mut answer = EstimatorAnswer::new(raw(PredictorKind::Hold), &recording);
    let asked = run_with(&session, &model(), &RunSettings::default(), 1, &mut answer).expect("a run");
    // A quarter of 0.5 m to the right, seen from 0.6 m.
    let expected = DVec3::new(0.125, 0.0, -0.6).normalize();
    let last = asked.frames.last().and_then(|frame| frame.direction);
    assert!(last.is_some_and(|direction| direction.abs_diff_eq(expected, 1e-12)), "{last:?}");
}
