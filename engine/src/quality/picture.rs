//! Pictures as the metrics take them, and the display's encoding.

use super::compare::MAX_PIXELS;
use crate::error::{Error, Result};
use std::sync::LazyLock;

/// The most light that a linear picture's value may stand for, either sign. It is far above what
/// half floats hold, and low enough that no sum of the metrics overflows.
pub const MAX_LIGHT: f32 = 1e9;

/// A picture: RGB with Rec.709 primaries, three values a pixel, rows from the top.
#[derive(Clone, Copy, Debug)]
pub enum Picture<'a> {
    /// 8 bits each, sRGB-encoded.
    Srgb8(&'a [u8]),
    /// Linear light; 1 is the display's white. Values are finite and at most [`MAX_LIGHT`].
    Linear(&'a [f32]),
}

impl Picture<'_> {
    /// Checks that a picture has a size (px), at least one pixel and at most 2^28, and that linear
    /// values are in range.
    ///
    /// # Errors
    /// [`Error::Setting`] otherwise.
    pub fn check(&self, [width, height]: [u32; 2]) -> Result<()> {
        let values = match self {
            Self::Srgb8(bytes) => bytes.len(),
            Self::Linear(values) => values.len(),
        };
        let pixels = (width as usize).checked_mul(height as usize).filter(|&pixels| pixels <= MAX_PIXELS);
        if !pixels.is_some_and(|pixels| pixels > 0 && values == 3 * pixels) {
            return Err(Error::Setting(format!(
                "a picture of {values} values cannot be taken as {width}x{height} RGB; it must have that size"
            )));
        }
        let Self::Linear(values) = self else { return Ok(()) };
        let outside = |value: &f32| !(-MAX_LIGHT..=MAX_LIGHT).contains(value);
        let Some(at) = values.iter().position(outside) else { return Ok(()) };
        let (x, y) = (at / 3 % width as usize, at / 3 / width as usize);
        Err(Error::Setting(format!(
            "the picture's pixel ({x}, {y}) has the value {}; linear light must lie within +-{MAX_LIGHT:e}",
            values[at]
        )))
    }

    /// A pixel's linear light, by its index.
    pub(super) fn linear(&self, pixel: usize) -> [f32; 3] {
        match self {
            Self::Srgb8(bytes) => decoded(&DECODED, bytes, pixel),
            Self::Linear(values) => [values[3 * pixel], values[3 * pixel + 1], values[3 * pixel + 2]],
        }
    }
}

fn decoded(table: &[f32; 256], bytes: &[u8], pixel: usize) -> [f32; 3] {
    let value = |channel| table[usize::from(bytes[3 * pixel + channel])];
    [value(0), value(1), value(2)]
}

/// Linear light of each sRGB byte.
static DECODED: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|byte| {
        let value = byte as f64 / 255.0;
        let linear = if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) };
        linear as f32
    })
});

/// The sRGB encoding of linear light (IEC 61966-2-1), 0 to 1 for 0 to 1. Beyond white the curve goes
/// on, and below black its straight part does, so that no difference is lost.
#[must_use]
pub fn encode_srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Relative luminance of linear Rec.709 light (ITU-R BT.709).
#[must_use]
pub fn luminance([red, green, blue]: [f32; 3]) -> f32 {
    0.2126 * red + 0.7152 * green + 0.0722 * blue
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_decode_and_encode_to_themselves() {
        let bytes: Vec<u8> = (0..=255).flat_map(|byte| [byte; 3]).collect();
        for pixel in 0..256 {
            let linear = Picture::Srgb8(&bytes).linear(pixel);
            for value in linear {
                assert!((encode_srgb(value) * 255.0 - pixel as f32).abs() < 1e-3, "{pixel}: {value}");
            }
        }
        // Mid grey of the standard's own table: 0.5 encoded is 0.2140 linear.
        assert!((encode_srgb(0.214_041_14) - 0.5).abs() < 1e-6);
        assert!((encode_srgb(1.0) - 1.0).abs() < 1e-6);
        assert_eq!(encode_srgb(-0.01), -0.1292);
        assert!(encode_srgb(MAX_LIGHT).is_finite());
    }

    #[test]
    fn white_has_luminance_one() {
        assert!((luminance([1.0; 3]) - 1.0).abs() < 1e-6);
        assert_eq!(luminance([0.0, 1.0, 0.0]), 0.7152);
    }

    #[test]
    fn what_is_no_picture_is_refused_in_one_line() {
        let values = [0.5, 0.5, 0.5, 0.5, f32::NAN, 0.5];
        let infinite = [f32::INFINITY; 3];
        let errors = [
            Picture::Linear(&values).check([2, 1]).unwrap_err(),
            Picture::Linear(&infinite).check([1, 1]).unwrap_err(),
            Picture::Linear(&values).check([1, 1]).unwrap_err(),
            Picture::Srgb8(&[]).check([0, 0]).unwrap_err(),
            Picture::Srgb8(&[0; 3]).check([u32::MAX, u32::MAX]).unwrap_err(),
        ];
        assert!(errors[0].to_string().contains("(1, 0)"), "{}", errors[0]);
        for error in errors {
            assert!(matches!(error, Error::Setting(_)) && !error.to_string().contains('\n'), "{error}");
        }
        Picture::Linear(&values[..3]).check([1, 1]).unwrap();
        Picture::Srgb8(&[0; 6]).check([1, 2]).unwrap();
    }
}
