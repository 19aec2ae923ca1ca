//! Arithmetic that gives the same bits on every machine: only `+ - * /`, `sqrt` and rounding, which
//! IEEE 754 fixes, and no function of the system's mathematics library.

use glam::{DQuat, DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Sine and cosine, to about 1e-15 for arguments of some hundred radians.
pub fn sin_cos(angle_rad: f64) -> (f64, f64) {
    let quarter = (angle_rad / FRAC_PI_2).round();
    let x = angle_rad - quarter * FRAC_PI_2;
    let x2 = x * x;
    // Taylor series; |x| <= pi/4, so the first term left out is below 1e-16.
    let (mut sin, mut cos) = (0.0, 0.0);
    for k in (0..9).rev() {
        let k = f64::from(k);
        sin = 1.0 - sin * x2 / ((2.0 * k + 2.0) * (2.0 * k + 3.0));
        cos = 1.0 - cos * x2 / ((2.0 * k + 1.0) * (2.0 * k + 2.0));
    }
    let sin = sin * x;
    match (quarter as i64).rem_euclid(4) {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Sine.
pub fn sin(angle_rad: f64) -> f64 {
    sin_cos(angle_rad).0
}

/// Cosine.
pub fn cos(angle_rad: f64) -> f64 {
    sin_cos(angle_rad).1
}

/// The point on the unit circle after a share of a full turn.
pub fn turn(share: f64) -> DVec2 {
    let (sin, cos) = sin_cos(share * TAU);
    DVec2::new(cos, sin)
}

/// Cubic step from 0 at `from` to 1 at `to`.
pub fn smooth_step(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Rotation about `+Y`.
pub fn yaw(angle_rad: f64) -> DQuat {
    let (sin, cos) = sin_cos(0.5 * angle_rad);
    DQuat::from_xyzw(0.0, sin, 0.0, cos)
}

/// Rotation that brings `-Z` to `forward` and keeps `+Y` as far up as it can: what glTF's cameras
/// and lights need.
pub fn look(forward: DVec3) -> DQuat {
    let back = -forward.normalize();
    let helper = if back.y.abs() > 0.999 { DVec3::X } else { DVec3::Y };
    let right = helper.cross(back).normalize();
    DQuat::from_mat3(&glam::DMat3::from_cols(right, back.cross(right), back))
}

/// A small generator (splitmix64): one multiplicative scramble of a counter.
pub struct Random(u64);

/// Scrambles one word.
fn scramble(word: u64) -> u64 {
    let word = (word ^ (word >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let word = (word ^ (word >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    word ^ (word >> 31)
}

impl Random {
    /// A stream of its own for each pair of `seed` and `stream`.
    pub fn new(seed: u64, stream: u64) -> Self {
        Self(scramble(seed).wrapping_add(scramble(stream ^ 0x5851_F42D_4C95_7F2D)))
    }

    /// The next word.
    pub fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        scramble(self.0)
    }

    /// In 0..1.
    pub fn unit(&mut self) -> f64 {
        // 53 bits: exactly what a double holds.
        (self.word() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// In `from..to`.
    pub fn range(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }
}

/// Smooth noise in 0..1 over the unit square, with `cells` lattice cells along each side; repeats
/// outside.
pub fn noise(x: f64, y: f64, cells: u32, seed: u64) -> f64 {
    let (gx, gy) = (x * f64::from(cells), y * f64::from(cells));
    let (cell_x, cell_y) = (gx.floor(), gy.floor());
    let ease = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let (fx, fy) = (ease(gx - cell_x), ease(gy - cell_y));
    let salt = scramble(seed);
    let corner = |dx: i64, dy: i64| {
        let wrap = |c: f64, d: i64| (c as i64 + d).rem_euclid(i64::from(cells)) as u64;
        // One product each, the last one folded: textures ask for tens of millions of these.
        let word = wrap(cell_x, dx).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ salt;
        let word = (word ^ wrap(cell_y, dy).wrapping_mul(0xD6E8_FEB8_6659_FD93)).rotate_left(29);
        let word = (word ^ (word >> 32)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (word >> 40) as f64 / (1u64 << 24) as f64
    };
    let top = corner(0, 0) + (corner(1, 0) - corner(0, 0)) * fx;
    let bottom = corner(0, 1) + (corner(1, 1) - corner(0, 1)) * fx;
    top + (bottom - top) * fy
}

/// Octaves of [`noise`], each with twice the cells and half the weight; in 0..1.
pub fn fractal(x: f64, y: f64, cells: u32, octaves: u32, seed: u64) -> f64 {
    let (mut sum, mut weight, mut weights) = (0.0, 1.0, 0.0);
    for octave in 0..octaves {
        sum += weight * noise(x, y, cells << octave, seed + u64::from(octave));
        weights += weight;
        weight *= 0.5;
    }
    sum / weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hall_sines_agree_with_the_library() {
        for step in -4000..4000 {
            let angle = f64::from(step) * 0.0137;
            let (sin, cos) = sin_cos(angle);
            assert!((sin - angle.sin()).abs() < 1e-13 && (cos - angle.cos()).abs() < 1e-13, "{angle}");
        }
    }

    #[test]
    fn hall_noise_repeats_and_stays_in_range() {
        for k in 0..200 {
            let (x, y) = (f64::from(k) * 0.0173, f64::from(k) * 0.0311);
            let value = fractal(x, y, 4, 4, 9);
            assert!((0.0..=1.0).contains(&value));
            assert!((value - fractal(x + 1.0, y - 2.0, 4, 4, 9)).abs() < 1e-9);
        }
    }

    #[test]
    fn hall_look_points_minus_z_forward() {
        for forward in [DVec3::new(0.3, -0.5, 0.8), DVec3::NEG_Y, DVec3::NEG_Z, DVec3::Z] {
            assert!((look(forward) * DVec3::NEG_Z - forward.normalize()).length() < 1e-12);
        }
    }
}
