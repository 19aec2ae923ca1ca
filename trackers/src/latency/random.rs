//! Random numbers by counter: the same seed, stream and number give the same value in any order of
//! asking, so that a sweep draws for each sample what the run drew for it.

/// The finaliser of `SplitMix64` (Steele, Lea, Flood 2014), which passes `BigCrush` on a counter.
fn mixed(mut value: u64) -> u64 {
    value = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    value = (value ^ (value >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    value ^ (value >> 31)
}

/// The numbers for one draw of one stage.
#[derive(Clone, Copy, Debug)]
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64, stream: u64, number: u64) -> Self {
        let start = mixed(seed.wrapping_add(stream.wrapping_mul(0x9e37_79b9_7f4a_7c15)));
        Self(mixed(start ^ number.wrapping_mul(0xd134_2543_de82_ef95)))
    }

    /// Uniform in 0 (inclusive) to 1 (exclusive).
    pub(super) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (mixed(self.0) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Normal with mean 0 and standard deviation 1 (Box and Muller).
    pub(super) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.unit()).cos()
    }
}
