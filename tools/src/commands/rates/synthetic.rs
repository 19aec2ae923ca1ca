//! A mapping for tests that samples at the same known rates everywhere outside its native disc.

use glam::{DMat2, DVec2, DVec3};
use macula::fovea::{ColumnLayout, DisplayGeometry, LpPoint, Mapping, TexelJacobian};

/// Samples at constant rates on the sphere around the gaze ray.
pub struct Constant {
    display: DisplayGeometry,
    gaze_px: DVec2,
    cpd: [f64; 2],
    native_deg: f64,
    columns: ColumnLayout,
}

impl Constant {
    /// With these radial and tangential rates, a native disc of that radius, and columns to `reach_deg`.
    pub fn new(
        display: DisplayGeometry,
        gaze_px: DVec2,
        cpd: [f64; 2],
        native_deg: f64,
        reach_deg: f64,
    ) -> Self {
        let count = (2.0 * cpd[0] * reach_deg) as u32;
        let mut made = Self { display, gaze_px, cpd, native_deg, columns: ColumnLayout::new(vec![]) };
        let heights = (0..count).map(|column| made.column_height(f64::from(column) + 0.5).round() as u32);
        made.columns = ColumnLayout::new(heights.map(|height| height.max(1)).collect());
        made
    }

    /// The gaze ray, and right and down as seen along it; from another rule than that of the code under
    /// test, which they turn with.
    fn frame(&self) -> [DVec3; 3] {
        let gaze = self.display.ray_of_px(self.gaze_px).normalize();
        let right = self.display.ray_of_px(self.gaze_px + DVec2::X).reject_from(gaze).normalize();
        [gaze, right, gaze.cross(right)]
    }

    fn ecc_deg(&self, px: DVec2) -> f64 {
        self.frame()[0].angle_between(self.display.ray_of_px(px)).to_degrees()
    }
}

impl Mapping for Constant {
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
        720.0 * self.cpd[1] * (u / (2.0 * self.cpd[0])).to_radians().sin()
    }

    fn forward(&self, px: DVec2) -> Option<LpPoint> {
        let ([_, right, down], ray) = (self.frame(), self.display.ray_of_px(px));
        let turns = ray.dot(down).atan2(ray.dot(right)).to_degrees() / 360.0;
        Some(LpPoint { u: 2.0 * self.cpd[0] * self.ecc_deg(px), v_share: turns.rem_euclid(1.0) })
    }

    fn inverse(&self, point: LpPoint) -> Option<DVec2> {
        let [gaze, right, down] = self.frame();
        let ecc = (point.u / (2.0 * self.cpd[0])).to_radians();
        let azimuth = (360.0 * point.v_share).to_radians();
        let outward = right * azimuth.cos() + down * azimuth.sin();
        self.display.px_of_ray(gaze * ecc.cos() + outward * ecc.sin())
    }

    fn jacobian(&self, px: DVec2) -> Option<TexelJacobian> {
        let (radial, tangential) = self.display.steps_per_degree(self.gaze_px, px)?;
        let texels = DMat2::from_diagonal(2.0 * DVec2::from_array(self.cpd));
        let per_px = texels * DMat2::from_cols(radial, tangential).inverse();
        let [du_dx, dv_dx, du_dy, dv_dy] = per_px.to_cols_array();
        Some(TexelJacobian { du_dx, du_dy, dv_dx, dv_dy })
    }

    fn is_native(&self, px: DVec2) -> bool {
        self.ecc_deg(px) <= self.native_deg
    }
}
