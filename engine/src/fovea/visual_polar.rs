//! The mapping of foveated path tracing in visual-polar space (Koskela et al. 2019).
//!
//! What the texts say. Koskela et al.: a regular polar grid whose radial axis is scaled so that the
//! density of samples follows a visual acuity model, and from which a triangle is cut so that the fovea
//! has one density. Zhang et al. 2025, section 4.2: a log-polar mapping that is linear in the fovea; a
//! cropped triangle with uniform rates there; outside it another acuity model than theirs and a
//! parameter that depends on the gaze; an LP-buffer of about their own size (932 columns, 1.06 million
//! samples), radial rates much like theirs in the periphery and far lower in the fovea; a tangential
//! rate that hangs on the radial one and is lower. Neither text at hand prints the formula.
//!
//! What is built here, all of which follows from those statements but for the points marked *assumed*:
//!
//! - Acuity model (*assumed*: Reddy's, which Koskela's other work uses): density relative to the fovea
//!   `V(e) = 1` up to `F` = 5.79 degrees and `((1 + 0.3 F)/(1 + 0.3 e))^2` beyond; the published factor
//!   7.49 makes the two meet.
//! - The grid lies in the plane of polar angle and azimuth (*assumed*: density per square degree of that
//!   plane). All columns outside the fovea are equally high, so that `du/de` is proportional to `e V(e)`,
//!   the integral of which is a logarithm:
//!   `u = u_F + (w - u_F) Q(e)/Q(e_d)`, `Q(e) = ln(1 + x) - b x/(1 + x)`,
//!   `x = 0.3 b (e - F)`, `b = 1/(1 + 0.3 F)`.
//!   Inside, `u = u_F e/F` with columns of `h u/u_F` texels: a uniform density.
//! - `e = atan(c_r r)` from the planar distance to the gaze, as Zhang et al. plot it; `e_d` is that of the
//!   display's farthest corner, the parameter that depends on the gaze.
//! - `u_F` makes `du/de` continuous for a gaze at the display's centre, and `h = 2 pi u_F` makes the fovea
//!   isotropic (*assumed*). For other gazes the LP-buffer and `u_F` stay as they are, and the peripheral
//!   rate falls with `e_d` (Zhang et al. name that as the method's weakness).
//!
//! With 932 columns at 1440x1600 and 110 degrees this yields 0.95 million samples, 15.5 cycles per degree
//! in the fovea (acuity: 40), radial rates of 0.8 to 1.4 times the acuity model from 5.8 to 60 degrees,
//! and beyond 20 degrees a tangential rate of about half the radial one.

use super::display::DisplayGeometry;
use super::gaze_frame::GazeFrame;
use super::kfr::LEAST_NATIVE_RADIUS_PX;
use super::mapping::{ColumnLayout, LpPoint, Mapping, TexelJacobian};
use super::method::{PolarOffset, gaze_in_use_px, on_circle, reach_px, tangent_per_px};
use super::radial::RadialMapping;
use crate::error::{Error, Result};
use glam::DVec2;
use std::f64::consts::FRAC_PI_2;
use std::f64::consts::TAU;

/// Where acuity begins to fall, degrees (Reddy's model). Larger widens the uniform fovea.
const FOVEA_DEG: f64 = 5.79;

/// Fall-off of acuity, per degree (Reddy's model). Larger moves columns towards the fovea.
const FALL_OFF_PER_DEG: f64 = 0.3;

/// The least angle from the display's centre to its corner that the fall-off is laid out for, degrees.
/// Below it everything lies in the fovea, and `Q` would lose its digits.
const LEAST_REACH_DEG: f64 = 0.1;

/// Columns of the LP-buffer: the width that Zhang et al. print for their own, which is "similar".
const DEFAULT_COLUMNS: u32 = 932;

/// Parameters of [`VisualPolarMapping`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VisualPolarParams {
    /// Width of the LP-buffer, texels, 16..=8192, whatever the display's size. Samples grow with its
    /// square.
    pub columns: u32,
}

impl VisualPolarParams {
    /// Checks the range.
    ///
    /// # Errors
    /// [`Error::Setting`] for a width outside its range.
    pub fn check(&self) -> Result<()> {
        if (16..=8192).contains(&self.columns) {
            return Ok(());
        }
        Err(Error::Setting(format!(
            "Visual-Polar has {} columns; it must have between 16 and 8192",
            self.columns
        )))
    }
}

impl Default for VisualPolarParams {
    fn default() -> Self {
        Self { columns: DEFAULT_COLUMNS }
    }
}

/// `Q` and `x` of the module's text.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FallOff {
    fovea_deg: f64,
    /// `b`
    end_share: f64,
    /// `dx/de`
    x_per_deg: f64,
}

impl FallOff {
    fn new(fovea_deg: f64) -> Self {
        let end_share = 1.0 / (1.0 + FALL_OFF_PER_DEG * fovea_deg);
        Self { fovea_deg, end_share, x_per_deg: FALL_OFF_PER_DEG * end_share }
    }

    /// `Q` at an eccentricity from the fovea's limit on.
    fn integral(&self, eccentricity_deg: f64) -> f64 {
        let x = self.x_per_deg * (eccentricity_deg - self.fovea_deg);
        x.ln_1p() - self.end_share * x / (1.0 + x)
    }

    /// `dQ/de`, per degree.
    fn slope_per_deg(&self, eccentricity_deg: f64) -> f64 {
        let stretch = 1.0 + self.x_per_deg * (eccentricity_deg - self.fovea_deg);
        self.x_per_deg * (stretch - self.end_share) / (stretch * stretch)
    }

    /// The eccentricity at a value of `Q` from 0 on, degrees.
    ///
    /// With `t = ln(1 + x)`, `Q = t - b (1 - e^-t)` is convex and rises with a slope of at least `1 - b`:
    /// Newton's method from above falls to the root without passing it.
    fn eccentricity_deg(&self, integral: f64) -> f64 {
        let mut t = (integral + self.end_share).min(integral / (1.0 - self.end_share));
        // It doubles the digits in each step; the slope, within 1-b..1, leaves no slow start.
        for _ in 0..8 {
            let decay = self.end_share * (-t).exp_m1();
            t -= (t + decay - integral) / (1.0 - self.end_share - decay);
        }
        self.fovea_deg + t.max(0.0).exp_m1() / self.x_per_deg
    }
}

/// Visual-Polar's mapping of one frame, as the module's text defines it.
///
/// Pixels nearer than 3 px to the gaze are native.
#[derive(Clone, Debug)]
pub struct VisualPolarMapping {
    display: DisplayGeometry,
    columns: ColumnLayout,
    /// `w` and `h`, texels.
    size: [f64; 2],
    /// `u_F`, texels.
    fovea_u: f64,
    fall_off: FallOff,
    tangent_per_px: f64,
    gaze_px: DVec2,
    reach_px: f64,
    /// `Q(e_d)`
    reach_integral: f64,
}

impl VisualPolarMapping {
    /// The mapping for a checked display, checked parameters and a gaze on the display or off it. A gaze
    /// farther than [`super::MAX_GAZE_PX`] is clamped, and one that is not finite is taken as the
    /// display's centre.
    ///
    /// On a display that is less than 23 degrees from corner to corner the fovea ends at a quarter of
    /// that angle, so that every gaze leaves a periphery.
    #[must_use]
    pub fn new(display: DisplayGeometry, gaze_px: DVec2, params: VisualPolarParams) -> Self {
        debug_assert!(params.check().is_ok(), "the parameters are checked by the settings");
        let tangent_per_px = tangent_per_px(&display);
        let center_reach_deg = (tangent_per_px * reach_px(&display, display.center_px()))
            .atan()
            .to_degrees()
            .max(LEAST_REACH_DEG);
        let fall_off = FallOff::new(FOVEA_DEG.min(center_reach_deg / 2.0));
        let width = f64::from(params.columns);
        // du/de on both sides of the limit: u_F/F = (w - u_F)/Q(e_d) dQ/de.
        let fovea_slope = fall_off.fovea_deg * fall_off.slope_per_deg(fall_off.fovea_deg);
        let fovea_u = width * fovea_slope / (fovea_slope + fall_off.integral(center_reach_deg));
        let height = (TAU * fovea_u).round().max(1.0);
        let texels = |column: u32| (height * ((f64::from(column) + 0.5) / fovea_u).min(1.0)).round() as u32;
        let columns = ColumnLayout::new((0..params.columns).map(|column| texels(column).max(1)).collect());
        let mut mapping = Self {
            display,
            columns,
            size: [width, height],
            fovea_u,
            fall_off,
            tangent_per_px,
            gaze_px,
            reach_px: 0.0,
            reach_integral: 0.0,
        };
        mapping.retarget(gaze_px);
        mapping
    }

    /// Changes the gaze; the LP-buffer keeps its size, and nothing is allocated.
    pub fn retarget(&mut self, gaze_px: DVec2) {
        self.gaze_px = gaze_in_use_px(self.display.size_px, gaze_px);
        self.reach_px = reach_px(&self.display, self.gaze_px);
        let reach_deg = self.eccentricity_deg(self.reach_px).max(2.0 * self.fall_off.fovea_deg);
        self.reach_integral = self.fall_off.integral(reach_deg);
    }

    /// Radius of the uniform fovea, px.
    #[must_use]
    pub fn fovea_radius_px(&self) -> f64 {
        self.fall_off.fovea_deg.to_radians().tan() / self.tangent_per_px
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

    /// The column coordinate at a distance from the gaze, texels: 0 at the gaze, the LP-buffer's width at
    /// the farthest corner and beyond.
    #[must_use]
    pub fn u_of_radius_px(&self, radius_px: f64) -> f64 {
        let eccentricity_deg = self.eccentricity_deg(radius_px.min(self.reach_px));
        if eccentricity_deg <= self.fall_off.fovea_deg {
            return self.fovea_u * eccentricity_deg / self.fall_off.fovea_deg;
        }
        let share = self.fall_off.integral(eccentricity_deg) / self.reach_integral;
        self.fovea_u + (self.size[0] - self.fovea_u) * share.clamp(0.0, 1.0)
    }

    /// The distance from the gaze at a column coordinate, which is clamped to the LP-buffer, px.
    #[must_use]
    pub fn radius_px(&self, u: f64) -> f64 {
        let u = u.clamp(0.0, self.size[0]);
        let eccentricity_deg = if u <= self.fovea_u {
            self.fall_off.fovea_deg * u / self.fovea_u
        } else {
            let share = (u - self.fovea_u) / (self.size[0] - self.fovea_u);
            self.fall_off.eccentricity_deg(share * self.reach_integral)
        };
        (eccentricity_deg.to_radians().tan() / self.tangent_per_px).clamp(0.0, self.reach_px)
    }

    /// Height at a column coordinate before rounding, texels: rises evenly through the fovea and then
    /// stays. Columns have at least one texel.
    #[must_use]
    pub fn height(&self, u: f64) -> f64 {
        self.size[1] * (u / self.fovea_u).clamp(0.0, 1.0)
    }

    /// Texels per px; 0 from the farthest corner on.
    fn du_dr(&self, radius_px: f64) -> f64 {
        if radius_px >= self.reach_px {
            return 0.0;
        }
        let eccentricity_deg = self.eccentricity_deg(radius_px);
        let du_de = if eccentricity_deg <= self.fall_off.fovea_deg {
            self.fovea_u / self.fall_off.fovea_deg
        } else {
            (self.size[0] - self.fovea_u) * self.fall_off.slope_per_deg(eccentricity_deg)
                / self.reach_integral
        };
        let tangent = self.tangent_per_px * radius_px;
        du_de * self.tangent_per_px.to_degrees() / (1.0 + tangent * tangent)
    }

    fn eccentricity_deg(&self, radius_px: f64) -> f64 {
        (self.tangent_per_px * radius_px).atan().to_degrees()
    }
}

impl Mapping for VisualPolarMapping {
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
        let height = self.height(self.u_of_radius_px(offset.radius_px));
        offset.jacobian(self.du_dr(offset.radius_px), height)
    }

    fn is_native(&self, px: DVec2) -> bool {
        PolarOffset::new(self.gaze_px, px).radius_px < LEAST_NATIVE_RADIUS_PX
    }
}

/// Circles of equal distance in pixels: an eccentricity is the arc tangent of the
/// distance in units of the display's distance.
impl RadialMapping for VisualPolarMapping {
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
}
