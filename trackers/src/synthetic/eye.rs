//! The true eye, in continuous time.

use super::blink::{Span, openness, span_at};
use super::build::build;
use super::fixation::FixationalMotion;
use super::geometry::deflect;
use super::head::Sway;
use super::random::{Lattice, stream};
use super::scene::{BLOCK_NS, Block};
use super::settings::SyntheticSettings;
use super::truth::{TruthEvent, TruthKind};
use crate::error::{Error, Result};
use crate::estimate::EyeState;
use crate::sample::HeadPose;
use glam::{DVec2, DVec3};

/// Lattice step of the pupil's slow changes, ns (hippus, below 1 Hz).
const PUPIL_NS: i64 = 900_000_000;
/// Longest time for which labels are told at once, ns.
const MAX_EVENTS_NS: i64 = 3_600_000_000_000_000;
/// Bounds of a pupil's diameter, mm.
const PUPIL_MM: [f64; 2] = [1.0, 9.5];

/// The true state of the eyes at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueEye {
    /// What an expert would call it.
    pub kind: TruthKind,
    /// The same as a state.
    pub state: EyeState,
    /// Combined gaze from between the eyes, view space, of length 1.
    pub direction: DVec3,
    /// Gaze of the left eye, view space, of length 1.
    pub left: DVec3,
    /// Gaze of the right eye, view space, of length 1.
    pub right: DVec3,
    /// Centre of the left eye, view space, m; the right one is mirrored.
    pub left_origin_m: DVec3,
    /// Distance at which the eyes converge, m.
    pub depth_m: f64,
    /// Combined gaze in the world, of length 1.
    pub direction_world: DVec3,
    /// The head.
    pub head: HeadPose,
    /// How far the lids are open, 0 to 1.
    pub openness: f64,
    /// Diameter of the pupil, mm.
    pub pupil_mm: f64,
    /// Displacement of the pupil against the eyeball, view space, rad: what a pupil-based tracker takes
    /// for a turn of the eye.
    pub pupil_swing: DVec3,
}

/// An eye whose whole life follows from a seed. It is a function of time alone: whoever asks, in whatever
/// order and however often, gets the same answer.
#[derive(Clone, Debug)]
pub struct EyeModel {
    settings: SyntheticSettings,
    key: u64,
    fixational: FixationalMotion,
    sway: Sway,
    pupil: Lattice,
    /// The block of time that was asked for last.
    block: Block,
}

impl EyeModel {
    /// An eye.
    ///
    /// # Errors
    /// [`crate::Error::Setting`] for a setting out of its range.
    pub fn new(settings: &SyntheticSettings, seed: u64) -> Result<Self> {
        settings.check()?;
        let sway = Sway::new(&settings.head, seed);
        Ok(Self {
            settings: settings.clone(),
            key: seed,
            fixational: FixationalMotion::new(&settings.fixation, seed),
            pupil: Lattice::new(seed, stream::PUPIL, PUPIL_NS),
            block: build(settings, seed, &sway, 0),
            sway,
        })
    }

    /// What it was made with.
    #[must_use]
    pub fn settings(&self) -> &SyntheticSettings {
        &self.settings
    }

    /// Makes the block of a time the current one, and tells the time within it.
    fn enter(&mut self, time_ns: i64) -> i64 {
        let index = time_ns.div_euclid(BLOCK_NS);
        if self.block.index != index {
            self.block = build(&self.settings, self.key, &self.sway, index);
        }
        time_ns.rem_euclid(BLOCK_NS)
    }

    /// The head at a time of the current block.
    fn head(&self, time_ns: i64, local_ns: i64) -> HeadPose {
        self.sway.pose(time_ns, self.block.turns.at_deg(local_ns))
    }

    /// The planned gaze in the world at a time of the current block.
    fn planned(&self, local_ns: i64, head: &HeadPose) -> DVec3 {
        let gain = self.settings.head.vor_gain;
        let step = self.block.step_at(local_ns);
        step.map_or(DVec3::NEG_Z, |step| step.gaze(local_ns, head.world_from_view, gain))
    }

    /// The state at a time of the eye, ns; any time can be asked for.
    #[must_use]
    pub fn state_at(&mut self, time_ns: i64) -> TrueEye {
        let local_ns = self.enter(time_ns);
        let head = self.head(time_ns, local_ns);
        let view_from_world = head.world_from_view.inverse();
        let planned = view_from_world * self.planned(local_ns, &head);
        let openness = span_at(&self.block.blinks, local_ns).map_or(1.0, |span| openness(span, local_ns));
        let dip_deg = DVec2::new(0.0, -self.settings.blink.dip_deg * (1.0 - openness));
        let direction = deflect(planned, self.fixational.at_deg(time_ns) + dip_deg);
        let (swing, vergence) = self
            .block
            .step_at(local_ns)
            .map_or((DVec3::ZERO, 0.0), |step| (step.swing(local_ns), step.vergence_at(local_ns)));
        let (kind, _) = self.block.kind_at(local_ns, self.settings.tracker.pupil_based);
        let left_origin_m = DVec3::new(-self.settings.eyes.ipd_mm * 0.5e-3, 0.0, 0.0);
        let pupil_mm =
            self.settings.eyes.pupil_mm + self.settings.eyes.pupil_sigma_mm * self.pupil.at(time_ns).x;
        TrueEye {
            kind,
            state: kind.state(),
            direction,
            // Over the depth, so that no depth is too far.
            left: (direction - left_origin_m * vergence).normalize_or(direction),
            right: (direction + left_origin_m * vergence).normalize_or(direction),
            left_origin_m,
            depth_m: 1.0 / vergence,
            direction_world: head.world_from_view * direction,
            head,
            openness,
            pupil_mm: pupil_mm.clamp(PUPIL_MM[0], PUPIL_MM[1]),
            pupil_swing: view_from_world * swing,
        }
    }

    /// Whether the tracker does not see the left or the right eye at a time, by lids or by loss.
    pub(super) fn unseen_at(&mut self, time_ns: i64) -> [bool; 2] {
        let local_ns = self.enter(time_ns);
        let covered = span_at(&self.block.covered, local_ns).is_some();
        self.block.losses.at(local_ns).map(|lost| covered || lost)
    }

    /// The labelled events from one time to another. What reaches beyond is cut off there.
    ///
    /// # Errors
    /// [`Error::Setting`] for more than a thousand hours.
    pub fn events(&mut self, from_ns: i64, to_ns: i64) -> Result<Vec<TruthEvent>> {
        if to_ns.saturating_sub(from_ns) > MAX_EVENTS_NS {
            return Err(Error::Setting("labels for more than 1000 h were asked for; ask for less".into()));
        }
        let oscillates = self.settings.tracker.pupil_based;
        let mut events: Vec<TruthEvent> = Vec::new();
        let mut at_ns = from_ns;
        while at_ns < to_ns {
            let start_ns = self.enter(at_ns);
            let length_ns = (BLOCK_NS - start_ns).min(to_ns.saturating_sub(at_ns));
            let within = Span { start_ns, end_ns: start_ns + length_ns };
            let zero_ns = at_ns.wrapping_sub(start_ns);
            let gaze = |local_ns: i64| {
                let head = self.head(zero_ns.wrapping_add(local_ns), local_ns);
                self.planned(local_ns, &head)
            };
            for mut event in self.block.events(within, oscillates, gaze) {
                event.start_ns = zero_ns.wrapping_add(event.start_ns);
                event.end_ns = zero_ns.wrapping_add(event.end_ns);
                match events.last_mut() {
                    // A rest or a loss goes on over the seam of two blocks.
                    Some(last) if last.kind == event.kind && event.peak_deg_s == 0.0 => {
                        last.end_ns = event.end_ns;
                        last.amplitude_deg = last.amplitude_deg.max(event.amplitude_deg);
                    }
                    _ => events.push(event),
                }
            }
            at_ns = at_ns.saturating_add(length_ns);
        }
        Ok(events)
    }
}
