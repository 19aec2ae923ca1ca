//! Tests of the synthetic eye, by what they hold it against.

mod analysis;
mod invariance;
mod statistics;
mod tracker;
