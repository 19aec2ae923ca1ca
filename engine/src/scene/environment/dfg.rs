//! The second half of the split sum: how much a GGX lobe reflects of a white environment.

use super::specular::hammersley;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Scale and bias so that a lobe under uniform light of radiance 1 reflects `f0 * scale + bias`
/// (Karis, "Real Shading in Unreal Engine 4", 2013): GGX with height-correlated Smith shadowing
/// (Heitz, "Understanding the Masking-Shadowing Function", 2014) and Schlick's Fresnel term. Half
/// vectors are sampled as far as they are visible (Dupuy and Benyoub, "Sampling Visible GGX Normals
/// with Spherical Caps", 2023): at grazing views, few others would matter.
///
/// `n_dot_v` in 0..=1; `roughness` is perceptual, 0..=1, alpha its square; `samples` at least 1.
/// Both results are finite, at least 0, and their sum is at most 1.
#[must_use]
pub fn dfg(n_dot_v: f64, roughness: f64, samples: u32) -> [f64; 2] {
    let samples = samples.max(1);
    // At exactly 0 the lobe is a point and the view a plane: the limits come from just beside them.
    let nv = n_dot_v.clamp(1e-4, 1.0);
    let alpha = roughness.clamp(0.0, 1.0).powi(2).max(1e-6);
    let alpha2 = alpha * alpha;
    let view = [(1.0 - nv * nv).max(0.0).sqrt(), nv];
    // The view direction where the surface is stretched to a hemisphere.
    let stretched = {
        let length = (alpha * view[0]).hypot(nv);
        [alpha * view[0] / length, nv / length]
    };
    // Twice the cosine over Smith's masking term.
    let spread = |cos: f64| cos + (cos * cos * (1.0 - alpha2) + alpha2).sqrt();
    let (mut scale, mut bias) = (0.0, 0.0);
    for index in 0..samples {
        let [a, b] = hammersley(index, samples).map(f64::from);
        let (sin_phi, cos_phi) = (b * TAU).sin_cos();
        let z = (1.0 - a) * (1.0 + stretched[1]) - stretched[1];
        let sin = (1.0 - z * z).max(0.0).sqrt();
        let half =
            [alpha * (sin * cos_phi + stretched[0]), alpha * sin * sin_phi, (z + stretched[1]).max(0.0)];
        let length = half[0].hypot(half[1]).hypot(half[2]).max(f64::MIN_POSITIVE);
        let nh = half[2] / length;
        let vh = ((view[0] * half[0] + view[1] * half[2]) / length).clamp(0.0, 1.0);
        let nl = 2.0 * vh * nh - nv;
        if nl <= 0.0 {
            continue;
        }
        let lambda_v = nl * (nv * nv * (1.0 - alpha2) + alpha2).sqrt();
        let lambda_l = nv * (nl * nl * (1.0 - alpha2) + alpha2).sqrt();
        // Shadowing and masking together over masking alone: the visible half vectors' density has
        // taken care of all else.
        let weight = nl * spread(nv) / (lambda_v + lambda_l);
        let fresnel = (1.0 - vh).powi(5);
        scale += (1.0 - fresnel) * weight;
        bias += fresnel * weight;
    }
    // Each weight is at most 1 but for rounding.
    let norm = f64::from(samples).max(scale + bias);
    [scale / norm, bias / norm]
}

/// `size * size` pairs of scale and bias as [`dfg`] gives them, rows one after the other: along a
/// row N.V, from row to row the perceptual roughness, both at texel centres, `(i + 0.5) / size`.
/// `samples` for each texel; 256 keep the error below 0.01.
#[must_use]
pub fn dfg_lut(size: usize, samples: usize) -> Vec<[f32; 2]> {
    let samples = u32::try_from(samples).unwrap_or(u32::MAX);
    let at = |index: usize| (index as f64 + 0.5) / size as f64;
    let texel = |index: usize| dfg(at(index % size), at(index / size), samples).map(|value| value as f32);
    (0..size * size).into_par_iter().map(texel).collect()
}
