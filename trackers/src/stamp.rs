//! What every live source does to a sample it got: the device time onto the host clock, what was lost
//! counted, and whether it is new at all.

use crate::sample::GazeSample;
use crate::source::SourceEvent;
use crate::time::{ClockMapper, FreshnessMonitor, FreshnessSettings, content_hash};

/// A gap is a loss from this many usual intervals on. Lower counts jitter of the stamps as loss, higher
/// misses single samples.
const GAP_INTERVALS: f64 = 1.6;
/// Longer gaps, ns, are no loss of samples but a source that was silent.
const MAX_GAP_NS: i64 = 10_000_000_000;

/// How a [`Stamper`] judges a source.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StampSettings {
    /// When the source counts as stalled.
    pub freshness: FreshnessSettings,
    /// Samples per second that the source promises. Gaps in the device time that are longer than this
    /// allows are counted as losses; `None` counts none, as for a source without a fixed rate.
    pub rate_hz: Option<f64>,
}

/// Makes events of raw samples. One for each source, kept over a disconnect ([`Stamper::reconnected`]).
#[derive(Clone, Debug)]
pub struct Stamper {
    settings: StampSettings,
    clock: ClockMapper,
    freshness: FreshnessMonitor,
    latest_device_ns: Option<i64>,
}

impl Stamper {
    /// For a new source.
    #[must_use]
    pub fn new(settings: StampSettings) -> Self {
        Self {
            settings,
            clock: ClockMapper::default(),
            freshness: FreshnessMonitor::new(settings.freshness, settings.rate_hz),
            latest_device_ns: None,
        }
    }

    /// A sample of which `device_time_ns` (unwrapped) and `received_ns` are set. Sets `time_ns` and
    /// appends, in this order where they apply: [`SourceEvent::Lost`], [`SourceEvent::Recovered`], the
    /// sample, [`SourceEvent::Stalled`]. Says whether the device clock jumped.
    pub fn stamp(&mut self, mut sample: GazeSample, events: &mut Vec<SourceEvent>) -> bool {
        let mut jumped = false;
        sample.time_ns = sample.received_ns;
        if let Some(device_ns) = sample.device_time_ns {
            let mapped = self.clock.observe(device_ns, sample.received_ns);
            (sample.time_ns, jumped) = (mapped.time_ns, mapped.jumped);
            if jumped {
                self.latest_device_ns = None;
                self.freshness.clock_restarted();
            }
            if let Some(samples) = self.lost_before(device_ns) {
                events.push(SourceEvent::Lost { samples });
            }
            self.latest_device_ns = self.latest_device_ns.max(Some(device_ns));
        }
        let content = content_hash(&sample);
        let event = self.freshness.observe(sample.device_time_ns, content, sample.received_ns).event();
        match event {
            Some(recovered @ SourceEvent::Recovered { .. }) => {
                events.extend([recovered, SourceEvent::Sample(sample)]);
            }
            other => {
                events.push(SourceEvent::Sample(sample));
                events.extend(other);
            }
        }
        jumped
    }

    /// Nothing more has come up to `now_ns`, host clock: appends [`SourceEvent::Stalled`] if that is
    /// too long.
    pub fn check(&mut self, now_ns: i64, events: &mut Vec<SourceEvent>) {
        events.extend(self.freshness.check(now_ns).event());
    }

    /// The source is there again after an absence: its clock may have started anew, and what was not
    /// made is not lost. A stall goes on until a new sample ends it.
    pub fn reconnected(&mut self) {
        self.clock = ClockMapper::default();
        self.latest_device_ns = None;
        self.freshness.clock_restarted();
    }

    /// Another rate is promised from now on.
    pub fn set_rate(&mut self, rate_hz: Option<f64>) {
        self.settings.rate_hz = rate_hz;
    }

    /// The relation of the clocks.
    #[must_use]
    pub fn clock(&self) -> &ClockMapper {
        &self.clock
    }

    /// The source is reported as stalled.
    #[must_use]
    pub fn is_stalled(&self) -> bool {
        self.freshness.is_stalled()
    }

    fn lost_before(&self, device_ns: i64) -> Option<u64> {
        let gap_ns = device_ns.saturating_sub(self.latest_device_ns?);
        let intervals = gap_ns as f64 * 1e-9 * self.settings.rate_hz?;
        (intervals >= GAP_INTERVALS && gap_ns <= MAX_GAP_NS)
            .then(|| (intervals.round() - 1.0).max(1.0) as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::EyeSample;
    use glam::DVec3;

    const MS: i64 = 1_000_000;

    /// Device time and arrival in ms; `x` makes samples differ.
    fn raw(device_ms: i64, received_ms: i64, x: f64) -> GazeSample {
        let combined =
            EyeSample { valid: true, direction: Some(DVec3::new(x, 0.0, -1.0)), ..EyeSample::default() };
        GazeSample {
            device_time_ns: Some(device_ms * MS),
            received_ns: received_ms * MS,
            combined,
            ..GazeSample::default()
        }
    }

    fn stamper(rate_hz: f64) -> Stamper {
        Stamper::new(StampSettings { rate_hz: Some(rate_hz), ..StampSettings::default() })
    }

    #[test]
    fn gaps_are_losses_and_late_samples_get_their_time() {
        let mut stamper = stamper(100.0);
        let mut events = Vec::new();
        for (device_ms, received_ms) in [(0, 1000), (10, 1010), (20, 1027), (30, 1030), (70, 1070)] {
            stamper.stamp(raw(device_ms, received_ms, device_ms as f64), &mut events);
        }
        let told: Vec<_> = events
            .iter()
            .map(|event| match event {
                SourceEvent::Sample(sample) => sample.time_ns / MS,
                SourceEvent::Lost { samples } => -(*samples as i64),
                other => panic!("{other:?}"),
            })
            .collect();
        assert_eq!(told, [1000, 1010, 1020, 1030, -3, 1070]);
    }

    #[test]
    fn a_frozen_sample_and_its_end_are_told_around_the_samples() {
        let mut stamper = stamper(100.0);
        let mut events = Vec::new();
        for number in 0..=60 {
            stamper.stamp(raw(number * 10, number * 10, 0.5), &mut events);
        }
        let at = events.iter().position(|event| matches!(event, SourceEvent::Stalled { .. }));
        assert_eq!(at, Some(51), "after the sample at 500 ms");
        assert_eq!(events[51], SourceEvent::Stalled { since_ns: 0 });
        events.clear();
        stamper.stamp(raw(610, 610, 0.25), &mut events);
        assert_eq!(events[0], SourceEvent::Recovered { after_ns: 610 * MS });
        assert!(matches!(events[1], SourceEvent::Sample(_)) && events.len() == 2);
    }

    #[test]
    fn silence_is_a_stall_and_an_absence_no_loss() {
        let mut stamper = stamper(100.0);
        let mut events = Vec::new();
        stamper.stamp(raw(0, 0, 0.0), &mut events);
        events.clear();
        stamper.check(50 * MS, &mut events);
        assert_eq!(events, []);
        stamper.check(101 * MS, &mut events);
        assert_eq!(events, [SourceEvent::Stalled { since_ns: 0 }]);
        events.clear();
        stamper.reconnected();
        stamper.stamp(raw(5000, 3000, 1.0), &mut events);
        assert_eq!(events[0], SourceEvent::Recovered { after_ns: 3000 * MS });
        assert!(matches!(&events[1], SourceEvent::Sample(sample) if sample.time_ns == 3000 * MS));
    }

    #[test]
    fn without_a_device_time_the_arrival_counts() {
        let mut stamper = stamper(100.0);
        let mut events = Vec::new();
        let sample = GazeSample { device_time_ns: None, ..raw(0, 77, 0.0) };
        assert!(!stamper.stamp(sample, &mut events));
        assert_eq!(events, [SourceEvent::Sample(GazeSample { time_ns: 77 * MS, ..sample })]);
    }
}
