//! The three layers of foveated 3D graphics (Guenter et al. 2012).
//!
//! Three nested images about the gaze: the inner one at the display's resolution, a middle and an outer one
//! at coarser sampling, each magnified to the display. Zhang et al. 2025 plot the method's steps but print no
//! parameters; these are the authors':
//!
//! - a linear MAR model `omega(e) = m e + omega_0`, degrees per cycle, with a slope of 1.32 (what their users
//!   found equal or better) to 1.65 arc minutes per degree;
//! - a layer's sampling factor is `omega` at the border where it takes over, relative to the display's
//!   own `omega*` (two pixels at the centre), at least 1;
//! - the outer layer covers the whole display; the two borders `e_1` and `e_2` are those that need the
//!   fewest samples in all.
//!
//! `omega_0 = 1/48` degree per cycle is not in the texts at hand; a fifth more or less changes the number
//! of samples by 5 %. With it, and the middle and the outer layer drawn in turns as the authors do, their
//! 1920x1080 desktop display needs 10 (1.32 arc minutes) to 13 times (1.65) fewer samples than pixels;
//! they report 10 to 15.
//!
//! Chosen here: layers keep their size for every gaze, follow it, and are cut off at the display's edge (what
//! hangs over is never read); no layer is snapped to a grid; the blend bands are those of KFR.

use super::axes::AxesLayer;
use super::display::{DisplayGeometry, size_dvec2_px};
use super::mapping::{ColumnLayout, LpPoint, Mapping, TexelJacobian};
use super::method::{below_one, gaze_in_use_px, within};
use crate::error::Result;
use glam::DVec2;

/// Half the inner layer's least size, px: the gazed pixel and its neighbours are always native.
const LEAST_NATIVE_HALF_PX: f64 = 1.5;

/// Parameters of [`GuenterMapping`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuenterParams {
    /// `m`: how the MAR rises with eccentricity, arc minutes per degree, 0.1..=10. Larger: coarser layers.
    pub slope_arcmin_per_deg: f64,
    /// `1/omega_0`: acuity at the gaze, cycles per degree, 1..=200. Larger: finer layers.
    pub foveal_cpd: f64,
}

impl GuenterParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`crate::error::Error::Setting`] for a parameter outside its range.
    pub fn check(&self) -> Result<()> {
        within("the slope of the MAR", self.slope_arcmin_per_deg, 0.1, 10.0)?;
        within("the foveal acuity", self.foveal_cpd, 1.0, 200.0)
    }

    /// `omega(e)`: degrees per cycle at an eccentricity in degrees.
    #[must_use]
    pub fn mar_deg(&self, eccentricity_deg: f64) -> f64 {
        self.slope_arcmin_per_deg / 60.0 * eccentricity_deg + self.foveal_cpd.recip()
    }
}

impl Default for GuenterParams {
    /// The authors' conservative slope.
    fn default() -> Self {
        Self { slope_arcmin_per_deg: 1.32, foveal_cpd: 48.0 }
    }
}

/// One of the two layers that lie in the LP-buffer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GuenterLayer {
    /// Its first column in the LP-buffer.
    pub first_column: u32,
    /// Columns and rows, texels.
    pub size: [u32; 2],
    /// Its upper left corner on the display, px; may lie off the display.
    pub origin_px: DVec2,
    /// Width and height of a texel on the display, px.
    pub px_per_texel: DVec2,
}

impl GuenterLayer {
    /// Its extent on the display, px.
    #[must_use]
    pub fn extent_px(&self) -> DVec2 {
        size_dvec2_px(self.size) * self.px_per_texel
    }

    /// Whether it covers a display position.
    #[must_use]
    pub fn covers(&self, px: DVec2) -> bool {
        let inside_px = px - self.origin_px;
        inside_px.cmpge(DVec2::ZERO).all() && inside_px.cmplt(self.extent_px()).all()
    }

    fn point(&self, px: DVec2) -> LpPoint {
        let [columns, rows] = self.size.map(f64::from);
        let texel = (px - self.origin_px) / self.px_per_texel;
        LpPoint {
            u: f64::from(self.first_column) + texel.x.clamp(0.0, columns),
            v_share: below_one(texel.y / rows),
        }
    }
}

/// Pixels of the display's centre per unit of tangent, and what follows from them.
struct Optics {
    size_px: DVec2,
    focal_px: DVec2,
}

impl Optics {
    fn new(display: &DisplayGeometry) -> Self {
        let size_px = size_dvec2_px(display.size_px);
        let tangents = DVec2::new(display.tan_right - display.tan_left, display.tan_up - display.tan_down);
        // A frustum that is all but closed must not make this infinite.
        Self { size_px, focal_px: size_px / tangents.max(DVec2::splat(1e-12)) }
    }

    /// The eccentricity at which a layer about the centre covers the display, degrees.
    fn most_deg(&self) -> f64 {
        (self.size_px / self.focal_px / 2.0).max_element().atan().to_degrees()
    }

    /// Half the size of a layer that ends at an eccentricity, px.
    fn half_px(&self, eccentricity_deg: f64) -> DVec2 {
        (eccentricity_deg.to_radians().tan() * self.focal_px).max(DVec2::splat(LEAST_NATIVE_HALF_PX))
    }

    /// Pixels per texel of a layer that begins at an eccentricity.
    fn factor(&self, params: &GuenterParams, eccentricity_deg: f64) -> DVec2 {
        let pixel_mar_deg = DVec2::new((2.0 / self.focal_px.x).atan(), (2.0 / self.focal_px.y).atan());
        (params.mar_deg(eccentricity_deg) / (pixel_mar_deg * 1f64.to_degrees()))
            .clamp(DVec2::ONE, self.size_px)
    }

    /// Samples of all three layers with the gaze at the centre.
    fn samples(&self, params: &GuenterParams, borders_deg: [f64; 2]) -> f64 {
        let [inner, middle] = borders_deg.map(|border| {
            let extent_px = (2.0 * self.half_px(border)).min(self.size_px);
            extent_px.x * extent_px.y
        });
        let [middle_factor, outer_factor] = borders_deg.map(|border| {
            let factor = self.factor(params, border);
            factor.x * factor.y
        });
        inner + middle / middle_factor + self.size_px.x * self.size_px.y / outer_factor
    }

    /// The borders `e_1 <= e_2` with the fewest samples, degrees: a coarse grid, then finer ones about the
    /// best point so far.
    fn best_borders_deg(&self, params: &GuenterParams) -> [f64; 2] {
        const STEPS: u32 = 48;
        const ROUNDS: u32 = 5;
        let most_deg = self.most_deg();
        let mut best = [most_deg; 2];
        let mut least = self.samples(params, best);
        let (mut centre, mut half_width) = ([most_deg / 2.0; 2], most_deg / 2.0);
        for _ in 0..ROUNDS {
            for index in 0..=STEPS * (STEPS + 2) {
                let share = |step: u32| 2.0 * f64::from(step) / f64::from(STEPS) - 1.0;
                let steps = [index / (STEPS + 1), index % (STEPS + 1)];
                let borders = [0, 1]
                    .map(|axis: usize| (centre[axis] + half_width * share(steps[axis])).clamp(0.0, most_deg));
                let samples = self.samples(params, borders);
                if borders[0] <= borders[1] && samples < least {
                    (best, least) = (borders, samples);
                }
            }
            (centre, half_width) = (best, half_width * 4.0 / f64::from(STEPS));
        }
        best
    }
}

/// Guenter et al.'s mapping of one frame: an inner rectangle of native pixels, and an LP-buffer that holds
/// the middle layer's columns and then the outer layer's.
///
/// Inside the inner rectangle, too, positions map to the middle layer, which the blend band needs.
#[derive(Clone, Debug)]
pub struct GuenterMapping {
    display: DisplayGeometry,
    columns: ColumnLayout,
    borders_deg: [f64; 2],
    native_half_px: DVec2,
    gaze_px: DVec2,
    layers: [GuenterLayer; 2],
    axes_layers: [AxesLayer; 2],
}

impl GuenterMapping {
    /// The mapping for a checked display, checked parameters and a gaze on the display or off it. A gaze
    /// farther than [`super::MAX_GAZE_PX`] is clamped, and one that is not finite is taken as the
    /// display's centre.
    #[must_use]
    pub fn new(display: DisplayGeometry, gaze_px: DVec2, params: GuenterParams) -> Self {
        debug_assert!(params.check().is_ok(), "the parameters are checked by the settings");
        let optics = Optics::new(&display);
        let borders_deg = optics.best_borders_deg(&params);
        let texels = |extent_px: DVec2, factor: DVec2| {
            let texels = (extent_px / factor).ceil();
            [texels.x as u32, texels.y as u32].map(|count| count.max(1))
        };
        // Twice the display covers all of it from any gaze on it.
        let middle_px = (2.0 * optics.half_px(borders_deg[1])).min(2.0 * optics.size_px);
        let middle_factor = optics.factor(&params, borders_deg[0]);
        let middle = GuenterLayer {
            first_column: 0,
            size: texels(middle_px, middle_factor),
            origin_px: DVec2::ZERO,
            px_per_texel: middle_factor,
        };
        let outer_size = texels(optics.size_px, optics.factor(&params, borders_deg[1]));
        let outer = GuenterLayer {
            first_column: middle.size[0],
            size: outer_size,
            origin_px: DVec2::ZERO,
            px_per_texel: optics.size_px / size_dvec2_px(outer_size),
        };
        let heights = [middle, outer].into_iter().flat_map(|layer| {
            let [columns, rows] = layer.size;
            std::iter::repeat_n(rows, columns as usize)
        });
        let mut mapping = Self {
            display,
            columns: ColumnLayout::new(heights.collect()),
            borders_deg,
            native_half_px: optics.half_px(borders_deg[0]),
            gaze_px,
            layers: [middle, outer],
            axes_layers: [middle, outer]
                .map(|layer| AxesLayer { first_column: layer.first_column, rows: layer.size[1] }),
        };
        mapping.retarget(gaze_px);
        mapping
    }

    /// Changes the gaze; the LP-buffer keeps its size, and nothing is allocated.
    pub fn retarget(&mut self, gaze_px: DVec2) {
        self.gaze_px = gaze_in_use_px(self.display.size_px, gaze_px);
        self.layers[0].origin_px = self.gaze_px - self.layers[0].extent_px() / 2.0;
    }

    /// The middle and the outer layer.
    #[must_use]
    pub fn layers(&self) -> [GuenterLayer; 2] {
        self.layers
    }

    /// `e_1` and `e_2`: where the inner and the middle layer end, degrees, with the gaze at the centre.
    #[must_use]
    pub fn borders_deg(&self) -> [f64; 2] {
        self.borders_deg
    }

    /// Upper left and lower right corner of the inner layer, cut off at the display's edge, px. Of a gaze
    /// far off the display nothing is left: a corner is not lower right of the other.
    #[must_use]
    pub fn native_rect_px(&self) -> [DVec2; 2] {
        [
            (self.gaze_px - self.native_half_px).max(DVec2::ZERO),
            (self.gaze_px + self.native_half_px).min(size_dvec2_px(self.display.size_px)),
        ]
    }

    /// Widths of the bands inside the inner and the middle layer's edges in which they blend with the next
    /// layer, px: a tenth of half the layer's size, within 1..=8 of its texels.
    #[must_use]
    pub fn blend_bands_px(&self) -> [f64; 2] {
        let middle = &self.layers[0];
        let band_px = |half_px: DVec2, texel_px: DVec2| {
            let texel_px = texel_px.max_element();
            (half_px.min_element() * 0.1).clamp(texel_px, 8.0 * texel_px)
        };
        [band_px(self.native_half_px, DVec2::ONE), band_px(middle.extent_px() / 2.0, middle.px_per_texel)]
    }

    /// Where the layers lie in the LP-buffer.
    pub(super) fn axes_layers(&self) -> &[AxesLayer] {
        &self.axes_layers
    }

    /// A position in the middle layer (0) or the outer one.
    pub(super) fn point_in_layer(&self, layer: usize, px: DVec2) -> LpPoint {
        self.layers[layer.min(1)].point(px)
    }

    /// The finest layer that covers a position; where none does the outer one.
    fn layer(&self, px: DVec2) -> &GuenterLayer {
        let [middle, outer] = &self.layers;
        if middle.covers(px) { middle } else { outer }
    }

    fn layer_of_column(&self, u: f64) -> &GuenterLayer {
        let [middle, outer] = &self.layers;
        if u < f64::from(outer.first_column) { middle } else { outer }
    }
}

impl Mapping for GuenterMapping {
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
        f64::from(self.layer_of_column(u).size[1])
    }

    fn forward(&self, px: DVec2) -> Option<LpPoint> {
        let layer = self.layer(px);
        let mut point = layer.point(px);
        if layer.first_column == 0 {
            // The middle layer's right edge must not become the outer layer's first column.
            point.u = point.u.min(f64::from(layer.size[0]).next_down());
        }
        Some(point)
    }

    fn inverse(&self, point: LpPoint) -> Option<DVec2> {
        let layer = self.layer_of_column(point.u);
        let [columns, rows] = layer.size.map(f64::from);
        let column = (point.u - f64::from(layer.first_column)).clamp(0.0, columns);
        let texel = DVec2::new(column, below_one(point.v_share) * rows);
        Some(layer.origin_px + texel * layer.px_per_texel)
    }

    fn jacobian(&self, px: DVec2) -> Option<TexelJacobian> {
        let layer = self.layer(px);
        let inside_px = px - layer.origin_px;
        let extent_px = layer.extent_px();
        // Beyond the outer layer's edges positions are clamped.
        let slope = |inside_px: f64, extent_px: f64, texel_px: f64| {
            if (0.0..=extent_px).contains(&inside_px) { texel_px.recip() } else { 0.0 }
        };
        Some(TexelJacobian {
            du_dx: slope(inside_px.x, extent_px.x, layer.px_per_texel.x),
            du_dy: 0.0,
            dv_dx: 0.0,
            dv_dy: slope(inside_px.y, extent_px.y, layer.px_per_texel.y),
        })
    }

    fn is_native(&self, px: DVec2) -> bool {
        let [low, high] = self.native_rect_px();
        px.cmpge(low).all() && px.cmplt(high).all()
    }
}
