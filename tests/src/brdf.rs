//! The reflection model of the glTF 2.0 specification, appendix B, in double precision, and light units
//! of `KHR_lights_punctual`. Written from the specifications' formulas, not from the shaders.

use glam::DVec3;
use std::f64::consts::PI;

/// A surface as appendix B sees it.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// Linear base colour.
    pub base: DVec3,
    /// Share of metal.
    pub metallic: f64,
    /// Perceptual roughness.
    pub roughness: f64,
}

/// B.3.5: the BRDF for unit vectors towards light and eye, per steradian.
#[must_use]
pub fn brdf(surface: &Surface, normal: DVec3, light: DVec3, view: DVec3) -> DVec3 {
    let half = (light + view).normalize();
    let (nl, nv) = (normal.dot(light), normal.dot(view));
    let (nh, vh) = (normal.dot(half), view.dot(half));
    if nl <= 0.0 || nv <= 0.0 {
        return DVec3::ZERO;
    }
    let alpha2 = (surface.roughness * surface.roughness).powi(2);
    let distribution = alpha2 / (PI * (nh * nh * (alpha2 - 1.0) + 1.0).powi(2));
    let one_side = |cosine: f64| 1.0 / (cosine + (alpha2 + (1.0 - alpha2) * cosine * cosine).sqrt());
    let visibility = one_side(nl) * one_side(nv);
    let f0 = DVec3::splat(0.04).lerp(surface.base, surface.metallic);
    let fresnel = f0 + (DVec3::ONE - f0) * (1.0 - vh.abs()).powi(5);
    let diffuse = surface.base * (1.0 - surface.metallic) / PI;
    (DVec3::ONE - fresnel) * diffuse + fresnel * (distribution * visibility)
}

/// Radiance towards the eye under light of an illuminance (lux, across its direction).
#[must_use]
pub fn radiance(surface: &Surface, normal: DVec3, light: DVec3, view: DVec3, lux: f64) -> DVec3 {
    brdf(surface, normal, light, view) * (lux * normal.dot(light).max(0.0))
}

/// Illuminance across the direction of a light of `candela`, with the extension's range window.
#[must_use]
pub fn lux_at(candela: f64, distance_m: f64, range_m: f64) -> f64 {
    let window =
        if range_m.is_finite() { (1.0 - (distance_m / range_m).powi(4)).clamp(0.0, 1.0) } else { 1.0 };
    candela * window / (distance_m * distance_m)
}

/// The share of a spot light's intensity at an angle from its axis, as the extension recommends.
#[must_use]
pub fn cone(angle: f64, inner: f64, outer: f64) -> f64 {
    let scale = 1.0 / (inner.cos() - outer.cos()).max(0.001);
    (angle.cos() * scale - outer.cos() * scale).clamp(0.0, 1.0).powi(2)
}
