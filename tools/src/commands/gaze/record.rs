//! `macula gaze record`: a source to a file while it runs.

use super::session::{Batch, Counts, End, Session, Summary, parse_seconds, stop_flag, words};
use super::source::SourceArgs;
use super::target::{names, written};
use crate::failure::Failure;
use crate::output;
use clap::Args;
use macula_trackers::bids::Recorder;
use macula_trackers::source::SourceEvent;
use serde::Serialize;
use std::io::{IsTerminal, Write, stderr};
use std::path::PathBuf;

/// Between two looks at how far it has come, ns.
const STATUS_NS: i64 = 500_000_000;

/// Record a tracker, a bridge, a replay or a synthetic eye to BIDS eye-tracking
///
/// Ctrl-C ends the recording. What was recorded is on the disk once a second: a crash loses at most the
/// last one, and an unfinished recording opens as any other. Losses, stalls and disconnects are counted
/// and kept in the recording's side-car.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  macula gaze record -o sub-01_task-hall\n  \
                        macula gaze record --bridge udp:5005 -o session --seconds 60\n  \
                        macula gaze record --replay session.csv --fast -o again")]
pub struct RecordArgs {
    #[command(flatten)]
    source: SourceArgs,
    /// The recording to write: NAME.tsv.gz with NAME.json; to another name _recording-eye3_physio is
    /// added. Nothing is overwritten
    #[arg(short, long, value_name = "NAME")]
    output: PathBuf,
    /// End after so many seconds
    #[arg(long, value_name = "S", value_parser = parse_seconds)]
    seconds: Option<f64>,
    /// Run a replay or a synthetic eye as fast as possible, by its own time; a replay keeps its times
    #[arg(long, conflicts_with = "speed")]
    fast: bool,
}

#[derive(Serialize)]
struct Recorded {
    files: Vec<PathBuf>,
    /// Samples that found no place while the disk was full.
    unwritten: u64,
    #[serde(flatten)]
    summary: Summary,
}

/// Runs the command.
///
/// # Errors
/// A source that cannot be opened or fails for good, a recording that is there already or cannot be
/// written. What was recorded until then stays.
pub fn run(args: &RecordArgs, json: bool) -> Result<(), Failure> {
    if args.fast && args.seconds.is_none() && args.source.is_endless() {
        return Err(Failure::usage("--fast without end would fill the disk; give --seconds"));
    }
    let stop = stop_flag()?;
    let mut session = args.source.open(args.fast)?;
    let source = session.source.info().name.clone();
    let mut recorder = Recorder::create(&args.output, &session.info, &[])?;
    output::note(&format!("recording {source} to {}; Ctrl-C ends it", recorder.path().display()));
    let mut keeper = Keeper { recorder: &mut recorder, trouble: false, shown_ns: i64::MIN };
    let (end, counts, failure) = session.run(args.seconds, &stop, |batch| {
        keeper.keep(batch);
        Ok(())
    })?;
    keeper.clear_status();
    describe(&mut recorder, &session, end, &counts);
    let unwritten = recorder.refused();
    recorder.finish()?;
    let files = written(&args.output);
    if let Some(failure) = failure {
        output::note(&format!("{} samples are in {}", counts.samples, names(&files)));
        return Err(failure);
    }
    let recorded = Recorded { files, unwritten, summary: Summary::new(&source, end, &counts) };
    if json { output::print_json(&recorded) } else { output::print(&text(&recorded)) }
}

/// Writes what comes, and says on stderr what a person should know while it runs.
struct Keeper<'a> {
    recorder: &'a mut Recorder,
    /// The last try to write failed.
    trouble: bool,
    shown_ns: i64,
}

impl Keeper<'_> {
    fn keep(&mut self, batch: &Batch<'_>) {
        let mut result = Ok(());
        for event in batch.events {
            if let SourceEvent::Sample(sample) = event {
                result = self.recorder.push(sample).and(result);
            } else if let Some(words) = words(event) {
                self.note(&words);
            }
        }
        let result = self.recorder.tick().and(result);
        if let (Err(error), false) = (&result, self.trouble) {
            self.note(&format!("warning: {error}; recording goes on and tries again; free some space"));
        }
        self.trouble = result.is_err() || self.recorder.is_failing();
        self.show(batch);
    }

    fn note(&self, text: &str) {
        self.clear_status();
        output::note(text);
    }

    fn show(&mut self, batch: &Batch<'_>) {
        if batch.now_ns.saturating_sub(self.shown_ns) < STATUS_NS || !stderr().is_terminal() {
            return;
        }
        self.shown_ns = batch.now_ns;
        let counts = batch.counts;
        // Nobody is left to hear that stderr is closed.
        _ = write!(
            stderr(),
            "\r\x1b[K{} samples, {:.1} s, {} lost",
            output::grouped(counts.samples),
            counts.span_s(),
            counts.lost
        );
    }

    fn clear_status(&self) {
        if stderr().is_terminal() {
            _ = write!(stderr(), "\r\x1b[K");
        }
    }
}

/// Puts into the recording what happened besides samples.
fn describe(recorder: &mut Recorder, session: &Session, end: End, counts: &Counts) {
    if counts.lost > 0 {
        recorder.skip(counts.lost, "lost before they arrived, by the gaps in the source's time");
    }
    if counts.rejected > 0 {
        let why = counts.rejected_why.as_deref().unwrap_or("no reason was told");
        recorder.skip(counts.rejected, &format!("no samples, as the last: {why}"));
    }
    if counts.stalls > 0 {
        recorder.note(format!(
            "The source told nothing new {} times, {:.3} s of them ended.",
            counts.stalls,
            counts.stalled_ns as f64 * 1e-9
        ));
    }
    if counts.disconnects > 0 {
        recorder.note(format!("The source was gone {} times.", counts.disconnects));
    }
    if end == End::Failed {
        recorder.note("The source failed; the recording ended there.");
    }
    if !session.untold.is_empty() {
        recorder.note(format!("The replayed recording also holds {}.", session.untold.join(", ")));
    }
}

fn text(recorded: &Recorded) -> String {
    let mut rows = recorded.summary.rows();
    let unwritten = recorded.unwritten;
    let unwritten =
        if unwritten > 0 { format!("{unwritten} samples, the disk was full") } else { String::new() };
    rows.push(("unwritten", unwritten));
    rows.push(("written", names(&recorded.files)));
    output::fields(&rows)
}
