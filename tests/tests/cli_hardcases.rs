//! `macula hardcases`: the subset holds, single cases are run by their ids, and what does not exist is
//! refused.

use macula_tests::cli::{failure, json, run};
use serde_json::Value;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn the_subset_has_no_failure() {
    let report = json(&run(&["hardcases", "--subset", "--json"]), "the subset");
    assert_eq!((&report["failures"], &report["non_finite"]), (&0.into(), &0.into()), "{report:#}");
    assert_eq!(report["failed"], serde_json::json!([]));
    assert_eq!(report["validated"], true, "{}", macula_tests::INSTALL_LAYER);
    let families = report["families"].as_array().unwrap();
    let (mut cases, mut checks) = (0, 0);
    for family in families {
        let name = family["name"].as_str().unwrap();
        assert!(number(&family["worst"]) <= number(&family["bound"]), "{family}");
        assert!(family["cases"].as_u64().unwrap() > 0, "{name} has no case");
        assert!(family["checks"].as_u64().unwrap() > 0, "{name} compares nothing");
        assert!(family["unit"].is_string() && family["worst_at"].is_string(), "{family}");
        cases += family["cases"].as_u64().unwrap();
        checks += family["checks"].as_u64().unwrap();
    }
    assert_eq!(report["cases"], cases);
    assert!(families.len() >= 25 && cases >= 1000 && checks >= 100_000, "{cases} cases, {checks} checks");
    for (part, place) in [("mapping", "cpu"), ("mapping", "gpu"), ("shading", "gpu"), ("temporal", "gpu")] {
        assert!(families.iter().any(|family| family["part"] == part && family["place"] == place));
    }
    // What the engine has nothing for is said, not left out.
    assert!(!report["left_out"].as_array().unwrap().is_empty());
}

#[test]
fn a_case_is_run_by_its_id() {
    let listed = run(&["hardcases", "--list", "--family", "px-round-trip,rays"]);
    assert!(listed.status.success());
    let listed = String::from_utf8(listed.stdout).unwrap();
    let ids: Vec<_> = listed.lines().filter_map(|line| line.strip_prefix("  ")).collect();
    // Every method on every display with every gaze, and the displays' rays.
    assert!(ids.len() > 3000, "{} cases", ids.len());
    assert!(ids.contains(&"px-round-trip:vafr/11520x6480/1e6px-off") && ids.contains(&"rays:1x1"));
    for id in [ids[0], ids[ids.len() / 2], ids[ids.len() - 1]] {
        let report = json(&run(&["hardcases", "--only", id, "--json"]), id);
        assert_eq!((&report["cases"], &report["failures"]), (&1.into(), &0.into()), "{id}");
        let family = &report["families"][0];
        assert_eq!(family["name"].as_str(), id.split(':').next());
        // The same inputs give the same figures.
        let again = json(&run(&["hardcases", "--only", id, "--json"]), id);
        for figure in ["worst", "worst_at", "checks"] {
            assert_eq!(family[figure], again["families"][0][figure], "{id}: {figure}");
        }
        // No case needed a device.
        assert_eq!(report["device"], Value::Null);
    }
}

#[test]
fn families_are_chosen_and_listed() {
    let report = json(&run(&["hardcases", "--family", "kernel,acuity", "--json"]), "two families");
    let names = |list: &Value| -> Vec<String> {
        list.as_array().unwrap().iter().map(|family| family["name"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(names(&report["families"]), ["kernel", "acuity"]);
    let all = json(&run(&["hardcases", "--list", "--json"]), "the list");
    let subset = json(&run(&["hardcases", "--list", "--subset", "--json"]), "the subset's list");
    assert_eq!(names(&all), names(&subset));
    let count = |list: &Value| -> usize {
        list.as_array().unwrap().iter().map(|family| family["cases"].as_array().unwrap().len()).sum()
    };
    assert!(count(&subset) * 3 < count(&all), "{} of {}", count(&subset), count(&all));
}

#[test]
fn what_does_not_exist_is_refused_in_one_line() {
    for (arguments, told) in [
        (&["--family", "odd"][..], "there is no family `odd`; there are rays, "),
        (&["--family", "seam,"], "there is no family ``"),
        (&["--only", "seam"], "expected FAMILY:CASE"),
        (&["--only", "seam:odd/1x1"], "there is no case `seam:odd/1x1`"),
        (&["--only", "odd:vafr/1x1"], "there is no case"),
        (&["--only", "seam:vafr/1x1", "--family", "seam"], "cannot be used with"),
        (&["--only", "seam:vafr/1x1", "--subset"], "cannot be used with"),
    ] {
        let line = failure(&run(&[&["hardcases"], arguments].concat()), 2, &arguments.join(" "));
        assert!(line.contains(told), "{line}");
    }
}
