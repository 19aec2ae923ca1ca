//! The budget against closed forms.

use super::*;
use crate::synthetic::{SyntheticEye, SyntheticSettings, TrackerSettings};

/// Runs at constant velocity, so that the radius needed is velocity times latency.
fn pursued(velocity_deg_s: f64, radius_deg: f64) -> (SessionGaze, LatencyRun, Budget) {
    let session = session(3.0, MS, |time| velocity_deg_s * time - 60.0);
    let mut model = steady();
    model.frames_ahead = 1.0;
    constant(&mut model, Stage::Readout, 12.0);
    constant(&mut model, Stage::Gpu, 6.0);
    constant(&mut model, Stage::Panel, 8.0);
    let settings = RunSettings { radius_deg, ..RunSettings::default() };
    let run = run(&session, &model, &settings, 1).expect("a run");
    let budget = run.budget(&session, None);
    (session, run, budget)
}

#[test]
fn at_constant_velocity_radius_and_latency_are_proportional() {
    let (_, _, budget) = pursued(40.0, 2.0);
    assert!((budget.latency_ms - 30.0).abs() < 1e-6);
    assert!(budget.needed_radius_deg.is_some_and(|radius| (radius - 1.2).abs() < 1e-6));
    // 2 degrees at 40 deg/s are 50 ms.
    assert!(budget.largest_latency_ms.is_some_and(|latency| (latency - 50.0).abs() < 0.1));
    assert!(!budget.beyond_sweep);
    // Each stage saves its own latency's worth: half of the 12 ms of read-out are 0.24 degrees.
    let readout = &budget.stages[Stage::Readout as usize];
    assert!(
        (readout.saved_if_half_deg - 0.24).abs() < 0.02 && (readout.saved_if_zero_deg - 0.48).abs() < 0.02
    );
    assert_eq!(budget.attack, Some(Stage::Readout));
    assert!((readout.share - 0.4).abs() < 1e-9);
}

#[test]
fn radius_and_latency_are_inverse_to_each_other() {
    let (_, _, budget) = pursued(40.0, 2.0);
    let mut last = 0.0;
    for ms in 1..=150 {
        let radius = budget.radius_for(f64::from(ms)).expect("a curve");
        assert!(radius >= last);
        last = radius;
        let back = budget.latency_for(radius).expect("a latency");
        assert!((back - f64::from(ms)).abs() < 1e-6, "{ms}: {back}");
    }
    for pair in budget.curve.windows(2) {
        assert!(pair[0].latency_ms < pair[1].latency_ms && pair[0].radius_deg <= pair[1].radius_deg);
        assert!(pair[0].outside_fraction <= pair[1].outside_fraction);
    }
}

/// What the sweep says of a latency must come out of the model itself when its tracker is that much slower.
#[test]
fn the_largest_latency_is_that_of_a_slower_model() {
    let settings = SyntheticSettings {
        tracker: TrackerSettings::preset("perfect").expect("a tracker"),
        ..SyntheticSettings::preset("free-viewing").expect("a preset")
    };
    let (recording, truth) =
        SyntheticEye::new(settings, 3).and_then(|mut eye| eye.record(120_000 * MS, 1000.0)).expect("an eye");
    let intervals: Vec<EyeInterval> = truth
        .events
        .iter()
        .map(|event| EyeInterval {
            state: event.kind.state(),
            start_ns: event.start_ns,
            end_ns: event.end_ns,
        })
        .collect();
    let session = SessionGaze::new(&recording).expect("a session").with_intervals(&intervals);
    let known = Known { value: 117.0, source: "a test".into(), guess: false };
    let model = |readout_ms: f64, filter_ms: f64| {
        let mut model = LatencyModel { tracker_rate_hz: Some(known.clone()), frames_ahead: 1.0, ..steady() };
        constant(&mut model, Stage::Readout, readout_ms);
        constant(&mut model, Stage::FilterDelay, filter_ms);
        constant(&mut model, Stage::Gpu, 6.0);
        model
    };
    let settings = RunSettings { radius_deg: 1.5, ..RunSettings::default() };
    for filter_ms in [0.0, 12.0] {
        let made = run(&session, &model(10.0, filter_ms), &settings, 1).expect("a run");
        let budget = made.budget(&session, None);
        let largest_ms = budget.largest_latency_ms.expect("a latency");
        assert!(!budget.beyond_sweep && largest_ms > budget.latency_ms + 10.0, "{budget:?}");
        let outside = |latency_ms: f64| {
            let slower_ms = 10.0 + latency_ms - budget.latency_ms;
            let slower = run(&session, &model(slower_ms, filter_ms), &settings, 1).expect("a run");
            let counted = slower.frames.iter().filter(|frame| frame.counted);
            let mean_ms =
                Figures::of(counted.filter_map(|frame| frame.age_ns).map(|ns| ns as f64 * 1e-6)).mean;
            // How the clocks meet changes the wait for a sample.
            assert!((mean_ms - latency_ms).abs() < 2.0, "{mean_ms} of {latency_ms}");
            slower.outside_fraction().expect("counted")
        };
        // The points of the sweep are 5 ms apart.
        let (below, above) = (outside(largest_ms - 4.0), outside(largest_ms + 4.0));
        let target = settings.target_outside;
        assert!(below <= target && above >= target, "{filter_ms}: {below} and {above} at {largest_ms}");
    }
}

#[test]
fn the_ends_of_the_sweep_are_told() {
    // At rest every latency will do.
    let (_, _, budget) = pursued(0.0, 2.0);
    assert!(budget.beyond_sweep);
    assert_eq!(budget.attack, None);
    // The eye is never less than 1 degree off: no latency will do.
    let mut recording = recording(1.0, MS, |_| 1.0);
    for (name, value) in ["x", "y", "z"].into_iter().zip([0.0, 0.0, -1.0]) {
        let values = vec![value; recording.len()];
        let name = format!("true_direction_{name}");
        recording.extra.push(crate::recording::ExtraColumn { name, values });
    }
    let session = SessionGaze::new(&recording).expect("a session");
    let settings = RunSettings { radius_deg: 0.5, ..RunSettings::default() };
    let run = run(&session, &steady(), &settings, 1).expect("a run");
    let budget = run.budget(&session, None);
    assert_eq!((budget.largest_latency_ms, budget.beyond_sweep), (None, false));
    assert!(budget.needed_radius_deg.is_some_and(|radius| (radius - 1.0).abs() < 1e-9));
}

#[test]
fn the_summary_has_the_names_of_its_interface() {
    let (session, run, budget) = pursued(40.0, 2.0);
    let json = serde_json::to_value(run.summary(&session, budget)).expect("JSON");
    for name in ["p50", "p95", "max"] {
        assert!(json["age_ms"][name].is_f64() && json["error_deg"][name].is_f64());
    }
    assert!((json["age_ms"]["p50"].as_f64().expect("a number") - 30.0).abs() < 1e-9);
    assert_eq!(json["outside_fraction"], 0.0);
    assert_eq!(json["budget"]["attack"], "readout");
    assert!(json["budget"]["largest_latency_ms"].is_f64());
    assert_eq!(json["budget"]["references"][0]["to_ms"], 70.0);
}
