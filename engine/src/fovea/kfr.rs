//! The mapping of kernel foveated rendering between the display and its log-polar (LP) buffer.

use super::display::{farthest_corner_px, size_dvec2_px};
use super::kernel::Kernel;
use super::params::clamp_gaze_px;
use glam::DVec2;
use std::f64::consts::TAU;

/// The native disc's least radius, px. It covers the fovea hole: the mapping is singular at 1 px.
pub(super) const LEAST_NATIVE_RADIUS_PX: f64 = 3.0;

/// The least distance to the farthest corner, px, so that its logarithm stays away from 0 on a
/// display of a single pixel.
const LEAST_REACH_PX: f64 = 2.0;

/// Texels up to this display area are finer than pixels, px^2.
const NATIVE_AREA_PX2: f64 = 1.0;

/// Texels above this display area are filtered in the LP-buffer, px^2.
const FILTER_AREA_PX2: f64 = 4.0;

/// A point of the LP-buffer, normalised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LpCoord {
    /// Along the radius, 0..=1.
    pub u_norm: f64,
    /// Along the angle, from 0 to below 1; 0 along the display's +x, rising towards +y (down).
    pub v_norm: f64,
}

/// Derivatives of the normalised LP coordinates by the display position, per px.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LpJacobian {
    /// Of `u_norm` by x.
    pub du_dx: f64,
    /// Of `u_norm` by y.
    pub du_dy: f64,
    /// Of `v_norm` by x.
    pub dv_dx: f64,
    /// Of `v_norm` by y.
    pub dv_dy: f64,
}

impl LpJacobian {
    /// LP-buffer shares per px^2.
    #[must_use]
    pub fn determinant(&self) -> f64 {
        self.du_dx * self.dv_dy - self.du_dy * self.dv_dx
    }
}

/// The KFR mapping of one frame (thesis, Eq. 2.8):
/// `u = w K(ln r / L)`, `v = h theta / 2 pi`, with `L` the log-distance to the farthest corner.
///
/// Plain data without an allocation: made anew for each gaze.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KfrMapping {
    size_px: [u32; 2],
    lp_size: [u32; 2],
    gaze_px: DVec2,
    kernel: Kernel,
    log_reach: f64,
    native_radius_px: f64,
    filter_start_u: f64,
}

impl KfrMapping {
    /// The mapping for a display, a gaze on it or off it, a checked kernel, and `sigma` (display
    /// width over LP-buffer width, above 0).
    ///
    /// A gaze farther than [`super::MAX_GAZE_PX`] is clamped, and one that is not finite is taken
    /// as the display's centre: no frame comes out as NaN. [`super::GazeKeeper`] does better, as it
    /// remembers the last valid gaze.
    #[must_use]
    pub fn new(size_px: [u32; 2], gaze_px: DVec2, kernel: Kernel, sigma: f64) -> Self {
        debug_assert!(sigma > 0.0, "sigma is checked by the settings");
        let gaze_px = if gaze_px.is_finite() { clamp_gaze_px(gaze_px) } else { size_dvec2_px(size_px) / 2.0 };
        // The cast saturates, so that a tiny sigma does not wrap around.
        let texels = |pixels: u32| ((f64::from(pixels) / sigma).round() as u32).max(1);
        let mut mapping = Self {
            size_px,
            lp_size: size_px.map(texels),
            gaze_px,
            kernel,
            log_reach: farthest_corner_px(size_px, gaze_px).max(LEAST_REACH_PX).ln(),
            native_radius_px: 0.0,
            filter_start_u: 1.0,
        };
        let native_z = mapping.last_z_within(NATIVE_AREA_PX2);
        let least_radius_px = LEAST_NATIVE_RADIUS_PX.min(mapping.reach_px());
        mapping.native_radius_px =
            native_z.map_or(least_radius_px, |z| mapping.radius_px(z)).max(least_radius_px);
        let filter_z = mapping.last_z_within(FILTER_AREA_PX2).unwrap_or(0.0);
        mapping.filter_start_u = kernel.eval(filter_z.max(mapping.z_of_radius(mapping.native_radius_px)));
        mapping
    }

    /// Width and height of the display, px.
    #[must_use]
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// Width (radial) and height (angular) of the LP-buffer, texels: the display's over sigma,
    /// rounded, at least 1.
    #[must_use]
    pub fn lp_size(&self) -> [u32; 2] {
        self.lp_size
    }

    /// The gaze in use, px.
    #[must_use]
    pub fn gaze_px(&self) -> DVec2 {
        self.gaze_px
    }

    /// The kernel function.
    #[must_use]
    pub fn kernel(&self) -> &Kernel {
        &self.kernel
    }

    /// `L`: natural logarithm of [`Self::reach_px`]; at least ln 2.
    #[must_use]
    pub fn log_reach(&self) -> f64 {
        self.log_reach
    }

    /// Distance from the gaze to the display's farthest corner, px; 2 where it is less.
    #[must_use]
    pub fn reach_px(&self) -> f64 {
        self.log_reach.exp()
    }

    /// From a finite display position to the LP-buffer (Eq. 2.8). All of the disc `r <= 1 px` maps
    /// to `u_norm = 0`, and all beyond [`Self::reach_px`] to 1.
    #[must_use]
    pub fn forward(&self, px: DVec2) -> LpCoord {
        let offset_px = px - self.gaze_px;
        let radius_px = offset_px.x.hypot(offset_px.y);
        let v_norm = offset_px.y.atan2(offset_px.x).rem_euclid(TAU) / TAU;
        LpCoord {
            u_norm: self.kernel.eval(self.z_of_radius(radius_px)),
            // An angle just below 0 becomes a full turn when it is rounded.
            v_norm: if v_norm < 1.0 { v_norm } else { 0.0 },
        }
    }

    /// From the LP-buffer to the display, px; the position may lie off the display. `u_norm` is
    /// clamped to 0..=1; `v_norm` is periodic.
    #[must_use]
    pub fn inverse(&self, lp: LpCoord) -> DVec2 {
        let radius_px = self.radius_px(self.kernel.inverse(lp.u_norm));
        self.gaze_px + DVec2::from_angle(TAU * lp.v_norm) * radius_px
    }

    /// `du_norm/dr`, per px; 0 outside the mapping's range, that is below 1 px and beyond the
    /// farthest corner.
    #[must_use]
    pub fn du_dr(&self, radius_px: f64) -> f64 {
        // The corner itself counts as inside, whatever its logarithm rounds to.
        if radius_px < 1.0 || radius_px > self.reach_px() * (1.0 + 1e-12) {
            return 0.0;
        }
        self.kernel.derivative(self.z_of_radius(radius_px)) / (self.log_reach * radius_px)
    }

    /// The analytic Jacobian at a display position. At the gaze itself, where the angle is not
    /// defined, everything is 0.
    #[must_use]
    pub fn jacobian(&self, px: DVec2) -> LpJacobian {
        let offset_px = px - self.gaze_px;
        let radius_px = offset_px.x.hypot(offset_px.y);
        if radius_px < f64::MIN_POSITIVE {
            return LpJacobian { du_dx: 0.0, du_dy: 0.0, dv_dx: 0.0, dv_dy: 0.0 };
        }
        let outward = offset_px / radius_px;
        let (du_dr, dv_ds) = (self.du_dr(radius_px), 1.0 / (TAU * radius_px));
        LpJacobian {
            du_dx: du_dr * outward.x,
            du_dy: du_dr * outward.y,
            dv_dx: -dv_ds * outward.y,
            dv_dy: dv_ds * outward.x,
        }
    }

    /// LP texels per px^2 at a distance from the gaze; 0 where [`Self::du_dr`] is.
    #[must_use]
    pub fn density_per_px2(&self, radius_px: f64) -> f64 {
        let du_dr = self.du_dr(radius_px);
        // Tells the singular gaze from a division by 0.
        if du_dr == 0.0 {
            return 0.0;
        }
        let [width, height] = self.lp_size.map(f64::from);
        width * du_dr * height / (TAU * radius_px)
    }

    /// Display area of one LP texel at a distance from the gaze, px^2; infinite where the density is
    /// 0 (inside 1 px, and where the kernel is flat).
    #[must_use]
    pub fn texel_area_px(&self, radius_px: f64) -> f64 {
        self.density_per_px2(radius_px).recip()
    }

    /// Radius of the *native disc* around the gaze, px. Inside it display pixels are shaded directly
    /// and not LP texels; it ends where the texels grow larger than pixels (1 px^2).
    ///
    /// At least 3 px, which covers the fovea hole, and at most [`Self::reach_px`].
    #[must_use]
    pub fn native_radius_px(&self) -> f64 {
        self.native_radius_px
    }

    /// Width of the ring outside the native disc in which both kinds of samples blend, px: a tenth
    /// of the radius, within 1..=8.
    #[must_use]
    pub fn blend_band_px(&self) -> f64 {
        (self.native_radius_px * 0.1).clamp(1.0, 8.0)
    }

    /// The `u_norm` from which on a texel covers more than 4 px^2: the LP-buffer's Gaussian works
    /// beyond it only. Never inside the native disc; 1 where there are no such texels.
    #[must_use]
    pub fn filter_start_u(&self) -> f64 {
        self.filter_start_u
    }

    /// `ln r / L` within 0..=1.
    fn z_of_radius(&self, radius_px: f64) -> f64 {
        if radius_px <= 1.0 { 0.0 } else { (radius_px.ln() / self.log_reach).min(1.0) }
    }

    fn radius_px(&self, z: f64) -> f64 {
        (self.log_reach * z).exp()
    }

    /// The largest `z` at which a texel covers at most `area_px2`; `None` where all cover more.
    ///
    /// Areas need not grow steadily with the radius (towards the gaze they grow again, and a
    /// polynomial kernel may wave), so that the outermost crossing is looked for from outside in
    /// even steps of z, and then bisected.
    fn last_z_within(&self, area_px2: f64) -> Option<f64> {
        const STEPS: u32 = 256;
        const BISECTIONS: u32 = 48;
        let [width, height] = self.lp_size.map(f64::from);
        let scale = TAU * self.log_reach / (width * height);
        // area = scale r^2 / K'(z); multiplied out, so that K' = 0 needs no care.
        let within =
            |z: f64| scale * (2.0 * self.log_reach * z).exp() <= area_px2 * self.kernel.derivative(z);
        let at = |step: u32| f64::from(step) / f64::from(STEPS);
        let step = (0..=STEPS).rev().find(|step| within(at(*step)))?;
        if step == STEPS {
            return Some(1.0);
        }
        let (mut low, mut high) = (at(step), at(step + 1));
        for _ in 0..BISECTIONS {
            let middle = f64::midpoint(low, high);
            if within(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some(low)
    }
}
