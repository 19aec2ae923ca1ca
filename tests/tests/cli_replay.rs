//! `macula replay`: a gaze session through the renderer.

use macula_tests::cli::{Place, failure, json, run};
use macula_tests::data::recording;
use std::path::Path;

/// A second and a half of a Vive Pro Eye.
fn session() -> String {
    recording("eyedentify3d/vive_duplicates.csv")
}

#[test]
fn a_session_is_rendered_frame_by_frame() {
    let place = Place::new();
    let [frames, sheet, ledger] = ["frames", "sheet.png", "ledger.csv"].map(|name| place.path(name));
    let session = session();
    let report = json(
        &run(&[
            "replay",
            "sdf",
            "--gaze-file",
            &session,
            "--latency",
            "vive-pro-eye",
            "--size",
            "96x54",
            "--frames",
            "5",
            "-o",
            &frames,
            "--sheet",
            &sheet,
            "--ledger",
            &ledger,
            "--json",
        ]),
        "replay",
    );
    assert_eq!((report["non_finite"].as_u64(), report["holes"].as_u64()), (Some(0), Some(0)));
    assert_eq!(report["validation_messages"], 0);
    let rendered = report["frames"].as_array().unwrap();
    assert_eq!(rendered.len(), 5);
    assert_eq!(std::fs::read_dir(&frames).unwrap().count(), 5);
    assert!(Path::new(&sheet).exists());

    // The ledger holds every refresh, and the frames have the gaze that it says.
    let ledger = std::fs::read_to_string(&ledger).unwrap();
    let mut lines = ledger.lines();
    let names: Vec<_> = lines.next().unwrap().split(',').collect();
    let rows: Vec<Vec<_>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len() as u64, report["refreshes"].as_u64().unwrap());
    let column = |name: &str| names.iter().position(|of| *of == name).unwrap();
    let mut with_gaze = 0;
    for frame in rendered {
        let refresh = frame["refresh"].to_string();
        let row = rows.iter().find(|row| row[column("refresh")] == refresh).unwrap();
        let number = |name: &str| row[column(name)].parse::<f64>().ok();
        assert_eq!(number("age_ms").is_some(), frame["age_ms"].as_f64().is_some());
        let Some(azimuth) = number("used_azimuth_deg") else {
            // Without a gaze every pixel is shaded.
            assert!(frame["gaze"].is_null());
            assert_eq!(frame["samples_shaded"], 96 * 54);
            continue;
        };
        with_gaze += 1;
        // A display 100 degrees wide: x = 1/2 + tan(azimuth) / (2 tan 50).
        let expected = 0.5 + 0.5 * azimuth.to_radians().tan() / 50f64.to_radians().tan();
        let x = frame["gaze"][0].as_f64().unwrap();
        assert!((x - expected).abs() < 1e-4, "{x} instead of {expected}");
        assert!(frame["samples_shaded"].as_u64().unwrap() < 96 * 54);
        assert!(frame["latch_gain_ms"].as_f64().unwrap() > 0.0);
    }
    assert!(with_gaze >= 3);
}

#[test]
fn the_same_session_gives_the_same_frames_and_a_head_turns_the_view() {
    let place = Place::new();
    // Of someone who boxes, and so turns the head.
    let session = recording("eyedentify3d/pico_boxing.csv");
    let frames = |name: &str, more: &[&str]| {
        let output = place.path(name);
        let mut arguments = vec![
            "replay",
            "sdf",
            "--gaze-file",
            &session,
            "--latency",
            "generic-90hz",
            "--size",
            "64x36",
            "--frames",
            "3",
            "--from",
            "0.5",
            "--predictor",
            "landing",
            "-o",
            &output,
            "--json",
        ];
        arguments.extend(more);
        json(&run(&arguments), name);
        let mut files: Vec<_> =
            std::fs::read_dir(&output).unwrap().map(|file| file.unwrap().path()).collect();
        files.sort();
        files.iter().map(|file| std::fs::read(file).unwrap()).collect::<Vec<_>>()
    };
    let first = frames("first", &[]);
    assert_eq!(first.len(), 3);
    assert!(first == frames("again", &[]), "two runs differ");
    assert!(first != frames("head", &["--head"]), "the head makes no difference");
}

#[test]
fn what_cannot_be_replayed_is_told_in_a_line() {
    let place = Place::new();
    let session = session();
    let sheet = place.path("sheet.png");
    let broken = place.write("broken.csv", "no gaze\n");
    for (arguments, code) in [
        (vec!["replay", "sdf", "--gaze-file", &session], 2),
        (vec!["replay", "sdf", "--gaze-file", "missing.csv", "--sheet", &sheet], 1),
        (vec!["replay", "sdf", "--gaze-file", &broken, "--sheet", &sheet], 1),
        (vec!["replay", "missing.glb", "--gaze-file", &session, "--sheet", &sheet], 1),
        (vec!["replay", "sdf", "--gaze-file", &session, "--sheet", &sheet, "--latency", "none-such"], 2),
        (vec!["replay", "sdf", "--gaze-file", &session, "--sheet", &sheet, "--frames", "65"], 2),
        (vec!["replay", "sdf", "--gaze-file", &session, "--sheet", "sheet.jpg"], 2),
        (vec!["replay", "sdf", "--gaze-file", &session, "--sheet", &sheet, "--head"], 2),
        (vec!["replay", "sdf", "--gaze-file", &session, "--sheet", &sheet, "--from", "1e9"], 2),
        (vec!["replay", "sdf", "--gaze-file", &session, "--sheet", &sheet, "--measured", "x=y.json"], 2),
        (
            vec![
                "replay",
                "sdf",
                "--gaze-file",
                &session,
                "--sheet",
                &sheet,
                "--method",
                "full",
                "--sigma",
                "2",
            ],
            2,
        ),
    ] {
        failure(&run(&arguments), code, &arguments.join(" "));
    }
    assert!(!Path::new(&sheet).exists());
}
