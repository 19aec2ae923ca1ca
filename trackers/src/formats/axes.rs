//! From the axes of recorders to view space (`-Z` forward, `+Y` up, `+X` to the wearer's right).

use glam::{DQuat, DVec3};

/// From x right, y up, z forward, which is left-handed: Unity, Varjo, FOVE, Pico.
pub(super) fn of_unity(v: DVec3) -> DVec3 {
    DVec3::new(v.x, v.y, -v.z)
}

/// From x to the wearer's left, y up, z forward: SRanipal, Tobii's head unit, Aria's pupil frame.
pub(super) fn of_left_up_forward(v: DVec3) -> DVec3 {
    DVec3::new(-v.x, v.y, -v.z)
}

/// From x right, y down, z forward: a camera.
pub(super) fn of_camera(v: DVec3) -> DVec3 {
    DVec3::new(v.x, -v.y, -v.z)
}

/// A vector that was told: finite and not zero, which recorders write for "none".
pub(super) fn told(v: DVec3) -> Option<DVec3> {
    (v.is_finite() && v != DVec3::ZERO).then_some(v)
}

/// An origin in m from one in mm.
pub(super) fn metres(v: DVec3) -> Option<DVec3> {
    told(v).map(|mm| mm * 1e-3)
}

/// A rotation of Unity's (left-handed) as one of view space; `None` where it is no rotation.
pub(super) fn quaternion_of_unity([x, y, z, w]: [f64; 4]) -> Option<DQuat> {
    let turn = DQuat::from_xyzw(-x, -y, z, w);
    let length = turn.length();
    // Written with three decimals, a quaternion is off by up to 0.001.
    (turn.is_finite() && (length - 1.0).abs() < 0.05).then(|| turn.normalize())
}

/// Unity's Euler angles in degrees: about z, then x, then y, all left-handed.
pub(super) fn quaternion_of_unity_deg(angles: DVec3) -> Option<DQuat> {
    let DVec3 { x, y, z } = angles.map(f64::to_radians);
    let turn = DQuat::from_rotation_y(-y) * DQuat::from_rotation_x(-x) * DQuat::from_rotation_z(z);
    angles.is_finite().then_some(turn)
}

/// The direction of an azimuth (positive to the right, about the vertical axis) and an elevation
/// (positive up, from the horizontal plane), degrees: `(sin a cos e, sin e, -cos a cos e)`.
pub(super) fn of_azimuth_deg(azimuth: f64, elevation: f64) -> Option<DVec3> {
    let (sin_a, cos_a) = azimuth.to_radians().sin_cos();
    let (sin_e, cos_e) = elevation.to_radians().sin_cos();
    told(DVec3::new(sin_a * cos_e, sin_e, -cos_a * cos_e))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn azimuth_is_to_the_right_and_elevation_up() {
        let near =
            |a: Option<DVec3>, b: DVec3| assert!(a.is_some_and(|a| a.abs_diff_eq(b, 1e-15)), "{a:?} {b}");
        near(of_azimuth_deg(0.0, 0.0), DVec3::NEG_Z);
        near(of_azimuth_deg(90.0, 0.0), DVec3::X);
        near(of_azimuth_deg(0.0, 90.0), DVec3::Y);
        let (half, quarter3) = (0.5, 0.75f64.sqrt());
        near(of_azimuth_deg(-30.0, 30.0), DVec3::new(-half * quarter3, half, -0.75));
        assert_eq!(of_azimuth_deg(f64::NAN, 0.0), None);
    }

    #[test]
    fn unity_turns_are_left_handed() {
        // In Unity a turn of +90 degrees about y looks to the right, about x down.
        let turn = quaternion_of_unity_deg(DVec3::new(0.0, 90.0, 0.0)).expect("finite");
        assert!((turn * DVec3::NEG_Z).abs_diff_eq(DVec3::X, 1e-15));
        let turn = quaternion_of_unity_deg(DVec3::new(90.0, 0.0, 0.0)).expect("finite");
        assert!((turn * DVec3::NEG_Z).abs_diff_eq(DVec3::NEG_Y, 1e-15));
        // About z a positive turn lifts the right-hand side.
        let turn = quaternion_of_unity_deg(DVec3::new(0.0, 0.0, 90.0)).expect("finite");
        assert!((turn * DVec3::X).abs_diff_eq(DVec3::Y, 1e-15));
        // The pitch is applied before the yaw.
        let turn = quaternion_of_unity_deg(DVec3::new(90.0, 90.0, 0.0)).expect("finite");
        assert!((turn * DVec3::NEG_Z).abs_diff_eq(DVec3::NEG_Y, 1e-15));
        assert!((turn * DVec3::Y).abs_diff_eq(DVec3::X, 1e-15));
    }

    #[test]
    fn a_quaternion_of_unity_turns_like_its_angles() {
        let half = 0.5f64.sqrt();
        let turn = quaternion_of_unity([0.0, half, 0.0, half]).expect("a rotation");
        assert!((turn * DVec3::NEG_Z).abs_diff_eq(DVec3::X, 1e-15));
        assert_eq!(quaternion_of_unity([0.0; 4]), None);
        assert_eq!(quaternion_of_unity([f64::NAN, 0.0, 0.0, 1.0]), None);
    }
}
