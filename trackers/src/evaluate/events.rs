//! Events of a recording, and how they agree with labelled ones.

use super::quantile;
use crate::classify::{Classifier, ClassifierSettings, Event};
use crate::estimate::EyeState;
use crate::history::{Entry, History};
use crate::recording::Recording;
use serde::Serialize;

/// One event of a report.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EventRow {
    /// What the eye did: the name of an [`EyeState`].
    pub kind: &'static str,
    /// When it began, s on the clock of the recording's `time_ns`.
    pub start_s: f64,
    /// When it ended.
    pub end_s: f64,
    /// From the gaze at the start to that at the end, deg; 0 where the eye was not seen.
    pub amplitude_deg: f64,
    /// The highest speed, deg/s; 0 where it is not known.
    pub peak_deg_s: f64,
    /// When an online classifier knew of the event, s.
    pub detected_s: f64,
}

impl EventRow {
    fn of(event: &Event) -> Self {
        Self {
            kind: event.kind.name(),
            start_s: event.start_ns as f64 * 1e-9,
            end_s: event.end_ns as f64 * 1e-9,
            amplitude_deg: event.amplitude_deg,
            peak_deg_s: event.peak_deg_s,
            detected_s: event.detected_ns as f64 * 1e-9,
        }
    }

    fn overlap_s(&self, other: &Self) -> f64 {
        (self.end_s.min(other.end_s) - self.start_s.max(other.start_s)).max(0.0)
    }
}

/// The entries of a recording as a live consumer would keep them: late ones left out.
pub(super) fn entries_of(recording: &Recording) -> impl Iterator<Item = (Entry, bool)> + '_ {
    use crate::history::Pushed;
    let mut history = History::new(1);
    recording.samples().filter_map(move |sample| {
        let entry = Entry::of(&sample, 0.0);
        match history.push(entry) {
            Pushed::Kept => Some((entry, false)),
            Pushed::Restarted => Some((entry, true)),
            Pushed::Late | Pushed::Suspect => None,
        }
    })
}

/// What the online classifier tells of a recording, in order of time.
#[must_use]
pub fn events_of(recording: &Recording, settings: &ClassifierSettings) -> Vec<EventRow> {
    let mut classifier = Classifier::new(*settings);
    let mut events = Vec::new();
    let keep = |events: &mut Vec<EventRow>, told: [Option<Event>; 2]| {
        events.extend(told.iter().flatten().map(EventRow::of));
    };
    for (entry, restarted) in entries_of(recording) {
        if restarted {
            keep(&mut events, classifier.unfinished());
            classifier.reset();
        }
        if let Some(update) = classifier.push(&entry) {
            keep(&mut events, update.finished);
        }
    }
    keep(&mut events, classifier.unfinished());
    events
}

/// The labels of a recording that has them, in a column `evt` (by hand) or `evt_truth` (of a synthetic
/// eye): 0 undefined (told as `unknown`), 1 fixation, 2 saccade, 3 post-saccadic oscillation (left out), 4
/// pursuit, 5 blink, 6 lost, 7 microsaccade (told as a saccade). `None` without such a column.
#[must_use]
pub fn labelled_events(recording: &Recording) -> Option<Vec<EventRow>> {
    let labels = recording.extra_column("evt").or_else(|| recording.extra_column("evt_truth"))?;
    let times = recording.times_ns();
    let mut events = Vec::new();
    let mut start = 0;
    for run in labels.chunk_by(|one, other| one == other) {
        let end = start + run.len();
        let kind = match run.first() {
            Some(1.0) => EyeState::Fixation,
            Some(2.0 | 7.0) => EyeState::Saccade,
            Some(4.0) => EyeState::Pursuit,
            Some(5.0) => EyeState::Blink,
            Some(6.0) => EyeState::Lost,
            _ => EyeState::Unknown,
        };
        let gaze = |index: usize| {
            recording.get(index).map(|sample| Entry::of(&sample, 0.0)).filter(|entry| entry.valid)
        };
        // A label holds until the next sample begins another.
        let end_ns = times.get(end).or(times.last());
        if let Some((start_ns, end_ns)) = times.get(start).zip(end_ns).filter(|_| run.first() != Some(&3.0)) {
            let ends = gaze(start).zip(gaze(end.min(times.len().saturating_sub(1))));
            events.push(EventRow {
                kind: kind.name(),
                start_s: *start_ns as f64 * 1e-9,
                end_s: *end_ns as f64 * 1e-9,
                amplitude_deg: ends
                    .map_or(0.0, |(from, to)| from.gaze().angle_between(to.gaze()).to_degrees()),
                peak_deg_s: 0.0,
                detected_s: *start_ns as f64 * 1e-9,
            });
        }
        start = end;
    }
    Some(events)
}

/// Saccades by the plainest means, to compare with: every run of samples whose speed from the sample
/// before exceeds a threshold in deg/s.
#[must_use]
pub fn naive_saccades(recording: &Recording, threshold_deg_s: f64) -> Vec<EventRow> {
    let mut events: Vec<EventRow> = Vec::new();
    let mut before: Option<Entry> = None;
    let mut open: Option<(Entry, f64)> = None;
    for (entry, _) in entries_of(recording) {
        let fast = before.filter(|before| before.valid && entry.valid).and_then(|before| {
            let step_s = entry.time_ns.saturating_sub(before.time_ns) as f64 * 1e-9;
            let speed = before.gaze().angle_between(entry.gaze()).to_degrees() / step_s;
            (speed > threshold_deg_s).then_some((before, speed))
        });
        match (fast, open) {
            (Some((_, speed)), Some((start, peak))) => open = Some((start, peak.max(speed))),
            (Some(start), None) => open = Some(start),
            (None, Some((start, peak_deg_s))) => {
                let end = before.unwrap_or(entry);
                events.push(EventRow::of(&Event {
                    kind: EyeState::Saccade,
                    start_ns: start.time_ns,
                    end_ns: end.time_ns,
                    amplitude_deg: start.gaze().angle_between(end.gaze()).to_degrees(),
                    peak_deg_s,
                    detected_ns: end.time_ns,
                }));
                open = None;
            }
            (None, None) => {}
        }
        before = Some(entry);
    }
    events
}

/// When a found event counts as a labelled one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatchSettings {
    /// The kind of event that is compared.
    pub kind: EyeState,
    /// Events of less amplitude, deg, need neither be found nor are they false; but one may be the
    /// partner of an event that is larger.
    pub least_amplitude_deg: f64,
    /// Least overlap: the intersection of the two intervals over their union, 0 to 1.
    pub overlap: f64,
}

impl Default for MatchSettings {
    fn default() -> Self {
        Self { kind: EyeState::Saccade, least_amplitude_deg: 1.0, overlap: 0.5 }
    }
}

/// Agreement of found events with labelled ones, matched one to one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Score {
    /// Labelled events.
    pub labelled: usize,
    /// Found events.
    pub found: usize,
    /// Share of the found ones that are labelled.
    pub precision: f64,
    /// Share of the labelled ones that were found.
    pub recall: f64,
    /// Harmonic mean of the two.
    pub f1: f64,
    /// From the labelled start to when the classifier knew, ms; median over the matched.
    pub onset_delay_ms: f64,
    /// From the labelled start to the found one, ms; median.
    pub start_error_ms: f64,
    /// From the labelled end to the found one, ms; median.
    pub end_error_ms: f64,
}

/// Compares found events with labelled ones. Pairs are made in order of overlap, each event once. Found
/// events whose middle lies in a stretch labelled `unknown` are left out.
#[must_use]
pub fn score_events(found: &[EventRow], labelled: &[EventRow], settings: &MatchSettings) -> Score {
    let of_kind = |row: &&EventRow| row.kind == settings.kind.name();
    let undefined: Vec<_> = labelled.iter().filter(|row| row.kind == EyeState::Unknown.name()).collect();
    let judged = |row: &&EventRow| {
        let middle_s = (row.start_s + row.end_s) / 2.0;
        !undefined.iter().any(|gap| (gap.start_s..gap.end_s).contains(&middle_s))
    };
    let found: Vec<_> = found.iter().filter(of_kind).filter(judged).collect();
    let labelled: Vec<_> = labelled.iter().filter(of_kind).collect();
    let mut pairs = Vec::new();
    for (f, found) in found.iter().enumerate() {
        for (l, labelled) in labelled.iter().enumerate() {
            let both_s = found.overlap_s(labelled);
            let either_s = found.end_s.max(labelled.end_s) - found.start_s.min(labelled.start_s);
            if both_s > 0.0 && both_s >= settings.overlap * either_s {
                pairs.push((both_s / either_s, f, l));
            }
        }
    }
    pairs.sort_by(|one, other| other.0.total_cmp(&one.0));
    let mut partner_of_found = vec![None; found.len()];
    let mut partner_of_label = vec![None; labelled.len()];
    // `f` and `l` count through `found` and `labelled`, for whose lengths the partners were made.
    for (_, f, l) in pairs {
        if partner_of_found[f].is_none() && partner_of_label[l].is_none() {
            (partner_of_found[f], partner_of_label[l]) = (Some(l), Some(f));
        }
    }
    let large = |row: &EventRow| row.amplitude_deg >= settings.least_amplitude_deg;
    let share = |rows: &[&EventRow], partners: &[Option<usize>]| {
        let counted = rows.iter().zip(partners).filter(|(row, _)| large(row));
        let (all, hits) = counted
            .fold((0, 0), |(all, hits), (_, partner)| (all + 1, hits + usize::from(partner.is_some())));
        (all, if all > 0 { hits as f64 / all as f64 } else { 0.0 })
    };
    let (found_count, precision) = share(&found, &partner_of_found);
    let (labelled_count, recall) = share(&labelled, &partner_of_label);
    let median_ms = |off_s: &dyn Fn(&EventRow, &EventRow) -> f64| {
        let matched = labelled.iter().zip(&partner_of_label).filter(|(row, _)| large(row));
        let mut off: Vec<f64> =
            matched.filter_map(|(row, partner)| partner.map(|f| off_s(found[f], row) * 1e3)).collect();
        quantile(&mut off, 0.5)
    };
    let sum = precision + recall;
    Score {
        labelled: labelled_count,
        found: found_count,
        precision,
        recall,
        f1: if sum > 0.0 { 2.0 * precision * recall / sum } else { 0.0 },
        onset_delay_ms: median_ms(&|found, label| found.detected_s - label.start_s),
        start_error_ms: median_ms(&|found, label| found.start_s - label.start_s),
        end_error_ms: median_ms(&|found, label| found.end_s - label.end_s),
    }
}
