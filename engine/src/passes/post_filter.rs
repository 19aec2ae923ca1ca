//! The thesis' foveated Gaussian on the display (Eq. 2.14), one axis after the other.

use super::{FrameArgs, FrameBuffers, Targets, dispatch_8x8};
use crate::error::Result;
use crate::gpu::{Bind, ComputePipeline, Context, Image, shaders};
use crate::graph::{Access, Pass, dependency, record_barrier};
use ash::vk;
use std::sync::Arc;

/// The pass.
pub struct PostFilter {
    along_x: ComputePipeline,
    along_y: ComputePipeline,
    context: Arc<Context>,
    targets: Arc<Targets>,
}

impl PostFilter {
    /// Builds it.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(context: &Arc<Context>, targets: &Arc<Targets>, buffers: &FrameBuffers) -> Result<Self> {
        let build = |source: &Image, filtered: &Image| {
            let binds = [
                ("Fovea", Bind::PerSlot(&buffers.fovea)),
                ("source", Bind::Image(source)),
                ("filtered", Bind::Image(filtered)),
            ];
            ComputePipeline::new(context, &shaders::POST_FILTER_COMP, &[], &binds)
        };
        Ok(Self {
            along_x: build(&targets.hdr, &targets.post_scratch)?,
            along_y: build(&targets.post_scratch, &targets.hdr)?,
            context: context.clone(),
            targets: targets.clone(),
        })
    }
}

impl Pass<FrameArgs> for PostFilter {
    fn record(&self, commands: vk::CommandBuffer, frame: &FrameArgs) {
        let size = self.targets.hdr.size;
        self.along_x.bind(commands, frame.slot, &[1i32, 0]);
        dispatch_8x8(&self.context, commands, size);
        // The second axis reads what the first wrote, and writes what it read.
        let (_, written) = dependency(Default::default(), Access::ComputeWrite);
        if let (Some(barrier), _) = dependency(written, Access::ComputeReadWrite) {
            record_barrier(&self.context, commands, barrier);
        }
        self.along_y.bind(commands, frame.slot, &[0i32, 1]);
        dispatch_8x8(&self.context, commands, size);
    }
}
