//! A triangle scene in GPU memory.

use super::environment::GpuEnvironment;
use super::features::{MaterialVariant, SceneFeatures};
use super::materials::GpuMaterials;
use crate::error::Result;
use crate::gpu::{Buffer, Context, structs, submit};
use crate::scene::environment::Environment;
use crate::scene::{AlphaMode, Light, LightKind, Scene};
use ash::vk;
use glam::{DMat3, DVec3};
use std::sync::Arc;

/// Where a mesh lies in the shared buffers.
#[derive(Clone, Copy, Debug)]
pub struct MeshRange {
    /// First index.
    pub first_index: u32,
    /// Number of indices.
    pub index_count: u32,
    /// Added to every index.
    pub vertex_offset: i32,
}

/// An instance as the CPU keeps it.
#[derive(Clone, Copy, Debug)]
pub struct DrawInstance {
    /// Index into [`GpuScene::meshes`].
    pub mesh: usize,
    /// Index of its material.
    pub material: usize,
    /// Its record but for the translation, which depends on the eye.
    pub record: structs::Draw,
    /// World position of the mesh's origin.
    pub origin: DVec3,
    /// World bounding sphere.
    pub centre: DVec3,
    /// Metres.
    pub radius_m: f64,
    /// Seen from both sides.
    pub double_sided: bool,
    /// Turns right into left.
    pub mirrored: bool,
    /// Which maps its material has.
    pub variant: MaterialVariant,
    /// Drawn in the forward pass.
    pub blend: bool,
}

/// A scene in GPU memory.
pub struct GpuScene {
    pub(crate) vertices: Buffer,
    pub(crate) indices: Buffer,
    materials: GpuMaterials,
    pub(crate) environment: GpuEnvironment,
    /// Meshes.
    pub meshes: Vec<MeshRange>,
    /// Instances.
    pub instances: Vec<DrawInstance>,
    /// Lights, directional ones first and then the brightest: those that get shadows come first.
    pub lights: Vec<Light>,
    /// World bounds; a unit cube for a scene without triangles.
    pub bounds: [DVec3; 2],
    /// What it has.
    pub features: SceneFeatures,
    pub(crate) context: Arc<Context>,
}

impl GpuScene {
    pub(super) fn upload(
        context: &Arc<Context>,
        scene: &Scene,
        environment: Option<&Environment>,
    ) -> Result<Self> {
        let mut vertices = Vec::new();
        let mut indices = Vec::new();
        let mut meshes = Vec::with_capacity(scene.meshes.len());
        for mesh in &scene.meshes {
            meshes.push(MeshRange {
                first_index: fit(indices.len()),
                index_count: fit(mesh.indices.len()),
                vertex_offset: i32::try_from(vertices.len()).unwrap_or(i32::MAX),
            });
            vertices.extend_from_slice(&mesh.vertices);
            indices.extend_from_slice(&mesh.indices);
        }
        let instances = scene.instances.iter().map(|instance| draw_instance(scene, instance)).collect();
        let mut lights = scene.lights.clone();
        lights.sort_by(|a, b| {
            let key = |light: &Light| {
                let directional = matches!(light.kind, LightKind::Directional);
                (u8::from(!directional), -light.intensity.max_element())
            };
            let (a, b) = (key(a), key(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        Ok(Self {
            vertices: submit::upload_buffer(
                context,
                "vertices",
                &vertices,
                vk::BufferUsageFlags::VERTEX_BUFFER,
            )?,
            indices: submit::upload_buffer(context, "indices", &indices, vk::BufferUsageFlags::INDEX_BUFFER)?,
            materials: GpuMaterials::upload(context, scene)?,
            environment: GpuEnvironment::upload(context, environment)?,
            meshes,
            instances,
            lights,
            bounds: scene.bounds().unwrap_or([DVec3::NEG_ONE, DVec3::ONE]),
            features: SceneFeatures::of(scene, environment),
            context: context.clone(),
        })
    }

    pub(crate) fn material_set(&self, material: usize) -> vk::DescriptorSet {
        self.materials.sets[material]
    }
}

fn fit(of: usize) -> u32 {
    u32::try_from(of).unwrap_or(u32::MAX)
}

fn draw_instance(scene: &Scene, instance: &crate::scene::Instance) -> DrawInstance {
    let material = &scene.materials[instance.material];
    let mesh = &scene.meshes[instance.mesh];
    let linear = DMat3::from_mat4(instance.world_from_mesh);
    let origin = instance.world_from_mesh.w_axis.truncate();
    let [low, high] = mesh.bounds.map(|bound| bound.as_dvec3());
    let centre = instance.world_from_mesh.transform_point3((low + high) * 0.5);
    // The columns' lengths bound how far the transform stretches a diagonal.
    let half = (high - low) * 0.5;
    let radius_m = (linear.x_axis * half.x).length()
        + (linear.y_axis * half.y).length()
        + (linear.z_axis * half.z).length();
    // The cofactor matrix is the inverse transpose times the determinant: normals need only its
    // direction, and it exists where the inverse would overflow.
    let cofactor = DMat3::from_cols(
        linear.y_axis.cross(linear.z_axis),
        linear.z_axis.cross(linear.x_axis),
        linear.x_axis.cross(linear.y_axis),
    );
    let mirrored = linear.determinant() < 0.0;
    let largest = cofactor.x_axis.length().max(cofactor.y_axis.length()).max(cofactor.z_axis.length());
    let scale = if mirrored { -1.0 } else { 1.0 } / largest.max(f64::MIN_POSITIVE);
    let rows = |of: DMat3| {
        let of = of.transpose();
        [of.x_axis, of.y_axis, of.z_axis].map(|row| row.as_vec3().extend(0.0).to_array())
    };
    DrawInstance {
        mesh: instance.mesh,
        material: instance.material,
        record: structs::Draw {
            rel_from_mesh: rows(linear),
            rel_from_normal: rows(cofactor * scale),
            handedness: if mirrored { -1.0 } else { 1.0 },
            view: 0,
            pad0: 0,
            pad1: 0,
        },
        origin,
        centre,
        radius_m,
        double_sided: material.double_sided,
        mirrored,
        variant: MaterialVariant::of(material),
        blend: material.alpha_mode == AlphaMode::Blend,
    }
}
