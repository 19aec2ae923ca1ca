//! The minimum angle of resolution (MAR) over eccentricity as a chain of polynomials, and the
//! integrals over it.

use super::MOST_DEG;
use super::quadrature::gauss;

/// An interval on which MAR is one polynomial.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    start_deg: f64,
    end_deg: f64,
    /// MAR in degrees per cycle as a polynomial of the step from the start, degrees; no falling
    /// one, and above 0 on the whole interval.
    mar: [f64; 4],
    /// Columns from the gaze to the start.
    columns: f64,
}

impl Piece {
    fn new(start_deg: f64, end_deg: f64, mar: [f64; 4]) -> Self {
        Self { start_deg, end_deg, mar, columns: 0.0 }
    }

    fn length_deg(&self) -> f64 {
        self.end_deg - self.start_deg
    }

    fn mar_at(&self, step_deg: f64) -> f64 {
        let [c0, c1, c2, c3] = self.mar;
        c0 + step_deg * (c1 + step_deg * (c2 + step_deg * c3))
    }

    fn is_linear(&self) -> bool {
        self.mar[2] == 0.0 && self.mar[3] == 0.0
    }

    /// The same polynomial from a later start.
    fn shifted(&self, step_deg: f64) -> Self {
        let [_, c1, c2, c3] = self.mar;
        let mar = [
            self.mar_at(step_deg),
            c1 + step_deg * (2.0 * c2 + 3.0 * step_deg * c3),
            c2 + 3.0 * step_deg * c3,
            c3,
        ];
        Self::new(self.start_deg + step_deg, self.end_deg, mar)
    }

    /// Whether one Gauss-Legendre rule over these steps is exact to rounding for `1/MAR^2` times a
    /// sine.
    ///
    /// By Taylor's bound about the middle, MAR has no zero within twice the half width, so that the
    /// integrand is analytic in the ellipse with that half axis, and the error of the 16 nodes falls
    /// below `1e-15` ((2 + sqrt 3)^-32 times the integrand's growth there).
    fn is_smooth(&self, from_deg: f64, to_deg: f64) -> bool {
        /// A sine of twice the angle must not grow much on the ellipse.
        const WIDEST_DEG: f64 = 30.0;
        let middle = self.shifted(0.5 * (from_deg + to_deg)).mar;
        let radius = to_deg - from_deg;
        let change = radius * (middle[1].abs() + radius * (middle[2].abs() + radius * middle[3].abs()));
        radius <= WIDEST_DEG && change <= 0.9 * middle[0]
    }

    /// Columns between the start and a step: the integral of `2/MAR`.
    fn columns_within(&self, step_deg: f64) -> f64 {
        if self.is_linear() {
            let growth = self.mar[1] * step_deg / self.mar[0];
            // ln(1 + x)/x, which is 1 where MAR is flat.
            let factor = if growth == 0.0 { 1.0 } else { growth.ln_1p() / growth };
            return 2.0 * step_deg / self.mar[0] * factor;
        }
        gauss(0.0, step_deg, |step| 2.0 / self.mar_at(step))
    }

    /// The inverse of [`Self::columns_within`].
    fn step_of_columns(&self, columns: f64) -> f64 {
        if self.is_linear() {
            let exponent = self.mar[1] * columns / 2.0;
            let factor = if exponent == 0.0 { 1.0 } else { exponent.exp_m1() / exponent };
            return (self.mar[0] * columns / 2.0 * factor).clamp(0.0, self.length_deg());
        }
        let (mut low, mut high) = (0.0, self.length_deg());
        let mut step = (self.mar[0] * columns / 2.0).min(high);
        // Newton's steps double the digits; a bisection stands in where one would leave the
        // bracket, so that 64 rounds reach the last digit in any case.
        for _ in 0..64 {
            let excess = self.columns_within(step) - columns;
            if excess > 0.0 {
                high = step
            } else {
                low = step
            }
            let newton = step - excess * self.mar_at(step) / 2.0;
            let next = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
            if (next - step).abs() <= f64::EPSILON * step {
                return next;
            }
            step = next;
        }
        step
    }
}

/// MAR from 0 to [`MOST_DEG`] degrees: never empty, without gaps, never falling.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Curve(Vec<Piece>);

impl Curve {
    /// Straight lines through pivots of (degrees, degrees per cycle); the last one goes on.
    pub(super) fn linear(pivots: &[[f64; 2]]) -> Self {
        let slopes = secants(pivots);
        let mut pieces = Vec::with_capacity(pivots.len());
        for (at, &[start_deg, mar]) in pivots.iter().enumerate() {
            let end_deg = pivots.get(at + 1).map_or(MOST_DEG, |pivot| pivot[0]);
            let slope = slopes.get(at).or(slopes.last()).copied().unwrap_or(0.0);
            pieces.push(Piece::new(start_deg, end_deg, [mar, slope, 0.0, 0.0]));
        }
        Self(pieces)
    }

    /// A monotone cubic through the pivots (Fritsch and Carlson 1980; slopes of Fritsch and Butland
    /// 1984), which leaves the last pivot with the last secant's slope and goes on with it: there it
    /// is the line of [`Self::linear`].
    pub(super) fn smooth(pivots: &[[f64; 2]]) -> Self {
        let secants = secants(pivots);
        let slopes = tangents(pivots, &secants);
        let mut pieces = Vec::new();
        for (at, pair) in pivots.windows(2).enumerate() {
            let (start, end) = (pair[0], pair[1]);
            let length = end[0] - start[0];
            let (secant, first, last) = (secants[at], slopes[at], slopes[at + 1]);
            let square = (3.0 * secant - 2.0 * first - last) / length;
            let cube = (first + last - 2.0 * secant) / (length * length);
            pieces.push(Piece::new(start[0], end[0], [start[1], first, square, cube]));
        }
        if let (Some(last), Some(&slope)) = (pivots.last(), slopes.last()) {
            pieces.push(Piece::new(last[0], MOST_DEG, [last[1], slope, 0.0, 0.0]));
        }
        Self(pieces)
    }

    /// Never below a MAR, which is that of the display, and ready for the integrals: cubics cut where one
    /// quadrature rule no longer reaches, columns counted.
    pub(super) fn finished(self, least_mar_deg: f64) -> Self {
        let mut pieces = self.at_least(least_mar_deg);
        pieces.retain(|piece| piece.length_deg() > 0.0);
        let mut cut = Vec::with_capacity(pieces.len());
        pieces.reverse();
        while let Some(piece) = pieces.pop() {
            let middle = 0.5 * piece.length_deg();
            if piece.is_linear() || piece.is_smooth(0.0, piece.length_deg()) {
                cut.push(piece);
            } else {
                pieces.push(piece.shifted(middle));
                pieces.push(Piece { end_deg: piece.start_deg + middle, ..piece });
            }
        }
        let mut columns = 0.0;
        for piece in &mut cut {
            piece.columns = columns;
            columns += piece.columns_within(piece.length_deg());
        }
        Self(cut)
    }

    fn at_least(self, least_mar_deg: f64) -> Vec<Piece> {
        let flat_to = |end_deg| Piece::new(0.0, end_deg, [least_mar_deg, 0.0, 0.0, 0.0]);
        let below = |piece: &Piece| piece.mar_at(piece.length_deg()) <= least_mar_deg;
        let kept = self.0.iter().position(|piece| !below(piece));
        let Some(kept) = kept else { return vec![flat_to(MOST_DEG)] };
        let first = self.0[kept];
        if kept == 0 && first.mar[0] >= least_mar_deg {
            return self.0;
        }
        let mut rest = first.shifted(crossing(&first, least_mar_deg));
        rest.mar[0] = rest.mar[0].max(least_mar_deg);
        let mut pieces = vec![flat_to(rest.start_deg), rest];
        pieces.extend_from_slice(&self.0[kept + 1..]);
        pieces
    }

    fn piece_of_deg(&self, ecc_deg: f64) -> &Piece {
        let after = self.0.partition_point(|piece| piece.start_deg <= ecc_deg);
        &self.0[after.saturating_sub(1)]
    }

    /// MAR, degrees per cycle, at 0 to [`MOST_DEG`] degrees.
    pub(super) fn mar_deg(&self, ecc_deg: f64) -> f64 {
        let piece = self.piece_of_deg(ecc_deg);
        piece.mar_at(ecc_deg - piece.start_deg)
    }

    /// Columns between the gaze and 0 to [`MOST_DEG`] degrees.
    pub(super) fn columns_to(&self, ecc_deg: f64) -> f64 {
        let piece = self.piece_of_deg(ecc_deg);
        piece.columns + piece.columns_within(ecc_deg - piece.start_deg)
    }

    /// The inverse of [`Self::columns_to`], for a number of columns that is not negative.
    pub(super) fn eccentricity_deg(&self, columns: f64) -> f64 {
        let after = self.0.partition_point(|piece| piece.columns <= columns);
        let piece = &self.0[after.saturating_sub(1)];
        piece.start_deg + piece.step_of_columns(columns - piece.columns)
    }

    /// The integral of a smooth function of (eccentricity in degrees, MAR) between two eccentricities.
    pub(super) fn integral(&self, from_deg: f64, to_deg: f64, f: impl Fn(f64, f64) -> f64) -> f64 {
        let mut sum = 0.0;
        for piece in &self.0 {
            let (from, to) = (from_deg.max(piece.start_deg), to_deg.min(piece.end_deg));
            let mut parts = vec![(from - piece.start_deg, to - piece.start_deg)];
            while let Some((from, to)) = parts.pop() {
                if from >= to {
                    continue;
                }
                if piece.is_smooth(from, to) {
                    sum += gauss(from, to, |step| f(piece.start_deg + step, piece.mar_at(step)));
                } else {
                    let middle = 0.5 * (from + to);
                    parts.extend([(middle, to), (from, middle)]);
                }
            }
        }
        sum
    }
}

/// Slopes of the lines between neighbouring points.
fn secants(points: &[[f64; 2]]) -> Vec<f64> {
    points.windows(2).map(|pair| (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0])).collect()
}

/// Slopes of the monotone cubic at its points; `secants` are not negative.
fn tangents(points: &[[f64; 2]], secants: &[f64]) -> Vec<f64> {
    let (Some(&first), Some(&last)) = (secants.first(), secants.last()) else {
        return vec![0.0; points.len()];
    };
    let length = |at: usize| points[at + 1][0] - points[at][0];
    // At the gaze the parabola through the first three points, held to what keeps the cubic rising.
    let start = secants.get(1).map_or(first, |second| {
        ((2.0 * length(0) + length(1)) * first - length(0) * second) / (length(0) + length(1))
    });
    let mut slopes = vec![start.clamp(0.0, 3.0 * first)];
    for (at, pair) in secants.windows(2).enumerate() {
        let (before, after) = (length(at), length(at + 1));
        let weights = [2.0 * after + before, after + 2.0 * before];
        // A secant of 0 gives a slope of 0: the harmonic mean's limit.
        slopes.push((weights[0] + weights[1]) / (weights[0] / pair[0] + weights[1] / pair[1]));
    }
    slopes.push(last);
    slopes
}

/// The step at which a piece that begins below a MAR and ends above it has that MAR.
fn crossing(piece: &Piece, mar_deg: f64) -> f64 {
    let (mut low, mut high) = (0.0, piece.length_deg());
    if piece.mar[0] >= mar_deg {
        return low;
    }
    if piece.is_linear() {
        return ((mar_deg - piece.mar[0]) / piece.mar[1]).clamp(low, high);
    }
    // 64 halvings of at most 180 degrees end below a double's resolution.
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        if piece.mar_at(middle) < mar_deg { low = middle } else { high = middle }
    }
    high
}
