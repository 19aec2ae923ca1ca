//! From the LP-buffer to the display.

use super::{FrameArgs, FrameBuffers, Targets, dispatch_8x8};
use crate::error::Result;
use crate::gpu::pipeline::Spec;
use crate::gpu::{Bind, ComputePipeline, Context, shaders};
use crate::graph::Pass;
use ash::vk;
use std::sync::Arc;

/// The pass.
pub struct Inverse {
    pipeline: ComputePipeline,
    context: Arc<Context>,
    targets: Arc<Targets>,
}

impl Inverse {
    /// Builds it, specialised to the mapping's kind and kernel.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(
        context: &Arc<Context>,
        targets: &Arc<Targets>,
        buffers: &FrameBuffers,
        spec: Spec<'_>,
    ) -> Result<Self> {
        let pipeline = ComputePipeline::new(
            context,
            &shaders::INVERSE_COMP,
            spec,
            &[
                ("Fovea", Bind::PerSlot(&buffers.fovea)),
                ("LpTables", Bind::Buffer(&targets.tables)),
                ("ForwardTable", Bind::Buffer(&targets.forward_table)),
                ("lp", Bind::Image(&targets.lp)),
                ("lp_filtered", Bind::Image(&targets.lp_filtered)),
                ("hdr", Bind::Image(&targets.hdr)),
            ],
        )?;
        Ok(Self { pipeline, context: context.clone(), targets: targets.clone() })
    }
}

impl Pass<FrameArgs> for Inverse {
    fn record(&self, commands: vk::CommandBuffer, frame: &FrameArgs) {
        self.pipeline.bind(commands, frame.slot, &());
        dispatch_8x8(&self.context, commands, self.targets.hdr.size);
    }
}
