//! 3x3 Gaussian in the periphery of the LP-buffer.

use super::{FrameArgs, FrameBuffers, Targets, dispatch_8x8};
use crate::error::Result;
use crate::gpu::{Bind, ComputePipeline, Context, shaders};
use crate::graph::Pass;
use ash::vk;
use std::sync::Arc;

/// The pass.
pub struct LpFilter {
    pipeline: ComputePipeline,
    context: Arc<Context>,
    targets: Arc<Targets>,
}

impl LpFilter {
    /// Builds it.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(context: &Arc<Context>, targets: &Arc<Targets>, buffers: &FrameBuffers) -> Result<Self> {
        let pipeline = ComputePipeline::new(
            context,
            &shaders::LP_FILTER_COMP,
            &[],
            &[
                ("Fovea", Bind::PerSlot(&buffers.fovea)),
                ("lp", Bind::Image(&targets.lp)),
                ("lp_filtered", Bind::Image(&targets.lp_filtered)),
            ],
        )?;
        Ok(Self { pipeline, context: context.clone(), targets: targets.clone() })
    }
}

impl Pass<FrameArgs> for LpFilter {
    fn record(&self, commands: vk::CommandBuffer, frame: &FrameArgs) {
        self.pipeline.bind(commands, frame.slot, &());
        // The first filtered column depends on the gaze, which may still change: the shader knows it.
        dispatch_8x8(&self.context, commands, self.targets.lp_size);
    }
}
