//! From the LP-buffer to the display: ramps stay ramps, without a seam at the azimuth 0 and without a step
//! where native pixels end.
//!
//! All of it on a picture that rises evenly in x and in y, so that a value says where it was taken: errors are
//! distances in pixels.

use super::super::bench::Bench;
use super::super::family::{Case, Family, Finding, Part, Place};
use super::super::subject::{Layout, Subject, methods};
use super::scenes::ramp;
use super::stage::{Frame, frame, looking_ahead, renderer, upload};
use crate::failure::Failure;
use glam::DVec2;
use macula::fovea::{DisplayGeometry, Mapping, TexelJacobian};

/// The allowance of a pixel (see `allowance_px`) is all that it may be off.
const RAMP: f64 = 1.0;

/// How much more the steps across the seam may differ from the ramp's than those on the other side of the
/// gaze, px. The samples of both sides lie at other places within their pixels: half a pixel each.
const SEAM_PX: f64 = 1.0;

/// How far the mean position may change from one ring about the gaze to the next, px. Chords and filters pull
/// towards the gaze by up to an eighth of a texel, which grows slowly; a ring of 2 px has at least 30 pixels
/// of which each is off by half a pixel at most: 0.1 px in the mean.
const RING_PX: f64 = 0.35;

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
        family("ramp", "a linear ramp comes back as a ramp", RAMP, "of the allowance", || {
            cases(|_| true, 3, &["kfr", "vafr"], ramps)
        }),
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
}

impl Ramp<'_> {
    fn size_px(&self) -> DVec2 {
        DVec2::from_array(self.frame.size.map(f64::from))
    }

    fn gaze_px(&self) -> DVec2 {
        self.mapping.gaze_px()
    }

    /// Where the value of a pixel was taken, from its centre, px.
    fn moved_px(&self, x: u32, y: u32) -> DVec2 {
        let [red, green, _] = self.frame.at(x, y);
        DVec2::new(red, green) * self.size_px() - centre(x, y)
    }

    /// Pixels and how far their values were moved.
    fn pixels(&self) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
        let [width, height] = self.frame.size;
        (0..height).flat_map(move |y| (0..width).map(move |x| (centre(x, y), self.moved_px(x, y))))
    }

    /// What sampling and storing may cost, px. A sample is the pixel that holds the texel's centre: half a
    /// pixel off on each axis; the G-buffer's emission has 9 bits, the picture 11. A chord cuts its arc, and
    /// a filter reaches to the neighbours: a fraction of a texel, a whole one close to the display's border,
    /// where texels beyond it take the border's pixel.
    fn allowance_px(&self, px: DVec2) -> DVec2 {
        let stored = self.size_px() * (1.0 / 1024.0 + 1.0 / 4096.0);
        let texel = self.mapping.jacobian(px).map_or(DVec2::ZERO, |jacobian| texel_box_px(&jacobian));
        let to_border = px.min(self.size_px() - px);
        let share = |axis: usize| if to_border[axis] < 2.0 * texel.max_element() { 1.0 } else { 0.25 };
        DVec2::splat(0.5) + stored + texel.max_element() * DVec2::new(share(0), share(1))
    }
}

fn centre(x: u32, y: u32) -> DVec2 {
    DVec2::new(f64::from(x), f64::from(y)) + 0.5
}

/// Width and height of the box around a texel, px, at most the largest display's: from the inverse of the
/// Jacobian.
fn texel_box_px(jacobian: &TexelJacobian) -> DVec2 {
    let determinant = jacobian.density_per_px2();
    let along_x = jacobian.dv_dy.abs() + jacobian.du_dy.abs();
    let along_y = jacobian.dv_dx.abs() + jacobian.du_dx.abs();
    let whole = DVec2::new(along_x, along_y) / determinant;
    if whole.is_finite() { whole.min(DVec2::splat(11520.0)) } else { DVec2::splat(11520.0) }
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
    for subject in methods().into_iter().filter(wanted) {
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

fn run(
    bench: &Bench,
    subject: &Subject,
    display: &DisplayGeometry,
    check: Check,
) -> Result<Finding, Failure> {
    let mut finding = Finding::default();
    let content = upload(bench, &ramp(display), None)?;
    let mut renderer = renderer(bench, &content, display, &subject.method)?;
    let size = DVec2::from_array(display.size_px.map(f64::from));
    for share in [DVec2::new(0.5, 0.5), DVec2::new(0.25, 0.7)] {
        // On a corner of four pixels, so that rows lie evenly on both sides of the seam.
        let gaze_px = (share * size).round();
        let frame = frame(&mut renderer, display.size_px, &looking_ahead(gaze_px))?;
        frame.must_be_whole(&mut finding, "the ramp");
        let mapping = subject.mapping(display, gaze_px)?;
        check(&Ramp { frame: &frame, mapping: &*mapping }, &mut finding);
    }
    Ok(finding)
}

fn ramps(ramp: &Ramp, finding: &mut Finding) {
    for (px, moved_px) in ramp.pixels() {
        let share = moved_px.abs() / ramp.allowance_px(px);
        finding.error(share.max_element(), || format!("px {}, {} is moved by {moved_px}", px.x, px.y));
    }
}

/// Rows above and below the gaze, where v wraps (right) and where it does not (left).
fn seams(ramp: &Ramp, finding: &mut Finding) {
    let (gaze, width) = (ramp.gaze_px().as_uvec2(), ramp.frame.size[0]);
    let step_px = |x: u32| (ramp.moved_px(x, gaze.y) - ramp.moved_px(x, gaze.y - 1)).y.abs();
    let reach = (width - gaze.x).min(gaze.x);
    let worst = |columns: &mut dyn Iterator<Item = u32>| columns.map(step_px).fold(0.0, f64::max);
    let right = worst(&mut (4..reach).map(|distance| gaze.x + distance));
    let left = worst(&mut (4..reach).map(|distance| gaze.x - 1 - distance));
    finding.error((right - left).max(0.0), || format!("gaze {gaze}: {right} px right, {left} px left"));
}

/// Means over rings of 2 px, along the radius.
fn rings(ramp: &Ramp, finding: &mut Finding) {
    let gaze_px = ramp.gaze_px();
    let border_px = gaze_px.min(ramp.size_px() - gaze_px).min_element();
    // From here outwards, up to where texels of the border would be met.
    let count = (0.7 * border_px / 2.0) as usize;
    let mut sums = vec![(0.0, 0.0); count];
    for (px, moved_px) in ramp.pixels() {
        let offset = px - gaze_px;
        let ring = (offset.length() / 2.0) as usize;
        if let Some((sum, pixels)) = sums.get_mut(ring) {
            *sum += moved_px.dot(offset.normalize());
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

    #[test]
    fn the_box_holds_the_texel() {
        // Texels of 4 px along x and 0.5 px along y.
        let straight = TexelJacobian { du_dx: 0.25, du_dy: 0.0, dv_dx: 0.0, dv_dy: 2.0 };
        assert_eq!(texel_box_px(&straight), DVec2::new(4.0, 0.5));
        // Squares of 1 px, turned by 45 degrees.
        let turned = TexelJacobian {
            du_dx: 0.5_f64.sqrt(),
            du_dy: 0.5_f64.sqrt(),
            dv_dx: -0.5_f64.sqrt(),
            dv_dy: 0.5_f64.sqrt(),
        };
        assert!(texel_box_px(&turned).abs_diff_eq(DVec2::splat(2.0_f64.sqrt()), 1e-12));
        let flat = TexelJacobian { du_dx: 0.0, du_dy: 0.0, dv_dx: 0.0, dv_dy: 1.0 };
        assert_eq!(texel_box_px(&flat), DVec2::splat(11520.0));
    }
}
