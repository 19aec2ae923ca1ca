//! Displays by name: the list, and the commands that take one.

use macula_tests::cli::{Place, failure, json, macula, run};
use serde_json::Value;
use std::io::Write;
use std::process::Stdio;

fn displays() -> Vec<Value> {
    let list = json(&run(&["displays", "--json"]), "displays");
    list.as_array().expect("a list").clone()
}

/// Maps one point of a display.
fn mapped(options: &[&str], point: &str) -> Value {
    let mut child = macula(&[&["map", "--json"][..], options].concat())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("macula runs");
    child.stdin.take().expect("its input").write_all(point.as_bytes()).expect("written");
    json(&child.wait_with_output().expect("its output"), "map")
}

#[test]
fn the_list_has_every_figure_and_its_guesses() {
    let displays = displays();
    let names: Vec<_> = displays.iter().filter_map(|display| display["name"].as_str()).collect();
    for name in [
        "fove-0",
        "vive-pro-eye",
        "varjo-aero",
        "varjo-xr-4",
        "pimax-crystal",
        "quest-pro",
        "psvr2",
        "desktop-24-1080p",
        "desktop-27-1440p",
        "desktop-27-4k",
        "desktop-32-4k",
        "retinal",
    ] {
        assert!(names.contains(&name), "{name} is not among {names:?}");
    }
    for display in &displays {
        for field in ["ppd", "refresh_hz", "ipd_mm", "tracker_latency_ms"] {
            assert!(display[field].as_f64().is_some_and(|value| value > 0.0), "{field} of {display}");
        }
        for field in ["panel_px", "render_px"] {
            assert!(display[field][0].as_u64() > Some(0) && display[field][1].as_u64() > Some(0));
        }
        for guess in display["guesses"].as_array().expect("a list") {
            assert!(display.get(guess.as_str().expect("a name")).is_some(), "{guess} of {display}");
        }
        let tangent = |eye: &str, at: usize| display[eye][at].as_f64().expect("a number");
        assert_eq!(tangent("left_eye_tangents", 0), -tangent("right_eye_tangents", 1));
        assert_eq!(tangent("left_eye_tangents", 2), tangent("right_eye_tangents", 2));
    }
}

#[test]
fn the_table_marks_guesses() {
    let output = run(&["displays"]);
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    for display in displays() {
        let name = display["name"].as_str().expect("a name");
        let line = text.lines().find(|line| line.split_whitespace().next() == Some(name));
        let line = line.unwrap_or_else(|| panic!("{name} is not in {text}"));
        let guesses = display["guesses"].as_array().expect("a list").len();
        assert_eq!(line.matches('?').count(), guesses, "{line}");
    }
}

#[test]
fn a_display_gives_its_size_and_a_size_keeps_its_field_of_view() {
    // At the gaze, which is the display's centre unless it is given.
    let full = mapped(&["--display", "vive-pro-eye"], "1234,1370\n");
    assert_eq!(full["size"], serde_json::json!([2468, 2740]));
    assert_eq!(full["points"][0]["u_norm"], 0.0);
    let small = mapped(&["--display", "vive-pro-eye", "--size", "617x685"], "1,1\n");
    assert_eq!(small["size"], serde_json::json!([617, 685]));
    // 53.57 + 50.41 degrees: the tangents 1.354895 and 1.209037.
    let across = f64::to_degrees(1.354_895_f64.atan() + 1.209_037_f64.atan());
    for map in [&full, &small] {
        assert!((map["hfov_deg"].as_f64().expect("degrees") - across).abs() < 1e-9, "{map}");
    }
    let plain = mapped(&[], "1,1\n");
    assert_eq!((&plain["size"], &plain["hfov_deg"]), (&serde_json::json!([1920, 1080]), &100.0.into()));
}

#[test]
fn displays_that_make_no_sense_are_refused() {
    let place = Place::new();
    let out = place.path("out.png");
    let before = place.names();
    for (wrong, named) in [
        (vec!["--display", "vive"], "vive-pro-eye"),
        (vec!["--display", "psvr2", "--hfov-deg", "90"], "--hfov-deg"),
        (vec!["--display-eye", "right"], "--display"),
        (vec!["--display", "psvr2", "--display-eye", "middle"], "left"),
        (vec!["--display", "psvr2", "--size", "0x9"], "at least 1"),
    ] {
        for command in [&["map"][..], &["render", "hall", "-o", &out], &["replay", "hall"]] {
            let output = macula(&[command, &wrong[..]].concat()).stdin(Stdio::null()).output().unwrap();
            let line = failure(&output, 2, &format!("{command:?} {wrong:?}"));
            assert!(line.contains(named), "{line}");
        }
    }
    assert_eq!(place.names(), before);
}

#[test]
fn both_eyes_of_a_headset_are_rendered() {
    let place = Place::new();
    let hall = ["--triangles", "10000", "--lights", "3", "--method", "full", "--json"];
    let mut pictures = Vec::new();
    for eye in ["left", "right"] {
        let out = place.path(&format!("{eye}.png"));
        let display = [
            "render",
            "hall",
            "-o",
            &out,
            "--display",
            "varjo-aero",
            "--size",
            "83x71",
            "--display-eye",
            eye,
        ];
        let report = json(&run(&[&display[..], &hall[..]].concat()), eye);
        assert_eq!(report["size"], serde_json::json!([83, 71]));
        assert_eq!(report["non_finite"], 0);
        pictures.push(std::fs::read(&out).unwrap());
    }
    assert_ne!(pictures[0], pictures[1]);
}
