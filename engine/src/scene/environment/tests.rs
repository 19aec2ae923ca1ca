use super::latlong::resample;
use super::*;
use std::path::PathBuf;
use std::time::Instant;

fn shared() -> Option<PathBuf> {
    let root = std::env::var_os("MACULA_SHARED")
        .map_or_else(|| PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared")), PathBuf::from);
    let scenes = root.join("data/scenes");
    if !scenes.is_dir() {
        println!("skipped: no corpus; set MACULA_SHARED to its folder");
        return None;
    }
    Some(scenes)
}

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|e| e == "exr" || e == "hdr") {
            found.push(path);
        }
    }
    found.sort();
}

/// A little generator, so that every run makes the same files.
fn next(state: &mut u64) -> u64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    *state
}

#[test]
fn constant_picture_stays_constant() {
    for size in [[64, 32], [1, 1], [37, 19], [2048, 512]] {
        let texel = [2.0, 0.5, 0.125, 0.3];
        let picture = vec![texel; (size[0] * size[1]) as usize];
        let filtered = Environment::from_pixels("constant", size, picture).unwrap();
        let uniform = Environment::uniform([2.0, 0.5, 0.125]);
        for (a, b) in filtered.diffuse_sh.iter().flatten().zip(uniform.diffuse_sh.iter().flatten()) {
            assert!((a - b).abs() < 1e-5, "{size:?}: {a} is not {b}");
        }
        assert_eq!(filtered.specular.len(), SPECULAR_LEVELS);
        for (level, expected) in filtered.specular.iter().zip(&uniform.specular) {
            assert_eq!(level.size, expected.size);
            assert_eq!(level.pixels.len(), (level.size[0] * level.size[1]) as usize);
            for (a, b) in level.pixels.iter().flatten().zip(expected.pixels.iter().flatten()) {
                assert!((a - b).abs() < 1e-3 * b, "{size:?} {:?}: {a} is not {b}", level.size);
            }
        }
        assert_eq!(filtered.repaired, 0);
    }
}

#[test]
fn uniform_light_is_the_same_along_every_normal() {
    let uniform = Environment::uniform([1.0, 4.0, f32::INFINITY]);
    for [x, y, z] in [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.6, 0.0, -0.8]] {
        assert_eq!(uniform.diffuse([x, y, z]), [1.0, 4.0, MAX_RADIANCE]);
    }
}

#[test]
fn directions_follow_the_convention() {
    let close = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    assert!(close(direction_of_uv([0.5, 0.5]), [0.0, 0.0, -1.0]));
    assert!(close(direction_of_uv([0.75, 0.5]), [1.0, 0.0, 0.0]));
    assert!(close(direction_of_uv([0.25, 0.5]), [-1.0, 0.0, 0.0]));
    assert!(close(direction_of_uv([0.3, 0.0]), [0.0, 1.0, 0.0]));
    assert!(close(direction_of_uv([0.3, 1.0]), [0.0, -1.0, 0.0]));
    for uv in [[0.1, 0.2], [0.9, 0.7], [0.5, 0.999], [0.3, 0.001]] {
        let back = uv_of_direction(direction_of_uv(uv));
        assert!((back[0] - uv[0]).abs() < 1e-5 && (back[1] - uv[1]).abs() < 1e-5, "{uv:?}: {back:?}");
    }
}

#[test]
fn repaired_texels_are_counted() {
    let mut picture = vec![[1.0; 4]; 8];
    picture[0] = [f32::NAN, -1.0, 3.0, f32::NAN];
    picture[1] = [f32::INFINITY, f32::NEG_INFINITY, 65505.0, 1.0];
    picture[2] = [MAX_RADIANCE, 0.0, -0.0, f32::NAN];
    let environment = Environment::from_pixels("broken", [4, 2], picture).unwrap();
    assert_eq!(environment.repaired, 2);
    assert_eq!(environment.pixels[0], [0.0, 0.0, 3.0, 1.0]);
    assert_eq!(environment.pixels[1], [MAX_RADIANCE, 0.0, MAX_RADIANCE, 1.0]);
    check_whole(&environment);
}

#[test]
fn wrong_sizes_are_refused() {
    for (size, count) in [([0, 4], 0), ([4, 2], 7), ([16385, 1], 16385)] {
        let refused = Environment::from_pixels("odd", size, vec![[0.0; 4]; count]);
        assert!(matches!(refused, Err(Error::Setting(_))), "{size:?}");
    }
}

/// Irradiance of one small source of radiance L and solid angle w, c = cosine to the normal. Cosine
/// lobe up to order 2: E / pi = L w / pi (1/4 + c/2 + 5/32 (3 c^2 - 1)); exact: L w / pi max(c, 0).
#[test]
fn one_bright_direction_has_the_irradiance_of_a_cosine() {
    let size = [256_u32, 128];
    for index in [64 * 256 + 128, 40 * 256 + 17, 3 * 256 + 200, 100 * 256] {
        let mut picture = vec![[0.0; 4]; (size[0] * size[1]) as usize];
        picture[index] = [1000.0, 100.0, 10.0, 1.0];
        let environment = Environment::from_pixels("sun", size, picture).unwrap();
        let (row, column) = (index / 256, index % 256);
        let source = direction_of_uv([(column as f32 + 0.5) / 256.0, (row as f32 + 0.5) / 128.0]);
        let angle = |row: usize| (row as f64 / 128.0 * std::f64::consts::PI).cos();
        let solid_angle = (angle(row) - angle(row + 1)) * std::f64::consts::TAU / 256.0;
        let unit = 1000.0 * solid_angle / std::f64::consts::PI;
        for normal in [source, [0.0, 1.0, 0.0], [0.6, 0.0, -0.8], [-0.48, 0.64, 0.6]] {
            let c: f64 = source.iter().zip(normal).map(|(a, b)| f64::from(a * b)).sum();
            let order_2 = (0.25 + c / 2.0 + 5.0 / 32.0 * (3.0 * c * c - 1.0)).max(0.0) * unit;
            let got = environment.diffuse(normal);
            assert!((f64::from(got[0]) - order_2).abs() < 2e-3 * unit, "{got:?}, not {order_2}");
            assert!((got[0] - 10.0 * got[1]).abs() < 1e-4 && (got[1] - 10.0 * got[2]).abs() < 1e-4);
            assert!((f64::from(got[0]) - c.max(0.0) * unit).abs() < 0.1 * unit);
        }
    }
}

#[test]
fn resampling_keeps_the_mean_over_the_sphere() {
    let mut state = 7;
    let size = [50, 21];
    let picture: Vec<[f32; 4]> =
        (0..size[0] * size[1]).map(|_| [(next(&mut state) % 1000) as f32; 4]).collect();
    let mean = |pixels: &[[f32; 4]], [width, height]: [usize; 2]| {
        let angle = |row: usize| (row as f64 / height as f64 * std::f64::consts::PI).cos();
        let row = |(y, line): (usize, &[[f32; 4]])| {
            line.iter().map(|texel| f64::from(texel[0])).sum::<f64>() * (angle(y) - angle(y + 1))
        };
        pixels.chunks(width).enumerate().map(row).sum::<f64>() / (2 * width) as f64
    };
    for to in [[100, 42], [32, 16], [7, 5], [1, 1]] {
        let image = resample(&picture, size, to);
        let (before, after) = (mean(&picture, size), mean(&image.pixels, to));
        assert!((before - after).abs() < 1e-3 * before, "{to:?}: {before} became {after}");
    }
}

#[test]
fn prefiltering_keeps_a_sun_in_place_and_its_light_finite() {
    let size = [512_u32, 256];
    let mut picture = vec![[0.01, 0.01, 0.01, 1.0]; (size[0] * size[1]) as usize];
    picture[90 * 512 + 400] = [MAX_RADIANCE, MAX_RADIANCE, MAX_RADIANCE, 1.0];
    let environment = Environment::from_pixels("sun", size, picture).unwrap();
    let mut peak_before = f32::INFINITY;
    for level in &environment.specular {
        let [width, height] = level.size.map(|side| side as usize);
        let brightest =
            (0..width * height).max_by(|&a, &b| level.pixels[a][0].total_cmp(&level.pixels[b][0]));
        let brightest = brightest.unwrap();
        let (x, y) = (brightest % width, brightest / width);
        let expected = [400.5 / 512.0 * width as f64, 90.5 / 256.0 * height as f64];
        assert!((x as f64 + 0.5 - expected[0]).abs() <= 1.5, "{:?}: column {x}", level.size);
        assert!((y as f64 + 0.5 - expected[1]).abs() <= 1.5, "{:?}: row {y}", level.size);
        let peak = level.pixels[brightest][0];
        assert!(peak < peak_before, "{peak} after {peak_before}");
        peak_before = peak;
    }
    check_whole(&environment);
}

/// Under a radiance of 1 + d . axis, a lobe that is symmetric about n sees 1 + k n . axis, where k is
/// the lobe's mean cosine, weighted by the cosine; here by quadrature over the half vector's angle.
#[test]
fn prefiltering_a_gradient_gives_the_mean_cosine_of_the_lobe() {
    let axis = [0.48_f32, 0.64, -0.6];
    let along = |uv: [f32; 2]| direction_of_uv(uv).iter().zip(axis).map(|(a, b)| a * b).sum::<f32>();
    let uv_of = |index: usize, [width, height]: [usize; 2]| {
        let (x, y) = (index % width, index / width);
        [(x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32]
    };
    let size = [512, 256];
    let picture = (0..512 * 256).map(|index| [1.0 + along(uv_of(index, size)); 4]).collect();
    let environment = Environment::from_pixels("gradient", [512, 256], picture).unwrap();
    for (index, level) in environment.specular.iter().enumerate().skip(1) {
        let alpha2 = (index as f64 / 5.0).powi(4);
        let (mut squares, mut sum) = (0.0, 0.0);
        for step in 0..20_000 {
            let (sin, cos) = ((f64::from(step) + 0.5) / 20_000.0 * std::f64::consts::FRAC_PI_4).sin_cos();
            let share = alpha2 / (cos * cos * (alpha2 - 1.0) + 1.0).powi(2) * cos * sin;
            let cosine = 2.0 * cos * cos - 1.0;
            squares += share * cosine * cosine;
            sum += share * cosine;
        }
        let k = (squares / sum) as f32;
        let size = level.size.map(|side| side as usize);
        for (texel, value) in level.pixels.iter().enumerate() {
            let expected = 1.0 + k * along(uv_of(texel, size));
            assert!((value[0] - expected).abs() < 0.03, "{size:?} {texel}: {}, not {expected}", value[0]);
        }
    }
}

/// The definition of the reflected share, by quadrature over the hemisphere of light directions.
fn dfg_by_quadrature(nv: f64, roughness: f64) -> [f64; 2] {
    let alpha2 = roughness.powi(4);
    let view = [(1.0 - nv * nv).sqrt(), 0.0, nv];
    let (rows, columns) = (600, 600);
    let mut sum = [0.0; 2];
    for row in 0..rows {
        // Uniform in angle: grazing light matters at grazing views.
        let theta = (row as f64 + 0.5) / rows as f64 * std::f64::consts::FRAC_PI_2;
        let (sin, nl) = theta.sin_cos();
        for column in 0..columns {
            let phi = (column as f64 + 0.5) / columns as f64 * std::f64::consts::PI;
            let half = [sin * phi.cos() + view[0], sin * phi.sin(), nl + nv];
            let length = (half[0] * half[0] + half[1] * half[1] + half[2] * half[2]).sqrt();
            let nh = half[2] / length;
            let vh = (half[0] * view[0] + half[2] * view[2]) / length;
            let d = alpha2 / (std::f64::consts::PI * (nh * nh * (alpha2 - 1.0) + 1.0).powi(2));
            let lambda = |a: f64, b: f64| a * (b * b * (1.0 - alpha2) + alpha2).sqrt();
            let visibility = 0.5 / (lambda(nl, nv) + lambda(nv, nl));
            let share = d * visibility * nl * sin;
            let fresnel = (1.0 - vh).powi(5);
            sum[0] += share * (1.0 - fresnel);
            sum[1] += share * fresnel;
        }
    }
    let cell = 2.0 * std::f64::consts::PI * std::f64::consts::FRAC_PI_2 / f64::from(rows * columns);
    sum.map(|value| value * cell)
}

#[test]
fn dfg_agrees_with_quadrature() {
    for roughness in [0.35, 0.5, 0.8, 1.0] {
        for nv in [0.1, 0.4, 0.75, 1.0] {
            let expected = dfg_by_quadrature(nv, roughness);
            let got = dfg(nv, roughness, 4096);
            for (got, expected) in got.into_iter().zip(expected) {
                assert!((got - expected).abs() < 3e-3, "nv {nv} r {roughness}: {got}, not {expected}");
            }
            let few = dfg(nv, roughness, 256);
            assert!(few.iter().zip(expected).all(|(few, expected)| (few - expected).abs() < 0.01));
        }
    }
}

#[test]
fn dfg_of_a_mirror_is_schlick() {
    for nv in [0.05, 0.3, 0.7, 1.0_f64] {
        let fresnel = (1.0 - nv).powi(5);
        let [scale, bias] = dfg(nv, 0.0, 64);
        assert!((scale - (1.0 - fresnel)).abs() < 1e-3 && (bias - fresnel).abs() < 1e-3, "{scale} {bias}");
    }
}

#[test]
fn dfg_lut_is_finite_and_reflects_no_more_than_arrives() {
    for size in [1, 16, 64] {
        let lut = dfg_lut(size, 64);
        assert_eq!(lut.len(), size * size);
        for [scale, bias] in lut {
            assert!(scale.is_finite() && bias.is_finite() && scale >= 0.0 && bias >= 0.0);
            assert!(scale + bias <= 1.0 + 1e-6, "{scale} + {bias}");
        }
    }
    for nv in [0.0, 1.0] {
        for roughness in [0.0, 1.0] {
            assert!(dfg(nv, roughness, 1).iter().all(|value| value.is_finite()));
        }
    }
    let first_row = &dfg_lut(64, 64)[..64];
    assert!(first_row[0][1] > 0.8 && first_row[63][1] < 0.01, "N.V runs along rows");
}

/// Everything in range and of the promised sizes.
fn check_whole(environment: &Environment) {
    let in_range = |texel: &[f32; 4]| texel.iter().all(|value| (0.0..=MAX_RADIANCE).contains(value));
    assert_eq!(environment.pixels.len(), (environment.size[0] * environment.size[1]) as usize);
    assert!(environment.pixels.iter().all(in_range));
    assert!(environment.diffuse_sh.iter().flatten().all(|value| value.is_finite()));
    assert_eq!(environment.specular.len(), SPECULAR_LEVELS);
    for level in &environment.specular {
        assert_eq!(level.pixels.len(), (level.size[0] * level.size[1]) as usize);
        assert!(level.pixels.iter().all(in_range));
    }
}

#[test]
fn corpus_loads_or_is_refused_in_one_line() {
    let Some(scenes) = shared() else { return };
    let mut paths = Vec::new();
    for folder in ["env", "exr"] {
        files(&scenes.join(folder), &mut paths);
    }
    let mut wrong = Vec::new();
    for path in paths {
        let start = Instant::now();
        let damaged = path.components().any(|part| part.as_os_str() == "Damaged");
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let loaded = Environment::load(&path);
        let ms = start.elapsed().as_millis();
        match loaded {
            Ok(environment) => {
                check_whole(&environment);
                let [width, height] = environment.size;
                println!("{ms:5} ms {name}: {width}x{height}, {} repaired", environment.repaired);
                if damaged {
                    println!("         damaged, and yet read");
                }
            }
            Err(error) => {
                let line = error.to_string();
                println!("{ms:5} ms {line}");
                assert!(!line.contains('\n') && line.contains(&name));
                if !damaged {
                    wrong.push(line);
                }
            }
        }
        assert!(ms < 20_000, "{name} took {ms} ms");
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn lossy_and_lossless_copies_agree() {
    let Some(scenes) = shared() else { return };
    for name in ["city", "forest", "night", "studio"] {
        let load = |file: String| Environment::load(scenes.join("env").join(file)).unwrap();
        let (lossy, lossless) = (load(format!("{name}.exr")), load(format!("{name}_zip.exr")));
        assert_eq!(lossy.size, lossless.size);
        for (a, b) in lossy.diffuse_sh.iter().flatten().zip(lossless.diffuse_sh.iter().flatten()) {
            let scale = lossless.diffuse_sh[0][1];
            assert!((a - b).abs() < 0.02 * scale, "{name}: {a} and {b} of {scale}");
        }
    }
}

#[test]
fn of_several_resolutions_the_largest_is_read() {
    let Some(scenes) = shared() else { return };
    let levels = Environment::load(scenes.join("exr/MultiResolution/ColorCodedLevels.exr")).unwrap();
    assert_eq!(levels.size, [512, 512]);
    let luminance = Environment::load(scenes.join("exr/LuminanceChroma/Garden.exr")).unwrap();
    assert!(luminance.pixels.iter().all(|[r, g, b, _]| r == g && g == b));
    assert!(luminance.pixels.iter().any(|texel| texel[0] > 0.1));
}

#[test]
fn other_files_are_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.exr");
    for bytes in [&b""[..], b"\x89PNG\r\n\x1a\n", b"\x76\x2f\x31\x01", b"#?RADIANCE\n"] {
        std::fs::write(&path, bytes).unwrap();
        let error = Environment::load(&path).unwrap_err();
        assert!(matches!(error, Error::File { .. }) && !error.to_string().contains('\n'), "{error}");
    }
    assert!(matches!(Environment::load(folder.path()), Err(Error::File { .. })));
    assert!(matches!(Environment::load(folder.path().join("none.exr")), Err(Error::Io { .. })));
}
