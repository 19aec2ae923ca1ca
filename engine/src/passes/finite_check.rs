//! Counts NaN, infinities and texels that nothing has written. Diagnostic: not part of a frame's time.

use super::{FrameArgs, FrameBuffers, Targets, dispatch_8x8};
use crate::error::Result;
use crate::gpu::{Bind, ComputePipeline, Context, Image, shaders};
use crate::graph::Pass;
use ash::vk;
use std::sync::Arc;

/// Bytes of findings: two counters.
pub const FINDINGS_PER_IMAGE: u64 = 8;

/// The pass.
pub struct FiniteCheck {
    display: ComputePipeline,
    display_size: [u32; 2],
    lp: Option<(ComputePipeline, [u32; 2])>,
    context: Arc<Context>,
}

/// Push constant: every texel should have been written.
const FULL: u32 = 1;
const SPARSE: u32 = 0;

impl FiniteCheck {
    /// Builds it for the display image and, in foveated frames, the LP-buffer.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(
        context: &Arc<Context>,
        targets: &Targets,
        buffers: &FrameBuffers,
        foveated: bool,
    ) -> Result<Self> {
        let build = |image: &Image| {
            let binds = [("image", Bind::Image(image)), ("Findings", Bind::PerSlot(&buffers.findings))];
            ComputePipeline::new(context, &shaders::FINITE_CHECK_COMP, &[], &binds)
        };
        let lp = foveated.then(|| build(&targets.lp).map(|pipeline| (pipeline, targets.lp.size)));
        Ok(Self {
            display: build(&targets.hdr)?,
            display_size: targets.hdr.size,
            lp: lp.transpose()?,
            context: context.clone(),
        })
    }
}

impl Pass<FrameArgs> for FiniteCheck {
    fn record(&self, commands: vk::CommandBuffer, frame: &FrameArgs) {
        self.display.bind(commands, frame.slot, &FULL);
        dispatch_8x8(&self.context, commands, self.display_size);
        if let Some((pipeline, size)) = &self.lp {
            pipeline.bind(commands, frame.slot, &SPARSE);
            dispatch_8x8(&self.context, commands, *size);
        }
    }
}
