//! Anti-aliasing of the LP-buffer.

use super::{FrameArgs, FrameBuffers, Targets};
use crate::error::Result;
use crate::gpu::pipeline::Spec;
use crate::gpu::{Bind, ComputePipeline, Context, shaders};
use crate::graph::Pass;
use crate::settings;
use ash::vk;
use std::sync::Arc;

/// The pass.
pub struct LpFilter {
    pipeline: ComputePipeline,
    context: Arc<Context>,
    targets: Arc<Targets>,
}

impl LpFilter {
    /// Builds it for one of the filters, specialised to the mapping's kind.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(
        context: &Arc<Context>,
        targets: &Arc<Targets>,
        buffers: &FrameBuffers,
        filter: settings::LpFilter,
        spec: Spec<'_>,
    ) -> Result<Self> {
        let mut binds = vec![
            ("Fovea", Bind::PerSlot(&buffers.fovea)),
            ("LpTables", Bind::Buffer(&targets.tables)),
            ("lp", Bind::Image(&targets.lp)),
            ("SampleList", Bind::Buffer(&targets.samples)),
            ("Indirect", Bind::Buffer(&targets.indirect)),
            ("lp_filtered", Bind::Image(&targets.lp_filtered)),
        ];
        let shader = if filter == settings::LpFilter::Fxaa {
            binds.push(("Frame", Bind::PerSlot(&buffers.frame)));
            &shaders::LP_FILTER_FXAA_COMP
        } else {
            &shaders::LP_FILTER_GAUSSIAN_COMP
        };
        let pipeline = ComputePipeline::new(context, shader, spec, &binds)?;
        Ok(Self { pipeline, context: context.clone(), targets: targets.clone() })
    }
}

impl Pass<FrameArgs> for LpFilter {
    fn record(&self, commands: vk::CommandBuffer, frame: &FrameArgs) {
        self.pipeline.bind(commands, frame.slot, &());
        // Only texels that were shaded: as many workgroups as the list has samples.
        // SAFETY: `commands` is being recorded with the pipeline bound; the buffer holds the three
        // group counts, written by an earlier pass.
        unsafe { self.context.device.cmd_dispatch_indirect(commands, self.targets.indirect.buffer, 0) };
    }
}
