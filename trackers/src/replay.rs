//! A recording as a live source.

use crate::error::{Error, Result};
use crate::recording::Recording;
use crate::source::{GazeSource, SourceEvent, SourceInfo};
use crate::time::HOST_CLOCK;
use std::sync::Arc;

/// How a recording is replayed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReplaySettings {
    /// Host time at which the earliest sample arrives, ns.
    pub start_ns: i64,
    /// Recorded seconds in one second of the replay.
    pub speed: f64,
    /// Begins anew after the last sample, without end, instead of telling [`SourceEvent::Ended`].
    pub looped: bool,
}

impl Default for ReplaySettings {
    fn default() -> Self {
        Self { start_ns: 0, speed: 1.0, looped: false }
    }
}

/// Tells the samples of a recording as they arrived, on a host clock of the caller's: a stepped one, so
/// that every run is the same bit by bit, or [`crate::time::host_now_ns`].
///
/// A sample is told by the first poll at or after its arrival. Host times (`received_ns`, `time_ns`) are
/// moved so that the earliest arrival is at the start, and divided by the speed; device times and all
/// values are as recorded. Samples are told in the order of their arrival; those of one arrival in the
/// order of the file. So a recording whose rows are out of order by arrival is told in order, and one
/// whose samples arrived out of order by `time_ns` is told just so, as it was live.
///
/// Looped, each round begins one usual interval after the last arrival of the round before, and device
/// times go on by the same length. One poll then tells no more than one round; the next goes on.
#[derive(Debug)]
pub struct Replay {
    info: SourceInfo,
    recording: Arc<Recording>,
    settings: ReplaySettings,
    /// Indices by arrival; empty where the file is in that order.
    order: Vec<u32>,
    /// Recorded arrival of the first sample, ns.
    origin_ns: i64,
    /// Recorded length of a round, ns.
    round_ns: i64,
    round: u64,
    next: usize,
    ended: bool,
}

impl Replay {
    /// Replays a recording.
    ///
    /// # Errors
    /// [`Error::Setting`]: the speed is not a number above zero, or the recording has more samples than
    /// `u32` counts.
    pub fn new(recording: Arc<Recording>, mut settings: ReplaySettings) -> Result<Self> {
        // Nothing can be repeated without end but never told.
        settings.looped &= !recording.is_empty();
        let speed = settings.speed;
        if !(speed.is_finite() && speed > 0.0) {
            return Err(Error::Setting(format!("a replay at speed {speed} never goes on; give one above 0")));
        }
        let count = u32::try_from(recording.len())
            .map_err(|_| Error::Setting("the recording has too many samples to replay; split it".into()))?;
        let arrivals = || recording.samples().map(|sample| sample.received_ns);
        let mut order = Vec::new();
        if !arrivals().is_sorted() {
            let received: Vec<i64> = arrivals().collect();
            order = (0..count).collect();
            order.sort_by_key(|index| received[*index as usize]);
        }
        let origin_ns = arrivals().min().unwrap_or(0);
        let last_ns = arrivals().max().unwrap_or(0);
        let interval_ns = recording.rate_hz().map_or(1_000_000, |rate_hz| (1e9 / rate_hz) as i64).max(1);
        let info = SourceInfo {
            name: format!(
                "replay of {}",
                if recording.info.device.is_empty() { "a recording" } else { &recording.info.device }
            ),
            device_clock: recording.info.device_clock.clone(),
            host_clock: HOST_CLOCK.to_owned(),
            rate_hz: recording.info.nominal_rate_hz.or(recording.rate_hz()).map(|rate_hz| rate_hz * speed),
        };
        Ok(Self {
            info,
            recording,
            settings,
            order,
            origin_ns,
            round_ns: last_ns.saturating_sub(origin_ns).saturating_add(interval_ns),
            round: 0,
            next: 0,
            ended: false,
        })
    }

    /// Everything was told.
    #[must_use]
    pub fn is_ended(&self) -> bool {
        self.ended
    }

    /// A recorded host time in the replay.
    fn host_ns(&self, recorded_ns: i64) -> i64 {
        let since = i128::from(recorded_ns) - i128::from(self.origin_ns);
        let since = since + i128::from(self.round) * i128::from(self.round_ns);
        // At the speed it was recorded at there is no rounding.
        let since = if self.settings.speed == 1.0 {
            since
        } else {
            (since as f64 / self.settings.speed).round() as i128
        };
        let host = i128::from(self.settings.start_ns).saturating_add(since);
        host.clamp(i128::from(i64::MIN), i128::from(i64::MAX)) as i64
    }

    fn device_ns(&self, recorded_ns: i64) -> i64 {
        let passed = i128::from(self.round) * i128::from(self.round_ns);
        let device = i128::from(recorded_ns) + passed;
        device.clamp(i128::from(i64::MIN), i128::from(i64::MAX)) as i64
    }
}

impl GazeSource for Replay {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    fn poll(&mut self, now_ns: i64, events: &mut Vec<SourceEvent>) -> Result<()> {
        // Without end, a poll in the far future must still return.
        let mut left = if self.settings.looped { self.recording.len() } else { usize::MAX };
        while !self.ended && left > 0 {
            let index = self.order.get(self.next).map_or(self.next, |index| *index as usize);
            let Some(mut sample) = self.recording.get(index) else {
                if self.settings.looped {
                    self.round += 1;
                    self.next = 0;
                    continue;
                }
                self.ended = true;
                events.push(SourceEvent::Ended);
                break;
            };
            sample.received_ns = self.host_ns(sample.received_ns);
            if sample.received_ns > now_ns {
                break;
            }
            sample.time_ns = self.host_ns(sample.time_ns);
            sample.device_time_ns = sample.device_time_ns.map(|device_ns| self.device_ns(device_ns));
            self.next += 1;
            left -= 1;
            events.push(SourceEvent::Sample(sample));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::RecordingInfo;
    use crate::sample::GazeSample;

    const MS: i64 = 1_000_000;

    /// Device time, arrival and mapped time in ms of each sample.
    fn recording(times_ms: &[(i64, i64, i64)]) -> Arc<Recording> {
        let mut recording = Recording::new(RecordingInfo::default());
        for &(device_ms, received_ms, time_ms) in times_ms {
            recording.push(&GazeSample {
                device_time_ns: Some(device_ms * MS),
                received_ns: received_ms * MS,
                time_ns: time_ms * MS,
                ..GazeSample::default()
            });
        }
        Arc::new(recording)
    }

    /// (device, received, time) in ms of the samples told; the end is (0, 0, 0).
    fn told(replay: &mut Replay, now_ms: i64) -> Vec<(i64, i64, i64)> {
        let mut events = Vec::new();
        replay.poll(now_ms * MS, &mut events).expect("no error");
        let sample = |event: &SourceEvent| match event {
            SourceEvent::Sample(sample) => {
                (sample.device_time_ns.unwrap_or(0) / MS, sample.received_ns / MS, sample.time_ns / MS)
            }
            SourceEvent::Ended => (0, 0, 0),
            other => panic!("{other:?}"),
        };
        events.iter().map(sample).collect()
    }

    fn replay(recording: &Arc<Recording>, speed: f64, looped: bool) -> Replay {
        let settings = ReplaySettings { start_ns: 5000 * MS, speed, looped };
        Replay::new(Arc::clone(recording), settings).expect("settings")
    }

    #[test]
    fn samples_come_when_they_arrived() {
        let recording = recording(&[(7, 100, 98), (17, 110, 108), (27, 120, 118)]);
        let mut replay = replay(&recording, 1.0, false);
        assert_eq!(told(&mut replay, 4999), []);
        assert_eq!(told(&mut replay, 5000), [(7, 5000, 4998)]);
        assert_eq!(told(&mut replay, 5009), []);
        assert_eq!(told(&mut replay, 6000), [(17, 5010, 5008), (27, 5020, 5018), (0, 0, 0)]);
        assert_eq!(told(&mut replay, 7000), []);
        assert!(replay.is_ended());
    }

    #[test]
    fn speed_stretches_host_times_only() {
        let recording = recording(&[(7, 100, 98), (17, 110, 108)]);
        assert_eq!(told(&mut replay(&recording, 0.5, false), 5019), [(7, 5000, 4996)]);
        assert_eq!(
            told(&mut replay(&recording, 2.0, false), 5005),
            [(7, 5000, 4999), (17, 5005, 5004), (0, 0, 0)]
        );
        for speed in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let settings = ReplaySettings { speed, ..ReplaySettings::default() };
            assert!(Replay::new(Arc::clone(&recording), settings).is_err(), "{speed}");
        }
    }

    #[test]
    fn disorder_is_told_by_arrival() {
        let recording = recording(&[(1, 120, 100), (2, 110, 110), (3, 110, 90)]);
        let told = told(&mut replay(&recording, 1.0, false), 5010);
        assert_eq!(told, [(2, 5000, 5000), (3, 5000, 4980), (1, 5010, 4990), (0, 0, 0)]);
    }

    #[test]
    fn rounds_follow_one_another() {
        let recording = recording(&[(7, 100, 100), (17, 110, 110)]);
        let mut replay = replay(&recording, 1.0, true);
        assert_eq!(told(&mut replay, 5025), [(7, 5000, 5000), (17, 5010, 5010)]);
        assert_eq!(told(&mut replay, 5025), [(27, 5020, 5020)]);
        assert_eq!(told(&mut replay, i64::MAX / MS).len(), 2, "a round at a time");
    }

    #[test]
    fn nothing_is_told_of_an_empty_recording() {
        let empty = Arc::new(Recording::new(RecordingInfo::default()));
        assert_eq!(told(&mut replay(&empty, 1.0, true), 0), [(0, 0, 0)]);
    }

    #[test]
    fn every_run_is_the_same() {
        let recording = recording(&(0..500).map(|n| (n * 7 % 501, n * 3, n * 3 - n % 5)).collect::<Vec<_>>());
        let run = |steps: &[i64]| {
            let mut replay = replay(&recording, 0.37, false);
            let mut events = Vec::new();
            for &now_ms in steps {
                replay.poll(now_ms * MS, &mut events).expect("no error");
            }
            events
        };
        let fine: Vec<i64> = (5000..10_000).collect();
        assert_eq!(run(&fine), run(&[10_000]));
        assert_eq!(run(&fine).len(), 501);
    }
}
