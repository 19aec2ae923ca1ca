//! Rendering without a window: the engine's own device, pictures read back to the CPU.

mod frames;
mod stereo;

pub use crate::content::Content;
pub use crate::gpu::owned::{DeviceReport, FeatureReport, device_reports};
pub use crate::renderer::{FrameInput, GpuMapping, MappedPoint};
pub use stereo::OffscreenStereo;

use crate::content::GpuContent as SharedContent;
use crate::error::Result;
use crate::fovea::{DisplayGeometry, FoveaParams, Kernel, KfrMapping, LpCoord};
use crate::gpu::resource::ImageDesc;
use crate::gpu::{Context, Image, owned, submit};
use crate::host::TargetImage;
use crate::passes;
use crate::renderer::{FrameSlot, Renderer};
use crate::settings::{LpFilter, RenderSettings};
use crate::stats::{Effects, FrameStats};
use ash::vk;
use frames::Frames;
use glam::DVec2;
use half::f16;
use std::sync::Arc;

/// How to make a device.
#[derive(Clone, Debug, Default)]
pub struct DeviceOptions {
    /// Turn the Vulkan validation layer on, synchronization validation included, where installed.
    pub validation: bool,
}

/// The engine's own Vulkan device.
pub struct HeadlessDevice {
    context: Arc<Context>,
}

impl HeadlessDevice {
    /// Makes a device on the best GPU, or else on a software driver.
    ///
    /// # Errors
    /// [`crate::Error::NoDevice`] where no Vulkan 1.3 driver is found.
    pub fn new(options: &DeviceOptions) -> Result<Self> {
        Ok(Self { context: owned::make_context(options.validation)? })
    }

    /// The device's name.
    #[must_use]
    pub fn name(&self) -> &str {
        self.context.name()
    }

    /// The driver's name and version.
    #[must_use]
    pub fn driver(&self) -> &str {
        self.context.driver()
    }

    /// Messages of the validation layer so far; `None` where the layer is off or not installed.
    #[must_use]
    pub fn validation_messages(&self) -> Option<u64> {
        self.context.validation_messages()
    }

    /// Bytes of GPU memory that are in use: of all content and renderers of this device.
    #[must_use]
    pub fn memory_bytes(&self) -> u64 {
        self.context.memory_bytes()
    }

    /// What renderers are built on.
    #[must_use]
    pub fn context(&self) -> &Arc<Context> {
        &self.context
    }
}

/// [`Content`] in GPU memory; several renderers can share it.
pub struct GpuContent(SharedContent);

impl GpuContent {
    /// Uploads.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] and [`crate::Error::Vulkan`].
    pub fn upload(device: &HeadlessDevice, content: &Content<'_>) -> Result<Self> {
        SharedContent::upload(&device.context, content).map(Self)
    }
}

/// Renders frames of one content with one set of settings.
pub struct OffscreenRenderer {
    // Waits for the GPU before what it uses goes.
    frames: Frames,
    renderer: Renderer,
    target: Image,
    context: Arc<Context>,
}

/// Of the pictures that are read back.
const FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;

impl OffscreenRenderer {
    /// Builds pipelines, buffers and the frame graph.
    ///
    /// # Errors
    /// [`crate::Error::Setting`], [`crate::Error::Memory`] and [`crate::Error::Vulkan`].
    pub fn new(device: &HeadlessDevice, content: &GpuContent, settings: &RenderSettings) -> Result<Self> {
        let context = &device.context;
        let renderer = Renderer::new(context, &content.0, settings, FORMAT)?;
        let target = make_target(context, settings.display.size_px)?;
        Ok(Self { frames: Frames::new(context)?, renderer, target, context: context.clone() })
    }

    /// Renders one frame and waits for it.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`] and [`crate::Error::Vulkan`].
    pub fn render(&mut self, input: &FrameInput) -> Result<FrameStats> {
        let slot = self.submit(input)?;
        self.read_stats(slot)
    }

    /// Renders one frame and waits for it, without reading its figures: allocates nothing.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`] and [`crate::Error::Vulkan`].
    pub fn submit(&mut self, input: &FrameInput) -> Result<FrameSlot> {
        let slot = self.record(input)?;
        self.launch()?;
        self.wait()?;
        Ok(slot)
    }

    /// Records a frame, while the frame before may still be rendered. Its gaze can be replaced by
    /// [`Self::late_latch`] until [`Self::launch`]. A frame that was recorded and not launched is dropped.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`] and [`crate::Error::Vulkan`].
    pub fn record(&mut self, input: &FrameInput) -> Result<FrameSlot> {
        let target = target_of(&self.target);
        self.frames.record(|commands| self.renderer.record_frame(commands, input, &target))
    }

    /// [`Renderer::late_latch`].
    pub fn late_latch(&mut self, frame: FrameSlot, gaze_px: DVec2) {
        self.renderer.late_latch(frame, gaze_px);
    }

    /// Submits the recorded frame, if there is one. Waits for the one before, if that is still on its way.
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
    pub fn read_stats(&mut self, frame: FrameSlot) -> Result<FrameStats> {
        self.renderer.read_stats(frame)
    }

    /// What the effect plan decided for the last frame.
    #[must_use]
    pub fn effects(&self) -> &Effects {
        self.renderer.effects()
    }

    /// The frame graph in words: resources, passes in order, every barrier.
    #[must_use]
    pub fn plan_text(&self) -> String {
        self.renderer.plan_text()
    }

    /// The last picture, tone-mapped and sRGB-encoded: `4 * width * height` bytes, alpha 255.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn read_rgba8(&mut self) -> Result<Vec<u8>> {
        submit::read_image(&self.context, "the picture", &self.target, 4)
    }

    /// The last picture as linear radiance: `4 * width * height` values, alpha 1.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn read_hdr(&mut self) -> Result<Vec<f32>> {
        read_half(&self.context, "the radiance", &self.renderer.targets().hdr)
    }

    /// The last LP-buffer (width, height, linear RGBA; alpha 0 where a texel was not shaded), or
    /// `None` for full shading.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn read_lp(&mut self) -> Result<Option<(u32, u32, Vec<f32>)>> {
        if !self.renderer.settings().foveated() {
            return Ok(None);
        }
        let image = &self.renderer.targets().lp;
        let [width, height] = image.size;
        Ok(Some((width, height, read_half(&self.context, "the LP-buffer", image)?)))
    }

    /// The last LP-buffer after its filter, like [`Self::read_lp`]; `None` where no filter runs. Columns
    /// that the filter leaves out are undefined.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn read_lp_filtered(&mut self) -> Result<Option<(u32, u32, Vec<f32>)>> {
        if self.renderer.settings().method.lp_filter() == LpFilter::None {
            return Ok(None);
        }
        let image = &self.renderer.targets().lp_filtered;
        let [width, height] = image.size;
        Ok(Some((width, height, read_half(&self.context, "the filtered LP-buffer", image)?)))
    }

    /// Of the last frame, by how many mip levels the samples are coarser than pixels: one number for each
    /// tile of 8x8 px, the last ones of a row or column smaller (width, height, levels). `None` where maps
    /// are not sampled by footprints.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`].
    pub fn read_footprint(&mut self) -> Result<Option<(u32, u32, Vec<f32>)>> {
        if !self.renderer.maps_by_footprint() {
            return Ok(None);
        }
        let image = &self.renderer.targets().footprint;
        let bytes = submit::read_image(&self.context, "the footprints", image, 4)?;
        let [width, height] = image.size;
        Ok(Some((width, height, bytemuck::pod_collect_to_vec(&bytes))))
    }
}

/// A picture to draw into and to read back, in GENERAL layout.
fn make_target(context: &Arc<Context>, size: [u32; 2]) -> Result<Image> {
    let target = Image::new(
        context,
        &ImageDesc {
            name: "target",
            size,
            layers: 1,
            levels: 1,
            format: FORMAT,
            usage: vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC,
            array_view: false,
        },
    )?;
    submit::submit_and_wait(context, "preparing the target", |commands| {
        submit::to_general(context, commands, &[&target]);
        Ok(())
    })?;
    Ok(target)
}

fn target_of(image: &Image) -> TargetImage {
    TargetImage {
        image: image.image,
        view: image.view,
        entry_layout: vk::ImageLayout::GENERAL,
        exit_layout: vk::ImageLayout::GENERAL,
    }
}

fn read_half(context: &Arc<Context>, name: &str, image: &Image) -> Result<Vec<f32>> {
    let bytes = submit::read_image(context, name, image, 8)?;
    Ok(bytes.chunks_exact(2).map(|pair| f16::from_ne_bytes([pair[0], pair[1]]).to_f32()).collect())
}

/// The mapping's coordinates of display points, computed on the GPU by the function that the
/// passes use.
///
/// # Errors
/// [`crate::Error::Vulkan`].
pub fn map_points_on_gpu(
    device: &HeadlessDevice,
    display: &DisplayGeometry,
    gaze_px: DVec2,
    kernel: &Kernel,
    points_px: &[DVec2],
) -> Result<Vec<LpCoord>> {
    // The normalised coordinates do not depend on the LP-buffer's size.
    let mapping = KfrMapping::new(display.size_px, gaze_px, *kernel, 1.0);
    passes::map_points(&device.context, &FoveaParams::new(&mapping), points_px)
}
