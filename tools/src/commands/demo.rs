//! `macula demo`: the generated scene at several gaze points, as pictures, a table and a page.

use crate::commands::compare::decibels;
use crate::content::{CameraArgs, Source, Subject};
use crate::failure::Failure;
use crate::library;
use crate::measure::{Pairs, gpu_times, measure_pairs, median, pass_medians, speedup};
use crate::options::{HallArgs, gaze_px, parse_hfov, parse_size};
use crate::output::{self, grouped};
use crate::page::picture::{difference_times_4, lp_picture};
use crate::page::{GazePart, Page};
use crate::progress::Steps;
use clap::Args;
use glam::{DMat4, DVec2};
use macula::fovea::DisplayGeometry;
use macula::headless::{FrameInput, GpuContent, HeadlessDevice, OffscreenRenderer};
use macula::settings::{KfrSettings, Method, RenderSettings, View};
use macula::stats::FrameStats;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Gaze points as fractions of the display, with the names that files and the page use.
const GAZES: [(&str, [f64; 2]); 3] = [("centre", [0.5, 0.5]), ("left", [0.2, 0.6]), ("corner", [0.85, 0.2])];

/// Render the generated hall at three gaze points, fully and foveated; leave pictures and a page
///
/// The page index.html holds everything: open it in any browser. The folder is made if need be.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  macula demo\n  macula demo -o out/large --size 1920x1080 --triangles 250000"
)]
pub struct DemoArgs {
    /// Folder for the pictures and index.html
    #[arg(short, long, value_name = "FOLDER", default_value = "out/demo")]
    output: PathBuf,
    /// Display size in pixels
    #[arg(long, value_name = "WxH", default_value = "960x540", value_parser = parse_size)]
    size: [u32; 2],
    /// Horizontal field of view of the display in degrees, above 0 and below 179
    #[arg(long, value_name = "D", default_value = "100", value_parser = parse_hfov)]
    hfov_deg: f64,
    /// Triangles of the hall, about, 10000 to 5000000
    #[arg(long, value_name = "N", default_value_t = 60_000)]
    triangles: u32,
    /// Lights of the hall, 1 to 1000
    #[arg(long, value_name = "N", default_value_t = 64)]
    lights: u32,
    /// Pairs of frames measured at each gaze
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    runs: u32,
}

impl DemoArgs {
    fn settings(&self, method: Method) -> RenderSettings {
        RenderSettings::new(DisplayGeometry::symmetric(self.size, self.hfov_deg), method)
    }

    fn picture_path(&self, name: &str) -> PathBuf {
        self.output.join(format!("{name}.png"))
    }
}

/// The renderers of one view.
struct Stage<'a> {
    args: &'a DemoArgs,
    world_from_view: DMat4,
    full: OffscreenRenderer,
    kfr: OffscreenRenderer,
    rings: OffscreenRenderer,
}

impl<'a> Stage<'a> {
    fn new(args: &'a DemoArgs, device: &HeadlessDevice, subject: &Subject) -> Result<Self, Failure> {
        let full = args.settings(Method::Full);
        let kfr = args.settings(Method::Kfr(KfrSettings::default()));
        let rings = RenderSettings { view: View::Rings, ..kfr.clone() };
        let content = GpuContent::upload(device, &subject.content(None))?;
        Ok(Self {
            args,
            world_from_view: CameraArgs::default().world_from_view(subject, &full.display)?,
            full: OffscreenRenderer::new(device, &content, &full)?,
            kfr: OffscreenRenderer::new(device, &content, &kfr)?,
            rings: OffscreenRenderer::new(device, &content, &rings)?,
        })
    }

    fn input(&self, gaze: [f64; 2]) -> FrameInput {
        let gaze_px = gaze_px(DVec2::from_array(gaze), self.args.size);
        FrameInput { world_from_view: self.world_from_view, gaze_px }
    }

    /// Alternating pairs at one gaze, after one warm-up of each.
    fn measure(&mut self, gaze: [f64; 2]) -> Result<Pairs<FrameStats>, Failure> {
        let input = self.input(gaze);
        self.full.render(&input)?;
        self.kfr.render(&input)?;
        let pairs = measure_pairs(self.args.runs as usize, |second| {
            let renderer = if second { &mut self.kfr } else { &mut self.full };
            renderer.render(&input)
        })?;
        Ok(pairs)
    }

    /// Writes one gaze's pictures and gathers what the page shows of it.
    fn part(&mut self, name: &'static str, gaze: [f64; 2], full: &[u8]) -> Result<GazePart, Failure> {
        let pairs = self.measure(gaze)?;
        let (full_times, kfr_times) = (gpu_times(&pairs.first), gpu_times(&pairs.second));
        let no_times = || Failure::environment("the device measures no GPU times; choose another device");
        let size = self.args.size;
        let foveated = self.kfr.read_rgba8()?;
        let (lp_width, lp_height, lp_linear) = self.kfr.read_lp()?.unwrap_or_default();
        let settings = self.args.settings(Method::Full);
        let lp_rgba8 = lp_picture(&lp_linear, settings.tone_map, settings.exposure);
        self.rings.render(&self.input(gaze))?;
        let rings = self.rings.read_rgba8()?;
        let samples = |frames: &[FrameStats]| frames.last().map_or(0, |frame| frame.samples_shaded);
        let picture = |kind: &str, size: [u32; 2], rgba8: &[u8]| {
            written_png(&self.args.picture_path(&format!("{name}-{kind}")), size, rgba8)
        };
        Ok(GazePart {
            name,
            gaze,
            kfr_png: picture("foveated", size, &foveated)?,
            difference_png: picture("difference", size, &difference_times_4(full, &foveated))?,
            rings_png: picture("rings", size, &rings)?,
            lp_png: picture("lp-buffer", [lp_width, lp_height], &lp_rgba8)?,
            lp: pairs.second.last().and_then(|frame| frame.lp).unwrap_or_default(),
            full_ms: median(&full_times).ok_or_else(no_times)?,
            kfr_ms: median(&kfr_times).ok_or_else(no_times)?,
            speedup: speedup(&full_times, &kfr_times).ok_or_else(no_times)?.median,
            samples: [samples(&pairs.first), samples(&pairs.second)],
            passes: pass_medians(&pairs.second),
            error: library::compare_pictures(
                full,
                &foveated,
                size,
                Some((&settings.display, gaze_px(gaze.into(), size))),
            )?,
        })
    }
}

/// Writes a PNG file and returns its bytes.
fn written_png(path: &Path, size: [u32; 2], rgba8: &[u8]) -> Result<Vec<u8>, Failure> {
    library::write_png(path, size, rgba8)?;
    std::fs::read(path).map_err(|error| macula::Error::io(path, error).into())
}

/// Runs the command.
///
/// # Errors
/// Options out of range, a folder that cannot be written, and what rendering reports.
pub fn run(args: &DemoArgs, json: bool) -> Result<(), Failure> {
    args.settings(Method::Kfr(KfrSettings::default())).check()?;
    let hall = HallArgs { triangles: Some(args.triangles), lights: Some(args.lights), seed: None };
    library::hall_options(&hall)?;
    std::fs::create_dir_all(&args.output).map_err(|error| macula::Error::io(&args.output, error))?;
    let mut steps = Steps::long(4 + GAZES.len() as u64);
    steps.next("generating and loading the hall");
    let subject = Source::Hall.open(&hall, 0.0)?;
    steps.next("preparing the device");
    let device = library::device(true)?;
    let mut stage = Stage::new(args, &device, &subject)?;
    steps.next("full shading");
    stage.full.render(&stage.input(GAZES[0].1))?;
    let full = stage.full.read_rgba8()?;
    let full_png = written_png(&args.picture_path("full"), args.size, &full)?;
    let mut gazes = Vec::new();
    for (name, gaze) in GAZES {
        steps.next(&format!("full and foveated, gaze {name}"));
        gazes.push(stage.part(name, gaze, &full)?);
    }
    steps.next("writing the page");
    let facts = facts(args, &device, &subject);
    let page = Page { size: args.size, facts, full_png, gazes, effects: stage.kfr.effects() };
    let path = args.output.join("index.html");
    library::write_file(&path, page.html().as_bytes())?;
    drop(steps);
    if json {
        return output::print_json(&report(args, &device, &page, &path));
    }
    output::print(&format!(
        "{} ({})\n\n{}\npage: {}\n",
        device.name(),
        device.driver(),
        table(&page),
        path.display()
    ))
}

fn facts(args: &DemoArgs, device: &HeadlessDevice, subject: &Subject) -> Vec<(&'static str, String)> {
    let triangles = subject.scene().map_or(0, macula::scene::Scene::triangle_count);
    vec![
        ("Device", device.name().to_owned()),
        ("Driver", device.driver().to_owned()),
        ("Scene", format!("generated hall, {} triangles, {} lights", grouped(triangles), args.lights)),
        ("Display", format!("{}×{} px, {} degrees across", args.size[0], args.size[1], args.hfov_deg)),
        ("Method", "kernel foveated rendering, sigma 1.8, kernel x^4, LP filter on".into()),
        ("Measured", format!("{} alternating pairs at each gaze, after a warm-up", args.runs)),
        ("Program", format!("macula {}", env!("CARGO_PKG_VERSION"))),
    ]
}

fn table(page: &Page<'_>) -> String {
    let row = |part: &GazePart| {
        vec![
            format!("{} ({}, {})", part.name, part.gaze[0], part.gaze[1]),
            format!("{:.1}", part.full_ms),
            format!("{:.1}", part.kfr_ms),
            format!("{:.2}x", part.speedup),
            grouped(part.samples[0]),
            grouped(part.samples[1]),
            decibels(part.error.psnr_within_5_deg_db),
        ]
    };
    let header =
        ["gaze", "full ms", "foveated ms", "speed-up", "samples full", "samples foveated", "PSNR within 5°"];
    output::table(&header, &page.gazes.iter().map(row).collect::<Vec<_>>())
}

fn report(args: &DemoArgs, device: &HeadlessDevice, page: &Page<'_>, path: &Path) -> serde_json::Value {
    let row = |part: &GazePart| {
        json!({
            "gaze": part.gaze,
            "full_ms": part.full_ms,
            "kfr_ms": part.kfr_ms,
            "speedup": part.speedup,
            "samples_full": part.samples[0],
            "samples_kfr": part.samples[1],
            "error": part.error,
        })
    };
    json!({
        "device": device.name(),
        "driver": device.driver(),
        "size": args.size,
        "page": path.display().to_string(),
        "rows": page.gazes.iter().map(row).collect::<Vec<_>>(),
    })
}
