use super::*;
use crate::sample::{EyeSample, HeadPose};
use crate::testing::gamma_saccade;
use proptest::prelude::*;

const MS: i64 = 1_000_000;

/// Looks `deg` to the right.
fn at_deg(deg: f64) -> DVec3 {
    let angle = deg.to_radians();
    DVec3::new(angle.sin(), 0.0, -angle.cos())
}

fn deg_of(direction: DVec3) -> f64 {
    direction.x.atan2(-direction.z).to_degrees()
}

fn looking(time_ns: i64, deg: f64) -> GazeSample {
    let eye = EyeSample { valid: true, direction: Some(at_deg(deg) * 2.0), ..EyeSample::default() };
    GazeSample { combined: eye, ..GazeSample::at(time_ns) }
}

fn one_eyed(time_ns: i64, deg: f64) -> GazeSample {
    let sample = looking(time_ns, deg);
    GazeSample { combined: EyeSample::default(), left: sample.combined, ..sample }
}

/// A fixation of `ms` milliseconds at 1 kHz, the last sample at `(ms - 1)` ms.
fn fixating(settings: EstimatorSettings, ms: i64, deg: f64) -> Estimator {
    let mut estimator = Estimator::new(settings);
    for time in 0..ms {
        assert_eq!(estimator.push(&looking(time * MS, deg)), Pushed::Kept);
    }
    estimator
}

fn kind_at(estimator: &Estimator, time_ns: i64) -> Option<EstimateKind> {
    estimator.estimate_at(time_ns).map(|estimate| estimate.kind)
}

#[test]
fn each_kind_has_its_time() {
    let mut estimator = Estimator::new(EstimatorSettings::default());
    assert_eq!(estimator.estimate_at(0), None);
    for index in 0..20 {
        estimator.push(&looking(index * 10 * MS, 4.0));
    }
    use EstimateKind::{Held, Interpolated, Measured, Predicted, Stale};
    let (last, none) = (190 * MS, LossPolicy::default().none_after_ns);
    for (time_ns, expected) in [
        (100 * MS, Some(Measured)),
        (100 * MS + 500_000, Some(Measured)),
        (100 * MS + 500_001, Some(Interpolated)),
        (104 * MS, Some(Interpolated)),
        (110 * MS - 500_001, Some(Interpolated)),
        (110 * MS - 500_000, Some(Measured)),
        (last, Some(Measured)),
        (last + 500_000, Some(Measured)),
        (last + 500_001, Some(Predicted)),
        (last + 20 * MS, Some(Predicted)),
        (last + 100 * MS, Some(Predicted)),
        (last + 101 * MS, Some(Held)),
        (last + 200 * MS, Some(Held)),
        (last + 201 * MS, Some(Stale)),
        (last + none, Some(Stale)),
        (last + none + 1, None),
        (i64::MAX, None),
        (-500 * MS, Some(Held)),
        (i64::MIN, Some(Held)),
    ] {
        assert_eq!(kind_at(&estimator, time_ns), expected, "{time_ns}");
    }
    // A sample is missing between 190 and 210 ms.
    estimator.push(&looking(210 * MS, 4.0));
    assert_eq!(kind_at(&estimator, 200 * MS), Some(Interpolated));
    // Two seconds are no gap to interpolate over.
    estimator.push(&looking(2_210 * MS, 4.0));
    assert_eq!(kind_at(&estimator, 1_000 * MS), Some(Held));
}

#[test]
fn between_two_samples_lies_the_great_circle() {
    let settings = EstimatorSettings { filter: FilterKind::None, ..EstimatorSettings::default() };
    let mut estimator = Estimator::new(settings);
    for time in 0..4 {
        estimator.push(&looking(time * 4 * MS, 0.0));
    }
    estimator.push(&looking(32 * MS, 60.0));
    let estimate = estimator.estimate_at(22 * MS).expect("between 12 and 32 ms");
    assert!((deg_of(estimate.direction_view) - 30.0).abs() < 1e-9, "{estimate:?}");
    assert!((estimate.direction_view.length() - 1.0).abs() < 1e-12);
    assert_eq!((estimate.kind, estimate.age_ns), (EstimateKind::Interpolated, -10 * MS));
}

#[test]
fn a_blink_is_held_then_widened_then_none() {
    let mut estimator = fixating(EstimatorSettings::default(), 300, 7.0);
    let blind = |time_ns| GazeSample::at(time_ns);
    for time in 300..500 {
        estimator.push(&blind(time * MS));
    }
    let held = estimator.estimate_at(510 * MS).expect("held");
    assert_eq!((held.kind, held.eye_state), (EstimateKind::Held, EyeState::Blink));
    assert!((deg_of(held.direction_view) - 7.0).abs() < 1e-6);
    for time in 500..1500 {
        estimator.push(&blind(time * MS));
    }
    let wide = estimator.estimate_at(1510 * MS).expect("wide");
    assert_eq!((wide.kind, wide.eye_state), (EstimateKind::Held, EyeState::Lost));
    assert!(wide.error_radius_rad > 3.0 * held.error_radius_rad);
    assert!((deg_of(wide.direction_view) - 7.0).abs() < 1e-6);
    for time in 1500..2400 {
        estimator.push(&blind(time * MS));
    }
    assert_eq!(estimator.estimate_at(2410 * MS), None);
    // It comes back with the first valid sample.
    estimator.push(&looking(2420 * MS, -3.0));
    let back = estimator.estimate_at(2420 * MS).expect("back");
    assert_eq!(back.kind, EstimateKind::Measured);
    assert!((deg_of(back.direction_view) + 3.0).abs() < 1e-6);
}

/// Each step of the policy, to the nanosecond.
#[test]
fn the_steps_of_a_loss_come_at_their_times() {
    use EstimateKind::{Held, Predicted};
    let loss = LossPolicy {
        bridge_ns: 30 * MS,
        one_eye_after_ns: 0,
        hold_ns: 90 * MS,
        stale_after_ns: 10_000 * MS,
        none_after_ns: 250 * MS,
    };
    let settings = EstimatorSettings { loss, ..EstimatorSettings::default() };
    let last = 299 * MS;
    for (unseen_ns, expected) in [(30 * MS, Predicted), (30 * MS + 1, Held)] {
        let mut estimator = fixating(settings, 300, 7.0);
        estimator.push(&GazeSample::at(last + unseen_ns));
        assert_eq!(kind_at(&estimator, last + unseen_ns + MS), Some(expected), "{unseen_ns}");
    }
    let estimator = fixating(settings, 300, 7.0);
    let radius_deg =
        |after_ns: i64| estimator.estimate_at(last + after_ns).map(|told| told.error_radius_rad.to_degrees());
    // Until the hold is over the radius is the root of 1 + (10 t)^2; then 30 deg/s come on top.
    let usual = |seconds: f64| (1.0 + (10.0 * seconds).powi(2)).sqrt();
    for (after_ms, widened_deg) in [(90, 0.0), (91, 0.03), (190, 3.0), (250, 4.8)] {
        let expected = usual(f64::from(after_ms) * 1e-3) + widened_deg;
        let told = radius_deg(i64::from(after_ms) * MS).expect("known");
        assert!((told - expected).abs() < 0.01, "{after_ms} ms: {told}, not {expected}");
    }
    assert_eq!(radius_deg(250 * MS + 1), None);
}

/// One eye sees 2 deg beside the mean of both. For 40 ms both are awaited, then one stands in.
#[test]
fn one_eye_stands_in_after_its_time() {
    let loss = LossPolicy { one_eye_after_ns: 40 * MS, ..LossPolicy::default() };
    let mut estimator = fixating(EstimatorSettings { loss, ..EstimatorSettings::default() }, 300, 7.0);
    let both = estimator.estimate_at(299 * MS).expect("both");
    for ms in 1..=40 {
        estimator.push(&one_eyed((299 + ms) * MS, 9.0));
        let told = estimator.estimate_at((299 + ms) * MS).expect("awaited");
        assert!((deg_of(told.direction_view) - 7.0).abs() < 1e-6, "{ms} ms");
        assert_eq!(told.eye_state, EyeState::Fixation);
    }
    assert_eq!(kind_at(&estimator, 340 * MS), Some(EstimateKind::Held));
    estimator.push(&one_eyed(340 * MS, 9.0));
    let one = estimator.estimate_at(340 * MS).expect("one");
    assert_eq!((one.kind, one.eye_state), (EstimateKind::Measured, EyeState::Fixation));
    assert!((deg_of(one.direction_view) - 9.0).abs() < 1e-6);
    let ratio = one.error_radius_rad / both.error_radius_rad;
    assert!((ratio - std::f64::consts::SQRT_2).abs() < 0.02, "{ratio}");
    // Both again are believed at once.
    estimator.push(&looking(341 * MS, 7.0));
    let back = estimator.estimate_at(341 * MS).expect("both");
    assert!((deg_of(back.direction_view) - 7.0).abs() < 1e-6);
}

#[test]
fn gaze_told_behind_closed_lids_is_not_believed() {
    let mut estimator = fixating(EstimatorSettings::default(), 300, 7.0);
    for time in 300..400 {
        let mut sample = looking(time * MS, 7.0 + (time - 300) as f64 * 0.1);
        sample.left.openness = Some(0.05);
        estimator.push(&sample);
    }
    let held = estimator.estimate_at(405 * MS).expect("held");
    assert_eq!((held.kind, held.eye_state), (EstimateKind::Held, EyeState::Blink));
    assert!((deg_of(held.direction_view) - 7.0).abs() < 1e-6);
}

#[test]
fn a_source_that_stalls_is_stale_until_it_recovers() {
    let mut estimator = fixating(EstimatorSettings::default(), 300, 1.0);
    let radius = |estimator: &Estimator| estimator.estimate_at(310 * MS).expect("known").error_radius_rad;
    let fresh = radius(&estimator);
    estimator.on_event(&SourceEvent::Stalled { since_ns: 299 * MS });
    assert_eq!(kind_at(&estimator, 310 * MS), Some(EstimateKind::Stale));
    assert!(radius(&estimator) >= fresh);
    estimator.on_event(&SourceEvent::Recovered { after_ns: 5 * MS });
    estimator.on_event(&SourceEvent::Sample(looking(305 * MS, 1.0)));
    assert_eq!(kind_at(&estimator, 310 * MS), Some(EstimateKind::Predicted));
    estimator.on_event(&SourceEvent::Disconnected { why: "pulled".into() });
    assert_eq!(kind_at(&estimator, 310 * MS), Some(EstimateKind::Stale));
}

#[test]
fn what_is_absurd_keeps_the_last_valid_gaze() {
    let mut estimator = fixating(EstimatorSettings::default(), 300, 5.0);
    for (index, bad) in [DVec3::NAN, DVec3::ZERO, DVec3::INFINITY].into_iter().enumerate() {
        let mut sample = looking((300 + 15 * index as i64) * MS, 0.0);
        sample.combined.direction = Some(bad);
        estimator.push(&sample);
    }
    let estimate = estimator.estimate_at(340 * MS).expect("kept");
    assert_eq!(estimate.kind, EstimateKind::Held);
    assert!((deg_of(estimate.direction_view) - 5.0).abs() < 1e-6);
    for broken in [i64::MAX, i64::MIN, 299 * MS, 0] {
        assert!(matches!(estimator.push(&looking(broken, 80.0)), Pushed::Late | Pushed::Suspect));
    }
    let after = estimator.estimate_at(340 * MS).expect("kept");
    assert!((deg_of(after.direction_view) - 5.0).abs() < 1e-6);
}

#[test]
fn a_clock_that_jumps_does_not_lose_the_gaze() {
    let mut estimator = fixating(EstimatorSettings::default(), 300, 5.0);
    let jump = 100_000_000 * MS;
    assert_eq!(estimator.push(&GazeSample::at(jump)), Pushed::Suspect);
    assert_eq!(estimator.push(&GazeSample::at(jump + MS)), Pushed::Restarted);
    let estimate = estimator.estimate_at(jump + 2 * MS).expect("kept");
    assert_eq!(estimate.kind, EstimateKind::Held);
    assert!((deg_of(estimate.direction_view) - 5.0).abs() < 1e-6);
    // Nor does it count as predicted where the policy holds for a moment only.
    let loss = LossPolicy { hold_ns: 5 * MS, ..LossPolicy::default() };
    let mut estimator = fixating(EstimatorSettings { loss, ..EstimatorSettings::default() }, 300, 5.0);
    estimator.push(&GazeSample::at(jump));
    estimator.push(&GazeSample::at(jump + MS));
    assert_eq!(kind_at(&estimator, jump + 2 * MS), Some(EstimateKind::Held));
}

/// The same samples at times since 1970 give the same answers to the last bit as at times since the start.
#[test]
fn answers_do_not_depend_on_the_origin_of_time() {
    let epoch_ns = 1_764_000_000_123_456_789;
    let told = |offset_ns: i64| {
        let mut estimator = Estimator::new(EstimatorSettings::default());
        let mut told = Vec::new();
        for ms in 0..900_i64 {
            let deg = 12.0 * gamma_saccade(((ms % 300) as f64 - 200.0) / 45.0, 0.7);
            let lost = (450..480).contains(&ms);
            let time_ns = offset_ns + ms * MS;
            estimator.push(&if lost { GazeSample::at(time_ns) } else { looking(time_ns, deg) });
            told.extend(
                [-7 * MS - 400_001, 0, 25 * MS].map(|ahead_ns| estimator.estimate_at(time_ns + ahead_ns)),
            );
        }
        told
    };
    assert_eq!(told(0), told(epoch_ns));
}

/// Gaze fixed in the world while the head turns left at 50 deg/s: in view space it goes right, and the
/// estimate must lead there.
#[test]
fn the_head_goes_on_turning() {
    let mut estimator = Estimator::new(EstimatorSettings::default());
    for time in 0..300_i64 {
        let turned_deg = time as f64 * 0.05;
        let head = HeadPose {
            position_m: DVec3::ZERO,
            world_from_view: DQuat::from_rotation_y(turned_deg.to_radians()),
        };
        estimator.push(&GazeSample { head: Some(head), ..looking(time * MS, turned_deg) });
    }
    let estimate = estimator.estimate_at(329 * MS).expect("ahead");
    assert_eq!((estimate.kind, estimate.eye_state), (EstimateKind::Predicted, EyeState::Fixation));
    let expected_deg = 329.0 * 0.05;
    assert!((deg_of(estimate.direction_view) - expected_deg).abs() < 0.02, "{estimate:?}");
}

#[test]
fn a_saccade_is_answered_with_its_landing() {
    let mut estimator = fixating(EstimatorSettings::default(), 300, 0.0);
    // A saccade of 10 deg in 43 ms, half of it seen.
    for ms in 0..=22_i64 {
        let deg = 10.0 * gamma_saccade(ms as f64 / 43.0, 0.7);
        estimator.push(&looking((300 + ms) * MS, deg));
    }
    let estimate = estimator.estimate_at(330 * MS).expect("in flight");
    assert_eq!(estimate.eye_state, EyeState::Saccade);
    assert!((deg_of(estimate.direction_view) - 10.0).abs() < 2.5, "{estimate:?}");
    let trajectory = EstimatorSettings { aim: Aim::Trajectory, ..EstimatorSettings::default() };
    let calm = fixating(trajectory, 300, 0.0).estimate_at(330 * MS).expect("at rest");
    assert!(estimate.error_radius_rad > calm.error_radius_rad);
    // Until it lands, the eye is on its way, and the radius says so: by then to where it truly is, and
    // beyond the horizon of the prediction, where the last gaze is held, to the landing.
    for ms in [23, 26, 30, 35] {
        let told = estimator.estimate_at((300 + ms) * MS).expect("in flight");
        let truly = 10.0 * gamma_saccade(ms as f64 / 43.0, 0.7);
        let off = (deg_of(told.direction_view) - truly).abs().to_radians();
        assert!(off <= told.error_radius_rad, "{ms} ms: {off} off, {told:?}");
    }
    let held = estimator.estimate_at(423 * MS).expect("held");
    assert_eq!(held.kind, EstimateKind::Held);
    assert!((deg_of(held.direction_view) - 10.0).abs().to_radians() <= held.error_radius_rad, "{held:?}");
}

/// One second of anything: what happens at each step, and by how many ns time goes on.
fn steps() -> impl Strategy<Value = Vec<(u8, i64, f64)>> {
    prop::collection::vec((0u8..8, 200_000i64..30 * MS, -30.0f64..30.0), 1..120)
}

fn fed(steps: &[(u8, i64, f64)], one_eye: bool) -> (Estimator, i64) {
    fed_with(EstimatorSettings::default(), steps, one_eye)
}

fn fed_with(settings: EstimatorSettings, steps: &[(u8, i64, f64)], one_eye: bool) -> (Estimator, i64) {
    let mut estimator = Estimator::new(settings);
    let mut time_ns = 0;
    for (what, step_ns, deg) in steps {
        time_ns += step_ns;
        let sample = match what {
            0 => GazeSample::at(time_ns),
            1 => looking(time_ns, f64::NAN),
            // A jump to anywhere.
            2 => {
                if one_eye {
                    one_eyed(time_ns, *deg)
                } else {
                    looking(time_ns, *deg)
                }
            }
            _ => {
                if one_eye {
                    one_eyed(time_ns, *deg * 0.001)
                } else {
                    looking(time_ns, *deg * 0.001)
                }
            }
        };
        estimator.push(&sample);
    }
    (estimator, time_ns)
}

proptest! {
    #[test]
    fn the_radius_never_shrinks_with_age(
        steps in steps(),
        ages in prop::collection::vec(0i64..3_000 * MS, 2..20),
        landing in any::<bool>(),
    ) {
        let aim = if landing { Aim::Landing } else { Aim::Trajectory };
        let (estimator, _) = fed_with(EstimatorSettings { aim, ..EstimatorSettings::default() }, &steps, false);
        let Some((last, phase)) = estimator.last else { return Ok(()) };
        // The eye comes nearer to its landing point.
        prop_assume!(!(landing && phase.state == EyeState::Saccade));
        let mut ages = ages;
        ages.sort_unstable();
        let mut before = 0.0;
        for age in ages {
            // None is the widest of all: the renderer goes to its fallback.
            let radius = estimator.estimate_at(last.time_ns + age).map_or(f64::INFINITY, |e| e.error_radius_rad);
            prop_assert!(radius >= before, "{radius} after {before}");
            before = radius;
        }
    }

    #[test]
    fn one_eye_is_never_surer_than_two(steps in steps(), age in 0i64..2_500 * MS) {
        let radius = |one_eye| {
            let (estimator, now_ns) = fed(&steps, one_eye);
            estimator.estimate_at(now_ns + age).map(|estimate| estimate.error_radius_rad)
        };
        let (one, two) = (radius(true), radius(false));
        prop_assert_eq!(one.is_some(), two.is_some());
        prop_assert!(one.zip(two).is_none_or(|(one, two)| one >= two));
    }

    #[test]
    fn losing_the_eye_is_never_surer_than_seeing_nothing_new(steps in steps(), lost in 1i64..60, age in 0i64..500 * MS) {
        let (mut estimator, now_ns) = fed(&steps, false);
        let asked_ns = now_ns + lost * 10 * MS + age;
        let before = estimator.estimate_at(asked_ns);
        for index in 1..=lost {
            estimator.push(&GazeSample::at(now_ns + index * 10 * MS));
        }
        let after = estimator.estimate_at(asked_ns);
        let radius = |e: Option<GazeEstimate>| e.map_or(f64::INFINITY, |e| e.error_radius_rad);
        prop_assert!(radius(after) >= radius(before), "{after:?} after {before:?}");
    }

    #[test]
    fn any_input_gives_a_sound_answer_or_none(
        samples in prop::collection::vec((any::<i64>(), any::<[f64; 3]>(), any::<[f64; 4]>(), any::<bool>()), 0..40),
        asked in any::<i64>(),
    ) {
        let mut estimator = Estimator::new(EstimatorSettings { capacity: 8, ..EstimatorSettings::default() });
        for (time_ns, direction, turn, near) in samples {
            let time_ns = if near { time_ns % 1_000_000_000 } else { time_ns };
            let direction = Some(DVec3::from_array(direction));
            let head = HeadPose { position_m: DVec3::NAN, world_from_view: DQuat::from_array(turn) };
            let openness = Some(turn[0]);
            let eye = EyeSample { valid: true, direction, openness, confidence: Some(turn[1]), ..EyeSample::default() };
            let head = Some(head);
            estimator.push(&GazeSample { combined: eye, head, ..GazeSample::at(time_ns) });
            for time_ns in [asked, time_ns, time_ns.saturating_add(10 * MS), time_ns.saturating_add(700 * MS)] {
                if let Some(told) = estimator.estimate_at(time_ns) {
                    prop_assert!((told.direction_view.length() - 1.0).abs() < 1e-6, "{told:?}");
                    prop_assert!(told.error_radius_rad > 0.0 && told.error_radius_rad.is_finite());
                }
            }
        }
    }
}
