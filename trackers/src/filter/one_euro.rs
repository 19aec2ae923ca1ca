//! The One-Euro filter of Casiez, Roussel and Vogel (CHI 2012), on directions.

use super::{Filter, MAX_STEP_NS, low_pass, ns_of};
use crate::estimate::EyeState;
use glam::DVec3;
use std::f64::consts::TAU;

/// How a [`OneEuro`] smooths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneEuroSettings {
    /// Cut-off of a gaze at rest, Hz. Lower: less jitter, more delay. 3 Hz brings the jitter of a headset
    /// (0.1 deg from sample to sample) below what a fovea of degrees shows.
    pub min_cutoff_hz: f64,
    /// What each deg/s of speed adds to the cut-off, Hz. Higher: less lag in movement, more jitter in it.
    /// At 0.5 a saccade of 300 deg/s is passed with a cut-off of 150 Hz, a delay of 1 ms.
    pub beta_hz_per_deg_s: f64,
    /// Cut-off of the speed, Hz. The authors' 1 Hz is for hands; a saccade is over in 50 ms, so that its
    /// speed must be seen within a few milliseconds.
    pub speed_cutoff_hz: f64,
}

impl Default for OneEuroSettings {
    fn default() -> Self {
        Self { min_cutoff_hz: 3.0, beta_hz_per_deg_s: 0.5, speed_cutoff_hz: 20.0 }
    }
}

/// A low pass whose cut-off grows with the speed. The direction moves on the tangent plane at the last
/// output, and the speed is a vector there, so that jitter does not count as movement.
#[derive(Clone, Copy, Debug, Default)]
pub struct OneEuro {
    settings: OneEuroSettings,
    last: Option<Last>,
    delay_ns: i64,
}

#[derive(Clone, Copy, Debug)]
struct Last {
    time_ns: i64,
    raw: DVec3,
    output: DVec3,
    velocity_rad_s: DVec3,
}

impl OneEuro {
    /// A filter with nothing seen yet.
    #[must_use]
    pub fn new(settings: OneEuroSettings) -> Self {
        Self { settings, last: None, delay_ns: 0 }
    }
}

impl Filter for OneEuro {
    fn apply(&mut self, time_ns: i64, direction: DVec3, _state: EyeState) -> DVec3 {
        let step = self.last.map(|last| (last, time_ns.saturating_sub(last.time_ns)));
        let Some((last, step_ns)) = step.filter(|(_, step_ns)| (1..=MAX_STEP_NS).contains(step_ns)) else {
            self.last =
                Some(Last { time_ns, raw: direction, output: direction, velocity_rad_s: DVec3::ZERO });
            self.delay_ns = 0;
            return direction;
        };
        let step_s = step_ns as f64 * 1e-9;
        let tau_s = |cutoff_hz: f64| 1.0 / (TAU * cutoff_hz.max(1e-6));
        let velocity = (direction - last.raw) / step_s;
        let share = step_s / (step_s + tau_s(self.settings.speed_cutoff_hz));
        let velocity_rad_s = last.velocity_rad_s + (velocity - last.velocity_rad_s) * share;
        let speed_deg_s = velocity_rad_s.length().to_degrees();
        let cutoff_hz = self.settings.min_cutoff_hz + self.settings.beta_hz_per_deg_s * speed_deg_s;
        let output = low_pass(last.output, direction, step_s, tau_s(cutoff_hz));
        self.delay_ns = ns_of(tau_s(cutoff_hz));
        self.last = Some(Last { time_ns, raw: direction, output, velocity_rad_s });
        output
    }

    fn delay_ns(&self) -> i64 {
        self.delay_ns
    }

    fn reset(&mut self) {
        *self = Self::new(self.settings);
    }
}
