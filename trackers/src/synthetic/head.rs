//! How the head moves: it follows wide gaze shifts, sways, and shakes if asked to.

use super::random::{Lattice, stream};
use super::saccade::minimum_jerk;
use super::settings::HeadSettings;
use crate::sample::HeadPose;
use glam::{DQuat, DVec2, DVec3};
use std::f64::consts::TAU;

/// Lattice steps of sway, slow and slower, ns.
const SWAY_NS: [i64; 2] = [1_700_000_000, 4_300_000_000];
/// Time that a turn of the head takes, ms, and what each degree adds: more makes a lazier head. 30 degrees
/// peak at about 100 deg/s.
const TURN_MS: f64 = 250.0;
const TURN_MS_PER_DEG: f64 = 10.0;
/// The head starts this much later than the eyes, ns.
const LAG_NS: i64 = 20_000_000;

/// A turn of the head, in the block's own time.
#[derive(Clone, Copy, Debug)]
struct Turn {
    start_ns: i64,
    length_ns: i64,
    /// To the right and up.
    by_deg: DVec2,
    /// Where all turns up to this one lead together.
    total_deg: DVec2,
}

/// The turns with which the head follows the gaze in one block of time.
#[derive(Clone, Debug)]
pub(super) struct Turns {
    base_deg: DVec2,
    turns: Vec<Turn>,
    longest_ns: i64,
}

impl Turns {
    pub(super) fn new(base_deg: DVec2) -> Self {
        Self { base_deg, turns: Vec::new(), longest_ns: 0 }
    }

    /// Where all turns lead, yaw and pitch, degrees.
    pub(super) fn end_deg(&self) -> DVec2 {
        self.turns.last().map_or(self.base_deg, |turn| turn.total_deg)
    }

    /// Turns the head to a place, from `time_ns` on and done by `until_ns`. Turns add up where they
    /// overlap.
    pub(super) fn turn_to(&mut self, place_deg: DVec2, time_ns: i64, until_ns: i64) {
        let by_deg = place_deg - self.end_deg();
        if by_deg == DVec2::ZERO {
            return;
        }
        let wished_ns = ((TURN_MS + TURN_MS_PER_DEG * by_deg.length()) * 1e6) as i64;
        let start_ns = (time_ns + LAG_NS).min(until_ns - 1);
        let length_ns = wished_ns.min(until_ns - start_ns);
        self.longest_ns = self.longest_ns.max(length_ns);
        self.turns.push(Turn { start_ns, length_ns, by_deg, total_deg: place_deg });
    }

    /// Yaw and pitch at a time of the block, degrees.
    pub(super) fn at_deg(&self, time_ns: i64) -> DVec2 {
        let begun = self.turns.partition_point(|turn| turn.start_ns <= time_ns);
        let begun = &self.turns[..begun];
        let end_deg = begun.last().map_or(self.base_deg, |turn| turn.total_deg);
        let running = begun.iter().rev().take_while(|turn| time_ns - turn.start_ns < self.longest_ns);
        let missing: DVec2 = running
            .map(|turn| {
                let along = (time_ns - turn.start_ns) as f64 / turn.length_ns as f64;
                turn.by_deg * (1.0 - minimum_jerk(along))
            })
            .sum();
        end_deg - missing
    }
}

/// Where the head turns for a gaze at `place_deg` when it would otherwise stay at `head_deg`.
pub(super) fn follow(settings: &HeadSettings, head_deg: DVec2, place_deg: DVec2) -> DVec2 {
    let off_deg = place_deg - head_deg;
    let beyond_deg = off_deg.length() - settings.dead_zone_deg;
    if beyond_deg <= 0.0 {
        return head_deg;
    }
    head_deg + off_deg.normalize_or_zero() * (beyond_deg * settings.follow_gain)
}

/// What the head does by itself, as a function of time.
#[derive(Clone, Debug)]
pub(super) struct Sway {
    settings: HeadSettings,
    turn: [Lattice; 2],
    shift: [Lattice; 2],
    other: Lattice,
}

impl Sway {
    pub(super) fn new(settings: &HeadSettings, key: u64) -> Self {
        let noise = |stream, index: usize| Lattice::new(key, stream, SWAY_NS[index]);
        let turn = std::array::from_fn(|index| noise(stream::SWAY + 1000, index));
        let shift = std::array::from_fn(|index| noise(stream::SWAY + 2000, index));
        Self { settings: settings.clone(), turn, shift, other: noise(stream::SWAY, 1) }
    }

    /// The pose at a time, with the turns that follow the gaze.
    pub(super) fn pose(&self, time_ns: i64, follow_deg: DVec2) -> HeadPose {
        let mut angles_deg = follow_deg.extend(0.0);
        let mut position_m = DVec3::ZERO;
        let pair = |noise: &[Lattice; 2]| (noise[0].at(time_ns) + noise[1].at(time_ns)) * 0.5_f64.sqrt();
        // Roll and distance sway less than what turning and stepping do.
        if self.settings.sway_deg > 0.0 {
            let roll = self.other.at(time_ns).x * 0.5;
            angles_deg += pair(&self.turn).extend(roll) * self.settings.sway_deg;
        }
        if self.settings.sway_mm > 0.0 {
            let depth = self.other.at(time_ns).y * 0.5;
            position_m = pair(&self.shift).extend(depth) * (self.settings.sway_mm * 1e-3);
        }
        if self.settings.shake_deg > 0.0 {
            let phase = TAU * self.settings.shake_hz * (time_ns as f64 * 1e-9);
            angles_deg.x += self.settings.shake_deg * phase.sin();
        }
        HeadPose { position_m, world_from_view: rotation(angles_deg) }
    }
}

/// Yaw to the right, then pitch up, then roll counter-clockwise, degrees.
fn rotation(angles_deg: DVec3) -> DQuat {
    if angles_deg == DVec3::ZERO {
        return DQuat::IDENTITY;
    }
    let rad = angles_deg * 1.0_f64.to_radians();
    DQuat::from_rotation_y(-rad.x) * DQuat::from_rotation_x(rad.y) * DQuat::from_rotation_z(rad.z)
}
