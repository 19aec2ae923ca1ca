//! Anti-aliasing in the LP-buffer: right neighbours where columns differ in height, nothing lost at holes
//! and borders, and a better picture.

use glam::{DMat4, DVec2, DVec3, Vec3};
use macula::fovea::{AcuityModel, DisplayGeometry, Kernel, Mapping, VafrForm, VafrMapping};
use macula::headless::{FrameInput, GpuContent, HeadlessDevice, OffscreenRenderer};
use macula::quality::compare::{self, Comparison};
use macula::scene::{Material, Scene};
use macula::settings::{KfrSettings, LpFilter, Method, RenderSettings, ToneMap, VafrSettings};
use macula_tests::scenes::{add, at, camera_of, coloured_quad, hall, one, quad, unlit};
use macula_tests::{Frame, ahead, gpu, next_frame, render_content, settings, upload};
use std::f64::consts::TAU;
use std::sync::Arc;

const FILTERS: [LpFilter; 2] = [LpFilter::Gaussian, LpFilter::Fxaa];

/// Acuity so coarse that small displays have a periphery.
fn acuity(scale: f64) -> AcuityModel {
    AcuityModel::vafr_2025().scaled(scale).unwrap()
}

fn vafr(form: VafrForm, scale: f64, lp_filter: LpFilter) -> Method {
    Method::Vafr(VafrSettings { form, acuity: acuity(scale), lp_filter })
}

fn kfr(lp_filter: LpFilter) -> Method {
    let kernel = Kernel::Power { alpha: 4.0 };
    Method::Kfr(KfrSettings { sigma: 1.6, kernel, lp_filter, post_filter: false })
}

/// One LP-buffer before and after the filter.
struct Buffers {
    size: [usize; 2],
    heights: Vec<usize>,
    before: Vec<f32>,
    after: Vec<f32>,
}

impl Buffers {
    fn texel(&self, of: &[f32], u: usize, v: usize) -> [f32; 4] {
        let first = 4 * (v * self.size[0] + u);
        [0, 1, 2, 3].map(|channel| of[first + channel])
    }

    fn before(&self, u: usize, v: usize) -> [f32; 4] {
        self.texel(&self.before, u, v)
    }

    fn after(&self, u: usize, v: usize) -> [f32; 4] {
        self.texel(&self.after, u, v)
    }

    /// Column and row of every texel that was shaded.
    fn shaded(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let texels =
            self.heights.iter().enumerate().flat_map(|(u, height)| (0..*height).map(move |v| (u, v)));
        texels.filter(|&(u, v)| self.before(u, v)[3] > 0.0)
    }

    /// At a share of a column's height, linear between rows and around the circle, in double precision.
    /// `None` where neither row was shaded.
    fn at_share(&self, u: usize, share: f64, channel: usize) -> Option<f64> {
        let height = self.heights[u] as f64;
        let at = share * height - 0.5;
        let rows = [at.floor(), at.floor() + 1.0];
        let weights = [1.0 - (at - at.floor()), at - at.floor()];
        let (mut sum, mut total) = (0.0, 0.0);
        for (row, weight) in rows.into_iter().zip(weights) {
            let texel = self.before(u, row.rem_euclid(height) as usize);
            sum += weight * f64::from(texel[3]) * f64::from(texel[channel]);
            total += weight * f64::from(texel[3]);
        }
        (total > 1e-6).then(|| sum / total)
    }
}

/// Renders a frame and reads the LP-buffer of the columns in use.
fn filtered(
    gpu: &HeadlessDevice,
    content: &GpuContent,
    settings: &RenderSettings,
    input: &FrameInput,
) -> (Frame, Buffers) {
    let mut renderer = OffscreenRenderer::new(gpu, content, settings).unwrap();
    let frame = next_frame(&mut renderer, settings, input);
    frame.check_whole("filtered");
    let (width, height, before) = renderer.read_lp().unwrap().unwrap();
    let (_, _, after) = renderer.read_lp_filtered().unwrap().unwrap();
    assert!(after.iter().all(|value| value.is_finite()));
    let columns = frame.stats.lp.unwrap().width as usize;
    let heights = match &settings.method {
        Method::Vafr(vafr) => {
            let acuity = Arc::new(vafr.acuity.clone());
            let mapping = VafrMapping::new(vafr.form, &settings.display, input.gaze_px, &acuity);
            mapping.columns().heights()[..columns].iter().map(|height| *height as usize).collect()
        }
        _ => vec![height as usize; columns],
    };
    (frame, Buffers { size: [width as usize, height as usize], heights, before, after })
}

/// A picture of two colours that meet on a straight line through the display's centre, at an angle
/// counted up from +x. The second colour lies above a level line.
fn halves(angle_rad: f64, colors: [[f32; 3]; 2]) -> Scene {
    let mut scene = Scene::default();
    for (side, [red, green, blue]) in [-1.0, 1.0].into_iter().zip(colors) {
        let place = DMat4::from_rotation_z(angle_rad) * at(0.0, side * 500.0, 0.0);
        add(&mut scene, quad(1000.0, 500.0), at(0.0, 0.0, -1.0) * place, unlit(red, green, blue));
    }
    scene
}

#[test]
fn flat_colours_stay_bit_for_bit_also_beside_holes() {
    let gpu = gpu();
    let content = upload(&gpu, &one(quad(900.0, 900.0), at(0.0, 0.0, -1.0), unlit(0.5, 0.25, 0.75)), None);
    for filter in FILTERS {
        for method in [kfr(filter), vafr(VafrForm::Sphere, 0.1, filter), vafr(VafrForm::Planar, 0.1, filter)]
        {
            let settings = settings([160, 90], 60.0, method);
            for gaze in [[80.0, 45.0], [30.3, 70.6], [159.0, 2.0]] {
                let input = FrameInput { gaze_px: DVec2::from_array(gaze), ..ahead(&settings) };
                let (_, buffers) = filtered(&gpu, &content, &settings, &input);
                // KFR's Gaussian leaves out its first columns.
                let first = if matches!(settings.method, Method::Kfr(_)) { buffers.size[0] / 2 } else { 0 };
                let (mut seen, mut beside_holes) = (0, 0);
                for (u, v) in buffers.shaded().filter(|(u, _)| *u >= first) {
                    assert_eq!(buffers.after(u, v), buffers.before(u, v), "{:?} {u}, {v}", settings.method);
                    let after = (v + 1) % buffers.heights[u];
                    beside_holes += usize::from(buffers.before(u, after)[3] == 0.0);
                    seen += 1;
                }
                assert!(seen > 500, "{seen} texels");
                assert!(beside_holes > 3 || gaze == [80.0, 45.0], "{beside_holes} beside holes");
            }
        }
    }
}

#[test]
fn the_gaussian_is_that_of_equal_azimuths() {
    let gpu = gpu();
    let scene = hall(10_000, 4);
    let content = upload(&gpu, &scene, None);
    for form in [VafrForm::Sphere, VafrForm::Planar] {
        let settings = settings([240, 136], 70.0, vafr(form, 0.15, LpFilter::Gaussian));
        let input = FrameInput { world_from_view: camera_of(&scene), gaze_px: DVec2::new(90.0, 80.0) };
        let (_, buffers) = filtered(&gpu, &content, &settings, &input);
        let (mut texels, mut apart) = (0, 0);
        for (u, v) in buffers.shaded() {
            for channel in 0..3 {
                let own = f64::from(buffers.before(u, v)[channel]);
                let (mut sum, mut most) = (0.0, own);
                for across in [-1, 0, 1] {
                    for along in [-1, 0, 1] {
                        let share = (v as f64 + 0.5 + f64::from(along)) / buffers.heights[u] as f64;
                        let column = u.checked_add_signed(across).filter(|c| *c < buffers.heights.len());
                        let value = column.and_then(|column| buffers.at_share(column, share, channel));
                        let value = value.unwrap_or(own);
                        let weight = (2 - across.abs()) * (2 - i64::from(along).abs() as isize);
                        sum += weight as f64 / 16.0 * value;
                        most = f64::max(most, value);
                    }
                }
                let off = (f64::from(buffers.after(u, v)[channel]) - sum).abs();
                // Half floats, subnormal ones too, and rows found in single precision.
                assert!(off <= 2e-3 * most + 1e-7, "{form:?} {u}, {v}: {off} off {sum}");
            }
            texels += 1;
            apart += usize::from(u > 0 && buffers.heights[u] != buffers.heights[u - 1]);
        }
        assert!(texels > 2000 && apart > texels / 2, "{apart} of {texels} beside another height");
    }
}

#[test]
fn an_edge_across_columns_of_different_heights_is_smoothed_without_shear() {
    let gpu = gpu();
    for filter in FILTERS {
        // The edge leaves the gaze at shares 0.9 and 0.4 of a turn: there a row that is taken for its
        // neighbour in the next column lies up to several rows away.
        let content = upload(&gpu, &halves(0.1 * TAU, [[0.1; 3], [0.8; 3]]), None);
        let settings = settings([360, 360], 80.0, vafr(VafrForm::Sphere, 0.1, filter));
        let (_, buffers) = filtered(&gpu, &content, &settings, &ahead(&settings));
        let (mut far, mut near, mut smoothed) = (0, 0, 0);
        for (u, v) in buffers.shaded() {
            let height = buffers.heights[u] as f64;
            let turns = ((v as f64 + 0.5) / height - 0.4).rem_euclid(0.5);
            let rows_away = turns.min(0.5 - turns) * height;
            let same = buffers.after(u, v) == buffers.before(u, v);
            // One row to the neighbour, one more that it is interpolated with, and less than one to the
            // centre of the shaded pixel.
            if rows_away > 3.0 {
                assert!(same, "{filter:?} {u}, {v}: {rows_away} rows from the edge");
                far += 1;
            } else if rows_away <= 1.0 {
                near += 1;
                smoothed += usize::from(!same);
            }
        }
        println!("{filter:?}: {far} far texels unchanged, {smoothed} of {near} near ones smoothed");
        assert!(far > 2000 && near > 100 && 2 * smoothed > near, "{far}, {smoothed} of {near}");
    }
}

/// Rectangles of all sizes, places and turns over a background, the same each time.
fn rectangles() -> Scene {
    let mut state = 7_u32;
    let mut next = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 24)
    };
    let mut scene = one(quad(900.0, 900.0), at(0.0, 0.0, -10.0), unlit(0.2, 0.2, 0.25));
    for index in 0..120 {
        let (x, y, turn) = (8.0 * next() - 4.0, 8.0 * next() - 4.0, TAU * next());
        let place = at(x, y, -5.0 + 0.01 * f64::from(index)) * DMat4::from_rotation_z(turn);
        let colour = [next(), next(), next()].map(|value| value as f32);
        let mesh = quad(0.1 + 0.5 * next() as f32, 0.03 + 0.2 * next() as f32);
        add(&mut scene, mesh, place, unlit(colour[0], colour[1], colour[2]));
    }
    scene
}

#[test]
fn the_seam_is_a_row_like_any_other() {
    let gpu = gpu();
    let content = upload(&gpu, &rectangles(), None);
    for filter in FILTERS {
        let settings = settings([192, 192], 80.0, kfr(filter));
        let upright = ahead(&settings);
        // Half a turn of the picture about the gaze moves every row by half the height.
        let turned = FrameInput { world_from_view: DMat4::from_rotation_z(TAU / 2.0), ..upright };
        let (_, a) = filtered(&gpu, &content, &settings, &upright);
        let (_, b) = filtered(&gpu, &content, &settings, &turned);
        let [width, height] = a.size;
        let opposite = |v: usize| (v + height / 2) % height;
        assert!(height.is_multiple_of(2));
        let equal = |u: usize, v: usize| a.before(u, v) == b.before(u, opposite(v));
        // As far as FXAA looks.
        let around = |u: usize, v: usize| {
            (u.saturating_sub(9)..(u + 10).min(width))
                .all(|u| (v + height - 9..v + height + 10).all(|v| equal(u, v % height)))
        };
        let (mut seen, mut at_seam, mut changed) = (0, 0, 0);
        for (u, v) in a.shaded().filter(|&(u, v)| u > width / 2 && around(u, v)) {
            let beside_seam = v == 0 || v + 1 == height;
            let (one, other) = (a.after(u, v), b.after(u, opposite(v)));
            for channel in 0..4 {
                let off = (one[channel] - other[channel]).abs();
                assert!(off <= 1.0 / 1024.0, "{filter:?} {u}, {v}: {one:?}, not {other:?}");
            }
            seen += 1;
            at_seam += usize::from(beside_seam);
            changed += usize::from(beside_seam && one != a.before(u, v));
        }
        println!("{filter:?}: {seen} texels, {at_seam} at the seam of which {changed} changed");
        assert!(seen > 1000 && at_seam > 20 && changed > 2, "{seen}, {at_seam}, {changed}");
    }
}

#[test]
fn a_ramp_has_no_line_at_the_seam() {
    let gpu = gpu();
    let size = [240, 160];
    let corners = [[0, 255, 128, 255], [255, 255, 255, 255], [255, 0, 128, 255], [0, 0, 0, 255]];
    for filter in FILTERS {
        let settings = settings(size, 90.0, vafr(VafrForm::Sphere, 0.1, filter));
        let half = [settings.display.tan_right as f32, settings.display.tan_up as f32].into();
        let mesh = coloured_quad(half, corners);
        let content = upload(&gpu, &one(mesh, at(0.0, 0.0, -1.0), unlit(1.0, 1.0, 1.0)), None);
        let frame = render_content(&gpu, &content, &settings, &ahead(&settings));
        frame.check_whole("ramp");
        // Steps across the ray to the right of the gaze, where v wraps, and across that to the left.
        let step = |x: u32| (frame.at(x, 80)[1] - frame.at(x, 79)[1]).abs();
        let most = |xs: &mut dyn Iterator<Item = u32>| xs.map(step).fold(0.0, f64::max);
        let (right, left) = (most(&mut (124..236)), most(&mut (4..116)));
        println!("{filter:?}: steps of at most {right} on the seam, {left} opposite");
        assert!(right <= 1.5 * left + 1.0 / 256.0, "a seam: {right} against {left}");
    }
}

#[test]
fn native_pixels_are_those_of_full_shading() {
    let gpu = gpu();
    let scene = hall(10_000, 4);
    let content = upload(&gpu, &scene, None);
    let size = [320, 180];
    let input = FrameInput { world_from_view: camera_of(&scene), gaze_px: DVec2::new(130.0, 100.0) };
    let full = render_content(&gpu, &content, &settings(size, 60.0, Method::Full), &input);
    for filter in FILTERS {
        let settings = settings(size, 60.0, vafr(VafrForm::Sphere, 0.3, filter));
        let frame = render_content(&gpu, &content, &settings, &input);
        let mapping =
            VafrMapping::new(VafrForm::Sphere, &settings.display, input.gaze_px, &Arc::new(acuity(0.3)));
        let (mut native, mut different) = (0, 0);
        for y in 0..size[1] {
            for x in 0..size[0] {
                let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                if mapping.pixels_over_acuity(centre) < 1.0 - 1e-4 {
                    assert_eq!(frame.at(x, y), full.at(x, y), "{filter:?} at {x}, {y}");
                    native += 1;
                } else {
                    different += u32::from(frame.at(x, y) != full.at(x, y));
                }
            }
        }
        assert!(native > 1000 && different > 300, "{native} native pixels, {different} others differ");
    }
}

#[test]
fn radiance_without_an_upper_end_stays_finite() {
    let gpu = gpu();
    let mut scene = one(quad(900.0, 900.0), at(0.0, 0.0, -10.0), unlit(0.0, 0.0, 0.0));
    for index in 0..12 {
        let lamp = Material { emissive: Vec3::splat(1e6), ..Material::default() };
        let place =
            DMat4::from_rotation_z(0.3 * f64::from(index)) * at(1.0 + 0.3 * f64::from(index), 0.0, -5.0);
        add(&mut scene, quad(0.4, 0.1), place, lamp);
    }
    let content = upload(&gpu, &scene, None);
    for filter in FILTERS {
        for exposure in [2e-6, 9e5] {
            let mut settings = settings([160, 90], 60.0, vafr(VafrForm::Planar, 0.1, filter));
            settings.exposure = exposure;
            let (_, buffers) = filtered(&gpu, &content, &settings, &ahead(&settings));
            assert!(buffers.shaded().any(|(u, v)| buffers.before(u, v)[0] > 6e4), "no lamp");
        }
    }
}

/// What a display of `factor` times the pixels along each side would show to an eye that takes as many
/// together as one pixel: the mean of the light that leaves the display, encoded.
fn box_average(frame: &Frame, factor: u32) -> Vec<u8> {
    let [width, height] = frame.size.map(|side| side / factor);
    let mut bytes = Vec::new();
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let mut sum = DVec3::ZERO;
        for (dx, dy) in (0..factor).flat_map(|dy| (0..factor).map(move |dx| (dx, dy))) {
            let light = DVec3::from_array(frame.at(factor * x + dx, factor * y + dy));
            sum += light.clamp(DVec3::ZERO, DVec3::ONE);
        }
        // IEC 61966-2-1.
        let encode = |linear: f64| match linear {
            v if v <= 0.003_130_8 => 12.92 * v,
            v => 1.055 * v.powf(1.0 / 2.4) - 0.055,
        };
        let mean = sum / f64::from(factor * factor);
        bytes.extend(mean.to_array().map(|value| (255.0 * encode(value)).round() as u8));
    }
    bytes
}

/// The mean of every block of pixels.
fn shrink(rgb: &[u8], [width, height]: [u32; 2], factor: u32) -> Vec<u8> {
    let blocks = (0..height / factor).flat_map(|y| (0..width / factor).map(move |x| (x, y)));
    let mean = |(x, y): (u32, u32)| {
        let inside = (0..factor * factor).map(move |i| (factor * x + i % factor, factor * y + i / factor));
        let mut sums = [0; 3];
        for (x, y) in inside {
            let first = 3 * (y * width + x) as usize;
            sums = [0, 1, 2].map(|channel| sums[channel] + u32::from(rgb[first + channel]));
        }
        sums.map(|sum| (sum / (factor * factor)) as u8)
    };
    blocks.flat_map(mean).collect()
}

/// A view supersampled by full shading.
struct Supersampled {
    content: GpuContent,
    world_from_view: DMat4,
    rgb: Vec<u8>,
}

const PICTURE_PX: [u32; 2] = [320, 180];
const HFOV_DEG: f64 = 60.0;

impl Supersampled {
    fn new(gpu: &HeadlessDevice, scene: &Scene, world_from_view: DMat4) -> Self {
        let content = upload(gpu, scene, None);
        let fine = settings(PICTURE_PX.map(|side| 4 * side), HFOV_DEG, Method::Full);
        let frame = render_content(gpu, &content, &fine, &FrameInput { world_from_view, ..ahead(&fine) });
        Self { content, world_from_view, rgb: box_average(&frame, 4) }
    }

    /// How far a foveated picture is from it, of blocks of pixels.
    fn compare(&self, gpu: &HeadlessDevice, method: Method, block_px: u32) -> Comparison {
        let mut settings = settings(PICTURE_PX, HFOV_DEG, method);
        settings.tone_map = ToneMap::None;
        let input = FrameInput { world_from_view: self.world_from_view, ..ahead(&settings) };
        let frame = render_content(gpu, &self.content, &settings, &input);
        frame.check_whole("picture");
        let [reference, picture] = [&self.rgb, &frame.rgb8()].map(|rgb| shrink(rgb, PICTURE_PX, block_px));
        let display = DisplayGeometry::symmetric(PICTURE_PX.map(|side| side / block_px), HFOV_DEG);
        compare::compare(&reference, &picture, &display, display.center_px()).unwrap()
    }
}

#[test]
fn fxaa_brings_edges_in_the_periphery_closer_to_a_supersampled_picture() {
    let gpu = gpu();
    let view = Supersampled::new(&gpu, &rectangles(), DMat4::IDENTITY);
    for block_px in [1, 2] {
        let [plain, gaussian, fxaa] = [LpFilter::None, LpFilter::Gaussian, LpFilter::Fxaa]
            .map(|filter| view.compare(&gpu, vafr(VafrForm::Sphere, 0.3, filter), block_px).rings);
        // From 10 and from 20 degrees.
        for ring in [3, 4] {
            let [plain, gaussian, fxaa] = [&plain, &gaussian, &fxaa].map(|rings| &rings[ring]);
            println!(
                "{block_px} px, from {} degrees: {:.2?} dB plain, {:.2?} Gaussian, {:.2?} FXAA",
                plain.from_deg, plain.psnr_db, gaussian.psnr_db, fxaa.psnr_db
            );
            assert!(plain.pixels > 1000 && fxaa.psnr_db > plain.psnr_db && fxaa.psnr_db > gaussian.psnr_db);
        }
    }
}
