mod analysis;
mod invariance;
mod statistics;
