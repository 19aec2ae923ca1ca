//! Tests of the methods that ours is compared with: their papers' closed forms and stated facts, and the
//! hard cases.

mod axes;

use super::tests::hard_gazes;
use super::*;
use glam::DVec2;
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

const QUARTIC: Kernel = Kernel::Power { alpha: 4.0 };

/// Pixels per eye of the resolutions in Zhang et al.'s table I.
const TABLE_SIZES: [[u32; 2]; 5] = [[2560, 1440], [3840, 2160], [5760, 3240], [7680, 4320], [11520, 6480]];

fn all(display: DisplayGeometry, gaze_px: DVec2) -> Vec<(&'static str, Box<dyn Mapping>)> {
    let retinal = LafrParams::RETINAL;
    vec![
        ("kfr", Box::new(KfrColumns::new(display, gaze_px, QUARTIC, 1.8))),
        ("lafr", Box::new(LafrMapping::new(display, gaze_px, LafrParams::default()))),
        ("lafr retinal", Box::new(LafrMapping::new(display, gaze_px, retinal))),
        ("visual-polar", Box::new(VisualPolarMapping::new(display, gaze_px, VisualPolarParams::default()))),
        ("rmfr", Box::new(RmfrMapping::new(display, gaze_px, RmfrParams::default()))),
        ("guenter3", Box::new(GuenterMapping::new(display, gaze_px, GuenterParams::default()))),
    ]
}

/// Zhang et al.'s acuity model, cycles per degree: the MAR is linear between their pivots.
fn acuity_cpd(eccentricity_deg: f64) -> f64 {
    let pivots = [(0.0, 40.0), (10.0, 10.0), (20.0, 6.0), (30.0, 5.0), (60.0, 4.0_f64)];
    let next = pivots.iter().position(|pivot| pivot.0 >= eccentricity_deg).unwrap_or(4).max(1);
    let ((low_deg, low), (high_deg, high)) = (pivots[next - 1], pivots[next]);
    let share = (eccentricity_deg - low_deg) / (high_deg - low_deg);
    (low.recip() + (high.recip() - low.recip()) * share).recip()
}

/// The display position on the centre's row at an eccentricity, gaze at the centre, square pixels.
fn px_at(display: &DisplayGeometry, eccentricity_deg: f64) -> DVec2 {
    let focal_px = f64::from(display.size_px[0]) / (display.tan_right - display.tan_left);
    display.center_px() + DVec2::X * (focal_px * eccentricity_deg.to_radians().tan())
}

fn rates_at(mapping: &dyn Mapping, eccentricity_deg: f64) -> Rates {
    mapping.rates(px_at(mapping.display(), eccentricity_deg)).expect("off the gaze")
}

fn lafr(display: DisplayGeometry, params: LafrParams) -> LafrMapping {
    LafrMapping::new(display, display.center_px(), params)
}

// --- All methods ---------------------------------------------------------------------------------

#[test]
fn hard_gazes_make_nothing_non_finite() {
    for size_px in [[1, 1], [1, 7], [2, 2], [13, 1], [1920, 1080], [11520, 6480]] {
        let mut narrow = DisplayGeometry::symmetric(size_px, 1e-7);
        narrow.tan_up += 1e-9;
        for display in [DisplayGeometry::symmetric(size_px, 100.0), asymmetric(size_px), narrow] {
            for gaze_px in hard_gazes(size_px) {
                for (name, mapping) in all(display, gaze_px) {
                    check_hard_points(name, mapping.as_ref());
                }
            }
        }
    }
}

fn asymmetric(size_px: [u32; 2]) -> DisplayGeometry {
    DisplayGeometry { size_px, tan_left: -1.4, tan_right: 0.9, tan_up: 1.1, tan_down: -1.2 }
}

fn check_hard_points(name: &str, mapping: &dyn Mapping) {
    let gaze_px = mapping.gaze_px();
    assert!(gaze_px.is_finite());
    let center_px = mapping.display().center_px();
    let width = mapping.columns().heights().len() as f64;
    let points = [DVec2::ZERO, center_px, 2.0 * center_px, gaze_px, gaze_px + 0.4, DVec2::splat(-1e9)];
    for px in points.into_iter().chain([gaze_px - DVec2::X * 1e-200, DVec2::splat(0.5)]) {
        let point = mapping.forward(px).expect("these methods have texels everywhere");
        assert!((0.0..=width).contains(&point.u), "{name}: {point:?} for {px}");
        assert!((0.0..1.0).contains(&point.v_share), "{name}: {point:?} for {px}");
        assert!(mapping.inverse(point).is_some_and(DVec2::is_finite), "{name}: {point:?}");
        if let Some(jacobian) = mapping.jacobian(px) {
            assert!(jacobian.density_per_px2().is_finite(), "{name}: {jacobian:?} at {px}");
        }
        assert!(mapping.column_height(point.u) >= 0.0);
    }
    for (u, v_share) in [(-1.0, -0.3), (0.0, 0.0), (width, 1.0), (width + 9.0, 7.2)] {
        assert!(mapping.inverse(LpPoint { u, v_share }).is_some_and(DVec2::is_finite), "{name} at {u}");
    }
}

#[test]
fn jacobian_is_the_slope() {
    for display in [DisplayGeometry::symmetric([2560, 1440], 100.0), asymmetric([1440, 1600])] {
        for share in [DVec2::splat(0.5), DVec2::new(0.2, 0.9), DVec2::new(-0.1, 0.4)] {
            let size_px = 2.0 * display.center_px();
            for (name, mapping) in all(display, share * size_px) {
                let bad = (0..3000_u32)
                    .map(|i| DVec2::new(f64::from(i * 7919 % 10007), f64::from(i * 5417 % 10009)) / 1e4)
                    .filter(|at| at.max_element() < 1.0 && !slope_fits(mapping.as_ref(), *at * size_px))
                    .count();
                // A step may straddle a kink or a layer's edge.
                assert!(bad <= 30, "{name}, gaze {share}: {bad} of 3000");
            }
        }
    }
}

fn slope_fits(mapping: &dyn Mapping, px: DVec2) -> bool {
    let step_px = (1e-4 * px.distance(mapping.gaze_px())).min(0.01);
    let height = mapping.column_height(mapping.forward(px).expect("texels").u);
    let difference = |step: DVec2| {
        let [after, before] = [px + step, px - step].map(|px| mapping.forward(px).expect("texels"));
        let dv = (after.v_share - before.v_share + 0.5).rem_euclid(1.0) - 0.5;
        DVec2::new(after.u - before.u, dv * height) / (2.0 * step_px)
    };
    let (by_x, by_y) = (difference(DVec2::X * step_px), difference(DVec2::Y * step_px));
    let jacobian = mapping.jacobian(px).expect("off the gaze");
    let scale = by_x.length() + by_y.length();
    let off = (by_x - DVec2::new(jacobian.du_dx, jacobian.dv_dx)).length()
        + (by_y - DVec2::new(jacobian.du_dy, jacobian.dv_dy)).length();
    off <= 1e-4 * scale
}

#[test]
fn retargeting_keeps_the_columns_and_equals_a_new_mapping() {
    let display = asymmetric([1440, 1600]);
    let start_px = DVec2::new(100.0, 1500.0);
    macro_rules! check {
        ($new:expr) => {
            let mut mapping = $new(start_px);
            let heights = mapping.columns().heights().as_ptr();
            for gaze_px in hard_gazes(display.size_px) {
                mapping.retarget(gaze_px);
                let fresh = $new(gaze_px);
                assert_eq!(mapping.columns().heights().as_ptr(), heights);
                assert_eq!(mapping.columns(), fresh.columns());
                for px in [DVec2::splat(3.3), DVec2::new(900.5, 700.5), DVec2::new(1439.5, 1.5)] {
                    assert_eq!(mapping.forward(px), fresh.forward(px));
                    assert_eq!(mapping.jacobian(px), fresh.jacobian(px));
                }
            }
        };
    }
    check!(|gaze_px| KfrColumns::new(display, gaze_px, QUARTIC, 1.8));
    check!(|gaze_px| LafrMapping::new(display, gaze_px, LafrParams::default()));
    check!(|gaze_px| VisualPolarMapping::new(display, gaze_px, VisualPolarParams::default()));
    check!(|gaze_px| RmfrMapping::new(display, gaze_px, RmfrParams::default()));
    check!(|gaze_px| GuenterMapping::new(display, gaze_px, GuenterParams::default()));
}

#[test]
fn parameters_out_of_range_are_refused_in_one_line() {
    let lafr = LafrParams::default();
    let rmfr = RmfrParams::default();
    let guenter = GuenterParams::default();
    let refused = [
        LafrParams { delta: f64::NAN, ..lafr }.check(),
        LafrParams { delta: 0.5, ..lafr }.check(),
        LafrParams { alpha: 1.2, ..lafr }.check(),
        LafrParams { beta: 0.6, ..lafr }.check(),
        RmfrParams { focal_x_share: 0.0, ..rmfr }.check(),
        RmfrParams { focal_y_share: f64::INFINITY, ..rmfr }.check(),
        RmfrParams { delta: -2.6, ..rmfr }.check(),
        GuenterParams { slope_arcmin_per_deg: 0.0, ..guenter }.check(),
        GuenterParams { foveal_cpd: f64::NAN, ..guenter }.check(),
        VisualPolarParams { columns: 0 }.check(),
    ];
    for (index, result) in refused.into_iter().enumerate() {
        let message = result.expect_err(&format!("case {index}")).to_string();
        assert!(!message.contains('\n') && message.len() < 120, "{message}");
    }
    let accepted = [
        lafr.check(),
        LafrParams::RETINAL.check(),
        rmfr.check(),
        guenter.check(),
        VisualPolarParams::default().check(),
    ];
    assert!(accepted.iter().all(Result::is_ok));
}

proptest! {
    #[test]
    fn round_trip(
        width in 1_u32..12_000, height in 1_u32..7_000,
        tangents in (0.05_f64..2.0, 0.05_f64..2.0, 0.05_f64..2.0, 0.05_f64..2.0),
        gaze in (-0.5_f64..1.5, -0.5_f64..1.5), at in (0.0_f64..1.0, 0.0_f64..1.0),
    ) {
        let (left, right, up, down) = tangents;
        let display = DisplayGeometry {
            size_px: [width, height], tan_left: -left, tan_right: right, tan_up: up, tan_down: -down,
        };
        let size_px = 2.0 * display.center_px();
        let px = size_px * DVec2::from(at);
        for (name, mapping) in all(display, size_px * DVec2::from(gaze)) {
            let density = mapping.jacobian(px).map_or(0.0, |jacobian| jacobian.density_per_px2());
            // Below 1 px a log-polar mapping is flat; so are texels of more than 100 x 100 px.
            if px.distance(mapping.gaze_px()) <= 1.0 || density < 1e-4 {
                continue;
            }
            let point = mapping.forward(px).expect("texels");
            let back = mapping.inverse(point).expect("on the plane");
            prop_assert!((back - px).length() < 1e-6, "{name}: {px} came back as {back}");
        }
    }
}

#[test]
fn u_rises_without_a_jump_and_inverts() {
    for size_px in [[1, 1], [640, 480], [1440, 1700], [11520, 6480]] {
        for display in [DisplayGeometry::symmetric(size_px, 110.0), DisplayGeometry::symmetric(size_px, 3.0)]
        {
            for gaze_px in hard_gazes(size_px) {
                let reach_px = display.farthest_corner_px(all(display, gaze_px)[0].1.gaze_px()).max(2.0);
                for params in [LafrParams::default(), LafrParams::RETINAL] {
                    let lafr = LafrMapping::new(display, gaze_px, params);
                    // It moves far gazes nearer than the other methods do.
                    let reach_px = display.farthest_corner_px(lafr.gaze_px()).max(2.0);
                    assert_eq!(lafr.reach_px(), reach_px);
                    check_radial(&lafr, reach_px, 1.0, |r| lafr.u_of_radius_px(r), |u| lafr.radius_px(u));
                }
                let polar = VisualPolarMapping::new(display, gaze_px, VisualPolarParams::default());
                assert_eq!(polar.reach_px(), reach_px);
                check_radial(&polar, reach_px, 1e-3, |r| polar.u_of_radius_px(r), |u| polar.radius_px(u));
            }
        }
    }
}

fn check_radial(
    mapping: &dyn Mapping,
    reach_px: f64,
    least_px: f64,
    u_of: impl Fn(f64) -> f64,
    radius_of: impl Fn(f64) -> f64,
) {
    const STEPS: u32 = 2000;
    let width = mapping.columns().heights().len() as f64;
    assert!(u_of(0.0) == 0.0 && radius_of(0.0) <= 1.0 + 1e-12);
    assert_eq!(u_of(reach_px), width);
    assert!((radius_of(width) / reach_px - 1.0).abs() < 1e-4);
    let ratio = reach_px / least_px;
    let mut last = u_of(least_px);
    for step in 1..=STEPS {
        let radius_px = least_px * ratio.powf(f64::from(step) / f64::from(STEPS));
        let u = u_of(radius_px);
        assert!(u >= last, "falls at {radius_px} px");
        // A jump would leave the values in its gap without a radius.
        let middle_u = f64::midpoint(u, last);
        let slack = 1e-9 * width;
        assert!((u_of(radius_of(middle_u)) - middle_u).abs() <= slack, "at u = {middle_u}");
        last = u;
    }
}

// --- KFR and LaFR --------------------------------------------------------------------------------

#[test]
fn sample_counts_of_table_1() {
    // Thousands of samples that the paper prints for LaFR(2.2), LaFR(1.8) and full shading.
    let printed = [
        [761.0, 1137.0, 3686.0],
        [1713.0, 2560.0, 8294.0],
        [3855.0, 5760.0, 18662.0],
        [6854.0, 10240.0, 33177.0],
        [15423.0, 23040.0, 74649.0],
    ];
    for (size_px, [coarse, fine, full]) in TABLE_SIZES.into_iter().zip(printed) {
        let display = DisplayGeometry::symmetric(size_px, 100.0);
        let thousands = |delta: f64| {
            lafr(display, LafrParams { delta, ..LafrParams::default() }).columns().texels() as f64 / 1e3
        };
        // Printed figures are cut off; our sides are whole texels.
        assert!((thousands(2.2) - coarse).abs() < 2e-3 * coarse, "{size_px:?}: {}", thousands(2.2));
        assert!((thousands(1.8) - fine).abs() < 2e-3 * fine, "{size_px:?}: {}", thousands(1.8));
        assert!((thousands(1.0) - full).abs() < 1.0);
        let kfr = KfrColumns::new(display, display.center_px(), QUARTIC, 1.8);
        assert_eq!(kfr.columns(), lafr(display, LafrParams::default()).columns());
    }
}

/// `LW(e)` of the paper, per degree: `w dz/de`.
fn columns_per_degree(display: &DisplayGeometry, width: f64, eccentricity_deg: f64) -> f64 {
    let (sine, cosine) = eccentricity_deg.to_radians().sin_cos();
    let log_reach = display.farthest_corner_px(display.center_px()).ln();
    width * PI / (180.0 * sine * cosine) / log_reach
}

fn z_at(display: &DisplayGeometry, eccentricity_deg: f64) -> f64 {
    let center_px = display.center_px();
    px_at(display, eccentricity_deg).distance(center_px).ln() / display.farthest_corner_px(center_px).ln()
}

#[test]
fn kfr_has_the_rates_of_equation_16_and_20() {
    for size_px in TABLE_SIZES {
        let display = DisplayGeometry::symmetric(size_px, 100.0);
        let kfr = KfrColumns::new(display, display.center_px(), QUARTIC, 1.8);
        let [width, height] = kfr.columns().size().map(f64::from);
        let native_px = kfr.mapping().native_radius_px();
        for eccentricity_deg in [1.0, 3.0, 8.0, 15.0, 30.0, 45.0, 49.0] {
            if kfr.is_native(px_at(&display, eccentricity_deg)) {
                assert!(px_at(&display, eccentricity_deg).distance(display.center_px()) < native_px);
                continue;
            }
            let rates = rates_at(&kfr, eccentricity_deg);
            let radial = 2.0
                * z_at(&display, eccentricity_deg).powi(3)
                * columns_per_degree(&display, width, eccentricity_deg);
            assert!((rates.radial_cpd / radial - 1.0).abs() < 1e-9, "{eccentricity_deg}: {rates:?}");
            check_tangential(height, eccentricity_deg, rates);
        }
    }
}

/// Eq. 20, without its conversion of tangential lengths with the radial scale, which is `1/cos e` off.
fn check_tangential(height: f64, eccentricity_deg: f64, rates: Rates) {
    let (sine, cosine) = eccentricity_deg.to_radians().sin_cos();
    let printed = height / (720.0 * cosine * sine);
    assert!((rates.tangential_cpd / (printed * cosine) - 1.0).abs() < 1e-9, "{eccentricity_deg}: {rates:?}");
}

#[test]
fn lafr_has_the_rates_of_equation_17_and_20() {
    for (size_px, params) in [
        ([1440, 1700], LafrParams::default()),
        ([2560, 1440], LafrParams { alpha: 0.78, beta: 0.9, delta: 2.2 }),
        ([11520, 6480], LafrParams::RETINAL),
    ] {
        let display = DisplayGeometry::symmetric(size_px, 110.0);
        let mapping = lafr(display, params);
        let [width, height] = mapping.columns().size().map(f64::from);
        let boundary_z = z_at(&display, 4.89);
        let f_a = 1.0 - (params.alpha * boundary_z.powf(0.75) / 0.75).log(boundary_z);
        let boundary_share = (boundary_z * (1.0 - f_a)).powf(1.0 / f_a);
        let shape = params.beta / 0.7;
        for eccentricity_deg in [0.4, 1.0, 2.0, 4.0, 4.88, 4.9, 6.0, 10.0, 25.0, 40.0, 54.0] {
            let z = z_at(&display, eccentricity_deg);
            let scale = columns_per_degree(&display, width, eccentricity_deg);
            let radial = if eccentricity_deg < 4.89 {
                (1.0 - f_a) / (2.0 * f_a) * (z - z * f_a).powf((1.0 - f_a) / f_a) * scale
            } else {
                // Half of what is printed (see the module), times what beta adds.
                let z_a = (1.0 / z - 1.0 / boundary_z) / (1.0 / boundary_z - 1.0);
                let within = (2.0 * z_a.acos() - PI) / PI;
                let printed = 2.0 * (1.0 - boundary_share)
                    / (-PI * (1.0 - z_a * z_a).sqrt())
                    / (1.0 / boundary_z - 1.0)
                    * (-1.0 / (z * z))
                    * scale;
                printed / 2.0 * shape * within.powf(shape - 1.0)
            };
            let rates = rates_at(&mapping, eccentricity_deg);
            assert!((rates.radial_cpd / radial - 1.0).abs() < 1e-9, "{eccentricity_deg}: {rates:?} {radial}");
            check_tangential(height, eccentricity_deg, rates);
        }
    }
}

#[test]
fn lafr_is_continuous_with_a_kink_and_close_to_acuity_outside_the_fovea() {
    let display = DisplayGeometry::symmetric([1440, 1700], 110.0);
    let mapping = lafr(display, LafrParams::default());
    let boundary_px = mapping.boundary_radius_px();
    assert!((boundary_px - (px_at(&display, 4.89) - display.center_px()).x).abs() < 1e-9);
    let step = mapping.u_of_radius_px(boundary_px * (1.0 + 1e-12))
        - mapping.u_of_radius_px(boundary_px * (1.0 - 1e-12));
    assert!((0.0..1e-8).contains(&step), "{step}");
    let (inside, outside) = (rates_at(&mapping, 4.88).radial_cpd, rates_at(&mapping, 4.9).radial_cpd);
    assert!(inside < 0.3 * acuity_cpd(4.88) && outside > acuity_cpd(4.9), "{inside} {outside}");
    for eccentricity_deg in 8..=55 {
        let eccentricity_deg = f64::from(eccentricity_deg);
        let share = rates_at(&mapping, eccentricity_deg).radial_cpd / acuity_cpd(eccentricity_deg);
        assert!((2.0 / 3.0..4.0 / 3.0).contains(&share), "{eccentricity_deg}: {share}");
    }
    assert_eq!(mapping.native_radius_px(), 3.0);
    assert!(mapping.is_native(display.center_px() + 2.0) && !mapping.is_native(display.center_px() + 2.2));
}

// --- Visual-Polar --------------------------------------------------------------------------------

#[test]
fn visual_polar_keeps_the_stated_facts() {
    let display = DisplayGeometry::symmetric([1440, 1600], 110.0);
    let mapping = VisualPolarMapping::new(display, display.center_px(), VisualPolarParams::default());
    // About as large as the 1.06 million samples it is compared with.
    let samples = mapping.columns().texels() as f64;
    assert!((0.85..1.15).contains(&(samples / 1.061e6)), "{samples}");
    let fovea = rates_at(&mapping, 1.0);
    for eccentricity_deg in [0.5, 2.0, 3.0, 4.5, 5.7] {
        let rates = rates_at(&mapping, eccentricity_deg);
        assert!((rates.radial_cpd / fovea.radial_cpd - 1.0).abs() < 1e-9, "uniform: {rates:?}");
        assert!((rates.tangential_cpd / fovea.radial_cpd - 1.0).abs() < 0.01, "isotropic: {rates:?}");
    }
    assert!(fovea.radial_cpd < 0.4 * acuity_cpd(0.0), "far below acuity: {fovea:?}");
    for eccentricity_deg in 6..=60 {
        let eccentricity_deg = f64::from(eccentricity_deg);
        let rates = rates_at(&mapping, eccentricity_deg);
        let share = rates.radial_cpd / acuity_cpd(eccentricity_deg);
        assert!((0.8..1.4).contains(&share), "similar to VaFR's at {eccentricity_deg}: {share}");
        assert!(rates.tangential_cpd < rates.radial_cpd, "lower at {eccentricity_deg}: {rates:?}");
    }
}

#[test]
fn visual_polar_density_follows_the_acuity_model() {
    for (size_px, hfov_deg) in [([1440, 1600], 110.0), ([1920, 1080], 47.0), ([11520, 6480], 120.0)] {
        let display = DisplayGeometry::symmetric(size_px, hfov_deg);
        let mapping = VisualPolarMapping::new(display, display.center_px(), VisualPolarParams::default());
        // Samples per square degree in the plane of polar angle and azimuth.
        let density = |eccentricity_deg: f64| {
            let rates = rates_at(&mapping, eccentricity_deg);
            let arc = eccentricity_deg.to_radians();
            rates.radial_cpd * rates.tangential_cpd * arc.sin() / arc
        };
        for eccentricity_deg in [1.0, 4.0, 5.78, 5.8, 8.0, 12.0, 20.0, 23.0] {
            let acuity = (7.49 / (0.3 * eccentricity_deg + 1.0_f64).powi(2)).min(1.0);
            let share = density(eccentricity_deg) / density(2.0);
            assert!((share / acuity - 1.0).abs() < 1e-3, "{eccentricity_deg}: {share} {acuity}");
        }
        // Foveal columns form the triangle, the others are full.
        let fovea_u = mapping.u_of_radius_px(mapping.fovea_radius_px());
        let full = mapping.columns().size()[1];
        for (column, &height) in mapping.columns().heights().iter().enumerate() {
            let share = (column as f64 + 0.5) / fovea_u;
            assert!((f64::from(height) - (share * f64::from(full)).min(f64::from(full))).abs() <= 0.5 + 1e-9);
            assert!((f64::from(height) - mapping.height(column as f64 + 0.5)).abs() <= 0.5);
        }
    }
}

#[test]
fn visual_polar_periphery_thins_out_for_gazes_aside() {
    let display = DisplayGeometry::symmetric([1440, 1600], 110.0);
    let at = |gaze_px: DVec2, step_px: f64| {
        let mapping = VisualPolarMapping::new(display, gaze_px, VisualPolarParams::default());
        mapping.u_of_radius_px(step_px + 1.0) - mapping.u_of_radius_px(step_px)
    };
    let (centre, corner) = (display.center_px(), DVec2::ZERO);
    assert!((at(corner, 20.0) / at(centre, 20.0) - 1.0).abs() < 1e-9);
    assert!(at(corner, 300.0) < 0.95 * at(centre, 300.0));
}
