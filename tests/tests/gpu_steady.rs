//! After warm-up a frame allocates no heap memory. In a test binary of its own: it counts every
//! allocation of the thread that records and submits.

use glam::{DMat4, DVec2, DVec3};
use macula::headless::{FrameInput, OffscreenRenderer, OffscreenStereo};
use macula::scene::{AlphaMode, LightKind, Material, Scene};
use macula::settings::{KfrSettings, Method, VafrSettings};
use macula::stereo::{StereoGaze, StereoInput, StereoMode, StereoSettings};
use macula_tests::scenes::{add, at, light, one, quad, sun, white};
use macula_tests::{gpu, settings, upload};
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

/// Surfaces before a wall, blended ones among them, under a sun and a lamp.
fn small_scene() -> Scene {
    let mut scene = one(quad(2.0, 2.0), at(0.0, 0.0, -2.0), white(0.2, 0.4));
    for x in -3..=3 {
        let glass = Material { alpha_mode: AlphaMode::Blend, ..white(0.0, 0.5) };
        add(&mut scene, quad(0.1, 0.1), at(f64::from(x) * 0.3, 0.2, -1.5), white(1.0, 0.3));
        add(&mut scene, quad(0.1, 0.1), at(f64::from(x) * 0.3, -0.2, -1.0), glass);
    }
    scene.lights.push(sun(3.0, DVec3::new(0.2, -0.3, -1.0)));
    let point = LightKind::Point { range: 8.0 };
    scene.lights.push(light(2.0, DVec3::new(0.0, 0.5, -1.0), DVec3::NEG_Z, point));
    scene
}

#[test]
fn a_steady_frame_allocates_nothing() {
    let before = ALLOCATIONS.get();
    drop(std::hint::black_box(Box::new(1_u64)));
    assert_eq!(ALLOCATIONS.get(), before + 1, "the counter does not count");

    let gpu = gpu();
    let content = upload(&gpu, &small_scene(), None);
    let kfr = Method::Kfr(KfrSettings { post_filter: true, ..KfrSettings::default() });
    for method in [Method::Full, kfr] {
        for (check_finite, force_effects) in [(false, false), (true, true)] {
            let mut settings = settings([96, 64], 80.0, method.clone());
            settings.shadowed_lights = 2;
            settings.check_finite = check_finite;
            settings.force_effects = force_effects;
            let mut renderer = OffscreenRenderer::new(&gpu, &content, &settings).unwrap();
            // Eye and gaze move; what is in view changes.
            let input = |frame: u32| FrameInput {
                world_from_view: DMat4::from_rotation_y(f64::from(frame % 5) * 0.4),
                gaze_px: DVec2::new(f64::from(frame * 13 % 96), f64::from(frame * 7 % 64)),
            };
            for frame in 0..4 {
                renderer.submit(&input(frame)).unwrap();
            }
            let before = ALLOCATIONS.get();
            for frame in 4..20 {
                let slot = renderer.record(&input(frame)).unwrap();
                renderer.late_latch(slot, input(frame + 1).gaze_px);
                renderer.launch().unwrap();
                renderer.wait().unwrap();
            }
            let allocated = ALLOCATIONS.get() - before;
            assert_eq!(allocated, 0, "{method:?}: {allocated} allocations in 16 frames");
        }
    }
}

#[test]
fn a_steady_frame_of_both_eyes_allocates_nothing() {
    let gpu = gpu();
    let content = upload(&gpu, &small_scene(), None);
    for method in [Method::Kfr(KfrSettings::default()), Method::Vafr(VafrSettings::default())] {
        for mode in [StereoMode::Dup, StereoMode::Rep] {
            let settings = StereoSettings::mirrored(settings([96, 64], 80.0, method.clone()), 0.063, mode);
            let mut renderer = OffscreenStereo::new(&gpu, &content, &settings).unwrap();
            let gaze = |frame: u32| {
                StereoGaze::Point(DVec3::new(
                    f64::from(frame % 7) * 0.3 - 1.0,
                    f64::from(frame % 3) * 0.4,
                    -1.5,
                ))
            };
            let input = |frame: u32| StereoInput {
                world_from_head: DMat4::from_rotation_y(f64::from(frame % 5) * 0.4),
                gaze: gaze(frame),
            };
            for frame in 0..4 {
                renderer.render(&input(frame)).unwrap();
            }
            let before = ALLOCATIONS.get();
            for frame in 4..16 {
                let slot = renderer.record(&input(frame)).unwrap();
                renderer.late_latch(slot, gaze(frame + 1));
                renderer.launch().unwrap();
                renderer.wait().unwrap();
            }
            let allocated = ALLOCATIONS.get() - before;
            assert_eq!(allocated, 0, "{mode:?} {method:?}: {allocated} allocations in 12 frames");
        }
    }
}
