//! What happens in a block of time: the movements of the eye and the head, the blinks and the losses.
//!
//! Time is cut into blocks so that any instant can be asked for without living through all before it.
//! A block begins with the gaze at rest on its anchor, a place that depends on the seed and the block's
//! number alone, and ends with the gaze at rest on the next one's.

use super::blink::{Span, span_at};
use super::geometry::{angle, turn};
use super::head::Turns;
use super::pursuit::Pursuit;
use super::saccade::{Profile, minimum_jerk, oscillation};
use super::truth::{TruthEvent, TruthKind};
use glam::{DQuat, DVec3};

/// Length of a block, ns. Longer ones have fewer seams and take longer to jump into.
pub(super) const BLOCK_NS: i64 = 120_000_000_000;
/// How long the eyes take to converge at another distance, ns.
const VERGENCE_NS: i64 = 300_000_000;

/// How the eye got to where it now is.
#[derive(Clone, Debug)]
pub(super) enum Way {
    /// It was there when the block began.
    Begin,
    /// By a saccade.
    Saccade(Box<Flight>),
}

/// A saccade.
#[derive(Clone, Debug)]
pub(super) struct Flight {
    pub(super) micro: bool,
    pub(super) from: DVec3,
    /// What the gaze turns about.
    pub(super) axis: DVec3,
    pub(super) amplitude_rad: f64,
    /// Sideways bend at the middle, rad.
    pub(super) bend_rad: f64,
    pub(super) length_ns: i64,
    pub(super) profile: Profile,
    /// Displacement of the pupil at the end, rad, and how long it swings on.
    pub(super) swing_rad: f64,
    pub(super) swing_ns: i64,
}

impl Flight {
    fn at(&self, since_ns: i64) -> DVec3 {
        let way = self.profile.position(since_ns as f64 / self.length_ns as f64);
        let straight = turn(self.from, self.axis, self.amplitude_rad * way);
        let (sin, cos) = (self.bend_rad * 4.0 * way * (1.0 - way)).sin_cos();
        straight * cos + self.axis * sin
    }

    fn peak_deg_s(&self) -> f64 {
        self.profile.peak * self.amplitude_rad.to_degrees() / (self.length_ns as f64 * 1e-9)
    }
}

/// A movement and the rest, or the pursuit, that follows it. Times are the block's own.
#[derive(Clone, Debug)]
pub(super) struct Step {
    pub(super) start_ns: i64,
    pub(super) way: Way,
    /// Where the movement ends.
    pub(super) to: DVec3,
    pub(super) pursuit: Option<Pursuit>,
    /// How the head was turned when the movement ended; `None` where the gaze does not slip at all.
    pub(super) slip_from: Option<DQuat>,
    /// Convergence before and after, 1/m.
    pub(super) vergence: [f64; 2],
}

impl Step {
    pub(super) fn end_ns(&self) -> i64 {
        match &self.way {
            Way::Begin => self.start_ns,
            Way::Saccade(flight) => self.start_ns + flight.length_ns,
        }
    }

    /// The gaze in the world, with the head turned like `head`.
    pub(super) fn gaze(&self, time_ns: i64, head: DQuat, vor_gain: f64) -> DVec3 {
        let since_ns = time_ns - self.end_ns();
        if let (Way::Saccade(flight), true) = (&self.way, since_ns < 0) {
            return flight.at(time_ns - self.start_ns);
        }
        let gaze = match &self.pursuit {
            None => self.to,
            Some(pursuit) => pursuit.at(self.to, since_ns as f64 * 1e-9),
        };
        let Some(before) = self.slip_from else { return gaze };
        let turned = (head * before.inverse()).to_scaled_axis();
        DQuat::from_scaled_axis(turned * (1.0 - vor_gain)) * gaze
    }

    /// Convergence of the eyes, 1/m.
    pub(super) fn vergence_at(&self, time_ns: i64) -> f64 {
        let [from, to] = self.vergence;
        from + (to - from) * minimum_jerk((time_ns - self.start_ns) as f64 / VERGENCE_NS as f64)
    }

    /// How far the pupil is displaced against the eyeball, in the world, rad.
    pub(super) fn swing(&self, time_ns: i64) -> DVec3 {
        let Way::Saccade(flight) = &self.way else { return DVec3::ZERO };
        let since_ns = time_ns - self.end_ns();
        if since_ns >= flight.swing_ns {
            return DVec3::ZERO;
        }
        let swing = oscillation(since_ns, flight.swing_ns, flight.length_ns);
        flight.axis.cross(self.to) * (flight.swing_rad * swing)
    }

    fn kind_at(&self, time_ns: i64, oscillates: bool) -> (TruthKind, f64) {
        if let Way::Saccade(flight) = &self.way {
            let since_ns = time_ns - self.end_ns();
            if since_ns < 0 {
                let kind = if flight.micro { TruthKind::Microsaccade } else { TruthKind::Saccade };
                return (kind, flight.peak_deg_s());
            }
            if oscillates && since_ns < flight.swing_ns && flight.swing_rad > 0.0 {
                return (TruthKind::Oscillation, 0.0);
            }
        }
        match &self.pursuit {
            Some(pursuit) => (TruthKind::Pursuit, pursuit.speed_rad_s.to_degrees()),
            None => (TruthKind::Fixation, 0.0),
        }
    }
}

/// Everything that happens in a block.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub(super) index: i64,
    /// The first starts at 0.
    pub(super) steps: Vec<Step>,
    pub(super) turns: Turns,
    /// When lids move.
    pub(super) blinks: Vec<Span>,
    /// When lids cover the pupil.
    pub(super) covered: Vec<Span>,
    pub(super) losses: Losses,
}

/// When the tracker loses the eyes.
#[derive(Clone, Debug, Default)]
pub(super) struct Losses {
    pub(super) both: Vec<Span>,
    pub(super) left: Vec<Span>,
    pub(super) right: Vec<Span>,
}

impl Losses {
    /// Whether the left and the right eye are lost.
    pub(super) fn at(&self, time_ns: i64) -> [bool; 2] {
        let both = span_at(&self.both, time_ns).is_some();
        [&self.left, &self.right].map(|spans| both || span_at(spans, time_ns).is_some())
    }

    fn all(&self) -> impl Iterator<Item = &Span> {
        self.both.iter().chain(&self.left).chain(&self.right)
    }
}

impl Block {
    /// The step that a time of the block falls into. There always is one, as the first starts at 0.
    pub(super) fn step_at(&self, time_ns: i64) -> Option<&Step> {
        let begun = self.steps.partition_point(|step| step.start_ns <= time_ns);
        self.steps.get(begun.saturating_sub(1))
    }

    /// What the eye does at a time of the block, and how fast at most.
    pub(super) fn kind_at(&self, time_ns: i64, oscillates: bool) -> (TruthKind, f64) {
        if self.losses.at(time_ns) == [true, true] {
            return (TruthKind::Lost, 0.0);
        }
        if span_at(&self.covered, time_ns).is_some() {
            return (TruthKind::Blink, 0.0);
        }
        let step = self.step_at(time_ns);
        step.map_or((TruthKind::Fixation, 0.0), |step| step.kind_at(time_ns, oscillates))
    }

    /// Labelled events from one time of the block to another. `gaze_at` tells the gaze in the world.
    pub(super) fn events(
        &self,
        within: Span,
        oscillates: bool,
        gaze_at: impl Fn(i64) -> DVec3,
    ) -> Vec<TruthEvent> {
        // The kind cannot change between two of these.
        let mut edges_ns: Vec<i64> = vec![within.start_ns, within.end_ns];
        for step in &self.steps {
            edges_ns.extend([step.start_ns, step.end_ns()]);
            if let Way::Saccade(flight) = &step.way {
                edges_ns.push(step.end_ns() + flight.swing_ns);
            }
        }
        let spans = self.covered.iter().chain(self.losses.all());
        edges_ns.extend(spans.flat_map(|span| [span.start_ns, span.end_ns]));
        edges_ns.retain(|edge| (within.start_ns..=within.end_ns).contains(edge));
        edges_ns.sort_unstable();
        edges_ns.dedup();
        let mut events: Vec<TruthEvent> = Vec::new();
        for pair in edges_ns.windows(2) {
            let [start_ns, end_ns] = [pair[0], pair[1]];
            let (kind, peak_deg_s) = self.kind_at(start_ns, oscillates);
            match events.last_mut() {
                // An edge of something that does not show in the label, as the loss of one eye.
                Some(last) if (last.kind, last.peak_deg_s) == (kind, peak_deg_s) => last.end_ns = end_ns,
                _ => events.push(TruthEvent { kind, start_ns, end_ns, amplitude_deg: 0.0, peak_deg_s }),
            }
        }
        for event in &mut events {
            event.amplitude_deg = angle(gaze_at(event.start_ns), gaze_at(event.end_ns - 1)).to_degrees();
        }
        events
    }
}
