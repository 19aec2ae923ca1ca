//! What the shaders are given of a mapping that is a function of eccentricity: two tables, one for each
//! direction.

use super::gaze_frame::GazeFrame;
use super::mapping::Mapping;
use super::vafr::NATIVE_BAND;

/// A mapping whose columns are circles of equal eccentricity about the gaze of a [`GazeFrame`].
pub trait RadialMapping: Mapping {
    /// The projection about the gaze.
    fn frame(&self) -> GazeFrame;

    /// Eccentricity in the frame of a column coordinate, rad; clamped to the LP-buffer.
    fn eccentricity_of_column_rad(&self, u: f64) -> f64;

    /// Column coordinate of an eccentricity in the frame, rad, 0..=pi.
    fn column_of_eccentricity(&self, ecc_rad: f64) -> f64;

    /// Samples per steradian from which on a display pixel is not shaded itself; 0 for a method without
    /// a native disc.
    fn acuity_per_steradian(&self, ecc_rad: f64) -> f64;

    /// How many columns this gaze uses: those up to the display's farthest corner.
    fn columns_in_use(&self) -> u32;

    /// Whether the column coordinate ends like a root, with a slope without bounds: the forward table's
    /// knots are then dense at the farthest corner, where it is even in a root of the distance to the end.
    fn ends_like_a_root(&self) -> bool {
        false
    }
}

/// Knots of the forward table. Between them the shader interpolates linearly; with these the error is
/// below 3e-4 columns for every published acuity model, and halving the number quadruples it.
pub const FORWARD_KNOTS: usize = 8192;

/// A knot of the forward table: the column coordinate, and `acuity_per_steradian` times a pixel's solid
/// angle on the axis.
pub type ForwardKnot = [f32; 2];

/// A column of the inverse table: sine and cosine of the eccentricity at its inner edge and at its
/// centre; at its outer edge, its height in texels, and the second number of [`ForwardKnot`] one column
/// farther out.
pub type ColumnRow = [[f32; 4]; 2];

/// The knots' abscissa is the square root of `tan(e / 2)`: without an arc function in the shader, and
/// such that acuity's columns are spread evenly over the knots. This is its greatest value.
#[must_use]
pub fn forward_reach(mapping: &impl RadialMapping) -> f64 {
    let columns = mapping.columns().heights().len() as f64;
    // Beyond this angle no display reaches, and the tangent stays far from its pole.
    let farthest_rad = mapping.eccentricity_of_column_rad(columns).min(3.1);
    (farthest_rad / 2.0).tan().sqrt()
}

/// Fills the forward table, of [`FORWARD_KNOTS`] knots.
pub fn fill_forward(mapping: &impl RadialMapping, knots: &mut [ForwardKnot]) {
    let reach = forward_reach(mapping);
    let last = (knots.len() - 1) as f64;
    for (index, knot) in knots.iter_mut().enumerate() {
        let share = index as f64 / last;
        let abscissa = reach * if mapping.ends_like_a_root() { share * (2.0 - share) } else { share };
        let ecc_rad = 2.0 * (abscissa * abscissa).atan();
        *knot = [mapping.column_of_eccentricity(ecc_rad) as f32, native_density(mapping, ecc_rad)];
    }
}

/// Fills the inverse table, one row for each column.
pub fn fill_columns(mapping: &impl RadialMapping, rows: &mut [ColumnRow]) {
    let circle = |u: f64| {
        let (sine, cosine) = mapping.eccentricity_of_column_rad(u).sin_cos();
        [sine as f32, cosine as f32]
    };
    for (index, (row, height)) in rows.iter_mut().zip(mapping.columns().heights()).enumerate() {
        let first = index as f64;
        let (inner, centre, outer) = (circle(first), circle(first + 0.5), circle(first + 1.0));
        let beyond = native_density(mapping, mapping.eccentricity_of_column_rad(first + 2.0));
        *row = [[inner[0], inner[1], centre[0], centre[1]], [outer[0], outer[1], *height as f32, beyond]];
    }
}

/// Never 0, so that the shader may divide by it.
fn native_density(mapping: &impl RadialMapping, ecc_rad: f64) -> f32 {
    let pixel = mapping.display().tangents_per_px();
    ((mapping.acuity_per_steradian(ecc_rad) * pixel.x * pixel.y) as f32).max(1e-30)
}

/// 1 over [`NATIVE_BAND`], for the shader.
pub(super) const INVERSE_NATIVE_BAND: f32 = (1.0 / NATIVE_BAND) as f32;
