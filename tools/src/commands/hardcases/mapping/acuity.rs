//! Acuity models at their pivots, where they are flat, and to the end of their range.

use super::super::family::{Case, Family, Finding, Part, Place};
use crate::failure::Failure;
use macula::Result;
use macula::fovea::AcuityModel;

/// Relative. The integrals are promised to 1e-12 of their value; the quadrature that they are compared with is
/// good to 1e-10.
const BOUND: f64 = 1e-9;

pub fn families() -> Vec<Family> {
    vec![Family {
        name: "acuity",
        what: "columns u(e) are the integral of the acuity across pivots and flat segments; e(u) undoes u(e)",
        part: Part::Mapping,
        place: Place::Cpu,
        bound: BOUND,
        unit: "of it",
        cases,
    }]
}

type Build = fn() -> Result<AcuityModel>;

fn cases() -> Vec<Case> {
    let models: [(&str, &[f64], Build); 11] = [
        ("paper", &[10.0, 20.0, 30.0, 60.0], || Ok(AcuityModel::vafr_2025())),
        ("paper-smooth", &[10.0, 20.0, 30.0, 60.0], || Ok(AcuityModel::vafr_2025().smooth())),
        ("paper-20th", &[10.0, 20.0, 30.0, 60.0], || AcuityModel::vafr_2025().scaled(0.05)),
        ("limited-9cpd", &[10.0, 20.0, 30.0, 60.0], || AcuityModel::vafr_2025().limited_to(9.0)),
        ("limited-smooth", &[10.0, 20.0], || AcuityModel::vafr_2025().smooth().limited_to(18.0)),
        ("constant", &[45.0], || AcuityModel::new(&[(0.0, 10.0)])),
        ("flat-segment", &[10.0, 20.0, 40.0], || {
            AcuityModel::new(&[(0.0, 40.0), (10.0, 8.0), (20.0, 8.0), (40.0, 4.0)])
        }),
        // Slopes m at which (1/m) ln(1 + m e/omega) has no digits left.
        ("nearly-flat-1e-9", &[30.0], || AcuityModel::new(&[(0.0, 10.0), (30.0, 10.0 - 1e-9), (60.0, 4.0)])),
        ("nearly-flat-1e-14", &[30.0], || {
            AcuityModel::new(&[(0.0, 10.0), (30.0, 10.0 - 1e-14), (60.0, 4.0)])
        }),
        ("steep", &[1e-3], || AcuityModel::new(&[(0.0, 1e4), (1e-3, 1.0), (180.0, 1e-3)])),
        ("pivot-at-90", &[60.0, 90.0], || AcuityModel::new(&[(0.0, 40.0), (60.0, 4.0), (90.0, 3.0)])),
    ];
    let case = |(name, pivots, build): (&'static str, &'static [f64], Build)| {
        Case::new(name, true, move |_| check(&build()?, pivots))
    };
    models.into_iter().map(case).collect()
}

/// Eccentricities, degrees: near 0, around each pivot, at 90 and beyond, to the end.
fn eccentricities(pivots_deg: &[f64]) -> Vec<f64> {
    let mut all = vec![0.0, 1e-300, 1e-9, 1e-3, 0.2, 1.0, 5.0, 15.0, 25.0, 45.0, 75.0];
    for &pivot_deg in pivots_deg.iter().chain(&[90.0, 180.0]) {
        for offset in [-1e-3, -1e-9, 0.0, 1e-9, 1e-3] {
            all.push((pivot_deg * (1.0 + offset)).min(180.0));
        }
        all.extend([pivot_deg.next_down(), pivot_deg.next_up().min(180.0)]);
    }
    all.sort_by(f64::total_cmp);
    all
}

/// Where MAR leaves its value at the gaze, degrees: a kink where a display's limit ends.
fn end_of_flat_start_deg(model: &AcuityModel) -> f64 {
    let (mut low, mut high) = (0.0, 180.0);
    while f64::midpoint(low, high) > low && f64::midpoint(low, high) < high {
        let middle = f64::midpoint(low, high);
        if model.mar_deg(middle) > model.mar_deg(0.0) {
            high = middle;
        } else {
            low = middle;
        }
    }
    low
}

fn check(model: &AcuityModel, pivots_deg: &[f64]) -> Result<Finding, Failure> {
    let mut finding = Finding::default();
    let pivots_deg = [pivots_deg, &[end_of_flat_start_deg(model)]].concat();
    let (mut last_deg, mut last_u, mut summed) = (0.0, 0.0, 0.0);
    for ecc_deg in eccentricities(&pivots_deg) {
        let u = model.columns_to(ecc_deg);
        finding.finite(u, || format!("u({ecc_deg})"));
        finding.holds(u >= last_u, || format!("u falls from {last_deg} to {ecc_deg} degrees"));
        summed += quadrature(last_deg, ecc_deg, |deg| 2.0 / model.mar_deg(deg));
        let off = if summed > 0.0 { (u / summed - 1.0).abs() } else { u };
        finding.error(off, || format!("u({ecc_deg}) against quadrature"));
        let back_deg = model.eccentricity_deg(u);
        let off = if ecc_deg > 0.0 { (back_deg / ecc_deg - 1.0).abs() } else { back_deg };
        finding.error(off, || format!("e(u({ecc_deg}))"));
        let mar_deg = model.mar_deg(ecc_deg);
        // Cubics of neighbouring pieces round differently where they meet.
        let rises = mar_deg > 0.0 && mar_deg >= model.mar_deg(last_deg) * (1.0 - 4.0 * f64::EPSILON);
        finding.holds(rises, || format!("MAR falls at {ecc_deg}"));
        for height in [model.height_planar(ecc_deg), model.height_on_sphere(ecc_deg)] {
            finding.finite(height, || format!("a height at {ecc_deg}"));
            finding.holds(height >= 0.0, || format!("a height is {height} at {ecc_deg}"));
        }
        (last_deg, last_u) = (ecc_deg, u);
    }
    for odd in [f64::NAN, f64::NEG_INFINITY, -1.0, 181.0, f64::INFINITY] {
        for value in
            [model.mar_deg(odd), model.columns_to(odd), model.eccentricity_deg(odd), model.delta(odd)]
        {
            finding.finite(value, || format!("a value at {odd}"));
        }
    }
    Ok(finding)
}

/// Adaptive quadrature of a function without kinks: five-point Gauss-Legendre on halves until they agree with
/// the whole to 1e-12.
fn quadrature(from: f64, to: f64, f: impl Fn(f64) -> f64 + Copy) -> f64 {
    refine(from, to, f, gauss(from, to, f), 48)
}

fn refine(from: f64, to: f64, f: impl Fn(f64) -> f64 + Copy, whole: f64, depth: u32) -> f64 {
    let middle = f64::midpoint(from, to);
    let (left, right) = (gauss(from, middle, f), gauss(middle, to, f));
    if depth == 0 || (left + right - whole).abs() <= 1e-12 * whole.abs() {
        return left + right;
    }
    refine(from, middle, f, left, depth - 1) + refine(middle, to, f, right, depth - 1)
}

/// Exact for polynomials up to the ninth degree.
fn gauss(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    // Nodes and weights in closed form: 0, and 1/3 sqrt(5 -+ 2 sqrt(10/7)).
    let root = 2.0 * (10.0_f64 / 7.0).sqrt();
    let (inner, outer) = ((5.0 - root).sqrt() / 3.0, (5.0 + root).sqrt() / 3.0);
    let spread = 13.0 * 70.0_f64.sqrt();
    let (inner_weight, outer_weight) = ((322.0 + spread) / 900.0, (322.0 - spread) / 900.0);
    let (middle, half) = (f64::midpoint(from, to), (to - from) / 2.0);
    let pair = |node: f64| f(middle - half * node) + f(middle + half * node);
    half * (128.0 / 225.0 * f(middle) + inner_weight * pair(inner) + outer_weight * pair(outer))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quadrature_is_good_to_ten_digits() {
        // The steepest integrand of the models: 2/(a + b e) over four decades.
        let found = quadrature(0.0, 1e-3, |deg| 2.0 / (1e-4 + 999.9 * deg));
        let expected = 2.0 / 999.9 * (1.0 + 999.9 * 1e-3 / 1e-4_f64).ln();
        assert!((found / expected - 1.0).abs() < 1e-10, "{}", found / expected - 1.0);
    }
}
