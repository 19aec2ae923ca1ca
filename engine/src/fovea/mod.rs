//! The mathematics of foveation: where on the display samples go, and how to find them again.
//! Pure functions in double precision, without Vulkan; `shaders/shared/fovea.glsl` is the twin in
//! single precision, and tests hold the two together.

mod display;
mod kernel;
mod kfr;
mod params;

pub use display::DisplayGeometry;
pub use kernel::Kernel;
pub use kfr::{KfrMapping, LpCoord};
pub use params::FoveaParams;
