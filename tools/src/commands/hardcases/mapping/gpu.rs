//! The mapping on the GPU, in single precision, against the CPU's in double precision.

use super::super::bench::Bench;
use super::super::family::{Case, Family, Finding, Part, Place};
use super::super::random::Random;
use super::super::subject::{Gaze, Layout, Screen, Subject, gazes, methods, on_display, screens};
use super::at_px;
use super::points::{extent_at_px, pixel_centres};
use crate::failure::Failure;
use glam::DVec2;
use macula::fovea::{LpPoint, MAX_GAZE_PX, Mapping};
use macula::headless::{GpuMapping, HeadlessDevice, map_points_on_gpu};
use macula::settings::{Method, RenderSettings};

/// Pixels, texels where those are larger. KFR's fast function is off by 2e-3 texels at
/// 7680x4320 and in proportion to the LP-buffer's size, the tables of the others by 3e-4 columns; azimuths
/// are good to 1e-7 of a turn, of up to 6480 texels; display positions beyond 8192 px lie 1e-3 px apart.
/// Interpolating, two hundredths of a texel would move the picture by two hundredths of its finest detail.
const TWINS: f64 = 5e-3;

/// What is asked for up to 11520x6480 wherever the LP-buffer has at least a sample per pixel, px.
const ROUND_TRIP_PX: f64 = 1e-3;

/// The tables end here: only from one edge of a frustum of nearly half a turn to a gaze off its other edge is
/// it farther, 178 degrees.
const MOST_RAD: f64 = 3.1;

/// What the function with pairs of floats promises, px.
const PAIRS_PX: f64 = 1e-4;

pub fn families() -> Vec<Family> {
    let family = |name, what, bound, unit, cases| Family {
        name,
        what,
        part: Part::Mapping,
        place: Place::Gpu,
        bound,
        unit,
        cases,
    };
    vec![
        family(
            "gpu-twin",
            "the GPU maps pixels to the LP-buffer, and texels to the display, as the CPU does",
            TWINS,
            "px, texels where larger",
            || cases(|_| true, twin),
        ),
        family(
            "gpu-round-trip",
            "forward and back on the GPU leads to the same place where there is a sample per pixel",
            ROUND_TRIP_PX,
            "px",
            || cases(|_| true, round_trip),
        ),
        family(
            "gpu-pairs",
            "KFR's mapping in pairs of floats keeps what single precision loses",
            PAIRS_PX,
            "px, texels where larger",
            || cases(|subject| subject.quick && matches!(subject.method, Method::Kfr(_)), pairs),
        ),
    ]
}

/// Displays that are mapped on the GPU; the first ones with every method's hardest parameters too. The others
/// of the catalogue differ from these in ways that only the CPU's double precision would show.
const SCREENS: [&str; 10] = [
    "11520x6480",
    "1280x720",
    "asymmetric",
    "1x1",
    "13x17",
    "101x103",
    "3840x2160",
    "11520x16",
    "wide-178deg",
    "anisotropic",
];

/// How many of those.
const WITH_ALL_PARAMETERS: usize = 3;

/// A method on a display with one of its gazes, on both sides.
struct Twins<'a> {
    mapping: &'a dyn Mapping,
    gpu: &'a mut GpuMapping,
    device: &'a HeadlessDevice,
    subject: &'a Subject,
    gaze: Gaze,
    /// Pixel centres.
    points: Vec<DVec2>,
}

impl Twins<'_> {
    /// LP points of the pixels; `None` for those that are shaded themselves and never looked up.
    fn forward(&mut self) -> Result<Vec<Option<LpPoint>>, Failure> {
        let mapped = self.gpu.forward(self.gaze.px, &self.points)?;
        Ok(mapped.into_iter().map(|of| (of.past_native > 0.0).then_some(of.point)).collect())
    }

    fn at(&self, px: DVec2) -> String {
        format!("{} (gaze {})", at_px(px), self.gaze.name)
    }

    /// Whether the mapping bends more within the pixel's texel than the parabola through the texel's edges
    /// and centre follows, by which the GPU places points inside texels. Only kinks do (the gaze by axes,
    /// the edge of a fovea) and LP-buffers of a few rows; samples lie at centres.
    fn is_bent(&self, px: DVec2) -> bool {
        let Some(point) = self.mapping.forward(px) else { return false };
        let rows = self.mapping.column_height(point.u);
        let column = |u: f64| self.mapping.inverse(LpPoint { u, ..point });
        let row = |v: f64| self.mapping.inverse(LpPoint { v_share: v / rows, ..point });
        let polar = self.subject.layout() == Layout::Polar;
        let off_px = off_parabola_px(point.u, column).max(if polar {
            0.0
        } else {
            off_parabola_px(point.v_share * rows, row)
        });
        off_px > ROUND_TRIP_PX / 5.0
    }
}

/// How far the place at a texel coordinate is from the parabola through those at the texel's edges and
/// centre, px.
fn off_parabola_px(coordinate: f64, place: impl Fn(f64) -> Option<DVec2>) -> f64 {
    // An edge may belong to the next layer.
    const INSET: f64 = 1e-9;
    let first = coordinate.floor();
    let places = [first + INSET, first + 0.5, first + 1.0 - INSET, coordinate].map(place);
    let [Some(low), Some(centre), Some(high), Some(there)] = places else { return 0.0 };
    let offset = coordinate - first - 0.5;
    let parabola = centre + offset * ((high - low) + offset * 2.0 * (high - 2.0 * centre + low));
    parabola.distance(there)
}

type Check = fn(&mut Twins, &mut Finding) -> Result<(), Failure>;

fn cases(wanted: fn(&Subject) -> bool, check: Check) -> Vec<Case> {
    let mut cases = Vec::new();
    for subject in methods().into_iter().filter(wanted) {
        let names = if subject.quick { &SCREENS[..] } else { &SCREENS[..WITH_ALL_PARAMETERS] };
        let known = |screen: &Screen| names.contains(&screen.name) && !is_left_out(&subject, screen);
        for screen in screens().into_iter().filter(known) {
            let id = format!("{}/{}", subject.name, screen.name);
            let quick = subject.quick && screen.name == SCREENS[0];
            let subject = subject.clone();
            cases.push(Case::new(id, quick, move |bench| run(bench, &subject, &screen, check)));
        }
    }
    cases
}

/// LaFR's table is over the angle from the gaze, on which its kernel does not depend.
pub const LEFT_OUT: (&str, &str) = (
    "LaFR on the GPU in a frustum of nearly half a turn",
    "single precision hardly tells its positions apart by their angles, next to 90 degrees",
);

fn is_left_out(subject: &Subject, screen: &Screen) -> bool {
    matches!(subject.method, Method::Lafr(_)) && screen.name == "wide-178deg"
}

/// Gazes that are not moved before they are used; the others are covered by those they are moved to.
fn plain_gazes(screen: &Screen) -> Vec<Gaze> {
    let all = gazes(&screen.display).into_iter();
    all.filter(|gaze| gaze.px.is_finite() && gaze.px.abs().max_element() < MAX_GAZE_PX / 2.0).collect()
}

fn run(bench: &Bench, subject: &Subject, screen: &Screen, check: Check) -> Result<Finding, Failure> {
    let mut finding = Finding::default();
    let device = bench.device()?;
    let settings = RenderSettings::new(screen.display, subject.method.clone());
    let mut gpu = GpuMapping::new(device, &settings)?;
    for gaze in plain_gazes(screen) {
        let mapping = subject.mapping(&screen.display, gaze.px)?;
        let mut points = pixel_centres(&screen.display, mapping.gaze_px(), &mut Random::of(gaze.name));
        points.retain(|px| screen.display.eccentricity_rad(gaze.px, *px) < MOST_RAD);
        let mut twins = Twins { mapping: &*mapping, gpu: &mut gpu, device, subject, gaze, points };
        check(&mut twins, &mut finding)?;
    }
    Ok(finding)
}

fn twin(twins: &mut Twins, finding: &mut Finding) -> Result<(), Failure> {
    forward(twins, finding)?;
    inverse(twins, finding)
}

/// Compared on the display, where both lead back to: texels may be far smaller than pixels, and right on a
/// layer's border either layer is right.
fn forward(twins: &mut Twins, finding: &mut Finding) -> Result<(), Failure> {
    for (index, found) in twins.forward()?.into_iter().enumerate() {
        let px = twins.points[index];
        let Some((found, extent_px)) = found.zip(extent_at_px(twins.mapping, px)) else { continue };
        let back = twins.mapping.inverse(found).map_or(f64::INFINITY, |back| back.distance(px));
        finding.error(back / extent_px.max(1.0), || twins.at(px));
    }
    Ok(())
}

/// Centres of the texels that hold the pixels.
fn inverse(twins: &mut Twins, finding: &mut Finding) -> Result<(), Failure> {
    let heights = twins.mapping.columns().heights();
    let centre = |px: &DVec2| {
        let point = twins.mapping.forward(*px)?;
        let column = (point.u as usize).min(heights.len() - 1);
        let rows = f64::from(heights[column]);
        let v_share = ((point.v_share * rows).floor().min(rows - 1.0) + 0.5) / rows;
        Some(LpPoint { u: column as f64 + 0.5, v_share })
    };
    let texels: Vec<_> = twins.points.iter().filter_map(centre).collect();
    let mapped = twins.gpu.inverse(twins.gaze.px, &texels)?;
    for (texel, found) in texels.iter().zip(mapped) {
        let Some(expected) = twins.mapping.inverse(*texel) else { continue };
        let Some(extent_px) = extent_at_px(twins.mapping, expected) else { continue };
        // Off the display there is nothing to fetch.
        if on_display(twins.mapping.display(), expected) {
            finding.error(found.distance(expected) / extent_px.max(1.0), || {
                format!("texel {}, share {} (gaze {})", texel.u, texel.v_share, twins.gaze.name)
            });
        }
    }
    Ok(())
}

fn round_trip(twins: &mut Twins, finding: &mut Finding) -> Result<(), Failure> {
    let fine = |px: DVec2| extent_at_px(twins.mapping, px).is_some_and(|extent_px| extent_px <= 1.0);
    let points = twins.points.iter().copied().filter(|px| fine(*px) && !twins.is_bent(*px)).collect();
    twins.points = points;
    let mapped = twins.forward()?;
    let (mut starts, mut points) = (Vec::new(), Vec::new());
    for (px, point) in twins.points.iter().zip(mapped) {
        if let Some(point) = point {
            starts.push(*px);
            points.push(point);
        }
    }
    let back = twins.gpu.inverse(twins.gaze.px, &points)?;
    for (px, back) in starts.into_iter().zip(back) {
        finding.error(back.distance(px), || twins.at(px));
    }
    Ok(())
}

fn pairs(twins: &mut Twins, finding: &mut Finding) -> Result<(), Failure> {
    let Method::Kfr(kfr) = &twins.subject.method else { return Ok(()) };
    // Each gaze makes a pipeline of its own.
    if !["centre", "corner", "1e6px-off"].contains(&twins.gaze.name) {
        return Ok(());
    }
    let display = twins.mapping.display();
    let mapped = map_points_on_gpu(twins.device, display, twins.gaze.px, &kfr.kernel, &twins.points)?;
    let columns = twins.mapping.columns().heights().len() as f64;
    for (&px, found) in twins.points.iter().zip(mapped) {
        let point = LpPoint { u: found.u_norm * columns, v_share: found.v_norm };
        let Some(extent_px) = extent_at_px(twins.mapping, px) else { continue };
        let back = twins.mapping.inverse(point).map_or(f64::INFINITY, |back| back.distance(px));
        finding.error(back / extent_px.max(1.0), || twins.at(px));
    }
    Ok(())
}
