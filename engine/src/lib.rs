//! `macula`: foveated rendering on raw Vulkan. Shades where the eye looks, cheaply elsewhere.

pub mod error;
pub mod fovea;
pub mod gpu;
pub mod graph;
pub mod headless;
pub mod host;
pub mod io;
pub mod quality;
pub mod scene;
pub mod settings;
pub mod stats;

pub use error::{Error, Result};
