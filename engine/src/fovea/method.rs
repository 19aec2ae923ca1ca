//! What the methods have in common: the gaze in use, the planar polar coordinates about it, and
//! LP-buffers of the display's size over a factor.

use super::display::{DisplayGeometry, size_dvec2_px};
use super::mapping::{ColumnLayout, TexelJacobian};
use super::params::clamp_gaze_px;
use crate::error::{Error, Result};
use glam::DVec2;
use std::f64::consts::TAU;

/// The least distance to the farthest corner, px, so that its logarithm stays away from 0 on a display
/// of a single pixel.
const LEAST_REACH_PX: f64 = 2.0;

/// The gaze that a mapping works with: the given one, at most [`super::MAX_GAZE_PX`] away, and the
/// display's centre for one that is not finite.
pub(super) fn gaze_in_use_px(size_px: [u32; 2], gaze_px: DVec2) -> DVec2 {
    if gaze_px.is_finite() { clamp_gaze_px(gaze_px) } else { size_dvec2_px(size_px) / 2.0 }
}

/// Distance from the gaze to the display's farthest corner, px; 2 where it is less.
pub(super) fn reach_px(display: &DisplayGeometry, gaze_px: DVec2) -> f64 {
    display.farthest_corner_px(gaze_px).max(LEAST_REACH_PX)
}

/// Tangent of the visual angle per pixel, counted from the view axis: the `c_r` of Zhang et al. 2025,
/// Eq. 3, who take it from the display's height.
pub(super) fn tangent_per_px(display: &DisplayGeometry) -> f64 {
    // The quotient of a frustum that is all but closed underflows.
    ((display.tan_up - display.tan_down) / f64::from(display.size_px[1])).max(f64::MIN_POSITIVE)
}

/// Columns of equal height for a display's size over `delta`, rounded, at least 1x1.
pub(super) fn reduced_columns(size_px: [u32; 2], delta: f64) -> ColumnLayout {
    // The cast saturates, so that a tiny delta does not wrap around.
    let [width, height] = size_px.map(|pixels| ((f64::from(pixels) / delta).round() as u32).max(1));
    ColumnLayout::new(vec![height; width as usize])
}

/// Clamps a share to what [`super::LpPoint::v_share`] allows: from 0 to below 1.
pub(super) fn below_one(share: f64) -> f64 {
    share.clamp(0.0, 1.0_f64.next_down())
}

/// An error unless a parameter lies within its range; NaN never does.
pub(super) fn within(name: &str, value: f64, low: f64, high: f64) -> Result<()> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(Error::Setting(format!("{name} is {value}; it must lie between {low} and {high}")))
}

/// A display position seen from the gaze.
#[derive(Clone, Copy, Debug)]
pub(super) struct PolarOffset {
    offset_px: DVec2,
    /// Distance from the gaze, px.
    pub radius_px: f64,
}

impl PolarOffset {
    pub fn new(gaze_px: DVec2, px: DVec2) -> Self {
        let offset_px = px - gaze_px;
        Self { offset_px, radius_px: offset_px.x.hypot(offset_px.y) }
    }

    /// Azimuth about the gaze as a share of a turn, from 0 to below 1.
    pub fn v_share(&self) -> f64 {
        // An angle just below 0 becomes a full turn when it is rounded.
        let share = self.offset_px.y.atan2(self.offset_px.x).rem_euclid(TAU) / TAU;
        if share < 1.0 { share } else { 0.0 }
    }

    /// The Jacobian from `du/dr` (texels per px) and the column's height (texels); `None` at the gaze.
    pub fn jacobian(&self, du_dr: f64, height: f64) -> Option<TexelJacobian> {
        if self.radius_px < f64::MIN_POSITIVE {
            return None;
        }
        let outward = self.offset_px / self.radius_px;
        let dv_ds = height / (TAU * self.radius_px);
        Some(TexelJacobian {
            du_dx: du_dr * outward.x,
            du_dy: du_dr * outward.y,
            dv_dx: -dv_ds * outward.y,
            dv_dy: dv_ds * outward.x,
        })
    }
}

/// The display position at a distance and an azimuth (a share of a turn) from the gaze, px.
pub(super) fn on_circle(gaze_px: DVec2, radius_px: f64, v_share: f64) -> DVec2 {
    gaze_px + DVec2::from_angle(TAU * v_share) * radius_px
}
