//! Tests of the acuity models against known answers, closed forms and plain quadrature.

use super::*;
use proptest::prelude::*;

/// The paper's pivots, degrees and degrees per cycle.
const PIVOTS: [[f64; 2]; 5] = [[0.0, 0.025], [10.0, 0.1], [20.0, 1.0 / 6.0], [30.0, 0.2], [60.0, 0.25]];

/// Eccentricities in degrees, columns `u`, planar heights `l`; made by other software.
#[rustfmt::skip]
const KNOWN_PLANAR: [[f64; 3]; 11] = [
    [0.017781887729924485, 1.4187701123877277, 8.890722932438974],
    [0.21338168494138007, 16.54640634632484, 100.80345813510087],
    [0.8234002676869654, 58.868471856016335, 331.8544265951932],
    [7.56054010248071, 315.7940684745973, 1149.3860283908298],
    [9.994788580519662, 369.57424753455183, 1231.1383021522354],
    [14.734185830421998, 451.96917191438433, 1346.1373063155079],
    [22.12393196707224, 547.8868942127701, 1445.7559638376715],
    [31.207830594421186, 644.3370426619673, 1579.4962967311708],
    [40.052998570686725, 728.8594845932843, 1636.1598941523234],
    [61.03389563183623, 908.3341693751615, 1211.9321290029975],
    [66.54025326908456, 951.3048497199517, 1007.8254773005717],
];

/// As [`KNOWN_PLANAR`], with the heights on the sphere.
#[rustfmt::skip]
const KNOWN_ON_SPHERE: [[f64; 3]; 11] = [
    [0.018810079896400565, 1.500576468023346, 9.401921969684143],
    [0.21338168494138007, 16.54640634632484, 100.80415719913813],
    [7.380225944910877, 311.34329524247545, 1151.0199754454463],
    [10.022546280371287, 370.12908335542875, 1251.176363187898],
    [18.81816508590922, 508.39799450672, 1462.6276558312695],
    [28.82910520157727, 620.4944114879044, 1770.4660255333022],
    [39.8148650038418, 726.6602102677115, 2130.8306231804563],
    [53.80366655153715, 849.4677572127229, 2424.2996710243488],
    [66.43957504999167, 950.5328263743744, 2531.252493425744],
    [75.77850333888114, 1020.1121223187254, 2526.024747341834],
    [87.65001682457745, 1103.1075267743722, 2429.702501119589],
];

fn close(value: f64, truth: f64, relative: f64) {
    assert!((value - truth).abs() <= relative * truth.abs(), "{value} instead of {truth}");
}

fn paper() -> AcuityModel {
    AcuityModel::vafr_2025()
}

fn model(pivots_deg_cpd: &[(f64, f64)]) -> AcuityModel {
    AcuityModel::new(pivots_deg_cpd).expect("a valid model")
}

/// Simpson's rule on panels that end at `kinks`.
fn simpson(from: f64, to: f64, kinks: &[f64], f: impl Fn(f64) -> f64) -> f64 {
    const PANELS: u32 = 4000;
    let inner = kinks.iter().copied().filter(|kink| *kink > from && *kink < to);
    let ends: Vec<f64> = [from].into_iter().chain(inner).chain([to]).collect();
    let mut sum = 0.0;
    for pair in ends.windows(2) {
        let step = (pair[1] - pair[0]) / f64::from(PANELS);
        for panel in 0..PANELS {
            let left = pair[0] + f64::from(panel) * step;
            sum += step / 6.0 * (f(left) + 4.0 * f(left + 0.5 * step) + f(left + step));
        }
    }
    sum
}

fn message(result: Result<AcuityModel>) -> String {
    result.expect_err("refused").to_string()
}

// --- Known answers -------------------------------------------------------------------------------

#[test]
fn columns_heights_and_samples_of_the_paper() {
    let model = paper();
    assert_eq!(model, AcuityModel::default());
    assert!((model.columns_to(60.0) - 900.0914).abs() < 5e-5);
    assert!((model.samples_to_planar(60.0) - 1_061_733.66).abs() < 5e-3);
    assert!((model.samples_on_sphere(60.0) - 1_267_241.07).abs() < 5e-3);
    let grid = || (0..=6000).map(|step| f64::from(step) / 100.0);
    let highest = |height: &dyn Fn(f64) -> f64| {
        grid().map(|deg| (height(deg), deg)).max_by(|a, b| a.0.total_cmp(&b.0)).expect("a grid")
    };
    let (planar, at_deg) = highest(&|deg| model.height_planar(deg));
    assert!((planar - 1637.90).abs() < 5e-3 && (at_deg - 38.73).abs() < 5e-3, "{planar} at {at_deg}");
    let (sphere, at_deg) = highest(&|deg| model.height_on_sphere(deg));
    assert!((sphere - 2494.15).abs() < 5e-3 && at_deg == 60.0, "{sphere} at {at_deg}");
}

#[test]
fn columns_and_heights_of_other_software() {
    let model = paper();
    for [deg, columns, height] in KNOWN_PLANAR {
        close(model.columns_to(deg), columns, 1e-12);
        close(model.height_planar(deg), height, 1e-12);
        close(model.eccentricity_deg(columns), deg, 1e-12);
    }
    for [deg, columns, height] in KNOWN_ON_SPHERE {
        close(model.columns_to(deg), columns, 1e-12);
        close(model.height_on_sphere(deg), height, 1e-12);
        close(model.eccentricity_deg(columns), deg, 1e-12);
    }
}

/// Eq. 5 as the paper prints it, segment by segment, with `c_0` from continuity.
#[test]
fn columns_are_the_papers_logarithms() {
    let model = paper();
    let mut before = 0.0;
    for pair in PIVOTS.windows(2) {
        let ([start, mar], [end, end_mar]) = (pair[0], pair[1]);
        let slope = (end_mar - mar) / (end - start);
        for share in [0.25, 0.5, 1.0] {
            let deg = start + share * (end - start);
            let mar_at = slope * (deg - start) + mar;
            close(model.mar_deg(deg), mar_at, 1e-14);
            close(model.columns_to(deg), before + 2.0 / slope * (mar_at / mar).ln(), 1e-12);
        }
        before += 2.0 / slope * (end_mar / mar).ln();
    }
    // The last segment goes on: 0.25 degrees at 60, 0.05 more each 30 degrees.
    for deg in [75.0, 90.0, 150.0, 180.0] {
        close(model.mar_deg(deg), 0.25 + (deg - 60.0) / 600.0, 1e-14);
    }
}

#[test]
fn samples_are_the_integral_of_the_heights() {
    let delta = [(5.0, 1.0), (30.0, 0.5), (70.0, 1.5)];
    let kinks = [5.0, 10.0, 20.0, 30.0, 60.0, 70.0, 90.0];
    for model in [paper(), paper().smooth()] {
        let model = model.with_delta(&delta).expect("valid ratios");
        for to_deg in [1e-3, 3.0, 10.0, 47.0, 89.0, 95.0, 180.0] {
            let planar = simpson(0.0, to_deg, &kinks, |deg| model.height_planar(deg) * 2.0 * model.cpd(deg));
            close(model.samples_to_planar(to_deg), planar, 1e-12);
            let sphere =
                simpson(0.0, to_deg, &kinks, |deg| model.height_on_sphere(deg) * 2.0 * model.cpd(deg));
            close(model.samples_on_sphere(to_deg), sphere, 1e-12);
        }
    }
    assert_eq!(paper().samples_to_planar(0.0), 0.0);
}

/// With MAR `a + m e` the integral of `720 sin(e)/MAR * 2/MAR` has a closed form for `m = 0`.
#[test]
fn samples_of_one_acuity_everywhere() {
    let model = model(&[(0.0, 10.0)]);
    let per_degree = 720.0 * 10.0 * 2.0 * 10.0;
    for deg in [1e-6_f64, 1.0, 60.0, 180.0] {
        // 1 - cos without its cancellation.
        let cap = 2.0 * (deg.to_radians() / 2.0).sin().powi(2) * 1f64.to_degrees();
        close(model.samples_on_sphere(deg), per_degree * cap, 1e-12);
    }
    let planar = 360.0 * 10.0 * 2.0 * 10.0 * 60f64.to_radians().sin().powi(2) * 1f64.to_degrees();
    close(model.samples_to_planar(60.0), planar, 1e-12);
}

// --- Pivots, flat segments, limits ---------------------------------------------------------------

#[test]
fn nothing_jumps_or_turns_back_at_the_pivots() {
    for model in [paper(), paper().smooth(), paper().limited_to(9.0).expect("a limit")] {
        for [pivot, _] in PIVOTS {
            for step in [1e-3, 1e-9] {
                let (low, high) = ((pivot - step).max(0.0), pivot + step);
                let (u_low, u, u_high) =
                    (model.columns_to(low), model.columns_to(pivot), model.columns_to(high));
                assert!(u_high > u && (u > u_low || pivot == 0.0), "{pivot}");
                assert!(u_high - u_low <= 2.0 * 2.0 * 40.0 * step * 1.01, "{pivot}");
                assert!(model.mar_deg(low) <= model.mar_deg(pivot));
                assert!(model.mar_deg(pivot) <= model.mar_deg(high));
                let back = model.eccentricity_deg(u + step);
                assert!(back > pivot && back <= pivot + step, "{pivot}: {back}");
            }
        }
    }
}

/// MAR all but flat: against the series of `2 d/omega (1 - x/2 + x^2/3)` with `x = m d/omega`.
#[test]
fn columns_where_the_slope_nearly_vanishes() {
    for slack in [0.0, 1e-16, 1e-15, 1e-12, 1e-9, 1e-6] {
        let model = model(&[(0.0, 8.0), (40.0, 8.0 / (1.0 + slack))]);
        let slope = (model.mar_deg(40.0) - 0.125) / 40.0;
        for deg in [1e-12, 0.1, 20.0, 40.0, 180.0] {
            let growth = slope * deg / 0.125;
            let columns = 16.0 * deg * (1.0 - growth / 2.0 + growth * growth / 3.0);
            close(model.columns_to(deg), columns, 1e-12);
            close(model.eccentricity_deg(columns), deg, 1e-12);
        }
    }
}

#[test]
fn a_flat_last_segment_stays_flat() {
    let model = model(&[(0.0, 20.0), (10.0, 5.0), (20.0, 5.0)]);
    assert_eq!([20.0, 60.0, 180.0].map(|deg| model.cpd(deg)), [5.0; 3]);
    close(model.columns_to(180.0) - model.columns_to(10.0), 1700.0, 1e-12);
}

#[test]
fn a_display_limits_acuity() {
    for smooth in [false, true] {
        let free = if smooth { paper().smooth() } else { paper() };
        for limit in [50.0, 40.0, 39.0, 18.0, 10.0, 9.0, 5.0, 4.5, 1.0, 1e-3] {
            let model = free.clone().limited_to(limit).expect("a limit");
            for step in 0..=1800 {
                let deg = f64::from(step) / 10.0;
                close(model.cpd(deg), free.cpd(deg).min(limit), 1e-13);
            }
            let kinks: Vec<f64> = (1..180).map(f64::from).collect();
            let columns = simpson(0.0, 40.5, &kinks, |deg| 2.0 * free.cpd(deg).min(limit));
            // Simpson's rule crosses the kink where the limit sets in.
            close(model.columns_to(40.5), columns, 1e-7);
            // Samples of the display's own density in the middle.
            close(model.columns_to(1e-3), 2e-3 * free.cpd(0.0).min(limit), 1e-2);
        }
    }
    // Of several the lowest.
    let twice = paper().limited_to(9.0).and_then(|model| model.limited_to(18.0));
    assert_eq!(twice.expect("limits"), paper().limited_to(9.0).expect("a limit"));
}

#[test]
fn scale_limit_and_smoothness_may_come_in_any_order() {
    let limited = |model: AcuityModel| model.limited_to(9.0).expect("a limit");
    let scaled = |model: AcuityModel| model.scaled(0.5).expect("a factor");
    let one = scaled(limited(paper())).smooth();
    assert_eq!(one, limited(scaled(paper().smooth())));
    assert_eq!(one.cpd(0.0), 9.0);
    let half = scaled(paper());
    for deg in [0.0, 0.3, 15.0, 44.0, 180.0] {
        close(half.cpd(deg), paper().cpd(deg) / 2.0, 1e-14);
        close(half.columns_to(deg), paper().columns_to(deg) / 2.0, 1e-12);
    }
    close(half.samples_on_sphere(60.0), paper().samples_on_sphere(60.0) / 4.0, 1e-12);
}

#[test]
fn the_ratio_is_linear_between_its_entries() {
    assert_eq!(paper().delta(30.0), 1.0);
    let model = paper().with_delta(&[(10.0, 1.0), (30.0, 0.5)]).expect("valid ratios");
    let known = [(0.0, 1.0), (10.0, 1.0), (20.0, 0.75), (30.0, 0.5), (180.0, 0.5)];
    for (deg, ratio) in known {
        assert_eq!(model.delta(deg), ratio, "{deg}");
        close(model.height_planar(deg), ratio * paper().height_planar(deg), 1e-15);
        close(model.height_on_sphere(deg), ratio * paper().height_on_sphere(deg), 1e-15);
    }
    let uniform = paper().with_delta(&[(0.0, 0.5)]).expect("a ratio");
    close(uniform.samples_to_planar(60.0), paper().samples_to_planar(60.0) / 2.0, 1e-12);
}

// --- The smooth variant --------------------------------------------------------------------------

#[test]
fn the_smooth_variant_meets_the_pivots_and_has_no_kinks() {
    let (model, lines) = (paper().smooth(), paper());
    for [deg, mar_deg] in PIVOTS {
        close(model.mar_deg(deg), mar_deg, 1e-14);
        let step = 1e-5;
        let below = (model.mar_deg(deg) - model.mar_deg(deg - step)) / step;
        let above = (model.mar_deg(deg + step) - model.mar_deg(deg)) / step;
        let kink = (lines.mar_deg(deg + step) + lines.mar_deg(deg - step) - 2.0 * mar_deg).abs() / step;
        if deg > 0.0 && deg < 60.0 {
            // The second derivative is below 1e-2, so that one-sided slopes differ by 1e-7 at most.
            assert!((above - below).abs() < 1e-7, "{deg}: {below} {above}");
            assert!(kink > 1e-4, "{deg}: the straight lines have one");
        }
    }
    for deg in [60.0, 70.0, 120.0, 180.0] {
        close(model.mar_deg(deg), lines.mar_deg(deg), 1e-14);
    }
    let mut before = 0.0;
    for step in 0..=18_000 {
        let mar_deg = model.mar_deg(f64::from(step) / 100.0);
        assert!(mar_deg > before, "{step}");
        before = mar_deg;
    }
}

#[test]
fn columns_of_the_smooth_variant_are_the_integral_of_its_rate() {
    let steep = model(&[(0.0, 1e4), (1e-3, 60.0), (2.0, 59.0), (90.0, 1e-3)]);
    for model in [paper(), model(&[(0.0, 30.0), (2.0, 30.0), (50.0, 2.0)])] {
        let model = model.smooth();
        for deg in [1e-3, 1.7, 10.0, 29.0, 60.0, 130.0] {
            let kinks = [2.0, 10.0, 20.0, 30.0, 50.0, 60.0];
            close(model.columns_to(deg), simpson(0.0, deg, &kinks, |deg| 2.0 * model.cpd(deg)), 1e-11);
        }
    }
    // Seven powers of ten within one model: each cut of the quadrature counts.
    let steep = steep.smooth();
    let mut kinks = vec![1e-3, 2.0];
    for power in -6..2 {
        kinks.extend([1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(power)));
        kinks.push(1e-3 - 10f64.powi(power - 2));
    }
    kinks.sort_by(f64::total_cmp);
    let columns = simpson(0.0, 80.0, &kinks, |deg| 2.0 * steep.cpd(deg));
    close(steep.columns_to(80.0), columns, 1e-10);
}

// --- Inputs of every kind ------------------------------------------------------------------------

#[test]
fn eccentricities_of_every_kind_give_finite_answers() {
    let near = model(&[(0.0, 1e4), (1e-4, 1e-3), (2e-4, 1e-3)]);
    let far = model(&[(0.0, 1e4), (179.0, 1e4), (179.0001, 1e-3)]);
    let extremes = [near.clone(), near.smooth(), far.clone(), far.smooth()];
    for model in [paper(), paper().smooth()].into_iter().chain(extremes) {
        let most = model.columns_to(180.0);
        for deg in [
            0.0,
            -1.0,
            1e-300,
            1e-6,
            5e-5,
            89.999_999,
            90.0,
            179.000_05,
            180.0,
            181.0,
            1e300,
            f64::INFINITY,
            f64::NAN,
        ] {
            let within = if deg.is_nan() { 0.0 } else { deg.clamp(0.0, 180.0) };
            for answer in [
                AcuityModel::mar_deg,
                AcuityModel::cpd,
                AcuityModel::delta,
                AcuityModel::columns_to,
                AcuityModel::eccentricity_deg,
                AcuityModel::height_planar,
                AcuityModel::height_on_sphere,
                AcuityModel::samples_to_planar,
                AcuityModel::samples_on_sphere,
            ] {
                let value = answer(&model, deg);
                assert!(value.is_finite() && value >= 0.0, "{value} at {deg}");
            }
            assert_eq!(model.columns_to(deg), model.columns_to(within));
        }
        assert_eq!(model.columns_to(0.0), 0.0);
        assert_eq!(model.eccentricity_deg(f64::NAN), 0.0);
        close(model.eccentricity_deg(2.0 * most), 180.0, 1e-15);
        assert_eq!(model.height_planar(90.0), 0.0);
        assert_eq!(model.samples_to_planar(120.0), model.samples_to_planar(90.0));
        assert!(model.samples_on_sphere(180.0) > model.samples_on_sphere(120.0));
    }
}

#[test]
fn pivots_that_make_no_model_are_refused() {
    let many: Vec<_> = (0..257).map(|deg| (f64::from(deg) / 2.0, 10.0)).collect();
    for (pivots, named) in [
        (&[][..], "no pivots"),
        (&[(1.0, 40.0)], "begins at 1 degrees"),
        (&[(0.0, 40.0), (0.0, 30.0)], "must rise"),
        (&[(0.0, 40.0), (20.0, 30.0), (10.0, 20.0)], "10 degrees after one at 20"),
        (&[(0.0, 40.0), (181.0, 30.0)], "181"),
        (&[(0.0, 40.0), (f64::NAN, 30.0)], "NaN"),
        (&[(0.0, 40.0), (f64::INFINITY, 30.0)], "inf"),
        (&[(0.0, 0.0)], "0 cpd"),
        (&[(0.0, -4.0)], "-4 cpd"),
        (&[(0.0, f64::NAN)], "NaN cpd"),
        (&[(0.0, 1e5)], "100000 cpd"),
        (&[(0.0, 10.0), (10.0, 10.5)], "minimum angle of resolution must not fall"),
        (&many, "257"),
    ] {
        let message = message(AcuityModel::new(pivots));
        assert!(message.contains(named) && !message.contains('\n'), "{message}");
    }
}

#[test]
fn factors_limits_and_ratios_out_of_range_are_refused() {
    for wrong in [0.0, 0.04, 21.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(message(paper().scaled(wrong)).contains(&wrong.to_string()));
        assert!(message(paper().with_delta(&[(3.0, wrong)])).contains(&format!("{wrong} at 3 degrees")));
        assert!(message(paper().limited_to(wrong.min(0.0))).contains("limit"));
    }
    let dim = model(&[(0.0, 0.002)]);
    assert!(message(dim.scaled(0.05)).contains("0 degrees"));
    for wrong in [[(10.0, 1.0), (10.0, 2.0)], [(-1.0, 1.0), (2.0, 1.0)], [(0.0, 1.0), (f64::NAN, 1.0)]] {
        assert!(message(paper().with_delta(&wrong)).starts_with("delta"));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn columns_lead_back_to_their_eccentricity(
        steps in prop::collection::vec((1e-3..40.0_f64, 1.0..3.0_f64), 0..6),
        first_cpd in 2.0..120.0_f64,
        is_smooth in any::<bool>(),
        limit in prop::option::of(1.0..60.0_f64),
        shares in prop::collection::vec(0.0..1.0_f64, 8),
    ) {
        let mut pivots = vec![(0.0, first_cpd)];
        for (step, fall) in steps {
            let (deg, cpd) = pivots[pivots.len() - 1];
            if deg + step <= 180.0 && cpd / fall >= 1e-3 {
                pivots.push((deg + step, cpd / fall));
            }
        }
        let mut model = model(&pivots);
        if is_smooth { model = model.smooth(); }
        if let Some(cpd) = limit { model = model.limited_to(cpd).expect("a limit"); }
        let most = model.columns_to(180.0);
        let mut before = (0.0, 0.0);
        let mut shares = shares;
        shares.sort_by(f64::total_cmp);
        for share in shares {
            let deg = model.eccentricity_deg(share * most);
            prop_assert!((model.columns_to(deg) - share * most).abs() < 1e-10, "{pivots:?} {deg}");
            let columns = model.columns_to(180.0 * share);
            prop_assert!((model.columns_to(model.eccentricity_deg(columns)) - columns).abs() < 1e-10);
            prop_assert!(deg >= before.0 && columns >= before.1);
            before = (deg, columns);
        }
    }
}

// --- Files ---------------------------------------------------------------------------------------

#[test]
fn a_file_says_all_that_the_builders_say() {
    let plain = AcuityModel::from_toml("degrees = [0, 10, 20, 30, 60]\ncpd = [40, 10.0, 6, 5, 4]\n");
    assert_eq!(plain.expect("a model"), paper());
    let text = "degrees = [0, 10.5]\ncpd = [30, 8]\nsmooth = true\nscale = 0.5\n\
                delta_degrees = [0, 30]\ndelta = [1, 0.5]\n";
    let built = model(&[(0.0, 30.0), (10.5, 8.0)]).smooth().scaled(0.5);
    let built = built.and_then(|model| model.with_delta(&[(0.0, 1.0), (30.0, 0.5)]));
    assert_eq!(AcuityModel::from_toml(text).expect("a model"), built.expect("a model"));
}

#[test]
fn broken_files_are_refused_by_key_and_value() {
    let good = "degrees = [0, 10]\ncpd = [30, 8]\n";
    for (text, named) in [
        ("", "no degrees and no cpd"),
        ("degrees = [0, 10\n", "line "),
        ("degrees = [0, 10]\n", "degrees but no cpd"),
        ("cpd = [30]\n", "cpd but no degrees"),
        ("degrees = [0, 10]\ncpd = [30]\n", "2 values in degrees and 1 in cpd"),
        ("degrees = [0, \"ten\"]\ncpd = [30, 8]\n", "degrees holds \"ten\""),
        ("degrees = 10\ncpd = [30, 8]\n", "degrees holds 10"),
        ("degrees = [0, 10]\ncpd = [30, nan]\n", "10 degrees is NaN cpd"),
        ("degrees = [0, 10]\ncpd = [30, 31]\n", "31 cpd"),
        (&format!("{good}pivots = 3\n"), "unknown key, pivots = 3"),
        (&format!("{good}smooth = 1\n"), "smooth holds 1"),
        (&format!("{good}scale = \"big\"\n"), "scale holds \"big\""),
        (&format!("{good}scale = 50\n"), "factor is 50"),
        (&format!("{good}delta = [1]\n"), "delta but no delta_degrees"),
        (&format!("{good}delta = [50]\ndelta_degrees = [3]\n"), "delta is 50 at 3 degrees"),
        (&format!("{good}cpd = [30, 8]\n"), "line 3"),
        (&format!("{good}other = \"{}\"\n", "x".repeat(1000)), "..."),
    ] {
        let message = message(AcuityModel::from_toml(text));
        assert!(message.contains(named), "{text:?}: {message}");
        assert!(!message.contains('\n') && message.chars().count() < 250, "{message}");
    }
}
