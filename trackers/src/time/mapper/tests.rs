//! Against a simulated device whose clock and delays are known.

use super::*;
use proptest::prelude::*;

/// A device with a true clock: `device = (host - start) * rate + offset`, and samples that arrive after a
/// least delay plus jitter with an exponential tail, some of them only with the next one.
struct Simulation {
    rate: f64,
    offset_ns: i64,
    period_ns: i64,
    jitter_ns: f64,
    seed: u64,
}

const START_NS: i64 = 1_000_000_000_000;

impl Simulation {
    fn random(&mut self) -> f64 {
        // Marsaglia's xorshift64.
        self.seed ^= self.seed << 13;
        self.seed ^= self.seed >> 7;
        self.seed ^= self.seed << 17;
        (self.seed >> 11) as f64 / (1u64 << 53) as f64
    }

    /// (true host time, device time, arrival) of `count` samples.
    fn samples(&mut self, from_ns: i64, count: usize) -> Vec<(i64, i64, i64)> {
        let mut told = Vec::new();
        let mut latest_ns = i64::MIN;
        for number in 0..count as i64 {
            let true_ns = START_NS + from_ns + number * self.period_ns;
            let device_ns = self.offset_ns + ((true_ns - START_NS) as f64 * self.rate) as i64;
            let mut delay_ns = -(1.0 - self.random()).ln() * self.jitter_ns;
            if self.random() < 0.05 {
                delay_ns += self.period_ns as f64;
            }
            latest_ns = latest_ns.max(true_ns + delay_ns as i64);
            told.push((true_ns, device_ns, latest_ns));
        }
        told
    }
}

/// A 120 Hz tracker, 100 ppm fast, 2 ms of jitter.
fn usual() -> Simulation {
    Simulation {
        rate: 1.0001,
        offset_ns: -5_000_000_000,
        period_ns: 8_333_333,
        jitter_ns: 2e6,
        seed: 0x9e37_79b9_7f4a_7c15,
    }
}

/// The largest error of the mapped times against the truth, and whether any jumped.
fn run(mapper: &mut ClockMapper, samples: &[(i64, i64, i64)]) -> (i64, bool) {
    samples.iter().fold((0, false), |(worst_ns, jumped), &(true_ns, device_ns, received_ns)| {
        let mapped = mapper.observe(device_ns, received_ns);
        (worst_ns.max((mapped.time_ns - true_ns).abs()), jumped | mapped.jumped)
    })
}

#[test]
fn offset_and_drift_are_found_under_jitter_and_bursts() {
    for rate in [1.0, 1.0001, 0.999, 1.001] {
        let mut device = Simulation { rate, ..usual() };
        let samples = device.samples(0, 120 * 60);
        let mut mapper = ClockMapper::default();
        let (first, rest) = samples.split_at(120 * 5);
        let (_, jumped) = run(&mut mapper, first);
        assert!(!jumped, "{rate}");
        // After 5 s: half a millisecond, a quarter of the mean jitter. After 30 s: 0.15 ms.
        let (settling, settled) = rest.split_at(120 * 25);
        let (worst_ns, jumped) = run(&mut mapper, settling);
        assert!(worst_ns < 500_000 && !jumped, "{rate}: {worst_ns} ns");
        let (worst_ns, jumped) = run(&mut mapper, settled);
        assert!(worst_ns < 150_000 && !jumped, "{rate}: {worst_ns} ns");
        let drift_ppm = (1.0 / rate - 1.0) * 1e6;
        assert!((mapper.drift_ppm() - drift_ppm).abs() < 10.0, "{rate}: {} ppm", mapper.drift_ppm());
        let (true_ns, device_ns, _) = samples[samples.len() - 1];
        assert!((mapper.offset_ns() - (true_ns - device_ns)).abs() < 150_000, "{rate}");
        // Exponential jitter of 2 ms, and one in twenty a period later: 2 + 8.3 / 20.
        assert!((1.5e6..3.5e6).contains(&mapper.residual_ns()), "{}", mapper.residual_ns());
    }
}

#[test]
fn nothing_is_lost_over_a_wrap() {
    let mut device = Simulation { offset_ns: ((1 << 32) - 10_000_000) * 1000, ..usual() };
    let mut clock = crate::time::Unwrapper::new(32, false, 1000);
    let mut mapper = ClockMapper::default();
    for (number, (true_ns, device_ns, received_ns)) in device.samples(0, 120 * 30).into_iter().enumerate() {
        let raw = (device_ns / 1000) as u64 & 0xffff_ffff;
        let device_time = clock.unwrap(raw, Some(received_ns));
        let mapped = mapper.observe(device_time.time_ns, received_ns);
        assert!(!mapped.jumped && !device_time.jumped);
        let error_ns = (mapped.time_ns - true_ns).abs();
        assert!(number < 600 || error_ns < 500_000, "{number}: {error_ns} ns");
    }
}

#[test]
fn steps_of_the_device_clock_are_reported_once_and_followed() {
    // (step, samples until it is noticed): at once when ahead or far back, after a second when a little back.
    for (step_ns, within) in
        [(3_600_000_000_000, 1), (60_000_000, 30), (-2_000_000_000, 1), (-100_000_000, 150)]
    {
        let mut device = usual();
        let mut mapper = ClockMapper::default();
        let (_, jumped) = run(&mut mapper, &device.samples(0, 1200));
        assert!(!jumped);
        device.offset_ns += step_ns;
        let after = device.samples(10_000_000_000, 120 * 10);
        let jumps: Vec<usize> = (0..)
            .zip(&after)
            .filter(|&(number, &(true_ns, device_ns, received_ns))| {
                let mapped = mapper.observe(device_ns, received_ns);
                let settled_ns = (mapped.time_ns - true_ns).abs();
                assert!(number < 400 || settled_ns < 500_000, "{step_ns}, {number}: {settled_ns} ns");
                mapped.jumped
            })
            .map(|(number, _)| number)
            .collect();
        assert!(jumps.len() == 1 && jumps[0] < within, "{step_ns}: {jumps:?}");
        assert!((mapper.drift_ppm() + 100.0).abs() < 100.0, "{step_ns}: {} ppm", mapper.drift_ppm());
    }
}

#[test]
fn a_queue_of_late_samples_is_no_step() {
    let mut device = usual();
    let mut mapper = ClockMapper::default();
    run(&mut mapper, &device.samples(0, 1200));
    // The host does not read for 3 s, then gets all at once.
    let mut queue = device.samples(10_000_000_000, 600);
    for sample in &mut queue {
        sample.2 = sample.2.max(START_NS + 13_000_000_000);
    }
    let (worst_ns, jumped) = run(&mut mapper, &queue);
    assert!(!jumped && worst_ns < 1_000_000, "{worst_ns} ns");
}

#[test]
fn a_slow_start_is_no_step() {
    let mut device = usual();
    let mut queue = device.samples(0, 360);
    for sample in &mut queue {
        sample.2 = sample.2.max(START_NS + 700_000_000);
    }
    let mut mapper = ClockMapper::default();
    let (_, jumped) = run(&mut mapper, &queue[..120]);
    assert!(!jumped);
    let (worst_ns, jumped) = run(&mut mapper, &queue[120..]);
    assert!(!jumped && worst_ns < 2_000_000, "{worst_ns} ns");
}

#[test]
fn slow_and_silent_sources_keep_their_relation() {
    // 1 Hz for a minute, then a silence of ten minutes, 4 kHz after it.
    let mut device = Simulation { period_ns: 1_000_000_000, ..usual() };
    let mut mapper = ClockMapper::default();
    let (_, jumped) = run(&mut mapper, &device.samples(0, 60));
    assert!(!jumped);
    device.period_ns = 250_000;
    let (worst_ns, jumped) = run(&mut mapper, &device.samples(660_000_000_000, 4000));
    assert!(!jumped && worst_ns < 200_000_000, "{worst_ns} ns");
    let (worst_ns, jumped) = run(&mut mapper, &device.samples(661_000_000_000, 4000));
    assert!(!jumped && worst_ns < 2_000_000, "{worst_ns} ns");
}

#[test]
fn disorder_is_placed_between_neighbours() {
    let mut mapper = ClockMapper::default();
    let ms = 1_000_000;
    for device_ms in [0, 10, 20] {
        mapper.observe(device_ms * ms, (1000 + device_ms) * ms);
    }
    assert_eq!(mapper.observe(15 * ms, 1022 * ms), Mapped { time_ns: 1015 * ms, jumped: false });
    assert_eq!(mapper.observe(20 * ms, 1023 * ms), Mapped { time_ns: 1020 * ms, jumped: false });
    assert_eq!(mapper.observe(-5 * ms, 1024 * ms), Mapped { time_ns: 995 * ms, jumped: false });
}

/// Device times and arrivals with everything in them that a device or a host can do.
fn anything() -> impl Strategy<Value = Vec<(i64, i64)>> {
    let step = prop_oneof![
        8 => 0i64..20_000_000,
        2 => -20_000_000i64..20_000_000,
        1 => Just(0i64),
        1 => -5_000_000_000i64..5_000_000_000,
        1 => any::<i64>(),
    ];
    let passed =
        prop_oneof![8 => 0i64..20_000_000, 1 => Just(0i64), 1 => 0i64..3_000_000_000, 1 => any::<i64>()];
    (any::<i64>(), any::<i64>(), prop::collection::vec((step, passed), 0..400)).prop_map(
        |(mut device_ns, mut received_ns, steps)| {
            let mut told = Vec::new();
            for (step, passed) in steps {
                device_ns = device_ns.saturating_add(step);
                received_ns = received_ns.saturating_add(passed);
                told.push((device_ns, received_ns));
            }
            told
        },
    )
}

proptest! {
    #[test]
    fn what_is_guaranteed_holds(told in anything()) {
        let mut mapper = ClockMapper::default();
        // Mapped since the last jump, latest last.
        let mut since: Vec<(i64, i64)> = Vec::new();
        for (device_ns, received_ns) in told {
            let mapped = mapper.observe(device_ns, received_ns);
            prop_assert!(mapped.time_ns <= received_ns);
            prop_assert!(mapper.drift_ppm().is_finite() && mapper.residual_ns().is_finite());
            prop_assert!(mapper.drift_ppm().abs() <= MAX_DRIFT * 1e6);
            if mapped.jumped {
                since.clear();
            }
            let newest = since.iter().map(|pair| pair.0).max();
            if newest.is_none_or(|newest| device_ns > newest) {
                prop_assert!(since.iter().all(|pair| pair.1 <= mapped.time_ns));
            }
            // Fewer than 64 in all are ordered completely.
            if since.len() < KNOTS {
                let oldest = since.iter().map(|pair| pair.0).min();
                for &(other_ns, time_ns) in &since {
                    let ordered = match device_ns.cmp(&other_ns) {
                        std::cmp::Ordering::Less => mapped.time_ns <= time_ns,
                        std::cmp::Ordering::Equal => mapped.time_ns == time_ns,
                        std::cmp::Ordering::Greater => mapped.time_ns >= time_ns,
                    };
                    prop_assert!(ordered || oldest.is_none(), "{device_ns} {other_ns}");
                }
            }
            since.push((device_ns, mapped.time_ns));
        }
    }
}
