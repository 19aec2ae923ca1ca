//! The effect plan and the frame graph: what runs, what does not and why, and that it makes no
//! difference to the picture.

use glam::{DMat4, DVec3};
use macula::headless::{FrameInput, OffscreenRenderer};
use macula::scene::environment::Environment;
use macula::scene::load::{LoadOptions, load};
use macula::scene::{AlphaMode, Material, Scene};
use macula::settings::{KfrSettings, Method, RenderSettings};
use macula_tests::scenes::{add, at, camera_of, hall, one, quad, sun, unlit, white};
use macula_tests::{
    Frame, ahead, data, gpu, greatest_step, kfr, next_frame, render, render_content, settings, upload,
};

const SIZE: [u32; 2] = [120, 80];

fn skipped<'a>(frame: &'a Frame, name: &str) -> Option<&'a str> {
    frame.effects.skipped.iter().find(|note| note.name == name).map(|note| note.why.as_str())
}

/// Lamp-less, opaque, without textures.
fn plain() -> Scene {
    let mut scene = one(quad(2.0, 2.0), at(0.0, 0.0, -2.0), unlit(0.6, 0.3, 0.1));
    add(&mut scene, quad(0.5, 0.4), at(0.4, 0.1, -1.5), white(0.3, 0.5));
    scene
}

fn glass() -> Material {
    let mut material = unlit(0.2, 0.9, 0.4);
    material.base_color.w = 0.5;
    Material { alpha_mode: AlphaMode::Blend, ..material }
}

fn subjects() -> Vec<(String, Scene)> {
    let mut lit = plain();
    lit.lights.push(sun(4.0, DVec3::new(0.3, -0.5, -1.0)));
    let mut blended = lit.clone();
    add(&mut blended, quad(0.6, 0.6), at(-0.3, 0.0, -1.0), glass());
    let mut subjects: Vec<_> =
        [("plain", plain()), ("lit", lit), ("blended", blended), ("hall", hall(10_000, 6))]
            .map(|(name, scene)| (name.to_owned(), scene))
            .into();
    for name in ["fox/Fox.glb", "khronos-tests/AlphaBlendModeTest.glb", "khronos-tests/BoxVertexColors.glb"] {
        let Some(path) = data::shared(&format!("data/scenes/{name}")) else { continue };
        subjects.push((name.to_owned(), load(&path, &LoadOptions::default()).unwrap()));
    }
    subjects
}

#[test]
fn forcing_effects_changes_nothing_that_is_seen() {
    let gpu = gpu();
    for (name, scene) in subjects() {
        let content = upload(&gpu, &scene, None);
        for method in [Method::Full, kfr(1.8, 4.0)] {
            let settings = settings(SIZE, 80.0, method.clone());
            let forced = RenderSettings { force_effects: true, ..settings.clone() };
            let view = if scene.cameras.is_empty() && scene.name == "test" {
                DMat4::IDENTITY
            } else {
                camera_of(&scene)
            };
            let input = FrameInput { world_from_view: view, ..ahead(&settings) };
            let planned = render_content(&gpu, &content, &settings, &input);
            let all = render_content(&gpu, &content, &forced, &input);
            all.check_whole(&name);
            let step = greatest_step(&planned, &all);
            assert!(step <= 1, "{name}, {method:?}: {step}/255");
            for note in planned.effects.run.iter().chain(&planned.effects.skipped).chain(&all.effects.run) {
                assert!(!note.why.is_empty() && !note.name.is_empty(), "{name}: {note:?}");
            }
            // Forced: the effects of scenes all run; only what settings switch off stays off.
            for effect in ["shadows", "environment", "normal maps", "transparency", "emissive", "alpha mask"]
            {
                assert!(
                    all.effects.run.iter().any(|note| note.name == effect),
                    "{name}: {effect} not forced"
                );
            }
            assert!(all.passes().contains(&"shadow") && all.passes().contains(&"forward"), "{name}");
        }
    }
}

#[test]
fn a_scene_pays_only_for_what_it_has() {
    let gpu = gpu();
    let settings = settings(SIZE, 80.0, Method::Full);
    let frame = render(&gpu, &plain(), None, &settings, &ahead(&settings));
    for pass in ["shadow", "forward", "lp_shade", "inverse"] {
        assert!(!frame.passes().contains(&pass), "{pass} ran: {:?}", frame.passes());
        assert!(!frame.plan_text.contains(&format!(" {pass}: ")), "{pass} planned: {}", frame.plan_text);
    }
    assert_eq!(frame.passes(), ["gbuffer", "full_shade", "output", "finite_check"]);
    for effect in ["shadows", "transparency", "environment", "normal maps", "alpha mask", "point lights"] {
        let why = skipped(&frame, effect).unwrap_or_else(|| panic!("{effect} is not listed as left out"));
        assert!(!why.is_empty());
    }
    assert_eq!(skipped(&frame, "shadows"), Some("the scene has no lamps"));
    assert_eq!(skipped(&frame, "foveation"), Some("full shading was asked for"));
    // And what it has runs.
    let sky = Environment::from_pixels("sky", [4, 2], vec![[0.5, 0.5, 0.5, 1.0]; 8]).unwrap();
    let mut scene = plain();
    scene.lights.push(sun(1.0, DVec3::NEG_Z));
    let frame = render(&gpu, &scene, Some(&sky), &settings, &ahead(&settings));
    assert!(frame.passes().contains(&"shadow"));
    for effect in ["shadows", "environment", "directional lights"] {
        assert!(frame.effects.run.iter().any(|note| note.name == effect), "{effect}");
        assert_eq!(skipped(&frame, effect), None, "{effect}");
    }
}

#[test]
fn blended_surfaces_cost_only_where_they_are_in_view() {
    let gpu = gpu();
    let mut scene = plain();
    add(&mut scene, quad(0.3, 0.3), at(0.0, 0.0, -1.0), glass());
    let content = upload(&gpu, &scene, None);
    for method in [Method::Full, kfr(1.8, 4.0)] {
        let settings = settings(SIZE, 80.0, method);
        let mut renderer = OffscreenRenderer::new(&gpu, &content, &settings).unwrap();
        let towards = ahead(&settings);
        let away = FrameInput { world_from_view: DMat4::from_rotation_y(std::f64::consts::PI), ..towards };
        for (input, in_view) in [(towards, true), (away, false), (towards, true)] {
            let frame = next_frame(&mut renderer, &settings, &input);
            frame.check_whole("blend");
            assert_eq!(frame.passes().contains(&"forward"), in_view, "{:?}", frame.passes());
            let why = skipped(&frame, "transparency");
            assert_eq!(why, (!in_view).then_some("the view holds no blended surface"));
            assert_eq!(frame.effects.run.iter().any(|note| note.name == "transparency"), in_view);
        }
    }
}

/// The passes of a printed plan, in order.
fn planned(text: &str) -> Vec<String> {
    let numbered = |line: &str| {
        let (number, rest) = line.trim_start().split_once(' ')?;
        number.parse::<u32>().ok()?;
        let (name, _) = rest.split_once(": reads")?;
        Some(name.to_owned())
    };
    text.lines().filter_map(numbered).collect()
}

#[test]
fn the_graph_prints_its_passes_in_order_with_barriers() {
    let gpu = gpu();
    let mut scene = plain();
    scene.lights.push(sun(1.0, DVec3::NEG_Z));
    add(&mut scene, quad(0.5, 0.5), at(0.0, 0.0, -1.0), glass());
    let kfr = KfrSettings { post_filter: true, ..KfrSettings::default() };
    for (method, expected) in [
        (
            Method::Full,
            &["shadow", "gbuffer", "full_shade", "forward", "output", "finite_check (diagnostic)"][..],
        ),
        (
            Method::Kfr(kfr),
            &[
                "lp_tables",
                "shadow",
                "gbuffer",
                "lp_classify",
                "lp_dispatch",
                "lp_shade",
                "lp_filter",
                "inverse",
                "post_filter",
                "forward",
                "output",
                "finite_check (diagnostic)",
            ],
        ),
    ] {
        let settings = settings(SIZE, 80.0, method);
        let frame = render(&gpu, &scene, None, &settings, &ahead(&settings));
        let text = &frame.plan_text;
        assert_eq!(planned(text), expected, "{text}");
        let ran: Vec<_> = expected.iter().map(|name| name.trim_end_matches(" (diagnostic)")).collect();
        assert_eq!(frame.passes(), ran);
        assert!(text.starts_with("inputs: scene") && text.contains("\noutputs: "), "{text}");
        // Whoever reads what a pass before wrote waits for it.
        let line_before = |pass: &str| {
            let lines: Vec<_> = text.lines().collect();
            let at = lines.iter().position(|line| line.contains(&format!(" {pass}: reads"))).unwrap();
            lines[at - 1].trim().to_owned()
        };
        for pass in ["output", "forward"] {
            assert!(line_before(pass).starts_with("barrier "), "{pass}: {text}");
        }
        // Every pass was timed.
        assert!(frame.stats.passes.iter().all(|pass| pass.gpu_ms.is_finite() && pass.gpu_ms >= 0.0));
        let sum: f64 =
            frame.stats.passes.iter().filter(|pass| !pass.diagnostic).map(|pass| pass.gpu_ms).sum();
        assert!((sum - frame.stats.gpu_ms).abs() < 1e-9);
    }
}
