//! `macula render --stereo`: both eyes in one picture, figures of each, and what makes no sense.

use macula_tests::cli::{Place, failure, json, run};
use std::path::Path;

const HALL: [&str; 8] =
    ["render", "hall", "--triangles", "10000", "--lights", "3", "--display", "varjo-aero"];

fn stereo(place: &Place, name: &str, more: &[&str]) -> (String, serde_json::Value) {
    let out = place.path(name);
    let arguments = [&HALL[..], &["--size", "96x80", "-o", &out, "--json"], more].concat();
    let report = json(&run(&arguments), name);
    (out, report)
}

#[test]
fn both_eyes_stand_beside_each_other() {
    let place = Place::new();
    let (dup, report) = stereo(&place, "dup.png", &["--stereo", "dup"]);
    let picture = macula::io::image_file::read_png_rgba8(Path::new(&dup)).unwrap();
    assert_eq!(picture.0, [192, 80]);
    let half =
        |first: usize| picture.1.chunks_exact(4 * 192).flat_map(move |row| &row[first..first + 4 * 96]);
    assert!(half(0).ne(half(4 * 96)), "two eyes see two pictures");
    assert!([0, 4 * 96].into_iter().all(|first| half(first).any(|value| (1..255).contains(value))));
    assert_eq!(report["against_dup"], serde_json::Value::Null);
    assert_eq!((&report["non_finite"], &report["holes"]), (&0.into(), &0.into()));
    assert_eq!(report["right"]["lp"]["reused"], 0);
    assert_eq!(report["size"], serde_json::json!([96, 80]));

    let (_, report) = stereo(&place, "rep.exr", &["--stereo", "rep", "--frames", "2", "--fixation-m", "2"]);
    let against = &report["against_dup"];
    let lp = &report["right"]["lp"];
    let of = |name: &str| lp[name].as_u64().expect("a count");
    let samples = report["right"]["samples_shaded"].as_u64().expect("a count");
    assert_eq!(of("shaded") + of("native_pixels"), samples);
    assert_eq!(samples + of("reused"), against["dup_samples_shaded"].as_u64().expect("a count"));
    assert!(against["error"]["flip"].as_f64().is_some_and(|flip| flip < 0.1), "{against}");
    assert!(against["error"]["rings"].as_array().is_some_and(|rings| rings.len() == 6));
    let notes = report["right"]["effects"]["run"].as_array().expect("notes");
    assert!(notes.iter().any(|note| note["name"] == "reprojection"));
    // Both gazes converge: the right eye's lies to the left of the mirrored one.
    let gaze = |eye: &str| report[eye]["gaze_px"][0].as_f64().expect("px");
    assert!(gaze("left") == 48.0 && gaze("right") < 96.0);
}

#[test]
fn what_makes_no_sense_is_refused() {
    let place = Place::new();
    let out = place.path("out.png");
    for (wrong, named) in [
        (vec!["--stereo", "both"], "dup"),
        (vec!["--fixation-m", "1"], "--stereo"),
        (vec!["--stereo", "dup", "--fixation-m", "-1"], "0.05"),
        (vec!["--stereo", "dup", "--fixation-m", "nan"], "0.05"),
        (vec!["--stereo", "rep", "--method", "full"], "foveated"),
        (vec!["--stereo", "dup", "--lp-out", "lp.png"], "--lp-out"),
        (vec!["--stereo", "dup", "--display", "psvr2", "--display-eye", "left"], "--display-eye"),
    ] {
        let line = failure(&run(&[&["render", "hall", "-o", &out], &wrong[..]].concat()), 2, named);
        assert!(line.contains(named), "{line}");
    }
    let marched = run(&["render", "sdf:primitives", "-o", &out, "--stereo", "rep"]);
    assert!(failure(&marched, 2, "sdf").contains("G-buffer"));
    assert!(place.names().is_empty());
}
