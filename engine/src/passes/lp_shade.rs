//! Shades the listed samples: LP texels into the LP-buffer, native pixels into the display image.

use super::{FrameArgs, FrameBuffers, Targets, shading_binds};
use crate::content::GpuContent;
use crate::error::Result;
use crate::gpu::pipeline::Spec;
use crate::gpu::{Bind, ComputePipeline, Context, shaders};
use crate::graph::Pass;
use ash::vk;
use std::sync::Arc;

/// The pass.
pub struct LpShade {
    pipeline: ComputePipeline,
    context: Arc<Context>,
    targets: Arc<Targets>,
}

impl LpShade {
    /// Builds it, specialised to what the scene has.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(
        context: &Arc<Context>,
        content: &GpuContent,
        targets: &Arc<Targets>,
        buffers: &FrameBuffers,
        spec: Spec<'_>,
    ) -> Result<Self> {
        let mut binds = vec![
            ("Fovea", Bind::PerSlot(&buffers.fovea)),
            ("SampleList", Bind::Buffer(&targets.samples)),
            ("Indirect", Bind::Buffer(&targets.indirect)),
            ("LpTables", Bind::Buffer(&targets.tables)),
            ("lp", Bind::Image(&targets.lp)),
            ("hdr", Bind::Image(&targets.hdr)),
        ];
        binds.extend(shading_binds(content, targets, buffers));
        let shader = match content {
            GpuContent::Scene(_) => &shaders::LP_SHADE_COMP,
            GpuContent::SdfPrimitives => &shaders::LP_SHADE_SDF_COMP,
        };
        let pipeline = ComputePipeline::new(context, shader, spec, &binds)?;
        Ok(Self { pipeline, context: context.clone(), targets: targets.clone() })
    }
}

impl Pass<FrameArgs> for LpShade {
    fn record(&self, commands: vk::CommandBuffer, frame: &FrameArgs) {
        self.pipeline.bind(commands, frame.slot, &());
        // SAFETY: `commands` is being recorded with the pipeline bound; the arguments were written by
        // the pass before.
        unsafe { self.context.device.cmd_dispatch_indirect(commands, self.targets.indirect.buffer, 0) };
    }
}
