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

/// What the catalogue names and no case can have.
pub const LEFT_OUT: [(&str, &str); 4] =
    [reconstruction::LEFT_OUT, sequences::LEFT_OUT[0], sequences::LEFT_OUT[1], sequences::LEFT_OUT[2]];

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
