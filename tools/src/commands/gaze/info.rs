//! `macula gaze info`: what a recording holds.

use super::GazeFileArgs;
use crate::failure::Failure;
use crate::output;
use clap::Args;
use macula_trackers::recording::{Recording, Skipped};
use serde::Serialize;

/// What a recording holds: format, samples, rate, what was skipped and assumed
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  macula gaze info session.csv\n  \
                        macula gaze info eye.asc --screen 1920x1080,533x301,565 --json")]
pub struct InfoArgs {
    #[command(flatten)]
    input: GazeFileArgs,
}

#[derive(Serialize)]
pub struct SkippedRows<'a> {
    rows: u64,
    why: &'a str,
}

impl<'a> From<&'a Skipped> for SkippedRows<'a> {
    fn from(skipped: &'a Skipped) -> Self {
        Self { rows: skipped.rows, why: &skipped.why }
    }
}

#[derive(Serialize)]
struct Info<'a> {
    format: &'a str,
    device: &'a str,
    samples: usize,
    /// Samples with a usable gaze: a direction, or else a point on the display.
    valid: usize,
    rate_hz: Option<f64>,
    nominal_rate_hz: Option<f64>,
    duration_s: f64,
    skipped: Vec<SkippedRows<'a>>,
    eyes: Vec<&'static str>,
    space: &'static str,
    device_clock: &'a str,
    head: bool,
    events: usize,
    extra_columns: Vec<&'a str>,
    notes: &'a [String],
}

/// Names of the eyes of which any sample tells something.
fn eyes(recording: &Recording) -> Vec<&'static str> {
    let mut found = [false; 3];
    for sample in recording.samples() {
        for (found, eye) in found.iter_mut().zip([sample.combined, sample.left, sample.right]) {
            *found |= eye.direction.is_some() || eye.point.is_some() || eye.origin_m.is_some();
        }
        if found == [true; 3] {
            break;
        }
    }
    ["combined", "left", "right"].into_iter().zip(found).filter_map(|(name, is)| is.then_some(name)).collect()
}

fn info(recording: &Recording) -> Info<'_> {
    let about = &recording.info;
    let usable = |sample: &macula_trackers::sample::GazeSample| {
        sample.gaze_direction().is_some() || sample.gaze_point().is_some()
    };
    Info {
        format: about.format,
        device: &about.device,
        samples: recording.len(),
        valid: recording.samples().filter(usable).count(),
        rate_hz: recording.rate_hz(),
        nominal_rate_hz: about.nominal_rate_hz,
        duration_s: recording.duration_s(),
        skipped: about.skipped.iter().map(SkippedRows::from).collect(),
        eyes: eyes(recording),
        space: about.space.name(),
        device_clock: &about.device_clock,
        head: recording.samples().any(|sample| sample.head.is_some()),
        events: recording.events.len(),
        extra_columns: recording.extra.iter().map(|column| column.name.as_str()).collect(),
        notes: &about.notes,
    }
}

/// Runs the command.
///
/// # Errors
/// A file that cannot be read.
pub fn run(args: &InfoArgs, json: bool) -> Result<(), Failure> {
    let recording = args.input.read()?;
    let info = info(&recording);
    if json { output::print_json(&info) } else { output::print(&text(&info)) }
}

fn text(info: &Info<'_>) -> String {
    let rate = info.rate_hz.map_or("unknown".to_owned(), |rate| format!("{rate:.2} Hz"));
    let nominal =
        info.nominal_rate_hz.map(|rate| format!(" (the file says {rate:.2} Hz)")).unwrap_or_default();
    let mut rows = vec![
        ("format", info.format.to_owned()),
        ("device", info.device.to_owned()),
        ("samples", output::grouped(info.samples as u64)),
        ("valid", output::grouped(info.valid as u64)),
        ("rate", rate + &nominal),
        ("duration", format!("{:.3} s", info.duration_s)),
        ("eyes", info.eyes.join(", ")),
        ("space", info.space.to_owned()),
        ("head pose", if info.head { "yes" } else { "no" }.to_owned()),
        ("clock", info.device_clock.to_owned()),
        ("events", if info.events > 0 { output::grouped(info.events as u64) } else { String::new() }),
        ("extra", info.extra_columns.join(", ")),
    ];
    rows.extend(
        info.skipped
            .iter()
            .map(|skipped| ("skipped", format!("{} rows: {}", output::grouped(skipped.rows), skipped.why))),
    );
    rows.extend(info.notes.iter().map(|note| ("note", note.clone())));
    output::fields(&rows)
}
