//! What latency a radius allows, what radius a latency needs, and which stage to attack.

use super::figures::quantile;
use super::run::{Follower, Frame, GazeAnswer, LatencyRun, Question, filter_ns, told, unit};
use super::session::{SessionGaze, angle_deg};
use super::stage::Stage;
use glam::DVec3;
use serde::Serialize;

/// The sweep looks at no more frames than this, evenly spread: a share of 2 % is known to 0.1 % with it.
const MOST_SWEEP_FRAMES: usize = 30_000;

/// A published latency to compare with.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Reference {
    /// What it says.
    pub what: &'static str,
    /// From, ms.
    pub from_ms: f64,
    /// To, ms.
    pub to_ms: f64,
    /// It is latency added to that of the system, not the whole.
    pub added: bool,
    /// Who says so.
    pub source: &'static str,
}

/// The bounds of Albert et al. 2017.
pub const REFERENCES: [Reference; 3] = [
    Reference {
        what: "total latency that could be tolerated",
        from_ms: 50.0,
        to_ms: 70.0,
        added: false,
        source: "Albert et al. 2017, ACM TAP 14(4):25",
    },
    Reference {
        what: "added latency without a significant effect",
        from_ms: 20.0,
        to_ms: 40.0,
        added: true,
        source: "Albert et al. 2017, ACM TAP 14(4):25",
    },
    Reference {
        what: "added latency that significantly reduces the acceptable foveation",
        from_ms: 80.0,
        to_ms: 150.0,
        added: true,
        source: "Albert et al. 2017, ACM TAP 14(4):25",
    },
];

/// One latency of the sweep.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BudgetPoint {
    /// Mean age of the gaze when displayed, ms.
    pub latency_ms: f64,
    /// Share of the counted time with the true gaze outside the asked radius.
    pub outside_fraction: f64,
    /// Radius that holds the true gaze for all but the target share of the counted time, degrees; never
    /// less than at a smaller latency.
    pub radius_deg: f64,
    /// Radius that holds it for 95 %, degrees.
    pub radius_p95_deg: f64,
}

/// A stage's part in the latency.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageShare {
    /// Which.
    pub stage: Stage,
    /// Mean, ms.
    pub mean_ms: f64,
    /// Of the mean age, 0 to 1.
    pub share: f64,
    /// By how much the needed radius shrinks if the stage takes no time, degrees.
    pub saved_if_zero_deg: f64,
    /// By how much it shrinks if the stage takes half the time, degrees.
    pub saved_if_half_deg: f64,
    /// Where the figure comes from.
    pub source: String,
    /// The figure is from no source.
    pub guess: bool,
}

/// The budget of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Budget {
    /// The radius of full quality, degrees.
    pub radius_deg: f64,
    /// The allowed share of the counted time outside of it.
    pub target_outside: f64,
    /// The mean age in the counted time as it is, ms.
    pub latency_ms: f64,
    /// The largest latency at which the radius keeps the target, ms; `None` where no latency does.
    pub largest_latency_ms: Option<f64>,
    /// The radius keeps the target even at the largest latency looked at; the one above is that.
    pub beyond_sweep: bool,
    /// The radius that keeps the target at the latency as it is, degrees; `None` without counted time.
    pub needed_radius_deg: Option<f64>,
    /// The radius that holds the true gaze for 95 % of the counted time, degrees.
    pub needed_radius_p95_deg: Option<f64>,
    /// The stage of which half the time saves most; `None` where none saves anything.
    pub attack: Option<Stage>,
    /// Every stage, in order.
    pub stages: Vec<StageShare>,
    /// The sweep, by ascending latency.
    pub curve: Vec<BudgetPoint>,
    /// Published latencies.
    pub references: Vec<Reference>,
}

impl Budget {
    /// The radius that keeps the target at a latency, degrees: between the points of the curve, and its
    /// ends beyond them. `None` for an empty curve.
    #[must_use]
    pub fn radius_for(&self, latency_ms: f64) -> Option<f64> {
        self.at(latency_ms, |point| point.radius_deg)
    }

    fn at(&self, latency_ms: f64, value: impl Fn(&BudgetPoint) -> f64) -> Option<f64> {
        let after = self.curve.partition_point(|point| point.latency_ms <= latency_ms);
        let to = self.curve.get(after).or(self.curve.last())?;
        let from = after.checked_sub(1).and_then(|index| self.curve.get(index)).unwrap_or(to);
        let width_ms = to.latency_ms - from.latency_ms;
        let share = if width_ms > 0.0 { (latency_ms - from.latency_ms) / width_ms } else { 0.0 };
        Some(value(from) + (value(to) - value(from)) * share.clamp(0.0, 1.0))
    }

    /// The largest latency at which a radius keeps the target, ms: the inverse of [`Self::radius_for`].
    /// `None` where the radius is too small at every latency; the end of the curve where it is large
    /// enough for all.
    #[must_use]
    pub fn latency_for(&self, radius_deg: f64) -> Option<f64> {
        let after = self.curve.partition_point(|point| point.radius_deg <= radius_deg);
        let from = self.curve.get(after.checked_sub(1)?)?;
        let Some(to) = self.curve.get(after) else { return Some(from.latency_ms) };
        let share = (radius_deg - from.radius_deg) / (to.radius_deg - from.radius_deg);
        Some(from.latency_ms + (to.latency_ms - from.latency_ms) * share.clamp(0.0, 1.0))
    }
}

impl LatencyRun {
    /// The budget of this run over `session`, which must be the one that it was made of; `answer` as in
    /// [`super::run_with`], `None` for a run that held the newest gaze. An answer is run once for each
    /// point of the sweep.
    ///
    /// Latency is added or removed between the arrival of the samples and the renderer.
    #[must_use]
    pub fn budget(&self, session: &SessionGaze, mut answer: Option<&mut dyn GazeAnswer>) -> Budget {
        let counted: Vec<&Frame> = self.frames.iter().filter(|frame| frame.counted).collect();
        let step = counted.len().div_ceil(MOST_SWEEP_FRAMES).max(1);
        // A copy that lies together: the sweep goes over it once for each latency.
        let frames: Vec<Frame> = counted.into_iter().step_by(step).copied().collect();
        let ages = || frames.iter().filter_map(|frame| frame.age_ns);
        let latency_ms = ages().map(|ns| ns as f64).sum::<f64>() * 1e-6 / ages().count().max(1) as f64;
        let mut errors: Vec<f64> = frames.iter().filter_map(|frame| frame.error_deg).collect();
        let needed = |level: f64, errors: &mut [f64]| (!errors.is_empty()).then(|| quantile(errors, level));
        let mut budget = Budget {
            radius_deg: self.settings.radius_deg,
            target_outside: self.settings.target_outside,
            latency_ms,
            largest_latency_ms: None,
            beyond_sweep: false,
            needed_radius_deg: needed(1.0 - self.settings.target_outside, &mut errors),
            needed_radius_p95_deg: needed(0.95, &mut errors),
            attack: None,
            stages: Vec::new(),
            curve: Vec::new(),
            references: REFERENCES.to_vec(),
        };
        let points = self.settings.sweep_points.max(2);
        for number in 0..points {
            let asked_ms = self.settings.sweep_to_ms * number as f64 / (points - 1) as f64;
            let shift_ns = ((asked_ms - latency_ms) * 1e6) as i64;
            let sweep = Sweep { run: self, session, frames: &frames, shift_ns };
            budget.add(match &mut answer {
                Some(answer) => sweep.errors(Some(&mut **answer)),
                None => sweep.errors(None),
            });
        }
        budget.conclude(self);
        budget
    }
}

impl Budget {
    fn add(&mut self, (latency_ms, mut errors): (f64, Vec<f64>)) {
        let last = self.curve.last();
        // No sample is newer than the display: below some latency nothing changes any more.
        let new = last.is_none_or(|last| latency_ms > last.latency_ms + 1e-6);
        if errors.is_empty() || !new {
            return;
        }
        let outside = errors.iter().filter(|error| **error > self.radius_deg).count();
        let radius_deg = quantile(&mut errors, 1.0 - self.target_outside);
        let least = last
            .map_or((0.0, 0.0, 0.0), |last| (last.outside_fraction, last.radius_deg, last.radius_p95_deg));
        self.curve.push(BudgetPoint {
            latency_ms,
            outside_fraction: (outside as f64 / errors.len() as f64).max(least.0),
            radius_deg: radius_deg.max(least.1),
            radius_p95_deg: quantile(&mut errors, 0.95).max(least.2),
        });
    }

    fn conclude(&mut self, run: &LatencyRun) {
        self.largest_latency_ms = self.latency_for(self.radius_deg);
        self.beyond_sweep = self.curve.last().is_some_and(|last| last.radius_deg <= self.radius_deg);
        let now = self.radius_for(self.latency_ms).unwrap_or(0.0);
        let total_ms: f64 = run.stage_ms.iter().sum();
        let saved = |ms: f64| now - self.radius_for(self.latency_ms - ms).unwrap_or(now);
        self.stages = Stage::ALL
            .into_iter()
            .zip(run.stage_ms)
            .map(|(stage, mean_ms)| {
                let time = run.model.stage(stage);
                StageShare {
                    stage,
                    mean_ms,
                    share: if total_ms > 0.0 { mean_ms / total_ms } else { 0.0 },
                    saved_if_zero_deg: saved(mean_ms),
                    saved_if_half_deg: saved(mean_ms * 0.5),
                    source: if stage.is_simulated() { "simulated".into() } else { time.source.clone() },
                    guess: time.guess,
                }
            })
            .collect();
        let worth = self.stages.iter().filter(|stage| stage.saved_if_half_deg > 0.0);
        let most = worth.max_by(|one, other| {
            let by_saving = one.saved_if_half_deg.total_cmp(&other.saved_if_half_deg);
            by_saving.then(one.mean_ms.total_cmp(&other.mean_ms))
        });
        self.attack = most.map(|stage| stage.stage);
    }
}

/// The frames of a run once more, with the samples shifted in time.
struct Sweep<'a> {
    run: &'a LatencyRun,
    session: &'a SessionGaze,
    frames: &'a [Frame],
    shift_ns: i64,
}

impl Sweep<'_> {
    /// The mean age, ms, and the errors, degrees.
    fn errors(&self, mut answer: Option<&mut dyn GazeAnswer>) -> (f64, Vec<f64>) {
        if let Some(answer) = answer.as_deref_mut() {
            answer.begin();
        }
        let mut newest = Follower::default();
        let mut errors = Vec::with_capacity(self.frames.len());
        let mut age_sum_ns = 0.0;
        for frame in self.frames {
            let filter_ns =
                if answer.is_some() { 0 } else { filter_ns(&self.run.model, self.run.seed, frame.picture) };
            // A filter's delay is part of what the sweep adds and removes.
            let by_ns = frame.latch_ns.saturating_sub(self.shift_ns).saturating_sub(filter_ns);
            newest.advance(
                &self.run.arrivals,
                |arrival| arrival.available_ns <= by_ns && arrival.time_ns <= frame.display_ns,
                |arrival| {
                    if let Some(answer) = answer.as_deref_mut() {
                        let received_ns = arrival.available_ns.saturating_add(self.shift_ns);
                        answer.sample(&told(self.session, arrival, received_ns));
                    }
                },
            );
            let Some(arrival) = newest.usable else { continue };
            let direction = match answer.as_deref_mut() {
                Some(answer) => self.answered(answer, frame),
                None => self.session.direction(arrival.row as usize),
            };
            if let (Some(direction), Some(truth)) = (direction, frame.truth) {
                age_sum_ns += frame.display_ns.saturating_sub(arrival.time_ns) as f64;
                errors.push(angle_deg(truth, direction));
            }
        }
        (age_sum_ns * 1e-6 / errors.len().max(1) as f64, errors)
    }

    fn answered(&self, answer: &mut dyn GazeAnswer, frame: &Frame) -> Option<DVec3> {
        answer
            .direction_at(&Question { latch_ns: frame.latch_ns, display_ns: frame.expected_ns })
            .and_then(unit)
    }
}
