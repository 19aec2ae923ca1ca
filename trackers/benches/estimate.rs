//! What one sample and one answer cost: `cargo bench -p macula-trackers --bench estimate`.

use criterion::{Criterion, criterion_group, criterion_main};
use glam::DVec3;
use macula_trackers::estimator::{Estimator, EstimatorSettings};
use macula_trackers::sample::{EyeSample, GazeSample};
use std::hint::black_box;

const MS: i64 = 1_000_000;

/// 1 kHz: every 300 ms a saccade of 10 degrees in 43 ms, to and fro.
fn sample(ms: i64) -> GazeSample {
    let x = ((ms % 300) as f64 / 43.0).min(1.0);
    let covered = x.powi(3) * (10.0 - 15.0 * x + 6.0 * x * x);
    let deg = 10.0 * if (ms / 300) % 2 == 0 { covered } else { 1.0 - covered };
    let direction = DVec3::new(deg.to_radians().sin(), 0.0, -deg.to_radians().cos());
    let eye = EyeSample { valid: true, direction: Some(direction), ..EyeSample::default() };
    GazeSample { combined: eye, ..GazeSample::at(ms * MS) }
}

fn fed(count: i64) -> Estimator {
    let mut estimator = Estimator::new(EstimatorSettings::default());
    // One sample is missing.
    for ms in (0..count).filter(|ms| *ms != 2_500) {
        estimator.push(&sample(ms));
    }
    estimator
}

fn estimate(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("estimate_at");
    let last = 2_999 * MS;
    let mut lost = fed(3_000);
    for ms in 3_000..3_900 {
        lost.push(&GazeSample::at(ms * MS));
    }
    for (name, estimator, time_ns) in [
        ("predicted, at rest", fed(3_000), last + 30 * MS),
        ("predicted, in a saccade", fed(3_022), last + 50 * MS),
        ("measured", fed(3_000), 2_400 * MS),
        ("interpolated", fed(3_000), 2_500 * MS),
        ("held, after 900 ms of loss", lost, last + 910 * MS),
        ("before the history", fed(3_000), 0),
    ] {
        assert!(estimator.estimate_at(time_ns).is_some(), "{name}");
        group.bench_function(name, |bencher| bencher.iter(|| estimator.estimate_at(black_box(time_ns))));
    }
    group.finish();
    // 600 ms are a whole period of the movement.
    criterion.bench_function("push, 600 samples with two saccades", |bencher| {
        let mut estimator = fed(600);
        let mut ms = 600;
        bencher.iter(|| {
            for _ in 0..600 {
                estimator.push(black_box(&sample(ms)));
                ms += 1;
            }
        });
    });
}

criterion_group!(benches, estimate);
criterion_main!(benches);
