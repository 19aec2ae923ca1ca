//! `macula`: foveated rendering on raw Vulkan. Shades where the eye looks, cheaply elsewhere.

pub mod content;
pub mod error;
pub mod fovea;
pub mod gpu;
pub mod graph;
pub mod headless;
pub mod host;
pub mod io;
pub mod passes;
pub mod plan;
pub mod quality;
pub mod renderer;
pub mod scene;
pub mod settings;
pub mod stats;

pub use error::{Error, Result};
