//! `macula rates`: what it prints and draws, and what it refuses.

use macula_tests::cli::{Place, failure, json, run};
use roxmltree::Document;
use serde_json::Value;

fn number(value: &Value, path: &str) -> f64 {
    let found = path.split('/').fold(value, |value, key| match key.parse::<usize>() {
        Ok(index) => &value[index],
        Err(_) => &value[key],
    });
    found.as_f64().unwrap_or_else(|| panic!("{path} is {found}"))
}

/// The row of an eccentricity.
fn row(rates: &Value, ecc_deg: f64) -> Value {
    let mut rows = rates["rows"].as_array().expect("rows").iter();
    rows.find(|row| number(row, "ecc_deg") == ecc_deg).expect("a row").clone()
}

#[test]
fn rates_are_those_of_the_acuity_and_of_the_display() {
    let arguments =
        ["rates", "--method", "vafr,full", "--size", "1920x1080", "--gaze-deg", "0,30", "--step-deg", "5"];
    let report = json(&run(&[&arguments[..], &["--json"]].concat()), "rates");
    assert_eq!((&report["acuity"], &report["counted_on"]), (&"vafr-2025".into(), &"CPU".into()));
    let curves = report["curves"].as_array().expect("curves");
    let names: Vec<_> = curves.iter().map(|curve| curve["method"].as_str().unwrap()).collect();
    assert_eq!(names, ["vafr", "full", "vafr", "full"]);
    let px_per_tan = 960.0 / 50f64.to_radians().tan();
    for (curve, off_axis_deg) in curves.iter().zip([0.0, 0.0, 30.0, 30.0f64]) {
        assert!((number(curve, "gaze/off_axis_deg") - off_axis_deg).abs() < 1e-9);
        let gaze_x = 960.0 + px_per_tan * off_axis_deg.to_radians().tan();
        assert!((number(curve, "gaze/px/0") - gaze_x).abs() < 1e-6);
        assert_eq!(number(curve, "gaze/px/1"), 540.0);
        let is_full = curve["method"] == "full";
        for (kind, bound) in [("analytic", 1e-9), ("counted", 0.01)] {
            assert!(number(&curve[kind], "deviation/off_both") < bound, "{}", curve[kind]["deviation"]);
            // MAR grows from 0.2 to 0.25 degrees between 30 and 60; the native disc ends before.
            for (ecc_deg, acuity_cpd) in [(30.0, 5.0), (45.0, 1.0 / 0.225)] {
                let row = row(&curve[kind], ecc_deg);
                assert_eq!(number(&row, "native_share"), f64::from(u8::from(is_full)));
                for direction in ["radial", "tangential"] {
                    let found = number(&row, &format!("{direction}/cpd/mean"));
                    let display_cpd = number(&row, &format!("{direction}/display_cpd"));
                    let expected = if is_full { display_cpd } else { acuity_cpd };
                    assert!((found / expected - 1.0).abs() < bound, "{kind} {direction}: {row}");
                }
            }
        }
        let totals = &curve["totals"];
        assert_eq!(totals["display_pixels"], 1920 * 1080);
        let samples = if is_full { 1920.0 * 1080.0 } else { number(totals, "limit") };
        // VaFR takes what the limit says but for whole columns and the disc's edge.
        assert!((number(totals, "samples") / samples - 1.0).abs() < 0.01, "{totals}");
        assert_eq!(totals["frame"], Value::Null);
    }
    // The known answer with the gaze at the centre, and a flat display's own rate about its axis.
    assert!((number(&curves[0], "totals/limit") / 684e3 - 1.0).abs() < 2e-3);
    let expected = px_per_tan / 10f64.to_radians().cos().powi(2) * 1f64.to_radians() / 2.0;
    let full = row(&curves[1]["analytic"], 10.0);
    assert!((number(&full, "radial/cpd/mean") / expected - 1.0).abs() < 1e-9, "{full}");
}

#[test]
fn the_gpu_counts_what_the_cpu_counts() {
    let arguments = [
        "rates",
        "--method",
        "vafr,kfr,visual-polar",
        "--size",
        "960x540",
        "--gaze-deg",
        "25",
        "--step-deg",
        "4",
        "--json",
    ];
    let [cpu, gpu] = [&arguments[..], &[&arguments[..], &["--gpu"]].concat()]
        .map(|arguments| json(&run(arguments), "rates"));
    assert_eq!((&cpu["counted_on"], &gpu["counted_on"]), (&"CPU".into(), &"GPU".into()));
    for curve in gpu["curves"].as_array().expect("curves") {
        let [totals, frame] = [&curve["totals"], &curve["totals"]["frame"]];
        assert!((0.5..=1.0).contains(&number(frame, "share_on_display")), "{frame}");
        // A frame shades what is of use, and some texels more that are needed to interpolate.
        let over = number(frame, "samples") / number(totals, "samples");
        assert!((1.0..1.3).contains(&over), "{totals}");
    }
    for at in 0..3 {
        for ecc_deg in [8.0, 20.0, 40.0] {
            for direction in ["radial", "tangential"] {
                let mean = |report: &Value| {
                    let row = row(&report["curves"][at]["counted"], ecc_deg);
                    number(&row, &format!("{direction}/cpd/mean"))
                };
                let (cpu, gpu) = (mean(&cpu), mean(&gpu));
                assert!((gpu / cpu - 1.0).abs() < 0.005, "{at} {direction} at {ecc_deg}: {gpu}, not {cpu}");
            }
        }
    }
}

#[test]
fn text_and_plot_are_written() {
    let place = Place::new();
    let plot = place.path("rates.svg");
    let acuity = place.write("mine.toml", "degrees = [0, 30]\ncpd = [20, 2]\nsmooth = true\n");
    let arguments = [
        "rates",
        "--method",
        "vafr,vafr-planar",
        "--display",
        "vive-pro-eye,varjo-aero",
        "--display-eye",
        "right",
        "--size",
        "320x300",
        "--gaze",
        "0.4,0.5",
        "--acuity",
        &acuity,
        "--step-deg",
        "2",
        "--y-scale",
        "linear",
        "-o",
        &plot,
    ];
    let output = run(&arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    for told in ["mine.toml", "vafr-planar", "vive-pro-eye 320x300, right eye", "varjo-aero", "limit"] {
        assert!(text.contains(told), "{told} in {text}");
    }
    let svg = std::fs::read_to_string(&plot).unwrap();
    let document = Document::parse(&svg).expect("XML");
    let curves = document.descendants().filter(|node| {
        node.has_tag_name("path")
            && node.attribute("class").is_some_and(|class| class.starts_with("tangential c"))
    });
    // Four in the panel, four in the legend.
    assert_eq!(curves.count(), 8);
    assert_eq!(place.names(), ["mine.toml", "rates.svg"]);
}

#[test]
fn a_display_of_one_pixel_has_its_pixel() {
    let report = json(&run(&["rates", "--size", "1x1", "--method", "vafr,full", "--json"]), "1x1");
    for curve in report["curves"].as_array().expect("curves") {
        assert_eq!(number(curve, "totals/samples"), 1.0, "{}", curve["totals"]);
        assert!((number(curve, "totals/limit") - 1.0).abs() < 1e-9);
    }
}

#[test]
fn bad_input_is_refused() {
    let place = Place::new();
    let rising = place.write("rising.toml", "degrees = [0, 10]\ncpd = [5, 10]\n");
    let noise = place.write("noise.toml", b"\xff\xfe\x00");
    let missing = place.path("missing.toml");
    let before = place.names();
    for (path, named) in [(&rising, "rising.toml"), (&noise, "noise.toml"), (&missing, "missing.toml")] {
        let line = failure(&run(&["rates", "--size", "64x64", "--acuity", path]), 1, named);
        assert!(line.contains(named), "{line}");
    }
    let nowhere = place.path("no/such/folder/rates.svg");
    let line = failure(&run(&["rates", "--size", "64x64", "-o", &nowhere]), 1, "no folder");
    assert!(line.contains("folder"), "{line}");
    for wrong in [
        vec!["--size", "0x64"],
        vec!["--size", "64"],
        vec!["--size", "64x40000"],
        vec!["--hfov-deg", "180"],
        vec!["--hfov-deg", "90", "--display", "vive-pro-eye"],
        vec!["--display", "vive"],
        vec!["--display-eye", "right"],
        vec!["--gaze-deg", "90"],
        vec!["--gaze-deg", "0,nan"],
        vec!["--gaze-deg", "10", "--gaze", "0.5,0.5"],
        vec!["--gaze", "0.5"],
        vec!["--gaze", "inf,0"],
        vec!["--gaze", "1e308,0"],
        vec!["--acuity-scale", "0"],
        vec!["--step-deg", "0"],
        vec!["--step-deg", "nan"],
        vec!["--method", "other"],
        vec!["--method", "vafr,,full"],
        vec!["--y-scale", "square"],
        vec!["--method", "full,vafr,full", "--size", "64x64,65x65,66x66"],
    ] {
        failure(&run(&[&["rates"][..], &wrong].concat()), 2, &format!("{wrong:?}"));
    }
    assert_eq!(place.names(), before);
}
