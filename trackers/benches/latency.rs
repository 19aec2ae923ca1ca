//! An hour at 1 kHz through the latency model, with and without its budget.

use criterion::{Criterion, criterion_group, criterion_main};
use glam::DVec3;
use macula_trackers::EyeState;
use macula_trackers::latency::{EyeInterval, RunSettings, SessionGaze, preset, run};
use macula_trackers::recording::{Recording, RecordingInfo};
use macula_trackers::sample::{EyeSample, GazeSample};
use std::hint::black_box;
use std::time::Duration;

const SAMPLES: i64 = 3_600_000;
const STEP_NS: i64 = 1_000_000;
/// A saccade at every 400 ms, over in 40.
const SACCADE_EVERY: i64 = 400;
const SACCADE_LASTS: i64 = 40;

fn recording() -> Recording {
    let mut recording = Recording::new(RecordingInfo::default());
    for index in 0..SAMPLES {
        let (number, into) = (index / SACCADE_EVERY, index % SACCADE_EVERY);
        let target = |number: i64| ((number * 37 % 31) as f64 - 15.0).to_radians();
        let share = (into as f64 / SACCADE_LASTS as f64).min(1.0);
        let azimuth = target(number) + (target(number + 1) - target(number)) * share;
        let direction = Some(DVec3::new(azimuth.sin(), 0.0, -azimuth.cos()));
        let combined = EyeSample { valid: true, direction, ..EyeSample::default() };
        recording.push(&GazeSample { combined, ..GazeSample::at(index * STEP_NS) });
    }
    recording
}

fn intervals() -> Vec<EyeInterval> {
    let at =
        |state, start: i64, end: i64| EyeInterval { state, start_ns: start * STEP_NS, end_ns: end * STEP_NS };
    (0..SAMPLES / SACCADE_EVERY)
        .flat_map(|number| {
            let start = number * SACCADE_EVERY;
            let rest = start + SACCADE_LASTS;
            [at(EyeState::Saccade, start, rest), at(EyeState::Fixation, rest, start + SACCADE_EVERY)]
        })
        .collect()
}

fn hour(criterion: &mut Criterion) {
    let (recording, intervals) = (recording(), intervals());
    let model = preset("generic-90hz").expect("a preset");
    let settings = RunSettings::default();
    let mut group = criterion.benchmark_group("latency/1h_1khz_90hz");
    group.sample_size(10).warm_up_time(Duration::from_secs(1)).measurement_time(Duration::from_secs(5));
    let session = SessionGaze::new(&recording).expect("a session").with_intervals(&intervals);
    let made = run(&session, &model, &settings, 1).expect("a run");
    group.bench_function("session", |bencher| {
        bencher.iter(|| SessionGaze::new(black_box(&recording)).expect("a session"));
    });
    group.bench_function("run", |bencher| {
        bencher.iter(|| run(black_box(&session), &model, &settings, 1).expect("a run"));
    });
    group.bench_function("budget", |bencher| {
        bencher.iter(|| made.budget(black_box(&session), None));
    });
    group.finish();
}

criterion_group!(benches, hour);
criterion_main!(benches);
