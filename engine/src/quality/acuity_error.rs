//! The acuity-surviving error: how far apart two pictures are to an eye that looks at the gaze.
//!
//! # Definition
//!
//! Let `e` be a pixel's eccentricity (the angle between its ray and the gaze ray, degrees), `f(e)`
//! the acuity there in cycles per degree (cpd), and `p` the display's pixels per degree at that
//! pixel.
//!
//! 1. Both pictures, in **linear light**, are low-passed by a Gaussian whose width belongs to the
//!    pixel that it is centred on: `sigma = p sqrt(2 ln 2)/(2 pi f(e))` px. Its transfer of a grating
//!    of `v` cpd is `2^-(v/f)^2`: half of the amplitude (-6 dB) at the acuity limit, 0.96 of it at a
//!    quarter, 0.06 at twice, 0.002 at three times the limit.
//! 2. Where the display resolves no more than the acuity, `f(e) >= p/2`, there is no filter.
//! 3. The display is surrounded by its own mirror image, so that every filter's weights sum to 1 and
//!    no edge darkens.
//! 4. Both results are **encoded** by the sRGB curve and subtracted. The error is the root of the
//!    mean square (RMSE) over pixels and RGB, where 1 is white on black, and its PSNR,
//!    `-20 log10(RMSE)`: over the display and over the rings of [`RING_STARTS_DEG`]. Without a
//!    filter it is [`super::compare::psnr_db`].
//!
//! # Why so
//!
//! - *Acuity.* `f(e)` is the caller's; the pivots of VaFR 2025 (40, 10, 6, 5, 4 cpd at 0, 10, 20, 30,
//!   60 degrees; `AcuityModel`) follow the linear fall of the minimum angle of resolution
//!   (Guenter et al., "Foveated 3D Graphics", 2012). It holds for high contrast: of what is left
//!   here, faint parts may not be seen.
//! - *Gaussian.* Acuity is where a grating stops being told from grey; an ideal filter would be a step
//!   at `f`. A step rings, makes negative light and has no local form. The Gaussian goes through the
//!   middle of the step; its full width at half maximum, `0.44/f`, is about the one sample (`0.5/f`) that a
//!   renderer may spend there. It is not the contrast sensitivity function: clearly visible contrasts look
//!   alike up to near the limit (Georgeson and Sullivan, "Contrast constancy", 1975), and a
//!   sensitivity weighting would forgive them.
//! - *Linear light before, encoding after.* What is finer than acuity reaches the eye as the mean of
//!   its light: the optics and the pooling of receptors add light, not code values (a checkerboard of
//!   black and white looks like 188, not 128). How visible the remaining difference is depends on its
//!   ratio to the light around, which the encoding evens out.
//! - *One `p` per pixel.* On a flat display pixels per degree differ by direction: with `s` the secant
//!   of the angle between a pixel's ray and the display's normal, they rise with `s^2` away from the
//!   foot of that normal and with `s` across. `p` is the root of the pixels per square degree, `s^1.5`, so that
//!   sigma is too small along the former and too large across by the factor `sqrt(s)`: 7 % at 30
//!   degrees off the normal, 25 % at 50, 41 % at 60.
//!
//! # How it is computed, and how exactly
//!
//! Gaussians at a fixed series of sigmas, each computed tile by tile where it is needed, and each
//! pixel interpolated between the two that enclose its own, linearly in the variance. Above a sigma
//! of 8 px they are computed on halved grids. At any frequency the transfer is within 0.02 of the
//! Gaussian's. The time per pixel is bounded, however large sigma is.

mod levels;
mod pyramid;
mod tile;

#[cfg(test)]
mod tests;

use super::compare::{
    MAX_PIXELS, RING_STARTS_DEG, check_gaze, eccentricities, finite_or_null, number_inf_or_null,
    number_or_inf, ring_end_deg, ring_of,
};
use super::picture::{Picture, encode_srgb};
use crate::error::{Error, Result};
use crate::fovea::DisplayGeometry;
use glam::DVec2;
use levels::{Level, SHARP, levels_to, place_of, sigma_times_cutoff};
use pyramid::{Planes, Pyramid};
use rayon::prelude::*;
use serde::Serialize;
use tile::{Scratch, TILE_PX, Tile, low_pass};

/// The acuity-surviving error in one ring of eccentricities.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AcuityRing {
    /// The least eccentricity in it, degrees.
    pub from_deg: f64,
    /// Where it ends, degrees, itself outside; infinite for the last ring, written as null.
    #[serde(serialize_with = "finite_or_null")]
    pub to_deg: f64,
    /// Pixels whose centres lie in it.
    pub pixels: u64,
    /// Root of the mean square of the encoded difference over them; `None`, written as null, without
    /// pixels.
    pub rmse: Option<f64>,
    /// The same as PSNR, dB; infinite, written as `"inf"`, where the RMSE is 0.
    #[serde(serialize_with = "number_inf_or_null")]
    pub psnr_db: Option<f64>,
}

/// The acuity-surviving error of two pictures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AcuityError {
    /// As [`AcuityRing::rmse`], of the whole pictures.
    pub rmse: f64,
    /// As [`AcuityRing::psnr_db`], of the whole pictures.
    #[serde(serialize_with = "number_or_inf")]
    pub psnr_db: f64,
    /// The rings that begin at [`RING_STARTS_DEG`].
    pub rings: Vec<AcuityRing>,
}

/// The low-pass of one display, gaze and acuity, for any number of pictures.
pub struct AcuityLowPass {
    size: [u32; 2],
    /// Where each pixel's sigma lies among the levels.
    places: Vec<f32>,
    /// Each pixel's ring.
    rings: Vec<u8>,
    levels: Vec<Level>,
}

impl AcuityLowPass {
    /// For pictures that fill `display`, around the gaze at `gaze_px` (pixel centres at .5; it may lie
    /// outside the display). `cutoff_cpd` is the acuity `f(e)` at an eccentricity of 0 to 180 degrees:
    /// above 0, and infinite for no filter.
    ///
    /// # Errors
    /// [`Error::Setting`] if display or gaze are out of range, the display has more than 2^28 pixels,
    /// or an acuity is not above 0.
    pub fn new(
        display: &DisplayGeometry,
        gaze_px: DVec2,
        cutoff_cpd: impl Fn(f64) -> f64 + Sync,
    ) -> Result<Self> {
        display.check()?;
        check_gaze(gaze_px)?;
        let [width, height] = display.size_px.map(|side| side as usize);
        let pixels = width.checked_mul(height).filter(|&pixels| pixels <= MAX_PIXELS);
        let Some(pixels) = pixels else {
            return Err(Error::Setting(format!(
                "a display of {width}x{height} px is too large for the acuity-surviving error; it may have \
                 {MAX_PIXELS} pixels"
            )));
        };
        let (mut places, mut rings) = (vec![SHARP; pixels], vec![0; pixels]);
        // A Gaussian this wide has averaged the whole display.
        let widest_px = 2.0 * width.max(height) as f64;
        let fill = |row: usize, places: &mut [f32], rings: &mut [u8]| -> Result<f32> {
            let angles = eccentricities(display, gaze_px, row);
            let mut last = SHARP;
            for (column, angle) in angles.enumerate() {
                rings[column] = ring_of(angle) as u8;
                let cutoff = cutoff_cpd(angle);
                if cutoff.is_nan() || cutoff <= 0.0 {
                    return Err(Error::Setting(format!(
                        "the acuity at {angle} degrees is {cutoff} cpd; it must be above 0"
                    )));
                }
                let density = pixels_per_degree(display, column, row);
                if cutoff < density / 2.0 {
                    let sigma_px = density * sigma_times_cutoff() / cutoff;
                    places[column] = place_of(sigma_px.min(widest_px));
                    last = last.max(places[column]);
                }
            }
            Ok(last)
        };
        let rows = places.par_chunks_mut(width).zip(rings.par_chunks_mut(width)).enumerate();
        let last = rows
            .map(|(row, (places, rings))| fill(row, places, rings))
            .try_reduce(|| SHARP, |a, b| Ok(a.max(b)))?;
        Ok(Self { size: display.size_px, places, rings, levels: levels_to(last) })
    }

    fn size(&self) -> [usize; 2] {
        self.size.map(|side| side as usize)
    }

    fn pyramid<'a>(&self, picture: Picture<'a>) -> Result<Pyramid<'a>> {
        picture.check(self.size)?;
        let halvings = self.levels.last().map_or(0, |level| level.halvings);
        Ok(Pyramid::new(picture, self.size(), halvings))
    }

    fn low_pass(&self, pyramid: &Pyramid, tile: &Tile, scratch: &mut Scratch, out: &mut Planes) {
        low_pass(pyramid, &self.levels, &self.places, self.size()[0], tile, scratch, out);
    }

    /// The low-passed picture in linear light: RGB, rows from the top.
    ///
    /// # Errors
    /// [`Error::Setting`] if [`Picture::check`] refuses the picture at the display's size.
    pub fn filter(&self, picture: Picture) -> Result<Vec<f32>> {
        let pyramid = self.pyramid(picture)?;
        let [width, height] = self.size();
        let mut rgb = vec![0.0; 3 * width * height];
        let tiles = Tile::all([width, height]);
        let strips = rgb.par_chunks_mut(3 * width * TILE_PX);
        strips.zip(tiles.par_chunks(width.div_ceil(TILE_PX))).for_each(|(strip, tiles)| {
            let (mut scratch, mut planes) = (Scratch::default(), Planes::default());
            for tile in tiles {
                self.low_pass(&pyramid, tile, &mut scratch, &mut planes);
                let local = Tile { y: 0..tile.y.len(), ..tile.clone() };
                for (at, pixel) in local.rows(width).flatten().enumerate() {
                    for (channel, plane) in planes.iter().enumerate() {
                        strip[3 * pixel + channel] = plane[at];
                    }
                }
            }
        });
        Ok(rgb)
    }

    /// The acuity-surviving error of `b` against the reference `a`.
    ///
    /// # Errors
    /// [`Error::Setting`] if [`Picture::check`] refuses a picture at the display's size.
    pub fn error(&self, a: Picture, b: Picture) -> Result<AcuityError> {
        let pyramids = [self.pyramid(a)?, self.pyramid(b)?];
        let tiles = Tile::all(self.size());
        let sums = |(scratch, planes): &mut (Scratch, [Planes; 2]), tile: &Tile| {
            for (pyramid, planes) in pyramids.iter().zip(planes.iter_mut()) {
                self.low_pass(pyramid, tile, scratch, planes);
            }
            self.sums(tile, planes)
        };
        // Collected and added in order, so that the result does not depend on the number of threads.
        let tiles: Vec<_> = tiles.par_iter().map_init(Default::default, sums).collect();
        let mut whole = Sums::default();
        let mut rings = [Sums::default(); RING_STARTS_DEG.len()];
        for tile in tiles {
            for (ring, sums) in rings.iter_mut().zip(tile) {
                ring.add(sums);
                whole.add(sums);
            }
        }
        let ring = |(index, sums): (usize, &Sums)| AcuityRing {
            from_deg: RING_STARTS_DEG[index],
            to_deg: ring_end_deg(index),
            pixels: sums.pixels,
            rmse: (sums.pixels > 0).then(|| sums.rmse()),
            psnr_db: (sums.pixels > 0).then(|| sums.psnr_db()),
        };
        let rings = rings.iter().enumerate().map(ring).collect();
        Ok(AcuityError { rmse: whole.rmse(), psnr_db: whole.psnr_db(), rings })
    }

    /// What a tile adds to each ring.
    fn sums(&self, tile: &Tile, [a, b]: &[Planes; 2]) -> [Sums; RING_STARTS_DEG.len()] {
        let mut sums = [Sums::default(); RING_STARTS_DEG.len()];
        for (at, pixel) in tile.rows(self.size()[0]).flatten().enumerate() {
            let ring = &mut sums[usize::from(self.rings[pixel])];
            ring.pixels += 1;
            for (a, b) in a.iter().zip(b) {
                ring.squares += f64::from(encode_srgb(a[at]) - encode_srgb(b[at])).powi(2);
            }
        }
        sums
    }
}

/// The acuity-surviving error of `b` against the reference `a`, which fill `display`, around the gaze
/// at `gaze_px`, with the acuity `cutoff_cpd` at an eccentricity in degrees.
///
/// # Errors
/// As [`AcuityLowPass::new`] and [`AcuityLowPass::error`].
pub fn acuity_error(
    a: Picture,
    b: Picture,
    display: &DisplayGeometry,
    gaze_px: DVec2,
    cutoff_cpd: impl Fn(f64) -> f64 + Sync,
) -> Result<AcuityError> {
    AcuityLowPass::new(display, gaze_px, cutoff_cpd)?.error(a, b)
}

/// The root of a display's pixels per square degree at a pixel's centre.
fn pixels_per_degree(display: &DisplayGeometry, column: usize, row: usize) -> f64 {
    let [width, height] = display.size_px.map(f64::from);
    let pixel = (display.tan_right - display.tan_left) / width * (display.tan_up - display.tan_down) / height;
    let secant = display.ray_of_px(DVec2::new(column as f64 + 0.5, row as f64 + 0.5)).length();
    // At a distance of 1 from the eye, a pixel seen under an angle with this secant covers
    // pixel/secant^3 of the sphere.
    (secant.powi(3) / pixel).sqrt() * 1_f64.to_radians()
}

/// What is added up in a ring.
#[derive(Clone, Copy, Default)]
struct Sums {
    pixels: u64,
    squares: f64,
}

impl Sums {
    fn add(&mut self, other: Self) {
        self.pixels += other.pixels;
        self.squares += other.squares;
    }

    fn rmse(&self) -> f64 {
        (self.squares / (3.0 * self.pixels as f64)).sqrt()
    }

    fn psnr_db(&self) -> f64 {
        if self.squares == 0.0 { f64::INFINITY } else { -20.0 * self.rmse().log10() }
    }
}
