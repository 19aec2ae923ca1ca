//! A gaze sample as its source told it: never filtered, never guessed. Values that a source does not
//! tell are `None`.
//!
//! Spaces: view space is the head's: right-handed, metres, `-Z` forward, `+Y` up, `+X` to the wearer's
//! right. World space is whatever the head pose refers to, of the same handedness. A point on the
//! display is a fraction of its width and height, x right, y down, (0, 0) the top left corner, and may
//! lie outside 0..1.

use glam::{DQuat, DVec2, DVec3};

/// What one eye, or both together, was found to do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EyeSample {
    /// The source says that the gaze below can be used. False where it says nothing and tells no gaze.
    pub valid: bool,
    /// Where the gaze ray starts, view space, metres.
    pub origin_m: Option<DVec3>,
    /// Direction of the gaze ray, view space; as told, so not always of length 1.
    pub direction: Option<DVec3>,
    /// Where the gaze meets the display, as fractions of it.
    pub point: Option<DVec2>,
    /// How sure the source is, as told; 0 to 1 by convention, but not enforced.
    pub confidence: Option<f64>,
    /// Pupil diameter, mm.
    pub pupil_mm: Option<f64>,
    /// How far the lids are open, 0 closed to 1 open.
    pub openness: Option<f64>,
}

impl EyeSample {
    /// The direction with length 1 if the sample is valid and the direction is finite and not zero.
    #[must_use]
    pub fn usable_direction(&self) -> Option<DVec3> {
        if !self.valid {
            return None;
        }
        self.direction?.try_normalize().filter(|direction| direction.is_finite())
    }
}

/// Where the head is and how it is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeadPose {
    /// Of the head's origin, world space, metres.
    pub position_m: DVec3,
    /// Turns a direction of view space into world space; of length 1.
    pub world_from_view: DQuat,
}

/// One sample of a source.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GazeSample {
    /// The time the source gives, on its own clock ([`crate::source::SourceInfo::device_clock`]),
    /// unwrapped, in ns. `None` where it gives none.
    pub device_time_ns: Option<i64>,
    /// When the host got it, on the host clock ([`crate::source::SourceInfo::host_clock`]), in ns.
    pub received_ns: i64,
    /// When the eye was like this, on the host clock, in ns: the device time as the clock mapping
    /// ([`crate::time::ClockMapper`]) puts it there, or `received_ns` where the source gives no time.
    pub time_ns: i64,
    /// Both eyes together, as the source combines them.
    pub combined: EyeSample,
    /// The left eye.
    pub left: EyeSample,
    /// The right eye.
    pub right: EyeSample,
    /// The head at the same time, where the source knows it.
    pub head: Option<HeadPose>,
}

impl GazeSample {
    /// A sample at a time on one clock for all, with nothing else known.
    #[must_use]
    pub fn at(time_ns: i64) -> Self {
        Self { device_time_ns: Some(time_ns), received_ns: time_ns, time_ns, ..Self::default() }
    }

    /// The direction of the combined gaze; the mean of the two eyes where the source does not combine
    /// them, or the only eye that can be used. The flag says whether just one eye went into it.
    #[must_use]
    pub fn gaze_direction(&self) -> Option<(DVec3, bool)> {
        if let Some(direction) = self.combined.usable_direction() {
            return Some((direction, false));
        }
        match (self.left.usable_direction(), self.right.usable_direction()) {
            (Some(left), Some(right)) => (left + right).try_normalize().map(|mean| (mean, false)),
            (Some(only), None) | (None, Some(only)) => Some((only, true)),
            (None, None) => None,
        }
    }

    /// The combined point on the display, or what the eyes tell of it, as in [`Self::gaze_direction`].
    #[must_use]
    pub fn gaze_point(&self) -> Option<DVec2> {
        let usable = |eye: &EyeSample| eye.point.filter(|point| eye.valid && point.is_finite());
        usable(&self.combined).or_else(|| match (usable(&self.left), usable(&self.right)) {
            (Some(left), Some(right)) => Some((left + right) * 0.5),
            (only, None) | (None, only) => only,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn looking(direction: DVec3) -> EyeSample {
        EyeSample { valid: true, direction: Some(direction), ..EyeSample::default() }
    }

    #[test]
    fn one_eye_stands_in_for_two_and_says_so() {
        let mut sample = GazeSample { left: looking(DVec3::new(0.0, 0.0, -2.0)), ..GazeSample::at(5) };
        assert_eq!(sample.gaze_direction(), Some((DVec3::NEG_Z, true)));
        sample.right = looking(DVec3::new(1.0, 0.0, -1.0));
        let (mean, single) = sample.gaze_direction().expect("two eyes");
        let expected = DVec3::new((22.5f64).to_radians().sin(), 0.0, -(22.5f64).to_radians().cos());
        assert!(mean.abs_diff_eq(expected, 1e-15) && !single);
        sample.combined = looking(DVec3::NEG_Y);
        assert_eq!(sample.gaze_direction(), Some((DVec3::NEG_Y, false)));
    }

    #[test]
    fn what_is_invalid_zero_or_not_finite_is_not_used() {
        let bad = [DVec3::ZERO, DVec3::NAN, DVec3::new(f64::INFINITY, 0.0, 0.0)];
        for direction in bad {
            assert_eq!(
                GazeSample { combined: looking(direction), ..GazeSample::at(0) }.gaze_direction(),
                None
            );
        }
        let closed = EyeSample { valid: false, ..looking(DVec3::NEG_Z) };
        assert_eq!(GazeSample { left: closed, ..GazeSample::at(0) }.gaze_direction(), None);
    }

    #[test]
    fn points_of_the_eyes_are_averaged() {
        let at = |x| EyeSample { valid: true, point: Some(DVec2::new(x, 0.5)), ..EyeSample::default() };
        let sample = GazeSample { left: at(0.25), right: at(0.75), ..GazeSample::at(0) };
        assert_eq!(sample.gaze_point(), Some(DVec2::splat(0.5)));
        let sample = GazeSample { left: at(f64::NAN), right: at(0.75), ..GazeSample::at(0) };
        assert_eq!(sample.gaze_point(), Some(DVec2::new(0.75, 0.5)));
    }
}
