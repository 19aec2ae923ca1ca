//! The display seen from the gaze: a projection between display pixels and directions about the gaze
//! ray, in which eccentricity is the angle to the third axis and azimuth the angle about it.

use super::display::{DisplayGeometry, size_dvec2_px};
use super::method::gaze_in_use_px;
use glam::{DMat3, DVec2, DVec3};

/// Coordinates of rays in a frame whose third axis is the gaze ray. The first axis is the display's +x
/// projected onto the plane across the gaze, the second one points to the display's +y (down).
///
/// Works on offsets from the display position nearest to the gaze. For a gaze on the display that is
/// the gaze itself, so that nothing cancels around it; for one far away single precision is not spent
/// on the way there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GazeFrame {
    gaze_px: DVec2,
    base_px: DVec2,
    /// Frame ray from `(px - base_px, 1)`.
    ray_from_offset: DMat3,
    /// Its inverse, up to the ray's length.
    offset_from_ray: DMat3,
}

impl GazeFrame {
    /// The frame around the gaze ray: eccentricities are true angles.
    ///
    /// A gaze farther than [`super::MAX_GAZE_PX`] is clamped, and one that is not finite is taken as the
    /// display's centre.
    #[must_use]
    pub fn on_sphere(display: &DisplayGeometry, gaze_px: DVec2) -> Self {
        let gaze_px = gaze_in_use_px(display.size_px, gaze_px);
        let forward = display.ray_of_px(gaze_px).normalize();
        let right = (DVec3::X - forward * forward.x).normalize();
        // Right-handed view space with +Y up: forward x right points down.
        let down = forward.cross(right);
        let frame_from_view = DMat3::from_cols(right, down, forward).transpose();
        let per_px = display.tangents_per_px();
        let base_px = base_px(display, gaze_px);
        let to_base = (base_px - gaze_px) * per_px * DVec2::new(1.0, -1.0);
        let gaze_length = display.ray_of_px(gaze_px).length();
        // The gaze ray is the third axis by construction: only the way to the base is rotated.
        let base = DVec3::Z * gaze_length + frame_from_view * to_base.extend(0.0);
        let ray_from_offset = DMat3::from_cols(
            frame_from_view * DVec3::X * per_px.x,
            frame_from_view * DVec3::NEG_Y * per_px.y,
            base,
        );
        Self { gaze_px, base_px, ray_from_offset, offset_from_ray: ray_from_offset.inverse() }
    }

    /// The paper's frame (VaFR, Eq. 3): the display's plane shifted so that the gaze lies at the
    /// principal point. An eccentricity is the arc tangent of the planar distance, which is the true
    /// angle for a gaze at the principal point only.
    #[must_use]
    pub fn planar(display: &DisplayGeometry, gaze_px: DVec2) -> Self {
        let gaze_px = gaze_in_use_px(display.size_px, gaze_px);
        let base_px = base_px(display, gaze_px);
        let per_px = display.tangents_per_px();
        let base = ((base_px - gaze_px) * per_px).extend(1.0);
        let ray_from_offset = DMat3::from_cols(DVec3::X * per_px.x, DVec3::Y * per_px.y, base);
        Self { gaze_px, base_px, ray_from_offset, offset_from_ray: ray_from_offset.inverse() }
    }

    /// As [`Self::planar`], with circles of equal distance in pixels: one tangent per px along both axes.
    #[must_use]
    pub(super) fn by_pixels(display: &DisplayGeometry, gaze_px: DVec2, tangent_per_px: f64) -> Self {
        let gaze_px = gaze_in_use_px(display.size_px, gaze_px);
        let base_px = base_px(display, gaze_px);
        let base = ((base_px - gaze_px) * tangent_per_px).extend(1.0);
        let ray_from_offset = DMat3::from_cols(DVec3::X * tangent_per_px, DVec3::Y * tangent_per_px, base);
        Self { gaze_px, base_px, ray_from_offset, offset_from_ray: ray_from_offset.inverse() }
    }

    /// The gaze in use, px.
    #[must_use]
    pub fn gaze_px(&self) -> DVec2 {
        self.gaze_px
    }

    /// The ray through a display position in the frame. On the sphere it has the length of
    /// [`DisplayGeometry::ray_of_px`].
    #[must_use]
    pub fn ray(&self, px: DVec2) -> DVec3 {
        self.ray_from_offset * (px - self.base_px).extend(1.0)
    }

    /// The display position that a ray of the frame meets, px; the inverse of [`Self::ray`], whatever
    /// the ray's length. `None` where it does not meet the display's plane, or too far away.
    #[must_use]
    pub fn px(&self, ray: DVec3) -> Option<DVec2> {
        let flat = self.offset_from_ray * ray;
        if flat.z.is_nan() || flat.z <= 0.0 {
            return None;
        }
        let px = self.base_px + flat.truncate() / flat.z;
        px.is_finite().then_some(px)
    }

    /// Change of the frame's rays per px to the right and per px down.
    pub(super) fn steps(&self) -> [DVec3; 2] {
        [self.ray_from_offset.x_axis, self.ray_from_offset.y_axis]
    }

    /// The least size of a pixel on the frame's plane at distance 1.
    pub(super) fn least_step(&self) -> f64 {
        let [x, y] = self.steps();
        x.length().min(y.length())
    }

    /// Unit normals, pointing inwards, of the planes through the frame's origin and the display's left,
    /// right, upper and lower edge.
    pub(super) fn edges(&self, size_px: [u32; 2]) -> [[f32; 4]; 4] {
        let [x, y, one] = {
            let rows = self.offset_from_ray.transpose();
            [rows.x_axis, rows.y_axis, rows.z_axis]
        };
        let (low, high) = (-self.base_px, size_dvec2_px(size_px) - self.base_px);
        // An offset's distance from an edge, as a function of the ray, is 0 on the plane through it.
        [x - one * low.x, one * high.x - x, y - one * low.y, one * high.y - y]
            .map(|normal| normal.normalize_or_zero().as_vec3().extend(0.0).to_array())
    }

    /// For the shaders: the base (x hi, y hi, x lo, y lo), the rows of the ray's matrix, the rows of its
    /// inverse.
    pub(super) fn rows(&self) -> ([f32; 4], [[f32; 4]; 3], [[f32; 4]; 3]) {
        let rows = |m: &DMat3| {
            let m = m.transpose();
            [m.x_axis, m.y_axis, m.z_axis].map(|row| row.as_vec3().extend(0.0).to_array())
        };
        let low = self.base_px - self.base_px.as_vec2().as_dvec2();
        let base = [self.base_px.x as f32, self.base_px.y as f32, low.x as f32, low.y as f32];
        (base, rows(&self.ray_from_offset), rows(&self.offset_from_ray))
    }
}

fn base_px(display: &DisplayGeometry, gaze_px: DVec2) -> DVec2 {
    gaze_px.clamp(DVec2::ZERO, size_dvec2_px(display.size_px))
}

/// Eccentricity of a ray of a [`GazeFrame`], rad, 0..=pi.
#[must_use]
pub fn eccentricity_of_ray_rad(ray: DVec3) -> f64 {
    ray.x.hypot(ray.y).atan2(ray.z)
}

/// Azimuth of a ray of a [`GazeFrame`] as a share of a turn, from 0 to below 1; 0 along the gaze.
#[must_use]
pub fn azimuth_turns(ray: DVec3) -> f64 {
    let turns = (ray.y.atan2(ray.x) / std::f64::consts::TAU).rem_euclid(1.0);
    // An angle just below 0 becomes a full turn when it is rounded.
    if turns < 1.0 { turns } else { 0.0 }
}
