//! Hard cases of shading: extreme scenes, foveated pictures of every size, scene files that must be refused;
//! and of sequences of frames.

mod extreme_scenes;
mod extremes;
mod files;
mod foveated;
mod reconstruction;
mod scenes;
mod sequences;
mod stage;

use super::family::Family;

/// The families of these parts.
pub fn families() -> Vec<Family> {
    let parts = [
        files::families(),
        extremes::families(),
        foveated::families(),
        reconstruction::families(),
        sequences::families(),
    ];
    parts.into_iter().flatten().collect()
}

pub use sequences::VACUOUS;
