//! The LP-buffer's tables: what a texel's place on the display depends on by column and by row, and the
//! way back from the display.

use super::{FrameArgs, FrameBuffers, Targets};
use crate::error::Result;
use crate::fovea::FoveaParams;
use crate::gpu::{Bind, Buffer, ComputePipeline, Context, shaders};
use crate::gpu_layout;
use crate::graph::Pass;
use ash::vk;
use std::sync::Arc;

// Here and not beside the struct: `fovea` is mathematics and knows no GPU.
gpu_layout!(FoveaParams, "FoveaParams" {
    gaze_px, size, size_f, log_reach, octave, kernel, shape, ring, beta_hi, beta_lo, base_px, ray_rows,
    px_rows, edges, table, native_box, native_rect, layer_rect, axes,
});

/// The pass.
pub struct LpTables {
    source: Source,
    targets: Arc<Targets>,
    context: Arc<Context>,
}

enum Source {
    /// The GPU computes radii of columns and directions of rows (KFR).
    Computed { pipeline: ComputePipeline, groups: u32 },
    /// The CPU computed them, one buffer of each table for each frame slot.
    Copied { tables: Vec<CopySource>, forward: Vec<CopySource> },
}

/// A host buffer that lives as long as the frame's buffers, which outlive the passes.
struct CopySource {
    buffer: vk::Buffer,
    size: u64,
}

impl From<&Buffer> for CopySource {
    fn from(buffer: &Buffer) -> Self {
        Self { buffer: buffer.buffer, size: buffer.size }
    }
}

impl LpTables {
    /// Builds the pass that computes the tables of a mapping by kernels.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn computed(context: &Arc<Context>, targets: &Arc<Targets>, buffers: &FrameBuffers) -> Result<Self> {
        let pipeline = ComputePipeline::new(
            context,
            &shaders::LP_TABLES_COMP,
            &[],
            &[("Fovea", Bind::PerSlot(&buffers.fovea)), ("LpTables", Bind::Buffer(&targets.tables))],
        )?;
        let groups = (targets.lp_size[0] + targets.lp_size[1]).div_ceil(64);
        let source = Source::Computed { pipeline, groups };
        Ok(Self { source, targets: targets.clone(), context: context.clone() })
    }

    /// The pass that copies the tables which the CPU computed.
    #[must_use]
    pub fn copied(context: &Arc<Context>, targets: &Arc<Targets>, buffers: &FrameBuffers) -> Self {
        let source = Source::Copied {
            tables: buffers.lp_tables.iter().map(CopySource::from).collect(),
            forward: buffers.forward_tables.iter().map(CopySource::from).collect(),
        };
        Self { source, targets: targets.clone(), context: context.clone() }
    }

    fn copy(&self, commands: vk::CommandBuffer, from: &CopySource, to: &Buffer) {
        let region = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size: from.size.min(to.size) }];
        // SAFETY: `commands` is being recorded outside of rendering; both buffers are alive and at least
        // as long as the region.
        unsafe { self.context.device.cmd_copy_buffer(commands, from.buffer, to.buffer, &region) };
    }
}

impl Pass<FrameArgs> for LpTables {
    fn record(&self, commands: vk::CommandBuffer, frame: &FrameArgs) {
        match &self.source {
            Source::Computed { pipeline, groups } => {
                pipeline.bind(commands, frame.slot, &());
                // SAFETY: `commands` is being recorded with the pipeline bound.
                unsafe { self.context.device.cmd_dispatch(commands, *groups, 1, 1) };
            }
            Source::Copied { tables, forward } => {
                self.copy(commands, &tables[frame.slot], &self.targets.tables);
                self.copy(commands, &forward[frame.slot], &self.targets.forward_table);
            }
        }
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
