//! `macula gaze monitor`: what a source tells, live.

use super::session::{Batch, Counts, Summary, parse_seconds, stop_flag, words};
use super::source::SourceArgs;
use crate::failure::Failure;
use crate::output;
use clap::Args;
use macula_trackers::estimator::{Estimator, EstimatorSettings};
use macula_trackers::sample::GazeSample;
use macula_trackers::source::SourceEvent;
use serde::Serialize;
use std::io::{IsTerminal, stdout};

/// Between two updates of the line, ns: more cannot be read.
const LINE_NS: i64 = 100_000_000;
/// Between two lines of JSON, ns.
const SECOND_NS: i64 = 1_000_000_000;

const AFTER_HELP: &str = "\
On a terminal one line is updated in place: gaze (degrees right and up, or a point on the display as
fractions from its top left), what the eye does, the rate, the age of the newest sample, and what was lost.
Elsewhere, or with --json, each line of stdout is a JSON object with a `type`:
  state         once a second: samples, valid, rate_hz (of that second); age_ms, azimuth_deg, elevation_deg,
                x, y (of the newest sample, null where it has none); eye_state (fixation, saccade, pursuit,
                blink, lost, unknown); lost, rejected, stalls (since the start); time_s (since the start)
  lost          samples
  rejected      count, why
  stalled, recovered (after_s), disconnected (why), reconnected, ended
  summary       at the end: source, end (ended, interrupted, time, failed), samples, valid, duration_s,
                rate_hz, lost, rejected, rejected_why, stalls, stalled_s, disconnects

Examples:
  macula gaze monitor
  macula gaze monitor --bridge unix:gaze.sock
  macula gaze monitor --replay session.csv --speed 0.5
  macula gaze monitor --synth vr-exploration --seconds 10 --json";

/// Watch what a tracker, a bridge, a replay or a synthetic eye tells, live
#[derive(Args, Debug)]
#[command(after_help = AFTER_HELP)]
pub struct MonitorArgs {
    #[command(flatten)]
    source: SourceArgs,
    /// End after so many seconds instead of by Ctrl-C
    #[arg(long, value_name = "S", value_parser = parse_seconds)]
    seconds: Option<f64>,
}

/// Runs the command.
///
/// # Errors
/// A source that cannot be opened or fails for good.
pub fn run(args: &MonitorArgs, json: bool) -> Result<(), Failure> {
    let stop = stop_flag()?;
    let mut session = args.source.open(false)?;
    let source = session.source.info().name.clone();
    let lines = json || !stdout().is_terminal();
    output::note(&format!("watching {source}; Ctrl-C ends it"));
    let mut view = View::new(lines);
    let (end, counts, failure) = session.run(args.seconds, &stop, |batch| view.take(batch))?;
    let summary = Summary::new(&source, end, &counts);
    if lines {
        output::print_json_line(&Line::Summary(&summary))?;
    } else {
        output::print(&format!("\r\x1b[K{}", output::fields(&summary.rows())))?;
    }
    failure.map_or(Ok(()), Err)
}

/// What is shown, and of when.
struct View {
    lines: bool,
    estimator: Estimator,
    newest: Option<GazeSample>,
    begun_ns: Option<i64>,
    shown_ns: i64,
    /// Counts when it was shown last.
    before: Counts,
    rate_hz: f64,
}

impl View {
    fn new(lines: bool) -> Self {
        Self {
            lines,
            estimator: Estimator::new(EstimatorSettings::default()),
            newest: None,
            begun_ns: None,
            shown_ns: 0,
            before: Counts::default(),
            rate_hz: 0.0,
        }
    }

    fn take(&mut self, batch: &Batch<'_>) -> Result<(), Failure> {
        for event in batch.events {
            self.estimator.on_event(event);
            match event {
                SourceEvent::Sample(sample) => self.newest = Some(*sample),
                _ => self.tell(event)?,
            }
        }
        let begun_ns = *self.begun_ns.get_or_insert_with(|| {
            self.shown_ns = batch.now_ns;
            batch.now_ns
        });
        let passed_ns = batch.now_ns.saturating_sub(self.shown_ns);
        if passed_ns < if self.lines { SECOND_NS } else { LINE_NS } {
            return Ok(());
        }
        let new = batch.counts.samples - self.before.samples;
        let rate_hz = new as f64 * 1e9 / passed_ns as f64;
        // Over a tenth of a second few samples come: a mean of about half a second, so that it can be read.
        self.rate_hz =
            if self.lines || self.rate_hz == 0.0 { rate_hz } else { self.rate_hz * 0.8 + rate_hz * 0.2 };
        let state = self.state(batch, batch.now_ns.saturating_sub(begun_ns));
        self.shown_ns = batch.now_ns;
        self.before = batch.counts.clone();
        if self.lines {
            output::print_json_line(&Line::State(&state))
        } else {
            // A line that would wrap is cut: it could not be updated.
            output::print(&format!("\r\x1b[?7l\x1b[K{}\x1b[?7h", state.line()))
        }
    }

    /// Says what happened that is no sample.
    fn tell(&self, event: &SourceEvent) -> Result<(), Failure> {
        if self.lines {
            Line::of(event).map_or(Ok(()), |line| output::print_json_line(&line))
        } else {
            words(event).map_or(Ok(()), |words| output::print(&format!("\r\x1b[K{words}\n")))
        }
    }

    fn state(&self, batch: &Batch<'_>, time_ns: i64) -> State {
        let direction =
            self.newest.as_ref().and_then(GazeSample::gaze_direction).map(|(direction, _)| direction);
        let point = self.newest.as_ref().and_then(GazeSample::gaze_point);
        let age_ns = self.newest.map(|sample| batch.now_ns.saturating_sub(sample.time_ns));
        State {
            time_s: time_ns as f64 * 1e-9,
            samples: batch.counts.samples - self.before.samples,
            valid: batch.counts.valid - self.before.valid,
            rate_hz: self.rate_hz,
            age_ms: age_ns.map(|age_ns| age_ns as f64 * 1e-6),
            azimuth_deg: direction.map(|direction| direction.x.atan2(-direction.z).to_degrees()),
            elevation_deg: direction.map(|direction| direction.normalize_or_zero().y.asin().to_degrees()),
            x: point.map(|point| point.x),
            y: point.map(|point| point.y),
            eye_state: self.estimator.phase().state.name(),
            lost: batch.counts.lost,
            rejected: batch.counts.rejected,
            stalls: batch.counts.stalls,
        }
    }
}

/// What is shown at a time.
#[derive(Serialize)]
struct State {
    time_s: f64,
    /// Since the line before, as `valid`.
    samples: u64,
    valid: u64,
    rate_hz: f64,
    age_ms: Option<f64>,
    azimuth_deg: Option<f64>,
    elevation_deg: Option<f64>,
    x: Option<f64>,
    y: Option<f64>,
    eye_state: &'static str,
    /// Since the start, as `rejected` and `stalls`.
    lost: u64,
    rejected: u64,
    stalls: u64,
}

impl State {
    fn line(&self) -> String {
        let gaze = match (self.azimuth_deg.zip(self.elevation_deg), self.x.zip(self.y)) {
            (Some((azimuth, elevation)), _) => format!("{azimuth:+7.2} {elevation:+7.2} deg"),
            (None, Some((x, y))) => format!("{x:7.4} {y:7.4}    "),
            (None, None) => "      - no gaze -  ".to_owned(),
        };
        let age = self.age_ms.map_or("    -".to_owned(), |age_ms| format!("{age_ms:5.0}"));
        format!(
            "{gaze}  {:<8}  {:6.1} Hz  age {age} ms  lost {}  rejected {}  stalls {}",
            self.eye_state, self.rate_hz, self.lost, self.rejected, self.stalls
        )
    }
}

/// A line of JSON.
#[derive(Serialize)]
#[serde(tag = "type", rename_all = "lowercase")]
enum Line<'a> {
    State(&'a State),
    Lost { samples: u64 },
    Rejected { count: u64, why: &'a str },
    Stalled,
    Recovered { after_s: f64 },
    Disconnected { why: &'a str },
    Reconnected,
    Ended,
    Summary(&'a Summary),
}

impl<'a> Line<'a> {
    /// Of an event; `None` of a sample.
    fn of(event: &'a SourceEvent) -> Option<Self> {
        Some(match event {
            SourceEvent::Sample(_) => return None,
            SourceEvent::Lost { samples } => Self::Lost { samples: *samples },
            SourceEvent::Rejected { count, why } => Self::Rejected { count: *count, why },
            SourceEvent::Stalled { .. } => Self::Stalled,
            SourceEvent::Recovered { after_ns } => Self::Recovered { after_s: *after_ns as f64 * 1e-9 },
            SourceEvent::Disconnected { why } => Self::Disconnected { why },
            SourceEvent::Reconnected => Self::Reconnected,
            SourceEvent::Ended => Self::Ended,
        })
    }
}
