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

/// What the catalogue names and no case can have, in parts.
pub const LEFT_OUT: [&[(&str, &str)]; 3] = [
    &[reconstruction::LEFT_OUT],
    &[
        ("flicker of small highlights", "it is a measurement, which `macula bench flicker` makes"),
        (
            "texture gradients across the seam",
            "materials are evaluated at display pixels, which have no seam",
        ),
    ],
    &sequences::LEFT_OUT,
];

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
