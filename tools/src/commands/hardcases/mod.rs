//! `macula hardcases`: the catalogue of numerically hard cases, run over methods, displays and gazes.

mod bench;
mod family;
mod mapping;
mod picture;
mod random;
mod report;
mod run;
mod subject;
#[cfg(test)]
mod tests;

use crate::failure::Failure;
use crate::output;
use clap::Args;
use family::{Family, Part, Place};
use report::{LeftOut, Report};
use run::{Chosen, FamilyResult};
use serde::Serialize;

/// Run numerically hard cases over methods, displays from 1x1 to 11520x6480 and gazes
///
/// Mappings in double precision on the CPU and in single precision on the GPU, frames of extreme scenes and
/// of every size, and sequences of frames. Each family of cases has a bound that its worst error must meet.
/// Cases are the same in every run; a failure prints the command that runs it alone. Exits with 1 where
/// there are failures.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  macula hardcases --subset\n  macula hardcases --family px-round-trip,seam\n  \
                        macula hardcases --only px-round-trip:kfr/1280x720/corner\n  macula hardcases --list"
)]
pub struct HardcasesArgs {
    /// Only these families
    #[arg(long, value_name = "NAME,..", value_delimiter = ',')]
    family: Vec<String>,
    /// Only this case, as --list and failures name it
    #[arg(long, value_name = "FAMILY:CASE", conflicts_with_all = ["family", "subset"])]
    only: Option<String>,
    /// A part that takes about a minute
    #[arg(long)]
    subset: bool,
    /// List the cases instead of running them
    #[arg(long)]
    list: bool,
}

/// The whole catalogue.
fn families() -> Vec<Family> {
    mapping::families().into_iter().chain(picture::families()).collect()
}

/// Runs the command.
///
/// # Errors
/// Options that name nothing, no usable device, and failures of cases.
pub fn run(args: &HardcasesArgs, json: bool) -> Result<(), Failure> {
    let chosen = choose(args, families())?;
    if args.list {
        return list(&chosen, json);
    }
    let report = report_of(&chosen)?;
    if json {
        output::print_json(&report)?
    } else {
        output::print(&report::text(&report))?
    }
    match report.failures {
        0 => Ok(()),
        failures => Err(Failure::environment(format!(
            "{failures} of {} cases failed; the report names each and the command that runs it alone",
            report.cases
        ))),
    }
}

fn report_of(chosen: &[Chosen]) -> Result<Report, Failure> {
    let (bench, families, failed) = run::run(chosen)?;
    let device = bench.device_in_use();
    let sum = |of: fn(&FamilyResult) -> usize| families.iter().map(of).sum();
    let left_out = [mapping::LEFT_OUT].into_iter().chain(picture::LEFT_OUT.concat());
    // Of a single case there is nothing to say.
    let told = chosen.iter().any(|chosen| chosen.as_a_whole && chosen.family.place == Place::Gpu);
    Ok(Report {
        device: device.map(|device| device.name().to_owned()),
        driver: device.map(|device| device.driver().to_owned()),
        validated: device.map(|device| device.validation_messages().is_some()),
        cases: sum(|family| family.cases),
        failures: failed.len(),
        non_finite: families.iter().map(|family| family.non_finite).fold(0, u64::saturating_add),
        seconds: families.iter().map(|family| family.seconds).sum(),
        families,
        failed,
        left_out: left_out.filter(|_| told).map(|(name, why)| LeftOut { name, why }).collect(),
    })
}

/// The families and cases that the options name.
fn choose(args: &HardcasesArgs, families: Vec<Family>) -> Result<Vec<Chosen>, Failure> {
    if let Some(id) = &args.only {
        return only(id, families);
    }
    for name in &args.family {
        if !families.iter().any(|family| family.name == name) {
            let known = families.iter().map(|family| family.name).collect::<Vec<_>>().join(", ");
            return Err(Failure::usage(format!("there is no family `{name}`; there are {known}")));
        }
    }
    let wanted =
        |family: &Family| args.family.is_empty() || args.family.iter().any(|name| name == family.name);
    let chosen = families.into_iter().filter(wanted).map(|family| {
        let mut cases = (family.cases)();
        cases.retain(|case| case.quick || !args.subset);
        Chosen { family, cases, as_a_whole: true }
    });
    Ok(chosen.collect())
}

fn only(id: &str, families: Vec<Family>) -> Result<Vec<Chosen>, Failure> {
    let Some((name, case)) = id.split_once(':') else {
        return Err(Failure::usage(format!(
            "`{id}` names no case; expected FAMILY:CASE, as --list prints them"
        )));
    };
    let family = families.into_iter().find(|family| family.name == name);
    let found = family.and_then(|family| {
        let case = (family.cases)().into_iter().find(|found| found.id == case)?;
        Some(Chosen { family, cases: vec![case], as_a_whole: false })
    });
    let found =
        found.ok_or_else(|| Failure::usage(format!("there is no case `{id}`; --list prints them all")))?;
    Ok(vec![found])
}

#[derive(Serialize)]
struct Listed {
    name: &'static str,
    what: &'static str,
    part: Part,
    place: Place,
    bound: f64,
    unit: &'static str,
    cases: Vec<String>,
}

fn list(chosen: &[Chosen], json: bool) -> Result<(), Failure> {
    let listed = chosen.iter().map(|Chosen { family, cases, .. }| Listed {
        name: family.name,
        what: family.what,
        part: family.part,
        place: family.place,
        bound: family.bound,
        unit: family.unit,
        cases: cases.iter().map(|case| format!("{}:{}", family.name, case.id)).collect(),
    });
    if json {
        return output::print_json(&listed.collect::<Vec<_>>());
    }
    let text: String = listed
        .map(|family| {
            let cases: String = family.cases.iter().map(|case| format!("  {case}\n")).collect();
            format!("{}: {}\n{cases}", family.name, family.what)
        })
        .collect();
    output::print(&text)
}
