//! `macula demo`: the generated scene at several gaze points, as pictures, a table and a page.

use crate::commands::compare::decibels;
use crate::content::{CameraArgs, Source, Subject};
use crate::failure::Failure;
use crate::library;
use crate::measure::{PairCount, gpu_times, measure_pairs, median, pass_medians, speedup};
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

/// What is shown: names of files, names on the page, and the gaze as fractions of the display.
type Shot = (&'static str, &'static str, [f64; 2]);

/// In the generated hall.
const HALL_SHOTS: [Shot; 3] = [
    ("centre", "Hall, centre", [0.5, 0.5]),
    ("lower-left", "Hall, lower left", [0.22, 0.72]),
    ("upper-right", "Hall, upper right", [0.8, 0.25]),
];

/// In the ray-marched scene.
const SDF_SHOT: Shot = ("ray-marched", "Ray-marched", [0.5, 0.5]);

/// Render fully and foveated: the generated hall at three gaze points, a ray-marched scene at one
///
/// Leaves pictures, prints a table, and writes a page. The page index.html holds everything: open it in any browser. The folder is made if need be.
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
    /// Pairs of frames measured for each picture
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=10_000))]
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

/// The renderers of one scene.
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
        let mut stage = Self {
            args,
            world_from_view: CameraArgs::default().world_from_view(subject, &full.display)?,
            full: OffscreenRenderer::new(device, &content, &full)?,
            kfr: OffscreenRenderer::new(device, &content, &kfr)?,
            rings: OffscreenRenderer::new(device, &content, &rings)?,
        };
        // The first frame's time holds what the driver compiles when it first runs a pass.
        let input = stage.input([0.5, 0.5]);
        stage.full.render(&input)?;
        stage.kfr.render(&input)?;
        Ok(stage)
    }

    fn input(&self, gaze: [f64; 2]) -> FrameInput {
        let gaze_px = gaze_px(DVec2::from_array(gaze), self.args.size);
        FrameInput { world_from_view: self.world_from_view, gaze_px }
    }

    /// Measures and writes the pictures of one shot, and gathers what the page shows of it. The full
    /// picture, which does not depend on the gaze, is in the first shot of a scene only.
    fn part(&mut self, (slug, title, gaze): Shot, full_slug: Option<&str>) -> Result<GazePart, Failure> {
        let input = self.input(gaze);
        let render = |second| {
            let renderer = if second { &mut self.kfr } else { &mut self.full };
            renderer.render(&input)
        };
        let pairs = measure_pairs(PairCount::Fixed(self.args.runs), render, |_| ())?;
        let (full_times, kfr_times) = (gpu_times(&pairs.first), gpu_times(&pairs.second));
        let no_times = || Failure::environment("the device measures no GPU times; choose another device");
        let size = self.args.size;
        let full = self.full.read_rgba8()?;
        let foveated = self.kfr.read_rgba8()?;
        let (lp_width, lp_height, lp_linear) = self.kfr.read_lp()?.unwrap_or_default();
        let settings = self.args.settings(Method::Full);
        let lp_rgba8 = lp_picture(&lp_linear, settings.tone_map, settings.exposure);
        self.rings.render(&input)?;
        let rings = self.rings.read_rgba8()?;
        let samples = |frames: &[FrameStats]| frames.last().map_or(0, |frame| frame.samples_shaded);
        let picture = |kind: &str, size: [u32; 2], rgba8: &[u8]| {
            written_png(&self.args.picture_path(&format!("{slug}-{kind}")), size, rgba8)
        };
        let full_png = full_slug.map(|slug| written_png(&self.args.picture_path(slug), size, &full));
        Ok(GazePart {
            name: title,
            gaze,
            full_png: full_png.transpose()?,
            kfr_png: picture("foveated", size, &foveated)?,
            difference_png: picture("difference", size, &difference_times_4(&full, &foveated))?,
            rings_png: picture("rings", size, &rings)?,
            lp_png: picture("lp-buffer", [lp_width, lp_height], &lp_rgba8)?,
            lp: pairs.second.last().and_then(|frame| frame.lp).unwrap_or_default(),
            full_ms: median(&full_times).ok_or_else(no_times)?,
            kfr_ms: median(&kfr_times).ok_or_else(no_times)?,
            speedup: speedup(&full_times, &kfr_times).ok_or_else(no_times)?.median,
            samples: [samples(&pairs.first), samples(&pairs.second)],
            passes: pass_medians(&pairs.second),
            error: library::compare_pictures(
                &full,
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
    let hall = HallArgs { triangles: Some(args.triangles), lights: Some(args.lights), ..HallArgs::default() };
    library::hall_options(&hall)?;
    if args.output.exists() && !args.output.is_dir() {
        let path = args.output.display();
        return Err(Failure::environment(format!("{path}: is not a folder; name another with --output")));
    }
    let device = library::device(true)?;
    let mut steps = Steps::long(5.0 + HALL_SHOTS.len() as f64);
    steps.next("generating and loading the hall");
    let hall = Source::Hall.open(&hall, 0.0)?;
    steps.next("preparing the hall");
    let mut stage = Stage::new(args, &device, &hall)?;
    // Only now, so that a size beyond the device's limits leaves no empty folder behind.
    std::fs::create_dir_all(&args.output).map_err(|error| macula::Error::io(&args.output, error))?;
    let mut gazes = Vec::new();
    for (index, shot) in HALL_SHOTS.into_iter().enumerate() {
        steps.next(&format!("{}: full and foveated", shot.1));
        gazes.push(stage.part(shot, (index == 0).then_some("full"))?);
    }
    let effects = stage.kfr.effects().clone();
    drop(stage);
    steps.next("preparing the ray-marched scene");
    let mut stage = Stage::new(args, &device, &Subject::Sdf)?;
    steps.next(&format!("{}: full and foveated", SDF_SHOT.1));
    gazes.push(stage.part(SDF_SHOT, Some("ray-marched-full"))?);
    drop(stage);
    steps.next("writing the page");
    let facts = facts(args, &device, &hall);
    let page = Page { size: args.size, facts, gazes, effects: &effects };
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
        (
            "Scenes",
            format!(
                "generated hall, {} triangles, {} lights; ray-marched primitives",
                grouped(triangles),
                args.lights
            ),
        ),
        ("Display", format!("{}×{} px, {} degrees across", args.size[0], args.size[1], args.hfov_deg)),
        ("Method", "kernel foveated rendering, sigma 1.8, kernel x^4, LP filter on".into()),
        ("Measured", format!("{} alternating pairs for each row, after a warm-up", args.runs)),
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
    let header = [
        "scene and gaze",
        "full ms",
        "foveated ms",
        "speed-up",
        "samples full",
        "samples foveated",
        "PSNR within 5°",
    ];
    output::table(&header, &page.gazes.iter().map(row).collect::<Vec<_>>())
}

fn report(args: &DemoArgs, device: &HeadlessDevice, page: &Page<'_>, path: &Path) -> serde_json::Value {
    let row = |part: &GazePart| {
        json!({
            "name": part.name,
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
