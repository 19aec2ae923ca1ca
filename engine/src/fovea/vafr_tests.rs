//! VaFR's mapping against answers computed in high precision, against differences, and in hard cases.

use super::acuity::AcuityModel;
use super::display::{DisplayGeometry, size_dvec2_px};
use super::mapping::{LpPoint, Mapping};
use super::radial::{FORWARD_KNOTS, RadialMapping, fill_columns, fill_forward};
use super::vafr::{NATIVE_BAND, VafrForm, VafrMapping};
use glam::DVec2;
use proptest::prelude::*;
use std::sync::Arc;

fn mapping(form: VafrForm, display: &DisplayGeometry, gaze_px: DVec2) -> VafrMapping {
    VafrMapping::new(form, display, gaze_px, &Arc::new(AcuityModel::vafr_2025()))
}

struct Known {
    form: VafrForm,
    /// Size in px, horizontal field of view in degrees.
    display: ([u32; 2], f64),
    gaze_px: [f64; 2],
    /// x and y in px, eccentricity in degrees, u, height and v in texels.
    points: [[f64; 6]; 5],
}

#[rustfmt::skip]
const KNOWN: [Known; 8] = [
    Known {
        form: VafrForm::Planar,
        display: ([1920, 1080], 100.0),
        gaze_px: [635.52, 178.20000000000002],
        points: [
            [632.52, 178.20100000000002, 0.21338168494138007, 16.54640634632484, 100.80345813510087, 50.39638127820082],
            [638.52, 178.199, 0.21338168494138007, 16.54640634632484, 100.80345813510087, 100.79811034575125],
            [0.5, 0.5, 39.30389156180338, 721.9274851390962, 1637.5715286407076, 889.899176680577],
            [1140.5, 272.5, 32.52663171686005, 657.3231159184253, 1598.4056342006786, 46.964653578193555],
            [211.5, 384.5, 30.34376695094077, 635.75187240978, 1565.049558450306, 669.7347843517587],
        ],
    },
    Known {
        form: VafrForm::Planar,
        display: ([1440, 1600], 98.0),
        gaze_px: [711.36, 366.40000000000003],
        points: [
            [708.36, 366.401, 0.27462813967492067, 21.112031894570347, 127.53373902411037, 63.76010363731371],
            [714.36, 366.39900000000006, 0.27462813967492067, 21.112031894570347, 127.53373902411037, 127.5269731493689],
            [0.5, 0.5, 51.94457650657761, 833.8530363106255, 1477.2285413901527, 850.375544835541],
            [477.5, 24.5, 33.49772947371893, 666.7963514513627, 1609.9272391467089, 1053.7323779028723],
            [1094.5, 756.5, 41.1410333644197, 738.8570277598155, 1632.1611686278018, 206.35826379084932],
        ],
    },
    Known {
        form: VafrForm::Planar,
        display: ([7680, 4320], 100.0),
        gaze_px: [3978.2400000000002, 3853.44],
        points: [
            [3975.2400000000002, 3853.4410000000003, 0.053345652451603685, 4.233863115892449, 26.392063524012915, 13.19463161960195],
            [3981.2400000000002, 3853.439, 0.053345652451603685, 4.233863115892449, 26.392063524012915, 26.39066338160841],
            [0.5, 0.5, 59.80735405069425, 898.5492209735927, 1253.4999471161536, 780.2582307529203],
            [2820.5, 3663.5, 20.00711930732775, 523.0116090348006, 1388.6346714372219, 730.2559849722675],
            [1611.5, 2766.5, 38.947981554847814, 718.619921297761, 1637.8541636964671, 931.1530588833751],
        ],
    },
    Known {
        form: VafrForm::Planar,
        display: ([11520, 6480], 120.0),
        gaze_px: [5034.24, 4082.4],
        points: [
            [5031.24, 4082.4010000000003, 0.051687072796283234, 4.1032347783564385, 25.584033276606984, 12.79065936323342],
            [5037.24, 4082.399, 0.051687072796283234, 4.1032347783564385, 25.584033276606984, 25.58267600153691],
            [0.5, 0.5, 62.8358782319974, 922.5666113902242, 1148.1083855303482, 698.5565722263303],
            [10644.5, 841.5, 62.829782129856696, 922.5187465266267, 1148.3295349813793, 1052.5910715546213],
            [3486.5, 2399.5, 34.50967817953568, 676.5891652846632, 1619.7898372424647, 1023.1478158806138],
        ],
    },
    Known {
        form: VafrForm::Sphere,
        display: ([1920, 1080], 100.0),
        gaze_px: [635.52, 178.20000000000002],
        points: [
            [632.52, 178.20100000000002, 0.17131504003692005, 13.364637251484064, 81.9028462705751, 40.94720058608512],
            [638.52, 178.199, 0.1716921506009346, 13.393329832398589, 82.07430452621551, 82.07007313738231],
            [0.5, 0.5, 25.79246413026968, 588.6956654744317, 1684.5346491980708, 916.4343614277269],
            [1140.5, 272.5, 32.686370662066096, 658.8865465644542, 1901.5750045573516, 55.87031997760739],
            [211.5, 384.5, 24.85397274771879, 578.5171482172792, 1655.054552230344, 718.2169492303796],
        ],
    },
    Known {
        form: VafrForm::Sphere,
        display: ([1440, 1600], 98.0),
        gaze_px: [711.36, 366.40000000000003],
        points: [
            [708.36, 366.401, 0.22570953176629252, 17.47169233895926, 106.25861685548315, 53.124674300943845],
            [714.36, 366.39900000000006, 0.2257293749657709, 17.473179116531284, 106.26736602161553, 106.26273151325114],
            [0.5, 0.5, 38.20500019670048, 711.6856823507799, 2084.02209461081, 1175.178653834886],
            [477.5, 24.5, 20.799271508378833, 532.4415886287682, 1509.8747332236057, 966.7598491810362],
            [1094.5, 756.5, 42.93134604506635, 755.1283859231057, 2213.5072874923876, 246.65552184018514],
        ],
    },
    Known {
        form: VafrForm::Sphere,
        display: ([7680, 4320], 100.0),
        gaze_px: [3978.2400000000002, 3853.44],
        points: [
            [3975.2400000000002, 3853.4410000000003, 0.04715491531919561, 3.7459592002212188, 23.372011445618575, 11.684907366802468],
            [3981.2400000000002, 3853.439, 0.047151979824299306, 3.745727636340112, 23.37057678213925, 23.36947849355372],
            [0.5, 0.5, 71.84566953053293, 991.300894902945, 2536.3381456025418, 1557.876985920604],
            [2820.5, 3663.5, 18.370241547699184, 502.702481257863, 1456.419082379657, 761.7582566071964],
            [1611.5, 2766.5, 39.75972938625572, 726.1504320110699, 2129.274211334566, 1196.5400188119893],
        ],
    },
    Known {
        form: VafrForm::Sphere,
        display: ([11520, 6480], 120.0),
        gaze_px: [5034.24, 4082.4],
        points: [
            [5031.24, 4082.4010000000003, 0.04794878952583321, 3.808575875375205, 23.759909898757783, 11.878705974503184],
            [5037.24, 4082.399, 0.04796578049535256, 3.8099158741261516, 23.76820994198227, 23.76696053080249],
            [0.5, 0.5, 61.16570086407423, 909.3809364162091, 2503.476845388117, 1513.4365491197602],
            [10644.5, 841.5, 75.77850333888114, 1020.1121223187254, 2526.024747341834, 2311.7027718026357],
            [3486.5, 2399.5, 33.72673108491501, 669.019448724254, 1938.630745717684, 1214.66314540695],
        ],
    },
];

#[test]
fn known_answers() {
    for known in &KNOWN {
        let display = DisplayGeometry::symmetric(known.display.0, known.display.1);
        let mapping = mapping(known.form, &display, known.gaze_px.into());
        for [x, y, ecc_deg, u, height, v] in known.points {
            let px = DVec2::new(x, y);
            let close = |what: &str, got: f64, want: f64| {
                assert!(
                    (got - want).abs() <= 1e-9 * want.abs().max(1.0),
                    "{what} at {px}: {got}, not {want}"
                );
            };
            close("eccentricity", mapping.eccentricity_deg(px), ecc_deg);
            let point = mapping.forward(px).unwrap();
            close("u", point.u, u);
            close("height", mapping.column_height(point.u), height);
            close("v", point.v_share * mapping.column_height(point.u), v);
        }
    }
}

/// Displays of many kinds: tiny, wide, asymmetric, with pixels that are not square.
fn displays() -> Vec<DisplayGeometry> {
    let mut displays: Vec<_> =
        [([1, 1], 50.0), ([13, 7], 90.0), ([1920, 1080], 100.0), ([11520, 6480], 120.0)]
            .map(|(size_px, hfov_deg)| DisplayGeometry::symmetric(size_px, hfov_deg))
            .into();
    displays.push(DisplayGeometry {
        size_px: [1440, 1600],
        tan_left: -1.4,
        tan_right: 0.9,
        tan_up: 1.2,
        tan_down: -1.3,
    });
    displays
}

fn gazes(size: DVec2) -> Vec<DVec2> {
    let shares = [(0.5, 0.5), (0.0, 0.0), (1.0, 0.3), (0.21, 0.77), (-0.2, 0.5), (2.0, -1.0)];
    let mut gazes: Vec<_> = shares.map(|(x, y)| DVec2::new(x, y) * size).into();
    gazes.extend([DVec2::splat(1e6), DVec2::new(f64::NAN, 1.0), DVec2::new(f64::INFINITY, 0.0)]);
    gazes
}

const FORMS: [VafrForm; 2] = [VafrForm::Sphere, VafrForm::Planar];

#[test]
fn there_and_back() {
    for display in displays() {
        let size = size_dvec2_px(display.size_px);
        for (gaze_px, form) in gazes(size).into_iter().flat_map(|gaze| FORMS.map(|form| (gaze, form))) {
            let mapping = mapping(form, &display, gaze_px);
            for index in 0..49 {
                let px = DVec2::new(f64::from(index % 7), f64::from(index / 7)) / 6.0 * size;
                let point = mapping.forward(px).unwrap();
                assert!(point.u.is_finite() && (0.0..1.0).contains(&point.v_share), "{point:?}");
                let back = mapping.inverse(point).unwrap();
                // The planar form squeezes a far gaze's display into a ten-millionth of a degree.
                let far = mapping.gaze_px().abs().max_element() > 4.0 * size.max_element();
                if !(far && form == VafrForm::Planar) {
                    assert!(back.distance(px) < 1e-6, "{form:?} {gaze_px}: {px} came back as {back}");
                }
            }
        }
    }
}

#[test]
fn the_jacobian_is_the_forward_mapping_s_slope() {
    let display = displays()[4];
    for form in FORMS {
        let mapping = mapping(form, &display, DVec2::new(300.0, 1200.0));
        for px in [DVec2::new(310.0, 1190.0), DVec2::new(1000.0, 100.0), DVec2::new(5.0, 1500.0)] {
            let at = mapping.forward(px).unwrap();
            let jacobian = mapping.jacobian(px).unwrap();
            let slope = |step: DVec2| {
                let (a, b) = (mapping.forward(px - step).unwrap(), mapping.forward(px + step).unwrap());
                let turn = (b.v_share - a.v_share + 0.5).rem_euclid(1.0) - 0.5;
                DVec2::new(b.u - a.u, turn * mapping.column_height(at.u)) / (2.0 * step.length())
            };
            for (step, want) in [
                (DVec2::X, DVec2::new(jacobian.du_dx, jacobian.dv_dx)),
                (DVec2::Y, DVec2::new(jacobian.du_dy, jacobian.dv_dy)),
            ] {
                let got = slope(step * 1e-3);
                assert!(
                    got.distance(want) < 1e-6 * want.length().max(1e-2),
                    "{form:?} {px}: {got}, not {want}"
                );
            }
        }
    }
}

#[test]
fn on_the_sphere_the_rate_is_the_acuity_s_at_every_gaze() {
    let display = DisplayGeometry::symmetric([11520, 6480], 120.0);
    let acuity = AcuityModel::vafr_2025();
    let mut planar_ratios = [f64::INFINITY, 0.0f64];
    for off_axis_deg in [0.0f64, 20.0, 30.0, 40.0] {
        let gaze_px =
            display.px_of_ray(glam::DVec3::new(off_axis_deg.to_radians().tan(), 0.0, -1.0)).unwrap();
        let [sphere, planar] = FORMS.map(|form| mapping(form, &display, gaze_px));
        for index in 0..2000 {
            let px = DVec2::new(f64::from(index % 50) + 0.37, f64::from(index / 50) + 0.61)
                * DVec2::new(11520.0 / 51.0, 6480.0 / 41.0);
            let ecc_deg = display.eccentricity_rad(gaze_px, px).to_degrees();
            if ecc_deg < 0.2 {
                continue;
            }
            let rates = sphere.rates(px).unwrap();
            if !sphere.is_native(px) {
                for rate in [rates.radial_cpd, rates.tangential_cpd] {
                    let ratio = rate / acuity.cpd(ecc_deg);
                    assert!((ratio - 1.0).abs() < 1e-6, "{off_axis_deg} degrees off, {ecc_deg}: {ratio}");
                }
            }
            if off_axis_deg == 40.0 {
                let ratio = planar.rates(px).unwrap().radial_cpd / acuity.cpd(ecc_deg);
                planar_ratios = [planar_ratios[0].min(ratio), planar_ratios[1].max(ratio)];
            }
        }
    }
    // The published form's rate misses the acuity by these factors along its worst meridian.
    assert!(planar_ratios[0] < 0.62 && planar_ratios[1] > 1.6, "{planar_ratios:?}");
}

#[test]
fn native_pixels_are_where_the_display_is_coarser_than_the_acuity() {
    for display in displays() {
        let size = size_dvec2_px(display.size_px);
        for gaze_px in gazes(size) {
            let mapping = mapping(VafrForm::Sphere, &display, gaze_px);
            let [first, end] = mapping.native_box_px();
            for index in 0..400 {
                let px = (DVec2::new(f64::from(index % 20), f64::from(index / 20)) / 19.0 * size)
                    .min(size - 0.5)
                    .floor()
                    + 0.5;
                // A pixel's area in the sky by the angles of its edges, and the acuity's samples there.
                let side =
                    |step: DVec2| display.eccentricity_rad(px - step / 2.0, px + step / 2.0).to_degrees();
                let ray = display.ray_of_px(px);
                let skew = ray.x * ray.y / ((1.0 + ray.x * ray.x) * (1.0 + ray.y * ray.y)).sqrt();
                let area_deg2 = side(DVec2::X) * side(DVec2::Y) * (1.0 - skew * skew).sqrt();
                let ecc_deg = display.eccentricity_rad(mapping.gaze_px(), px).to_degrees();
                let asked = (2.0 * AcuityModel::vafr_2025().cpd(ecc_deg)).powi(2) * area_deg2;
                // Large pixels are not flat, and the ratio at the limit rounds.
                if display.size_px[0] > 1000 && (asked - 1.0).abs() > 1e-2 {
                    assert_eq!(mapping.is_native(px), asked > 1.0 || px.distance(mapping.gaze_px()) <= 3.0);
                }
                let inside = px.x >= f64::from(first[0])
                    && px.y >= f64::from(first[1])
                    && px.x < f64::from(end[0])
                    && px.y < f64::from(end[1]);
                let needed = mapping.pixels_over_acuity(px) <= 1.0 + NATIVE_BAND;
                assert!(
                    inside || !needed,
                    "{px} is native and outside of {first:?}..{end:?}, gaze {gaze_px}"
                );
            }
        }
    }
}

#[test]
fn columns_reach_every_pixel_of_every_gaze() {
    for display in displays() {
        let size = size_dvec2_px(display.size_px);
        for (gaze_px, form) in gazes(size).into_iter().flat_map(|gaze| FORMS.map(|form| (gaze, form))) {
            let mapping = mapping(form, &display, gaze_px);
            let in_use = mapping.columns_in_use();
            assert!(in_use as usize <= mapping.columns().heights().len());
            assert!(mapping.columns().heights().iter().all(|height| *height >= 1));
            for index in 0..121 {
                let px = DVec2::new(f64::from(index % 11), f64::from(index / 11)) / 10.0 * size;
                let u = mapping.forward(px).unwrap().u;
                assert!(u <= f64::from(in_use), "{form:?} {gaze_px}: {px} lies at {u} of {in_use}");
            }
        }
    }
}

#[test]
fn interpolated_tables_keep_their_bounds() {
    let display = DisplayGeometry::symmetric([11520, 6480], 120.0);
    let steep = AcuityModel::new(&[(0.0, 60.0), (2.0, 20.0), (10.0, 6.0), (60.0, 2.0)]).unwrap();
    for acuity in [AcuityModel::vafr_2025(), AcuityModel::vafr_2025().smooth(), steep] {
        for form in FORMS {
            let mapping = VafrMapping::new(form, &display, display.center_px(), &Arc::new(acuity.clone()));
            let mut knots = vec![[0.0; 2]; FORWARD_KNOTS];
            fill_forward(&mapping, &mut knots);
            let mut rows = vec![[[0.0; 4]; 2]; mapping.columns().heights().len()];
            fill_columns(&mapping, &mut rows);
            assert!(knots.as_flattened().iter().all(|value| value.is_finite()));
            assert!(rows.as_flattened().as_flattened().iter().all(|value| value.is_finite()));
            // Where the first display pixels lie the table's own spacing shows; the native disc is there.
            for pair in knots.windows(2).enumerate().skip(16) {
                let (index, [low, high]) = pair else { unreachable!("windows of two") };
                let reach = super::radial::forward_reach(&mapping);
                let abscissa = reach * (index as f64 + 0.5) / (FORWARD_KNOTS - 1) as f64;
                let want = mapping.column_of_eccentricity(2.0 * (abscissa * abscissa).atan());
                let got = f64::midpoint(f64::from(low[0]), f64::from(high[0]));
                assert!((got - want).abs() < 3e-4, "knot {index}: {got}, not {want}");
            }
        }
    }
}

proptest! {
    #[test]
    fn moving_the_gaze_is_making_the_mapping_anew(x in -1e4..1e4f64, y in -1e4..1e4f64) {
        let display = displays()[2];
        for form in FORMS {
            let mut moved = mapping(form, &display, display.center_px());
            moved.retarget(DVec2::new(x, y));
            prop_assert_eq!(moved, mapping(form, &display, DVec2::new(x, y)));
        }
    }

    #[test]
    fn texels_come_back(u in 0.5..900.0f64, v_share in 0.0..1.0f64) {
        let display = DisplayGeometry::symmetric([3840, 2160], 100.0);
        for form in FORMS {
            let mapping = mapping(form, &display, DVec2::new(2500.0, 1000.0));
            if let Some(px) = mapping.inverse(LpPoint { u, v_share }) {
                let back = mapping.forward(px).unwrap();
                prop_assert!((back.u - u).abs() < 1e-7, "{} became {}", u, back.u);
                let turn = (back.v_share - v_share + 0.5).rem_euclid(1.0) - 0.5;
                prop_assert!(turn.abs() < 1e-9);
            }
        }
    }
}
