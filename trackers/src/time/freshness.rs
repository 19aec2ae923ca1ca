//! Whether a source still tells anything new, by its own time and its own values: that samples arrive
//! proves nothing. Runtimes are known that went on stamping one frozen sample as current for minutes.

use super::SET_BACK_NS;
use crate::sample::{EyeSample, GazeSample};
use crate::source::SourceEvent;

/// When a source counts as stalled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FreshnessSettings {
    /// No new sample for so long, ns, or for [`FreshnessSettings::intervals`] where that is longer.
    /// Default 100 ms: twelve samples of a 120 Hz tracker, and about the time until a held gaze is
    /// likely wrong (a tenth of the pauses between saccades are no longer than that). Shorter reports
    /// hiccups of delivery, longer keeps a dead gaze in use.
    pub silence_ns: i64,
    /// Mean intervals between new samples that must pass at the least, so that a slow source is not
    /// called stalled between any two of its samples. Default 5.
    pub intervals: u32,
    /// Values that stay the same bit for bit for so long, ns, while their stamps advance, are one old
    /// sample stamped anew; `None` never takes them for that, as for a gaze told by a mouse. Default
    /// 500 ms: an eye at rest drifts by about a quarter of a degree in that time, and every tracker's
    /// noise is larger than the last bit of its values, so even one that rounds to a pixel or a tenth of
    /// a degree repeats itself for a few samples at most.
    pub same_ns: Option<i64>,
}

impl Default for FreshnessSettings {
    fn default() -> Self {
        Self { silence_ns: 100_000_000, intervals: 5, same_ns: Some(500_000_000) }
    }
}

/// What a sample, or its absence, says of the source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Freshness {
    /// The sample is new.
    Fresh,
    /// Nothing new, but not for too long; or already reported as stalled.
    Old,
    /// Nothing new for too long; told once.
    Stalled {
        /// Host time of the last new sample, ns.
        since_ns: i64,
    },
    /// The first new sample after that.
    Recovered {
        /// How long it had stalled, ns.
        after_ns: i64,
    },
}

impl Freshness {
    /// The event to tell, if there is one.
    #[must_use]
    pub fn event(self) -> Option<SourceEvent> {
        match self {
            Self::Fresh | Self::Old => None,
            Self::Stalled { since_ns } => Some(SourceEvent::Stalled { since_ns }),
            Self::Recovered { after_ns } => Some(SourceEvent::Recovered { after_ns }),
        }
    }
}

/// The interval taken for that of a source of which only one sample is known: 200 ms, so that one of
/// 1 Hz is not called stalled before its second sample.
const FIRST_INTERVAL_NS: i64 = 200_000_000;

/// Watches a source.
#[derive(Clone, Debug)]
pub struct FreshnessMonitor {
    settings: FreshnessSettings,
    latest_device_ns: Option<i64>,
    /// What the latest new sample said, and when it first said so.
    content: Option<u64>,
    content_since_ns: i64,
    /// Host time of the latest sample whose stamp was new.
    advanced_ns: Option<i64>,
    interval_ns: Option<i64>,
    stalled_since_ns: Option<i64>,
}

impl FreshnessMonitor {
    /// Watches with `settings`; `rate_hz` is what the source promises, if it does.
    #[must_use]
    pub fn new(settings: FreshnessSettings, rate_hz: Option<f64>) -> Self {
        let promised = rate_hz.filter(|rate| *rate > 0.0).map(|rate| (1e9 / rate) as i64);
        Self {
            settings,
            latest_device_ns: None,
            content: None,
            content_since_ns: 0,
            advanced_ns: None,
            interval_ns: promised,
            stalled_since_ns: None,
        }
    }

    /// The source is reported as stalled and has told nothing new since.
    #[must_use]
    pub fn is_stalled(&self) -> bool {
        self.stalled_since_ns.is_some()
    }

    /// The source's clock starts anew: the next time on it is a new one, whatever it is.
    pub fn clock_restarted(&mut self) {
        self.latest_device_ns = None;
    }

    /// A sample came: its time on the source's clock, what it says ([`content_hash`]; `None` where it
    /// has no valid gaze, which is never taken for a repetition), and when it arrived.
    pub fn observe(
        &mut self,
        device_time_ns: Option<i64>,
        content: Option<u64>,
        received_ns: i64,
    ) -> Freshness {
        let advanced = match (device_time_ns, self.latest_device_ns) {
            (Some(now), Some(latest)) => now > latest || now < latest.saturating_sub(SET_BACK_NS),
            _ => true,
        };
        if !advanced {
            return self.check(received_ns);
        }
        self.latest_device_ns = device_time_ns.or(self.latest_device_ns);
        let repeated = self.settings.same_ns.is_some() && content.is_some() && content == self.content;
        if !repeated {
            self.content = content;
            self.content_since_ns = received_ns;
        }
        let same_ns = received_ns.saturating_sub(self.content_since_ns);
        if self.stalled_since_ns.is_none()
            && repeated
            && self.settings.same_ns.is_some_and(|limit| same_ns >= limit)
        {
            self.advanced_ns = Some(received_ns);
            return self.stalled(self.content_since_ns);
        }
        let silence_ns = self.advanced_ns.map(|then| received_ns.saturating_sub(then));
        self.advanced_ns = Some(received_ns);
        match self.stalled_since_ns {
            Some(_) if repeated => Freshness::Old,
            Some(since_ns) => {
                self.stalled_since_ns = None;
                Freshness::Recovered { after_ns: received_ns.saturating_sub(since_ns) }
            }
            None => {
                self.learn_interval(silence_ns);
                if repeated { Freshness::Old } else { Freshness::Fresh }
            }
        }
    }

    /// Nothing came up to `now_ns`, on the host clock.
    pub fn check(&mut self, now_ns: i64) -> Freshness {
        let Some(advanced_ns) = self.advanced_ns else { return Freshness::Old };
        let interval_ns = self.interval_ns.unwrap_or(FIRST_INTERVAL_NS);
        let limit_ns =
            interval_ns.saturating_mul(i64::from(self.settings.intervals)).max(self.settings.silence_ns);
        if self.stalled_since_ns.is_none() && now_ns.saturating_sub(advanced_ns) > limit_ns {
            return self.stalled(advanced_ns);
        }
        Freshness::Old
    }

    fn stalled(&mut self, since_ns: i64) -> Freshness {
        self.stalled_since_ns = Some(since_ns);
        Freshness::Stalled { since_ns }
    }

    /// A mean over about the latest eight.
    fn learn_interval(&mut self, silence_ns: Option<i64>) {
        let Some(silence_ns) = silence_ns.map(|silence_ns| silence_ns.max(0)) else { return };
        let mean_ns = self.interval_ns.unwrap_or(silence_ns);
        self.interval_ns = Some(mean_ns + silence_ns.saturating_sub(mean_ns) / 8);
    }
}

/// A number that differs where what the valid eyes tell differs in any bit; `None` where none is valid.
/// The head is left out: it may have another source, and moves on while a gaze is frozen.
#[must_use]
pub fn content_hash(sample: &GazeSample) -> Option<u64> {
    let eyes = [&sample.combined, &sample.left, &sample.right];
    if !eyes.iter().any(|eye| eye.valid) {
        return None;
    }
    Some(eyes.into_iter().filter(|eye| eye.valid).fold(FNV_OFFSET, hash_eye))
}

/// Parameters of the 64-bit FNV-1a hash, taken a word at a time.
const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const FNV_PRIME: u64 = 0x0000_0100_0000_01b3;

fn hash_eye(hash: u64, eye: &EyeSample) -> u64 {
    let origin = eye.origin_m.unwrap_or_default();
    let direction = eye.direction.unwrap_or_default();
    let point = eye.point.unwrap_or_default();
    let told = [eye.confidence, eye.pupil_mm, eye.openness].map(Option::unwrap_or_default);
    origin
        .to_array()
        .into_iter()
        .chain(direction.to_array())
        .chain(point.to_array())
        .chain(told)
        // The multiplication only carries upwards: the rotation brings high bits down again.
        .fold(hash, |hash, value| ((hash ^ value.to_bits()).wrapping_mul(FNV_PRIME)).rotate_left(29))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    const MS: i64 = 1_000_000;

    fn monitor() -> FreshnessMonitor {
        FreshnessMonitor::new(FreshnessSettings::default(), Some(100.0))
    }

    #[test]
    fn a_source_that_stops_is_stalled_once_and_recovers() {
        let mut monitor = monitor();
        for number in 0..10i64 {
            let told = monitor.observe(Some(number), Some(number as u64), number * 10 * MS);
            assert_eq!(told, Freshness::Fresh);
        }
        assert_eq!(monitor.check(190 * MS), Freshness::Old);
        assert_eq!(monitor.check(191 * MS), Freshness::Stalled { since_ns: 90 * MS });
        assert_eq!(monitor.check(500 * MS), Freshness::Old);
        assert!(monitor.is_stalled());
        let told = monitor.observe(Some(11), Some(11), 590 * MS);
        assert_eq!(told, Freshness::Recovered { after_ns: 500 * MS });
        assert!(!monitor.is_stalled());
    }

    #[test]
    fn samples_that_arrive_with_an_old_stamp_are_a_stall() {
        let mut monitor = monitor();
        monitor.observe(Some(7), Some(1), 0);
        let told: Vec<_> = (1..=12i64)
            .map(|number| monitor.observe(Some(7), Some(number as u64), number * 10 * MS))
            .collect();
        assert_eq!(told[9], Freshness::Old);
        assert_eq!(told[10], Freshness::Stalled { since_ns: 0 });
        assert_eq!(told[11], Freshness::Old);
    }

    #[test]
    fn a_frozen_sample_stamped_anew_is_a_stall() {
        let mut monitor = monitor();
        monitor.observe(Some(0), Some(1), 0);
        let mut stalls = Vec::new();
        for number in 1..200i64 {
            let told = monitor.observe(Some(number * 10 * MS), Some(42), number * 10 * MS);
            assert_eq!(monitor.check(number * 10 * MS + 5 * MS), Freshness::Old, "silence is no issue");
            if told.event().is_some() {
                stalls.push((number, told));
            }
        }
        assert_eq!(stalls, [(51, Freshness::Stalled { since_ns: 10 * MS })]);
        let told = monitor.observe(Some(2000 * MS), Some(43), 2000 * MS);
        assert_eq!(told, Freshness::Recovered { after_ns: 1990 * MS });
    }

    #[test]
    fn blinks_coarse_steps_and_a_mouse_are_no_stall() {
        let mut lost = monitor();
        let mut coarse = monitor();
        let still = FreshnessSettings { same_ns: None, ..FreshnessSettings::default() };
        let mut mouse = FreshnessMonitor::new(still, None);
        for number in 0..500i64 {
            let time_ns = number * 10 * MS;
            assert_eq!(lost.observe(Some(time_ns), None, time_ns).event(), None);
            assert_eq!(coarse.observe(Some(time_ns), Some(number as u64 / 40), time_ns).event(), None);
            assert_eq!(mouse.observe(None, Some(1), time_ns).event(), None);
        }
    }

    #[test]
    fn a_mouse_that_rests_recovers_after_a_silence() {
        let still = FreshnessSettings { same_ns: None, ..FreshnessSettings::default() };
        let mut mouse = FreshnessMonitor::new(still, Some(100.0));
        assert_eq!(mouse.observe(None, Some(1), 0), Freshness::Fresh);
        assert_eq!(mouse.check(300 * MS), Freshness::Stalled { since_ns: 0 });
        assert_eq!(mouse.observe(None, Some(1), 400 * MS), Freshness::Recovered { after_ns: 400 * MS });
    }

    #[test]
    fn a_slow_source_is_given_its_time() {
        let mut monitor = FreshnessMonitor::new(FreshnessSettings::default(), None);
        for number in 0..20i64 {
            assert_eq!(monitor.check(number * 1000 * MS - 1).event(), None);
            assert_eq!(monitor.observe(None, Some(number as u64), number * 1000 * MS), Freshness::Fresh);
        }
        // Five intervals of 1 s after the last.
        assert_eq!(monitor.check(24_000 * MS), Freshness::Old);
        assert_eq!(monitor.check(24_001 * MS), Freshness::Stalled { since_ns: 19_000 * MS });
    }

    #[test]
    fn a_clock_set_back_is_new_and_disorder_is_not() {
        let mut monitor = monitor();
        monitor.observe(Some(10_000 * MS), Some(1), 0);
        assert_eq!(monitor.observe(Some(9_990 * MS), Some(2), MS), Freshness::Old);
        assert_eq!(monitor.observe(Some(3 * MS), Some(3), 2 * MS), Freshness::Fresh);
    }

    #[test]
    fn the_hash_sees_the_last_bit_and_only_valid_eyes() {
        let sample = |x: f64, valid| {
            let eye = EyeSample { valid, direction: Some(DVec3::new(x, 0.0, -1.0)), ..EyeSample::default() };
            GazeSample { left: eye, ..GazeSample::at(0) }
        };
        assert_ne!(content_hash(&sample(0.1, true)), content_hash(&sample(0.1f64.next_up(), true)));
        assert_eq!(
            content_hash(&sample(0.1, true)),
            content_hash(&GazeSample { time_ns: 5, ..sample(0.1, true) })
        );
        assert_eq!(content_hash(&sample(0.1, false)), None);
    }
}
