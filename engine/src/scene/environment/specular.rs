//! Specular light: the picture as GGX lobes see it.
//!
//! The first half of the split sum (Karis, "Real Shading in Unreal Engine 4", 2013): the lobe's
//! normal and view direction are its mirror direction. Samples follow the lobe and read from a
//! halved picture whose texels are about as large as the part of the lobe for which the sample
//! stands (Krivanek and Colbert, "Real-time Shading with Filtered Importance Sampling", 2008), so
//! that small bright sources leave no single bright texels.

use super::latlong::{Chain, Image, direction_of_uv, resample};
use super::{MAX_RADIANCE, SpecularLevel};
use rayon::prelude::*;
use std::f32::consts::{PI, TAU};

/// Number of levels in `Environment::specular`.
pub const SPECULAR_LEVELS: usize = 6;

/// Width and height of the first level.
pub const SPECULAR_SIZE: [u32; 2] = [512, 256];

/// The picture from which samples are taken; finer detail than the first level needs would cost
/// memory only.
const SOURCE_SIZE: [usize; 2] = [1024, 512];

/// Lobe samples for each texel. The rough levels have few texels and wide lobes.
const SAMPLES: [u32; SPECULAR_LEVELS] = [1, 64, 128, 256, 256, 512];

/// Width and height of a level.
pub(super) fn level_size(level: usize) -> [u32; 2] {
    SPECULAR_SIZE.map(|side| (side >> level).max(1))
}

/// One direction of the lobe around +Z.
#[derive(Clone, Copy, Debug)]
struct LobeSample {
    direction: [f32; 3],
    /// Its cosine over the sum of all cosines.
    weight: f32,
    lod: f32,
}

/// Point `index` of `count` of the Hammersley set: stratified in both coordinates.
pub(super) fn hammersley(index: u32, count: u32) -> [f32; 2] {
    let radical_inverse = index.reverse_bits() as f32 * 2.0_f32.powi(-32);
    [(index as f32 + 0.5) / count as f32, radical_inverse]
}

/// Directions that follow the GGX distribution's half vectors, mirrored about them.
fn lobe(roughness: f32, count: u32) -> Vec<LobeSample> {
    let alpha2 = (roughness * roughness).powi(2);
    let texel_angle = 4.0 * PI / (SOURCE_SIZE[0] * SOURCE_SIZE[1]) as f32;
    let sample_of = |index: u32| {
        let [a, b] = hammersley(index, count);
        let cos2 = (1.0 - a) / (1.0 + (alpha2 - 1.0) * a);
        let (cos, sin) = (cos2.sqrt(), (1.0 - cos2).max(0.0).sqrt());
        let (sin_phi, cos_phi) = (b * TAU).sin_cos();
        // The mirrored view direction: twice the half vector's angle.
        let direction = [2.0 * cos * sin * cos_phi, 2.0 * cos * sin * sin_phi, 2.0 * cos2 - 1.0];
        let density = alpha2 / (PI * (cos2 * (alpha2 - 1.0) + 1.0).powi(2)) / 4.0;
        let sample_angle = 1.0 / (count as f32 * density);
        // One level coarser than of equal size, for overlap between samples.
        let lod = (0.5 * (sample_angle / texel_angle).log2() + 1.0).max(0.0);
        LobeSample { direction, weight: direction[2], lod }
    };
    let mut samples: Vec<LobeSample> =
        (0..count).map(sample_of).filter(|sample| sample.weight > 0.0).collect();
    let sum: f32 = samples.iter().map(|sample| sample.weight).sum();
    for sample in &mut samples {
        sample.weight /= sum;
    }
    samples
}

/// What the lobe around the direction at `uv` sees.
fn filtered_texel(chain: &Chain, samples: &[LobeSample], uv: [f32; 2]) -> [f32; 4] {
    let n = direction_of_uv(uv);
    let (sin_phi, cos_phi) = ((uv[0] - 0.5) * TAU).sin_cos();
    // East and its perpendicular: smooth over the picture, so that the samples' error is smooth too.
    let t = [cos_phi, 0.0, sin_phi];
    let b = [n[1] * t[2], n[2] * t[0] - n[0] * t[2], -n[1] * t[0]];
    let mut sum = [0.0_f32; 3];
    for sample in samples {
        let [x, y, z] = sample.direction;
        let direction = [0, 1, 2].map(|i| t[i] * x + b[i] * y + n[i] * z);
        for (sum, value) in sum.iter_mut().zip(chain.sample(direction, sample.lod)) {
            *sum += value * sample.weight;
        }
    }
    let [r, g, b] = sum.map(|value| value.clamp(0.0, MAX_RADIANCE));
    [r, g, b, 1.0]
}

/// One level of the chain.
fn filtered_level(chain: &Chain, level: usize) -> SpecularLevel {
    let size = level_size(level);
    let [width, height] = size.map(|side| side as usize);
    if level == 0 {
        let source = chain.level(0);
        let Image { mut pixels, .. } = resample(&source.pixels, source.size, [width, height]);
        for texel in &mut pixels {
            *texel = texel.map(|value| value.clamp(0.0, MAX_RADIANCE));
            texel[3] = 1.0;
        }
        return SpecularLevel { size, pixels };
    }
    let roughness = level as f32 / (SPECULAR_LEVELS - 1) as f32;
    let samples = lobe(roughness, SAMPLES[level]);
    let mut pixels = vec![[0.0_f32; 4]; width * height];
    pixels.par_chunks_mut(width).enumerate().for_each(|(row, line)| {
        for (column, texel) in line.iter_mut().enumerate() {
            let uv = [(column as f32 + 0.5) / width as f32, (row as f32 + 0.5) / height as f32];
            *texel = filtered_texel(chain, &samples, uv);
        }
    });
    SpecularLevel { size, pixels }
}

/// `Environment::specular` of a picture.
pub(super) fn prefilter(size: [u32; 2], pixels: &[[f32; 4]]) -> Vec<SpecularLevel> {
    let chain = Chain::new(resample(pixels, size.map(|side| side as usize), SOURCE_SIZE));
    (0..SPECULAR_LEVELS).map(|level| filtered_level(&chain, level)).collect()
}
