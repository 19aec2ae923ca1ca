//! Measuring the rows.

use super::VafrBenchArgs;
use super::paper::{self, PublishedSamples};
use crate::commands::bench::loaded::Loaded;
use crate::failure::Failure;
use crate::library;
use crate::measure::{PassMedian, Speedup, gpu_times, measure_rounds, median, pass_medians, speedup};
use crate::options::HallArgs;
use crate::progress::Steps;
use crate::shading::MethodName;
use macula::fovea::{AcuityModel, DisplayGeometry, sample_limit};
use macula::headless::OffscreenRenderer;
use macula::settings::{Method, RenderSettings};
use macula::stats::FrameStats;
use serde::Serialize;

/// Everything that was measured.
#[derive(Serialize)]
pub struct Results {
    /// The device.
    pub device: String,
    /// Its driver.
    pub driver: String,
    /// Fractions of the display.
    pub gaze: [f64; 2],
    /// Samples for each pixel or texel of the ray-marched scene.
    pub spp: u32,
    /// What was noticed while loading.
    pub warnings: Vec<String>,
    /// Each scene at each size.
    pub rows: Vec<Row>,
    /// Table I.
    pub published_samples: [PublishedSamples; 5],
}

/// One scene at one size.
#[derive(Serialize)]
pub struct Row {
    /// Display, px.
    pub size: [u32; 2],
    /// The display's horizontal field of view.
    pub hfov_deg: f64,
    /// What was rendered.
    pub scene: String,
    /// Rounds that were measured.
    pub rounds: usize,
    /// Pixels, the samples of full shading without its samples per pixel.
    pub pixels: u64,
    /// Samples that acuity and display together call for.
    pub limit: f64,
    /// Full shading, median.
    pub full_ms: f64,
    /// Passes with full shading.
    pub full_passes: Vec<PassMedian>,
    /// The methods.
    pub methods: Vec<MethodRow>,
    /// The published range of speed-ups at this size and kind of scene.
    pub published_speedup: Option<[f64; 2]>,
}

/// One method of a row; times are medians of whole frames on the GPU.
#[derive(Serialize)]
pub struct MethodRow {
    /// Its name.
    pub method: &'static str,
    /// Median of the frames.
    pub gpu_ms: f64,
    /// Ratios of the rounds, full shading over this.
    pub speedup: Speedup,
    /// Shaded pixels and texels, without samples per pixel.
    pub samples: u64,
    /// The samples over the limit.
    pub samples_over_limit: f64,
    /// Share of the shaded texels that land on the display; `None` where no texel was shaded.
    pub landed: Option<f64>,
    /// Display pixels that were shaded themselves.
    pub native_pixels: u64,
    /// Passes.
    pub passes: Vec<PassMedian>,
}

fn no_times() -> Failure {
    Failure::environment("the device measures no GPU times; choose another with VK_DRIVER_FILES")
}

fn settings(args: &VafrBenchArgs, size: [u32; 2], method: Method) -> RenderSettings {
    let display = DisplayGeometry::symmetric(size, args.hfov_deg(size));
    let mut settings = RenderSettings::new(display, method);
    settings.samples_per_pixel = args.spp;
    settings
}

/// Refuses before the first of many minutes what would fail in the last of them.
fn check(args: &VafrBenchArgs, acuity: &AcuityModel) -> Result<(), Failure> {
    if args.methods.contains(&MethodName::Full) {
        return Err(Failure::usage("full shading is measured anyway; leave `full` out of --methods"));
    }
    for &size in &args.sizes {
        for method in &args.methods {
            settings(args, size, method.with_acuity(acuity)).check()?;
        }
    }
    let hall =
        HallArgs { triangles: Some(args.triangles), lights: Some(args.hall_lights), ..HallArgs::default() };
    library::hall_options(&hall)?;
    Ok(())
}

/// Measures everything that was asked for.
///
/// # Errors
/// Options out of range, and what loading and rendering report.
pub fn run(args: &VafrBenchArgs) -> Result<Results, Failure> {
    let acuity = args.acuity.model()?;
    check(args, &acuity)?;
    // Validation would be part of what is measured.
    let device = library::device(true)?;
    let pixels = |size: [u32; 2]| size.map(f64::from).iter().product::<f64>();
    let weight = args.sizes.iter().map(|&size| pixels(size)).sum::<f64>();
    let mut steps = Steps::long(weight * args.scenes.len() as f64);
    let (mut rows, mut warnings) = (Vec::new(), Vec::new());
    for source in &args.scenes {
        let loaded = Loaded::open(&device, source, args.hall_lights, args.triangles, &mut warnings)?;
        for &size in &args.sizes {
            let what = format!("{} at {}x{}", loaded.name, size[0], size[1]);
            steps.next_of_weight(&what, pixels(size));
            rows.push(measure(&loaded, args, &acuity, size, &steps)?);
        }
    }
    Ok(Results {
        device: device.name().to_owned(),
        driver: device.driver().to_owned(),
        gaze: args.gaze.to_array(),
        spp: args.spp,
        warnings,
        rows,
        published_samples: paper::SAMPLES,
    })
}

/// One row. The renderers, which hold most of the GPU memory, live only as long as it takes.
fn measure(
    loaded: &Loaded<'_>,
    args: &VafrBenchArgs,
    acuity: &AcuityModel,
    size: [u32; 2],
    steps: &Steps,
) -> Result<Row, Failure> {
    let display = DisplayGeometry::symmetric(size, args.hfov_deg(size));
    let input = loaded.input(&display, args.gaze)?;
    let methods = args.methods.iter().map(|method| method.with_acuity(acuity));
    let mut renderers = std::iter::once(Method::Full)
        .chain(methods)
        .map(|method| OffscreenRenderer::new(loaded.device, &loaded.content, &settings(args, size, method)))
        .collect::<Result<Vec<_>, _>>()?;
    for renderer in &mut renderers {
        renderer.render(&input)?;
    }
    let variants = renderers.len();
    let frames = measure_rounds(
        args.rounds(),
        variants,
        |variant| renderers[variant].render(&input),
        |share| steps.within(share * 0.9),
    )?;
    let limit = sample_limit(&display, input.gaze_px, &|ecc_deg| acuity.cpd(ecc_deg));
    let full = &frames[0];
    let of_method = |(method, frames): (&MethodName, &Vec<FrameStats>)| {
        method_row(method.name(), full, frames, limit, args.spp, loaded.subject.scene().is_none())
    };
    Ok(Row {
        size,
        hfov_deg: args.hfov_deg(size),
        scene: loaded.name.clone(),
        rounds: full.len(),
        pixels: u64::from(size[0]) * u64::from(size[1]),
        limit,
        full_ms: median(&gpu_times(full)).ok_or_else(no_times)?,
        full_passes: pass_medians(full),
        methods: args.methods.iter().zip(&frames[1..]).map(of_method).collect::<Result<_, _>>()?,
        published_speedup: paper::speedups(loaded.kind(), size),
    })
}

fn method_row(
    method: &'static str,
    full: &[FrameStats],
    frames: &[FrameStats],
    limit: f64,
    spp: u32,
    ray_marched: bool,
) -> Result<MethodRow, Failure> {
    let last = frames.last().ok_or_else(no_times)?;
    let lp = last.lp.unwrap_or_default();
    let samples = last.samples_shaded / if ray_marched { u64::from(spp) } else { 1 };
    let times = gpu_times(frames);
    Ok(MethodRow {
        method,
        gpu_ms: median(&times).ok_or_else(no_times)?,
        speedup: speedup(&gpu_times(full), &times).ok_or_else(no_times)?,
        samples,
        samples_over_limit: samples as f64 / limit,
        landed: (lp.shaded > 0).then(|| lp.shaded_on_display as f64 / lp.shaded as f64),
        native_pixels: lp.native_pixels,
        passes: pass_medians(frames),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use macula::stats::LpStats;

    #[test]
    fn a_row_follows_from_its_frames() {
        let frame =
            |gpu_ms, samples_shaded, lp| FrameStats { gpu_ms, samples_shaded, lp, ..FrameStats::default() };
        let lp = LpStats { shaded: 100, shaded_on_display: 98, native_pixels: 60, ..LpStats::default() };
        let full = [frame(40.0, 16_000, None), frame(44.0, 16_000, None)];
        let foveated = [frame(10.0, 2_560, Some(lp)), frame(10.0, 2_560, Some(lp))];
        let Ok(row) = method_row("vafr", &full, &foveated, 80.0, 16, true) else { panic!() };
        assert_eq!((row.samples, row.native_pixels, row.landed), (160, 60, Some(0.98)));
        assert!((row.samples_over_limit - 2.0).abs() < 1e-12);
        assert!((row.speedup.median - 4.2).abs() < 1e-12 && row.speedup.least == 4.0);
        assert!(method_row("vafr", &full, &[], 80.0, 1, false).is_err());
    }
}
