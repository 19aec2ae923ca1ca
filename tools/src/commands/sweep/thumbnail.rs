//! Small pictures for the report.

use crate::failure::Failure;
use image::codecs::jpeg::JpegEncoder;
use image::imageops::{FilterType, resize};
use image::{DynamicImage, RgbaImage};

/// Wide enough to see what a setting does, small enough that a report of a hundred settings opens.
const WIDTH_PX: u32 = 560;
const QUALITY: u8 = 82;

/// A JPEG of an RGBA picture, at most 560 px wide.
///
/// # Errors
/// A picture that JPEG cannot hold.
pub fn thumbnail(rgba: &[u8], [width, height]: [u32; 2]) -> Result<Vec<u8>, Failure> {
    let told = |what: String| Failure::environment(format!("a picture of {width}x{height} px: {what}"));
    let fits = rgba.len() as u64 == 4 * u64::from(width) * u64::from(height);
    let picture = RgbaImage::from_raw(width, height, rgba.to_vec()).filter(|_| fits);
    let picture = picture.ok_or_else(|| told("it has another number of pixels".into()))?;
    let small = if width > WIDTH_PX {
        let high = (f64::from(height) * f64::from(WIDTH_PX) / f64::from(width)).round().max(1.0) as u32;
        resize(&picture, WIDTH_PX, high, FilterType::Triangle)
    } else {
        picture
    };
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, QUALITY);
    DynamicImage::from(small)
        .into_rgb8()
        .write_with_encoder(encoder)
        .map_err(|error| told(error.to_string()))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thumbnails_keep_their_shape_and_their_light() {
        let rgba: Vec<u8> = std::iter::repeat_n([200, 100, 50, 255], 1120 * 64).flatten().collect();
        let bytes = thumbnail(&rgba, [1120, 64]).unwrap();
        let read = image::load_from_memory(&bytes).unwrap().into_rgb8();
        assert_eq!(read.dimensions(), (560, 32));
        let middle = read.get_pixel(280, 16).0;
        assert!(middle.iter().zip([200_u8, 100, 50]).all(|(a, b)| a.abs_diff(b) < 4), "{middle:?}");
        assert!(thumbnail(&rgba, [3, 3]).is_err());
    }
}
