//! How many samples a second a tracker really takes.

/// Intervals looked at: more resist more losses among them, fewer follow a change of mode sooner.
const INTERVALS: usize = 32;
/// By how much the median may differ from what the tracker says before it is believed instead. Clocks
/// differ by far less, modes by far more.
const TOLERANCE: f64 = 0.25;

/// The rate that a tracker says it has, unless its timestamps say otherwise for long enough.
#[derive(Clone, Debug, Default)]
pub(super) struct RateEstimate {
    nominal_hz: Option<f64>,
    measured_hz: Option<f64>,
    latest_ns: Option<i64>,
    intervals_ns: Vec<i64>,
}

impl RateEstimate {
    pub fn set_nominal(&mut self, nominal_hz: Option<f64>) {
        self.nominal_hz = nominal_hz.filter(|rate| rate.is_finite() && *rate > 0.0);
    }

    /// Takes in a device time. Returns the rate when it has been measured anew.
    pub fn observe(&mut self, device_ns: i64) -> Option<f64> {
        let step_ns = self.latest_ns.replace(device_ns).map(|latest| device_ns.saturating_sub(latest));
        self.intervals_ns.extend(step_ns.filter(|step| *step > 0));
        if self.intervals_ns.len() < INTERVALS {
            return None;
        }
        let (_, median_ns, _) = self.intervals_ns.select_nth_unstable(INTERVALS / 2);
        self.measured_hz = Some(1e9 / *median_ns as f64);
        self.intervals_ns.clear();
        self.rate_hz()
    }

    /// What came before is not comparable.
    pub fn clock_jumped(&mut self) {
        self.intervals_ns.clear();
        self.latest_ns = None;
    }

    pub fn rate_hz(&self) -> Option<f64> {
        let close = |nominal: &f64| {
            self.measured_hz.is_none_or(|measured| (measured / nominal - 1.0).abs() <= TOLERANCE)
        };
        self.nominal_hz.filter(close).or(self.measured_hz)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Feeds so many samples, `step_us` apart, and returns the rate at their end.
    fn after(rate: &mut RateEstimate, samples: i64, step_us: i64) -> Option<f64> {
        let from = rate.latest_ns.unwrap_or(0);
        for sample in 1..=samples {
            rate.observe(from + sample * step_us * 1000);
        }
        rate.rate_hz()
    }

    #[test]
    fn the_promise_holds_until_the_clock_contradicts_it() {
        let mut rate = RateEstimate::default();
        rate.set_nominal(Some(1000.0));
        assert_eq!(after(&mut rate, 100, 1010), Some(1000.0));
        assert_eq!(after(&mut rate, 100, 4000), Some(250.0));
        assert_eq!(after(&mut rate, 100, 1000), Some(1000.0));
    }

    #[test]
    fn without_a_promise_it_is_measured_through_losses() {
        let mut rate = RateEstimate::default();
        assert_eq!(after(&mut rate, 20, 2000), None);
        for lost in 0..40 {
            after(&mut rate, 3, 2000);
            after(&mut rate, 1, 2000 * (2 + lost % 5));
        }
        assert_eq!(rate.rate_hz(), Some(500.0));
        rate.set_nominal(Some(f64::NAN));
        assert_eq!(rate.rate_hz(), Some(500.0));
    }
}
