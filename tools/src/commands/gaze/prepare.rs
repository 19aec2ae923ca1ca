//! What the commands make of a recording before they look at the gaze in it.

use crate::failure::Failure;
use macula_trackers::EyeState;
use macula_trackers::classify::ClassifierSettings;
use macula_trackers::evaluate::{EventRow, events_of, labelled_events};
use macula_trackers::latency::EyeInterval;
use macula_trackers::recording::{ExtraColumn, Recording};
use macula_trackers::sample::{EyeSample, GazeSample};

/// Where events come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EventsFrom {
    /// Labels in the recording: an expert's, or the truth of a synthetic eye.
    Labels,
    /// The online classifier.
    Classifier,
}

impl EventsFrom {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Labels => "the labels in the recording",
            Self::Classifier => "the online classifier",
        }
    }
}

/// The recording with a direction in every sample that has a gaze: points on a display become directions.
///
/// # Errors
/// A recording with points only whose display is not known, and one without any gaze.
pub fn with_directions(recording: Recording) -> Result<Recording, Failure> {
    let has_direction = |sample: &GazeSample| sample.gaze_direction().is_some();
    if recording.samples().any(|sample| has_direction(&sample)) {
        return Ok(recording);
    }
    let points = recording.samples().filter(|sample| sample.gaze_point().is_some()).count();
    if points == 0 {
        let count = recording.len();
        return Err(Failure::environment(format!(
            "the recording has no gaze in any of its {count} samples; `macula gaze info` shows what it has"
        )));
    }
    let Some(screen) = recording.info.screen else {
        return Err(Failure::usage(
            "the recording has points and no directions; give the display that they lie on, as in --screen \
             1920x1080,533x301,565",
        ));
    };
    let mut made = Recording::new(recording.info.clone());
    made.reserve(recording.len());
    for mut sample in recording.samples() {
        let direction = sample.gaze_point().map(|point| screen.direction_of(point));
        if let Some(direction) = direction.filter(|direction| direction.is_finite()) {
            sample.combined = EyeSample { valid: true, direction: Some(direction), ..sample.combined };
        }
        made.push(&sample);
    }
    made.extra = recording.extra;
    made.events = recording.events;
    Ok(made)
}

/// The recording at a lower rate: for each time of it the nearest sample, none twice, and nothing in
/// between. Whole where its own rate is not higher.
pub fn thinned(recording: &Recording, rate_hz: f64) -> Recording {
    let times = recording.times_ns();
    let step_ns = 1e9 / rate_hz;
    let mut kept: Vec<usize> = Vec::new();
    let mut tick = 0.0_f64;
    let first_ns = times.first().copied().unwrap_or(0);
    let since = |time_ns: i64| time_ns.saturating_sub(first_ns) as f64;
    for (index, &time_ns) in times.iter().enumerate() {
        // As far as the next sample is nearer to the tick, this one is not it.
        let until_ns =
            times.get(index + 1).map_or(since(time_ns), |&next_ns| (since(time_ns) + since(next_ns)) * 0.5);
        if tick * step_ns <= until_ns {
            kept.push(index);
            tick = (until_ns / step_ns).floor().max(tick) + 1.0;
        }
    }
    let mut info = recording.info.clone();
    info.nominal_rate_hz = info.nominal_rate_hz.map(|nominal_hz| nominal_hz.min(rate_hz));
    let mut made = Recording::new(info);
    made.reserve(kept.len());
    for sample in kept.iter().filter_map(|&index| recording.get(index)) {
        made.push(&sample);
    }
    let values = |column: &ExtraColumn| {
        kept.iter().map(|&index| column.values.get(index).copied().unwrap_or(f64::NAN)).collect()
    };
    made.extra = recording
        .extra
        .iter()
        .map(|column| ExtraColumn { name: column.name.clone(), values: values(column) })
        .collect();
    made
}

/// What the eye did, from the recording's labels or else from the online classifier.
pub fn eye_intervals(recording: &Recording) -> (Vec<EyeInterval>, EventsFrom) {
    let (rows, from) = match labelled_events(recording) {
        Some(rows) => (rows, EventsFrom::Labels),
        None => (events_of(recording, &ClassifierSettings::default()), EventsFrom::Classifier),
    };
    (rows.iter().filter_map(interval).collect(), from)
}

fn interval(row: &EventRow) -> Option<EyeInterval> {
    let states = [EyeState::Fixation, EyeState::Saccade, EyeState::Pursuit, EyeState::Blink, EyeState::Lost];
    let state = states.into_iter().find(|state| state.name() == row.kind)?;
    let ns = |time_s: f64| (time_s * 1e9).round() as i64;
    Some(EyeInterval { state, start_ns: ns(row.start_s), end_ns: ns(row.end_s) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, DVec3};
    use macula_trackers::recording::{RecordingInfo, Screen};

    fn recording(times_ms: &[i64], screen: Option<Screen>) -> Recording {
        let mut recording = Recording::new(RecordingInfo { screen, ..RecordingInfo::default() });
        for time_ms in times_ms {
            let point = Some(DVec2::new(0.5, 0.5));
            let combined = EyeSample { valid: true, point, ..EyeSample::default() };
            recording.push(&GazeSample { combined, ..GazeSample::at(time_ms * 1_000_000) });
        }
        let values = times_ms.iter().map(|&time_ms| time_ms as f64).collect();
        recording.extra.push(ExtraColumn { name: "evt".into(), values });
        recording
    }

    fn kept_ms(times_ms: &[i64], rate_hz: f64) -> Vec<i64> {
        let thin = thinned(&recording(times_ms, None), rate_hz);
        let times: Vec<i64> = thin.times_ns().iter().map(|time_ns| time_ns / 1_000_000).collect();
        let labels = thin.extra_column("evt").unwrap_or_default();
        assert!(labels.iter().zip(&times).all(|(&label, &time_ms)| label == time_ms as f64), "{labels:?}");
        times
    }

    #[test]
    fn thinning_takes_the_nearest_sample() {
        let every_ms: Vec<i64> = (0..40).collect();
        assert_eq!(kept_ms(&every_ms, 100.0), [0, 10, 20, 30]);
        // 120 Hz: 0, 8.33, 16.67, 25, 33.33 ms.
        assert_eq!(kept_ms(&every_ms, 120.0), [0, 8, 17, 25, 33]);
        // A hole is not filled by the same sample again.
        assert_eq!(kept_ms(&[0, 4, 9, 52, 58, 61], 100.0), [0, 9, 52, 61]);
        // A slower recording stays as it is.
        assert_eq!(kept_ms(&[0, 8, 16, 24], 1000.0), [0, 8, 16, 24]);
        assert!(kept_ms(&[], 100.0).is_empty());
    }

    #[test]
    fn points_need_a_display() {
        let Err(failure) = with_directions(recording(&[0, 8], None)) else { panic!("a direction") };
        assert!(failure.line().is_some_and(|line| line.contains("--screen")), "{failure:?}");
        let screen = Screen { size_px: DVec2::splat(100.0), size_m: DVec2::splat(0.5), distance_m: 0.5 };
        let Ok(made) = with_directions(recording(&[0, 8], Some(screen))) else { panic!("a screen") };
        let direction = made.get(1).and_then(|sample| sample.gaze_direction());
        assert_eq!(direction, Some((DVec3::NEG_Z, false)));
        assert_eq!(made.extra_column("evt"), Some(&[0.0, 8.0][..]));
        assert!(with_directions(Recording::new(RecordingInfo::default())).is_err());
    }
}
