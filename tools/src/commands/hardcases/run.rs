//! Runs cases, and keeps what they found.

use super::bench::Bench;
use super::family::{Case, Family, Finding, Part, Place};
use crate::failure::Failure;
use crate::progress::Steps;
use serde::Serialize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// A case that failed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Failed {
    /// `FAMILY:CASE`.
    pub id: String,
    /// What was found: the error against its bound, or what is broken.
    pub cause: String,
    /// The command that runs exactly this case.
    pub reproduce: String,
}

/// What a family's cases found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FamilyResult {
    /// Its name.
    pub name: &'static str,
    /// What holds.
    pub what: &'static str,
    /// Part of the catalogue.
    pub part: Part,
    /// Where it ran.
    pub place: Place,
    /// Cases that ran.
    pub cases: usize,
    /// Of those, cases that failed.
    pub failures: usize,
    /// Of those, cases in which there was nothing to compare.
    pub without_checks: usize,
    /// Comparisons.
    pub checks: u64,
    /// Values that were not finite.
    pub non_finite: u64,
    /// The greatest error of all cases; `None` where one is infinite or not a number.
    pub worst: Option<f64>,
    /// The greatest error that is allowed.
    pub bound: f64,
    /// Of both.
    pub unit: &'static str,
    /// The case and place of the greatest error.
    pub worst_at: String,
    /// Time, seconds.
    pub seconds: f64,
}

/// Cases chosen from a family.
pub struct Chosen {
    /// The family.
    pub family: Family,
    /// Some or all of its cases.
    pub cases: Vec<Case>,
    /// Cases of the family that were to be run without naming each: if none of them compares anything, the
    /// family itself is broken.
    pub as_a_whole: bool,
}

/// Runs all of them. Failures of single cases are results; only a missing device ends the run.
///
/// # Errors
/// No usable device, where a case needs one.
pub fn run(chosen: &[Chosen]) -> Result<(Bench, Vec<FamilyResult>, Vec<Failed>), Failure> {
    let bench = Bench::default();
    let needs_device = |chosen: &Chosen| chosen.family.place == Place::Gpu && !chosen.cases.is_empty();
    if chosen.iter().any(needs_device) {
        bench.device()?;
    }
    let mut steps = Steps::long(chosen.iter().map(weight).sum());
    let (mut results, mut failed) = (Vec::new(), Vec::new());
    for chosen in chosen {
        steps.next_of_weight(chosen.family.name, weight(chosen));
        results.push(run_family(chosen, &bench, &steps, &mut failed));
    }
    Ok((bench, results, failed))
}

/// Share of the work, about in seconds: a frame's pipelines and pixels against some thousand mapped points.
fn weight(chosen: &Chosen) -> f64 {
    let each = if chosen.family.place == Place::Gpu { 1.0 } else { 0.002 };
    chosen.cases.len() as f64 * each
}

fn run_family(chosen: &Chosen, bench: &Bench, steps: &Steps, failed: &mut Vec<Failed>) -> FamilyResult {
    let (family, begun) = (&chosen.family, Instant::now());
    let mut result = FamilyResult {
        name: family.name,
        what: family.what,
        part: family.part,
        place: family.place,
        cases: chosen.cases.len(),
        failures: 0,
        without_checks: 0,
        checks: 0,
        non_finite: 0,
        worst: Some(0.0),
        bound: family.bound,
        unit: family.unit,
        worst_at: String::new(),
        seconds: 0.0,
    };
    let mut worst = -1.0;
    for (index, case) in chosen.cases.iter().enumerate() {
        steps.within(index as f64 / chosen.cases.len() as f64);
        let id = format!("{}:{}", family.name, case.id);
        let finding = find(case, bench);
        result.checks += finding.checks;
        result.non_finite = result.non_finite.saturating_add(finding.non_finite);
        result.without_checks += usize::from(finding.checks == 0);
        if finding.worst > worst && !finding.at.is_empty() {
            worst = finding.worst;
            result.worst = finding.worst.is_finite().then_some(finding.worst);
            result.worst_at = format!("{}: {}", case.id, finding.at);
        }
        if let Some(cause) = cause(family, &finding) {
            result.failures += 1;
            failed.push(Failed { reproduce: format!("macula hardcases --only {id}"), id, cause });
        }
    }
    if chosen.as_a_whole && result.checks == 0 {
        result.failures += 1;
        failed.push(Failed {
            id: family.name.to_owned(),
            cause: "none of the cases compared anything".to_owned(),
            reproduce: format!("macula hardcases --family {}", family.name),
        });
    }
    result.seconds = begun.elapsed().as_secs_f64();
    result
}

/// Runs a case. Errors and panics of the library, and messages of the validation layer, are findings.
fn find(case: &Case, bench: &Bench) -> Finding {
    let messages = bench.validation_messages();
    let outcome = catch_unwind(AssertUnwindSafe(|| (case.check)(bench)));
    let broken = |cause: String| Finding { broken: Some(cause), checks: 1, ..Finding::default() };
    let mut finding = match outcome {
        Ok(Ok(finding)) => finding,
        Ok(Err(failure)) => broken(failure.line().unwrap_or_else(|| "the output was closed".to_owned())),
        Err(payload) => {
            let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
            let text = text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_default();
            broken(format!("panicked: {text}"))
        }
    };
    let new = bench.validation_messages().saturating_sub(messages);
    finding.holds(new == 0, || format!("{new} messages of the validation layer, see above"));
    // That comparison is not the case's own.
    finding.checks -= 1;
    finding
}

/// Why a case has failed, if it has.
fn cause(family: &Family, finding: &Finding) -> Option<String> {
    if let Some(broken) = &finding.broken {
        return Some(one_line(broken));
    }
    if finding.worst > family.bound {
        let Family { bound, unit, .. } = family;
        return Some(one_line(&format!("{:.3e} {unit}, bound {bound:e}, at {}", finding.worst, finding.at)));
    }
    (finding.non_finite > 0).then(|| format!("{} values are not finite", finding.non_finite))
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
