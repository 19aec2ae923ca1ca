//! The methods' mappings.

use glam::DVec2;
use macula::fovea::{ColumnLayout, DisplayGeometry, LpPoint, Mapping, TexelJacobian};
use macula::settings::Method;

/// A method's mapping for a checked display and a gaze.
pub fn mapping_of(method: &Method, display: &DisplayGeometry, gaze_px: DVec2) -> Box<dyn Mapping> {
    method.mapping(display, gaze_px).unwrap_or_else(|| Box::new(Pixels::new(*display, gaze_px)))
}

/// Full shading: every pixel is native, and there is no LP-buffer.
struct Pixels {
    display: DisplayGeometry,
    gaze_px: DVec2,
    columns: ColumnLayout,
}

impl Pixels {
    fn new(display: DisplayGeometry, gaze_px: DVec2) -> Self {
        Self { display, gaze_px, columns: ColumnLayout::new(vec![]) }
    }
}

impl Mapping for Pixels {
    fn display(&self) -> &DisplayGeometry {
        &self.display
    }

    fn gaze_px(&self) -> DVec2 {
        self.gaze_px
    }

    fn columns(&self) -> &ColumnLayout {
        &self.columns
    }

    fn column_height(&self, _: f64) -> f64 {
        0.0
    }

    fn forward(&self, _: DVec2) -> Option<LpPoint> {
        None
    }

    fn inverse(&self, _: LpPoint) -> Option<DVec2> {
        None
    }

    fn jacobian(&self, _: DVec2) -> Option<TexelJacobian> {
        None
    }

    fn is_native(&self, _: DVec2) -> bool {
        true
    }
}
