//! Rasterises the surfaces that the eye sees: 16 bytes of surface and 4 of depth a pixel.

use super::{DrawState, FrameArgs, FrameBuffers, Targets, bind_geometry, set_viewport};
use crate::content::GpuScene;
use crate::error::Result;
use crate::gpu::pipeline::{GraphicsState, Spec};
use crate::gpu::{Bind, Context, GraphicsPipeline, shaders};
use crate::graph::Pass;
use ash::vk;
use std::sync::Arc;

/// Bytes of G-buffer to a pixel, depth included.
pub const BYTES_PER_PX: u32 = 20;

/// The pass.
pub struct GBuffer {
    opaque: GraphicsPipeline,
    /// Drops fragments, so it cannot test depth early; only for what needs it.
    masked: Option<GraphicsPipeline>,
    context: Arc<Context>,
    scene: Arc<GpuScene>,
    targets: Arc<Targets>,
}

impl GBuffer {
    /// Builds it, specialised to what the materials use. `spec` must leave out `HAS_ALPHA_MASK`.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(
        context: &Arc<Context>,
        scene: &Arc<GpuScene>,
        targets: &Arc<Targets>,
        buffers: &FrameBuffers,
        spec: Spec<'_>,
        masked: bool,
    ) -> Result<Self> {
        let build = |mask: u32| {
            let mut spec = spec.to_vec();
            spec.push(("HAS_ALPHA_MASK", mask));
            GraphicsPipeline::new(
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
                &[
                    ("Frame", Bind::PerSlot(&buffers.frame)),
                    ("Instances", Bind::PerSlot(&buffers.instances)),
                    ("Materials", Bind::Buffer(scene.material_buffer())),
                ],
            )
        };
        Ok(Self {
            opaque: build(0)?,
            masked: masked.then(|| build(1)).transpose()?,
            context: context.clone(),
            scene: scene.clone(),
            targets: targets.clone(),
        })
    }

    fn draw(&self, commands: vk::CommandBuffer, frame: &FrameArgs) {
        let scene = &self.scene;
        bind_geometry(scene, commands);
        for (pipeline, masked) in [(Some(&self.opaque), false), (self.masked.as_ref(), true)] {
            let Some(pipeline) = pipeline else { continue };
            pipeline.bind(commands, frame.slot);
            let mut state = DrawState::default();
            for &index in &frame.opaque {
                if scene.instances[index as usize].masked == masked {
                    state.draw(scene, commands, pipeline, index, true);
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
            .clear_value(vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth: 0.0, stencil: 0 } });
        let [width, height] = self.targets.gbuffer.size;
        let info = vk::RenderingInfo::default()
            .render_area(vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width, height } })
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
