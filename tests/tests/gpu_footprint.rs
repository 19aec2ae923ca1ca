//! Shading over footprints larger than a pixel: highlights do not flicker more than in full shading, and
//! what needs no filter stays as it is.

use glam::{DMat4, DVec2, DVec3, Vec2, Vec3, Vec4};
use macula::fovea::{AcuityModel, Kernel, KfrMapping, Mapping, VafrForm, VafrMapping};
use macula::headless::{FrameInput, OffscreenRenderer};
use macula::quality::picture::Picture;
use macula::quality::temporal::{self, RingVariance, TemporalVariance};
use macula::scene::{Mesh, Sampler, Scene, Texture, TextureUse, Vertex};
use macula::settings::{KfrSettings, LpFilter, Method, RenderSettings, VafrSettings};
use macula_tests::scenes::{add, at, one, quad, sun, unlit, white};
use macula_tests::{Frame, Gpu, ahead, gpu, kfr, next_frame, render, settings, upload};
use std::sync::Arc;

const SIZE: [u32; 2] = [192, 112];
const HFOV_DEG: f64 = 60.0;

/// An acuity so low that a display of few pixels is foveated like one of many: samples of 1 px at 2
/// degrees from the gaze, of 3 px at 10.
fn low_acuity() -> AcuityModel {
    AcuityModel::vafr_2025().scaled(0.05).unwrap()
}

fn vafr() -> Method {
    Method::Vafr(VafrSettings { acuity: low_acuity(), ..VafrSettings::default() })
}

fn with_footprint(method: Method, footprint: bool) -> RenderSettings {
    RenderSettings { footprint, ..settings(SIZE, HFOV_DEG, method) }
}

fn vafr_mapping(settings: &RenderSettings, gaze_px: DVec2) -> VafrMapping {
    VafrMapping::new(VafrForm::Sphere, &settings.display, gaze_px, &Arc::new(low_acuity()))
}

/// A map of linear values with mip levels.
fn map(side: u32, texel: impl Fn(u32, u32) -> [u8; 4]) -> Texture {
    let texels = (0..side * side).flat_map(|at| texel(at % side, at / side));
    Texture {
        name: "map".into(),
        size: [side; 2],
        rgba8: texels.collect(),
        srgb: false,
        sampler: Sampler::default(),
    }
}

/// The use of the first texture, repeated so often over the surface.
fn repeated(times: f32) -> Option<TextureUse> {
    Some(TextureUse { texture: 0, uv_set: 0, uv_transform: [Vec3::X * times, Vec3::Y * times] })
}

/// A checkerboard of cells of one texel.
fn checker(x: u32, y: u32) -> [u8; 4] {
    let value = if (x + y).is_multiple_of(2) { 255 } else { 0 };
    [value, value, value, 255]
}

/// Normals that point to any direction within about 30 degrees, without a pattern.
fn rough_normals(x: u32, y: u32) -> [u8; 4] {
    let mut state = (x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b)).wrapping_add(0x27d4_eb2f);
    let mut next = || {
        state = (state ^ (state >> 15)).wrapping_mul(0x2c1b_3c6d);
        state = (state ^ (state >> 12)).wrapping_mul(0x297a_2d39);
        f64::from(state >> 8) / f64::from(1 << 24) - 0.5
    };
    let normal = DVec3::new(next(), next(), 0.866).normalize();
    let byte = |value: f64| (value * 127.5 + 127.5).round() as u8;
    [byte(normal.x), byte(normal.y), byte(normal.z), 255]
}

/// A wall ahead, 2 m away and larger than the view, with one map of 256 texels a side; `repeat` maps to
/// the wall.
fn wall(mut material: macula::scene::Material, texture: Texture, what: Map, repeat: f32) -> Scene {
    let place = match what {
        Map::BaseColor => &mut material.base_color_texture,
        Map::Normal => &mut material.normal_texture,
    };
    *place = repeated(repeat);
    let mut scene = one(quad(3.0, 3.0), at(0.0, 0.0, -2.0), material);
    scene.textures.push(texture);
    scene.lights.push(sun(3.0, DVec3::new(0.2, -0.3, -1.0)));
    scene
}

#[derive(Clone, Copy)]
enum Map {
    BaseColor,
    Normal,
}

/// A ball of radius 1 around its origin.
fn ball() -> Mesh {
    const RINGS: u32 = 12;
    const SEGMENTS: u32 = 24;
    let mut mesh = Mesh { name: "ball".into(), bounds: [Vec3::NEG_ONE, Vec3::ONE], ..Mesh::default() };
    for ring in 0..=RINGS {
        let (radius, height) = (std::f32::consts::PI * ring as f32 / RINGS as f32).sin_cos();
        for segment in 0..=SEGMENTS {
            let (sine, cosine) = (std::f32::consts::TAU * segment as f32 / SEGMENTS as f32).sin_cos();
            let normal = Vec3::new(radius * sine, height, radius * cosine);
            mesh.vertices.push(Vertex {
                position: normal,
                normal,
                tangent: [cosine, 0.0, -sine, 1.0],
                uv0: Vec2::ZERO,
                uv1: Vec2::ZERO,
                color: [255; 4],
                padding: 0,
            });
        }
    }
    for ring in 0..RINGS {
        for segment in 0..SEGMENTS {
            let a = ring * (SEGMENTS + 1) + segment;
            let b = a + SEGMENTS + 1;
            mesh.indices.extend([a, b, a + 1, a + 1, b, b + 1]);
        }
    }
    mesh
}

/// Polished balls, 16 px across, before a dark wall.
fn balls() -> Scene {
    let dark = macula::scene::Material { base_color: Vec4::new(0.02, 0.02, 0.02, 1.0), ..white(0.0, 0.9) };
    let mut scene = one(quad(3.0, 3.0), at(0.0, 0.0, -2.2), dark);
    let placed = |x: f64, y: f64| at(x, y, -2.0) * DMat4::from_scale(DVec3::splat(0.1));
    add(&mut scene, ball(), placed(0.0, 0.0), white(1.0, 0.3));
    let instance = scene.instances[1].clone();
    for index in 0..9 * 7 {
        let (column, row) = (f64::from(index % 9) - 4.0, f64::from(index / 9) - 3.0);
        let world_from_mesh = placed(0.27 * column, 0.23 * row);
        scene.instances.push(macula::scene::Instance { world_from_mesh, ..instance.clone() });
    }
    // Highlights a pixel or two wide, which the display need not clip: of a clipped one the display shows
    // the more the wider it is, in whatever way it was averaged.
    scene.lights.push(sun(0.15, DVec3::new(0.4, -0.5, -1.0)));
    scene
}

#[test]
fn maps_are_sampled_as_coarsely_as_the_mapping_is() {
    let gpu = gpu();
    let scene = wall(unlit(1.0, 1.0, 1.0), map(256, checker), Map::BaseColor, 1.0);
    let content = upload(&gpu, &scene, None);
    for (method, gaze) in [
        (vafr(), [96.0, 56.0]),
        (vafr(), [20.0, 90.0]),
        (kfr(2.5, 4.0), [96.0, 56.0]),
        (kfr(2.5, 2.0), [150.0, 30.0]),
    ] {
        let settings = with_footprint(method.clone(), true);
        let gaze_px = DVec2::from_array(gaze);
        let mut renderer = OffscreenRenderer::new(&gpu, &content, &settings).unwrap();
        renderer.render(&FrameInput { gaze_px, ..ahead(&settings) }).unwrap();
        let (width, height, levels) = renderer.read_footprint().unwrap().unwrap();
        assert_eq!([width, height], SIZE.map(|side| side.div_ceil(8)));
        // Texels per px^2 and native pixels, in double precision.
        let density = |px: DVec2| match &method {
            Method::Kfr(KfrSettings { sigma, kernel, .. }) => {
                let mapping = KfrMapping::new(SIZE, gaze_px, *kernel, *sigma);
                let radius_px = px.distance(gaze_px);
                (mapping.density_per_px2(radius_px), radius_px < 1.5 * mapping.native_radius_px() + 12.0)
            }
            _ => {
                let mapping = vafr_mapping(&settings, gaze_px);
                let jacobian = mapping.jacobian(px).unwrap();
                let determinant = jacobian.du_dx * jacobian.dv_dy - jacobian.du_dy * jacobian.dv_dx;
                (determinant.abs(), mapping.pixels_over_acuity(px) < 2.0 || px.distance(gaze_px) < 16.0)
            }
        };
        let (mut compared, mut worst) = (0, 0.0_f64);
        for (tile, found) in levels.iter().enumerate() {
            let corner = DVec2::new((tile as u32 % width) as f64 * 8.0, (tile as u32 / width) as f64 * 8.0);
            let (per_px2, near_native) = density(corner + 4.0);
            if !near_native {
                let expected = (-0.5 * per_px2.log2()).max(0.0);
                worst = worst.max((f64::from(*found) - expected).abs());
                compared += 1;
            }
        }
        println!("gaze {gaze:?}: {compared} tiles, {worst:.3} levels off at most");
        // Columns are steps of up to a tenth of their width where they are few.
        assert!(compared > 100 && worst < 0.1, "{worst} levels off");
        let greatest = levels.iter().copied().fold(0.0, f32::max);
        assert!(greatest > 1.0, "{greatest}: nothing is coarse");
    }
}

#[test]
fn a_minified_checkerboard_is_its_mean() {
    let gpu = gpu();
    // A texel of the map is about one pixel: 500 px to the wall.
    let scene = wall(unlit(1.0, 1.0, 1.0), map(256, checker), Map::BaseColor, 1.9);
    let deviation = |footprint: bool| {
        let settings = with_footprint(vafr(), footprint);
        let input = ahead(&settings);
        let frame = render(&gpu, &scene, None, &settings, &input);
        frame.check_whole("checker");
        let mapping = vafr_mapping(&settings, input.gaze_px);
        let (mut worst, mut squares, mut count) = (0.0_f64, 0.0, 0.0);
        for_each_pixel(|x, y, px| {
            // Samples of 4x4 px and more: cells of one pixel are gone from their mip levels.
            if mapping.pixels_over_acuity(px) > 16.0 {
                let off = frame.at(x, y)[0] - 0.5;
                worst = worst.max(off.abs());
                squares += off * off;
                count += 1.0;
            }
        });
        assert!(count > 1000.0, "{count} pixels");
        (worst, f64::sqrt(squares / count))
    };
    let ((worst, filtered), (_, point)) = (deviation(true), deviation(false));
    println!("off the mean by {worst:.3} at most, {filtered:.4} rms; without footprints {point:.3}");
    assert!(worst < 0.02 && point > 0.1);
}

fn for_each_pixel(mut visit: impl FnMut(u32, u32, DVec2)) {
    for y in 0..SIZE[1] {
        for x in 0..SIZE[0] {
            visit(x, y, DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        }
    }
}

#[test]
fn native_pixels_stay_those_of_full_shading() {
    let gpu = gpu();
    let scene = wall(white(1.0, 0.2), map(256, rough_normals), Map::Normal, 3.0);
    let full_settings = settings(SIZE, HFOV_DEG, Method::Full);
    for gaze in [[96.0, 56.0], [31.5, 77.25]] {
        let input = FrameInput { gaze_px: DVec2::from_array(gaze), ..ahead(&full_settings) };
        let full = render(&gpu, &scene, None, &full_settings, &input);
        let settings = with_footprint(vafr(), true);
        let frame = render(&gpu, &scene, None, &settings, &input);
        let mapping = vafr_mapping(&settings, input.gaze_px);
        let kfr_frame = render(&gpu, &scene, None, &with_footprint(kfr(1.8, 4.0), true), &input);
        let kfr = KfrMapping::new(SIZE, input.gaze_px, Kernel::Power { alpha: 4.0 }, 1.8);
        let (mut seen, mut seen_kfr) = (0, 0);
        for_each_pixel(|x, y, px| {
            // A rounding error's width inside the edge.
            if mapping.pixels_over_acuity(px) < 1.0 - 1e-4 {
                assert_eq!(frame.at(x, y), full.at(x, y), "vafr at {x}, {y}");
                seen += 1;
            }
            if px.distance(input.gaze_px) < kfr.native_radius_px() - kfr.blend_band_px() - 1e-3 {
                assert_eq!(kfr_frame.at(x, y), full.at(x, y), "kfr at {x}, {y}");
                seen_kfr += 1;
            }
        });
        assert!(seen > 15 && seen_kfr > 5, "{seen} and {seen_kfr} native pixels");
        assert!(frame.hdr != full.hdr);
    }
}

/// The greatest difference of two frames, relative to the brightest value.
fn difference(a: &Frame, b: &Frame) -> f32 {
    let most = b.hdr.iter().copied().fold(0.0, f32::max);
    a.hdr.iter().zip(&b.hdr).map(|(a, b)| (a - b).abs() / most).fold(0.0, f32::max)
}

#[test]
fn what_is_even_is_left_as_it_is() {
    let gpu = gpu();
    let flat = |_: u32, _: u32| [128, 128, 255, 255];
    let constant = |_: u32, _: u32| [200, 100, 50, 255];
    let mirror = wall(white(1.0, 0.0), map(256, flat), Map::Normal, 40.0);
    let coloured = wall(white(0.0, 0.5), map(256, constant), Map::BaseColor, 40.0);
    for (what, scene) in [("mirror", mirror), ("constant colour", coloured)] {
        for method in [vafr(), kfr(1.8, 4.0)] {
            let [with, without] = [true, false].map(|footprint| {
                let settings = with_footprint(method.clone(), footprint);
                let frame = render(&gpu, &scene, None, &settings, &ahead(&settings));
                frame.check_whole(what);
                frame
            });
            assert!(without.hdr.iter().any(|value| *value > 0.0), "{what} is black");
            // Means of equal numbers, and half floats.
            let off = difference(&with, &without);
            assert!(off < 2e-3, "{what}: changed by {off}");
        }
    }
}

#[test]
fn normals_that_cancel_make_no_hole() {
    let gpu = gpu();
    // Neighbours point in opposite directions: the mean has no direction.
    let opposite =
        |x: u32, y: u32| if (x + y).is_multiple_of(2) { [255, 128, 128, 255] } else { [0, 127, 127, 255] };
    for repeat in [1.0, 7.0, 300.0] {
        let scene = wall(white(1.0, 0.1), map(256, opposite), Map::Normal, repeat);
        for method in [vafr(), kfr(1.8, 4.0)] {
            let settings = with_footprint(method, true);
            render(&gpu, &scene, None, &settings, &ahead(&settings)).check_whole("opposite normals");
        }
    }
}

/// Change over time while the eye moves slowly past a scene, per ring.
fn rings(gpu: &Gpu, scene: &Scene, settings: &RenderSettings) -> Vec<RingVariance> {
    const FRAMES: u32 = 10;
    let content = upload(gpu, scene, None);
    let mut renderer = OffscreenRenderer::new(gpu, &content, settings).unwrap();
    let mut variance = TemporalVariance::new(SIZE).unwrap();
    let still = ahead(settings);
    for frame in 0..FRAMES {
        let step = f64::from(frame);
        let world_from_view = DMat4::from_translation(DVec3::X * 0.002 * step)
            * DMat4::from_rotation_y((0.05 * step).to_radians());
        let frame = next_frame(&mut renderer, settings, &FrameInput { world_from_view, ..still });
        frame.check_whole("flicker");
        variance.add(Picture::Srgb8(&frame.rgb8())).unwrap();
    }
    variance.rings(&settings.display, still.gaze_px).unwrap()
}

#[test]
fn highlights_do_not_flicker_more_than_in_full_shading() {
    let gpu = gpu();
    let bumpy = wall(white(1.0, 0.25), map(256, rough_normals), Map::Normal, 2.0);
    for (what, scene) in [("normal map", bumpy), ("balls", balls())] {
        let full = rings(&gpu, &scene, &settings(SIZE, HFOV_DEG, Method::Full));
        // Without the filter over the LP-buffer, which smooths edges by itself.
        let unfiltered =
            VafrSettings { acuity: low_acuity(), lp_filter: LpFilter::None, ..VafrSettings::default() };
        for (name, method) in [("vafr", Method::Vafr(unfiltered)), ("kfr", kfr(1.8, 4.0))] {
            let [with, without] = [true, false].map(|footprint| {
                let rings = rings(&gpu, &scene, &with_footprint(method.clone(), footprint));
                temporal::ratio(&rings, &full).unwrap()
            });
            for ((with, without), ring) in with.iter().zip(&without).zip(&full) {
                // In few pixels a single highlight decides; changes of a quarter of an 8-bit step are none.
                if ring.pixels < 300 || ring.variance.unwrap() < 1e-6 {
                    continue;
                }
                let (a, b) = (with.variance.unwrap(), without.variance.unwrap());
                println!(
                    "{what}, {name}, from {}: {a:.3} of full shading's variance {:.1e}, {b:.3} without",
                    with.from_deg,
                    ring.variance.unwrap()
                );
                assert!(a <= 1.1, "{what}, {name}, from {} degrees: {a}", with.from_deg);
                // Where samples are larger than pixels at all.
                if name == "vafr" && with.from_deg >= 5.0 {
                    assert!(a < b, "{what} from {} degrees: {a}, {b} without footprints", with.from_deg);
                }
            }
        }
    }
}

#[test]
fn rougher_is_not_darker() {
    let gpu = gpu();
    let scene = wall(white(1.0, 0.25), map(256, rough_normals), Map::Normal, 2.0);
    let mean = |settings: &RenderSettings| {
        let input = ahead(settings);
        let frame = render(&gpu, &scene, None, settings, &input);
        let (mut sum, mut count) = (0.0, 0.0);
        for_each_pixel(|x, y, px| {
            if px.distance(input.gaze_px) > 24.0 {
                sum += frame.at(x, y)[1];
                count += 1.0;
            }
        });
        sum / count
    };
    let full = mean(&settings(SIZE, HFOV_DEG, Method::Full));
    let ratio = mean(&with_footprint(vafr(), true)) / full;
    println!("mean radiance {ratio:.3} of full shading's");
    // A normal distribution stands for one that ends at 30 degrees; a mirror-like mean normal would leave
    // almost nothing.
    assert!((0.7..1.4).contains(&ratio), "{ratio}");
}

#[test]
fn the_plan_leaves_footprints_out_where_they_change_nothing() {
    let gpu = gpu();
    let names = ["footprints of maps", "footprints of surfaces"];
    let plain = one(quad(3.0, 3.0), at(0.0, 0.0, -2.0), unlit(0.5, 0.5, 0.5));
    let lit = one(quad(3.0, 3.0), at(0.0, 0.0, -2.0), white(0.0, 0.5));
    let mut mapped = wall(unlit(1.0, 1.0, 1.0), map(16, checker), Map::BaseColor, 1.0);
    mapped.materials[0].base_color = Vec4::ONE;
    for (scene, expected) in [(&plain, [false, false]), (&lit, [false, true]), (&mapped, [true, true])] {
        for footprint in [true, false] {
            let settings = with_footprint(vafr(), footprint);
            let frame = render(&gpu, scene, None, &settings, &ahead(&settings));
            let runs = names.map(|name| frame.effects.run.iter().any(|note| note.name == name));
            let left_out = names.map(|name| frame.effects.skipped.iter().any(|note| note.name == name));
            assert_eq!(runs, expected.map(|on| on && footprint));
            assert_eq!(left_out, runs.map(|on| !on));
            assert_eq!(frame.passes().contains(&"footprint"), runs[0]);
        }
    }
}
