//! Forward and back again.

use super::super::family::{Family, Finding, Part, Place};
use super::super::subject::{Layout, on_display, pixel_of};
use super::points::{extent_at_px, texel_extent_px};
use super::{Situation, any_gaze, at_px, share_between, situations};
use glam::DVec2;
use macula::fovea::{LpPoint, Mapping};

/// Positions are below 1e7 px (the farthest gaze in use), where doubles lie 2e-9 px apart; the logarithm,
/// whose error the way back multiplies with the distance, leaves 1e-8 px. A mapping that is right is a
/// hundred times below this.
const BOUND: f64 = 1e-6;

/// Texels are looked at up to so many display sizes off the display. Farther out, next to the directions
/// that never meet the plane, a position says little of the angle.
const REACH_DISPLAYS: f64 = 3.0;

pub fn families() -> Vec<Family> {
    vec![
        Family {
            name: "px-round-trip",
            what: "a pixel's centre maps to the LP-buffer and back to itself; every pixel has a sample",
            part: Part::Mapping,
            place: Place::Cpu,
            bound: BOUND,
            unit: "px, texels where larger",
            cases: || situations(any_gaze, pixels),
        },
        Family {
            name: "texel-round-trip",
            what: "a texel's centre maps to the display and back to itself, first and last columns included",
            part: Part::Mapping,
            place: Place::Cpu,
            bound: BOUND,
            unit: "texels",
            cases: || situations(any_gaze, texels),
        },
        Family {
            name: "gazed-pixel",
            what: "the gazed pixel is shaded itself, or maps back to itself",
            part: Part::Mapping,
            place: Place::Cpu,
            bound: BOUND,
            unit: "px",
            cases: || situations(|display, gaze| on_display(display, gaze.px), gazed_pixel),
        },
    ]
}

/// Distance between a position and where its LP point leads back to, px.
fn round_trip_px(mapping: &dyn Mapping, px: DVec2) -> Option<f64> {
    let back = mapping.inverse(mapping.forward(px)?)?;
    Some(back.distance(px))
}

pub(super) fn pixels(situation: &Situation, mapping: &dyn Mapping, finding: &mut Finding) {
    for px in situation.pixel_centres(mapping) {
        let extent_px = extent_at_px(mapping, px);
        if mapping.is_native(px) && extent_px.is_none() {
            continue;
        }
        // A pixel that is neither native nor on a texel with bounds has no sample of its own.
        finding.holds(extent_px.is_some(), || format!("there is no texel for {}", at_px(px)));
        if let Some(extent_px) = extent_px {
            let error_px = round_trip_px(mapping, px).unwrap_or(f64::INFINITY);
            finding.error(error_px / extent_px.max(1.0), || at_px(px));
        }
    }
}

pub(super) fn gazed_pixel(situation: &Situation, mapping: &dyn Mapping, finding: &mut Finding) {
    let px = pixel_of(&situation.display, situation.gaze_px);
    let native = mapping.is_native(px);
    let error_px = if native { Some(0.0) } else { round_trip_px(mapping, px) };
    finding.error(error_px.unwrap_or(f64::INFINITY), || at_px(px));
}

pub(super) fn texels(situation: &Situation, mapping: &dyn Mapping, finding: &mut Finding) {
    let mut random = situation.random();
    let heights = mapping.columns().heights();
    let count = heights.len() as u32;
    let [width, height] = situation.display.size_px.map(f64::from);
    let size_px = DVec2::new(width, height);
    let mut columns = vec![0, 1, 2, count / 2, count.saturating_sub(2), count.saturating_sub(1)];
    columns.extend((0..18).map(|_| random.below(count.max(1))));
    for column in columns.into_iter().filter(|column| *column < count) {
        let rows = heights[column as usize];
        for row in [0, rows / 2, rows - 1, random.below(rows), random.below(rows)] {
            let texel =
                LpPoint { u: f64::from(column) + 0.5, v_share: (f64::from(row) + 0.5) / f64::from(rows) };
            let Some(px) = mapping.inverse(texel) else { continue };
            let near =
                px.cmpge(-REACH_DISPLAYS * size_px).all() && px.cmple((1.0 + REACH_DISPLAYS) * size_px).all();
            // Where the mapping clamps there is no way back.
            let bounded = mapping.jacobian(px).as_ref().and_then(texel_extent_px).is_some();
            let Some(back) = mapping.forward(px).filter(|_| near && bounded) else { continue };
            let periodic = situation.periodic();
            let along = share_between(texel.v_share, back.v_share, periodic) * f64::from(rows);
            let off = (back.u - texel.u).hypot(along);
            // A texel of the outer layer under the finer one is never read.
            let hidden = situation.subject.layout() == Layout::Layers && (back.u - texel.u).abs() > 0.5;
            if !hidden {
                finding.error(off, || format!("texel {column}, {row} ({})", at_px(px)));
            }
        }
    }
}
