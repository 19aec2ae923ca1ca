//! The ray-marched scene of `shaders/shared/sdf.glsl`: what the CPU knows of it.

use glam::DVec3;

/// Where the default camera stands, metres.
pub const DEFAULT_EYE: DVec3 = DVec3::new(-2.2, 3.4, 8.4);

/// What the default camera looks at, metres.
pub const DEFAULT_LOOK_AT: DVec3 = DVec3::new(-0.1, 0.4, 0.2);

/// The kinds of solids, by the number that the shader knows them by: five to a row, from the
/// farthest row on the left.
pub const PRIMITIVE_KINDS: [&str; 20] = [
    "sphere",
    "box",
    "round box",
    "box frame",
    "torus",
    "capped torus",
    "link",
    "cylinder",
    "capped cone",
    "round cone",
    "capsule",
    "hexagonal prism",
    "triangular prism",
    "octahedron",
    "pyramid",
    "ellipsoid",
    "solid angle",
    "cut sphere",
    "sphere with a dent",
    "rhombic prism",
];
