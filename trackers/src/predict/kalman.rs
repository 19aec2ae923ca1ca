//! A Kalman filter of position and velocity on the tangent plane at the gaze.

use super::{Predictor, horizon_s};
use crate::classify::Phase;
use crate::estimate::EyeState;
use crate::filter::MAX_STEP_NS;
use crate::history::Entry;
use glam::DVec3;

/// Process noise of a [`Kalman`]: the spectral density of a white acceleration, deg^2/s^3. A velocity that
/// changes by `dv` within `dt` asks for about `dv^2 / dt`. Higher follows faster and smooths less.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KalmanSettings {
    /// Drift of a fixating eye: about 3 deg/s within a second.
    pub fixation: f64,
    /// A target that turns: 20 deg/s within 0.1 s.
    pub pursuit: f64,
    /// A saccade's start: 300 deg/s within 20 ms.
    pub saccade: f64,
    /// Least standard deviation of a measurement, deg; the classifier's jitter where that is higher.
    pub least_jitter_deg: f64,
}

impl Default for KalmanSettings {
    fn default() -> Self {
        Self { fixation: 10.0, pursuit: 4e3, saccade: 4.5e6, least_jitter_deg: 0.02 }
    }
}

/// Constant velocity, disturbed by a white acceleration that depends on what the eye does. The two axes of
/// the tangent plane share one covariance, because they have the same noises.
#[derive(Clone, Copy, Debug, Default)]
pub struct Kalman {
    settings: KalmanSettings,
    state: Option<State>,
}

#[derive(Clone, Copy, Debug)]
struct State {
    time_ns: i64,
    gaze: DVec3,
    /// Tangent at `gaze`, deg/s.
    velocity: DVec3,
    /// Covariance of position and velocity: deg^2, deg^2/s, deg^2/s^2.
    variance: [f64; 3],
    kind: EyeState,
}

impl Kalman {
    /// A filter with nothing seen yet.
    #[must_use]
    pub fn new(settings: KalmanSettings) -> Self {
        Self { settings, state: None }
    }
}

/// Variance of the velocity of an eye of which nothing is known but that it rests, deg^2/s^2.
const REST_VARIANCE: f64 = 10.0;

impl State {
    fn moved(&self, seconds: f64) -> DVec3 {
        let step = self.velocity * seconds.to_radians();
        (self.gaze + step).try_normalize().unwrap_or(self.gaze)
    }

    fn advance(&mut self, seconds: f64, density: f64) {
        let [pp, pv, vv] = self.variance;
        let (s, s2) = (seconds, seconds * seconds);
        self.variance = [
            pp + 2.0 * s * pv + s2 * vv + density * s2 * s / 3.0,
            pv + s * vv + density * s2 / 2.0,
            vv + density * s,
        ];
        self.gaze = self.moved(seconds);
        self.velocity -= self.gaze * self.velocity.dot(self.gaze);
    }

    fn correct(&mut self, gaze: DVec3, noise_deg: f64) {
        let [pp, pv, vv] = self.variance;
        let total = pp + noise_deg * noise_deg;
        let (gain, velocity_gain) = (pp / total, pv / total);
        // The innovation on the tangent plane, in degrees of arc.
        let off = gaze - self.gaze;
        let off_deg = (off - self.gaze * off.dot(self.gaze)) * 1f64.to_degrees();
        self.velocity += off_deg * velocity_gain;
        self.gaze = (self.gaze + off_deg * (gain * 1f64.to_radians())).try_normalize().unwrap_or(gaze);
        self.velocity -= self.gaze * self.velocity.dot(self.gaze);
        self.variance = [pp * (1.0 - gain), pv * (1.0 - gain), vv - velocity_gain * pv];
    }
}

impl Predictor for Kalman {
    fn name(&self) -> &'static str {
        "kalman"
    }

    fn push(&mut self, entry: &Entry, phase: &Phase) {
        let gaze = entry.gaze();
        let noise_deg = phase.jitter_deg.max(self.settings.least_jitter_deg);
        let step = self.state.map(|state| (state, entry.time_ns.saturating_sub(state.time_ns)));
        let Some((mut state, step_ns)) = step.filter(|(_, step_ns)| (1..=MAX_STEP_NS).contains(step_ns))
        else {
            let variance = [noise_deg * noise_deg, 0.0, REST_VARIANCE];
            let velocity = DVec3::ZERO;
            self.state = Some(State { time_ns: entry.time_ns, gaze, velocity, variance, kind: phase.state });
            return;
        };
        if state.kind == EyeState::Saccade && phase.state != EyeState::Saccade {
            // The eye has stopped: its velocity in flight says nothing of what follows.
            state.velocity = DVec3::ZERO;
            state.gaze = gaze;
            state.variance = [noise_deg * noise_deg, 0.0, REST_VARIANCE];
        } else {
            let density = match phase.state {
                EyeState::Saccade => self.settings.saccade,
                EyeState::Pursuit => self.settings.pursuit,
                _ => self.settings.fixation,
            };
            state.advance(step_ns as f64 * 1e-9, density);
            state.correct(gaze, noise_deg);
        }
        state.time_ns = entry.time_ns;
        state.kind = phase.state;
        self.state = Some(state);
    }

    fn predict(&self, time_ns: i64) -> Option<DVec3> {
        self.state.map(|state| state.moved(horizon_s(state.time_ns, time_ns)))
    }

    fn reset(&mut self) {
        self.state = None;
    }
}
