//! Counting against mappings of known rate.

use super::super::synthetic::Constant;
use super::*;
use macula::fovea::{AcuityModel, ColumnLayout, DisplayGeometry, TexelJacobian, VafrForm, VafrMapping};
use std::sync::Arc;

fn display() -> DisplayGeometry {
    DisplayGeometry::symmetric([1920, 1080], 100.0)
}

fn counted(mapping: &dyn Mapping, acuity: &AcuityModel, eccs_deg: &[f64]) -> Summary {
    let mut forward = |points: &[DVec2]| Ok(points.iter().map(|&px| mapping.forward(px)).collect());
    match rates(mapping, &Target::new(mapping, acuity), eccs_deg, &mut forward) {
        Ok(summary) => summary,
        Err(failure) => panic!("{failure:?}"),
    }
}

#[test]
fn known_rates_are_counted() {
    let acuity = AcuityModel::vafr_2025();
    for gaze_px in [display().center_px(), DVec2::new(1700.0, 200.0)] {
        for cpd_of in [[1.0, 4.0], [4.0, 1.0], [9.0, 9.0], [40.0, 20.0]] {
            let mapping = Constant::new(display(), gaze_px, cpd_of, 0.0, 100.0);
            let summary = counted(&mapping, &acuity, &[7.0, 12.0, 33.3, 40.0]);
            assert_eq!(summary.rows.len(), 4);
            for row in &summary.rows {
                let (Some(radial), Some(tangential)) = (row.radial, row.tangential) else {
                    panic!("{row:?}")
                };
                for (rate, cpd) in [(radial, cpd_of[0]), (tangential, cpd_of[1])] {
                    // Two parts in 1024 of a line that has edges on at least a quarter of its length, and
                    // half a texel of a column's height.
                    let height = mapping.column_height(2.0 * cpd_of[0] * row.ecc_deg);
                    let bound = 0.008 + 0.5 / height;
                    let off = f64::max(rate.cpd.max / cpd - 1.0, 1.0 - rate.cpd.min / cpd);
                    assert!(off < bound, "{off} at {cpd} cpd, {} degrees", row.ecc_deg);
                }
            }
        }
    }
}

#[test]
fn pixels_are_counted_in_the_native_disc_and_texels_outside() {
    let acuity = AcuityModel::vafr_2025();
    let mapping = Constant::new(display(), display().center_px(), [5.0, 5.0], 8.0, 100.0);
    let summary = counted(&mapping, &acuity, &[0.5, 4.0, 7.0, 9.5, 20.0]);
    for row in &summary.rows {
        let native = row.ecc_deg < 8.0;
        assert_eq!(row.native_share, if native { 1.0 } else { 0.0 });
        for rate in [row.radial, row.tangential].into_iter().flatten() {
            let expected = if native { rate.limits.display_cpd } else { 5.0 };
            for cpd in [rate.cpd.min, rate.cpd.max] {
                assert!((cpd / expected - 1.0).abs() < 0.01, "{cpd} for {expected} at {}", row.ecc_deg);
            }
        }
        assert!(row.radial.is_some() && row.tangential.is_some(), "{row:?}");
    }
}

/// Within 1 % of the acuity model or the display's limit at every eccentricity above 0.2 degrees.
#[test]
fn vafr_is_counted_at_the_acuity() {
    let acuity = Arc::new(AcuityModel::vafr_2025());
    for size_px in [[1920, 1080], [7680, 4320]] {
        let display = DisplayGeometry::symmetric(size_px, 100.0);
        for off_axis_deg in [0.0_f64, 20.0, 40.0] {
            let half = f64::from(size_px[0]) / 2.0;
            let x = half * (1.0 + off_axis_deg.to_radians().tan() / 50f64.to_radians().tan());
            let gaze_px = DVec2::new(x, f64::from(size_px[1]) / 2.0);
            let mapping = VafrMapping::new(VafrForm::Sphere, &display, gaze_px, &acuity);
            let summary = counted(&mapping, &acuity, &[0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 35.0, 50.0]);
            let Some(deviation) = summary.deviation else { panic!("nothing was counted") };
            assert!(deviation.off_both < 0.01, "{size_px:?} at {off_axis_deg}: {deviation:?}");
        }
    }
}

/// Two layers of square texels that lie side by side in the LP-buffer.
struct Layers {
    display: DisplayGeometry,
    columns: ColumnLayout,
}

impl Mapping for Layers {
    fn display(&self) -> &DisplayGeometry {
        &self.display
    }
    fn gaze_px(&self) -> DVec2 {
        self.display.center_px()
    }
    fn columns(&self) -> &ColumnLayout {
        &self.columns
    }
    fn column_height(&self, _: f64) -> f64 {
        540.0
    }
    fn forward(&self, px: DVec2) -> Option<LpPoint> {
        let inner = px.distance(self.gaze_px()) < 300.0;
        let (start, width) = if inner { (0.0, 2.0) } else { (1000.0, 4.0) };
        Some(LpPoint { u: start + px.x / width, v_share: px.y / width / 540.0 })
    }
    fn inverse(&self, _: LpPoint) -> Option<DVec2> {
        None
    }
    fn jacobian(&self, _: DVec2) -> Option<TexelJacobian> {
        None
    }
    fn is_native(&self, _: DVec2) -> bool {
        false
    }
}

#[test]
fn layers_do_not_run_into_each_other() {
    let layers = Layers { display: display(), columns: ColumnLayout::new(vec![540; 1480]) };
    let border_deg = (300.0 / 960.0 * 50f64.to_radians().tan()).atan().to_degrees();
    let acuity = AcuityModel::vafr_2025();
    for (ecc_deg, width) in [(border_deg - 0.8, 2.0), (border_deg + 1.5, 4.0), (border_deg + 8.0, 4.0)] {
        let summary = counted(&layers, &acuity, &[ecc_deg]);
        let Some(row) = summary.rows.first() else { panic!("nothing at {ecc_deg}") };
        for rate in [row.radial, row.tangential].into_iter().flatten() {
            let expected = rate.limits.display_cpd / width;
            for cpd in [rate.cpd.min, rate.cpd.max] {
                assert!((cpd / expected - 1.0).abs() < 0.01, "{cpd} for {expected} at {ecc_deg}");
            }
        }
        assert!(row.radial.is_some() && row.tangential.is_some(), "{row:?}");
    }
}

#[test]
fn what_the_forward_mapping_reports_is_told() {
    let mapping = Constant::new(display(), display().center_px(), [5.0, 5.0], 0.0, 60.0);
    let acuity = AcuityModel::vafr_2025();
    let mut lost = |_: &[DVec2]| Err(Failure::environment("the device was lost"));
    assert!(rates(&mapping, &Target::new(&mapping, &acuity), &[5.0], &mut lost).is_err());
    // A mapping that has no texels, or answers for too few points, is not counted.
    let mut nothing = |points: &[DVec2]| Ok(vec![None; points.len() / 3]);
    let summary = rates(&mapping, &Target::new(&mapping, &acuity), &[5.0], &mut nothing);
    assert!(summary.is_ok_and(|summary| summary.rows.is_empty()));
}

#[test]
fn turns_go_on_past_their_end() {
    let texel = |v_share| Some(Place::Texel(LpPoint { u: 3.0, v_share }));
    let places =
        [texel(0.9), texel(0.98), texel(0.06), None, texel(0.2), texel(0.95), Some(Place::Pixel(DVec2::ONE))];
    let rows: Vec<_> = unrolled(&places, false).into_iter().map(|place| place.map(|[_, v]| v)).collect();
    for (found, expected) in
        rows.iter().zip([Some(0.9), Some(0.98), Some(1.06), None, Some(1.2), Some(0.95), None])
    {
        match (found, expected) {
            (Some(found), Some(expected)) => assert!((found - expected).abs() < 1e-12, "{rows:?}"),
            (found, expected) => assert_eq!(found.is_some(), expected.is_some(), "{rows:?}"),
        }
    }
    assert_eq!(unrolled(&places, true)[5..], [None, Some([1.0, 1.0])]);
}

#[test]
fn lines_stay_on_their_side_of_the_gaze() {
    let none = Count::default();
    for direction in DIRECTIONS {
        let mut line = Line::new((0.3, 10.0), direction, false);
        while let Some(longer) = line.longer(&none) {
            assert!(longer.length_deg > line.length_deg);
            line = longer;
        }
        let most_deg = match direction {
            Direction::Radial => 0.6,
            Direction::Tangential => 180.0 * 0.3f64.to_radians().sin(),
        };
        assert!((line.length_deg - most_deg).abs() < 1e-12, "{line:?}");
        assert_eq!(line.offset_deg(POINTS / 2), 0.0);
    }
    // What runs across texels may turn by 0.3 rad.
    let oblique = Count { axes: [[0, 1, 2], [0, 1, 2]].map(|row| Edges::of(0, row.into_iter())), ..none };
    let arc = Line::new((0.3, 10.0), Direction::Tangential, false);
    assert!(arc.longer(&oblique).is_none());
    assert!((arc.length_deg / 0.3 - 0.3).abs() < 1e-4, "{arc:?}");
}
