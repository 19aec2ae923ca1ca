//! What the commands print.

use macula_tests::cli::{json, macula, run};
use macula_tests::data;
use serde_json::Value;
use std::io::Write;
use std::process::{Output, Stdio};

const EXCERPT: &str = include_str!("data/mapping_excerpt.json");

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().expect("an object").keys().map(String::as_str).collect()
}

#[test]
fn render_reports_the_fields_that_are_promised() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (picture, lp) = (path("out.png"), path("lp.exr"));
    let hall = ["--triangles", "10000", "--lights", "3"];
    let base = ["render", "hall", "--size", "96x54", "--json", "-o", &picture, "--gaze", "0.3,0.6"];
    let report = json(&run(&[&base[..], &hall[..], &["--lp-out", &lp]].concat()), "kfr");
    for field in [
        "device",
        "driver",
        "size",
        "method",
        "passes",
        "gpu_ms",
        "samples_shaded",
        "lp",
        "effects",
        "non_finite",
        "validation_messages",
    ] {
        assert!(report.get(field).is_some(), "{field} is missing in {report}");
    }
    assert!(!report["device"].as_str().unwrap().is_empty() && !report["driver"].as_str().unwrap().is_empty());
    assert_eq!(report["size"], serde_json::json!([96, 54]));
    assert_eq!(report["method"], "kfr");
    assert_eq!(report["non_finite"], 0);
    assert_eq!(report["validation_messages"], 0, "{}", macula_tests::INSTALL_LAYER);
    for pass in report["passes"].as_array().unwrap() {
        assert!(pass["name"].is_string() && pass["gpu_ms"].as_f64().unwrap() >= 0.0, "{pass}");
    }
    for field in ["width", "height", "texels", "on_display"] {
        assert!(report["lp"][field].as_u64().unwrap() > 0, "{field}: {}", report["lp"]);
    }
    // 96 / 1.8 and 54 / 1.8.
    assert_eq!((&report["lp"]["width"], &report["lp"]["height"]), (&53.into(), &30.into()));
    for list in ["run", "skipped"] {
        let notes = report["effects"][list].as_array().unwrap();
        assert!(!notes.is_empty());
        for note in notes {
            assert_eq!(keys(note), ["name", "why"]);
        }
    }
    let (width, height) = image::image_dimensions(&picture).unwrap();
    assert_eq!((width, height), (96, 54));
    assert!(std::fs::read(&lp).unwrap().starts_with(&[0x76, 0x2f, 0x31, 0x01]), "not an OpenEXR file");

    let report = json(&run(&[&base[..], &hall[..], &["--method", "full"]].concat()), "full");
    assert_eq!((&report["method"], &report["samples_shaded"]), (&"full".into(), &(96 * 54).into()));
    assert_eq!(report["lp"], Value::Null);
    // Nothing else lies there.
    let mut names: Vec<_> =
        std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["lp.exr", "out.png"]);
}

#[test]
fn the_ray_marched_scene_renders() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sdf.png").to_string_lossy().into_owned();
    for method in ["full", "kfr"] {
        let report = json(
            &run(&["render", "sdf:primitives", "--size", "96x54", "--method", method, "-o", &path, "--json"]),
            method,
        );
        assert_eq!((&report["non_finite"], &report["validation_messages"]), (&0.into(), &0.into()));
        let picture = image::open(&path).unwrap().to_rgb8();
        let first = picture.get_pixel(0, 0);
        assert!(picture.pixels().any(|pixel| pixel != first), "{method}: an empty picture");
    }
}

fn map(arguments: &[&str], input: &str) -> Output {
    let mut child = macula(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("macula runs");
    child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
    child.wait_with_output().unwrap()
}

/// Runs `map` for each case of an oracle; `extra` decides where.
fn check_map(oracle: &str, extra: &[&str], tolerance: f64) {
    let oracle: Value = serde_json::from_str(oracle).unwrap();
    for case in oracle["cases"].as_array().unwrap().iter().filter(|case| case["method"] == "kfr") {
        let text = |value: &Value| value.to_string();
        let size = format!("{}x{}", case["display"]["width_px"], case["display"]["height_px"]);
        let gaze = format!("{},{}", case["gaze_px"][0], case["gaze_px"][1]);
        let hfov = text(&case["display"]["hfov_deg"]);
        let kernel = case["kernel"]["type"].as_str().unwrap();
        let mut arguments = vec!["map", "--method", "kfr", "--size", &size, "--hfov-deg", &hfov];
        arguments.extend(["--gaze-px", &gaze, "--kernel", kernel]);
        let (alpha, beta) = (text(&case["kernel"]["alpha"]), text(&case["kernel"]["beta"]));
        let beta = beta.trim_matches(['[', ']']);
        match kernel {
            "pow" => arguments.extend(["--alpha", &alpha]),
            "poly" => arguments.extend(["--beta", beta]),
            _ => {}
        }
        arguments.extend(extra);
        let points = case["points"].as_array().unwrap();
        let input: String = points.iter().map(|point| format!("{},{}\n", point["x"], point["y"])).collect();
        let output = map(&arguments, &input);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let stdout = String::from_utf8(output.stdout).unwrap();
        assert_eq!(stdout.lines().count(), points.len());
        for (line, point) in stdout.lines().zip(points) {
            let mapped: Value = serde_json::from_str(line).unwrap();
            assert_eq!(keys(&mapped), keys(point));
            for field in ["x", "y", "u_norm", "v_norm"] {
                let (found, expected) = (mapped[field].as_f64().unwrap(), point[field].as_f64().unwrap());
                // v is an angle of no meaning in the gazed pixel, and wraps.
                let off = (found - expected).abs();
                let off = if field == "v_norm" { off.min(1.0 - off) } else { off };
                let free = field == "v_norm" && point["u_norm"] == 0.0;
                assert!(
                    off <= tolerance || free,
                    "{case_of}: {field} {found}, not {expected}",
                    case_of = case["kernel"]
                );
            }
        }
    }
}

#[test]
fn map_prints_the_oracle() {
    check_map(EXCERPT, &[], 1e-9);
    if let Some(path) = data::shared("oracle/mapping.json") {
        check_map(&std::fs::read_to_string(path).unwrap(), &[], 1e-9);
    }
}

#[test]
fn map_prints_the_oracle_from_the_gpu_too() {
    check_map(EXCERPT, &["--gpu"], 1e-6);
}

/// Every case of VaFR's two forms in the high-precision oracle.
#[test]
fn map_prints_the_oracle_of_vafr() {
    let Some(path) = data::shared("oracle/mapping.json") else {
        println!("skipped: shared/oracle is not there");
        return;
    };
    let oracle: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let mut compared = 0;
    for case in oracle["cases"].as_array().unwrap() {
        let method = match case["method"].as_str().unwrap() {
            "vafr-planar" => "vafr-planar",
            "vafr-sphere" => "vafr",
            _ => continue,
        };
        let size = format!("{}x{}", case["display"]["width_px"], case["display"]["height_px"]);
        let gaze = format!("{},{}", case["gaze_px"][0], case["gaze_px"][1]);
        let hfov = case["display"]["hfov_deg"].to_string();
        let arguments = ["map", "--method", method, "--size", &size, "--hfov-deg", &hfov, "--gaze-px", &gaze];
        let points = case["points"].as_array().unwrap();
        let input: String = points.iter().map(|point| format!("{},{}\n", point["x"], point["y"])).collect();
        let output = map(&arguments, &input);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        for (point, line) in points.iter().zip(String::from_utf8(output.stdout).unwrap().lines()) {
            let got: Value = serde_json::from_str(line).unwrap();
            let close = |name: &str, want: f64, period: f64| {
                let got = got[name].as_f64().unwrap();
                let miss = (got - want).abs();
                // v is periodic: a full turn is none.
                let miss = miss.min((period - miss).abs());
                assert!(miss <= 1e-9 * want.abs().max(1.0), "{method} {size} {name}: {got}, not {want}");
            };
            let of = |name: &str| point[name].as_f64().unwrap();
            close("u", of("u"), f64::INFINITY);
            close("height", of("l"), f64::INFINITY);
            close("v", of("v"), of("l"));
            compared += 1;
        }
    }
    assert!(compared >= 400, "only {compared} points");
}

#[test]
fn map_names_a_bad_line() {
    let output = map(&["map", "--size", "64x64"], "1,2\nnonsense\n");
    let line = macula_tests::cli::failure(&output, 1, "map");
    assert!(line.contains("line 2"), "{line}");
}

#[test]
fn a_picture_equals_itself() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (a, b) = (path("a.png"), path("b.png"));
    let mut picture =
        image::RgbaImage::from_fn(40, 30, |x, y| image::Rgba([x as u8 * 6, y as u8 * 8, 99, 255]));
    picture.save(&a).unwrap();
    let report = json(&run(&["compare", &a, &a, "--gaze", "0.5,0.5", "--hfov-deg", "90", "--json"]), "same");
    assert_eq!((&report["psnr_db"], &report["flip"]), (&"inf".into(), &0.0.into()));
    assert_eq!(report["psnr_within_5_deg_db"], "inf");
    assert_eq!(report["rings"].as_array().unwrap().len(), 6);
    let surviving = &report["acuity_surviving"];
    assert_eq!((&surviving["psnr_db"], &surviving["rmse"]), (&"inf".into(), &0.0.into()));
    assert_eq!(surviving["rings"].as_array().unwrap().len(), 6);
    // One value of 3 * 1200 off by 36: the mean square is known.
    picture.get_pixel_mut(3, 4).0[2] += 36;
    picture.save(&b).unwrap();
    let report = json(&run(&["compare", &a, &b, "--json"]), "one value");
    let expected = 10.0 * (255.0_f64.powi(2) * 3600.0 / 36.0_f64.powi(2)).log10();
    assert!((report["psnr_db"].as_f64().unwrap() - expected).abs() < 1e-6, "{report}");
    assert!(report["flip"].as_f64().unwrap() > 0.0);
    assert_eq!(report["acuity_surviving"], Value::Null);
    // With half a pixel to a degree the display resolves less than the eye everywhere: all survives.
    let eye = ["--gaze", "0.5,0.5", "--hfov-deg", "90", "--json"];
    let report = json(&run(&[&["compare", &a, &b][..], &eye].concat()), "one value");
    let surviving = report["acuity_surviving"]["psnr_db"].as_f64().unwrap();
    assert!((surviving - expected).abs() < 1e-3, "{surviving}, not {expected}");
}

#[test]
fn the_hall_has_the_same_bytes_for_the_same_seed() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let make = |name: &str, seed: &str| {
        let file = path(name);
        let arguments =
            ["scene", "hall", "-o", &file, "--triangles", "10000", "--lights", "9", "--seed", seed, "--json"];
        let report = json(&run(&arguments), name);
        let bytes = std::fs::read(&file).unwrap();
        assert_eq!(report["bytes"], bytes.len());
        assert_eq!((&report["lights"], &report["triangles"]), (&9.into(), &10_000.into()));
        bytes
    };
    let (first, second, other) = (make("a.glb", "5"), make("b.glb", "5"), make("c.glb", "6"));
    assert!(first == second, "the same seed, other bytes");
    assert!(first != other, "another seed, the same bytes");
    let report = json(&run(&["info", &path("a.glb"), "--json"]), "info");
    assert!(report.is_object(), "{report}");
}

#[test]
fn doctor_tells_what_there_is() {
    let report = json(&run(&["doctor", "--json"]), "doctor");
    let devices = report["devices"].as_array().unwrap();
    assert!(!devices.is_empty());
    for device in devices {
        assert!(device["name"].is_string() && device["driver"].is_string() && device["usable"].is_boolean());
    }
    assert!(report["validation_layer"].is_boolean());
    let text = run(&["doctor"]);
    assert!(text.status.success());
    let text = String::from_utf8(text.stdout).unwrap();
    assert!(text.contains(devices[0]["name"].as_str().unwrap()), "{text}");
}

#[test]
fn help_says_what_each_command_does() {
    let all = run(&["--help"]);
    assert!(all.status.success());
    let all = String::from_utf8(all.stdout).unwrap();
    for command in ["doctor", "scene", "info", "compare", "render", "bench", "map", "demo"] {
        assert!(all.contains(command), "{command} in {all}");
        let help = run(&[command, "--help"]);
        assert!(help.status.success() && help.stdout.len() > 200, "{command}");
    }
}
