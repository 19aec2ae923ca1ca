//! The latitude-longitude layout: directions, solid angles, resampling and sampling.

use rayon::prelude::*;
use std::f32::consts::{PI, TAU};

/// The unit direction at picture position `uv`; see the module's documentation.
#[must_use]
pub fn direction_of_uv([u, v]: [f32; 2]) -> [f32; 3] {
    let (sin_phi, cos_phi) = ((u - 0.5) * TAU).sin_cos();
    let (sin_theta, cos_theta) = (v * PI).sin_cos();
    [sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi]
}

/// The picture position of a direction (of any length above 0), both in 0..=1; see the module's
/// documentation.
#[must_use]
pub fn uv_of_direction([x, y, z]: [f32; 3]) -> [f32; 2] {
    // atan2 keeps its precision near the poles, where acos has none.
    [0.5 + x.atan2(-z) / TAU, x.hypot(z).atan2(y) / PI]
}

/// A picture of RGBA texels.
#[derive(Clone, Debug)]
pub(super) struct Image {
    /// Width and height, each at least 1.
    pub size: [usize; 2],
    /// `width * height` texels.
    pub pixels: Vec<[f32; 4]>,
}

/// For each target index: the source indices under it, with weights whose sum is 1.
type Taps = Vec<Vec<(usize, f32)>>;

/// Taps of a box filter; `measure(a, b)` is the measure of source positions a..b, in texels.
fn box_taps(source: usize, target: usize, measure: impl Fn(f64, f64) -> f64) -> Taps {
    let scale = source as f64 / target as f64;
    let taps_of = |index: usize| {
        let (low, high) = (index as f64 * scale, (index + 1) as f64 * scale);
        let last = (high.ceil() as usize).clamp(1, source);
        let first = (low.floor() as usize).min(last - 1);
        let mut taps: Vec<(usize, f64)> = (first..last)
            .map(|texel| (texel, measure(low.max(texel as f64), high.min((texel + 1) as f64)).max(0.0)))
            .collect();
        let sum: f64 = taps.iter().map(|tap| tap.1).sum();
        if sum <= 0.0 {
            taps = vec![(first, 1.0)];
        }
        let sum = if sum > 0.0 { sum } else { 1.0 };
        taps.into_iter().map(|(texel, weight)| (texel, (weight / sum) as f32)).collect()
    };
    (0..target).map(taps_of).collect()
}

/// Brings a picture to another size: each new texel is the mean over the solid angle under it.
pub(super) fn resample(source: &[[f32; 4]], from: [usize; 2], to: [usize; 2]) -> Image {
    let columns = box_taps(from[0], to[0], |low, high| high - low);
    let angle = |row: f64| (row / from[1] as f64 * std::f64::consts::PI).cos();
    let rows = box_taps(from[1], to[1], |low, high| angle(low) - angle(high));
    let mut pixels = vec![[0.0_f32; 4]; to[0] * to[1]];
    pixels.par_chunks_mut(to[0]).zip(rows.par_iter()).for_each(|(line, row_taps)| {
        for &(row, row_weight) in row_taps {
            let source_line = &source[row * from[0]..(row + 1) * from[0]];
            for (texel, column_taps) in line.iter_mut().zip(&columns) {
                for &(column, weight) in column_taps {
                    for (sum, value) in texel.iter_mut().zip(source_line[column]) {
                        *sum += value * weight * row_weight;
                    }
                }
            }
        }
    });
    Image { size: to, pixels }
}

/// A picture and its halvings, for filtered sampling.
#[derive(Debug)]
pub(super) struct Chain {
    levels: Vec<Image>,
}

impl Chain {
    /// Halves until one row is left.
    pub fn new(base: Image) -> Self {
        let mut levels = vec![base];
        while let Some(last) = levels.last()
            && last.size[1] > 1
        {
            let half = last.size.map(|side| (side / 2).max(1));
            let next = resample(&last.pixels, last.size, half);
            levels.push(next);
        }
        Self { levels }
    }

    /// The level `index`, or the smallest.
    pub fn level(&self, index: usize) -> &Image {
        &self.levels[index.min(self.levels.len() - 1)]
    }

    /// The radiance along a direction, linear in space and between levels. `lod` at least 0.
    pub fn sample(&self, direction: [f32; 3], lod: f32) -> [f32; 3] {
        let uv = uv_of_direction(direction);
        let lod = lod.clamp(0.0, (self.levels.len() - 1) as f32);
        let low = lod as usize;
        let between = lod - low as f32;
        let fine = self.level(low).sample(uv);
        if between <= 0.0 {
            return fine;
        }
        let coarse = self.level(low + 1).sample(uv);
        [0, 1, 2].map(|i| fine[i] + (coarse[i] - fine[i]) * between)
    }
}

impl Image {
    /// Bilinear; round the globe along u and over the poles along v.
    fn sample(&self, [u, v]: [f32; 2]) -> [f32; 3] {
        let [width, height] = self.size;
        let (x, y) = (u * width as f32 - 0.5, v * height as f32 - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let (x0, y0) = (x0 as i64, y0 as i64);
        let texel = |x: i64, y: i64| {
            // Beyond a pole lies the same row, half the globe away.
            let (x, y) = if y < 0 {
                (x + width as i64 / 2, -1 - y)
            } else if y >= height as i64 {
                (x + width as i64 / 2, 2 * height as i64 - 1 - y)
            } else {
                (x, y)
            };
            self.pixels[y as usize * width + x.rem_euclid(width as i64) as usize]
        };
        let corners = [texel(x0, y0), texel(x0 + 1, y0), texel(x0, y0 + 1), texel(x0 + 1, y0 + 1)];
        [0, 1, 2].map(|i| {
            let top = corners[0][i] + (corners[1][i] - corners[0][i]) * fx;
            let bottom = corners[2][i] + (corners[3][i] - corners[2][i]) * fx;
            top + (bottom - top) * fy
        })
    }
}
