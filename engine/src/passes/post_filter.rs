//! The thesis' foveated Gaussian on the display (Eq. 2.14).

use super::{FrameArgs, FrameBuffers, Targets, dispatch_8x8};
use crate::error::Result;
use crate::gpu::{Bind, ComputePipeline, Context, shaders};
use crate::graph::Pass;
use ash::vk;
use std::sync::Arc;

/// The pass.
pub struct PostFilter {
    pipeline: ComputePipeline,
    context: Arc<Context>,
    targets: Arc<Targets>,
}

impl PostFilter {
    /// Builds it.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(context: &Arc<Context>, targets: &Arc<Targets>, buffers: &FrameBuffers) -> Result<Self> {
        let pipeline = ComputePipeline::new(
            context,
            &shaders::POST_FILTER_COMP,
            &[],
            &[
                ("Fovea", Bind::PerSlot(&buffers.fovea)),
                ("hdr", Bind::Image(&targets.hdr)),
                ("hdr_post", Bind::Image(&targets.hdr_post)),
            ],
        )?;
        Ok(Self { pipeline, context: context.clone(), targets: targets.clone() })
    }
}

impl Pass<FrameArgs> for PostFilter {
    fn record(&self, commands: vk::CommandBuffer, frame: &FrameArgs) {
        self.pipeline.bind(commands, frame.slot, &());
        dispatch_8x8(&self.context, commands, self.targets.hdr.size);
    }
}
