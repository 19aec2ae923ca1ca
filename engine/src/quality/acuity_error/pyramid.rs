//! A picture at its own resolution and, for wide kernels, at halved ones.

use crate::quality::picture::Picture;
use rayon::prelude::*;
use std::ops::Range;

/// Three planes: red, green, blue.
pub(super) type Planes = [Vec<f32>; 3];

/// A picture's linear light on grids of which each has half of the last one's pixels per side,
/// rounded up. Pixel `i` of a grid covers the pixels `2i` and `2i + 1` of the finer one; the last one
/// may reach beyond the picture.
pub(super) struct Pyramid<'a> {
    grids: Vec<Grid<'a>>,
}

struct Grid<'a> {
    light: Light<'a>,
    size: [usize; 2],
    /// The picture's size in this grid's pixels.
    extent: [f64; 2],
}

enum Light<'a> {
    Given(Picture<'a>),
    Halved(Vec<f32>),
}

impl<'a> Pyramid<'a> {
    /// Of a picture whose size was checked.
    pub(super) fn new(picture: Picture<'a>, size: [usize; 2], halvings: usize) -> Self {
        let mut grid = Grid { light: Light::Given(picture), size, extent: size.map(|side| side as f64) };
        let mut grids = Vec::with_capacity(halvings + 1);
        for _ in 0..halvings {
            let half = grid.half();
            grids.push(grid);
            grid = half;
        }
        grids.push(grid);
        Self { grids }
    }

    /// Copies a window of a grid, which may reach beyond it: there the picture is mirrored.
    pub(super) fn load(&self, halvings: usize, [x, y]: [Range<isize>; 2], planes: &mut Planes) {
        let grid = &self.grids[halvings];
        let columns: Vec<Tap> = x.map(|column| grid.tap(column, 0)).collect();
        planes.iter_mut().for_each(Vec::clear);
        for row in y.map(|row| grid.tap(row, 1)) {
            for &column in &columns {
                let light = grid.light(column, row);
                planes.iter_mut().zip(light).for_each(|(plane, light)| plane.push(light));
            }
        }
    }
}

/// A place of one side of a grid: a pixel, and a share of the next one.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Tap {
    pixel: usize,
    next: f32,
}

impl Grid<'_> {
    fn tap(&self, index: isize, side: usize) -> Tap {
        mirrored(index, self.size[side], self.extent[side])
    }

    fn light(&self, column: Tap, row: Tap) -> [f32; 3] {
        let pixel = |x: usize, y: usize| {
            let at = y * self.size[0] + x;
            match &self.light {
                Light::Given(picture) => picture.linear(at),
                Light::Halved(rgb) => [rgb[3 * at], rgb[3 * at + 1], rgb[3 * at + 2]],
            }
        };
        let mix = |a: [f32; 3], b: [f32; 3], share: f32| -> [f32; 3] {
            std::array::from_fn(|channel| a[channel] + share * (b[channel] - a[channel]))
        };
        let line = |y: usize| {
            let light = pixel(column.pixel, y);
            if column.next == 0.0 { light } else { mix(light, pixel(column.pixel + 1, y), column.next) }
        };
        let light = line(row.pixel);
        if row.next == 0.0 { light } else { mix(light, line(row.pixel + 1), row.next) }
    }

    /// The next grid, by the weights 1 3 3 1 along each side.
    fn half<'a>(&self) -> Grid<'a> {
        const WEIGHTS: [f32; 4] = [0.125, 0.375, 0.375, 0.125];
        let size = self.size.map(|side| side.div_ceil(2));
        let around = |at: usize, side: usize| -> [Tap; 4] {
            std::array::from_fn(|tap| self.tap(2 * at as isize + tap as isize - 1, side))
        };
        let mut rgb = vec![0.0; 3 * size[0] * size[1]];
        rgb.par_chunks_mut(3 * size[0]).enumerate().for_each(|(row, line)| {
            let rows = around(row, 1);
            for (column, sum) in line.chunks_exact_mut(3).enumerate() {
                let columns = around(column, 0);
                for (&y, wy) in rows.iter().zip(WEIGHTS) {
                    for (&x, wx) in columns.iter().zip(WEIGHTS) {
                        let light = self.light(x, y);
                        sum.iter_mut().zip(light).for_each(|(sum, light)| *sum += wx * wy * light);
                    }
                }
            }
        });
        Grid { light: Light::Halved(rgb), size, extent: self.extent.map(|side| side / 2.0) }
    }
}

/// Where the light of a pixel lies in a row that goes on as its own mirror image, without end: both
/// edges lie between the outermost pixels of the picture and their images. On a halved grid the far
/// edge may cut a pixel, so that images fall between pixels.
fn mirrored(index: isize, count: usize, extent: f64) -> Tap {
    if (0..count as isize).contains(&index) {
        return Tap { pixel: index as usize, next: 0.0 };
    }
    let at = (index as f64 + 0.5).rem_euclid(2.0 * extent);
    let place = (at.min(2.0 * extent - at) - 0.5).clamp(0.0, count as f64 - 1.0);
    Tap { pixel: place as usize, next: place.fract() as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_go_on_as_their_mirror_image() {
        let found: Vec<Tap> = (-7..8).map(|index| mirrored(index, 3, 3.0)).collect();
        let expected = [0, 0, 1, 2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0, 1];
        assert_eq!(found, expected.map(|pixel| Tap { pixel, next: 0.0 }));
        assert!((-5..5).all(|index| mirrored(index, 1, 1.0) == Tap { pixel: 0, next: 0.0 }));
        // An edge at 2.75 pixels: the image of 3.5 is 2, half-way between pixels 1 and 2.
        assert_eq!(mirrored(3, 3, 2.75), Tap { pixel: 1, next: 0.5 });
        assert_eq!(mirrored(-1, 3, 2.75), Tap { pixel: 0, next: 0.0 });
    }

    #[test]
    fn halved_grids_keep_constants_and_ramps() {
        let size = [11, 6];
        let ramp: Vec<f32> = (0..66).flat_map(|at| [0.25, (at % 11) as f32, (at / 11) as f32]).collect();
        let pyramid = Pyramid::new(Picture::Linear(&ramp), size, 2);
        assert_eq!((pyramid.grids[1].size, pyramid.grids[2].size), ([6, 3], [3, 2]));
        let mut planes = Planes::default();
        for halvings in 1..3 {
            pyramid.load(halvings, [-9..9, -9..9], &mut planes);
            assert!(planes[0].iter().all(|value| *value == 0.25));
        }
        // Away from the edges, a ramp's mean is the value between the two middle pixels.
        pyramid.load(1, [1..4, 1..2], &mut planes);
        assert_eq!(planes[1], [2.5, 4.5, 6.5]);
        pyramid.load(0, [-1..2, 5..7], &mut planes);
        assert_eq!(planes[1], [0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
        assert_eq!(planes[2], [5.0; 6]);
    }
}
