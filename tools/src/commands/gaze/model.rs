//! A session through a latency model, as options.

use crate::failure::Failure;
use clap::{Args, ValueEnum};
use macula_trackers::EyeState;
use macula_trackers::classify::ClassifierSettings;
use macula_trackers::estimator::{EstimatorSettings, FilterKind};
use macula_trackers::evaluate::{self, EventRow};
use macula_trackers::latency::{self, EstimatorAnswer, EyeInterval, LatencyModel, LatencyRun};
use macula_trackers::latency::{ArrivalTimes, RunSettings, SessionGaze};
use macula_trackers::predict::PredictorKind;
use macula_trackers::recording::Recording;
use std::path::Path;

/// What the renderer makes of the samples that it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AnswerName {
    /// The newest sample as it is
    Newest,
    /// The filtered gaze, held
    Hold,
    /// Straight on at the last velocity
    ConstantVelocity,
    /// Predicted at most once in 20 ms, and only while the eye moves
    Gate20,
    /// Kalman filter of position and velocity
    Kalman,
    /// Where a saccade will land
    Landing,
}

impl AnswerName {
    fn predictor(self) -> Option<PredictorKind> {
        match self {
            Self::Newest => None,
            Self::Hold => Some(PredictorKind::Hold),
            Self::ConstantVelocity => Some(PredictorKind::ConstantVelocity),
            Self::Gate20 => Some(PredictorKind::Gate20),
            Self::Kalman => Some(PredictorKind::Kalman),
            Self::Landing => Some(PredictorKind::Landing),
        }
    }
}

/// The filters before a predictor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FilterName {
    /// The raw gaze
    None,
    /// One-Euro
    OneEuro,
    /// Strong in a fixation, none in a saccade
    SaccadeAware,
}

/// Which latency, and what the renderer makes of the samples that it has.
#[derive(Args, Clone, Debug)]
pub struct LatencyArgs {
    /// Latency model: the name of a preset or a .toml file; `macula gaze latency --list-presets` lists
    /// the presets
    #[arg(long, value_name = "PRESET|FILE", default_value = "generic-90hz")]
    latency: String,
    /// What the renderer makes of the samples that it has
    #[arg(long, value_enum, value_name = "NAME", default_value = "newest")]
    predictor: AnswerName,
    /// Filter before the predictor [default: saccade-aware]
    #[arg(long, value_enum, value_name = "NAME")]
    filter: Option<FilterName>,
    /// Latch the gaze when the GPU begins with a frame, whatever the model says
    #[arg(long)]
    late_latch: bool,
    /// Measured times of a stage, as in gpu=render.json: gpu_ms of what `macula render --json` or
    /// `macula replay --json` printed (cpu_ms for cpu)
    #[arg(long, value_name = "STAGE=FILE")]
    measured: Vec<String>,
    /// Use the arrival times that the recording has instead of the model's
    #[arg(long)]
    recorded_arrival: bool,
    /// Radius around the gaze within which the picture has its full quality, degrees
    #[arg(long, value_name = "DEG", default_value_t = 5.0)]
    radius_deg: f64,
    /// Share of the time in which the true gaze may lie outside, 0 to 1
    #[arg(long, value_name = "SHARE", default_value_t = 0.02)]
    target_outside: f64,
    /// Seed of what the model draws: the same seed gives the same run
    #[arg(long, value_name = "N", default_value_t = 1)]
    latency_seed: u64,
}

impl LatencyArgs {
    /// The answer's name in reports.
    pub fn predictor_name(&self) -> &'static str {
        self.predictor.predictor().map_or("newest", |kind| kind.make().name())
    }

    /// The model, with what was measured.
    ///
    /// # Errors
    /// An unknown preset, a broken file, an unknown stage.
    pub fn model(&self) -> Result<LatencyModel, Failure> {
        let path = Path::new(&self.latency);
        let is_file = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
        let mut model = if is_file { LatencyModel::open(path)? } else { latency::preset(&self.latency)? };
        model.late_latch |= self.late_latch;
        for measured in &self.measured {
            set_measured(&mut model, measured)?;
        }
        Ok(model)
    }

    /// What the run is asked.
    pub fn settings(&self) -> RunSettings {
        RunSettings {
            radius_deg: self.radius_deg,
            target_outside: self.target_outside,
            arrival: if self.recorded_arrival { ArrivalTimes::Recorded } else { ArrivalTimes::Model },
            ..RunSettings::default()
        }
    }

    /// The session of a recording: its labels or true events where it has them, else what the online
    /// classifier finds.
    ///
    /// # Errors
    /// [`Failure::Environment`] for a recording without directions.
    pub fn session(&self, recording: &Recording) -> Result<SessionGaze, Failure> {
        let events = evaluate::labelled_events(recording)
            .unwrap_or_else(|| evaluate::events_of(recording, &ClassifierSettings::default()));
        Ok(SessionGaze::new(recording)?.with_intervals(&events.iter().map(interval).collect::<Vec<_>>()))
    }

    /// What answers instead of the newest sample, if anything does.
    pub fn answer<'a>(&self, recording: &'a Recording) -> Result<Option<EstimatorAnswer<'a>>, Failure> {
        let Some(predictor) = self.predictor.predictor() else {
            return match self.filter {
                Some(_) => Err(Failure::usage("--filter needs a --predictor behind it; add one")),
                None => Ok(None),
            };
        };
        let filter = match self.filter {
            Some(FilterName::None) => FilterKind::None,
            Some(FilterName::OneEuro) => FilterKind::OneEuro,
            Some(FilterName::SaccadeAware) | None => FilterKind::SaccadeAware,
        };
        let settings = EstimatorSettings { predictor, filter, ..EstimatorSettings::default() };
        Ok(Some(EstimatorAnswer::new(settings, recording)))
    }

    /// Runs the session through the model.
    ///
    /// # Errors
    /// Settings that are out of range or do not fit the session.
    pub fn run(&self, recording: &Recording, session: &SessionGaze) -> Result<LatencyRun, Failure> {
        let (model, settings) = (self.model()?, self.settings());
        Ok(match self.answer(recording)? {
            Some(mut answer) => {
                latency::run_with(session, &model, &settings, self.latency_seed, &mut answer)?
            }
            None => latency::run(session, &model, &settings, self.latency_seed)?,
        })
    }
}

fn set_measured(model: &mut LatencyModel, text: &str) -> Result<(), Failure> {
    let form = || Failure::usage(format!("--measured {text}: expected STAGE=FILE, as in gpu=render.json"));
    let (name, file) = text.split_once('=').ok_or_else(form)?;
    let stages = latency::Stage::ALL.into_iter().filter(|stage| !stage.is_simulated());
    let Some(stage) = stages.clone().find(|stage| stage.name() == name) else {
        let names = stages.map(latency::Stage::name).collect::<Vec<_>>().join(", ");
        return Err(Failure::usage(format!(
            "--measured {text}: there is no stage {name}; there are {names}"
        )));
    };
    let path = Path::new(file);
    let json = std::fs::read_to_string(path).map_err(|error| macula::Error::io(path, error))?;
    let key = if stage == latency::Stage::Cpu { "cpu_ms" } else { "gpu_ms" };
    let times = latency::measured_ms(path, &json, key)?;
    Ok(model.set_measured(stage, &times, file)?)
}

fn interval(event: &EventRow) -> EyeInterval {
    let state = [EyeState::Fixation, EyeState::Saccade, EyeState::Pursuit, EyeState::Blink, EyeState::Lost]
        .into_iter()
        .find(|state| state.name() == event.kind)
        .unwrap_or_default();
    let ns = |seconds: f64| (seconds * 1e9).round() as i64;
    EyeInterval { state, start_ns: ns(event.start_s), end_ns: ns(event.end_s) }
}
