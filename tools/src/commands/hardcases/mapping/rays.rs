//! Display positions and rays, to 90 degrees from the gaze and beyond.

use super::super::family::{Case, Family, Finding, Part, Place};
use super::super::random::Random;
use super::super::subject::{Gaze, Screen, gazes, screens};
use super::at_px;
use super::points::pixel_centres;
use glam::{DVec2, DVec3};
use macula::fovea::{DisplayGeometry, MAX_GAZE_PX};

/// Relative. Neighbouring pixels of 11520 are 1e-4 rad apart, of which rounding the rays leaves 1e-12;
/// gazes 1e7 px away lose three digits more.
const BOUND: f64 = 1e-8;

pub fn families() -> Vec<Family> {
    vec![Family {
        name: "rays",
        what: "rays lead back to their pixels, angles are Kahan's, and rays behind the eye meet nothing",
        part: Part::Mapping,
        place: Place::Cpu,
        bound: BOUND,
        unit: "of it",
        cases: || screens().into_iter().map(case).collect(),
    }]
}

fn case(screen: Screen) -> Case {
    Case::plain(screen.name, screen.quick, move || {
        let mut finding = Finding::default();
        let within_reach = |gaze: &Gaze| gaze.px.is_finite() && gaze.px.abs().max_element() <= MAX_GAZE_PX;
        for gaze in gazes(&screen.display).into_iter().filter(within_reach) {
            let mut random = Random::of(gaze.name);
            for px in pixel_centres(&screen.display, gaze.px, &mut random) {
                angles(&screen.display, gaze.px, px, &mut finding);
            }
        }
        behind(&screen.display, &mut finding);
        finding
    })
}

fn angles(display: &DisplayGeometry, gaze_px: DVec2, px: DVec2, finding: &mut Finding) {
    let ray = display.ray_of_px(px);
    let back = display.px_of_ray(ray * 37.5).map_or(f64::INFINITY, |back| back.distance(px));
    finding.error(back / px.length(), || format!("the ray of {}", at_px(px)));
    // W. Kahan, "How futile are mindless assessments of roundoff": good at every angle.
    let (a, b) = (display.ray_of_px(gaze_px).normalize(), ray.normalize());
    let expected = 2.0 * (a - b).length().atan2((a + b).length());
    let found = display.eccentricity_rad(gaze_px, px);
    // Next to the gaze the independent form has no digits left.
    if expected > 1e-6 {
        finding
            .error((found / expected - 1.0).abs(), || format!("{} from gaze {}", at_px(px), at_px(gaze_px)));
    } else {
        finding.holds((0.0..=2e-6).contains(&found), || format!("{found} rad at {}", at_px(px)));
    }
}

/// Rays along the display's plane and away from it.
fn behind(display: &DisplayGeometry, finding: &mut Finding) {
    for z in [0.0, -0.0, 1e-300, 1.0, f64::NAN] {
        for across in [DVec2::ZERO, DVec2::X, DVec2::new(-1e300, 1.0)] {
            let ray = across.extend(z);
            finding.holds(display.px_of_ray(ray).is_none(), || format!("the ray {ray} meets the display"));
        }
    }
    let nearly_along = display.px_of_ray(DVec3::new(1.0, 1.0, -1e-308));
    finding
        .holds(nearly_along.is_none_or(DVec2::is_finite), || "a ray along the display overflows".to_owned());
}
