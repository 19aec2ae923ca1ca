//! Gaze for foveated rendering: what an eye tracker, a recording or a synthetic eye says, in the
//! form in which a renderer needs it. This crate knows no Vulkan and no window.
//!
//! Data flows one way: a [`source::GazeSource`] tells [`sample::GazeSample`]s; filters, classification and
//! prediction make a [`GazeEstimate`] of them for the time at which a picture will be displayed: a
//! direction, how sure it is, and how it was made.

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
