//! What a run says: a table, or one JSON document.

use super::run::{Failed, FamilyResult};
use crate::output::{grouped, table};
use serde::Serialize;

/// A case of the catalogue that is not run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// What the catalogue names.
    pub name: &'static str,
    /// Why there is no case.
    pub why: &'static str,
}

/// A whole run.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The device; `None` where no case needed one.
    pub device: Option<String>,
    /// Its driver.
    pub driver: Option<String>,
    /// Whether the validation layer watched; `None` without a device.
    pub validated: Option<bool>,
    /// Cases that ran.
    pub cases: usize,
    /// Failures.
    pub failures: usize,
    /// NaN and infinite values in results and in the engine's buffers.
    pub non_finite: u64,
    /// Time, seconds.
    pub seconds: f64,
    /// In the catalogue's order.
    pub families: Vec<FamilyResult>,
    /// The failures.
    pub failed: Vec<Failed>,
    /// What there is no case for.
    pub left_out: Vec<LeftOut>,
}

/// For people.
pub fn text(report: &Report) -> String {
    let mut text =
        table(&["family", "where", "cases", "worst", "bound", "unit", "failures", "s"], &rows(report));
    text.push('\n');
    for family in report.families.iter().filter(|family| family.worst != Some(0.0)) {
        text += &format!("{:<18} worst at {}\n", family.name, family.worst_at);
    }
    for family in report.families.iter().filter(|family| family.without_checks > 0) {
        text += &format!("{:<18} {} cases with nothing to compare\n", family.name, family.without_checks);
    }
    for LeftOut { name, why } in &report.left_out {
        text += &format!("no case: {name}: {why}\n");
    }
    if let (Some(device), Some(driver)) = (&report.device, &report.driver) {
        let watched = if report.validated == Some(true) { "" } else { ", without the validation layer" };
        text += &format!("device: {device} ({driver}){watched}\n");
    }
    for Failed { id, cause, reproduce } in &report.failed {
        text += &format!("FAILED {id}: {cause}; run it again: {reproduce}\n");
    }
    text += &format!(
        "{} cases, {} failures, {} values not finite, {:.0} s\n",
        grouped(report.cases as u64),
        report.failures,
        report.non_finite,
        report.seconds
    );
    text
}

fn rows(report: &Report) -> Vec<Vec<String>> {
    let row = |family: &FamilyResult| {
        vec![
            family.name.to_owned(),
            if family.place == super::family::Place::Gpu { "GPU" } else { "CPU" }.to_owned(),
            grouped(family.cases as u64),
            family.worst.map_or_else(|| "inf".to_owned(), number),
            number(family.bound),
            family.unit.to_owned(),
            family.failures.to_string(),
            format!("{:.1}", family.seconds),
        ]
    };
    report.families.iter().map(row).collect()
}

/// Three digits.
fn number(value: f64) -> String {
    if value == 0.0 || (0.01..1e4).contains(&value) {
        let text = format!("{value:.3}");
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    format!("{value:.2e}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        for (value, expected) in [
            (0.0, "0"),
            (0.5, "0.5"),
            (1.0, "1"),
            (0.012_34, "0.012"),
            (1.5e-7, "1.50e-7"),
            (123.456, "123.456"),
        ] {
            assert_eq!(number(value), expected);
        }
    }
}
