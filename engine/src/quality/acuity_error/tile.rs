//! The low-pass of one tile: every level that its pixels need, each weighted pixel by pixel.

use super::levels::Level;
use super::pyramid::{Planes, Pyramid};
use std::ops::Range;

/// Side of a tile, px. Larger tiles share more of what neighbours need and hold more levels; at 64
/// the buffers of the widest kernels fit a core's second-level cache.
pub(super) const TILE_PX: usize = 64;

/// A part of the display, px.
#[derive(Clone, Debug)]
pub(super) struct Tile {
    pub(super) x: Range<usize>,
    pub(super) y: Range<usize>,
}

impl Tile {
    /// The tiles of a display, row by row.
    pub(super) fn all([width, height]: [usize; 2]) -> Vec<Self> {
        let parts =
            |length: usize| (0..length).step_by(TILE_PX).map(move |at| at..(at + TILE_PX).min(length));
        parts(height).flat_map(|y| parts(width).map(move |x| Self { x, y: y.clone() })).collect()
    }

    /// The indices of each row's pixels.
    pub(super) fn rows(&self, width: usize) -> impl Iterator<Item = Range<usize>> + use<> {
        let x = self.x.clone();
        self.y.clone().map(move |y| y * width + x.start..y * width + x.end)
    }
}

/// Buffers that serve one tile after another.
#[derive(Default)]
pub(super) struct Scratch {
    places: Vec<f32>,
    input: Planes,
    rows: Vec<f32>,
    blurred: Vec<f32>,
}

/// The part of a halved grid under a tile, and where the tile's pixels lie in it.
struct Window {
    x: Range<isize>,
    y: Range<isize>,
    /// For each of the tile's columns and rows the pixel before it and the share of the next one.
    columns: Vec<(usize, f32)>,
    rows: Vec<(usize, f32)>,
}

impl Window {
    fn new(tile: &Tile, halvings: usize) -> Self {
        let (x, columns) = Self::side(&tile.x, halvings);
        let (y, rows) = Self::side(&tile.y, halvings);
        Self { x, y, columns, rows }
    }

    fn side(fine: &Range<usize>, halvings: usize) -> (Range<isize>, Vec<(usize, f32)>) {
        if halvings == 0 {
            return (fine.start as isize..fine.end as isize, Vec::new());
        }
        // The centre of fine pixel i lies at (i + 1/2)/scale - 1/2, counted from centre to centre.
        let scale = 2_f64.powi(halvings as i32);
        let at = |fine: usize| (fine as f64 + 0.5) / scale - 0.5;
        let start = at(fine.start).floor() as isize;
        let end = at(fine.end - 1).floor() as isize + 2;
        let place = |fine: usize| {
            let at = at(fine);
            ((at.floor() as isize - start) as usize, (at - at.floor()) as f32)
        };
        (start..end, fine.clone().map(place).collect())
    }

    fn size(&self) -> [usize; 2] {
        [self.x.len(), self.y.len()]
    }

    /// Wider by a kernel's reach on every side.
    fn widened(&self, reach: usize) -> [Range<isize>; 2] {
        let reach = reach as isize;
        [self.x.start - reach..self.x.end + reach, self.y.start - reach..self.y.end + reach]
    }
}

/// Low-passes a tile into three planes of its pixels. `places` holds where each of the display's
/// pixels lies among the levels.
pub(super) fn low_pass(
    pyramid: &Pyramid,
    levels: &[Level],
    places: &[f32],
    width: usize,
    tile: &Tile,
    scratch: &mut Scratch,
    out: &mut Planes,
) {
    pyramid.load(0, Window::new(tile, 0).widened(0), out);
    scratch.places.clear();
    tile.rows(width).for_each(|row| scratch.places.extend_from_slice(&places[row]));
    let needed = needed(&scratch.places, levels.len());
    if needed.is_empty() {
        return;
    }
    for plane in &mut *out {
        let filtered = plane.iter_mut().zip(&scratch.places).filter(|(_, place)| **place >= 0.0);
        filtered.for_each(|(value, _)| *value = 0.0);
    }
    for grid in needed.chunk_by(|&a, &b| levels[a].halvings == levels[b].halvings) {
        let window = Window::new(tile, levels[grid[0]].halvings);
        let reach = |level: usize| levels[level].kernel.len() - 1;
        let widest = grid.iter().map(|&level| reach(level)).max().unwrap_or(0);
        let [x, y] = window.widened(widest);
        let loaded = x.len();
        pyramid.load(levels[grid[0]].halvings, [x, y], &mut scratch.input);
        for &level in grid {
            for (input, out) in scratch.input.iter().zip(&mut *out) {
                let kernel = &levels[level].kernel;
                blur(input, loaded, widest, kernel, &window, &mut scratch.rows, &mut scratch.blurred);
                add_weighted(out, &scratch.places, level, &scratch.blurred, &window, tile.x.len());
            }
        }
    }
}

/// The levels on either side of any place, in rising order.
fn needed(places: &[f32], count: usize) -> Vec<usize> {
    let mut needed = vec![false; count];
    for &place in places.iter().filter(|place| **place >= 0.0) {
        needed[place as usize] = true;
        needed[place.ceil() as usize] = true;
    }
    (0..count).filter(|&level| needed[level]).collect()
}

/// Blurs the window's pixels. The input is wider than the window by `margin` on every side, which is
/// at least the kernel's reach; its rows have `loaded` values.
fn blur(
    input: &[f32],
    loaded: usize,
    margin: usize,
    kernel: &[f32],
    window: &Window,
    rows: &mut Vec<f32>,
    out: &mut Vec<f32>,
) {
    let [width, height] = window.size();
    let reach = kernel.len() - 1;
    let used = (margin - reach) * loaded..(margin + height + reach) * loaded;
    rows.clear();
    rows.resize((height + 2 * reach) * width, 0.0);
    for (line, from) in rows.chunks_exact_mut(width).zip(input[used].chunks_exact(loaded)) {
        weigh(line, kernel[0], &from[margin..margin + width]);
        for (step, &weight) in kernel.iter().enumerate().skip(1) {
            let (before, after) = (margin - step, margin + step);
            add_both(line, weight, &from[before..before + width], &from[after..after + width]);
        }
    }
    out.clear();
    out.resize(width * height, 0.0);
    for (row, line) in out.chunks_exact_mut(width).enumerate() {
        let from = |row: usize| &rows[row * width..(row + 1) * width];
        weigh(line, kernel[0], from(row + reach));
        for (step, &weight) in kernel.iter().enumerate().skip(1) {
            add_both(line, weight, from(row + reach - step), from(row + reach + step));
        }
    }
}

fn weigh(line: &mut [f32], weight: f32, from: &[f32]) {
    line.iter_mut().zip(from).for_each(|(sum, from)| *sum = weight * from);
}

fn add_both(line: &mut [f32], weight: f32, before: &[f32], after: &[f32]) {
    for ((sum, before), after) in line.iter_mut().zip(before).zip(after) {
        *sum += weight * (before + after);
    }
}

/// Adds a level's share to each pixel: all of it where the place is the level, none from the
/// neighbouring levels on.
fn add_weighted(
    out: &mut [f32],
    places: &[f32],
    level: usize,
    blurred: &[f32],
    window: &Window,
    width: usize,
) {
    let share = |place: f32| (1.0 - (place - level as f32).abs()).max(0.0);
    if window.columns.is_empty() {
        for ((sum, &place), &value) in out.iter_mut().zip(places).zip(blurred) {
            *sum += share(place) * value;
        }
        return;
    }
    let lines = out.chunks_exact_mut(width).zip(places.chunks_exact(width)).zip(&window.rows);
    let stride = window.x.len();
    for ((line, places), &(row, down)) in lines {
        let [upper, lower] = [row, row + 1].map(|row| &blurred[row * stride..(row + 1) * stride]);
        for ((sum, &place), &(column, right)) in line.iter_mut().zip(places).zip(&window.columns) {
            let across = |line: &[f32]| line[column] + right * (line[column + 1] - line[column]);
            let (upper, lower) = (across(upper), across(lower));
            *sum += share(place) * (upper + down * (lower - upper));
        }
    }
}
