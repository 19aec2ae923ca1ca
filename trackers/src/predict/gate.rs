//! The 20 ms gate of "Accelerated Foveated Rendering based on Adaptive Tessellation" (Tiwary, Ramanathan
//! and Kosinka, Eurographics 2020), section 3.

use super::{Predictor, along};
use crate::classify::Phase;
use crate::estimate::EyeState;
use crate::history::Entry;
use glam::DVec3;

/// How a [`Gate20`] works.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GateSettings {
    /// While the eye moves, the prediction is computed once in this time, ns: the paper's shortest
    /// saccade. Longer saves more work and lags more.
    pub gate_ns: i64,
    /// The prediction is this far ahead, ns, along the velocity: again the paper's shortest saccade.
    /// Longer overshoots small saccades, shorter falls short of large ones.
    pub ahead_ns: i64,
    /// A gaze at rest that is further than this, deg, from the last computed one has moved unnoticed, in a
    /// blink or by drift. Lower computes more often, higher lets the fovea lie further off.
    pub rest_deg: f64,
}

impl Default for GateSettings {
    fn default() -> Self {
        Self { gate_ns: 20_000_000, ahead_ns: 20_000_000, rest_deg: 0.5 }
    }
}

/// Computes only while the eye moves, and then at most once in 20 ms: gaze plus velocity times the
/// shortest saccade. In between, and while the eye rests, the prediction stays. The paper has a mouse for an
/// eye, whose every step is a movement; here the eye also counts as moved when it comes to rest and when
/// it rests elsewhere than was computed, else the last guess of a landing would stay for the whole
/// fixation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gate20 {
    settings: GateSettings,
    computed: Option<(i64, DVec3)>,
    moving: bool,
    computations: u64,
}

impl Gate20 {
    /// A gate with nothing seen yet.
    #[must_use]
    pub fn new(settings: GateSettings) -> Self {
        Self { settings, ..Self::default() }
    }

    /// How often the prediction was computed, which is what the gate saves.
    #[must_use]
    pub fn computations(&self) -> u64 {
        self.computations
    }
}

impl Predictor for Gate20 {
    fn name(&self) -> &'static str {
        "gate20"
    }

    fn push(&mut self, entry: &Entry, phase: &Phase) {
        let moving = matches!(phase.state, EyeState::Saccade | EyeState::Pursuit);
        let stopped = self.moving && !moving;
        self.moving = moving;
        let due = self.computed.is_none_or(|(last_ns, computed)| {
            let off_deg = computed.angle_between(entry.smoothed_gaze()).to_degrees();
            let waited = entry.time_ns.saturating_sub(last_ns) >= self.settings.gate_ns;
            waited && (moving || off_deg > self.settings.rest_deg)
        });
        if due || stopped {
            let ahead_s = if moving { self.settings.ahead_ns.max(0) as f64 * 1e-9 } else { 0.0 };
            let gaze = along(entry.smoothed_gaze(), phase.velocity, ahead_s);
            self.computed = Some((entry.time_ns, gaze));
            self.computations += 1;
        }
    }

    fn predict(&self, _time_ns: i64) -> Option<DVec3> {
        self.computed.map(|(_, gaze)| gaze)
    }

    fn reset(&mut self) {
        *self = Self::new(self.settings);
    }
}
