//! Pictures that are computed from others.

use macula::settings::ToneMap;

/// Where nothing was shaded: dark grey, which no shadow is taken for.
const NOT_SHADED: [u8; 4] = [36, 36, 40, 255];

/// The LP-buffer for looking at: tone-mapped like the picture, dark grey where nothing was shaded.
pub fn lp_picture(linear: &[f32], tone_map: ToneMap, exposure: f32) -> Vec<u8> {
    let texels = linear.chunks_exact(4);
    texels
        .flat_map(|texel| {
            if texel[3] <= 0.0 {
                return NOT_SHADED;
            }
            let [red, green, blue] = [texel[0], texel[1], texel[2]].map(|value| {
                let value = (value * exposure).max(0.0);
                srgb(match tone_map {
                    ToneMap::None => value,
                    ToneMap::Aces => aces(value),
                })
            });
            [red, green, blue, 255]
        })
        .collect()
}

/// The absolute difference of two pictures times 4, alpha 255.
pub fn difference_times_4(a: &[u8], b: &[u8]) -> Vec<u8> {
    let texels = a.chunks_exact(4).zip(b.chunks_exact(4));
    texels
        .flat_map(|(a, b)| {
            let of = |channel: usize| a[channel].abs_diff(b[channel]).saturating_mul(4);
            [of(0), of(1), of(2), 255]
        })
        .collect()
}

/// The curve of the output pass: the rational fit by K. Narkowicz (2015).
fn aces(value: f32) -> f32 {
    // Far above this the curve is flat, and infinity would become NaN.
    let value = value.min(1e6);
    value * (2.51 * value + 0.03) / (value * (2.43 * value + 0.59) + 0.14)
}

fn srgb(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let encoded = if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_shaded_is_dark_grey() {
        let picture = lp_picture(&[1.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.5, 1.0], ToneMap::None, 1.0);
        assert_eq!(picture, [36, 36, 40, 255, 255, 0, 188, 255]);
    }

    #[test]
    fn the_curve_rises_and_stays_in_range() {
        let texels = [0.0, 0.01, 0.2, 1.0, 50.0, f32::INFINITY].map(|value| [value, value, value, 1.0]);
        let picture = lp_picture(texels.as_flattened(), ToneMap::Aces, 1.0);
        let reds = picture.chunks_exact(4).map(|texel| texel[0]).collect::<Vec<_>>();
        assert!(reds.is_sorted() && reds[0] == 0 && reds[5] == 255, "{reds:?}");
    }

    #[test]
    fn exposure_acts_before_the_curve() {
        // The published fit at 0.5 is 0.6163, in sRGB 206.
        let picture = lp_picture(&[0.25, 0.25, 0.25, 1.0], ToneMap::Aces, 2.0);
        assert_eq!(picture, [206, 206, 206, 255]);
    }

    #[test]
    fn differences_are_absolute_and_saturate() {
        let difference = difference_times_4(&[10, 200, 0, 255], &[13, 0, 0, 255]);
        assert_eq!(difference, [12, 255, 0, 255]);
    }
}
