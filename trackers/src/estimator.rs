//! From samples to the one answer a renderer asks for: where does the eye look at this display time, and
//! how sure is that?

mod radius;
mod settings;

pub use settings::{Aim, EstimatorSettings, FilterKind, LossPolicy, RadiusSettings};

use crate::classify::{Classifier, EventUpdate, Phase};
use crate::estimate::{EstimateKind, EyeState, GazeEstimate};
use crate::filter::{Filter, FilterChain};
use crate::history::{Entry, History, Pushed};
use crate::predict::{Landing, MAX_HORIZON_NS, Predictor};
use crate::sample::GazeSample;
use crate::source::SourceEvent;
use glam::{DQuat, DVec3};
use radius::Doubt;

/// The head's rate is measured over this, ns: long enough that the jitter of a pose (0.02 deg) stays below
/// 1 deg/s.
const HEAD_WINDOW_NS: i64 = 20_000_000;
/// A time within this of a sample, ns, is that of the sample: at 500 deg/s the eye moves by 0.25 deg in it.
/// At most half of the step between samples.
const SAME_TIME_NS: i64 = 500_000;

/// Makes estimates of samples.
///
/// Samples go in by [`Self::push`] in the order in which they arrive; [`Self::estimate_at`] answers for any
/// time. Neither allocates. What cannot be used (NaN, broken times, no gaze) never makes an answer surer:
/// the last valid sample is kept, and the answer says so by its kind.
#[derive(Debug)]
pub struct Estimator {
    settings: EstimatorSettings,
    history: History,
    classifier: Classifier,
    filters: FilterChain,
    predictor: Box<dyn Predictor>,
    /// The newest entry in which the eye was seen, and what the eye did there.
    last: Option<(Entry, Phase)>,
    /// The landing predicted there.
    landing: Option<Landing>,
    /// Time between samples, ns: the shortest of late.
    step_ns: i64,
    head: Option<HeadMotion>,
    /// The source said that it tells nothing new.
    silent: bool,
    last_event: Option<EventUpdate>,
}

/// The head's pose at the last valid sample, and how fast it turns.
#[derive(Clone, Copy, Debug)]
struct HeadMotion {
    time_ns: i64,
    world_from_view: DQuat,
    /// Rotation vector per second, world space.
    rate_rad_s: DVec3,
}

impl HeadMotion {
    /// The pose at a later time, if the head goes on turning for at most [`MAX_HORIZON_NS`].
    fn at(&self, time_ns: i64) -> DQuat {
        let ahead_s = time_ns.saturating_sub(self.time_ns).clamp(0, MAX_HORIZON_NS) as f64 * 1e-9;
        DQuat::from_scaled_axis(self.rate_rad_s * ahead_s) * self.world_from_view
    }
}

impl Estimator {
    /// An estimator with nothing seen yet.
    #[must_use]
    pub fn new(settings: EstimatorSettings) -> Self {
        Self {
            history: History::new(settings.capacity),
            classifier: Classifier::new(settings.classifier),
            filters: settings.filter.make(),
            predictor: settings.predictor.make(),
            last: None,
            landing: None,
            step_ns: 0,
            head: None,
            silent: false,
            last_event: None,
            settings,
        }
    }

    /// The same with filters and a predictor of one's own.
    #[must_use]
    pub fn with(settings: EstimatorSettings, filters: FilterChain, predictor: Box<dyn Predictor>) -> Self {
        Self { filters, predictor, ..Self::new(settings) }
    }

    /// Takes a sample, and says what the history made of its time. A source that said that it is silent
    /// stays so until it says otherwise: it may be telling an old sample again.
    pub fn push(&mut self, sample: &GazeSample) -> Pushed {
        let mut entry = Entry::of(sample, self.settings.min_confidence);
        // Behind closing lids a tracker may go on telling a gaze, of what is left of the pupil.
        let least = self.settings.classifier.closed_openness;
        entry.valid &= entry.openness.is_none_or(|openness| openness >= least);
        let awaited = self.awaits_both_eyes(&entry);
        entry.valid &= !awaited;
        let before = self.history.newest().copied();
        // The time is judged before anything learns from the sample.
        let pushed = self.history.push(entry);
        match pushed {
            Pushed::Late | Pushed::Suspect => return pushed,
            Pushed::Restarted => self.restart(),
            Pushed::Kept => {}
        }
        if let Some(before) = before.filter(|_| pushed == Pushed::Kept) {
            self.learn_step(entry.time_ns.saturating_sub(before.time_ns));
        }
        if !awaited {
            self.last_event = self.classifier.push(&entry).or(self.last_event);
        }
        if entry.valid {
            self.take_valid(&mut entry);
        }
        pushed
    }

    /// Both eyes were seen so shortly before that one alone does not yet stand in for them.
    fn awaits_both_eyes(&self, entry: &Entry) -> bool {
        let since = |last: &Entry| entry.time_ns.saturating_sub(last.time_ns);
        let both = self.last.as_ref().filter(|(last, _)| !last.one_eye);
        entry.one_eye && both.is_some_and(|(last, _)| since(last) <= self.settings.loss.one_eye_after_ns)
    }

    fn take_valid(&mut self, entry: &mut Entry) {
        let phase = self.classifier.phase();
        if self.last.is_some_and(|(last, _)| !last.comparable(entry)) {
            self.filters.reset();
            self.predictor.reset();
        }
        let smoothed = self.filters.apply(entry.time_ns, entry.gaze(), phase.state);
        entry.smoothed = entry.world_from_view.map_or(smoothed, |turn| turn.inverse() * smoothed);
        self.history.smooth_newest(entry.smoothed);
        self.predictor.push(entry, &phase);
        self.landing = self.predictor.landing();
        self.head = entry.world_from_view.map(|turn| self.head_motion(entry.time_ns, turn));
        self.last = Some((*entry, phase));
    }

    /// Takes what a source tells: samples are pushed; a source that stalls, leaves or ends makes answers
    /// stale until it recovers.
    pub fn on_event(&mut self, event: &SourceEvent) {
        match event {
            SourceEvent::Sample(sample) => {
                self.push(sample);
            }
            SourceEvent::Stalled { .. } | SourceEvent::Disconnected { .. } | SourceEvent::Ended => {
                self.silent = true;
            }
            SourceEvent::Recovered { .. } | SourceEvent::Reconnected => self.silent = false,
            SourceEvent::Lost { .. } | SourceEvent::Rejected { .. } => {}
        }
    }

    /// Where the eye looks at a time on the host clock. `None` where no usable gaze is known: before the
    /// first valid sample, and long after the last one.
    #[must_use]
    pub fn estimate_at(&self, display_time_ns: i64) -> Option<GazeEstimate> {
        let (last, _) = self.last.as_ref()?;
        if display_time_ns <= last.time_ns { self.past(display_time_ns) } else { self.ahead(display_time_ns) }
    }

    /// What the eye does at the newest valid sample, and since when.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.classifier.phase()
    }

    /// The last change of what the eye does.
    #[must_use]
    pub fn last_event(&self) -> Option<&EventUpdate> {
        self.last_event.as_ref()
    }

    /// The raw samples.
    #[must_use]
    pub fn history(&self) -> &History {
        &self.history
    }

    /// How late the filters make the gaze now, ns.
    #[must_use]
    pub fn filter_delay_ns(&self) -> i64 {
        self.filters.delay_ns()
    }

    /// The landing of the saccade under way, as the predictor sees it.
    #[must_use]
    pub fn landing(&self) -> Option<Landing> {
        self.landing
    }

    /// A new epoch of time: everything that compares times starts anew. The last valid gaze is kept, at the
    /// start of the new epoch, and counts as old as the loss policy's hold allows.
    fn restart(&mut self) {
        self.classifier.reset();
        self.filters.reset();
        self.predictor.reset();
        self.landing = None;
        self.head = None;
        self.step_ns = 0;
        let start_ns = self.history.newest().map_or(0, |newest| newest.time_ns);
        if let Some((last, _)) = self.last.as_mut() {
            last.time_ns = start_ns.saturating_sub(self.settings.loss.hold_ns.max(0));
        }
    }

    fn learn_step(&mut self, step_ns: i64) {
        if self.step_ns == 0 || step_ns < self.step_ns {
            self.step_ns = step_ns;
        } else {
            // Grows by a sixteenth of the difference, so that a slower rate is learnt within some samples.
            self.step_ns = self.step_ns.saturating_add((step_ns.saturating_sub(self.step_ns)) / 16);
        }
    }

    fn same_time_ns(&self) -> i64 {
        (self.step_ns / 2).min(SAME_TIME_NS)
    }

    fn head_motion(&self, time_ns: i64, world_from_view: DQuat) -> HeadMotion {
        let earlier = self.history.around(time_ns.saturating_sub(HEAD_WINDOW_NS)).0;
        let rate = earlier.and_then(|earlier| {
            let past_s = time_ns.saturating_sub(earlier.time_ns) as f64 * 1e-9;
            let turned = (world_from_view * earlier.world_from_view?.inverse()).normalize();
            let turned = if turned.w < 0.0 { -turned } else { turned };
            (past_s > 0.0 && past_s < 0.1).then(|| turned.to_scaled_axis() / past_s)
        });
        HeadMotion { time_ns, world_from_view, rate_rad_s: rate.unwrap_or(DVec3::ZERO) }
    }

    /// At or before the newest valid sample.
    fn past(&self, time_ns: i64) -> Option<GazeEstimate> {
        let (last, _) = self.last.as_ref()?;
        let (before, after) = self.history.around(time_ns);
        let before = before.filter(|entry| entry.valid);
        let after = after.filter(|entry| entry.valid);
        let same_ns = self.same_time_ns();
        let near = |entry: &Entry| time_ns.saturating_sub(entry.time_ns).saturating_abs() <= same_ns;
        let nearest = [before, after].into_iter().flatten().filter(|entry| near(entry));
        let nearest = nearest.min_by_key(|entry| time_ns.saturating_sub(entry.time_ns).saturating_abs());
        if let Some(entry) = nearest {
            return Some(self.answer(entry, entry.smoothed, time_ns, EstimateKind::Measured, 0.0));
        }
        if let Some((before, after)) = before.zip(after).filter(|(before, after)| {
            before.comparable(after)
                && after.time_ns.saturating_sub(before.time_ns) <= self.settings.max_gap_ns
        }) {
            let gap = after.time_ns.saturating_sub(before.time_ns) as f64;
            let share = time_ns.saturating_sub(before.time_ns) as f64 / gap;
            let direction = between(before.smoothed, after.smoothed, share);
            let mut answer = self.answer(before, direction, time_ns, EstimateKind::Interpolated, 0.0);
            answer.age_ns = time_ns.saturating_sub(after.time_ns);
            return Some(answer);
        }
        // A gap, or a time before the history: the last valid sample before it, or else the first after.
        let entry = self.history.valid_near(time_ns).unwrap_or(last);
        Some(self.answer(entry, entry.smoothed, time_ns, EstimateKind::Held, 0.0))
    }

    /// After the newest valid sample.
    fn ahead(&self, time_ns: i64) -> Option<GazeEstimate> {
        let (last, phase) = self.last.as_ref()?;
        let loss = &self.settings.loss;
        let age_ns = time_ns.saturating_sub(last.time_ns);
        if age_ns > loss.none_after_ns {
            return None;
        }
        let newest_ns = self.history.newest().map_or(last.time_ns, |newest| newest.time_ns);
        let unseen_ns = newest_ns.saturating_sub(last.time_ns);
        let quiet_ns = time_ns.saturating_sub(newest_ns.max(last.time_ns));
        let kind = if self.silent || quiet_ns > loss.stale_after_ns {
            EstimateKind::Stale
        } else if age_ns <= self.same_time_ns() {
            EstimateKind::Measured
        } else if unseen_ns > loss.bridge_ns || age_ns > self.settings.max_horizon_ns {
            EstimateKind::Held
        } else {
            EstimateKind::Predicted
        };
        let predicted = if kind == EstimateKind::Predicted { self.predicted(phase, time_ns) } else { None };
        // After a jump of the clock there is nothing yet to predict from.
        let unpredicted = kind == EstimateKind::Predicted && predicted.is_none();
        let kind = if unpredicted { EstimateKind::Held } else { kind };
        let in_view = |gaze: DVec3| self.head.map_or(gaze, |head| head.at(time_ns).inverse() * gaze);
        let direction = predicted.map_or(last.smoothed, in_view);
        // On its way to the landing point, or held while it moves on, the eye is not where the answer is.
        let likely = self.predictor.predict(time_ns).map(in_view);
        let away_rad = likely.map_or(0.0, |likely| likely.angle_between(direction));
        Some(self.answer(last, direction, time_ns, kind, away_rad))
    }

    /// Gaze ahead, in the space of the predictor.
    fn predicted(&self, phase: &Phase, time_ns: i64) -> Option<DVec3> {
        let landing =
            self.landing.filter(|_| phase.state == EyeState::Saccade && self.settings.aim == Aim::Landing);
        landing.map(|landing| landing.gaze).or_else(|| self.predictor.predict(time_ns))
    }

    fn answer(
        &self,
        from: &Entry,
        direction: DVec3,
        time_ns: i64,
        kind: EstimateKind,
        away_rad: f64,
    ) -> GazeEstimate {
        let age_ns = time_ns.saturating_sub(from.time_ns);
        let newest = self.last.as_ref().filter(|(last, _)| last.time_ns == from.time_ns);
        let phase = self.classifier.phase();
        // Of a past sample it is not kept what the eye did; the newest stands in, and it is the doubt of
        // a moving eye that counts.
        let eye_state =
            if newest.is_some() || time_ns >= phase.since_ns { phase.state } else { EyeState::Unknown };
        let doubt = Doubt {
            age_ns: age_ns.saturating_abs(),
            one_eye: from.one_eye,
            measured: newest.map_or(phase, |(_, phase)| *phase),
            now: phase.state,
            landing_deg: newest.and(self.landing).map_or(0.0, |landing| landing.error_deg),
            away_deg: away_rad.to_degrees(),
        };
        let error_radius_rad = doubt.radius_deg(&self.settings.radius, &self.settings.loss).to_radians();
        GazeEstimate { direction_view: direction, error_radius_rad, kind, age_ns, eye_state }
    }
}

/// On the great circle from one unit vector to another.
fn between(from: DVec3, to: DVec3, share: f64) -> DVec3 {
    let angle = from.angle_between(to);
    // The same direction, or opposite ones, between which there is no one great circle.
    if !(1e-6..std::f64::consts::PI - 1e-6).contains(&angle) {
        return if share < 0.5 { from } else { to };
    }
    let direction = from * ((1.0 - share) * angle).sin() + to * (share * angle).sin();
    direction.try_normalize().unwrap_or(to)
}

#[cfg(test)]
mod calibration;
#[cfg(test)]
mod tests;
