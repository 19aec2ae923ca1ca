//! Foveated frames of every size, method and gaze: whole, and full shading where the eye looks.

use super::super::bench::Bench;
use super::super::family::{Case, Family, Finding, Part, Place};
use super::super::subject::{Gaze, Screen, Subject, gazes, methods, on_display, pixel_of};
use super::scenes::pattern;
use super::stage::{Frame, frame, looking_ahead, renderer, upload};
use crate::failure::Failure;
use glam::DVec2;
use macula::fovea::DisplayGeometry;
use macula::headless::{Content, GpuContent};
use macula::settings::Method;

pub fn families() -> Vec<Family> {
    vec![
        Family {
            name: "frames",
            what: "frames of every display size, method and gaze hold no value that is not finite and no hole",
            part: Part::Shading,
            place: Place::Gpu,
            bound: 0.0,
            unit: "values",
            cases: frames,
        },
        Family {
            name: "gazed-pixel-shaded",
            what: "the gazed pixel is that of full shading, bit for bit, where the method shades it itself",
            part: Part::Shading,
            place: Place::Gpu,
            bound: 0.0,
            unit: "radiance",
            cases: gazed_pixels,
        },
    ]
}

/// Displays that are rendered: one so narrow that the acuity asks for fewer samples than pixels everywhere, one
/// pixel, one without symmetry, odd and prime sides, one row or column, one as long as the longest.
fn rendered_screens() -> Vec<Screen> {
    let screen = |name, size_px: [u32; 2], hfov_deg| Screen {
        name,
        display: DisplayGeometry::symmetric(size_px, hfov_deg),
        quick: false,
    };
    let [tan_left, tan_right, tan_up, tan_down] = [-1.42, 1.07, 1.19, -1.43];
    let asymmetric = DisplayGeometry { size_px: [144, 160], tan_left, tan_right, tan_up, tan_down };
    vec![
        screen(NARROW, [160, 90], 1.2),
        screen("1x1", [1, 1], 60.0),
        Screen { name: "asymmetric", display: asymmetric, quick: false },
        screen("13x17", [13, 17], 80.0),
        screen("2x1", [2, 1], 60.0),
        screen("1x7", [1, 7], 20.0),
        screen("64x64", [64, 64], 90.0),
        screen("101x103", [101, 103], 90.0),
        screen("320x180-5deg", [320, 180], 5.0),
        screen("1280x720", [1280, 720], 100.0),
        screen("11520x16", [11520, 16], 120.0),
    ]
}

const NARROW: &str = "160x90-1.2deg";

/// How many of the displays are rendered with every method's hardest parameters too.
const WITH_ALL_PARAMETERS: usize = 2;

/// All gazes up to this many pixels; on larger displays those of the subset.
const MANY_PIXELS: u32 = 20_000;

fn rendered_gazes(display: &DisplayGeometry) -> Vec<Gaze> {
    let [width, height] = display.size_px;
    gazes(display).into_iter().filter(|gaze| width * height <= MANY_PIXELS || gaze.quick).collect()
}

/// A case for each method on the first `most` displays. `quick`: methods and displays of the subset.
fn cases(
    most: usize,
    quick: &[(&str, &str)],
    check: fn(&Bench, &Subject, &Screen) -> Result<Finding, Failure>,
) -> Vec<Case> {
    let mut cases = Vec::new();
    for subject in methods() {
        let most = if subject.quick { most } else { WITH_ALL_PARAMETERS };
        for screen in rendered_screens().into_iter().take(most) {
            let id = format!("{}/{}", subject.name, screen.name);
            let quick = quick.contains(&(subject.name, screen.name));
            let subject = subject.clone();
            cases.push(Case::new(id, quick, move |bench| check(bench, &subject, &screen)));
        }
    }
    cases
}

fn frames() -> Vec<Case> {
    let quick = [("kfr", "1x1"), ("vafr", "1x1"), ("vafr-planar", NARROW), ("guenter3", NARROW)];
    let mut all = cases(usize::MAX, &quick, triangles);
    // The ray-marched scene has passes of its own.
    let marched = methods().into_iter().filter(|subject| subject.quick);
    all.extend(marched.map(|subject| {
        let id = format!("{}/ray-marched", subject.name);
        let quick = subject.name == "rmfr";
        Case::new(id, quick, move |bench| ray_marched(bench, &subject))
    }));
    all
}

fn triangles(bench: &Bench, subject: &Subject, screen: &Screen) -> Result<Finding, Failure> {
    let content = upload(bench, &pattern(&screen.display), None)?;
    every_gaze(bench, &content, &subject.method, &screen.display)
}

fn ray_marched(bench: &Bench, subject: &Subject) -> Result<Finding, Failure> {
    let content = GpuContent::upload(bench.device()?, &Content::SdfPrimitives)?;
    every_gaze(bench, &content, &subject.method, &DisplayGeometry::symmetric([96, 54], 100.0))
}

fn every_gaze(
    bench: &Bench,
    content: &GpuContent,
    method: &Method,
    display: &DisplayGeometry,
) -> Result<Finding, Failure> {
    let mut finding = Finding::default();
    let mut renderer = renderer(bench, content, display, method)?;
    for gaze in rendered_gazes(display) {
        let frame = frame(&mut renderer, display.size_px, &looking_ahead(gaze.px))?;
        frame.whole(&mut finding, &format!("gaze {}", gaze.name));
        let held = frame.stats.gaze_held != gaze.px.is_finite();
        finding.holds(held, || format!("gaze {}: held is {}", gaze.name, frame.stats.gaze_held));
    }
    Ok(finding)
}

fn gazed_pixels() -> Vec<Case> {
    cases(4, &[("kfr", "1x1"), ("vafr", NARROW), ("guenter3", NARROW)], gazed_pixel)
}

fn gazed_pixel(bench: &Bench, subject: &Subject, screen: &Screen) -> Result<Finding, Failure> {
    let (display, mut finding) = (&screen.display, Finding::default());
    let content = upload(bench, &pattern(display), None)?;
    let size = display.size_px;
    let mut full = renderer(bench, &content, display, &Method::Full)?;
    let reference = frame(&mut full, size, &looking_ahead(display.center_px()))?;
    let mut foveated = renderer(bench, &content, display, &subject.method)?;
    for gaze in rendered_gazes(display).into_iter().filter(|gaze| on_display(display, gaze.px)) {
        let px = pixel_of(display, gaze.px);
        if !subject.mapping(display, gaze.px)?.is_native(px) {
            continue;
        }
        let frame = frame(&mut foveated, size, &looking_ahead(gaze.px))?;
        frame.must_be_whole(&mut finding, gaze.name);
        finding.error(difference(&frame, &reference, px), || format!("gaze {} at {px}", gaze.name));
    }
    Ok(finding)
}

fn difference(a: &Frame, b: &Frame, px: DVec2) -> f64 {
    let (a, b) = (a.at_px(px), b.at_px(px));
    (0..3).map(|channel| (a[channel] - b[channel]).abs()).fold(0.0, f64::max)
}
