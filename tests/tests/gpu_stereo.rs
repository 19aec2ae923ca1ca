//! Both eyes in one frame: each as if rendered by itself, or the right one from the left one.

use glam::{DMat4, DVec2, DVec3, Vec2};
use macula::fovea::DisplayGeometry;
use macula::headless::{GpuContent, OffscreenStereo};
use macula::scene::{AlphaMode, Material, Scene};
use macula::settings::{KfrSettings, LpFilter, Method, RenderSettings, VafrSettings};
use macula::stats::FrameStats;
use macula::stereo::{StereoGaze, StereoInput, StereoMode, StereoSettings};
use macula_tests::scenes::{add, at, coloured_quad, light, one, quad, sun, unlit, white};
use macula_tests::{Frame, Gpu, gpu, kfr, psnr, render_content, upload};

const SIZE: [u32; 2] = [160, 144];
const IPD_M: f64 = 0.064;

/// A left eye's frustum: wider to the left than to the nose.
fn left_settings(method: Method) -> RenderSettings {
    let display =
        DisplayGeometry { size_px: SIZE, tan_left: -1.1, tan_right: 0.8, tan_up: 0.9, tan_down: -1.0 };
    RenderSettings { check_finite: true, ..RenderSettings::new(display, method) }
}

fn stereo(method: Method, mode: StereoMode) -> StereoSettings {
    StereoSettings::mirrored(left_settings(method), IPD_M, mode)
}

fn looking_at(point: DVec3) -> StereoInput {
    StereoInput { world_from_head: DMat4::IDENTITY, gaze: StereoGaze::Point(point) }
}

/// The eyes' frames.
fn both(gpu: &Gpu, content: &GpuContent, settings: &StereoSettings, input: &StereoInput) -> [Frame; 2] {
    let mut renderer = OffscreenStereo::new(gpu, content, settings).expect("a renderer");
    // The second frame finds what the first has left.
    renderer.render(input).expect("a frame");
    let stats = renderer.render(input).expect("a frame");
    let [left, right] = renderer.read_hdr().expect("radiance");
    let [left8, right8] = renderer.read_rgba8().expect("pictures");
    let effects = renderer.effects().map(Clone::clone);
    let frame = |hdr, rgba8, stats: &FrameStats, effects: &macula::stats::Effects| Frame {
        size: SIZE,
        stats: stats.clone(),
        hdr,
        rgba8,
        effects: effects.clone(),
        plan_text: renderer.plan_text(),
    };
    let frames = [frame(left, left8, &stats[0], &effects[0]), frame(right, right8, &stats[1], &effects[1])];
    for (frame, eye) in frames.iter().zip(["left", "right"]) {
        frame.check_whole(eye);
    }
    frames
}

/// Share of the right eye's samples on the display that were taken from the left one.
fn reused_share(right: &Frame) -> f64 {
    let lp = right.stats.lp.expect("a foveated frame");
    lp.reused as f64 / (lp.reused + lp.shaded_on_display + lp.native_pixels) as f64
}

/// A floor, a wall and a ball's worth of boards, all of them matte.
fn room(material: impl Fn(f32) -> Material) -> Scene {
    let colours = [[255, 40, 40, 255], [40, 255, 40, 255], [40, 40, 255, 255], [230, 230, 230, 255]];
    let wall = coloured_quad(Vec2::new(6.0, 4.0), colours);
    let mut scene = one(wall, at(0.0, 0.0, -4.0), material(0.9));
    let floor = DMat4::from_translation(DVec3::new(0.0, -1.2, -3.0)) * DMat4::from_rotation_x(-1.57);
    add(&mut scene, coloured_quad(Vec2::new(5.0, 5.0), colours), floor, material(0.8));
    scene.lights.push(sun(3.0, DVec3::new(0.2, -0.6, -1.0)));
    scene.lights.push(light(
        6.0,
        DVec3::new(-0.5, 0.8, -2.0),
        DVec3::NEG_Z,
        macula::scene::LightKind::Point { range: f32::INFINITY },
    ));
    scene
}

fn matte(roughness: f32) -> Material {
    white(0.0, roughness)
}

fn methods() -> [Method; 3] {
    [kfr(1.8, 4.0), Method::Vafr(VafrSettings::default()), Method::Full]
}

#[test]
fn both_eyes_are_what_each_is_by_itself() {
    let gpu = gpu();
    let content = upload(&gpu, &room(matte), None);
    for method in methods() {
        let settings = stereo(method, StereoMode::Dup);
        let input = looking_at(DVec3::new(0.3, -0.2, -2.0));
        let eyes = both(&gpu, &content, &settings, &input);
        let alone = [&settings.left, &settings.right].into_iter().zip(input.eyes(&settings));
        for (found, (of, input)) in eyes.iter().zip(alone) {
            let expected = render_content(&gpu, &content, of, &input);
            assert!(found.hdr == expected.hdr && found.rgba8 == expected.rgba8, "{:?}", of.method);
            assert_eq!(found.stats.samples_shaded, expected.stats.samples_shaded);
        }
        assert!(eyes[0].hdr != eyes[1].hdr);
    }
}

#[test]
fn the_eyes_look_at_one_point() {
    let settings = stereo(Method::Full, StereoMode::Dup);
    let half = IPD_M / 2.0;
    // The right eye sees the point to the left of where the left eye sees it, by the angle between them.
    let near = looking_at(DVec3::new(0.0, 0.1, -0.5)).eyes(&settings);
    let across = |of: &RenderSettings, tangent: f64| {
        let d = &of.display;
        f64::from(SIZE[0]) * (tangent - d.tan_left) / (d.tan_right - d.tan_left)
    };
    assert!((near[0].gaze_px.x - across(&settings.left, half / 0.5)).abs() < 1e-9);
    assert!((near[1].gaze_px.x - across(&settings.right, -half / 0.5)).abs() < 1e-9);
    assert!((near[0].gaze_px.y - near[1].gaze_px.y).abs() < 1e-9);
    let apart = near[1].world_from_view.w_axis - near[0].world_from_view.w_axis;
    assert!((apart.truncate() - DVec3::new(IPD_M, 0.0, 0.0)).length() < 1e-12);
    // From the left eye's pixel and back; without a distance in parallel.
    let px = DVec2::new(31.0, 99.0);
    for distance in [None, Some(0.4), Some(1e4)] {
        let gaze = StereoGaze::of_left(&settings, px, distance);
        let eyes = StereoInput { world_from_head: DMat4::IDENTITY, gaze }.eyes(&settings);
        assert!(eyes[0].gaze_px.distance(px) < 1e-9, "{distance:?}");
        let ray = |of: &RenderSettings, px| of.display.ray_of_px(px).normalize();
        let angle = ray(&settings.left, px).angle_between(ray(&settings.right, eyes[1].gaze_px));
        let wanted = distance.map_or(0.0, |distance_m| IPD_M / distance_m);
        assert!(angle <= wanted + 1e-9 && angle >= 0.5 * wanted, "{distance:?}: {angle}");
    }
    // Behind the display's plane there is nothing to look at; the last gaze is held.
    let behind = looking_at(DVec3::new(0.0, 0.0, 1.0)).eyes(&settings);
    assert!(behind.iter().all(|eye| eye.gaze_px.is_nan()));
}

#[test]
fn matte_surfaces_are_taken_from_the_left_eye() {
    let gpu = gpu();
    let content = upload(&gpu, &room(matte), None);
    for method in &methods()[..2] {
        let dup = stereo(method.clone(), StereoMode::Dup);
        let rep = stereo(method.clone(), StereoMode::Rep);
        for point in [DVec3::new(0.0, 0.0, -4.0), DVec3::new(-2.4, 1.6, -4.0), DVec3::new(0.5, -1.2, -2.0)] {
            let expected = both(&gpu, &content, &dup, &looking_at(point));
            let found = both(&gpu, &content, &rep, &looking_at(point));
            assert!(found[0].hdr == expected[0].hdr, "the left eye gives and does not change");
            let share = reused_share(&found[1]);
            let (lp, all) = (found[1].stats.lp.unwrap(), expected[1].stats.lp.unwrap());
            assert_eq!(
                lp.reused + lp.shaded + lp.native_pixels,
                all.shaded + all.native_pixels,
                "every sample is either shaded or taken"
            );
            let psnr = psnr(&found[1], &expected[1]);
            println!("{point}: {share:.3} reused, {psnr:.1} dB");
            // What only the right eye sees at its edge: the frusta differ by 0.3 of 1.9, so that a fifth
            // of the samples at most has no counterpart.
            assert!(share > 0.7, "{method:?} {point}: {share}");
            // Smooth shading interpolated once more: steps of 1 or 2 of 255 (RMS 1.8 is 43 dB).
            assert!(psnr > 40.0, "{method:?} {point}: {psnr}");
        }
    }
}

#[test]
fn shiny_surfaces_are_shaded_for_each_eye() {
    let gpu = gpu();
    let smooth = |_| white(0.0, 0.2);
    let metal = |_| white(1.0, 0.9);
    for scene in [room(smooth), room(metal)] {
        let content = upload(&gpu, &scene, None);
        for method in &methods()[..2] {
            let input = looking_at(DVec3::new(0.0, 0.0, -4.0));
            let expected = both(&gpu, &content, &stereo(method.clone(), StereoMode::Dup), &input);
            let found = both(&gpu, &content, &stereo(method.clone(), StereoMode::Rep), &input);
            assert_eq!(found[1].stats.lp.map(|lp| lp.reused), Some(0));
            assert!(found[1].hdr == expected[1].hdr && found[1].rgba8 == expected[1].rgba8, "{method:?}");
        }
    }
}

/// A red board before a green wall, both unlit, so that a ghost of one on the other is a colour.
fn board_before_wall() -> Scene {
    let mut scene = one(quad(8.0, 8.0), at(0.0, 0.0, -4.0), unlit(0.0, 1.0, 0.0));
    add(&mut scene, quad(0.12, 0.2), at(0.02, 0.0, -0.6), unlit(1.0, 0.0, 0.0));
    scene
}

/// Surfaces have one colour each, so a sample that was taken has the very colour that shading gives, but
/// for a neighbour's share: within the depth's tolerance (0.001 over the relative step from 0.6 to 4 m, so
/// 0.0012), and where the places at which depths are compared miss a texel's outermost part. A ghost would
/// be a difference of 1.
const GHOST: f32 = 2.0 / 255.0;

fn greatest_difference(a: &Frame, b: &Frame) -> f32 {
    a.hdr.iter().zip(&b.hdr).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn what_the_left_eye_does_not_see_is_shaded() {
    let gpu = gpu();
    let content = upload(&gpu, &board_before_wall(), None);
    for method in [
        Method::Kfr(KfrSettings { sigma: 1.8, lp_filter: LpFilter::None, ..KfrSettings::default() }),
        Method::Vafr(VafrSettings::default()),
    ] {
        for point in [DVec3::new(0.0, 0.0, -0.6), DVec3::new(0.0, 0.0, -4.0), DVec3::new(1.5, 1.0, -4.0)] {
            let input = looking_at(point);
            let expected = both(&gpu, &content, &stereo(method.clone(), StereoMode::Dup), &input);
            let found = both(&gpu, &content, &stereo(method.clone(), StereoMode::Rep), &input);
            assert!(reused_share(&found[1]) > 0.5, "{method:?}");
            let most = greatest_difference(&found[1], &expected[1]);
            assert!(most < GHOST, "{method:?} {point}: {most}");
        }
    }
}

#[test]
fn glass_before_a_wall_is_not_taken_along() {
    let gpu = gpu();
    let mut scene = board_before_wall();
    let glass = Material {
        alpha_mode: AlphaMode::Blend,
        base_color: glam::Vec4::new(0.0, 0.0, 1.0, 0.5),
        ..unlit(0.0, 0.0, 1.0)
    };
    add(&mut scene, quad(0.1, 0.1), at(-0.2, 0.1, -0.5), glass);
    let content = upload(&gpu, &scene, None);
    let input = looking_at(DVec3::new(0.0, 0.0, -4.0));
    let method = Method::Kfr(KfrSettings { lp_filter: LpFilter::None, ..KfrSettings::default() });
    let expected = both(&gpu, &content, &stereo(method.clone(), StereoMode::Dup), &input);
    let found = both(&gpu, &content, &stereo(method, StereoMode::Rep), &input);
    assert!(found[0].passes().contains(&"keep") && !expected[0].passes().contains(&"keep"));
    assert!(found[0].hdr == expected[0].hdr);
    assert!(reused_share(&found[1]) > 0.5);
    let most = greatest_difference(&found[1], &expected[1]);
    assert!(most < GHOST, "{most}");
}

#[test]
fn what_cannot_be_is_refused() {
    let gpu = gpu();
    let content = upload(&gpu, &room(matte), None);
    let refused = |settings: &StereoSettings, content: &GpuContent| {
        let error = OffscreenStereo::new(&gpu, content, settings).err().expect("refused").to_string();
        assert!(!error.contains('\n') && error.len() > 20, "{error}");
        error
    };
    let good = stereo(kfr(1.8, 4.0), StereoMode::Rep);
    assert!(refused(&stereo(Method::Full, StereoMode::Rep), &content).contains("foveated"));
    for ipd_m in [-0.01, 0.3, f64::NAN, f64::INFINITY] {
        assert!(refused(&StereoSettings { ipd_m, ..good.clone() }, &content).contains("eyes"));
    }
    let lopsided = StereoSettings { right: good.left.clone(), ..good.clone() };
    assert!(refused(&lopsided, &content).contains("mirrored"));
    let mut loose = good.clone();
    loose.reuse.depth_tolerance = f32::NAN;
    assert!(refused(&loose, &content).contains("tolerance"));
    let marched = GpuContent::upload(&gpu, &macula::headless::Content::SdfPrimitives).expect("uploads");
    assert!(refused(&good, &marched).contains("G-buffer"));
    let dup = stereo(kfr(1.8, 4.0), StereoMode::Dup);
    let input = looking_at(DVec3::new(0.0, 0.0, -4.0));
    both(&gpu, &marched, &dup, &input);
}
