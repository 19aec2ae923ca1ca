//! Tests of the mapping against known answers, and of its behaviour in the hard cases.

use super::*;
use glam::{DVec2, DVec3};
use proptest::prelude::*;
use std::f64::consts::TAU;

const POLYNOMIAL: Kernel = Kernel::Polynomial { beta: [0.0, 0.25, 0.25, 0.5, 0.0, 0.0, 0.0, 0.0] };

fn kernels() -> Vec<Kernel> {
    let mut kernels: Vec<_> = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0].map(|alpha| Kernel::Power { alpha }).into();
    let made = |beta: &[f64]| Kernel::polynomial(beta).expect("a valid kernel");
    // The second one is flat at both ends, the third has all coefficients.
    kernels.extend([
        POLYNOMIAL,
        made(&[0.0, 0.0, 3.0, -2.0]),
        made(&[0.0, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.4]),
        // Without low powers: Newton's method alone is slow at 0.
        made(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.25, 0.75]),
        Kernel::Sine,
        Kernel::Exponential,
    ]);
    kernels
}

/// Gazes on corners, edges and off the display.
pub(super) fn hard_gazes(size_px: [u32; 2]) -> Vec<DVec2> {
    let size = DVec2::new(f64::from(size_px[0]), f64::from(size_px[1]));
    vec![
        size / 2.0,
        DVec2::ZERO,
        size,
        DVec2::new(size.x, 0.0),
        DVec2::new(size.x / 2.0, size.y),
        DVec2::new(0.3 * size.x + 0.123, 0.4 * size.y + 0.377),
        DVec2::new(-1.0, size.y / 3.0),
        DVec2::new(size.x / 2.0, size.y + 1.0),
        DVec2::new(2.0 * size.x, -size.y),
        DVec2::new(1e6, 1e6),
        DVec2::new(-1e12, 3.0),
        DVec2::new(f64::MAX, f64::MIN),
        DVec2::new(f64::NAN, 1.0),
        DVec2::new(f64::INFINITY, f64::NEG_INFINITY),
    ]
}

// --- Known answers -------------------------------------------------------------------------------

struct Known {
    size_px: [u32; 2],
    gaze_px: [f64; 2],
    kernel: Kernel,
    /// x and y in px, `u_norm`, `v_norm`
    points: [[f64; 4]; 5],
}

#[rustfmt::skip]
const KNOWN: [Known; 8] = [
    Known {
        size_px: [11520, 6480],
        gaze_px: [5760.0, 3240.0],
        kernel: Kernel::Power { alpha: 1.0 },
        points: [
            [5757.0, 3240.001, 0.12489701820473782, 0.4999469483542568],
            [5763.0, 3239.999, 0.12489701820473782, 0.9999469483542568],
            [0.5, 0.5, 0.9999882859836198, 0.5815447234109806],
            [11519.5, 0.5, 0.9999882859836198, 0.9184552765890194],
            [1391.5, 5937.5, 0.9712987124908209, 0.41195870203658436],
        ],
    },
    Known {
        size_px: [7680, 4320],
        gaze_px: [3978.2400000000002, 3853.44],
        kernel: Kernel::Power { alpha: 2.0 },
        points: [
            [3975.2400000000002, 3853.4410000000003, 0.016245244179619155, 0.4999469483542568],
            [3981.2400000000002, 3853.439, 0.016245244179619155, 0.9999469483542568],
            [0.5, 0.5, 0.9999703784391449, 0.6224637125418393],
            [2820.5, 3663.5, 0.6723099920682526, 0.5258805645522737],
            [1858.5, 3850.5, 0.7895635074962962, 0.5002207418044916],
        ],
    },
    Known {
        size_px: [11520, 6480],
        gaze_px: [5034.24, 4082.4],
        kernel: Kernel::Exponential,
        points: [
            [5031.24, 4082.4010000000003, 0.07605917411849926, 0.4999469483542568],
            [5037.24, 4082.399, 0.07605917411849926, 0.9999469483542568],
            [0.5, 0.5, 0.97062472956326, 0.6084413118397742],
            [8627.5, 6139.5, 0.8947667534166377, 0.08275177976020993],
            [3486.5, 2399.5, 0.7999076839273885, 0.631654670474056],
        ],
    },
    Known {
        size_px: [11520, 6480],
        gaze_px: [5034.24, 4082.4],
        kernel: Kernel::Power { alpha: 6.0 },
        points: [
            [5031.24, 4082.4010000000003, 3.434047175660673e-06, 0.4999469483542568],
            [5037.24, 4082.399, 3.434047175660673e-06, 0.9999469483542568],
            [0.5, 0.5, 0.8926801474842874, 0.6084413118397742],
            [11519.5, 0.5, 0.9999396444966712, 0.9105922201636047],
            [8211.5, 1970.5, 0.614368346200783, 0.9066342303023763],
        ],
    },
    Known {
        size_px: [7680, 4320],
        gaze_px: [3978.2400000000002, 3853.44],
        kernel: Kernel::Power { alpha: 4.0 },
        points: [
            [3975.2400000000002, 3853.4410000000003, 0.00026390795845545, 0.4999469483542568],
            [3981.2400000000002, 3853.439, 0.00026390795845545, 0.9999469483542568],
            [0.5, 0.5, 0.9999407577557268, 0.6224637125418393],
            [2820.5, 3663.5, 0.4520007254348139, 0.5258805645522737],
            [1806.5, 836.5, 0.8274112811876355, 0.650699518255409],
        ],
    },
    Known {
        size_px: [7680, 4320],
        gaze_px: [3840.0, 2160.0],
        kernel: POLYNOMIAL,
        points: [
            [3837.0, 2160.001, 0.038141246827929916, 0.4999469483542568],
            [3843.0, 2159.999, 0.038141246827929916, 0.9999469483542568],
            [0.5, 0.5, 0.9999585543535179, 0.5815424270632517],
            [4362.5, 4118.5, 0.8063994743954013, 0.20850613902522777],
            [6603.5, 1961.5, 0.880879092681603, 0.988587627624794],
        ],
    },
    Known {
        size_px: [11520, 6480],
        gaze_px: [5760.0, 3240.0],
        kernel: Kernel::Power { alpha: 3.0 },
        points: [
            [5757.0, 3240.001, 0.001948301704223746, 0.4999469483542568],
            [5763.0, 3239.999, 0.001948301704223746, 0.9999469483542568],
            [0.5, 0.5, 0.9999648583625123, 0.5815447234109806],
            [11519.5, 0.5, 0.9999648583625123, 0.9184552765890194],
            [2081.5, 225.5, 0.8919348978801112, 0.6092620335777553],
        ],
    },
    Known {
        size_px: [11520, 6480],
        gaze_px: [5034.24, 4082.4],
        kernel: Kernel::Sine,
        points: [
            [5031.24, 4082.4010000000003, 0.19174457655357463, 0.4999469483542568],
            [5037.24, 4082.399, 0.19174457655357463, 0.9999469483542568],
            [0.5, 0.5, 0.9995666195149899, 0.6084413118397742],
            [10644.5, 841.5, 0.9995652643565535, 0.9166280579656864],
            [8211.5, 1970.5, 0.9925064920864198, 0.9066342303023763],
        ],
    },
];

fn assert_close(mapping: &KfrMapping, point: [f64; 4]) {
    let lp = mapping.forward(DVec2::new(point[0], point[1]));
    assert!((lp.u_norm - point[2]).abs() <= 1e-9, "u of {point:?} is {}", lp.u_norm);
    assert!((lp.v_norm - point[3]).abs() <= 1e-9, "v of {point:?} is {}", lp.v_norm);
}

#[test]
fn known_answers() {
    for known in &KNOWN {
        let mapping = KfrMapping::new(known.size_px, DVec2::from(known.gaze_px), known.kernel, 1.8);
        for point in known.points {
            assert_close(&mapping, point);
        }
    }
}

#[test]
fn all_known_answers_of_the_oracle() {
    let root = std::env::var_os("MACULA_SHARED").map_or_else(
        || std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"),
        std::path::PathBuf::from,
    );
    let Ok(text) = std::fs::read_to_string(root.join("oracle/mapping.json")) else {
        println!("skipped: no oracle/mapping.json under MACULA_SHARED");
        return;
    };
    let oracle: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    let mut count = 0;
    for case in oracle["cases"].as_array().expect("cases").iter().filter(|case| case["method"] == "kfr") {
        let size_px = ["width_px", "height_px"].map(|side| number(&case["display"][side]) as u32);
        let gaze_px = DVec2::new(number(&case["gaze_px"][0]), number(&case["gaze_px"][1]));
        let kernel = match case["kernel"]["type"].as_str() {
            Some("pow") => Kernel::Power { alpha: number(&case["kernel"]["alpha"]) },
            Some("sin") => Kernel::Sine,
            Some("exp") => Kernel::Exponential,
            _ => {
                let beta = case["kernel"]["beta"].as_array().expect("coefficients");
                Kernel::polynomial(&beta.iter().map(number).collect::<Vec<_>>()).expect("valid")
            }
        };
        let mapping = KfrMapping::new(size_px, gaze_px, kernel, 1.8);
        for point in case["points"].as_array().expect("points") {
            assert_close(&mapping, ["x", "y", "u_norm", "v_norm"].map(|name| number(&point[name])));
            count += 1;
        }
    }
    assert!(count >= 700, "the oracle has only {count} points");
}

// --- Kernels -------------------------------------------------------------------------------------

#[test]
fn kernels_rise_from_0_to_1_and_invert() {
    for kernel in kernels() {
        kernel.check().expect("valid");
        assert_eq!((kernel.eval(0.0), kernel.eval(1.0)), (0.0, 1.0));
        assert_eq!((kernel.inverse(0.0), kernel.inverse(1.0)), (0.0, 1.0));
        assert_eq!(
            (kernel.eval(-3.0), kernel.eval(7.0), kernel.inverse(-1.0), kernel.inverse(2.0)),
            (0.0, 1.0, 0.0, 1.0)
        );
        let mut last = 0.0;
        for step in 1..=2000 {
            let x = f64::from(step) / 2000.0;
            let y = kernel.eval(x);
            assert!(y >= last, "{kernel:?} falls at {x}");
            last = y;
            // What one ulp of y is worth, where the kernel is flat.
            let slack = 1e-12 + 4.0 * f64::EPSILON / kernel.derivative(x).max(1e-8);
            assert!((kernel.inverse(y) - x).abs() <= slack, "{kernel:?} at {x}");
            let step = 1e-6;
            let difference = (kernel.eval(x - 2.0 * step) - kernel.eval(x - 3.0 * step)) / step;
            let slope = kernel.derivative(x - 2.5 * step);
            assert!((difference - slope).abs() <= 1e-6, "{kernel:?} at {x}: {difference} {slope}");
        }
    }
}

#[test]
fn kernels_keep_relative_precision_at_their_ends() {
    for kernel in kernels() {
        for exponent in 1..=15 {
            let x = 10.0_f64.powi(-exponent);
            let back = kernel.inverse(kernel.eval(x));
            assert!((back / x - 1.0).abs() < 1e-12, "{kernel:?} at {x}: {back}");
            let y = 10.0_f64.powi(-exponent);
            assert!((kernel.eval(kernel.inverse(y)) / y - 1.0).abs() < 1e-12, "{kernel:?} at {y}");
            assert!((kernel.eval(kernel.inverse(1.0 - y)) - (1.0 - y)).abs() < 1e-14, "{kernel:?} at 1-{y}");
        }
    }
}

#[test]
fn bad_kernels_are_refused_in_one_line() {
    let polynomial = |beta: &[f64]| Kernel::polynomial(beta).map(|_| ());
    // Falls only between 0.49 and 0.51: its slope is c ((x - 0.5)^2 - 1e-4).
    let c = 1.0 / (1.0 / 3.0 - 0.5 + 0.2499);
    let dip = [0.0, 0.2499 * c, -0.5 * c, c / 3.0];
    let refused = [
        Kernel::Power { alpha: 0.99 }.check(),
        Kernel::Power { alpha: 6.01 }.check(),
        Kernel::Power { alpha: f64::NAN }.check(),
        polynomial(&[]),
        polynomial(&[0.1, 0.9]),
        polynomial(&[0.0, 0.5, 0.4]),
        polynomial(&[0.0, 0.5, f64::NAN]),
        polynomial(&[0.0, f64::INFINITY]),
        polynomial(&[0.0, 3.0, -2.0]),
        polynomial(&dip),
        polynomial(&[0.0, 0.2, 0.2, 0.2, 0.1, 0.1, 0.1, 0.05, 0.05]),
    ];
    for (index, result) in refused.into_iter().enumerate() {
        let message = result.expect_err(&format!("kernel {index}")).to_string();
        assert!(!message.contains('\n') && message.len() < 120, "{message}");
    }
    // Touches a slope of 0 in the middle without falling: (1 + (2x - 1)^3) / 2.
    polynomial(&[0.0, 3.0, -6.0, 4.0]).expect("rises");
}

// --- Mapping -------------------------------------------------------------------------------------

#[test]
fn round_trip_on_a_large_display() {
    let size_px = [11520, 6480];
    for kernel in kernels() {
        for gaze_px in &hard_gazes(size_px)[..9] {
            let mapping = KfrMapping::new(size_px, *gaze_px, kernel, 1.8);
            let mut worst = 0.0_f64;
            for step in 0..4000_u32 {
                let px = DVec2::new(f64::from(step * 7919 % 11520), f64::from(step * 104_729 % 6480)) + 0.5;
                let radius_px = (px - *gaze_px).length();
                // Where the kernel is flat a step of u is many pixels wide, whatever the precision.
                if radius_px > 1.0 && mapping.texel_area_px(radius_px) < 1e4 {
                    worst = worst.max((mapping.inverse(mapping.forward(px)) - px).length());
                }
            }
            assert!(worst < 1e-6, "{kernel:?} with the gaze at {gaze_px}: {worst} px");
        }
    }
}

#[test]
fn seam_from_both_sides() {
    let gaze_px = DVec2::new(800.0, 450.0);
    let mapping = KfrMapping::new([1600, 900], gaze_px, Kernel::Power { alpha: 4.0 }, 1.8);
    for exponent in 0..300 {
        let y = 10.0_f64.powi(-exponent);
        // From the gaze's own row, as adding 1e-20 px to a position would round away.
        let origin = KfrMapping::new([1600, 900], DVec2::ZERO, Kernel::Power { alpha: 4.0 }, 1.8);
        let below = origin.forward(DVec2::new(100.0, y));
        let above = origin.forward(DVec2::new(100.0, -y));
        for lp in [below, above] {
            assert!((0.0..1.0).contains(&lp.v_norm), "{lp:?} at {y}");
        }
        let gap = (below.v_norm - above.v_norm).rem_euclid(1.0);
        assert!((gap - 2.0 * (y / 100.0).atan() / TAU).abs() < 1e-15);
    }
    let right = mapping.inverse(LpCoord { u_norm: 0.5, v_norm: 0.0 });
    let wrapped = mapping.inverse(LpCoord { u_norm: 0.5, v_norm: 1.0 });
    assert!((right - wrapped).length() < 1e-10);
    // The azimuth rises downwards.
    assert_eq!(mapping.forward(gaze_px + DVec2::new(0.0, 50.0)).v_norm, 0.25);
    assert_eq!(mapping.forward(gaze_px - DVec2::new(0.0, 50.0)).v_norm, 0.75);
}

#[test]
fn density_is_the_jacobian() {
    let gaze_px = DVec2::new(939.52, 371.52);
    for kernel in kernels() {
        let mapping = KfrMapping::new([2560, 1440], gaze_px, kernel, 1.8);
        let [width, height] = mapping.lp_size().map(f64::from);
        for step in 0..2000 {
            let angle = f64::from(step) * 2.4;
            let radius_px = 1.2 * (mapping.reach_px() * 0.8).powf(f64::from(step) / 2000.0);
            let px = gaze_px + DVec2::from_angle(angle) * radius_px;
            let h = 1e-4 * radius_px;
            let difference = |step: DVec2| {
                let (after, before) = (mapping.forward(px + step), mapping.forward(px - step));
                let dv = (after.v_norm - before.v_norm + 0.5).rem_euclid(1.0) - 0.5;
                DVec2::new(after.u_norm - before.u_norm, dv) / (2.0 * h)
            };
            let (by_x, by_y) = (difference(DVec2::X * h), difference(DVec2::Y * h));
            let measured = by_x.x * by_y.y - by_y.x * by_x.y;
            let analytic = mapping.jacobian(px).determinant();
            let density = mapping.density_per_px2(radius_px);
            assert!(
                (measured / analytic - 1.0).abs() < 0.01,
                "{kernel:?} at {radius_px} px: {measured} {analytic}"
            );
            assert!((analytic * width * height / density - 1.0).abs() < 1e-9);
            assert!((density * mapping.texel_area_px(radius_px) - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn larger_alpha_moves_samples_to_the_edge() {
    let density = |alpha: f64, radius_px: f64| {
        KfrMapping::new([2560, 1440], DVec2::new(1280.0, 720.0), Kernel::Power { alpha }, 1.8)
            .density_per_px2(radius_px)
    };
    for alpha in 1..6 {
        let alpha = f64::from(alpha);
        assert!(density(alpha + 1.0, 1400.0) > density(alpha, 1400.0));
        assert!(density(alpha + 1.0, 5.0) < density(alpha, 5.0));
    }
}

#[test]
fn native_disc_ends_where_texels_outgrow_pixels() {
    for kernel in kernels() {
        for (size_px, sigma) in
            [([1920, 1080], 1.8), ([3840, 2160], 1.0), ([2560, 1440], 3.0), ([640, 480], 40.0)]
        {
            for gaze_px in hard_gazes(size_px) {
                let mapping = KfrMapping::new(size_px, gaze_px, kernel, sigma);
                let radius_px = mapping.native_radius_px();
                assert!(radius_px >= 3.0 && radius_px <= mapping.reach_px() * (1.0 + 1e-9));
                if radius_px > 3.0 && radius_px < 0.999 * mapping.reach_px() {
                    assert!(
                        (mapping.texel_area_px(radius_px) - 1.0).abs() < 1e-6,
                        "{kernel:?}: {radius_px} px"
                    );
                }
                for step in 1..=200 {
                    let outside_px =
                        radius_px * (mapping.reach_px() / radius_px).powf(f64::from(step) / 200.0);
                    assert!(mapping.texel_area_px(outside_px) >= 1.0 - 1e-6 || outside_px <= radius_px);
                    let filtered = mapping.forward(mapping.gaze_px() + DVec2::X * outside_px).u_norm;
                    if filtered > mapping.filter_start_u() + 1e-9 && filtered < 1.0 {
                        assert!(mapping.texel_area_px(outside_px) >= 4.0 * (1.0 - 1e-6));
                    }
                }
                let band_px = mapping.blend_band_px();
                assert!((1.0..=8.0).contains(&band_px) && band_px <= (radius_px * 0.1).max(1.0));
                assert!((0.0..=1.0).contains(&mapping.filter_start_u()));
            }
        }
    }
}

#[test]
fn nothing_is_non_finite_and_the_block_has_its_layout() {
    assert_eq!(size_of::<FoveaParams>(), 448);
    for size_px in [[1, 1], [1, 7], [2, 2], [13, 1], [1920, 1080], [11520, 6480]] {
        for gaze_px in hard_gazes(size_px) {
            for kernel in kernels() {
                for sigma in [0.5, 1.0, 1.8, 3.7, 1e9] {
                    let mapping = KfrMapping::new(size_px, gaze_px, kernel, sigma);
                    let [width, height] = mapping.lp_size();
                    assert!(width >= 1 && height >= 1);
                    for px in [
                        DVec2::ZERO,
                        DVec2::splat(0.5),
                        mapping.gaze_px(),
                        mapping.gaze_px() + 0.4,
                        DVec2::splat(1e9),
                    ] {
                        let lp = mapping.forward(px);
                        assert!(
                            (0.0..=1.0).contains(&lp.u_norm) && (0.0..1.0).contains(&lp.v_norm),
                            "{lp:?}"
                        );
                        assert!(
                            mapping.inverse(lp).is_finite() && mapping.jacobian(px).determinant().is_finite()
                        );
                        assert!(!mapping.texel_area_px(px.distance(mapping.gaze_px())).is_nan());
                    }
                    let params = FoveaParams::new(&mapping);
                    let floats = [
                        params.gaze_px,
                        params.size_f,
                        params.log_reach,
                        params.octave,
                        params.shape,
                        params.ring,
                    ];
                    assert!(floats.as_flattened().iter().all(|value| value.is_finite()), "{params:?}");
                    assert!(params.beta_hi.as_flattened().iter().all(|value| value.is_finite()));
                }
            }
        }
    }
}

#[test]
fn sizes_of_the_lp_buffer() {
    let lp_size = |size_px, sigma| KfrMapping::new(size_px, DVec2::ZERO, Kernel::Sine, sigma).lp_size();
    assert_eq!(lp_size([1920, 1080], 1.8), [1067, 600]);
    assert_eq!(lp_size([2560, 1440], 1.8), [1422, 800]);
    assert_eq!(lp_size([1, 1], 1.8), [1, 1]);
    assert_eq!(lp_size([1920, 1080], 1e6), [1, 1]);
    assert_eq!(lp_size([101, 53], 1.0), [101, 53]);
    assert_eq!(lp_size([100, 50], 0.5), [200, 100]);
}

#[test]
fn parameter_pairs_carry_double_precision() {
    let gaze_px = DVec2::new(3978.2400000000002, 9_999_999.123_456);
    let mapping = KfrMapping::new([7680, 4320], gaze_px, Kernel::Power { alpha: 2.3 }, 1.8);
    let params = FoveaParams::new(&mapping);
    let sum = |hi: f32, lo: f32| f64::from(hi) + f64::from(lo);
    let used = mapping.gaze_px();
    assert!((sum(params.gaze_px[0], params.gaze_px[2]) - used.x).abs() < 1e-9);
    assert!((sum(params.gaze_px[1], params.gaze_px[3]) - used.y).abs() < 1e-7);
    assert!(
        (sum(params.log_reach[0], params.log_reach[1]) - mapping.log_reach()).abs()
            < 1e-14 * mapping.log_reach()
    );
    assert!((sum(params.log_reach[2], params.log_reach[3]) * mapping.log_reach() - 1.0).abs() < 1e-14);
    assert_eq!((params.kernel[0], params.kernel[1]), (0, 0));
    let four = FoveaParams::new(&KfrMapping::new([8, 8], DVec2::ONE, Kernel::Power { alpha: 4.0 }, 1.0));
    assert_eq!(four.kernel, [0, 4, 0, 0]);
    let polynomial = FoveaParams::new(&KfrMapping::new([8, 8], DVec2::ONE, POLYNOMIAL, 1.0));
    assert_eq!(polynomial.kernel, [1, 0, 4, 0]);
    // Whatever the octave's head is multiplied by, the product is exact.
    for factor in 1..=60_u8 {
        let product = f64::from(params.octave[0]) * f64::from(factor);
        assert_eq!(f64::from(product as f32), product);
    }
}

#[test]
fn gaze_keeper_holds_the_last_valid_gaze() {
    let mut keeper = GazeKeeper::new(DVec2::new(960.0, 540.0));
    assert_eq!(keeper.accept(DVec2::new(f64::NAN, 0.0)), (DVec2::new(960.0, 540.0), false));
    assert_eq!(keeper.accept(DVec2::new(-5.0, 2000.0)), (DVec2::new(-5.0, 2000.0), true));
    assert_eq!(keeper.accept(DVec2::new(0.0, f64::INFINITY)), (DVec2::new(-5.0, 2000.0), false));
    let (far, valid) = keeper.accept(DVec2::new(3e300, -4e300));
    assert!(valid && (far - DVec2::new(6e6, -8e6)).length() < 1e-6, "{far}");
    assert!((keeper.accept(DVec2::splat(f64::MAX)).0.length() - MAX_GAZE_PX).abs() < 1e-6);
}

// --- Display -------------------------------------------------------------------------------------

#[test]
fn display_rays() {
    let display = DisplayGeometry::symmetric([1920, 1080], 90.0);
    assert_eq!(display.center_px(), DVec2::new(960.0, 540.0));
    assert!(display.ray_of_px(display.center_px()).abs_diff_eq(DVec3::NEG_Z, 1e-15));
    let edge_rad = display.eccentricity_rad(display.center_px(), DVec2::new(1920.0, 540.0));
    assert!((edge_rad.to_degrees() - 45.0).abs() < 1e-12);
    let across_rad = display.eccentricity_rad(DVec2::new(0.0, 540.0), DVec2::new(1920.0, 540.0));
    assert!((across_rad.to_degrees() - 90.0).abs() < 1e-12);
    assert_eq!(display.eccentricity_rad(DVec2::ONE, DVec2::ONE), 0.0);
    // Small angles keep their digits: 1e-9 px at the centre is 1e-9/960 rad.
    let tiny_rad =
        display.eccentricity_rad(DVec2::new(960.0, 540.0), DVec2::new(960.0 + 1.0 / 1024.0, 540.0));
    assert!((tiny_rad * 960.0 * 1024.0 - 1.0).abs() < 1e-9);
    for ray in [DVec3::X, DVec3::Z, DVec3::ZERO, DVec3::NAN, DVec3::new(1.0, 1.0, -1e-320)] {
        assert_eq!(display.px_of_ray(ray), None);
    }
    assert_eq!(display.farthest_corner_px(DVec2::new(920.0, 1080.0 - 80.0)), 1000.0_f64.hypot(1000.0));
}

proptest! {
    #[test]
    fn display_round_trip(
        x in -1e4_f64..2e4, y in -1e4_f64..2e4, left in -2.0_f64..-0.2, right in 0.1_f64..2.0,
        up in 0.1_f64..2.0, down in -2.0_f64..0.05, length in 1e-6_f64..1e6,
    ) {
        let display = DisplayGeometry {
            size_px: [1440, 1600], tan_left: left, tan_right: right, tan_up: up, tan_down: down,
        };
        display.check().expect("a valid frustum");
        let px = DVec2::new(x, y);
        let back = display.px_of_ray(display.ray_of_px(px) * length).expect("ahead of the eye");
        prop_assert!((back - px).length() < 1e-8);
    }

    #[test]
    fn mapping_round_trip(
        kernel in 0_usize..12, width in 1_u32..12_000, height in 1_u32..7_000, sigma in 0.7_f64..8.0,
        gaze in (-0.5_f64..1.5, -0.5_f64..1.5), at in (0.0_f64..1.0, 0.0_f64..1.0),
    ) {
        let size = DVec2::new(f64::from(width), f64::from(height));
        let mapping = KfrMapping::new([width, height], size * DVec2::from(gaze), kernels()[kernel], sigma);
        let px = size * DVec2::from(at);
        let radius_px = px.distance(mapping.gaze_px());
        prop_assume!(radius_px > 1.0 && mapping.texel_area_px(radius_px) < 1e4);
        let back = mapping.inverse(mapping.forward(px));
        prop_assert!((back - px).length() < 1e-6, "{px} came back as {back}");
    }
}
