//! Numbers that look random and are the same in every run.

/// SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014).
pub struct Random(u64);

impl Random {
    /// Begins from a text: a case's id gives it numbers of its own, whichever other cases run.
    pub fn of(text: &str) -> Self {
        // FNV-1a, 64 bits: its published offset and prime.
        let hash = text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        Self(hash)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// From 0 to below 1, in steps of 2^-53.
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 * 2.0_f64.powi(-53)
    }

    /// From 0 to below `end`, which is at least 1.
    pub fn below(&mut self, end: u32) -> u32 {
        // The share is below 1, and the product of an integer below 2^32 is exact enough to stay below it.
        (self.unit() * f64::from(end)) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_numbers() {
        // The reference implementation's first outputs for the seed 0.
        let mut random = Random(0);
        let first = [0xe220_a839_7b1d_cdaf, 0x6e78_9e6a_a1b9_65f4, 0x06c4_5d18_8009_454f];
        assert_eq!([random.next(), random.next(), random.next()], first);
    }

    #[test]
    fn numbers_depend_on_the_text_only_and_lie_in_range() {
        let draw = |text: &str| {
            let mut random = Random::of(text);
            (0..1000).map(|_| random.below(7)).collect::<Vec<_>>()
        };
        assert_eq!(draw("a"), draw("a"));
        assert_ne!(draw("a"), draw("b"));
        for value in 0..7 {
            assert!(draw("a").contains(&value));
        }
        assert!(draw("b").iter().all(|value| *value < 7));
    }
}
