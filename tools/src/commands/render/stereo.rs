//! `macula render --stereo`: both eyes beside each other, and what the right eye saves by taking from the
//! left one.

use super::{Loaded, RenderArgs, is_exr, validation_state};
use crate::content::Source;
use crate::failure::Failure;
use crate::library;
use crate::measure::{
    PairCount, Pairs, PassMedian, Speedup, findings, gpu_times, measure_pairs, median, pass_medians, speedup,
};
use crate::options::{gaze_px, parse_within};
use crate::output;
use crate::progress::Steps;
use crate::shading::MethodName;
use clap::{Args, ValueEnum};
use macula::headless::{GpuContent, HeadlessDevice, OffscreenStereo};
use macula::quality::compare::Comparison;
use macula::settings::RenderSettings;
use macula::stats::{Effects, FrameStats, LpStats};
use macula::stereo::{StereoGaze, StereoInput, StereoMode, StereoSettings};
use serde::Serialize;

/// How the right eye comes about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum StereoName {
    /// Each eye is rendered by itself
    Dup,
    /// The right eye takes what looks the same from the left one; compared with dup
    Rep,
}

/// Options of both eyes.
#[derive(Args, Clone, Debug)]
pub(super) struct StereoArgs {
    /// Render both eyes, the left one beside the right one; --gaze is the left eye's
    #[arg(long, value_enum, value_name = "MODE")]
    pub(super) stereo: Option<StereoName>,
    /// Distance of the point that both eyes look at, metres, 0.05 to 1e6 [default: they look in parallel]
    #[arg(long, value_name = "D", requires = "stereo", value_parser = parse_fixation, allow_hyphen_values = true)]
    fixation_m: Option<f64>,
}

fn parse_fixation(text: &str) -> Result<f64, String> {
    parse_within(text, 0.05, 1e6)
}

/// Most people's distance between the eyes, as headsets that adapt take it, mm.
const IPD_MM: f64 = 63.0;

impl RenderArgs {
    /// Options that two eyes have no use for.
    pub(super) fn check_stereo(&self) -> Result<(), Failure> {
        let Some(mode) = self.stereo.stereo else { return Ok(()) };
        let of_one_eye =
            [(self.lp_out.is_some(), "--lp-out"), (self.display.display_eye.is_some(), "--display-eye")];
        if let Some((_, name)) = of_one_eye.iter().find(|(given, _)| *given) {
            return Err(Failure::usage(format!("{name} is for one eye; leave it or --stereo out")));
        }
        if mode == StereoName::Rep && self.shading.method == MethodName::Full {
            return Err(Failure::usage(
                "--stereo rep needs a foveated method; use --stereo dup or another --method",
            ));
        }
        if mode == StereoName::Rep && self.scene == Source::Sdf {
            return Err(Failure::usage(
                "--stereo rep needs a G-buffer, which the ray-marched scene does not have; use --stereo dup",
            ));
        }
        Ok(())
    }
}

/// One eye's cost.
#[derive(Serialize)]
struct EyeReport {
    gaze_px: [f64; 2],
    passes: Vec<PassMedian>,
    gpu_ms: f64,
    samples_shaded: u64,
    lp: Option<LpStats>,
    effects: Effects,
}

/// The right eye beside the same eye rendered by itself, in the same run.
#[derive(Serialize)]
struct AgainstDup {
    dup_gpu_ms: f64,
    dup_samples_shaded: u64,
    /// Of the right eye.
    speedup: Option<Speedup>,
    /// Of both eyes together.
    speedup_of_both: Option<Speedup>,
    error: Comparison,
}

/// The result; its field names are an interface.
#[derive(Serialize)]
struct Report<'a> {
    device: &'a str,
    driver: &'a str,
    stereo: StereoName,
    method: &'static str,
    /// Of one eye.
    size: [u32; 2],
    ipd_mm: f64,
    fixation_m: Option<f64>,
    left: EyeReport,
    right: EyeReport,
    against_dup: Option<AgainstDup>,
    non_finite: Option<u64>,
    holes: Option<u64>,
    validation_messages: Option<u64>,
    validation: &'static str,
    warnings: Vec<String>,
}

type Eyes = [FrameStats; 2];

/// What was rendered.
struct Rendered {
    /// The mode that was asked for.
    frames: Vec<Eyes>,
    /// The same by dup, where that was not asked for.
    dup: Option<(Vec<Eyes>, Comparison)>,
    effects: [Effects; 2],
}

/// Runs the command.
pub(super) fn run(
    args: &RenderArgs,
    mode: StereoName,
    settings: RenderSettings,
    json: bool,
) -> Result<(), Failure> {
    let ipd_mm = args.display.preset.map_or(IPD_MM, |preset| preset.ipd_mm);
    let dup = StereoSettings::mirrored(settings, ipd_mm * 1e-3, StereoMode::Dup);
    dup.check()?;
    let modes = if mode == StereoName::Rep { 2 } else { 1 };
    let mut steps = Steps::short(4 + modes * u64::from(args.frames));
    steps.next("loading");
    let Loaded { subject, environment, warnings } = args.load()?;
    let left_px = gaze_px(args.gaze, dup.left.display.size_px);
    let input = StereoInput {
        world_from_head: args.camera.world_from_view(&subject, &dup.left.display)?,
        gaze: StereoGaze::of_left(&dup, left_px, args.stereo.fixation_m),
    };
    steps.next("preparing");
    let device = library::device(args.no_validation)?;
    let content = GpuContent::upload(&device, &subject.content(environment.as_ref()))?;
    let rendered = match mode {
        StereoName::Dup => render_dup(args, &device, &content, &dup, &input, &mut steps)?,
        StereoName::Rep => render_rep(args, &device, &content, &dup, &input, &mut steps)?,
    };
    drop(steps);
    let mut report = report(args, mode, &device, &rendered, warnings);
    report.ipd_mm = ipd_mm;
    let eyes = input.eyes(&dup);
    report.left.gaze_px = eyes[0].gaze_px.to_array();
    report.right.gaze_px = eyes[1].gaze_px.to_array();
    if json { output::print_json(&report) } else { print_text(args, &report) }
}

fn render_dup(
    args: &RenderArgs,
    device: &HeadlessDevice,
    content: &GpuContent,
    settings: &StereoSettings,
    input: &StereoInput,
    steps: &mut Steps,
) -> Result<Rendered, Failure> {
    let mut renderer = OffscreenStereo::new(device, content, settings)?;
    steps.next("warming up");
    renderer.render(input)?;
    let mut frames = Vec::new();
    for _ in 0..args.frames {
        steps.next("rendering");
        frames.push(renderer.render(input)?);
    }
    steps.next("writing");
    write_picture(args, settings, &mut renderer)?;
    let effects = renderer.effects().map(Clone::clone);
    if args.plan {
        output::note(renderer.plan_text().trim_end());
    }
    Ok(Rendered { frames, dup: None, effects })
}

/// Renders in both modes alternately, and compares the right eyes.
fn render_rep(
    args: &RenderArgs,
    device: &HeadlessDevice,
    content: &GpuContent,
    dup_settings: &StereoSettings,
    input: &StereoInput,
    steps: &mut Steps,
) -> Result<Rendered, Failure> {
    let settings = StereoSettings { mode: StereoMode::Rep, ..dup_settings.clone() };
    let mut dup = OffscreenStereo::new(device, content, dup_settings)?;
    let mut rep = OffscreenStereo::new(device, content, &settings)?;
    steps.next("warming up");
    dup.render(input)?;
    rep.render(input)?;
    let measure = |second| {
        steps.next("rendering");
        if second { rep.render(input) } else { dup.render(input) }
    };
    let Pairs { first, second } = measure_pairs(PairCount::Fixed(args.frames), measure, |_| ())?;
    steps.next("writing");
    write_picture(args, &settings, &mut rep)?;
    let ([_, expected], [_, found]) = (dup.read_rgba8()?, rep.read_rgba8()?);
    let display = &settings.right.display;
    let [_, right] = input.eyes(&settings);
    let error =
        library::compare_pictures(&expected, &found, display.size_px, Some((display, right.gaze_px)))?;
    let effects = rep.effects().map(Clone::clone);
    if args.plan {
        output::note(rep.plan_text().trim_end());
    }
    Ok(Rendered { frames: second, dup: Some((first, error)), effects })
}

/// Rows of two pictures of one height beside each other. `row`: values of a row of one of them.
fn beside<T: Copy>([left, right]: &[Vec<T>; 2], row: usize) -> Vec<T> {
    left.chunks_exact(row)
        .zip(right.chunks_exact(row))
        .flat_map(|(l, r)| l.iter().chain(r))
        .copied()
        .collect()
}

fn write_picture(
    args: &RenderArgs,
    settings: &StereoSettings,
    renderer: &mut OffscreenStereo,
) -> Result<(), Failure> {
    let [width, height] = settings.left.display.size_px;
    let (size, row) = ([2 * width, height], 4 * width as usize);
    if is_exr(&args.output)? {
        library::write_exr(&args.output, size, &beside(&renderer.read_hdr()?, row))
    } else {
        library::write_png(&args.output, size, &beside(&renderer.read_rgba8()?, row))
    }
}

fn of_eye(frames: &[Eyes], eye: usize) -> Vec<FrameStats> {
    frames.iter().map(|frame| frame[eye].clone()).collect()
}

fn eye_report(rendered: &Rendered, eye: usize) -> EyeReport {
    let frames = of_eye(&rendered.frames, eye);
    let last = frames.last().cloned().unwrap_or_default();
    EyeReport {
        gaze_px: [0.0; 2],
        passes: pass_medians(&frames),
        gpu_ms: median(&gpu_times(&frames)).unwrap_or(last.gpu_ms),
        samples_shaded: last.samples_shaded,
        lp: last.lp,
        effects: rendered.effects[eye].clone(),
    }
}

fn against_dup(rendered: &Rendered) -> Option<AgainstDup> {
    let (dup, error) = rendered.dup.as_ref()?;
    let of_both = |frames: &[Eyes]| frames.iter().map(|[l, r]| l.gpu_ms + r.gpu_ms).collect::<Vec<_>>();
    let (right, found) = (of_eye(dup, 1), of_eye(&rendered.frames, 1));
    Some(AgainstDup {
        dup_gpu_ms: median(&gpu_times(&right)).unwrap_or_default(),
        dup_samples_shaded: right.last().map_or(0, |frame| frame.samples_shaded),
        speedup: speedup(&gpu_times(&right), &gpu_times(&found)),
        speedup_of_both: speedup(&of_both(dup), &of_both(&rendered.frames)),
        error: error.clone(),
    })
}

fn report<'a>(
    args: &RenderArgs,
    mode: StereoName,
    device: &'a HeadlessDevice,
    rendered: &Rendered,
    mut warnings: Vec<String>,
) -> Report<'a> {
    let all = || rendered.frames.iter().flatten();
    let non_finite = all().filter_map(|frame| frame.non_finite).max();
    let holes = all().filter_map(|frame| frame.holes).max();
    let validation_messages = device.validation_messages();
    warnings.extend(findings(non_finite, holes, validation_messages));
    if rendered.frames.last().is_some_and(|eyes| eyes.iter().any(|eye| eye.gaze_held)) {
        warnings.push("an eye's gaze does not meet its display; the display's centre was taken".into());
    }
    Report {
        device: device.name(),
        driver: device.driver(),
        stereo: mode,
        method: args.shading.name(),
        size: args.display.size_px(),
        ipd_mm: IPD_MM,
        fixation_m: args.stereo.fixation_m,
        left: eye_report(rendered, 0),
        right: eye_report(rendered, 1),
        against_dup: against_dup(rendered),
        non_finite,
        holes,
        validation_messages,
        validation: validation_state(args, device),
        warnings,
    }
}

fn print_text(args: &RenderArgs, report: &Report<'_>) -> Result<(), Failure> {
    for warning in &report.warnings {
        output::note(&format!("warning: {warning}"));
    }
    let mut text = format!("{} on {} ({})\n\n", args.output.display(), report.device, report.driver);
    let time_of = |eye: &EyeReport, name: &str| {
        let pass = eye.passes.iter().find(|pass| pass.name == name);
        pass.map_or_else(|| "-".into(), |pass| format!("{:.3}", pass.gpu_ms))
    };
    let (left, right) = (&report.left, &report.right);
    let mut names = left.passes.iter().map(|pass| pass.name).collect::<Vec<_>>();
    names.extend(right.passes.iter().map(|pass| pass.name).filter(|name| time_of(left, name) == "-"));
    let mut rows = names
        .iter()
        .map(|name| vec![(*name).to_owned(), time_of(left, name), time_of(right, name)])
        .collect::<Vec<_>>();
    rows.push(vec!["eye".into(), format!("{:.3}", left.gpu_ms), format!("{:.3}", right.gpu_ms)]);
    text += &output::table(&["pass", "left GPU ms", "right GPU ms"], &rows);
    text += "\n";
    for (name, eye) in [("left eye", left), ("right eye", right)] {
        let reused = eye.lp.map_or(0, |lp| lp.reused);
        text += &format!(
            "{name:<10} {} samples, {} taken from the left eye; gaze at {:.1}, {:.1} px\n",
            output::grouped(eye.samples_shaded),
            output::grouped(reused),
            eye.gaze_px[0],
            eye.gaze_px[1]
        );
    }
    text += &report.against_dup.as_ref().map(dup_text).unwrap_or_default();
    let count = |count: Option<u64>| count.map_or("not checked".into(), |count| count.to_string());
    text += &format!("not finite {}, holes {}\n", count(report.non_finite), count(report.holes));
    text += &format!("validation {}, messages: {}\n", report.validation, count(report.validation_messages));
    output::print(&text)
}

fn dup_text(of: &AgainstDup) -> String {
    let ratio = |of: Option<Speedup>| {
        of.map_or_else(String::new, |of| format!("{:.2}x ({:.2} to {:.2})", of.median, of.least, of.greatest))
    };
    let mut text = format!(
        "by dup     {:.3} ms and {} samples for the right eye; rep is {} as fast, both eyes {}\n\n",
        of.dup_gpu_ms,
        output::grouped(of.dup_samples_shaded),
        ratio(of.speedup),
        ratio(of.speedup_of_both)
    );
    let number = |value: Option<f64>, digits: usize| {
        value.map_or_else(|| "-".into(), |value| format!("{value:.digits$}"))
    };
    let mut rows =
        vec![vec!["whole".into(), number(Some(of.error.psnr_db), 2), number(Some(of.error.flip), 4)]];
    rows.extend(of.error.rings.iter().filter(|ring| ring.pixels > 0).map(|ring| {
        let name = if ring.to_deg.is_finite() {
            format!("{} to {} deg", ring.from_deg, ring.to_deg)
        } else {
            format!("from {} deg", ring.from_deg)
        };
        vec![name, number(ring.psnr_db, 2), number(ring.flip, 4)]
    }));
    text += &output::table(&["right eye against dup", "PSNR dB", "FLIP"], &rows);
    text + "\n"
}
