//! How fast the gaze moves, and how fast it seems to move when it does not.

use crate::ring::Ring;
use glam::DVec3;

/// The gaze at one time, and its velocity over the window that ends there.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Point {
    pub(super) time_ns: i64,
    pub(super) gaze: DVec3,
    pub(super) velocity: Velocity,
}

/// A velocity over a window of time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Velocity {
    /// Change of the direction, deg/s, in the space of the gaze.
    pub deg_s: DVec3,
    /// The middle of the window, ns: the time for which the velocity holds.
    pub middle_ns: i64,
    /// From the first to the last sample of the window, s; 0 where there is no velocity.
    pub span_s: f64,
}

/// The slope of the least-squares line through the gaze at `newest` and the points before it that lie
/// within `window_ns`, or just the last one where the rate is too low for that. With n samples in a window
/// its noise is about sqrt(6 / n) that of the difference of the two ends. `None` without a point
/// within `max_step_ns`.
pub(super) fn velocity(
    points: &Ring<Point>,
    newest_ns: i64,
    gaze: DVec3,
    window_ns: i64,
    max_step_ns: i64,
) -> Option<Velocity> {
    let age_ns = |point: &Point| newest_ns.saturating_sub(point.time_ns);
    let within = |(back, point): &(usize, &Point)| {
        age_ns(point) <= if *back == 0 { window_ns.max(max_step_ns) } else { window_ns }
    };
    // Times and directions relative to the newest, so that nothing cancels.
    let (mut n, mut t, mut tt, mut first_s) = (1.0, 0.0, 0.0, 0.0);
    let (mut d, mut td) = (DVec3::ZERO, DVec3::ZERO);
    for (_, point) in points.newest_first().enumerate().take_while(within) {
        first_s = -(age_ns(point) as f64) * 1e-9;
        let moved = point.gaze - gaze;
        n += 1.0;
        t += first_s;
        tt += first_s * first_s;
        d += moved;
        td += moved * first_s;
    }
    let spread = tt - t * t / n;
    (spread > 0.0).then(|| Velocity {
        deg_s: (td - d * (t / n)) * (1.0 / spread).to_degrees(),
        middle_ns: newest_ns.saturating_add((t / n * 1e9) as i64),
        span_s: -first_s,
    })
}

/// A running median that forgets: it steps up by a little where a value lies above it and down where one
/// lies below, so that it comes to rest where both are as frequent. Steps are shares of the value.
#[derive(Clone, Copy, Debug)]
pub(super) struct RunningMedian {
    value: f64,
    least: f64,
    most: f64,
}

impl RunningMedian {
    pub(super) fn new(start: f64, least: f64, most: f64) -> Self {
        Self { value: start, least, most }
    }

    pub(super) fn value(self) -> f64 {
        self.value
    }

    /// Takes a value that stands for `share` of the memory (0 to 1). A constant change of level by a
    /// factor of two is followed within the memory.
    pub(super) fn push(&mut self, value: f64, share: f64) {
        let step = (share.clamp(0.0, 1.0) * std::f64::consts::LN_2).exp();
        self.value = if value > self.value { self.value * step } else { self.value / step };
        self.value = self.value.clamp(self.least, self.most);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Uniform motion about an axis across the gaze, sampled unevenly: the slope is the rate.
    #[test]
    fn velocity_of_uniform_motion() {
        let at = |s: f64| {
            let angle = (40.0 * s).to_radians();
            DVec3::new(angle.sin(), 0.0, -angle.cos())
        };
        let mut points = Ring::new(64);
        for time_ns in [0, 1_000_000, 1_200_000, 4_000_000, 7_000_000, 8_500_000] {
            points.push(Point { time_ns, gaze: at(time_ns as f64 * 1e-9), ..Point::default() });
        }
        let told = velocity(&points, 10_000_000, at(0.01), 10_000_000, 100_000_000).expect("moves");
        assert!((told.deg_s.length() - 40.0).abs() < 0.01, "{told:?}");
        assert!((told.span_s - 0.01).abs() < 1e-12);
        // Seven samples, whose mean time is 31.7 ms / 7.
        assert!((told.middle_ns - 4_528_571).abs() <= 1, "{}", told.middle_ns);
        let slow = velocity(&points, 68_500_000, at(0.0685), 10_000_000, 100_000_000).expect("two samples");
        assert!((slow.deg_s.length() - 40.0).abs() < 0.05 && (slow.span_s - 0.06).abs() < 1e-12);
        assert_eq!(velocity(&points, 200_000_000, at(0.2), 10_000_000, 100_000_000), None);
        assert_eq!(velocity(&Ring::new(3), 0, DVec3::NEG_Z, 10, 10), None);
    }

    #[test]
    fn the_median_is_that_of_a_skewed_sequence() {
        // 1, 2, 3, 4, 5, 600, 700: median 4, mean 188.
        let mut median = RunningMedian::new(50.0, 0.1, 1000.0);
        for index in 0..7000 {
            median.push([5.0, 1.0, 600.0, 2.0, 4.0, 700.0, 3.0][index % 7], 0.002);
        }
        assert!((median.value() - 4.0).abs() < 0.1, "{}", median.value());
        median.push(f64::NAN, f64::NAN);
    }
}
