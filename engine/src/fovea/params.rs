//! What the shaders need to know of the mapping.

use super::axes::AxesMapping;
use super::kernel::{Kernel, MAX_COEFFICIENTS};
use super::kfr::{KfrMapping, LEAST_NATIVE_RADIUS_PX};
use super::radial::{FORWARD_KNOTS, INVERSE_NATIVE_BAND, RadialMapping, forward_reach};
use bytemuck::Zeroable;
use glam::DVec2;
use std::f64::consts::{LN_2, LOG2_E};

/// A gaze farther from the display's origin than this is moved onto this circle, px. The mapping's
/// single-precision twin is exact to 1e-6 px up to here.
pub const MAX_GAZE_PX: f64 = 1e7;

/// The mapping as the shaders see it; `FoveaParams` in `shaders/shared/fovea.glsl` has the same
/// layout. All members are vectors of 16 bytes, for which std140, std430 and `repr(C)` agree.
///
/// Values marked *hi, lo* are pairs of which the sum carries about 48 bits: single precision alone
/// would cost more than 1e-4 px on a large display.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct FoveaParams {
    /// Gaze on the display, px: x hi, y hi, x lo, y lo.
    pub gaze_px: [f32; 4],
    /// Display width and height (px), LP-buffer width and height (texels).
    pub size: [u32; 4],
    /// LP-buffer width and height as floats, display width and height (px).
    pub size_f: [f32; 4],
    /// `L` hi, lo (L = ln of the distance to the farthest corner in px), `1/L` hi, lo.
    pub log_reach: [f32; 4],
    /// `ln 2 / (2 L)` head, tail (the head has 16 bits, so that its product with a small integer is
    /// exact), `L / ln 2` hi, lo: scales of the fast paths.
    pub octave: [f32; 4],
    /// Kernel kind (0 power, 1 polynomial, 2 sine, 3 exponential), the power's exponent where it is
    /// an integer and else 0, number of polynomial coefficients, 0.
    pub kernel: [u32; 4],
    /// The power's exponent alpha hi, lo, `1/alpha`, 0.
    pub shape: [f32; 4],
    /// Native radius (px), blend band (px), `u_norm` from which the LP filter works (1: it
    /// does not), distance to the farthest corner (px).
    pub ring: [f32; 4],
    /// `beta_0` to `beta_7`, hi.
    pub beta_hi: [[f32; 4]; 2],
    /// `beta_0` to `beta_7`, lo.
    pub beta_lo: [[f32; 4]; 2],
    /// Where the offsets of the gaze's frame are counted from, px: x hi, y hi, x lo, y lo.
    pub base_px: [f32; 4],
    /// Rows of the matrix from `(offset, 1)` to the ray in the gaze's frame.
    pub ray_rows: [[f32; 4]; 3],
    /// Rows of its inverse.
    pub px_rows: [[f32; 4]; 3],
    /// Unit normals, pointing inwards, of the planes through the frame's origin and the display's left,
    /// right, upper and lower edge.
    pub edges: [[f32; 4]; 4],
    /// Radial methods: knots of the forward table per unit of its abscissa, its last knot, pixels per
    /// unit of the plane at distance 1, and 1 over the width of the native disc's band.
    pub table: [f32; 4],
    /// First pixel (x, y) and end (x, y) of the box that holds all native pixels.
    pub native_box: [i32; 4],
    /// Methods by axes: the native rectangle, px: x0, y0, x1, y1.
    pub native_rect: [f32; 4],
    /// Methods by axes: where the finer of two layers is used, px: x0, y0, x1, y1.
    pub layer_rect: [f32; 4],
    /// Methods by axes: bands inside those two rectangles in which they pass over to what lies outside
    /// (px), columns of the finer layer, where the coarser layer begins in the forward table. Radial
    /// methods: 1 for knots that are dense at the end, else 0.
    pub axes: [f32; 4],
}

impl FoveaParams {
    /// The block for a mapping.
    #[must_use]
    pub fn new(mapping: &KfrMapping) -> Self {
        let (gaze_x, gaze_y) = (hi_lo(mapping.gaze_px().x), hi_lo(mapping.gaze_px().y));
        let log_reach = mapping.log_reach();
        let (reach, reach_inverse) = (hi_lo(log_reach), hi_lo(log_reach.recip()));
        let octave_z = LN_2 / (2.0 * log_reach);
        let octave_head = f32::from_bits((octave_z as f32).to_bits() & 0xffff_ff00);
        let octave_tail = (octave_z - f64::from(octave_head)) as f32;
        let octaves = hi_lo(log_reach * LOG2_E);
        let [lp_width, lp_height] = mapping.lp_size();
        let [width, height] = mapping.size_px();
        let (alpha, beta) = match *mapping.kernel() {
            Kernel::Power { alpha } => (alpha, [0.0; MAX_COEFFICIENTS]),
            Kernel::Polynomial { beta } => (1.0, beta),
            Kernel::Sine | Kernel::Exponential => (1.0, [0.0; MAX_COEFFICIENTS]),
        };
        let count = beta.iter().rposition(|value| *value != 0.0).map_or(0, |last| last + 1);
        let alpha_pair = hi_lo(alpha);
        let beta = beta.map(hi_lo);
        let rows = |part: usize| {
            [[0, 1, 2, 3], [4, 5, 6, 7]].map(|row: [usize; 4]| row.map(|index| beta[index][part]))
        };
        Self {
            gaze_px: [gaze_x[0], gaze_y[0], gaze_x[1], gaze_y[1]],
            size: [width, height, lp_width, lp_height],
            size_f: [lp_width as f32, lp_height as f32, width as f32, height as f32],
            log_reach: [reach[0], reach[1], reach_inverse[0], reach_inverse[1]],
            octave: [octave_head, octave_tail, octaves[0], octaves[1]],
            kernel: [kind(mapping.kernel()), integer_alpha(mapping.kernel()), count as u32, 0],
            shape: [alpha_pair[0], alpha_pair[1], alpha.recip() as f32, 0.0],
            ring: [
                mapping.native_radius_px() as f32,
                mapping.blend_band_px() as f32,
                mapping.filter_start_u() as f32,
                mapping.reach_px() as f32,
            ],
            beta_hi: rows(0),
            beta_lo: rows(1),
            ..Self::zeroed()
        }
        .with_disc(mapping.native_radius_px())
    }

    /// The block with another native disc, px.
    #[must_use]
    pub fn with_disc(mut self, radius_px: f64) -> Self {
        let size = DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]));
        let gaze_px = DVec2::new(f64::from(self.gaze_px[0]), f64::from(self.gaze_px[1]));
        let corner = |px: DVec2| px.clamp(DVec2::ZERO, size).as_ivec2();
        let first = corner((gaze_px - radius_px).floor());
        let end = corner((gaze_px + radius_px).ceil());
        self.ring[0] = radius_px as f32;
        self.native_box = [first.x, first.y, end.x, end.y];
        self
    }

    /// The block with its native disc cut down to a box of this size, px: what was recorded has no room
    /// for more.
    #[must_use]
    pub fn within_box(mut self, [width, height]: [u32; 2]) -> Self {
        let [x0, y0, x1, y1] = self.native_box;
        let room = |side: u32| i32::try_from(side).unwrap_or(i32::MAX);
        let fits = x1 - x0 <= room(width) && y1 - y0 <= room(height);
        if !fits {
            let least = width.min(height) as f32;
            self.ring[0] = self.ring[0].min(least / 2.0 - 1.0);
            self.native_box = [x0, y0, x1.min(x0 + room(width)), y1.min(y0 + room(height))];
        }
        self
    }

    /// The block for a mapping by eccentricity. `height`: of the LP-buffer's image, texels.
    #[must_use]
    pub fn of_radial(mapping: &impl RadialMapping, height: u32) -> Self {
        let gaze = mapping.gaze_px();
        let (gaze_x, gaze_y) = (hi_lo(gaze.x), hi_lo(gaze.y));
        let [width, display_height] = mapping.display().size_px;
        let columns = mapping.columns_in_use();
        let (base_px, ray_rows, px_rows) = mapping.frame().rows();
        let edges = mapping.frame().edges([width, display_height]);
        let last = (FORWARD_KNOTS - 1) as f64;
        let pixel = mapping.frame().least_step();
        // Around the singular point; wider where pixels are compared with the acuity.
        let hole_px = LEAST_NATIVE_RADIUS_PX as f32;
        Self {
            gaze_px: [gaze_x[0], gaze_y[0], gaze_x[1], gaze_y[1]],
            size: [width, display_height, columns, height],
            size_f: [columns as f32, height as f32, width as f32, display_height as f32],
            ring: [
                hole_px + 1.0,
                1.0,
                1.0,
                super::display::farthest_corner_px([width, display_height], gaze).max(2.0) as f32,
            ],
            base_px,
            ray_rows,
            px_rows,
            edges,
            table: [
                (last / forward_reach(mapping)) as f32,
                last as f32,
                pixel.recip() as f32,
                INVERSE_NATIVE_BAND,
            ],
            axes: [f32::from(u8::from(mapping.ends_like_a_root())), 0.0, 0.0, 0.0],
            ..Self::zeroed()
        }
        .with_disc(f64::from(hole_px) + 1.0)
    }

    /// The block with the box of its native pixels, as first and end in px.
    #[must_use]
    pub fn with_box(mut self, native_box_px: [[u32; 2]; 2]) -> Self {
        let [first, end] = native_box_px.map(|px| px.map(|value| value as i32));
        self.native_box = [first[0], first[1], end[0], end[1]];
        self
    }

    /// The block for a mapping by axes. `height`: of the LP-buffer's image, texels.
    #[must_use]
    pub fn of_axes(mapping: &impl AxesMapping, height: u32) -> Self {
        let gaze = mapping.gaze_px();
        let (gaze_x, gaze_y) = (hi_lo(gaze.x), hi_lo(gaze.y));
        let [width, display_height] = mapping.display().size_px;
        let columns = mapping.columns().size()[0];
        let finer = mapping.layers().get(1).map_or(0, |outer| outer.first_column);
        let rect = |corners: Option<[DVec2; 2]>| match corners {
            Some([low, high]) => [low.x, low.y, high.x, high.y].map(|value| value as f32),
            // Nothing lies inside.
            None => [1e9, 1e9, -1e9, -1e9],
        };
        let size_px = DVec2::new(f64::from(width), f64::from(display_height));
        let native_rect = rect(mapping.native_rect_px().map(|corners| beyond_edges(corners, size_px)));
        let [band, finer_band] = mapping.bands_px().map(|band| band as f32);
        let first = |value: f32| value.max(0.0) as i32;
        let end = |value: f32, side: u32| (value.ceil().max(0.0) as i32).min(side as i32);
        Self {
            gaze_px: [gaze_x[0], gaze_y[0], gaze_x[1], gaze_y[1]],
            size: [width, display_height, columns, height],
            size_f: [columns as f32, height as f32, width as f32, display_height as f32],
            ring: [0.0, 1.0, 1.0, 2.0],
            native_box: [
                first(native_rect[0]).min(width as i32),
                first(native_rect[1]).min(display_height as i32),
                end(native_rect[2], width),
                end(native_rect[3], display_height),
            ],
            native_rect,
            layer_rect: rect(mapping.finer_rect_px()),
            axes: [
                band,
                finer_band,
                finer as f32,
                if finer > 0 { (width + display_height) as f32 } else { 0.0 },
            ],
            ..Self::zeroed()
        }
    }
}

/// A rectangle that goes on where it ends at the display's edge: pixels there blend with nothing outside.
fn beyond_edges([low, high]: [DVec2; 2], size_px: DVec2) -> [DVec2; 2] {
    const FAR_PX: DVec2 = DVec2::splat(1e9);
    [DVec2::select(low.cmple(DVec2::ZERO), -FAR_PX, low), DVec2::select(high.cmpge(size_px), FAR_PX, high)]
}

fn kind(kernel: &Kernel) -> u32 {
    match kernel {
        Kernel::Power { .. } => 0,
        Kernel::Polynomial { .. } => 1,
        Kernel::Sine => 2,
        Kernel::Exponential => 3,
    }
}

fn integer_alpha(kernel: &Kernel) -> u32 {
    match *kernel {
        Kernel::Power { alpha } if alpha.fract() == 0.0 && (1.0..=6.0).contains(&alpha) => alpha as u32,
        _ => 0,
    }
}

/// The nearest single-precision value and what it leaves.
fn hi_lo(value: f64) -> [f32; 2] {
    let hi = value as f32;
    [hi, (value - f64::from(hi)) as f32]
}

/// A finite gaze, at most [`MAX_GAZE_PX`] from the display's origin, in the same direction.
pub(super) fn clamp_gaze_px(gaze_px: DVec2) -> DVec2 {
    let most_px = gaze_px.abs().max_element();
    if most_px <= MAX_GAZE_PX / 2.0 {
        return gaze_px;
    }
    // Scaled first: the square of a coordinate near the largest double overflows.
    let scaled = gaze_px / most_px;
    let share = MAX_GAZE_PX / most_px / scaled.length();
    if share < 1.0 { gaze_px * share } else { gaze_px }
}

/// Keeps the last valid gaze, for when the eye tracker delivers one that is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GazeKeeper {
    /// The gaze that stands in for an invalid one, px.
    pub last_valid: DVec2,
}

impl GazeKeeper {
    /// Starts from a finite gaze, usually the display's centre, px.
    #[must_use]
    pub fn new(start_px: DVec2) -> Self {
        Self { last_valid: if start_px.is_finite() { clamp_gaze_px(start_px) } else { DVec2::ZERO } }
    }

    /// The gaze to render with, px, and whether it is the given one (clamped to [`MAX_GAZE_PX`] from
    /// the display's origin where it is farther). One that is not finite yields the last valid gaze
    /// and `false`.
    pub fn accept(&mut self, gaze_px: DVec2) -> (DVec2, bool) {
        let valid = gaze_px.is_finite();
        if valid {
            self.last_valid = clamp_gaze_px(gaze_px);
        }
        (self.last_valid, valid)
    }
}
