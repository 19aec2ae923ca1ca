//! Tests of the acuity models.

use super::*;

#[test]
fn known_answers() {
    let model = AcuityModel::vafr_2025();
    assert!((model.columns_to(60.0) - 900.0914).abs() < 5e-5);
    assert!((model.samples_to_planar(60.0) - 1_061_733.66).abs() < 5e-3);
    assert!((model.samples_on_sphere(60.0) - 1_267_241.07).abs() < 5e-3);
}
