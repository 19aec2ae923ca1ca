//! How a saccade runs from its start to its end.
//!
//! The speed rises as a gamma function does and falls to zero at the end of the duration:
//! `v(u) ~ u^p (1 - u)^q` over the fraction `u` of the duration (a beta function, the gamma's bounded
//! sibling). Two numbers of the main sequence fix `p` and `q`: where the peak lies, which comes earlier
//! the longer the saccade lasts (van Opstal and van Gisbergen 1987), and how high it is.

use super::settings::SaccadeSettings;

/// Pieces of the table: the interpolation errs by less than 1e-4 of the amplitude.
const PIECES: usize = 48;
/// Bounds of `p + q`: a nearly flat speed, and one narrower than any eye's.
const SUM: [f64; 2] = [0.2, 12.0];

/// The course of one saccade, for a distance and a duration of 1.
#[derive(Clone, Debug)]
pub(super) struct Profile {
    position: [f64; PIECES + 1],
    speed: [f64; PIECES + 1],
    /// Peak speed over mean speed.
    pub(super) peak: f64,
}

/// Speeds at the nodes and half way between them.
type Speeds = [f64; 2 * PIECES + 1];

/// The logarithm of the speed, over `p + q`, when the peak is 1 and lies at `mode`.
fn shape(mode: f64) -> Speeds {
    std::array::from_fn(|index| {
        let along = index as f64 / (2 * PIECES) as f64;
        mode * (along / mode).ln() + (1.0 - mode) * ((1.0 - along) / (1.0 - mode)).ln()
    })
}

fn speeds(shape: &Speeds, sum: f64) -> Speeds {
    // The ends are exp(-inf), which is zero.
    shape.map(|logarithm| (sum * logarithm).exp())
}

/// Area below the speed in each piece, by Simpson's rule.
fn areas(speeds: &Speeds) -> [f64; PIECES] {
    std::array::from_fn(|piece| {
        let at = 2 * piece;
        (speeds[at] + 4.0 * speeds[at + 1] + speeds[at + 2]) / (6 * PIECES) as f64
    })
}

impl Profile {
    /// A course whose speed peaks at the fraction `mode` of its duration, at `peak` times its mean.
    /// Where no exponents within bounds give that peak, the nearest is taken.
    pub(super) fn new(mode: f64, peak: f64) -> Self {
        let shape = shape(mode.clamp(0.05, 0.95));
        let [mut low, mut high] = SUM;
        for _ in 0..20 {
            let middle = 0.5 * (low + high);
            let area: f64 = areas(&speeds(&shape, middle)).iter().sum();
            // The raw peak is 1, so that the area is the mean over the peak.
            if 1.0 / area < peak { low = middle } else { high = middle }
        }
        let raw = speeds(&shape, 0.5 * (low + high));
        let areas = areas(&raw);
        let total: f64 = areas.iter().sum();
        let mut position = [0.0; PIECES + 1];
        let mut passed = 0.0;
        for (piece, area) in areas.iter().enumerate() {
            passed += area;
            position[piece + 1] = passed / total;
        }
        // What rounding left out: the whole distance is exactly 1.
        position[PIECES] = 1.0;
        Self { position, speed: std::array::from_fn(|node| raw[2 * node] / total), peak: 1.0 / total }
    }

    /// The fraction of the distance after a fraction of the duration; 0 before and 1 behind.
    pub(super) fn position(&self, along: f64) -> f64 {
        if along.is_nan() || along <= 0.0 {
            return 0.0;
        }
        if along >= 1.0 {
            return 1.0;
        }
        let scaled = along * PIECES as f64;
        let piece = (scaled as usize).min(PIECES - 1);
        let part = scaled - piece as f64;
        let (from, to) = (self.position[piece], self.position[piece + 1]);
        let step = 1.0 / PIECES as f64;
        let (start, end) = (self.speed[piece] * step, self.speed[piece + 1] * step);
        // Cubic Hermite: the speed is continuous from piece to piece.
        let rise = part * part * (3.0 - 2.0 * part);
        let rest = 1.0 - part;
        from + (to - from) * rise + part * rest * (start * rest - end * part)
    }
}

/// Duration of a saccade by its amplitude, ms.
pub(super) fn duration_ms(settings: &SaccadeSettings, amplitude_deg: f64) -> f64 {
    settings.duration_at_zero_ms + settings.duration_ms_per_deg * amplitude_deg
}

/// The fraction of its duration at which a saccade is fastest.
pub(super) fn mode(settings: &SaccadeSettings, duration_ms: f64) -> f64 {
    (settings.mode_at_zero - settings.mode_per_ms * duration_ms).clamp(0.2, 0.5)
}

/// Displacement of the pupil against the eyeball around the end of a saccade, along its direction, as a
/// fraction of the full displacement. The iris swings ahead while the eye brakes, then back and out as a
/// damped oscillator does: one period in `length_ns`, decaying to 5 % by its end.
pub(super) fn oscillation(since_end_ns: i64, length_ns: i64, move_ns: i64) -> f64 {
    if since_end_ns < 0 {
        let ahead_ns = (length_ns / 2).min(move_ns / 2).max(1);
        return smooth(1.0 + since_end_ns as f64 / ahead_ns as f64);
    }
    if since_end_ns >= length_ns {
        return 0.0;
    }
    let along = since_end_ns as f64 / length_ns as f64;
    let phase = std::f64::consts::TAU * along;
    let decay = 3.0 * along;
    // Level at the start, where it joins the swing ahead; the last factor ends it at zero.
    let swing = (phase.cos() + phase.sin() * 3.0 / std::f64::consts::TAU) * (-decay).exp();
    swing * (1.0 - smooth(2.0 * along - 1.0))
}

/// From 0 to 1 with level ends.
pub(super) fn smooth(along: f64) -> f64 {
    let along = along.clamp(0.0, 1.0);
    along * along * (3.0 - 2.0 * along)
}

/// From 0 to 1 along a path of minimum jerk (Flash and Hogan 1985).
pub(super) fn minimum_jerk(along: f64) -> f64 {
    let along = along.clamp(0.0, 1.0);
    along * along * along * (10.0 + along * (6.0 * along - 15.0))
}
