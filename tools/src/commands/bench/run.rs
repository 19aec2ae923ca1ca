//! Measuring the rows.

use super::KfrBenchArgs;
use super::loaded::Loaded;
use super::paper::{self, PublishedPass, PublishedRate};
use crate::content::Source;
use crate::failure::Failure;
use crate::library;
use crate::measure::{PassMedian, Speedup, gpu_times, measure_pairs, median, pass_medians, speedup, time_of};
use crate::options::HallArgs;
use crate::progress::Steps;
use macula::fovea::DisplayGeometry;
use macula::headless::OffscreenRenderer;
use macula::settings::{KfrSettings, Method, RenderSettings};
use macula::stats::FrameStats;
use serde::Serialize;
use std::time::{Duration, Instant};

/// Passes that KFR adds and that the full frame does not have.
const ADDED_PASSES: [&str; 2] = ["lp_filter", "inverse"];
/// The pass of Eq. 2.14.
const POST_FILTER_PASS: &str = "post_filter";
/// No further frames with that pass are begun after this time.
const POST_FILTER_BUDGET: Duration = Duration::from_secs(10);
/// Below this speed-up foveation does not pay: the gain drowns in the spread of the measurement.
const PAYS_FROM: f64 = 1.05;

/// Everything that was measured.
#[derive(Serialize)]
pub struct Results {
    /// The device.
    pub device: String,
    /// Its driver.
    pub driver: String,
    /// The method that is compared with full shading.
    pub method: &'static str,
    /// Display width over LP-buffer width.
    pub sigma: f64,
    /// The kernel in words.
    pub kernel: String,
    /// The display's horizontal field of view.
    pub hfov_deg: f64,
    /// Fractions of the display.
    pub gaze: [f64; 2],
    /// What was noticed while loading.
    pub warnings: Vec<String>,
    /// Each scene at each size.
    pub rows: Vec<Row>,
    /// The hall at the first size, with different numbers of lights.
    pub light_sweep: Vec<Row>,
    /// The post filter of Eq. 2.14, which the rows leave out.
    pub post_filter: Vec<PostFilterRow>,
    /// Table 4.2.
    pub published_rates: [PublishedRate; 6],
    /// Table 4.1.
    pub published_passes: [PublishedPass; 7],
}

/// One scene at one size; times are medians of whole frames on the GPU.
#[derive(Default, Serialize)]
pub struct Row {
    /// Display, px.
    pub size: [u32; 2],
    /// What was rendered.
    pub scene: String,
    /// Lights in it; `None` where it is ray-marched.
    pub lights: Option<usize>,
    /// Pairs that were measured.
    pub runs: usize,
    /// Full shading.
    pub full_ms: f64,
    /// Foveated.
    pub kfr_ms: f64,
    /// Median of the pairs' ratios.
    pub speedup: f64,
    /// How far those ratios lie apart.
    pub spread: Spread,
    /// Shading samples with full shading.
    pub samples_full: u64,
    /// Shading samples foveated.
    pub samples_kfr: u64,
    /// Passes with full shading.
    pub passes_full: Vec<PassMedian>,
    /// Passes foveated.
    pub passes_kfr: Vec<PassMedian>,
    /// LP filter and inverse over the full frame's time.
    pub added_share: f64,
    /// The published speed-up at this size and kind of scene.
    pub published_speedup: Option<f64>,
    /// Whether foveation pays.
    pub pays: bool,
}

/// The least and the greatest of the pairs' ratios.
#[derive(Clone, Copy, Default, Serialize)]
pub struct Spread {
    /// What `low` and `high` are.
    pub kind: &'static str,
    /// The least.
    pub low: f64,
    /// The greatest.
    pub high: f64,
}

/// What the post filter adds.
#[derive(Serialize)]
pub struct PostFilterRow {
    /// Display, px.
    pub size: [u32; 2],
    /// What was rendered.
    pub scene: String,
    /// The whole foveated frame with the filter.
    pub kfr_with_post_filter_ms: f64,
    /// The filter's pass alone.
    pub post_filter_ms: f64,
    /// The post filter over the full frame's time.
    pub share: f64,
}

impl Loaded<'_> {
    /// Medians over alternating pairs after one warm-up of each. The renderers, which hold most of the
    /// GPU memory, live only as long as the row takes.
    fn measure(&self, args: &KfrBenchArgs, size: [u32; 2], steps: &Steps) -> Result<Row, Failure> {
        let input = self.input(&DisplayGeometry::symmetric(size, args.hfov_deg), args.gaze)?;
        let full_settings = settings(args, size, Method::Full);
        let mut full = OffscreenRenderer::new(self.device, &self.content, &full_settings)?;
        let kfr_settings = settings(args, size, Method::Kfr(kfr(args, false)?));
        let mut kfr = OffscreenRenderer::new(self.device, &self.content, &kfr_settings)?;
        full.render(&input)?;
        kfr.render(&input)?;
        let render = |second| {
            let renderer = if second { &mut kfr } else { &mut full };
            renderer.render(&input)
        };
        let pairs = measure_pairs(args.pairs(), render, |share| steps.within(share * 0.9))?;
        let published_speedup = paper::speedup(self.kind(), size);
        let lights = self.subject.scene().map(|scene| scene.lights.len());
        let row = Row { size, scene: self.name.clone(), lights, published_speedup, ..Row::default() };
        row.with_frames(&pairs.first, &pairs.second)
    }

    fn measure_post_filter(&self, args: &KfrBenchArgs, row: &Row) -> Result<PostFilterRow, Failure> {
        let input = self.input(&DisplayGeometry::symmetric(row.size, args.hfov_deg), args.gaze)?;
        let settings = settings(args, row.size, Method::Kfr(kfr(args, true)?));
        let mut renderer = OffscreenRenderer::new(self.device, &self.content, &settings)?;
        renderer.render(&input)?;
        let begun = Instant::now();
        let mut frames = vec![renderer.render(&input)?];
        while frames.len() < row.runs.min(5) && begun.elapsed() < POST_FILTER_BUDGET {
            frames.push(renderer.render(&input)?);
        }
        let passes = pass_medians(&frames);
        let filter_ms = time_of(&passes, POST_FILTER_PASS)?;
        Ok(PostFilterRow {
            size: row.size,
            scene: self.name.clone(),
            kfr_with_post_filter_ms: median(&gpu_times(&frames)).ok_or_else(no_times)?,
            post_filter_ms: filter_ms,
            share: filter_ms / row.full_ms,
        })
    }
}

impl Row {
    /// Fills in what follows from the frames of the alternating pairs.
    fn with_frames(self, full: &[FrameStats], kfr: &[FrameStats]) -> Result<Self, Failure> {
        let (full_times, kfr_times) = (gpu_times(full), gpu_times(kfr));
        let measured = speedup(&full_times, &kfr_times);
        let Speedup { median: ratio, least, greatest } = measured.ok_or_else(no_times)?;
        let full_ms = median(&full_times).ok_or_else(no_times)?;
        let passes_kfr = pass_medians(kfr);
        let added = ADDED_PASSES.iter().map(|name| time_of(&passes_kfr, name));
        let added_ms = added.sum::<Result<f64, Failure>>()?;
        let samples = |frames: &[FrameStats]| frames.last().map_or(0, |frame| frame.samples_shaded);
        Ok(Self {
            runs: full.len(),
            full_ms,
            kfr_ms: median(&kfr_times).ok_or_else(no_times)?,
            speedup: ratio,
            spread: Spread { kind: "least and greatest ratio of a pair", low: least, high: greatest },
            samples_full: samples(full),
            samples_kfr: samples(kfr),
            passes_full: pass_medians(full),
            passes_kfr,
            added_share: added_ms / full_ms,
            pays: ratio >= PAYS_FROM,
            ..self
        })
    }
}

fn no_times() -> Failure {
    Failure::environment("the device measures no GPU times; choose another with VK_DRIVER_FILES")
}

fn kfr(args: &KfrBenchArgs, post_filter: bool) -> Result<KfrSettings, Failure> {
    let kernel = args.kernel.kernel()?;
    Ok(KfrSettings { sigma: args.sigma, kernel, post_filter, ..KfrSettings::default() })
}

fn settings(args: &KfrBenchArgs, size: [u32; 2], method: Method) -> RenderSettings {
    let mut settings = RenderSettings::new(DisplayGeometry::symmetric(size, args.hfov_deg), method);
    settings.samples_per_pixel = args.spp;
    settings
}

/// Refuses before the first of many minutes what would fail in the last of them.
fn check(args: &KfrBenchArgs) -> Result<(), Failure> {
    for &size in &args.sizes {
        settings(args, size, Method::Kfr(kfr(args, false)?)).check()?;
    }
    let sweep = if args.no_light_sweep { &[][..] } else { &args.lights };
    for &lights in sweep.iter().chain([&args.hall_lights]) {
        let hall = HallArgs { triangles: Some(args.triangles), lights: Some(lights), ..HallArgs::default() };
        library::hall_options(&hall)?;
    }
    Ok(())
}

/// The share of the whole that a row takes: pixels, and lights that shade them.
fn weight(size: [u32; 2], lights: u32) -> f64 {
    size.map(f64::from).iter().product::<f64>() * (30.0 + f64::from(lights))
}

/// Measures everything that was asked for.
///
/// # Errors
/// Options out of range, and what loading and rendering report.
pub fn run(args: &KfrBenchArgs) -> Result<Results, Failure> {
    check(args)?;
    // Validation would be part of what is measured.
    let device = library::device(true)?;
    let first_size = args.sizes.first().copied().unwrap_or_default();
    let sweep = if args.no_light_sweep { &[][..] } else { &args.lights };
    let of_sizes = args.sizes.iter().map(|&size| weight(size, args.hall_lights)).sum::<f64>();
    let of_sweep = sweep.iter().map(|&lights| weight(first_size, lights)).sum::<f64>();
    let mut steps = Steps::long(of_sizes * args.scenes.len() as f64 + of_sweep);
    let (mut rows, mut post_filter, mut warnings) = (Vec::new(), Vec::new(), Vec::new());
    for source in &args.scenes {
        let loaded = Loaded::open(&device, source, args.hall_lights, args.triangles, &mut warnings)?;
        for &size in &args.sizes {
            let what = format!("{} at {}x{}", loaded.name, size[0], size[1]);
            steps.next_of_weight(&what, weight(size, args.hall_lights));
            let row = loaded.measure(args, size, &steps)?;
            post_filter.push(loaded.measure_post_filter(args, &row)?);
            rows.push(row);
        }
    }
    let mut light_sweep = Vec::new();
    for &lights in sweep {
        let of = if lights == 1 { "light" } else { "lights" };
        let what = format!("hall with {lights} {of} at {}x{}", first_size[0], first_size[1]);
        steps.next_of_weight(&what, weight(first_size, lights));
        let loaded = Loaded::open(&device, &Source::Hall, lights, args.triangles, &mut warnings)?;
        light_sweep.push(loaded.measure(args, first_size, &steps)?);
    }
    Ok(Results {
        device: device.name().to_owned(),
        driver: device.driver().to_owned(),
        method: "kfr",
        sigma: args.sigma,
        kernel: args.kernel.label(),
        hfov_deg: args.hfov_deg,
        gaze: args.gaze.to_array(),
        warnings,
        rows,
        light_sweep,
        post_filter,
        published_rates: paper::RATES,
        published_passes: paper::PASSES,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use macula::stats::PassTime;

    fn frame(passes: &[(&'static str, f64)], samples_shaded: u64) -> FrameStats {
        let pass = |&(name, gpu_ms): &(&'static str, f64)| PassTime { name, gpu_ms, diagnostic: false };
        let gpu_ms = passes.iter().map(|(_, gpu_ms)| gpu_ms).sum();
        FrameStats {
            passes: passes.iter().map(pass).collect(),
            gpu_ms,
            samples_shaded,
            ..FrameStats::default()
        }
    }

    #[test]
    fn a_row_follows_from_its_frames() {
        let full = [frame(&[("gbuffer", 2.0), ("full_shade", 18.0)], 1000)];
        let kfr = [frame(&[("gbuffer", 2.0), ("lp_shade", 2.0), ("lp_filter", 0.4), ("inverse", 0.6)], 300)];
        let Ok(row) = Row::default().with_frames(&full, &kfr) else { panic!() };
        assert!((row.speedup - 4.0).abs() < 1e-12 && row.pays);
        // Filter and inverse together, over the full frame.
        assert!((row.added_share - 0.05).abs() < 1e-12);
        assert_eq!((row.samples_full, row.samples_kfr), (1000, 300));
    }

    #[test]
    fn a_small_gain_does_not_pay() {
        let kfr = [("lp_shade", 9.0), ("lp_filter", 0.5), ("inverse", 0.5)];
        let of =
            |full_ms| Row::default().with_frames(&[frame(&[("full_shade", full_ms)], 1)], &[frame(&kfr, 1)]);
        assert!(of(10.4).is_ok_and(|row| !row.pays));
        assert!(of(10.6).is_ok_and(|row| row.pays));
    }

    #[test]
    fn a_renamed_pass_is_an_error_and_not_free() {
        let full = [frame(&[("full_shade", 20.0)], 1)];
        let kfr = [frame(&[("lp_shade", 9.0), ("lp_filter", 0.5), ("unfold", 0.5)], 1)];
        let Err(failure) = Row::default().with_frames(&full, &kfr) else { panic!("`inverse` is missing") };
        assert!(failure.line().is_some_and(|line| line.contains("`inverse`")), "{failure:?}");
    }

    #[test]
    fn a_device_without_timestamps_is_an_error() {
        let still = [frame(&[("a", 0.0)], 1)];
        assert!(matches!(Row::default().with_frames(&still, &still), Err(Failure::Environment(_))));
    }
}
