//! What the eye does: suppression, loss and truth.

use super::*;
use crate::estimate::EyeState;
use crate::recording::{ExtraColumn, Screen, Space};
use glam::DVec2;

fn interval(state: EyeState, start_ms: i64, end_ms: i64) -> EyeInterval {
    EyeInterval { state, start_ns: start_ms * MS, end_ns: end_ms * MS }
}

/// At rest, a jump of 10 degrees from 500 to 540 ms, and at rest again until 1 s.
fn jump() -> SessionGaze {
    let session = session(1.0, MS, |time| ((time - 0.5) / 0.04).clamp(0.0, 1.0) * 10.0);
    session.with_intervals(&[
        interval(EyeState::Fixation, 540, 1000),
        interval(EyeState::Saccade, 500, 540),
        interval(EyeState::Fixation, 0, 500),
    ])
}

fn late(ms: f64) -> LatencyModel {
    let mut model = steady();
    constant(&mut model, Stage::Readout, ms);
    model
}

#[test]
fn suppression_hides_what_its_windows_cover() {
    let session = jump();
    let settings = RunSettings {
        radius_deg: 5.1,
        suppression: Suppression { before_onset_ms: 50.0, after_end_ms: 30.0 },
        ..RunSettings::default()
    };
    let run = run(&session, &late(100.0), &settings, 1).expect("a run");
    // Refreshes every 10 ms. Suppressed from 450 up to 570: 12 of them. No sample before 100 ms.
    assert_eq!(run.frames.iter().filter(|frame| frame.suppressed).count(), 12);
    let counted: Vec<i64> =
        run.frames.iter().filter(|frame| frame.counted).map(|frame| frame.display_ns / MS).collect();
    let expected: Vec<i64> = (10..45).chain(57..100).map(|refresh| refresh * 10).collect();
    assert_eq!(counted, expected);
    // The error is above the radius while the eye is that far ahead of what it was 100 ms before: from
    // just after 520 until before 620. Of the counted refreshes: 570, 580, 590, 600, 610.
    assert_eq!(run.outside_fraction(), Some(5.0 / 78.0));
    // With what is suppressed: 540 to 610, of 100..490 and 540..990.
    assert_eq!(run.outside_fraction_unsuppressed(), Some(8.0 / 86.0));
    // Of everything: 530 to 610, of 100..990.
    assert_eq!(run.outside_fraction_raw(), Some(9.0 / 90.0));
}

#[test]
fn states_come_from_the_intervals() {
    let run = run(&jump(), &steady(), &RunSettings::default(), 1).expect("a run");
    let state = |refresh: usize| run.frames[refresh].state;
    assert_eq!([state(49), state(50), state(53)], [EyeState::Fixation, EyeState::Saccade, EyeState::Saccade]);
    assert_eq!(state(54), EyeState::Fixation);
}

#[test]
fn over_a_blink_the_old_gaze_is_held_and_nothing_is_judged() {
    let mut recording = recording(1.0, MS, |time| time);
    let mut lossy = Recording::new(RecordingInfo::default());
    for (index, mut sample) in recording.samples().enumerate() {
        sample.combined.valid = !(300..500).contains(&index);
        lossy.push(&sample);
    }
    recording.info.notes.clear();
    let session = SessionGaze::new(&lossy).expect("a session");
    let session = session.with_intervals(&[
        interval(EyeState::Fixation, 0, 300),
        interval(EyeState::Blink, 300, 500),
        interval(EyeState::Fixation, 500, 1000),
    ]);
    let run = run(&session, &steady(), &RunSettings::default(), 1).expect("a run");
    let in_blink: Vec<&Frame> = run.frames.iter().filter(|frame| frame.state == EyeState::Blink).collect();
    assert_eq!(in_blink.len(), 20);
    for frame in in_blink {
        assert!(frame.over_loss && frame.sample == Some(299) && frame.truth.is_none() && !frame.counted);
    }
    let summary = run.summary(&session, run.budget(&session, None));
    assert_eq!((summary.frames_over_loss, summary.frames_not_judged, summary.frames_counted), (20, 20, 80));
}

#[test]
fn the_truth_of_a_synthetic_eye_is_the_judge() {
    // The samples are 2 degrees off, the columns say so.
    let mut recording = recording(1.0, MS, |_| 2.0);
    let truth = turned(0.0);
    for (name, value) in ["x", "y", "z"].into_iter().zip(truth.to_array()) {
        let values = vec![value; recording.len()];
        recording.extra.push(ExtraColumn { name: format!("true_direction_{name}"), values });
    }
    let session = SessionGaze::new(&recording).expect("a session");
    let run = run(&session, &steady(), &RunSettings::default(), 1).expect("a run");
    assert!(session.has_truth());
    assert!((run.error_deg().max - 2.0).abs() < 1e-9 && (run.error_deg().p50 - 2.0).abs() < 1e-9);
}

#[test]
fn points_need_a_display() {
    let screen =
        Screen { size_px: DVec2::new(1920.0, 1080.0), size_m: DVec2::new(0.6, 0.3), distance_m: 0.6 };
    let mut recording = Recording::new(RecordingInfo { space: Space::Display, ..RecordingInfo::default() });
    for index in 0..100 {
        let mut sample = GazeSample::at(index * 10 * MS);
        sample.combined =
            EyeSample { valid: true, point: Some(DVec2::new(1.0, 0.5)), ..EyeSample::default() };
        recording.push(&sample);
    }
    let message = SessionGaze::new(&recording).expect_err("no display").to_string();
    assert!(message.contains("display's size and distance"), "{message}");
    recording.info.screen = Some(screen);
    let session = SessionGaze::new(&recording).expect("a session");
    // Half of 0.6 m at 0.6 m: the angle whose tangent is a half.
    let azimuth = session.direction(3).map(|direction| direction.x.atan2(-direction.z).to_degrees());
    assert!(azimuth.is_some_and(|azimuth| (azimuth - 0.5_f64.atan().to_degrees()).abs() < 1e-9));
}
