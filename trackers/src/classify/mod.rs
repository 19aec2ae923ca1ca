//! What the eye does, told sample by sample: fixation, saccade, pursuit, blink, lost.
//!
//! The velocity is the slope over a window of time, of gaze in the world where the head's pose is known, less
//! the slow velocity of pursuit; thresholds are multiples of a running median of its own noise. The onset
//! is dated back to where the speed along the saccade rose above the lower threshold, and the end to
//! where it fell below, so that what follows (the post-saccadic oscillation) belongs to the fixation.

mod motion;
mod settings;
mod steps;

pub use motion::Velocity;
pub use settings::ClassifierSettings;

use crate::estimate::EyeState;
use crate::history::Entry;
use crate::ring::Ring;
use glam::DVec3;
use motion::{Point, RunningMedian, velocity};

/// Points kept to date an onset back: 128 ms at 4 kHz.
const POINTS: usize = 512;
/// Noise assumed at the start, deg/s: that of a headset at 120 Hz, so that jitter is no saccade before it is
/// known how strong it is.
const START_NOISE_DEG_S: f64 = 15.0;
/// For so long, s, the noise is learnt faster, with a memory of [`START_MEMORY_S`]: the start value is off
/// by up to a factor of ten.
const START_S: f64 = 0.3;
const START_MEMORY_S: f64 = 0.1;
/// Sample-to-sample jitter assumed at the start, deg.
const START_JITTER_DEG: f64 = 0.1;

/// One event, finished.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// What the eye did.
    pub kind: EyeState,
    /// When it began, host clock, ns.
    pub start_ns: i64,
    /// When it ended.
    pub end_ns: i64,
    /// From the gaze at the start to that at the end, deg; 0 where the eye was not seen.
    pub amplitude_deg: f64,
    /// The highest speed over a window, deg/s.
    pub peak_deg_s: f64,
    /// When the classifier knew that it had begun: the time of the sample that told it.
    pub detected_ns: i64,
}

/// A change of what the eye is thought to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EventUpdate {
    /// What it does now.
    pub state: EyeState,
    /// Since when: estimated, before `detected_ns`.
    pub since_ns: i64,
    /// The time of the sample that told it.
    pub detected_ns: i64,
    /// What is over, in order. Empty where the last state was a mistake: a saccade that proved to be
    /// noise or the lid of a blink is never told as finished, and the event before it goes on.
    pub finished: [Option<Event>; 2],
}

/// What is known of the eye's movement at the newest sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase {
    /// What the eye does.
    pub state: EyeState,
    /// Since when, host clock, ns.
    pub since_ns: i64,
    /// Gaze at that time, of length 1, in the space of [`Entry::gaze`]; zero where it is not known.
    pub onset: DVec3,
    /// Velocity over the window that ends with the newest sample.
    pub velocity: Velocity,
    /// Median speed of a gaze at rest, deg/s.
    pub noise_deg_s: f64,
    /// Standard deviation of the gaze at rest from jitter, deg, both axes together.
    pub jitter_deg: f64,
}

/// An event under way.
#[derive(Clone, Copy, Debug)]
struct Open {
    kind: EyeState,
    start_ns: i64,
    start_gaze: DVec3,
    peak_deg_s: f64,
    detected_ns: i64,
}

impl Open {
    fn ended(&self, end_ns: i64, gaze: DVec3) -> Event {
        let seen = self.start_gaze != DVec3::ZERO && gaze != DVec3::ZERO;
        Event {
            kind: self.kind,
            start_ns: self.start_ns,
            end_ns: end_ns.max(self.start_ns),
            amplitude_deg: if seen { self.start_gaze.angle_between(gaze).to_degrees() } else { 0.0 },
            peak_deg_s: self.peak_deg_s,
            detected_ns: self.detected_ns,
        }
    }
}

/// Tells events online. Allocates nothing after it was made. Below about 10 Hz nothing can be told of
/// movements, and the eye counts as lost between the samples.
#[derive(Clone, Debug)]
pub struct Classifier {
    settings: ClassifierSettings,
    points: Ring<Point>,
    state: State,
}

#[derive(Clone, Copy, Debug)]
struct State {
    open: Option<Open>,
    /// The event that goes on if the saccade under way proves to be none; only during a saccade.
    before: Option<Open>,
    /// The last entry in which the eye was seen.
    last: Option<Entry>,
    last_ns: Option<i64>,
    /// When the eye was seen again after a loss, while it is not yet trusted.
    reopened_ns: Option<i64>,
    velocity: Velocity,
    /// Slow velocity, deg/s.
    drift_deg_s: DVec3,
    noise_deg_s: RunningMedian,
    jitter_deg: RunningMedian,
    /// How long noise was learnt, s, up to [`START_S`].
    learnt_s: f64,
    /// End and peak speed of the last saccade.
    last_saccade: Option<(i64, f64)>,
    /// Speed along the saccade at the point before, and its time.
    along: (f64, i64),
    /// Since when the slow velocity is on the other side of the threshold of pursuit.
    turning_ns: Option<i64>,
}

impl Default for State {
    fn default() -> Self {
        Self {
            open: None,
            before: None,
            last: None,
            last_ns: None,
            reopened_ns: None,
            velocity: Velocity::default(),
            drift_deg_s: DVec3::ZERO,
            noise_deg_s: RunningMedian::new(START_NOISE_DEG_S, 0.1, 200.0),
            jitter_deg: RunningMedian::new(START_JITTER_DEG, 1e-4, 10.0),
            learnt_s: 0.0,
            last_saccade: None,
            along: (0.0, 0),
            turning_ns: None,
        }
    }
}

impl Classifier {
    /// A classifier with nothing seen yet.
    #[must_use]
    pub fn new(settings: ClassifierSettings) -> Self {
        Self { settings, points: Ring::new(POINTS), state: State::default() }
    }

    /// Forgets everything.
    pub fn reset(&mut self) {
        self.points.clear();
        self.state = State::default();
    }

    /// What is known now.
    #[must_use]
    pub fn phase(&self) -> Phase {
        let open = self.state.open.as_ref();
        Phase {
            state: open.map_or(EyeState::Unknown, |open| open.kind),
            since_ns: open.map_or(0, |open| open.start_ns),
            onset: open.map_or(DVec3::ZERO, |open| open.start_gaze),
            velocity: self.state.velocity,
            noise_deg_s: self.state.noise_deg_s.value(),
            // Steps between samples of a Gaussian jitter are Rayleigh-distributed: their median is
            // sqrt(2 ln 2) times sqrt(2) the deviation of one axis; both axes together have sqrt(2) of it.
            jitter_deg: self.state.jitter_deg.value() / (2.0 * std::f64::consts::LN_2).sqrt(),
        }
    }

    /// What is not finished, as if it ended with the newest sample: for the end of a recording. A saccade
    /// under way is told, too.
    #[must_use]
    pub fn unfinished(&self) -> [Option<Event>; 2] {
        let State { open, before, last, last_ns, .. } = self.state;
        let gaze = last.map_or(DVec3::ZERO, |last| last.gaze());
        let ended = open.zip(last_ns).map(|(open, last_ns)| open.ended(last_ns, gaze));
        [before.zip(open).map(|(before, open)| before.ended(open.start_ns, open.start_gaze)), ended]
    }

    /// Takes the next entry and tells what changes. Entries that are not later than the last are ignored.
    pub fn push(&mut self, entry: &Entry) -> Option<EventUpdate> {
        if self.state.last_ns.is_some_and(|last_ns| entry.time_ns <= last_ns) {
            return None;
        }
        self.state.last_ns = Some(entry.time_ns);
        let closed = entry.openness.is_some_and(|openness| openness < self.settings.closed_openness);
        if !entry.valid || closed { self.unseen(entry) } else { self.seen(entry) }
    }

    /// The eye is not seen.
    fn unseen(&mut self, entry: &Entry) -> Option<EventUpdate> {
        let last = self.state.last;
        let since_ns = last.map_or(entry.time_ns, |last| last.time_ns);
        let lost_ns = entry.time_ns.saturating_sub(since_ns);
        let lids_open = entry.openness.is_some_and(|openness| openness >= self.settings.closed_openness);
        let no_blink = lids_open || last.is_none() || lost_ns > self.settings.max_blink_ns;
        let kind = if no_blink { EyeState::Lost } else { EyeState::Blink };
        self.state.reopened_ns = None;
        match self.state.open.as_mut() {
            Some(open) if open.kind == EyeState::Lost => None,
            Some(open) if open.kind == EyeState::Blink => {
                if kind == EyeState::Blink {
                    return None;
                }
                // It was none from the start.
                open.kind = EyeState::Lost;
                self.told([None, None], entry.time_ns)
            }
            Some(_) if lost_ns <= self.settings.min_loss_ns => None,
            _ => self.lose(kind, last, since_ns, entry.time_ns),
        }
    }

    /// The eye is seen.
    fn seen(&mut self, entry: &Entry) -> Option<EventUpdate> {
        let before = self.state.last.replace(*entry);
        let step_ns = before.map_or(0, |before| entry.time_ns.saturating_sub(before.time_ns));
        let silent = step_ns > self.settings.max_step_ns;
        let comparable = !silent && before.is_none_or(|before| before.comparable(entry));
        if !comparable {
            self.points.clear();
            self.state.drift_deg_s = DVec3::ZERO;
        }
        self.measure(entry);
        let kind = self.state.open.map(|open| open.kind);
        match kind {
            None => self.begin_fixation(entry),
            Some(EyeState::Blink | EyeState::Lost) => self.reopen(entry),
            Some(_) if silent => {
                // No sample told of the loss: the stream itself was silent.
                let since_ns = before.map_or(entry.time_ns, |before| before.time_ns);
                let told = self.lose(EyeState::Lost, before, since_ns, entry.time_ns);
                self.state.reopened_ns = Some(entry.time_ns);
                told
            }
            Some(EyeState::Saccade) if !comparable => self.retract(entry.time_ns),
            Some(_) if self.state.velocity.span_s <= 0.0 => None,
            Some(EyeState::Saccade) => self.in_saccade(entry),
            Some(_) => self.at_rest(entry, step_ns),
        }
    }
}

#[cfg(test)]
mod tests;
