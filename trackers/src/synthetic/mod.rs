//! An eye that behaves like one, for those who have no tracker, and for tests that need to know the truth.
//!
//! Two layers. [`EyeModel`] is the true eye: what it does follows from the settings and a seed, in
//! continuous time and at any sampling rate alike. [`SyntheticTracker`] is what a tracker makes of it:
//! errors by eccentricity, noise, lost eyes, latency, its own clock. [`SyntheticEye`] puts both behind
//! [`crate::source::GazeSource`], and records with the truth beside the samples.
//!
//! Sizes and times come from hand-labelled and published recordings; each setting says which. Times of
//! the eye start at 0 and may be anything that an `i64` of nanoseconds holds.

mod blink;
mod build;
mod eye;
mod fixation;
mod geometry;
mod head;
mod plan;
mod presets;
mod pursuit;
mod random;
mod saccade;
mod scene;
mod settings;
mod source;
#[cfg(test)]
mod tests;
mod tracker;
mod truth;

pub use eye::{EyeModel, TrueEye};
pub use presets::{PRESETS, TRACKERS};
pub use settings::{
    BlinkSettings, EyesSettings, FixationSettings, HeadSettings, Plan, SaccadeSettings, SceneSettings,
    SyntheticSettings, TrackerSettings,
};
pub use source::SyntheticEye;
pub use tracker::SyntheticTracker;
pub use truth::{DIRECTION_COLUMNS, TRUTH_COLUMN, Truth, TruthEvent, TruthKind};
