//! Support of macula's integration tests: a device with the validation layer on, small scenes made in
//! code, pictures and where the shared data lies.

pub mod brdf;
pub mod cli;
pub mod data;
pub mod scenes;

use glam::{DMat4, DVec2};
use macula::fovea::{DisplayGeometry, Kernel};
use macula::headless::{Content, DeviceOptions, FrameInput, GpuContent, HeadlessDevice, OffscreenRenderer};
use macula::quality::compare;
use macula::scene::Scene;
use macula::scene::environment::Environment;
use macula::settings::{KfrSettings, Method, RenderSettings};
use macula::stats::{Effects, FrameStats};
use std::ops::Deref;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError, TryLockError};

/// What to do about a missing validation layer.
pub const INSTALL_LAYER: &str = "the Vulkan validation layer is not installed; install it (Debian: apt-get install vulkan-validationlayers)";

/// A device of the test binary, for one test at a time. Any message of the validation layer fails the
/// test that holds it.
pub struct Gpu(MutexGuard<'static, HeadlessDevice>);

/// A device of the test binary, with the validation layer on. There are two, made when they are first
/// needed, so that two tests can run at a time. A test holds one at a time.
///
/// # Panics
/// Where no device can be made, or the validation layer is missing.
#[must_use]
pub fn gpu() -> Gpu {
    static DEVICES: [OnceLock<Mutex<HeadlessDevice>>; 2] = [const { OnceLock::new() }; 2];
    static TURN: AtomicUsize = AtomicUsize::new(0);
    let device_of = |slot: &'static OnceLock<Mutex<HeadlessDevice>>| {
        slot.get_or_init(|| {
            let device = HeadlessDevice::new(&DeviceOptions { validation: true }).expect("a Vulkan device");
            assert!(device.validation_messages().is_some(), "{INSTALL_LAYER}");
            Mutex::new(device)
        })
    };
    let free = DEVICES.iter().find_map(|slot| match device_of(slot).try_lock() {
        Ok(device) => Some(device),
        // A failed test leaves the device whole; a lost one fails the others by itself.
        Err(TryLockError::Poisoned(device)) => Some(device.into_inner()),
        Err(TryLockError::WouldBlock) => None,
    });
    let wait = || {
        let turn = TURN.fetch_add(1, Ordering::Relaxed) % DEVICES.len();
        device_of(&DEVICES[turn]).lock().unwrap_or_else(PoisonError::into_inner)
    };
    let gpu = Gpu(free.unwrap_or_else(wait));
    gpu.check();
    gpu
}

impl Gpu {
    /// Fails where the validation layer has said anything so far.
    ///
    /// # Panics
    /// Then.
    pub fn check(&self) {
        assert_eq!(self.0.validation_messages(), Some(0), "messages of the validation layer, see above");
    }
}

impl Deref for Gpu {
    type Target = HeadlessDevice;

    fn deref(&self) -> &HeadlessDevice {
        &self.0
    }
}

impl Drop for Gpu {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            self.check();
        }
    }
}

/// One rendered frame.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Width and height, px.
    pub size: [u32; 2],
    /// Figures.
    pub stats: FrameStats,
    /// Linear radiance, RGBA.
    pub hdr: Vec<f32>,
    /// Tone-mapped and encoded, RGBA.
    pub rgba8: Vec<u8>,
    /// What the plan decided.
    pub effects: Effects,
    /// The frame graph in words.
    pub plan_text: String,
}

impl Frame {
    /// Radiance at a pixel.
    #[must_use]
    pub fn at(&self, x: u32, y: u32) -> [f64; 3] {
        let first = 4 * (y as usize * self.size[0] as usize + x as usize);
        [0, 1, 2].map(|channel| f64::from(self.hdr[first + channel]))
    }

    /// Radiance at the pixel that holds a display position.
    #[must_use]
    pub fn at_px(&self, px: DVec2) -> [f64; 3] {
        self.at(px.x as u32, px.y as u32)
    }

    /// RGB, 8 bits each.
    #[must_use]
    pub fn rgb8(&self) -> Vec<u8> {
        compare::rgb_of_rgba(&self.rgba8)
    }

    /// Names of the passes that ran.
    #[must_use]
    pub fn passes(&self) -> Vec<&'static str> {
        self.stats.passes.iter().map(|pass| pass.name).collect()
    }

    /// Fails where the frame has holes, or values that are not finite.
    ///
    /// # Panics
    /// Then.
    #[track_caller]
    pub fn check_whole(&self, what: &str) {
        assert_eq!(
            (self.stats.non_finite, self.stats.holes),
            (Some(0), Some(0)),
            "{what}: not finite, holes"
        );
        assert!(self.hdr.iter().all(|value| value.is_finite()), "{what}: not finite");
    }
}

/// Peak signal to noise ratio of two frames, dB.
///
/// # Panics
/// Where their sizes differ.
#[must_use]
pub fn psnr(a: &Frame, b: &Frame) -> f64 {
    compare::psnr_db(&a.rgb8(), &b.rgb8()).expect("frames of one size")
}

/// The greatest difference of any 8-bit value.
///
/// # Panics
/// Where their sizes differ.
#[must_use]
pub fn greatest_step(a: &Frame, b: &Frame) -> u8 {
    assert_eq!(a.size, b.size);
    a.rgba8.iter().zip(&b.rgba8).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

/// Kernel foveated rendering with a power kernel; all else as the user study chose it.
#[must_use]
pub fn kfr(sigma: f64, alpha: f64) -> Method {
    kfr_with(sigma, Kernel::Power { alpha })
}

/// Kernel foveated rendering with any kernel.
#[must_use]
pub fn kfr_with(sigma: f64, kernel: Kernel) -> Method {
    Method::Kfr(KfrSettings { sigma, kernel, ..KfrSettings::default() })
}

/// Settings that look for values that are not finite.
#[must_use]
pub fn settings(size: [u32; 2], hfov_deg: f64, method: Method) -> RenderSettings {
    let mut settings = RenderSettings::new(DisplayGeometry::symmetric(size, hfov_deg), method);
    settings.check_finite = true;
    settings
}

/// A frame seen from the origin along `-Z`, with the gaze at the display's centre.
#[must_use]
pub fn ahead(settings: &RenderSettings) -> FrameInput {
    FrameInput { world_from_view: DMat4::IDENTITY, gaze_px: settings.display.center_px() }
}

/// A scene in GPU memory.
///
/// # Panics
/// Where it cannot be uploaded.
#[must_use]
pub fn upload(gpu: &HeadlessDevice, scene: &Scene, environment: Option<&Environment>) -> GpuContent {
    GpuContent::upload(gpu, &Content::Scene { scene, environment }).expect("the scene uploads")
}

/// Renders one frame of uploaded content.
///
/// # Panics
/// Where rendering fails.
#[must_use]
pub fn render_content(
    gpu: &HeadlessDevice,
    content: &GpuContent,
    settings: &RenderSettings,
    input: &FrameInput,
) -> Frame {
    let mut renderer = OffscreenRenderer::new(gpu, content, settings).expect("a renderer");
    next_frame(&mut renderer, settings, input)
}

/// Renders another frame.
///
/// # Panics
/// Where rendering fails.
#[must_use]
pub fn next_frame(renderer: &mut OffscreenRenderer, settings: &RenderSettings, input: &FrameInput) -> Frame {
    let stats = renderer.render(input).expect("a frame");
    Frame {
        size: settings.display.size_px,
        stats,
        hdr: renderer.read_hdr().expect("radiance"),
        rgba8: renderer.read_rgba8().expect("a picture"),
        effects: renderer.effects().clone(),
        plan_text: renderer.plan_text(),
    }
}

/// Renders one frame of a scene.
///
/// # Panics
/// Where rendering fails.
#[must_use]
pub fn render(
    gpu: &HeadlessDevice,
    scene: &Scene,
    environment: Option<&Environment>,
    settings: &RenderSettings,
    input: &FrameInput,
) -> Frame {
    render_content(gpu, &upload(gpu, scene, environment), settings, input)
}
