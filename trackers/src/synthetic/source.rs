//! The synthetic eye as a source, and as a recording.

use super::eye::TrueEye;
use super::settings::SyntheticSettings;
use super::tracker::SyntheticTracker;
use super::truth::{DIRECTION_COLUMNS, TRUTH_COLUMN, Truth};
use crate::error::{Error, Result};
use crate::recording::{ExtraColumn, Recording, RecordingInfo, Space};
use crate::sample::GazeSample;
use crate::source::{GazeSource, SourceEvent, SourceInfo};
use crate::time::HOST_CLOCK;

/// Samples that one poll may bring; what is older is lost, as in a reader's buffer that runs over.
const MAX_PER_POLL: i64 = 1 << 16;
/// Samples that a recording may have: about 14 hours at 1 kHz.
const MAX_SAMPLES: f64 = 5e7;

/// A person who does not exist, with a tracker that does not either.
///
/// As a source it lives in the caller's time: its time zero is that of the first poll, or
/// [`SyntheticEye::starting_at`].
#[derive(Clone, Debug)]
pub struct SyntheticEye {
    tracker: SyntheticTracker,
    info: SourceInfo,
    seed: u64,
    rate_hz: f64,
    start_ns: Option<i64>,
    /// Number of the next sample.
    next: i64,
    /// Nothing arrives before what was made before it, ns.
    arrived_ns: i64,
    /// Samples that were lost since the last one that arrived: told before the next one, as a reader
    /// finds out by the gap.
    lost: i64,
}

impl SyntheticEye {
    /// An eye and a tracker whose every sample follows from the settings and the seed.
    ///
    /// # Errors
    /// [`Error::Setting`] for a setting out of its range.
    pub fn new(settings: SyntheticSettings, seed: u64) -> Result<Self> {
        let tracker = SyntheticTracker::new(&settings, seed)?;
        let rate_hz = settings.tracker.rate_hz;
        let info = SourceInfo {
            name: format!("synthetic eye {seed}"),
            device_clock: clock_name(&settings),
            host_clock: HOST_CLOCK.into(),
            rate_hz: Some(rate_hz),
        };
        Ok(Self { tracker, info, seed, rate_hz, start_ns: None, next: 0, arrived_ns: i64::MIN, lost: 0 })
    }

    /// Sets the host time of the eye's time zero.
    #[must_use]
    pub fn starting_at(mut self, host_ns: i64) -> Self {
        self.start_ns = Some(host_ns);
        self
    }

    /// The tracker and its eye, in the eye's own time.
    pub fn tracker(&mut self) -> &mut SyntheticTracker {
        &mut self.tracker
    }

    /// The true state of the eye at a host time; before the first poll, in the eye's own time.
    #[must_use]
    pub fn truth_at(&mut self, host_ns: i64) -> TrueEye {
        self.tracker.truth_at(host_ns.saturating_sub(self.start_ns.unwrap_or(0)))
    }

    /// The time of a sample since the start, ns.
    fn sample_ns(number: i64, rate_hz: f64) -> i64 {
        (number as f64 * 1e9 / rate_hz).round() as i64
    }

    /// A recording from the eye's time zero on, and its truth. It does not depend on what was polled.
    /// Labels and true directions are extra columns too ([`TRUTH_COLUMN`], [`DIRECTION_COLUMNS`]).
    ///
    /// # Errors
    /// [`Error::Setting`] for a rate outside 1 Hz to 10 kHz, a negative duration, or more than 50 million
    /// samples.
    pub fn record(&mut self, duration_ns: i64, rate_hz: f64) -> Result<(Recording, Truth)> {
        if !(1.0..=1e4).contains(&rate_hz) {
            return Err(Error::Setting(format!("a rate of {rate_hz} Hz cannot be made; give 1 to 10000")));
        }
        let expected = duration_ns as f64 * 1e-9 * rate_hz;
        if !(0.0..=MAX_SAMPLES).contains(&expected) {
            return Err(Error::Setting(format!(
                "{:.0} s at {rate_hz} Hz is {expected:.0} samples; give 0 to {MAX_SAMPLES:.0}",
                duration_ns as f64 * 1e-9
            )));
        }
        let mut recording = Recording::new(self.recording_info(rate_hz));
        let mut labels = Vec::with_capacity(expected as usize + 1);
        let mut truth = Truth::default();
        truth.directions.reserve(expected as usize + 1);
        let mut arrived_ns = i64::MIN;
        for number in 0.. {
            let time_ns = Self::sample_ns(number, rate_hz);
            if time_ns >= duration_ns {
                break;
            }
            if self.tracker.dropped(number) {
                continue;
            }
            let (mut sample, state) = self.tracker.sample(number, time_ns);
            arrived_ns = self.arrival_ns(number, rate_hz).max(arrived_ns);
            sample.received_ns = arrived_ns;
            recording.push(&sample);
            labels.push(f64::from(state.kind.code()));
            truth.directions.push(state.direction);
        }
        recording.extra.push(ExtraColumn { name: TRUTH_COLUMN.into(), values: labels });
        for (axis, name) in DIRECTION_COLUMNS.into_iter().enumerate() {
            let values = truth.directions.iter().map(|direction| direction[axis]).collect();
            recording.extra.push(ExtraColumn { name: name.into(), values });
        }
        truth.events = self.tracker.eye().events(0, duration_ns)?;
        Ok((recording, truth))
    }

    fn recording_info(&mut self, rate_hz: f64) -> RecordingInfo {
        let device = format!("synthetic eye {}", self.seed);
        RecordingInfo {
            format: "synthetic",
            device,
            space: Space::View,
            nominal_rate_hz: Some(rate_hz),
            device_clock: self.info.device_clock.clone(),
            ..RecordingInfo::default()
        }
    }

    /// When a sample arrives, if none before it is later; since the start.
    fn arrival_ns(&self, number: i64, rate_hz: f64) -> i64 {
        let with = self.tracker.arrives_with(number);
        Self::sample_ns(with, rate_hz).saturating_add(self.tracker.delay_ns(with))
    }

    /// The next sample if it has arrived by `now_ns`. One that was dropped holds up none behind it.
    fn take(&mut self, start_ns: i64, now_ns: i64) -> Taken {
        if self.tracker.dropped(self.next) {
            self.next += 1;
            return Taken::Dropped;
        }
        let arrival_ns = start_ns.saturating_add(self.arrival_ns(self.next, self.rate_hz));
        let arrival_ns = arrival_ns.max(self.arrived_ns);
        if arrival_ns > now_ns {
            return Taken::NotYet;
        }
        let number = self.next;
        self.next += 1;
        self.arrived_ns = arrival_ns;
        let (mut sample, _) = self.tracker.sample(number, Self::sample_ns(number, self.rate_hz));
        sample.time_ns = sample.time_ns.saturating_add(start_ns);
        sample.received_ns = arrival_ns;
        Taken::Sample(sample)
    }
}

// Nearly always a sample, and gone at once.
#[allow(clippy::large_enum_variant)]
enum Taken {
    Sample(GazeSample),
    Dropped,
    NotYet,
}

fn clock_name(settings: &SyntheticSettings) -> String {
    let tracker = &settings.tracker;
    let bits = if tracker.clock_bits > 0 { tracker.clock_bits } else { 64 };
    format!("synthetic ({} ns ticks, {bits} bit)", tracker.clock_tick_ns)
}

impl GazeSource for SyntheticEye {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    fn poll(&mut self, now_ns: i64, events: &mut Vec<SourceEvent>) -> Result<()> {
        let start_ns = *self.start_ns.get_or_insert(now_ns);
        let elapsed_ns = now_ns.saturating_sub(start_ns);
        let newest = (elapsed_ns as f64 * 1e-9 * self.rate_hz) as i64;
        let behind = newest.saturating_sub(self.next).saturating_sub(MAX_PER_POLL).max(0);
        self.next += behind;
        self.lost = self.lost.saturating_add(behind);
        while self.next <= newest {
            match self.take(start_ns, now_ns) {
                Taken::NotYet => break,
                Taken::Dropped => self.lost = self.lost.saturating_add(1),
                Taken::Sample(sample) => {
                    let samples = std::mem::take(&mut self.lost) as u64;
                    if samples > 0 {
                        events.push(SourceEvent::Lost { samples });
                    }
                    events.push(SourceEvent::Sample(sample));
                }
            }
        }
        Ok(())
    }
}
