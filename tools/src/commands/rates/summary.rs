//! From single rates to what is shown of each eccentricity, and to the greatest deviations.

use super::target::Limits;
use serde::Serialize;

/// Deviations count from here on, degrees: nearer to the gaze there are only a few pixels.
pub const DEVIATION_FROM_DEG: f64 = 0.2;

/// Away from the gaze or across that.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// Along the great circle away from the gaze.
    Radial,
    /// Along the circle about the gaze.
    Tangential,
}

/// Both.
pub const DIRECTIONS: [Direction; 2] = [Direction::Radial, Direction::Tangential];

/// The shading rate at one place in one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Angle from the gaze ray, degrees.
    pub ecc_deg: f64,
    /// About the gaze, degrees.
    pub azimuth_deg: f64,
    /// Of the rate.
    pub direction: Direction,
    /// The shading rate, cycles per degree.
    pub cpd: f64,
    /// What it is to be.
    pub limits: Limits,
    /// The display's pixels themselves are shaded.
    pub is_native: bool,
}

impl Sample {
    fn ratio(&self) -> f64 {
        self.cpd / self.limits.target_cpd
    }

    /// The share by which the rate misses the nearer of acuity and display.
    fn off_both(&self) -> f64 {
        let Limits { acuity_cpd, display_cpd, .. } = self.limits;
        f64::min((self.cpd / acuity_cpd - 1.0).abs(), (self.cpd / display_cpd - 1.0).abs())
    }
}

/// Least, mean and greatest over the azimuths.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Least.
    pub min: f64,
    /// Mean.
    pub mean: f64,
    /// Greatest.
    pub max: f64,
}

impl Spread {
    /// Of at least one value.
    fn of(values: impl ExactSizeIterator<Item = f64>) -> Self {
        let count = values.len() as f64;
        let start = (f64::INFINITY, 0.0, f64::NEG_INFINITY);
        let (min, sum, max) = values
            .fold(start, |(min, sum, max), value| (f64::min(min, value), sum + value, f64::max(max, value)));
        Self { min, mean: sum / count, max }
    }
}

/// Rates of one direction at one eccentricity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rate {
    /// The shading rate, cycles per degree.
    pub cpd: Spread,
    /// Acuity, display and the smaller of both, as means.
    #[serde(flatten)]
    pub limits: Limits,
    /// The rate over the target.
    pub ratio: Spread,
}

/// What is known of one eccentricity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Angle from the gaze ray, degrees.
    pub ecc_deg: f64,
    /// Azimuths of which the rate is known: the others lie off the display.
    pub azimuths: usize,
    /// Share of these at which the display's pixels themselves are shaded.
    pub native_share: f64,
    /// Away from the gaze; `None` where no azimuth has that rate.
    pub radial: Option<Rate>,
    /// Across that.
    pub tangential: Option<Rate>,
}

/// The rate that lies farthest on one side of its target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Extreme {
    /// Rate over target.
    pub ratio: f64,
    /// Of the rate.
    pub direction: Direction,
    /// Where, degrees from the gaze.
    pub ecc_deg: f64,
    /// Where, degrees about the gaze.
    pub azimuth_deg: f64,
}

impl From<&Sample> for Extreme {
    fn from(sample: &Sample) -> Self {
        let Sample { direction, ecc_deg, azimuth_deg, .. } = *sample;
        Self { ratio: sample.ratio(), direction, ecc_deg, azimuth_deg }
    }
}

/// How far rates lie from their targets at [`DEVIATION_FROM_DEG`] and beyond.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Deviation {
    /// The greatest, as a share of the target.
    pub greatest: f64,
    /// The greatest share by which a rate misses both the acuity and the display's limit, of which the
    /// target is the smaller. A flat display is denser away from its centre than around it: where the
    /// one direction is limited by the eye and the other by the display, texels and pixels alike are
    /// right in one of them and finer than the target in the other.
    pub off_both: f64,
    /// The least and the greatest rate over the acuity alone.
    pub over_acuity: [f64; 2],
    /// The rate farthest below its target.
    pub lowest: Extreme,
    /// The rate farthest above its target.
    pub highest: Extreme,
}

impl Deviation {
    /// `None` without samples.
    fn of<'a>(samples: impl Iterator<Item = &'a Sample> + Clone) -> Option<Self> {
        let by_ratio = |a: &&Sample, b: &&Sample| a.ratio().total_cmp(&b.ratio());
        let lowest = Extreme::from(samples.clone().min_by(by_ratio)?);
        let highest = Extreme::from(samples.clone().max_by(by_ratio)?);
        let off_both = samples.clone().map(Sample::off_both).fold(0.0, f64::max);
        let over_acuity = samples.map(|sample| sample.cpd / sample.limits.acuity_cpd);
        let over_acuity =
            over_acuity.fold([f64::INFINITY, 0.0], |[low, high], ratio| [low.min(ratio), high.max(ratio)]);
        let greatest = f64::max((lowest.ratio - 1.0).abs(), (highest.ratio - 1.0).abs());
        Some(Self { greatest, off_both, over_acuity, lowest, highest })
    }
}

/// The rates of one method on one display at one gaze.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// By eccentricity, rising.
    pub rows: Vec<Row>,
    /// Over all of the display.
    pub deviation: Option<Deviation>,
    /// Over what is shaded in the LP-buffer.
    pub deviation_outside_native: Option<Deviation>,
}

impl Summary {
    /// Of samples in any order.
    pub fn of(mut samples: Vec<Sample>) -> Self {
        samples.sort_by(|a, b| a.ecc_deg.total_cmp(&b.ecc_deg));
        let rows = samples.chunk_by(|a, b| a.ecc_deg == b.ecc_deg).map(row).collect();
        let counted = samples.iter().filter(|sample| sample.ecc_deg >= DEVIATION_FROM_DEG);
        Self {
            rows,
            deviation: Deviation::of(counted.clone()),
            deviation_outside_native: Deviation::of(counted.filter(|sample| !sample.is_native)),
        }
    }
}

/// Of the samples of one eccentricity, at least one.
fn row(samples: &[Sample]) -> Row {
    let mut azimuths: Vec<_> = samples.iter().map(|sample| sample.azimuth_deg).collect();
    azimuths.sort_by(f64::total_cmp);
    azimuths.dedup();
    let native = samples.iter().filter(|sample| sample.is_native).count();
    Row {
        ecc_deg: samples[0].ecc_deg,
        azimuths: azimuths.len(),
        native_share: native as f64 / samples.len() as f64,
        radial: rate(samples, Direction::Radial),
        tangential: rate(samples, Direction::Tangential),
    }
}

fn rate(samples: &[Sample], direction: Direction) -> Option<Rate> {
    let found: Vec<_> = samples.iter().filter(|sample| sample.direction == direction).collect();
    if found.is_empty() {
        return None;
    }
    let spread = |value: fn(&Sample) -> f64| Spread::of(found.iter().map(|sample| value(sample)));
    let limits = found.iter().map(|sample| sample.limits).fold(Limits::default(), Limits::plus);
    Some(Rate {
        cpd: spread(|sample| sample.cpd),
        limits: limits.over(found.len() as f64),
        ratio: spread(Sample::ratio),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(ecc_deg: f64, azimuth_deg: f64, direction: Direction, cpd: f64) -> Sample {
        let is_native = ecc_deg < 1.0;
        let limits = Limits { acuity_cpd: 10.0, display_cpd: 8.0, target_cpd: 8.0 };
        Sample { ecc_deg, azimuth_deg, direction, cpd, limits, is_native }
    }

    #[test]
    fn samples_become_rows_and_deviations() {
        use Direction::{Radial, Tangential};
        let summary = Summary::of(vec![
            sample(2.0, 90.0, Radial, 12.0),
            sample(0.1, 0.0, Radial, 80.0),
            sample(2.0, 0.0, Radial, 8.0),
            sample(0.5, 0.0, Tangential, 2.0),
            sample(2.0, 45.0, Radial, 4.0),
        ]);
        let eccs_deg: Vec<_> = summary.rows.iter().map(|row| row.ecc_deg).collect();
        assert_eq!(eccs_deg, [0.1, 0.5, 2.0]);
        let last = &summary.rows[2];
        assert_eq!((last.azimuths, last.native_share, last.tangential), (3, 0.0, None));
        let Some(radial) = last.radial else { panic!("no radial rate") };
        assert_eq!(radial.cpd, Spread { min: 4.0, mean: 8.0, max: 12.0 });
        assert_eq!(radial.ratio, Spread { min: 0.5, mean: 1.0, max: 1.5 });
        assert_eq!((radial.limits.acuity_cpd, radial.limits.target_cpd), (10.0, 8.0));
        // What lies below 0.2 degrees does not count.
        let Some(all) = summary.deviation else { panic!("no deviation") };
        // 2 cpd miss 8 cpd by more than 12 cpd miss 10.
        assert_eq!((all.greatest, all.off_both, all.over_acuity), (0.75, 0.75, [0.2, 1.2]));
        let lowest = Extreme { ratio: 0.25, direction: Tangential, ecc_deg: 0.5, azimuth_deg: 0.0 };
        let highest = Extreme { ratio: 1.5, direction: Radial, ecc_deg: 2.0, azimuth_deg: 90.0 };
        assert_eq!((all.lowest, all.highest), (lowest, highest));
        let lp = summary.deviation_outside_native.map(|deviation| (deviation.greatest, deviation.off_both));
        assert_eq!(lp, Some((0.5, 0.5)));
    }

    #[test]
    fn nothing_is_made_of_nothing() {
        let summary = Summary::of(vec![]);
        assert!(summary.rows.is_empty() && summary.deviation.is_none());
        let summary = Summary::of(vec![sample(0.5, 0.0, Direction::Radial, 8.0)]);
        assert!(summary.deviation.is_some() && summary.deviation_outside_native.is_none());
    }
}
