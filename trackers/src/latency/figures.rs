//! Sums and quantiles.

use super::stage::Stage;
use serde::Serialize;

/// A step between two samples shown that is longer, ns, is a hole and no wait for a sample.
const LONGEST_STEP_NS: i64 = 1_000_000_000;

/// A distribution in a few figures. NaN-free: all are 0 where there are no values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Half of the values are at most this.
    pub p50: f64,
    /// 95 of 100 are at most this.
    pub p95: f64,
    /// The largest.
    pub max: f64,
    /// The mean.
    pub mean: f64,
    /// How many values there are.
    pub count: u64,
}

impl Figures {
    /// Of the finite ones among the values.
    pub fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
        let count = values.len();
        if count == 0 {
            return Self::default();
        }
        let mean = values.iter().sum::<f64>() / count as f64;
        Self {
            p50: quantile(&mut values, 0.5),
            p95: quantile(&mut values, 0.95),
            max: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            mean,
            count: count as u64,
        }
    }
}

/// The smallest of the values that a share of `level` does not exceed (nearest rank); 0 for none. Changes
/// their order.
pub(super) fn quantile(values: &mut [f64], level: f64) -> f64 {
    let Some(last) = values.len().checked_sub(1) else { return 0.0 };
    // Less a hair: 0.98 of 100 must be the 98th although 0.98 * 100 may round up past 98.
    let rank = ((level * values.len() as f64 - 1e-9).ceil().max(1.0) as usize - 1).min(last);
    *values.select_nth_unstable_by(rank, f64::total_cmp).1
}

/// What a run adds up.
#[derive(Clone, Debug, Default)]
pub(super) struct Sums {
    parts_ns: [f64; Stage::ALL.len()],
    frames: u64,
    last_sample_ns: Option<i64>,
    step_ns: f64,
    step_by_latency: f64,
    gain_ns: f64,
    pictures: u64,
}

impl Sums {
    pub(super) fn add(&mut self, parts_ns: &[i64; Stage::ALL.len()], sample_ns: i64, age_ns: i64) {
        for (sum, part) in self.parts_ns.iter_mut().zip(parts_ns) {
            *sum += *part as f64;
        }
        self.frames += 1;
        let step_ns = self.last_sample_ns.map_or(0, |last| sample_ns.saturating_sub(last));
        self.last_sample_ns = Some(sample_ns);
        if (1..=LONGEST_STEP_NS).contains(&step_ns) {
            let step_ns = step_ns as f64;
            // Movements since the sample shown before are first seen now: on average half a step older.
            self.step_by_latency += step_ns * (age_ns as f64 + step_ns * 0.5);
            self.step_ns += step_ns;
        }
    }

    /// A loss: the next step between samples is no wait for a sample.
    pub(super) fn interrupt(&mut self) {
        self.last_sample_ns = None;
    }

    pub(super) fn add_late_latch(&mut self, gain_ns: i64) {
        self.gain_ns += gain_ns as f64;
        self.pictures += 1;
    }

    pub(super) fn stage_ms(&self) -> [f64; Stage::ALL.len()] {
        self.parts_ns.map(|sum| sum * 1e-6 / self.frames.max(1) as f64)
    }

    pub(super) fn eye_to_photon_ms(&self) -> Option<f64> {
        (self.step_ns > 0.0).then(|| self.step_by_latency / self.step_ns * 1e-6)
    }

    pub(super) fn late_latch_gain_ms(&self) -> f64 {
        self.gain_ns * 1e-6 / self.pictures.max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values_by_nearest_rank() {
        let figures = Figures::of((1..=100).rev().map(f64::from).chain([f64::NAN]));
        let expected = Figures { p50: 50.0, p95: 95.0, max: 100.0, mean: 50.5, count: 100 };
        assert_eq!(figures, expected);
        assert_eq!(Figures::of(std::iter::empty()), Figures::default());
        assert_eq!(quantile(&mut [3.0, 1.0, 2.0], 1.0), 3.0);
        assert_eq!(quantile(&mut [3.0, 1.0, 2.0], 0.0), 1.0);
    }
}
