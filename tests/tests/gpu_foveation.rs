//! The foveated picture: equal to full shading where the eye looks, and without seams, rings or holes
//! elsewhere.

use glam::{DVec2, Vec2};
use macula::fovea::{Kernel, KfrMapping};
use macula::headless::{FrameInput, GpuContent, HeadlessDevice, OffscreenRenderer};
use macula::quality::compare;
use macula::scene::Scene;
use macula::settings::{KfrSettings, LpFilter, Method, ToneMap};
use macula_tests::scenes::{at, camera_of, coloured_quad, hall, one, quad, unlit};
use macula_tests::{Frame, ahead, gpu, kfr, kfr_with, next_frame, render_content, settings, upload};

/// Full shading and a list of (sigma, alpha), all of one view of the hall with one gaze.
struct HallViews {
    full: Frame,
    foveated: Vec<(f64, f64, Frame)>,
    input: FrameInput,
    display: macula::fovea::DisplayGeometry,
}

fn hall_views(
    gpu: &HeadlessDevice,
    scene: &Scene,
    content: &GpuContent,
    gaze: [f64; 2],
    kernels: &[(f64, f64)],
) -> HallViews {
    let size = [480, 270];
    let full_settings = settings(size, 100.0, Method::Full);
    let input = FrameInput {
        world_from_view: camera_of(scene),
        gaze_px: DVec2::new(gaze[0] * 480.0, gaze[1] * 270.0),
    };
    let full = render_content(gpu, content, &full_settings, &input);
    full.check_whole("full");
    let foveated = kernels.iter().map(|&(sigma, alpha)| {
        let frame = render_content(gpu, content, &settings(size, 100.0, kfr(sigma, alpha)), &input);
        frame.check_whole("kfr");
        (sigma, alpha, frame)
    });
    HallViews { full, foveated: foveated.collect(), input, display: full_settings.display }
}

#[test]
fn the_fovea_is_that_of_full_shading() {
    let gpu = gpu();
    let scene = hall(20_000, 16);
    let content = upload(&gpu, &scene, None);
    let kernels = [(1.0, 1.0), (1.0, 2.0), (1.0, 3.0), (1.0, 4.0), (1.8, 4.0)];
    for (gaze, kernels) in [([0.5, 0.5], &kernels[..]), ([0.21, 0.77], &kernels[3..])] {
        let views = hall_views(&gpu, &scene, &content, gaze, kernels);
        for (sigma, alpha, frame) in &views.foveated {
            let (a, b) = (views.full.rgb8(), frame.rgb8());
            let psnr = compare::within(&a, &b, &views.display, views.input.gaze_px, 5.0).unwrap().unwrap();
            let whole = compare::psnr_db(&a, &b).unwrap();
            let least = if *sigma > 1.0 { 40.0 } else { 50.0 };
            println!(
                "gaze {gaze:?} sigma {sigma} alpha {alpha}: {psnr:.1} dB within 5 degrees, {whole:.1} in all"
            );
            assert!(psnr > least, "sigma {sigma} alpha {alpha}: {psnr} dB within 5 degrees of the gaze");
            // Foveation does something, and the picture is still the same scene.
            assert!(whole > 15.0 && frame.stats.samples_shaded > 0, "{whole} dB");
            native_pixels_are_equal(&views, *sigma, *alpha, frame);
        }
    }
}

fn native_pixels_are_equal(views: &HallViews, sigma: f64, alpha: f64, frame: &Frame) {
    let gaze_px = views.input.gaze_px;
    let mapping = KfrMapping::new(views.display.size_px, gaze_px, Kernel::Power { alpha }, sigma);
    let radius_px = mapping.native_radius_px() - mapping.blend_band_px();
    let (mut seen, [width, height]) = (0, frame.size);
    for y in 0..height {
        for x in 0..width {
            let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            if centre.distance(gaze_px) < radius_px - 1e-3 {
                assert_eq!(frame.at(x, y), views.full.at(x, y), "sigma {sigma} alpha {alpha} at {x}, {y}");
                seen += 1;
            }
        }
    }
    let lp = frame.stats.lp.unwrap();
    assert!(lp.native_pixels >= seen, "{lp:?}");
    println!("  native radius {:.1} px, {seen} pixels equal", mapping.native_radius_px());
}

#[test]
fn samples_are_counted_as_the_mapping_says() {
    let gpu = gpu();
    let scene = one(quad(9.0, 9.0), at(0.0, 0.0, -1.0), unlit(0.5, 0.5, 0.5));
    let content = upload(&gpu, &scene, None);
    let size = [160, 90];
    for (sigma, alpha, gaze) in
        [(1.8, 4.0, [80.0, 45.0]), (1.8, 4.0, [10.0, 80.0]), (3.0, 1.0, [-40.0, 20.0])]
    {
        let settings = settings(size, 90.0, kfr(sigma, alpha));
        let gaze_px = DVec2::from_array(gaze);
        let frame = render_content(&gpu, &content, &settings, &FrameInput { gaze_px, ..ahead(&settings) });
        let mapping = KfrMapping::new(size, gaze_px, Kernel::Power { alpha }, sigma);
        let [width, height] = mapping.lp_size();
        // Counted texel by texel with the mapping in double precision.
        let on_display = (0..width)
            .flat_map(|u| (0..height).map(move |v| (u, v)))
            .filter(|(u, v)| {
                let px = mapping.inverse(macula::fovea::LpCoord {
                    u_norm: (f64::from(*u) + 0.5) / f64::from(width),
                    v_norm: (f64::from(*v) + 0.5) / f64::from(height),
                });
                px.x >= 0.0 && px.y >= 0.0 && px.x < 160.0 && px.y < 90.0
            })
            .count() as u64;
        let lp = frame.stats.lp.unwrap();
        assert_eq!((lp.width, lp.height, lp.texels), (width, height, u64::from(width * height)));
        // Single precision may decide differently at the very edge.
        let off = lp.on_display.abs_diff(on_display);
        assert!(off <= 4, "{lp:?}, not {on_display} on the display");
        assert!(lp.shaded <= lp.texels);
        assert_eq!(frame.stats.samples_shaded, lp.shaded + lp.native_pixels);
    }
}

/// A colour that the G-buffer holds exactly.
const COLOUR: [f32; 3] = [0.5, 0.25, 0.75];

#[test]
fn a_constant_picture_stays_constant() {
    let gpu = gpu();
    let scene = one(quad(900.0, 900.0), at(0.0, 0.0, -1.0), unlit(COLOUR[0], COLOUR[1], COLOUR[2]));
    let content = upload(&gpu, &scene, None);
    for (sigma, kernel, post_filter) in [
        (1.0, Kernel::Power { alpha: 1.0 }, false),
        (1.8, Kernel::Power { alpha: 4.0 }, true),
        (4.0, Kernel::Power { alpha: 6.0 }, false),
        (1.8, Kernel::Sine, false),
    ] {
        let method = Method::Kfr(KfrSettings { sigma, kernel, lp_filter: LpFilter::Gaussian, post_filter });
        let settings = settings([160, 90], 100.0, method);
        let mut renderer = OffscreenRenderer::new(&gpu, &content, &settings).unwrap();
        for (x, y) in
            [(80.0, 45.0), (80.3, 44.6), (0.0, 0.0), (160.0, 30.0), (-30.0, 45.0), (400.0, 400.0), (1e6, 7.0)]
        {
            let gaze_px = DVec2::new(x, y);
            let frame = next_frame(&mut renderer, &settings, &FrameInput { gaze_px, ..ahead(&settings) });
            frame.check_whole("constant");
            for (index, pixel) in frame.hdr.chunks(4).enumerate() {
                let off = (0..3).map(|c| (pixel[c] - COLOUR[c]).abs()).fold(0.0, f32::max);
                assert!(
                    off < 1.0 / 255.0,
                    "{kernel:?} sigma {sigma} gaze {gaze_px}: {pixel:?} at {}, {}",
                    index % 160,
                    index / 160
                );
            }
        }
    }
}

/// A picture that rises evenly from left to right (red), from top to bottom (green) and along the
/// diagonal (blue).
fn ramp_scene(half_x: f32, half_y: f32) -> Scene {
    let colors = [[0, 255, 128, 255], [255, 255, 255, 255], [255, 0, 128, 255], [0, 0, 0, 255]];
    one(coloured_quad(Vec2::new(half_x, half_y), colors), at(0.0, 0.0, -1.0), unlit(1.0, 1.0, 1.0))
}

#[test]
fn a_ramp_comes_back_as_a_ramp() {
    let gpu = gpu();
    let size = [240, 160];
    let display = settings(size, 90.0, Method::Full).display;
    let scene = ramp_scene(display.tan_right as f32, display.tan_up as f32);
    let content = upload(&gpu, &scene, None);
    for (sigma, alpha, filtered) in [(1.0, 4.0, false), (1.8, 4.0, true), (1.8, 1.0, false), (3.0, 2.0, true)]
    {
        let kernel = Kernel::Power { alpha };
        let lp_filter = if filtered { LpFilter::Gaussian } else { LpFilter::None };
        let method = Method::Kfr(KfrSettings { sigma, kernel, lp_filter, post_filter: false });
        let settings = settings(size, 90.0, method);
        for gaze in [[120.0, 80.0], [60.0, 110.0]] {
            let gaze_px = DVec2::from_array(gaze);
            let frame =
                render_content(&gpu, &content, &settings, &FrameInput { gaze_px, ..ahead(&settings) });
            frame.check_whole("ramp");
            let mapping = KfrMapping::new(size, gaze_px, kernel, sigma);
            let (mut worst_share, mut sum_px, mut shrink_px, mut count) = (0.0_f64, 0.0, 0.0, 0.0_f64);
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                    let radius_px = centre.distance(gaze_px);
                    // Red rises by 1/240 a pixel: the error as a distance along x.
                    let error_px = frame.at(x, y)[0] * 240.0 - centre.x;
                    // What a texel covers, along the radius and across.
                    let along_px = 1.0 / (mapping.du_dr(radius_px) * f64::from(mapping.lp_size()[0]));
                    let across_px = std::f64::consts::TAU * radius_px / f64::from(mapping.lp_size()[1]);
                    // A sample is the pixel that holds the texel's centre: 0.5 px off at most, and
                    // interpolation keeps that. The 9-bit colour costs 240/1024 px. Texels just off the
                    // display take its border's pixel, and a chord cuts its arc: by less than a texel
                    // close to the border, by a fraction of one inside.
                    let to_border_px = centre.min(DVec2::new(240.0, 160.0) - centre).min_element();
                    let texel_px = along_px.min(1e3).hypot(across_px);
                    let share = if to_border_px < 2.0 * texel_px { 1.0 } else { 0.25 };
                    let bound_px = 0.5 + 0.25 + 0.05 + share * texel_px;
                    worst_share = worst_share.max(error_px.abs() / bound_px);
                    assert!(
                        error_px.abs() <= bound_px,
                        "sigma {sigma} alpha {alpha} gaze {gaze:?} at {x}, {y}: off by {error_px} px, bound {bound_px}"
                    );
                    if share < 1.0 {
                        sum_px += error_px;
                        // Chords and the filter pull towards the gaze, each by the angle's square.
                        let angle = across_px / radius_px;
                        shrink_px += radius_px * angle * angle * if filtered { 0.375 } else { 0.125 };
                        count += 1.0;
                    }
                }
            }
            let (mean_px, shrink_px) = (sum_px / count, shrink_px / count);
            println!("sigma {sigma} alpha {alpha}: {worst_share:.2} of the bound, mean {mean_px:.3} px");
            assert!(count > 1000.0, "{count} pixels");
            assert!(mean_px.abs() < shrink_px + 0.1, "moved by {mean_px} px, not {shrink_px} at most");
        }
    }
}

#[test]
fn there_is_no_seam_to_the_right_of_the_gaze() {
    let gpu = gpu();
    let size = [240, 160];
    let display = settings(size, 90.0, Method::Full).display;
    let scene = ramp_scene(display.tan_right as f32, display.tan_up as f32);
    let content = upload(&gpu, &scene, None);
    for (sigma, alpha) in [(1.8, 4.0), (4.0, 1.0)] {
        let settings = settings(size, 90.0, kfr(sigma, alpha));
        let input = FrameInput { gaze_px: DVec2::new(120.0, 80.0), ..ahead(&settings) };
        let frame = render_content(&gpu, &content, &settings, &input);
        let channel = |x: u32, y: u32, of: usize| frame.at(x, y)[of];
        // Steps across the ray that leaves the gaze to the right, where v wraps, against those to the
        // left, where it does not. Green's true step down a row is 1/160, blue's is of that size.
        let (mut right, mut left) = (Vec::new(), Vec::new());
        for distance in 4..116 {
            for of in [1, 2] {
                let step = |x: u32| (channel(x, 80, of) - channel(x, 79, of)).abs();
                right.push(step(120 + distance));
                left.push(step(119 - distance));
            }
        }
        let most = |steps: &[f64]| steps.iter().copied().fold(0.0, f64::max);
        let mean = |steps: &[f64]| steps.iter().sum::<f64>() / steps.len() as f64;
        println!(
            "sigma {sigma}: mean {} and {}, most {} and {}",
            mean(&right),
            mean(&left),
            most(&right),
            most(&left)
        );
        assert!(
            most(&right) <= 1.5 * most(&left) + 1.0 / 256.0,
            "a seam: {} against {}",
            most(&right),
            most(&left)
        );
        assert!(
            mean(&right) <= 1.25 * mean(&left) + 1.0 / 512.0,
            "a seam: {} against {}",
            mean(&right),
            mean(&left)
        );
    }
}

#[test]
fn frames_depend_on_their_own_gaze_only() {
    let gpu = gpu();
    let scene = hall(10_000, 4);
    let content = upload(&gpu, &scene, None);
    let settings = settings([160, 90], 100.0, kfr_with(1.8, Kernel::Power { alpha: 4.0 }));
    let view = |x: f64, y: f64| FrameInput { world_from_view: camera_of(&scene), gaze_px: DVec2::new(x, y) };
    let (a, b) = (view(30.0, 20.0), view(120.0, 70.0));
    let alone = render_content(&gpu, &content, &settings, &b);
    let again = render_content(&gpu, &content, &settings, &b);
    assert!(alone.hdr == again.hdr && alone.rgba8 == again.rgba8, "another run, another picture");
    let mut renderer = OffscreenRenderer::new(&gpu, &content, &settings).unwrap();
    let first = next_frame(&mut renderer, &settings, &a);
    let lp_before = renderer.read_lp().unwrap().unwrap();
    for _ in 0..3 {
        let second = next_frame(&mut renderer, &settings, &b);
        assert!(second.hdr == alone.hdr && second.rgba8 == alone.rgba8, "gaze A shows in gaze B's frame");
        assert_eq!(second.stats.lp, alone.stats.lp);
    }
    let back = next_frame(&mut renderer, &settings, &a);
    assert!(back.hdr == first.hdr && renderer.read_lp().unwrap().unwrap() == lp_before);
    assert!(first.hdr != alone.hdr, "the gaze has no effect");
}

#[test]
fn the_picture_is_the_radiance_encoded() {
    let gpu = gpu();
    let scene = ramp_scene(1.0, 1.0);
    let mut settings = settings([64, 64], 90.0, Method::Full);
    settings.tone_map = ToneMap::None;
    let frame = macula_tests::render(&gpu, &scene, None, &settings, &ahead(&settings));
    for (linear, byte) in frame.hdr.iter().zip(&frame.rgba8) {
        // IEC 61966-2-1.
        let encoded = match f64::from(*linear) {
            v if v <= 0.003_130_8 => 12.92 * v,
            v => 1.055 * v.powf(1.0 / 2.4) - 0.055,
        };
        let expected = if (linear - 1.0).abs() < 1e-9 { 255.0 } else { 255.0 * encoded };
        assert!((f64::from(*byte) - expected).abs() <= 0.75, "{byte} for {linear}");
    }
}
