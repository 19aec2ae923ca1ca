//! The options of `macula gaze latency`.

use crate::commands::gaze::input::ReadArgs;
use crate::commands::render::check_folder;
use crate::failure::Failure;
use crate::options::parse_within;
use clap::Args;
use macula_trackers::estimator::{EstimatorSettings, FilterKind};
use macula_trackers::latency::{
    ArrivalTimes, Delay, LatencyModel, RunSettings, Stage, StageTime, measured_ms, preset,
};
use macula_trackers::predict::PredictorKind;
use std::path::{Path, PathBuf};

/// A file of measured times is no larger, bytes.
const MOST_MEASURED_BYTES: u64 = 64 << 20;

/// How old and how far off the gaze is when its picture is displayed, and what foveation needs
///
/// Takes the recording through a model of tracker, renderer and display, refresh by refresh. Times from
/// which the model draws are in a preset or a TOML file (which may be based_on a preset). What the eye
/// did comes from labels in the recording, or else from the online classifier.
///
/// The renderer holds the newest sample that it has, unless --predictor or --filter puts the estimator
/// between; then the model's filter_delay is left out.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  macula gaze latency session.csv --preset vive-pro-eye -o latency.html\n  \
                        macula gaze latency session.csv --model mine.toml --predictor landing --late-latch --json\n  \
                        macula render hall -o a.png --json > gpu.json && \
                        macula gaze latency session.csv --preset generic-90hz --measured gpu=gpu.json\n  \
                        macula gaze latency --list-presets"
)]
pub struct LatencyArgs {
    /// The recording: any known format, recognised by its content
    #[arg(value_name = "FILE", required_unless_present = "list_presets")]
    pub file: Option<PathBuf>,
    #[command(flatten)]
    pub read: ReadArgs,
    /// A model that comes with macula; --list-presets names them
    #[arg(long, value_name = "NAME", required_unless_present_any = ["model", "list_presets"])]
    pub preset: Option<String>,
    /// A model from a TOML file
    #[arg(long, value_name = "FILE.toml", conflicts_with = "preset")]
    pub model: Option<PathBuf>,
    /// Lists the presets and does nothing else
    #[arg(long, conflicts_with_all = ["file", "preset", "model"])]
    pub list_presets: bool,
    /// Radius of full quality around the gaze, degrees
    #[arg(long, value_name = "R", default_value = "5", value_parser = |text: &str| parse_within(text, 0.0, 180.0))]
    pub radius_deg: f64,
    /// Share of the time, 0 to 1, in which the true gaze may lie outside the radius
    #[arg(long, value_name = "P", default_value = "0.02", value_parser = |text: &str| parse_within(text, 0.0, 1.0))]
    pub target: f64,
    /// The renderer asks this predictor for the gaze at the display time [filter: saccade-aware]
    #[arg(long, value_name = "NAME", value_enum)]
    pub predictor: Option<PredictorName>,
    /// The gaze is filtered by this [predictor: hold]
    #[arg(long, value_name = "NAME", value_enum)]
    pub filter: Option<FilterName>,
    /// The gaze is taken when the GPU begins instead of when the CPU does
    #[arg(long)]
    pub late_latch: bool,
    /// Replaces a stage by measured times: ms from the field STAGE_ms of a JSON file, as gpu_ms of
    /// `macula render --json`; may be given for several stages
    #[arg(long, value_name = "STAGE=FILE.json")]
    pub measured: Vec<String>,
    /// Samples arrive when the recording says that they did, not when the model has them arrive
    #[arg(long)]
    pub recorded_arrival: bool,
    /// Seed of everything that the model draws
    #[arg(long, value_name = "N", default_value = "1")]
    pub seed: u64,
    /// Writes a page with plots: one HTML file that needs nothing else
    #[arg(short, long, value_name = "PAGE.html")]
    pub output: Option<PathBuf>,
    /// Writes a CSV row for each refresh of the display
    #[arg(long, value_name = "FRAMES.csv")]
    pub ledger: Option<PathBuf>,
    /// Writes a CSV row for each sample: when it was taken, had, used and shown
    #[arg(long, value_name = "SAMPLES.csv")]
    pub sample_ledger: Option<PathBuf>,
}

/// Predictors by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum PredictorName {
    /// The last sample
    Hold,
    /// Straight on
    ConstantVelocity,
    /// 20 ms straight on, at most once in 20 ms
    Gate20,
    /// Kalman filter of position and velocity
    Kalman,
    /// Landing point of saccades
    Landing,
}

impl PredictorName {
    fn kind(self) -> PredictorKind {
        match self {
            Self::Hold => PredictorKind::Hold,
            Self::ConstantVelocity => PredictorKind::ConstantVelocity,
            Self::Gate20 => PredictorKind::Gate20,
            Self::Kalman => PredictorKind::Kalman,
            Self::Landing => PredictorKind::Landing,
        }
    }
}

/// Filters by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum FilterName {
    /// None
    None,
    /// One-Euro
    OneEuro,
    /// Smooths fixations and lets saccades through
    SaccadeAware,
}

impl FilterName {
    fn kind(self) -> FilterKind {
        match self {
            Self::None => FilterKind::None,
            Self::OneEuro => FilterKind::OneEuro,
            Self::SaccadeAware => FilterKind::SaccadeAware,
        }
    }
}

/// A value's name on the command line.
fn name_of(value: impl clap::ValueEnum) -> String {
    value.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
}

impl LatencyArgs {
    /// What the run is asked.
    pub fn settings(&self) -> RunSettings {
        RunSettings {
            radius_deg: self.radius_deg,
            target_outside: self.target,
            arrival: if self.recorded_arrival { ArrivalTimes::Recorded } else { ArrivalTimes::Model },
            ..RunSettings::default()
        }
    }

    /// The model with what the options change in it.
    ///
    /// # Errors
    /// An unknown preset, a broken file, a stage that does not exist.
    pub fn model(&self) -> Result<LatencyModel, Failure> {
        let mut model = match (&self.preset, &self.model) {
            (Some(name), None) => preset(name)?,
            (None, Some(path)) => LatencyModel::open(path)?,
            _ => return Err(Failure::usage("give either --preset or --model")),
        };
        model.late_latch |= self.late_latch;
        if self.estimator().is_some() {
            let source = "part of the estimator".to_owned();
            let delay = Delay::Constant { ms: 0.0 };
            model.set(Stage::FilterDelay, StageTime { delay, source, guess: false })?;
        }
        let mut given = Vec::new();
        for argument in &self.measured {
            let (stage, path) = parse_measured(argument)?;
            if given.contains(&stage) {
                return Err(Failure::usage(format!("--measured {} is given twice", stage.name())));
            }
            if stage == Stage::FilterDelay && self.estimator().is_some() {
                return Err(Failure::usage(
                    "--measured filter_delay and --predictor or --filter contradict each other: the filter is \
                     part of the estimator",
                ));
            }
            if self.recorded_arrival && stage < Stage::FilterDelay {
                return Err(Failure::usage(format!(
                    "--measured {} and --recorded-arrival contradict each other: arrival times of the \
                     recording take the place of that stage",
                    stage.name()
                )));
            }
            given.push(stage);
            let values_ms = read_measured(path, stage)?;
            let source = format!("{} measured values of {}", values_ms.len(), path.display());
            model.set_measured(stage, &values_ms, &source)?;
        }
        Ok(model)
    }

    /// The estimator between samples and renderer; `None` where the newest sample is held.
    pub fn estimator(&self) -> Option<EstimatorSettings> {
        let (predictor, filter) = self.estimator_names()?;
        Some(EstimatorSettings {
            predictor: predictor.kind(),
            filter: filter.kind(),
            ..EstimatorSettings::default()
        })
    }

    fn estimator_names(&self) -> Option<(PredictorName, FilterName)> {
        (self.predictor.is_some() || self.filter.is_some()).then(|| {
            let predictor = self.predictor.unwrap_or(PredictorName::Hold);
            (predictor, self.filter.unwrap_or(FilterName::SaccadeAware))
        })
    }

    /// What the renderer takes the gaze to be, in words.
    pub fn answer_words(&self) -> String {
        match self.estimator_names() {
            None => "the newest sample that it has".into(),
            Some((predictor, filter)) => format!(
                "the estimate for the display time (predictor {}, filter {})",
                name_of(predictor),
                name_of(filter)
            ),
        }
    }

    /// Fails where one output would replace another or an input, or has no folder: before long work.
    ///
    /// # Errors
    /// Then.
    pub fn check_outputs(&self, file: &Path) -> Result<(), Failure> {
        let outputs = [&self.output, &self.ledger, &self.sample_ledger].into_iter().flatten();
        let measured = self.measured.iter().filter_map(|argument| Some(argument.split_once('=')?.1));
        let mut taken: Vec<PathBuf> = std::iter::once(file)
            .chain(self.model.as_deref())
            .chain(measured.map(Path::new))
            .map(place)
            .collect();
        for output in outputs {
            check_folder(output)?;
            let place = place(output);
            if taken.contains(&place) {
                let path = output.display();
                return Err(Failure::usage(format!(
                    "{path} is given twice; each file needs a name of its own"
                )));
            }
            taken.push(place);
        }
        Ok(())
    }
}

/// Where a path leads, as far as that exists.
fn place(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let beside = || Some(folder.canonicalize().ok()?.join(path.file_name()?));
    path.canonicalize().ok().or_else(beside).unwrap_or_else(|| path.to_owned())
}

fn parse_measured(argument: &str) -> Result<(Stage, &Path), Failure> {
    let Some((name, path)) = argument.split_once('=') else {
        return Err(Failure::usage(format!(
            "--measured {argument}: expected STAGE=FILE.json, as in gpu=render.json"
        )));
    };
    let known = || Stage::ALL.into_iter().filter(|stage| !stage.is_simulated());
    let stage = known().find(|stage| stage.name() == name).ok_or_else(|| {
        let names: Vec<&str> = known().map(Stage::name).collect();
        Failure::usage(format!("--measured: there is no stage {name}; known are {}", names.join(", ")))
    })?;
    Ok((stage, Path::new(path)))
}

fn read_measured(path: &Path, stage: Stage) -> Result<Vec<f64>, Failure> {
    let read = || {
        let length = std::fs::metadata(path)?.len();
        if length > MOST_MEASURED_BYTES {
            return Ok(None);
        }
        std::fs::read_to_string(path).map(Some)
    };
    let text = read().map_err(|source| macula_trackers::Error::io(path, source))?;
    let Some(text) = text else {
        let cause = format!("is larger than {} MiB; it is no report", MOST_MEASURED_BYTES >> 20);
        return Err(Failure::environment(format!("{}: {cause}", path.display())));
    };
    Ok(measured_ms(path, &text, &format!("{}_ms", stage.name()))?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Only {
        #[command(flatten)]
        args: LatencyArgs,
    }

    fn args(options: &str) -> Option<LatencyArgs> {
        let words = format!("latency {options}");
        Only::try_parse_from(words.split_whitespace()).ok().map(|only| only.args)
    }

    #[test]
    fn a_run_needs_a_recording_and_one_model() {
        for wrong in [
            "",
            "a.csv",
            "--preset fove-0",
            "a.csv --preset fove-0 --model a.toml",
            "a.csv --preset fove-0 --list-presets",
            "a.csv --preset fove-0 --target 1.5",
            "a.csv --preset fove-0 --radius-deg nan",
            "a.csv --preset fove-0 --predictor crystal-ball",
        ] {
            assert!(args(wrong).is_none(), "{wrong}");
        }
        for right in ["a.csv --preset fove-0", "a.csv --model a.toml", "--list-presets"] {
            assert!(args(right).is_some(), "{right}");
        }
    }

    #[test]
    fn the_estimator_is_used_where_it_is_named() {
        let estimator = |options: &str| {
            let args = args(&format!("a.csv --preset fove-0 {options}"))?;
            args.estimator().map(|settings| (settings.predictor, settings.filter))
        };
        assert_eq!(estimator(""), None);
        let predictor = estimator("--predictor kalman");
        assert_eq!(predictor, Some((PredictorKind::Kalman, FilterKind::SaccadeAware)));
        assert_eq!(estimator("--filter one-euro"), Some((PredictorKind::Hold, FilterKind::OneEuro)));
        let names = ["hold", "constant-velocity", "gate20", "kalman", "landing"];
        let kinds = names.map(|name| estimator(&format!("--predictor {name}")).map(|kinds| kinds.0));
        assert_eq!(kinds, PredictorKind::ALL.map(Some));
    }

    #[test]
    fn measured_stages_are_named_once_and_exist() {
        let model =
            |options: &str| args(&format!("a.csv --preset fove-0 {options}")).map(|args| args.model());
        for wrong in [
            "--measured gpu",
            "--measured nothing=a.json",
            "--measured pacing=a.json",
            "--measured exposure=a.json --recorded-arrival",
            "--measured filter_delay=a.json --filter none",
        ] {
            assert!(matches!(model(wrong), Some(Err(Failure::Usage(_)))), "{wrong}");
        }
        assert!(matches!(model("--measured gpu=no/such.json"), Some(Err(Failure::Environment(_)))));
        assert!(matches!(model("--late-latch"), Some(Ok(model)) if model.late_latch));
    }

    #[test]
    fn no_output_replaces_another_file() {
        let check = |options: &str| {
            args(&format!("a.csv --preset fove-0 {options}"))
                .map(|args| args.check_outputs(Path::new("a.csv")))
        };
        for wrong in ["-o a.csv", "-o ./a.csv", "-o b.html --ledger b.html", "--ledger no/such/folder/b.csv"]
        {
            assert!(matches!(check(wrong), Some(Err(_))), "{wrong}");
        }
        assert!(matches!(check("-o b.html --ledger b.csv --sample-ledger c.csv"), Some(Ok(()))));
    }
}
