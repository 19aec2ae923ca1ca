//! Where a saccade lands, from its course so far.
//!
//! A saccade is ballistic: once under way its direction is fixed, and its duration and shape follow from
//! its amplitude (the main sequence). So every amplitude and duration explains the displacements so far more or
//! less well, and the mean over all of them, weighted by how well, is the prediction.

use super::{Landing, Predictor, along, horizon_s};
use crate::classify::{Phase, Velocity};
use crate::estimate::EyeState;
use crate::history::Entry;
use crate::ring::Ring;
use glam::DVec3;

/// Points kept: 128 ms at 4 kHz.
const POINTS: usize = 512;
/// Points of the course that are compared, evenly chosen; more cost time and tell little.
const COMPARED: usize = 12;
/// Amplitudes tried: from what is covered already to [`REACH`] times that, evenly in the logarithm.
const AMPLITUDES: usize = 20;
const REACH: f64 = 8.0;
/// The largest saccade thought of, deg. The eye turns at most about 50 degrees from straight ahead, and nearly
/// all saccades stay far below that; without a bound a noisy onset lands anywhere.
const LARGEST_DEG: f64 = 50.0;
/// Durations tried for each, as deviations from the main sequence in standard deviations, and the
/// logarithm of their prior weight.
const DURATIONS: [f64; 5] = [-1.5, -0.75, 0.0, 0.75, 1.5];

/// What a [`LandingPredictor`] knows of saccades.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LandingSettings {
    /// Main sequence: duration of a saccade of no amplitude, s, and what each degree adds, s. 2.2 A + 21 ms
    /// is Carpenter's (Movements of the Eyes, 1988). Longer predicts further.
    pub duration_s: f64,
    /// See `duration_s`.
    pub duration_s_per_deg: f64,
    /// Standard deviation of the logarithm of the duration about the main sequence: persons and
    /// saccades differ by about 15 %. Larger trusts the course more than the main sequence.
    pub duration_spread: f64,
    /// Median amplitude expected before anything is known, deg, and the standard deviation of its
    /// logarithm. 5 deg is common in natural viewing; a deviation of 2 makes that a weak belief (two thirds
    /// between 0.7 and 37 deg). Smaller ones pull small saccades up and large ones down.
    pub usual_amplitude_deg: f64,
    /// See `usual_amplitude_deg`.
    pub amplitude_spread: f64,
    /// How far single saccades depart from the template, as a share of the amplitude. Larger trusts the
    /// course less.
    pub shape_error: f64,
    /// How far the speed at one time departs from the template, as a share of the mean speed.
    pub speed_error: f64,
    /// Departures from the template last as long as a third of a saccade, so that all points together
    /// count as this many independent ones.
    pub independent_points: f64,
    /// The speed is that over the last so many ns.
    pub speed_window_ns: i64,
}

impl Default for LandingSettings {
    fn default() -> Self {
        Self {
            duration_s: 0.021,
            duration_s_per_deg: 0.0022,
            duration_spread: 0.15,
            usual_amplitude_deg: 5.0,
            amplitude_spread: 2.0,
            shape_error: 0.1,
            speed_error: 0.3,
            independent_points: 3.0,
            speed_window_ns: 8_000_000,
        }
    }
}

/// Predicts the landing in a saccade, goes straight on in a pursuit, and holds the filtered gaze otherwise.
#[derive(Clone, Debug)]
pub struct LandingPredictor {
    settings: LandingSettings,
    points: Ring<Point>,
    state: EyeState,
    last: Option<(i64, DVec3, Velocity)>,
    flight: Option<Flight>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Point {
    time_ns: i64,
    gaze: DVec3,
}

/// The saccade under way, as it is thought to go on.
#[derive(Clone, Copy, Debug)]
struct Flight {
    start_ns: i64,
    /// Gaze at the start, and the direction at right angles to it in which the eye moves.
    origin: DVec3,
    side: DVec3,
    covered_deg: f64,
    amplitude_deg: f64,
    error_deg: f64,
    duration_s: f64,
}

/// A displacement along the saccade, deg, at a time since its start, s.
type Course = [(f64, f64)];

impl Default for LandingPredictor {
    fn default() -> Self {
        Self::new(LandingSettings::default())
    }
}

impl LandingPredictor {
    /// A predictor with nothing seen yet.
    #[must_use]
    pub fn new(settings: LandingSettings) -> Self {
        Self { settings, points: Ring::new(POINTS), state: EyeState::Unknown, last: None, flight: None }
    }

    fn flight(&self, entry: &Entry, phase: &Phase) -> Option<Flight> {
        let start_ns = phase.since_ns;
        let since_s = |time_ns: i64| time_ns.saturating_sub(start_ns) as f64 * 1e-9;
        let origin = self.origin(start_ns).or(phase.onset.try_normalize())?;
        let gaze = entry.gaze();
        let side = (gaze - origin * gaze.dot(origin)).try_normalize()?;
        let displaced = |gaze: DVec3| gaze.dot(side).atan2(gaze.dot(origin)).to_degrees();
        let in_flight = self.points.partition(|point| point.time_ns > start_ns);
        let mut course = [(0.0, 0.0); COMPARED];
        let count = in_flight.min(COMPARED);
        for (index, slot) in course.iter_mut().take(count).enumerate() {
            // From the newest, evenly back to the first of the saccade.
            let back = if count < 2 { 0 } else { index * (in_flight - 1) / (count - 1) };
            let point = self.points.back(back)?;
            *slot = (since_s(point.time_ns), displaced(point.gaze));
        }
        let course = course.get(..count)?;
        let earlier_ns = entry.time_ns.saturating_sub(self.settings.speed_window_ns.max(1));
        let earlier = self.points.back(self.points.partition(|point| point.time_ns > earlier_ns).max(1));
        let earlier = earlier.filter(|point| point.time_ns >= start_ns);
        let earlier = earlier.map_or((0.0, 0.0), |point| (since_s(point.time_ns), displaced(point.gaze)));
        let (amplitude_deg, error_deg, duration_s) = self.fit(course, earlier, phase.jitter_deg)?;
        let covered_deg = course.first().map_or(0.0, |newest| newest.1);
        Some(Flight { start_ns, origin, side, covered_deg, amplitude_deg, error_deg, duration_s })
    }

    /// Mean gaze of the last 4 ms before the start.
    fn origin(&self, start_ns: i64) -> Option<DVec3> {
        let from_ns = start_ns.saturating_sub(4_000_000);
        let newest = self.points.partition(|point| point.time_ns > start_ns);
        let oldest = self.points.partition(|point| point.time_ns >= from_ns);
        let sum = (newest..oldest).filter_map(|back| self.points.back(back)).map(|point| point.gaze).sum();
        DVec3::try_normalize(sum)
    }

    /// Mean and standard deviation of the amplitude, deg, and the mean duration, s. The course begins with
    /// the newest point; `earlier` is the one that the speed is measured from.
    fn fit(&self, course: &Course, earlier: (f64, f64), jitter_deg: f64) -> Option<(f64, f64, f64)> {
        let settings = &self.settings;
        let newest = *course.first()?;
        let covered_deg = newest.1.max(0.2);
        let weight = (settings.independent_points / course.len() as f64).min(1.0);
        let reach = REACH.min(LARGEST_DEG / covered_deg).max(1.0);
        let ratio = reach.powf(1.0 / (AMPLITUDES - 1) as f64);
        // At low rates a sample may be the first in flight, and the jitter must not look like precision.
        let jitter_deg = jitter_deg.max(0.02);
        let mut best = f64::INFINITY;
        let mut sums = [0.0; 4];
        let mut amplitude_deg = covered_deg;
        for _ in 0..AMPLITUDES {
            let prior = (amplitude_deg / settings.usual_amplitude_deg).ln() / settings.amplitude_spread;
            let usual_s = settings.duration_s + settings.duration_s_per_deg * amplitude_deg;
            let variance = jitter_deg.powi(2) + (settings.shape_error * amplitude_deg).powi(2);
            for deviation in DURATIONS {
                let duration_s = usual_s * (deviation * settings.duration_spread).exp();
                let at = |time_s: f64| amplitude_deg * covered(time_s / duration_s);
                let squares: f64 = course.iter().map(|(time_s, deg)| (deg - at(*time_s)).powi(2)).sum();
                let lasted_s = newest.0 - earlier.0;
                let moved = newest.1 - earlier.1 - (at(newest.0) - at(earlier.0));
                let speed_error = settings.speed_error * amplitude_deg * lasted_s / duration_s;
                let speed_variance = 2.0 * jitter_deg.powi(2) + speed_error.powi(2);
                let cost = weight * (squares / variance + course.len() as f64 * variance.ln())
                    + moved * moved / speed_variance
                    + speed_variance.ln()
                    + deviation * deviation
                    + prior * prior;
                if cost < best {
                    // Weights are relative to the best, so that none overflows.
                    let scale = (0.5 * (cost - best)).exp();
                    sums = sums.map(|sum| sum * scale);
                    best = cost;
                }
                let share = (0.5 * (best - cost)).exp();
                for (sum, value) in
                    sums.iter_mut().zip([1.0, amplitude_deg, amplitude_deg * amplitude_deg, duration_s])
                {
                    *sum += share * value;
                }
            }
            amplitude_deg *= ratio;
        }
        let [total, amplitude, square, duration] = sums;
        let mean = amplitude / total;
        let spread = (square / total - mean * mean).max(0.0).sqrt();
        (total > 0.0 && mean.is_finite()).then_some((mean, spread, duration / total))
    }
}

/// The template: share of the amplitude covered at a share of the duration. Its velocity is
/// x (1 - x)^2: it peaks at a third of the duration at 1.78 times the mean, and dies out softly, as
/// saccades of more than a few degrees do (van Opstal and van Gisbergen 1987).
fn covered(time: f64) -> f64 {
    let left = 1.0 - if time > 0.0 { time.min(1.0) } else { 0.0 };
    1.0 - left * left * left * (4.0 - 3.0 * left)
}

impl Flight {
    fn at_deg(&self, deg: f64) -> DVec3 {
        let angle = deg.to_radians();
        self.origin * angle.cos() + self.side * angle.sin()
    }

    fn landing_ns(&self) -> i64 {
        self.start_ns.saturating_add((self.duration_s * 1e9) as i64)
    }
}

impl Predictor for LandingPredictor {
    fn name(&self) -> &'static str {
        "landing"
    }

    fn push(&mut self, entry: &Entry, phase: &Phase) {
        self.points.push(Point { time_ns: entry.time_ns, gaze: entry.gaze() });
        self.state = phase.state;
        self.last = Some((entry.time_ns, entry.smoothed_gaze(), phase.velocity));
        self.flight = if phase.state == EyeState::Saccade { self.flight(entry, phase) } else { None };
    }

    fn predict(&self, time_ns: i64) -> Option<DVec3> {
        let (from_ns, gaze, velocity) = self.last?;
        let Some(flight) = self.flight.filter(|_| time_ns > from_ns) else {
            let on = self.state == EyeState::Pursuit;
            return Some(if on { along(gaze, velocity, horizon_s(from_ns, time_ns)) } else { gaze });
        };
        // From where the eye is on along the template, so that the prediction begins without a jump.
        let left_at = |at_ns: i64| {
            let since_s = at_ns.saturating_sub(flight.start_ns) as f64 * 1e-9;
            1.0 - covered(since_s / flight.duration_s)
        };
        let left = left_at(from_ns);
        let share = if left > 0.0 { 1.0 - left_at(time_ns) / left } else { 1.0 };
        Some(flight.at_deg(flight.covered_deg + (flight.amplitude_deg - flight.covered_deg) * share))
    }

    fn landing(&self) -> Option<Landing> {
        let (from_ns, ..) = self.last?;
        self.flight.map(|flight| Landing {
            gaze: flight.at_deg(flight.amplitude_deg),
            time_ns: flight.landing_ns().max(from_ns),
            error_deg: flight.error_deg,
        })
    }

    fn reset(&mut self) {
        self.points.clear();
        self.state = EyeState::Unknown;
        self.last = None;
        self.flight = None;
    }
}

#[cfg(test)]
mod tests {
    use super::covered;

    /// The profile x (1 - x)^2 summed up step by step.
    #[test]
    fn the_template_is_the_integral_of_its_profile() {
        let profile = |x: f64| x * (1.0 - x) * (1.0 - x);
        let sum = |to: usize| (0..to).map(|step| profile((step as f64 + 0.5) / 1e4)).sum::<f64>();
        for percent in 0..=100 {
            let expected = sum(percent * 100) / sum(10_000);
            assert!((covered(percent as f64 / 100.0) - expected).abs() < 1e-6, "{percent} %");
        }
        assert_eq!([f64::NAN, -1.0, f64::INFINITY].map(covered), [0.0, 0.0, 1.0]);
    }
}
