//! The ray-marched scene's default camera.
use glam::DVec3;
/// Eye.
pub const DEFAULT_EYE: DVec3 = DVec3::new(0.0, 3.0, 6.0);
/// Where it looks.
pub const DEFAULT_LOOK_AT: DVec3 = DVec3::ZERO;
/// Kinds.
pub const PRIMITIVE_KINDS: [&str; 0] = [];
