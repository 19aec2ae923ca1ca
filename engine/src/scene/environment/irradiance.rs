//! Diffuse light: irradiance as spherical harmonics of order 2.

use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Number of coefficients.
pub const SH_COUNT: usize = 9;

/// The polynomials that `diffuse_sh` multiplies, at a unit direction: 1, y, z, x, xy, yz, 3z^2 - 1,
/// xz, x^2 - y^2.
#[must_use]
pub fn sh_basis([x, y, z]: [f32; 3]) -> [f32; SH_COUNT] {
    [1.0, y, z, x, x * y, y * z, 3.0 * z * z - 1.0, x * z, x * x - y * y]
}

/// For each polynomial, the square of its normalisation in the real spherical harmonics, times the
/// cosine lobe's coefficient over pi (1, 2/3, 1/4 for the orders 0, 1, 2).
fn factors() -> [f64; SH_COUNT] {
    let order_1 = 3.0 / (4.0 * PI) * (2.0 / 3.0);
    let order_2 = 15.0 / (4.0 * PI) * 0.25;
    [
        1.0 / (4.0 * PI),
        order_1,
        order_1,
        order_1,
        order_2,
        order_2,
        5.0 / (16.0 * PI) * 0.25,
        order_2,
        order_2 / 4.0,
    ]
}

/// Integrals over one row's polar angles of the functions of theta in the polynomials, the
/// `sin theta` of the solid angle included.
#[derive(Clone, Copy)]
struct RowIntegrals {
    one: f64,
    cos: f64,
    cos_cos: f64,
    sin: f64,
    sin_cos: f64,
    sin_sin: f64,
}

impl RowIntegrals {
    fn new(row: usize, height: usize) -> Self {
        let angle = |row: usize| row as f64 / height as f64 * PI;
        let ((s0, c0), (s1, c1)) = (angle(row).sin_cos(), angle(row + 1).sin_cos());
        let one = c0 - c1;
        let cos_cos = (c0.powi(3) - c1.powi(3)) / 3.0;
        Self {
            one,
            cos: (s1 * s1 - s0 * s0) / 2.0,
            cos_cos,
            sin: (PI / height as f64 - (s1 * c1 - s0 * c0)) / 2.0,
            sin_cos: (s1.powi(3) - s0.powi(3)) / 3.0,
            sin_sin: one - cos_cos,
        }
    }
}

/// Integrals over one column's azimuths of the functions of phi in the polynomials.
#[derive(Clone, Copy)]
struct ColumnIntegrals {
    one: f64,
    sin: f64,
    cos: f64,
    sin_sin: f64,
    sin_cos: f64,
}

impl ColumnIntegrals {
    fn new(column: usize, width: usize) -> Self {
        let angle = |column: usize| (column as f64 / width as f64 - 0.5) * TAU;
        let ((s0, c0), (s1, c1)) = (angle(column).sin_cos(), angle(column + 1).sin_cos());
        let one = TAU / width as f64;
        Self {
            one,
            sin: c0 - c1,
            cos: s1 - s0,
            sin_sin: (one - (s1 * c1 - s0 * c0)) / 2.0,
            sin_cos: (s1 * s1 - s0 * s0) / 2.0,
        }
    }
}

/// The integrals of the nine polynomials over one texel's solid angle.
fn texel_integrals(row: &RowIntegrals, column: &ColumnIntegrals) -> [f64; SH_COUNT] {
    let solid_angle = row.one * column.one;
    [
        solid_angle,
        row.cos * column.one,
        -row.sin * column.cos,
        row.sin * column.sin,
        row.sin_cos * column.sin,
        -row.sin_cos * column.cos,
        3.0 * row.sin_sin * (column.one - column.sin_sin) - solid_angle,
        -row.sin_sin * column.sin_cos,
        row.sin_sin * column.sin_sin - row.cos_cos * column.one,
    ]
}

/// `diffuse_sh` of a picture; exact for texels of constant radiance, at any size.
pub(super) fn project(size: [u32; 2], pixels: &[[f32; 4]]) -> [[f32; 4]; SH_COUNT] {
    let [width, height] = size.map(|side| side as usize);
    let columns: Vec<ColumnIntegrals> =
        (0..width).map(|column| ColumnIntegrals::new(column, width)).collect();
    let row_sum = |(row, line): (usize, &[[f32; 4]])| {
        let row = RowIntegrals::new(row, height);
        let mut sum = [[0.0_f64; 3]; SH_COUNT];
        for (column, texel) in columns.iter().zip(line) {
            for (sum, integral) in sum.iter_mut().zip(texel_integrals(&row, column)) {
                for (sum, value) in sum.iter_mut().zip(texel) {
                    *sum += f64::from(*value) * integral;
                }
            }
        }
        sum
    };
    // Collected and added in order, so that the result does not depend on the number of threads.
    let rows: Vec<_> = pixels.par_chunks(width).enumerate().map(row_sum).collect();
    let mut coefficients = [[0.0_f32; 4]; SH_COUNT];
    for (index, factor) in factors().into_iter().enumerate() {
        for channel in 0..3 {
            let sum: f64 = rows.iter().map(|row| row[index][channel]).sum();
            coefficients[index][channel] = (sum * factor) as f32;
        }
    }
    coefficients
}
