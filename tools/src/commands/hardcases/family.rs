//! What the catalogue is made of: families of cases, each family with one bound that all its cases meet.

use super::bench::Bench;
use crate::failure::Failure;

/// Which part of the catalogue a family belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Part {
    /// Between the display and the LP-buffer.
    Mapping,
    /// Pictures of single frames, and scene files.
    Shading,
    /// Sequences of frames.
    Temporal,
}

/// What it takes to run a family.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Place {
    /// Double precision, no device.
    Cpu,
    /// A Vulkan device.
    Gpu,
}

/// Cases that share a bound.
pub struct Family {
    /// In ids and tables: letters, digits and dashes.
    pub name: &'static str,
    /// What holds, in one clause.
    pub what: &'static str,
    /// Part of the catalogue.
    pub part: Part,
    /// Where it runs.
    pub place: Place,
    /// The greatest error that a case may have. The module of the family says why.
    pub bound: f64,
    /// Of the error and the bound.
    pub unit: &'static str,
    /// The cases, always the same and in the same order.
    pub cases: fn() -> Vec<Case>,
}

type Check = Box<dyn Fn(&Bench) -> Result<Finding, Failure>>;

/// One case: always the same check of the same inputs.
pub struct Case {
    /// Within the family: letters, digits, dots, dashes and slashes, so that no shell changes it.
    pub id: String,
    /// Part of the subset.
    pub quick: bool,
    /// Runs it. An error of the library is a failure of the case.
    pub check: Check,
}

impl Case {
    /// A case.
    pub fn new(
        id: impl Into<String>,
        quick: bool,
        check: impl Fn(&Bench) -> Result<Finding, Failure> + 'static,
    ) -> Self {
        Self { id: id.into(), quick, check: Box::new(check) }
    }

    /// A case that needs no device and cannot fail but by its errors.
    pub fn plain(id: impl Into<String>, quick: bool, check: impl Fn() -> Finding + 'static) -> Self {
        Self::new(id, quick, move |_| Ok(check()))
    }
}

/// What a case found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Finding {
    /// The greatest error, in the family's unit; infinite where one was not a number.
    pub worst: f64,
    /// Where that was.
    pub at: String,
    /// Comparisons made. A case without any says nothing.
    pub checks: u64,
    /// Values that were NaN or infinite.
    pub non_finite: u64,
    /// What is wrong beside the size of errors.
    pub broken: Option<String>,
}

impl Finding {
    /// Takes an error into account, which is at least 0. One that is not finite counts as such, and is
    /// worse than every bound.
    pub fn error(&mut self, error: f64, at: impl FnOnce() -> String) {
        self.checks += 1;
        let error = if error.is_finite() {
            error
        } else {
            self.non_finite += 1;
            f64::INFINITY
        };
        if error > self.worst || self.at.is_empty() {
            self.worst = error;
            self.at = at();
        }
    }

    /// Counts a value that must be finite, and says whether it is.
    pub fn finite(&mut self, value: f64, what: impl FnOnce() -> String) -> bool {
        self.checks += 1;
        if !value.is_finite() {
            self.non_finite += 1;
            self.broken.get_or_insert_with(|| format!("{} is {value}", what()));
        }
        value.is_finite()
    }

    /// Takes a condition into account that holds or does not.
    pub fn holds(&mut self, condition: bool, otherwise: impl FnOnce() -> String) {
        self.checks += 1;
        if !condition {
            self.broken.get_or_insert_with(otherwise);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_error_is_kept_with_its_place() {
        let mut finding = Finding::default();
        for (error, at) in [(1.0, "a"), (3.0, "b"), (2.0, "c")] {
            finding.error(error, || at.to_owned());
        }
        assert_eq!((finding.worst, finding.at.as_str(), finding.checks), (3.0, "b", 3));
    }

    #[test]
    fn what_is_not_a_number_is_worse_than_any_bound() {
        let mut finding = Finding::default();
        finding.error(f64::NAN, || "here".to_owned());
        finding.error(5.0, || "there".to_owned());
        assert_eq!((finding.worst, finding.at.as_str(), finding.non_finite), (f64::INFINITY, "here", 1));
        assert!(!finding.finite(f64::NEG_INFINITY, || "u".to_owned()));
        assert_eq!((finding.non_finite, finding.broken.as_deref()), (2, Some("u is -inf")));
    }

    #[test]
    fn the_first_broken_condition_is_told() {
        let mut finding = Finding::default();
        finding.holds(true, || "fine".to_owned());
        finding.holds(false, || "first".to_owned());
        finding.holds(false, || "second".to_owned());
        assert_eq!((finding.broken.as_deref(), finding.checks), (Some("first"), 3));
    }
}
