//! Scenes made in code. The eye stands at the origin and looks along `-Z`.

use glam::{DMat4, DVec3, Vec2, Vec3, Vec4};
use macula::fovea::DisplayGeometry;
use macula::scene::{
    Instance, Light, LightKind, Material, Mesh, Sampler, Scene, Texture, TextureUse, Vertex,
};

/// A vertex of a surface that faces `+Z`, white.
pub fn vertex(position: Vec3, uv: Vec2) -> Vertex {
    Vertex {
        position,
        normal: Vec3::Z,
        tangent: [1.0, 0.0, 0.0, 1.0],
        uv0: uv,
        uv1: Vec2::ZERO,
        color: [255; 4],
        padding: 0,
    }
}

/// A mesh of these vertices and triangles, with its bounds.
pub fn mesh(vertices: Vec<Vertex>, indices: Vec<u32>) -> Mesh {
    let low = vertices.iter().fold(Vec3::INFINITY, |low, vertex| low.min(vertex.position));
    let high = vertices.iter().fold(Vec3::NEG_INFINITY, |high, vertex| high.max(vertex.position));
    let has_colors = vertices.iter().any(|vertex| vertex.color != [255; 4]);
    Mesh { name: "hard case".into(), vertices, indices, bounds: [low, high], has_colors }
}

/// The corners of a rectangle in the XY plane, seen from `+Z`: -x -y, +x -y, +x +y, -x +y.
const CORNERS: [Vec2; 4] =
    [Vec2::new(-1.0, -1.0), Vec2::new(1.0, -1.0), Vec2::new(1.0, 1.0), Vec2::new(-1.0, 1.0)];

/// A rectangle in the XY plane with the given half sizes. Its texture is upright.
pub fn quad(half_x: f32, half_y: f32) -> Mesh {
    let half = Vec2::new(half_x, half_y);
    let corner = |at: &Vec2| vertex((*at * half).extend(0.0), Vec2::new(at.x, -at.y) * 0.5 + 0.5);
    mesh(CORNERS.iter().map(corner).collect(), vec![0, 1, 2, 0, 2, 3])
}

/// A surface with something else in each vertex.
pub fn with(mut surface: Mesh, change: impl Fn(&mut Vertex)) -> Mesh {
    surface.vertices.iter_mut().for_each(change);
    mesh(surface.vertices, surface.indices)
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
pub fn one(mesh: Mesh, world_from_mesh: DMat4, material: Material) -> Scene {
    let mut scene = Scene { name: "hard case".into(), ..Scene::default() };
    add(&mut scene, mesh, world_from_mesh, material);
    scene
}

/// At a place.
pub fn at(x: f64, y: f64, z: f64) -> DMat4 {
    DMat4::from_translation(DVec3::new(x, y, z))
}

/// A material that shows a linear colour as it is.
pub fn unlit(red: f32, green: f32, blue: f32) -> Material {
    Material { unlit: true, base_color: Vec4::new(red, green, blue, 1.0), ..Material::default() }
}

/// A white surface.
pub fn white(metallic: f32, roughness: f32) -> Material {
    Material { metallic, roughness, ..Material::default() }
}

/// A white light.
pub fn light(intensity: f32, position: DVec3, kind: LightKind) -> Light {
    Light {
        name: "lamp".into(),
        intensity: Vec3::splat(intensity),
        position,
        direction: DVec3::new(0.2, 0.1, -1.0).normalize(),
        kind,
    }
}

/// A lamp that shines in all directions, candela.
pub fn lamp(intensity: f32, position: DVec3) -> Light {
    light(intensity, position, LightKind::Point { range: f32::INFINITY })
}

/// White light from infinitely far over the eye's shoulder, lux.
pub fn sun(lux: f32) -> Light {
    light(lux, DVec3::ZERO, LightKind::Directional)
}

/// Adds a texture and says how it is used.
pub fn texture(
    scene: &mut Scene,
    size: [u32; 2],
    srgb: bool,
    texel: impl Fn(u32, u32) -> [u8; 3],
) -> TextureUse {
    let [width, height] = size;
    let texels = (0..width * height).flat_map(|index| {
        let [red, green, blue] = texel(index % width, index / width);
        [red, green, blue, 255]
    });
    scene.textures.push(Texture {
        name: "pattern".into(),
        size,
        rgba8: texels.collect(),
        srgb,
        sampler: Sampler { mip_linear: None, ..Sampler::default() },
    });
    TextureUse {
        texture: scene.textures.len() - 1,
        uv_set: 0,
        uv_transform: [Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0)],
    }
}

/// Half sizes of what fills a display at a distance of 1 m, and the middle of it; a little is added at each
/// side.
fn fill(display: &DisplayGeometry, more: f64) -> ([f32; 2], DMat4) {
    let half = |low: f64, high: f64| ((high - low) / 2.0 * more) as f32;
    let middle = |low: f64, high: f64| (high + low) / 2.0;
    let d = display;
    (
        [half(d.tan_left, d.tan_right), half(d.tan_down, d.tan_up)],
        at(middle(d.tan_left, d.tan_right), middle(d.tan_down, d.tan_up), -1.0),
    )
}

/// Fills the display with a picture that rises evenly from left to right (red), from top to bottom (green)
/// and along the diagonal (blue), from 0 to 1.
pub fn ramp(display: &DisplayGeometry) -> Scene {
    let ([half_x, half_y], place) = fill(display, 1.0);
    let mut surface = quad(half_x, half_y);
    let colors = [[0, 255, 128, 255], [255, 255, 255, 255], [255, 0, 128, 255], [0, 0, 0, 255]];
    for (vertex, color) in surface.vertices.iter_mut().zip(colors) {
        vertex.color = color;
    }
    one(mesh(surface.vertices, surface.indices), place, unlit(1.0, 1.0, 1.0))
}

/// Fills the display with a lit wall whose pattern is as fine as its pixels, before it a mirror-like and a
/// glowing panel.
pub fn pattern(display: &DisplayGeometry) -> Scene {
    let ([half_x, half_y], place) = fill(display, 1.2);
    let mut scene = one(quad(half_x, half_y), place, white(0.0, 0.7));
    let noise = |x: u32, y: u32, salt: u32| {
        // An integer hash (Wang's); only its irregularity matters.
        let mut word = x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77) ^ salt;
        word = (word ^ 61 ^ (word >> 16)).wrapping_mul(9);
        word = (word ^ (word >> 4)).wrapping_mul(0x27d4_eb2d);
        (word >> 24) as u8
    };
    let used = texture(&mut scene, [256, 256], true, |x, y| [1, 2, 3].map(|salt| noise(x, y, salt)));
    scene.materials[0].base_color_texture = Some(used);
    let panel = |x: f64| place * at(f64::from(half_x) * x, 0.0, 0.1);
    add(&mut scene, quad(half_x * 0.15, half_y * 0.3), panel(-0.5), white(1.0, 0.1));
    let glowing = Material { emissive: Vec3::new(20.0, 5.0, 1.0), ..white(0.0, 1.0) };
    add(&mut scene, quad(half_x * 0.1, half_y * 0.1), panel(0.45), glowing);
    scene.lights.push(sun(3.0));
    scene.lights.push(lamp(2.0, DVec3::new(0.1, 0.2, -0.3)));
    scene
}
