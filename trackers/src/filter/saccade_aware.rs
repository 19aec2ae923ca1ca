//! Smoothing that lets saccades through untouched.

use super::{Filter, MAX_STEP_NS, low_pass, ns_of};
use crate::estimate::EyeState;
use glam::DVec3;

/// How a [`SaccadeAware`] smooths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SaccadeAwareSettings {
    /// Time constant in a fixation, s. Longer: less jitter, slower after a small saccade that was not
    /// noticed. 50 ms leaves a third of the jitter at 120 Hz.
    pub fixation_tau_s: f64,
    /// Time constant in a pursuit, s; the gaze lags the target by this time its speed.
    pub pursuit_tau_s: f64,
    /// A fixation's smoothing grows to its full strength over this, s. Longer shows more of the
    /// post-saccadic oscillation; shorter holds on to where the eye overshot to.
    pub settle_s: f64,
}

impl Default for SaccadeAwareSettings {
    fn default() -> Self {
        Self { fixation_tau_s: 0.05, pursuit_tau_s: 0.01, settle_s: 0.1 }
    }
}

/// Strong in a fixation, weak in a pursuit, none in a saccade or while the state is unknown.
#[derive(Clone, Copy, Debug, Default)]
pub struct SaccadeAware {
    settings: SaccadeAwareSettings,
    last: Option<(i64, DVec3)>,
    /// When the eye came to rest.
    rest_ns: Option<i64>,
    delay_ns: i64,
}

impl SaccadeAware {
    /// A filter with nothing seen yet.
    #[must_use]
    pub fn new(settings: SaccadeAwareSettings) -> Self {
        Self { settings, ..Self::default() }
    }
}

impl Filter for SaccadeAware {
    fn apply(&mut self, time_ns: i64, direction: DVec3, state: EyeState) -> DVec3 {
        let strongest_s = match state {
            EyeState::Fixation => self.settings.fixation_tau_s,
            EyeState::Pursuit => self.settings.pursuit_tau_s,
            _ => 0.0,
        };
        let step = self.last.map(|(last_ns, output)| (time_ns.saturating_sub(last_ns), output));
        let joined = step.filter(|(step_ns, _)| (1..=MAX_STEP_NS).contains(step_ns) && strongest_s > 0.0);
        let Some((step_ns, before)) = joined else {
            self.rest_ns = None;
            self.delay_ns = 0;
            self.last = Some((time_ns, direction));
            return direction;
        };
        let rest_ns = *self.rest_ns.get_or_insert(time_ns);
        let rested_s = time_ns.saturating_sub(rest_ns) as f64 * 1e-9;
        let tau_s = strongest_s * (rested_s / self.settings.settle_s.max(1e-9)).min(1.0);
        let output = low_pass(before, direction, step_ns as f64 * 1e-9, tau_s);
        self.delay_ns = ns_of(tau_s);
        self.last = Some((time_ns, output));
        output
    }

    fn delay_ns(&self) -> i64 {
        self.delay_ns
    }

    fn reset(&mut self) {
        *self = Self::new(self.settings);
    }
}
