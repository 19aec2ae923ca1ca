//! Following something that moves.

use super::geometry::turn;
use glam::DVec3;

/// Smooth pursuit along a great circle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pursuit {
    /// What the eye turns about, of length 1 and at right angles to the gaze.
    pub(super) axis: DVec3,
    /// Speed of the eye, rad/s.
    pub(super) speed_rad_s: f64,
    /// Time in which the eye takes up speed, s; 0 after a catch-up saccade, when it already follows.
    pub(super) ramp_s: f64,
}

impl Pursuit {
    /// Where the eye looks a time after it began at `from`.
    pub(super) fn at(&self, from: DVec3, since_s: f64) -> DVec3 {
        turn(from, self.axis, self.speed_rad_s * self.way_s(since_s))
    }

    /// The way over the speed: speed rises as `1 - exp(-t / ramp)`.
    fn way_s(&self, since_s: f64) -> f64 {
        if self.ramp_s <= 0.0 {
            return since_s;
        }
        since_s - self.ramp_s * (1.0 - (-since_s / self.ramp_s).exp())
    }
}
