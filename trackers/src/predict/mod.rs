//! Where the eye will look at the time of display. Every predictor sees each usable sample with what the
//! eye does then, and answers for any later time. Directions are of length 1 in the space of
//! [`Entry::gaze`].

mod gate;
mod kalman;
mod landing;
mod simple;

pub use gate::{Gate20, GateSettings};
pub use kalman::{Kalman, KalmanSettings};
pub use landing::{LandingPredictor, LandingSettings};
pub use simple::{ConstantVelocity, Hold};

use crate::classify::{Phase, Velocity};
use crate::history::Entry;
use glam::DVec3;
use std::fmt::Debug;

/// No predictor goes further ahead than this, ns: by then the eye has stopped or turned. Longer lets a
/// velocity carry the gaze off; shorter cuts off long latencies.
pub const MAX_HORIZON_NS: i64 = 100_000_000;

/// Where and when a saccade under way will end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landing {
    /// Gaze after the saccade.
    pub gaze: DVec3,
    /// When it will be there, host clock, ns.
    pub time_ns: i64,
    /// Standard deviation of where, deg.
    pub error_deg: f64,
}

/// Predicts gaze. Allocates nothing after it was made.
pub trait Predictor: Debug + Send {
    /// A short name for reports.
    fn name(&self) -> &'static str;

    /// Takes a sample in which the eye was seen, later than the last, and what the eye does there.
    fn push(&mut self, entry: &Entry, phase: &Phase);

    /// Gaze at a time; for one at or before the last sample, that sample. `None` before the first.
    fn predict(&self, time_ns: i64) -> Option<DVec3>;

    /// Where the saccade under way will end, if the predictor can tell and there is one.
    fn landing(&self) -> Option<Landing> {
        None
    }

    /// Forgets the past.
    fn reset(&mut self);
}

/// The predictors by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PredictorKind {
    /// The last sample.
    Hold,
    /// Straight on.
    ConstantVelocity,
    /// The 20 ms gate.
    Gate20,
    /// Kalman filter of position and velocity.
    Kalman,
    /// Landing point of saccades.
    #[default]
    Landing,
}

impl PredictorKind {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Hold, Self::ConstantVelocity, Self::Gate20, Self::Kalman, Self::Landing];

    /// Makes one with its default settings.
    #[must_use]
    pub fn make(self) -> Box<dyn Predictor> {
        match self {
            Self::Hold => Box::<Hold>::default(),
            Self::ConstantVelocity => Box::<ConstantVelocity>::default(),
            Self::Gate20 => Box::<Gate20>::default(),
            Self::Kalman => Box::<Kalman>::default(),
            Self::Landing => Box::<LandingPredictor>::default(),
        }
    }

    /// The one of this name, as [`Predictor::name`] tells it.
    #[must_use]
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.make().name() == name)
    }
}

/// From `gaze` along the great circle of `velocity` for `seconds`.
fn along(gaze: DVec3, velocity: Velocity, seconds: f64) -> DVec3 {
    let tangent = velocity.deg_s - gaze * velocity.deg_s.dot(gaze);
    let angle = (tangent.length() * seconds).to_radians();
    let Some(side) = tangent.try_normalize() else { return gaze };
    (gaze * angle.cos() + side * angle.sin()).try_normalize().unwrap_or(gaze)
}

/// From `from_ns` to `time_ns`, s, within 0 and [`MAX_HORIZON_NS`].
fn horizon_s(from_ns: i64, time_ns: i64) -> f64 {
    time_ns.saturating_sub(from_ns).clamp(0, MAX_HORIZON_NS) as f64 * 1e-9
}

#[cfg(test)]
mod tests;
