//! The mapping of visual-acuity-consistent foveated rendering (VaFR, 2025): the LP-buffer's density is
//! the acuity at each eccentricity, whatever the display.

use super::acuity::AcuityModel;
use super::display::{DisplayGeometry, size_dvec2_px};
use super::gaze_frame::{GazeFrame, azimuth_turns, eccentricity_of_ray_rad};
use super::kfr::LEAST_NATIVE_RADIUS_PX;
use super::mapping::{ColumnLayout, LpPoint, Mapping, TexelJacobian};
use super::radial::RadialMapping;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// In what sense an eccentricity is an angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VafrForm {
    /// About the gaze ray, so that the rate is the acuity's at every gaze; with a native disc.
    Sphere,
    /// The paper's (Eq. 3 to 9): planar distance from the gazed pixel; no native disc beyond the
    /// singular point.
    Planar,
}

/// Where the display's pixels are this much denser than the acuity asks, the picture comes from the
/// LP-buffer alone; between 1 and this it passes over from native pixels. A wider band hides the change
/// of sharpness better and costs more native pixels: at 28 px per degree this one is half a degree.
pub const NATIVE_BAND: f64 = 0.1;

/// The mapping of one frame. Its columns do not depend on the gaze: they reach as far as any gaze can
/// call for.
#[derive(Clone, Debug, PartialEq)]
pub struct VafrMapping {
    form: VafrForm,
    display: DisplayGeometry,
    acuity: Arc<AcuityModel>,
    frame: GazeFrame,
    columns: Arc<ColumnLayout>,
}

impl VafrMapping {
    /// The mapping for a checked display and a gaze on it or off it, which is clamped as
    /// [`GazeFrame::on_sphere`] says.
    #[must_use]
    pub fn new(form: VafrForm, display: &DisplayGeometry, gaze_px: DVec2, acuity: &Arc<AcuityModel>) -> Self {
        let mut made = Self {
            form,
            display: *display,
            acuity: acuity.clone(),
            frame: frame_of(form, display, gaze_px),
            columns: Arc::default(),
        };
        let count = acuity.columns_to(made.farthest_of_any_gaze_deg()).ceil().max(1.0) as u32;
        let height = |column: u32| {
            let texels = made.height_at_deg(acuity.eccentricity_deg(f64::from(column) + 0.5));
            (texels.round() as u32).max(1)
        };
        made.columns = Arc::new(ColumnLayout::new((0..count).map(height).collect()));
        made
    }

    /// Moves the gaze; allocates nothing.
    pub fn retarget(&mut self, gaze_px: DVec2) {
        self.frame = frame_of(self.form, &self.display, gaze_px);
    }

    /// The form.
    #[must_use]
    pub fn form(&self) -> VafrForm {
        self.form
    }

    /// Eccentricity of a display position in this form, degrees.
    #[must_use]
    pub fn eccentricity_deg(&self, px: DVec2) -> f64 {
        eccentricity_of_ray_rad(self.frame.ray(px)).to_degrees()
    }

    /// Display pixels over the pixels that the acuity asks for, per solid angle: at most 1 inside the
    /// native disc. Infinite in the planar form, which has none.
    #[must_use]
    pub fn pixels_over_acuity(&self, px: DVec2) -> f64 {
        let ray = self.frame.ray(px);
        self.display.pixels_per_steradian(ray.length())
            / self.acuity_per_steradian(eccentricity_of_ray_rad(ray))
    }

    /// The box of display pixels, as first and end in x and y, that holds every pixel which is shaded
    /// itself, those of the band included.
    #[must_use]
    pub fn native_box_px(&self) -> [[u32; 2]; 2] {
        let gaze_px = self.frame.gaze_px();
        let margin_px = LEAST_NATIVE_RADIUS_PX + 2.0;
        let (mut low, mut high) = (gaze_px - margin_px, gaze_px + margin_px);
        if let Some([cone_low, cone_high]) = self.native_cone_px() {
            (low, high) = (low.min(cone_low), high.max(cone_high));
        }
        let size = size_dvec2_px(self.display.size_px);
        // Casts of clamped values.
        let clipped = |px: DVec2| px.clamp(DVec2::ZERO, size).to_array().map(|value| value as u32);
        [clipped((low - 1.0).floor()), clipped((high + 1.0).ceil())]
    }

    /// The box of the cone about the gaze outside which no pixel is native.
    fn native_cone_px(&self) -> Option<[DVec2; 2]> {
        let gaze = self.display.ray_of_px(self.frame.gaze_px()).normalize();
        let off_axis_deg = gaze.truncate().length().atan2(-gaze.z).to_degrees();
        // A pixel within `ecc_deg` of the gaze is at best as far from the axis as this, and the farther
        // the denser.
        let may_be_native = |ecc_deg: f64| {
            let nearest = (off_axis_deg - ecc_deg).max(0.0).to_radians();
            let least_density = self.display.pixels_per_steradian(nearest.cos().recip());
            least_density <= (1.0 + NATIVE_BAND) * self.acuity_per_steradian(ecc_deg.to_radians())
        };
        const STEPS_PER_DEG: u32 = 8;
        let step_deg = |step: u32| f64::from(step) / f64::from(STEPS_PER_DEG);
        // From outside, as neither side need be monotone. One step more covers what lies between.
        let outermost = (0..180 * STEPS_PER_DEG).rev().find(|step| may_be_native(step_deg(*step)))?;
        Some(self.cone_box_px(gaze, step_deg(outermost + 1).to_radians()))
    }

    /// The box of a cone's section with the display's plane. The plane through the eye that touches the
    /// cone at its edge in x has the normal `(1, 0, X)`, at the cone's angle to the gaze.
    fn cone_box_px(&self, gaze: DVec3, half_angle_rad: f64) -> [DVec2; 2] {
        let size = size_dvec2_px(self.display.size_px);
        let sine = half_angle_rad.sin();
        let rest = gaze.z * gaze.z - sine * sine;
        if half_angle_rad >= PI / 2.0 || rest <= 0.0 {
            return [DVec2::ZERO, size];
        }
        let edges = |along: f64| {
            let swing = sine * (along * along + rest).max(0.0).sqrt();
            [(-along * gaze.z - swing) / rest, (-along * gaze.z + swing) / rest]
        };
        let (x, y) = (edges(gaze.x), edges(gaze.y));
        let ray = |x: f64, y: f64| self.display.px_of_ray(DVec3::new(x, y, -1.0)).unwrap_or(DVec2::ZERO);
        [ray(x[0], y[1]), ray(x[1], y[0])]
    }

    fn farthest_of_any_gaze_deg(&self) -> f64 {
        match self.form {
            VafrForm::Planar => 90.0,
            VafrForm::Sphere => {
                let d = &self.display;
                let x = d.tan_left.abs().max(d.tan_right.abs());
                let y = d.tan_up.abs().max(d.tan_down.abs());
                (90.0 + x.hypot(y).atan().to_degrees()).min(180.0)
            }
        }
    }

    fn height_at_deg(&self, ecc_deg: f64) -> f64 {
        match self.form {
            VafrForm::Sphere => self.acuity.height_on_sphere(ecc_deg),
            VafrForm::Planar => self.acuity.height_planar(ecc_deg),
        }
    }
}

fn frame_of(form: VafrForm, display: &DisplayGeometry, gaze_px: DVec2) -> GazeFrame {
    match form {
        VafrForm::Sphere => GazeFrame::on_sphere(display, gaze_px),
        VafrForm::Planar => GazeFrame::planar(display, gaze_px),
    }
}

impl Mapping for VafrMapping {
    fn display(&self) -> &DisplayGeometry {
        &self.display
    }

    fn gaze_px(&self) -> DVec2 {
        self.frame.gaze_px()
    }

    fn columns(&self) -> &ColumnLayout {
        &self.columns
    }

    fn column_height(&self, u: f64) -> f64 {
        self.height_at_deg(self.eccentricity_of_column_rad(u).to_degrees())
    }

    fn forward(&self, px: DVec2) -> Option<LpPoint> {
        let ray = self.frame.ray(px);
        let ecc_deg = eccentricity_of_ray_rad(ray).to_degrees();
        Some(LpPoint { u: self.acuity.columns_to(ecc_deg), v_share: azimuth_turns(ray) })
    }

    fn inverse(&self, point: LpPoint) -> Option<DVec2> {
        let (sine, cosine) = self.eccentricity_of_column_rad(point.u).sin_cos();
        let around = DVec2::from_angle(TAU * point.v_share);
        self.frame.px((around * sine).extend(cosine))
    }

    fn jacobian(&self, px: DVec2) -> Option<TexelJacobian> {
        let ray = self.frame.ray(px);
        let radius2 = ray.x * ray.x + ray.y * ray.y;
        if radius2 < f64::MIN_POSITIVE {
            return None;
        }
        let radius = radius2.sqrt();
        let ecc_deg = eccentricity_of_ray_rad(ray).to_degrees();
        let columns_per_rad = 2.0 * self.acuity.cpd(ecc_deg) * 1f64.to_degrees();
        let texels_per_rad = self.height_at_deg(ecc_deg) / TAU;
        let [along_x, along_y] = self.frame.steps().map(|step| {
            let outward = (ray.x * step.x + ray.y * step.y) / radius;
            let ecc_step = (ray.z * outward - radius * step.z) / ray.length_squared();
            let azimuth_step = (ray.x * step.y - ray.y * step.x) / radius2;
            DVec2::new(columns_per_rad * ecc_step, texels_per_rad * azimuth_step)
        });
        Some(TexelJacobian { du_dx: along_x.x, du_dy: along_y.x, dv_dx: along_x.y, dv_dy: along_y.y })
    }

    fn is_native(&self, px: DVec2) -> bool {
        px.distance(self.gaze_px()) <= LEAST_NATIVE_RADIUS_PX || self.pixels_over_acuity(px) <= 1.0
    }
}

impl RadialMapping for VafrMapping {
    fn frame(&self) -> GazeFrame {
        self.frame
    }

    fn eccentricity_of_column_rad(&self, u: f64) -> f64 {
        self.acuity.eccentricity_deg(u.clamp(0.0, self.columns.heights().len() as f64)).to_radians()
    }

    fn column_of_eccentricity(&self, ecc_rad: f64) -> f64 {
        self.acuity.columns_to(ecc_rad.to_degrees())
    }

    /// 0 in the planar form, so that no pixel counts as native.
    fn acuity_per_steradian(&self, ecc_rad: f64) -> f64 {
        match self.form {
            VafrForm::Planar => 0.0,
            VafrForm::Sphere => {
                let ecc_deg = ecc_rad.to_degrees();
                let per_rad = 2.0 * self.acuity.cpd(ecc_deg) * 1f64.to_degrees();
                self.acuity.delta(ecc_deg) * per_rad * per_rad
            }
        }
    }

    fn columns_in_use(&self) -> u32 {
        let all = self.columns.heights().len() as u32;
        let size = size_dvec2_px(self.display.size_px);
        let corners = [DVec2::ZERO, DVec2::new(size.x, 0.0), DVec2::new(0.0, size.y), size];
        let farthest_deg = corners.map(|px| self.eccentricity_deg(px)).into_iter().fold(0.0, f64::max);
        // The cone of a wider angle is not convex: an edge may lie farther than both of its ends.
        if farthest_deg >= 90.0 {
            all
        } else {
            (self.acuity.columns_to(farthest_deg).ceil() as u32 + 1).min(all)
        }
    }
}
