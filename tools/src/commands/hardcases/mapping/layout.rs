//! The LP-buffer's columns.

use super::super::family::{Family, Finding, Part, Place};
use super::{Situation, any_gaze, situations};
use macula::fovea::Mapping;

/// A column has the whole number nearest to its analytic height; half a texel and what rounding adds.
const BOUND_TEXELS: f64 = 0.5 + 1e-9;

/// No LP-buffer that makes sense is as large, texels: sixteen times the pixels of 11520x6480.
const MOST_TEXELS: u64 = 1 << 30;

pub fn families() -> Vec<Family> {
    vec![Family {
        name: "columns",
        what: "columns have at least a texel and their analytic height, and add up, also in buffers of one texel",
        part: Part::Mapping,
        place: Place::Cpu,
        bound: BOUND_TEXELS,
        unit: "texels",
        cases: || situations(any_gaze, columns),
    }]
}

pub(super) fn columns(situation: &Situation, mapping: &dyn Mapping, finding: &mut Finding) {
    let columns = mapping.columns();
    let (heights, offsets) = (columns.heights(), columns.offsets());
    finding.holds(!heights.is_empty(), || "there is no column".to_owned());
    finding.holds(offsets.len() == heights.len() + 1, || format!("{} offsets", offsets.len()));
    let mut total = 0;
    for ((column, &height), &offset) in heights.iter().enumerate().zip(offsets) {
        finding.holds(height >= 1, || format!("column {column} has no texel"));
        finding.holds(offset == total, || format!("column {column} begins at {offset}, not at {total}"));
        total += u64::from(height);
        // Heights below one texel are raised to one.
        let analytic = mapping.column_height(column as f64 + 0.5).max(1.0);
        finding.error((f64::from(height) - analytic).abs(), || format!("column {column}"));
    }
    finding.holds(columns.texels() == total, || format!("{} texels, not {total}", columns.texels()));
    finding.holds(total <= MOST_TEXELS, || format!("{total} texels"));
    let [width, height] = columns.size();
    let fits = width as usize == heights.len() && heights.iter().all(|column| *column <= height);
    finding.holds(fits, || format!("the image is {width}x{height}"));
    for px in situation.pixel_centres(mapping) {
        let inside = mapping.forward(px).is_none_or(|point| point.u <= f64::from(width));
        finding.holds(inside, || format!("px {}, {} lies beyond the last column", px.x, px.y));
    }
}
