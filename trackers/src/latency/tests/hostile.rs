//! Disorder, holes, extremes, and the same from run to run.

use super::*;
use crate::estimate::EyeState;
use proptest::prelude::*;

#[test]
fn disorder_and_duplicates_change_nothing() {
    let (model, settings) = (preset("generic-90hz").expect("a preset"), RunSettings::default());
    let ordered = recording(2.0, 8 * MS, |time| 10.0 * (time * 3.0).sin());
    let mut shuffled = Recording::new(RecordingInfo::default());
    let samples: Vec<GazeSample> = ordered.samples().collect();
    for pair in samples.chunks(2) {
        pair.iter().rev().for_each(|sample| shuffled.push(sample));
    }
    // A stale copy first in the file: the later one stays.
    let mut doubled = Recording::new(RecordingInfo::default());
    for sample in &samples {
        doubled.push(&looking(sample.time_ns, 77.0));
        doubled.push(sample);
    }
    let of = |recording: &Recording| {
        let session = SessionGaze::new(recording).expect("a session");
        let run = run(&session, &model, &settings, 5).expect("a run");
        (session.duplicates(), run.error_deg(), run.age_ms(), run.stage_ms)
    };
    let (_, error, age, stages) = of(&ordered);
    assert_eq!(of(&shuffled), (0, error, age, stages));
    assert_eq!(of(&doubled), (samples.len() as u64, error, age, stages));
}

#[test]
fn the_same_seed_gives_the_same_run_and_another_another() {
    let model = preset("vive-pro-eye").expect("a preset");
    let session = session(2.0, 8 * MS, |time| 10.0 * (time * 3.0).sin());
    let of = |seed| run(&session, &model, &RunSettings::default(), seed).expect("a run").frames;
    assert_eq!(of(5), of(5));
    assert_ne!(of(5), of(6));
}

#[test]
fn a_long_hole_is_left_out_and_a_broken_time_does_not_hang() {
    let mut recording = recording(1.0, 10 * MS, |_| 0.0);
    for index in 0..100 {
        recording.push(&looking(3600 * 1000 * MS + index * 10 * MS, 1.0));
    }
    recording.push(&looking(i64::MAX - 5, 2.0));
    recording.push(&looking(i64::MIN + 5, 2.0));
    let session = SessionGaze::new(&recording).expect("a session");
    let run = run(&session, &steady(), &RunSettings::default(), 1).expect("a run");
    // 1 s of each part, and up to 1 s into each hole.
    assert!((300..=600).contains(&run.frames.len()), "{}", run.frames.len());
    let summary = run.summary(&session, run.budget(&session, None));
    assert!(summary.frames_not_judged > 0);
}

#[test]
fn a_session_that_is_too_long_is_refused() {
    let mut recording = Recording::new(RecordingInfo::default());
    for index in 0..60_000 {
        recording.push(&looking(index * 900 * MS, 0.0));
    }
    let session = SessionGaze::new(&recording).expect("a session");
    let error = run(&session, &steady(), &RunSettings::default(), 1).expect_err("15 h at 100 Hz");
    assert!(error.to_string().contains("cut it"), "{error}");
}

#[test]
fn recorded_arrivals_are_used_where_there_are_some() {
    let settings = RunSettings { arrival: ArrivalTimes::Recorded, ..RunSettings::default() };
    let plain = session(1.0, MS, |_| 0.0);
    let error = run(&plain, &steady(), &settings, 1).expect_err("no arrivals");
    assert!(error.to_string().contains("no arrival times"), "{error}");
    let mut recording = Recording::new(RecordingInfo::default());
    for index in 0..1000 {
        let mut sample = looking(index * MS, 0.0);
        sample.received_ns = sample.time_ns + 23 * MS;
        recording.push(&sample);
    }
    let session = SessionGaze::new(&recording).expect("a session");
    let run = run(&session, &preset("fove-0").expect("a preset"), &settings, 1).expect("a run");
    assert!((run.stage_ms[Stage::TrackerProcessing as usize] - 23.0).abs() < 1e-9);
    assert_eq!(run.stage_ms[Stage::Exposure as usize], 0.0);
    assert!((run.stage_ms.iter().sum::<f64>() - run.age_ms().mean).abs() < 1e-6);
}

#[test]
fn settings_out_of_range_are_refused() {
    let session = session(0.1, MS, |_| 0.0);
    let good = RunSettings::default();
    for bad in [
        RunSettings { radius_deg: f64::NAN, ..good.clone() },
        RunSettings { target_outside: 1.5, ..good.clone() },
        RunSettings { sweep_points: 0, ..good.clone() },
        RunSettings { sweep_to_ms: f64::INFINITY, ..good.clone() },
        RunSettings { suppression: Suppression { before_onset_ms: -1.0, after_end_ms: 0.0 }, ..good.clone() },
    ] {
        assert!(run(&session, &steady(), &bad, 1).is_err(), "{bad:?}");
    }
    assert!(run(&session, &LatencyModel::instant(f64::NAN), &good, 1).is_err());
}

#[test]
fn a_session_without_gaze_is_refused() {
    let mut recording = Recording::new(RecordingInfo::default());
    assert!(SessionGaze::new(&recording).is_err());
    for index in 0..10 {
        recording.push(&GazeSample::at(index));
    }
    let message = SessionGaze::new(&recording).expect_err("no gaze").to_string();
    assert!(message.contains("0 samples"), "{message}");
}

fn states() -> impl Strategy<Value = EyeState> {
    prop::sample::select(vec![
        EyeState::Fixation,
        EyeState::Saccade,
        EyeState::Pursuit,
        EyeState::Blink,
        EyeState::Lost,
        EyeState::Unknown,
    ])
}

fn times() -> impl Strategy<Value = i64> {
    prop_oneof![8 => -400 * MS..1600 * MS, 1 => any::<i64>()]
}

fn components() -> impl Strategy<Value = f64> {
    prop_oneof![8 => -1.0..1.0, 1 => any::<f64>()]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn nothing_panics_and_no_figure_is_nan(
        samples in prop::collection::vec((times(), [components(), components(), components()]), 2..150),
        intervals in prop::collection::vec((states(), times(), times()), 0..20),
        which in 0..PRESETS.len(),
        seed: u64,
        late_latch: bool,
    ) {
        let mut recording = Recording::new(RecordingInfo::default());
        for (time_ns, [x, y, z]) in samples {
            let mut sample = looking(time_ns, 0.0);
            sample.combined.direction = Some(DVec3::new(x, y, z));
            recording.push(&sample);
        }
        let Ok(session) = SessionGaze::new(&recording) else { return Ok(()) };
        let intervals: Vec<EyeInterval> = intervals
            .into_iter()
            .map(|(state, start_ns, end_ns)| EyeInterval { state, start_ns, end_ns })
            .collect();
        let session = session.with_intervals(&intervals);
        let model = LatencyModel { late_latch, ..preset(PRESETS[which].0).expect("a preset") };
        let settings = RunSettings { sweep_points: 9, ..RunSettings::default() };
        let run = run(&session, &model, &settings, seed).expect("a run");
        for frame in &run.frames {
            prop_assert!(frame.error_deg.is_none_or(|error| (0.0..=180.001).contains(&error)));
            prop_assert!(frame.age_ns.is_none_or(|age| age >= 0));
        }
        prop_assert!(run.stage_ms.iter().all(|ms| ms.is_finite() && *ms >= -1e-9), "{:?}", run.stage_ms);
        let summary = run.summary(&session, run.budget(&session, None));
        for share in [summary.outside_fraction, summary.outside_fraction_raw].into_iter().flatten() {
            prop_assert!((0.0..=1.0).contains(&share));
        }
        // serde_json writes NaN as null: only what may be unknown is null.
        let json = serde_json::to_value(&summary).expect("JSON");
        prop_assert!(json["age_ms"]["max"].is_f64() && json["error_deg"]["p95"].is_f64());
        let curve = json["budget"]["curve"].as_array().cloned().unwrap_or_default();
        prop_assert!(curve.iter().all(|point| point["radius_deg"].is_f64() && point["latency_ms"].is_f64()));
    }
}
