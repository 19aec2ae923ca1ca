//! `macula replay`: a gaze session through the renderer, with the latency that it would have had.

mod frames;
mod sheet;

use crate::commands::gaze::{ReadArgs, RunArgs, eye_intervals, with_directions};
use crate::content::{CameraArgs, Source, load_environment, neutral_light, parse_source};
use crate::failure::Failure;
use crate::library;
use crate::measure::{findings, median};
use crate::options::{DisplayArgs, HallArgs};
use crate::output;
use crate::progress::Steps;
use crate::shading::{MethodName, ShadingArgs};
use clap::Args;
use frames::{Job, RenderedFrame};
use macula::headless::GpuContent;
use macula::settings::RenderSettings;
use macula_trackers::formats;
use macula_trackers::latency::{Figures, Frame, LatencyModel, SessionGaze, preset};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Render a recorded gaze session with the gaze that a renderer of some latency would have had
///
/// The session runs through a latency model, refresh by refresh of its display. The chosen frames are
/// rendered for the gaze that was known when each was made. The ledger holds every refresh: which
/// sample was used, how old it was when the light left, and how far off. Frames without any known gaze
/// are shaded in full.
///
/// On the contact sheet a red cross marks the gaze that was used and a white ring where the eye looked;
/// the border is green where that was within the radius of full quality, orange where it was not, and
/// grey where it does not count (a saccade, a blink).
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    macula replay hall --gaze-file session.csv --latency vive-pro-eye --sheet sheet.png\n  \
    macula replay scene.glb --gaze-file eye_recording-eye3_physio.tsv.gz --latency varjo-aero \
    --predictor landing --from 2 --every 1 --frames 90 -o frames --ledger frames.csv --json")]
pub struct ReplayArgs {
    /// A .gltf or .glb file, `hall` (generated) or `sdf:primitives` (ray-marched)
    #[arg(value_name = "SCENE", value_parser = parse_source)]
    scene: Source,
    /// The recorded session: any known format
    #[arg(long, value_name = "FILE", help_heading = "Session")]
    gaze_file: PathBuf,
    #[command(flatten, next_help_heading = "Session")]
    read: ReadArgs,
    /// Latency model: the name of a preset or a .toml file; `macula gaze latency --list-presets` lists
    /// the presets
    #[arg(long, value_name = "PRESET|FILE.toml", default_value = "generic-90hz", help_heading = "Latency")]
    latency: String,
    #[command(flatten, next_help_heading = "Latency")]
    run: RunArgs,
    /// Folder for the frames, made if it is missing: a .png for each, named by its refresh
    #[arg(short, long, value_name = "FOLDER", help_heading = "Output")]
    output: Option<PathBuf>,
    /// Contact sheet of the frames: a .png file
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    sheet: Option<PathBuf>,
    /// Ledger of every refresh of the session: a .csv file
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    ledger: Option<PathBuf>,
    /// Frames to render, 1 to 100000
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=100_000), help_heading = "Frames")]
    frames: u32,
    /// Seconds of the session before the first frame
    #[arg(long, value_name = "S", default_value_t = 0.0, help_heading = "Frames")]
    from: f64,
    /// Render every N-th refresh [default: the frames spread over the session]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Frames")]
    every: Option<u32>,
    /// Turn the view with the recorded head, where the session has one
    #[arg(long, help_heading = "Frames")]
    head: bool,
    #[command(flatten)]
    display: DisplayArgs,
    #[command(flatten)]
    shading: ShadingArgs,
    #[command(flatten, next_help_heading = "Scene and camera")]
    camera: CameraArgs,
    /// Environment map: an equirectangular .exr or .hdr file, for sky and ambient light
    #[arg(long, value_name = "FILE", help_heading = "Scene and camera")]
    env: Option<PathBuf>,
    #[command(flatten, next_help_heading = "Scene and camera")]
    hall: HallArgs,
    /// Do not use the Vulkan validation layer, which is on where it is installed
    #[arg(long)]
    no_validation: bool,
}

/// The result; its field names are an interface.
#[derive(Serialize)]
struct Report<'a> {
    device: &'a str,
    driver: &'a str,
    size: [u32; 2],
    method: &'static str,
    model: &'a str,
    /// Where the renderer takes the gaze to be.
    answer: String,
    /// Of the whole session, as are the next two.
    refreshes: usize,
    age_ms: Figures,
    error_deg: Figures,
    outside_fraction: Option<f64>,
    /// Rendered without any known gaze, so in full.
    without_gaze: usize,
    /// Median over the frames, ms.
    gpu_ms: Option<f64>,
    /// Median over the frames, ms: so much younger is a gaze that is latched when the frame is
    /// submitted instead of when its recording begins.
    latch_gain_ms: Option<f64>,
    non_finite: u64,
    holes: u64,
    validation_messages: Option<u64>,
    frames: Vec<RenderedFrame>,
    warnings: Vec<String>,
}

/// Runs the command.
///
/// # Errors
/// Everything that can go wrong between the command line and the last frame's file.
pub fn run(args: &ReplayArgs, json: bool) -> Result<(), Failure> {
    let settings = args.settings()?;
    let model = args.model()?;
    let recording = with_directions(formats::read(&args.gaze_file, &args.read.options())?)?;
    if args.head && recording.samples().all(|sample| sample.head.is_none()) {
        return Err(Failure::usage(format!(
            "{} holds no head pose; leave --head out",
            args.gaze_file.display()
        )));
    }
    let session = SessionGaze::new(&recording)?.with_intervals(&eye_intervals(&recording).0);
    let run = args.run.through(&model, &session, args.run.answer(&recording).as_mut())?;
    let chosen = args.chosen(&run.frames)?;
    if let Some(folder) = &args.output {
        std::fs::create_dir_all(folder).map_err(|error| Failure::from(macula::Error::io(folder, error)))?;
    }
    if let Some(path) = &args.ledger {
        library::write_with(path, |file| run.ledger(&session).write_frames_csv(file))?;
    }
    let mut warnings = Vec::new();
    let subject = args.scene.open(&args.hall, 0.0)?;
    warnings.extend(subject.scene().map(|scene| scene.warnings.clone()).unwrap_or_default());
    let environment = match &args.env {
        Some(path) => Some(load_environment(path, &mut warnings)?),
        None => neutral_light(&subject, &mut warnings),
    };
    let mut steps = Steps::long(1.0 + chosen.len() as f64);
    steps.next("preparing");
    let device = library::device(args.no_validation)?;
    let content = GpuContent::upload(&device, &subject.content(environment.as_ref()))?;
    let job = Job {
        device: &device,
        content: &content,
        settings: &settings,
        world_from_view: args.camera.world_from_view(&subject, &settings.display)?,
        head: args.head.then_some(&recording),
        folder: args.output.as_deref(),
        tiles: args.sheet.is_some(),
    };
    let (frames, tiles) = frames::render(&job, &chosen, &mut steps)?;
    drop(steps);
    if let (Some(path), Some((size, pixels))) = (&args.sheet, sheet::sheet(&tiles)) {
        library::write_png(path, size, &pixels)?;
    }
    let non_finite = frames.iter().map(|frame| frame.non_finite).sum();
    let holes = frames.iter().map(|frame| frame.holes).sum();
    warnings.extend(findings(Some(non_finite), Some(holes), device.validation_messages()));
    let of = |value: fn(&RenderedFrame) -> Option<f64>| {
        median(&frames.iter().filter_map(value).collect::<Vec<_>>())
    };
    let report = Report {
        device: device.name(),
        driver: device.driver(),
        size: settings.display.size_px,
        method: args.shading.name(),
        model: &run.model.name,
        answer: args.run.answer_words(),
        refreshes: run.frames.len(),
        age_ms: run.age_ms(),
        error_deg: run.error_deg(),
        outside_fraction: run.outside_fraction(),
        without_gaze: frames.iter().filter(|frame| frame.gaze.is_none()).count(),
        gpu_ms: of(|frame| Some(frame.gpu_ms)),
        latch_gain_ms: of(|frame| frame.latch_gain_ms),
        non_finite,
        holes,
        validation_messages: device.validation_messages(),
        frames,
        warnings,
    };
    if json { output::print_json(&report) } else { print_text(args, &report) }
}

impl ReplayArgs {
    fn settings(&self) -> Result<RenderSettings, Failure> {
        if self.output.is_none() && self.sheet.is_none() && self.ledger.is_none() {
            return Err(Failure::usage("nothing would be written; give --output, --sheet or --ledger"));
        }
        if let Some(sheet) = &self.sheet {
            if self.frames as usize > sheet::MOST_TILES {
                return Err(Failure::usage(format!(
                    "a contact sheet holds at most {} frames; lower --frames or leave --sheet out",
                    sheet::MOST_TILES
                )));
            }
            if sheet.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("png")) {
                return Err(Failure::usage(format!("{}: the sheet is a .png; name it so", sheet.display())));
            }
        }
        if !(self.from >= 0.0 && self.from.is_finite()) {
            return Err(Failure::usage(format!("--from is {}; give seconds, 0 or more", self.from)));
        }
        let display = self.display.geometry();
        display.check()?;
        let mut settings = self.shading.settings(display)?;
        settings.check_finite = true;
        settings.check()?;
        Ok(settings)
    }

    fn model(&self) -> Result<LatencyModel, Failure> {
        let path = Path::new(&self.latency);
        let is_file = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
        self.run.changed(if is_file { LatencyModel::open(path)? } else { preset(&self.latency)? })
    }

    /// The frames to render.
    fn chosen<'a>(&self, frames: &'a [Frame]) -> Result<Vec<&'a Frame>, Failure> {
        let first_ns = frames.first().map_or(0, |frame| frame.display_ns);
        let begins = |frame: &Frame| frame.display_ns.saturating_sub(first_ns) as f64 * 1e-9 >= self.from;
        let left: Vec<_> = frames.iter().filter(|frame| begins(frame)).collect();
        if left.is_empty() {
            return Err(Failure::usage(format!(
                "the session has no frame after {} s; lower --from or give a longer session",
                self.from
            )));
        }
        let wanted = self.frames as usize;
        let every = self.every.map_or(left.len().div_ceil(wanted).max(1), |every| every as usize);
        Ok(left.into_iter().step_by(every).take(wanted).collect())
    }
}

fn print_text(args: &ReplayArgs, report: &Report<'_>) -> Result<(), Failure> {
    for warning in &report.warnings {
        output::note(&format!("warning: {warning}"));
    }
    let or_dash =
        |value: Option<f64>, digits: usize| value.map_or("-".to_owned(), |value| format!("{value:.digits$}"));
    let rows = report.frames.iter().map(|frame| {
        let at = frame.gaze.map_or("none".to_owned(), |[x, y]| format!("{x:.3}, {y:.3}"));
        vec![
            frame.refresh.to_string(),
            format!("{:.3}", frame.display_s),
            at,
            or_dash(frame.age_ms, 1),
            or_dash(frame.error_deg, 2),
            frame.state.to_owned(),
            match (frame.outside, frame.suppressed) {
                (true, true) => "outside, suppressed",
                (true, false) => "outside",
                (false, _) => "",
            }
            .to_owned(),
            format!("{:.1}", frame.gpu_ms),
            output::grouped(frame.samples_shaded),
        ]
    });
    let head = ["refresh", "at s", "gaze", "age ms", "error deg", "eye", "", "GPU ms", "samples"];
    let mut text = output::table(&head, &rows.collect::<Vec<_>>());
    text += &format!("\n{} on {} ({})\n", report.method, report.device, report.driver);
    text += &format!(
        "{} refreshes of {}: age {} ms, error {} deg (medians), outside {}\n",
        output::grouped(report.refreshes as u64),
        report.model,
        or_dash(Some(report.age_ms.p50), 1),
        or_dash(Some(report.error_deg.p50), 2),
        report.outside_fraction.map_or("-".to_owned(), |share| format!("{:.2} %", share * 100.0)),
    );
    text += &format!(
        "latched at submission the gaze is {} ms younger than at the start of recording\n",
        or_dash(report.latch_gain_ms, 1)
    );
    if args.shading.method == MethodName::Kfr && report.without_gaze > 0 {
        text += &format!("{} frames had no gaze and were shaded in full\n", report.without_gaze);
    }
    let files = [&args.output, &args.sheet, &args.ledger];
    for path in files.into_iter().flatten() {
        text += &format!("wrote      {}\n", path.display());
    }
    output::print(&text)
}
