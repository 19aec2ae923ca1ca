//! The catalogue's machinery, with planted cases.

use super::family::{Case, Family, Finding, Part, Place};
use super::run::{Failed, FamilyResult, run};
use super::{HardcasesArgs, choose, families};
use crate::failure::Failure;
use clap::Parser;
use std::collections::HashSet;

#[derive(Parser)]
struct Line {
    #[command(flatten)]
    args: HardcasesArgs,
}

fn args(line: &[&str]) -> HardcasesArgs {
    Line::try_parse_from([&["hardcases"], line].concat()).expect("valid options").args
}

fn planted(cases: fn() -> Vec<Case>) -> Family {
    Family {
        name: "planted",
        what: "errors stay small",
        part: Part::Mapping,
        place: Place::Cpu,
        bound: 1e-3,
        unit: "px",
        cases,
    }
}

fn off_by(error: f64) -> Finding {
    let mut finding = Finding::default();
    finding.error(error, || "px 3, 4".to_owned());
    finding
}

/// One of each kind; `bad`, `nan`, `broken`, `refused` and `panics` must fail.
fn mixed() -> Vec<Case> {
    vec![
        Case::plain("good", true, || off_by(5e-4)),
        Case::plain("bad", false, || off_by(0.25)),
        Case::plain("nan", false, || off_by(f64::NAN)),
        Case::plain("nothing", true, Finding::default),
        Case::plain("broken", false, || {
            let mut finding = off_by(0.0);
            finding.holds(false, || "two\nlines".to_owned());
            finding
        }),
        Case::new("refused", false, |_| Err(Failure::environment("no such thing"))),
        Case::plain("panics", false, || panic!("planted")),
    ]
}

fn outcome(line: &[&str], family: Family) -> (FamilyResult, Vec<Failed>) {
    let chosen = choose(&args(line), vec![family]).expect("chosen");
    let (_, mut results, failed) = run(&chosen).expect("a run");
    (results.remove(0), failed)
}

#[test]
fn planted_failures_are_found_and_named() {
    let (result, failed) = outcome(&[], planted(mixed));
    let ids: Vec<_> = failed.iter().map(|failed| failed.id.as_str()).collect();
    assert_eq!(ids, ["planted:bad", "planted:nan", "planted:broken", "planted:refused", "planted:panics"]);
    for failed in &failed {
        assert_eq!(failed.reproduce, format!("macula hardcases --only {}", failed.id));
        assert!(!failed.cause.contains('\n'), "{}", failed.cause);
    }
    assert_eq!(failed[0].cause, "2.500e-1 px, bound 1e-3, at px 3, 4");
    assert_eq!(failed[2].cause, "two lines");
    assert!(failed[3].cause.contains("no such thing") && failed[4].cause == "panicked: planted");
    assert_eq!((result.cases, result.failures, result.without_checks, result.non_finite), (7, 5, 1, 1));
    // A NaN is worse than everything.
    assert_eq!((result.worst, result.worst_at.as_str()), (None, "nan: px 3, 4"));
}

#[test]
fn the_line_of_a_failure_runs_that_case_alone() {
    let (_, failed) = outcome(&[], planted(mixed));
    let line = failed[0].reproduce.strip_prefix("macula hardcases ").expect("the command");
    let (result, again) = outcome(&line.split(' ').collect::<Vec<_>>(), planted(mixed));
    assert_eq!((result.cases, &again[..]), (1, &failed[..1]));
}

#[test]
fn the_subset_leaves_out_what_is_slow() {
    let (result, failed) = outcome(&["--subset"], planted(mixed));
    assert_eq!((result.cases, result.without_checks, failed.len()), (2, 1, 0));
    assert_eq!(result.worst, Some(5e-4));
}

#[test]
fn a_family_that_compares_nothing_fails() {
    let (result, failed) = outcome(&[], planted(|| vec![Case::plain("nothing", true, Finding::default)]));
    assert_eq!((result.failures, failed[0].id.as_str()), (1, "planted"));
    // A single case may have nothing to compare.
    let family = planted(|| vec![Case::plain("nothing", true, Finding::default)]);
    assert!(outcome(&["--only", "planted:nothing"], family).1.is_empty());
}

#[test]
fn what_does_not_exist_is_refused() {
    for line in [
        &["--family", "planted,odd"][..],
        &["--only", "planted"],
        &["--only", "odd:bad"],
        &["--only", "planted:odd"],
    ] {
        match choose(&args(line), vec![planted(mixed)]) {
            Err(Failure::Usage(message)) => assert!(message.contains("planted") || message.contains("odd")),
            _ => panic!("{line:?} was taken"),
        }
    }
    assert!(Line::try_parse_from(["hardcases", "--only", "a:b", "--subset"]).is_err());
}

#[test]
fn ids_are_unique_the_same_each_time_and_plain() {
    let ids = || {
        let all = families().into_iter().flat_map(|family| {
            (family.cases)().into_iter().map(move |case| format!("{}:{}", family.name, case.id))
        });
        all.collect::<Vec<_>>()
    };
    let (first, second) = (ids(), ids());
    assert_eq!(first, second);
    assert_eq!(first.iter().collect::<HashSet<_>>().len(), first.len());
    for id in &first {
        let plain = |letter: char| letter.is_ascii_alphanumeric() || ".:/-".contains(letter);
        assert!(id.chars().all(plain), "{id}");
    }
}

#[test]
fn every_family_is_in_the_subset() {
    for family in families() {
        let cases = (family.cases)();
        assert!(cases.iter().any(|case| case.quick), "{} has no quick case", family.name);
        assert!(family.bound >= 0.0 && family.bound.is_finite(), "{}", family.name);
    }
}
