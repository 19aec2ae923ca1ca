//! Shading against closed forms: the specification's formulas in double precision, evaluated at the
//! points that the pixels see.

use glam::{DMat4, DVec3, Vec2, Vec3};
use macula::scene::environment::Environment;
use macula::scene::{AlphaMode, Light, LightKind, Material, Scene};
use macula::settings::{Method, RenderSettings};
use macula_tests::brdf::{self, Surface};
use macula_tests::scenes::{add, at, coloured_quad, light, one, point_of_pixel, quad, sun, unlit, white};
use macula_tests::{Frame, ahead, gpu, kfr, render, settings};

const SIZE: [u32; 2] = [64, 48];
const WALL_M: f64 = 2.0;

fn full() -> RenderSettings {
    settings(SIZE, 60.0, Method::Full)
}

fn frame_of(scene: &Scene) -> Frame {
    let settings = full();
    let frame = render(&gpu(), scene, None, &settings, &ahead(&settings));
    frame.check_whole(&scene.name);
    frame
}

/// A wall that fills the view, facing the eye.
fn wall(material: Material) -> Scene {
    one(quad(3.0, 3.0), at(0.0, 0.0, -WALL_M), material)
}

/// A grid of pixels over the display.
fn pixels() -> impl Iterator<Item = (u32, u32)> {
    (2..SIZE[1]).step_by(5).flat_map(|y| (2..SIZE[0]).step_by(5).map(move |x| (x, y)))
}

/// Relative difference of the greatest channel.
#[track_caller]
fn close(found: [f64; 3], expected: DVec3, relative: f64, what: &str) {
    let off = (DVec3::from_array(found) - expected).abs().max_element();
    // Half floats have 11 bits; below 1e-4 their steps and the G-buffer's count.
    let allowed = relative * expected.max_element() + 2e-5;
    assert!(off <= allowed, "{what}: {found:?}, not {expected}, off by {off}");
}

/// Checks each pixel of a wall against the closed form, under lights whose illuminance and direction at
/// a point `lux` gives.
fn check_wall(frame: &Frame, surface: &Surface, relative: f64, lux: impl Fn(DVec3) -> (DVec3, f64)) {
    let display = full().display;
    for (x, y) in pixels() {
        let point = point_of_pixel(&display, x, y, WALL_M);
        let (to_light, lux) = lux(point);
        let expected = brdf::radiance(surface, DVec3::Z, to_light, -point.normalize(), lux);
        close(frame.at(x, y), expected, relative, &format!("{surface:?} at {x}, {y}"));
    }
}

#[test]
fn sunlight_is_reflected_as_appendix_b_says() {
    // Base colours whose square roots, and roughnesses, that 8 bits hold exactly.
    let red = DVec3::new(1.0, (0.4_f64).powi(2), (0.2_f64).powi(2));
    let directions = [DVec3::new(0.0, 0.0, -1.0), DVec3::new(0.5, -0.3, -1.0), DVec3::new(-3.0, 0.5, -1.0)];
    for (metallic, roughness, base, direction) in [
        (0.0, 1.0, DVec3::ONE, directions[0]),
        (0.0, 1.0, red, directions[1]),
        (1.0, 1.0, red, directions[1]),
        (0.0, 0.4, red, directions[0]),
        (1.0, 0.6, red, directions[0]),
        (0.6, 0.8, red, directions[1]),
        (0.0, 0.8, DVec3::ONE, directions[2]),
    ] {
        let material =
            Material { base_color: base.as_vec3().extend(1.0), ..white(metallic as f32, roughness as f32) };
        let mut scene = wall(material);
        scene.lights.push(sun(7.5, direction));
        let frame = frame_of(&scene);
        let surface = Surface { base, metallic, roughness };
        check_wall(&frame, &surface, 0.01, |_| (-direction.normalize(), 7.5));
    }
}

#[test]
fn extreme_roughness_and_metal_stay_finite_and_bounded() {
    for (metallic, roughness) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.02)] {
        let mut scene = wall(white(metallic, roughness));
        scene.lights.push(sun(10.0, DVec3::NEG_Z));
        scene.lights.push(light(
            1e6,
            DVec3::new(0.1, 0.1, -1.0),
            DVec3::NEG_Z,
            LightKind::Point { range: f32::INFINITY },
        ));
        // On the surface itself.
        scene.lights.push(light(
            5.0,
            DVec3::new(0.4, 0.2, -WALL_M),
            DVec3::NEG_Z,
            LightKind::Point { range: f32::INFINITY },
        ));
        let frame = frame_of(&scene);
        assert!(frame.hdr.iter().all(|value| (0.0..=65504.0).contains(value)), "{metallic} {roughness}");
    }
}

#[test]
fn point_light_falls_off_with_the_square_and_ends_at_its_range() {
    let surface = Surface { base: DVec3::ONE, metallic: 0.0, roughness: 0.8 };
    for (candela, position, range) in [
        (4.0, DVec3::new(0.3, 0.2, -1.2), f64::INFINITY),
        (40.0, DVec3::new(-0.8, 0.1, -0.4), f64::INFINITY),
        (4.0, DVec3::new(0.0, 0.0, -1.4), 1.2),
    ] {
        let mut scene = wall(white(0.0, 0.8));
        scene.lights.push(light(
            candela as f32,
            position,
            DVec3::NEG_Z,
            LightKind::Point { range: range as f32 },
        ));
        let frame = frame_of(&scene);
        check_wall(&frame, &surface, 0.012, |point| {
            let offset = position - point;
            (offset.normalize(), brdf::lux_at(candela, offset.length(), range))
        });
        if range < 2.0 {
            assert_eq!(frame.at(0, 0), [0.0; 3], "light beyond its range");
        }
    }
}

#[test]
fn spot_light_has_its_cone() {
    let surface = Surface { base: DVec3::ONE, metallic: 0.0, roughness: 1.0 };
    let (inner, outer) = (0.2_f64, 0.45_f64);
    let (position, direction) = (DVec3::new(0.2, 0.0, 0.0), DVec3::new(-0.2, 0.1, -1.0).normalize());
    let mut scene = wall(white(0.0, 1.0));
    let kind = LightKind::Spot { range: f32::INFINITY, inner_angle: inner as f32, outer_angle: outer as f32 };
    scene.lights.push(light(20.0, position, direction, kind));
    let frame = frame_of(&scene);
    let (mut dark, mut half, mut bright) = (0, 0, 0);
    let display = full().display;
    for (x, y) in pixels() {
        let point = point_of_pixel(&display, x, y, WALL_M);
        let offset = position - point;
        let angle = direction.angle_between(-offset);
        let share = brdf::cone(angle, inner, outer);
        let lux = brdf::lux_at(20.0, offset.length(), f64::INFINITY) * share;
        let expected = brdf::radiance(&surface, DVec3::Z, offset.normalize(), -point.normalize(), lux);
        // The shadow map cuts the light off around its cone only.
        close(frame.at(x, y), expected, 0.012, &format!("spot at {x}, {y}"));
        *(if share == 0.0 {
            &mut dark
        } else if share < 1.0 {
            &mut half
        } else {
            &mut bright
        }) += 1;
    }
    assert!(dark > 5 && half > 5 && bright > 5, "{dark} {half} {bright}");
}

#[test]
fn emission_and_unlit_surfaces_are_shown_as_they_are() {
    // Emissive strength is multiplied into the emission when a file is loaded.
    let glowing = Material { emissive: Vec3::new(12.0, 3.0, 0.75), ..white(0.0, 1.0) };
    let frame = frame_of(&wall(glowing));
    for (x, y) in pixels() {
        close(frame.at(x, y), DVec3::new(12.0, 3.0, 0.75), 1e-9, "emission");
    }
    let mut scene = wall(unlit(0.25, 0.5, 0.125));
    scene.lights.push(sun(100.0, DVec3::NEG_Z));
    let frame = frame_of(&scene);
    for (x, y) in pixels() {
        close(frame.at(x, y), DVec3::new(0.25, 0.5, 0.125), 1e-9, "unlit under light");
    }
}

/// A file with `KHR_materials_emissive_strength` and vertex colours, loaded as any other.
#[test]
fn emissive_strength_of_a_file_multiplies() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("strength.gltf");
    let floats: [f32; 12] = [-3.0, -3.0, -2.0, 3.0, -3.0, -2.0, 3.0, 3.0, -2.0, -3.0, 3.0, -2.0];
    let mut bytes: Vec<u8> = floats.iter().flat_map(|value| value.to_le_bytes()).collect();
    bytes.extend([0_u16, 1, 2, 0, 2, 3].iter().flat_map(|index| index.to_le_bytes()));
    std::fs::write(folder.path().join("strength.bin"), &bytes).unwrap();
    let document = serde_json::json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_materials_emissive_strength"],
        "buffers": [{ "uri": "strength.bin", "byteLength": bytes.len() }],
        "bufferViews": [
            { "buffer": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 12 },
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
              "min": [-3, -3, -2], "max": [3, 3, -2] },
            { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" },
        ],
        "materials": [{
            "emissiveFactor": [1.0, 0.5, 0.25],
            "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 8.0 } },
        }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "material": 0 }] }],
        "nodes": [{ "mesh": 0 }],
        "scenes": [{ "nodes": [0] }],
        "scene": 0,
    });
    std::fs::write(&path, document.to_string()).unwrap();
    let scene = macula::scene::load::load(&path, &macula::scene::load::LoadOptions::default()).unwrap();
    close(frame_of(&scene).at(30, 20), DVec3::new(8.0, 4.0, 2.0), 1e-9, "emissive strength");
}

/// An environment that shines evenly.
fn even(radiance: [f32; 3]) -> Environment {
    let [r, g, b] = radiance;
    Environment::from_pixels("even", [32, 16], vec![[r, g, b, 1.0]; 32 * 16]).unwrap()
}

#[test]
fn even_surroundings_light_a_white_surface_evenly() {
    let environment = even([2.0, 1.0, 0.5]);
    let settings = full();
    for roughness in [1.0, 0.6, 0.2] {
        let scene = one(quad(0.5, 0.5), at(0.0, 0.0, -WALL_M), white(0.0, roughness));
        let frame = render(&gpu(), &scene, Some(&environment), &settings, &ahead(&settings));
        frame.check_whole("furnace");
        // A white dielectric gives back all but a few per cent, a matter of the split sum.
        close(
            frame.at(32, 24),
            DVec3::new(2.0, 1.0, 0.5),
            0.03,
            &format!("surface of roughness {roughness}"),
        );
        close(frame.at(1, 1), DVec3::new(2.0, 1.0, 0.5), 1e-3, "sky");
    }
    // A smooth metal mirrors.
    let scene = one(quad(0.5, 0.5), at(0.0, 0.0, -WALL_M), white(1.0, 0.0));
    let frame = render(&gpu(), &scene, Some(&environment), &settings, &ahead(&settings));
    close(frame.at(32, 24), DVec3::new(2.0, 1.0, 0.5), 0.02, "mirror");
}

/// Bilinear in the picture, repeating along u and clamping along v.
fn sample(environment: &Environment, direction: DVec3) -> DVec3 {
    let u = 0.5 + direction.x.atan2(-direction.z) / std::f64::consts::TAU;
    let v = direction.y.acos() / std::f64::consts::PI;
    let [width, height] = environment.size.map(|side| side as i64);
    let (x, y) = (u * width as f64 - 0.5, v * height as f64 - 0.5);
    let (fx, fy) = (x - x.floor(), y - y.floor());
    let texel = |dx: i64, dy: i64| {
        let x = (x.floor() as i64 + dx).rem_euclid(width);
        let y = (y.floor() as i64 + dy).clamp(0, height - 1);
        let [r, g, b, _] = environment.pixels[(y * width + x) as usize];
        DVec3::new(f64::from(r), f64::from(g), f64::from(b))
    };
    texel(0, 0).lerp(texel(1, 0), fx).lerp(texel(0, 1).lerp(texel(1, 1), fx), fy)
}

#[test]
fn the_sky_is_the_environment_in_every_direction() {
    let (width, height) = (64_u32, 32_u32);
    let waves = (0..width * height).map(|index| {
        let (x, y) = ((index % width) as f32 / width as f32, (index / width) as f32 / height as f32);
        [1.0 + (x * std::f32::consts::TAU).sin(), 4.0 * y, 0.5 + 0.4 * (x * std::f32::consts::TAU).cos(), 1.0]
    });
    let environment = Environment::from_pixels("waves", [width, height], waves.collect()).unwrap();
    let settings = full();
    let gpu = gpu();
    for (yaw, pitch) in [(0.0, 0.0), (1.4, 0.3), (std::f64::consts::PI, -0.4), (-1.8, 1.1)] {
        let turn = DMat4::from_rotation_y(yaw) * DMat4::from_rotation_x(pitch);
        let mut input = ahead(&settings);
        input.world_from_view = turn;
        let frame = render(&gpu, &Scene::default(), Some(&environment), &settings, &input);
        frame.check_whole("sky");
        for (x, y) in pixels() {
            let ray = point_of_pixel(&settings.display, x, y, 1.0);
            let expected = sample(&environment, turn.transform_vector3(ray).normalize());
            // The sampler's weights have 8 bits.
            close(frame.at(x, y), expected, 0.01, &format!("sky at {x}, {y}, yaw {yaw}"));
        }
    }
}

#[test]
fn alpha_is_masked_at_its_cutoff() {
    for (alpha, cutoff, seen) in [(0.3, 0.5, false), (0.3, 0.2, true), (0.5, 0.5, true), (0.0, 0.0, true)] {
        let mut front = unlit(1.0, 0.0, 0.0);
        front.base_color.w = alpha;
        front.alpha_mode = AlphaMode::Mask { cutoff };
        let mut scene = wall(unlit(0.0, 1.0, 0.0));
        add(&mut scene, quad(0.5, 0.5), at(0.0, 0.0, -1.0), front);
        let frame = frame_of(&scene);
        let expected = if seen { DVec3::X } else { DVec3::Y };
        close(frame.at(32, 24), expected, 1e-9, &format!("alpha {alpha}, cutoff {cutoff}"));
        close(frame.at(1, 1), DVec3::Y, 1e-9, "behind");
    }
}

#[test]
fn blended_surfaces_lie_over_what_is_behind_them() {
    let blended = |red: f32, green: f32, blue: f32, alpha: f32| {
        let mut material = unlit(red, green, blue);
        material.base_color.w = alpha;
        Material { alpha_mode: AlphaMode::Blend, ..material }
    };
    // Given nearest first: the renderer sorts. A third one behind the wall must not show.
    let mut scene = one(quad(0.4, 0.4), at(0.0, 0.0, -1.0), blended(1.0, 0.0, 0.0, 0.25));
    add(&mut scene, quad(3.0, 3.0), at(0.0, 0.0, -1.5), blended(0.0, 1.0, 0.0, 0.5));
    add(&mut scene, quad(3.0, 3.0), at(0.0, 0.0, -WALL_M), unlit(0.0, 0.25, 1.0));
    add(&mut scene, quad(3.0, 3.0), at(0.0, 0.0, -3.0), blended(1.0, 1.0, 1.0, 0.5));
    let over = |back: DVec3, front: DVec3, alpha: f64| back.lerp(front, alpha);
    let one_over = over(DVec3::new(0.0, 0.25, 1.0), DVec3::Y, 0.5);
    let both_over = over(one_over, DVec3::X, 0.25);
    for method in [Method::Full, kfr(1.8, 4.0)] {
        let settings = settings(SIZE, 60.0, method);
        let frame = render(&gpu(), &scene, None, &settings, &ahead(&settings));
        frame.check_whole("blend");
        close(frame.at(32, 24), both_over, 2e-3, "two over the wall");
        close(frame.at(1, 1), one_over, 2e-3, "one over the wall");
        assert!(frame.passes().contains(&"forward"));
    }
}

/// Radiance of a wall with a transform, lit from the eye.
fn seen(world_from_mesh: DMat4, double_sided: bool) -> [f64; 3] {
    let material = Material { double_sided, ..white(0.0, 1.0) };
    let mut scene = one(quad(3.0, 3.0), world_from_mesh, material);
    scene.lights.push(sun(5.0, DVec3::NEG_Z));
    // Without shadows: which sides throw them is another question.
    let settings = RenderSettings { shadowed_lights: 0, ..full() };
    let frame = render(&gpu(), &scene, None, &settings, &ahead(&settings));
    frame.check_whole("sides");
    frame.at(32, 24)
}

#[test]
fn sides_and_mirrored_transforms() {
    let surface = Surface { base: DVec3::ONE, metallic: 0.0, roughness: 1.0 };
    let point = point_of_pixel(&full().display, 32, 24, WALL_M);
    let lit = brdf::radiance(&surface, DVec3::Z, DVec3::Z, -point.normalize(), 5.0);
    let place = at(0.0, 0.0, -WALL_M);
    let turned = place * DMat4::from_rotation_y(std::f64::consts::PI);
    close(seen(place, false), lit, 0.01, "front");
    close(seen(turned, false), DVec3::ZERO, 0.01, "back of a one-sided surface");
    close(seen(turned, true), lit, 0.01, "back of a double-sided surface");
    // A negative determinant turns the winding: the front stays the front.
    let scale = |x: f64, y: f64, z: f64| DMat4::from_scale(DVec3::new(x, y, z));
    close(seen(place * scale(-1.0, 1.0, 1.0), false), lit, 0.01, "mirrored in x");
    close(seen(place * scale(1.0, -2.0, 1.0), false), lit, 0.01, "mirrored in y");
    close(seen(place * scale(-1.0, -1.0, 1.0), false), lit, 0.01, "mirrored twice");
    close(seen(turned * scale(1.0, 1.0, -1.0), false), lit, 0.01, "turned and mirrored in z");
    close(seen(place * scale(1.0, 1.0, -1.0), false), DVec3::ZERO, 0.01, "mirrored away");
    close(seen(place * scale(1.0, 1.0, -1.0), true), lit, 0.01, "mirrored away, double-sided");
    // A slanted surface under a non-uniform scale: its normal follows the inverse transpose.
    let slanted = DMat4::from_scale(DVec3::new(1.0, 1.0, 0.25)) * DMat4::from_rotation_y(0.9);
    let normal = DMat4::from_scale(DVec3::new(1.0, 1.0, 4.0)).transform_vector3(DVec3::new(
        0.9_f64.sin(),
        0.0,
        0.9_f64.cos(),
    ));
    let ray = point_of_pixel(&full().display, 32, 24, 1.0).normalize();
    let expected = brdf::radiance(&surface, normal.normalize(), DVec3::Z, -ray, 5.0);
    close(seen(place * slanted, false), expected, 0.01, "non-uniform scale");
}

#[test]
fn vertex_colours_multiply() {
    let colors = [[255, 51, 102, 255]; 4];
    let scene = one(coloured_quad(Vec2::splat(3.0), colors), at(0.0, 0.0, -WALL_M), unlit(1.0, 0.5, 1.0));
    // The G-buffer's emission has 9 bits below the greatest channel.
    close(frame_of(&scene).at(20, 20), DVec3::new(1.0, 0.1, 0.4), 1.0 / 512.0, "vertex colours");
}

/// Whether the segment from a point on the wall to the light meets a rectangle at `z` around `centre`,
/// for rectangles a little smaller and a little larger.
fn blocked(point: DVec3, to_light: DVec3, centre: DVec3, half: f64, margin: f64) -> Option<bool> {
    let share = (centre.z - point.z) / to_light.z;
    let hit = point + to_light * share;
    let off = (hit - centre).truncate().abs().max_element();
    if off < half - margin {
        Some(true)
    } else if off > half + margin {
        Some(false)
    } else {
        None
    }
}

fn check_shadow(lamp: Light, towards: impl Fn(DVec3) -> (DVec3, f64)) {
    let surface = Surface { base: DVec3::ONE, metallic: 0.0, roughness: 1.0 };
    let (centre, half) = (DVec3::new(-0.35, 0.3, -1.4), 0.15);
    let mut scene = wall(white(0.0, 1.0));
    add(&mut scene, quad(half as f32, half as f32), DMat4::from_translation(centre), white(0.0, 1.0));
    let name = format!("{:?}", lamp.kind);
    scene.lights.push(lamp);
    let settings = settings([128, 96], 60.0, Method::Full);
    let frame = render(&gpu(), &scene, None, &settings, &ahead(&settings));
    frame.check_whole("shadow");
    assert!(frame.passes().contains(&"shadow"));
    let (mut dark, mut bright) = (0, 0);
    for y in 0..96 {
        for x in 0..128 {
            let point = point_of_pixel(&settings.display, x, y, WALL_M);
            // Where the eye sees the wall beside the rectangle.
            if blocked(point, -point, centre, half, 0.02) != Some(false) {
                continue;
            }
            let (to_light, lux) = towards(point);
            // 20 mm: some texels of the shadow map.
            let expected = match blocked(point, to_light, centre, half, 0.02) {
                Some(true) => DVec3::ZERO,
                Some(false) => {
                    brdf::radiance(&surface, DVec3::Z, to_light.normalize(), -point.normalize(), lux)
                }
                None => continue,
            };
            close(frame.at(x, y), expected, 0.012, &format!("{name} at {x}, {y} ({point})"));
            *(if expected == DVec3::ZERO { &mut dark } else { &mut bright }) += 1;
        }
    }
    println!("{name}: {dark} pixels in the shadow, {bright} in the light");
    assert!(dark > 50 && bright > 1000);
}

#[test]
fn the_sun_throws_a_shadow() {
    let direction = DVec3::new(0.9, -0.4, -1.0);
    check_shadow(sun(6.0, direction), |_| (-direction.normalize(), 6.0));
}

#[test]
fn a_point_light_throws_a_shadow() {
    let position = DVec3::new(-1.3, 0.9, -0.6);
    let lamp = light(12.0, position, DVec3::NEG_Z, LightKind::Point { range: f32::INFINITY });
    check_shadow(lamp, |point| {
        (position - point, brdf::lux_at(12.0, position.distance(point), f64::INFINITY))
    });
}

#[test]
fn a_spot_light_throws_a_shadow() {
    let (position, direction) = (DVec3::new(-1.0, 0.8, -0.4), DVec3::new(0.8, -0.6, -1.6).normalize());
    let (inner, outer) = (0.5_f64, 0.7_f64);
    let kind = LightKind::Spot { range: f32::INFINITY, inner_angle: inner as f32, outer_angle: outer as f32 };
    check_shadow(light(12.0, position, direction, kind), |point| {
        let share = brdf::cone(direction.angle_between(point - position), inner, outer);
        (position - point, brdf::lux_at(12.0, position.distance(point), f64::INFINITY) * share)
    });
}

#[test]
fn lights_add_up_to_hundreds() {
    // A hundred equal suns are one sun of a hundred times the light.
    let mut many = wall(white(0.0, 0.6));
    for _ in 0..100 {
        many.lights.push(sun(0.1, DVec3::new(0.2, 0.1, -1.0)));
    }
    let settings = RenderSettings { shadowed_lights: 0, ..full() };
    let frame = render(&gpu(), &many, None, &settings, &ahead(&settings));
    let surface = Surface { base: DVec3::ONE, metallic: 0.0, roughness: 0.6 };
    check_wall(&frame, &surface, 0.01, |_| (-DVec3::new(0.2, 0.1, -1.0).normalize(), 10.0));
}
