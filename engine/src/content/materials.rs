//! Materials: one storage buffer with their numbers, one descriptor set each with their textures.

use super::textures::{self, Samplers};
use crate::error::Result;
use crate::gpu::pipeline::{Bind, write_set};
use crate::gpu::reflect::{BindingInfo, ShaderInfo};
use crate::gpu::structs;
use crate::gpu::{Buffer, Context, Image, shaders, submit};
use crate::scene::{self, AlphaMode, Scene, Texture, TextureUse};
use ash::vk;
use std::sync::Arc;

/// The materials of a scene in GPU memory.
pub(super) struct GpuMaterials {
    buffer: Buffer,
    pub(super) sets: Vec<vk::DescriptorSet>,
    pool: vk::DescriptorPool,
    layout: vk::DescriptorSetLayout,
    _images: Vec<Image>,
    _samplers: Samplers,
    context: Arc<Context>,
}

/// Finds a material's use of one kind of map.
type MapOf = fn(&scene::Material) -> Option<TextureUse>;

/// The names in `shaders/shared/material.glsl`, with the use that fills each.
const MAPS: [(&str, MapOf); 5] = [
    ("base_color_map", |material| material.base_color_texture),
    ("metallic_roughness_map", |material| material.metallic_roughness_texture),
    ("normal_map", |material| material.normal_texture),
    ("occlusion_map", |material| material.occlusion_texture),
    ("emissive_map", |material| material.emissive_texture),
];

/// Stands in where a material has no texture; the shader does not sample it.
fn white() -> Texture {
    Texture {
        name: "white".into(),
        size: [1, 1],
        rgba8: Arc::from([255u8; 4]),
        srgb: false,
        sampler: scene::Sampler { mip_linear: None, ..scene::Sampler::default() },
    }
}

impl GpuMaterials {
    pub(super) fn upload(context: &Arc<Context>, scene: &Scene) -> Result<Self> {
        let white = white();
        let mut samplers = Samplers::default();
        let mut images = Vec::with_capacity(scene.textures.len() + 1);
        for texture in scene.textures.iter().chain([&white]) {
            samplers.add(context, &texture.sampler)?;
            images.push(textures::upload(context, texture)?);
        }
        // Each material's record starts where the device lets a uniform block begin.
        let size = size_of::<structs::Material>();
        let alignment = usize::try_from(context.limits.min_uniform_buffer_offset_alignment).unwrap_or(256);
        let stride = size.next_multiple_of(alignment.max(1));
        let mut records = vec![0u8; stride * scene.materials.len()];
        for (material, bytes) in scene.materials.iter().zip(records.chunks_exact_mut(stride)) {
            bytes[..size].copy_from_slice(bytemuck::bytes_of(&record(material)));
        }
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER;
        let buffer = submit::upload_buffer(context, "materials", &records, usage)?;
        let bindings = set1_bindings(&shaders::GBUFFER_FRAG);
        let layout = make_layout(context, &bindings)?;
        let mut made = Self {
            buffer,
            sets: Vec::new(),
            pool: vk::DescriptorPool::null(),
            layout,
            _images: Vec::new(),
            _samplers: Samplers::default(),
            context: context.clone(),
        };
        made.allocate_sets(scene.materials.len())?;
        for (index, (material, &set)) in scene.materials.iter().zip(&made.sets).enumerate() {
            let block = Bind::Range(&made.buffer, (index * stride) as u64, size as u64);
            let maps = MAPS.map(|(name, of)| {
                let index = of(material).map_or(scene.textures.len(), |use_| use_.texture);
                let sampler = scene.textures.get(index).map_or(&white.sampler, |texture| &texture.sampler);
                // Every texture's sampler was added above.
                let Some(sampler) = samplers.get(sampler) else { unreachable!("{name} has no sampler") };
                (name, Bind::Sampled(&images[index], sampler))
            });
            let mut binds = maps.to_vec();
            binds.push(("MaterialBlock", block));
            write_set(context, "material", set, &bindings, &binds, 0);
        }
        made._images = images;
        made._samplers = samplers;
        Ok(made)
    }

    fn allocate_sets(&mut self, materials: usize) -> Result<()> {
        let count = u32::try_from(materials.max(1)).unwrap_or(u32::MAX);
        let size =
            |ty: vk::DescriptorType, each: u32| vk::DescriptorPoolSize { ty, descriptor_count: count * each };
        let sizes = [
            size(vk::DescriptorType::COMBINED_IMAGE_SAMPLER, MAPS.len() as u32),
            size(vk::DescriptorType::UNIFORM_BUFFER, 1),
        ];
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(count).pool_sizes(&sizes);
        let device = &self.context.device;
        // SAFETY: the device is alive.
        let pool = unsafe { device.create_descriptor_pool(&info, None) };
        self.pool = Context::check(pool, || "making the materials' descriptor pool".into())?;
        let layouts = vec![self.layout; materials];
        if layouts.is_empty() {
            return Ok(());
        }
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(self.pool).set_layouts(&layouts);
        // SAFETY: the pool has room for exactly these sets.
        let sets = unsafe { device.allocate_descriptor_sets(&info) };
        self.sets = Context::check(sets, || "allocating the materials' descriptor sets".into())?;
        Ok(())
    }
}

impl Drop for GpuMaterials {
    fn drop(&mut self) {
        // SAFETY: renderers that use the materials hold the content alive and wait for their frames.
        unsafe {
            self.context.device.destroy_descriptor_pool(self.pool, None);
            self.context.device.destroy_descriptor_set_layout(self.layout, None);
        }
    }
}

fn set1_bindings(shader: &ShaderInfo) -> Vec<BindingInfo> {
    shader.bindings.iter().filter(|binding| binding.set == 1).copied().collect()
}

fn make_layout(context: &Context, bindings: &[BindingInfo]) -> Result<vk::DescriptorSetLayout> {
    let bindings: Vec<_> = bindings
        .iter()
        .map(|binding| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(binding.binding)
                .descriptor_type(binding.kind.vk())
                .descriptor_count(binding.count)
                .stage_flags(vk::ShaderStageFlags::FRAGMENT)
        })
        .collect();
    let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
    // SAFETY: the device is alive.
    let layout = unsafe { context.device.create_descriptor_set_layout(&info, None) };
    Context::check(layout, || "making the materials' set layout".into())
}

fn record(material: &scene::Material) -> structs::Material {
    let use_of = |of: Option<TextureUse>| {
        of.map_or_else(structs::TextureUse::default, |of| {
            let [u, v] = of.uv_transform;
            structs::TextureUse {
                row_u: u.extend(of.uv_set as f32).to_array(),
                row_v: v.extend(1.0).to_array(),
            }
        })
    };
    let cutoff = match material.alpha_mode {
        AlphaMode::Mask { cutoff } => cutoff,
        AlphaMode::Opaque | AlphaMode::Blend => -1.0,
    };
    let blend = material.alpha_mode == AlphaMode::Blend;
    structs::Material {
        base_color: material.base_color.to_array(),
        emissive: material.emissive.extend(cutoff).to_array(),
        factors: [material.metallic, material.roughness, material.normal_scale, material.occlusion_strength],
        flags: [u32::from(material.unlit), u32::from(blend), u32::from(material.double_sided), 0],
        base_color_use: use_of(material.base_color_texture),
        metallic_roughness_use: use_of(material.metallic_roughness_texture),
        normal_use: use_of(material.normal_texture),
        occlusion_use: use_of(material.occlusion_texture),
        emissive_use: use_of(material.emissive_texture),
    }
}
