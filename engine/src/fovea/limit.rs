//! How few samples would do: what acuity and the display together call for.

use super::display::DisplayGeometry;
use glam::DVec2;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Cells are quartered until all that their quarters change is at most this share of the whole. The
/// quarters are what counts in the end and lie nearer to the truth than that. Smaller takes longer.
const TOLERANCE: f64 = 3e-4;

/// Cells along each side of the four parts of the display to begin with, so that no detail hides
/// between the nodes.
const FIRST_CELLS: u32 = 8;

/// No more cells than that are quartered: what no acuity needs, even one that jumps, a function without
/// any order does not get.
const MOST_CELLS: usize = 1 << 18;

/// Nodes and weights on 0..1 of Gauss and Legendre's rule with three nodes.
const NODES: [(f64, f64); 3] =
    [(0.112_701_665_379_258_31, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// The number of samples that acuity and display together call for: the integral over the display of the
/// smaller of its pixels per square degree and `(2 f(e))^2`. No sampler that shows all that the eye and
/// the display resolve gets by with less.
///
/// `cpd` is the acuity, cycles per degree, not negative, at an eccentricity in degrees. The display is a
/// checked one, and the gaze, px, is finite; it may lie off the display. Precise to 1e-3 of the value.
#[must_use]
pub fn sample_limit(display: &DisplayGeometry, gaze_px: DVec2, cpd: &dyn Fn(f64) -> f64) -> f64 {
    let per_px = |px: DVec2| {
        let ecc_deg = display.eccentricity_rad(gaze_px, px).to_degrees();
        let per_rad = 2.0 * cpd(ecc_deg) * 1f64.to_degrees();
        (per_rad * per_rad / display.pixels_per_steradian(display.ray_of_px(px).length())).min(1.0)
    };
    // Acuity peaks at the gaze, which is made a corner of cells.
    let [width, height] = display.size_px.map(f64::from);
    let x_parts = parts(width, gaze_px.x);
    let mut cells = BinaryHeap::new();
    for y in parts(height, gaze_px.y) {
        for x in &x_parts {
            let cell = Cell { low: DVec2::new(x[0], y[0]), high: DVec2::new(x[1], y[1]) };
            cells.push(Estimate::new(cell, &per_px));
        }
    }
    refine(&mut cells, &per_px);
    cells.iter().map(|cell| cell.value).sum()
}

/// A rectangle of the display, px.
#[derive(Clone, Copy)]
struct Cell {
    low: DVec2,
    high: DVec2,
}

impl Cell {
    fn integral(&self, f: &impl Fn(DVec2) -> f64) -> f64 {
        let size = self.high - self.low;
        let mut sum = 0.0;
        for (x, x_weight) in NODES {
            for (y, y_weight) in NODES {
                sum += x_weight * y_weight * f(self.low + size * DVec2::new(x, y));
            }
        }
        sum * size.x * size.y
    }

    fn quarters(&self) -> [Self; 4] {
        let Self { low, high } = *self;
        let middle = (low + high) / 2.0;
        [
            Self { low, high: middle },
            Self { low: DVec2::new(middle.x, low.y), high: DVec2::new(high.x, middle.y) },
            Self { low: DVec2::new(low.x, middle.y), high: DVec2::new(middle.x, high.y) },
            Self { low: middle, high },
        ]
    }
}

/// A cell's integral from its quarters, and how much that differs from the integral without them.
/// Ordered by that difference.
struct Estimate {
    cell: Cell,
    value: f64,
    change: f64,
}

impl Estimate {
    fn new(cell: Cell, f: &impl Fn(DVec2) -> f64) -> Self {
        let value: f64 = cell.quarters().iter().map(|quarter| quarter.integral(f)).sum();
        Self { cell, value, change: (value - cell.integral(f)).abs() }
    }
}

impl Ord for Estimate {
    fn cmp(&self, other: &Self) -> Ordering {
        self.change.total_cmp(&other.change)
    }
}

impl PartialOrd for Estimate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Estimate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Estimate {}

/// Quarters the worst cell, until all are good enough.
fn refine(cells: &mut BinaryHeap<Estimate>, f: &impl Fn(DVec2) -> f64) {
    let (mut value, mut change) =
        cells.iter().fold((0.0, 0.0), |(value, change), cell| (value + cell.value, change + cell.change));
    for _ in 0..MOST_CELLS {
        if change <= TOLERANCE * value {
            return;
        }
        let Some(worst) = cells.pop() else { return };
        value -= worst.value;
        change -= worst.change;
        for quarter in worst.cell.quarters() {
            let estimate = Estimate::new(quarter, f);
            value += estimate.value;
            change += estimate.change;
            cells.push(estimate);
        }
    }
}

/// Cells along one side of the display, on both sides of the gaze where it lies within.
fn parts(length: f64, gaze: f64) -> Vec<[f64; 2]> {
    let cut = gaze.clamp(0.0, length);
    let mut cells = Vec::new();
    for [from, to] in [[0.0, cut], [cut, length]] {
        let at = |step: u32| from + (to - from) * f64::from(step) / f64::from(FIRST_CELLS);
        if to > from {
            cells.extend((0..FIRST_CELLS).map(|step| [at(step), at(step + 1)]));
        }
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::super::AcuityModel;
    use super::*;
    use std::f64::consts::TAU;

    fn vafr_2025(display: &DisplayGeometry, gaze_px: DVec2) -> f64 {
        let acuity = AcuityModel::vafr_2025();
        sample_limit(display, gaze_px, &|ecc_deg| acuity.cpd(ecc_deg))
    }

    fn assert_close(value: f64, expected: f64, share: f64) {
        assert!((value - expected).abs() <= share * expected, "{value}, not {expected}");
    }

    #[test]
    fn known_answers_at_the_centre() {
        for (size_px, hfov_deg, thousands) in [
            ([1920, 1080], 100.0, 684.0),
            ([2560, 1440], 100.0, 765.0),
            ([3840, 2160], 100.0, 854.0),
            ([7680, 4320], 100.0, 932.0),
            ([11520, 6480], 120.0, 1137.0),
        ] {
            let display = DisplayGeometry::symmetric(size_px, hfov_deg);
            let limit = vafr_2025(&display, display.center_px());
            // They are printed in thousands.
            assert!((limit / 1000.0 - thousands).abs() <= 0.5 + 1e-3 * thousands, "{size_px:?}: {limit}");
        }
    }

    /// Of a rectangle with its corners at these tangents; the arc tangent of van Oosterom and Strackee.
    fn square_degrees(display: &DisplayGeometry) -> f64 {
        let corner = |x: f64, y: f64| (x * y).atan2((1.0 + x * x + y * y).sqrt());
        let DisplayGeometry { tan_left, tan_right, tan_up, tan_down, .. } = *display;
        let steradians = corner(tan_right, tan_up) - corner(tan_left, tan_up) - corner(tan_right, tan_down)
            + corner(tan_left, tan_down);
        steradians * 1f64.to_degrees().powi(2)
    }

    fn asymmetric(size_px: [u32; 2]) -> DisplayGeometry {
        DisplayGeometry { size_px, tan_left: -1.4, tan_right: 0.9, tan_up: 1.0, tan_down: -1.3 }
    }

    #[test]
    fn a_display_coarser_than_the_eye_needs_its_pixels() {
        for size_px in [[1, 1], [3, 1], [1440, 1600]] {
            let display = asymmetric(size_px);
            let limit = sample_limit(&display, DVec2::new(0.3, 0.2), &|_| 1e4);
            assert_close(limit, f64::from(size_px[0]) * f64::from(size_px[1]), 1e-12);
        }
    }

    #[test]
    fn one_acuity_everywhere_needs_its_square_times_the_solid_angle() {
        for display in [asymmetric([1440, 1600]), DisplayGeometry::symmetric([4000, 3000], 150.0)] {
            for gaze_px in [DVec2::ZERO, display.center_px(), DVec2::new(-700.0, 9e3), DVec2::splat(1e7)] {
                let limit = sample_limit(&display, gaze_px, &|_| 0.25);
                assert_close(limit, 0.25 * square_degrees(&display), 1e-3);
            }
        }
        assert_eq!(sample_limit(&asymmetric([64, 64]), DVec2::ZERO, &|_| 0.0), 0.0);
    }

    /// A sum over every pixel, with nine points in each.
    fn over_all_pixels(display: &DisplayGeometry, gaze_px: DVec2, cpd: &dyn Fn(f64) -> f64) -> f64 {
        let [width, height] = display.size_px.map(|side| 3 * side);
        let mut sum = 0.0;
        for at in 0..u64::from(width) * u64::from(height) {
            let (x, y) = (at % u64::from(width), at / u64::from(width));
            let px = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) / 3.0;
            let ray = display.ray_of_px(px);
            let ecc_deg = ray.angle_between(display.ray_of_px(gaze_px)).to_degrees();
            // A step of a third of a pixel in both directions spans this solid angle.
            let step = |d: DVec2| display.ray_of_px(px + d / 6.0) - display.ray_of_px(px - d / 6.0);
            let facing = step(DVec2::X).cross(step(DVec2::Y)).dot(ray).abs();
            let square_degrees = facing / ray.length().powi(3) * 1f64.to_degrees().powi(2);
            sum += ((2.0 * cpd(ecc_deg)).powi(2) * square_degrees).min(1.0 / 9.0);
        }
        sum
    }

    #[test]
    fn steep_acuities_are_summed_as_over_all_pixels() {
        let display = asymmetric([160, 144]);
        let acuity = AcuityModel::vafr_2025();
        let shapes: [&dyn Fn(f64) -> f64; 3] =
            [&|ecc_deg| acuity.cpd(ecc_deg) / 20.0, &|ecc_deg| 2.0 / (1.0 + 3.0 * ecc_deg), &|ecc_deg| {
                (-ecc_deg / 15.0).exp()
            }];
        for gaze_px in [display.center_px(), DVec2::new(31.4, 100.2), DVec2::ZERO, DVec2::new(-40.0, 70.0)] {
            for shape in shapes {
                let expected = over_all_pixels(&display, gaze_px, shape);
                assert_close(sample_limit(&display, gaze_px, shape), expected, 1e-3);
            }
        }
    }

    #[test]
    fn an_acuity_that_jumps_needs_its_cap_and_the_rest() {
        let display = asymmetric([1440, 1600]);
        let limit =
            sample_limit(&display, display.center_px(), &|ecc_deg| if ecc_deg < 7.0 { 2.0 } else { 0.5 });
        let cap = TAU * (1.0 - 7f64.to_radians().cos()) * 1f64.to_degrees().powi(2);
        assert_close(limit, 16.0 * cap + square_degrees(&display) - cap, 1e-3);
    }
}
