//! Rendering without a window: the engine's own device, pictures read back to the CPU.

use crate::error::{Error, Result};
use crate::fovea::{DisplayGeometry, Kernel, LpCoord};
use crate::scene::Scene;
use crate::scene::environment::Environment;
use crate::settings::RenderSettings;
use crate::stats::{Effects, FrameStats};
use glam::{DMat4, DVec2};

/// How to make a device.
#[derive(Clone, Debug, Default)]
pub struct DeviceOptions {
    /// Turn the Vulkan validation layer on, synchronization validation included, where installed.
    pub validation: bool,
}

/// The engine's own Vulkan device.
pub struct HeadlessDevice;

impl HeadlessDevice {
    /// Makes a device on the best GPU, or else on a software driver.
    ///
    /// # Errors
    /// [`Error::NoDevice`] where no Vulkan 1.3 driver is found.
    pub fn new(_options: &DeviceOptions) -> Result<Self> {
        Err(Error::NoDevice("not built yet".into()))
    }

    /// The device's name.
    #[must_use]
    pub fn name(&self) -> &str {
        ""
    }

    /// The driver's name and version.
    #[must_use]
    pub fn driver(&self) -> &str {
        ""
    }

    /// Messages of the validation layer so far; `None` where the layer is off or not installed.
    #[must_use]
    pub fn validation_messages(&self) -> Option<u64> {
        None
    }
}

/// What is rendered.
pub enum Content<'a> {
    /// A triangle scene and what surrounds it.
    Scene {
        /// The scene.
        scene: &'a Scene,
        /// Sky and ambient light.
        environment: Option<&'a Environment>,
    },
    /// The ray-marched scene of signed-distance primitives.
    SdfPrimitives,
}

/// [`Content`] in GPU memory; several renderers can share it.
pub struct GpuContent;

impl GpuContent {
    /// Uploads.
    ///
    /// # Errors
    /// [`Error::Memory`] and [`Error::Vulkan`].
    pub fn upload(_device: &HeadlessDevice, _content: &Content<'_>) -> Result<Self> {
        Err(Error::NoDevice("not built yet".into()))
    }
}

/// What changes from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameInput {
    /// Where the eye stands: right-handed view space, `-Z` forward, no scale.
    pub world_from_view: DMat4,
    /// Gaze in display pixels, x right and y down; off the display is allowed. Not finite: the
    /// last finite one is used (the display's centre before the first), and the statistics say so.
    pub gaze_px: DVec2,
}

/// Renders frames of one content with one set of settings.
pub struct OffscreenRenderer;

impl OffscreenRenderer {
    /// Builds pipelines, buffers and the frame graph.
    ///
    /// # Errors
    /// [`Error::Setting`], [`Error::Memory`] and [`Error::Vulkan`].
    pub fn new(_device: &HeadlessDevice, _content: &GpuContent, _settings: &RenderSettings) -> Result<Self> {
        Err(Error::NoDevice("not built yet".into()))
    }

    /// Renders one frame and waits for it.
    ///
    /// # Errors
    /// [`Error::DeviceLost`] and [`Error::Vulkan`].
    pub fn render(&mut self, _input: &FrameInput) -> Result<FrameStats> {
        Err(Error::NoDevice("not built yet".into()))
    }

    /// What the effect plan decided for the last frame.
    #[must_use]
    pub fn effects(&self) -> &Effects {
        unreachable!()
    }

    /// The frame graph in words: resources, passes in order, every barrier.
    #[must_use]
    pub fn plan_text(&self) -> String {
        String::new()
    }

    /// The last picture, tone-mapped and sRGB-encoded: `4 * width * height` bytes, alpha 255.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn read_rgba8(&mut self) -> Result<Vec<u8>> {
        Err(Error::NoDevice("not built yet".into()))
    }

    /// The last picture as linear radiance: `4 * width * height` values, alpha 1.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn read_hdr(&mut self) -> Result<Vec<f32>> {
        Err(Error::NoDevice("not built yet".into()))
    }

    /// The last LP-buffer (width, height, linear RGBA; alpha 0 where a texel was not shaded), or
    /// `None` for full shading.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn read_lp(&mut self) -> Result<Option<(u32, u32, Vec<f32>)>> {
        Err(Error::NoDevice("not built yet".into()))
    }
}

/// The mapping's coordinates of display points, computed on the GPU by the function that the
/// passes use.
///
/// # Errors
/// [`Error::Vulkan`].
pub fn map_points_on_gpu(
    _device: &HeadlessDevice,
    _display: &DisplayGeometry,
    _gaze_px: DVec2,
    _kernel: &Kernel,
    _points_px: &[DVec2],
) -> Result<Vec<LpCoord>> {
    Err(Error::NoDevice("not built yet".into()))
}
