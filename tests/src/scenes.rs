//! Small scenes made in code. The eye of [`crate::ahead`] stands at the origin and looks along `-Z`.

use glam::{DMat4, DVec2, DVec3, Vec2, Vec3, Vec4};
use macula::fovea::DisplayGeometry;
use macula::scene::hall::{self, HallOptions};
use macula::scene::load::{LoadOptions, load};
use macula::scene::{Camera, Instance, Light, LightKind, Material, Mesh, Scene, Vertex};

/// A rectangle in the XY plane, seen from `+Z`, of half sizes `half`, with linear colours at its corners
/// (-x -y, +x -y, +x +y, -x +y).
#[must_use]
pub fn coloured_quad(half: Vec2, colors: [[u8; 4]; 4]) -> Mesh {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let vertices = corners.iter().zip(colors).map(|(&(x, y), color)| Vertex {
        position: Vec3::new(x * half.x, y * half.y, 0.0),
        normal: Vec3::Z,
        tangent: [1.0, 0.0, 0.0, 1.0],
        uv0: Vec2::new(x * 0.5 + 0.5, 0.5 - y * 0.5),
        uv1: Vec2::ZERO,
        color,
        padding: 0,
    });
    Mesh {
        name: "quad".into(),
        vertices: vertices.collect(),
        indices: vec![0, 1, 2, 0, 2, 3],
        bounds: [(-half).extend(0.0), half.extend(0.0)],
        has_colors: colors.iter().any(|color| *color != [255; 4]),
    }
}

/// A white rectangle in the XY plane, seen from `+Z`.
#[must_use]
pub fn quad(half_x: f32, half_y: f32) -> Mesh {
    coloured_quad(Vec2::new(half_x, half_y), [[255; 4]; 4])
}

/// Adds a mesh, where it stands and its material.
pub fn add(scene: &mut Scene, mesh: Mesh, world_from_mesh: DMat4, material: Material) {
    scene.instances.push(Instance {
        mesh: scene.meshes.len(),
        material: scene.materials.len(),
        world_from_mesh,
    });
    scene.meshes.push(mesh);
    scene.materials.push(material);
}

/// A scene of one thing.
#[must_use]
pub fn one(mesh: Mesh, world_from_mesh: DMat4, material: Material) -> Scene {
    let mut scene = Scene { name: "test".into(), ..Scene::default() };
    add(&mut scene, mesh, world_from_mesh, material);
    scene
}

/// At a distance ahead.
#[must_use]
pub fn at(x: f64, y: f64, z: f64) -> DMat4 {
    DMat4::from_translation(DVec3::new(x, y, z))
}

/// A material that shows a linear colour as it is.
#[must_use]
pub fn unlit(red: f32, green: f32, blue: f32) -> Material {
    Material { unlit: true, base_color: Vec4::new(red, green, blue, 1.0), ..Material::default() }
}

/// A white surface.
#[must_use]
pub fn white(metallic: f32, roughness: f32) -> Material {
    Material { metallic, roughness, ..Material::default() }
}

/// A white light.
#[must_use]
pub fn light(intensity: f32, position: DVec3, direction: DVec3, kind: LightKind) -> Light {
    let direction = direction.normalize();
    Light { name: "lamp".into(), intensity: Vec3::splat(intensity), position, direction, kind }
}

/// White light from infinitely far.
#[must_use]
pub fn sun(lux: f32, direction: DVec3) -> Light {
    light(lux, DVec3::ZERO, direction, LightKind::Directional)
}

/// Where the ray through a pixel's centre meets the plane at a distance ahead.
#[must_use]
pub fn point_of_pixel(display: &DisplayGeometry, x: u32, y: u32, distance_m: f64) -> DVec3 {
    display.ray_of_px(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)) * distance_m
}

/// The generated hall, written and loaded like any other file.
///
/// # Panics
/// Where it cannot be made.
#[must_use]
pub fn hall(triangles: u32, lights: u32) -> Scene {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("hall.glb");
    hall::write_glb(&path, &HallOptions { triangles, lights, ..HallOptions::default() }).expect("a hall");
    load(&path, &LoadOptions::default()).expect("the hall loads")
}

/// The file's first camera, or else one that sees the whole scene from in front and above.
#[must_use]
pub fn camera_of(scene: &Scene) -> DMat4 {
    if let Some(Camera { world_from_view, .. }) = scene.cameras.first() {
        return *world_from_view;
    }
    let [low, high] = scene.bounds().unwrap_or([DVec3::ZERO; 2]);
    let centre = (low + high) * 0.5;
    let radius_m = ((high - low).length() * 0.5).max(1e-3);
    let eye = centre + DVec3::new(0.4, 0.3, 1.0).normalize() * (1.6 * radius_m);
    let back = (eye - centre).normalize();
    let right = DVec3::Y.cross(back).normalize();
    let column = |axis: DVec3| axis.extend(0.0);
    DMat4::from_cols(column(right), column(back.cross(right)), column(back), eye.extend(1.0))
}
