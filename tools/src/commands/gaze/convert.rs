//! `macula gaze convert`: a recording of any format as BIDS.

use super::GazeFileArgs;
use super::info::SkippedRows;
use super::target::{ForceArgs, names, written};
use crate::failure::Failure;
use crate::output;
use crate::progress::Steps;
use clap::Args;
use macula_trackers::bids;
use serde::Serialize;
use std::path::PathBuf;

/// Convert a recording of any known format to BIDS eye-tracking, with all its columns and events
///
/// A BIDS recording is NAME.tsv.gz with its side-car NAME.json, and events in ..._physioevents.tsv.gz.
/// A name without such an ending gets _recording-eye3_physio.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  macula gaze convert session.csv sub-01_task-hall\n  \
                        macula gaze convert eye.asc eye --screen 1920x1080,533x301,565 --json")]
pub struct ConvertArgs {
    #[command(flatten)]
    input: GazeFileArgs,
    /// The recording to write
    #[arg(value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    force: ForceArgs,
}

#[derive(Serialize)]
struct Converted<'a> {
    files: Vec<PathBuf>,
    format: &'a str,
    samples: usize,
    events: usize,
    extra_columns: usize,
    skipped: Vec<SkippedRows<'a>>,
    notes: &'a [String],
}

/// Runs the command.
///
/// # Errors
/// A recording that cannot be read or written, or one that is there already.
pub fn run(args: &ConvertArgs, json: bool) -> Result<(), Failure> {
    args.force.check(&args.output)?;
    let same = |file: &PathBuf| file.canonicalize().ok() == args.input.file.canonicalize().ok();
    if written(&args.output).iter().any(same) {
        return Err(Failure::usage("the recording cannot be written over itself; choose another name"));
    }
    let mut steps = Steps::short(2);
    steps.next("reading");
    let recording = args.input.read()?;
    steps.next("writing");
    bids::write_recording(&recording, &args.output)?;
    drop(steps);
    let about = &recording.info;
    let converted = Converted {
        files: written(&args.output),
        format: about.format,
        samples: recording.len(),
        events: recording.events.len(),
        extra_columns: recording.extra.len(),
        skipped: about.skipped.iter().map(SkippedRows::from).collect(),
        notes: &about.notes,
    };
    if json {
        return output::print_json(&converted);
    }
    let some = |count: usize| if count > 0 { output::grouped(count as u64) } else { String::new() };
    let mut rows = vec![
        ("format", converted.format.to_owned()),
        ("samples", output::grouped(converted.samples as u64)),
        ("events", some(converted.events)),
        (
            "extra",
            if converted.extra_columns > 0 {
                format!("{} columns", converted.extra_columns)
            } else {
                String::new()
            },
        ),
    ];
    rows.extend(
        about.skipped.iter().map(|skipped| ("skipped", format!("{} rows: {}", skipped.rows, skipped.why))),
    );
    rows.extend(about.notes.iter().map(|note| ("note", note.clone())));
    rows.push(("written", names(&converted.files)));
    output::print(&output::fields(&rows))
}
