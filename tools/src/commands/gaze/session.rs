//! A source that runs: polled, counted, and ended by a signal, a time, or by itself.

use crate::failure::Failure;
use macula_trackers::recording::RecordingInfo;
use macula_trackers::source::{GazeSource, SourceEvent};
use macula_trackers::time::host_now_ns;
use serde::Serialize;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Time between polls. Sources stamp arrivals by themselves, so this only delays what is shown and
/// written; shorter costs wake-ups.
const POLL: Duration = Duration::from_millis(2);
/// A stepped clock goes on by this, ns; twice as far after each step that brought nothing, so that gaps
/// in a recording are soon passed, up to the longest: what one step brings is held in memory.
const STEP_NS: i64 = 10_000_000;
const LONGEST_STEP_NS: i64 = 10_000_000_000;

/// What drives a source.
#[derive(Clone, Copy, Debug)]
pub enum Clock {
    /// The host's.
    Host,
    /// One that goes on as fast as the source is polled.
    Stepped {
        /// Its time, ns.
        now_ns: i64,
        /// Its next step, ns.
        step_ns: i64,
    },
}

impl Clock {
    /// The host's clock, or a stepped one that begins at a time.
    pub fn starting_at(now_ns: i64, stepped: bool) -> Self {
        if stepped { Self::Stepped { now_ns, step_ns: STEP_NS } } else { Self::Host }
    }

    fn now_ns(&self) -> i64 {
        match self {
            Self::Host => host_now_ns(),
            Self::Stepped { now_ns, .. } => *now_ns,
        }
    }

    /// Waits for the next poll.
    fn wait(&mut self, brought_nothing: bool) {
        match self {
            Self::Host => std::thread::sleep(POLL),
            Self::Stepped { now_ns, step_ns } => {
                *step_ns = if brought_nothing { (*step_ns * 2).min(LONGEST_STEP_NS) } else { STEP_NS };
                *now_ns = now_ns.saturating_add(*step_ns);
            }
        }
    }
}

/// An open source.
pub struct Session {
    /// The source.
    pub source: Box<dyn GazeSource>,
    /// What a recording of it says of itself.
    pub info: RecordingInfo,
    /// What drives it.
    pub clock: Clock,
    /// Columns and events of a replayed recording that have no place in a source's samples.
    pub untold: Vec<String>,
}

/// Why a session ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum End {
    /// The source told everything.
    Ended,
    /// By a signal, as of Ctrl-C.
    Interrupted,
    /// The time was up.
    Time,
    /// The source failed for good.
    Failed,
}

/// What a session brought so far.
#[derive(Clone, Debug, Default)]
pub struct Counts {
    pub samples: u64,
    /// Samples with a usable gaze.
    pub valid: u64,
    pub lost: u64,
    pub rejected: u64,
    /// Why the last one was.
    pub rejected_why: Option<String>,
    pub stalls: u64,
    /// Of stalls that are over.
    pub stalled_ns: i64,
    pub disconnects: u64,
    /// Host time of the first and the last arrival, ns.
    arrivals_ns: Option<(i64, i64)>,
}

impl Counts {
    fn count(&mut self, event: &SourceEvent) {
        match event {
            SourceEvent::Sample(sample) => {
                self.samples += 1;
                let usable = sample.gaze_direction().is_some() || sample.gaze_point().is_some();
                self.valid += u64::from(usable);
                let first_ns = self.arrivals_ns.map_or(sample.received_ns, |(first_ns, _)| first_ns);
                self.arrivals_ns = Some((first_ns, sample.received_ns));
            }
            SourceEvent::Lost { samples } => self.lost = self.lost.saturating_add(*samples),
            SourceEvent::Rejected { count, why } => {
                self.rejected = self.rejected.saturating_add(*count);
                self.rejected_why = Some(why.clone());
            }
            SourceEvent::Stalled { .. } => self.stalls += 1,
            SourceEvent::Recovered { after_ns } => {
                self.stalled_ns = self.stalled_ns.saturating_add(*after_ns);
            }
            SourceEvent::Disconnected { .. } => self.disconnects += 1,
            SourceEvent::Reconnected | SourceEvent::Ended => {}
        }
    }

    /// From the first to the last arrival, s.
    pub fn span_s(&self) -> f64 {
        self.arrivals_ns.map_or(0.0, |(first_ns, last_ns)| last_ns.saturating_sub(first_ns) as f64 * 1e-9)
    }

    /// Samples per second, from the first to the last arrival.
    pub fn rate_hz(&self) -> Option<f64> {
        let span_s = self.span_s();
        (span_s > 0.0).then(|| self.samples.saturating_sub(1) as f64 / span_s)
    }
}

/// What a session was, at its end.
#[derive(Debug, Serialize)]
pub struct Summary {
    pub source: String,
    pub end: End,
    pub samples: u64,
    pub valid: u64,
    /// From the first to the last arrival.
    pub duration_s: f64,
    pub rate_hz: Option<f64>,
    pub lost: u64,
    pub rejected: u64,
    /// What was wrong with the last that was rejected.
    pub rejected_why: Option<String>,
    pub stalls: u64,
    /// How long all stalls took that ended.
    pub stalled_s: f64,
    pub disconnects: u64,
}

impl Summary {
    /// Of what was counted.
    pub fn new(source: &str, end: End, counts: &Counts) -> Self {
        Self {
            source: source.to_owned(),
            end,
            samples: counts.samples,
            valid: counts.valid,
            duration_s: counts.span_s(),
            rate_hz: counts.rate_hz(),
            lost: counts.lost,
            rejected: counts.rejected,
            rejected_why: counts.rejected_why.clone(),
            stalls: counts.stalls,
            stalled_s: counts.stalled_ns as f64 * 1e-9,
            disconnects: counts.disconnects,
        }
    }

    /// As rows of text, without what did not happen.
    pub fn rows(&self) -> Vec<(&'static str, String)> {
        let counted =
            |count: u64, rest: String| if count > 0 { format!("{count}{rest}") } else { String::new() };
        let why = self.rejected_why.as_ref().map(|why| format!(", the last: {why}")).unwrap_or_default();
        vec![
            ("source", self.source.clone()),
            ("samples", format!("{}, {} of them valid", self.samples, self.valid)),
            ("duration", format!("{:.3} s", self.duration_s)),
            ("rate", self.rate_hz.map_or("unknown".to_owned(), |rate_hz| format!("{rate_hz:.2} Hz"))),
            ("lost", self.lost.to_string()),
            ("rejected", counted(self.rejected, why)),
            ("stalls", counted(self.stalls, format!(", {:.3} s in all", self.stalled_s))),
            ("gone", counted(self.disconnects, " times".to_owned())),
        ]
    }
}

/// What a poll brought.
pub struct Batch<'a> {
    /// The time of the poll, ns.
    pub now_ns: i64,
    pub events: &'a [SourceEvent],
    /// These events included.
    pub counts: &'a Counts,
}

/// A flag that Ctrl-C, SIGTERM and SIGHUP set; a second one ends the program at once.
///
/// # Errors
/// The system does not allow it.
pub fn stop_flag() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        // In this order: the first signal sets the flag after it was looked at.
        flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&stop))
            .and_then(|_| flag::register(signal, Arc::clone(&stop)))
            .map_err(|error| Failure::environment(format!("signals cannot be handled: {error}")))?;
    }
    Ok(stop)
}

impl Session {
    /// Runs until `stop` is set, so many seconds have passed, or the source ends; `take` gets what each
    /// poll brought. A source that fails for good ends it too, with the error beside the counts.
    ///
    /// # Errors
    /// What `take` fails with.
    pub fn run(
        &mut self,
        seconds: Option<f64>,
        stop: &AtomicBool,
        mut take: impl FnMut(&Batch<'_>) -> Result<(), Failure>,
    ) -> Result<(End, Counts, Option<Failure>), Failure> {
        let begun_ns = self.clock.now_ns();
        let end_ns = seconds.map_or(i64::MAX, |seconds| begun_ns.saturating_add((seconds * 1e9) as i64));
        let mut counts = Counts::default();
        let mut events = Vec::new();
        loop {
            let now_ns = self.clock.now_ns().min(end_ns);
            events.clear();
            let polled = self.source.poll(now_ns, &mut events);
            events.iter().for_each(|event| counts.count(event));
            take(&Batch { now_ns, events: &events, counts: &counts })?;
            if let Err(error) = polled {
                return Ok((End::Failed, counts, Some(error.into())));
            }
            let end = if matches!(events.last(), Some(SourceEvent::Ended)) {
                End::Ended
            } else if stop.load(Ordering::Relaxed) {
                End::Interrupted
            } else if now_ns >= end_ns {
                End::Time
            } else {
                self.clock.wait(events.is_empty());
                continue;
            };
            return Ok((end, counts, None));
        }
    }
}

/// A number of seconds on the command line.
pub fn parse_seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse::<f64>().ok().filter(|seconds| *seconds > 0.0 && *seconds <= 1e6);
    seconds.ok_or_else(|| "expected seconds, above 0 and at most 1000000".into())
}

/// What an event means, for a person; `None` for those that are only counted.
pub fn words(event: &SourceEvent) -> Option<String> {
    match event {
        SourceEvent::Stalled { .. } => Some("the source tells nothing new".to_owned()),
        SourceEvent::Recovered { after_ns } => {
            Some(format!("the source tells something new again, after {:.3} s", *after_ns as f64 * 1e-9))
        }
        SourceEvent::Disconnected { why } => Some(format!("the source is gone: {why}")),
        SourceEvent::Reconnected => Some("the source is there".to_owned()),
        SourceEvent::Sample(_)
        | SourceEvent::Lost { .. }
        | SourceEvent::Rejected { .. }
        | SourceEvent::Ended => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use macula_trackers::sample::GazeSample;

    #[test]
    fn the_rate_is_that_of_arrivals() {
        let mut counts = Counts::default();
        for number in 0..11 {
            let sample = GazeSample { received_ns: 5 + number * 4_000_000, ..GazeSample::at(0) };
            counts.count(&SourceEvent::Sample(sample));
        }
        assert!(counts.rate_hz().is_some_and(|rate_hz| (rate_hz - 250.0).abs() < 1e-9));
        assert_eq!((counts.samples, counts.valid), (11, 0));
        assert_eq!(Counts::default().rate_hz(), None);
    }

    #[test]
    fn a_stepped_clock_hurries_where_nothing_comes() {
        let mut clock = Clock::starting_at(0, true);
        clock.wait(false);
        assert_eq!(clock.now_ns(), STEP_NS);
        for _ in 0..40 {
            clock.wait(true);
        }
        let before_ns = clock.now_ns();
        clock.wait(true);
        assert_eq!(clock.now_ns() - before_ns, LONGEST_STEP_NS);
        let before_ns = clock.now_ns();
        clock.wait(false);
        assert_eq!(clock.now_ns() - before_ns, STEP_NS);
    }
}
