//! `macula`: foveated rendering on raw Vulkan. Shades where the eye looks, cheaply elsewhere.
//!
//! # Embedding
//!
//! The host owns instance, device, queue, command buffers and images; the engine borrows them, records
//! into the host's command buffer and leaves the image in the layout that was declared. The device
//! needs [`host::required_features`] and the queue graphics and compute. For rendering without a host
//! of one's own there is [`headless`].
//!
//! ```no_run
//! use ash::vk;
//! use macula::content::{Content, GpuContent};
//! use macula::fovea::DisplayGeometry;
//! use macula::host::{Context, ContextParts, TargetImage};
//! use macula::renderer::{FrameInput, Renderer};
//! use macula::scene::load::{LoadOptions, load};
//! use macula::settings::{KfrSettings, Method, RenderSettings};
//!
//! /// Once: `host` holds the host's instance, device and queue, which outlive the renderer.
//! fn set_up(host: ContextParts, path: &std::path::Path, size_px: [u32; 2]) -> macula::Result<Renderer> {
//!     // SAFETY: as `Context::from_host` asks: the handles belong together and outlive the renderer.
//!     let context = unsafe { Context::from_host(host)? };
//!     let scene = load(path, &LoadOptions::default())?;
//!     let content = Content::Scene { scene: &scene, environment: None };
//!     let content = GpuContent::upload(&context, &content)?;
//!     let display = DisplayGeometry::symmetric(size_px, 100.0);
//!     let settings = RenderSettings::new(display, Method::Kfr(KfrSettings::default()));
//!     Renderer::new(&context, &content, &settings, vk::Format::B8G8R8A8_SRGB)
//! }
//!
//! /// Every frame: records only. The host begins, ends and submits `commands`.
//! fn frame(
//!     renderer: &mut Renderer,
//!     commands: vk::CommandBuffer,
//!     (image, view): (vk::Image, vk::ImageView),
//!     (world_from_view, gaze_px): (glam::DMat4, glam::DVec2),
//! ) {
//!     let target = TargetImage {
//!         image,
//!         view,
//!         entry_layout: vk::ImageLayout::UNDEFINED,
//!         exit_layout: vk::ImageLayout::PRESENT_SRC_KHR,
//!     };
//!     renderer.record_frame(commands, &FrameInput { world_from_view, gaze_px }, &target);
//! }
//! ```

pub mod content;
pub mod error;
pub mod fovea;
pub mod gpu;
pub mod graph;
pub mod headless;
pub mod host;
pub mod io;
pub mod knobs;
pub mod passes;
pub mod plan;
pub mod quality;
pub mod renderer;
pub mod scene;
pub mod settings;
pub mod stats;
pub mod stereo;

pub use error::{Error, Result};
