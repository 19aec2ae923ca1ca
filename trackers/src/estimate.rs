//! The answer to "where will the eye look when this picture is displayed?".

use glam::DVec3;

/// How an estimate came about. A renderer trusts the kinds in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EstimateKind {
    /// A sample of the tracker taken at the asked time.
    Measured,
    /// Between two samples around the asked time.
    Interpolated,
    /// Ahead of the newest sample.
    Predicted,
    /// The last valid sample, kept because nothing newer is usable.
    Held,
    /// The source has stopped telling anything new.
    Stale,
}

/// What the eye does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum EyeState {
    /// At rest on one place of the world.
    Fixation,
    /// Jumping to another place.
    Saccade,
    /// Following something that moves.
    Pursuit,
    /// The lids are closed.
    Blink,
    /// The tracker does not see the eye.
    Lost,
    /// Nothing is known yet.
    #[default]
    Unknown,
}

impl EyeState {
    /// The name in reports and JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fixation => "fixation",
            Self::Saccade => "saccade",
            Self::Pursuit => "pursuit",
            Self::Blink => "blink",
            Self::Lost => "lost",
            Self::Unknown => "unknown",
        }
    }
}

/// Where the eye looks at one display time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GazeEstimate {
    /// Gaze direction in view space: right-handed, `-Z` forward, `+Y` up. Need not be of length 1.
    pub direction_view: DVec3,
    /// Radius of the cone in which the true gaze lies, in radians, at one standard deviation. Doubt
    /// makes it larger, never smaller.
    pub error_radius_rad: f64,
    /// How the estimate was made.
    pub kind: EstimateKind,
    /// Display time less the time of the newest sample that went into it, in nanoseconds.
    pub age_ns: i64,
    /// What the eye is thought to do at the display time.
    pub eye_state: EyeState,
}

impl GazeEstimate {
    /// The direction with length 1, or `None` where it is zero, not finite, or behind the eye
    /// (then there is no point of the display that it could mean).
    #[must_use]
    pub fn unit_direction(&self) -> Option<DVec3> {
        let direction = self.direction_view.try_normalize()?;
        (direction.is_finite() && direction.z < 0.0).then_some(direction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(direction_view: DVec3) -> GazeEstimate {
        GazeEstimate {
            direction_view,
            error_radius_rad: 0.01,
            kind: EstimateKind::Measured,
            age_ns: 0,
            eye_state: EyeState::Fixation,
        }
    }

    #[test]
    fn unusable_directions_are_refused() {
        for bad in [DVec3::ZERO, DVec3::NAN, DVec3::new(f64::INFINITY, 0.0, -1.0), DVec3::Z, DVec3::X] {
            assert_eq!(estimate(bad).unit_direction(), None, "{bad}");
        }
        let direction = estimate(DVec3::new(3.0, 0.0, -4.0)).unit_direction();
        assert!(direction.is_some_and(|unit| unit.abs_diff_eq(DVec3::new(0.6, 0.0, -0.8), 1e-15)));
    }
}
