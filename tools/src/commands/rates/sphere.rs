//! Walking on the sphere around the gaze ray: from eccentricity and azimuth to the display.

use glam::{DVec2, DVec3};
use macula::fovea::DisplayGeometry;

/// Below the first step eccentricities are halved down to this one, degrees: two thirds of a pixel of a
/// coarse headset. Lower shows single pixels.
const LEAST_ECC_DEG: f64 = 0.05;

/// A display as it lies around a gaze.
pub struct Surroundings {
    display: DisplayGeometry,
    gaze_px: DVec2,
    gaze: DVec3,
    right: DVec3,
    down: DVec3,
}

impl Surroundings {
    /// Of a checked display and a finite gaze, px, which may lie off the display.
    pub fn new(display: DisplayGeometry, gaze_px: DVec2) -> Self {
        let gaze = display.ray_of_px(gaze_px).normalize();
        // No gaze ray runs along the display's plane, so that something of the x axis is left.
        let right = (DVec3::X - gaze * gaze.x).normalize();
        Self { display, gaze_px, gaze, right, down: gaze.cross(right) }
    }

    /// The position on the display, px, at an angle from the gaze ray and an azimuth about it: 0 along
    /// the display's +x, rising towards +y (down). `None` off the display.
    pub fn px_at(&self, ecc_deg: f64, azimuth_deg: f64) -> Option<DVec2> {
        self.px_of_ray(self.ray(ecc_deg, azimuth_deg))
    }

    /// The position on the display, px, at an angle from the place of [`Self::px_at`] along the great
    /// circle across the one from the gaze, towards rising azimuths. `None` off the display.
    pub fn px_across(&self, ecc_deg: f64, azimuth_deg: f64, offset_deg: f64) -> Option<DVec2> {
        let across = self.outward(azimuth_deg + 90.0);
        let (sine, cosine) = offset_deg.to_radians().sin_cos();
        self.px_of_ray(self.ray(ecc_deg, azimuth_deg) * cosine + across * sine)
    }

    fn outward(&self, azimuth_deg: f64) -> DVec3 {
        let (sine, cosine) = azimuth_deg.to_radians().sin_cos();
        self.right * cosine + self.down * sine
    }

    fn ray(&self, ecc_deg: f64, azimuth_deg: f64) -> DVec3 {
        let (sine, cosine) = ecc_deg.to_radians().sin_cos();
        self.gaze * cosine + self.outward(azimuth_deg) * sine
    }

    fn px_of_ray(&self, ray: DVec3) -> Option<DVec2> {
        let px = self.display.px_of_ray(ray)?;
        let [width, height] = self.display.size_px.map(f64::from);
        let inside = px.x >= 0.0 && px.y >= 0.0 && px.x < width && px.y < height;
        inside.then_some(px)
    }

    /// Eccentricities on the display in steps, degrees, and below the first step halves of it.
    pub fn eccentricities_deg(&self, step_deg: f64) -> Vec<f64> {
        let mut halves = vec![];
        let mut half_deg = step_deg / 2.0;
        while half_deg >= LEAST_ECC_DEG {
            halves.push(half_deg);
            half_deg /= 2.0;
        }
        let steps = (self.reach_deg() / step_deg) as u32;
        halves.into_iter().rev().chain((1..=steps).map(|step| f64::from(step) * step_deg)).collect()
    }

    /// Eccentricity of the corner farthest from the gaze, degrees.
    pub fn reach_deg(&self) -> f64 {
        let [width, height] = self.display.size_px.map(f64::from);
        let corners =
            [DVec2::ZERO, DVec2::new(width, 0.0), DVec2::new(0.0, height), DVec2::new(width, height)];
        let ecc_deg = |px| self.display.eccentricity_rad(self.gaze_px, px).to_degrees();
        corners.map(ecc_deg).into_iter().fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn displays() -> [DisplayGeometry; 2] {
        let asymmetric = DisplayGeometry {
            size_px: [1440, 1600],
            tan_left: -1.4,
            tan_right: 0.9,
            tan_up: 1.0,
            tan_down: -1.3,
        };
        [DisplayGeometry::symmetric([1920, 1080], 100.0), asymmetric]
    }

    #[test]
    fn positions_lie_at_their_eccentricity() {
        for display in displays() {
            for gaze_px in [display.center_px(), DVec2::new(200.0, 700.0), DVec2::new(-900.0, 300.0)] {
                let around = Surroundings::new(display, gaze_px);
                let mut found = 0;
                for ecc_deg in [0.05, 1.0, 20.0, 47.0, 80.0, 100.0] {
                    for azimuth_deg in (0..360).step_by(5) {
                        let Some(px) = around.px_at(ecc_deg, f64::from(azimuth_deg)) else { continue };
                        let back_deg = display.eccentricity_rad(gaze_px, px).to_degrees();
                        assert!((back_deg - ecc_deg).abs() < 1e-9 * ecc_deg, "{back_deg} at {ecc_deg}");
                        found += 1;
                    }
                }
                assert!(found > 20, "{gaze_px}: {found}");
            }
        }
    }

    #[test]
    fn azimuths_turn_from_right_to_down() {
        for display in displays() {
            let gaze_px = DVec2::new(700.0, 500.0);
            let around = Surroundings::new(display, gaze_px);
            for (azimuth_deg, towards) in
                [(0.0, DVec2::X), (90.0, DVec2::Y), (180.0, DVec2::NEG_X), (270.0, DVec2::NEG_Y)]
            {
                let Some(px) = around.px_at(2.0, azimuth_deg) else { panic!("{azimuth_deg} is off") };
                let along = (px - gaze_px).normalize().dot(towards);
                // The great circle to the right bends on the plane unless the gaze lies on its middle row.
                assert!(along > 0.95, "{azimuth_deg}: {along}");
            }
        }
    }

    #[test]
    fn lines_across_are_straight_and_upright_on_those_from_the_gaze() {
        for display in displays() {
            let gaze_px = DVec2::new(700.0, 500.0);
            let around = Surroundings::new(display, gaze_px);
            let ray = |px: Option<DVec2>| display.ray_of_px(px.unwrap_or(DVec2::NAN)).normalize();
            let place = ray(around.px_at(12.0, 70.0));
            let [before, after] = [-3.0, 3.0].map(|offset_deg| ray(around.px_across(12.0, 70.0, offset_deg)));
            for end in [before, after] {
                assert!((end.angle_between(place).to_degrees() - 3.0).abs() < 1e-9);
            }
            let gaze = display.ray_of_px(gaze_px).normalize();
            let [chord, towards_gaze] = [(after - before).normalize(), (gaze - place).normalize()];
            assert!(chord.dot(towards_gaze).abs() < 1e-12 && chord.dot(place).abs() < 1e-12);
            assert!(ray(around.px_at(12.0, 71.0)).dot(chord) > ray(around.px_at(12.0, 69.0)).dot(chord));
        }
    }

    #[test]
    fn nothing_lies_off_the_display_or_behind_the_eye() {
        let [display, _] = displays();
        let around = Surroundings::new(display, display.center_px());
        for (ecc_deg, azimuth_deg) in [(50.1, 0.0), (50.1, 180.0), (40.0, 90.0), (90.0, 30.0), (170.0, 30.0)]
        {
            assert_eq!(around.px_at(ecc_deg, azimuth_deg), None, "{ecc_deg} {azimuth_deg}");
        }
        assert!(around.px_at(49.9, 0.0).is_some());
    }

    #[test]
    fn steps_end_at_the_farthest_corner() {
        let [display, _] = displays();
        let around = Surroundings::new(display, display.center_px());
        let half_width = 50f64.to_radians().tan();
        let corner_deg = half_width.hypot(half_width * 9.0 / 16.0).atan().to_degrees();
        assert!((around.reach_deg() - corner_deg).abs() < 1e-9);
        let all = around.eccentricities_deg(0.5);
        assert_eq!(all[..6], [0.0625, 0.125, 0.25, 0.5, 1.0, 1.5]);
        assert!(all.last().is_some_and(|last| corner_deg - 0.5 < *last && *last <= corner_deg));
        assert_eq!(around.eccentricities_deg(60.0).last(), Some(&30.0));
    }
}
