//! `macula gaze synth`: a session of an eye that does not exist, with the truth beside it.

use super::session::parse_seconds;
use super::target::{ForceArgs, names, written};
use crate::failure::Failure;
use crate::output;
use clap::Args;
use clap::builder::PossibleValuesParser;
use glam::{DQuat, DVec2, DVec3};
use macula_trackers::bids;
use macula_trackers::recording::Recording;
use macula_trackers::sample::EyeSample;
use macula_trackers::synthetic::{PRESETS, SyntheticEye, SyntheticSettings, TRACKERS, TrackerSettings};
use serde::Serialize;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// The most bytes of a file of settings.
const MAX_SETTINGS: u64 = 1 << 20;

const AFTER_HELP: &str = "\
Presets:
  target-task     jumping targets on a screen, the head held
  free-viewing    looking at pictures on a screen, the head held
  reading         lines of text
  pursuit         following what moves, with saccades between
  vr-exploration  looking about in a headset, with a head that follows

The recording has the truth in extra columns: evt_truth (1 fixation, 2 saccade, 3 oscillation, 4 pursuit,
5 blink, 6 lost, 7 microsaccade) and true_direction_x, _y, _z. The same command writes the same samples.

Examples:
  macula gaze synth -o eye --preset vr-exploration --seconds 60 --seed 7
  macula gaze synth --preset reading --show-settings > mine.toml
  macula gaze synth -o eye --preset reading --settings mine.toml";

/// Write a session of a synthetic eye, with the truth beside the samples
#[derive(Args, Debug)]
#[command(after_help = AFTER_HELP)]
pub struct SynthArgs {
    /// The recording to write: NAME.tsv.gz with NAME.json; to another name _recording-eye3_physio is added
    #[arg(short, long, value_name = "NAME", required_unless_present = "show_settings")]
    output: Option<PathBuf>,
    /// What the eye does
    #[arg(long, value_name = "PRESET", default_value = "free-viewing", value_parser = PossibleValuesParser::new(PRESETS))]
    preset: String,
    /// Which tracker sees it, instead of the preset's
    #[arg(long, value_name = "TRACKER", value_parser = PossibleValuesParser::new(TRACKERS))]
    tracker: Option<String>,
    /// How long
    #[arg(long, value_name = "S", default_value = "60", value_parser = parse_seconds)]
    seconds: f64,
    /// Samples per second, instead of the tracker's
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// The same seed gives the same eye, at any rate and with any tracker
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// TOML with settings that go over the preset's and the tracker's
    #[arg(long, value_name = "FILE.toml")]
    settings: Option<PathBuf>,
    /// Round values (not times) to so many decimals, as most trackers' files do: takes less room
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=12))]
    decimals: Option<u8>,
    /// Print all settings as TOML, and write nothing
    #[arg(long, conflicts_with = "output")]
    show_settings: bool,
    #[command(flatten)]
    force: ForceArgs,
}

#[derive(Serialize)]
struct Written<'a> {
    files: Vec<PathBuf>,
    preset: &'a str,
    seed: u64,
    samples: usize,
    rate_hz: f64,
    /// Of the truth.
    events: usize,
}

/// Runs the command.
///
/// # Errors
/// A setting out of its range, settings that cannot be read, a recording that is there already or cannot
/// be written.
pub fn run(args: &SynthArgs, json: bool) -> Result<(), Failure> {
    let settings = settings(args)?;
    settings.check()?;
    let Some(path) = &args.output else {
        let text = toml::to_string(&settings)
            .map_err(|error| Failure::environment(format!("the settings cannot be written: {error}")))?;
        return output::print(&text);
    };
    args.force.check(path)?;
    let rate_hz = settings.tracker.rate_hz;
    let mut eye = SyntheticEye::new(settings, args.seed)?;
    let (mut recording, truth) = eye.record((args.seconds * 1e9).round() as i64, rate_hz)?;
    recording.info.device = format!("{}, preset {}", recording.info.device, args.preset);
    if let Some(decimals) = args.decimals {
        recording = rounded(&recording, decimals);
    }
    bids::write_recording(&recording, path)?;
    let written = Written {
        files: written(path),
        preset: &args.preset,
        seed: args.seed,
        samples: recording.len(),
        rate_hz,
        events: truth.events.len(),
    };
    if json {
        return output::print_json(&written);
    }
    output::print(&output::fields(&[
        ("preset", format!("{}, seed {}", written.preset, written.seed)),
        ("samples", output::grouped(written.samples as u64)),
        ("rate", format!("{rate_hz} Hz")),
        ("events", format!("{} in truth", written.events)),
        ("written", names(&written.files)),
    ]))
}

/// The preset, then the tracker, then the file, then the rate.
fn settings(args: &SynthArgs) -> Result<SyntheticSettings, Failure> {
    let mut settings = SyntheticSettings::preset(&args.preset)?;
    if let Some(tracker) = &args.tracker {
        settings.tracker = TrackerSettings::preset(tracker)?;
    }
    if let Some(path) = &args.settings {
        settings = over(&settings, path)?;
    }
    settings.tracker.rate_hz = args.rate.unwrap_or(settings.tracker.rate_hz);
    Ok(settings)
}

/// Settings with those of a file over them.
fn over(settings: &SyntheticSettings, path: &Path) -> Result<SyntheticSettings, Failure> {
    let broken = |cause: String| Failure::from(macula_trackers::Error::file(path, cause));
    let io = |error| Failure::from(macula_trackers::Error::io(path, error));
    if path.metadata().map_err(io)?.len() > MAX_SETTINGS {
        return Err(broken(format!("is longer than {MAX_SETTINGS} bytes, so no file of settings")));
    }
    let text = std::fs::read_to_string(path).map_err(io)?;
    let file = text.parse::<Table>().map_err(|error| broken(format!("is no TOML: {error}")))?;
    let mut all = Table::try_from(settings).map_err(|error| broken(error.to_string()))?;
    for (name, value) in file {
        match (all.get_mut(&name), value) {
            (Some(Value::Table(part)), Value::Table(over)) => part.extend(over),
            (_, value) => _ = all.insert(name, value),
        }
    }
    all.try_into().map_err(|error| broken(format!("{error}; --show-settings prints what there is")))
}

/// The recording with its values rounded.
fn rounded(recording: &Recording, decimals: u8) -> Recording {
    let scale = 10f64.powi(i32::from(decimals));
    // A zero has no sign to keep.
    let number = |value: f64| (value * scale).round() / scale + 0.0;
    let vector = |value: DVec3| DVec3::from_array(value.to_array().map(number));
    let point = |value: DVec2| DVec2::from_array(value.to_array().map(number));
    let eye = |eye: EyeSample| EyeSample {
        valid: eye.valid,
        origin_m: eye.origin_m.map(vector),
        direction: eye.direction.map(vector),
        point: eye.point.map(point),
        confidence: eye.confidence.map(number),
        pupil_mm: eye.pupil_mm.map(number),
        openness: eye.openness.map(number),
    };
    let mut rounded = Recording::new(recording.info.clone());
    for mut sample in recording.samples() {
        (sample.combined, sample.left, sample.right) =
            (eye(sample.combined), eye(sample.left), eye(sample.right));
        if let Some(head) = &mut sample.head {
            head.position_m = vector(head.position_m);
            head.world_from_view = DQuat::from_array(head.world_from_view.to_array().map(number));
        }
        rounded.push(&sample);
    }
    rounded.extra = recording.extra.clone();
    for column in &mut rounded.extra {
        column.values.iter_mut().for_each(|value| *value = number(*value));
    }
    rounded.info.notes.push(format!("Values were rounded to {decimals} decimals."));
    rounded
}
