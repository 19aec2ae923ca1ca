//! Acuity models: how finely people resolve at each eccentricity, and how many samples that calls
//! for.

mod curve;
mod file;
mod quadrature;
#[cfg(test)]
mod tests;

use crate::error::{Error, Result};
use curve::Curve;

/// Eccentricities end opposite to the gaze.
const MOST_DEG: f64 = 180.0;

/// Pivots lie at least this far apart, degrees: a hundredth of the finest pixel that people see, and far
/// enough that the steepest step still has many doubles on its way.
const LEAST_STEP_DEG: f64 = 1e-4;

/// No table has more pivots; a column's lookup stays short.
const MOST_PIVOTS: usize = 256;

/// Acuities that are taken, cpd. People reach about 60; with these bounds every sum stays finite.
const CPD_RANGE: std::ops::RangeInclusive<f64> = 1e-3..=1e4;

/// Factors that [`AcuityModel::scaled`] takes.
const FACTOR_RANGE: std::ops::RangeInclusive<f64> = 0.05..=20.0;

/// Tangential to radial ratios that are taken; people's lie between 0.5 and 2.
const DELTA_RANGE: std::ops::RangeInclusive<f64> = 0.05..=20.0;

/// Acuity over eccentricity, the angle from the gaze ray.
///
/// The minimum angle of resolution (MAR, degrees per cycle, `omega` in the paper) rises from pivot to
/// pivot, by straight lines (VaFR 2025, Eq. 2, in segments) or by a smooth curve; acuity is its
/// reciprocal in cycles per degree (cpd), and a cycle is two samples. The model also gives the
/// numbers of samples that follow: columns `u(e)` (Eq. 4 and 5) and their heights `l(e)`.
///
/// Eccentricities below 0 and NaN are taken as 0, those above 180 degrees as 180; all results are
/// finite.
#[derive(Clone, Debug, PartialEq)]
pub struct AcuityModel {
    /// Degrees, degrees per cycle.
    pivots: Vec<[f64; 2]>,
    is_smooth: bool,
    /// The display's MAR, degrees per cycle; 0 without a display.
    least_mar_deg: f64,
    /// Degrees, tangential to radial ratio; empty stands for 1.
    delta: Vec<[f64; 2]>,
    /// What follows from the above.
    curve: Curve,
}

impl Default for AcuityModel {
    /// [`Self::vafr_2025`].
    fn default() -> Self {
        Self::vafr_2025()
    }
}

impl AcuityModel {
    /// From pivots of (degrees, cpd), with MAR linear between them; beyond the last one the last
    /// segment goes on. A single pivot gives the same acuity everywhere.
    ///
    /// # Errors
    /// [`Error::Setting`] without pivots or for more than 256, for a first one that is not at 0
    /// degrees, for degrees that do not rise by at least 1e-4 or exceed 180, for an acuity outside
    /// 1e-3 to 1e4 cpd, and for one that rises with eccentricity, where MAR would fall.
    pub fn new(pivots_deg_cpd: &[(f64, f64)]) -> Result<Self> {
        check_pivots(pivots_deg_cpd)?;
        let pivots = pivots_deg_cpd.iter().map(|&(deg, cpd)| [deg, 1.0 / cpd]).collect();
        Ok(Self::from_parts(pivots, false, 0.0, Vec::new()))
    }

    /// The pivots of VaFR 2025, section 3.3: 40, 10, 6, 5 and 4 cpd at 0, 10, 20, 30 and 60 degrees.
    #[must_use]
    pub fn vafr_2025() -> Self {
        let pivots = [[0.0, 40.0], [10.0, 10.0], [20.0, 6.0], [30.0, 5.0], [60.0, 4.0]];
        let pivots = pivots.map(|[deg, cpd]| [deg, 1.0 / cpd]);
        Self::from_parts(pivots.into(), false, 0.0, Vec::new())
    }

    fn from_parts(pivots: Vec<[f64; 2]>, is_smooth: bool, least_mar_deg: f64, delta: Vec<[f64; 2]>) -> Self {
        let curve = if is_smooth { Curve::smooth(&pivots) } else { Curve::linear(&pivots) };
        let curve = curve.finished(least_mar_deg);
        Self { pivots, is_smooth, least_mar_deg, delta, curve }
    }

    /// The variant without kinks: MAR is a monotone cubic through the same pivots, and beyond the last
    /// one the same line. Its first derivative is continuous, so that the sampling rate has no kinks
    /// (but for the one where a display's limit sets in).
    #[must_use]
    pub fn smooth(self) -> Self {
        Self::from_parts(self.pivots, true, self.least_mar_deg, self.delta)
    }

    /// Acuity times a factor of 0.05 to 20: below 1 foveation is stronger, above 1 weaker. A display's
    /// limit stays as it is, whichever of the two was set first.
    ///
    /// # Errors
    /// [`Error::Setting`] for a factor out of range, or one that takes an acuity out of the range of
    /// [`Self::new`].
    pub fn scaled(self, factor: f64) -> Result<Self> {
        if !FACTOR_RANGE.contains(&factor) {
            return Err(setting(format!("the acuity's factor is {factor}; it must be 0.05 to 20")));
        }
        let pivots: Vec<_> = self.pivots.iter().map(|&[deg, mar]| [deg, mar / factor]).collect();
        for &[deg, mar] in &pivots {
            check_cpd(deg, 1.0 / mar)?;
        }
        Ok(Self::from_parts(pivots, self.is_smooth, self.least_mar_deg, self.delta))
    }

    /// With the ratio of the tangential to the radial rate, `Delta(e)` (VaFR 2025, section 9): (degrees,
    /// ratio), linear between, constant outside. None at all is a ratio of 1.
    ///
    /// # Errors
    /// [`Error::Setting`] for more than 256 entries, for degrees that do not rise by at least 1e-4 or lie
    /// outside 0 to 180, and for ratios outside 0.05 to 20.
    pub fn with_delta(self, deg_ratio: &[(f64, f64)]) -> Result<Self> {
        check_degrees("delta", deg_ratio)?;
        for &(deg, ratio) in deg_ratio {
            if !DELTA_RANGE.contains(&ratio) {
                return Err(setting(format!("delta is {ratio} at {deg} degrees; it must be 0.05 to 20")));
            }
        }
        Ok(Self { delta: deg_ratio.iter().map(|&(deg, ratio)| [deg, ratio]).collect(), ..self })
    }

    /// Limited to what a display resolves (its Nyquist limit: half its pixels per degree): acuity is
    /// the smaller of the two. Of several limits the lowest holds.
    ///
    /// # Errors
    /// [`Error::Setting`] for a limit outside 1e-3 to 1e4 cpd.
    pub fn limited_to(self, cpd: f64) -> Result<Self> {
        if !CPD_RANGE.contains(&cpd) {
            return Err(setting(format!("the display's limit is {cpd} cpd; it must be 0.001 to 10000")));
        }
        let least_mar_deg = self.least_mar_deg.max(1.0 / cpd);
        Ok(Self::from_parts(self.pivots, self.is_smooth, least_mar_deg, self.delta))
    }

    /// MAR (`omega`), degrees per cycle: above 0, never falling.
    #[must_use]
    pub fn mar_deg(&self, ecc_deg: f64) -> f64 {
        self.curve.mar_deg(clamp_deg(ecc_deg))
    }

    /// Acuity (`f`), cycles per degree: above 0, never rising.
    #[must_use]
    pub fn cpd(&self, ecc_deg: f64) -> f64 {
        1.0 / self.mar_deg(ecc_deg)
    }

    /// Ratio of the tangential to the radial rate, `Delta(e)`.
    #[must_use]
    pub fn delta(&self, ecc_deg: f64) -> f64 {
        let ecc_deg = clamp_deg(ecc_deg);
        let after = self.delta.partition_point(|entry| entry[0] <= ecc_deg);
        let (before, next) = (after.checked_sub(1).map(|at| self.delta[at]), self.delta.get(after));
        match (before, next) {
            (Some(low), Some(high)) => {
                low[1] + (high[1] - low[1]) * ((ecc_deg - low[0]) / (high[0] - low[0]))
            }
            (Some(only), None) => only[1],
            (None, Some(only)) => only[1],
            (None, None) => 1.0,
        }
    }

    /// Columns between the gaze and an eccentricity, texels: `u(e)`, the integral of `2/MAR`, 0 at
    /// the gaze. Precise to 1e-12 of its value.
    #[must_use]
    pub fn columns_to(&self, ecc_deg: f64) -> f64 {
        self.curve.columns_to(clamp_deg(ecc_deg))
    }

    /// The inverse of [`Self::columns_to`] (VaFR 2025, Eq. 10), degrees; columns before the gaze and NaN
    /// are taken as 0, those behind 180 degrees as 180.
    #[must_use]
    pub fn eccentricity_deg(&self, columns: f64) -> f64 {
        let most = self.curve.columns_to(MOST_DEG);
        clamp_deg(self.curve.eccentricity_deg(columns.max(0.0).min(most)))
    }

    /// Height of the column at an eccentricity in the paper's planar form (VaFR 2025, Eq. 9 with
    /// `Delta`): `Delta 360 sin(2 e)/MAR` texels, and 0 from 90 degrees on, where the plane ends.
    #[must_use]
    pub fn height_planar(&self, ecc_deg: f64) -> f64 {
        self.delta(ecc_deg) * planar_height(clamp_deg(ecc_deg), self.mar_deg(ecc_deg))
    }

    /// Height of the column at an eccentricity on the sphere about the gaze ray, where the circle is
    /// `360 sin(e)` degrees round: `Delta 720 sin(e)/MAR` texels.
    #[must_use]
    pub fn height_on_sphere(&self, ecc_deg: f64) -> f64 {
        self.delta(ecc_deg) * sphere_height(clamp_deg(ecc_deg), self.mar_deg(ecc_deg))
    }

    /// Samples up to an eccentricity in the planar form: the integral of [`Self::height_planar`] over the
    /// columns, to 1e-12 of its value.
    #[must_use]
    pub fn samples_to_planar(&self, ecc_deg: f64) -> f64 {
        self.samples_to(clamp_deg(ecc_deg).min(90.0), planar_height)
    }

    /// Samples up to an eccentricity on the sphere: the integral of [`Self::height_on_sphere`] over the
    /// columns, to 1e-12 of its value.
    #[must_use]
    pub fn samples_on_sphere(&self, ecc_deg: f64) -> f64 {
        self.samples_to(clamp_deg(ecc_deg), sphere_height)
    }

    fn samples_to(&self, ecc_deg: f64, height: impl Fn(f64, f64) -> f64) -> f64 {
        // Delta has kinks, which no quadrature rule may cross.
        let inner = self.delta.iter().map(|entry| entry[0]).filter(|deg| *deg < ecc_deg);
        let mut from_deg = 0.0;
        let mut sum = 0.0;
        for to_deg in inner.chain([ecc_deg]) {
            sum += self.curve.integral(from_deg, to_deg, |deg, mar_deg| {
                self.delta(deg) * height(deg, mar_deg) * 2.0 / mar_deg
            });
            from_deg = to_deg;
        }
        sum
    }
}

fn planar_height(ecc_deg: f64, mar_deg: f64) -> f64 {
    if ecc_deg < 90.0 { 360.0 * (2.0 * ecc_deg.to_radians()).sin() / mar_deg } else { 0.0 }
}

fn sphere_height(ecc_deg: f64, mar_deg: f64) -> f64 {
    720.0 * ecc_deg.to_radians().sin() / mar_deg
}

/// Into 0..=180, NaN as 0.
fn clamp_deg(ecc_deg: f64) -> f64 {
    if ecc_deg.is_nan() { 0.0 } else { ecc_deg.clamp(0.0, MOST_DEG) }
}

fn setting(cause: String) -> Error {
    Error::Setting(cause)
}

fn check_cpd(deg: f64, cpd: f64) -> Result<()> {
    if CPD_RANGE.contains(&cpd) {
        return Ok(());
    }
    Err(setting(format!("the acuity at {deg} degrees is {cpd} cpd; it must be 0.001 to 10000")))
}

/// Degrees within 0..=180 that rise.
fn check_degrees(what: &str, entries: &[(f64, f64)]) -> Result<()> {
    if entries.len() > MOST_PIVOTS {
        let count = entries.len();
        return Err(setting(format!("{what} has {count} entries; at most {MOST_PIVOTS} are supported")));
    }
    for &(deg, _) in entries {
        if !(0.0..=MOST_DEG).contains(&deg) {
            return Err(setting(format!("{what} has an entry at {deg} degrees; it must be 0 to 180")));
        }
    }
    for pair in entries.windows(2) {
        let (before, deg) = (pair[0].0, pair[1].0);
        if deg - before < LEAST_STEP_DEG {
            return Err(setting(format!(
                "{what} has an entry at {deg} degrees after one at {before}; degrees must rise, by at \
                 least {LEAST_STEP_DEG}"
            )));
        }
    }
    Ok(())
}

fn check_pivots(pivots: &[(f64, f64)]) -> Result<()> {
    check_degrees("the acuity model", pivots)?;
    match pivots.first() {
        None => return Err(setting("the acuity model has no pivots; give at least one at 0 degrees".into())),
        Some(&(deg, _)) if deg != 0.0 => {
            return Err(setting(format!(
                "the acuity model begins at {deg} degrees; its first pivot must lie at 0"
            )));
        }
        Some(_) => {}
    }
    for &(deg, cpd) in pivots {
        check_cpd(deg, cpd)?;
    }
    for pair in pivots.windows(2) {
        let ((before_deg, before_cpd), (deg, cpd)) = (pair[0], pair[1]);
        if cpd > before_cpd {
            return Err(setting(format!(
                "the acuity rises from {before_cpd} cpd at {before_deg} degrees to {cpd} cpd at {deg}; the \
                 minimum angle of resolution must not fall away from the gaze"
            )));
        }
    }
    Ok(())
}
