//! The mapping's shape: finite for every input, without a seam, rising outwards, right around the gaze.

use super::super::family::{Case, Family, Finding, Part, Place};
use super::super::subject::{Layout, Screen, Subject, methods, on_display, screens};
use super::points::extent_at_px;
use super::{Situation, any_gaze, at_px, share_between, situations};
use crate::failure::Failure;
use glam::DVec2;
use macula::fovea::{LpPoint, Mapping};

/// What rounding may take: u is below 1e5 texels, where doubles lie 1.5e-11 apart.
const ROUNDING_TEXELS: f64 = 1e-9;

/// The greatest offset from the seam is 1e-4 of the distance on the display and of that from the eye: the
/// azimuth's third-order term is then below 1e-12 of a turn, and columns have up to 1e4 texels.
const SEAM_TEXELS: f64 = 1e-6;

pub fn families() -> Vec<Family> {
    vec![
        Family {
            name: "finite",
            what: "every result is finite and in range: positions on and off the display, any column and row",
            part: Part::Mapping,
            place: Place::Cpu,
            bound: 0.0,
            unit: "values",
            cases: || situations(any_gaze, finite),
        },
        Family {
            name: "singular-point",
            what: "u rises from the gaze through r = 1 px, and pixels without a texel are native",
            part: Part::Mapping,
            place: Place::Cpu,
            bound: ROUNDING_TEXELS,
            unit: "texels",
            cases: || situations(|display, gaze| on_display(display, gaze.px), around_the_gaze),
        },
        Family {
            name: "monotone",
            what: "u never falls on the way outwards (by axes: from left to right)",
            part: Part::Mapping,
            place: Place::Cpu,
            bound: ROUNDING_TEXELS,
            unit: "texels",
            cases: || situations(any_gaze, monotone),
        },
        Family {
            name: "seam",
            what: "v, and what it leads back to, go on across the azimuth 0 from both sides",
            part: Part::Mapping,
            place: Place::Cpu,
            bound: SEAM_TEXELS,
            unit: "texels",
            cases: seams,
        },
    ]
}

/// Whether a point lies where LP points lie.
fn in_range(mapping: &dyn Mapping, point: LpPoint) -> bool {
    let columns = mapping.columns().heights().len() as f64;
    (0.0..=columns).contains(&point.u) && (0.0..1.0).contains(&point.v_share)
}

pub(super) fn finite(situation: &Situation, mapping: &dyn Mapping, finding: &mut Finding) {
    let gaze_px = mapping.gaze_px();
    finding.finite(gaze_px.x + gaze_px.y, || "the gaze in use".to_owned());
    let mut positions = situation.pixel_centres(mapping);
    let [width, height] = situation.display.size_px.map(f64::from);
    positions.extend([gaze_px, gaze_px + DVec2::Y * 5e-324, gaze_px - DVec2::X * 1e-300]);
    for [x, y] in [[-1.0, -1.0], [2.0 * width, -height], [1e6, 1e6], [-1e7, 3.0], [1e12, -1e12]] {
        positions.push(DVec2::new(x, y));
    }
    for &px in &positions {
        if let Some(point) = mapping.forward(px) {
            finding.finite(point.u, || format!("u at {}", at_px(px)));
            let inside = !on_display(&situation.display, px) || in_range(mapping, point);
            finding.holds(inside, || format!("{} maps out of the LP-buffer, to {point:?}", at_px(px)));
        }
        if let Some(jacobian) = mapping.jacobian(px) {
            let sum = jacobian.du_dx + jacobian.du_dy + jacobian.dv_dx + jacobian.dv_dy;
            finding.finite(sum, || format!("the Jacobian at {}", at_px(px)));
        }
        if let Some(rates) = mapping.rates(px).filter(|_| on_display(&situation.display, px)) {
            finding.finite(rates.radial_cpd + rates.tangential_cpd, || format!("a rate at {}", at_px(px)));
        }
    }
    finite_columns(mapping, finding);
    finding.error(finding.non_finite as f64, || "the values above".to_owned());
}

/// From every kind of column and row, also outside the LP-buffer.
fn finite_columns(mapping: &dyn Mapping, finding: &mut Finding) {
    let columns = mapping.columns().heights().len() as f64;
    for u in [-1e12, -1.0, 0.0, 5e-324, 0.5, 1.0, columns / 2.0, columns.next_down(), columns, columns + 1e9]
    {
        let height = mapping.column_height(u);
        finding.finite(height, || format!("the height at column {u}"));
        finding.holds(height >= 0.0, || format!("the height at column {u} is {height}"));
        for v_share in [0.0, 5e-324, 0.25, 0.5, 1.0_f64.next_down(), 1.0, -0.25, 7.5] {
            if let Some(px) = mapping.inverse(LpPoint { u, v_share }) {
                finding.finite(px.x + px.y, || format!("the position of column {u}, share {v_share}"));
            }
        }
    }
}

/// Distances from the gaze, px: 0, within a pixel, 1 from both sides, and the first pixels.
const NEAR_PX: [f64; 12] =
    [0.0, 5e-324, 1e-300, 1e-12, 1e-3, 0.5, 1.0 - 1e-15, 1.0, 1.0 + 1e-15, 1.5, 2.5, 4.0];

pub(super) fn around_the_gaze(situation: &Situation, mapping: &dyn Mapping, finding: &mut Finding) {
    let gaze_px = mapping.gaze_px();
    for px in situation.pixel_centres(mapping) {
        let texel = extent_at_px(mapping, px).is_some();
        finding.holds(texel || mapping.is_native(px), || format!("{} has no sample", at_px(px)));
    }
    if situation.subject.layout() != Layout::Polar {
        return;
    }
    for step in 0..16 {
        let outward = DVec2::from_angle(std::f64::consts::TAU * f64::from(step) / 16.0);
        let mut last_u = 0.0;
        for radius_px in NEAR_PX {
            let px = gaze_px + outward * radius_px;
            let Some(point) = mapping.forward(px) else { continue };
            finding.error((last_u - point.u).max(0.0), || at_px(px));
            let share = (0.0..1.0).contains(&point.v_share);
            finding.holds(share, || format!("v is {} at {}", point.v_share, at_px(px)));
            last_u = point.u;
        }
    }
}

pub(super) fn monotone(situation: &Situation, mapping: &dyn Mapping, finding: &mut Finding) {
    match situation.subject.layout() {
        Layout::Polar => outwards(mapping, finding),
        Layout::Axes => across(situation, mapping, 0, finding),
        // From the outer layer to the middle one u falls: once in a row.
        Layout::Layers => across(situation, mapping, 1, finding),
    }
}

fn outwards(mapping: &dyn Mapping, finding: &mut Finding) {
    const DIRECTIONS: u32 = 4;
    const STEPS: i32 = 600;
    let reach_px = 1.1 * mapping.display().farthest_corner_px(mapping.gaze_px());
    for direction in 0..DIRECTIONS {
        // Off the axes by a little, so that no direction is special.
        let angle = std::f64::consts::TAU * (f64::from(direction) + 0.01) / f64::from(DIRECTIONS);
        let mut last_u = 0.0;
        for step in 0..=STEPS {
            let radius_px = 0.01 * (reach_px / 0.01).powf(f64::from(step) / f64::from(STEPS));
            let px = mapping.gaze_px() + DVec2::from_angle(angle) * radius_px;
            let Some(point) = mapping.forward(px) else { continue };
            finding.error((last_u - point.u).max(0.0), || at_px(px));
            last_u = point.u;
        }
    }
}

/// Along rows of the display; `falls` of more than a texel are let pass in each.
fn across(situation: &Situation, mapping: &dyn Mapping, falls: u32, finding: &mut Finding) {
    const STEPS: u32 = 400;
    let [width, height] = situation.display.size_px.map(f64::from);
    for row in 0..7 {
        let (mut last_u, mut fallen) = (0.0, 0);
        for step in 0..=STEPS {
            let share = DVec2::new(f64::from(step) / f64::from(STEPS), (f64::from(row) + 0.5) / 7.0);
            let px = share * DVec2::new(width, height);
            let Some(point) = mapping.forward(px) else { continue };
            let fall = (last_u - point.u).max(0.0);
            last_u = point.u;
            if fall > 1.0 && fallen < falls {
                fallen += 1;
                continue;
            }
            finding.error(fall, || at_px(px));
        }
    }
}

fn seams() -> Vec<Case> {
    let mut cases = Vec::new();
    for subject in methods().into_iter().filter(|subject| subject.layout() == Layout::Polar) {
        for screen in screens() {
            let (id, quick) = (format!("{}/{}", subject.name, screen.name), subject.quick && screen.quick);
            let subject = subject.clone();
            cases.push(Case::new(id, quick, move |_| seam(&subject, &screen)));
        }
    }
    cases
}

fn seam(subject: &Subject, screen: &Screen) -> Result<Finding, Failure> {
    let mut finding = Finding::default();
    let [width, height] = screen.display.size_px.map(f64::from);
    // In the first row the offsets from the seam can be as small as doubles are.
    for gaze_px in
        [DVec2::new(width / 3.0, 0.0), DVec2::new(0.0, height / 2.0), DVec2::new(-5.0, 0.25 * height)]
    {
        let mapping = subject.mapping(&screen.display, gaze_px)?;
        for share in [0.01, 0.1, 0.5, 1.0] {
            let px = gaze_px + DVec2::X * (share * (width - gaze_px.x)).max(4.0);
            let eye_px = screen.display.tangents_per_px().max_element().recip();
            let distance_px = (px.x - gaze_px.x).min(eye_px);
            for exponent in [-4, -6, -9, -12, -30, -100, -300] {
                across_seam(&*mapping, px, distance_px * 10.0_f64.powi(exponent), &mut finding);
            }
            meeting_ends(&*mapping, px, &mut finding);
        }
    }
    Ok(finding)
}

/// Both sides of a point on the seam, against the slope there.
pub(super) fn across_seam(mapping: &dyn Mapping, px: DVec2, offset_px: f64, finding: &mut Finding) {
    let (above_px, below_px) = (px - DVec2::Y * offset_px, px + DVec2::Y * offset_px);
    let sides = (mapping.forward(above_px), mapping.forward(below_px));
    let (Some(above), Some(below)) = sides else { return };
    let (Some(middle), Some(slope)) = (mapping.forward(px), mapping.jacobian(px)) else { return };
    for side in [above, below] {
        let share = (0.0..1.0).contains(&side.v_share);
        finding.holds(share, || format!("v is {} beside {}", side.v_share, at_px(px)));
    }
    // What is left of the offset once it is added to the position.
    let step_px = below_px.y - above_px.y;
    let along = share_between(above.v_share, below.v_share, true) * mapping.column_height(middle.u);
    let off = (along - slope.dv_dy * step_px).hypot(below.u - above.u - slope.du_dy * step_px);
    finding.error(off, || format!("{offset_px:e} px beside {}", at_px(px)));
}

/// Columns begin where they end.
fn meeting_ends(mapping: &dyn Mapping, px: DVec2, finding: &mut Finding) {
    let Some(point) = mapping.forward(px) else { return };
    let Some(extent_px) = extent_at_px(mapping, px) else { return };
    let at = |v_share| mapping.inverse(LpPoint { u: point.u, v_share });
    let Some(first_px) = at(0.0) else { return };
    for last in [1.0_f64.next_down(), 1.0] {
        let gap_px = at(last).map_or(f64::INFINITY, |px| px.distance(first_px));
        finding.error(gap_px / extent_px.max(1.0), || format!("v = {last} against v = 0 at {}", at_px(px)));
    }
}
