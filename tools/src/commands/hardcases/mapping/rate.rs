//! The density of samples: what the analytic Jacobian says against what the forward mapping does.

use super::super::family::{Family, Finding, Part, Place};
use super::super::subject::on_display;
use super::points::texel_extent_px;
use super::{Situation, any_gaze, at_px, share_between, situations};
use glam::{DVec2, DVec3};
use macula::fovea::{DisplayGeometry, Mapping, Rates, TexelJacobian};

/// One per cent is what a rate may be off. The differences are themselves good to 1e-4: over a thousandth of a
/// pixel the mappings hardly bend, and rounding takes 1e-5 of such a step.
const BOUND: f64 = 0.01;

/// Step of the differences, px; texels where those are larger, as far from the gaze a pixel may be less than
/// an angle's last digit.
const STEP: f64 = 1e-3;

/// No step is longer than this share of the distance from the gaze, on which mappings bend.
const LONGEST_STEP: f64 = 0.01;

/// Nearer to the gaze a mapping may be singular, px.
const SINGULAR_PX: f64 = 1.5;

/// Texels as large as the largest display have no slope that would show, and next to none in u: with the gaze
/// 1e7 px away a whole display can lie in the last digit.
const LARGEST_TEXEL_PX: f64 = 11520.0;

/// Whether a texel's slope can show.
fn has_slope(jacobian: &TexelJacobian) -> bool {
    texel_extent_px(jacobian).is_some_and(|extent_px| extent_px < LARGEST_TEXEL_PX)
}

pub fn families() -> Vec<Family> {
    vec![
        Family {
            name: "jacobian",
            what: "the analytic Jacobian is the forward mapping's slope in x and in y",
            part: Part::Mapping,
            place: Place::Cpu,
            bound: BOUND,
            unit: "of it",
            cases: || situations(any_gaze, jacobian),
        },
        Family {
            name: "rate",
            what: "cycles per degree along and across the great circles about the gaze are those counted",
            part: Part::Mapping,
            place: Place::Cpu,
            bound: BOUND,
            unit: "of it",
            cases: || situations(|display, gaze| on_display(display, gaze.px), rates),
        },
    ]
}

/// Texels from one position to another; v with the height at the first.
fn texels_between(situation: &Situation, mapping: &dyn Mapping, from: DVec2, to: DVec2) -> Option<DVec2> {
    let (first, last) = (mapping.forward(from)?, mapping.forward(to)?);
    let share = share_between(first.v_share, last.v_share, situation.periodic());
    Some(DVec2::new(last.u - first.u, share * mapping.column_height(first.u)))
}

/// A step that a mapping next to its reach or to a kink needs, and one that is long enough for texels of many
/// pixels, px.
fn steps_px(mapping: &dyn Mapping, jacobian: &TexelJacobian, px: DVec2) -> [f64; 2] {
    let extent_px = texel_extent_px(jacobian).unwrap_or(1.0).max(1.0);
    let longest_px = LONGEST_STEP * px.distance(mapping.gaze_px());
    [STEP, (STEP * extent_px).min(longest_px.max(STEP))]
}

/// First and last place of differences to both sides and to either, for each step.
fn ends(steps: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
    steps.into_iter().flat_map(|step| [[-step, step], [0.0, step], [-step, 0.0]])
}

/// The least error of all the differences. Where the slope jumps (the edge of a fovea or of a layer) it is that
/// of one side; elsewhere all of them say the same, and a wrong Jacobian contradicts each.
fn least(errors: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    errors.flatten().reduce(f64::min)
}

pub(super) fn jacobian(situation: &Situation, mapping: &dyn Mapping, finding: &mut Finding) {
    for px in situation.pixel_centres(mapping) {
        let Some(analytic) = mapping.jacobian(px).filter(has_slope) else {
            continue;
        };
        if px.distance(mapping.gaze_px()) < SINGULAR_PX {
            continue;
        }
        let steps_px = steps_px(mapping, &analytic, px);
        for (axis, slope) in [
            (DVec2::X, DVec2::new(analytic.du_dx, analytic.dv_dx)),
            (DVec2::Y, DVec2::new(analytic.du_dy, analytic.dv_dy)),
        ] {
            let error = least(ends(steps_px).map(|[from, to]| {
                let (from, to) = (px + axis * from, px + axis * to);
                let measured = texels_between(situation, mapping, from, to)? / (to - from).dot(axis);
                Some(measured.distance(slope) / slope.length())
            }));
            finding.error(error.unwrap_or(f64::INFINITY), || format!("{} along {axis}", at_px(px)));
        }
    }
}

/// Half the texels, or pixels where those are shaded themselves, in a degree of an arc.
fn counted_cpd(
    situation: &Situation,
    mapping: &dyn Mapping,
    [from, to]: [DVec2; 2],
    arc_rad: f64,
) -> Option<f64> {
    let native = mapping.is_native(from) && mapping.is_native(to);
    let samples = if native { to - from } else { texels_between(situation, mapping, from, to)? };
    Some(samples.length() / arc_rad.to_degrees() / 2.0)
}

/// Unit vectors away from the gaze and across that direction, both across the ray.
fn directions(display: &DisplayGeometry, gaze_px: DVec2, ray: DVec3) -> Option<[DVec3; 2]> {
    let gaze = display.ray_of_px(gaze_px).normalize();
    let across = gaze.cross(ray).try_normalize()?;
    Some([across.cross(ray), across])
}

pub(super) fn rates(situation: &Situation, mapping: &dyn Mapping, finding: &mut Finding) {
    let display = &situation.display;
    for px in situation.pixel_centres(mapping) {
        // On the border of the native region both counts hold.
        let around = [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y];
        let border = around.iter().any(|step| mapping.is_native(px + 0.1 * *step) != mapping.is_native(px));
        let slope = mapping.is_native(px) || mapping.jacobian(px).as_ref().is_some_and(has_slope);
        if border || !slope || px.distance(mapping.gaze_px()) < SINGULAR_PX {
            continue;
        }
        let ray = display.ray_of_px(px).normalize();
        let Some(Rates { radial_cpd, tangential_cpd }) = mapping.rates(px) else { continue };
        let Some([outward, across]) = directions(display, mapping.gaze_px(), ray) else { continue };
        // An arc of about one pixel.
        let pixel_rad = display.tangents_per_px().min_element() * ray.z * ray.z;
        let steps_px = mapping.jacobian(px).map_or([STEP; 2], |jacobian| steps_px(mapping, &jacobian, px));
        for (direction, analytic_cpd) in [(outward, radial_cpd), (across, tangential_cpd)] {
            let turned = |arc_rad: f64| display.px_of_ray(ray * arc_rad.cos() + direction * arc_rad.sin());
            let error = least(ends(steps_px).map(|[from, to]| {
                let ends = [turned(from * pixel_rad)?, turned(to * pixel_rad)?];
                let cpd = counted_cpd(situation, mapping, ends, (to - from) * pixel_rad)?;
                Some((cpd / analytic_cpd - 1.0).abs())
            }));
            finding.error(error.unwrap_or(f64::INFINITY), || format!("{}: {analytic_cpd} cpd", at_px(px)));
        }
    }
}
