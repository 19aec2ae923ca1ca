//! Gaze for foveated rendering: what an eye tracker, a recording or a synthetic eye says, in the
//! form in which a renderer needs it. This crate knows no Vulkan and no window.
//!
//! Data flows one way: a [`source::GazeSource`] tells [`sample::GazeSample`]s; filters, classification and
//! prediction make a [`GazeEstimate`] of them for the time at which a picture will be displayed: a
//! direction, how sure it is, and how it was made.
//!
//! ```
//! use macula_trackers::estimator::{Estimator, EstimatorSettings};
//! use macula_trackers::source::GazeSource;
//! use macula_trackers::synthetic::{SyntheticEye, SyntheticSettings};
//!
//! # fn main() -> macula_trackers::Result<()> {
//! // A device, a socket or a recording would do as well: each is a `GazeSource`.
//! let mut source = SyntheticEye::new(SyntheticSettings::preset("free-viewing")?, 1)?;
//! let mut estimator = Estimator::new(EstimatorSettings::default());
//! let mut events = Vec::new();
//! let mut with_gaze = 0;
//! for frame in 0..90 {
//!     // A host takes `time::host_now_ns()`.
//!     let now_ns = frame * 11_111_111;
//!     events.clear();
//!     source.poll(now_ns, &mut events)?;
//!     events.iter().for_each(|event| estimator.on_event(event));
//!     // The picture will be displayed in 25 ms.
//!     if let Some(gaze) = estimator.estimate_at(now_ns + 25_000_000) {
//!         assert!(gaze.error_radius_rad > 0.0);
//!         with_gaze += 1;
//!     }
//! }
//! assert!(with_gaze > 80);
//! # Ok(())
//! # }
//! ```

pub mod bids;
pub mod bridge;
pub mod classify;
pub mod error;
mod estimate;
pub mod estimator;
pub mod evaluate;
pub mod filter;
pub mod formats;
pub mod hid;
pub mod history;
pub mod latency;
pub mod predict;
pub mod recording;
pub mod replay;
mod ring;
pub mod sample;
pub mod source;
pub mod stamp;
pub mod synthetic;
#[cfg(test)]
mod testing;
pub mod time;

pub use error::{Error, Result};
pub use estimate::{EstimateKind, EyeState, GazeEstimate};
