//! The mapping of kernel foveated rendering.
/// A point of the LP-buffer, both coordinates in 0..=1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LpCoord {
    /// Along the radius.
    pub u_norm: f64,
    /// Along the angle.
    pub v_norm: f64,
}
/// Stub.
pub struct KfrMapping;
