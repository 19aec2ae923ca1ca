//! Environment maps: light from infinitely far, from a latitude-longitude picture.
//!
//! # Directions
//! World space is right-handed with `+Y` up. A direction `(x, y, z)` of length 1 lies at
//!
//! ```text
//! u = 0.5 + atan2(x, -z) / (2 pi)      0 at the left edge, 1 at the right edge
//! v = acos(y) / pi                     0 at the top (+Y), 1 at the bottom (-Y)
//! ```
//!
//! so `-Z` is the picture's centre and `+X` lies to its right. Every picture here, the GPU's copies
//! included, has this layout; sampling repeats along u and clamps along v.

mod dfg;
mod exr_file;
#[cfg(test)]
mod hostile_tests;
mod irradiance;
mod latlong;
mod radiance_file;
mod read;
mod specular;
#[cfg(test)]
mod tests;

pub use dfg::{dfg, dfg_lut};
pub use irradiance::{SH_COUNT, sh_basis};
pub use latlong::{direction_of_uv, uv_of_direction};
pub use specular::{SPECULAR_LEVELS, SPECULAR_SIZE};

use crate::error::{Error, Result};
use std::path::Path;

/// The greatest radiance kept, in the file's unit: the greatest half float, so that every texel fits
/// a 16 bit float texture.
pub const MAX_RADIANCE: f32 = 65504.0;

/// The most texels that a file may have.
pub const MAX_TEXELS: usize = 8192 * 4096;

/// The longest side that a file may have, texels.
pub const MAX_SIDE: usize = 16384;

/// One level of the prefiltered chain.
#[derive(Clone, Debug, PartialEq)]
pub struct SpecularLevel {
    /// Width and height, texels.
    pub size: [u32; 2],
    /// `width * height` linear RGB radiances, rows from the top; the fourth value is 1.
    pub pixels: Vec<[f32; 4]>,
}

/// An environment map with what image-based lighting needs of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// The file's name without its folder, for messages.
    pub name: String,
    /// Width and height of `pixels`, each at least 1.
    pub size: [u32; 2],
    /// `width * height` linear RGB radiances in 0..=[`MAX_RADIANCE`], rows from the top, in the
    /// layout that the module's documentation gives; the fourth value is 1.
    pub pixels: Vec<[f32; 4]>,
    /// Texels of the file that were not in range: NaN and negative values became 0, infinite and
    /// too large ones [`MAX_RADIANCE`].
    pub repaired: u64,
    /// Irradiance / pi as spherical harmonics up to order 2 (Ramamoorthi and Hanrahan, "An Efficient
    /// Representation for Irradiance Environment Maps", 2001); the fourth value of each is 0.
    /// All constants are multiplied in, those of the harmonics and of the cosine lobe, so
    ///
    /// ```text
    /// irradiance(n) / pi = sum over i of diffuse_sh[i].rgb * sh_basis(n)[i]
    /// sh_basis(n) = 1, y, z, x, x y, y z, 3 z^2 - 1, x z, x^2 - y^2
    /// ```
    ///
    /// and a white Lambertian surface sends out just that radiance. Where a small bright source
    /// stands opposite, the sum can fall below 0; clamp it.
    pub diffuse_sh: [[f32; 4]; SH_COUNT],
    /// [`SPECULAR_LEVELS`] levels, each half as wide as the one before; level `i` holds what a GGX
    /// lobe of perceptual roughness `i / (SPECULAR_LEVELS - 1)` sees along its mirror direction.
    pub specular: Vec<SpecularLevel>,
}

impl Environment {
    /// Reads a latitude-longitude picture from an OpenEXR or Radiance HDR file (told apart by their
    /// first bytes) and filters it.
    ///
    /// OpenEXR: the first part (of one with several) that has `R`, `G` or `B`, or else `Y`, without
    /// a layer's prefix or with the first that has all three; half, float and integer; scan lines
    /// and tiles, of several resolutions the largest. The picture is the data window, whatever the
    /// display window says. Alpha is ignored. Subsampled chroma, deep data and HTJ2K are not
    /// supported.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read; [`Error::File`] if it is damaged, of another
    /// format, a cube map, or larger than [`MAX_TEXELS`] or [`MAX_SIDE`].
    pub fn load(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let picture = read::read(path)?;
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        Ok(Self::filtered(name, picture.size, picture.pixels))
    }

    /// Filters a picture of `width * height` linear RGBA radiances in the module's layout. Values
    /// out of range are repaired as in [`Environment::load`].
    ///
    /// # Errors
    /// [`Error::Setting`] if the size is 0, is too large or is not that of `pixels`.
    pub fn from_pixels(name: impl Into<String>, size: [u32; 2], pixels: Vec<[f32; 4]>) -> Result<Self> {
        let name = name.into();
        let wide = size.map(|side| side as usize);
        read::check_size(wide).map_err(|cause| Error::Setting(format!("environment {name}: {cause}")))?;
        if pixels.len() != wide[0] * wide[1] {
            return Err(Error::Setting(format!(
                "environment {name}: {} texels given for {}x{}",
                pixels.len(),
                size[0],
                size[1]
            )));
        }
        Ok(Self::filtered(name, size, pixels))
    }

    /// The same radiance from everywhere, in closed form: irradiance / pi and every prefiltered
    /// texel equal it. Values out of range become 0 or [`MAX_RADIANCE`].
    #[must_use]
    pub fn uniform(radiance: [f32; 3]) -> Self {
        let [r, g, b] = radiance.map(|value| read::repaired(value).0);
        let level = |index: usize| {
            let size = specular::level_size(index);
            SpecularLevel { size, pixels: vec![[r, g, b, 1.0]; (size[0] * size[1]) as usize] }
        };
        let mut diffuse_sh = [[0.0; 4]; SH_COUNT];
        diffuse_sh[0] = [r, g, b, 0.0];
        Self {
            name: "uniform".into(),
            size: [2, 1],
            pixels: vec![[r, g, b, 1.0]; 2],
            repaired: 0,
            diffuse_sh,
            specular: (0..SPECULAR_LEVELS).map(level).collect(),
        }
    }

    /// Irradiance / pi, RGB, on a surface of unit normal `normal`; not below 0.
    #[must_use]
    pub fn diffuse(&self, normal: [f32; 3]) -> [f32; 3] {
        let mut sum = [0.0_f32; 3];
        for (coefficient, basis) in self.diffuse_sh.iter().zip(sh_basis(normal)) {
            for (sum, coefficient) in sum.iter_mut().zip(coefficient) {
                *sum += coefficient * basis;
            }
        }
        sum.map(|value| value.max(0.0))
    }

    /// Repairs and filters; `pixels` has `size[0] * size[1]` texels, at least one.
    fn filtered(name: String, size: [u32; 2], mut pixels: Vec<[f32; 4]>) -> Self {
        let repaired = read::repair(&mut pixels);
        let diffuse_sh = irradiance::project(size, &pixels);
        let specular = specular::prefilter(size, &pixels);
        Self { name, size, pixels, repaired, diffuse_sh, specular }
    }
}
