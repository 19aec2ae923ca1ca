//! Filters between the raw samples and the estimate. Each says how late it makes the gaze, and the raw
//! direction stays in the history beside the filtered one.

mod one_euro;
mod saccade_aware;

pub use one_euro::{OneEuro, OneEuroSettings};
pub use saccade_aware::{SaccadeAware, SaccadeAwareSettings};

use crate::estimate::EyeState;
use glam::DVec3;
use std::fmt::Debug;

/// Samples further apart than this, ns, have nothing to do with each other: a filter starts anew. Longer
/// keeps smoothing across losses, and then drags the gaze from where it was before them.
pub(crate) const MAX_STEP_NS: i64 = 100_000_000;

/// A filter of directions.
pub trait Filter: Debug + Send {
    /// Takes a direction of length 1 and gives the filtered one, of length 1. Times ascend; `state` is
    /// what the eye does then.
    fn apply(&mut self, time_ns: i64, direction: DVec3, state: EyeState) -> DVec3;

    /// How late the last output is, ns: the group delay at low frequencies with the smoothing that was in
    /// force.
    fn delay_ns(&self) -> i64;

    /// Forgets the past.
    fn reset(&mut self);
}

/// Filters one after the other. Empty, it changes nothing and delays nothing.
#[derive(Debug, Default)]
pub struct FilterChain {
    filters: Vec<Box<dyn Filter>>,
}

impl FilterChain {
    /// A chain in this order.
    #[must_use]
    pub fn new(filters: Vec<Box<dyn Filter>>) -> Self {
        Self { filters }
    }
}

impl Filter for FilterChain {
    fn apply(&mut self, time_ns: i64, direction: DVec3, state: EyeState) -> DVec3 {
        self.filters.iter_mut().fold(direction, |direction, filter| filter.apply(time_ns, direction, state))
    }

    fn delay_ns(&self) -> i64 {
        self.filters.iter().fold(0, |sum: i64, filter| sum.saturating_add(filter.delay_ns()))
    }

    fn reset(&mut self) {
        self.filters.iter_mut().for_each(|filter| filter.reset());
    }
}

/// One step of an exponential low pass of directions with time constant `tau_s`: how much of the way from
/// `from` to `to` is gone, and the direction there. Small angles, so a straight line does for an arc.
fn low_pass(from: DVec3, to: DVec3, step_s: f64, tau_s: f64) -> DVec3 {
    let share = if tau_s > 0.0 { step_s / (step_s + tau_s) } else { 1.0 };
    (from + (to - from) * share).try_normalize().unwrap_or(to)
}

/// Seconds as whole nanoseconds; beyond the range, its end.
fn ns_of(seconds: f64) -> i64 {
    (seconds * 1e9) as i64
}

#[cfg(test)]
mod tests;
