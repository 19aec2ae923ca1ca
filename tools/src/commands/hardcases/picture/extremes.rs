//! Shading at the ends of what scenes hold.

use super::super::bench::Bench;
use super::super::family::{Case, Family, Finding, Part, Place};
use super::super::subject::methods;
use super::extreme_scenes::{DEPTHS_M, FRONT_COLOURS, SCENES, bumpy, depths, moved};
use super::scenes::{add, at, lamp, one, quad, sun, texture, white, with};
use super::stage::{Frame, frame, looking_ahead, picture, renderer, upload};
use crate::failure::Failure;
use glam::{DMat3, DMat4, DVec2, DVec3};
use macula::fovea::DisplayGeometry;
use macula::headless::FrameInput;
use macula::scene::{Material, Mesh, Scene};
use macula::settings::Method;

/// Two steps of a half float, in which radiance is stored, relative: what a different way to the same number
/// may change in the last digit of the number and of the normal that the G-buffer holds.
const SAME: f64 = 2.0 / 1024.0;

/// Radiance below this counts as this in relative errors.
const DARK: f64 = 1e-3;

const SIZE: [u32; 2] = [96, 64];

fn display() -> DisplayGeometry {
    DisplayGeometry::symmetric(SIZE, 60.0)
}

/// Methods that differ in how they come by their samples: every pixel, by kernels, by eccentricity, by axes.
/// The function that shades a sample is the same in all methods.
const METHODS: [&str; 3] = ["kfr", "vafr-planar", "guenter3"];

pub fn families() -> Vec<Family> {
    vec![
        Family {
            name: "extreme-scenes",
            what: "scenes with extreme depths, normals, scales, materials, lights and triangles give whole frames",
            part: Part::Shading,
            place: Place::Gpu,
            bound: 0.0,
            unit: "values",
            cases: extreme_scenes,
        },
        Family {
            name: "depth-order",
            what: "from 1 mm to 100 km in one view the nearer of two surfaces is seen, a ten-thousandth apart",
            part: Part::Shading,
            place: Place::Gpu,
            bound: 0.0,
            unit: "px",
            cases: || vec![Case::new("panels", true, depth_order)],
        },
        Family {
            name: "same-picture",
            what: "what describes the same surface in another way looks the same",
            part: Part::Shading,
            place: Place::Gpu,
            bound: SAME,
            unit: "of it",
            cases: same_pictures,
        },
    ]
}

/// Scenes of the subset: those that are hardest on numbers.
const QUICK: [&str; 4] = ["normals-of-length-0", "lights-on-surfaces", "radiance-3e38", "huge-triangles"];

fn extreme_scenes() -> Vec<Case> {
    let foveated = methods().into_iter().filter(|subject| METHODS.contains(&subject.name));
    let mut rendered = vec![("full", Method::Full)];
    rendered.extend(foveated.map(|subject| (subject.name, subject.method)));
    let mut cases = Vec::new();
    for (scene, build) in SCENES {
        for (name, method) in rendered.clone() {
            let quick = name == "vafr-planar" && QUICK.contains(&scene);
            let check = move |bench: &Bench| {
                let (display, mut finding) = (display(), Finding::default());
                let view = build(&display)?;
                let content = upload(bench, &view.scene, view.environment.as_ref())?;
                let mut renderer = renderer(bench, &content, &display, &method)?;
                for gaze_px in [display.center_px(), DVec2::new(90.0, 3.0)] {
                    let input = FrameInput { world_from_view: view.world_from_view, gaze_px };
                    let frame = frame(&mut renderer, SIZE, &input)?;
                    frame.whole(&mut finding, &format!("gaze {}, {}", gaze_px.x, gaze_px.y));
                }
                Ok(finding)
            };
            cases.push(Case::new(format!("{scene}/{name}"), quick, check));
        }
    }
    cases
}

/// The panels stand at -0.75, -0.25, 0.25 and 0.75 of the view's tangent, a half each.
fn depth_order(bench: &Bench) -> Result<Finding, Failure> {
    let display = DisplayGeometry::symmetric([128, 32], 90.0);
    let frame = picture(bench, &depths(), &display, &Method::Full, display.center_px())?;
    let mut finding = Finding::default();
    frame.must_be_whole(&mut finding, "the panels");
    for (panel, expected) in FRONT_COLOURS.into_iter().enumerate() {
        let mut wrong = 0;
        // A pixel at each side of a panel may show its neighbour.
        for x in 32 * panel as u32 + 1..32 * panel as u32 + 31 {
            for y in 0..32 {
                wrong += u32::from(frame.at(x, y) != expected.map(f64::from));
            }
        }
        finding.error(f64::from(wrong), || format!("the panel at {} m", DEPTHS_M[panel]));
    }
    Ok(finding)
}

/// A surface described in two ways, each with its eye.
type Pair = fn() -> [(Scene, DVec3); 2];

fn same_pictures() -> Vec<Case> {
    let pairs: [(&str, Pair); 7] = [
        ("origin-1048576m-away", || both_origins(DVec3::new(1_048_576.0, -524_288.0, 2_097_152.0))),
        ("origin-1e6m-away", || both_origins(DVec3::new(1e6 + 0.1, -3e5, 2e6 - 0.7))),
        ("no-tangents", || here([no_tangents(true), no_tangents(false)])),
        ("mirrored-uv", || here([tilted(true), tilted(false)])),
        ("mirrored-scale", || here([true, false].map(mirrored))),
        ("non-uniform-scale", || here([true, false].map(stretched))),
        ("tiny-scale", || here([1e-6, 1.0].map(scaled))),
    ];
    let quick = ["origin-1e6m-away", "mirrored-uv"];
    let case = |(name, pair): (&str, Pair)| {
        Case::new(name, quick.contains(&name), move |bench| compare(bench, pair()))
    };
    pairs.into_iter().map(case).collect()
}

fn here(scenes: [Scene; 2]) -> [(Scene, DVec3); 2] {
    scenes.map(|scene| (scene, DVec3::ZERO))
}

fn compare(bench: &Bench, views: [(Scene, DVec3); 2]) -> Result<Finding, Failure> {
    let (display, mut finding) = (display(), Finding::default());
    let mut frames = Vec::new();
    for (scene, eye) in &views {
        let content = upload(bench, scene, None)?;
        let mut renderer = renderer(bench, &content, &display, &Method::Full)?;
        let input = FrameInput {
            world_from_view: DMat4::from_translation(*eye),
            ..looking_ahead(display.center_px())
        };
        let rendered = frame(&mut renderer, SIZE, &input)?;
        rendered.must_be_whole(&mut finding, "one of the two");
        frames.push(rendered);
    }
    let seen = |frame: &Frame| frame.at(SIZE[0] / 2, SIZE[1] / 2).iter().sum::<f64>() > DARK;
    finding.holds(frames.iter().all(seen), || "the surface is not seen".to_owned());
    for y in 0..SIZE[1] {
        for x in 0..SIZE[0] {
            let (a, b) = (frames[0].at(x, y), frames[1].at(x, y));
            let off = (0..3).map(|c| (a[c] - b[c]).abs() / a[c].max(b[c]).max(DARK)).fold(0.0, f64::max);
            finding.error(off, || format!("px {x}, {y}"));
        }
    }
    Ok(finding)
}

/// A curved-looking wall under a lamp: no edge of it is in view, which rounding could move by a pixel.
fn wall_scene(surface: Mesh, place: DMat4, material: Material) -> Scene {
    let mut scene = one(surface, place, material);
    scene.lights.push(sun(2.0));
    scene.lights.push(lamp(3.0, DVec3::new(0.3, 0.2, -0.8)));
    scene
}

fn both_origins(by: DVec3) -> [(Scene, DVec3); 2] {
    let scene = || {
        let tilt = DMat4::from_rotation_y(0.3) * DMat4::from_rotation_x(-0.2);
        wall_scene(quad(4.0, 4.0), at(0.0, 0.0, -1.5) * tilt, white(0.4, 0.35))
    };
    let there = moved(scene(), by);
    [(scene(), DVec3::ZERO), (there.scene, by)]
}

/// Without a tangent a normal map has no meaning and is left out.
fn no_tangents(with_map: bool) -> Scene {
    let mut scene = bumpy(with(quad(3.0, 3.0), |vertex| vertex.tangent = [0.0; 4]));
    if !with_map {
        scene.materials[0].normal_texture = None;
    }
    scene
}

/// A normal map that tilts along the texture's u, on a wall whose u runs the other way, against the tilt
/// turned round.
fn tilted(mirrored: bool) -> Scene {
    let surface = with(quad(3.0, 3.0), |vertex| {
        if mirrored {
            vertex.uv0.x = 1.0 - vertex.uv0.x;
            vertex.tangent = [-1.0, 0.0, 0.0, -1.0];
        }
    });
    let mut scene = wall_scene(surface, at(0.0, 0.0, -1.5), white(0.2, 0.5));
    // 2 x/255 - 1 of the two is +0.25 and -0.25.
    let along = if mirrored { 159 } else { 96 };
    scene.materials[0].normal_texture = Some(texture(&mut scene, [1, 1], false, |_, _| [along, 128, 250]));
    scene
}

/// A panel that its own mirror image equals.
fn mirrored(mirrored: bool) -> Scene {
    let scale = if mirrored { DVec3::new(-1.0, 1.0, 1.0) } else { DVec3::ONE };
    let place = at(0.0, 0.0, -1.5) * DMat4::from_scale(scale);
    wall_scene(quad(3.0, 3.0), place, white(0.3, 0.4))
}

/// A slanted wall stretched by its transform, against one whose vertices are stretched. Its normals follow
/// the inverse transpose.
fn stretched(by_transform: bool) -> Scene {
    let (slant, stretch) = (DMat3::from_rotation_y(0.8), DMat3::from_diagonal(DVec3::new(1.0, 2.0, 0.25)));
    let place = at(0.0, 0.0, -1.5);
    let material = white(0.3, 0.4);
    if by_transform {
        return wall_scene(quad(6.0, 3.0), place * DMat4::from_mat3(stretch * slant), material);
    }
    let normal = (stretch.inverse().transpose() * slant * DVec3::Z).normalize().as_vec3();
    let surface = with(quad(6.0, 3.0), |vertex| {
        vertex.position = (stretch * slant * vertex.position.as_dvec3()).as_vec3();
        vertex.normal = normal;
    });
    wall_scene(surface, place, material)
}

/// A wall of its size in the world, whatever its mesh's.
fn scaled(scale: f64) -> Scene {
    let half = (3.0 / scale) as f32;
    let mut scene = wall_scene(
        quad(half, half),
        at(0.0, 0.0, -1.5) * DMat4::from_scale(DVec3::splat(scale)),
        white(0.3, 0.4),
    );
    add(
        &mut scene,
        quad(half, half),
        at(0.0, 0.0, -9.0) * DMat4::from_scale(DVec3::splat(scale)),
        white(0.0, 1.0),
    );
    scene
}
