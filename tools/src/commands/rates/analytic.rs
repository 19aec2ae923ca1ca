//! Shading rates from the mapping's analytic Jacobian.

use super::sphere::Surroundings;
use super::summary::{Direction, Sample, Summary};
use super::target::Target;
use macula::fovea::Mapping;

/// Azimuths about the gaze at which rates are taken, degrees apart. The axes and the diagonals are
/// among them; closer together finds a little more of the extremes of rectangular methods.
const AZIMUTH_STEP_DEG: usize = 5;

/// Rates at eccentricities in degrees, as far as they lie on the display.
pub fn rates(mapping: &dyn Mapping, target: &Target<'_>, eccs_deg: &[f64]) -> Summary {
    let around = Surroundings::new(*mapping.display(), mapping.gaze_px());
    let mut samples = vec![];
    for &ecc_deg in eccs_deg {
        for azimuth_deg in (0..360).step_by(AZIMUTH_STEP_DEG).map(f64::from) {
            let Some(px) = around.px_at(ecc_deg, azimuth_deg) else { continue };
            let Some(rates) = mapping.rates(px) else { continue };
            let is_native = mapping.is_native(px);
            for (direction, cpd) in
                [(Direction::Radial, rates.radial_cpd), (Direction::Tangential, rates.tangential_cpd)]
            {
                if let Some(limits) = target.limits(ecc_deg, px, direction) {
                    samples.push(Sample { ecc_deg, azimuth_deg, direction, cpd, limits, is_native });
                }
            }
        }
    }
    Summary::of(samples)
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::Constant;
    use super::*;
    use glam::DVec2;
    use macula::fovea::{AcuityModel, DisplayGeometry, VafrForm, VafrMapping};
    use std::sync::Arc;

    fn display() -> DisplayGeometry {
        DisplayGeometry::symmetric([1920, 1080], 100.0)
    }

    fn assert_close(value: f64, expected: f64) {
        assert!((value - expected).abs() <= 1e-9 * expected, "{value}, not {expected}");
    }

    #[test]
    fn known_rates_come_back_beside_their_targets() -> macula::error::Result<()> {
        let acuity = AcuityModel::new(&[(0.0, 3.0)])?.with_delta(&[(0.0, 0.5)])?;
        for gaze_px in [display().center_px(), DVec2::new(1500.0, 200.0)] {
            let mapping = Constant::new(display(), gaze_px, [6.0, 0.75], 0.0, 80.0);
            let summary = rates(&mapping, &Target::new(&mapping, &acuity), &[0.25, 5.0, 30.0]);
            assert_eq!(summary.rows.len(), 3);
            for row in &summary.rows {
                let (Some(radial), Some(tangential)) = (row.radial, row.tangential) else {
                    panic!("{row:?}")
                };
                for (rate, cpd, ratio) in [(radial, 6.0, 2.0), (tangential, 0.75, 0.5)] {
                    for value in [rate.cpd.min, rate.cpd.mean, rate.cpd.max] {
                        assert_close(value, cpd);
                    }
                    assert_close(rate.ratio.min, ratio);
                    assert_close(rate.ratio.max, ratio);
                }
                assert_eq!((radial.limits.acuity_cpd, tangential.limits.acuity_cpd), (3.0, 1.5));
            }
            let Some(deviation) = summary.deviation else { panic!("no deviation") };
            assert_close(deviation.greatest, 1.0);
        }
        Ok(())
    }

    /// Pixels of a flat display per degree, at its centre and away from it along the x axis.
    #[test]
    fn native_pixels_have_the_displays_rate() {
        let mapping = Constant::new(display(), display().center_px(), [6.0, 6.0], 180.0, 80.0);
        let acuity = AcuityModel::vafr_2025();
        let target = Target::new(&mapping, &acuity);
        let px_per_tan = 960.0 / 50f64.to_radians().tan();
        for (ecc_deg, azimuth_at) in [(20.0_f64, 0), (45.0, 0)] {
            let row = &rates(&mapping, &target, &[ecc_deg]).rows[azimuth_at];
            let cosine = ecc_deg.to_radians().cos();
            let (Some(radial), Some(tangential)) = (row.radial, row.tangential) else { panic!("{row:?}") };
            // The same at every azimuth about the centre.
            for value in [radial.cpd.min, radial.cpd.max, radial.limits.display_cpd] {
                assert_close(value, px_per_tan / cosine.powi(2) * 1f64.to_radians() / 2.0);
            }
            for value in [tangential.cpd.min, tangential.cpd.max, tangential.limits.display_cpd] {
                assert_close(value, px_per_tan / cosine * 1f64.to_radians() / 2.0);
            }
            assert_eq!(row.native_share, 1.0);
        }
    }

    #[test]
    fn azimuths_off_the_display_are_left_out() {
        let mapping = Constant::new(display(), display().center_px(), [6.0, 6.0], 0.0, 80.0);
        let acuity = AcuityModel::vafr_2025();
        let summary = rates(&mapping, &Target::new(&mapping, &acuity), &[10.0, 45.0, 52.0, 60.0]);
        let azimuths: Vec<_> = summary.rows.iter().map(|row| (row.ecc_deg, row.azimuths)).collect();
        // The display's upper and lower edge lie at 33.8 degrees, the sides at 50, the corners at 53.8: of
        // 72 azimuths those remain of which the sine is below tan 33.84 / tan 45, and at 52 degrees those
        // that are not nearer to an axis either.
        let upper_tan = 50f64.to_radians().tan() * 1080.0 / 1920.0;
        let within = |azimuth: u32, ecc_deg: f64| {
            let (sine, cosine) = f64::from(azimuth).to_radians().sin_cos();
            let tangent = ecc_deg.to_radians().tan();
            (sine * tangent).abs() < upper_tan && (cosine * tangent).abs() < 50f64.to_radians().tan()
        };
        let count = |ecc_deg: f64| (0..72).filter(|step| within(step * 5, ecc_deg)).count();
        assert_eq!(azimuths, [(10.0, 72), (45.0, count(45.0)), (52.0, count(52.0))]);
        assert!(count(45.0) > count(52.0) && count(52.0) > 0);
    }

    /// None of them ends at the display's edge.
    fn eccs_deg() -> Vec<f64> {
        (1..=180).map(|step| f64::from(step) * 0.5 - 0.2).collect()
    }

    fn vafr(form: VafrForm, off_axis_deg: f64) -> Summary {
        let display = display();
        let acuity = Arc::new(AcuityModel::vafr_2025());
        let gaze_px =
            DVec2::new(960.0 * (1.0 + off_axis_deg.to_radians().tan() / 50f64.to_radians().tan()), 540.0);
        let mapping = VafrMapping::new(form, &display, gaze_px, &acuity);
        rates(&mapping, &Target::new(&mapping, &acuity), &eccs_deg())
    }

    /// The planar form's radial rate over the acuity on the display's middle row, degrees to the right of a
    /// gaze on it: with the tangents `t` and `g` of both angles to the axis, its eccentricity is
    /// `atan(t - g)`, and its density by that of the angle `(1 + t^2)/(1 + (t - g)^2)`.
    fn planar_over_acuity(acuity: &AcuityModel, off_axis_deg: f64, step_deg: f64) -> f64 {
        let [tangent, gaze] = [off_axis_deg + step_deg, off_axis_deg].map(|deg| deg.to_radians().tan());
        let planar_deg = (tangent - gaze).abs().atan().to_degrees();
        let stretch = (1.0 + tangent * tangent) / (1.0 + (tangent - gaze).powi(2));
        acuity.cpd(planar_deg) / acuity.cpd(step_deg.abs()) * stretch
    }

    #[test]
    fn vafr_meets_the_acuity_and_the_planar_form_does_not() {
        let acuity = AcuityModel::vafr_2025();
        for off_axis_deg in [20.0, 30.0, 40.0] {
            let sphere = vafr(VafrForm::Sphere, off_axis_deg);
            assert!(sphere.deviation.is_some_and(|deviation| deviation.off_both < 1e-9), "{off_axis_deg}");
            // The middle row has the extremes, but for what azimuths beside it find near by.
            let steps = eccs_deg().into_iter().flat_map(|ecc_deg| [ecc_deg, -ecc_deg]);
            let on_display = steps.filter(|step| (step + off_axis_deg).abs() < 50.0);
            let expected = on_display.map(|step| planar_over_acuity(&acuity, off_axis_deg, step));
            let found = vafr(VafrForm::Planar, off_axis_deg).rows.into_iter().filter_map(|row| row.radial);
            let found =
                found.flat_map(|rate| [rate.cpd.min, rate.cpd.max].map(|cpd| cpd / rate.limits.acuity_cpd));
            let range = |(low, high), ratio| (f64::min(low, ratio), f64::max(high, ratio));
            let (expected, found) = (expected.fold((1.0, 1.0), range), found.fold((1.0, 1.0), range));
            assert!(
                found.0 <= expected.0 + 1e-9 && found.0 > 0.99 * expected.0,
                "{found:?}, not {expected:?}"
            );
            assert!(
                found.1 >= expected.1 - 1e-9 && found.1 < 1.01 * expected.1,
                "{found:?}, not {expected:?}"
            );
            assert!(found.0 < 0.8 && found.1 > 1.2, "{found:?}");
        }
    }
}
