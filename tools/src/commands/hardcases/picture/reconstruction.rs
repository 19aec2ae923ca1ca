//! From the LP-buffer to the display: interpolated between the right texels, without a seam at the azimuth 0
//! and without a step where native pixels end.
//!
//! All of it on a picture that rises evenly in x and in y, so that a value says where it was taken: errors are
//! distances in pixels. Texels are far apart where a method spends few, and between them a bent mapping bends
//! the ramp; that is taken from the mapping in double precision, and what is left is the renderer's.

use super::super::bench::Bench;
use super::super::family::{Case, Family, Finding, Part, Place};
use super::super::subject::{Layout, Subject, methods};
use super::scenes::ramp;
use super::stage::{Frame, frame, looking_ahead, settings, upload};
use crate::failure::Failure;
use glam::DVec2;
use macula::fovea::{DisplayGeometry, LpPoint, Mapping};
use macula::headless::OffscreenRenderer;
use macula::settings::{LpFilter, Method, RenderSettings};

/// A sample is the pixel that holds the texel's centre: half a pixel off on each axis, 0.71 px in all. The
/// G-buffer's emission has 9 bits and the picture 11: 0.4 px of 320.
const RAMP_PX: f64 = 1.1;

/// How much more the steps across the seam may differ from what the mapping says than those on the other
/// side of the gaze, px. The samples of both sides lie at other places within their pixels.
const SEAM_PX: f64 = 0.5;

/// How far the mean of a ring about the gaze may be from that of the next one, px: a ring of 2 px has at
/// least 30 pixels, each up to half a pixel off at random, which leaves 0.1 px.
const RING_PX: f64 = 0.3;

pub fn families() -> Vec<Family> {
    let family = |name, what, bound, unit, cases| Family {
        name,
        what,
        part: Part::Shading,
        place: Place::Gpu,
        bound,
        unit,
        cases,
    };
    vec![
        family(
            "ramp",
            "a linear ramp comes back as a ramp, interpolated between the texels around each pixel",
            RAMP_PX,
            "px",
            || cases(|_| true, 3, &["kfr", "vafr"], ramps),
        ),
        family(
            "seam-gradient",
            "the gradient of a smooth picture shows no seam to the right of the gaze",
            SEAM_PX,
            "px",
            || cases(|subject| subject.layout() == Layout::Polar, 2, &["vafr-planar"], seams),
        ),
        family("ring", "no step where native pixels and the LP-buffer meet", RING_PX, "px", || {
            cases(|_| true, 2, &["kfr", "vafr"], rings)
        }),
    ]
}

/// A foveated ramp.
struct Ramp<'a> {
    frame: &'a Frame,
    mapping: &'a dyn Mapping,
    layout: Layout,
}

impl Ramp<'_> {
    fn size_px(&self) -> DVec2 {
        DVec2::from_array(self.frame.size.map(f64::from))
    }

    fn gaze_px(&self) -> DVec2 {
        self.mapping.gaze_px()
    }

    /// Where the value of a pixel was taken, px.
    fn taken_px(&self, x: u32, y: u32) -> DVec2 {
        let [red, green, _] = self.frame.at(x, y);
        DVec2::new(red, green) * self.size_px()
    }

    /// How far that is from where it belongs: between the pixel itself, if it is native, and the mean of the
    /// four texels around it; anywhere between the two in the band where both blend. `None` next to
    /// directions that never meet the display.
    fn error_px(&self, x: u32, y: u32) -> Option<DVec2> {
        let centre = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
        let bend = self.interpolated_px(centre)? - centre;
        let moved = self.taken_px(x, y) - centre;
        let share = (moved.dot(bend) / bend.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        Some(moved - share * bend)
    }

    /// Pixels and their errors.
    fn errors(&self) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
        let [width, height] = self.frame.size;
        let all = (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)));
        all.filter_map(|(x, y)| Some((DVec2::new(f64::from(x), f64::from(y)) + 0.5, self.error_px(x, y)?)))
    }

    /// The mean of the texels around a position: linear in each of the two nearest columns, then across.
    fn interpolated_px(&self, px: DVec2) -> Option<DVec2> {
        let point = self.mapping.forward(px)?;
        let at = point.u - 0.5;
        let share = at - at.floor();
        let [inner, outer] = [at.floor(), at.floor() + 1.0].map(|column| self.in_column(column, point));
        Some(inner?.lerp(outer?, share))
    }

    fn in_column(&self, column: f64, point: LpPoint) -> Option<DVec2> {
        let heights = self.mapping.columns().heights();
        // Layers do not run into each other; elsewhere the first and the last column end the buffer.
        let own = heights[(point.u as usize).min(heights.len() - 1)];
        let nearest = (column.max(0.0) as usize).min(heights.len() - 1);
        let nearest =
            if self.layout == Layout::Layers && heights[nearest] != own { point.u as usize } else { nearest };
        let rows = f64::from(heights[nearest]);
        let at = point.v_share * rows - 0.5;
        let share = at - at.floor();
        let [first, second] = [at.floor(), at.floor() + 1.0].map(|row| {
            let row =
                if self.layout == Layout::Polar { row.rem_euclid(rows) } else { row.clamp(0.0, rows - 1.0) };
            let texel = LpPoint { u: nearest as f64 + 0.5, v_share: (row + 0.5) / rows };
            // Texels off the display take its border's pixel.
            let taken = |px: DVec2| px.clamp(DVec2::splat(0.5), self.size_px() - 0.5);
            self.mapping.inverse(texel).map(taken)
        });
        Some(first?.lerp(second?, share))
    }
}

/// Displays on which the picture's detail, the texels and the native disc have every relation: hardly any
/// native pixels, native pixels in the middle, and texels of several pixels.
fn displays() -> [(&'static str, DisplayGeometry); 3] {
    [
        ("320x200-2deg", DisplayGeometry::symmetric([320, 200], 2.0)),
        ("320x240-5deg", DisplayGeometry::symmetric([320, 240], 5.0)),
        ("240x160-90deg", DisplayGeometry::symmetric([240, 160], 90.0)),
    ]
}

type Check = fn(&Ramp, &mut Finding);

/// A case for each wanted method on the first `most` displays, of hard parameters on the first only. `quick`:
/// methods of the subset.
fn cases(wanted: fn(&Subject) -> bool, most: usize, quick: &[&str], check: Check) -> Vec<Case> {
    let mut cases = Vec::new();
    let unfiltered = |subject: &Subject| plain_method(&subject.method).lp_filter() == LpFilter::None;
    for subject in methods().into_iter().filter(wanted).filter(unfiltered) {
        let most = if subject.quick { most } else { 1 };
        for (index, (name, display)) in displays().into_iter().take(most).enumerate() {
            let id = format!("{}/{name}", subject.name);
            let quick = quick.contains(&subject.name) && index + 1 == most.min(2);
            let subject = subject.clone();
            cases.push(Case::new(id, quick, move |bench| run(bench, &subject, &display, check)));
        }
    }
    cases
}

/// What there is no case for, and why.
pub const LEFT_OUT: (&str, &str) = (
    "the ramp with LaFR",
    "its filter over the LP-buffer, which cannot be switched off, moves values by itself",
);

/// A method without the filter that spreads samples over several texels, where that can be switched off.
fn plain_method(method: &Method) -> Method {
    let mut method = method.clone();
    match &mut method {
        Method::Kfr(kfr) => kfr.lp_filter = LpFilter::None,
        Method::Vafr(vafr) => vafr.lp_filter = LpFilter::None,
        _ => {}
    }
    method
}

/// One sample for each texel.
fn plain(display: &DisplayGeometry, method: &Method) -> RenderSettings {
    RenderSettings { footprint: false, ..settings(display, &plain_method(method)) }
}

fn run(
    bench: &Bench,
    subject: &Subject,
    display: &DisplayGeometry,
    check: Check,
) -> Result<Finding, Failure> {
    let mut finding = Finding::default();
    let content = upload(bench, &ramp(display), None)?;
    let mut renderer = OffscreenRenderer::new(bench.device()?, &content, &plain(display, &subject.method))?;
    let size = DVec2::from_array(display.size_px.map(f64::from));
    for share in [DVec2::new(0.5, 0.5), DVec2::new(0.25, 0.7)] {
        // On a corner of four pixels, so that rows lie evenly on both sides of the seam.
        let gaze_px = (share * size).round();
        let frame = frame(&mut renderer, display.size_px, &looking_ahead(gaze_px))?;
        frame.must_be_whole(&mut finding, "the ramp");
        let mapping = subject.mapping(display, gaze_px)?;
        check(&Ramp { frame: &frame, mapping: &*mapping, layout: subject.layout() }, &mut finding);
    }
    Ok(finding)
}

fn ramps(ramp: &Ramp, finding: &mut Finding) {
    for (px, error_px) in ramp.errors() {
        finding.error(error_px.length(), || format!("px {}, {} (gaze {})", px.x, px.y, ramp.gaze_px()));
    }
}

/// Rows above and below the gaze, where v wraps (right) and where it does not (left).
fn seams(ramp: &Ramp, finding: &mut Finding) {
    let (gaze, width) = (ramp.gaze_px().as_uvec2(), ramp.frame.size[0]);
    let step_px = |x: u32| {
        let step = ramp.error_px(x, gaze.y)? - ramp.error_px(x, gaze.y - 1)?;
        Some(step.y.abs())
    };
    let reach = (width - gaze.x).min(gaze.x);
    let worst = |columns: &mut dyn Iterator<Item = u32>| columns.filter_map(step_px).fold(0.0, f64::max);
    let right = worst(&mut (4..reach).map(|distance| gaze.x + distance));
    let left = worst(&mut (4..reach).map(|distance| gaze.x - 1 - distance));
    finding.error((right - left).max(0.0), || format!("gaze {gaze}: {right} px right, {left} px left"));
}

/// Means over rings of 2 px, along the radius.
fn rings(ramp: &Ramp, finding: &mut Finding) {
    let gaze_px = ramp.gaze_px();
    let border_px = gaze_px.min(ramp.size_px() - gaze_px).min_element();
    let mut sums = vec![(0.0, 0.0); (0.7 * border_px / 2.0) as usize];
    for (px, error_px) in ramp.errors() {
        let offset = px - gaze_px;
        if let Some((sum, pixels)) = sums.get_mut((offset.length() / 2.0) as usize) {
            *sum += error_px.dot(offset.normalize());
            *pixels += 1.0;
        }
    }
    let means: Vec<f64> = sums.iter().map(|(sum, pixels): &(f64, f64)| sum / pixels.max(1.0)).collect();
    for (ring, pair) in means.windows(2).enumerate().skip(1) {
        let step_px = (pair[1] - pair[0]).abs();
        finding.error(step_px, || format!("gaze {gaze_px}: {} px from it", 2 * (ring + 1)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use macula::fovea::{Kernel, KfrColumns};

    /// A picture in which each pixel holds its own place, moved.
    fn planted(moved_px: impl Fn(DVec2) -> DVec2) -> Finding {
        let display = DisplayGeometry::symmetric([64, 48], 90.0);
        let mapping = KfrColumns::new(display, DVec2::new(32.0, 24.0), Kernel::Power { alpha: 1.0 }, 1.0);
        let size_px = DVec2::new(64.0, 48.0);
        let pixels = (0..48 * 64).flat_map(|index: u32| {
            let px = DVec2::new(f64::from(index % 64), f64::from(index / 64)) + 0.5;
            let [red, green] = ((px + moved_px(px)) / size_px).to_array();
            [red as f32, green as f32, 0.0, 1.0]
        });
        let frame = Frame { size: [64, 48], stats: Default::default(), hdr: pixels.collect() };
        let ramp = Ramp { frame: &frame, mapping: &mapping, layout: Layout::Polar };
        let mut finding = Finding::default();
        for check in [ramps, seams, rings] {
            let mut own = Finding::default();
            check(&ramp, &mut own);
            finding.error(own.worst, || own.at);
        }
        finding
    }

    #[test]
    fn an_exact_ramp_has_no_error() {
        assert!(planted(|_| DVec2::ZERO).worst < 1e-4);
    }

    #[test]
    fn a_planted_shift_seam_and_step_are_found() {
        let shift =
            planted(|px| if px == DVec2::new(50.5, 40.5) { DVec2::new(0.0, -3.0) } else { DVec2::ZERO });
        assert!((shift.worst - 3.0).abs() < 0.3 && shift.at.contains("50.5, 40.5"), "{shift:?}");
        let seam = planted(|px| if px.y == 24.5 && px.x > 32.0 { DVec2::new(0.0, 0.8) } else { DVec2::ZERO });
        assert!(seam.worst > 0.6, "{seam:?}");
        let centre = DVec2::new(32.0, 24.0);
        let step = planted(|px| {
            let outward = px - centre;
            if outward.length() > 10.0 { outward.normalize() } else { DVec2::ZERO }
        });
        assert!((step.worst - 1.0).abs() < 0.3, "{step:?}");
    }
}
