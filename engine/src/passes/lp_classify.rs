//! Lists the samples that a foveated frame shades: LP texels that land on the display and the pixels
//! of the native disc.

use super::{FrameArgs, FrameBuffers, Targets, dispatch_8x8};
use crate::error::Result;
use crate::gpu::pipeline::Spec;
use crate::gpu::{Bind, ComputePipeline, Context, shaders};
use crate::graph::Pass;
use ash::vk;
use std::sync::Arc;

/// The pass.
pub struct LpClassify {
    pipeline: ComputePipeline,
    context: Arc<Context>,
    targets: Arc<Targets>,
}

const MODE_TEXELS: u32 = 0;
const MODE_NATIVE: u32 = 1;

impl LpClassify {
    /// Builds it, specialised to the mapping's kind and to whether a filter over the LP-buffer runs
    /// (`LP_FILTERED`).
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
            &shaders::LP_CLASSIFY_COMP,
            spec,
            &[
                ("Fovea", Bind::PerSlot(&buffers.fovea)),
                ("SampleList", Bind::Buffer(&targets.samples)),
                ("Counts", Bind::Buffer(&targets.counts)),
                ("LpTables", Bind::Buffer(&targets.tables)),
                ("ForwardTable", Bind::Buffer(&targets.forward_table)),
                ("lp", Bind::Image(&targets.lp)),
                ("lp_filtered", Bind::Image(&targets.lp_filtered)),
            ],
        )?;
        Ok(Self { pipeline, context: context.clone(), targets: targets.clone() })
    }
}

impl Pass<FrameArgs> for LpClassify {
    fn record(&self, commands: vk::CommandBuffer, frame: &FrameArgs) {
        // The two dispatches touch the same counters, by atomics only: they need no barrier.
        self.pipeline.bind(commands, frame.slot, &MODE_TEXELS);
        dispatch_8x8(&self.context, commands, self.targets.lp_size);
        self.pipeline.bind(commands, frame.slot, &MODE_NATIVE);
        dispatch_8x8(&self.context, commands, frame.native_box_px);
    }
}
