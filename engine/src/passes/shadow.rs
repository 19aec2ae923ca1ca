//! Shadow maps: depth from each shadowed light.

use super::{DrawState, FrameArgs, FrameBuffers, Targets, bind_geometry, set_viewport};
use crate::content::GpuScene;
use crate::error::Result;
use crate::gpu::pipeline::GraphicsState;
use crate::gpu::{Bind, Context, GraphicsPipeline, shaders};
use crate::graph::Pass;
use ash::vk;
use std::sync::Arc;

/// Layers of the shadow map array: 16 point lights with six views each.
pub const MAX_SHADOW_VIEWS: u32 = 96;

/// Constant and slope-scaled bias, away from the light (depth is reversed, so they are negative).
/// The offset along the normal in the lighting does most of the work; this keeps flat casters that
/// face the light free of noise.
const DEPTH_BIAS: [f32; 2] = [-2.0, -1.5];

/// The pass.
pub struct Shadow {
    opaque: GraphicsPipeline,
    masked: Option<GraphicsPipeline>,
    context: Arc<Context>,
    scene: Arc<GpuScene>,
    targets: Arc<Targets>,
}

impl Shadow {
    /// Builds it.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(
        context: &Arc<Context>,
        scene: &Arc<GpuScene>,
        targets: &Arc<Targets>,
        buffers: &FrameBuffers,
        masked: bool,
    ) -> Result<Self> {
        let state = GraphicsState {
            depth: true,
            depth_write: true,
            depth_bias: Some(DEPTH_BIAS),
            scene_vertices: true,
            ..GraphicsState::default()
        };
        let binds = [("shadow_views", Bind::PerSlot(&buffers.shadow_views))];
        let opaque = GraphicsPipeline::new(context, &[&shaders::SHADOW_VERT], &[], &state, &binds)?;
        let masked = masked
            .then(|| {
                let stages = [&shaders::SHADOW_VERT, &shaders::SHADOW_MASK_FRAG];
                GraphicsPipeline::new(context, &stages, &[], &state, &binds)
            })
            .transpose()?;
        Ok(Self { opaque, masked, context: context.clone(), scene: scene.clone(), targets: targets.clone() })
    }

    fn draw_view(&self, commands: vk::CommandBuffer, frame: &FrameArgs, view: u32) {
        let scene = &self.scene;
        for (pipeline, masked) in [(Some(&self.opaque), false), (self.masked.as_ref(), true)] {
            let Some(pipeline) = pipeline else { continue };
            pipeline.bind(commands, frame.slot);
            let mut state = DrawState::default();
            for instance in &scene.instances {
                // Blended surfaces cast no shadow: there is no one depth at which they stop light.
                if !instance.blend && instance.variant.masked() == masked {
                    state.draw(scene, commands, pipeline, instance, frame.eye, Some(view));
                }
            }
        }
    }
}

impl Pass<FrameArgs> for Shadow {
    fn record(&self, commands: vk::CommandBuffer, frame: &FrameArgs) {
        let [width, height] = self.targets.shadow_maps.size;
        for view in 0..frame.shadow_views {
            let depth = vk::RenderingAttachmentInfo::default()
                .image_view(self.targets.shadow_maps.layer_views[view as usize])
                .image_layout(vk::ImageLayout::GENERAL)
                .load_op(vk::AttachmentLoadOp::CLEAR)
                .store_op(vk::AttachmentStoreOp::STORE)
                .clear_value(vk::ClearValue {
                    depth_stencil: vk::ClearDepthStencilValue { depth: 0.0, stencil: 0 },
                });
            let info = vk::RenderingInfo::default()
                .render_area(vk::Rect2D {
                    offset: vk::Offset2D::default(),
                    extent: vk::Extent2D { width, height },
                })
                .layer_count(1)
                .depth_attachment(&depth);
            // SAFETY: `commands` is being recorded; the layer exists.
            unsafe {
                self.context.device.cmd_begin_rendering(commands, &info);
                set_viewport(&self.context, commands, [width, height]);
                bind_geometry(&self.scene, commands);
                self.draw_view(commands, frame, view);
                self.context.device.cmd_end_rendering(commands);
            }
        }
    }
}
