use super::*;
use crate::estimate::EyeState;
use crate::testing::gamma_saccade;

/// Looks `deg` to the right and `up` degrees up.
fn at_deg(deg: f64) -> DVec3 {
    let angle = deg.to_radians();
    DVec3::new(angle.sin(), 0.0, -angle.cos())
}

fn deg_of(direction: DVec3) -> f64 {
    direction.x.atan2(-direction.z).to_degrees()
}

fn entry(time_ns: i64, deg: f64) -> Entry {
    let direction = at_deg(deg);
    Entry { time_ns, direction, smoothed: direction, valid: true, ..Entry::default() }
}

fn phase(state: EyeState, since_ns: i64, deg: f64, deg_s: f64) -> Phase {
    let along = at_deg(deg).cross(DVec3::NEG_Y);
    let velocity = Velocity { deg_s: along * -deg_s, middle_ns: 0, span_s: 0.01 };
    Phase { state, since_ns, onset: at_deg(0.0), velocity, noise_deg_s: 3.0, jitter_deg: 0.04 }
}

/// Feeds uniform motion of 20 deg/s at 1 kHz and returns the last time.
fn pursue(predictor: &mut dyn Predictor) -> i64 {
    for ms in 0..200_i64 {
        let deg = ms as f64 * 0.02;
        predictor.push(&entry(ms * 1_000_000, deg), &phase(EyeState::Pursuit, 0, deg, 20.0));
    }
    199_000_000
}

#[test]
fn uniform_motion_is_continued() {
    for (kind, expected_deg) in [
        (PredictorKind::Hold, 3.98),
        (PredictorKind::ConstantVelocity, 3.98 + 0.6),
        (PredictorKind::Kalman, 3.98 + 0.6),
        (PredictorKind::Landing, 3.98 + 0.6),
        // The gate opened at 180 ms and looked 20 ms ahead.
        (PredictorKind::Gate20, 3.6 + 0.4),
    ] {
        let mut predictor = kind.make();
        assert_eq!(predictor.predict(0), None);
        let last_ns = pursue(predictor.as_mut());
        let told = deg_of(predictor.predict(last_ns + 30_000_000).expect("fed"));
        assert!((told - expected_deg).abs() < 0.01, "{}: {told}, not {expected_deg}", predictor.name());
        assert_eq!(predictor.landing(), None);
        predictor.reset();
        assert_eq!(predictor.predict(0), None);
    }
}

#[test]
fn the_horizon_is_bounded_and_times_before_give_the_last_sample() {
    for kind in PredictorKind::ALL {
        let mut predictor = kind.make();
        let last_ns = pursue(predictor.as_mut());
        let far = predictor.predict(i64::MAX).expect("fed");
        let near = predictor.predict(last_ns + MAX_HORIZON_NS).expect("fed");
        assert!(far.abs_diff_eq(near, 1e-12) && far.is_finite(), "{kind:?}");
        if kind != PredictorKind::Gate20 {
            assert!((deg_of(predictor.predict(i64::MIN).expect("fed")) - 3.98).abs() < 0.01, "{kind:?}");
        }
        assert_eq!(PredictorKind::of_name(predictor.name()), Some(kind));
    }
}

#[test]
fn the_gate_computes_once_in_20_ms_and_only_while_the_eye_moves() {
    let mut gate = Gate20::default();
    for ms in 0..400_i64 {
        let moves = (100..200).contains(&ms);
        let state = if moves { EyeState::Saccade } else { EyeState::Fixation };
        gate.push(&entry(ms * 1_000_000, 5.0), &phase(state, 0, 5.0, if moves { 100.0 } else { 0.0 }));
    }
    // The first sample, 100, 120, 140, 160 and 180 ms, and the stop at 200 ms.
    assert_eq!(gate.computations(), 7);
    assert!((deg_of(gate.predict(0).expect("fed")) - 5.0).abs() < 1e-9);
}

/// Saccades of the gamma shape, the larger the more skewed: other shapes than the template's.
#[test]
fn half_a_saccade_tells_its_end() {
    for (amplitude, duration_ms, fall) in [(2.0, 25, 0.9), (5.0, 32, 0.8), (10.0, 43, 0.7), (20.0, 65, 0.5)] {
        let course = |ms: i32| amplitude * gamma_saccade(f64::from(ms) / f64::from(duration_ms), fall);
        let mut predictor = LandingPredictor::default();
        for ms in -100..=duration_ms / 2 {
            let deg = course(ms);
            let state = if ms >= 6 { EyeState::Saccade } else { EyeState::Fixation };
            predictor.push(&entry(i64::from(ms) * 1_000_000, deg), &phase(state, 0, deg, 0.0));
        }
        let landing = predictor.landing().expect("in flight");
        let off = deg_of(landing.gaze) - amplitude;
        let held = amplitude - course(duration_ms / 2);
        assert!(off.abs() < 0.5 * held, "{amplitude} deg: off by {off}, held by {held}");
        let expected_ms = f64::from(duration_ms);
        let told_ms = landing.time_ns as f64 * 1e-6;
        assert!((told_ms - expected_ms).abs() < 0.3 * expected_ms, "{amplitude} deg: lands at {told_ms}");
        let (now_ns, end) = (i64::from(duration_ms / 2) * 1_000_000, deg_of(landing.gaze));
        let mut before = deg_of(predictor.predict(now_ns).expect("fed"));
        for ahead_ms in 1..100 {
            let told = deg_of(predictor.predict(now_ns + ahead_ms * 1_000_000).expect("fed"));
            assert!(told >= before - 1e-9 && told <= end + 1e-9, "{told} after {before}, end {end}");
            before = told;
        }
        assert!((before - end).abs() < 1e-9);
    }
}

#[test]
fn a_saccade_that_is_over_is_held() {
    let mut predictor = LandingPredictor::default();
    for ms in 0..40_i64 {
        let state = if (5..30).contains(&ms) { EyeState::Saccade } else { EyeState::Fixation };
        predictor.push(&entry(ms * 1_000_000, ms.min(30) as f64 * 0.2), &phase(state, 5_000_000, 0.0, 50.0));
    }
    assert_eq!(predictor.landing(), None);
    assert!(predictor.predict(90_000_000).is_some_and(|gaze| (deg_of(gaze) - 6.0).abs() < 1e-9));
}
