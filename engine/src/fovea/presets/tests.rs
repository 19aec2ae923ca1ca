//! Tests of the display presets.

use super::*;
use glam::DVec2;
use macula_trackers::latency::{self, Stage};
use std::collections::HashSet;

/// The stages before the sample is with the renderer.
const BEFORE_THE_RENDERER: [Stage; 5] =
    [Stage::Exposure, Stage::Readout, Stage::TrackerProcessing, Stage::Polling, Stage::Wakeup];

fn preset(name: &str) -> &'static DisplayPreset {
    DisplayPreset::by_name(name).unwrap_or_else(|| panic!("there is no preset {name}"))
}

#[test]
fn names_are_unique_and_lead_to_their_preset() {
    let mut names = HashSet::new();
    for preset in DisplayPreset::all() {
        assert!(names.insert(preset.name), "{}", preset.name);
        assert!(preset.name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-'));
        assert_eq!(DisplayPreset::by_name(preset.name), Some(preset));
        assert!(!preset.about.is_empty() && !preset.source.is_empty());
    }
    assert_eq!(DisplayPreset::by_name("vive"), None);
}

#[test]
fn every_frustum_holds_the_view_axis_and_is_mirrored() {
    for preset in DisplayPreset::all() {
        let (left, right) = (preset.left(), preset.right());
        for display in [left, right] {
            display.check().unwrap_or_else(|error| panic!("{}: {error}", preset.name));
            assert!(display.tan_left < 0.0 && display.tan_right > 0.0, "{}", preset.name);
            assert!(display.tan_down < 0.0 && display.tan_up > 0.0, "{}", preset.name);
            assert_eq!(display.size_px, preset.render_px);
        }
        let (width, at) = (f64::from(left.size_px[0]), DVec2::new(13.25, 200.5));
        let (ray, mirrored) = (left.ray_of_px(at), right.ray_of_px(DVec2::new(width - at.x, at.y)));
        assert!((ray.x + mirrored.x).abs() < 1e-14, "{}", preset.name);
        assert_eq!((ray.y, ray.z), (mirrored.y, mirrored.z));
    }
    // The nose hides the inner side.
    let crystal = preset("pimax-crystal");
    assert!(-crystal.left().tan_left > crystal.left().tan_right);
    assert!(crystal.right().tan_right > -crystal.right().tan_left);
}

#[test]
fn density_is_that_of_a_degree_on_the_view_axis() {
    for preset in DisplayPreset::all() {
        let display = preset.left();
        let degree = 1f64.to_radians();
        let px = |x: f64, y: f64| display.px_of_ray(glam::DVec3::new(x, y, -1.0)).expect("ahead");
        let half = (degree / 2.0).tan();
        let across = (px(half, 0.0) - px(-half, 0.0)).x;
        let down = (px(0.0, -half) - px(0.0, half)).y;
        assert!((preset.ppd() / (across * down).sqrt() - 1.0).abs() < 1e-4, "{}", preset.name);
    }
}

#[test]
fn density_is_the_published_one() {
    let published = DisplayPreset::all().iter().filter_map(|preset| Some((preset, preset.published_ppd?)));
    let published: Vec<_> = published.collect();
    assert!(published.len() >= 5);
    for (preset, ppd) in published {
        assert!((preset.ppd() / ppd - 1.0).abs() < 0.1, "{}: {} and {ppd}", preset.name, preset.ppd());
    }
}

#[test]
fn monitors_follow_from_their_size_and_distance() {
    for (name, inches, distance_cm, ppd) in [
        ("desktop-24-1080p", 24.0, 60.0, 37.84),
        ("desktop-27-1440p", 27.0, 65.0, 48.59),
        ("desktop-27-4k", 27.0, 65.0, 72.88),
        ("desktop-32-4k", 32.0, 70.0, 66.22),
    ] {
        let preset = preset(name);
        let half_width_cm = inches * 2.54 * 16.0 / 16f64.hypot(9.0) / 2.0;
        let display = preset.left();
        assert!((display.tan_right - half_width_cm / distance_cm).abs() < 1e-12, "{name}");
        assert!((preset.ppd() - ppd).abs() < 5e-3, "{name}: {}", preset.ppd());
        assert_eq!(preset.left(), preset.right());
    }
    let (retinal, paper) = (preset("retinal").left(), DisplayGeometry::symmetric([11520, 6480], 120.0));
    assert_eq!(retinal.size_px, paper.size_px);
    assert!((retinal.tan_right - paper.tan_right).abs() < 1e-12);
    assert!((retinal.tan_up - paper.tan_up).abs() < 1e-12);
}

#[test]
fn trackers_are_as_late_as_their_latency_model_says() {
    for preset in DisplayPreset::all() {
        let model = latency::preset(preset.latency_preset).expect("a latency model");
        let mean_ms: f64 = BEFORE_THE_RENDERER.iter().map(|&stage| model.stage(stage).delay.mean_ms()).sum();
        assert!((preset.tracker_latency_ms - mean_ms).abs() < 1e-3, "{}: {mean_ms}", preset.name);
        assert_eq!(preset.refresh_hz, model.refresh_hz.value, "{}", preset.name);
        // Known where the vendor gives the larger part: exposure, read-out and processing.
        let is_guess = BEFORE_THE_RENDERER[..3].iter().any(|&stage| model.stage(stage).guess);
        assert_eq!(preset.is_guess("tracker_latency_ms"), is_guess, "{}", preset.name);
        let has_own = latency::PRESETS.iter().any(|(name, _)| *name == preset.name);
        assert!(!has_own || preset.latency_preset == preset.name, "{}", preset.name);
    }
}

#[test]
fn guesses_name_fields() {
    let known = [
        "panel_px",
        "render_px",
        "left_eye_tangents",
        "published_ppd",
        "refresh_hz",
        "ipd_mm",
        "tracker_latency_ms",
    ];
    for preset in DisplayPreset::all() {
        for guess in preset.guesses {
            assert!(known.contains(guess), "{}: {guess}", preset.name);
        }
        assert!(!preset.is_guess("published_ppd") || preset.published_ppd.is_some(), "{}", preset.name);
    }
}

#[test]
fn another_size_keeps_the_frusta() {
    let (full, small) = (preset("varjo-aero"), preset("varjo-aero").scaled([207, 178]));
    assert_eq!(small.left().size_px, [207, 178]);
    assert_eq!(DisplayGeometry { size_px: full.render_px, ..small.right() }, full.right());
    assert!((small.ppd() * 20.0 / full.ppd() - 1.0).abs() < 0.01);
}
