//! Scenes with one extreme each.

use super::scenes::{
    add, at, lamp, light, mesh, one, pattern, quad, sun, texture, unlit, vertex, white, with,
};
use glam::{DMat4, DVec3, Vec2, Vec3};
use macula::Result;
use macula::fovea::DisplayGeometry;
use macula::scene::environment::Environment;
use macula::scene::{AlphaMode, LightKind, Material, Scene};

/// What is rendered, and from where.
pub struct View {
    pub scene: Scene,
    pub environment: Option<Environment>,
    pub world_from_view: DMat4,
}

impl From<Scene> for View {
    fn from(scene: Scene) -> Self {
        Self { scene, environment: None, world_from_view: DMat4::IDENTITY }
    }
}

type Build = fn(&DisplayGeometry) -> Result<View>;

/// All of them, with their names in ids.
pub const SCENES: [(&str, Build); 17] = [
    ("empty", |_| Ok(Scene::default().into())),
    ("depth-1e-3-to-1e5m", |_| Ok(depths().into())),
    ("origin-1e6m-away", |display| Ok(far_from_origin(display))),
    ("normals-of-length-0", |_| Ok(lit(with(wall(), |vertex| vertex.normal = Vec3::ZERO)).into())),
    ("normals-cancelling", |_| {
        Ok(lit(with(wall(), |vertex| vertex.normal *= vertex.position.x.signum())).into())
    }),
    ("grazing", |_| Ok(grazing().into())),
    ("mirrored-uv", |_| Ok(bumpy(with(wall(), |vertex| vertex.uv0.x = -vertex.uv0.x)).into())),
    ("tangents-of-length-0", |_| Ok(bumpy(with(wall(), |vertex| vertex.tangent = [0.0; 4])).into())),
    ("scales", |_| Ok(scales().into())),
    ("materials", |_| Ok(materials().into())),
    ("lights-on-surfaces", |_| Ok(lights_on_surfaces().into())),
    ("radiance-1e6", |_| Ok(bright(1e6).into())),
    ("radiance-3e38", |_| Ok(bright(f32::MAX).into())),
    ("sky-1e6", |_| bright_sky()),
    ("degenerate-triangles", |_| Ok(degenerate().into())),
    ("slivers", |_| Ok(slivers().into())),
    ("huge-triangles", |_| Ok(huge().into())),
];

fn wall() -> macula::scene::Mesh {
    quad(2.0, 2.0)
}

/// Distance of the wall, m.
const WALL_M: f64 = 1.5;

fn lit(surface: macula::scene::Mesh) -> Scene {
    let mut scene = one(surface, at(0.0, 0.0, -WALL_M), white(0.3, 0.4));
    scene.lights.push(sun(3.0));
    scene.lights.push(lamp(2.0, DVec3::new(0.3, 0.2, -1.0)));
    scene
}

/// Coloured panels from 1 mm to 100 km, each with another close behind it.
pub fn depths() -> Scene {
    let mut scene = Scene::default();
    for (index, distance_m) in DEPTHS_M.into_iter().enumerate() {
        for (behind, colour) in [(1.0, FRONT_COLOURS[index]), (1.0 + DEPTH_GAP, BEHIND)] {
            let z = distance_m * behind;
            // Panels side by side, a quarter of the view's tangent each.
            let half = (0.25 * z) as f32;
            let place = at((0.5 * index as f64 - 0.75) * z, 0.0, -z);
            let [red, green, blue] = colour;
            add(&mut scene, quad(half, 4.0 * half), place, unlit(red, green, blue));
        }
    }
    scene
}

/// Distances of the panels, from left to right, m.
pub const DEPTHS_M: [f64; 4] = [1e-3, 1.0, 1e3, 1e5];

/// How much farther the hidden panels are. Reversed depth in single precision resolves 1e-7.
const DEPTH_GAP: f64 = 1e-4;

/// Colours of the panels, which the G-buffer holds exactly.
pub const FRONT_COLOURS: [[f32; 3]; 4] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0]];

const BEHIND: [f32; 3] = [1.0, 1.0, 1.0];

/// The fine pattern, moved with the eye.
fn far_from_origin(display: &DisplayGeometry) -> View {
    moved(pattern(display), DVec3::new(1e6 + 0.1, -3e5, 2e6 - 0.7))
}

/// A scene and its eye, moved.
pub fn moved(mut scene: Scene, by: DVec3) -> View {
    let translation = DMat4::from_translation(by);
    for instance in &mut scene.instances {
        instance.world_from_mesh = translation * instance.world_from_mesh;
    }
    for light in &mut scene.lights {
        light.position += by;
    }
    View { scene, environment: None, world_from_view: translation }
}

/// Floors that the view almost and exactly touches.
fn grazing() -> Scene {
    let mut scene = lit(wall());
    for (index, angle_deg) in [85.0, 89.99, 89.999_999, 90.0, 90.000_001].into_iter().enumerate() {
        let tilt = DMat4::from_rotation_x(-f64::to_radians(angle_deg));
        let place = at(0.4 * (index as f64 - 2.0), -0.05, -1.0) * tilt;
        let material = Material { double_sided: true, ..white(1.0, 0.05) };
        add(&mut scene, quad(0.18, 1.0), place, material);
    }
    scene
}

/// A wall with a normal map of steep bumps.
pub fn bumpy(surface: macula::scene::Mesh) -> Scene {
    let mut scene = lit(surface);
    let steep = |x: u32, y: u32| if (x + y).is_multiple_of(2) { [250, 128, 150] } else { [128, 5, 150] };
    scene.materials[0].normal_texture = Some(texture(&mut scene, [16, 16], false, steep));
    scene
}

/// One panel under non-uniform, tiny, large, negative and nearly singular scales.
fn scales() -> Scene {
    let mut scene = Scene::default();
    let scales = [
        DVec3::new(1e-3, 1e3, 1.0),
        DVec3::new(1e6, 1e6, 1e-9),
        DVec3::new(-1.0, 1.0, 1.0),
        DVec3::new(-1.0, -1.0, -1.0),
        DVec3::new(1.0, -5.0, 1e-12),
    ];
    for (index, scale) in scales.into_iter().enumerate() {
        let place = at(0.5 * (index as f64 - 2.0), 0.0, -2.0);
        // The panel stays a fifth of a metre wide in the world.
        let surface = quad((0.2 / scale.x.abs()) as f32, (0.2 / scale.y.abs()) as f32);
        let material = Material { double_sided: true, ..white(0.5, 0.3) };
        add(&mut scene, surface, place * DMat4::from_rotation_y(0.4) * DMat4::from_scale(scale), material);
    }
    scene.lights.push(sun(2.0));
    scene
}

/// The corners of the material's square, and what lies outside it.
fn materials() -> Scene {
    let mut scene = Scene::default();
    for (column, roughness) in [0.0, 1e-6, 0.5, 1.0, 2.0].into_iter().enumerate() {
        for (row, metallic) in [0.0, 0.5, 1.0, -1.0].into_iter().enumerate() {
            let place = at(0.4 * (column as f64 - 2.0), 0.4 * (row as f64 - 1.5), -1.5);
            add(&mut scene, quad(0.18, 0.18), place, white(metallic, roughness));
        }
    }
    // Straight back to the eye: the peak of every highlight.
    scene.lights.push(lamp(5.0, DVec3::ZERO));
    scene.lights.push(sun(5.0));
    scene
}

/// Lamps in, on and next to a wall, and in the eye.
fn lights_on_surfaces() -> Scene {
    let mut scene = lit(wall());
    for (index, gap_m) in [0.0, 1e-30, 1e-6, 1e-4, -1e-3].into_iter().enumerate() {
        let position = DVec3::new(0.4 * (index as f64 - 2.0), 0.1, -WALL_M + gap_m);
        scene.lights.push(lamp(10.0, position));
        let kind = LightKind::Spot { range: 1e-3, inner_angle: 0.0, outer_angle: 1e-3 };
        scene.lights.push(light(1e6, position, kind));
    }
    scene.lights.push(lamp(1.0, DVec3::ZERO));
    scene
}

/// Lamps, glow and blended glow of a strength.
fn bright(strength: f32) -> Scene {
    let mut scene = lit(wall());
    let glow = |roughness: f32| Material { emissive: Vec3::splat(strength), ..white(1.0, roughness) };
    add(&mut scene, quad(0.2, 0.2), at(-0.4, 0.0, -1.0), glow(0.0));
    let blended = Material { alpha_mode: AlphaMode::Blend, ..glow(0.5) };
    add(&mut scene, quad(0.2, 0.2), at(0.4, 0.0, -1.0), blended);
    scene.lights.push(sun(strength));
    scene.lights.push(lamp(strength, DVec3::new(0.0, 0.5, -1.2)));
    scene
}

fn bright_sky() -> Result<View> {
    let size = [16, 8];
    let texel = |index: u32| if index % 16 == 5 { 1e6 } else { 1e-6 };
    let pixels = (0..size[0] * size[1]).map(|index| {
        let value = texel(index);
        [value, value, value, 1.0]
    });
    let mut scene = lit(quad(0.5, 0.5));
    scene.materials[0].roughness = 0.0;
    let environment = Some(Environment::from_pixels("sky", size, pixels.collect())?);
    Ok(View { scene, environment, world_from_view: DMat4::IDENTITY })
}

/// Triangles of three corners.
fn triangles(corners: &[[f32; 3]]) -> macula::scene::Mesh {
    let place = |corner: &[f32; 3]| vertex(Vec3::from_array(*corner), Vec2::new(corner[0], corner[1]));
    mesh(corners.iter().map(place).collect(), (0..corners.len() as u32).collect())
}

/// Points and lines that call themselves triangles.
fn degenerate() -> Scene {
    let mut scene = lit(wall());
    let corners = [
        [0.1, 0.1, 0.0],
        [0.1, 0.1, 0.0],
        [0.1, 0.1, 0.0],
        [-0.5, 0.0, 0.0],
        [0.0, 0.0, 0.0],
        [0.5, 0.0, 0.0],
        [0.3, 0.3, 0.0],
        [0.3, 0.3, 0.0],
        [-0.3, 0.3, 0.0],
        [0.0, 1e-40, 0.0],
        [1e-40, 0.0, 0.0],
        [0.0, 0.0, 1e-40],
    ];
    add(&mut scene, triangles(&corners), at(0.0, 0.0, -1.0), white(0.0, 0.5));
    scene
}

/// A hundred-thousandth of a pixel wide.
fn slivers() -> Scene {
    let mut scene = lit(wall());
    for index in 0..12 {
        let sliver = triangles(&[[0.0, 0.0, 0.0], [1e-7, 0.0, 0.0], [1e-7, 900.0, -900.0]]);
        let turn = DMat4::from_rotation_z(f64::from(index) * 0.5);
        let material = Material { double_sided: true, ..white(1.0, 0.0) };
        add(&mut scene, sliver, at(0.0, 0.0, -1.0) * turn, material);
    }
    scene
}

/// A ground of 2000 km, a triangle through the eye's plane, one with a corner in the eye, one around it.
fn huge() -> Scene {
    let ground = DMat4::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    let mut scene = one(quad(1e6, 1e6), at(0.0, -1.0, 0.0) * ground, white(0.0, 0.5));
    let double_sided = || Material { double_sided: true, ..white(0.5, 0.5) };
    let through = [[-1e6, 0.5, 1e6], [1e6, 0.5, 1e6], [0.0, 0.6, -1e6]];
    let in_eye = [[0.0, 0.0, 0.0], [0.1, 1.0, -1e6], [-0.1, 1.0, -1e6]];
    let around = [[-1e6, -1e6, -1e5], [1e6, -1e6, -1e5], [0.0, 1e6, -1e5]];
    for corners in [through, in_eye, around] {
        add(&mut scene, triangles(&corners), DMat4::IDENTITY, double_sided());
    }
    scene.lights.push(sun(2.0));
    scene.lights.push(lamp(1e12, DVec3::new(0.0, 1e6, 0.0)));
    scene
}
