//! Samples from the program itself.

use super::inbox::{Inbox, Item};
use crate::error::Result;
use crate::sample::GazeSample;
use crate::source::{GazeSource, SourceEvent, SourceInfo};
use crate::stamp::{StampSettings, Stamper};
use crate::time::host_now_ns;
use std::sync::{Arc, Weak};

/// When a sample was taken, as far as the program knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleTime {
    /// Not known: its arrival counts.
    Unknown,
    /// On the host clock ([`host_now_ns`]), ns. May lie in the future, for a gaze that the runtime has
    /// predicted; the sample's `time_ns` then is its arrival.
    Host(i64),
    /// On another clock, ns: mapped onto the host's while samples come in.
    Device(i64),
}

impl SampleTime {
    /// An OpenXR time, as in `XrEyeGazeSampleTimeEXT`: zero or less is unknown, and it may be in the
    /// future. On Linux it is `CLOCK_MONOTONIC` with the common runtimes; where it is not (the runtime
    /// converts by `XR_KHR_convert_timespec_time`), use [`SampleTime::Device`].
    #[must_use]
    pub fn of_openxr(time: i64) -> Self {
        if time > 0 { Self::Host(time) } else { Self::Unknown }
    }
}

/// A source that is fed by the program, and its other end. An OpenXR host pushes what
/// `XR_EXT_eye_gaze_interaction` tells: the pose's orientation times `-Z` as the combined direction and
/// its position as the origin, in the space of the views' mid-point, valid where the orientation is; most
/// runtimes tell the same sample until the next, so the sample time should go along.
#[must_use]
pub fn host_source(info: SourceInfo, settings: StampSettings) -> (Feeder, HostSource) {
    let inbox = Arc::new(Inbox::default());
    let feeder = Feeder { inbox: Arc::downgrade(&inbox) };
    (feeder, HostSource { info, inbox, stamper: Stamper::new(settings), ended: false })
}

/// Feeds a [`HostSource`], from any thread. Clones feed the same source.
#[derive(Clone, Debug)]
pub struct Feeder {
    inbox: Weak<Inbox>,
}

impl Feeder {
    /// Hands over a sample, which arrives now. Its own times do not count. Never waits for the one who
    /// polls; the oldest of more than 4096 samples that wait is given up and counted as lost. Says whether
    /// the source is still there.
    pub fn push(&self, sample: GazeSample, time: SampleTime) -> bool {
        self.push_at(sample, time, host_now_ns())
    }

    /// As [`Feeder::push`], of a sample that arrived at a host time; not in the future of the next poll.
    pub fn push_at(&self, mut sample: GazeSample, time: SampleTime, received_ns: i64) -> bool {
        let Some(inbox) = self.inbox.upgrade() else { return false };
        sample.received_ns = received_ns;
        (sample.device_time_ns, sample.time_ns) = match time {
            SampleTime::Unknown => (None, received_ns),
            SampleTime::Host(time_ns) | SampleTime::Device(time_ns) => (Some(time_ns), received_ns),
        };
        inbox.put(received_ns, Item::Sample { sample, on_host_clock: matches!(time, SampleTime::Host(_)) });
        true
    }
}

/// A source of samples that the program pushes; made by [`host_source`]. It ends when the last feeder
/// is gone.
#[derive(Debug)]
pub struct HostSource {
    info: SourceInfo,
    inbox: Arc<Inbox>,
    stamper: Stamper,
    ended: bool,
}

impl GazeSource for HostSource {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    fn poll(&mut self, now_ns: i64, events: &mut Vec<SourceEvent>) -> Result<()> {
        if self.ended {
            return Ok(());
        }
        // Before what waits is taken: the last feeder may push and go in between.
        let last = Arc::weak_count(&self.inbox) == 0;
        tell(&self.inbox, &mut self.stamper, now_ns, events);
        if last && self.inbox.is_empty() {
            self.ended = true;
            events.push(SourceEvent::Ended);
        }
        Ok(())
    }
}

/// Makes events of what waits.
pub fn tell(inbox: &Inbox, stamper: &mut Stamper, now_ns: i64, events: &mut Vec<SourceEvent>) {
    let samples = inbox.take_overflowed();
    if samples > 0 {
        events.push(SourceEvent::Lost { samples });
    }
    while let Some(item) = inbox.take(now_ns) {
        match item {
            Item::Sample { sample, on_host_clock: true } => stamper.stamp_on_host_clock(sample, events),
            Item::Sample { sample, on_host_clock: false } => {
                stamper.stamp(sample, events);
            }
            Item::Rejected { count, why } => events.push(SourceEvent::Rejected { count, why }),
            Item::Joined => {
                stamper.reconnected();
                events.push(SourceEvent::Reconnected);
            }
            Item::Left { why } => events.push(SourceEvent::Disconnected { why }),
        }
    }
    stamper.check(now_ns, events);
}
