//! What the eye really did, as an expert would label it.

use crate::estimate::EyeState;
use glam::DVec3;

/// The name of the column of labels in a recording of a synthetic eye; values are
/// [`TruthKind::code`].
pub const TRUTH_COLUMN: &str = "evt_truth";
/// The names of the columns of the true direction, view space.
pub const DIRECTION_COLUMNS: [&str; 3] = ["true_direction_x", "true_direction_y", "true_direction_z"];

/// What the eye did, or why the tracker could not see it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TruthKind {
    /// At rest.
    Fixation,
    /// A jump to another place.
    Saccade,
    /// The pupil swings after a saccade, as far as the tracker shows it. The eye is at rest.
    Oscillation,
    /// Following what moves.
    Pursuit,
    /// The lids cover the pupil.
    Blink,
    /// The tracker sees neither eye.
    Lost,
    /// A small jump within a fixation.
    Microsaccade,
}

impl TruthKind {
    /// The number in the column of labels: 1 to 5 as in the hand-labelled recordings of Zemblys et al.
    /// (2018), where 0 would be "undefined"; then lost and microsaccade.
    #[must_use]
    pub fn code(self) -> u8 {
        match self {
            Self::Fixation => 1,
            Self::Saccade => 2,
            Self::Oscillation => 3,
            Self::Pursuit => 4,
            Self::Blink => 5,
            Self::Lost => 6,
            Self::Microsaccade => 7,
        }
    }

    /// The kind with a number; `None` where there is none.
    #[must_use]
    pub fn from_code(code: u8) -> Option<Self> {
        let all = [
            Self::Fixation,
            Self::Saccade,
            Self::Oscillation,
            Self::Pursuit,
            Self::Blink,
            Self::Lost,
            Self::Microsaccade,
        ];
        all.into_iter().find(|kind| kind.code() == code)
    }

    /// The state of the eye that it is.
    #[must_use]
    pub fn state(self) -> EyeState {
        match self {
            Self::Fixation | Self::Oscillation => EyeState::Fixation,
            Self::Saccade | Self::Microsaccade => EyeState::Saccade,
            Self::Pursuit => EyeState::Pursuit,
            Self::Blink => EyeState::Blink,
            Self::Lost => EyeState::Lost,
        }
    }
}

/// A labelled stretch of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruthEvent {
    /// What it is.
    pub kind: TruthKind,
    /// Its start, time of the eye, ns.
    pub start_ns: i64,
    /// Its end (the first instant that no longer belongs to it), ns.
    pub end_ns: i64,
    /// Between the planned gaze directions in the world at its start and its end, degrees; without
    /// drift and tremor.
    pub amplitude_deg: f64,
    /// Peak speed of the saccade, or the speed of pursuit, of which it is a part, deg/s; else 0.
    pub peak_deg_s: f64,
}

/// The truth of a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Truth {
    /// Every instant from the start to the end belongs to one event; in order.
    pub events: Vec<TruthEvent>,
    /// The true direction of the combined gaze, view space, for each sample of the recording.
    pub directions: Vec<DVec3>,
}
