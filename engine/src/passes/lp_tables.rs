//! Radii of the LP-buffer's columns and directions of its rows.

use super::{FrameArgs, FrameBuffers, Targets};
use crate::error::Result;
use crate::fovea::FoveaParams;
use crate::gpu::{Bind, ComputePipeline, Context, shaders};
use crate::gpu_layout;
use crate::graph::Pass;
use ash::vk;
use std::sync::Arc;

// Here and not beside the struct: `fovea` is mathematics and knows no GPU.
gpu_layout!(FoveaParams, "FoveaParams" {
    gaze_px, size, size_f, log_reach, octave, kernel, shape, ring, beta_hi, beta_lo,
});

/// The pass.
pub struct LpTables {
    pipeline: ComputePipeline,
    groups: u32,
    context: Arc<Context>,
}

impl LpTables {
    /// Builds it.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(context: &Arc<Context>, targets: &Targets, buffers: &FrameBuffers) -> Result<Self> {
        let pipeline = ComputePipeline::new(
            context,
            &shaders::LP_TABLES_COMP,
            &[],
            &[("Fovea", Bind::PerSlot(&buffers.fovea)), ("LpTables", Bind::Buffer(&targets.tables))],
        )?;
        let groups = (targets.lp_size[0] + targets.lp_size[1]).div_ceil(64);
        Ok(Self { pipeline, groups, context: context.clone() })
    }
}

impl Pass<FrameArgs> for LpTables {
    fn record(&self, commands: vk::CommandBuffer, frame: &FrameArgs) {
        self.pipeline.bind(commands, frame.slot, &());
        // SAFETY: `commands` is being recorded with the pipeline bound.
        unsafe { self.context.device.cmd_dispatch(commands, self.groups, 1, 1) };
    }
}

#[cfg(test)]
mod tests {
    use super::FoveaParams;
    use crate::gpu::reflect::check_layout;
    use crate::gpu::shaders::ALL;

    #[test]
    fn the_mapping_s_block_matches_its_twin_in_glsl() {
        match check_layout::<FoveaParams>(ALL) {
            Ok(compared) => assert!(compared > 5, "only {compared} shaders have it"),
            Err(difference) => panic!("{difference}"),
        }
    }
}
