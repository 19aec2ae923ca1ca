//! Two pictures compared: PSNR and FLIP, whole and in rings around the gaze.
//!
//! Pictures are RGB, 8 bits each, sRGB-encoded, rows from the top. In every function the first
//! picture is the reference.

use crate::error::{Error, Result};
use crate::fovea::DisplayGeometry;
use glam::DVec2;
use rayon::prelude::*;
use serde::{Serialize, Serializer};

/// Where the rings begin, degrees from the gaze; each ends where the next begins, and the last one
/// does not end.
pub const RING_STARTS_DEG: [f64; 6] = [0.0, 2.0, 5.0, 10.0, 20.0, 40.0];

/// The most pixels that a picture may have: FLIP counts its bytes in 32 bits.
pub(super) const MAX_PIXELS: usize = 1 << 28;

/// The range of pixels per degree in which FLIP's filters have a sensible size.
const PIXELS_PER_DEGREE: std::ops::RangeInclusive<f32> = 0.1..=1000.0;

/// How two pictures differ in one ring of eccentricities.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ring {
    /// The least eccentricity in it, degrees.
    pub from_deg: f64,
    /// Where it ends, degrees, itself outside; infinite for the last ring, written as null.
    #[serde(serialize_with = "finite_or_null")]
    pub to_deg: f64,
    /// Pixels whose centres lie in it.
    pub pixels: u64,
    /// PSNR over them, dB; `None`, written as null, without pixels. Infinite, written as `"inf"`,
    /// where they are all equal.
    #[serde(serialize_with = "number_inf_or_null")]
    pub psnr_db: Option<f64>,
    /// Mean FLIP error over them, 0..=1; `None`, written as null, without pixels.
    pub flip: Option<f64>,
}

/// How two pictures differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// [`psnr_db`] of the whole pictures; infinite, written as `"inf"`, where they are equal.
    #[serde(serialize_with = "number_or_inf")]
    pub psnr_db: f64,
    /// [`flip_mean`] of the whole pictures.
    pub flip: f64,
    /// [`within`] 5 degrees of the gaze; written as in [`Ring::psnr_db`].
    #[serde(serialize_with = "number_inf_or_null")]
    pub psnr_within_5_deg_db: Option<f64>,
    /// The rings that begin at [`RING_STARTS_DEG`].
    pub rings: Vec<Ring>,
}

// Signatures as serde wants them.
#[allow(clippy::trivially_copy_pass_by_ref)]
pub(super) fn finite_or_null<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    value.is_finite().then_some(*value).serialize(serializer)
}

#[allow(clippy::trivially_copy_pass_by_ref)]
pub(super) fn number_or_inf<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if value.is_infinite() { serializer.serialize_str("inf") } else { serializer.serialize_f64(*value) }
}

pub(super) fn number_inf_or_null<S: Serializer>(
    value: &Option<f64>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    match value {
        Some(value) => number_or_inf(value, serializer),
        None => serializer.serialize_none(),
    }
}

/// PSNR of a sum of squared differences of `values` 8 bit values, dB.
fn psnr_of_sum(squares: u64, values: u64) -> f64 {
    if squares == 0 {
        return f64::INFINITY;
    }
    10.0 * (255.0 * 255.0 * values as f64 / squares as f64).log10()
}

/// The sum of the squared differences.
fn squared_difference(a: &[u8], b: &[u8]) -> u64 {
    a.iter().zip(b).map(|(&a, &b)| u64::from(a.abs_diff(b)).pow(2)).sum()
}

/// Checks that two pictures have the same length, at least 1.
fn check_equal_length(a: &[u8], b: &[u8]) -> Result<()> {
    if a.len() == b.len() && !a.is_empty() {
        return Ok(());
    }
    Err(Error::Setting(format!(
        "pictures of {} and {} bytes cannot be compared; both must have the same size, at least one pixel",
        a.len(),
        b.len()
    )))
}

/// Checks that two pictures have `3 * width * height` bytes, at least one pixel.
fn check_sizes(a: &[u8], b: &[u8], [width, height]: [u32; 2]) -> Result<()> {
    let pixels = (width as usize).checked_mul(height as usize).filter(|&pixels| pixels <= MAX_PIXELS);
    let fits = pixels.is_some_and(|pixels| pixels > 0 && a.len() == 3 * pixels && b.len() == 3 * pixels);
    if fits {
        return Ok(());
    }
    Err(Error::Setting(format!(
        "pictures of {} and {} bytes cannot be compared as {width}x{height} RGB; both must have that size",
        a.len(),
        b.len()
    )))
}

/// Peak signal-to-noise ratio of two RGB8 pictures, dB, over all values as they are encoded; peak
/// 255. Infinite where the pictures are equal.
///
/// # Errors
/// [`Error::Setting`] if the pictures differ in length or are empty.
pub fn psnr_db(a: &[u8], b: &[u8]) -> Result<f64> {
    check_equal_length(a, b)?;
    let squares: u64 =
        a.par_chunks(1 << 16).zip(b.par_chunks(1 << 16)).map(|(a, b)| squared_difference(a, b)).sum();
    Ok(psnr_of_sum(squares, a.len() as u64))
}

/// The FLIP error of each pixel, 0..=1, rows from the top (Andersson et al., "FLIP: A Difference
/// Evaluator for Alternating Images", 2020). `size` is width and height; `pixels_per_degree` is the
/// display's resolution as the eye sees it, 0.1..=1000 ([`DisplayGeometry`]'s is
/// [`pixels_per_degree`]).
///
/// # Errors
/// [`Error::Setting`] if a picture is not `3 * width * height` bytes long, is empty or has more than
/// 2^28 pixels, or if `pixels_per_degree` is out of range.
pub fn flip_map(a: &[u8], b: &[u8], size: [u32; 2], pixels_per_degree: f32) -> Result<Vec<f32>> {
    check_sizes(a, b, size)?;
    if !PIXELS_PER_DEGREE.contains(&pixels_per_degree) {
        return Err(Error::Setting(format!(
            "FLIP at {pixels_per_degree} pixels per degree is out of range; it must lie within 0.1..=1000"
        )));
    }
    let [width, height] = size;
    let reference = nv_flip::FlipImageRgb8::with_data(width, height, a);
    let test = nv_flip::FlipImageRgb8::with_data(width, height, b);
    Ok(nv_flip::flip(reference, test, pixels_per_degree).to_vec())
}

/// The mean of [`flip_map`], 0..=1.
///
/// # Errors
/// As there.
pub fn flip_mean(a: &[u8], b: &[u8], size: [u32; 2], pixels_per_degree: f32) -> Result<f64> {
    let map = flip_map(a, b, size, pixels_per_degree)?;
    Ok(map.iter().map(|&error| f64::from(error)).sum::<f64>() / map.len() as f64)
}

/// Pixels per degree at the display's centre: the mean along both axes.
///
/// # Errors
/// As [`DisplayGeometry::check`].
pub fn pixels_per_degree(display: &DisplayGeometry) -> Result<f32> {
    display.check()?;
    let centre = DVec2::new(f64::from(display.size_px[0]), f64::from(display.size_px[1])) / 2.0;
    let ray = |dx: f64, dy: f64| display.ray_of_px(centre + DVec2::new(dx, dy));
    let along_x = ray(-0.5, 0.0).angle_between(ray(0.5, 0.0)).to_degrees();
    let along_y = ray(0.0, -0.5).angle_between(ray(0.0, 0.5)).to_degrees();
    Ok((0.5 / along_x + 0.5 / along_y) as f32)
}

/// The angle between the rays through a pixel's centre and through the gaze, degrees, of every pixel
/// of a row.
pub(super) fn eccentricities(
    display: &DisplayGeometry,
    gaze_px: DVec2,
    row: usize,
) -> impl Iterator<Item = f64> + use<'_> {
    let gaze = display.ray_of_px(gaze_px);
    (0..display.size_px[0]).map(move |column| {
        let ray = display.ray_of_px(DVec2::new(f64::from(column) + 0.5, row as f64 + 0.5));
        // Precise for small angles too, which an arc cosine is not.
        gaze.cross(ray).length().atan2(gaze.dot(ray)).to_degrees()
    })
}

/// The ring that an eccentricity lies in, an index of [`RING_STARTS_DEG`].
pub(super) fn ring_of(eccentricity_deg: f64) -> usize {
    // Angles are at least 0, so at least the first ring has begun.
    RING_STARTS_DEG.iter().rposition(|&start| start <= eccentricity_deg).unwrap_or(0)
}

/// Where a ring ends, degrees; infinite for the last one.
pub(super) fn ring_end_deg(ring: usize) -> f64 {
    RING_STARTS_DEG.get(ring + 1).copied().unwrap_or(f64::INFINITY)
}

/// What is added up in a ring.
#[derive(Clone, Copy, Default)]
struct Sums {
    pixels: u64,
    squares: u64,
    flip: f64,
}

/// Checks what the functions by eccentricity share.
fn check_view(a: &[u8], b: &[u8], display: &DisplayGeometry, gaze_px: DVec2) -> Result<()> {
    display.check()?;
    check_sizes(a, b, display.size_px)?;
    check_gaze(gaze_px)
}

/// Checks that a gaze is a position.
pub(super) fn check_gaze(gaze_px: DVec2) -> Result<()> {
    if !gaze_px.is_finite() {
        return Err(Error::Setting(format!(
            "the gaze at {gaze_px} px is not finite; give a display position"
        )));
    }
    Ok(())
}

/// The rings that begin at [`RING_STARTS_DEG`], of two pictures that fill `display`, around the gaze
/// at `gaze_px` (pixel centres at .5; it may lie outside the display). `flip` holds the pictures'
/// [`flip_map`]: FLIP looks at neighbours, so the pictures are not cut before it.
///
/// # Errors
/// [`Error::Setting`] if sizes do not agree, or display or gaze are out of range.
pub fn rings(
    a: &[u8],
    b: &[u8],
    flip: &[f32],
    display: &DisplayGeometry,
    gaze_px: DVec2,
) -> Result<Vec<Ring>> {
    check_view(a, b, display, gaze_px)?;
    if 3 * flip.len() != a.len() {
        return Err(Error::Setting(format!(
            "a FLIP map of {} pixels does not belong to pictures of {}; both must have the same size",
            flip.len(),
            a.len() / 3
        )));
    }
    let width = display.size_px[0] as usize;
    let row_sums = |row: usize, [a, b]: [&[u8]; 2], flip: &[f32]| {
        let mut sums = [Sums::default(); RING_STARTS_DEG.len()];
        let pixels = a.chunks_exact(3).zip(b.chunks_exact(3)).zip(flip);
        for (((a, b), &flip), angle) in pixels.zip(eccentricities(display, gaze_px, row)) {
            let ring = ring_of(angle);
            sums[ring].pixels += 1;
            sums[ring].squares += squared_difference(a, b);
            sums[ring].flip += f64::from(flip);
        }
        sums
    };
    let lines = a.par_chunks(3 * width).zip(b.par_chunks(3 * width)).zip(flip.par_chunks(width));
    // Collected and added in order, so that the result does not depend on the number of threads.
    let rows: Vec<_> = lines.enumerate().map(|(row, ((a, b), flip))| row_sums(row, [a, b], flip)).collect();
    let ring = |index: usize| {
        let mut sums = Sums::default();
        for row in &rows {
            sums.pixels += row[index].pixels;
            sums.squares += row[index].squares;
            sums.flip += row[index].flip;
        }
        let any = sums.pixels > 0;
        Ring {
            from_deg: RING_STARTS_DEG[index],
            to_deg: ring_end_deg(index),
            pixels: sums.pixels,
            psnr_db: any.then(|| psnr_of_sum(sums.squares, 3 * sums.pixels)),
            flip: any.then(|| sums.flip / sums.pixels as f64),
        }
    };
    Ok((0..RING_STARTS_DEG.len()).map(ring).collect())
}

/// PSNR, dB, over the pixels whose centres lie within `deg` degrees of the gaze (as in [`rings`], at
/// most `deg`); infinite where they are all equal, `None` if there are none.
///
/// # Errors
/// [`Error::Setting`] if sizes do not agree, or display or gaze are out of range.
pub fn within(
    a: &[u8],
    b: &[u8],
    display: &DisplayGeometry,
    gaze_px: DVec2,
    deg: f64,
) -> Result<Option<f64>> {
    check_view(a, b, display, gaze_px)?;
    let width = display.size_px[0] as usize;
    let row_sum = |(row, (a, b)): (usize, (&[u8], &[u8]))| {
        let pixels = a.chunks_exact(3).zip(b.chunks_exact(3)).zip(eccentricities(display, gaze_px, row));
        let inside = pixels.filter(|(_, angle)| *angle <= deg).map(|(pixel, _)| pixel);
        inside.fold((0, 0), |(count, squares), (a, b)| (count + 1, squares + squared_difference(a, b)))
    };
    let (count, squares) = a
        .par_chunks(3 * width)
        .zip(b.par_chunks(3 * width))
        .enumerate()
        .map(row_sum)
        .reduce(|| (0_u64, 0_u64), |a, b| (a.0 + b.0, a.1 + b.1));
    Ok((count > 0).then(|| psnr_of_sum(squares, 3 * count)))
}

/// All of the above of two pictures that fill `display`, with FLIP at the display's own
/// [`pixels_per_degree`].
///
/// # Errors
/// [`Error::Setting`] if sizes do not agree, or display or gaze are out of range.
pub fn compare(a: &[u8], b: &[u8], display: &DisplayGeometry, gaze_px: DVec2) -> Result<Comparison> {
    check_view(a, b, display, gaze_px)?;
    let flip = flip_map(a, b, display.size_px, pixels_per_degree(display)?)?;
    Ok(Comparison {
        psnr_db: psnr_db(a, b)?,
        flip: flip.iter().map(|&error| f64::from(error)).sum::<f64>() / flip.len() as f64,
        psnr_within_5_deg_db: within(a, b, display, gaze_px, 5.0)?,
        rings: rings(a, b, &flip, display, gaze_px)?,
    })
}

/// RGB of RGBA; alpha is dropped. Values after the last whole pixel are ignored.
#[must_use]
pub fn rgb_of_rgba<T: Copy>(rgba: &[T]) -> Vec<T> {
    rgba.as_chunks::<4>().0.iter().flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn display() -> DisplayGeometry {
        DisplayGeometry::symmetric([160, 90], 100.0)
    }

    fn noise(length: usize) -> Vec<u8> {
        let mut state = 99_u32;
        let next = |_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8 / 2
        };
        (0..length).map(next).collect()
    }

    #[test]
    fn constant_offset_has_the_psnr_of_its_square() {
        let a = noise(3 * 64 * 64);
        for offset in [1_u8, 7, 100] {
            let b: Vec<u8> = a.iter().map(|value| value + offset).collect();
            let expected = 20.0 * (255.0 / f64::from(offset)).log10();
            assert!((psnr_db(&a, &b).unwrap() - expected).abs() < 1e-9);
            assert!((psnr_db(&b, &a).unwrap() - expected).abs() < 1e-9);
        }
        assert_eq!(psnr_db(&[0; 3], &[255; 3]).unwrap(), 0.0);
    }

    #[test]
    fn equal_pictures_are_equal() {
        let display = display();
        let a = noise(3 * 160 * 90);
        let same = compare(&a, &a, &display, DVec2::new(80.0, 45.0)).unwrap();
        assert_eq!((same.psnr_db, same.flip), (f64::INFINITY, 0.0));
        assert_eq!(same.psnr_within_5_deg_db, Some(f64::INFINITY));
        for ring in &same.rings {
            assert_eq!((ring.psnr_db, ring.flip), (Some(f64::INFINITY), Some(0.0)));
        }
        assert_eq!(psnr_db(&a, &a).unwrap(), f64::INFINITY);
        assert!(flip_map(&a, &a, [160, 90], 30.0).unwrap().iter().all(|&error| error == 0.0));
    }

    #[test]
    fn flip_of_black_and_white_is_large() {
        let (black, white) = ([0_u8; 3 * 32 * 32], [255_u8; 3 * 32 * 32]);
        let mean = flip_mean(&black, &white, [32, 32], 67.0).unwrap();
        assert!(mean > 0.9 && mean <= 1.0, "{mean}");
        assert!(flip_mean(&[9; 3], &[9; 3], [1, 1], 67.0).unwrap() == 0.0);
    }

    #[test]
    fn ring_counts_agree_with_every_pixel_counted() {
        let a = noise(3 * 160 * 90);
        let lopsided = DisplayGeometry { tan_left: -0.4, tan_right: 1.4, tan_up: 0.6, ..display() };
        for display in [display(), lopsided] {
            for gaze in [DVec2::new(80.0, 45.0), DVec2::new(3.2, 80.9), DVec2::new(-40.0, 200.0)] {
                let rings = rings(&a, &a, &[0.0; 160 * 90], &display, gaze).unwrap();
                let mut counts = [0_u64; 6];
                let mut inside = 0;
                for y in 0..90 {
                    for x in 0..160 {
                        let ray = display.ray_of_px(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
                        let cos = ray.normalize().dot(display.ray_of_px(gaze).normalize());
                        let angle = cos.min(1.0).acos().to_degrees();
                        counts[match angle {
                            a if a < 2.0 => 0,
                            a if a < 5.0 => 1,
                            a if a < 10.0 => 2,
                            a if a < 20.0 => 3,
                            a if a < 40.0 => 4,
                            _ => 5,
                        }] += 1;
                        inside += u64::from(angle <= 5.0);
                    }
                }
                assert_eq!(rings.iter().map(|ring| ring.pixels).collect::<Vec<_>>(), counts);
                assert_eq!(within(&a, &a, &display, gaze, 5.0).unwrap().is_some(), inside > 0);
                for ring in rings {
                    assert_eq!(
                        (ring.psnr_db.is_some(), ring.flip.is_some()),
                        (ring.pixels > 0, ring.pixels > 0)
                    );
                }
            }
        }
    }

    #[test]
    fn a_change_outside_ten_degrees_stays_outside() {
        let display = display();
        let gaze = DVec2::new(70.0, 40.0);
        let a = noise(3 * 160 * 90);
        let mut b = a.clone();
        let mut map = vec![0.0; 160 * 90];
        for row in 0..90 {
            for (column, angle) in eccentricities(&display, gaze, row).enumerate() {
                if angle >= 10.0 {
                    let pixel = row * 160 + column;
                    b[3 * pixel..3 * pixel + 3].iter_mut().for_each(|value| *value += 10);
                    map[pixel] = 0.25;
                }
            }
        }
        let offset_of_10 = 20.0 * 25.5_f64.log10();
        for ring in rings(&a, &b, &map, &display, gaze).unwrap() {
            assert!(ring.pixels > 0);
            let psnr = ring.psnr_db.unwrap();
            if ring.from_deg < 10.0 {
                assert_eq!((psnr, ring.flip), (f64::INFINITY, Some(0.0)));
            } else {
                assert!((psnr - offset_of_10).abs() < 1e-9 && ring.flip == Some(0.25));
            }
        }
        assert_eq!(within(&a, &b, &display, gaze, 9.9).unwrap(), Some(f64::INFINITY));
        assert!(within(&a, &b, &display, gaze, 90.0).unwrap().unwrap().is_finite());
        assert!(within(&a, &b, &display, DVec2::new(1e5, 0.0), 1.0).unwrap().is_none());
        let whole = compare(&a, &b, &display, gaze).unwrap();
        assert!(whole.flip > 0.0 && whole.rings[5].flip > whole.rings[0].flip);
    }

    #[test]
    fn results_are_written_as_documented() {
        let rings = |psnr_db, flip, to_deg| Ring { from_deg: 40.0, to_deg, pixels: 0, psnr_db, flip };
        let text = serde_json::to_string(&[
            rings(None, None, f64::INFINITY),
            rings(Some(f64::INFINITY), Some(0.0), 50.0),
            rings(Some(30.5), Some(0.5), 50.0),
        ]);
        assert_eq!(
            text.unwrap(),
            "[{\"from_deg\":40.0,\"to_deg\":null,\"pixels\":0,\"psnr_db\":null,\"flip\":null},\
             {\"from_deg\":40.0,\"to_deg\":50.0,\"pixels\":0,\"psnr_db\":\"inf\",\"flip\":0.0},\
             {\"from_deg\":40.0,\"to_deg\":50.0,\"pixels\":0,\"psnr_db\":30.5,\"flip\":0.5}]"
        );
    }

    #[test]
    fn what_does_not_fit_is_refused_in_one_line() {
        let display = display();
        let a = noise(3 * 160 * 90);
        let gaze = DVec2::new(80.0, 45.0);
        let errors = [
            psnr_db(&a, &a[3..]).unwrap_err(),
            psnr_db(&[], &[]).unwrap_err(),
            flip_map(&a, &a[3..], [160, 90], 60.0).unwrap_err(),
            flip_map(&a, &a, [90, 161], 60.0).unwrap_err(),
            flip_map(&a, &a, [u32::MAX, u32::MAX], 60.0).unwrap_err(),
            flip_map(&a, &a, [160, 90], f32::NAN).unwrap_err(),
            flip_map(&a, &a, [160, 90], 0.0).unwrap_err(),
            compare(&a, &a[..3], &display, gaze).unwrap_err(),
            compare(&a, &a, &display, DVec2::NAN).unwrap_err(),
            rings(&a, &a, &[0.0], &display, gaze).unwrap_err(),
        ];
        for error in errors {
            assert!(matches!(error, Error::Setting(_)) && !error.to_string().contains('\n'), "{error}");
        }
    }

    #[test]
    fn pixels_per_degree_of_a_plain_display() {
        // At the centre a pixel spans 2 tan(50 deg) / 160 radians along both axes.
        let expected = 160.0 / (2.0 * 50.0_f64.to_radians().tan()) * 1.0_f64.to_radians();
        let got = f64::from(pixels_per_degree(&display()).unwrap());
        assert!((got - expected).abs() < 1e-3 * expected, "{got}, not {expected}");
    }

    #[test]
    fn alpha_is_dropped() {
        assert_eq!(rgb_of_rgba(&[1, 2, 3, 4, 5, 6, 7, 8, 9]), [1, 2, 3, 5, 6, 7]);
    }
}
