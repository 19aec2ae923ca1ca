//! Error metrics between two pictures, whole and by eccentricity, and of sequences of pictures.

pub mod acuity_error;
pub mod compare;
pub mod picture;
pub mod temporal;
