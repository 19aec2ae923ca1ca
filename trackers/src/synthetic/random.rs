//! Repeatable randomness.
//!
//! The eye must be the same at every sampling rate, and any instant may be asked for, so noise has to be
//! a function of the time and not of how often it was asked. A counter-based hash gives that; a generator
//! with a running state does not. The finaliser is that of `SplitMix64` (Steele, Lea and Flood 2014), which
//! also makes the short sequences of [`Random`], so that no seed means something else when a library is
//! updated.

use glam::DVec2;
use std::f64::consts::TAU;

/// The increment of `SplitMix64`: the golden ratio, odd, so that every counter is reached.
const STEP: u64 = 0x9E37_79B9_7F4A_7C15;

fn mix(value: u64) -> u64 {
    let value = (value ^ (value >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let value = (value ^ (value >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    value ^ (value >> 31)
}

/// A number that depends on all three, evenly.
pub(super) fn hash(key: u64, stream: u64, counter: i64) -> u64 {
    let stream = mix(key.wrapping_add(stream.wrapping_add(1).wrapping_mul(STEP)));
    mix(stream.wrapping_add((counter as u64).wrapping_mul(STEP)))
}

/// 0 to below 1, from all the bits that a double holds.
fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

/// A short repeatable sequence of random numbers.
#[derive(Clone, Debug)]
pub(super) struct Random {
    state: u64,
}

impl Random {
    /// The sequence of a stream's item.
    pub(super) fn new(key: u64, stream: u64, item: i64) -> Self {
        Self { state: hash(key, stream, item) }
    }

    /// Evenly from 0 to below 1.
    pub(super) fn unit(&mut self) -> f64 {
        self.state = self.state.wrapping_add(STEP);
        unit(mix(self.state))
    }

    /// Evenly between two numbers.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// True with a probability.
    pub(super) fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// Two independent normal numbers, mean 0, standard deviation 1 (Box and Muller 1958).
    pub(super) fn normal_pair(&mut self) -> DVec2 {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        DVec2::from_angle(TAU * self.unit()) * radius
    }

    /// One normal number, mean 0, standard deviation 1.
    pub(super) fn normal(&mut self) -> f64 {
        self.normal_pair().x
    }

    /// Log-normal, by its median and the standard deviation of its logarithm.
    pub(super) fn log_normal(&mut self, median: f64, sigma: f64) -> f64 {
        median * (sigma * self.normal()).exp()
    }

    /// Exponential, by its mean.
    pub(super) fn exponential(&mut self, mean: f64) -> f64 {
        -mean * (1.0 - self.unit()).ln()
    }
}

/// Smooth noise over time: random values on a lattice, joined by cubics with level ends. Mean 0,
/// standard deviation 1, no power to speak of above one cycle in two steps of the lattice.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    key: u64,
    period_ns: i64,
}

impl Lattice {
    /// Noise of a stream with a lattice step of at least 1 ns.
    pub(super) fn new(key: u64, stream: u64, period_ns: i64) -> Self {
        Self { key: hash(key, stream, 0), period_ns: period_ns.max(1) }
    }

    /// Two independent components at a time.
    pub(super) fn at(&self, time_ns: i64) -> DVec2 {
        let index = time_ns.div_euclid(self.period_ns);
        let along = time_ns.rem_euclid(self.period_ns) as f64 / self.period_ns as f64;
        let weight = along * along * (3.0 - 2.0 * along);
        let before = self.node(index);
        // The mean of (1 - w)^2 + w^2 over a step is 26/35: what interpolation takes from the variance.
        (before + (self.node(index.wrapping_add(1)) - before) * weight) * (35.0 / 26.0_f64).sqrt()
    }

    /// Evenly within +-sqrt(3), which has a standard deviation of 1.
    fn node(&self, index: i64) -> DVec2 {
        let bits = mix(self.key.wrapping_add((index as u64).wrapping_mul(STEP)));
        let halves = DVec2::new((bits >> 32) as f64, (bits & 0xFFFF_FFFF) as f64);
        (halves / f64::from(u32::MAX) * 2.0 - 1.0) * 3.0_f64.sqrt()
    }
}

/// Streams of randomness, so that one setting does not shift the dice of another.
pub(super) mod stream {
    pub(in crate::synthetic) const SCENE: u64 = 1;
    pub(in crate::synthetic) const ANCHOR: u64 = 2;
    pub(in crate::synthetic) const BLINKS: u64 = 3;
    pub(in crate::synthetic) const LOSSES: u64 = 4;
    pub(in crate::synthetic) const PUPIL: u64 = 5;
    pub(in crate::synthetic) const TREMOR: u64 = 6;
    pub(in crate::synthetic) const SWAY: u64 = 7;
    pub(in crate::synthetic) const FIELD: u64 = 8;
    pub(in crate::synthetic) const WANDER: u64 = 9;
    pub(in crate::synthetic) const SAMPLE: u64 = 10;
    pub(in crate::synthetic) const BURST: u64 = 11;
    /// One each for the octaves of drift, from here on.
    pub(in crate::synthetic) const DRIFT: u64 = 100;
}
