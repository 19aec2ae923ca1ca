use super::*;
use crate::quality::compare;
use std::f64::consts::{PI, TAU};

/// The pivots of VaFR 2025 with a MAR that is linear between them and goes on beyond the last one.
fn vafr_cpd(ecc_deg: f64) -> f64 {
    const PIVOTS: [[f64; 2]; 5] = [[0.0, 40.0], [10.0, 10.0], [20.0, 6.0], [30.0, 5.0], [60.0, 4.0]];
    let segment = PIVOTS.windows(2).rfind(|pair| pair[0][0] <= ecc_deg).unwrap();
    let share = (ecc_deg - segment[0][0]) / (segment[1][0] - segment[0][0]);
    1.0 / (1.0 / segment[0][1] + share * (1.0 / segment[1][1] - 1.0 / segment[0][1]))
}

fn noise(length: usize, seed: u32) -> Vec<f32> {
    let mut state = seed;
    let next = |_| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1_u32 << 24) as f32
    };
    (0..length).map(next).collect()
}

fn grey(values: &[f32]) -> Vec<f32> {
    values.iter().flat_map(|&value| [value; 3]).collect()
}

/// A display so far away that its pixels per degree are the same everywhere to 0.1 %.
fn distant(size_px: [u32; 2]) -> (DisplayGeometry, f64) {
    let display = DisplayGeometry::symmetric(size_px, 4.0);
    let density = pixels_per_degree(&display, size_px[0] as usize / 2, size_px[1] as usize / 2);
    (display, density)
}

/// The spatially varying Gaussian in double precision, in the cosine transform of the picture: the
/// cosines are the eigenvectors of every symmetric filter on a row that goes on as its mirror image, and
/// a Gaussian's eigenvalues are its transfer at their frequencies.
fn exact(values: &[f32], [width, height]: [usize; 2], sigma_px: &[f64]) -> Vec<f64> {
    let table = |count: usize| -> Vec<Vec<f64>> {
        let wave = |k: usize, at: usize| (PI * k as f64 * (at as f64 + 0.5) / count as f64).cos();
        (0..count).map(|k| (0..count).map(|at| wave(k, at)).collect()).collect()
    };
    let (across, down) = (table(width), table(height));
    let mut spectrum = vec![0.0; width * height];
    for (k, sum) in spectrum.iter_mut().enumerate() {
        let (kx, ky) = (k % width, k / width);
        let norm = |k: usize, count: usize| if k == 0 { 1.0 } else { 2.0 } / count as f64;
        for (at, &value) in values.iter().enumerate() {
            *sum += f64::from(value) * across[kx][at % width] * down[ky][at / width];
        }
        *sum *= norm(kx, width) * norm(ky, height);
    }
    let pixel = |at: usize| {
        let transfer =
            |k: usize, count: usize| (-0.5 * (sigma_px[at] * PI * k as f64 / count as f64).powi(2)).exp();
        let rows: Vec<f64> = (0..width).map(|k| across[k][at % width] * transfer(k, width)).collect();
        let columns: Vec<f64> = (0..height).map(|k| down[k][at / width] * transfer(k, height)).collect();
        let terms = spectrum.iter().enumerate();
        terms.map(|(k, value)| value * rows[k % width] * columns[k / width]).sum::<f64>()
    };
    (0..width * height).map(pixel).collect()
}

/// The same as a sum over pixels and their mirror images, each weighted by the Gaussian itself.
fn weighted_sum(values: &[f32], [width, height]: [usize; 2], at: usize, sigma_px: f64) -> f64 {
    let side = |at: usize, count: usize| -> Vec<f64> {
        let reach = (8.0 * sigma_px).ceil() as isize;
        let mut weights = vec![0.0; count];
        for step in -reach..=reach {
            let to = (at as isize + step).rem_euclid(2 * count as isize) as usize;
            weights[to.min(2 * count - 1 - to)] += (-0.5 * (step as f64 / sigma_px).powi(2)).exp();
        }
        let sum: f64 = weights.iter().sum();
        weights.iter().map(|weight| weight / sum).collect()
    };
    let (across, down) = (side(at % width, width), side(at / width, height));
    let terms = values.iter().enumerate();
    terms.map(|(at, &value)| f64::from(value) * across[at % width] * down[at / width]).sum()
}

/// Every pixel's sigma by the definition, px; 0 without a filter.
fn sigmas(display: &DisplayGeometry, gaze_px: DVec2, cutoff_cpd: impl Fn(f64) -> f64) -> Vec<f64> {
    let [width, height] = display.size_px.map(|side| side as usize);
    let sigma = |at: usize| {
        let px = DVec2::new((at % width) as f64 + 0.5, (at / width) as f64 + 0.5);
        let cutoff = cutoff_cpd(display.eccentricity_rad(gaze_px, px).to_degrees());
        let density = pixels_per_degree(display, at % width, at / width);
        if cutoff >= density / 2.0 { 0.0 } else { density * 0.187_390_625 / cutoff }
    };
    (0..width * height).map(sigma).collect()
}

#[test]
fn the_low_pass_is_the_spatially_varying_gaussian() {
    // Sizes below a tile, odd ones, several tiles; sigma from 0 to 2, 12 and 60 px.
    let cases = [([48, 32], 0.1), ([61, 45], 0.04), ([97, 70], 0.004)];
    for (size_px, scale) in cases {
        let size = size_px.map(|side| side as usize);
        let display = DisplayGeometry { tan_left: -0.3, ..DisplayGeometry::symmetric(size_px, 80.0) };
        let gaze = DVec2::new(0.3, 0.6) * DVec2::new(f64::from(size_px[0]), f64::from(size_px[1]));
        let cutoff = |ecc_deg: f64| scale * vafr_cpd(ecc_deg) / (1.0 + (0.1 * ecc_deg).powi(2) / 10.0);
        let sigma = sigmas(&display, gaze, cutoff);
        let values = noise(size[0] * size[1], 7);
        let low_pass = AcuityLowPass::new(&display, gaze, cutoff).unwrap();
        let found = low_pass.filter(Picture::Linear(&grey(&values))).unwrap();
        let expected = exact(&values, size, &sigma);
        let (mut worst, mut squares, mut filtered) = (0.0_f64, 0.0, 0);
        for (at, pixel) in found.chunks_exact(3).enumerate() {
            assert!(pixel[0] == pixel[1] && pixel[0] == pixel[2]);
            if sigma[at] == 0.0 {
                assert_eq!(pixel[0], values[at]);
                continue;
            }
            let off = (f64::from(pixel[0]) - expected[at]).abs();
            worst = worst.max(off);
            squares += off * off;
            filtered += 1;
            if at % 37 == 0 && sigma[at] >= 1.0 {
                let sum = weighted_sum(&values, size, at, sigma[at]);
                assert!((sum - expected[at]).abs() < 0.003, "sigma {}: {sum}", sigma[at]);
            }
        }
        let rms = (squares / f64::from(filtered)).sqrt();
        assert!(filtered > 500 && worst < 0.01 && rms < 0.002, "{size_px:?}: {worst}, {rms}");
    }
}

#[test]
fn density_is_the_area_of_a_square_degree() {
    let lopsided = DisplayGeometry {
        tan_left: -0.4,
        tan_right: 1.4,
        tan_up: 0.6,
        ..DisplayGeometry::symmetric([160, 90], 100.0)
    };
    for (column, row) in [(0, 0), (159, 0), (70, 45), (3, 89)] {
        let px = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
        let (outward, across) = lopsided.steps_per_degree(DVec2::new(20.0, 30.0), px).unwrap();
        let area = outward.perp_dot(across).abs();
        let found = pixels_per_degree(&lopsided, column, row);
        assert!((found / area.sqrt() - 1.0).abs() < 1e-9, "{found}, not {}", area.sqrt());
    }
}

/// The share of a grating's amplitude that is left, of a display without foveation.
fn left_of_grating(cycles_per_cutoff: f64, cutoff_px: f64, tilt_deg: f64) -> f64 {
    let (display, density) = distant([160, 128]);
    let frequency = cycles_per_cutoff * cutoff_px;
    let wave = |at: usize| {
        let (x, y) = ((at % 160) as f64, (at / 160) as f64);
        let (sin, cos) = tilt_deg.to_radians().sin_cos();
        TAU * frequency * (x * cos + y * sin)
    };
    let picture: Vec<f32> = (0..160 * 128).map(|at| 0.5 + 0.4 * wave(at).cos() as f32).collect();
    let low_pass = AcuityLowPass::new(&display, DVec2::new(80.0, 64.0), |_| cutoff_px * density).unwrap();
    let found = low_pass.filter(Picture::Linear(&grey(&picture))).unwrap();
    // The amplitude of the grating's own frequency away from the edges, by least squares.
    let (mut even, mut odd, mut norm) = (0.0, 0.0, 0.0);
    for at in 0..160 * 128 {
        let (x, y) = (at % 160, at / 160);
        let window = |at: usize, count: usize| (PI * (at as f64 + 0.5) / count as f64).sin().powi(4);
        let weight = window(x, 160) * window(y, 128);
        even += weight * (f64::from(found[3 * at]) - 0.5) * wave(at).cos();
        odd += weight * (f64::from(found[3 * at]) - 0.5) * wave(at).sin();
        norm += weight * 0.5;
    }
    even.hypot(odd) / norm / 0.4
}

#[test]
fn gratings_are_left_as_the_definition_says() {
    // Cutoffs from the grid's Nyquist frequency to one that is filtered on a halved grid.
    for cutoff_px in [0.49, 0.35, 0.2, 0.08, 0.02] {
        for tilt_deg in [0.0, 90.0, 37.0] {
            for (cycles, left) in [(0.25, 0.9576), (0.5, 0.8409), (1.0, 0.5), (2.0, 0.0625), (3.0, 0.00195)] {
                // What the grid holds, and what the display shows at least two cycles of.
                if !(0.016..=0.5).contains(&(cycles * cutoff_px)) {
                    continue;
                }
                let found = left_of_grating(cycles, cutoff_px, tilt_deg);
                assert!(
                    (found - left).abs() < 0.02,
                    "{found} of the amplitude is left at {cycles} times a cutoff of {cutoff_px}/px, tilted by \
                     {tilt_deg}; {left} is right"
                );
            }
        }
    }
}

#[test]
fn a_faint_grating_becomes_the_error_that_is_left_of_it() {
    let (display, density) = distant([128, 96]);
    let cutoff = 0.125 * density;
    for (period_px, left) in [(64.0, 0.9576_f64.powf(0.25)), (8.0, 0.5), (4.0, 0.0625)] {
        let wave = |at: usize| (TAU * ((at % 128) as f64 + 0.5) / period_px).cos() as f32;
        let a = vec![0.5; 3 * 128 * 96];
        let b = grey(&(0..128 * 96).map(|at| 0.5 + 0.01 * wave(at)).collect::<Vec<_>>());
        let gaze = DVec2::new(64.0, 48.0);
        let error = |cutoff: f64| {
            acuity_error(Picture::Linear(&a), Picture::Linear(&b), &display, gaze, |_| cutoff).unwrap()
        };
        // The encoding's slope at 0.5, and the RMS of a cosine.
        let unfiltered = 0.01 * 1.055 / 2.4 * 0.5_f64.powf(1.0 / 2.4 - 1.0) / 2_f64.sqrt();
        let (sharp, found) = (error(f64::INFINITY), error(cutoff));
        assert!((sharp.rmse / unfiltered - 1.0).abs() < 1e-3, "{}", sharp.rmse);
        assert!((found.rmse / unfiltered - left).abs() < 0.01, "period {period_px}: {}", found.rmse);
        assert!((found.psnr_db + 20.0 * found.rmse.log10()).abs() < 1e-9);
    }
}

#[test]
fn equal_pictures_leave_no_error() {
    let display = DisplayGeometry::symmetric([150, 83], 90.0);
    let a = noise(3 * 150 * 83, 3);
    let error =
        acuity_error(Picture::Linear(&a), Picture::Linear(&a), &display, DVec2::new(9.0, 70.0), |ecc_deg| {
            0.05 * vafr_cpd(ecc_deg)
        })
        .unwrap();
    assert_eq!((error.rmse, error.psnr_db), (0.0, f64::INFINITY));
    for ring in error.rings.iter().filter(|ring| ring.pixels > 0) {
        assert_eq!((ring.rmse, ring.psnr_db), (Some(0.0), Some(f64::INFINITY)));
    }
}

#[test]
fn constants_survive_up_to_the_edges() {
    // Sigma from below 1 px to beyond the display.
    for scale in [0.3, 0.03, 1e-3, 1e-30] {
        let display = DisplayGeometry::symmetric([67, 131], 70.0);
        let cutoff = |ecc_deg: f64| scale * vafr_cpd(ecc_deg);
        let low_pass = AcuityLowPass::new(&display, DVec2::ZERO, cutoff).unwrap();
        let flat = low_pass.filter(Picture::Linear(&[0.625; 3 * 67 * 131])).unwrap();
        assert!(flat.iter().all(|value| (value - 0.625).abs() < 1e-5));
        let (a, b) = ([100_u8; 3 * 67 * 131], [107_u8; 3 * 67 * 131]);
        let error = low_pass.error(Picture::Srgb8(&a), Picture::Srgb8(&b)).unwrap();
        assert!((error.rmse - 7.0 / 255.0).abs() < 1e-5, "{}", error.rmse);
        assert!((error.psnr_db - compare::psnr_db(&a, &b).unwrap()).abs() < 1e-2);
    }
}

#[test]
fn an_offset_of_light_stays_that_offset() {
    let display = DisplayGeometry::symmetric([90, 70], 70.0);
    let low_pass = AcuityLowPass::new(&display, DVec2::ZERO, |ecc_deg| 0.1 * vafr_cpd(ecc_deg)).unwrap();
    let a = noise(3 * 90 * 70, 5);
    let b: Vec<f32> = a.iter().map(|value| value + 0.125).collect();
    let [a, b] = [&a, &b].map(|picture| low_pass.filter(Picture::Linear(picture)).unwrap());
    assert!(a.iter().zip(&b).all(|(a, b)| (b - a - 0.125).abs() < 1e-5));
}

#[test]
fn a_filter_wider_than_the_display_leaves_the_mean() {
    for size_px in [[1, 1], [1, 9], [64, 32], [70, 1]] {
        let display = DisplayGeometry { size_px, ..DisplayGeometry::symmetric([64, 48], 60.0) };
        let values = noise((size_px[0] * size_px[1]) as usize, 11);
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        let low_pass = AcuityLowPass::new(&display, DVec2::ZERO, |_| f64::MIN_POSITIVE).unwrap();
        let found = low_pass.filter(Picture::Linear(&grey(&values))).unwrap();
        assert!(found.iter().all(|value| (value - mean).abs() < 0.01), "{size_px:?}: {found:?}, not {mean}");
    }
}

#[test]
fn without_a_filter_the_error_is_the_psnr() {
    let display = DisplayGeometry::symmetric([160, 90], 100.0);
    let bytes = |seed| noise(3 * 160 * 90, seed).iter().map(|v| (v * 255.0) as u8).collect::<Vec<u8>>();
    let (a, b) = (bytes(1), bytes(2));
    let gaze = DVec2::new(40.0, 80.0);
    let error =
        acuity_error(Picture::Srgb8(&a), Picture::Srgb8(&b), &display, gaze, |_| f64::INFINITY).unwrap();
    assert!((error.psnr_db - compare::psnr_db(&a, &b).unwrap()).abs() < 1e-4);
    let rings = compare::rings(&a, &b, &[0.0; 160 * 90], &display, gaze).unwrap();
    assert_eq!(rings.len(), error.rings.len());
    for (found, expected) in error.rings.iter().zip(rings) {
        let bounds = |from_deg, to_deg, pixels| (from_deg, to_deg, pixels);
        assert_eq!(
            bounds(found.from_deg, found.to_deg, found.pixels),
            bounds(expected.from_deg, expected.to_deg, expected.pixels)
        );
        assert_eq!(found.psnr_db.is_some(), expected.psnr_db.is_some());
        let (found, expected) = (found.psnr_db.unwrap_or(0.0), expected.psnr_db.unwrap_or(0.0));
        assert!((found - expected).abs() < 1e-4, "{found}, not {expected}");
    }
}

/// A checkerboard and the grey of the same light differ where the eye looks, and nowhere else.
#[test]
fn detail_beyond_acuity_counts_only_near_the_gaze() {
    let size_px = [320, 180];
    let display = DisplayGeometry::symmetric(size_px, 40.0);
    let cells: Vec<f32> = (0..320 * 180).map(|at| ((at % 320 + at / 320) % 2) as f32).collect();
    let (a, b) = (vec![0.5; 3 * 320 * 180], grey(&cells));
    let gaze = DVec2::new(0.5, 90.0);
    let cutoff = |ecc_deg: f64| 0.5 * vafr_cpd(ecc_deg);
    let error = acuity_error(Picture::Linear(&a), Picture::Linear(&b), &display, gaze, cutoff).unwrap();
    // A grating of the highest frequency in both directions, of which the filters leave a known share.
    let sigma = sigmas(&display, gaze, cutoff);
    let mut expected = [(0.0, 0.0); 6];
    for (at, &cell) in cells.iter().enumerate() {
        let left = (-(sigma[at] * PI).powi(2)).exp() as f32;
        let off = encode_srgb(0.5 + left * (cell - 0.5)) - encode_srgb(0.5);
        let px = DVec2::new((at % 320) as f64 + 0.5, (at / 320) as f64 + 0.5);
        let (squares, pixels) = &mut expected[ring_of(display.eccentricity_rad(gaze, px).to_degrees())];
        *squares += f64::from(off).powi(2);
        *pixels += 1.0;
    }
    for (ring, (squares, pixels)) in error.rings[..5].iter().zip(expected) {
        let (found, expected) = (ring.rmse.unwrap(), (squares / pixels).sqrt());
        assert!((found - expected).abs() < 0.01, "{found}, not {expected}, from {} degrees", ring.from_deg);
    }
    assert!(error.rings[0].rmse.unwrap() > 0.5 && error.rings[4].rmse.unwrap() < 0.03, "{error:?}");
}

#[test]
fn extreme_light_gives_finite_errors() {
    let display = DisplayGeometry::symmetric([40, 30], 60.0);
    let wild: Vec<f32> =
        noise(3 * 40 * 30, 1).iter().map(|value| if *value < 0.5 { -1e9 } else { 1e9 }).collect();
    let calm = vec![f32::MIN_POSITIVE; 3 * 40 * 30];
    let low_pass = AcuityLowPass::new(&display, DVec2::new(1e9, -1e9), |_| 0.05).unwrap();
    let error = low_pass.error(Picture::Linear(&wild), Picture::Linear(&calm)).unwrap();
    assert!(error.rmse.is_finite() && error.rmse > 1.0 && error.psnr_db.is_finite());
}

#[test]
fn what_does_not_fit_is_refused_in_one_line() {
    let display = DisplayGeometry::symmetric([8, 6], 60.0);
    let huge = DisplayGeometry::symmetric([1 << 16, 1 << 16], 60.0);
    let filter = |display: &DisplayGeometry, gaze, cutoff: f64| {
        AcuityLowPass::new(display, gaze, |_| cutoff).err().unwrap()
    };
    let low_pass = AcuityLowPass::new(&display, DVec2::ZERO, vafr_cpd).unwrap();
    let errors = [
        filter(&display, DVec2::NAN, 4.0),
        filter(&display, DVec2::ZERO, 0.0),
        filter(&display, DVec2::ZERO, -1.0),
        filter(&display, DVec2::ZERO, f64::NAN),
        filter(&DisplayGeometry { size_px: [0, 6], ..display }, DVec2::ZERO, 4.0),
        filter(&huge, DVec2::ZERO, 4.0),
        low_pass.filter(Picture::Srgb8(&[0; 7])).unwrap_err(),
        low_pass.error(Picture::Srgb8(&[0; 144]), Picture::Linear(&[f32::NAN; 144])).unwrap_err(),
    ];
    for error in errors {
        assert!(matches!(error, Error::Setting(_)) && !error.to_string().contains('\n'), "{error}");
    }
}

#[test]
fn results_are_written_as_documented() {
    let ring = AcuityRing { from_deg: 40.0, to_deg: f64::INFINITY, pixels: 0, rmse: None, psnr_db: None };
    let error = AcuityError { rmse: 0.0, psnr_db: f64::INFINITY, rings: vec![ring] };
    assert_eq!(
        serde_json::to_string(&error).unwrap(),
        "{\"rmse\":0.0,\"psnr_db\":\"inf\",\"rings\":[{\"from_deg\":40.0,\"to_deg\":null,\"pixels\":0,\
         \"rmse\":null,\"psnr_db\":null}]}"
    );
}
