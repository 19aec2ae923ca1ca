//! Lists the samples that a foveated frame shades: LP texels that land on the display and the pixels
//! of the native disc.

use super::{FrameArgs, FrameBuffers, Targets, dispatch_8x8};
use crate::error::Result;
use crate::gpu::pipeline::Spec;
use crate::gpu::{Bind, Buffer, ComputePipeline, Context, shaders};
use crate::graph::Pass;
use ash::vk;
use std::sync::Arc;

/// What the right eye reads of the left one, whose frame is recorded before it.
pub struct LeftEye<'a> {
    /// The left eye's G-buffer, depth and picture.
    pub targets: &'a Targets,
    /// What the CPU writes of the left eye.
    pub buffers: &'a FrameBuffers,
    /// [`crate::gpu::structs::ReuseParams`], for each frame slot.
    pub params: &'a [Buffer],
}

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
    /// (`LP_FILTERED`). With a left eye, samples that it has are stored at once and not listed.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn new(
        context: &Arc<Context>,
        targets: &Arc<Targets>,
        buffers: &FrameBuffers,
        spec: Spec<'_>,
        left: Option<&LeftEye<'_>>,
    ) -> Result<Self> {
        let mut binds = vec![
            ("Fovea", Bind::PerSlot(&buffers.fovea)),
            ("SampleList", Bind::Buffer(&targets.samples)),
            ("Counts", Bind::Buffer(&targets.counts)),
            ("LpTables", Bind::Buffer(&targets.tables)),
            ("ForwardTable", Bind::Buffer(&targets.forward_table)),
            ("lp", Bind::Image(&targets.lp)),
            ("lp_filtered", Bind::Image(&targets.lp_filtered)),
        ];
        let shader = match left {
            None => &shaders::LP_CLASSIFY_COMP,
            Some(left) => {
                binds.extend([
                    ("Frame", Bind::PerSlot(&buffers.frame)),
                    ("LeftFrame", Bind::PerSlot(&left.buffers.frame)),
                    ("LeftFovea", Bind::PerSlot(&left.buffers.fovea)),
                    ("Reuse", Bind::PerSlot(left.params)),
                    ("gbuffer", Bind::Image(&targets.gbuffer)),
                    ("depth_buffer", Bind::Image(&targets.depth)),
                    ("left_gbuffer", Bind::Image(&left.targets.gbuffer)),
                    ("left_depth", Bind::Image(&left.targets.depth)),
                    ("left_radiance", Bind::Image(left.targets.shaded())),
                    ("hdr", Bind::Image(&targets.hdr)),
                ]);
                &shaders::LP_CLASSIFY_REUSE_COMP
            }
        };
        let pipeline = ComputePipeline::new(context, shader, spec, &binds)?;
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
