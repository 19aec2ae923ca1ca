//! Scenes on the CPU: what a glTF file says, checked and in the form in which the GPU wants it.
//!
//! A [`Scene`] is evaluated at one time: skins, morph targets and animations have been applied.
//! Every number in it is finite, every index is in range, every mesh has positions, normals and
//! tangents of length 1; [`load::load`] refuses what cannot be brought into that form.

pub mod environment;
pub mod hall;
pub mod load;
pub mod sdf;

use glam::{DMat4, DVec3, Vec2, Vec3, Vec4};

/// One scene at one time. Lengths in metres, angles in radians, world space right-handed, `+Y` up.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The file's name without its folder, for messages.
    pub name: String,
    /// Triangle lists, one for each glTF primitive that holds triangles (and one for each skinned
    /// or morphed use of one).
    pub meshes: Vec<Mesh>,
    /// Uses of meshes in the world.
    pub instances: Vec<Instance>,
    /// Materials; the last one is glTF's default material where a primitive names none.
    pub materials: Vec<Material>,
    /// Decoded textures.
    pub textures: Vec<Texture>,
    /// Punctual lights, in world space.
    pub lights: Vec<Light>,
    /// Cameras, in world space.
    pub cameras: Vec<Camera>,
    /// What was ignored or mended, one line each.
    pub warnings: Vec<String>,
}

/// One vertex; 64 bytes, as `shaders/shared/vertex.glsl` has it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Vertex {
    /// Position in the mesh's space, metres.
    pub position: Vec3,
    /// Unit normal.
    pub normal: Vec3,
    /// Unit tangent, and at the end the bitangent's sign, -1 or 1.
    pub tangent: [f32; 4],
    /// First UV set; (0, 0) where the file has none.
    pub uv0: Vec2,
    /// Second UV set; (0, 0) where the file has none.
    pub uv1: Vec2,
    /// Linear vertex colour and alpha as RGBA8; white where the file has none.
    pub color: [u8; 4],
    /// Unused; zero.
    pub padding: u32,
}

/// A triangle list.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// For messages and debug labels.
    pub name: String,
    /// The vertices.
    pub vertices: Vec<Vertex>,
    /// Three for each triangle, each below `vertices.len()`.
    pub indices: Vec<u32>,
    /// The least and the greatest coordinate of the positions.
    pub bounds: [Vec3; 2],
    /// The file brought vertex colours.
    pub has_colors: bool,
}

/// One use of a mesh.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// Invertible affine transform; in double precision, for worlds far from their origin.
    pub world_from_mesh: DMat4,
}

/// What happens to a surface's alpha.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// Fragments below the cutoff are dropped.
    Mask {
        /// 0..=1
        cutoff: f32,
    },
    /// Blended over what lies behind, in a forward pass.
    Blend,
}

/// A glTF metallic-roughness material.
#[derive(Clone, Debug)]
pub struct Material {
    /// For messages.
    pub name: String,
    /// Linear base colour and alpha.
    pub base_color: Vec4,
    /// 0..=1
    pub metallic: f32,
    /// Perceptual roughness, 0..=1.
    pub roughness: f32,
    /// Linear emitted radiance; emissive strength is multiplied in.
    pub emissive: Vec3,
    /// Scale of the normal map's x and y.
    pub normal_scale: f32,
    /// 0..=1
    pub occlusion_strength: f32,
    /// Alpha.
    pub alpha_mode: AlphaMode,
    /// Seen from both sides.
    pub double_sided: bool,
    /// `KHR_materials_unlit`: the base colour is shown as it is.
    pub unlit: bool,
    /// sRGB base colour and alpha.
    pub base_color_texture: Option<TextureUse>,
    /// Roughness in G, metallic in B.
    pub metallic_roughness_texture: Option<TextureUse>,
    /// Tangent-space normals.
    pub normal_texture: Option<TextureUse>,
    /// Occlusion in R.
    pub occlusion_texture: Option<TextureUse>,
    /// sRGB emission.
    pub emissive_texture: Option<TextureUse>,
}

impl Default for Material {
    /// glTF's default material.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec4::ONE,
            metallic: 1.0,
            roughness: 1.0,
            emissive: Vec3::ZERO,
            normal_scale: 1.0,
            occlusion_strength: 1.0,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            unlit: false,
            base_color_texture: None,
            metallic_roughness_texture: None,
            normal_texture: None,
            occlusion_texture: None,
            emissive_texture: None,
        }
    }
}

/// How a material uses a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureUse {
    /// Index into [`Scene::textures`].
    pub texture: usize,
    /// UV set, 0 or 1.
    pub uv_set: u32,
    /// `KHR_texture_transform` as the two rows of a 2x3 matrix:
    /// `u' = rows[0] . (u, v, 1)`, `v' = rows[1] . (u, v, 1)`.
    pub uv_transform: [Vec3; 2],
}

/// A texture: pixels and how to sample them.
#[derive(Clone, Debug)]
pub struct Texture {
    /// For messages.
    pub name: String,
    /// Width and height in texels, each at least 1.
    pub size: [u32; 2],
    /// `4 * width * height` bytes, rows from the top.
    pub rgba8: std::sync::Arc<[u8]>,
    /// The colours are sRGB-encoded (base colour and emissive), else linear.
    pub srgb: bool,
    /// How it is sampled.
    pub sampler: Sampler,
}

/// glTF's wrap modes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// Repeats.
    #[default]
    Repeat,
    /// Repeats mirrored.
    MirroredRepeat,
    /// Takes the edge.
    ClampToEdge,
}

/// glTF's sampler.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Sampler {
    /// Along u.
    pub wrap_u: Wrap,
    /// Along v.
    pub wrap_v: Wrap,
    /// Linear when magnified, else nearest.
    pub mag_linear: bool,
    /// Linear when minified, else nearest.
    pub min_linear: bool,
    /// `None`: no mip levels; else linear (`true`) or nearest between levels.
    pub mip_linear: Option<bool>,
}

impl Default for Sampler {
    fn default() -> Self {
        Self {
            wrap_u: Wrap::Repeat,
            wrap_v: Wrap::Repeat,
            mag_linear: true,
            min_linear: true,
            mip_linear: Some(true),
        }
    }
}

/// A light of `KHR_lights_punctual`.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// For messages.
    pub name: String,
    /// Linear colour times intensity: lux for directional lights, candela for the others.
    pub intensity: Vec3,
    /// World position (of no meaning for directional lights).
    pub position: DVec3,
    /// Unit direction in which the light shines.
    pub direction: DVec3,
    /// The kind and what only it has.
    pub kind: LightKind,
}

/// Kinds of punctual light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// From infinitely far.
    Directional,
    /// In all directions.
    Point {
        /// Metres; infinite where the file gives none.
        range: f32,
    },
    /// In a cone.
    Spot {
        /// Metres; infinite where the file gives none.
        range: f32,
        /// Half angle at which the fall-off begins, radians.
        inner_angle: f32,
        /// Half angle of the cone, radians, above `inner_angle`.
        outer_angle: f32,
    },
}

/// A camera: where it stands; the frustum comes from the display that one renders for.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// The camera's, or else its node's, name.
    pub name: String,
    /// World from view: right-handed, `-Z` forward, without scale.
    pub world_from_view: DMat4,
    /// Vertical field of view, radians, of a perspective camera.
    pub yfov_rad: Option<f64>,
}

impl Scene {
    /// World-space bounds of all instances, or `None` for a scene without triangles.
    #[must_use]
    pub fn bounds(&self) -> Option<[DVec3; 2]> {
        let mut bounds: Option<[DVec3; 2]> = None;
        for instance in &self.instances {
            let [low, high] = self.meshes[instance.mesh].bounds.map(|b| b.as_dvec3());
            for corner in 0..8u32 {
                let pick = |bit: u32, low: f64, high: f64| if corner >> bit & 1 == 0 { low } else { high };
                let local =
                    DVec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z));
                let world = instance.world_from_mesh.transform_point3(local);
                let [least, greatest] = bounds.unwrap_or([world; 2]);
                bounds = Some([least.min(world), greatest.max(world)]);
            }
        }
        bounds
    }

    /// Triangles that one frame draws: each instance counts.
    #[must_use]
    pub fn triangle_count(&self) -> u64 {
        let of_instance = |instance: &Instance| self.meshes[instance.mesh].indices.len() as u64 / 3;
        self.instances.iter().map(of_instance).sum()
    }
}
