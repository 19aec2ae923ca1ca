//! The mathematics of foveation: where on the display samples go, and how to find them again.
//! Pure functions in double precision, without Vulkan; `shaders/shared/fovea.glsl` and `mapping.glsl`
//! are the twin in single precision, and tests hold the two together.

mod acuity;
mod axes;
#[cfg(test)]
mod comparators_tests;
mod display;
mod gaze_frame;
mod guenter;
mod kernel;
mod kfr;
mod kfr_columns;
mod lafr;
mod limit;
mod mapping;
mod method;
mod params;
mod presets;
mod radial;
mod rmfr;
#[cfg(test)]
mod tests;
mod vafr;
#[cfg(test)]
mod vafr_tests;
mod visual_polar;

pub use acuity::AcuityModel;
pub use axes::{AxesLayer, AxesMapping, axes_knots, axes_table_rows, fill_axes_columns, fill_axes_forward};
pub use display::DisplayGeometry;
pub use gaze_frame::GazeFrame;
pub use guenter::{GuenterLayer, GuenterMapping, GuenterParams};
pub use kernel::{Kernel, MAX_COEFFICIENTS};
pub use kfr::{KfrMapping, LpCoord, LpJacobian};
pub use kfr_columns::KfrColumns;
pub use lafr::{LafrMapping, LafrParams};
pub use limit::sample_limit;
pub use mapping::{ColumnLayout, LpPoint, Mapping, Rates, TexelJacobian};
pub use params::{FoveaParams, GazeKeeper, MAX_GAZE_PX};
pub use presets::DisplayPreset;
pub use radial::{ColumnRow, FORWARD_KNOTS, ForwardKnot, RadialMapping, fill_columns, fill_forward};
pub use rmfr::{RmfrMapping, RmfrParams};
pub use vafr::{NATIVE_BAND, VafrForm, VafrMapping};
pub use visual_polar::{VisualPolarMapping, VisualPolarParams};
