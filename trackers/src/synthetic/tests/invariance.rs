//! The eye is a function of time; whoever asks gets the same, and always something sane.

use crate::source::{GazeSource, SourceEvent};
use crate::synthetic::scene::BLOCK_NS;
use crate::synthetic::*;
use glam::DVec3;

const SECOND_NS: i64 = 1_000_000_000;

fn eye(name: &str, seed: u64) -> EyeModel {
    EyeModel::new(&SyntheticSettings::preset(name).expect("a preset"), seed).expect("sane settings")
}

fn sane(eye: &TrueEye) -> bool {
    let unit = |direction: DVec3| (direction.length() - 1.0).abs() < 1e-9;
    let directions = [eye.direction, eye.left, eye.right, eye.direction_world];
    directions.into_iter().all(unit)
        && (0.0..=1.0).contains(&eye.openness)
        && (1.0..=10.0).contains(&eye.pupil_mm)
        && eye.depth_m > 0.0
        && eye.depth_m.is_finite()
        && eye.head.position_m.is_finite()
        && eye.head.world_from_view.is_normalized()
        && eye.pupil_swing.is_finite()
}

/// Degrees between directions of length 1.
fn between_deg(one: DVec3, other: DVec3) -> f64 {
    (2.0 * (one.distance(other) / 2.0).clamp(0.0, 1.0).asin()).to_degrees()
}

#[test]
fn the_eye_is_the_same_at_every_rate() {
    for name in PRESETS {
        let recorded = |rate_hz: f64| {
            let settings = SyntheticSettings::preset(name).expect("a preset");
            let mut eye = SyntheticEye::new(settings, 7).expect("sane settings");
            let (recording, truth) = eye.record(130 * SECOND_NS, rate_hz).expect("a recording");
            let every = (rate_hz / 10.0) as usize;
            let times = recording.times_ns().iter().copied().step_by(every).collect::<Vec<_>>();
            (times, truth.directions.into_iter().step_by(every).collect::<Vec<_>>(), truth.events)
        };
        let slow = recorded(90.0);
        assert_eq!(slow.0[1], 100_000_000);
        assert_eq!(slow, recorded(120.0), "{name}");
        assert_eq!(slow, recorded(1000.0), "{name}");
        let mut other =
            SyntheticEye::new(SyntheticSettings::preset(name).expect("a preset"), 8).expect("sane");
        assert_ne!(slow.1, other.record(130 * SECOND_NS, 10.0).expect("a recording").1.directions);
    }
}

#[test]
fn the_order_of_questions_does_not_matter() {
    let mut forwards = eye("vr-exploration", 3);
    let times: Vec<i64> = (-40..40).map(|step| step * 7 * SECOND_NS + 123_456_789).collect();
    let told: Vec<TrueEye> = times.iter().map(|time| forwards.state_at(*time)).collect();
    let mut backwards = eye("vr-exploration", 3);
    for (time, told) in times.iter().zip(&told).rev() {
        assert_eq!(backwards.state_at(*time), *told, "{time}");
    }
}

#[test]
fn polling_in_other_steps_brings_the_same() {
    let mut settings = SyntheticSettings::preset("vr-exploration").expect("a preset");
    settings.tracker.burst = 3;
    settings.tracker.burst_probability = 0.2;
    settings.tracker.drop_probability = 0.05;
    settings.tracker.jitter_ms = 6.0;
    let polled = |step_ns: i64| {
        let source = SyntheticEye::new(settings.clone(), 11).expect("sane settings");
        let (mut source, mut events) = (source.starting_at(-5 * SECOND_NS), Vec::new());
        let mut now_ns = -5 * SECOND_NS;
        while now_ns < 20 * SECOND_NS {
            let before = events.len();
            now_ns = (now_ns + step_ns).min(20 * SECOND_NS);
            source.poll(now_ns, &mut events).expect("never ends");
            for event in &events[before..] {
                if let SourceEvent::Sample(sample) = event {
                    assert!(sample.received_ns <= now_ns && sample.received_ns > now_ns - step_ns);
                    assert!(sample.received_ns >= sample.time_ns + 30_000_000, "latency");
                }
            }
        }
        events
    };
    let events = polled(1_000_000);
    assert!(events == polled(7_777_777) && events == polled(25 * SECOND_NS));
    let samples = events.iter().filter(|event| matches!(event, SourceEvent::Sample(_))).count() as u64;
    let lost: u64 =
        events.iter().map(|e| if let SourceEvent::Lost { samples } = e { *samples } else { 0 }).sum();
    // 25 s at 120 Hz, one in twenty of them dropped: +-4 standard deviations.
    assert!((2990..=3001).contains(&(samples + lost)), "{samples} and {lost}");
    assert!((100..=200).contains(&lost), "{lost}");
    let arrivals = events.iter().filter_map(|event| match event {
        SourceEvent::Sample(sample) => Some(sample.received_ns),
        _ => None,
    });
    assert!(arrivals.clone().is_sorted());
    let together = arrivals.clone().zip(arrivals.skip(1)).filter(|pair| pair.0 == pair.1).count();
    assert!(together > 100, "bursts: {together}");
}

#[test]
fn a_sample_is_told_as_soon_as_it_arrives() {
    let mut settings = SyntheticSettings::preset("target-task").expect("a preset");
    settings.tracker = TrackerSettings::preset("perfect").expect("a tracker");
    let mut source = SyntheticEye::new(settings, 1).expect("sane settings").starting_at(0);
    let mut events = Vec::new();
    for step in 0..5000 {
        events.clear();
        source.poll(step * 1_000_000, &mut events).expect("never ends");
        let [SourceEvent::Sample(sample)] = events[..] else {
            panic!("{} events at {step} ms", events.len())
        };
        assert_eq!(sample.received_ns, step * 1_000_000);
    }
}

#[test]
fn a_recording_is_what_the_source_tells() {
    let mut settings = SyntheticSettings::preset("vr-exploration").expect("a preset");
    settings.tracker.drop_probability = 0.2;
    settings.tracker.jitter_ms = 20.0;
    settings.tracker.burst = 4;
    settings.tracker.burst_probability = 0.3;
    let source = SyntheticEye::new(settings, 12).expect("sane settings");
    let (mut source, mut events) = (source.starting_at(0), Vec::new());
    let (recording, _) = source.clone().record(20 * SECOND_NS, 120.0).expect("a recording");
    for step in 0..2100 {
        source.poll(step * 10_000_000, &mut events).expect("never ends");
    }
    let told = events.iter().filter_map(|event| match event {
        SourceEvent::Sample(sample) => Some(*sample),
        _ => None,
    });
    for (number, (recorded, told)) in recording.samples().zip(told).enumerate() {
        assert_eq!(recorded, told, "{number}");
    }
}

#[test]
fn nothing_jumps_and_nothing_is_nan() {
    for name in PRESETS {
        let mut eye = eye(name, 5);
        let mut before = eye.state_at(-SECOND_NS);
        // Over two seams of blocks, at 1 kHz.
        for centre_ns in [0, BLOCK_NS] {
            for step in -8000..8000 {
                let now = eye.state_at(centre_ns + step * 1_000_000);
                assert!(sane(&now), "{name} {now:?}");
                if step > -8000 {
                    // Human saccades do not exceed about 900 deg/s.
                    let moved_deg = between_deg(before.direction_world, now.direction_world);
                    assert!(moved_deg < 1.0, "{name}: {moved_deg} deg in 1 ms at {step} ms");
                    assert!(between_deg(before.direction, now.direction) < 1.2, "{name} in the head");
                    let turned = before.head.world_from_view.angle_between(now.head.world_from_view);
                    assert!(turned.to_degrees() < 0.3, "{name}: the head turns {turned} rad in 1 ms");
                }
                before = now;
            }
            let nanosecond = (eye.state_at(centre_ns - 1), eye.state_at(centre_ns));
            assert!(between_deg(nanosecond.0.direction, nanosecond.1.direction) < 1e-6, "{name}");
        }
    }
}

#[test]
fn ten_hours_and_the_ends_of_time() {
    let mut eye = eye("vr-exploration", 9);
    for step in 0..300 {
        let now = eye.state_at(step * 120_000_000_017);
        assert!(sane(&now), "{now:?}");
    }
    for time_ns in [i64::MIN, i64::MIN + 1, i64::MAX - 1, i64::MAX, -1, 0] {
        assert!(sane(&eye.state_at(time_ns)), "{time_ns}");
    }
    assert!(eye.events(i64::MIN, i64::MAX).is_err());
    assert_eq!(eye.events(5, 5).expect("none"), []);
    for (from_ns, to_ns) in [(i64::MIN, i64::MIN + SECOND_NS), (i64::MAX - SECOND_NS, i64::MAX)] {
        let events = eye.events(from_ns, to_ns).expect("one second");
        assert_eq!((events[0].start_ns, events[events.len() - 1].end_ns), (from_ns, to_ns));
    }
    let mut source = SyntheticEye::new(SyntheticSettings::default(), 1).expect("sane settings");
    let mut events = Vec::new();
    for now_ns in [i64::MIN, 0, i64::MAX, i64::MAX, 5, i64::MIN] {
        source.poll(now_ns, &mut events).expect("never ends");
        assert!(events.len() <= 3 * 65_538, "bounded: {}", events.len());
    }
}

#[test]
fn every_range_holds_at_both_of_its_ends() {
    let preset = SyntheticSettings::preset("vr-exploration").expect("a preset");
    for (name, _, low, high) in preset.ranges() {
        let with = |value: f64| {
            let mut tree = serde_json::to_value(&preset).expect("settings are a tree");
            let (part, field) = name.split_once('.').expect("part.field");
            let entry = tree[part].get_mut(field).expect("the name is that of a field");
            *entry = if entry.is_f64() { value.into() } else { (value as i64).into() };
            serde_json::from_value::<SyntheticSettings>(tree)
        };
        for value in [low, high] {
            let settings = with(value).expect("in range");
            let mut tracker = SyntheticTracker::new(&settings, 2).expect("in range");
            for step in 0..40 {
                let (sample, truth) = tracker.sample(step, step * 3_100_000_000);
                assert!(sane(&truth), "{name} {value}: {truth:?}");
                let finite = sample.gaze_direction().is_none_or(|(direction, _)| direction.is_finite());
                assert!(finite, "{name} {value}: {sample:?}");
            }
        }
        let apart = 1.0 + 0.01 * (high - low);
        for value in [low - apart, high + apart, f64::NAN] {
            if let Ok(settings) = with(value) {
                // Whole numbers cannot hold what is no number.
                let whole = value.is_nan() && settings.check().is_ok();
                let message = SyntheticEye::new(settings, 2).map(drop).map_err(|error| error.to_string());
                assert!(whole || message.is_err_and(|text| text.contains(name)), "{name} {value}");
            }
        }
    }
}

#[test]
fn settings_read_back_and_say_what_is_wrong() {
    for name in PRESETS {
        let settings = SyntheticSettings::preset(name).expect("a preset");
        let text = toml::to_string(&settings).expect("settings are a table");
        assert_eq!(toml::from_str::<SyntheticSettings>(&text).expect("it reads back"), settings);
    }
    let some: SyntheticSettings = toml::from_str("[blink]\nper_min = 3.0").expect("the rest is default");
    assert_eq!((some.blink.per_min, some.fixation), (3.0, FixationSettings::default()));
    assert!(toml::from_str::<SyntheticSettings>("[blink]\nper_hour = 3.0").is_err());
    let unknown = SyntheticSettings::preset("sleep").expect_err("no preset");
    assert!(unknown.to_string().contains("target-task"), "{unknown}");
    let unknown = TrackerSettings::preset("sundial").expect_err("no tracker");
    assert!(unknown.to_string().contains("vive-pro-eye"), "{unknown}");
    let mut settings = SyntheticSettings::default();
    for table in [vec![], vec![[5.0, 1.0], [5.0, 2.0]], vec![[0.0, -1.0]], vec![[0.0, f64::NAN]]] {
        settings.tracker.accuracy_deg = table;
        assert!(settings.check().is_err());
    }
}

#[test]
fn what_cannot_be_recorded_is_refused() {
    let mut eye = SyntheticEye::new(SyntheticSettings::default(), 1).expect("sane settings");
    for (duration_ns, rate_hz) in
        [(-1, 100.0), (SECOND_NS, 0.0), (SECOND_NS, f64::NAN), (SECOND_NS, 2e4), (i64::MAX, 1000.0)]
    {
        assert!(eye.record(duration_ns, rate_hz).is_err(), "{duration_ns} ns at {rate_hz} Hz");
    }
    let (recording, truth) = eye.record(0, 100.0).expect("nothing is a recording too");
    assert!(recording.is_empty() && truth.events.is_empty());
}
