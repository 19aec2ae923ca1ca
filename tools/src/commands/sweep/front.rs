//! The Pareto front: settings that no other setting beats in both time and error.

use super::record::{Figures, Outcome, Record};

/// Which time a setting is judged by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Time {
    /// Median of the pairs' ratios to the reference's time.
    Ratio,
    /// Median of the frames, milliseconds.
    GpuMs,
}

impl Time {
    /// Of figures.
    pub fn of(self, figures: &Figures) -> f64 {
        match self {
            Self::Ratio => figures.times.ratio.median,
            Self::GpuMs => figures.times.setting_ms.median,
        }
    }
}

/// Which error a setting is judged by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// The error that survives the acuity: the front's own.
    AcuityRmse,
    /// FLIP.
    Flip,
    /// Root of the mean square difference.
    Rmse,
}

impl Measure {
    /// Of figures.
    pub fn of(self, figures: &Figures) -> f64 {
        match self {
            Self::AcuityRmse => figures.errors.acuity_rmse,
            Self::Flip => figures.errors.flip,
            Self::Rmse => figures.errors.rmse,
        }
    }
}

/// What a setting costs and how far off it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// [`Time`], above 0.
    pub time: f64,
    /// [`Measure`], from 0.
    pub error: f64,
}

impl Point {
    /// `None` for what is no measurement: not finite, an error below 0, a time of 0 or below.
    pub fn new(time: f64, error: f64) -> Option<Self> {
        let measured = time.is_finite() && time > 0.0 && error.is_finite() && error >= 0.0;
        measured.then_some(Self { time, error })
    }

    /// `None` for a failed setting and as [`Self::new`].
    pub fn of(record: &Record, time: Time, measure: Measure) -> Option<Self> {
        match &record.outcome {
            Outcome::Failed(_) => None,
            Outcome::Measured(figures) => Self::new(time.of(figures), measure.of(figures)),
        }
    }
}

/// Places in `points` of those on the front, from the fastest to the most accurate.
///
/// A point is on it where no other is at least as fast and at least as accurate, and better in one of both.
/// Equal points are on it together.
pub fn front(points: &[Option<Point>]) -> Vec<usize> {
    let mut measured: Vec<(usize, Point)> =
        points.iter().enumerate().filter_map(|(place, point)| Some((place, (*point)?))).collect();
    measured.sort_by(|(_, a), (_, b)| a.time.total_cmp(&b.time).then(a.error.total_cmp(&b.error)));
    let mut last: Option<Point> = None;
    let mut places = Vec::new();
    for (place, point) in measured {
        if last.is_none_or(|last| point.error < last.error || point == last) {
            places.push(place);
            last = Some(point);
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use super::super::report::fixture::records;
    use super::*;

    fn points(of: &[(f64, f64)]) -> Vec<Option<Point>> {
        of.iter().map(|&(time, error)| Point::new(time, error)).collect()
    }

    #[test]
    fn the_front_is_in_order_of_time() {
        let of = points(&[(3.0, 1.0), (1.0, 3.0), (2.0, 2.0), (2.5, 2.5), (4.0, 1.5)]);
        assert_eq!(front(&of), [1, 2, 0]);
    }

    #[test]
    fn equal_points_are_on_it_together_and_ties_in_one_figure_are_not() {
        assert_eq!(front(&points(&[(1.0, 1.0), (2.0, 0.5), (1.0, 1.0)])), [0, 2, 1]);
        assert_eq!(front(&points(&[(1.0, 1.0), (1.0, 2.0)])), [0]);
        assert_eq!(front(&points(&[(2.0, 1.0), (1.0, 1.0)])), [1]);
        assert_eq!(front(&points(&[(1.0, 0.0), (2.0, 0.0)])), [0]);
    }

    #[test]
    fn what_is_no_measurement_is_on_no_front() {
        let strange = [f64::INFINITY, f64::NEG_INFINITY, f64::NAN, -1.0];
        for value in strange {
            assert_eq!(Point::new(value, 1.0), None);
            assert_eq!(Point::new(1.0, value), None);
        }
        assert_eq!((Point::new(0.0, 1.0), Point::new(1.0, -0.0).map(|point| point.error)), (None, Some(0.0)));
        let of = points(&[(0.5, f64::INFINITY), (f64::NAN, 0.1), (1.0, 1.0)]);
        assert_eq!(front(&of), [2]);
        assert!(front(&[]).is_empty() && front(&[None]).is_empty());
    }

    #[test]
    fn it_is_what_comparing_all_with_all_finds() {
        let grid: Vec<[u8; 2]> = (1..=3).flat_map(|time| (0..3).map(move |error| [time, error])).collect();
        for choice in 0..grid.len().pow(4) {
            let of = [0, 1, 2, 3].map(|digit| grid[choice / grid.len().pow(digit) % grid.len()]);
            let found = front(&of.map(|[time, error]| Point::new(time.into(), error.into())));
            assert!(found.is_sorted_by_key(|&place| of[place][0]), "{of:?}: {found:?}");
            for place in 0..of.len() {
                let [time, error] = of[place];
                let beaten =
                    of.iter().any(|&other| other[0] <= time && other[1] <= error && other != of[place]);
                assert_eq!(found.contains(&place), !beaten, "{of:?}: {found:?}");
            }
        }
    }

    #[test]
    fn failed_settings_have_no_point() {
        let records = records();
        let failed = records.iter().filter(|record| matches!(record.outcome, Outcome::Failed(_)));
        assert!(failed.clone().count() > 0);
        for record in &records {
            let point = Point::of(record, Time::Ratio, Measure::Flip);
            assert_eq!(point.is_none(), matches!(record.outcome, Outcome::Failed(_)));
        }
    }
}
