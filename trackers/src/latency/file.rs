//! A model's TOML file.

use super::model::{Known, LatencyModel};
use super::preset;
use super::stage::{Delay, Stage, StageTime};
use crate::error::{Error, Result};
use serde::Deserialize;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;

/// No model file is longer, bytes; a list of a million measured values is.
const MOST_BYTES: u64 = 16 << 20;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ModelFile {
    name: Option<String>,
    about: Option<String>,
    /// A preset that gives what this file does not.
    based_on: Option<Spanned<String>>,
    tracker: Option<Spanned<TrackerFile>>,
    display: Option<Spanned<DisplayFile>>,
    #[serde(default)]
    renderer: RendererFile,
    #[serde(default)]
    stages: StagesFile,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TrackerFile {
    rate_hz: Option<f64>,
    phase: Option<f64>,
    #[serde(default)]
    source: String,
    #[serde(default)]
    guess: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DisplayFile {
    refresh_hz: Option<f64>,
    phase: Option<f64>,
    #[serde(default)]
    source: String,
    #[serde(default)]
    guess: bool,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct RendererFile {
    frames_ahead: Option<f64>,
    late_latch: Option<bool>,
    latch_before_gpu_ms: Option<f64>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct StagesFile {
    exposure: Option<Spanned<StageFile>>,
    readout: Option<Spanned<StageFile>>,
    tracker_processing: Option<Spanned<StageFile>>,
    polling: Option<Spanned<StageFile>>,
    wakeup: Option<Spanned<StageFile>>,
    filter_delay: Option<Spanned<StageFile>>,
    cpu: Option<Spanned<StageFile>>,
    gpu: Option<Spanned<StageFile>>,
    compositor: Option<Spanned<StageFile>>,
    scanout: Option<Spanned<StageFile>>,
    panel: Option<Spanned<StageFile>>,
}

impl StagesFile {
    fn into_list(self) -> [(Stage, Option<Spanned<StageFile>>); 11] {
        [
            (Stage::Exposure, self.exposure),
            (Stage::Readout, self.readout),
            (Stage::TrackerProcessing, self.tracker_processing),
            (Stage::Polling, self.polling),
            (Stage::Wakeup, self.wakeup),
            (Stage::FilterDelay, self.filter_delay),
            (Stage::Cpu, self.cpu),
            (Stage::Gpu, self.gpu),
            (Stage::Compositor, self.compositor),
            (Stage::Scanout, self.scanout),
            (Stage::Panel, self.panel),
        ]
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StageFile {
    constant_ms: Option<f64>,
    uniform_ms: Option<[f64; 2]>,
    normal_ms: Option<NormalFile>,
    lognormal_ms: Option<LogNormalFile>,
    exponential_ms: Option<ExponentialFile>,
    measured_ms: Option<Vec<f64>>,
    #[serde(default)]
    source: String,
    #[serde(default)]
    guess: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NormalFile {
    mean: f64,
    sd: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LogNormalFile {
    #[serde(default)]
    shift: f64,
    median: f64,
    sigma: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ExponentialFile {
    #[serde(default)]
    shift: f64,
    mean: f64,
}

impl StageFile {
    fn into_time(self) -> Result<StageTime, String> {
        let given = [
            self.constant_ms.map(|ms| Delay::Constant { ms }),
            self.uniform_ms.map(|[low_ms, high_ms]| Delay::Uniform { low_ms, high_ms }),
            self.normal_ms.map(|given| Delay::Normal { mean_ms: given.mean, sd_ms: given.sd }),
            self.lognormal_ms.map(|given| Delay::LogNormal {
                shift_ms: given.shift,
                median_ms: given.median,
                sigma: given.sigma,
            }),
            self.exponential_ms
                .map(|given| Delay::Exponential { shift_ms: given.shift, mean_ms: given.mean }),
            self.measured_ms.map(|values| Delay::Measured(values.into())),
        ];
        let mut given = given.into_iter().flatten();
        let (Some(delay), None) = (given.next(), given.next()) else {
            return Err("give exactly one of constant_ms, uniform_ms, normal_ms, lognormal_ms, \
                        exponential_ms and measured_ms"
                .into());
        };
        delay.check().map_err(|error| error.to_string())?;
        check_source(&self.source, self.guess)?;
        Ok(StageTime { delay, source: self.source, guess: self.guess })
    }
}

fn check_source(source: &str, guess: bool) -> Result<(), String> {
    if source.trim().is_empty() && !guess {
        return Err("say where the figure comes from in source, or guess = true".into());
    }
    Ok(())
}

/// Lines count from 1.
fn line_of(text: &str, span: &Range<usize>) -> usize {
    let before = text.as_bytes().get(..span.start).unwrap_or(text.as_bytes());
    1 + before.iter().filter(|byte| **byte == b'\n').count()
}

impl LatencyModel {
    /// Reads a model's file.
    ///
    /// # Errors
    /// [`Error::Io`], and [`Error::File`] as [`Self::from_toml`].
    pub fn open(path: &Path) -> Result<Self> {
        let metadata = std::fs::metadata(path).map_err(|source| Error::io(path, source))?;
        if metadata.is_dir() {
            return Err(Error::file(path, "is a folder; give a latency model's TOML file"));
        }
        if metadata.len() > MOST_BYTES {
            return Err(Error::file(path, format!("is larger than {MOST_BYTES} bytes; it is no model")));
        }
        let text = std::fs::read_to_string(path).map_err(|source| Error::io(path, source))?;
        Self::from_toml(path, &text)
    }

    /// Reads a model from TOML text; `path` is for messages.
    ///
    /// # Errors
    /// [`Error::File`] with the line: a syntax error, an unknown key, a stage that is missing where the
    /// file is based on no preset, a figure out of range, or one without a source that is no guess.
    pub fn from_toml(path: &Path, text: &str) -> Result<Self> {
        let file: ModelFile = toml::from_str(text).map_err(|error| {
            let line = error.span().map_or(1, |span| line_of(text, &span));
            Error::file(path, format!("line {line}: {}", error.message()))
        })?;
        let at = |span: Range<usize>, cause: &dyn std::fmt::Display| {
            Error::file(path, format!("line {}: {cause}", line_of(text, &span)))
        };
        let base = match &file.based_on {
            None => None,
            Some(name) => Some(preset(name.get_ref()).map_err(|error| at(name.span(), &error))?),
        };
        let based = base.is_some();
        let mut model = base.unwrap_or_else(|| Self::instant(f64::NAN));
        if let Some(name) = file.name {
            model.name = name;
        } else if !based {
            return Err(Error::file(path, "has no name; add name = \"...\" at the top"));
        }
        model.about = file.about.unwrap_or(model.about);
        if let Some(tracker) = file.tracker {
            let span = tracker.span();
            model.take_tracker(tracker.into_inner()).map_err(|cause| at(span, &cause))?;
        }
        if let Some(display) = file.display {
            let span = display.span();
            model.take_display(display.into_inner()).map_err(|cause| at(span, &cause))?;
        }
        if model.refresh_hz.value.is_nan() {
            return Err(Error::file(path, "has no refresh_hz; add it under [display]"));
        }
        model.frames_ahead =
            file.renderer.frames_ahead.unwrap_or(if based { model.frames_ahead } else { 1.0 });
        model.late_latch = file.renderer.late_latch.unwrap_or(model.late_latch);
        model.latch_before_gpu_ms = file.renderer.latch_before_gpu_ms.unwrap_or(model.latch_before_gpu_ms);
        for (stage, given) in file.stages.into_list() {
            match given {
                Some(given) => {
                    let span = given.span();
                    let time = given.into_inner().into_time();
                    model.times[stage as usize] =
                        time.map_err(|cause| at(span, &format!("stage {}: {cause}", stage.name())))?;
                }
                None if based => {}
                None => {
                    let cause = format!("stage {} is missing; add it, or based_on = a preset", stage.name());
                    return Err(Error::file(path, cause));
                }
            }
        }
        model.check().map_err(|error| Error::file(path, error))?;
        Ok(model)
    }

    fn take_tracker(&mut self, given: TrackerFile) -> Result<(), String> {
        self.tracker_phase = given.phase.or(self.tracker_phase);
        if let Some(value) = given.rate_hz {
            check_source(&given.source, given.guess)?;
            self.tracker_rate_hz = Some(Known { value, source: given.source, guess: given.guess });
        }
        self.check_phases()
    }

    fn take_display(&mut self, given: DisplayFile) -> Result<(), String> {
        self.display_phase = given.phase.or(self.display_phase);
        if let Some(value) = given.refresh_hz {
            check_source(&given.source, given.guess)?;
            self.refresh_hz = Known { value, source: given.source, guess: given.guess };
        }
        self.check_phases()
    }

    /// Rates too, where they are known by now, for an error with its line.
    fn check_phases(&self) -> Result<(), String> {
        let known = Self {
            refresh_hz: Known {
                value: if self.refresh_hz.value.is_nan() { 1.0 } else { self.refresh_hz.value },
                ..self.refresh_hz.clone()
            },
            ..self.clone()
        };
        known.check().map_err(|error| error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<LatencyModel> {
        LatencyModel::from_toml(Path::new("model.toml"), text)
    }

    #[test]
    fn a_preset_is_changed_where_the_file_says_so() {
        let text = "based_on = \"generic-90hz\"\n[display]\nrefresh_hz = 120\nguess = true\n\
                    [renderer]\nlate_latch = true\n\
                    [stages.gpu]\nmeasured_ms = [3, 5]\nsource = \"a bench\"\n";
        let (model, base) = (of(text).expect("a model"), preset("generic-90hz").expect("a preset"));
        assert_eq!(model.refresh_hz.value, 120.0);
        assert_eq!(model.stage(Stage::Gpu).delay, Delay::Measured([3.0, 5.0].into()));
        assert_eq!(model.stage(Stage::Readout), base.stage(Stage::Readout));
        assert!(model.late_latch && !base.late_latch);
    }

    #[test]
    fn every_kind_of_delay_is_read() {
        let text = "based_on = \"generic-90hz\"\n\
                    [stages.exposure]\nconstant_ms = 8\nguess = true\n\
                    [stages.readout]\nuniform_ms = [1, 2]\nguess = true\n\
                    [stages.cpu]\nnormal_ms = { mean = 3, sd = 0.5 }\nguess = true\n\
                    [stages.gpu]\nlognormal_ms = { median = 6, sigma = 0.2 }\nguess = true\n\
                    [stages.wakeup]\nexponential_ms = { shift = 0.1, mean = 0.4 }\nguess = true\n";
        let model = of(text).expect("a model");
        let delay = |stage| model.stage(stage).delay.clone();
        assert_eq!(delay(Stage::Exposure), Delay::Constant { ms: 8.0 });
        assert_eq!(delay(Stage::Readout), Delay::Uniform { low_ms: 1.0, high_ms: 2.0 });
        assert_eq!(delay(Stage::Cpu), Delay::Normal { mean_ms: 3.0, sd_ms: 0.5 });
        let expected = Delay::LogNormal { shift_ms: 0.0, median_ms: 6.0, sigma: 0.2 };
        assert_eq!(delay(Stage::Gpu), expected);
        assert_eq!(delay(Stage::Wakeup), Delay::Exponential { shift_ms: 0.1, mean_ms: 0.4 });
    }

    #[test]
    fn what_is_no_file_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let message = LatencyModel::open(folder.path()).expect_err("a folder").to_string();
        assert!(message.contains("is a folder"), "{message}");
        let missing = folder.path().join("none.toml");
        assert!(matches!(LatencyModel::open(&missing), Err(Error::Io { .. })));
        std::fs::write(&missing, b"name = \"\xff\"").expect("a file");
        assert!(LatencyModel::open(&missing).is_err());
    }

    #[test]
    fn hostile_files_are_refused_with_their_line() {
        let cases = [
            ("name = \"x\"\nspeed = 9\n", "line 2"),
            ("name = \"x\"\n[stages]\nsampling_wait = { constant_ms = 1, guess = true }\n", "line 3"),
            ("name = \"x\"\n[stages.gpu]\nconstant_s = 1\n", "line 3"),
            ("based_on = \"generic-90hz\"\n\n[stages.gpu]\nconstant_ms = -1\nguess = true\n", "line 3"),
            ("based_on = \"generic-90hz\"\n[stages.gpu]\nconstant_ms = 1\n", "line 2"),
            ("based_on = \"generic-90hz\"\n[stages.gpu]\nguess = true\n", "line 2"),
            (
                "based_on = \"generic-90hz\"\n[stages.gpu]\nconstant_ms = 1\nuniform_ms = [1, 2]\nguess = true\n",
                "line 2",
            ),
            ("based_on = \"generic-90hz\"\n[stages.gpu]\nconstant_ms = nan\nguess = true\n", "line 2"),
            ("based_on = \"generic-90hz\"\n[stages.gpu]\nuniform_ms = [1]\nguess = true\n", "line 3"),
            ("\nbased_on = \"nothing\"\n", "line 2"),
            ("based_on = \"generic-90hz\"\n[display]\nrefresh_hz = 0\nguess = true\n", "line 2"),
            ("based_on = \"generic-90hz\"\n[tracker]\nrate_hz = inf\nguess = true\n", "line 2"),
            ("based_on = \"generic-90hz\"\n[tracker]\nphase = 3\n", "line 2"),
            ("based_on = \"generic-90hz\"\n[renderer]\nframes_ahead = -1\n", "frames_ahead"),
            ("name = \"x\"\n[display]\nrefresh_hz = 90\nguess = true\n", "stage exposure is missing"),
            ("name = \"x\"\n", "refresh_hz"),
            ("", "name"),
            ("name = ", "line 1"),
            ("\u{0}", "line 1"),
        ];
        for (text, expected) in cases {
            let message = of(text).expect_err(text).to_string();
            assert!(message.starts_with("model.toml: ") && message.contains(expected), "{text}: {message}");
            assert_eq!(message.lines().count(), 1, "{message}");
        }
    }
}
