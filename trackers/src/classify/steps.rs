//! What each state makes of the next sample.

use super::{Classifier, Event, EventUpdate, Open, Point, START_MEMORY_S, START_S, velocity};
use crate::estimate::EyeState;
use crate::history::Entry;
use glam::DVec3;

impl Classifier {
    /// Tells the state that is open now.
    pub(super) fn told(&self, finished: [Option<Event>; 2], detected_ns: i64) -> Option<EventUpdate> {
        let open = self.state.open?;
        Some(EventUpdate { state: open.kind, since_ns: open.start_ns, detected_ns, finished })
    }

    fn begin(&mut self, kind: EyeState, start_ns: i64, start_gaze: DVec3, detected_ns: i64) {
        self.state.open = Some(Open { kind, start_ns, start_gaze, peak_deg_s: 0.0, detected_ns });
        self.state.turning_ns = None;
    }

    pub(super) fn begin_fixation(&mut self, entry: &Entry) -> Option<EventUpdate> {
        self.begin(EyeState::Fixation, entry.time_ns, entry.gaze(), entry.time_ns);
        self.told([None, None], entry.time_ns)
    }

    /// Measures velocity and jitter and remembers the point.
    pub(super) fn measure(&mut self, entry: &Entry) {
        let gaze = entry.gaze();
        let settings = &self.settings;
        let found = velocity(&self.points, entry.time_ns, gaze, settings.window_ns, settings.max_step_ns);
        self.state.velocity = found.unwrap_or_default();
        if let Some(before) = self.points.back(0).filter(|_| found.is_some()) {
            let step_ns = entry.time_ns.saturating_sub(before.time_ns);
            let moved_deg = before.gaze.angle_between(gaze).to_degrees();
            self.state.jitter_deg.push(moved_deg, self.share(step_ns, settings.noise_memory_s));
        }
        self.points.push(Point { time_ns: entry.time_ns, gaze, velocity: self.state.velocity });
    }

    fn share(&self, step_ns: i64, memory_s: f64) -> f64 {
        step_ns as f64 * 1e-9 / memory_s.max(1e-9)
    }

    /// Thresholds of onset and offset, deg/s.
    fn thresholds(&self) -> (f64, f64) {
        let noise = self.state.noise_deg_s.value();
        let onset = (self.settings.onset_noise * noise).max(self.settings.onset_floor_deg_s);
        (onset, (self.settings.offset_noise * noise).max(self.settings.offset_floor_deg_s).min(onset))
    }

    /// Fast velocity: what the slow one does not explain.
    fn fast(&self) -> DVec3 {
        self.state.velocity.deg_s - self.state.drift_deg_s
    }

    /// Learns noise from a sample that does not belong to a saccade, or is the first that does: else the
    /// noise of a tracker that becomes noisier would pass for saccades for ever.
    fn learn_noise(&mut self, step_ns: i64) {
        let starts = self.state.learnt_s < START_S;
        let memory_s = if starts { START_MEMORY_S } else { self.settings.noise_memory_s };
        self.state.noise_deg_s.push(self.fast().length(), self.share(step_ns, memory_s));
        if starts {
            self.state.learnt_s += step_ns as f64 * 1e-9;
        }
    }

    /// In a fixation or pursuit: does a saccade begin, or the other of the two?
    pub(super) fn at_rest(&mut self, entry: &Entry, step_ns: i64) -> Option<EventUpdate> {
        let (onset_deg_s, offset_deg_s) = self.thresholds();
        let mut threshold = onset_deg_s;
        let mut settling = false;
        if let Some((end_ns, peak_deg_s)) = self.state.last_saccade {
            let since_ns = entry.time_ns.saturating_sub(end_ns);
            settling = since_ns < self.settings.settle_ns;
            if settling {
                let decay = (-self.share(since_ns, self.settings.settle_tau_s)).exp();
                threshold = threshold.max(peak_deg_s * self.settings.settle_peak_share * decay);
            }
        }
        let speed = self.fast().length();
        if let Some(open) = self.state.open.as_mut() {
            open.peak_deg_s = open.peak_deg_s.max(speed.min(threshold));
        }
        self.learn_noise(step_ns);
        if speed > threshold {
            return self.begin_saccade(entry, offset_deg_s);
        }
        if !settling {
            let share = 1.0 - (-self.share(step_ns, self.settings.drift_tau_s)).exp();
            self.state.drift_deg_s += self.fast() * share;
        }
        self.pursuit(entry)
    }

    /// Dates the onset back to where the speed along the saccade crossed the threshold of offset.
    fn begin_saccade(&mut self, entry: &Entry, offset_deg_s: f64) -> Option<EventUpdate> {
        let fast = self.fast();
        let along = fast.normalize_or_zero();
        let speed_of = |point: &Point| (point.velocity.deg_s - self.state.drift_deg_s).dot(along);
        let earliest_ns = self.state.open.map_or(i64::MIN, |open| open.start_ns);
        let mut after = (fast.length(), self.state.velocity.middle_ns);
        let mut start_ns = after.1;
        for point in self.points.newest_first().skip(1) {
            let at = (speed_of(point), point.velocity.middle_ns);
            start_ns = if point.velocity.span_s > 0.0 { crossing(offset_deg_s, after, at) } else { after.1 };
            if at.0 <= offset_deg_s || at.1 <= earliest_ns || point.velocity.span_s <= 0.0 {
                break;
            }
            after = at;
        }
        let start_ns = start_ns.max(earliest_ns);
        let start_gaze = self.gaze_at(start_ns);
        self.state.before = self.state.open;
        self.begin(EyeState::Saccade, start_ns, start_gaze, entry.time_ns);
        self.state.along = (fast.length(), self.state.velocity.middle_ns);
        if let Some(open) = self.state.open.as_mut() {
            open.peak_deg_s = fast.length();
        }
        self.told([None, None], entry.time_ns)
    }

    /// Gaze of the first point at or after a time, or of the newest.
    fn gaze_at(&self, time_ns: i64) -> DVec3 {
        let later = self.points.partition(|point| point.time_ns >= time_ns);
        self.points.back(later.saturating_sub(1)).map_or(DVec3::ZERO, |point| point.gaze)
    }

    /// In a saccade: is it over?
    pub(super) fn in_saccade(&mut self, entry: &Entry) -> Option<EventUpdate> {
        let offset_deg_s = self.thresholds().1;
        let fast = self.fast();
        let middle_ns = self.state.velocity.middle_ns;
        let open = self.state.open.as_mut()?;
        open.peak_deg_s = open.peak_deg_s.max(fast.length());
        let saccade = *open;
        let moved = entry.gaze() - saccade.start_gaze;
        let speed = fast.dot(moved.normalize_or_zero());
        let threshold = offset_deg_s.max(self.settings.offset_peak_share * saccade.peak_deg_s);
        if speed >= threshold {
            self.state.along = (speed, middle_ns);
            if entry.time_ns.saturating_sub(saccade.start_ns) <= self.settings.max_saccade_ns {
                return None;
            }
            // Too long: it was the start of a pursuit.
            let finished =
                self.state.before.take().map(|before| before.ended(saccade.start_ns, saccade.start_gaze));
            self.state.drift_deg_s = self.state.velocity.deg_s;
            self.begin(EyeState::Pursuit, saccade.start_ns, saccade.start_gaze, entry.time_ns);
            return self.told([finished, None], entry.time_ns);
        }
        let end_ns = crossing(threshold, self.state.along, (speed, middle_ns)).max(saccade.start_ns);
        let end_gaze = self.gaze_at(end_ns);
        let event = saccade.ended(end_ns, end_gaze);
        self.state.last_saccade = Some((end_ns, saccade.peak_deg_s));
        // What moves at the threshold for one window is noise.
        let least_deg = self.thresholds().0 * self.state.velocity.span_s;
        let real = event.amplitude_deg >= self.settings.min_amplitude_deg.max(least_deg)
            && end_ns.saturating_sub(saccade.start_ns) >= self.settings.min_saccade_ns;
        if !real {
            return self.retract(entry.time_ns);
        }
        let before =
            self.state.before.take().map(|before| before.ended(saccade.start_ns, saccade.start_gaze));
        self.begin(EyeState::Fixation, end_ns, end_gaze, entry.time_ns);
        self.told([before, Some(event)], entry.time_ns)
    }

    /// The saccade under way was none: what was before it goes on.
    pub(super) fn retract(&mut self, now_ns: i64) -> Option<EventUpdate> {
        self.state.open = self.state.before.take();
        self.told([None, None], now_ns)
    }

    /// Fixation turns into pursuit and back with the slow velocity.
    fn pursuit(&mut self, entry: &Entry) -> Option<EventUpdate> {
        let settings = self.settings;
        let open = self.state.open?;
        // Averaging over two time constants leaves this share of the noise of one window.
        let averaged = (self.state.velocity.span_s / (2.0 * settings.drift_tau_s.max(1e-9))).sqrt().min(1.0);
        let least = settings.pursuit_noise * self.state.noise_deg_s.value() * averaged;
        let threshold = settings.pursuit_deg_s.max(least);
        let speed = self.state.drift_deg_s.length();
        let pursues = open.kind == EyeState::Pursuit;
        // Leaving takes a lower speed than entering.
        let turning = if pursues { speed < 0.6 * threshold } else { speed > threshold };
        if !turning {
            self.state.turning_ns = None;
            return None;
        }
        let since_ns = *self.state.turning_ns.get_or_insert(entry.time_ns);
        if entry.time_ns.saturating_sub(since_ns) < settings.min_pursuit_ns {
            return None;
        }
        // The slow velocity reaches half of a step within ln 2 of its time constant.
        let lag_ns = (settings.drift_tau_s * std::f64::consts::LN_2 * 1e9) as i64;
        let start_ns = since_ns.saturating_sub(lag_ns).max(open.start_ns);
        let start_gaze = self.gaze_at(start_ns);
        let finished = (start_ns > open.start_ns).then(|| open.ended(start_ns, start_gaze));
        let kind = if pursues { EyeState::Fixation } else { EyeState::Pursuit };
        self.begin(kind, start_ns, start_gaze, entry.time_ns);
        self.told([finished, None], entry.time_ns)
    }

    /// The eye is lost since `since_ns`. A saccade that runs into the loss was the lid, which drags the
    /// visible part of the pupil along: the loss begins with it.
    pub(super) fn lose(
        &mut self,
        kind: EyeState,
        last: Option<Entry>,
        since_ns: i64,
        now_ns: i64,
    ) -> Option<EventUpdate> {
        let gaze = last.map_or(DVec3::ZERO, |last| last.gaze());
        let (finished, start_ns) = match (self.state.open, self.state.before.take()) {
            (Some(saccade), Some(before)) => {
                (Some(before.ended(saccade.start_ns, saccade.start_gaze)), saccade.start_ns)
            }
            (open, _) => (open.map(|open| open.ended(since_ns, gaze)), since_ns),
        };
        self.begin(kind, start_ns, DVec3::ZERO, now_ns);
        self.state.last_saccade = None;
        self.told([finished, None], now_ns)
    }

    /// The eye is seen again; the loss ends when the lids had time to open.
    pub(super) fn reopen(&mut self, entry: &Entry) -> Option<EventUpdate> {
        let Some(reopened_ns) = self.state.reopened_ns else {
            self.state.reopened_ns = Some(entry.time_ns);
            self.points.clear();
            self.state.drift_deg_s = DVec3::ZERO;
            self.measure(entry);
            return None;
        };
        if entry.time_ns.saturating_sub(reopened_ns) < self.settings.reopen_ns {
            return None;
        }
        let finished = self.state.open.map(|open| open.ended(entry.time_ns, DVec3::ZERO));
        self.state.reopened_ns = None;
        self.begin(EyeState::Fixation, entry.time_ns, entry.gaze(), entry.time_ns);
        self.told([finished, None], entry.time_ns)
    }
}

/// When a speed that was `from.0` at `from.1` and is `to.0` at `to.1` crossed the threshold, on the
/// straight line between them; the nearer end where it did not.
fn crossing(threshold: f64, from: (f64, i64), to: (f64, i64)) -> i64 {
    let change = to.0 - from.0;
    let share = if change == 0.0 { 1.0 } else { ((threshold - from.0) / change).clamp(0.0, 1.0) };
    from.1.saturating_add((share * to.1.saturating_sub(from.1) as f64) as i64)
}
