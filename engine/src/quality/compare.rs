//! Comparison of two pictures.
