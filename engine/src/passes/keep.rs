//! Keeps the shaded picture for the other eye, where later passes draw over it.

use super::{FrameArgs, Targets};
use crate::gpu::Context;
use crate::graph::Pass;
use ash::vk;
use std::sync::Arc;

/// The pass.
pub struct Keep {
    context: Arc<Context>,
    targets: Arc<Targets>,
}

impl Keep {
    /// For targets that have room for it.
    #[must_use]
    pub fn new(context: &Arc<Context>, targets: &Arc<Targets>) -> Self {
        Self { context: context.clone(), targets: targets.clone() }
    }
}

impl Pass<FrameArgs> for Keep {
    fn record(&self, commands: vk::CommandBuffer, _frame: &FrameArgs) {
        let layers = vk::ImageSubresourceLayers {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            mip_level: 0,
            base_array_layer: 0,
            layer_count: 1,
        };
        let [width, height] = self.targets.hdr.size;
        let region = [vk::ImageCopy::default()
            .src_subresource(layers)
            .dst_subresource(layers)
            .extent(vk::Extent3D { width, height, depth: 1 })];
        let general = vk::ImageLayout::GENERAL;
        let (from, to) = (self.targets.hdr.image, self.targets.kept.image);
        // SAFETY: `commands` is being recorded outside of rendering; both images are alive, in GENERAL
        // layout and of one size and format.
        unsafe { self.context.device.cmd_copy_image(commands, from, general, to, general, &region) };
    }
}
