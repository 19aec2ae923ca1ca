//! Directions on the sphere.

use glam::{DVec2, DVec3};

/// The direction to a place given by yaw (right) and pitch (up), degrees.
pub(super) fn direction(place_deg: DVec2) -> DVec3 {
    let (yaw, pitch) = (place_deg.x.to_radians(), place_deg.y.to_radians());
    DVec3::new(yaw.sin() * pitch.cos(), pitch.sin(), -yaw.cos() * pitch.cos())
}

/// Yaw (right) and pitch (up) of a direction of length 1, degrees.
pub(super) fn place_deg(direction: DVec3) -> DVec2 {
    let yaw = direction.x.atan2(-direction.z);
    DVec2::new(yaw.to_degrees(), direction.y.clamp(-1.0, 1.0).asin().to_degrees())
}

/// Turns a direction about an axis of length 1 at right angles to it.
pub(super) fn turn(from: DVec3, axis: DVec3, angle_rad: f64) -> DVec3 {
    let (sin, cos) = angle_rad.sin_cos();
    from * cos + axis.cross(from) * sin
}

/// The angle between two directions of length 1, rad; exact for small ones too.
pub(super) fn angle(from: DVec3, to: DVec3) -> f64 {
    from.cross(to).length().atan2(from.dot(to))
}

/// The axis about which `from` turns towards `to`, of length 1; upright where both are the same.
pub(super) fn axis(from: DVec3, to: DVec3) -> DVec3 {
    from.cross(to).try_normalize().unwrap_or_else(|| tangents(from).1)
}

/// Right and up, as seen along a direction of length 1.
pub(super) fn tangents(direction: DVec3) -> (DVec3, DVec3) {
    let right = direction.cross(DVec3::Y).try_normalize().unwrap_or(DVec3::X);
    (right, right.cross(direction))
}

/// A direction moved a little to the right and up, degrees.
pub(super) fn deflect(direction: DVec3, by_deg: DVec2) -> DVec3 {
    let (right, up) = tangents(direction);
    let by = by_deg * 1.0_f64.to_radians();
    (direction + right * by.x + up * by.y).normalize_or(direction)
}
