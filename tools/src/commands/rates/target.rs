//! What shading rate is called for: by the eye and by the display.

use super::summary::Direction;
use glam::DVec2;
use macula::fovea::{AcuityModel, DisplayGeometry, Mapping};
use serde::Serialize;

/// How finely the eye and the display resolve at one place in one direction, cycles per degree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Limits {
    /// The eye.
    pub acuity_cpd: f64,
    /// The display: half its pixels per degree.
    pub display_cpd: f64,
    /// The smaller of the two: a finer rate shows nothing more.
    pub target_cpd: f64,
}

impl Limits {
    /// The sum of both, value by value.
    pub fn plus(self, other: Self) -> Self {
        Self {
            acuity_cpd: self.acuity_cpd + other.acuity_cpd,
            display_cpd: self.display_cpd + other.display_cpd,
            target_cpd: self.target_cpd + other.target_cpd,
        }
    }

    /// Value by value over a number above 0.
    pub fn over(self, number: f64) -> Self {
        Self {
            acuity_cpd: self.acuity_cpd / number,
            display_cpd: self.display_cpd / number,
            target_cpd: self.target_cpd / number,
        }
    }
}

/// An acuity model before a display.
pub struct Target<'a> {
    display: DisplayGeometry,
    gaze_px: DVec2,
    acuity: &'a AcuityModel,
}

impl<'a> Target<'a> {
    /// For a mapping's display and gaze.
    pub fn new(mapping: &dyn Mapping, acuity: &'a AcuityModel) -> Self {
        Self { display: *mapping.display(), gaze_px: mapping.gaze_px(), acuity }
    }

    /// The limits at a position that lies at this eccentricity; `None` at the gaze.
    pub fn limits(&self, ecc_deg: f64, px: DVec2, direction: Direction) -> Option<Limits> {
        let (radial, tangential) = self.display.steps_per_degree(self.gaze_px, px)?;
        let (step_px, ratio) = match direction {
            Direction::Radial => (radial, 1.0),
            Direction::Tangential => (tangential, self.acuity.delta(ecc_deg)),
        };
        let (acuity_cpd, display_cpd) = (self.acuity.cpd(ecc_deg) * ratio, step_px.length() / 2.0);
        Some(Limits { acuity_cpd, display_cpd, target_cpd: acuity_cpd.min(display_cpd) })
    }
}
