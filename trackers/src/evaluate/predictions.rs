//! How far predictions are off, and how far predicted landing points.

use super::events::{EventRow, entries_of, events_of, labelled_events};
use super::quantile;
use crate::classify::{Classifier, ClassifierSettings};
use crate::estimate::EyeState;
use crate::history::Entry;
use crate::predict::{Predictor, PredictorKind};
use crate::recording::Recording;
use glam::DVec3;
use serde::Serialize;

/// Shares of a saccade's duration at which its landing is predicted.
const FRACTIONS: [f64; 3] = [0.25, 0.5, 0.75];
/// Bins of amplitude, deg.
const BINS_DEG: [(f64, f64); 5] = [(1.0, 2.0), (2.0, 5.0), (5.0, 10.0), (10.0, 20.0), (20.0, f64::INFINITY)];

/// One predictor at one horizon.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PredictionRow {
    /// The predictor.
    pub predictor: &'static str,
    /// How far ahead, ms.
    pub horizon_ms: f64,
    /// How many predictions were compared with where the eye looked.
    pub count: usize,
    /// Median error, deg.
    pub median_deg: f64,
    /// The error that 95 % lie below, deg.
    pub p95_deg: f64,
}

/// One predictor's landing points at one share of the duration.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LandingRow {
    /// The predictor.
    pub predictor: &'static str,
    /// Share of the saccade's duration after which it was asked.
    pub at_fraction: f64,
    /// Least amplitude of the saccades, deg.
    pub from_deg: f64,
    /// Largest amplitude; `None` for no limit.
    pub to_deg: Option<f64>,
    /// How many saccades.
    pub count: usize,
    /// Median distance from the predicted to the true end, deg; `None` where there are none.
    pub landing_median_deg: Option<f64>,
}

/// All predictors on one recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PredictionReport {
    /// Where the saccades come from: `labels` of the file, or our own `classifier`.
    pub saccades: &'static str,
    /// By predictor and horizon.
    pub horizons: Vec<PredictionRow>,
    /// By predictor and share of the duration: all saccades of 1 degree or more, then by amplitude.
    pub landings: Vec<LandingRow>,
}

/// A predictor that runs along with the classifier.
struct Run<'a> {
    classifier: Classifier,
    predictor: Box<dyn Predictor>,
    settings: &'a ClassifierSettings,
    last: Option<Entry>,
}

impl<'a> Run<'a> {
    fn new(predictor: Box<dyn Predictor>, settings: &'a ClassifierSettings) -> Self {
        Self { classifier: Classifier::new(*settings), predictor, settings, last: None }
    }

    fn push(&mut self, entry: &Entry, restarted: bool) {
        if restarted || self.last.is_some_and(|last| !last.comparable(entry)) {
            self.predictor.reset();
        }
        if restarted {
            self.classifier = Classifier::new(*self.settings);
        }
        self.classifier.push(entry);
        if entry.valid {
            self.predictor.push(entry, &self.classifier.phase());
            self.last = Some(*entry);
        }
    }
}

/// The entries with their times, which ascend within a recording whose clock does not jump.
fn entries(recording: &Recording) -> Vec<(Entry, bool)> {
    entries_of(recording).collect()
}

/// Gaze at a time, between the entries around it; `None` where one of them is invalid or they are more
/// than 20 ms or two steps apart.
fn truth_at(entries: &[(Entry, bool)], time_ns: i64, step_ns: i64) -> Option<DVec3> {
    let after = entries.partition_point(|(entry, _)| entry.time_ns < time_ns);
    let (later, _) = entries.get(after)?;
    if later.time_ns == time_ns {
        return later.valid.then(|| later.gaze());
    }
    let (earlier, _) = entries.get(after.checked_sub(1)?)?;
    let gap_ns = later.time_ns.saturating_sub(earlier.time_ns);
    let usable = earlier.valid && later.valid && earlier.comparable(later);
    if !usable || gap_ns > step_ns.saturating_mul(2).max(20_000_000) {
        return None;
    }
    let share = time_ns.saturating_sub(earlier.time_ns) as f64 / gap_ns as f64;
    earlier.gaze().lerp(later.gaze(), share).try_normalize()
}

/// Errors of all predictors for each horizon, ms, and of their landing points. Saccades are those of the
/// file's labels, or our own where it has none.
#[must_use]
pub fn predict_report(recording: &Recording, horizons_ms: &[f64]) -> PredictionReport {
    let settings = ClassifierSettings::default();
    match labelled_events(recording) {
        Some(labels) => predict_report_of(recording, horizons_ms, &labels, "labels", &settings),
        None => {
            let found = events_of(recording, &settings);
            predict_report_of(recording, horizons_ms, &found, "classifier", &settings)
        }
    }
}

/// As [`predict_report`], with given events and settings.
#[must_use]
pub fn predict_report_of(
    recording: &Recording,
    horizons_ms: &[f64],
    events: &[EventRow],
    saccades: &'static str,
    settings: &ClassifierSettings,
) -> PredictionReport {
    let entries = entries(recording);
    let step_ns = recording.rate_hz().map_or(0, |rate_hz| (1e9 / rate_hz) as i64);
    let mut horizons = Vec::new();
    for kind in PredictorKind::ALL {
        let mut run = Run::new(kind.make(), settings);
        let mut errors = vec![Vec::new(); horizons_ms.len()];
        for (entry, restarted) in &entries {
            run.push(entry, *restarted);
            if !entry.valid {
                continue;
            }
            for (horizon_ms, errors) in horizons_ms.iter().zip(&mut errors) {
                let time_ns = entry.time_ns.saturating_add((horizon_ms * 1e6) as i64);
                let told = run.predictor.predict(time_ns).zip(truth_at(&entries, time_ns, step_ns));
                errors.extend(told.map(|(told, truth)| told.angle_between(truth).to_degrees()));
            }
        }
        for (horizon_ms, mut errors) in horizons_ms.iter().zip(errors) {
            horizons.push(PredictionRow {
                predictor: run.predictor.name(),
                horizon_ms: *horizon_ms,
                count: errors.len(),
                median_deg: quantile(&mut errors, 0.5),
                p95_deg: quantile(&mut errors, 0.95),
            });
        }
    }
    PredictionReport { saccades, horizons, landings: landing_rows(recording, events, settings) }
}

fn landing_rows(
    recording: &Recording,
    events: &[EventRow],
    settings: &ClassifierSettings,
) -> Vec<LandingRow> {
    let mut rows = Vec::new();
    for kind in PredictorKind::ALL {
        for fraction in FRACTIONS {
            let predictor = kind.make();
            let name = predictor.name();
            let errors = landing_errors(recording, events, settings, predictor, fraction);
            rows.push(landing_row(name, fraction, (1.0, f64::INFINITY), &errors));
            rows.extend(BINS_DEG.map(|bin| landing_row(name, fraction, bin, &errors)));
        }
    }
    rows
}

/// For each saccade of 1 degree or more, its amplitude and the distance from the predicted landing point
/// to the gaze at its end, deg: asked after a share of its duration, with the samples until then and no
/// knowledge of the given events. A predictor that tells no landing is asked for the gaze at the
/// saccade's true end.
#[must_use]
pub fn landing_errors(
    recording: &Recording,
    events: &[EventRow],
    settings: &ClassifierSettings,
    predictor: Box<dyn Predictor>,
    fraction: f64,
) -> Vec<(f64, f64)> {
    let entries = entries(recording);
    let step_ns = recording.rate_hz().map_or(0, |rate_hz| (1e9 / rate_hz) as i64);
    let saccade = |event: &&EventRow| event.kind == EyeState::Saccade.name() && event.amplitude_deg >= 1.0;
    let mut saccades: Vec<_> = events.iter().filter(saccade).collect();
    saccades.sort_by(|one, other| one.start_s.total_cmp(&other.start_s));
    let mut errors = Vec::new();
    let mut run = Run::new(predictor, settings);
    let mut fed = 0;
    for saccade in saccades {
        let asked_s = saccade.start_s + fraction * (saccade.end_s - saccade.start_s);
        let (asked_ns, end_ns) = ((asked_s * 1e9) as i64, (saccade.end_s * 1e9) as i64);
        while let Some((entry, restarted)) = entries.get(fed).filter(|(entry, _)| entry.time_ns <= asked_ns) {
            run.push(entry, *restarted);
            fed += 1;
        }
        let landing = run.predictor.landing().map(|landing| landing.gaze);
        let told = landing.or_else(|| run.predictor.predict(end_ns));
        if let Some((told, truth)) = told.zip(truth_at(&entries, end_ns, step_ns)) {
            errors.push((saccade.amplitude_deg, told.angle_between(truth).to_degrees()));
        }
    }
    errors
}

fn landing_row(
    predictor: &'static str,
    at_fraction: f64,
    (from_deg, to_deg): (f64, f64),
    errors: &[(f64, f64)],
) -> LandingRow {
    let within = errors.iter().filter(|(amplitude, _)| (from_deg..to_deg).contains(amplitude));
    let mut within: Vec<f64> = within.map(|(_, error)| *error).collect();
    LandingRow {
        predictor,
        at_fraction,
        from_deg,
        to_deg: Some(to_deg).filter(|to_deg| to_deg.is_finite()),
        count: within.len(),
        landing_median_deg: (!within.is_empty()).then(|| quantile(&mut within, 0.5)),
    }
}
