//! The figures of a run, as JSON has them.

use super::budget::Budget;
use super::figures::Figures;
use super::run::{ArrivalTimes, LatencyRun};
use super::session::SessionGaze;
use super::stage::Stage;
use serde::Serialize;

/// What a latch at the GPU's start gains.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LateLatch {
    /// The run used it.
    pub used: bool,
    /// How much younger the gaze is with it, ms (mean).
    pub gain_ms: f64,
    /// By how much the needed radius is smaller with it, degrees.
    pub gain_deg: f64,
}

/// All figures of a run; the field names are an interface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LatencySummary {
    /// The model's name.
    pub model: String,
    /// Samples of the session at different times.
    pub samples: usize,
    /// Samples per second of the session.
    pub rate_hz: f64,
    /// Samples per second of the tracker in the run.
    pub tracker_rate_hz: f64,
    /// Refreshes per second of the display.
    pub refresh_hz: f64,
    /// From the first to the last sample, s.
    pub duration_s: f64,
    /// Refreshes with a picture.
    pub frames: usize,
    /// Of these, the ones that showed a picture again because the next was late.
    pub frames_repeated: usize,
    /// Of these, the ones for which the renderer had no gaze at all.
    pub frames_without_gaze: usize,
    /// Of these, the ones with an older gaze because the newest sample had none.
    pub frames_over_loss: usize,
    /// Of these, the ones at which it is not known where the eye looked: blinks and holes.
    pub frames_not_judged: usize,
    /// Of these, the ones that count for `outside_fraction`.
    pub frames_counted: usize,
    /// From the sample to the light, ms.
    pub age_ms: Figures,
    /// From an eye movement to its first light, ms (mean).
    pub eye_to_photon_ms: Option<f64>,
    /// The gaze used against the true one, all frames, degrees.
    pub error_deg: Figures,
    /// The same in the counted frames, degrees.
    pub counted_error_deg: Figures,
    /// Share of the counted time with the true gaze outside the radius.
    pub outside_fraction: Option<f64>,
    /// The same with the suppressed time.
    pub outside_fraction_unsuppressed: Option<f64>,
    /// The same of all frames, whatever the eye did.
    pub outside_fraction_raw: Option<f64>,
    /// Late latching.
    pub late_latch: LateLatch,
    /// What follows.
    pub budget: Budget,
    /// What to know when reading the figures, a sentence each.
    pub notes: Vec<String>,
}

impl LatencyRun {
    /// All figures; `session` and `budget` must be those of this run.
    #[must_use]
    pub fn summary(&self, session: &SessionGaze, budget: Budget) -> LatencySummary {
        let count =
            |which: fn(&super::Frame) -> bool| self.frames.iter().filter(|frame| which(frame)).count();
        let ends = session.times_ns().first().zip(session.times_ns().last());
        let gain_ms = self.late_latch_gain_ms;
        let now_ms = budget.latency_ms;
        let [from_ms, to_ms] =
            if self.model.late_latch { [now_ms + gain_ms, now_ms] } else { [now_ms, now_ms - gain_ms] };
        let gain_deg = budget.radius_for(from_ms).zip(budget.radius_for(to_ms));
        LatencySummary {
            model: self.model.name.clone(),
            samples: session.len(),
            rate_hz: session.rate_hz(),
            tracker_rate_hz: self.tracker_rate_hz,
            refresh_hz: self.model.refresh_hz.value,
            duration_s: ends
                .map_or(0.0, |(first, last)| (i128::from(*last) - i128::from(*first)) as f64 * 1e-9),
            frames: self.frames.len(),
            frames_repeated: self.frames.windows(2).filter(|pair| pair[0].picture == pair[1].picture).count(),
            frames_without_gaze: count(|frame| frame.direction.is_none()),
            frames_over_loss: count(|frame| frame.over_loss),
            frames_not_judged: count(|frame| frame.truth.is_none()),
            frames_counted: count(|frame| frame.counted),
            age_ms: self.age_ms(),
            eye_to_photon_ms: self.eye_to_photon_ms,
            error_deg: self.error_deg(),
            counted_error_deg: self.counted_error_deg(),
            outside_fraction: self.outside_fraction(),
            outside_fraction_unsuppressed: self.outside_fraction_unsuppressed(),
            outside_fraction_raw: self.outside_fraction_raw(),
            late_latch: LateLatch {
                used: self.model.late_latch,
                gain_ms,
                gain_deg: gain_deg.map_or(0.0, |(from, to)| from - to),
            },
            notes: self.notes(session),
            budget,
        }
    }

    fn notes(&self, session: &SessionGaze) -> Vec<String> {
        let mut notes = Vec::new();
        if session.intervals().is_empty() {
            notes.push("What the eye did is not known: every frame counts and nothing is suppressed.".into());
        }
        if !session.has_truth() {
            notes.push(
                "Where the eye truly looked is taken from the recording itself: its noise is in the error, \
                 its bias is not."
                    .into(),
            );
        }
        if let Some(rate) = &self.model.tracker_rate_hz
            && rate.value > session.rate_hz() * 1.5
        {
            notes.push(format!(
                "The recording has {:.0} samples a second and the tracker {:.0}: the wait for a sample is \
                 longer here than with the tracker.",
                session.rate_hz(),
                rate.value
            ));
        }
        if self.settings.arrival == ArrivalTimes::Recorded {
            notes.push(
                "Arrival times are those of the recording; the tracker's stages are one figure.".into(),
            );
        }
        if session.duplicates() > 0 {
            let count = session.duplicates();
            notes.push(format!("{count} samples had the time of another and were left out."));
        }
        let guesses: Vec<&str> =
            Stage::ALL.into_iter().filter(|stage| self.model.stage(*stage).guess).map(Stage::name).collect();
        if !guesses.is_empty() {
            notes.push(format!("No source gives the figures of {}: they are guesses.", guesses.join(", ")));
        }
        notes
    }
}
