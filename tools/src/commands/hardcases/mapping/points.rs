//! Display positions at which mappings are looked at.

use super::super::random::Random;
use glam::DVec2;
use macula::fovea::{DisplayGeometry, Mapping, TexelJacobian};

/// Displays up to so many pixels are looked at pixel by pixel.
const FEW_PIXELS: u32 = 400;

/// Pixels drawn at random on the others: enough for every ring about the gaze to be met in some case.
const DRAWN: u32 = 64;

/// Pixel centres: all of a small display; of others the corners, the neighbourhood of the gaze, its row
/// (where v begins and ends), rings about it, and some at random.
pub fn pixel_centres(display: &DisplayGeometry, gaze_px: DVec2, random: &mut Random) -> Vec<DVec2> {
    let [width, height] = display.size_px;
    if u64::from(width) * u64::from(height) <= u64::from(FEW_PIXELS) {
        let pixel = |index: u32| DVec2::new(f64::from(index % width), f64::from(index / width)) + 0.5;
        return (0..width * height).map(pixel).collect();
    }
    let last = DVec2::new(f64::from(width), f64::from(height)) - 1.0;
    let mut pixels = vec![DVec2::ZERO, last, DVec2::new(last.x, 0.0), DVec2::new(0.0, last.y)];
    let near = gaze_px.floor().clamp(DVec2::ZERO, last);
    for index in 0..25 {
        pixels.push(near + DVec2::new(f64::from(index % 5), f64::from(index / 5)) - 2.0);
    }
    for step in 0..24 {
        let reach = 1.5 * (last.x / 1.5).powf(f64::from(step) / 23.0);
        pixels.extend([near + DVec2::X * reach, near - DVec2::X * reach, near + DVec2::new(reach, -1.0)]);
        pixels.push(near + DVec2::from_angle(2.4 * f64::from(step)) * reach);
    }
    pixels.extend(
        (0..DRAWN).map(|_| DVec2::new(f64::from(random.below(width)), f64::from(random.below(height)))),
    );
    pixels.retain(|px| px.cmpge(DVec2::ZERO).all() && px.cmplt(last + 1.0).all());
    pixels.into_iter().map(|px| px.floor() + 0.5).collect()
}

/// The greatest extent of a texel on the display, px: the reciprocal of the Jacobian's least singular value.
/// `None` where a texel has no bounds.
pub fn texel_extent_px(jacobian: &TexelJacobian) -> Option<f64> {
    let determinant = jacobian.density_per_px2();
    let TexelJacobian { du_dx, du_dy, dv_dx, dv_dy } = *jacobian;
    // Of a 2x2 matrix: the singular values' sum and difference, squared, are |J|^2 + 2 det and |J|^2 - 2 det.
    let squares = du_dx * du_dx + du_dy * du_dy + dv_dx * dv_dx + dv_dy * dv_dy;
    let greatest =
        ((squares + 2.0 * determinant).sqrt() + (squares - 2.0 * determinant).max(0.0).sqrt()) / 2.0;
    let extent_px = greatest / determinant;
    extent_px.is_finite().then_some(extent_px)
}

/// The texel's extent at a display position; `None` where the method has no texel or an unbounded one.
pub fn extent_at_px(mapping: &dyn Mapping, px: DVec2) -> Option<f64> {
    mapping.jacobian(px).as_ref().and_then(texel_extent_px)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_pixel_centres_of_the_display() {
        for (size, gaze) in [([1, 1], [0.5, 0.5]), ([13, 17], [-1e6, 3.0]), ([1920, 1080], [960.0, 540.0])] {
            let display = DisplayGeometry::symmetric(size, 90.0);
            let points = pixel_centres(&display, DVec2::from_array(gaze), &mut Random::of("test"));
            assert!(points.len() >= (size[0] * size[1]).min(100) as usize);
            for point in points {
                assert_eq!(point.fract(), DVec2::splat(0.5));
                assert!(
                    point.cmpgt(DVec2::ZERO).all()
                        && point.x < f64::from(size[0])
                        && point.y < f64::from(size[1])
                );
            }
        }
    }

    #[test]
    fn the_extent_is_the_longer_axis_of_the_texel() {
        // Stretched by 1/4 and 2 and turned: texels 4 px by 1/2 px.
        let (sin, cos) = 0.7_f64.sin_cos();
        let jacobian =
            TexelJacobian { du_dx: 0.25 * cos, du_dy: 0.25 * sin, dv_dx: -2.0 * sin, dv_dy: 2.0 * cos };
        let extent_px = texel_extent_px(&jacobian).expect("bounded");
        assert!((extent_px - 4.0).abs() < 1e-12, "{extent_px}");
        let flat = TexelJacobian { du_dx: 0.0, du_dy: 0.0, dv_dx: 1.0, dv_dy: 2.0 };
        assert_eq!(texel_extent_px(&flat), None);
    }
}
