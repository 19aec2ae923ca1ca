//! KFR as one of several methods: its mapping in texels, with display and columns.

use super::display::DisplayGeometry;
use super::kernel::Kernel;
use super::kfr::{KfrMapping, LpCoord};
use super::mapping::{ColumnLayout, LpPoint, Mapping, TexelJacobian};
use glam::DVec2;

/// [`KfrMapping`] with what [`Mapping`] asks for beside it. With the kernel `x^4` this is what Zhang
/// et al. 2025 call LMFR (their Eq. 14).
#[derive(Clone, Debug)]
pub struct KfrColumns {
    mapping: KfrMapping,
    sigma: f64,
    display: DisplayGeometry,
    columns: ColumnLayout,
}

impl KfrColumns {
    /// The mapping for a checked display, a gaze (see [`KfrMapping::new`]), a checked kernel, and
    /// `sigma` (display width over LP-buffer width, above 0).
    #[must_use]
    pub fn new(display: DisplayGeometry, gaze_px: DVec2, kernel: Kernel, sigma: f64) -> Self {
        let mapping = KfrMapping::new(display.size_px, gaze_px, kernel, sigma);
        let [width, height] = mapping.lp_size();
        let columns = ColumnLayout::new(vec![height; width as usize]);
        Self { mapping, sigma, display, columns }
    }

    /// Changes the gaze; the LP-buffer keeps its size, and nothing is allocated.
    pub fn retarget(&mut self, gaze_px: DVec2) {
        self.mapping = KfrMapping::new(self.display.size_px, gaze_px, *self.mapping.kernel(), self.sigma);
    }

    /// The mapping in shares.
    #[must_use]
    pub fn mapping(&self) -> &KfrMapping {
        &self.mapping
    }
}

impl Mapping for KfrColumns {
    fn display(&self) -> &DisplayGeometry {
        &self.display
    }

    fn gaze_px(&self) -> DVec2 {
        self.mapping.gaze_px()
    }

    fn columns(&self) -> &ColumnLayout {
        &self.columns
    }

    fn column_height(&self, _u: f64) -> f64 {
        f64::from(self.mapping.lp_size()[1])
    }

    fn forward(&self, px: DVec2) -> Option<LpPoint> {
        let lp = self.mapping.forward(px);
        Some(LpPoint { u: lp.u_norm * f64::from(self.mapping.lp_size()[0]), v_share: lp.v_norm })
    }

    fn inverse(&self, point: LpPoint) -> Option<DVec2> {
        let u_norm = point.u / f64::from(self.mapping.lp_size()[0]);
        Some(self.mapping.inverse(LpCoord { u_norm, v_norm: point.v_share }))
    }

    fn jacobian(&self, px: DVec2) -> Option<TexelJacobian> {
        if px.distance(self.mapping.gaze_px()) < f64::MIN_POSITIVE {
            return None;
        }
        let [width, height] = self.mapping.lp_size().map(f64::from);
        let shares = self.mapping.jacobian(px);
        Some(TexelJacobian {
            du_dx: shares.du_dx * width,
            du_dy: shares.du_dy * width,
            dv_dx: shares.dv_dx * height,
            dv_dy: shares.dv_dy * height,
        })
    }

    fn is_native(&self, px: DVec2) -> bool {
        px.distance(self.mapping.gaze_px()) < self.mapping.native_radius_px()
    }
}
