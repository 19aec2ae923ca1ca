//! The two predictors that everything else is measured against.

use super::{Predictor, along, horizon_s};
use crate::classify::{Phase, Velocity};
use crate::history::Entry;
use glam::DVec3;

/// The last sample, as the filters left it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hold {
    gaze: Option<DVec3>,
}

impl Predictor for Hold {
    fn name(&self) -> &'static str {
        "hold"
    }

    fn push(&mut self, entry: &Entry, _phase: &Phase) {
        self.gaze = Some(entry.smoothed_gaze());
    }

    fn predict(&self, _time_ns: i64) -> Option<DVec3> {
        self.gaze
    }

    fn reset(&mut self) {
        self.gaze = None;
    }
}

/// On along the great circle of the velocity over the classifier's window.
#[derive(Clone, Copy, Debug, Default)]
pub struct ConstantVelocity {
    last: Option<(i64, DVec3, Velocity)>,
}

impl Predictor for ConstantVelocity {
    fn name(&self) -> &'static str {
        "constant-velocity"
    }

    fn push(&mut self, entry: &Entry, phase: &Phase) {
        self.last = Some((entry.time_ns, entry.smoothed_gaze(), phase.velocity));
    }

    fn predict(&self, time_ns: i64) -> Option<DVec3> {
        self.last.map(|(from_ns, gaze, velocity)| along(gaze, velocity, horizon_s(from_ns, time_ns)))
    }

    fn reset(&mut self) {
        self.last = None;
    }
}
