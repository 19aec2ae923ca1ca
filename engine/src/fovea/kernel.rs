//! Kernel functions of KFR: how the LP-buffer's columns are spread over the radius.

use crate::error::{Error, Result};
use std::f64::consts::{E, FRAC_PI_2, FRAC_PI_4, PI};

/// The most coefficients that a [`Kernel::Polynomial`] holds, `beta_0` included.
pub const MAX_COEFFICIENTS: usize = 8;

/// How far the coefficients' sum may lie from 1.
const SUM_TOLERANCE: f64 = 1e-9;

/// A slope above minus this counts as not falling: rounding in the coefficients.
const SLOPE_TOLERANCE: f64 = 1e-9;

/// A kernel function `K`: rises from `K(0) = 0` to `K(1) = 1` (KFR thesis, Eq. 2.8 and 2.9).
///
/// All functions take and give shares in 0..=1 and clamp what lies outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kernel {
    /// `x^alpha`, alpha a real number in 1..=6.
    Power {
        /// The exponent.
        alpha: f64,
    },
    /// `sum beta_i x^i`, normalised and rising.
    Polynomial {
        /// `beta_0` (which must be 0), `beta_1`, ...; filled up with zeros. The sum is 1.
        /// [`Kernel::polynomial`] makes it from a slice.
        beta: [f64; MAX_COEFFICIENTS],
    },
    /// `sin(pi x / 2)`
    Sine,
    /// `(e^x - 1)/(e - 1)`
    Exponential,
}

impl Kernel {
    /// A checked [`Kernel::Polynomial`] from `beta_0`, `beta_1`, ...
    ///
    /// # Errors
    /// [`Error::Setting`] for more than [`MAX_COEFFICIENTS`] coefficients, and all that
    /// [`Kernel::check`] refuses.
    pub fn polynomial(coefficients: &[f64]) -> Result<Self> {
        if coefficients.len() > MAX_COEFFICIENTS {
            return Err(Error::Setting(format!(
                "the kernel has {} coefficients; at most {MAX_COEFFICIENTS} are supported",
                coefficients.len()
            )));
        }
        let mut beta = [0.0; MAX_COEFFICIENTS];
        beta[..coefficients.len()].copy_from_slice(coefficients);
        let kernel = Self::Polynomial { beta };
        kernel.check()?;
        Ok(kernel)
    }

    /// Checks the parameters.
    ///
    /// # Errors
    /// [`Error::Setting`] for an alpha outside 1..=6, and for a polynomial that is not finite, does
    /// not start at 0, does not end at 1 (within 1e-9), or falls anywhere in 0..=1.
    pub fn check(&self) -> Result<()> {
        match self {
            Self::Power { alpha } if !(1.0..=6.0).contains(alpha) => {
                Err(Error::Setting(format!("the kernel's alpha is {alpha}; it must lie between 1 and 6")))
            }
            Self::Polynomial { beta } => check_polynomial(beta),
            Self::Power { .. } | Self::Sine | Self::Exponential => Ok(()),
        }
    }

    /// `K(x)`: share of the columns that lie within the share `x` of the log-radius.
    #[must_use]
    pub fn eval(&self, x: f64) -> f64 {
        // Exact ends, whatever a polynomial's sum rounds to.
        if x <= 0.0 {
            return 0.0;
        }
        if x >= 1.0 {
            return 1.0;
        }
        let y = match self {
            Self::Power { alpha } => x.powf(*alpha),
            Self::Polynomial { beta } => horner(beta, x),
            // Near 1 from the distance to 1, where the sine itself is flat.
            Self::Sine if x > 0.5 => {
                let half = (FRAC_PI_4 * (1.0 - x)).sin();
                1.0 - 2.0 * half * half
            }
            Self::Sine => (FRAC_PI_2 * x).sin(),
            Self::Exponential => x.exp_m1() / (E - 1.0),
        };
        y.clamp(0.0, 1.0)
    }

    /// `K^-1(y)`: the share of the log-radius at which the share `y` of the columns is used up.
    #[must_use]
    pub fn inverse(&self, y: f64) -> f64 {
        if y <= 0.0 {
            return 0.0;
        }
        if y >= 1.0 {
            return 1.0;
        }
        let x = match self {
            Self::Power { alpha } => y.powf(alpha.recip()),
            Self::Polynomial { beta } => solve_polynomial(beta, y),
            // The arc sine has an infinite slope at 1; its half-angle form has not.
            Self::Sine if y > 0.5 => 1.0 - 4.0 / PI * ((1.0 - y) / 2.0).sqrt().asin(),
            Self::Sine => y.asin() / FRAC_PI_2,
            Self::Exponential => (y * (E - 1.0)).ln_1p(),
        };
        x.clamp(0.0, 1.0)
    }

    /// `dK/dx` at `x`, which is clamped to 0..=1; never negative, and 0 where `K` is flat.
    #[must_use]
    pub fn derivative(&self, x: f64) -> f64 {
        let x = x.clamp(0.0, 1.0);
        let slope = match self {
            Self::Power { alpha } => alpha * x.powf(alpha - 1.0),
            Self::Polynomial { beta } => horner(&slope_coefficients(beta), x),
            // As a sine of the distance to 1: the cosine of a rounded pi/2 would leave 6e-17.
            Self::Sine => FRAC_PI_2 * (FRAC_PI_2 * (1.0 - x)).sin(),
            Self::Exponential => x.exp() / (E - 1.0),
        };
        slope.max(0.0)
    }
}

fn horner(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

/// Coefficients of a polynomial's derivative.
fn slope_coefficients(beta: &[f64; MAX_COEFFICIENTS]) -> [f64; MAX_COEFFICIENTS - 1] {
    let mut power = 0.0;
    let mut slope = [0.0; MAX_COEFFICIENTS - 1];
    for (to, from) in slope.iter_mut().zip(&beta[1..]) {
        power += 1.0;
        *to = power * from;
    }
    slope
}

fn check_polynomial(beta: &[f64; MAX_COEFFICIENTS]) -> Result<()> {
    let refuse = |cause: String| Err(Error::Setting(format!("the kernel's coefficients {cause}")));
    if let Some(index) = beta.iter().position(|value| !value.is_finite()) {
        return refuse(format!("must be finite; beta_{index} is {}", beta[index]));
    }
    if beta[0] != 0.0 {
        return refuse(format!("must start with beta_0 = 0; it is {}", beta[0]));
    }
    let sum: f64 = beta.iter().sum();
    if (sum - 1.0).abs() > SUM_TOLERANCE {
        return refuse(format!("must add up to 1; they add up to {sum}"));
    }
    if falls_somewhere(&slope_coefficients(beta)) {
        return refuse("must make a kernel that rises everywhere between 0 and 1; it falls".into());
    }
    Ok(())
}

/// Whether a polynomial is negative anywhere in 0..=1, to a small tolerance.
///
/// In the Bernstein basis a polynomial lies within the hull of its coefficients, and its end values
/// are coefficients: all of them positive settles a piece one way, a negative end the other, and a
/// piece that neither settles is cut in two.
fn falls_somewhere(coefficients: &[f64; MAX_COEFFICIENTS - 1]) -> bool {
    const DEGREE: usize = MAX_COEFFICIENTS - 2;
    let binomial = |n: usize, k: usize| -> f64 {
        (0..k).fold(1.0, |product, step| product * (n - step) as f64 / (step + 1) as f64)
    };
    let mut bernstein = [0.0; DEGREE + 1];
    for (index, value) in bernstein.iter_mut().enumerate() {
        *value = (0..=index)
            .map(|power| binomial(index, power) / binomial(DEGREE, power) * coefficients[power])
            .sum();
    }
    let tolerance = SLOPE_TOLERANCE * coefficients.iter().fold(1.0, |most: f64, value| most.max(value.abs()));
    piece_falls(&bernstein, tolerance, 24)
}

fn piece_falls<const N: usize>(bernstein: &[f64; N], tolerance: f64, cuts_left: u32) -> bool {
    if bernstein[0] < -tolerance || bernstein[N - 1] < -tolerance {
        return true;
    }
    if cuts_left == 0 || bernstein.iter().all(|value| *value >= -tolerance) {
        return false;
    }
    // De Casteljau's scheme at the middle yields the coefficients of both halves.
    let (mut left, mut right) = (*bernstein, *bernstein);
    for (round, kept) in left.iter_mut().enumerate().skip(1) {
        for index in 0..N - round {
            right[index] = f64::midpoint(right[index], right[index + 1]);
        }
        *kept = right[0];
    }
    piece_falls(&left, tolerance, cuts_left - 1) || piece_falls(&right, tolerance, cuts_left - 1)
}

/// The root of `K(x) = y` for a rising polynomial and `0 < y < 1`: Newton's method inside a bracket
/// that shrinks with every step, and bisection where Newton's step leaves it or hardly gets on.
fn solve_polynomial(beta: &[f64; MAX_COEFFICIENTS], y: f64) -> f64 {
    let slope = slope_coefficients(beta);
    // No slope within 0..=1 is greater than the sum.
    let steepest: f64 = slope.iter().map(|coefficient| coefficient.abs()).sum();
    let (mut low, mut high) = (y / steepest.max(1.0), 1.0_f64);
    let (mut x, mut last_step) = (y, 1.0_f64);
    // Newton doubles the digits in each step. Where the first powers are missing it approaches a small
    // root by a constant factor only; halving the bracket's ratio takes 60 steps from any root.
    for _ in 0..200 {
        let miss = horner(beta, x) - y;
        if miss == 0.0 {
            return x;
        }
        if miss < 0.0 {
            low = x;
        } else {
            high = x;
        }
        // A slope of 0 makes the step infinite or NaN, which the comparisons sort out.
        let step = miss / horner(&slope, x);
        // What the rounding of the terms may move the root by.
        if step.abs() <= 4.0 * f64::EPSILON * x {
            return (x - step).max(low).min(high);
        }
        let newton = x - step;
        let quick = newton > low && newton < high && step.abs() < 0.5 * last_step;
        let next = if quick { newton } else { (low * high).sqrt() };
        last_step = (next - x).abs();
        if last_step <= f64::EPSILON * x {
            return next;
        }
        x = next;
    }
    x
}
