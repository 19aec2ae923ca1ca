//! `macula bench flicker`: how much a slow move of the camera makes the picture flicker, per ring of
//! eccentricity, beside full shading.

use crate::content::{CameraArgs, Source, Subject, moved, neutral_light, parse_source};
use crate::failure::Failure;
use crate::library;
use crate::measure::{PassMedian, pass_medians};
use crate::options::{DisplayArgs, HallArgs, gaze_px, parse_pair, parse_within};
use crate::output::{self, table};
use crate::progress::Steps;
use clap::Args;
use glam::{DMat4, DVec2};
use macula::fovea::DisplayGeometry;
use macula::headless::{FrameInput, GpuContent, HeadlessDevice, OffscreenRenderer};
use macula::quality::picture::Picture;
use macula::quality::temporal::{self, RingRatio, RingVariance, TemporalVariance};
use macula::settings::{KfrSettings, Method, RenderSettings, VafrSettings};
use macula::stats::FrameStats;
use serde::Serialize;

/// Temporal variance of a slow move of the camera over glossy surfaces, per ring of eccentricity
///
/// The gaze stays; the eye turns and moves by the same small step from frame to frame. Every method is
/// rendered in every frame, each with and without shading over footprints. Ratios are to full shading of
/// the same frames; how much of full shading's own variance is the move itself, and not its aliasing, is
/// estimated from full shading with four samples a pixel.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  macula bench flicker --size 1280x720 --hfov-deg 40 --lights 32\n  \
                        macula bench flicker --frames 24 --json > flicker.json")]
pub struct FlickerArgs {
    /// Scene: hall, or a .gltf or .glb file
    #[arg(long, value_name = "NAME", value_parser = parse_source, default_value = "hall")]
    scene: Source,
    #[command(flatten)]
    hall: HallArgs,
    #[command(flatten)]
    camera: CameraArgs,
    #[command(flatten)]
    display: DisplayArgs,
    /// Gaze as fractions of the display
    #[arg(long, value_name = "X,Y", default_value = "0.5,0.5", value_parser = parse_pair, allow_hyphen_values = true)]
    gaze: DVec2,
    /// Frames, 2 to 1000
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u32).range(2..=1000))]
    frames: u32,
    /// Turn about the vertical axis from frame to frame, degrees, 0 to 5
    #[arg(long, value_name = "D", default_value = "0.05", value_parser = parse_yaw_deg)]
    yaw_deg: f64,
    /// Move to the right from frame to frame, millimetres, 0 to 1000
    #[arg(long, value_name = "MM", default_value = "2", value_parser = parse_step_mm)]
    step_mm: f64,
    /// Leave out the four samples a pixel, which take most of the time
    #[arg(long)]
    no_motion_share: bool,
}

fn parse_yaw_deg(text: &str) -> Result<f64, String> {
    parse_within(text, 0.0, 5.0)
}

fn parse_step_mm(text: &str) -> Result<f64, String> {
    parse_within(text, 0.0, 1000.0)
}

/// What was measured.
#[derive(Serialize)]
struct Results {
    device: String,
    driver: String,
    scene: String,
    size: [u32; 2],
    hfov_deg: f64,
    gaze: [f64; 2],
    frames: u32,
    yaw_deg: f64,
    step_mm: f64,
    /// Full shading, in squared encoded luminance.
    full: Vec<RingVariance>,
    /// Full shading's passes.
    full_passes: Vec<PassMedian>,
    /// Four samples a pixel over full shading.
    motion: Option<Vec<RingRatio>>,
    variants: Vec<Variant>,
    warnings: Vec<String>,
}

/// One way of foveated shading.
#[derive(Serialize)]
struct Variant {
    name: &'static str,
    /// Over full shading.
    rings: Vec<RingRatio>,
    samples: u64,
    passes: Vec<PassMedian>,
}

/// One renderer with what its frames add up to.
struct Track<'a> {
    name: &'static str,
    renderer: OffscreenRenderer,
    variance: TemporalVariance,
    frames: Vec<FrameStats>,
    /// Pixels of the renderer along a pixel of the display.
    scale: u32,
    display: &'a DisplayGeometry,
}

impl<'a> Track<'a> {
    fn new(
        device: &HeadlessDevice,
        content: &GpuContent,
        display: &'a DisplayGeometry,
        (name, method, footprint, scale): (&'static str, Method, bool, u32),
    ) -> Result<Self, Failure> {
        let rendered = DisplayGeometry { size_px: display.size_px.map(|side| side * scale), ..*display };
        let mut settings = RenderSettings::new(rendered, method);
        settings.footprint = footprint;
        let renderer = OffscreenRenderer::new(device, content, &settings)?;
        let variance = TemporalVariance::new(display.size_px)?;
        Ok(Self { name, renderer, variance, frames: Vec::new(), scale, display })
    }

    fn add_frame(&mut self, input: &FrameInput) -> Result<(), Failure> {
        let gaze_px = input.gaze_px * f64::from(self.scale);
        self.frames.push(self.renderer.render(&FrameInput { gaze_px, ..*input })?);
        let rgba8 = self.renderer.read_rgba8()?;
        let rgb8: Vec<u8> = rgba8.chunks_exact(4).flat_map(|texel| [texel[0], texel[1], texel[2]]).collect();
        if self.scale == 1 {
            self.variance.add(Picture::Srgb8(&rgb8))?;
        } else {
            let mean = box_mean(&rgb8, self.display.size_px, self.scale as usize);
            self.variance.add(Picture::Linear(&mean))?;
        }
        Ok(())
    }

    fn rings(&self, gaze_px: DVec2) -> Result<Vec<RingVariance>, Failure> {
        Ok(self.variance.rings(self.display, gaze_px)?)
    }

    fn passes(&self) -> Vec<PassMedian> {
        pass_medians(&self.frames)
    }
}

/// The display's light of a picture that is larger by a whole factor: means of its squares of pixels.
fn box_mean(rgb8: &[u8], [width, height]: [u32; 2], scale: usize) -> Vec<f32> {
    let [width, height] = [width as usize, height as usize];
    let linear: [f32; 256] = std::array::from_fn(|byte| {
        let encoded = byte as f32 / 255.0;
        // IEC 61966-2-1.
        if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
    });
    let mut sums = vec![0.0; 3 * width * height];
    for (y, row) in rgb8.chunks_exact(3 * width * scale).enumerate() {
        let first = 3 * width * (y / scale);
        for (x, pixel) in row.chunks_exact(3).enumerate() {
            for (channel, byte) in pixel.iter().enumerate() {
                sums[first + 3 * (x / scale) + channel] += linear[usize::from(*byte)];
            }
        }
    }
    let share = 1.0 / (scale * scale) as f32;
    sums.iter_mut().for_each(|sum| *sum *= share);
    sums
}

/// The eye in a frame: turned about the world's vertical axis and moved to its right, both in even steps
/// around the given view.
fn pose(world_from_view: DMat4, args: &FlickerArgs, frame: u32) -> DMat4 {
    let step = f64::from(frame) - f64::from(args.frames - 1) / 2.0;
    moved(world_from_view, args.yaw_deg * step, args.step_mm * step)
}

/// What is compared: full shading, more samples of it, and each method without and with footprints.
fn subjects(args: &FlickerArgs) -> Vec<(&'static str, Method, bool, u32)> {
    let kfr = || Method::Kfr(KfrSettings::default());
    let vafr = || Method::Vafr(VafrSettings::default());
    let mut subjects = vec![
        ("full", Method::Full, false, 1),
        ("kfr", kfr(), false, 1),
        ("kfr, footprint", kfr(), true, 1),
        ("vafr, no footprint", vafr(), false, 1),
        ("vafr", vafr(), true, 1),
    ];
    if !args.no_motion_share {
        subjects.push(("full, 4 samples", Method::Full, false, 2));
    }
    subjects
}

/// Runs the command.
///
/// # Errors
/// Options out of range, and what loading and rendering report.
pub fn run(args: &FlickerArgs, json: bool) -> Result<(), Failure> {
    if args.scene != Source::Hall
        && let Some(name) = args.hall.given()
    {
        return Err(Failure::usage(format!("{name} belongs to --scene hall; leave it out")));
    }
    let results = measure(args)?;
    for warning in &results.warnings {
        output::note(&format!("warning: {warning}"));
    }
    if json { output::print_json(&results) } else { output::print(&text(&results)) }
}

fn measure(args: &FlickerArgs) -> Result<Results, Failure> {
    let display = args.display.geometry();
    let subject = args.scene.open(&args.hall, 0.0)?;
    if matches!(subject, Subject::Sdf) {
        return Err(Failure::usage("the ray-marched scene has no G-buffer; name a scene of triangles"));
    }
    let mut warnings = subject.scene().map(|scene| scene.warnings.clone()).unwrap_or_default();
    let environment = neutral_light(&subject, &mut warnings);
    let world_from_view = args.camera.world_from_view(&subject, &display)?;
    let device = library::device(true)?;
    let content = GpuContent::upload(&device, &subject.content(environment.as_ref()))?;
    let tracks = subjects(args).into_iter().map(|of| Track::new(&device, &content, &display, of));
    let mut tracks = tracks.collect::<Result<Vec<_>, _>>()?;
    let gaze_px = gaze_px(args.gaze, display.size_px);
    let mut steps = Steps::long(f64::from(args.frames));
    for frame in 0..args.frames {
        steps.next(&format!("frame {}", frame + 1));
        let input = FrameInput { world_from_view: pose(world_from_view, args, frame), gaze_px };
        tracks.iter_mut().try_for_each(|track| track.add_frame(&input))?;
    }
    drop(steps);
    let full = tracks[0].rings(gaze_px)?;
    let over_full =
        |track: &Track| -> Result<_, Failure> { Ok(temporal::ratio(&track.rings(gaze_px)?, &full)?) };
    let motion = tracks.iter().find(|track| track.scale > 1).map(over_full).transpose()?;
    let foveated = tracks[1..].iter().filter(|track| track.scale == 1);
    let variants = foveated.map(|track| {
        let samples = track.frames.last().map_or(0, |frame| frame.samples_shaded);
        Ok(Variant { name: track.name, rings: over_full(track)?, samples, passes: track.passes() })
    });
    Ok(Results {
        variants: variants.collect::<Result<Vec<_>, Failure>>()?,
        device: device.name().to_owned(),
        driver: device.driver().to_owned(),
        scene: args.scene.name(),
        size: display.size_px,
        hfov_deg: args.display.hfov_deg(),
        gaze: args.gaze.to_array(),
        frames: args.frames,
        yaw_deg: args.yaw_deg,
        step_mm: args.step_mm,
        full_passes: tracks[0].passes(),
        motion,
        full,
        warnings,
    })
}

fn text(results: &Results) -> String {
    let [width, height] = results.size;
    let mut text = format!(
        "{} ({})\n{} at {width}x{height}, {} degrees across, gaze ({}, {})\n\
         {} frames, {} degrees and {} mm from each to the next\n",
        results.device,
        results.driver,
        results.scene,
        results.hfov_deg,
        results.gaze[0],
        results.gaze[1],
        results.frames,
        results.yaw_deg,
        results.step_mm
    );
    text += "\nTemporal variance over full shading's\n";
    text += &rings(results, |ratio| ratio.variance);
    text += "\nMean squared change from frame to frame over full shading's\n";
    text += &rings(results, |ratio| ratio.flicker);
    if results.motion.is_some() {
        text += "\nmotion: what four samples a pixel leave of full shading's, the share that is the move itself\n";
    }
    text += "\nGPU time, medians over the frames, ms\n";
    text + &times(results)
}

fn rings(results: &Results, of: impl Fn(&RingRatio) -> Option<f64>) -> String {
    let mut header = vec!["degrees", "pixels"];
    header.extend(results.motion.is_some().then_some("motion"));
    header.extend(results.variants.iter().map(|variant| variant.name));
    let shown = |ratio: &RingRatio| of(ratio).map_or("-".into(), |value| format!("{value:.3}"));
    let row = |(index, ring): (usize, &RingVariance)| {
        let end = if ring.to_deg.is_finite() { ring.to_deg.to_string() } else { String::new() };
        let mut cells = vec![format!("{}..{end}", ring.from_deg), output::grouped(ring.pixels)];
        let all = results.motion.iter().chain(results.variants.iter().map(|variant| &variant.rings));
        cells.extend(all.map(|rings| shown(&rings[index])));
        cells
    };
    let with_pixels = results.full.iter().enumerate().filter(|(_, ring)| ring.pixels > 0);
    table(&header, &with_pixels.map(row).collect::<Vec<_>>())
}

fn times(results: &Results) -> String {
    let time = |passes: &[PassMedian], name: &str| {
        let found = passes.iter().find(|pass| pass.name == name);
        found.map_or("-".into(), |pass| format!("{:.2}", pass.gpu_ms))
    };
    let row = |name: &str, passes: &[PassMedian], shade: &str, samples: Option<u64>| {
        let samples = samples.map_or("-".into(), output::grouped);
        let all: f64 = passes.iter().map(|pass| pass.gpu_ms).sum();
        let passes = ["footprint", "gbuffer", shade].map(|pass| time(passes, pass));
        [vec![name.to_owned(), samples], passes.to_vec(), vec![format!("{all:.2}")]].concat()
    };
    let mut rows = vec![row("full", &results.full_passes, "full_shade", None)];
    let variants = results.variants.iter();
    rows.extend(variants.map(|of| row(of.name, &of.passes, "lp_shade", Some(of.samples))));
    table(&["method", "samples", "footprint", "gbuffer", "shading", "all"], &rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_larger_picture_is_averaged_as_light() {
        // Half black, half white: half the light.
        let columns = [0, 255, 0, 255];
        let row: Vec<u8> = columns.iter().flat_map(|&value| [value, value, 255]).collect();
        let picture = [row.clone(), row].concat();
        let mean = box_mean(&picture, [2, 1], 2);
        assert_eq!(mean, [0.5, 0.5, 1.0, 0.5, 0.5, 1.0]);
    }
}
