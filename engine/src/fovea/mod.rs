//! The mathematics of foveation: where on the display samples go, and how to find them again.
//! Pure functions in double precision, without Vulkan; `shaders/shared/fovea.glsl` is the twin in
//! single precision, and tests hold the two together.

mod acuity;
mod display;
mod gaze_frame;
mod kernel;
mod kfr;
mod mapping;
mod params;
mod presets;
mod radial;
#[cfg(test)]
mod tests;
mod vafr;

pub use acuity::AcuityModel;
pub use display::DisplayGeometry;
pub use gaze_frame::GazeFrame;
pub use kernel::{Kernel, MAX_COEFFICIENTS};
pub use kfr::{KfrMapping, LpCoord, LpJacobian};
pub use mapping::{ColumnLayout, LpPoint, Mapping, Rates, TexelJacobian};
pub use params::{FoveaParams, GazeKeeper, MAX_GAZE_PX};
pub use presets::DisplayPreset;
pub use radial::{ColumnRow, FORWARD_KNOTS, ForwardKnot, RadialMapping, fill_columns, fill_forward};
pub use vafr::{NATIVE_BAND, VafrForm, VafrMapping};
