//! How a session runs through a latency model: options of every command that does it.

use crate::failure::Failure;
use crate::options::parse_within;
use clap::Args;
use macula_trackers::estimator::{EstimatorSettings, FilterKind};
use macula_trackers::latency::{
    ArrivalTimes, Delay, EstimatorAnswer, LatencyModel, LatencyRun, RunSettings, SessionGaze, Stage,
    StageTime, measured_ms, run, run_with,
};
use macula_trackers::predict::PredictorKind;
use macula_trackers::recording::Recording;
use std::path::Path;

/// A file of measured times is no larger, bytes.
const MOST_MEASURED_BYTES: u64 = 64 << 20;

/// How the session runs.
#[derive(Args, Clone, Debug)]
pub struct RunArgs {
    /// Radius of full quality around the gaze, degrees
    #[arg(long, value_name = "R", default_value = "5", value_parser = |text: &str| parse_within(text, 0.0, 180.0))]
    radius_deg: f64,
    /// Share of the time, 0 to 1, in which the true gaze may lie outside the radius
    #[arg(long, value_name = "P", default_value = "0.02", value_parser = |text: &str| parse_within(text, 0.0, 1.0))]
    target: f64,
    /// The renderer asks this predictor for the gaze at the display time [filter: saccade-aware]
    #[arg(long, value_name = "NAME", value_enum)]
    predictor: Option<PredictorName>,
    /// The gaze is filtered by this [predictor: hold]
    #[arg(long, value_name = "NAME", value_enum)]
    filter: Option<FilterName>,
    /// The gaze is taken when the GPU begins instead of when the CPU does
    #[arg(long)]
    late_latch: bool,
    /// Replaces a stage by measured times: ms from the field STAGE_ms of a JSON file, as gpu_ms of
    /// `macula render --json`; may be given for several stages
    #[arg(long, value_name = "STAGE=FILE.json")]
    pub measured: Vec<String>,
    /// Samples arrive when the recording says that they did, not when the model has them arrive
    #[arg(long)]
    recorded_arrival: bool,
    /// Seed of everything that the model draws
    #[arg(long, value_name = "N", default_value = "1")]
    pub seed: u64,
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

impl RunArgs {
    /// What the run is asked.
    pub fn settings(&self) -> RunSettings {
        RunSettings {
            radius_deg: self.radius_deg,
            target_outside: self.target,
            arrival: if self.recorded_arrival { ArrivalTimes::Recorded } else { ArrivalTimes::Model },
            ..RunSettings::default()
        }
    }

    /// A model with what the options change in it.
    ///
    /// # Errors
    /// Measured times that cannot be read or have no place, and options that contradict each other.
    pub fn changed(&self, mut model: LatencyModel) -> Result<LatencyModel, Failure> {
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

    /// The estimator on a recording, where one is asked for.
    pub fn answer<'a>(&self, recording: &'a Recording) -> Option<EstimatorAnswer<'a>> {
        self.estimator().map(|settings| EstimatorAnswer::new(settings, recording))
    }

    /// Runs a session through a model. `answer` is that of [`Self::answer`].
    ///
    /// # Errors
    /// Settings that do not fit the session.
    pub fn through(
        &self,
        model: &LatencyModel,
        session: &SessionGaze,
        answer: Option<&mut EstimatorAnswer<'_>>,
    ) -> Result<LatencyRun, Failure> {
        Ok(match answer {
            Some(answer) => run_with(session, model, &self.settings(), self.seed, answer)?,
            None => run(session, model, &self.settings(), self.seed)?,
        })
    }
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
