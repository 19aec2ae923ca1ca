//! `macula gaze latency`: how old and how far off the gaze is when its picture is displayed.

mod options;
mod text;

use super::prepare::{EventsFrom, eye_intervals, with_directions};
use crate::failure::Failure;
use crate::progress::Steps;
use crate::{library, output};
use macula_trackers::formats;
use macula_trackers::latency::{
    GazeAnswer, LatencyModel, LatencyRun, LatencySummary, PRESETS, SessionGaze, Verdict, page, preset,
    report_data, verdict,
};
use macula_trackers::recording::Recording;
pub use options::LatencyArgs;
use serde::Serialize;
use std::path::Path;

#[derive(Serialize)]
struct Report {
    /// Where the eye's events come from.
    events_from: EventsFrom,
    /// Where the renderer takes the gaze to be.
    answer: String,
    seed: u64,
    conclusion: Verdict,
    #[serde(flatten)]
    summary: LatencySummary,
}

#[derive(Serialize)]
struct PresetRow {
    name: &'static str,
    title: String,
    tracker_rate_hz: Option<f64>,
    refresh_hz: f64,
    about: String,
}

/// Runs the command.
///
/// # Errors
/// A recording, model or measurement that cannot be read, options that contradict each other, and output
/// that cannot be written.
pub fn run(args: &LatencyArgs, json: bool) -> Result<(), Failure> {
    if args.list_presets {
        return list_presets(json);
    }
    let Some(file) = &args.file else { return Err(Failure::usage("a recording is missing")) };
    let model = args.model()?;
    args.check_outputs(file)?;
    let mut steps = Steps::short(4);
    steps.next("reading");
    let recording = with_directions(formats::read(file, &args.read.options())?)?;
    steps.next("events");
    let (intervals, events_from) = eye_intervals(&recording);
    let session = SessionGaze::new(&recording)?.with_intervals(&intervals);
    steps.next("running");
    let mut estimator = args.run.answer(&recording);
    let run = args.run.through(&model, &session, estimator.as_mut())?;
    steps.next("budget");
    let answer = estimator.as_mut().map(|answer| answer as &mut dyn GazeAnswer);
    let summary = run.summary(&session, run.budget(&session, answer));
    drop(steps);
    let report = report(args, summary, events_from);
    write(args, &run, &session, &report, &title(file, &recording))?;
    if json { output::print_json(&report) } else { output::print(&text::text(&report, args)) }
}

fn report(args: &LatencyArgs, mut summary: LatencySummary, events_from: EventsFrom) -> Report {
    let answer = args.run.answer_words();
    summary.notes.insert(0, format!("The renderer takes {answer}."));
    summary.notes.insert(1, format!("What the eye did comes from {}.", events_from.words()));
    Report { events_from, answer, seed: args.run.seed, conclusion: verdict(&summary), summary }
}

/// What the page is about: the file's name and the device that wrote it.
fn title(file: &Path, recording: &Recording) -> String {
    let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy();
    if recording.info.device.is_empty() {
        name.into_owned()
    } else {
        format!("{name}, {}", recording.info.device)
    }
}

fn write(
    args: &LatencyArgs,
    run: &LatencyRun,
    session: &SessionGaze,
    report: &Report,
    title: &str,
) -> Result<(), Failure> {
    if let Some(path) = &args.output {
        let data = report_data(run, session, report.summary.clone(), title);
        library::write_file(path, page(&data).as_bytes())?;
    }
    let ledger = run.ledger(session);
    if let Some(path) = &args.ledger {
        library::write_with(path, |file| ledger.write_frames_csv(file))?;
    }
    if let Some(path) = &args.sample_ledger {
        library::write_with(path, |file| ledger.write_samples_csv(file))?;
    }
    Ok(())
}

fn list_presets(json: bool) -> Result<(), Failure> {
    let row = |name: &'static str| {
        let LatencyModel { name: title, about, tracker_rate_hz, refresh_hz, .. } = preset(name)?;
        let tracker_rate_hz = tracker_rate_hz.map(|rate_hz| rate_hz.value);
        Ok(PresetRow { name, title, tracker_rate_hz, refresh_hz: refresh_hz.value, about })
    };
    let rows = PRESETS.iter().map(|(name, _)| row(name)).collect::<Result<Vec<_>, Failure>>()?;
    if json { output::print_json(&rows) } else { output::print(&text::presets(&rows)) }
}
