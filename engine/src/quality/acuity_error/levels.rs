//! The scales between which the low-pass interpolates, and their kernels.

use std::f64::consts::{LN_2, PI, TAU};

/// Sigma of a Gaussian that lets half of the amplitude through at a frequency, times that frequency:
/// `sqrt(2 ln 2) / 2 pi`.
pub(super) fn sigma_times_cutoff() -> f64 {
    (2.0 * LN_2).sqrt() / TAU
}

/// Sigma from one level to the next. Nearer to 1 takes more levels in every tile and interpolates
/// more exactly: the error of a Gaussian's amplitude falls with the square of the step, and at 1.15
/// it is 0.0053 (by evaluation over all frequencies).
const LEVEL_RATIO: f64 = 1.15;

/// Sigma of the levels on a halved grid, in that grid's pixels, is at least this. The bilinear
/// interpolation between its pixels is wrong by at most `2/(8 e sigma^2)` of the amplitude, 0.0057
/// at 4; a larger value makes it more exact and the kernels longer.
const LEAST_COARSE_SIGMA: f64 = 4.0;

/// Kernels reach this many sigma, where a Gaussian has fallen to 0.0022.
const REACH_SIGMAS: f64 = 3.5;

/// Kernels reach at least this far, px. Below a sigma of 1 px a Gaussian's spectrum is cut off at the
/// grid's Nyquist frequency, and what its kernel loses by being short is felt there: 0.0174 of the
/// amplitude at 8, in inverse proportion.
const LEAST_REACH_PX: usize = 8;

/// Variance that one halving of the grid adds, px^2 of the finer grid: that of weights 1 3 3 1.
const HALVING_VARIANCE: f64 = 0.75;

/// The place of pixels that are not filtered; a whole level away from the first level.
pub(super) const SHARP: f32 = -1.0;

/// One scale.
#[derive(Clone, Debug)]
pub(super) struct Level {
    /// How often the grid that it is computed on was halved.
    pub(super) halvings: usize,
    /// Weights at 0, 1, 2... px of that grid, the same on both sides.
    pub(super) kernel: Vec<f32>,
}

/// Variance of a level, px^2. The first level is the Gaussian whose cutoff is the display's Nyquist
/// frequency; smaller ones are not used.
fn variance_px2(level: f64) -> f64 {
    (2.0 * sigma_times_cutoff() * LEVEL_RATIO.powf(level)).powi(2)
}

/// Where a sigma (px, at least the first level's) lies among the levels: the integer part is a
/// level, the rest its share of the way to the next one, linear in the variance. Interpolated images
/// then have the variance asked for.
pub(super) fn place_of(sigma_px: f64) -> f32 {
    let level = ((sigma_px / variance_px2(0.0).sqrt()).ln() / LEVEL_RATIO.ln()).floor().max(0.0);
    let (from, to) = (variance_px2(level), variance_px2(level + 1.0));
    (level + ((sigma_px * sigma_px - from) / (to - from)).clamp(0.0, 1.0)) as f32
}

/// The levels that places up to `last` need.
pub(super) fn levels_to(last: f32) -> Vec<Level> {
    let count = if last < 0.0 { 0 } else { last.ceil() as usize + 1 };
    (0..count).map(level).collect()
}

fn level(index: usize) -> Level {
    let variance = variance_px2(index as f64);
    let halvings = (variance.sqrt() / LEAST_COARSE_SIGMA).log2().floor().max(0.0);
    let area = 4_f64.powf(halvings);
    // The halvings have blurred already: by 0.75 (1 + 4 + 16...) px^2.
    let coarse = (variance - HALVING_VARIANCE * (area - 1.0) / 3.0) / area;
    Level { halvings: halvings as usize, kernel: kernel(coarse.sqrt()) }
}

/// Half of the kernel that has a Gaussian's spectrum at the frequencies 0, 1/2n, 2/2n... 1/2 cycles
/// per px, where n is its reach. (Sampling the Gaussian itself would be wrong for a sigma below 1 px:
/// at 0.37 it lets 0.89 of the Nyquist frequency through, not 0.5.)
fn kernel(sigma_px: f64) -> Vec<f32> {
    let reach = ((REACH_SIGMAS * sigma_px).ceil() as usize).max(LEAST_REACH_PX);
    let weight = |at: usize| {
        let term = |k: usize| {
            let frequency = PI * k as f64 / reach as f64;
            let ends = if k == 0 || k == reach { 0.5 } else { 1.0 };
            ends * (-0.5 * (sigma_px * frequency).powi(2)).exp() * (frequency * at as f64).cos()
        };
        let weight = (0..=reach).map(term).sum::<f64>() / reach as f64;
        // The outermost weight stands for both of its sides.
        (if at == reach { 0.5 * weight } else { weight }) as f32
    };
    (0..=reach).map(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A kernel's amplitude at a frequency in radians per px.
    fn amplitude(kernel: &[f32], frequency: f64) -> f64 {
        let sides = kernel.iter().enumerate().skip(1);
        let sum = sides.map(|(at, &weight)| 2.0 * f64::from(weight) * (frequency * at as f64).cos());
        f64::from(kernel[0]) + sum.sum::<f64>()
    }

    #[test]
    fn half_of_the_amplitude_is_left_at_the_cutoff() {
        let sigma_px = sigma_times_cutoff() / 0.1;
        let left = (-0.5 * (sigma_px * TAU * 0.1).powi(2)).exp();
        assert!((left - 0.5).abs() < 1e-12, "{left}");
    }

    /// Over both frequencies, for every sigma between levels that are computed at full resolution.
    #[test]
    fn interpolated_levels_have_the_spectrum_of_a_gaussian() {
        const STEPS: usize = 48;
        let frequencies: Vec<f64> = (0..=STEPS).map(|step| PI * step as f64 / STEPS as f64).collect();
        let levels = levels_to(21.0);
        assert!(levels.iter().all(|level| level.halvings == 0));
        let spectrum = |level: usize| -> Vec<f64> {
            frequencies.iter().map(|&frequency| amplitude(&levels[level].kernel, frequency)).collect()
        };
        for first in 0..21 {
            let spectra = [spectrum(first), spectrum(first + 1)];
            for share in [0.0, 0.3, 0.6, 0.9] {
                let sigma_px = ((1.0 - share) * variance_px2(first as f64)
                    + share * variance_px2(first as f64 + 1.0))
                .sqrt();
                assert!((f64::from(place_of(sigma_px)) - first as f64 - share).abs() < 1e-5);
                for (x, &fx) in frequencies.iter().enumerate() {
                    for (y, &fy) in frequencies.iter().enumerate() {
                        let found = (1.0 - share) * spectra[0][x] * spectra[0][y]
                            + share * spectra[1][x] * spectra[1][y];
                        let expected = (-0.5 * sigma_px * sigma_px * (fx * fx + fy * fy)).exp();
                        let off = (found - expected).abs();
                        assert!(off < 0.02, "sigma {sigma_px}: {found}, not {expected} at {fx}, {fy}");
                    }
                }
            }
        }
    }

    #[test]
    fn places_rise_with_sigma_and_levels_reach_them() {
        assert_eq!(place_of(variance_px2(0.0).sqrt()), 0.0);
        let mut last = 0.0;
        for step in 0..2000 {
            let place = place_of(0.375 * 1.006_f64.powi(step));
            assert!(place >= last, "{place} after {last}");
            last = place;
        }
        assert_eq!(levels_to(last).len(), last.ceil() as usize + 1);
        assert!(levels_to(SHARP).is_empty());
        for level in levels_to(last) {
            assert!(level.kernel.len() < 40, "{} weights", level.kernel.len());
            let sum = amplitude(&level.kernel, 0.0);
            assert!((sum - 1.0).abs() < 1e-5, "{sum}");
        }
    }
}
