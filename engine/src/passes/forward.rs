//! Blended surfaces, farthest first, lit and drawn over the finished picture.

use super::{DrawState, FrameArgs, FrameBuffers, Targets, bind_geometry, lighting_binds, set_viewport};
use crate::content::GpuScene;
use crate::error::Result;
use crate::gpu::pipeline::{GraphicsState, Spec};
use crate::gpu::{Context, GraphicsPipeline, shaders};
use crate::graph::Pass;
use ash::vk;
use std::sync::Arc;

/// The pass.
pub struct Forward {
    pipeline: GraphicsPipeline,
    context: Arc<Context>,
    scene: Arc<GpuScene>,
    targets: Arc<Targets>,
    /// Recorded also in frames without blended surfaces.
    forced: bool,
}

impl Forward {
    /// Builds it, specialised to what the scene has.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(
        context: &Arc<Context>,
        scene: &Arc<GpuScene>,
        targets: &Arc<Targets>,
        buffers: &FrameBuffers,
        spec: Spec<'_>,
        forced: bool,
    ) -> Result<Self> {
        let pipeline = GraphicsPipeline::new(
            context,
            &[&shaders::GBUFFER_VERT, &shaders::FORWARD_FRAG],
            spec,
            &GraphicsState {
                color_formats: &[targets.hdr.format],
                depth: true,
                blend: true,
                scene_vertices: true,
                ..GraphicsState::default()
            },
            &lighting_binds(scene, targets, buffers),
        )?;
        Ok(Self {
            pipeline,
            context: context.clone(),
            scene: scene.clone(),
            targets: targets.clone(),
            forced,
        })
    }
}

impl Pass<FrameArgs> for Forward {
    fn wanted(&self, frame: &FrameArgs) -> bool {
        self.forced || !frame.blended.is_empty()
    }

    fn record(&self, commands: vk::CommandBuffer, frame: &FrameArgs) {
        let attachment = |view: vk::ImageView| {
            vk::RenderingAttachmentInfo::default()
                .image_view(view)
                .image_layout(vk::ImageLayout::GENERAL)
                .load_op(vk::AttachmentLoadOp::LOAD)
        };
        let color = [attachment(self.targets.hdr.view).store_op(vk::AttachmentStoreOp::STORE)];
        let depth = attachment(self.targets.depth.view).store_op(vk::AttachmentStoreOp::NONE);
        let [width, height] = self.targets.hdr.size;
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
            set_viewport(&self.context, commands, self.targets.hdr.size);
            bind_geometry(&self.scene, commands);
            self.pipeline.bind(commands, frame.slot);
            let mut state = DrawState::default();
            for &index in &frame.blended {
                let instance = &self.scene.instances[index as usize];
                state.draw(&self.scene, commands, &self.pipeline, instance, frame.eye, None);
            }
            self.context.device.cmd_end_rendering(commands);
        }
    }
}
