//! Rendering without a window: the engine's own device, pictures read back to the CPU.

pub use crate::content::Content;
pub use crate::gpu::owned::{DeviceReport, FeatureReport, device_reports};
pub use crate::renderer::FrameInput;

use crate::content::GpuContent as SharedContent;
use crate::error::Result;
use crate::fovea::{DisplayGeometry, FoveaParams, Kernel, KfrMapping, LpCoord};
use crate::gpu::pipeline::FRAME_SLOTS;
use crate::gpu::resource::ImageDesc;
use crate::gpu::{Context, Image, owned, submit};
use crate::host::TargetImage;
use crate::passes;
use crate::renderer::{FrameSlot, Renderer};
use crate::settings::RenderSettings;
use crate::stats::{Effects, FrameStats};
use ash::vk;
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
    renderer: Renderer,
    target: Image,
    pool: vk::CommandPool,
    /// In turn, so that a frame can be recorded while the one before is rendered.
    commands: [vk::CommandBuffer; FRAME_SLOTS],
    current: usize,
    /// The current frame is recorded and not yet submitted.
    recorded: bool,
    /// Of the frame on its way, of which there is at most one: frames share their images.
    fence: vk::Fence,
    on_its_way: bool,
    context: Arc<Context>,
}

impl OffscreenRenderer {
    /// Builds pipelines, buffers and the frame graph.
    ///
    /// # Errors
    /// [`crate::Error::Setting`], [`crate::Error::Memory`] and [`crate::Error::Vulkan`].
    pub fn new(device: &HeadlessDevice, content: &GpuContent, settings: &RenderSettings) -> Result<Self> {
        let context = &device.context;
        let format = vk::Format::R8G8B8A8_UNORM;
        let renderer = Renderer::new(context, &content.0, settings, format)?;
        let target = Image::new(
            context,
            &ImageDesc {
                name: "target",
                size: settings.display.size_px,
                layers: 1,
                levels: 1,
                format,
                usage: vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC,
                array_view: false,
            },
        )?;
        submit::submit_and_wait(context, "preparing the target", |commands| {
            submit::to_general(context, commands, &[&target]);
            Ok(())
        })?;
        let mut made = Self {
            renderer,
            target,
            pool: vk::CommandPool::null(),
            commands: [vk::CommandBuffer::null(); FRAME_SLOTS],
            current: 0,
            recorded: false,
            fence: vk::Fence::null(),
            on_its_way: false,
            context: context.clone(),
        };
        made.make_commands()?;
        Ok(made)
    }

    fn make_commands(&mut self) -> Result<()> {
        let pool = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER)
            .queue_family_index(self.context.queue_family);
        let what = || "preparing to record frames".to_owned();
        let device = &self.context.device;
        // SAFETY: the device is alive; the objects are destroyed with `self`.
        unsafe {
            self.pool = Context::check(device.create_command_pool(&pool, None), what)?;
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(self.pool)
                .command_buffer_count(FRAME_SLOTS as u32);
            let commands = Context::check(device.allocate_command_buffers(&info), what)?;
            self.commands.copy_from_slice(&commands);
            self.fence = Context::check(device.create_fence(&vk::FenceCreateInfo::default(), None), what)?;
        }
        Ok(())
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
        if self.recorded {
            // The buffers of the frame that is still on its way are next in turn.
            self.wait()?;
        }
        self.current = (self.current + 1) % FRAME_SLOTS;
        let commands = self.commands[self.current];
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        let target = TargetImage {
            image: self.target.image,
            view: self.target.view,
            entry_layout: vk::ImageLayout::GENERAL,
            exit_layout: vk::ImageLayout::GENERAL,
        };
        let device = &self.context.device;
        // SAFETY: at most one frame is on its way, in the other command buffer: this one is free.
        unsafe {
            Context::check(device.begin_command_buffer(commands, &begin), rendering)?;
            let slot = self.renderer.record_frame(commands, input, &target);
            Context::check(device.end_command_buffer(commands), rendering)?;
            self.recorded = true;
            Ok(slot)
        }
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
        self.wait()?;
        if !std::mem::take(&mut self.recorded) {
            return Ok(());
        }
        let list = [self.commands[self.current]];
        let submits = [vk::SubmitInfo::default().command_buffers(&list)];
        let device = &self.context.device;
        // SAFETY: the command buffer is recorded, and the fence is free.
        let done = unsafe { device.queue_submit(self.context.queue, &submits, self.fence) };
        self.on_its_way = done.is_ok();
        Context::check(done, rendering)
    }

    /// Waits for the submitted frame, if there is one.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`] and [`crate::Error::Vulkan`].
    pub fn wait(&mut self) -> Result<()> {
        if !self.on_its_way {
            return Ok(());
        }
        self.on_its_way = false;
        let fence = [self.fence];
        let device = &self.context.device;
        // SAFETY: the fence is alive.
        let done = unsafe {
            device.wait_for_fences(&fence, true, u64::MAX).and_then(|()| device.reset_fences(&fence))
        };
        Context::check(done, rendering)
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

fn rendering() -> String {
    "rendering a frame".to_owned()
}

fn read_half(context: &Arc<Context>, name: &str, image: &Image) -> Result<Vec<f32>> {
    let bytes = submit::read_image(context, name, image, 8)?;
    Ok(bytes.chunks_exact(2).map(|pair| f16::from_ne_bytes([pair[0], pair[1]]).to_f32()).collect())
}

impl Drop for OffscreenRenderer {
    fn drop(&mut self) {
        // SAFETY: every frame was waited for; after a lost device nothing runs any more.
        unsafe {
            let _ = self.context.device.device_wait_idle();
            self.context.device.destroy_fence(self.fence, None);
            self.context.device.destroy_command_pool(self.pool, None);
        }
    }
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
