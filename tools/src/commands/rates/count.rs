//! Shading rates by counting: which texel does each of many close points fall into? Nothing here knows
//! the mapping's derivatives, so that the result checks them, and the forward mapping may be the GPU's.

use super::edges::Edges;
use super::sphere::Surroundings;
use super::summary::{DIRECTIONS, Direction, Sample, Summary};
use super::target::{Limits, Target};
use crate::failure::Failure;
use glam::DVec2;
use macula::fovea::{LpPoint, Mapping};

/// Maps display positions, px, to the LP-buffer, one result for each.
pub type Forward<'a> = dyn FnMut(&[DVec2]) -> Result<Vec<Option<LpPoint>>, Failure> + 'a;

/// Points along a line. Where a texel ends is known to one part in as many of the line's length.
const POINTS: usize = 1024;

/// Length of a line at first, degrees.
const FIRST_LENGTH_DEG: f64 = 0.25;

/// A line is made longer until it crosses as many texels: more make a rate more precise where the line runs
/// nearly along the texels, fewer leave less of the curve between the line's ends.
const ENOUGH_EDGES: usize = 16;

/// With fewer edges nothing is said of a rate, unless the line crosses edges of both kinds. It may cross two
/// texels the other way without telling: with as many edges that is 1.4 % of the rate at most (half of the
/// square of 2 over this).
const LEAST_EDGES: usize = 12;

/// Of a line that crosses edges of both kinds.
const LEAST_EDGES_OBLIQUE: usize = 3;

/// Lines grow no longer, degrees: 2 cycles per degree make [`ENOUGH_EDGES`] in half of it.
const MOST_LENGTH_DEG: f64 = 8.0;

/// The most by which an arc turns where it does not run along texels, rad: its length is then read off as
/// if it were straight, which makes a rate at most 0.4 % too low (1 minus the sine of half of it over that).
const MOST_TURN_RAD: f64 = 0.3;

/// Neighbouring points lie a fraction of a texel apart. Where they are more texels apart, one part of the
/// LP-buffer ends and another begins, as between layers.
const MOST_STEP: i64 = 4;

/// Azimuths of the lines, degrees apart, beginning with half of it: off the axes and the diagonals, where
/// rectangular methods have kinks that no line may straddle.
const AZIMUTH_STEP_DEG: f64 = 22.5;

/// Lines that are mapped at a time: bounds the memory that they take (100 MiB). Smaller calls the forward
/// mapping more often, which builds pipelines each time on the GPU.
const BATCH: usize = 1024;

/// Rates at eccentricities in degrees, as far as they lie on the display.
///
/// A rate is that over a line about its place, from the first to the last edge between two texels on it;
/// its target is the mean over the same part. Each edge is known to the distance of two points, which makes
/// a rate wrong by at most two parts in [`POINTS`] of the line's share between these edges.
///
/// # Errors
/// What `forward` reports.
pub fn rates(
    mapping: &dyn Mapping,
    target: &Target<'_>,
    eccs_deg: &[f64],
    forward: &mut Forward<'_>,
) -> Result<Summary, Failure> {
    let around = Surroundings::new(*mapping.display(), mapping.gaze_px());
    let counter = Counter { mapping, target, around };
    let turns = (360.0 / AZIMUTH_STEP_DEG) as u32;
    let azimuths_deg = (0..turns).map(|turn| (f64::from(turn) + 0.5) * AZIMUTH_STEP_DEG);
    let places =
        eccs_deg.iter().flat_map(|ecc_deg| azimuths_deg.clone().map(|azimuth_deg| (*ecc_deg, azimuth_deg)));
    let mut open: Vec<Line> = places.flat_map(|place| counter.lines(place)).collect();
    let mut samples = vec![];
    while !open.is_empty() {
        let mut longer = vec![];
        for lines in open.chunks(BATCH) {
            for (line, count) in lines.iter().zip(counter.count(lines, forward)?) {
                match line.longer(&count) {
                    Some(line) => longer.push(line),
                    None => samples.extend(counter.sample(line, &count)),
                }
            }
        }
        open = longer;
    }
    Ok(Summary::of(samples))
}

/// Points on the sphere in a row, half of them on each side of a place.
#[derive(Clone, Copy, Debug)]
struct Line {
    ecc_deg: f64,
    azimuth_deg: f64,
    direction: Direction,
    /// The place is a native pixel. Pixels lie in straight rows, so that the line is straight too, and not
    /// an arc about the gaze.
    is_native: bool,
    length_deg: f64,
}

impl Line {
    fn new((ecc_deg, azimuth_deg): (f64, f64), direction: Direction, is_native: bool) -> Self {
        let line = Self { ecc_deg, azimuth_deg, direction, is_native, length_deg: 0.0 };
        Self { length_deg: FIRST_LENGTH_DEG.min(line.most_length_deg(true)), ..line }
    }

    fn is_arc(&self) -> bool {
        self.direction == Direction::Tangential && !self.is_native
    }

    /// Radially from the gaze to as far behind the place; half around the gaze, or, where the arc does not
    /// run along texels, as far as it may turn.
    fn most_length_deg(&self, is_oblique: bool) -> f64 {
        let turn_deg = if is_oblique { MOST_TURN_RAD.to_degrees() } else { 180.0 };
        let room_deg = match self.direction {
            _ if self.is_native => MOST_LENGTH_DEG,
            Direction::Radial => 2.0 * self.ecc_deg,
            Direction::Tangential => turn_deg * self.ecc_deg.to_radians().sin(),
        };
        room_deg.min(MOST_LENGTH_DEG)
    }

    /// The line to count next, where this one was too short and a longer one may cross more edges.
    fn longer(&self, count: &Count) -> Option<Self> {
        /// A line with too few edges says little of how many a longer one has.
        const MOST_FACTOR: f64 = 4.0;
        let most_deg = self.most_length_deg(count.is_oblique());
        if count.is_cut || count.edges() >= ENOUGH_EDGES || self.length_deg >= most_deg {
            return None;
        }
        let wanted = (ENOUGH_EDGES + 2) as f64 / count.edges().max(1) as f64;
        let length_deg = (wanted.clamp(2.0, MOST_FACTOR) * self.length_deg).min(most_deg);
        Some(Self { length_deg, ..*self })
    }

    /// How far a point lies from the place, degrees.
    fn offset_deg(&self, point: usize) -> f64 {
        (point as f64 / POINTS as f64 - 0.5) * self.length_deg
    }

    /// Eccentricity of a point of a line that is not native, degrees.
    fn point_ecc_deg(&self, point: usize) -> f64 {
        if self.is_arc() { self.ecc_deg } else { self.ecc_deg + self.offset_deg(point) }
    }

    fn px(&self, around: &Surroundings, point: usize) -> Option<DVec2> {
        let Self { ecc_deg, azimuth_deg, .. } = *self;
        let offset_deg = self.offset_deg(point);
        match self.direction {
            Direction::Radial => around.px_at(ecc_deg + offset_deg, azimuth_deg),
            Direction::Tangential if self.is_native => around.px_across(ecc_deg, azimuth_deg, offset_deg),
            Direction::Tangential => {
                around.px_at(ecc_deg, azimuth_deg + offset_deg / ecc_deg.to_radians().sin())
            }
        }
    }
}

/// What a point falls into.
#[derive(Clone, Copy, Debug)]
enum Place {
    /// A display pixel, at this position.
    Pixel(DVec2),
    /// An LP texel.
    Texel(LpPoint),
}

impl Place {
    fn is_native(&self) -> bool {
        matches!(self, Self::Pixel(_))
    }
}

/// The edges of pixels or texels that a line crosses.
#[derive(Clone, Debug, Default)]
struct Count {
    /// The line leaves the display, the native disc or the part of the LP-buffer.
    is_cut: bool,
    /// Along the columns' order and along the columns; or the display's x and y.
    axes: [Edges; 2],
}

impl Count {
    /// The axis that is crossed more often comes first.
    fn by_edges(&self) -> [&Edges; 2] {
        let [first, second] = &self.axes;
        if first.count() >= second.count() { [first, second] } else { [second, first] }
    }

    fn edges(&self) -> usize {
        self.by_edges()[0].count()
    }

    /// The line crosses both kinds of edges. (A single one is what flickers on a line along texels.)
    fn is_oblique(&self) -> bool {
        self.by_edges()[1].count() > 1
    }
}

struct Counter<'a> {
    mapping: &'a dyn Mapping,
    target: &'a Target<'a>,
    around: Surroundings,
}

impl Counter<'_> {
    /// Both directions' lines at an eccentricity and an azimuth, degrees; none off the display.
    fn lines(&self, place: (f64, f64)) -> Vec<Line> {
        let Some(px) = self.around.px_at(place.0, place.1) else { return vec![] };
        let is_native = self.mapping.is_native(px);
        DIRECTIONS.map(|direction| Line::new(place, direction, is_native)).into()
    }

    fn count(&self, lines: &[Line], forward: &mut Forward<'_>) -> Result<Vec<Count>, Failure> {
        let along = |line: &Line| (0..POINTS).map(|point| line.px(&self.around, point)).collect::<Vec<_>>();
        let px: Vec<Option<DVec2>> = lines.iter().flat_map(along).collect();
        let on_display: Vec<DVec2> = px.iter().flatten().copied().collect();
        let mut mapped = forward(&on_display)?.into_iter();
        let places: Vec<Option<Place>> = px.iter().map(|px| self.place((*px)?, mapped.next()?)).collect();
        Ok(places.chunks(POINTS).map(|places| self.count_along(places)).collect())
    }

    fn place(&self, px: DVec2, mapped: Option<LpPoint>) -> Option<Place> {
        if self.mapping.is_native(px) { Some(Place::Pixel(px)) } else { mapped.map(Place::Texel) }
    }

    /// Counts the part of a line around its middle that is all native or all in one part of the
    /// LP-buffer, as far on both sides.
    fn count_along(&self, places: &[Option<Place>]) -> Count {
        let middle = places.len() / 2;
        let Some(Some(at_middle)) = places.get(middle).copied() else { return Count::default() };
        let height = self.height_at(at_middle);
        let index = |[along, across]: [f64; 2]| [along.floor() as i64, (across * height).floor() as i64];
        let indices: Vec<Option<[i64; 2]>> =
            unrolled(places, at_middle.is_native()).into_iter().map(|place| place.map(index)).collect();
        let connected = |point: &usize| {
            let (Some(from), Some(to)) = (indices[point - 1], indices[*point]) else { return false };
            from.iter().zip(to).all(|(from, to)| (to - from).abs() <= MOST_STEP)
        };
        let before = (1..=middle).rev().take_while(connected).count();
        let after = (middle + 1..places.len()).take_while(connected).count();
        let side = before.min(after);
        let run = || indices[middle - side..=middle + side].iter().flatten();
        let axis = |axis: usize| Edges::of(middle - side, run().map(|index| index[axis]));
        Count { is_cut: side + 1 < middle, axes: [axis(0), axis(1)] }
    }

    /// Height of the LP-buffer's columns at a place, texels, by which all texels of a line are counted:
    /// that columns differ in height shifts their texels against each other and changes no rate. Between
    /// two columns' centres it is their mean, as the picture is.
    fn height_at(&self, place: Place) -> f64 {
        let heights = self.mapping.columns().heights();
        let (Place::Texel(point), Some(last)) = (place, heights.len().checked_sub(1)) else { return 1.0 };
        let from_first = (point.u - 0.5).clamp(0.0, last as f64);
        let column = from_first as usize;
        let [here, next] = [column, (column + 1).min(last)].map(|column| f64::from(heights[column]));
        here + (next - here) * from_first.fract()
    }

    fn sample(&self, line: &Line, count: &Count) -> Option<Sample> {
        let Line { ecc_deg, azimuth_deg, direction, is_native, length_deg } = *line;
        let turns_too_far = line.is_arc() && count.is_oblique() && length_deg > line.most_length_deg(true);
        let least_edges = if count.is_oblique() { LEAST_EDGES_OBLIQUE } else { LEAST_EDGES };
        if count.edges() < least_edges || turns_too_far {
            return None;
        }
        let [main, other] = count.by_edges();
        let span = main.span()?;
        let [first, last] = span.map(|point| line.offset_deg(point));
        let texels = main.texels_between(span).hypot(other.texels_between(span));
        let cpd = texels / (last - first) / 2.0;
        let limits = self.limits(line, span)?;
        Some(Sample { ecc_deg, azimuth_deg, direction, cpd, limits, is_native })
    }

    /// Limits as means over a part of a line. Native pixels change too slowly for that to matter, while a
    /// straight line would change its direction about the gaze: of them it is the place's.
    fn limits(&self, line: &Line, [first, last]: [usize; 2]) -> Option<Limits> {
        if line.is_native {
            let px = self.around.px_at(line.ecc_deg, line.azimuth_deg)?;
            return self.target.limits(line.ecc_deg, px, line.direction);
        }
        let (mut sum, mut points) = (Limits::default(), 0.0);
        for point in first..=last {
            let px = line.px(&self.around, point)?;
            sum = sum.plus(self.target.limits(line.point_ecc_deg(point), px, line.direction)?);
            points += 1.0;
        }
        (points > 0.0).then(|| sum.over(points))
    }
}

/// Positions in a row among pixels or texels; columns are as high as 1, and a turn about the gaze goes on
/// where it passes its end. `None` off the kind that is asked for.
fn unrolled(places: &[Option<Place>], is_native: bool) -> Vec<Option<[f64; 2]>> {
    let mut last_v = None;
    let mut position = |place: Place| match place {
        Place::Pixel(px) => px.to_array(),
        Place::Texel(LpPoint { u, v_share }) => {
            let step = v_share - last_v.unwrap_or(v_share);
            let v = last_v.unwrap_or(v_share) + (step - step.round());
            last_v = Some(v);
            [u, v]
        }
    };
    let same_kind = |place: &Place| place.is_native() == is_native;
    places.iter().map(|place| place.filter(same_kind).map(&mut position)).collect()
}

#[cfg(test)]
mod tests;
