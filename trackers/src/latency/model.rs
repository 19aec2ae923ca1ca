//! The model of a whole system: tracker, renderer and display.

use super::stage::{Delay, Stage, StageTime};
use crate::error::{Error, Result};
use serde_json::Value;
use std::path::Path;

/// A figure of a device, and how it is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Known<T> {
    /// The figure.
    pub value: T,
    /// Where it comes from.
    pub source: String,
    /// It is from no source.
    pub guess: bool,
}

/// How the stages hang together, and how long each takes.
#[derive(Clone, Debug, PartialEq)]
pub struct LatencyModel {
    /// A short name.
    pub name: String,
    /// What it is a model of, a sentence or two.
    pub about: String,
    /// Samples per second of the tracker. A recording of a higher rate is thinned to it; `None` and
    /// lower rates take every sample.
    pub tracker_rate_hz: Option<Known<f64>>,
    /// Where between two samples of the recording the tracker's first one lies, 0 to 1; `None` draws it.
    pub tracker_phase: Option<f64>,
    /// Refreshes per second of the display.
    pub refresh_hz: Known<f64>,
    /// Where the first refresh lies, as a fraction of a frame after the first sample; `None` draws it.
    pub display_phase: Option<f64>,
    /// How many refreshes before its own one the work on a picture begins. A smaller value lowers the
    /// age and leaves less time for CPU and GPU; what is not ready in time is shown a refresh later.
    pub frames_ahead: f64,
    /// The gaze is written when the GPU begins, not when the CPU records.
    pub late_latch: bool,
    /// How long before the GPU begins a late latch takes the gaze, ms.
    pub latch_before_gpu_ms: f64,
    pub(super) times: [StageTime; Stage::ALL.len()],
}

impl LatencyModel {
    /// A model in which no stage takes any time, with every sample of the recording used: the start
    /// for a model in code.
    #[must_use]
    pub fn instant(refresh_hz: f64) -> Self {
        Self {
            name: "instant".into(),
            about: "Every stage takes no time.".into(),
            tracker_rate_hz: None,
            tracker_phase: None,
            refresh_hz: Known { value: refresh_hz, source: String::new(), guess: false },
            display_phase: None,
            frames_ahead: 0.0,
            late_latch: false,
            latch_before_gpu_ms: 0.0,
            times: std::array::from_fn(|_| StageTime::none()),
        }
    }

    /// How long a stage takes. Of a simulated stage: nothing.
    #[must_use]
    pub fn stage(&self, stage: Stage) -> &StageTime {
        &self.times[stage as usize]
    }

    /// Sets how long a stage takes.
    ///
    /// # Errors
    /// [`Error::Setting`] for a simulated stage and for times that none can take.
    pub fn set(&mut self, stage: Stage, time: StageTime) -> Result<()> {
        let refused = |cause: String| Error::Setting(format!("stage {}: {cause}", stage.name()));
        if stage.is_simulated() {
            return Err(refused("is simulated, it takes no figure".into()));
        }
        time.delay.check().map_err(|error| refused(error.to_string()))?;
        self.times[stage as usize] = time;
        Ok(())
    }

    /// Replaces a stage by measured values, ms, in the order in which they were measured.
    ///
    /// # Errors
    /// As [`Self::set`].
    pub fn set_measured(&mut self, stage: Stage, values_ms: &[f64], source: &str) -> Result<()> {
        let time =
            StageTime { delay: Delay::Measured(values_ms.into()), source: source.to_owned(), guess: false };
        self.set(stage, time)
    }

    /// Checks what no type can.
    ///
    /// # Errors
    /// [`Error::Setting`] for rates, phases and times out of range.
    pub fn check(&self) -> Result<()> {
        let within = |name: &str, value: f64, low: f64, high: f64| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            Err(Error::Setting(format!("{name} is {value}; it must be {low} to {high}")))
        };
        within("refresh_hz", self.refresh_hz.value, 1.0, 1000.0)?;
        if let Some(rate) = &self.tracker_rate_hz {
            within("rate_hz", rate.value, 1.0, 10_000.0)?;
        }
        for (name, phase) in [("tracker phase", self.tracker_phase), ("display phase", self.display_phase)] {
            within(name, phase.unwrap_or(0.0), 0.0, 1.0)?;
        }
        within("frames_ahead", self.frames_ahead, 0.0, 8.0)?;
        within("latch_before_gpu_ms", self.latch_before_gpu_ms, 0.0, 100.0)?;
        self.times.iter().try_for_each(|time| time.delay.check())
    }

    /// The length of a frame, ns.
    pub(super) fn frame_ns(&self) -> f64 {
        1e9 / self.refresh_hz.value
    }
}

/// Reads measured times from the JSON that `macula render --json` writes: the top-level field, a number
/// or a list of them; of a list of such objects, or of the objects in `frames`, one each.
///
/// # Errors
/// [`Error::File`], naming `path`, where there is no such figure or one is no time.
pub fn measured_ms(path: &Path, text: &str, field: &str) -> Result<Vec<f64>> {
    let json: Value = serde_json::from_str(text).map_err(|error| Error::file(path, error))?;
    let mut values = Vec::new();
    let objects = match &json {
        Value::Array(objects) => objects.as_slice(),
        object => std::slice::from_ref(object),
    };
    for object in objects {
        let frames = object.get("frames").and_then(Value::as_array);
        let inner = frames.map_or(&[][..], Vec::as_slice);
        let per_frame = inner.iter().filter_map(|frame| frame.get(field));
        // Times of single frames say more than their median beside them.
        let told: Vec<&Value> = per_frame.collect();
        let told = if told.is_empty() { object.get(field).into_iter().collect() } else { told };
        for value in told {
            match value {
                Value::Array(list) => values.extend(list.iter().map(Value::as_f64)),
                one => values.push(one.as_f64()),
            }
        }
    }
    let values: Option<Vec<f64>> = values.into_iter().collect();
    let values = values.ok_or_else(|| Error::file(path, format!("a {field} is no number; give ms")))?;
    Delay::Measured(values.as_slice().into())
        .check()
        .map_err(|error| Error::file(path, format!("{field}: {error}")))?;
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measured_times_come_from_every_form_of_report() {
        let of = |text: &str| measured_ms(Path::new("report.json"), text, "gpu_ms");
        let report = r#"{"passes": [{"name": "shade", "gpu_ms": 9}], "gpu_ms": 6.5}"#;
        assert_eq!(of(report).expect("a report"), [6.5]);
        assert_eq!(of(r#"{"gpu_ms": [1, 2.5]}"#).expect("a list"), [1.0, 2.5]);
        assert_eq!(of(r#"[{"gpu_ms": 1}, {"gpu_ms": 3}]"#).expect("reports"), [1.0, 3.0]);
        let frames = r#"{"gpu_ms": 2, "frames": [{"gpu_ms": 1}, {"gpu_ms": 3}]}"#;
        assert_eq!(of(frames).expect("frames"), [1.0, 3.0]);
        for bad in ["", "{}", "[]", "7", r#"{"gpu_ms": "fast"}"#, r#"{"gpu_ms": -1}"#, r#"{"gpu_ms": 1e9}"#] {
            let message = of(bad).expect_err("a bad report").to_string();
            assert!(message.starts_with("report.json: ") && message.lines().count() == 1, "{message}");
        }
    }

    #[test]
    fn simulated_stages_take_no_figure() {
        let mut model = LatencyModel::instant(90.0);
        assert!(model.set(Stage::SamplingWait, StageTime::none()).is_err());
        assert!(model.set_measured(Stage::Gpu, &[], "nowhere").is_err());
        assert!(model.set_measured(Stage::Gpu, &[4.0, 6.0], "a bench").is_ok());
        assert_eq!(model.stage(Stage::Gpu).delay.mean_ms(), 5.0);
    }
}
