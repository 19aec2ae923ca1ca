//! Turns the sample count into the arguments of the indirect dispatch.

use super::{FrameArgs, FrameBuffers, Targets};
use crate::error::Result;
use crate::gpu::{Bind, ComputePipeline, Context, shaders};
use crate::graph::Pass;
use ash::vk;
use std::sync::Arc;

/// The pass.
pub struct LpDispatch {
    pipeline: ComputePipeline,
    context: Arc<Context>,
}

impl LpDispatch {
    /// Builds it.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(context: &Arc<Context>, targets: &Targets, buffers: &FrameBuffers) -> Result<Self> {
        let pipeline = ComputePipeline::new(
            context,
            &shaders::LP_DISPATCH_COMP,
            &[],
            &[
                ("Counts", Bind::Buffer(&targets.counts)),
                ("Indirect", Bind::Buffer(&targets.indirect)),
                ("Stats", Bind::PerSlot(&buffers.stats)),
            ],
        )?;
        Ok(Self { pipeline, context: context.clone() })
    }
}

impl Pass<FrameArgs> for LpDispatch {
    fn record(&self, commands: vk::CommandBuffer, frame: &FrameArgs) {
        self.pipeline.bind(commands, frame.slot, &());
        // SAFETY: `commands` is being recorded with the pipeline bound.
        unsafe { self.context.device.cmd_dispatch(commands, 1, 1, 1) };
    }
}
