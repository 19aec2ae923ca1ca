//! Device counters of few bits, as times that do not wrap.

use super::clamp_i64;

/// How far a counter may disagree with the host before that is called a jump: 1 s, because a sample may
/// well come so late. Larger misses jumps (the clock mapping still finds them), smaller takes late
/// samples for jumps.
const JUMP_NS: i128 = 1_000_000_000;
/// What a device clock may gain on the host's: 1 part in 500, twice the worst oscillator to expect.
const DRIFT_DIVISOR: i128 = 500;

/// A counter value on a time line without wraps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unwrapped {
    /// Device time, ns; at the ends of `i64` it stays there.
    pub time_ns: i64,
    /// The counter moved in a way that neither passing time nor disorder explains: it was set, or the
    /// device started anew.
    pub jumped: bool,
}

/// Unwraps a counter of up to 64 bits: each value is put where it is nearest to the one before, so that
/// a wrap goes on and a small step backwards stays one. With the host's time of arrival, whole periods
/// that passed in silence are counted too; without it, a silence of more than half a period is
/// ambiguous and comes out too short.
#[derive(Clone, Copy, Debug)]
pub struct Unwrapper {
    bits: u32,
    signed: bool,
    unit_ns: i64,
    last: Option<Last>,
}

#[derive(Clone, Copy, Debug)]
struct Last {
    ticks: i128,
    received_ns: Option<i64>,
}

impl Unwrapper {
    /// For a counter of `bits` (taken as 1 to 64) whose unit is `unit_ns` (at least 1): 1000 for
    /// microseconds, 1 000 000 for milliseconds. A `signed` one may start below zero.
    #[must_use]
    pub fn new(bits: u32, signed: bool, unit_ns: i64) -> Self {
        Self { bits: bits.clamp(1, 64), signed, unit_ns: unit_ns.max(1), last: None }
    }

    /// The next value, of which the lowest `bits` count: sign-extended or not, both are right.
    /// `received_ns` is its arrival on the host clock, where that is known.
    pub fn unwrap(&mut self, raw: u64, received_ns: Option<i64>) -> Unwrapped {
        let period = 1i128 << self.bits;
        let raw = i128::from(raw) & (period - 1);
        let Some(last) = self.last else {
            let ticks = if self.signed { nearest(raw, period) } else { raw };
            self.last = Some(Last { ticks, received_ns });
            return Unwrapped { time_ns: self.time_ns(ticks), jumped: false };
        };
        let unit_ns = i128::from(self.unit_ns);
        let elapsed_ns =
            received_ns.zip(last.received_ns).map(|(now, then)| (i128::from(now) - i128::from(then)).max(0));
        let mut step = nearest((raw - last.ticks).rem_euclid(period), period);
        if let Some(elapsed_ns) = elapsed_ns {
            let missing = elapsed_ns / unit_ns - step;
            step += ((missing + period / 2).div_euclid(period)).max(0) * period;
        }
        let step_ns = step.saturating_mul(unit_ns);
        let jumped = elapsed_ns.is_some_and(|elapsed_ns| {
            let tolerance_ns = JUMP_NS + elapsed_ns / DRIFT_DIVISOR;
            step_ns < -tolerance_ns || step_ns > elapsed_ns + tolerance_ns
        });
        let ticks = last.ticks + step;
        self.last = Some(Last { ticks, received_ns: received_ns.or(last.received_ns) });
        Unwrapped { time_ns: self.time_ns(ticks), jumped }
    }

    fn time_ns(&self, ticks: i128) -> i64 {
        clamp_i64(ticks.saturating_mul(i128::from(self.unit_ns)))
    }
}

/// The representative of `value` (0 to `period`) that is nearest to zero.
fn nearest(value: i128, period: i128) -> i128 {
    if value >= period / 2 { value - period } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn microseconds_wrap_after_71_minutes() {
        let mut clock = Unwrapper::new(32, false, 1000);
        // 2^32 us are 4294.967296 s.
        assert_eq!(clock.unwrap(0xffff_fff0, None).time_ns, 4_294_967_280_000);
        assert_eq!(clock.unwrap(0x10, None), Unwrapped { time_ns: 4_294_967_312_000, jumped: false });
        // Back across the wrap by 32 us: disorder, no second wrap.
        assert_eq!(clock.unwrap(0xffff_fff0, None).time_ns, 4_294_967_280_000);
        assert_eq!(clock.unwrap(0x20, None).time_ns, 4_294_967_328_000);
    }

    #[test]
    fn signed_milliseconds_start_below_zero_and_pass_it() {
        let mut clock = Unwrapper::new(32, true, 1_000_000);
        for value in [-16i32, -8, 0, 8] {
            assert_eq!(clock.unwrap(value as u64, None).time_ns, i64::from(value) * 1_000_000);
        }
        let mut clock = Unwrapper::new(32, true, 1_000_000);
        assert_eq!(clock.unwrap(i32::MAX as u64, None).time_ns, 2_147_483_647_000_000);
        assert_eq!(clock.unwrap(i32::MIN as u64, None).time_ns, 2_147_483_648_000_000);
    }

    #[test]
    fn periods_of_silence_are_counted_by_the_host() {
        let mut clock = Unwrapper::new(16, false, 100_000);
        assert_eq!(clock.unwrap(100, Some(0)).time_ns, 10_000_000);
        // Three periods of 6.5536 s and 5 ms later, arriving 2 ms late.
        let told = clock.unwrap(150, Some(3 * 6_553_600_000 + 7_000_000));
        assert_eq!(told, Unwrapped { time_ns: 10_000_000 + 3 * 6_553_600_000 + 5_000_000, jumped: false });
    }

    #[test]
    fn a_restart_is_a_jump_and_a_late_sample_is_not() {
        let mut clock = Unwrapper::new(32, false, 1000);
        clock.unwrap(3_000_000_000, Some(0));
        assert!(!clock.unwrap(3_000_001_000, Some(10_000_000_000)).jumped, "ten seconds late");
        assert!(clock.unwrap(5, Some(10_001_000_000)).jumped, "started anew");
        assert!(!clock.unwrap(1005, Some(10_002_000_000)).jumped);
        assert!(clock.unwrap(0xffff_ffff - 60_000_000, Some(10_003_000_000)).jumped, "a minute back");
    }

    proptest! {
        /// A counter cut to its bits gives the true times, while each step is under half a period.
        #[test]
        fn true_times_come_back(
            bits in 8u32..=64,
            start in any::<u64>(),
            steps in prop::collection::vec(-20i64..100, 1..200),
        ) {
            let mask = u64::MAX >> (64 - bits);
            let mut clock = Unwrapper::new(bits, false, 1);
            let mut truth = i128::from(start & mask);
            clock.unwrap(start, None);
            for step in steps {
                truth += i128::from(step);
                let told = clock.unwrap(truth as u64 & mask, None);
                prop_assert_eq!(told.time_ns, clamp_i64(truth));
            }
        }

        #[test]
        fn nothing_overflows(
            bits in any::<u32>(), signed: bool, unit_ns: i64,
            values in prop::collection::vec((any::<u64>(), any::<Option<i64>>()), 0..20),
        ) {
            let mut clock = Unwrapper::new(bits, signed, unit_ns);
            for (raw, received_ns) in values {
                clock.unwrap(raw, received_ns);
            }
        }
    }
}
