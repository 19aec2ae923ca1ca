//! What the eye does, measured as the recordings of people were, against their figures.

use super::analysis::*;
use crate::synthetic::*;
use std::sync::OnceLock;

const SECOND_NS: i64 = 1_000_000_000;

fn record(settings: &SyntheticSettings, seconds: i64, rate_hz: f64) -> (Trace, Truth) {
    let mut eye = SyntheticEye::new(settings.clone(), 21).expect("sane settings");
    let (recording, truth) = eye.record(seconds * SECOND_NS, rate_hz).expect("a recording");
    (Trace::measured(&recording), truth)
}

fn preset(name: &str) -> SyntheticSettings {
    SyntheticSettings::preset(name).expect("a preset")
}

/// Twenty minutes of the target task, which several tests measure.
fn target_task() -> &'static Trace {
    static TRACE: OnceLock<Trace> = OnceLock::new();
    TRACE.get_or_init(|| record(&preset("target-task"), 1200, 1000.0).0)
}

fn within(what: &str, value: f64, low: f64, high: f64) {
    println!("{what}: {value:.4}");
    assert!((low..=high).contains(&value), "{what} is {value}, not {low} to {high}");
}

/// Median of a value of the saccades near an amplitude, brought to that amplitude by an expected curve.
fn near(saccades: &[Saccade], at_deg: f64, value: impl Fn(&Saccade) -> f64, curve: fn(f64) -> f64) -> f64 {
    let close = saccades.iter().filter(|saccade| (saccade.amplitude_deg / at_deg).ln().abs() < 0.2);
    let values: Vec<f64> =
        close.map(|saccade| value(saccade) * curve(at_deg) / curve(saccade.amplitude_deg)).collect();
    assert!(values.len() >= 20, "{} saccades near {at_deg} deg", values.len());
    percentile(&values, 0.5)
}

/// The fits to 240 hand-labelled saccades.
fn labelled_duration_ms(amplitude_deg: f64) -> f64 {
    2.28 * amplitude_deg + 14.6
}

fn labelled_peak_deg_s(amplitude_deg: f64) -> f64 {
    564.0 * (1.0 - (-amplitude_deg / 8.9).exp())
}

#[test]
fn duration_and_peak_speed_follow_the_main_sequence() {
    let mut settings = preset("target-task");
    settings.scene.half_width_deg = 25.0;
    let saccades = record(&settings, 1200, 1000.0).0.saccades();
    let points = saccades.iter().filter(|saccade| saccade.amplitude_deg >= 0.5);
    let (slope, at_zero) = line(points.map(|saccade| (saccade.amplitude_deg, saccade.duration_ms)));
    within("ms for each degree", slope, 2.28 - 0.12, 2.28 + 0.12);
    within("ms at zero", at_zero, 14.6 - 1.0, 14.6 + 1.0);
    // The filter takes 10 % of the peak at 5 degrees, and more below; the fit to the labels is itself
    // lower there than the labels' own medians (67 at 1 degree, 137 at 2).
    for (at_deg, tolerance) in
        [(1.0, 0.15), (2.0, 0.15), (5.0, 0.08), (10.0, 0.06), (20.0, 0.06), (40.0, 0.06)]
    {
        let duration = near(&saccades, at_deg, |saccade| saccade.duration_ms, labelled_duration_ms);
        let peak = near(&saccades, at_deg, |saccade| saccade.peak_deg_s, labelled_peak_deg_s);
        within(&format!("duration at {at_deg}"), duration / labelled_duration_ms(at_deg), 0.94, 1.06);
        let ratio = peak / labelled_peak_deg_s(at_deg);
        within(&format!("peak at {at_deg}"), ratio, 1.0 - tolerance, 1.0 + tolerance);
    }
}

#[test]
fn the_peak_comes_earlier_the_longer_a_saccade_lasts() {
    let saccades = target_task().saccades();
    let at = |from_ms: f64, to_ms: f64| {
        let lasting = saccades.iter().filter(|saccade| (from_ms..to_ms).contains(&saccade.duration_ms));
        percentile(&lasting.map(|saccade| saccade.peak_at).collect::<Vec<_>>(), 0.5)
    };
    // Medians of the hand-labelled recording: 0.44, 0.37, 0.29, 0.21.
    let peaks = [at(10.0, 25.0), at(40.0, 60.0), at(60.0, 80.0), at(80.0, 150.0)];
    for (peak, labelled) in peaks.into_iter().zip([0.44, 0.37, 0.29, 0.21]) {
        within("peak of the speed", peak, labelled - 0.05, labelled + 0.05);
    }
    assert!(peaks.is_sorted_by(|early, late| early > late), "{peaks:?}");
}

#[test]
fn times_between_saccades_are_those_of_a_target_task() {
    let intervals = target_task().intervals_ms();
    within("p10 ms", percentile(&intervals, 0.1), 100.0, 130.0);
    within("median ms", percentile(&intervals, 0.5), 330.0, 480.0);
    within("p90 ms", percentile(&intervals, 0.9), 1060.0, 1400.0);
}

#[test]
fn noise_from_sample_to_sample_is_that_of_the_trackers() {
    within("EyeLink-like, 1 kHz", target_task().rms_s2s_deg(), 0.043, 0.049);
    let tracker = TrackerSettings::preset("vive-pro-eye").expect("a tracker");
    let still = SyntheticSettings { tracker, ..preset("target-task") };
    within("Vive-like, 120 Hz", record(&still, 600, 120.0).0.rms_s2s_deg(), 0.11, 0.14);
}

#[test]
fn microsaccades_and_blinks_come_as_often_as_people_make_them() {
    for name in ["target-task", "free-viewing", "reading"] {
        let (trace, truth) = record(&preset(name), 600, 100.0);
        let of = |kind| truth.events.iter().filter(move |event| event.kind == kind);
        let fixated_s: f64 =
            of(TruthKind::Fixation).map(|event| (event.end_ns - event.start_ns) as f64 * 1e-9).sum();
        let micro = of(TruthKind::Microsaccade).count() as f64;
        within(&format!("{name}: microsaccades a second"), micro / fixated_s, 1.0, 2.0);
        let amplitudes: Vec<f64> = of(TruthKind::Microsaccade).map(|event| event.amplitude_deg).collect();
        within("median amplitude", percentile(&amplitudes, 0.5), 0.25, 0.5);
        let blinks = trace.runs().iter().filter(|run| run.label == 5).count() as f64;
        within("blinks a minute", blinks / 10.0, 9.0, 18.0);
        let covered_ms: Vec<f64> =
            of(TruthKind::Blink).map(|e| (e.end_ns - e.start_ns) as f64 * 1e-6).collect();
        // 160 to 220 ms in the hand labels.
        within("median blink, ms", percentile(&covered_ms, 0.5), 140.0, 220.0);
    }
}

#[test]
fn the_speed_of_a_saccade_adds_up_to_its_amplitude() {
    let mut settings = preset("target-task");
    settings.fixation.drift_deg_per_root_s = 0.0;
    settings.fixation.tremor_deg = 0.0;
    settings.saccade.curvature = 0.0;
    let mut eye = EyeModel::new(&settings, 2).expect("sane settings");
    let events = eye.events(0, 100 * SECOND_NS).expect("labels");
    let saccades = events.iter().filter(|event| event.kind == TruthKind::Saccade);
    let mut count = 0;
    for event in saccades {
        let step_ns = 20_000;
        if [event.start_ns, event.end_ns].iter().any(|time_ns| eye.state_at(*time_ns).openness < 1.0) {
            // Moving lids turn the eye too.
            continue;
        }
        let (mut way_deg, mut fastest) = (0.0, 0.0_f64);
        let mut before = eye.state_at(event.start_ns).direction;
        for time_ns in (event.start_ns..event.end_ns).step_by(step_ns as usize).skip(1) {
            let now = eye.state_at(time_ns).direction;
            let moved_deg = now.cross(before).length().asin().to_degrees();
            way_deg += moved_deg;
            fastest = fastest.max(moved_deg / (step_ns as f64 * 1e-9));
            before = now;
        }
        let ratio = way_deg / event.amplitude_deg;
        assert!((0.999..=1.001).contains(&ratio), "{way_deg} for {event:?}");
        assert!((0.98..=1.005).contains(&(fastest / event.peak_deg_s)), "{fastest} for {event:?}");
        count += 1;
    }
    assert!(count > 50, "{count}");
}

#[test]
fn the_pupil_swings_after_a_saccade_and_the_eye_does_not() {
    within("median length, ms", percentile(&target_task().lengths(OSCILLATION), 0.5), 15.0, 20.0);
    within("p10, ms", percentile(&target_task().lengths(OSCILLATION), 0.1), 12.0, 17.0);
    within("p90, ms", percentile(&target_task().lengths(OSCILLATION), 0.9), 20.0, 27.0);
    let mut settings = preset("target-task");
    settings.tracker =
        TrackerSettings { pupil_based: true, ..TrackerSettings::preset("perfect").expect("a tracker") };
    let mut tracker = SyntheticTracker::new(&settings, 3).expect("sane settings");
    let events = tracker.eye().events(0, 100 * SECOND_NS).expect("labels");
    let wide = |event: &&TruthEvent| event.kind == TruthKind::Saccade && event.amplitude_deg > 5.0;
    let mut swings = 0;
    for event in events.iter().filter(wide) {
        let way = tracker.truth_at(event.end_ns).direction - tracker.truth_at(event.start_ns).direction;
        let lids = [event.end_ns, event.end_ns + 40_000_000];
        if lids.into_iter().any(|time_ns| tracker.truth_at(time_ns).openness < 1.0) {
            continue;
        }
        // Along the saccade, from its end on, each millisecond.
        let along: Vec<f64> = (0..40)
            .map(|ms| {
                let (sample, truth) = tracker.sample(ms, event.end_ns + ms * 1_000_000);
                let told = sample.combined.direction.expect("no lid closes right after a saccade");
                (told - truth.direction).dot(way.normalize()).to_degrees()
            })
            .collect();
        assert!((0.2..0.41).contains(&along[0]), "{event:?} {along:?}");
        assert!(along.iter().any(|swing| *swing < -0.02), "it swings back and past: {along:?}");
        assert!(along[27..].iter().all(|swing| swing.abs() < 0.02), "and dies: {along:?}");
        swings += 1;
    }
    assert!(swings > 20, "{swings}");
    settings.tracker.pupil_based = false;
    let (_, truth) = record(&settings, 60, 100.0);
    assert!(truth.events.iter().all(|event| event.kind != TruthKind::Oscillation));
}

#[test]
fn drift_grows_with_the_root_of_the_time() {
    let mut settings = preset("target-task");
    settings.fixation = FixationSettings { drift_deg_per_root_s: 0.4, tremor_deg: 0.0, ..settings.fixation };
    settings.fixation.microsaccades_per_s = 0.0;
    let mut eye = EyeModel::new(&settings, 5).expect("sane settings");
    let events = eye.events(0, 1200 * SECOND_NS).expect("labels");
    let mut moved = [(0.0, 0.0); 3];
    for event in events.iter().filter(|event| event.kind == TruthKind::Fixation) {
        for (lag_ns, sums) in [100_000_000, 300_000_000, SECOND_NS].into_iter().zip(&mut moved) {
            for start_ns in (event.start_ns..event.end_ns - lag_ns).step_by(50_000_000) {
                let [first, last] = [start_ns, start_ns + lag_ns].map(|time_ns| eye.state_at(time_ns));
                if first.openness == 1.0 && last.openness == 1.0 {
                    let step_deg = first.direction.angle_between(last.direction).to_degrees();
                    *sums = (sums.0 + step_deg * step_deg / 2.0, sums.1 + 1.0);
                }
            }
        }
    }
    for ((lag_s, share), (sum, count)) in [(0.1_f64, 1.0), (0.3, 1.0), (1.0, 0.8)].into_iter().zip(moved) {
        let over_root = (sum / count / lag_s).sqrt();
        within(&format!("drift in {lag_s} s"), over_root / (0.4 * share), 0.93, 1.07);
    }
}

#[test]
fn pursuit_is_as_fast_as_its_label_and_as_what_it_follows() {
    let mut settings = preset("pursuit");
    settings.fixation = FixationSettings { drift_deg_per_root_s: 0.0, tremor_deg: 0.0, ..settings.fixation };
    settings.blink.per_min = 0.0;
    let mut eye = EyeModel::new(&settings, 8).expect("sane settings");
    let events = eye.events(0, 600 * SECOND_NS).expect("labels");
    let mut speeds = Vec::new();
    for event in events.iter().filter(|event| event.kind == TruthKind::Pursuit) {
        // Behind the 60 ms in which the eye takes up speed.
        let (from_ns, to_ns) = (event.start_ns + 250_000_000, event.end_ns - 1_000_000);
        if to_ns - from_ns < 100_000_000 {
            continue;
        }
        let [from, to] = [from_ns, to_ns].map(|time_ns| eye.state_at(time_ns).direction_world);
        let speed_deg_s = from.angle_between(to).to_degrees() / ((to_ns - from_ns) as f64 * 1e-9);
        within("speed over its label", speed_deg_s / event.peak_deg_s, 0.98, 1.01);
        speeds.push(speed_deg_s);
    }
    // Targets move at a median of 10 deg/s, and the eye at 0.95 of it.
    assert!(speeds.len() > 100, "{}", speeds.len());
    within("median speed, deg/s", percentile(&speeds, 0.5), 7.5, 11.5);
}

#[test]
fn gaze_stays_in_the_world_while_the_head_turns() {
    let mut settings = preset("target-task");
    // Peaks at 2 pi * 0.8 Hz * 20 degrees, or 100 deg/s.
    settings.head.shake_deg = 20.0;
    settings.head.shake_hz = 0.8;
    settings.fixation.microsaccades_per_s = 0.0;
    for (vor_gain, largest_deg) in [(1.0, 0.8), (0.95, 3.0)] {
        settings.head.vor_gain = vor_gain;
        let mut eye = EyeModel::new(&settings, 4).expect("sane settings");
        let fixations = eye.events(0, 60 * SECOND_NS).expect("labels");
        let (mut fastest, mut opposite, mut strayed) = (0.0_f64, 0, 0.0_f64);
        for event in fixations.iter().filter(|event| event.kind == TruthKind::Fixation) {
            let first = eye.state_at(event.start_ns);
            let mut before = first;
            for time_ns in (event.start_ns..event.end_ns).step_by(10_000_000).skip(1) {
                let now = eye.state_at(time_ns);
                let turned = before.head.world_from_view.angle_between(now.head.world_from_view);
                fastest = fastest.max(turned.to_degrees() * 100.0);
                let head = (now.head.world_from_view * glam::DVec3::NEG_Z).x
                    - (before.head.world_from_view * glam::DVec3::NEG_Z).x;
                let eye_in_head = now.direction.x - before.direction.x;
                opposite += i32::from(head * eye_in_head < 0.0) - i32::from(head * eye_in_head > 0.0);
                if now.openness == 1.0 && first.openness == 1.0 {
                    let gaze = first.direction_world.angle_between(now.direction_world);
                    strayed = strayed.max(gaze.to_degrees());
                }
                before = now;
            }
        }
        within("head, deg/s", fastest, 98.0, 102.0);
        within("gaze in the world, deg", strayed, 0.0, largest_deg);
        // The rest are moments of a nearly still head, when drift decides.
        assert!(opposite > 4000, "eye against head: {opposite} of about 5200");
    }
}

#[test]
fn in_a_headset_the_eye_moves_against_the_head() {
    let mut settings = preset("vr-exploration");
    settings.tracker = TrackerSettings::preset("perfect").expect("a tracker");
    let mut eye = EyeModel::new(&settings, 6).expect("sane settings");
    let (mut in_head, mut in_world, mut off_deg) = (Vec::new(), Vec::new(), Vec::new());
    for number in 0..60_000 {
        let [first, second] = [0, 1].map(|next| eye.state_at((number + next) * SECOND_NS / 120));
        off_deg.push(first.direction.angle_between(glam::DVec3::NEG_Z).to_degrees());
        if first.kind == TruthKind::Fixation && second.kind == TruthKind::Fixation {
            in_head.push(first.direction.angle_between(second.direction).to_degrees() * 120.0);
            in_world.push(first.direction_world.angle_between(second.direction_world).to_degrees() * 120.0);
        }
    }
    within("eye in head, median deg/s", percentile(&in_head, 0.5), 6.0, 30.0);
    within("gaze in world, median deg/s", percentile(&in_world, 0.5), 0.0, 3.5);
    // Beyond about 55 degrees no eye turns (Guitton and Volle 1987).
    within("eccentricity, p99.9", percentile(&off_deg, 0.999), 15.0, 55.0);
}

#[test]
fn it_measures_like_the_hand_labelled_recording() {
    let Some(labelled) = Trace::hand_labelled() else { return };
    let made = target_task();
    let ratio = |what: &str, value: fn(&Trace) -> f64, low: f64, high: f64| {
        println!("{what}: made {:.4}, labelled {:.4}", value(made), value(&labelled));
        within(what, value(made) / value(&labelled), low, high);
    };
    ratio("RMS-S2S", Trace::rms_s2s_deg, 0.85, 1.15);
    ratio("interval p10", |trace| percentile(&trace.intervals_ms(), 0.1), 0.75, 1.25);
    ratio("interval median", |trace| percentile(&trace.intervals_ms(), 0.5), 0.75, 1.25);
    ratio("interval p90", |trace| percentile(&trace.intervals_ms(), 0.9), 0.75, 1.25);
    ratio("fixation median", |trace| percentile(&trace.lengths(FIXATION), 0.5), 0.7, 1.3);
    ratio("oscillation median", |trace| percentile(&trace.lengths(OSCILLATION), 0.5), 0.8, 1.2);
    let per_sample = |trace: &Trace| trace.saccades().len() as f64 / trace.label.len() as f64;
    ratio("saccades a sample", per_sample, 0.8, 1.25);
    let slope = |trace: &Trace| {
        let saccades = trace.saccades();
        let points = saccades.iter().filter(|saccade| saccade.amplitude_deg >= 0.5);
        line(points.map(|saccade| (saccade.amplitude_deg, saccade.duration_ms))).0
    };
    ratio("ms for each degree", slope, 0.9, 1.1);
    // Peak over mean speed of wide saccades: what duration and peak have to do with each other.
    let factor = |trace: &Trace| {
        let saccades = trace.saccades();
        let wide = saccades.iter().filter(|saccade| (10.0..35.0).contains(&saccade.amplitude_deg));
        let factors = wide.map(|wide| wide.peak_deg_s * wide.duration_ms * 1e-3 / wide.amplitude_deg);
        percentile(&factors.collect::<Vec<_>>(), 0.5)
    };
    ratio("peak over mean speed", factor, 0.9, 1.1);
}
