//! Exposure, tone curve and debug views, into the target.

use super::{FrameArgs, FrameBuffers, Targets, set_viewport};
use crate::error::Result;
use crate::gpu::pipeline::GraphicsState;
use crate::gpu::{Bind, Context, GraphicsPipeline, shaders};
use crate::graph::Pass;
use crate::host::TargetImage;
use crate::settings::{RenderSettings, ToneMap, View};
use ash::vk;
use std::sync::Arc;

/// The pass.
pub struct Output {
    pipeline: GraphicsPipeline,
    context: Arc<Context>,
    size: [u32; 2],
}

/// Formats whose hardware encodes sRGB itself.
fn encodes_srgb(format: vk::Format) -> bool {
    matches!(format, vk::Format::R8G8B8A8_SRGB | vk::Format::B8G8R8A8_SRGB | vk::Format::A8B8G8R8_SRGB_PACK32)
}

impl Output {
    /// Builds it for targets of one format.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(
        context: &Arc<Context>,
        targets: &Targets,
        buffers: &FrameBuffers,
        settings: &RenderSettings,
        format: vk::Format,
    ) -> Result<Self> {
        let tone_map = match settings.tone_map {
            ToneMap::None => 0,
            ToneMap::Aces => 1,
        };
        let view = match settings.view {
            View::Picture => 0,
            View::Density => 1,
            View::Grid => 2,
            View::Gaze => 3,
            View::Rings => 4,
        };
        let pipeline = GraphicsPipeline::new(
            context,
            &[&shaders::OUTPUT_VERT, &shaders::OUTPUT_FRAG],
            &[
                ("TONE_MAP", tone_map),
                ("ENCODE_SRGB", u32::from(!encodes_srgb(format))),
                ("VIEW", view),
                ("FOVEATED", u32::from(settings.foveated())),
            ],
            &GraphicsState { color_formats: &[format], ..GraphicsState::default() },
            &[
                ("Frame", Bind::PerSlot(&buffers.frame)),
                ("Fovea", Bind::PerSlot(&buffers.fovea)),
                ("radiance", Bind::Image(&targets.hdr)),
            ],
        )?;
        Ok(Self { pipeline, context: context.clone(), size: settings.display.size_px })
    }

    /// The target is the host's: it enters and leaves in the layouts that the host declared.
    fn transition(
        &self,
        commands: vk::CommandBuffer,
        target: &TargetImage,
        [from, to]: [vk::ImageLayout; 2],
        [src, dst]: [(vk::PipelineStageFlags2, vk::AccessFlags2); 2],
    ) {
        let barrier = [vk::ImageMemoryBarrier2::default()
            .src_stage_mask(src.0)
            .src_access_mask(src.1)
            .dst_stage_mask(dst.0)
            .dst_access_mask(dst.1)
            .old_layout(from)
            .new_layout(to)
            .image(target.image)
            .subresource_range(vk::ImageSubresourceRange {
                aspect_mask: vk::ImageAspectFlags::COLOR,
                base_mip_level: 0,
                level_count: 1,
                base_array_layer: 0,
                layer_count: 1,
            })];
        let info = vk::DependencyInfo::default().image_memory_barriers(&barrier);
        // SAFETY: `commands` is being recorded, outside of rendering; the host keeps the image alive.
        unsafe { self.context.device.cmd_pipeline_barrier2(commands, &info) };
    }
}

impl Pass<FrameArgs> for Output {
    fn record(&self, commands: vk::CommandBuffer, frame: &FrameArgs) {
        use vk::{AccessFlags2 as A, PipelineStageFlags2 as S};
        let drawn = vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL;
        let target = &frame.target;
        let attachment_write = (S::COLOR_ATTACHMENT_OUTPUT, A::COLOR_ATTACHMENT_WRITE);
        // Waits at the colour output, where hosts let their semaphores wait, and for whatever the host
        // did with the image before.
        let before = (S::ALL_COMMANDS, A::MEMORY_WRITE);
        self.transition(commands, target, [target.entry_layout, drawn], [before, attachment_write]);
        let color = [vk::RenderingAttachmentInfo::default()
            .image_view(target.view)
            .image_layout(drawn)
            .load_op(vk::AttachmentLoadOp::DONT_CARE)
            .store_op(vk::AttachmentStoreOp::STORE)];
        let [width, height] = self.size;
        let info = vk::RenderingInfo::default()
            .render_area(vk::Rect2D {
                offset: vk::Offset2D::default(),
                extent: vk::Extent2D { width, height },
            })
            .layer_count(1)
            .color_attachments(&color);
        // SAFETY: `commands` is being recorded; the target's view lives as long as the host says.
        unsafe {
            let device = &self.context.device;
            device.cmd_begin_rendering(commands, &info);
            set_viewport(&self.context, commands, self.size);
            device.cmd_set_cull_mode(commands, vk::CullModeFlags::NONE);
            device.cmd_set_front_face(commands, vk::FrontFace::COUNTER_CLOCKWISE);
            self.pipeline.bind(commands, frame.slot);
            device.cmd_draw(commands, 3, 1, 0, 0);
            device.cmd_end_rendering(commands);
        }
        let after = (S::ALL_COMMANDS, A::MEMORY_READ | A::MEMORY_WRITE);
        self.transition(commands, target, [drawn, target.exit_layout], [attachment_write, after]);
    }
}
