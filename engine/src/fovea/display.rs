//! The display as the eye sees it: pixels, and the rays through them.

use crate::error::{Error, Result};
use glam::{DVec2, DVec3};

/// A flat display: its pixels and the frustum through its edges.
///
/// Display pixels have x to the right, y down, centres at .5. View space is right-handed, `-Z`
/// forward, `+Y` up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplayGeometry {
    /// Width and height, px.
    pub size_px: [u32; 2],
    /// Tangents of the half angles to the left, right, upper and lower edge; the left and the lower
    /// one are negative in a frustum that holds the view axis (as in OpenXR's `XrFovf`).
    pub tan_left: f64,
    /// See `tan_left`.
    pub tan_right: f64,
    /// See `tan_left`.
    pub tan_up: f64,
    /// See `tan_left`.
    pub tan_down: f64,
}

impl DisplayGeometry {
    /// Square pixels with the view axis through the display's centre.
    #[must_use]
    pub fn symmetric(size_px: [u32; 2], hfov_deg: f64) -> Self {
        let tan_right = (hfov_deg.to_radians() / 2.0).tan();
        let tan_up = tan_right * f64::from(size_px[1]) / f64::from(size_px[0]);
        Self { size_px, tan_left: -tan_right, tan_right, tan_up, tan_down: -tan_up }
    }

    /// Checks size and frustum.
    ///
    /// # Errors
    /// [`Error::Setting`] for a size of 0 or a frustum that is empty or not finite.
    pub fn check(&self) -> Result<()> {
        let [width, height] = self.size_px;
        if width == 0 || height == 0 {
            return Err(Error::Setting(format!(
                "the display is {width}x{height} px; both must be at least 1"
            )));
        }
        let edges = [self.tan_left, self.tan_right, self.tan_up, self.tan_down];
        let in_range = edges.iter().all(|edge| edge.is_finite() && edge.abs() < 1e3);
        if !in_range || self.tan_left >= self.tan_right || self.tan_down >= self.tan_up {
            return Err(Error::Setting(
                "the field of view is out of range; it must lie above 0 and below 179 degrees".into(),
            ));
        }
        Ok(())
    }

    /// Direction (not of length 1; z is -1) of the ray through a display position.
    #[must_use]
    pub fn ray_of_px(&self, px: DVec2) -> DVec3 {
        let x = px.x / f64::from(self.size_px[0]);
        let y = px.y / f64::from(self.size_px[1]);
        DVec3::new(
            self.tan_left + (self.tan_right - self.tan_left) * x,
            self.tan_up + (self.tan_down - self.tan_up) * y,
            -1.0,
        )
    }

    /// The display position at which a ray from the eye meets the display's plane; the inverse of
    /// [`Self::ray_of_px`]. The ray's length does not matter, and the position may lie off the
    /// display. `None` for a ray that runs along the plane or away from it, or so nearly along it
    /// that the position overflows.
    #[must_use]
    pub fn px_of_ray(&self, ray: DVec3) -> Option<DVec2> {
        let ahead = -ray.z;
        if ahead.is_nan() || ahead <= 0.0 {
            return None;
        }
        let share = DVec2::new(
            (ray.x / ahead - self.tan_left) / (self.tan_right - self.tan_left),
            (ray.y / ahead - self.tan_up) / (self.tan_down - self.tan_up),
        );
        let px = share * self.size_dvec2_px();
        px.is_finite().then_some(px)
    }

    /// Angle between the rays through two display positions, rad, in `0..=pi`.
    ///
    /// From the tangent of the half-plane pair (cross and dot product), which keeps its relative
    /// precision at angles near 0, where the arc cosine of a dot product loses half of its digits.
    #[must_use]
    pub fn eccentricity_rad(&self, gaze_px: DVec2, px: DVec2) -> f64 {
        let (gaze, ray) = (self.ray_of_px(gaze_px), self.ray_of_px(px));
        // The cross product with the *difference* of the rays: that difference comes from the
        // pixels' difference, so that neighbours do not cancel.
        let step = (px - gaze_px) / self.size_dvec2_px();
        let difference = DVec3::new(
            (self.tan_right - self.tan_left) * step.x,
            (self.tan_down - self.tan_up) * step.y,
            0.0,
        );
        gaze.cross(difference).length().atan2(gaze.dot(ray))
    }

    /// Display steps, px, of one degree away from the gaze along the great circle through it, and of
    /// one degree across that circle, both to first order. `None` at the gaze itself.
    #[must_use]
    pub fn steps_per_degree(&self, gaze_px: DVec2, px: DVec2) -> Option<(DVec2, DVec2)> {
        let (gaze, ray) = (self.ray_of_px(gaze_px).normalize(), self.ray_of_px(px));
        let across = gaze.cross(ray).normalize_or_zero();
        if across == DVec3::ZERO {
            return None;
        }
        let outward = across.cross(ray).normalize();
        // A turn by a small angle moves the ray's end by its length; the display's plane is z = -1.
        let step = |direction: DVec3| {
            let moved = direction * (ray.length() * 1f64.to_radians());
            let on_plane = moved + ray * moved.z;
            DVec2::new(
                on_plane.x / (self.tan_right - self.tan_left),
                on_plane.y / (self.tan_down - self.tan_up),
            ) * self.size_dvec2_px()
        };
        Some((step(outward), step(across)))
    }

    /// Distance from a position to the corner of the display farthest from it, px. The position may
    /// lie off the display.
    #[must_use]
    pub fn farthest_corner_px(&self, gaze_px: DVec2) -> f64 {
        farthest_corner_px(self.size_px, gaze_px)
    }

    /// The display's centre, px.
    #[must_use]
    pub fn center_px(&self) -> DVec2 {
        self.size_dvec2_px() / 2.0
    }

    /// Width and height of a pixel on the plane at distance 1.
    #[must_use]
    pub fn tangents_per_px(&self) -> DVec2 {
        DVec2::new(self.tan_right - self.tan_left, self.tan_up - self.tan_down) / self.size_dvec2_px()
    }

    /// Pixels per steradian at a ray of [`Self::ray_of_px`] of this length: a pixel's solid angle falls
    /// with the cube of the distance.
    #[must_use]
    pub fn pixels_per_steradian(&self, ray_length: f64) -> f64 {
        let pixel = self.tangents_per_px();
        ray_length.powi(3) / (pixel.x * pixel.y)
    }

    fn size_dvec2_px(&self) -> DVec2 {
        size_dvec2_px(self.size_px)
    }
}

/// Width and height as a vector, px.
pub(super) fn size_dvec2_px(size_px: [u32; 2]) -> DVec2 {
    DVec2::new(f64::from(size_px[0]), f64::from(size_px[1]))
}

/// Distance from a position to the farthest corner of a display, px.
pub(super) fn farthest_corner_px(size_px: [u32; 2], gaze_px: DVec2) -> f64 {
    let reach = gaze_px.abs().max((size_dvec2_px(size_px) - gaze_px).abs());
    reach.x.hypot(reach.y)
}
