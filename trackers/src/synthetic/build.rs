//! Lays out what happens in a block of time.

use super::blink::{Span, Spread, covered, spans};
use super::geometry::{angle, axis, deflect, direction, place_deg, turn};
use super::head::{Sway, Turns, follow};
use super::plan::{anchor_deg, next_deg};
use super::pursuit::Pursuit;
use super::random::{Random, stream};
use super::saccade::{Profile, duration_ms, mode};
use super::scene::{BLOCK_NS, Block, Flight, Losses, Step, Way};
use super::settings::SyntheticSettings;
use glam::{DQuat, DVec2, DVec3};

/// Kept for the way to the next anchor at the end of a block, ns: a shift with its correction, up to
/// three saccades, the turn of the head and the eyes' convergence.
const RESERVE_NS: i64 = 4_000_000_000;
/// The gaze rests at least this long at the end of a block, ns.
const REST_NS: i64 = 600_000_000;
/// Time at the ends of a block without blinks, ns.
const CALM_NS: i64 = 500_000_000;
/// Shortest and longest time on one place, ns.
const DWELL_NS: [f64; 2] = [80e6, 10e9];
/// Longest saccade, ms.
const LONGEST_MS: f64 = 400.0;
/// Least time from a saccade to a microsaccade and the other way round, ns, and between two
/// microsaccades, s. They set the shortest times between saccades: a tenth of those in the hand labels are
/// below 115 to 122 ms.
const APART_NS: i64 = 100_000_000;
const REFRACTORY_S: f64 = 0.15;
/// Least time from the lids' opening to a saccade, ns.
const AFTER_BLINK_NS: i64 = 30_000_000;
/// Saccades from here on may fall short, degrees.
const CORRECTED_DEG: f64 = 3.0;
/// Where a saccade lands that does not fall short: standard deviation over the amplitude.
const SCATTER: f64 = 0.02;
/// The eye stays this close to what it fixates, degrees.
const FOVEA_DEG: f64 = 0.5;
/// Time in which pursuit takes up speed, s, and between catch-up saccades, ms.
const RAMP_S: f64 = 0.06;
const CATCH_UP_MS: f64 = 400.0;
/// A lag of pursuit that is left alone, rad.
const LAG_RAD: f64 = 0.005;

struct Builder<'a> {
    settings: &'a SyntheticSettings,
    sway: &'a Sway,
    random: Random,
    block: Block,
    /// Fixation time that is left to the next microsaccade, s; infinite for none.
    micro_left_s: f64,
}

/// The place and the distance (1/m) at which a block begins.
fn anchor(settings: &SyntheticSettings, key: u64, index: i64) -> (DVec2, f64) {
    let mut random = Random::new(key, stream::ANCHOR, index);
    (anchor_deg(&settings.scene, &mut random), vergence(settings, &mut random))
}

fn vergence(settings: &SyntheticSettings, random: &mut Random) -> f64 {
    1.0 / random.log_normal(settings.scene.depth_m, settings.scene.depth_sigma).clamp(0.15, 1e5)
}

/// Lays out a block.
pub(super) fn build(settings: &SyntheticSettings, key: u64, sway: &Sway, index: i64) -> Block {
    let (begin_deg, begin_vergence) = anchor(settings, key, index);
    let (end_deg, end_vergence) = anchor(settings, key, index.wrapping_add(1));
    let blinks = blinks(settings, key, index);
    let block = Block {
        index,
        steps: vec![Step {
            start_ns: 0,
            way: Way::Begin,
            to: direction(begin_deg),
            pursuit: None,
            slip_from: None,
            vergence: [begin_vergence; 2],
        }],
        turns: Turns::new(follow(&settings.head, DVec2::ZERO, begin_deg)),
        covered: blinks.iter().map(|blink| covered(*blink)).collect(),
        blinks,
        losses: losses(settings, key, index),
    };
    let random = Random::new(key, stream::SCENE, index);
    let mut builder = Builder { settings, sway, random, block, micro_left_s: f64::INFINITY };
    builder.next_micro();
    builder.fill();
    builder.go_home(direction(end_deg), end_vergence, follow(&settings.head, DVec2::ZERO, end_deg));
    builder.block
}

fn blinks(settings: &SyntheticSettings, key: u64, index: i64) -> Vec<Span> {
    let spread = Spread {
        per_min: settings.blink.per_min,
        median_ms: settings.blink.median_ms,
        within: Span { start_ns: CALM_NS, end_ns: BLOCK_NS - RESERVE_NS - CALM_NS },
        block_ns: BLOCK_NS,
    };
    spans(&mut Random::new(key, stream::BLINKS, index), &spread)
}

fn losses(settings: &SyntheticSettings, key: u64, index: i64) -> Losses {
    let mut random = Random::new(key, stream::LOSSES, index);
    let tracker = &settings.tracker;
    let mut made = |per_min: f64| {
        let within = Span { start_ns: 0, end_ns: BLOCK_NS };
        let spread = Spread { per_min, median_ms: tracker.loss_ms, within, block_ns: BLOCK_NS };
        spans(&mut random, &spread)
    };
    Losses {
        both: made(tracker.losses_per_min),
        left: made(tracker.one_eye_losses_per_min / 2.0),
        right: made(tracker.one_eye_losses_per_min / 2.0),
    }
}

impl Builder<'_> {
    /// From one place to the next until the reserve begins.
    fn fill(&mut self) {
        let leave_ns = BLOCK_NS - RESERVE_NS;
        let scene = &self.settings.scene;
        let mut place = place_deg(self.gaze_at(0));
        let mut at_ns = 0;
        loop {
            at_ns = if self.random.chance(scene.pursuit_probability) {
                self.pursue(at_ns, leave_ns)
            } else {
                let fixation = &self.settings.fixation;
                let dwell_ns = self.random.log_normal(fixation.median_ms * 1e6, fixation.sigma);
                let dwell_ns = dwell_ns.clamp(DWELL_NS[0], DWELL_NS[1]) as i64;
                self.fixate(at_ns, (at_ns + dwell_ns).min(leave_ns))
            };
            if at_ns >= leave_ns {
                return;
            }
            if self.last().pursuit.is_some() {
                place = place_deg(self.gaze_at(at_ns));
            }
            place = next_deg(scene, &mut self.random, place);
            at_ns = self.shift_gaze(at_ns, place);
        }
    }

    /// To the next block's anchor, and rest there.
    fn go_home(&mut self, home: DVec3, vergence: f64, head_deg: DVec2) {
        let mut at_ns = self.last().end_ns().max(BLOCK_NS - RESERVE_NS);
        // A hop may be longer than saccades otherwise are, so that three always do.
        let reach = self.settings.scene.max_amplitude_deg.to_radians();
        let reach = reach.max(angle(self.gaze_at(at_ns), home) / 3.0 + 1e-9);
        loop {
            let from = self.gaze_at(at_ns);
            let far = angle(from, home);
            if far <= reach {
                break;
            }
            at_ns = self.jump(at_ns, turn(from, axis(from, home), reach), vergence, false);
            at_ns += 2 * APART_NS;
        }
        self.block.turns.turn_to(head_deg, at_ns, BLOCK_NS);
        at_ns = self.jump(at_ns, home, vergence, false);
        self.fixate(at_ns, BLOCK_NS - REST_NS);
        let last_ns = (self.last().end_ns() + APART_NS).max(BLOCK_NS - REST_NS);
        if self.last().to != home {
            self.jump(last_ns, home, vergence, true);
        }
        // The next block knows nothing of this one's head: no slip is carried over.
        if let Some(last) = self.block.steps.last_mut() {
            last.slip_from = None;
        }
    }

    /// The last step. There is always the first.
    fn last(&self) -> &Step {
        &self.block.steps[self.block.steps.len() - 1]
    }

    fn head_at(&self, time_ns: i64) -> DQuat {
        let absolute_ns = self.block.index.wrapping_mul(BLOCK_NS).wrapping_add(time_ns);
        self.sway.pose(absolute_ns, self.block.turns.at_deg(time_ns)).world_from_view
    }

    fn gaze_at(&self, time_ns: i64) -> DVec3 {
        self.last().gaze(time_ns, self.head_at(time_ns), self.settings.head.vor_gain)
    }

    /// Draws when the next microsaccade is due.
    fn next_micro(&mut self) {
        let per_s = self.settings.fixation.microsaccades_per_s;
        self.micro_left_s = if per_s > 0.0 {
            let mean_s = (1.0 / per_s - REFRACTORY_S).max(0.01);
            REFRACTORY_S + self.random.exponential(mean_s)
        } else {
            f64::INFINITY
        };
    }

    /// Fixates from one time to another, with microsaccades; tells when it can be left.
    fn fixate(&mut self, from_ns: i64, until_ns: i64) -> i64 {
        let (aim, vergence) = (self.last().to, self.last().vergence[1]);
        let mut offset_deg = DVec2::ZERO;
        let mut at_ns = from_ns;
        loop {
            let due_ns = at_ns.saturating_add((self.micro_left_s * 1e9) as i64).max(at_ns + APART_NS);
            if due_ns >= until_ns - APART_NS {
                let passed_s = (until_ns - at_ns).max(0) as f64 * 1e-9;
                self.micro_left_s = (self.micro_left_s - passed_s).max(0.0);
                return until_ns.max(at_ns + APART_NS / 2);
            }
            offset_deg = self.next_offset_deg(offset_deg);
            at_ns = self.jump(due_ns, deflect(aim, offset_deg), vergence, true);
            self.next_micro();
        }
    }

    /// Where a microsaccade goes: anywhere, or back if that would leave the fovea.
    fn next_offset_deg(&mut self, offset_deg: DVec2) -> DVec2 {
        let median = self.settings.fixation.microsaccade_deg;
        let length = self.random.log_normal(median, 0.35).min(1.0);
        let away = offset_deg + DVec2::from_angle(std::f64::consts::TAU * self.random.unit()) * length;
        if away.length() <= FOVEA_DEG || offset_deg == DVec2::ZERO {
            return away;
        }
        offset_deg - offset_deg.normalize() * length
    }

    /// Looks at another place: a saccade, the head after it, a correction. Tells when fixation begins.
    fn shift_gaze(&mut self, time_ns: i64, place_deg: DVec2) -> i64 {
        let target = direction(place_deg);
        let vergence = vergence(self.settings, &mut self.random);
        let from = self.gaze_at(time_ns);
        let far = angle(from, target);
        let saccade = &self.settings.saccade;
        let short = far.to_degrees() >= CORRECTED_DEG && self.random.chance(saccade.corrective_probability);
        let scatter = self.random.normal_pair();
        let landing = if short {
            let missing = saccade.undershoot * (1.0 + 0.4 * scatter.x).clamp(0.3, 2.0);
            turn(from, axis(from, target), far * (1.0 - missing))
        } else {
            deflect(target, scatter.clamp_length_max(3.0) * (SCATTER * far.to_degrees()))
        };
        let head_deg = follow(&self.settings.head, self.block.turns.end_deg(), place_deg);
        let start_ns = self.clear_of_blinks(time_ns, self.longest_ns());
        self.block.turns.turn_to(head_deg, start_ns, BLOCK_NS);
        let end_ns = self.jump(start_ns, landing, vergence, false);
        if !short {
            return end_ns;
        }
        let pause_ms = self.random.log_normal(saccade.corrective_ms, 0.25).clamp(60.0, 600.0);
        self.jump(end_ns + (pause_ms * 1e6) as i64, target, vergence, false)
    }

    /// Follows something that moves; tells when it is left.
    fn pursue(&mut self, from_ns: i64, leave_ns: i64) -> i64 {
        let scene = &self.settings.scene;
        let start = self.last().to;
        let towards = direction(next_deg(scene, &mut self.random, place_deg(start)));
        let speed = self.random.log_normal(scene.pursuit_deg_s, 0.4).min(60.0).to_radians();
        let axis = axis(start, towards);
        let length_s = self.random.log_normal(scene.pursuit_ms * 1e-3, 0.4).clamp(0.1, 10.0);
        // To the place at most, so that it stays within the field.
        let length_s = if speed > 0.0 { length_s.min(angle(start, towards) / speed) } else { length_s };
        let until_ns = (from_ns + ((length_s * 1e9) as i64).max(APART_NS)).min(leave_ns);
        let mut pursuit = Pursuit { axis, speed_rad_s: speed * scene.pursuit_gain, ramp_s: RAMP_S };
        let mut at_ns = from_ns;
        loop {
            if let Some(last) = self.block.steps.last_mut() {
                last.pursuit = Some(pursuit);
            }
            pursuit.ramp_s = 0.0;
            let pause_ms = self.random.log_normal(CATCH_UP_MS, 0.3).clamp(150.0, 2000.0);
            let next_ns = at_ns + (pause_ms * 1e6) as i64;
            let next_ns = self.clear_of_blinks(next_ns, self.longest_ns());
            if next_ns + APART_NS >= until_ns {
                return until_ns.max(at_ns + APART_NS);
            }
            // It aims at where the target will be when the saccade ends, about 20 ms ahead.
            let ahead_s = (next_ns - from_ns) as f64 * 1e-9 + 0.02;
            let target = turn(start, axis, speed * ahead_s);
            at_ns = next_ns;
            if angle(self.gaze_at(next_ns), target) > LAG_RAD {
                at_ns = self.jump(next_ns, target, self.last().vergence[1], false);
            }
        }
    }

    fn longest_ns(&self) -> i64 {
        let deg = self.settings.scene.max_amplitude_deg;
        (duration_ms(&self.settings.saccade, deg).min(LONGEST_MS) * 1.3e6) as i64
    }

    /// The time itself, or when the eye can be seen again where lids would cover a movement.
    fn clear_of_blinks(&self, time_ns: i64, length_ns: i64) -> i64 {
        let mut at_ns = time_ns;
        for blink in &self.block.covered {
            if blink.start_ns < at_ns + length_ns && at_ns < blink.end_ns + AFTER_BLINK_NS {
                at_ns = blink.end_ns + AFTER_BLINK_NS;
            }
        }
        at_ns
    }

    /// A saccade from wherever the gaze is; tells when it ends.
    fn jump(&mut self, time_ns: i64, to: DVec3, vergence: f64, micro: bool) -> i64 {
        let saccade = &self.settings.saccade;
        let random = &mut self.random;
        let (spread, bend, swing) = (random.normal_pair(), random.normal(), random.normal());
        let near = angle(self.last().to, to).to_degrees();
        let scale = (spread.x.clamp(-3.0, 3.0) * saccade.duration_sigma).exp();
        let expected_ns = (duration_ms(saccade, near).min(LONGEST_MS) * scale * 1e6) as i64;
        let start_ns = self.clear_of_blinks(time_ns, expected_ns);
        let from = self.gaze_at(start_ns);
        let amplitude_rad = angle(from, to);
        let amplitude_deg = amplitude_rad.to_degrees();
        let length_ms = (duration_ms(saccade, amplitude_deg) * scale).clamp(1.0, LONGEST_MS);
        let swing_deg = (saccade.oscillation_fraction * amplitude_deg).min(saccade.oscillation_max_deg);
        let swing_ms = (saccade.oscillation_ms * (0.2 * swing.clamp(-2.0, 2.0)).exp()).clamp(4.0, 50.0);
        let flight = Flight {
            micro,
            from,
            axis: axis(from, to),
            amplitude_rad,
            bend_rad: bend.clamp(-3.0, 3.0) * saccade.curvature * amplitude_rad,
            length_ns: (length_ms * 1e6) as i64,
            profile: Profile::new(mode(saccade, length_ms), saccade.peak_factor),
            swing_rad: swing_deg.to_radians(),
            swing_ns: (swing_ms * 1e6) as i64,
        };
        let end_ns = start_ns + flight.length_ns;
        let slips = self.settings.head.vor_gain != 1.0;
        let step = Step {
            start_ns,
            way: Way::Saccade(Box::new(flight)),
            to,
            pursuit: None,
            slip_from: slips.then(|| self.head_at(end_ns)),
            vergence: [self.last().vergence_at(start_ns), vergence],
        };
        self.block.steps.push(step);
        end_ns
    }
}
