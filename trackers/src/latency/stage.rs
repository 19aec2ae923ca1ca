//! The stages between the eye and the photons, and how long each takes.

use super::random::Random;
use crate::error::{Error, Result};
use serde::Serialize;
use std::sync::Arc;

/// No stage may take longer than this, ms: more is a mistake of units, and it bounds every run.
pub const MOST_STAGE_MS: f64 = 1000.0;
/// The most measured values that one stage holds.
pub const MOST_MEASURED: usize = 1_000_000;

/// A stage, in the order in which a sample goes through them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// The eye camera's exposure. A sample's time is its middle, so half of it adds to the age.
    Exposure,
    /// Sensor read-out and transfer of the eye's picture.
    Readout,
    /// From the eye's picture to a gaze sample.
    TrackerProcessing,
    /// Until the host's bus asks the device.
    Polling,
    /// Until the thread that reads is awake. What waits for an earlier sample waits here.
    Wakeup,
    /// Group delay of the filter on the host.
    FilterDelay,
    /// The sample lies there until the renderer takes its gaze. Simulated.
    SamplingWait,
    /// Recording the frame's commands.
    Cpu,
    /// Rendering.
    Gpu,
    /// What the compositor needs before the refresh.
    Compositor,
    /// Waiting for the GPU to be free and for the refresh. Simulated.
    Pacing,
    /// From the refresh to when the gaze's row is driven.
    Scanout,
    /// From the driven row to the middle of its light.
    Panel,
}

impl Stage {
    /// All, in order.
    pub const ALL: [Self; 13] = [
        Self::Exposure,
        Self::Readout,
        Self::TrackerProcessing,
        Self::Polling,
        Self::Wakeup,
        Self::FilterDelay,
        Self::SamplingWait,
        Self::Cpu,
        Self::Gpu,
        Self::Compositor,
        Self::Pacing,
        Self::Scanout,
        Self::Panel,
    ];

    /// The name in model files, reports and JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Exposure => "exposure",
            Self::Readout => "readout",
            Self::TrackerProcessing => "tracker_processing",
            Self::Polling => "polling",
            Self::Wakeup => "wakeup",
            Self::FilterDelay => "filter_delay",
            Self::SamplingWait => "sampling_wait",
            Self::Cpu => "cpu",
            Self::Gpu => "gpu",
            Self::Compositor => "compositor",
            Self::Pacing => "pacing",
            Self::Scanout => "scanout",
            Self::Panel => "panel",
        }
    }

    /// The waits that come out of the simulation instead of a model's file.
    #[must_use]
    pub fn is_simulated(self) -> bool {
        matches!(self, Self::SamplingWait | Self::Pacing)
    }
}

/// How long something takes, ms. Never negative.
#[derive(Clone, Debug, PartialEq)]
pub enum Delay {
    /// Always the same.
    Constant {
        /// ms.
        ms: f64,
    },
    /// Anything between two bounds, all equally likely.
    Uniform {
        /// ms.
        low_ms: f64,
        /// ms.
        high_ms: f64,
    },
    /// A normal distribution without its part below 0.
    Normal {
        /// Of the whole distribution, before the cut, ms.
        mean_ms: f64,
        /// Of the whole distribution, before the cut, ms.
        sd_ms: f64,
    },
    /// `shift + median exp(sigma z)` with a standard normal `z`: a long tail.
    LogNormal {
        /// ms.
        shift_ms: f64,
        /// Above the shift, ms.
        median_ms: f64,
        /// Of the logarithm.
        sigma: f64,
    },
    /// A least time and an exponential tail.
    Exponential {
        /// ms.
        shift_ms: f64,
        /// Above the shift, ms.
        mean_ms: f64,
    },
    /// Measured values, ms, taken in their order and again from the start: runs of slow frames stay
    /// together.
    Measured(Arc<[f64]>),
}

impl Delay {
    /// Checks the bounds.
    ///
    /// # Errors
    /// [`Error::Setting`] for what is negative, not finite, longer than [`MOST_STAGE_MS`] or empty.
    pub fn check(&self) -> Result<()> {
        let time = |name: &str, ms: f64| {
            if (0.0..=MOST_STAGE_MS).contains(&ms) {
                return Ok(());
            }
            Err(Error::Setting(format!("{name} is {ms}; it must be 0 to {MOST_STAGE_MS} ms")))
        };
        match self {
            Self::Constant { ms } => time("the constant", *ms),
            Self::Uniform { low_ms, high_ms } => {
                time("the lower bound", *low_ms)?;
                time("the upper bound", *high_ms)?;
                if low_ms > high_ms {
                    return Err(Error::Setting(format!(
                        "the lower bound {low_ms} is above the upper bound {high_ms}"
                    )));
                }
                Ok(())
            }
            Self::Normal { mean_ms, sd_ms } => {
                time("the mean", *mean_ms)?;
                time("the standard deviation", *sd_ms)
            }
            Self::LogNormal { shift_ms, median_ms, sigma } => {
                time("the shift", *shift_ms)?;
                time("the median", *median_ms)?;
                if !(0.0..=2.0).contains(sigma) {
                    return Err(Error::Setting(format!("sigma is {sigma}; it must be 0 to 2")));
                }
                Ok(())
            }
            Self::Exponential { shift_ms, mean_ms } => {
                time("the shift", *shift_ms)?;
                time("the mean of the tail", *mean_ms)
            }
            Self::Measured(values) => {
                if values.is_empty() || values.len() > MOST_MEASURED {
                    let count = values.len();
                    return Err(Error::Setting(format!(
                        "there are {count} measured values; give 1 to {MOST_MEASURED}"
                    )));
                }
                values.iter().try_for_each(|ms| time("a measured value", *ms))
            }
        }
    }

    /// The mean, ms. Tails are cut at [`MOST_STAGE_MS`] when drawn, which the mean of a sensible model
    /// does not show.
    #[must_use]
    pub fn mean_ms(&self) -> f64 {
        match self {
            Self::Constant { ms } => *ms,
            Self::Uniform { low_ms, high_ms } => (low_ms + high_ms) * 0.5,
            Self::Normal { mean_ms, sd_ms } => mean_of_cut_normal(*mean_ms, *sd_ms),
            Self::LogNormal { shift_ms, median_ms, sigma } => {
                shift_ms + median_ms * (sigma * sigma * 0.5).exp()
            }
            Self::Exponential { shift_ms, mean_ms } => shift_ms + mean_ms,
            Self::Measured(values) => values.iter().sum::<f64>() / values.len().max(1) as f64,
        }
    }

    /// The time drawn for the `number`th sample or frame, ns.
    pub(super) fn draw_ns(&self, seed: u64, stage: Stage, number: u64) -> i64 {
        let mut random = Random::new(seed, stage as u64, number);
        let ms = match self {
            Self::Constant { ms } => *ms,
            Self::Uniform { low_ms, high_ms } => low_ms + (high_ms - low_ms) * random.unit(),
            // At least half of the distribution lies above 0, as the mean does.
            Self::Normal { mean_ms, sd_ms } => {
                (0..64).map(|_| mean_ms + sd_ms * random.normal()).find(|ms| *ms >= 0.0).unwrap_or(*mean_ms)
            }
            Self::LogNormal { shift_ms, median_ms, sigma } => {
                shift_ms + median_ms * (sigma * random.normal()).exp()
            }
            Self::Exponential { shift_ms, mean_ms } => shift_ms - mean_ms * (1.0 - random.unit()).ln(),
            Self::Measured(values) => {
                let turn = number % values.len().max(1) as u64;
                values.get(turn as usize).copied().unwrap_or(0.0)
            }
        };
        (ms.clamp(0.0, MOST_STAGE_MS) * 1e6).round() as i64
    }
}

/// By Simpson's rule over the part of the density above 0.
fn mean_of_cut_normal(mean_ms: f64, sd_ms: f64) -> f64 {
    if sd_ms <= 0.0 {
        return mean_ms;
    }
    const STEPS: u32 = 2000;
    let low = (mean_ms - 9.0 * sd_ms).max(0.0);
    let step = (mean_ms + 9.0 * sd_ms - low) / f64::from(STEPS);
    let (mut weight_sum, mut sum) = (0.0, 0.0);
    for index in 0..=STEPS {
        let at = low + step * f64::from(index);
        let simpson = match index {
            0 | STEPS => 1.0,
            _ if index % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let weight = simpson * (-0.5 * ((at - mean_ms) / sd_ms).powi(2)).exp();
        weight_sum += weight;
        sum += weight * at;
    }
    sum / weight_sum
}

/// How long a stage takes, and how that is known.
#[derive(Clone, Debug, PartialEq)]
pub struct StageTime {
    /// How long.
    pub delay: Delay,
    /// Where the figure comes from.
    pub source: String,
    /// The figure is from no source.
    pub guess: bool,
}

impl StageTime {
    /// Nothing at all.
    #[must_use]
    pub fn none() -> Self {
        Self { delay: Delay::Constant { ms: 0.0 }, source: String::new(), guess: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn_ms(delay: &Delay) -> Vec<f64> {
        (0..40_000).map(|number| delay.draw_ns(7, Stage::Gpu, number) as f64 * 1e-6).collect()
    }

    #[test]
    fn draws_have_the_mean_that_is_told() {
        let cases = [
            Delay::Constant { ms: 3.5 },
            Delay::Uniform { low_ms: 1.0, high_ms: 5.0 },
            Delay::Normal { mean_ms: 1.0, sd_ms: 2.0 },
            Delay::LogNormal { shift_ms: 1.0, median_ms: 2.0, sigma: 0.5 },
            Delay::Exponential { shift_ms: 0.25, mean_ms: 1.5 },
            Delay::Measured([1.0, 2.0, 6.0, 11.0].into()),
        ];
        for delay in cases {
            let drawn = drawn_ms(&delay);
            let mean = drawn.iter().sum::<f64>() / drawn.len() as f64;
            assert!((mean - delay.mean_ms()).abs() < 0.03, "{delay:?}: {mean} and {}", delay.mean_ms());
            assert!(drawn.iter().all(|ms| *ms >= 0.0));
        }
    }

    #[test]
    fn closed_forms_of_the_means() {
        // Cut at its mean, a normal distribution is a half-normal one: sd sqrt(2 / pi).
        let half = mean_of_cut_normal(0.0, 3.0);
        assert!((half - 3.0 * (2.0 / std::f64::consts::PI).sqrt()).abs() < 1e-9);
        // Far from 0 the cut takes nothing.
        assert!((mean_of_cut_normal(20.0, 1.0) - 20.0).abs() < 1e-9);
        assert!((mean_of_cut_normal(20.0, 0.0) - 20.0).abs() < 1e-12);
    }

    #[test]
    fn measured_values_keep_their_order() {
        let delay = Delay::Measured([4.0, 7.0].into());
        let drawn: Vec<i64> = (0..5).map(|number| delay.draw_ns(1, Stage::Gpu, number)).collect();
        assert_eq!(drawn, [4_000_000, 7_000_000, 4_000_000, 7_000_000, 4_000_000]);
    }

    #[test]
    fn draws_do_not_depend_on_the_order_of_asking() {
        let delay = Delay::Uniform { low_ms: 0.0, high_ms: 9.0 };
        let one = delay.draw_ns(3, Stage::Polling, 12);
        _ = delay.draw_ns(3, Stage::Polling, 5);
        assert_eq!(one, delay.draw_ns(3, Stage::Polling, 12));
        assert_ne!(one, delay.draw_ns(4, Stage::Polling, 12));
        assert_ne!(one, delay.draw_ns(3, Stage::Wakeup, 12));
    }

    #[test]
    fn what_no_stage_can_take_is_refused() {
        let bad = [
            Delay::Constant { ms: -1.0 },
            Delay::Constant { ms: f64::NAN },
            Delay::Constant { ms: 1e9 },
            Delay::Uniform { low_ms: 3.0, high_ms: 2.0 },
            Delay::Normal { mean_ms: f64::INFINITY, sd_ms: 1.0 },
            Delay::LogNormal { shift_ms: 0.0, median_ms: 1.0, sigma: 50.0 },
            Delay::Exponential { shift_ms: 0.0, mean_ms: -2.0 },
            Delay::Measured([].into()),
            Delay::Measured([1.0, f64::NAN].into()),
        ];
        for delay in bad {
            assert!(delay.check().is_err(), "{delay:?}");
        }
    }
}
