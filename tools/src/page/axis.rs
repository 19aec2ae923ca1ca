//! Axes, their ticks, and colours of plots.

/// Colours on a light and on a dark ground: Okabe and Ito's, which colour-blind people tell apart, the
/// light ones made darker for a light ground and the dark ones lighter for a dark one.
pub const COLORS: [[&str; 2]; 8] = [
    ["#0072b2", "#56b4e9"],
    ["#d55e00", "#ff8c42"],
    ["#007f5f", "#2fc79a"],
    ["#b0478a", "#e39bc8"],
    ["#8a6d00", "#f0e442"],
    ["#5a3fc0", "#a99bff"],
    ["#a11d2c", "#ff7b86"],
    ["#3d4652", "#c3cad4"],
];

/// Values whose greatest is so many times the least are shown on a logarithmic axis.
const LOG_FROM: f64 = 8.0;
/// What is smaller than the greatest by more than this has no place of its own on a logarithmic axis: it lies
/// in the break, above 0 and below all others.
const LOG_SPAN: f64 = 1e4;
/// The part of a logarithmic axis that is set aside for 0, in the axis's units of length.
const ZERO_BAND: f64 = 28.0;

/// Round numbers from 0 on, about so many.
pub fn steps(most: f64, about: f64) -> Vec<f64> {
    let raw = most / about;
    let decade = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * decade).into_iter().find(|step| *step >= raw);
    let step = step.unwrap_or(raw);
    (0..=(most / step) as u32).map(|tick| f64::from(tick) * step).collect()
}

/// These digits of every decade between two values.
pub fn decades(low: f64, high: f64, digits: &[f64]) -> Vec<f64> {
    let decades = low.log10().floor() as i32..=high.log10().ceil() as i32;
    let ticks = decades.flat_map(|decade| digits.iter().map(move |digit| digit * 10f64.powi(decade)));
    ticks.filter(|tick| (low..=high).contains(tick)).collect()
}

/// From a value to a place along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    scale: Scale,
    from: f64,
    to: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Scale {
    /// From 0 to this.
    Linear(f64),
    /// Between these; 0 has a place of its own before them.
    Log(f64, f64),
}

impl Axis {
    /// From 0 at `from` to a little beyond the greatest of `values` at `to`.
    pub fn from_zero(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let most = values.filter(|value| value.is_finite()).fold(0.0, f64::max);
        Self { scale: Scale::Linear(if most > 0.0 { most * 1.06 } else { 1.0 }), from, to }
    }

    /// As [`Self::from_zero`]; logarithmic where the values above 0 are far apart.
    pub fn fitting(values: impl Iterator<Item = f64> + Clone, from: f64, to: f64) -> Self {
        let above = values.clone().filter(|value| value.is_finite() && *value > 0.0);
        let (least, most) = above
            .fold((f64::INFINITY, 0.0), |(low, high), value| (f64::min(low, value), f64::max(high, value)));
        if most < LOG_FROM * least {
            return Self::from_zero(values, from, to);
        }
        let low = least.max(most / LOG_SPAN) / 1.25;
        Self { scale: Scale::Log(low, most * 1.25), from, to }
    }

    /// Where a value lies, 0 or above.
    pub fn at(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear(most) => self.from + (self.to - self.from) * (value / most).clamp(0.0, 1.0),
            Scale::Log(low, high) => {
                let begin = self.log_from();
                if value <= 0.0 {
                    self.from
                } else if value < low {
                    f64::midpoint(self.from, begin)
                } else {
                    begin + (self.to - begin) * ((value / low).ln() / (high / low).ln()).min(1.0)
                }
            }
        }
    }

    /// Where the logarithmic part begins.
    fn log_from(&self) -> f64 {
        self.from + ZERO_BAND * (self.to - self.from).signum()
    }

    /// Where the break between 0 and the logarithmic part lies.
    pub fn break_at(&self) -> Option<f64> {
        matches!(self.scale, Scale::Log(..)).then(|| f64::midpoint(self.from, self.log_from()))
    }

    /// Values to write at the axis, at most about so many.
    pub fn ticks(&self, about: usize) -> Vec<f64> {
        match self.scale {
            Scale::Linear(most) => steps(most, about as f64),
            Scale::Log(low, high) => {
                let fine = decades(low, high, &[1.0, 2.0, 5.0]);
                let mut ticks = if fine.len() <= about { fine } else { decades(low, high, &[1.0]) };
                ticks.insert(0, 0.0);
                ticks
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_values_lie_on_a_linear_axis_from_zero() {
        let axis = Axis::fitting([2.0, 10.0].into_iter(), 100.0, 0.0);
        assert_eq!(axis.at(0.0), 100.0);
        assert!((axis.at(5.0) - axis.at(10.0) - (axis.at(0.0) - axis.at(5.0))).abs() < 1e-9);
        assert!(axis.at(10.0) > 0.0 && axis.break_at().is_none());
        assert_eq!(axis.ticks(5)[..3], [0.0, 5.0, 10.0]);
    }

    #[test]
    fn far_values_lie_on_a_logarithmic_axis_with_a_place_for_zero() {
        let axis = Axis::fitting([0.0, 0.001, 0.01, 0.1].into_iter(), 100.0, 0.0);
        assert_eq!(axis.at(0.0), 100.0);
        let [a, b, c] = [0.001, 0.01, 0.1].map(|value| axis.at(value));
        assert!((a - b - (b - c)).abs() < 1e-9 && a > b, "{a} {b} {c}");
        let broken = axis.break_at().expect("a break");
        assert!(broken < 100.0 && broken > a);
        let small = Axis::fitting([1e-9, 0.1].into_iter(), 100.0, 0.0);
        assert!(
            small.at(0.0) > small.at(1e-9)
                && small.at(1e-9) > small.at(1e-5)
                && small.at(1e-5) > small.at(0.1)
        );
        let ticks = axis.ticks(8);
        assert_eq!(ticks.len(), 7 + 1, "{ticks:?}");
        assert!(ticks.is_sorted() && ticks[0] == 0.0);
    }

    #[test]
    fn no_value_and_only_zero_have_an_axis() {
        for values in [vec![], vec![0.0], vec![f64::NAN, f64::INFINITY]] {
            let axis = Axis::fitting(values.into_iter(), 0.0, 10.0);
            assert!(axis.at(0.5).is_finite() && axis.ticks(4).iter().all(|tick| tick.is_finite()));
        }
    }
}
