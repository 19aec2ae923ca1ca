//! How much a sequence of pictures changes, by eccentricity: temporal variance and flicker.
//!
//! Both are of the **encoded luminance**: linear Rec.709 luminance through the sRGB curve, 0 to 1. The
//! curve is near the eye's lightness scale, so that a change counts alike in dark and bright places;
//! of linear light, highlights would drown all the rest, of radiance before the tone mapping even what
//! the display clips. Luminance without colour, because flicker beyond a few hertz is seen in it
//! alone. Give pictures as they are shown, after the tone mapping.
//!
//! *Variance* is that of each pixel over all frames, with `n - 1` in the denominator. A slow move of the
//! camera has variance of its own, which grows with the sequence's length. *Flicker* is the mean square of
//! the change from each frame to the next: a slow move adds little to it. Noise that is new in each
//! frame has twice its variance as flicker. Both mean something beside those of a reference: see
//! [`ratio`].

use super::compare::{
    MAX_PIXELS, RING_STARTS_DEG, check_gaze, eccentricities, finite_or_null, number_inf_or_null,
    ring_end_deg, ring_of,
};
use super::picture::{Picture, encode_srgb, luminance};
use crate::error::{Error, Result};
use crate::fovea::DisplayGeometry;
use glam::DVec2;
use rayon::prelude::*;
use serde::Serialize;

/// Change over time in one ring of eccentricities.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RingVariance {
    /// The least eccentricity in it, degrees.
    pub from_deg: f64,
    /// Where it ends, degrees, itself outside; infinite for the last ring, written as null.
    #[serde(serialize_with = "finite_or_null")]
    pub to_deg: f64,
    /// Pixels whose centres lie in it.
    pub pixels: u64,
    /// Mean over them of the temporal variance; `None`, written as null, without pixels or with fewer
    /// than two frames.
    pub variance: Option<f64>,
    /// Mean over them of the squared change from frame to frame; `None` as for the variance.
    pub flicker: Option<f64>,
}

/// One sequence's change over time as a multiple of another's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RingRatio {
    /// The least eccentricity in the ring, degrees.
    pub from_deg: f64,
    /// Where it ends, degrees, itself outside; infinite for the last ring, written as null.
    #[serde(serialize_with = "finite_or_null")]
    pub to_deg: f64,
    /// Of the variances: 1 where both are 0; infinite, written as `"inf"`, where only the reference's
    /// is; `None`, written as null, where one is missing.
    #[serde(serialize_with = "number_inf_or_null")]
    pub variance: Option<f64>,
    /// Of the flicker, in the same way.
    #[serde(serialize_with = "number_inf_or_null")]
    pub flicker: Option<f64>,
}

/// Adds up a sequence's change over time, frame by frame; 16 bytes a pixel, whatever its length.
///
/// Welford's recurrence in single precision: both results are within 1e-4 of their value for
/// sequences of up to 2000 frames.
pub struct TemporalVariance {
    size: [u32; 2],
    frames: u32,
    pixels: Vec<Pixel>,
}

#[derive(Clone, Copy, Default)]
struct Pixel {
    mean: f32,
    /// Sum of the squared distances from the mean.
    squares: f32,
    last: f32,
    /// Sum of the squared changes.
    changes: f32,
}

impl Pixel {
    fn add(&mut self, value: f32, frames: f32) {
        if frames == 1.0 {
            *self = Self { mean: value, last: value, ..Self::default() };
            return;
        }
        let distance = value - self.mean;
        self.mean += distance / frames;
        self.squares += distance * (value - self.mean);
        let change = value - self.last;
        self.changes += change * change;
        self.last = value;
    }
}

impl TemporalVariance {
    /// For frames of a size, px.
    ///
    /// # Errors
    /// [`Error::Setting`] for a size of 0 or more than 2^28 pixels.
    pub fn new(size: [u32; 2]) -> Result<Self> {
        let [width, height] = size.map(|side| side as usize);
        let fits = |pixels: &usize| (1..=MAX_PIXELS).contains(pixels);
        let Some(pixels) = width.checked_mul(height).filter(fits) else {
            return Err(Error::Setting(format!(
                "a sequence of {width}x{height} px cannot be judged; frames must have 1 to {MAX_PIXELS} pixels"
            )));
        };
        Ok(Self { size, frames: 0, pixels: vec![Pixel::default(); pixels] })
    }

    /// Frames so far.
    #[must_use]
    pub fn frames(&self) -> u32 {
        self.frames
    }

    /// Adds the next frame.
    ///
    /// # Errors
    /// [`Error::Setting`] if [`Picture::check`] refuses it at the sequence's size; it then counts for
    /// nothing.
    pub fn add(&mut self, frame: Picture) -> Result<()> {
        const CHUNK: usize = 1 << 14;
        frame.check(self.size)?;
        self.frames = self.frames.saturating_add(1);
        let frames = self.frames as f32;
        self.pixels.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, pixels)| {
            for (at, pixel) in pixels.iter_mut().enumerate() {
                let light = frame.linear(chunk * CHUNK + at);
                pixel.add(encode_srgb(luminance(light)), frames);
            }
        });
        Ok(())
    }

    /// The rings that begin at [`RING_STARTS_DEG`], of frames that fill `display`, around a gaze that
    /// stayed at `gaze_px` (pixel centres at .5; it may lie outside the display). A gaze path takes one
    /// accumulator for each fixation.
    ///
    /// # Errors
    /// [`Error::Setting`] if display or gaze are out of range, or the display has another size.
    pub fn rings(&self, display: &DisplayGeometry, gaze_px: DVec2) -> Result<Vec<RingVariance>> {
        display.check()?;
        check_gaze(gaze_px)?;
        if display.size_px != self.size {
            let ([width, height], [other_width, other_height]) = (self.size, display.size_px);
            return Err(Error::Setting(format!(
                "a sequence of {width}x{height} px does not fill a display of {other_width}x{other_height} \
                 px; both must have the same size"
            )));
        }
        let row_sums = |(row, pixels): (usize, &[Pixel])| {
            let mut sums = [(0_u64, 0.0, 0.0); RING_STARTS_DEG.len()];
            for (pixel, angle) in pixels.iter().zip(eccentricities(display, gaze_px, row)) {
                let (count, squares, changes) = &mut sums[ring_of(angle)];
                *count += 1;
                *squares += f64::from(pixel.squares);
                *changes += f64::from(pixel.changes);
            }
            sums
        };
        let rows = self.pixels.par_chunks(self.size[0] as usize).enumerate();
        // Collected and added in order, so that the result does not depend on the number of threads.
        let rows: Vec<_> = rows.map(row_sums).collect();
        let steps = f64::from(self.frames.saturating_sub(1));
        let ring = |index: usize| {
            let add = |a: (u64, f64, f64), b: (u64, f64, f64)| (a.0 + b.0, a.1 + b.1, a.2 + b.2);
            let (pixels, squares, changes) = rows.iter().map(|row| row[index]).fold((0, 0.0, 0.0), add);
            let mean = |sum: f64| (pixels > 0 && steps > 0.0).then(|| sum / (pixels as f64 * steps));
            RingVariance {
                from_deg: RING_STARTS_DEG[index],
                to_deg: ring_end_deg(index),
                pixels,
                variance: mean(squares),
                flicker: mean(changes),
            }
        };
        Ok((0..RING_STARTS_DEG.len()).map(ring).collect())
    }
}

/// Change over time per ring, as a multiple of the reference's.
///
/// # Errors
/// [`Error::Setting`] if the rings are not the same.
pub fn ratio(rings: &[RingVariance], reference: &[RingVariance]) -> Result<Vec<RingRatio>> {
    let bounds = |ring: &RingVariance| (ring.from_deg, ring.to_deg, ring.pixels);
    if !rings.iter().map(bounds).eq(reference.iter().map(bounds)) {
        return Err(Error::Setting(
            "sequences of different rings cannot be compared; both must have the same display and gaze"
                .into(),
        ));
    }
    let quotient = |value: Option<f64>, reference: Option<f64>| match (value?, reference?) {
        (0.0, 0.0) => Some(1.0),
        (value, reference) => Some(value / reference),
    };
    let pair = |(ring, reference): (&RingVariance, &RingVariance)| RingRatio {
        from_deg: ring.from_deg,
        to_deg: ring.to_deg,
        variance: quotient(ring.variance, reference.variance),
        flicker: quotient(ring.flicker, reference.flicker),
    };
    Ok(rings.iter().zip(reference).map(pair).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const SIZE: [u32; 2] = [64, 36];

    fn display() -> DisplayGeometry {
        DisplayGeometry::symmetric(SIZE, 60.0)
    }

    /// Linear light of a grey whose encoded value is given.
    fn light(encoded: f64) -> f32 {
        ((encoded + 0.055) / 1.055).powf(2.4) as f32
    }

    /// Rings of a sequence whose pixels have an encoded value by frame and index.
    fn rings(frames: usize, value: impl Fn(usize, usize) -> f64) -> Vec<RingVariance> {
        let mut sum = TemporalVariance::new(SIZE).unwrap();
        for frame in 0..frames {
            let picture: Vec<f32> = (0..64 * 36).flat_map(|at| [light(value(frame, at)); 3]).collect();
            sum.add(Picture::Linear(&picture)).unwrap();
        }
        assert_eq!(sum.frames() as usize, frames);
        sum.rings(&display(), DVec2::new(20.0, 18.0)).unwrap()
    }

    fn check(ring: &RingVariance, variance: f64, flicker: f64) {
        if ring.pixels == 0 {
            assert_eq!((ring.variance, ring.flicker), (None, None));
            return;
        }
        let close = |found: Option<f64>, expected: f64| (found.unwrap() / expected - 1.0).abs() < 1e-4;
        assert!(close(ring.variance, variance) && close(ring.flicker, flicker), "{ring:?}");
    }

    #[test]
    fn still_pictures_have_no_variance() {
        for ring in rings(9, |_, at| 0.1 + 0.8 * (at % 17) as f64 / 17.0) {
            assert!(ring.pixels == 0 || (ring.variance, ring.flicker) == (Some(0.0), Some(0.0)));
        }
    }

    #[test]
    fn a_sine_has_half_its_squared_amplitude() {
        // 16 frames a cycle: variance a^2/2 n/(n - 1), change per step 2 a sin(pi/16) times a sine.
        let (amplitude, frames) = (0.05, 2000);
        let found = rings(frames, |frame, at| 0.5 + amplitude * (TAU * (frame + at) as f64 / 16.0).sin());
        let variance = amplitude * amplitude / 2.0 * frames as f64 / (frames - 1) as f64;
        let change = 2.0 * amplitude * (TAU / 32.0).sin();
        for ring in &found[..5] {
            assert!(ring.pixels > 0);
            // The phases of a ring's pixels do not even out wholly over 1999 steps.
            let flicker = ring.flicker.unwrap() / (change * change / 2.0);
            assert!((flicker - 1.0).abs() < 1e-3, "{flicker}");
            check(ring, variance, ring.flicker.unwrap());
        }
    }

    #[test]
    fn a_ramp_has_much_variance_and_little_flicker() {
        // Of 0, 1 .. n - 1 the variance is n (n + 1)/12.
        let (step, frames) = (0.002, 101);
        for ring in rings(frames, |frame, _| 0.3 + step * frame as f64) {
            check(&ring, step * step * 101.0 * 102.0 / 12.0, step * step);
        }
        for ring in rings(100, |frame, _| 0.3 + 0.002 * (frame % 2) as f64) {
            check(&ring, 0.001 * 0.001 * 100.0 / 99.0, 0.002 * 0.002);
        }
    }

    #[test]
    fn change_is_found_in_its_ring_only() {
        let display = display();
        let gaze = DVec2::new(20.0, 18.0);
        let outside = |at: usize| {
            let px = DVec2::new((at % 64) as f64 + 0.5, (at / 64) as f64 + 0.5);
            display.eccentricity_rad(gaze, px).to_degrees() >= 10.0
        };
        let blinking =
            |high: f64| rings(2, move |frame, at| 0.4 + high * f64::from(frame == 1 && outside(at)));
        let (a, b) = (blinking(0.02), blinking(0.01));
        let ratios = ratio(&a, &b).unwrap();
        for (ring, ratio) in a.iter().zip(&ratios) {
            if ring.pixels == 0 {
                assert_eq!((ratio.variance, ratio.flicker), (None, None));
            } else if ring.from_deg < 10.0 {
                assert_eq!((ring.variance, ratio.variance, ratio.flicker), (Some(0.0), Some(1.0), Some(1.0)));
            } else {
                // The variance of two values is half of their squared distance.
                check(ring, 0.0002, 0.0004);
                assert!((ratio.variance.unwrap() - 4.0).abs() < 1e-3);
                assert!((ratio.flicker.unwrap() - 4.0).abs() < 1e-3);
            }
        }
        assert!(ratios[2].variance.is_some() && ratios[3].variance.is_some());
        let still = rings(2, |_, _| 0.4);
        assert_eq!(ratio(&a, &still).unwrap()[3].variance, Some(f64::INFINITY));
        assert_eq!(ratio(&still, &a).unwrap()[3].variance, Some(0.0));
    }

    #[test]
    fn bytes_are_taken_as_they_are_shown() {
        let mut sum = TemporalVariance::new([1, 1]).unwrap();
        sum.add(Picture::Srgb8(&[100; 3])).unwrap();
        let display = DisplayGeometry::symmetric([1, 1], 10.0);
        let first = |sum: &TemporalVariance| sum.rings(&display, DVec2::new(0.5, 0.5)).unwrap()[0];
        assert_eq!((first(&sum).pixels, first(&sum).variance), (1, None));
        sum.add(Picture::Srgb8(&[110; 3])).unwrap();
        let step = (10.0_f64 / 255.0).powi(2);
        check(&first(&sum), step / 2.0, step);
    }

    #[test]
    fn what_does_not_fit_is_refused_in_one_line() {
        let mut sum = TemporalVariance::new(SIZE).unwrap();
        let found = rings(2, |_, _| 0.5);
        let other = DisplayGeometry::symmetric([36, 64], 60.0);
        let errors = [
            TemporalVariance::new([0, 4]).err().unwrap(),
            TemporalVariance::new([u32::MAX; 2]).err().unwrap(),
            sum.add(Picture::Srgb8(&[0; 3])).unwrap_err(),
            sum.add(Picture::Linear(&[f32::NAN; 3 * 64 * 36])).unwrap_err(),
            sum.rings(&other, DVec2::ZERO).unwrap_err(),
            sum.rings(&display(), DVec2::NAN).unwrap_err(),
            ratio(&found, &found[1..]).unwrap_err(),
        ];
        for error in errors {
            assert!(matches!(error, Error::Setting(_)) && !error.to_string().contains('\n'), "{error}");
        }
        assert_eq!(sum.frames(), 0);
    }

    #[test]
    fn ratios_are_written_as_documented() {
        let ratio = RingRatio {
            from_deg: 40.0,
            to_deg: f64::INFINITY,
            variance: Some(f64::INFINITY),
            flicker: Some(1.5),
        };
        assert_eq!(
            serde_json::to_string(&ratio).unwrap(),
            "{\"from_deg\":40.0,\"to_deg\":null,\"variance\":\"inf\",\"flicker\":1.5}"
        );
    }
}
