//! The mapping on the GPU, against an oracle computed apart from this code.

use glam::DVec2;
use macula::fovea::{DisplayGeometry, Kernel, KfrMapping, LpCoord};
use macula::headless::map_points_on_gpu;
use macula_tests::{data, gpu};
use serde_json::Value;

const EXCERPT: &str = include_str!("data/mapping_excerpt.json");

/// The greatest error after mapping back, px.
const MOST_PX: f64 = 1e-4;

fn kernel_of(value: &Value) -> Kernel {
    match value["type"].as_str().unwrap() {
        "pow" => Kernel::Power { alpha: value["alpha"].as_f64().unwrap() },
        "sin" => Kernel::Sine,
        "exp" => Kernel::Exponential,
        "poly" => {
            let beta: Vec<_> =
                value["beta"].as_array().unwrap().iter().map(|b| b.as_f64().unwrap()).collect();
            Kernel::polynomial(&beta).unwrap()
        }
        other => panic!("kernel {other}"),
    }
}

fn check(document: &str) {
    let document: Value = serde_json::from_str(document).unwrap();
    let gpu = gpu();
    let (mut points_seen, mut worst) = (0, (0.0, String::new()));
    for case in document["cases"].as_array().unwrap().iter().filter(|case| case["method"] == "kfr") {
        let number = |value: &Value| value.as_f64().unwrap();
        let size = ["width_px", "height_px"].map(|side| case["display"][side].as_u64().unwrap() as u32);
        let display = DisplayGeometry::symmetric(size, number(&case["display"]["hfov_deg"]));
        let gaze_px = DVec2::new(number(&case["gaze_px"][0]), number(&case["gaze_px"][1]));
        let kernel = kernel_of(&case["kernel"]);
        let mapping = KfrMapping::new(size, gaze_px, kernel, 1.0);
        let points = case["points"].as_array().unwrap();
        let places: Vec<_> = points.iter().map(|p| DVec2::new(number(&p["x"]), number(&p["y"]))).collect();
        let mapped = map_points_on_gpu(&gpu, &display, gaze_px, &kernel, &places).unwrap();
        assert_eq!(mapped.len(), places.len());
        for ((point, place), mapped) in points.iter().zip(&places).zip(mapped) {
            let oracle = LpCoord { u_norm: number(&point["u_norm"]), v_norm: number(&point["v_norm"]) };
            let what = format!("{size:?} {gaze_px} {kernel:?} at {place}: {mapped:?}, not {oracle:?}");
            if oracle.u_norm == 0.0 {
                // All of the innermost pixel: its angle says nothing of the place.
                assert_eq!(mapped.u_norm, 0.0, "{what}");
            } else {
                let error = mapping.inverse(mapped).distance(mapping.inverse(oracle));
                assert!(error < MOST_PX, "{what}: {error} px");
                if error > worst.0 {
                    worst = (error, what);
                }
            }
            points_seen += 1;
        }
    }
    println!("{points_seen} points, at most {} px off: {}", worst.0, worst.1);
    assert!(points_seen >= 20);
}

#[test]
fn known_answers() {
    check(EXCERPT);
}

#[test]
fn the_whole_oracle() {
    let Some(path) = data::shared("oracle/mapping.json") else { return };
    check(&std::fs::read_to_string(path).unwrap());
}

#[test]
fn no_points_give_none() {
    let display = DisplayGeometry::symmetric([64, 64], 90.0);
    let none = map_points_on_gpu(&gpu(), &display, DVec2::ZERO, &Kernel::Sine, &[]).unwrap();
    assert!(none.is_empty());
}
