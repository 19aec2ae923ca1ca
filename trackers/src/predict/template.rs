//! The course of a saccade: main sequence and shape.

/// Nodes of the table; a straight line between them is off by less than 1e-4 of the amplitude.
const NODES: usize = 129;

/// Exponents of the velocity profile x^RISE (1 - x)^FALL over the duration. 1 and 1.5 put the peak at 0.4
/// of the duration and leave a tail, as the mean profile of medium saccades has it; larger ones give a
/// sharper peak, a larger `FALL` an earlier one.
const RISE: f64 = 1.0;
const FALL: f64 = 1.5;

/// Share of the amplitude covered at a share of the duration: the integral of the velocity profile.
#[derive(Clone, Debug)]
pub(super) struct Template {
    covered: [f64; NODES],
}

impl Template {
    pub(super) fn new() -> Self {
        const STEPS: usize = 16;
        let mut covered = [0.0; NODES];
        let mut sum = 0.0;
        for (node, share) in covered.iter_mut().enumerate().skip(1) {
            for step in 0..STEPS {
                let at = ((node - 1) * STEPS + step) as f64 + 0.5;
                let x = at / ((NODES - 1) * STEPS) as f64;
                sum += x.powf(RISE) * (1.0 - x).powf(FALL);
            }
            *share = sum;
        }
        covered.iter_mut().for_each(|share| *share /= sum);
        Self { covered }
    }

    /// The share covered at a share of the duration: 0 before the start, 1 after the end.
    pub(super) fn covered(&self, time: f64) -> f64 {
        let at = (time * (NODES - 1) as f64).max(0.0).min((NODES - 1) as f64);
        let node = (at as usize).min(NODES - 2);
        let from = self.covered.get(node).copied().unwrap_or(0.0);
        let to = self.covered.get(node + 1).copied().unwrap_or(1.0);
        from + (to - from) * (at - node as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In closed form: the integral of x (1 - x)^1.5 is 4/35 - (1 - x)^2.5 (2/5) + (1 - x)^3.5 (2/7).
    #[test]
    fn the_table_is_the_integral_of_the_profile() {
        let template = Template::new();
        for step in -10..=110 {
            let x = f64::from(step) / 100.0;
            let left = 1.0 - x.clamp(0.0, 1.0);
            let exact = 1.0 - (left.powf(2.5) * 2.0 / 5.0 - left.powf(3.5) * 2.0 / 7.0) * 35.0 / 4.0;
            assert!((template.covered(x) - exact).abs() < 1e-4, "{x}: {} {exact}", template.covered(x));
        }
        assert_eq!((template.covered(f64::NAN), template.covered(f64::INFINITY)), (0.0, 1.0));
    }
}
