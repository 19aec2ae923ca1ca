//! What every source of gaze has in common, be it a device, a socket, a recording or a synthetic eye.

use crate::error::Result;
use crate::sample::GazeSample;
use std::fmt;

/// What a source says of itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SourceInfo {
    /// What it is, for a person.
    pub name: String,
    /// The clock of [`GazeSample::device_time_ns`], as in `tracker (us, 64 bit)`; empty if it gives no
    /// time.
    pub device_clock: String,
    /// The clock of [`GazeSample::received_ns`] and [`GazeSample::time_ns`], as in `CLOCK_MONOTONIC`.
    pub host_clock: String,
    /// Samples per second that it promises, if it does.
    pub rate_hz: Option<f64>,
}

/// What a source has to tell, in the order in which it happened.
// Nearly every event is a sample: a box would allocate for each of them.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq)]
pub enum SourceEvent {
    /// A sample, valid or not.
    Sample(GazeSample),
    /// Samples that were made but never arrived, by the gap in the source's own time.
    Lost {
        /// About how many.
        samples: u64,
    },
    /// What arrived was no sample: a broken report, a line of rubbish.
    Rejected {
        /// How many in a row.
        count: u64,
        /// What is wrong with the last one.
        why: String,
    },
    /// The source's own time no longer advances, whatever still arrives.
    Stalled {
        /// Host time of the last new sample, ns.
        since_ns: i64,
    },
    /// New samples come again after [`SourceEvent::Stalled`].
    Recovered {
        /// How long it had stalled, ns.
        after_ns: i64,
    },
    /// The device or peer is gone. The source goes on looking for it.
    Disconnected {
        /// What the system said.
        why: String,
    },
    /// The device or peer is there again.
    Reconnected,
    /// The source has told everything it ever will.
    Ended,
}

/// A source of gaze samples.
///
/// Time comes from the caller, so that a stepped clock makes a run repeatable; sources with a thread of
/// their own stamp `received_ns` there, from [`crate::time::host_now_ns`].
pub trait GazeSource: fmt::Debug + Send {
    /// What it is.
    fn info(&self) -> &SourceInfo;

    /// Appends what has happened up to `now_ns` (host clock) and was not yet told. Never waits.
    ///
    /// # Errors
    /// What ends the source for good. A device that is unplugged is an event, not an error.
    fn poll(&mut self, now_ns: i64, events: &mut Vec<SourceEvent>) -> Result<()>;
}
