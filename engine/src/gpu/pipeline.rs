//! Pipelines whose descriptors are bound by the names that the shaders give them.

use super::context::Context;
use super::reflect::{BindingInfo, DescriptorKind, ShaderInfo};
use super::resource::{Buffer, Image, Sampler};
use crate::error::Result;
use ash::vk;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Frames that may be in flight at once. What the CPU writes each frame exists this many times.
pub const FRAME_SLOTS: usize = 2;

/// What a name in a shader is bound to.
#[derive(Clone, Copy)]
pub enum Bind<'a> {
    /// The same buffer in every frame slot.
    Buffer(&'a Buffer),
    /// One buffer for each frame slot.
    PerSlot(&'a [Buffer]),
    /// Part of a buffer: offset and size in bytes.
    Range(&'a Buffer, u64, u64),
    /// An image as storage image or as sampled image without sampler.
    Image(&'a Image),
    /// An image and a sampler.
    Sampled(&'a Image, &'a Sampler),
}

/// Specialization: name and value (booleans as 0 and 1).
pub type Spec<'a> = &'a [(&'a str, u32)];

/// Descriptor sets of set 0, one for each frame slot, and the layouts of a pipeline.
struct Bindings {
    layout: vk::PipelineLayout,
    set_layouts: Vec<vk::DescriptorSetLayout>,
    pool: vk::DescriptorPool,
    sets: [vk::DescriptorSet; FRAME_SLOTS],
    context: Arc<Context>,
}

/// The union of what several stages bind, by set and binding.
fn merged(shaders: &[&ShaderInfo]) -> BTreeMap<(u32, u32), (BindingInfo, vk::ShaderStageFlags)> {
    let mut all = BTreeMap::new();
    for shader in shaders {
        for binding in shader.bindings {
            let entry = all
                .entry((binding.set, binding.binding))
                .or_insert((*binding, vk::ShaderStageFlags::empty()));
            entry.1 |= shader.stage.flags();
        }
    }
    all
}

impl Bindings {
    fn new(context: &Arc<Context>, shaders: &[&ShaderInfo], binds: &[(&str, Bind<'_>)]) -> Result<Self> {
        let device = &context.device;
        let name = shaders[0].name;
        let all = merged(shaders);
        let mut made = Self {
            layout: vk::PipelineLayout::null(),
            set_layouts: Vec::new(),
            pool: vk::DescriptorPool::null(),
            sets: [vk::DescriptorSet::null(); FRAME_SLOTS],
            context: context.clone(),
        };
        let set_count = all.keys().map(|(set, _)| set + 1).max().unwrap_or(1);
        for set in 0..set_count {
            let of_set: Vec<_> = all
                .iter()
                .filter(|((of, _), _)| *of == set)
                .map(|(_, (binding, stages))| {
                    vk::DescriptorSetLayoutBinding::default()
                        .binding(binding.binding)
                        .descriptor_type(binding.kind.vk())
                        .descriptor_count(binding.count)
                        .stage_flags(*stages)
                })
                .collect();
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&of_set);
            // SAFETY: the device is alive.
            let layout = unsafe { device.create_descriptor_set_layout(&info, None) };
            made.set_layouts.push(Context::check(layout, || format!("making {name}'s set layout"))?);
        }
        let push_bytes = shaders.iter().map(|shader| shader.push_constant_bytes).max().unwrap_or(0);
        let push_stages = shaders
            .iter()
            .filter(|shader| shader.push_constant_bytes > 0)
            .fold(vk::ShaderStageFlags::empty(), |flags, shader| flags | shader.stage.flags());
        let push = [vk::PushConstantRange { stage_flags: push_stages, offset: 0, size: push_bytes }];
        let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&made.set_layouts);
        if push_bytes > 0 {
            info = info.push_constant_ranges(&push);
        }
        // SAFETY: the set layouts are alive.
        let layout = unsafe { device.create_pipeline_layout(&info, None) };
        made.layout = Context::check(layout, || format!("making {name}'s pipeline layout"))?;
        let of_set0: Vec<_> =
            all.iter().filter(|((set, _), _)| *set == 0).map(|(_, (binding, _))| *binding).collect();
        made.allocate(name, &of_set0)?;
        for slot in 0..FRAME_SLOTS {
            write_set(context, name, made.sets[slot], &of_set0, binds, slot);
        }
        Ok(made)
    }

    fn allocate(&mut self, name: &str, of_set0: &[BindingInfo]) -> Result<()> {
        if of_set0.is_empty() {
            return Ok(());
        }
        let mut sizes: BTreeMap<i32, u32> = BTreeMap::new();
        for binding in of_set0 {
            *sizes.entry(binding.kind.vk().as_raw()).or_default() += binding.count * FRAME_SLOTS as u32;
        }
        let sizes: Vec<_> = sizes
            .into_iter()
            .map(|(ty, count)| vk::DescriptorPoolSize {
                ty: vk::DescriptorType::from_raw(ty),
                descriptor_count: count,
            })
            .collect();
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(FRAME_SLOTS as u32).pool_sizes(&sizes);
        // SAFETY: the device is alive.
        let pool = unsafe { self.context.device.create_descriptor_pool(&info, None) };
        self.pool = Context::check(pool, || format!("making {name}'s descriptor pool"))?;
        let layouts = [self.set_layouts[0]; FRAME_SLOTS];
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(self.pool).set_layouts(&layouts);
        // SAFETY: the pool has room for exactly these sets.
        let sets = unsafe { self.context.device.allocate_descriptor_sets(&info) };
        let sets = Context::check(sets, || format!("allocating {name}'s descriptor sets"))?;
        self.sets.copy_from_slice(&sets);
        Ok(())
    }
}

impl Drop for Bindings {
    fn drop(&mut self) {
        // SAFETY: the pipeline's owner has waited for the frames that used it.
        unsafe {
            self.context.device.destroy_descriptor_pool(self.pool, None);
            self.context.device.destroy_pipeline_layout(self.layout, None);
            for &layout in &self.set_layouts {
                self.context.device.destroy_descriptor_set_layout(layout, None);
            }
        }
    }
}

/// Points every binding of a set at what its name is bound to.
///
/// # Panics
/// If a name is not bound or bound to the wrong kind: the pass that lists the names is next to the
/// shader, so this is a mistake in the engine that the first use shows.
pub(crate) fn write_set(
    context: &Context,
    shader: &str,
    set: vk::DescriptorSet,
    bindings: &[BindingInfo],
    binds: &[(&str, Bind<'_>)],
    slot: usize,
) {
    for binding in bindings {
        let Some((_, bind)) = binds.iter().find(|(name, _)| *name == binding.name) else {
            unreachable!("{shader}: nothing is bound to {}", binding.name)
        };
        let write = vk::WriteDescriptorSet::default()
            .dst_set(set)
            .dst_binding(binding.binding)
            .descriptor_type(binding.kind.vk());
        let (buffer, image) = match (binding.kind, bind) {
            (
                DescriptorKind::UniformBuffer
                | DescriptorKind::StorageBuffer
                | DescriptorKind::UniformTexelBuffer,
                Bind::Buffer(_) | Bind::PerSlot(_) | Bind::Range(..),
            ) => match bind {
                Bind::PerSlot(buffers) => (Some(&buffers[slot]), None),
                Bind::Buffer(buffer) | Bind::Range(buffer, ..) => (Some(*buffer), None),
                Bind::Image(_) | Bind::Sampled(..) => (None, None),
            },
            (DescriptorKind::StorageImage | DescriptorKind::SampledImage, Bind::Image(image)) => {
                (None, Some((*image, vk::Sampler::null())))
            }
            (DescriptorKind::CombinedImageSampler, Bind::Sampled(image, sampler)) => {
                (None, Some((*image, sampler.sampler)))
            }
            _ => unreachable!("{shader}: {} is bound to the wrong kind", binding.name),
        };
        let texels = buffer.map(|buffer| [buffer.texel_view]);
        let buffers = buffer.map(|buffer| {
            let (offset, range) = match *bind {
                Bind::Range(_, offset, size) => (offset, size),
                _ => (0, vk::WHOLE_SIZE),
            };
            [vk::DescriptorBufferInfo { buffer: buffer.buffer, offset, range }]
        });
        let images = image.map(|(image, sampler)| {
            [vk::DescriptorImageInfo {
                sampler,
                image_view: image.view,
                image_layout: vk::ImageLayout::GENERAL,
            }]
        });
        let write = match (&buffers, &texels, &images) {
            (_, Some(texels), _) if binding.kind == DescriptorKind::UniformTexelBuffer => {
                write.texel_buffer_view(texels)
            }
            (Some(buffers), _, _) => write.buffer_info(buffers),
            (None, _, Some(images)) => write.image_info(images),
            (None, _, None) => continue,
        };
        // SAFETY: the set is not in use yet, and the resources outlive it: the pass owns both.
        unsafe { context.device.update_descriptor_sets(&[write], &[]) };
    }
}

/// A shader module that lives while a pipeline is made.
struct Module<'a> {
    module: vk::ShaderModule,
    context: &'a Context,
}

impl<'a> Module<'a> {
    fn new(context: &'a Context, shader: &ShaderInfo) -> Result<Self> {
        let info = vk::ShaderModuleCreateInfo::default().code(shader.spirv);
        // SAFETY: the words come from glslang.
        let module = unsafe { context.device.create_shader_module(&info, None) };
        Ok(Self { module: Context::check(module, || format!("loading {}", shader.name))?, context })
    }
}

impl Drop for Module<'_> {
    fn drop(&mut self) {
        // SAFETY: a pipeline does not need its modules once it is made.
        unsafe { self.context.device.destroy_shader_module(self.module, None) };
    }
}

/// Specialization entries and data for one shader; values that the shader does not name are left out.
fn specialization(shader: &ShaderInfo, spec: Spec<'_>) -> (Vec<vk::SpecializationMapEntry>, Vec<u8>) {
    let mut entries = Vec::new();
    let mut data = Vec::new();
    for (name, value) in spec {
        if let Some((_, id)) = shader.spec.iter().find(|(of, _)| of == name) {
            entries.push(vk::SpecializationMapEntry {
                constant_id: *id,
                offset: u32::try_from(data.len()).unwrap_or(u32::MAX),
                size: 4,
            });
            data.extend_from_slice(&value.to_ne_bytes());
        }
    }
    (entries, data)
}

/// A compute pipeline with its descriptors.
pub struct ComputePipeline {
    pipeline: vk::Pipeline,
    bindings: Bindings,
}

impl ComputePipeline {
    /// Builds the pipeline and binds everything that the shader names.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    ///
    /// # Panics
    /// If a name that the shader declares is not bound, or bound to the wrong kind.
    pub fn new(
        context: &Arc<Context>,
        shader: &ShaderInfo,
        spec: Spec<'_>,
        binds: &[(&str, Bind<'_>)],
    ) -> Result<Self> {
        let bindings = Bindings::new(context, &[shader], binds)?;
        let module = Module::new(context, shader)?;
        let (entries, data) = specialization(shader, spec);
        let special = vk::SpecializationInfo::default().map_entries(&entries).data(&data);
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module.module)
            .name(c"main")
            .specialization_info(&special);
        let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(bindings.layout)];
        // SAFETY: module, layout and cache are alive.
        let made = unsafe { context.device.create_compute_pipelines(context.pipeline_cache, &info, None) };
        let made = Context::check(made.map_err(|(_, code)| code), || format!("building {}", shader.name))?;
        context.set_name(made[0], shader.name);
        Ok(Self { pipeline: made[0], bindings })
    }

    /// Binds the pipeline and the frame slot's descriptors, and sets the push constants.
    pub fn bind<P: bytemuck::Pod>(&self, commands: vk::CommandBuffer, slot: usize, push: &P) {
        let device = &self.bindings.context.device;
        let point = vk::PipelineBindPoint::COMPUTE;
        // SAFETY: `commands` is being recorded; pipeline, sets and layout belong together.
        unsafe {
            device.cmd_bind_pipeline(commands, point, self.pipeline);
            let sets = &self.bindings.sets[slot..=slot];
            if sets[0] != vk::DescriptorSet::null() {
                device.cmd_bind_descriptor_sets(commands, point, self.bindings.layout, 0, sets, &[]);
            }
            let bytes = bytemuck::bytes_of(push);
            if !bytes.is_empty() {
                let stages = vk::ShaderStageFlags::COMPUTE;
                device.cmd_push_constants(commands, self.bindings.layout, stages, 0, bytes);
            }
        }
    }
}

impl Drop for ComputePipeline {
    fn drop(&mut self) {
        // SAFETY: the owner has waited for the frames that used it.
        unsafe { self.bindings.context.device.destroy_pipeline(self.pipeline, None) };
    }
}

/// Fixed-function state of a graphics pipeline. Viewport, scissor, cull mode and front face are
/// dynamic.
#[derive(Clone, Copy, Debug, Default)]
pub struct GraphicsState<'a> {
    /// Colour attachments.
    pub color_formats: &'a [vk::Format],
    /// Depth attachment D32 with reversed depth.
    pub depth: bool,
    /// Writes depth.
    pub depth_write: bool,
    /// Blends premultiplied alpha over the attachment.
    pub blend: bool,
    /// Constant and slope-scaled depth bias.
    pub depth_bias: Option<[f32; 2]>,
    /// Reads [`crate::scene::Vertex`] from binding 0; else no vertex input.
    pub scene_vertices: bool,
}

/// A graphics pipeline with the descriptors of set 0.
pub struct GraphicsPipeline {
    pipeline: vk::Pipeline,
    bindings: Bindings,
    push_stages: vk::ShaderStageFlags,
}

impl GraphicsPipeline {
    /// Builds the pipeline and binds everything that set 0 of the shaders names.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    ///
    /// # Panics
    /// If a name that the shader declares is not bound, or bound to the wrong kind.
    pub fn new(
        context: &Arc<Context>,
        shaders: &[&ShaderInfo],
        spec: Spec<'_>,
        state: &GraphicsState<'_>,
        binds: &[(&str, Bind<'_>)],
    ) -> Result<Self> {
        let bindings = Bindings::new(context, shaders, binds)?;
        let pipeline = build_graphics(context, shaders, spec, state, bindings.layout)?;
        context.set_name(pipeline, shaders[0].name);
        let push_stages = shaders
            .iter()
            .filter(|shader| shader.push_constant_bytes > 0)
            .fold(vk::ShaderStageFlags::empty(), |flags, shader| flags | shader.stage.flags());
        Ok(Self { pipeline, bindings, push_stages })
    }

    /// The layout of descriptor set 1, for those who fill it (the materials).
    #[must_use]
    pub fn set1_layout(&self) -> Option<vk::DescriptorSetLayout> {
        self.bindings.set_layouts.get(1).copied()
    }

    /// Binds the pipeline and the frame slot's set 0.
    pub fn bind(&self, commands: vk::CommandBuffer, slot: usize) {
        let device = &self.bindings.context.device;
        let point = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: `commands` is being recorded; pipeline, sets and layout belong together.
        unsafe {
            device.cmd_bind_pipeline(commands, point, self.pipeline);
            let sets = &self.bindings.sets[slot..=slot];
            if sets[0] != vk::DescriptorSet::null() {
                device.cmd_bind_descriptor_sets(commands, point, self.bindings.layout, 0, sets, &[]);
            }
        }
    }

    /// Binds set 1.
    pub fn bind_set1(&self, commands: vk::CommandBuffer, set: vk::DescriptorSet) {
        let point = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: as above; the set was allocated with `set1_layout`.
        unsafe {
            let device = &self.bindings.context.device;
            device.cmd_bind_descriptor_sets(commands, point, self.bindings.layout, 1, &[set], &[]);
        }
    }

    /// Sets the push constants.
    pub fn push<P: bytemuck::Pod>(&self, commands: vk::CommandBuffer, push: &P) {
        let bytes = bytemuck::bytes_of(push);
        // SAFETY: `commands` is being recorded, and the layout has a range of this size.
        unsafe {
            let device = &self.bindings.context.device;
            device.cmd_push_constants(commands, self.bindings.layout, self.push_stages, 0, bytes);
        }
    }
}

impl Drop for GraphicsPipeline {
    fn drop(&mut self) {
        // SAFETY: the owner has waited for the frames that used it.
        unsafe { self.bindings.context.device.destroy_pipeline(self.pipeline, None) };
    }
}

/// How [`crate::scene::Vertex`] lies in memory.
const VERTEX_ATTRIBUTES: [(vk::Format, u32); 6] = [
    (vk::Format::R32G32B32_SFLOAT, 0),
    (vk::Format::R32G32B32_SFLOAT, 12),
    (vk::Format::R32G32B32A32_SFLOAT, 24),
    (vk::Format::R32G32_SFLOAT, 40),
    (vk::Format::R32G32_SFLOAT, 48),
    (vk::Format::R8G8B8A8_UNORM, 56),
];

fn build_graphics(
    context: &Arc<Context>,
    shaders: &[&ShaderInfo],
    spec: Spec<'_>,
    state: &GraphicsState<'_>,
    layout: vk::PipelineLayout,
) -> Result<vk::Pipeline> {
    let modules = shaders.iter().map(|shader| Module::new(context, shader)).collect::<Result<Vec<_>>>()?;
    let special: Vec<_> = shaders.iter().map(|shader| specialization(shader, spec)).collect();
    let infos: Vec<_> = special
        .iter()
        .map(|(entries, data)| vk::SpecializationInfo::default().map_entries(entries).data(data))
        .collect();
    let stages: Vec<_> = (0..shaders.len())
        .map(|index| {
            vk::PipelineShaderStageCreateInfo::default()
                .stage(shaders[index].stage.flags())
                .module(modules[index].module)
                .name(c"main")
                .specialization_info(&infos[index])
        })
        .collect();
    let stride = size_of::<crate::scene::Vertex>() as u32;
    let vertex_bindings =
        [vk::VertexInputBindingDescription { binding: 0, stride, input_rate: vk::VertexInputRate::VERTEX }];
    let attributes: Vec<_> = (0u32..)
        .zip(VERTEX_ATTRIBUTES)
        .map(|(location, (format, offset))| vk::VertexInputAttributeDescription {
            location,
            binding: 0,
            format,
            offset,
        })
        .collect();
    let mut vertex_input = vk::PipelineVertexInputStateCreateInfo::default();
    if state.scene_vertices {
        vertex_input = vertex_input
            .vertex_binding_descriptions(&vertex_bindings)
            .vertex_attribute_descriptions(&attributes);
    }
    let assembly =
        vk::PipelineInputAssemblyStateCreateInfo::default().topology(vk::PrimitiveTopology::TRIANGLE_LIST);
    let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
    let mut raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
    if let Some([constant, slope]) = state.depth_bias {
        raster = raster
            .depth_bias_enable(true)
            .depth_bias_constant_factor(constant)
            .depth_bias_slope_factor(slope);
    }
    let samples =
        vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
    let depth = vk::PipelineDepthStencilStateCreateInfo::default()
        .depth_test_enable(state.depth)
        .depth_write_enable(state.depth_write)
        // Reversed depth: nearer is greater.
        .depth_compare_op(vk::CompareOp::GREATER_OR_EQUAL);
    let blend = vk::PipelineColorBlendAttachmentState::default()
        .color_write_mask(vk::ColorComponentFlags::RGBA)
        .blend_enable(state.blend)
        .src_color_blend_factor(vk::BlendFactor::ONE)
        .dst_color_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
        .src_alpha_blend_factor(vk::BlendFactor::ZERO)
        .dst_alpha_blend_factor(vk::BlendFactor::ONE);
    let blends = vec![blend; state.color_formats.len()];
    let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
    let dynamic = [
        vk::DynamicState::VIEWPORT,
        vk::DynamicState::SCISSOR,
        vk::DynamicState::CULL_MODE,
        vk::DynamicState::FRONT_FACE,
    ];
    let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
    let mut rendering =
        vk::PipelineRenderingCreateInfo::default().color_attachment_formats(state.color_formats);
    if state.depth {
        rendering = rendering.depth_attachment_format(vk::Format::D32_SFLOAT);
    }
    let info = [vk::GraphicsPipelineCreateInfo::default()
        .stages(&stages)
        .vertex_input_state(&vertex_input)
        .input_assembly_state(&assembly)
        .viewport_state(&viewport)
        .rasterization_state(&raster)
        .multisample_state(&samples)
        .depth_stencil_state(&depth)
        .color_blend_state(&blend)
        .dynamic_state(&dynamic)
        .layout(layout)
        .push_next(&mut rendering)];
    // SAFETY: everything that `info` points to is alive.
    let made = unsafe { context.device.create_graphics_pipelines(context.pipeline_cache, &info, None) };
    let what = || format!("building {}", shaders[0].name);
    Ok(Context::check(made.map_err(|(_, code)| code), what)?[0])
}
