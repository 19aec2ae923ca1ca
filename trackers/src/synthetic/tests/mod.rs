mod analysis;
mod invariance;
mod statistics;
mod tracker;
