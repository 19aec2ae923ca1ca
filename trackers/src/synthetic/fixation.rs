//! What the eye does while it fixates: slow drift like a random walk, and tremor. (Microsaccades are
//! movements of the plan.)

use super::random::{Lattice, stream};
use super::settings::FixationSettings;
use glam::DVec2;

/// Octaves of drift, the first with steps of [`SHORTEST_NS`], each next twice as long.
const OCTAVES: usize = 7;
const SHORTEST_NS: i64 = 20_000_000;
/// Lattice step of the tremor: power up to about 90 Hz, as tremor lies at 50 to 100 Hz (Bowers et al. 2019).
const TREMOR_NS: i64 = 5_600_000;
/// Octaves whose variance is `k` times their period have a mean square displacement of about `6 k` times
/// the lag between the shortest and the longest period.
const WALK: f64 = 6.0;

/// Drift and tremor as a function of time.
#[derive(Clone, Debug)]
pub(super) struct FixationalMotion {
    drift: [(Lattice, f64); OCTAVES],
    tremor: (Lattice, f64),
}

impl FixationalMotion {
    pub(super) fn new(settings: &FixationSettings, key: u64) -> Self {
        let drift = std::array::from_fn(|octave| {
            let period_ns = SHORTEST_NS << octave;
            let variance = settings.drift_deg_per_root_s.powi(2) / WALK * period_ns as f64 * 1e-9;
            (Lattice::new(key, stream::DRIFT + octave as u64, period_ns), variance.sqrt())
        });
        let tremor = (Lattice::new(key, stream::TREMOR, TREMOR_NS), settings.tremor_deg);
        Self { drift, tremor }
    }

    /// Displacement to the right and up, degrees.
    pub(super) fn at_deg(&self, time_ns: i64) -> DVec2 {
        let drift: DVec2 = self.drift.iter().map(|(noise, scale)| noise.at(time_ns) * *scale).sum();
        drift + self.tremor.0.at(time_ns) * self.tremor.1
    }
}
