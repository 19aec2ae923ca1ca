//! Both eyes without a window.

use super::frames::Frames;
use super::{FORMAT, GpuContent, HeadlessDevice, make_target, read_half, target_of};
use crate::error::Result;
use crate::gpu::{Context, Image, submit};
use crate::stats::{Effects, FrameStats};
use crate::stereo::{StereoGaze, StereoInput, StereoRenderer, StereoSettings, StereoSlot};
use std::sync::Arc;

/// Renders frames of both eyes of one content with one set of settings. Of pairs the left eye comes first.
pub struct OffscreenStereo {
    // Waits for the GPU before what it uses goes.
    frames: Frames,
    renderer: StereoRenderer,
    targets: [Image; 2],
    context: Arc<Context>,
}

impl OffscreenStereo {
    /// Builds pipelines, buffers and the frame graphs.
    ///
    /// # Errors
    /// As [`StereoRenderer::new`].
    pub fn new(device: &HeadlessDevice, content: &GpuContent, settings: &StereoSettings) -> Result<Self> {
        let context = device.context();
        let renderer = StereoRenderer::new(context, &content.0, settings, FORMAT)?;
        let targets = [
            make_target(context, settings.left.display.size_px)?,
            make_target(context, settings.right.display.size_px)?,
        ];
        Ok(Self { frames: Frames::new(context)?, renderer, targets, context: context.clone() })
    }

    /// Renders one frame and waits for it.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`] and [`crate::Error::Vulkan`].
    pub fn render(&mut self, input: &StereoInput) -> Result<[FrameStats; 2]> {
        let slot = self.record(input)?;
        self.launch()?;
        self.wait()?;
        self.renderer.read_stats(slot)
    }

    /// Records a frame, as [`super::OffscreenRenderer::record`].
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`] and [`crate::Error::Vulkan`].
    pub fn record(&mut self, input: &StereoInput) -> Result<StereoSlot> {
        let targets = [target_of(&self.targets[0]), target_of(&self.targets[1])];
        self.frames.record(|commands| self.renderer.record_frame(commands, input, &targets))
    }

    /// [`StereoRenderer::late_latch`].
    pub fn late_latch(&mut self, frame: StereoSlot, gaze: StereoGaze) {
        self.renderer.late_latch(frame, gaze);
    }

    /// Submits the recorded frame, as [`super::OffscreenRenderer::launch`].
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`] and [`crate::Error::Vulkan`].
    pub fn launch(&mut self) -> Result<()> {
        self.frames.launch()
    }

    /// Waits for the submitted frame, if there is one.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`] and [`crate::Error::Vulkan`].
    pub fn wait(&mut self) -> Result<()> {
        self.frames.wait()
    }

    /// Figures of a frame that was waited for.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn read_stats(&mut self, frame: StereoSlot) -> Result<[FrameStats; 2]> {
        self.renderer.read_stats(frame)
    }

    /// What the effect plan decided for both eyes.
    #[must_use]
    pub fn effects(&self) -> [&Effects; 2] {
        self.renderer.effects()
    }

    /// The eyes' frame graphs in words.
    #[must_use]
    pub fn plan_text(&self) -> String {
        self.renderer.plan_text()
    }

    /// The last pictures, tone-mapped and sRGB-encoded: `4 * width * height` bytes each, alpha 255.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn read_rgba8(&mut self) -> Result<[Vec<u8>; 2]> {
        let read = |image| submit::read_image(&self.context, "the picture", image, 4);
        Ok([read(&self.targets[0])?, read(&self.targets[1])?])
    }

    /// The last pictures as linear radiance: `4 * width * height` values each, alpha 1.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn read_hdr(&mut self) -> Result<[Vec<f32>; 2]> {
        let [left, right] = self.renderer.eyes();
        let read = |image| read_half(&self.context, "the radiance", image);
        Ok([read(&left.targets().hdr)?, read(&right.targets().hdr)?])
    }
}
