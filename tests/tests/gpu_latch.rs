//! Late latching: a gaze that is written after the frame was recorded is the one that the picture has.

use glam::{DMat4, DVec2};
use macula::headless::{Content, FrameInput, GpuContent, OffscreenRenderer};
use macula::settings::{RenderSettings, View};
use macula_tests::{gpu, kfr, settings};

const SIZE: [u32; 2] = [320, 180];

fn input(gaze_px: DVec2) -> FrameInput {
    FrameInput { world_from_view: DMat4::from_translation(glam::DVec3::new(-2.2, 3.4, 8.4)), gaze_px }
}

/// Radiance of a frame recorded for one gaze and latched to another.
fn latched(renderer: &mut OffscreenRenderer, recorded: DVec2, latched: DVec2) -> Vec<f32> {
    let frame = renderer.record(&input(recorded)).unwrap();
    renderer.late_latch(frame, latched);
    renderer.launch().unwrap();
    renderer.wait().unwrap();
    let stats = renderer.read_stats(frame).unwrap();
    assert_eq!((stats.non_finite, stats.holes, stats.gaze_held), (Some(0), Some(0), false));
    renderer.read_hdr().unwrap()
}

fn recorded(renderer: &mut OffscreenRenderer, gaze_px: DVec2) -> Vec<f32> {
    renderer.submit(&input(gaze_px)).unwrap();
    renderer.read_hdr().unwrap()
}

#[test]
fn the_latched_gaze_is_the_one_rendered() {
    let gpu = gpu();
    let content = GpuContent::upload(&gpu, &Content::SdfPrimitives).unwrap();
    let settings: RenderSettings = settings(SIZE, 100.0, kfr(1.8, 4.0));
    let mut renderer = OffscreenRenderer::new(&gpu, &content, &settings).unwrap();
    let centre = DVec2::new(160.0, 90.0);
    let other = recorded(&mut renderer, centre);
    // A step of the eye, a saccade to where the native disc is somewhat wider, and off the display.
    for gaze in [DVec2::new(171.5, 84.25), DVec2::new(230.0, 60.0), DVec2::new(335.0, 90.0)] {
        let expected = recorded(&mut renderer, gaze);
        assert!(expected != other, "the gaze makes no difference");
        // Compared as a whole: a failure would print every value.
        assert!(latched(&mut renderer, centre, gaze) == expected, "{gaze}");
        assert!(latched(&mut renderer, gaze, centre) == other, "{gaze} and back");
    }
}

#[test]
fn a_far_jump_is_whole_and_a_gaze_that_is_none_changes_nothing() {
    let gpu = gpu();
    let content = GpuContent::upload(&gpu, &Content::SdfPrimitives).unwrap();
    let mut settings = settings(SIZE, 100.0, kfr(1.8, 4.0));
    let mut renderer = OffscreenRenderer::new(&gpu, &content, &settings).unwrap();
    let centre = DVec2::new(160.0, 90.0);
    for gaze in [DVec2::ZERO, DVec2::new(320.0, 180.0), DVec2::new(-1e6, 1e6)] {
        let there = latched(&mut renderer, centre, gaze);
        let back = latched(&mut renderer, gaze, centre);
        assert!(there.iter().chain(&back).all(|value| value.is_finite()));
    }
    let expected = recorded(&mut renderer, centre);
    for none in [DVec2::NAN, DVec2::new(f64::INFINITY, 0.0)] {
        let frame = renderer.record(&input(centre)).unwrap();
        renderer.late_latch(frame, none);
        renderer.launch().unwrap();
        renderer.wait().unwrap();
        assert!(renderer.read_hdr().unwrap() == expected, "{none}");
    }
    // Debug views read the gaze from another block.
    settings.view = View::Gaze;
    let mut renderer = OffscreenRenderer::new(&gpu, &content, &settings).unwrap();
    let gaze = DVec2::new(200.0, 100.0);
    recorded(&mut renderer, gaze);
    let expected = renderer.read_rgba8().unwrap();
    latched(&mut renderer, centre, gaze);
    assert!(renderer.read_rgba8().unwrap() == expected, "the cross is elsewhere");
}

#[test]
fn a_frame_is_recorded_while_another_is_rendered() {
    let gpu = gpu();
    let content = GpuContent::upload(&gpu, &Content::SdfPrimitives).unwrap();
    let settings = settings(SIZE, 100.0, kfr(1.8, 4.0));
    let mut renderer = OffscreenRenderer::new(&gpu, &content, &settings).unwrap();
    let gazes = [DVec2::new(40.0, 30.0), DVec2::new(160.0, 90.0), DVec2::new(300.0, 170.0)];
    let expected = gazes.map(|gaze| recorded(&mut renderer, gaze));
    let mut next = renderer.record(&input(gazes[0])).unwrap();
    for (index, expected) in expected.iter().enumerate() {
        let current = next;
        renderer.launch().unwrap();
        if let Some(gaze) = gazes.get(index + 1) {
            next = renderer.record(&input(*gaze)).unwrap();
        }
        renderer.wait().unwrap();
        assert_eq!(renderer.read_stats(current).unwrap().non_finite, Some(0));
        assert!(&renderer.read_hdr().unwrap() == expected, "frame {index}");
    }
}

#[test]
fn a_frame_that_is_not_launched_disturbs_none_that_is() {
    let gpu = gpu();
    let content = GpuContent::upload(&gpu, &Content::SdfPrimitives).unwrap();
    let settings = settings(SIZE, 100.0, kfr(1.8, 4.0));
    let mut renderer = OffscreenRenderer::new(&gpu, &content, &settings).unwrap();
    let (rendered, dropped) = (DVec2::new(40.0, 30.0), DVec2::new(300.0, 170.0));
    let expected = recorded(&mut renderer, rendered);
    renderer.record(&input(rendered)).unwrap();
    renderer.launch().unwrap();
    for _ in 0..3 {
        renderer.record(&input(dropped)).unwrap();
    }
    renderer.wait().unwrap();
    assert!(renderer.read_hdr().unwrap() == expected, "another frame's picture");
    renderer.record(&input(rendered)).unwrap();
    renderer.launch().unwrap();
    renderer.launch().unwrap();
    renderer.wait().unwrap();
    assert!(renderer.read_hdr().unwrap() == expected, "launched twice");
}
