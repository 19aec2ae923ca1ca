//! How coarse the samples are at each place of the display, for the G-buffer's maps.

use super::{FrameArgs, FrameBuffers, Targets, dispatch_8x8};
use crate::error::Result;
use crate::gpu::pipeline::Spec;
use crate::gpu::{Bind, ComputePipeline, Context, shaders};
use crate::graph::Pass;
use ash::vk;
use std::sync::Arc;

/// Side of a tile of the display that has one number, px: `FOOTPRINT_TILE_PX` of
/// `shaders/shared/footprint.glsl`.
pub(super) const TILE_PX: u32 = 8;

/// The pass.
pub struct Footprint {
    pipeline: ComputePipeline,
    context: Arc<Context>,
    targets: Arc<Targets>,
}

impl Footprint {
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
            &shaders::FOOTPRINT_COMP,
            spec,
            &[
                ("Fovea", Bind::PerSlot(&buffers.fovea)),
                ("LpTables", Bind::Buffer(&targets.tables)),
                ("ForwardTable", Bind::Buffer(&targets.forward_table)),
                ("footprint", Bind::Image(&targets.footprint)),
            ],
        )?;
        Ok(Self { pipeline, context: context.clone(), targets: targets.clone() })
    }
}

impl Pass<FrameArgs> for Footprint {
    fn record(&self, commands: vk::CommandBuffer, frame: &FrameArgs) {
        self.pipeline.bind(commands, frame.slot, &());
        dispatch_8x8(&self.context, commands, self.targets.footprint.size);
    }
}
