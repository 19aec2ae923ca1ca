//! Rasterises the surfaces that the eye sees: 16 bytes of surface and 4 of depth a pixel.

use super::{DrawState, FrameArgs, FrameBuffers, Targets, bind_geometry, set_viewport};
use crate::content::{GpuScene, MaterialVariant};
use crate::error::Result;
use crate::gpu::pipeline::{GraphicsState, Spec};
use crate::gpu::{Bind, Context, GraphicsPipeline, shaders};
use crate::graph::Pass;
use ash::vk;
use std::sync::Arc;

/// The pass.
pub struct GBuffer {
    /// One pipeline for each combination of maps that the materials have: a fragment samples no
    /// texture that its material lacks, and only masked materials give up the early depth test.
    pipelines: Vec<(MaterialVariant, GraphicsPipeline)>,
    context: Arc<Context>,
    scene: Arc<GpuScene>,
    targets: Arc<Targets>,
}

impl GBuffer {
    /// Builds it. `spec` says what the scene's materials have beside their maps; `force`: as if every
    /// material had every map.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(
        context: &Arc<Context>,
        scene: &Arc<GpuScene>,
        targets: &Arc<Targets>,
        buffers: &FrameBuffers,
        spec: Spec<'_>,
        force: bool,
    ) -> Result<Self> {
        let opaque = scene.instances.iter().filter(|instance| !instance.blend);
        let mut variants: Vec<_> = opaque.map(|instance| instance.variant).collect();
        variants.sort_unstable();
        variants.dedup();
        let mut pipelines = Vec::with_capacity(variants.len());
        for variant in variants {
            let mut spec = spec.to_vec();
            for (name, value) in variant.spec(force) {
                spec.push((name, value));
            }
            let pipeline = GraphicsPipeline::new(
                context,
                &[&shaders::GBUFFER_VERT, &shaders::GBUFFER_FRAG],
                &spec,
                &GraphicsState {
                    color_formats: &[targets.gbuffer.format],
                    depth: true,
                    depth_write: true,
                    scene_vertices: true,
                    ..GraphicsState::default()
                },
                &[("Frame", Bind::PerSlot(&buffers.frame)), ("footprint", Bind::Image(&targets.footprint))],
            )?;
            pipelines.push((variant, pipeline));
        }
        Ok(Self { pipelines, context: context.clone(), scene: scene.clone(), targets: targets.clone() })
    }

    fn draw(&self, commands: vk::CommandBuffer, frame: &FrameArgs) {
        let scene = &self.scene;
        bind_geometry(scene, commands);
        for (variant, pipeline) in &self.pipelines {
            pipeline.bind(commands, frame.slot);
            let mut state = DrawState::default();
            for &index in &frame.opaque {
                let instance = &scene.instances[index as usize];
                if instance.variant == *variant {
                    state.draw(scene, commands, pipeline, instance, frame.eye, None);
                }
            }
        }
    }
}

impl Pass<FrameArgs> for GBuffer {
    fn record(&self, commands: vk::CommandBuffer, frame: &FrameArgs) {
        // Nothing reads the surface of a pixel without depth, so colour is not cleared.
        let color = [vk::RenderingAttachmentInfo::default()
            .image_view(self.targets.gbuffer.view)
            .image_layout(vk::ImageLayout::GENERAL)
            .load_op(vk::AttachmentLoadOp::DONT_CARE)
            .store_op(vk::AttachmentStoreOp::STORE)];
        let depth = vk::RenderingAttachmentInfo::default()
            .image_view(self.targets.depth.view)
            .image_layout(vk::ImageLayout::GENERAL)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(vk::AttachmentStoreOp::STORE)
            // Reversed depth: 0 is infinitely far.
            .clear_value(vk::ClearValue {
                depth_stencil: vk::ClearDepthStencilValue { depth: 0.0, stencil: 0 },
            });
        let [width, height] = self.targets.gbuffer.size;
        let info = vk::RenderingInfo::default()
            .render_area(vk::Rect2D {
                offset: vk::Offset2D::default(),
                extent: vk::Extent2D { width, height },
            })
            .layer_count(1)
            .color_attachments(&color)
            .depth_attachment(&depth);
        // SAFETY: `commands` is being recorded; the attachments live as long as the pass.
        unsafe {
            self.context.device.cmd_begin_rendering(commands, &info);
            set_viewport(&self.context, commands, self.targets.gbuffer.size);
            self.draw(commands, frame);
            self.context.device.cmd_end_rendering(commands);
        }
    }
}
