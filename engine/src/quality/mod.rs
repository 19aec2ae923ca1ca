//! Error metrics between two pictures, whole and by eccentricity.

pub mod compare;
