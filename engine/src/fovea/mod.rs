//! The mathematics of foveation: where on the display samples go, and how to find them again.
//! Pure functions in double precision, without Vulkan; `shaders/shared/fovea.glsl` is the twin in
//! single precision, and tests hold the two together.

#[cfg(test)]
mod comparators_tests;
mod display;
mod guenter;
mod kernel;
mod kfr;
mod kfr_columns;
mod lafr;
mod mapping;
mod method;
mod params;
mod rmfr;
#[cfg(test)]
mod tests;
mod visual_polar;

pub use display::DisplayGeometry;
pub use guenter::{GuenterLayer, GuenterMapping, GuenterParams};
pub use kernel::{Kernel, MAX_COEFFICIENTS};
pub use kfr::{KfrMapping, LpCoord, LpJacobian};
pub use kfr_columns::KfrColumns;
pub use lafr::{LafrMapping, LafrParams};
pub use mapping::{ColumnLayout, LpPoint, Mapping, Rates, TexelJacobian};
pub use params::{FoveaParams, GazeKeeper, MAX_GAZE_PX};
pub use rmfr::{RmfrMapping, RmfrParams};
pub use visual_polar::{VisualPolarMapping, VisualPolarParams};
