//! After it was made, an estimator allocates no heap memory. In a test binary of its own: it counts every
//! allocation of the thread that pushes and asks.

use glam::{DQuat, DVec3};
use macula_trackers::estimator::{Aim, Estimator, EstimatorSettings, FilterKind};
use macula_trackers::predict::PredictorKind;
use macula_trackers::sample::{EyeSample, GazeSample, HeadPose};
use macula_trackers::source::SourceEvent;
use macula_trackers::{EstimateKind, EyeState};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    // Threads that end allocate after their locals are gone; those do not count.
    let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
}

// SAFETY: everything is handed on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: as the caller promises.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: as the caller promises.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const MS: i64 = 1_000_000;

/// At 1 kHz by turns of 3 s: rest with a saccade of 10 degrees every 300 ms, a blink, one eye, a pursuit, a
/// loss of 700 ms, rubbish; and a jump back of the clock at 12 s. The head turns all the while.
fn sample(ms: i64) -> GazeSample {
    let within = ms % 3_000;
    let x = ((ms % 300) as f64 / 43.0).min(1.0);
    let covered = x.powi(3) * (10.0 - 15.0 * x + 6.0 * x * x);
    let saccades = 10.0 * if (ms / 300) % 2 == 0 { covered } else { 1.0 - covered };
    let pursuit = if (1_500..2_000).contains(&within) { (within - 1_500) as f64 * 0.015 } else { 0.0 };
    let angle = (saccades + pursuit).to_radians();
    let direction = Some(DVec3::new(angle.sin(), 0.0, -angle.cos()));
    let eye = EyeSample { valid: true, direction, openness: Some(0.9), ..EyeSample::default() };
    let turn = DQuat::from_rotation_y(ms as f64 * 1e-4);
    let head = Some(HeadPose { position_m: DVec3::ZERO, world_from_view: turn });
    let time_ns = if ms < 12_000 { ms * MS } else { (ms - 11_000) * MS - 1_000_000 * MS };
    let sample = GazeSample { combined: eye, left: eye, right: eye, head, ..GazeSample::at(time_ns) };
    match within {
        1_000..1_150 | 2_200..2_900 => GazeSample { head, ..GazeSample::at(time_ns) },
        1_200..1_300 => GazeSample { combined: EyeSample::default(), right: EyeSample::default(), ..sample },
        2_100..2_110 => GazeSample {
            combined: EyeSample { direction: Some(DVec3::NAN), ..eye },
            left: EyeSample::default(),
            right: EyeSample::default(),
            ..sample
        },
        _ => sample,
    }
}

#[test]
fn push_and_estimate_at_allocate_nothing() {
    let before = ALLOCATIONS.get();
    drop(std::hint::black_box(Box::new(1_u64)));
    assert_eq!(ALLOCATIONS.get(), before + 1, "the counter does not count");

    for predictor in PredictorKind::ALL {
        for filter in [FilterKind::None, FilterKind::OneEuro, FilterKind::SaccadeAware] {
            for aim in [Aim::Landing, Aim::Trajectory] {
                let settings = EstimatorSettings { predictor, filter, aim, ..EstimatorSettings::default() };
                let mut estimator = Estimator::new(settings);
                let (mut kinds, mut states) = (Vec::with_capacity(16), Vec::with_capacity(16));
                let before = ALLOCATIONS.get();
                for ms in (0..13_000).filter(|ms| ms % 300 != 150) {
                    let sample = sample(ms);
                    estimator.on_event(&SourceEvent::Sample(sample));
                    for ahead_ms in [-700, -50, 0, 30, 150, 300] {
                        let told = estimator.estimate_at(sample.time_ns + ahead_ms * MS);
                        let Some(told) = told else { continue };
                        if !kinds.contains(&told.kind) {
                            kinds.push(told.kind);
                        }
                        if !states.contains(&told.eye_state) {
                            states.push(told.eye_state);
                        }
                    }
                }
                assert_eq!(ALLOCATIONS.get(), before, "{predictor:?}, {filter:?}, {aim:?}");
                // The input did lead everywhere.
                use EstimateKind::{Held, Interpolated, Measured, Predicted, Stale};
                for kind in [Measured, Interpolated, Predicted, Held, Stale] {
                    assert!(kinds.contains(&kind), "{kind:?} not in {kinds:?}");
                }
                use EyeState::{Blink, Fixation, Lost, Pursuit, Saccade};
                for state in [Fixation, Saccade, Pursuit, Blink, Lost] {
                    assert!(states.contains(&state), "{state:?} not in {states:?}");
                }
            }
        }
    }
}
