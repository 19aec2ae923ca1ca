//! KFR's kernel functions at their ends.

use super::super::family::{Case, Family, Finding, Part, Place};
use super::super::random::Random;
use crate::failure::Failure;
use macula::fovea::Kernel;
use std::f64::consts::{E, FRAC_PI_2};

/// Relative. A power of six multiplies one rounding of its argument by six, and polynomials add up seven
/// terms: 1e-15 each. A series' second term is below 5e-13 of the first where it is compared.
const BOUND: f64 = 1e-12;

pub fn families() -> Vec<Family> {
    vec![Family {
        name: "kernel",
        what: "K and its inverse keep their digits near 0 and 1, rise, and undo each other",
        part: Part::Mapping,
        place: Place::Cpu,
        bound: BOUND,
        unit: "of it",
        cases,
    }]
}

/// The closed form near 0: `K(x)/x^order` there, and the order.
type Start = (f64, f64);

fn cases() -> Vec<Case> {
    let power = |alpha: f64| (Kernel::Power { alpha }, (1.0, alpha));
    let named = [
        ("alpha1", power(1.0)),
        ("alpha1.5", power(1.5)),
        ("alpha4", power(4.0)),
        ("alpha6", power(6.0)),
        ("sine", (Kernel::Sine, (FRAC_PI_2, 1.0))),
        ("exponential", (Kernel::Exponential, (1.0 / (E - 1.0), 1.0))),
    ];
    let plain = named.map(|(name, (kernel, start))| {
        Case::plain(name, true, move || {
            let mut finding = Finding::default();
            check(&kernel, Some(start), &mut finding);
            finding
        })
    });
    let sums = (0..24).map(|index| {
        let id = format!("sum-of-powers-{index}");
        let quick = index < 4;
        Case::new(id.clone(), quick, move |_| sum_of_powers(&mut Random::of(&id)))
    });
    plain.into_iter().chain(sums).collect()
}

/// Positive coefficients, some of them 0, so that the slope at 0 may vanish.
fn sum_of_powers(random: &mut Random) -> Result<Finding, Failure> {
    let mut beta = [0.0; 8];
    for coefficient in &mut beta[1..] {
        *coefficient = if random.below(3) == 0 { 0.1 + random.unit() } else { 0.0 };
    }
    beta[7] += 0.1 + random.unit();
    let sum: f64 = beta.iter().sum();
    beta.iter_mut().for_each(|coefficient| *coefficient /= sum);
    let kernel = Kernel::polynomial(&beta)?;
    let mut finding = Finding::default();
    let first = beta.iter().zip(0..8).find(|(coefficient, _)| **coefficient > 0.0);
    check(&kernel, first.map(|(coefficient, order)| (*coefficient, f64::from(order))), &mut finding);
    Ok(finding)
}

fn check(kernel: &Kernel, start: Option<Start>, finding: &mut Finding) {
    let ends = [
        (kernel.eval(0.0), 0.0),
        (kernel.eval(1.0), 1.0),
        (kernel.inverse(0.0), 0.0),
        (kernel.inverse(1.0), 1.0),
    ];
    for (found, expected) in ends {
        finding.holds(found == expected, || format!("{found} instead of {expected} at an end"));
    }
    for outside in [-1.0, 2.0, f64::MAX, f64::MIN] {
        let clamped = [kernel.eval(outside), kernel.inverse(outside)];
        finding.holds(clamped == [outside.clamp(0.0, 1.0); 2], || format!("{clamped:?} at {outside}"));
    }
    for value in [5e-324, 1e-300, 1e-30] {
        for found in [kernel.eval(value), kernel.inverse(value), kernel.derivative(value)] {
            finding.finite(found, || format!("a value at {value}"));
        }
    }
    near_the_ends(kernel, start, finding);
    rising(kernel, finding);
}

fn near_the_ends(kernel: &Kernel, start: Option<Start>, finding: &mut Finding) {
    for exponent in 1..=15 {
        let x = 10.0_f64.powi(-exponent);
        let there = kernel.inverse(kernel.eval(x));
        finding.error((there / x - 1.0).abs(), || format!("K^-1(K({x:e}))"));
        let back = kernel.eval(kernel.inverse(x));
        finding.error((back / x - 1.0).abs(), || format!("K(K^-1({x:e}))"));
        let y = 1.0 - x;
        finding.error((kernel.eval(kernel.inverse(y)) - y).abs(), || format!("K(K^-1(1 - {x:e}))"));
        // The closed form is the first term of a series: good where the second one is below rounding.
        if let Some((scale, order)) = start.filter(|_| exponent >= 14) {
            let expected = scale * x.powf(order);
            finding.error((kernel.eval(x) / expected - 1.0).abs(), || format!("K({x:e}) against its series"));
        }
    }
}

fn rising(kernel: &Kernel, finding: &mut Finding) {
    const STEPS: u32 = 3000;
    let (mut last, mut last_inverse) = (0.0, 0.0);
    for step in 0..=STEPS {
        let x = f64::from(step) / f64::from(STEPS);
        let (value, inverse) = (kernel.eval(x), kernel.inverse(x));
        finding.holds(value >= last, || format!("K falls at {x}"));
        finding.holds(inverse >= last_inverse, || format!("K^-1 falls at {x}"));
        let slope = kernel.derivative(x);
        finding.finite(slope, || format!("the slope at {x}"));
        finding.holds(slope >= 0.0, || format!("the slope at {x} is {slope}"));
        (last, last_inverse) = (value, inverse);
    }
}
