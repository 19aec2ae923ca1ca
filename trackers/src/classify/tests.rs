use super::*;
use crate::predict::PredictorKind;

const MS: i64 = 1_000_000;

/// A direction `x` degrees to the right and `y` up, along the sphere.
fn at_deg(x: f64, y: f64) -> DVec3 {
    let (x, y) = (x.to_radians(), y.to_radians());
    DVec3::new(x.sin() * y.cos(), y.sin(), -x.cos() * y.cos())
}

/// Jitter of one axis: a fixed pseudo-random sequence, uniform with a standard deviation of `deg`.
struct Jitter(u64, f64);

impl Jitter {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 40) as f64 / (1u64 << 24) as f64 - 0.5) * 12f64.sqrt() * self.1
    }
}

/// Minimum-jerk course, 0 to 1.
fn minimum_jerk(share: f64) -> f64 {
    let x = share.clamp(0.0, 1.0);
    x.powi(3) * (10.0 - 15.0 * x + 6.0 * x * x)
}

/// Runs gaze (deg; `None` for a loss) by time (s) at a rate and gives all events.
fn run(rate_hz: f64, seconds: f64, jitter_deg: f64, gaze: impl Fn(f64) -> Option<(f64, f64)>) -> Vec<Event> {
    let mut classifier = Classifier::new(ClassifierSettings::default());
    let (mut jitter, mut events) = (Jitter(7, jitter_deg), Vec::new());
    for index in 0..(seconds * rate_hz) as i64 {
        let time_s = index as f64 / rate_hz;
        let (x, y) = (jitter.next(), jitter.next());
        let direction = gaze(time_s).map_or(DVec3::ZERO, |gaze| at_deg(gaze.0 + x, gaze.1 + y));
        let valid = direction != DVec3::ZERO;
        let time_ns = (time_s * 1e9) as i64;
        let entry = Entry { time_ns, direction, smoothed: direction, valid, ..Entry::default() };
        if let Some(update) = classifier.push(&entry) {
            assert!(update.since_ns <= update.detected_ns && update.detected_ns == time_ns);
            events.extend(update.finished.into_iter().flatten());
        }
    }
    events.extend(classifier.unfinished().into_iter().flatten());
    events
}

fn kinds(events: &[Event]) -> Vec<EyeState> {
    events.iter().map(|event| event.kind).collect()
}

/// A saccade of 8 degrees, obliquely, from 1.000 to 1.039 s.
fn one_saccade(time_s: f64) -> Option<(f64, f64)> {
    let deg = 8.0 * minimum_jerk((time_s - 1.0) / 0.039);
    Some((deg * 0.6, deg * -0.8))
}

#[test]
fn a_saccade_is_found_at_every_rate() {
    use EyeState::{Fixation, Saccade};
    for (rate_hz, jitter_deg) in
        [(60.0, 0.05), (120.0, 0.1), (250.0, 0.05), (1000.0, 0.03), (2000.0, 0.02), (4000.0, 0.02)]
    {
        let events = run(rate_hz, 2.0, jitter_deg, one_saccade);
        assert_eq!(kinds(&events), [Fixation, Saccade, Fixation], "{rate_hz} Hz");
        let saccade = events[1];
        let slack_ms = 6.0 + 1e3 / rate_hz;
        let off = |time_ns: i64, true_s: f64| (time_ns as f64 * 1e-9 - true_s).abs() * 1e3;
        assert!(off(saccade.start_ns, 1.0) < slack_ms, "{rate_hz} Hz: {saccade:?}");
        assert!(off(saccade.end_ns, 1.039) < slack_ms, "{rate_hz} Hz: {saccade:?}");
        assert!((saccade.amplitude_deg - 8.0).abs() < 0.6, "{rate_hz} Hz: {saccade:?}");
        // The peak of a minimum-jerk course is 1.875 times its mean speed; a window flattens it.
        let peak = 1.875 * 8.0 / 0.039;
        assert!((0.4 * peak..1.05 * peak).contains(&saccade.peak_deg_s), "{rate_hz} Hz: {saccade:?}");
        assert!((events[0].end_ns, saccade.end_ns) == (saccade.start_ns, events[2].start_ns));
    }
}

#[test]
fn noise_alone_is_a_fixation_however_strong() {
    for (rate_hz, jitter_deg) in [(60.0, 0.3), (120.0, 0.2), (250.0, 0.3), (1000.0, 0.15), (4000.0, 0.2)] {
        let events = run(rate_hz, 20.0, jitter_deg, |_| Some((3.0, -2.0)));
        // The first moments, while the noise is being learnt, are excused.
        let late = events.iter().filter(|event| event.start_ns > 1_000 * MS).count();
        assert_eq!(late, 0, "{rate_hz} Hz: {:?}", kinds(&events));
    }
}

/// An overshoot that swings back within 20 ms, a tenth of the amplitude.
#[test]
fn the_oscillation_after_a_saccade_is_no_second_one() {
    let events = run(1000.0, 2.0, 0.02, |time_s| {
        let (deg, _) = one_saccade(time_s).map(|gaze| (gaze.0 / 0.6, 0.0))?;
        let after = (time_s - 1.039).max(0.0);
        let swing = 0.8 * (std::f64::consts::TAU * after / 0.02).sin() * (-after / 0.01).exp();
        Some((deg + swing, 0.0))
    });
    assert_eq!(kinds(&events), [EyeState::Fixation, EyeState::Saccade, EyeState::Fixation]);
    assert!((events[1].end_ns - 1_039 * MS).abs() < 8 * MS, "{:?}", events[1]);
}

#[test]
fn a_pursuit_is_told_from_rest_and_its_saccades_from_it() {
    use EyeState::{Fixation, Pursuit, Saccade};
    let target = |time_s: f64| ((time_s - 1.0).clamp(0.0, 1.0) * 15.0, 0.0);
    for (rate_hz, jitter_deg) in [(120.0, 0.05), (1000.0, 0.03)] {
        let events = run(rate_hz, 3.0, jitter_deg, |time_s| Some(target(time_s)));
        assert_eq!(kinds(&events), [Fixation, Pursuit, Fixation], "{rate_hz} Hz");
        assert!((events[1].start_ns - 1_000 * MS).abs() < 60 * MS, "{:?}", events[1]);
        assert!((events[1].end_ns - 2_000 * MS).abs() < 80 * MS, "{:?}", events[1]);
        let events = run(rate_hz, 3.0, jitter_deg, |time_s| {
            let (x, _) = target(time_s);
            Some((x, 4.0 * minimum_jerk((time_s - 1.5) / 0.03)))
        });
        let saccades: Vec<_> = events.iter().filter(|event| event.kind == Saccade).collect();
        assert_eq!(saccades.len(), 1, "{rate_hz} Hz: {:?}", kinds(&events));
        assert!((saccades[0].start_ns - 1_500 * MS).abs() < 15 * MS);
    }
}

#[test]
fn a_short_loss_is_bridged_a_longer_one_a_blink_and_a_long_one_lost() {
    use EyeState::{Blink, Fixation, Lost};
    let lost =
        |from_s: f64, to_s: f64| move |time_s: f64| (!(from_s..to_s).contains(&time_s)).then_some((1.0, 1.0));
    assert_eq!(kinds(&run(1000.0, 2.0, 0.03, lost(1.0, 1.015))), [Fixation]);
    let events = run(1000.0, 2.0, 0.03, lost(1.0, 1.15));
    assert_eq!(kinds(&events), [Fixation, Blink, Fixation]);
    assert!((events[1].start_ns - 1_000 * MS).abs() <= MS);
    // The lids have 100 ms to open.
    assert!((events[1].end_ns - 1_250 * MS).abs() <= MS);
    assert_eq!(kinds(&run(1000.0, 3.0, 0.03, lost(1.0, 1.9))), [Fixation, Lost, Fixation]);
    assert_eq!(kinds(&run(1000.0, 1.0, 0.03, |_| None)), [Lost]);
}

/// The lid draws the gaze down by 8 degrees in 25 ms until it is lost, and back up after it.
#[test]
fn lids_of_a_blink_are_no_saccades() {
    let events = run(1000.0, 2.0, 0.03, |time_s| {
        let (down, up) = ((time_s - 0.975) / 0.03, (time_s - 1.15) / 0.06);
        let covered = (1.0..1.15).contains(&time_s);
        (!covered).then(|| (0.0, -8.0 * down.clamp(0.0, 1.0) * (1.0 - up.clamp(0.0, 1.0))))
    });
    assert_eq!(kinds(&events), [EyeState::Fixation, EyeState::Blink, EyeState::Fixation]);
    assert!((events[1].start_ns - 975 * MS).abs() <= 5 * MS, "{:?}", events[1]);
}

#[test]
fn closed_lids_are_a_blink_though_a_gaze_is_told() {
    let mut classifier = Classifier::new(ClassifierSettings::default());
    let mut states = Vec::new();
    for ms in 0..600_i64 {
        let openness = Some(if (200..350).contains(&ms) { 0.05 } else { 0.9 });
        let direction = at_deg(0.0, 0.0);
        let entry = Entry {
            time_ns: ms * MS,
            direction,
            smoothed: direction,
            valid: true,
            openness,
            ..Entry::default()
        };
        states.extend(classifier.push(&entry).map(|update| update.state));
    }
    assert_eq!(states, [EyeState::Fixation, EyeState::Blink, EyeState::Fixation]);
}

/// Gaze stays on a point of the world while the head turns at 100 deg/s: a fixation where the pose is
/// known.
#[test]
fn the_counter_rotation_of_the_eye_is_no_movement_of_gaze() {
    let mut classifier = Classifier::new(ClassifierSettings::default());
    for ms in 0..400_i64 {
        let turned = (ms as f64 * 0.1 - 20.0).to_radians();
        let world_from_view = Some(glam::DQuat::from_rotation_y(turned));
        let direction = glam::DQuat::from_rotation_y(-turned) * DVec3::NEG_Z;
        let entry = Entry {
            time_ns: ms * MS,
            direction,
            smoothed: direction,
            valid: true,
            world_from_view,
            ..Entry::default()
        };
        classifier.push(&entry);
        assert_eq!(classifier.phase().state, EyeState::Fixation, "{ms}");
    }
}

/// One eye sees 3 degrees beside the mean of both: no saccade when the other is lost.
#[test]
fn a_change_from_two_eyes_to_one_is_no_saccade() {
    let mut classifier = Classifier::new(ClassifierSettings::default());
    for ms in 0..400_i64 {
        let one_eye = (100..200).contains(&ms);
        let direction = at_deg(if one_eye { 3.0 } else { 0.0 }, 0.0);
        let entry = Entry {
            time_ns: ms * MS,
            direction,
            smoothed: direction,
            valid: true,
            one_eye,
            ..Entry::default()
        };
        classifier.push(&entry);
        assert_eq!(classifier.phase().state, EyeState::Fixation, "{ms}");
    }
}

#[test]
fn slow_and_silent_streams_tell_no_movement() {
    for rate_hz in [1.0, 5.0] {
        let events = run(rate_hz, 60.0, 0.1, |time_s| Some(((time_s as i64 % 20) as f64, 0.0)));
        assert!(kinds(&events).iter().all(|kind| *kind != EyeState::Saccade), "{rate_hz} Hz");
    }
    let mut classifier = Classifier::new(ClassifierSettings::default());
    let mut predictor = PredictorKind::Landing.make();
    for time_ns in (0..300).map(|ms| ms * MS).chain((0..300).map(|ms| (5_000 + ms) * MS)) {
        let direction = at_deg(if time_ns < 1_000 * MS { 0.0 } else { 20.0 }, 0.0);
        let entry = Entry { time_ns, direction, smoothed: direction, valid: true, ..Entry::default() };
        classifier.push(&entry);
        predictor.push(&entry, &classifier.phase());
        assert_ne!(classifier.phase().state, EyeState::Saccade);
    }
}

/// With jitter of 0.1 deg an axis the deviation of both together is 0.141 deg.
#[test]
fn jitter_is_measured() {
    let mut classifier = Classifier::new(ClassifierSettings::default());
    let mut jitter = Jitter(3, 0.1);
    for ms in 0..5_000_i64 {
        let direction = at_deg(jitter.next(), jitter.next());
        let entry =
            Entry { time_ns: ms * MS, direction, smoothed: direction, valid: true, ..Entry::default() };
        classifier.push(&entry);
    }
    let told = classifier.phase().jitter_deg;
    assert!((told - 0.141).abs() < 0.02, "{told}");
}

/// After ten quiet seconds the jitter grows tenfold: within two seconds it is known again.
#[test]
fn a_tracker_that_becomes_noisier_is_learnt() {
    let mut classifier = Classifier::new(ClassifierSettings::default());
    let (mut quiet, mut noisy, mut late) = (Jitter(3, 0.02), Jitter(5, 0.2), 0);
    for ms in 0..30_000_i64 {
        let jitter = if ms < 10_000 { &mut quiet } else { &mut noisy };
        let direction = at_deg(jitter.next(), jitter.next());
        let entry =
            Entry { time_ns: ms * MS, direction, smoothed: direction, valid: true, ..Entry::default() };
        let told = classifier.push(&entry);
        late += usize::from(told.is_some() && ms > 12_000);
    }
    assert_eq!(late, 0);
}
