//! What every foveated method has in common: a mapping between the display and its LP-buffer, made
//! of columns.

use super::display::DisplayGeometry;
use glam::DVec2;

/// A point of the LP-buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LpPoint {
    /// Column coordinate, texels: column `j` covers `j..=j + 1`, its centre lies at `j + 0.5`.
    pub u: f64,
    /// Place along the column as a share of its height, from 0 to below 1. Polar methods: azimuth
    /// about the gaze as a share of a turn, 0 along the display's +x, rising towards +y (down).
    pub v_share: f64,
}

/// Derivatives of the LP coordinates by the display position, texels per px.
///
/// Those of v hold the column's height fixed: neighbouring columns of different heights are shifted
/// against each other, which changes no sample's area and no rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexelJacobian {
    /// Of u by x.
    pub du_dx: f64,
    /// Of u by y.
    pub du_dy: f64,
    /// Of v by x.
    pub dv_dx: f64,
    /// Of v by y.
    pub dv_dy: f64,
}

impl TexelJacobian {
    /// LP texels per px^2, never negative.
    #[must_use]
    pub fn density_per_px2(&self) -> f64 {
        (self.du_dx * self.dv_dy - self.du_dy * self.dv_dx).abs()
    }

    /// How far a step on the display goes in the LP-buffer, texels.
    #[must_use]
    pub fn step_texels(&self, step_px: DVec2) -> DVec2 {
        DVec2::new(
            self.du_dx * step_px.x + self.du_dy * step_px.y,
            self.dv_dx * step_px.x + self.dv_dy * step_px.y,
        )
    }
}

/// Heights of the LP-buffer's columns, and where each begins when all texels are counted column by
/// column.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ColumnLayout {
    heights: Vec<u32>,
    offsets: Vec<u64>,
}

impl ColumnLayout {
    /// From the columns' heights, texels, each at least 1.
    #[must_use]
    pub fn new(heights: Vec<u32>) -> Self {
        let mut offsets = Vec::with_capacity(heights.len() + 1);
        offsets.push(0);
        let mut total = 0;
        for &height in &heights {
            total += u64::from(height);
            offsets.push(total);
        }
        Self { heights, offsets }
    }

    /// Heights, texels, from the gaze outwards.
    #[must_use]
    pub fn heights(&self) -> &[u32] {
        &self.heights
    }

    /// Number of texels before each column; one entry more than columns, the last one being
    /// [`Self::texels`].
    #[must_use]
    pub fn offsets(&self) -> &[u64] {
        &self.offsets
    }

    /// Texels of all columns.
    #[must_use]
    pub fn texels(&self) -> u64 {
        self.offsets.last().copied().unwrap_or(0)
    }

    /// Width and height of an image that holds every column, texels, at least 1x1.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        let width = u32::try_from(self.heights.len()).unwrap_or(u32::MAX);
        [width.max(1), self.heights.iter().copied().max().unwrap_or(1)]
    }
}

/// Samples along and across the direction away from the gaze, cycles per degree (a cycle is two
/// samples).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rates {
    /// Along the great circle away from the gaze.
    pub radial_cpd: f64,
    /// Across it.
    pub tangential_cpd: f64,
}

/// The mapping of one frame: a method, a display and a gaze.
pub trait Mapping {
    /// Pixels and frustum.
    fn display(&self) -> &DisplayGeometry;

    /// The gaze in use, px; always finite.
    fn gaze_px(&self) -> DVec2;

    /// The LP-buffer's columns.
    fn columns(&self) -> &ColumnLayout;

    /// The analytic height at a column coordinate, texels, before rounding; a column has the rounded
    /// height at its centre.
    fn column_height(&self, u: f64) -> f64;

    /// From a finite display position to the LP-buffer. `None` where the method has no texels.
    fn forward(&self, px: DVec2) -> Option<LpPoint>;

    /// From the LP-buffer to the display, px; the position may lie off the display. `None` for a
    /// direction that does not meet the display's plane. `u` is clamped to the LP-buffer, and
    /// `v_share` is periodic for polar methods and else clamped.
    fn inverse(&self, point: LpPoint) -> Option<DVec2>;

    /// The analytic Jacobian at a display position. `None` where [`Self::forward`] is, and at the
    /// gaze itself where the azimuth is not defined.
    fn jacobian(&self, px: DVec2) -> Option<TexelJacobian>;

    /// Whether a display pixel with this centre is shaded itself, without the LP-buffer.
    fn is_native(&self, px: DVec2) -> bool;

    /// Sampling rates of the LP-buffer at a display position, from the analytic Jacobian; where the
    /// pixel is native, those of the display. `None` where neither is defined.
    fn rates(&self, px: DVec2) -> Option<Rates> {
        let display = self.display();
        let (radial, tangential) = display.steps_per_degree(self.gaze_px(), px)?;
        if self.is_native(px) {
            return Some(Rates {
                radial_cpd: radial.length() / 2.0,
                tangential_cpd: tangential.length() / 2.0,
            });
        }
        let jacobian = self.jacobian(px)?;
        Some(Rates {
            radial_cpd: jacobian.step_texels(radial).length() / 2.0,
            tangential_cpd: jacobian.step_texels(tangential).length() / 2.0,
        })
    }
}
