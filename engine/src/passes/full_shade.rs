//! Shades every pixel of the display: the reference.

use super::{FrameArgs, FrameBuffers, Targets, dispatch_8x8, shading_binds};
use crate::content::GpuContent;
use crate::error::Result;
use crate::gpu::pipeline::Spec;
use crate::gpu::{Bind, ComputePipeline, Context, shaders};
use crate::graph::Pass;
use ash::vk;
use std::sync::Arc;

/// The pass.
pub struct FullShade {
    pipeline: ComputePipeline,
    context: Arc<Context>,
    targets: Arc<Targets>,
}

impl FullShade {
    /// Builds it, specialised to what the scene has.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(
        context: &Arc<Context>,
        content: &GpuContent,
        targets: &Arc<Targets>,
        buffers: &FrameBuffers,
        spec: Spec<'_>,
    ) -> Result<Self> {
        let mut binds = vec![("hdr", Bind::Image(&targets.hdr))];
        binds.extend(shading_binds(content, targets, buffers));
        let shader = match content {
            GpuContent::Scene(_) => &shaders::FULL_SHADE_COMP,
            GpuContent::SdfPrimitives => &shaders::FULL_SHADE_SDF_COMP,
        };
        let pipeline = ComputePipeline::new(context, shader, spec, &binds)?;
        Ok(Self { pipeline, context: context.clone(), targets: targets.clone() })
    }
}

impl Pass<FrameArgs> for FullShade {
    fn record(&self, commands: vk::CommandBuffer, frame: &FrameArgs) {
        self.pipeline.bind(commands, frame.slot, &());
        dispatch_8x8(&self.context, commands, self.targets.hdr.size);
    }
}
