//! The error radius: everything that makes a gaze doubtful makes it larger.

use super::settings::{LossPolicy, RadiusSettings};
use crate::classify::Phase;
use crate::estimate::EyeState;
use crate::predict::MAX_HORIZON_NS;

/// What is doubtful about an estimate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Doubt {
    /// From the sample it comes from to the asked time, ns; not negative.
    pub(super) age_ns: i64,
    /// That sample was of one eye.
    pub(super) one_eye: bool,
    /// What the eye did at that sample.
    pub(super) measured: Phase,
    /// What it is thought to do by now.
    pub(super) now: EyeState,
    /// Standard deviation of the landing point, deg; 0 where none is told.
    pub(super) landing_deg: f64,
    /// From the answer to where the eye most likely is at the asked time, deg.
    pub(super) away_deg: f64,
}

impl Doubt {
    /// The radius, deg. It never falls with age, with one eye instead of two, or with a state that is less
    /// at rest.
    pub(super) fn radius_deg(&self, settings: &RadiusSettings, loss: &LossPolicy) -> f64 {
        let factor = if self.one_eye { settings.one_eye_factor.max(1.0) } else { 1.0 };
        let at_sample = settings.accuracy_deg * factor;
        let jitter = self.measured.jitter_deg * factor;
        let age_s = self.age_ns.max(0) as f64 * 1e-9;
        let speed_deg_s = self.measured.velocity.deg_s.length();
        let moved = match self.measured.state {
            EyeState::Fixation | EyeState::Pursuit => 0.0,
            EyeState::Saccade => speed_deg_s * settings.timing_s,
            // Around a loss no predictor follows the movement.
            _ => speed_deg_s * (settings.timing_s + age_s.min(MAX_HORIZON_NS as f64 * 1e-9)),
        };
        // The faster of what the eye did and what it is thought to do.
        let growth = rate(self.measured.state, settings).max(rate(self.now, settings)) * age_s;
        let late_s = self.age_ns.saturating_sub(loss.hold_ns).max(0) as f64 * 1e-9;
        let parts = [at_sample, jitter, moved, self.landing_deg, self.away_deg, growth];
        let radius = parts.iter().map(|part| part * part).sum::<f64>().sqrt() + settings.widen_deg_s * late_s;
        if radius.is_finite() { radius.clamp(0.0, settings.cap_deg.max(0.0)) } else { settings.cap_deg }
    }
}

fn rate(state: EyeState, settings: &RadiusSettings) -> f64 {
    let rest = settings.rest_deg_s.max(0.0);
    match state {
        EyeState::Fixation => rest,
        EyeState::Pursuit => rest.max(settings.pursuit_deg_s),
        _ => rest.max(settings.pursuit_deg_s).max(settings.moving_deg_s),
    }
}
