//! What the shaders are given of a mapping that takes the display's two axes one by one: tables of the
//! columns and rows of its layers, and of the display's columns and rows.

use super::guenter::GuenterMapping;
use super::mapping::{LpPoint, Mapping};
use super::radial::{ColumnRow, ForwardKnot};
use super::rmfr::RmfrMapping;
use glam::DVec2;

/// A mapping whose column depends on x only and whose row on y only, in one or two layers.
pub trait AxesMapping: Mapping {
    /// The layers, finer first: the column at which each begins, and its rows.
    fn layers(&self) -> &[AxesLayer];

    /// A display position in one of the layers, whether or not that is the one in use there.
    fn in_layer(&self, layer: usize, px: DVec2) -> LpPoint;

    /// Corners of the rectangle in which pixels are shaded themselves, px; `None` without one.
    fn native_rect_px(&self) -> Option<[DVec2; 2]>;

    /// Corners of the rectangle in which the finer of two layers is used, px; `None` for one layer.
    fn finer_rect_px(&self) -> Option<[DVec2; 2]>;

    /// Widths of the bands inside those two rectangles in which they pass over to what lies outside, px.
    fn bands_px(&self) -> [f64; 2];
}

/// Where a layer lies in the LP-buffer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AxesLayer {
    /// First column.
    pub first_column: u32,
    /// Rows, texels.
    pub rows: u32,
}

/// How far inside a texel's edges they are looked up, texels: an edge itself may belong to a neighbour in
/// another layer.
const INSET: f64 = 1e-6;

/// Rows of the table by columns and rows that [`fill_axes_columns`] fills, counted in halves of a
/// [`ColumnRow`].
#[must_use]
pub fn axes_table_rows(mapping: &impl AxesMapping) -> usize {
    let rows: usize = mapping.layers().iter().map(|layer| layer.rows as usize).sum();
    2 * mapping.columns().heights().len() + rows
}

/// Knots of the forward table: for each layer one for each display column and each display row.
#[must_use]
pub fn axes_knots(mapping: &impl AxesMapping) -> usize {
    let [width, height] = mapping.display().size_px;
    mapping.layers().len() * (width as usize + height as usize)
}

/// Fills the table by columns and rows. A column: x at its left edge, its centre and its right edge, where
/// its rows begin after the columns; 0, 0, its height, 0. A row: y at its upper edge, its centre and its
/// lower edge, 0. The last row of the buffer may be half used.
pub fn fill_axes_columns(mapping: &impl AxesMapping, table: &mut [ColumnRow]) {
    let table = table.as_flattened_mut();
    let heights = mapping.columns().heights();
    let place = |u: f64, v_share: f64| mapping.inverse(LpPoint { u, v_share }).unwrap_or_default();
    let mut first_row = 0;
    for (index, layer) in mapping.layers().iter().enumerate() {
        let end = mapping.layers().get(index + 1).map_or(heights.len(), |next| next.first_column as usize);
        for column in layer.first_column as usize..end {
            let left = column as f64;
            let x = [INSET, 0.5, 1.0 - INSET].map(|offset| place(left + offset, 0.0).x as f32);
            table[2 * column] = [x[0], x[1], x[2], first_row as f32];
            table[2 * column + 1] = [0.0, 0.0, layer.rows as f32, 0.0];
        }
        let u = f64::from(layer.first_column) + 0.5;
        for row in 0..layer.rows as usize {
            let share = |offset: f64| (row as f64 + offset) / f64::from(layer.rows);
            let y = [INSET, 0.5, 1.0 - INSET].map(|offset| place(u, share(offset)).y as f32);
            table[2 * heights.len() + first_row + row] = [y[0], y[1], y[2], 0.0];
        }
        first_row += layer.rows as usize;
    }
}

/// Fills the forward table: column coordinates of the display's columns, then shares of the display's
/// rows, layer by layer.
pub fn fill_axes_forward(mapping: &impl AxesMapping, knots: &mut [ForwardKnot]) {
    let [width, height] = mapping.display().size_px.map(|side| side as usize);
    for layer in 0..mapping.layers().len() {
        let knots = &mut knots[layer * (width + height)..];
        for (x, knot) in knots[..width].iter_mut().enumerate() {
            *knot = [mapping.in_layer(layer, DVec2::new(x as f64 + 0.5, 0.5)).u as f32, 0.0];
        }
        for (y, knot) in knots[width..width + height].iter_mut().enumerate() {
            *knot = [mapping.in_layer(layer, DVec2::new(0.5, y as f64 + 0.5)).v_share as f32, 0.0];
        }
    }
}

impl AxesMapping for RmfrMapping {
    fn layers(&self) -> &[AxesLayer] {
        self.axes_layers()
    }

    fn in_layer(&self, _layer: usize, px: DVec2) -> LpPoint {
        self.forward(px).unwrap_or(LpPoint { u: 0.0, v_share: 0.0 })
    }

    fn native_rect_px(&self) -> Option<[DVec2; 2]> {
        None
    }

    fn finer_rect_px(&self) -> Option<[DVec2; 2]> {
        None
    }

    fn bands_px(&self) -> [f64; 2] {
        [1.0, 1.0]
    }
}

impl AxesMapping for GuenterMapping {
    fn layers(&self) -> &[AxesLayer] {
        self.axes_layers()
    }

    fn in_layer(&self, layer: usize, px: DVec2) -> LpPoint {
        self.point_in_layer(layer, px)
    }

    fn native_rect_px(&self) -> Option<[DVec2; 2]> {
        Some(GuenterMapping::native_rect_px(self))
    }

    fn finer_rect_px(&self) -> Option<[DVec2; 2]> {
        let [middle, _] = GuenterMapping::layers(self);
        Some([middle.origin_px, middle.origin_px + middle.extent_px()])
    }

    fn bands_px(&self) -> [f64; 2] {
        self.blend_bands_px()
    }
}
