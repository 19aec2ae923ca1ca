//! The mapping of locomotion-aware foveated rendering (LaFR, Shi et al. 2023).
//!
//! Known through Zhang et al. 2025, Eq. 15 and 17. With `z = ln r / L`, `r` the distance from the gaze
//! in px and `L = ln` of the farthest corner's distance, `Z` the `z` at the foveal boundary of 4.89
//! degrees, the share of the columns within `z` is
//!
//! - inside the boundary `(z (1 - F))^(1/F)` with `F = 1 - log_Z(alpha Z^(1-a) / (1-a))`;
//! - outside it `U + (1 - U) p^(beta/0.7)` with `p = 2/pi asin((1/Z - 1/z)/(1/Z - 1))` and `U` the inner
//!   share at the boundary.
//!
//! Both pieces are `U` at the boundary, and the outer one ends at 1: the mapping is continuous and
//! rises. Its *slope* jumps at the boundary, from about 3 to 28 cycles per degree at 1440x1700, which is
//! the discontinuity that Zhang et al. show in their figures 6 and 7.
//!
//! Where the text leaves a choice:
//!
//! - `a` is "LMFR's alpha". LMFR writes its kernel `x^4` both for `u(z)` and for its inverse. With `a = 4`
//!   the logarithm's argument is negative; here the kernel is inverted, so that `a = 1/4`: then the inner
//!   piece behaves like `z^2` to `z^3`, and `F` lies between 0 and 1 for the alpha in use.
//! - The outer line of Eq. 17 is twice the derivative of Eq. 15 over 2, which the inner line and Eq. 16
//!   are. The derivative is used: it stays within a third of the acuity model from 8 to 55 degrees, as
//!   the text says of LaFR; twice as much does not.
//! - Eq. 20 converts tangential lengths with the radial `de/dr`; the true tangential rate is `cos e`
//!   times that.
//! - The boundary's radius is `tan(4.89 deg)/c_r` at every gaze, as in Eq. 3.
//!
//! `Z` and `F` are kept within ranges that the paper's displays do not reach, so that a display smaller
//! than the foveal boundary or coarser than a few pixels has a mapping too.

use super::display::DisplayGeometry;
use super::gaze_frame::GazeFrame;
use super::kfr::LEAST_NATIVE_RADIUS_PX;
use super::mapping::{ColumnLayout, LpPoint, Mapping, TexelJacobian};
use super::method::{
    PolarOffset, gaze_in_use_px, on_circle, reach_px, reduced_columns, tangent_per_px, within,
};
use super::radial::RadialMapping;
use crate::error::Result;
use glam::DVec2;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// The foveal boundary, degrees (Eq. 15). Larger widens the blurred inner part.
const FOVEA_DEG: f64 = 4.89;

/// The inverse of LMFR's exponent 4. Larger moves columns towards the gaze.
const KERNEL_A: f64 = 0.25;

/// The `beta` for which the outer piece is the plain arc sine (Eq. 15).
const PLAIN_BETA: f64 = 0.7;

/// Range of `Z`. The paper's displays have 0.5 to 0.65.
const BOUNDARY_RANGE: (f64, f64) = (0.05, 0.9);

/// Range of `F`. The paper's displays have 0.3 to 0.55; at 0 the inner share vanishes, and at 1 too.
const EXPONENT_RANGE: (f64, f64) = (0.1, 0.9);

/// The arc sine's slope has no bound at the farthest corner. It is cut off where `1 - s` is below this,
/// nearer to that corner than any pixel's centre.
const LEAST_GAP: f64 = 1e-12;

/// A gaze farther off than this many of the display's diagonals from its centre is moved onto that circle.
/// The kernel is steep at the farthest corner; seen from farther away all of the display lies there, between
/// two angles that the shaders' single precision hardly tells apart.
const MOST_DIAGONALS: f64 = 4.0;

fn within_reach_px(display: &DisplayGeometry, gaze_px: DVec2) -> DVec2 {
    let centre_px = display.center_px();
    centre_px + (gaze_px - centre_px).clamp_length_max(MOST_DIAGONALS * 2.0 * centre_px.length())
}

/// Parameters of [`LafrMapping`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LafrParams {
    /// Display width over LP-buffer width, 1..=64. Larger: fewer samples. The authors vary it between
    /// 1.8 and 2.2 with the user's locomotion.
    pub delta: f64,
    /// Scale of the inner kernel, 0.5..=1. Smaller: fewer columns inside the foveal boundary.
    pub alpha: f64,
    /// Shape of the outer part, 0.7..=1.4. Larger: fewer columns near the foveal boundary.
    pub beta: f64,
}

impl LafrParams {
    /// What Zhang et al. tuned for 11520x6480 (section 4.5).
    pub const RETINAL: Self = Self { delta: 8.0, alpha: 0.78, beta: 0.9 };

    /// Checks the ranges.
    ///
    /// # Errors
    /// [`crate::error::Error::Setting`] for a parameter outside its range.
    pub fn check(&self) -> Result<()> {
        within("LaFR's delta", self.delta, 1.0, 64.0)?;
        within("LaFR's alpha", self.alpha, 0.5, 1.0)?;
        within("LaFR's beta", self.beta, PLAIN_BETA, 1.4)
    }
}

impl Default for LafrParams {
    /// The original paper's values.
    fn default() -> Self {
        Self { delta: 1.8, alpha: 0.85, beta: PLAIN_BETA }
    }
}

/// The kernel for one distance to the farthest corner.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LafrKernel {
    boundary_z: f64,
    exponent: f64,
    boundary_share: f64,
    outer_power: f64,
}

impl LafrKernel {
    fn new(boundary_px: f64, log_reach: f64, params: &LafrParams) -> Self {
        let boundary_z = (boundary_px.ln() / log_reach).clamp(BOUNDARY_RANGE.0, BOUNDARY_RANGE.1);
        let scaled = params.alpha * boundary_z.powf(1.0 - KERNEL_A) / (1.0 - KERNEL_A);
        let exponent = (1.0 - scaled.ln() / boundary_z.ln()).clamp(EXPONENT_RANGE.0, EXPONENT_RANGE.1);
        let mut kernel =
            Self { boundary_z, exponent, boundary_share: 1.0, outer_power: params.beta / PLAIN_BETA };
        kernel.boundary_share = kernel.inner(boundary_z);
        kernel
    }

    fn inner(&self, z: f64) -> f64 {
        (z * (1.0 - self.exponent)).powf(self.exponent.recip())
    }

    /// `s` (0 at the boundary, 1 at the corner) and `1 - s`, each without cancellation.
    fn outer_share(&self, z: f64) -> (f64, f64) {
        let scale = z * (1.0 - self.boundary_z);
        ((z - self.boundary_z) / scale, self.boundary_z * (1.0 - z) / scale)
    }

    /// Share of the columns within `z`, which lies in 0..=1.
    fn eval(&self, z: f64) -> f64 {
        if z <= self.boundary_z {
            return self.inner(z).min(self.boundary_share);
        }
        let (s, gap) = self.outer_share(z);
        // The arc sine has an infinite slope at 1; its half-angle form has not.
        let p = if s > 0.5 { 1.0 - (gap / 2.0).sqrt().asin() / FRAC_PI_4 } else { s.asin() / FRAC_PI_2 };
        self.boundary_share + (1.0 - self.boundary_share) * p.powf(self.outer_power)
    }

    /// The `z` within which lies a share of the columns, 0..=1.
    fn inverse(&self, share: f64) -> f64 {
        if share <= self.boundary_share {
            let z = share.powf(self.exponent) / (1.0 - self.exponent);
            return z.min(self.boundary_z);
        }
        let p = ((share - self.boundary_share) / (1.0 - self.boundary_share)).powf(self.outer_power.recip());
        let half = (FRAC_PI_4 * (1.0 - p)).sin();
        let gap = 2.0 * half * half;
        self.boundary_z / (self.boundary_z + gap * (1.0 - self.boundary_z))
    }

    /// Slope of [`Self::eval`] at `z` within 0..=1; at the boundary the inner one.
    fn derivative(&self, z: f64) -> f64 {
        if z <= self.boundary_z {
            let base = 1.0 - self.exponent;
            return base / self.exponent * (z * base).powf(self.exponent.recip() - 1.0);
        }
        let (s, gap) = self.outer_share(z);
        let p = s.min(1.0).asin() / FRAC_PI_2;
        let dp_ds = 2.0 / (PI * (gap.max(LEAST_GAP) * (1.0 + s)).sqrt());
        let ds_dz = self.boundary_z / ((1.0 - self.boundary_z) * z * z);
        (1.0 - self.boundary_share) * self.outer_power * p.powf(self.outer_power - 1.0) * dp_ds * ds_dz
    }
}

/// LaFR's mapping of one frame: `u = w K(ln r / L)` with the two-part kernel above, `v = h theta / 2 pi`,
/// `w = W/delta` and `h = H/delta` rounded, all columns of equal height.
///
/// Pixels nearer than 3 px to the gaze are native; the method's own `du/dr` is 0 below 1 px.
#[derive(Clone, Debug)]
pub struct LafrMapping {
    display: DisplayGeometry,
    params: LafrParams,
    columns: ColumnLayout,
    /// Width and height of the LP-buffer, texels.
    size: [f64; 2],
    gaze_px: DVec2,
    reach_px: f64,
    log_reach: f64,
    kernel: LafrKernel,
}

impl LafrMapping {
    /// The mapping for a checked display, checked parameters and a gaze on the display or off it. A gaze
    /// farther than [`super::MAX_GAZE_PX`] is clamped, and one that is not finite is taken as the
    /// display's centre.
    #[must_use]
    pub fn new(display: DisplayGeometry, gaze_px: DVec2, params: LafrParams) -> Self {
        debug_assert!(params.check().is_ok(), "the parameters are checked by the settings");
        let columns = reduced_columns(display.size_px, params.delta);
        let mut mapping = Self {
            display,
            params,
            size: columns.size().map(f64::from),
            columns,
            gaze_px,
            reach_px: 0.0,
            log_reach: 0.0,
            kernel: LafrKernel { boundary_z: 0.0, exponent: 0.0, boundary_share: 0.0, outer_power: 0.0 },
        };
        mapping.retarget(gaze_px);
        mapping
    }

    /// Changes the gaze; the LP-buffer keeps its size, and nothing is allocated.
    pub fn retarget(&mut self, gaze_px: DVec2) {
        self.gaze_px = within_reach_px(&self.display, gaze_in_use_px(self.display.size_px, gaze_px));
        self.reach_px = reach_px(&self.display, self.gaze_px);
        self.log_reach = self.reach_px.ln();
        self.kernel = LafrKernel::new(self.boundary_radius_px(), self.log_reach, &self.params);
    }

    /// Radius of the foveal boundary as the paper defines it, px. On displays that it does not fit
    /// the kernel's own boundary lies elsewhere.
    #[must_use]
    pub fn boundary_radius_px(&self) -> f64 {
        FOVEA_DEG.to_radians().tan() / tangent_per_px(&self.display)
    }

    /// Distance from the gaze to the display's farthest corner, px; 2 where it is less.
    #[must_use]
    pub fn reach_px(&self) -> f64 {
        self.reach_px
    }

    /// Radius of the disc of native pixels around the gaze, px.
    #[must_use]
    pub fn native_radius_px(&self) -> f64 {
        LEAST_NATIVE_RADIUS_PX
    }

    /// The column coordinate at a distance from the gaze, texels: 0 up to 1 px, the LP-buffer's width at
    /// the farthest corner and beyond.
    #[must_use]
    pub fn u_of_radius_px(&self, radius_px: f64) -> f64 {
        self.size[0] * self.kernel.eval(self.z_of_radius(radius_px))
    }

    /// The distance from the gaze at a column coordinate, which is clamped to the LP-buffer, px.
    #[must_use]
    pub fn radius_px(&self, u: f64) -> f64 {
        let share = (u / self.size[0]).clamp(0.0, 1.0);
        (self.log_reach * self.kernel.inverse(share)).exp()
    }

    /// Height of every column, texels.
    #[must_use]
    pub fn height(&self, _u: f64) -> f64 {
        self.size[1]
    }

    /// Texels per px; 0 below 1 px and from the farthest corner on.
    fn du_dr(&self, radius_px: f64) -> f64 {
        if radius_px < 1.0 || radius_px >= self.reach_px {
            return 0.0;
        }
        let slope = self.kernel.derivative(self.z_of_radius(radius_px));
        self.size[0] * slope / (self.log_reach * radius_px)
    }

    fn z_of_radius(&self, radius_px: f64) -> f64 {
        if radius_px <= 1.0 { 0.0 } else { (radius_px.ln() / self.log_reach).min(1.0) }
    }
}

impl Mapping for LafrMapping {
    fn display(&self) -> &DisplayGeometry {
        &self.display
    }

    fn gaze_px(&self) -> DVec2 {
        self.gaze_px
    }

    fn columns(&self) -> &ColumnLayout {
        &self.columns
    }

    fn column_height(&self, u: f64) -> f64 {
        self.height(u)
    }

    fn forward(&self, px: DVec2) -> Option<LpPoint> {
        let offset = PolarOffset::new(self.gaze_px, px);
        Some(LpPoint { u: self.u_of_radius_px(offset.radius_px), v_share: offset.v_share() })
    }

    fn inverse(&self, point: LpPoint) -> Option<DVec2> {
        Some(on_circle(self.gaze_px, self.radius_px(point.u), point.v_share))
    }

    fn jacobian(&self, px: DVec2) -> Option<TexelJacobian> {
        let offset = PolarOffset::new(self.gaze_px, px);
        offset.jacobian(self.du_dr(offset.radius_px), self.height(0.0))
    }

    fn is_native(&self, px: DVec2) -> bool {
        PolarOffset::new(self.gaze_px, px).radius_px < LEAST_NATIVE_RADIUS_PX
    }
}

/// Circles of equal distance in pixels: an eccentricity is the arc tangent of the
/// distance in units of the display's distance.
impl RadialMapping for LafrMapping {
    fn frame(&self) -> GazeFrame {
        GazeFrame::by_pixels(&self.display, self.gaze_px, tangent_per_px(&self.display))
    }

    fn eccentricity_of_column_rad(&self, u: f64) -> f64 {
        (self.radius_px(u) * tangent_per_px(&self.display)).atan()
    }

    fn column_of_eccentricity(&self, ecc_rad: f64) -> f64 {
        let radius_px =
            if ecc_rad < FRAC_PI_2 { ecc_rad.tan() / tangent_per_px(&self.display) } else { f64::MAX };
        self.u_of_radius_px(radius_px.min(self.reach_px))
    }

    fn acuity_per_steradian(&self, _ecc_rad: f64) -> f64 {
        0.0
    }

    fn columns_in_use(&self) -> u32 {
        self.columns.size()[0]
    }

    /// The arc sine's.
    fn ends_like_a_root(&self) -> bool {
        true
    }
}
