//! `macula render`: one picture, or both eyes' pictures, and what they cost.

mod stereo;

use crate::content::{CameraArgs, Source, Subject, load_environment, neutral_light, parse_source};
use crate::failure::Failure;
use crate::library;
use crate::measure::{PassMedian, findings, gpu_times, median, pass_medians};
use crate::options::{DisplayArgs, HallArgs, gaze_px, parse_pair};
use crate::output;
use crate::page::picture::lp_picture;
use crate::progress::Steps;
use crate::shading::{MethodName, ShadingArgs, without_meaning};
use clap::{Args, ValueEnum};
use glam::DVec2;
use macula::headless::{FrameInput, GpuContent, HeadlessDevice, OffscreenRenderer};
use macula::scene::environment::Environment;
use macula::settings::{RenderSettings, ToneMap, View};
use macula::stats::{Effects, FrameStats, LpStats};
use serde::Serialize;
use std::path::{Path, PathBuf};
use stereo::StereoArgs;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ViewName {
    /// The picture
    Picture,
    /// Samples per pixel as a colour: blue few, green one, red many
    Density,
    /// The LP-buffer's texel borders over the picture
    Grid,
    /// A cross at the gaze
    Gaze,
    /// Rings of eccentricity at 2, 5, 10, 20 and 40 degrees
    Rings,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ToneMapName {
    /// ACES filmic curve
    Aces,
    /// Clamped to 0..1 only
    None,
}

/// Render a scene to a picture and print what it cost
///
/// A .png holds the tone-mapped picture, an .exr linear radiance. Files appear only when they are
/// whole.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    macula render hall -o hall.png --gaze 0.3,0.6 --lp-out lp.png\n  \
    macula render scene.glb -o ref.exr --method full --size 2560x1440 --env sky.hdr\n  \
    macula render hall -o both.png --display psvr2 --stereo rep --fixation-m 2\n  \
    macula render scene.glb -o out.png --eye 0,1.6,4 --look-at 0,1,0 --sigma 1.6 --kernel sin\n  \
    macula render sdf:primitives -o sdf.png --spp 4 --json")]
pub struct RenderArgs {
    /// A .gltf or .glb file, `hall` (generated) or `sdf:primitives` (ray-marched)
    #[arg(value_name = "SCENE", value_parser = parse_source)]
    scene: Source,
    /// Where the picture goes: a .png or .exr file
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    display: DisplayArgs,
    /// Gaze as fractions of the display, from the left and from the top; off the display is allowed
    #[arg(long, value_name = "X,Y", default_value = "0.5,0.5", value_parser = parse_pair, allow_hyphen_values = true)]
    gaze: DVec2,
    #[command(flatten, next_help_heading = "Both eyes")]
    stereo: StereoArgs,
    #[command(flatten)]
    shading: ShadingArgs,
    /// Write the LP-buffer too: a .png or .exr file
    #[arg(long, value_name = "FILE", help_heading = "Foveation")]
    lp_out: Option<PathBuf>,
    #[command(flatten, next_help_heading = "Scene and camera")]
    camera: CameraArgs,
    /// Environment map: an equirectangular .exr or .hdr file, for sky and ambient light
    #[arg(long, value_name = "FILE", help_heading = "Scene and camera")]
    env: Option<PathBuf>,
    /// Time at which animations are evaluated, seconds [default: 0]
    #[arg(long, value_name = "SECONDS", help_heading = "Scene and camera")]
    time: Option<f64>,
    #[command(flatten, next_help_heading = "Scene and camera")]
    hall: HallArgs,
    /// What the picture shows
    #[arg(long, value_enum, default_value = "picture", help_heading = "Picture")]
    view: ViewName,
    /// From linear radiance to the display [default: aces]
    #[arg(long, value_enum, help_heading = "Picture")]
    tone_map: Option<ToneMapName>,
    /// Factor on radiance before tone mapping, above 0
    #[arg(long, value_name = "E", default_value_t = 1.0, help_heading = "Picture")]
    exposure: f32,
    /// Samples for each pixel or LP texel of a ray-marched scene, 1 to 16 [default: 1]
    #[arg(long, value_name = "N", help_heading = "Picture")]
    spp: Option<u32>,
    /// Lights that cast shadows, 0 to 16: directional ones first, then by intensity [default: 1]
    #[arg(long, value_name = "N", help_heading = "Picture")]
    shadowed_lights: Option<u32>,
    /// Texels along the side of a shadow map, 64 to 8192 [default: 1024]
    #[arg(long, value_name = "N", help_heading = "Picture")]
    shadow_map_size: Option<u32>,
    /// Run every effect, also those that the scene does not call for
    #[arg(long, help_heading = "Running")]
    force_effects: bool,
    /// Frames to measure, after one that warms up; times are their medians
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100_000), help_heading = "Running")]
    frames: u32,
    /// Do not use the Vulkan validation layer, which is on where it is installed
    #[arg(long, help_heading = "Running")]
    no_validation: bool,
    /// Print the frame graph to stderr: passes in order and every barrier
    #[arg(long, help_heading = "Running")]
    plan: bool,
}

/// The result; its field names are an interface.
#[derive(Serialize)]
struct Report<'a> {
    device: &'a str,
    driver: &'a str,
    size: [u32; 2],
    method: &'static str,
    passes: Vec<PassMedian>,
    gpu_ms: f64,
    samples_shaded: u64,
    lp: Option<LpStats>,
    effects: &'a Effects,
    non_finite: Option<u64>,
    holes: Option<u64>,
    validation_messages: Option<u64>,
    validation: &'static str,
    warnings: Vec<String>,
}

/// Runs the command.
///
/// # Errors
/// Everything that can go wrong between the command line and the picture's file.
pub fn run(args: &RenderArgs, json: bool) -> Result<(), Failure> {
    let settings = args.settings()?;
    for path in [Some(&args.output), args.lp_out.as_ref()].into_iter().flatten() {
        check_folder(path)?;
    }
    if let Some(mode) = args.stereo.stereo {
        return stereo::run(args, mode, settings, json);
    }
    let mut steps = Steps::short(4 + u64::from(args.frames));
    steps.next("loading");
    let Loaded { subject, environment, warnings } = args.load()?;
    let input = FrameInput {
        world_from_view: args.camera.world_from_view(&subject, &settings.display)?,
        gaze_px: gaze_px(args.gaze, args.display.size_px()),
    };
    steps.next("preparing");
    let device = library::device(args.no_validation)?;
    let content = GpuContent::upload(&device, &subject.content(environment.as_ref()))?;
    let mut renderer = OffscreenRenderer::new(&device, &content, &settings)?;
    // The first frame's time holds what the driver compiles when it first runs a pass.
    steps.next("warming up");
    renderer.render(&input)?;
    let mut frames = Vec::new();
    for _ in 0..args.frames {
        steps.next("rendering");
        frames.push(renderer.render(&input)?);
    }
    steps.next("writing");
    write_pictures(args, &settings, &mut renderer)?;
    drop(steps);
    if args.plan {
        output::note(renderer.plan_text().trim_end());
    }
    let report = report(args, &device, &renderer, &frames, warnings);
    if json { output::print_json(&report) } else { print_text(args, &report) }
}

/// What is rendered, in memory.
struct Loaded {
    subject: Subject,
    environment: Option<Environment>,
    warnings: Vec<String>,
}

impl RenderArgs {
    fn load(&self) -> Result<Loaded, Failure> {
        let mut warnings = Vec::new();
        let subject = self.scene.open(&self.hall, self.time.unwrap_or(0.0))?;
        warnings.extend(subject.scene().map(|scene| scene.warnings.clone()).unwrap_or_default());
        let environment = match &self.env {
            Some(path) => Some(load_environment(path, &mut warnings)?),
            None => neutral_light(&subject, &mut warnings),
        };
        Ok(Loaded { subject, environment, warnings })
    }

    fn settings(&self) -> Result<RenderSettings, Failure> {
        self.check_combinations()?;
        let display = self.display.geometry();
        display.check()?;
        let mut settings = self.shading.settings(display)?;
        settings.tone_map = match self.tone_map {
            Some(ToneMapName::None) => ToneMap::None,
            Some(ToneMapName::Aces) | None => ToneMap::Aces,
        };
        settings.view = match self.view {
            ViewName::Picture => View::Picture,
            ViewName::Density => View::Density,
            ViewName::Grid => View::Grid,
            ViewName::Gaze => View::Gaze,
            ViewName::Rings => View::Rings,
        };
        settings.exposure = self.exposure;
        settings.shadowed_lights = self.shadowed_lights.unwrap_or(settings.shadowed_lights);
        settings.shadow_map_size = self.shadow_map_size.unwrap_or(settings.shadow_map_size);
        settings.samples_per_pixel = self.spp.unwrap_or(settings.samples_per_pixel);
        settings.force_effects = self.force_effects;
        settings.check_finite = true;
        settings.check()?;
        Ok(settings)
    }

    /// Options that would be ignored are refused: whoever gives one expects it to do something.
    fn check_combinations(&self) -> Result<(), Failure> {
        self.check_method()?;
        self.check_content()?;
        self.check_stereo()?;
        let exr = is_exr(&self.output)?;
        if let Some(lp_out) = &self.lp_out {
            is_exr(lp_out)?;
            if *lp_out == self.output {
                return Err(Failure::usage("--output and --lp-out name the same file; name two"));
            }
        }
        if exr && self.view != ViewName::Picture {
            return Err(Failure::usage("--view is drawn on the tone-mapped picture; write it to a .png"));
        }
        if exr && self.tone_map.is_some() {
            return Err(Failure::usage(
                "an .exr holds linear radiance; leave --tone-map out or write a .png",
            ));
        }
        match self.time {
            Some(time) if !time.is_finite() => {
                Err(Failure::usage(format!("--time is {time}; give seconds as a finite number")))
            }
            _ => Ok(()),
        }
    }

    fn check_method(&self) -> Result<(), Failure> {
        let of_kfr = [(self.lp_out.is_some(), "--lp-out"), (self.view == ViewName::Grid, "--view grid")];
        match of_kfr.iter().find(|(given, _)| *given && self.shading.method == MethodName::Full) {
            Some((_, name)) => Err(without_meaning(name)),
            None => Ok(()),
        }
    }

    fn check_content(&self) -> Result<(), Failure> {
        let sdf = self.scene == Source::Sdf;
        let of_triangles = [
            (self.camera.camera.is_some(), "--camera"),
            (self.env.is_some(), "--env"),
            (self.time.is_some(), "--time"),
            (self.shadowed_lights.is_some(), "--shadowed-lights"),
            (self.shadow_map_size.is_some(), "--shadow-map-size"),
        ];
        if let Some((_, name)) = of_triangles.iter().find(|(given, _)| sdf && *given) {
            return Err(Failure::usage(format!(
                "{name} has no meaning for the ray-marched scene; leave it out"
            )));
        }
        if self.spp.is_some() && !sdf {
            return Err(Failure::usage("--spp is for sdf:primitives only; leave it out"));
        }
        match self.hall.given() {
            Some(name) if self.scene != Source::Hall => Err(Failure::usage(format!(
                "{name} is for the generated `hall` only; leave it out or render `hall`"
            ))),
            _ => Ok(()),
        }
    }
}

/// Whether a picture's name asks for EXR; otherwise it must ask for PNG.
fn is_exr(path: &Path) -> Result<bool, Failure> {
    let extension = path.extension().map(|extension| extension.to_ascii_lowercase());
    match extension.as_ref().and_then(|extension| extension.to_str()) {
        Some("exr") => Ok(true),
        Some("png") => Ok(false),
        _ => Err(Failure::usage(format!("{}: pictures are .png or .exr; name it so", path.display()))),
    }
}

/// Says before the rendering, not after it, that a picture has nowhere to go.
pub fn check_folder(path: &Path) -> Result<(), Failure> {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => Err(Failure::environment(
            format!("{}: the folder does not exist; make it first or write elsewhere", path.display()),
        )),
        _ => Ok(()),
    }
}

fn write_pictures(
    args: &RenderArgs,
    settings: &RenderSettings,
    renderer: &mut OffscreenRenderer,
) -> Result<(), Failure> {
    let size = args.display.size_px();
    if is_exr(&args.output)? {
        library::write_exr(&args.output, size, &renderer.read_hdr()?)?;
    } else {
        library::write_png(&args.output, size, &renderer.read_rgba8()?)?;
    }
    let Some(path) = &args.lp_out else { return Ok(()) };
    let Some((width, height, linear)) = renderer.read_lp()? else { return Ok(()) };
    if is_exr(path)? {
        return library::write_exr(path, [width, height], &linear);
    }
    library::write_png(path, [width, height], &lp_picture(&linear, settings.tone_map, settings.exposure))
}

fn report<'a>(
    args: &RenderArgs,
    device: &'a HeadlessDevice,
    renderer: &'a OffscreenRenderer,
    frames: &[FrameStats],
    mut warnings: Vec<String>,
) -> Report<'a> {
    let last = frames.last().cloned().unwrap_or_default();
    let validation_messages = device.validation_messages();
    let validation = validation_state(args, device);
    let non_finite = frames.iter().filter_map(|frame| frame.non_finite).max();
    let holes = frames.iter().filter_map(|frame| frame.holes).max();
    warnings.extend(findings(non_finite, holes, validation_messages));
    if last.gaze_held {
        warnings.push("the gaze is not finite; the display's centre was taken".into());
    }
    Report {
        device: device.name(),
        driver: device.driver(),
        size: args.display.size_px(),
        method: args.shading.name(),
        passes: pass_medians(frames),
        gpu_ms: median(&gpu_times(frames)).unwrap_or(last.gpu_ms),
        samples_shaded: last.samples_shaded,
        lp: last.lp,
        effects: renderer.effects(),
        non_finite,
        holes,
        validation_messages,
        validation,
        warnings,
    }
}

fn validation_state(args: &RenderArgs, device: &HeadlessDevice) -> &'static str {
    match device.validation_messages() {
        Some(_) => "on",
        None if args.no_validation => "off: --no-validation was given",
        None => "off: the validation layer is not installed",
    }
}

fn print_text(args: &RenderArgs, report: &Report<'_>) -> Result<(), Failure> {
    for warning in &report.warnings {
        output::note(&format!("warning: {warning}"));
    }
    let mut text = format!("{} on {} ({})\n\n", args.output.display(), report.device, report.driver);
    let row = |pass: &PassMedian| vec![pass.name.to_owned(), format!("{:.3}", pass.gpu_ms)];
    let mut rows = report.passes.iter().map(row).collect::<Vec<_>>();
    rows.push(vec!["frame".into(), format!("{:.3}", report.gpu_ms)]);
    text += &output::table(&["pass", "GPU ms"], &rows);
    let pixels = u64::from(report.size[0]) * u64::from(report.size[1]);
    let samples = report.samples_shaded;
    text += &format!("\nsamples    {} for {} pixels\n", output::grouped(samples), output::grouped(pixels));
    if let Some(lp) = report.lp {
        text += &format!(
            "LP-buffer  {}x{} texels, {} on the display, {} shaded, {} pixels shaded directly\n",
            lp.width,
            lp.height,
            output::grouped(lp.on_display),
            output::grouped(lp.shaded),
            output::grouped(lp.native_pixels)
        );
    }
    for (title, notes) in [("runs", &report.effects.run), ("left out", &report.effects.skipped)] {
        for note in notes {
            text += &format!("{title:<10} {}: {}\n", note.name, note.why);
        }
    }
    let count = |count: Option<u64>| count.map_or("not checked".into(), |count| count.to_string());
    text += &format!("not finite {}, holes {}\n", count(report.non_finite), count(report.holes));
    text += &format!("validation {}, messages: {}\n", report.validation, count(report.validation_messages));
    output::print(&text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use macula::fovea::Kernel;
    use macula::settings::{LpFilter, Method};

    #[derive(Parser)]
    struct Only {
        #[command(flatten)]
        args: RenderArgs,
    }

    fn settings(options: &str) -> Result<RenderSettings, Failure> {
        let words = format!("render {options}");
        match Only::try_parse_from(words.split_whitespace()) {
            Ok(only) => only.args.settings(),
            Err(error) => Err(Failure::usage(error.to_string())),
        }
    }

    #[test]
    fn defaults_are_those_of_the_user_study() {
        let Ok(settings) = settings("hall -o a.png") else { panic!() };
        let Method::Kfr(kfr) = &settings.method else { panic!("{settings:?}") };
        assert!((kfr.sigma - 1.8).abs() < 1e-12 && kfr.lp_filter == LpFilter::Gaussian && !kfr.post_filter);
        assert_eq!(kfr.kernel, Kernel::Power { alpha: 4.0 });
        assert!(settings.check_finite);
    }

    #[test]
    fn what_makes_no_sense_is_a_usage_error() {
        for wrong in [
            "hall -o a.png --method full --sigma 2",
            "hall -o a.png --method full --alpha 2",
            "hall -o a.png --method full --lp-out lp.png",
            "hall -o a.png --method full --view grid",
            "hall -o a.png --beta 0,1",
            "hall -o a.png --kernel poly",
            "hall -o a.png --kernel sin --alpha 2",
            "hall -o a.png --spp 4",
            "hall -o a.png --lp-out a.png",
            "hall -o a.jpg",
            "hall -o a",
            "hall -o a.exr --view rings",
            "hall -o a.exr --tone-map none",
            "hall -o a.png --sigma 0.5",
            "hall -o a.png --sigma nan",
            "hall -o a.png --exposure 0",
            "hall -o a.png --shadowed-lights 17",
            "hall -o a.png --frames 0",
            "hall -o a.png --time inf",
            "a.glb -o a.png --lights 3",
            "sdf:primitives -o a.png --camera x",
            "sdf:primitives -o a.png --env a.hdr",
            "sdf:primitives -o a.png --spp 17",
            "hall -o a.png --up 0,1,0",
            "hall -o a.png --gaze 1",
            "hall -o a.png --fixation-m 1",
            "hall -o a.png --stereo dup --fixation-m 0",
            "hall -o a.png --stereo dup --lp-out b.png",
            "hall -o a.png --stereo rep --method full",
            "sdf:primitives -o a.png --stereo rep",
            "hall -o a.png --stereo dup --display psvr2 --display-eye right",
        ] {
            assert!(matches!(settings(wrong), Err(Failure::Usage(_))), "{wrong}");
        }
    }

    #[test]
    fn what_makes_sense_is_taken() {
        for right in [
            "hall -o a.exr --method full --exposure 2 --frames 5",
            "hall -o a.png --kernel exp --sigma 4 --gaze -0.5,1.7 --lp-out lp.exr",
            "sdf:primitives -o a.png --spp 16 --eye 0,1,2 --look-at 0,0,0 --up 1,0,0",
            "hall -o a.exr --stereo rep --display psvr2 --fixation-m 0.5 --size 64x64",
            "hall -o a.PNG --triangles 20000 --lights 3 --seed 9 --view density",
        ] {
            let result = settings(right);
            assert!(result.is_ok(), "{right}: {result:?}");
        }
    }

    #[test]
    fn a_missing_folder_is_told_before_rendering() {
        assert!(check_folder(Path::new("no/such/folder/a.png")).is_err());
        assert!(check_folder(Path::new("a.png")).is_ok());
    }
}
