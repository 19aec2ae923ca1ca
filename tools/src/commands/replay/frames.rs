//! Renders the chosen frames, each with the gaze that the renderer would have had.

use super::sheet::{Tile, Verdict};
use crate::failure::Failure;
use crate::library;
use crate::progress::Steps;
use glam::{DMat4, DVec2};
use macula::fovea::DisplayGeometry;
use macula::headless::{FrameInput, GpuContent, HeadlessDevice, OffscreenRenderer};
use macula::settings::{Method, RenderSettings};
use macula::stats::FrameStats;
use macula_trackers::latency::Frame;
use macula_trackers::recording::Recording;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A rendered frame; its field names are an interface.
#[derive(Debug, Serialize)]
pub struct RenderedFrame {
    /// Refreshes of the display since the session began.
    pub refresh: u64,
    /// When it was displayed, s since the session's first frame.
    pub display_s: f64,
    /// The gaze used, as fractions of the display; `null`: none was known, so every pixel was shaded.
    pub gaze: Option<[f64; 2]>,
    /// Where the eye looked, as fractions of the display.
    pub true_gaze: Option<[f64; 2]>,
    /// How old the gaze was, ms.
    pub age_ms: Option<f64>,
    /// How far off it was, degrees.
    pub error_deg: Option<f64>,
    /// What the eye did.
    pub state: &'static str,
    /// Vision is dulled by a saccade.
    pub suppressed: bool,
    /// The true gaze lay outside the radius of full quality.
    pub outside: bool,
    /// GPU time, ms.
    pub gpu_ms: f64,
    /// What recording the frame took on the CPU, ms.
    pub cpu_ms: f64,
    /// From before the frame was recorded to just before it was submitted, ms: so much younger is a gaze
    /// that is latched late. Without the time that reading pictures back takes.
    pub latch_gain_ms: Option<f64>,
    /// Samples shaded.
    pub samples_shaded: u64,
    /// NaN and infinite values found.
    pub non_finite: u64,
    /// Pixels that no sample reached.
    pub holes: u64,
    /// The picture's file.
    pub file: Option<PathBuf>,
}

/// What the frames are rendered with.
pub struct Job<'a> {
    pub device: &'a HeadlessDevice,
    pub content: &'a GpuContent,
    pub settings: &'a RenderSettings,
    /// Where the head is when the session begins.
    pub world_from_view: DMat4,
    /// The session, where its head turns the view.
    pub head: Option<&'a Recording>,
    /// Where frames go, if they are written.
    pub folder: Option<&'a Path>,
    /// Whether tiles for the contact sheet are made.
    pub tiles: bool,
}

/// A frame that is recorded or rendered and not yet read back.
struct Pending<'a> {
    frame: &'a Frame,
    gaze_px: Option<DVec2>,
    cpu_ms: f64,
    latch_gain_ms: Option<f64>,
}

/// Frames as they are finished.
struct Finished<'a> {
    job: &'a Job<'a>,
    start_ns: i64,
    frames: Vec<RenderedFrame>,
    tiles: Vec<Tile>,
}

/// Renders `frames`. While one is rendered the next is recorded, for the gaze known then; just before it
/// is submitted its own gaze is latched. A frame without any gaze is shaded in full.
///
/// # Errors
/// Those of rendering and writing.
pub fn render(
    job: &Job<'_>,
    frames: &[&Frame],
    steps: &mut Steps,
) -> Result<(Vec<RenderedFrame>, Vec<Tile>), Failure> {
    let mut foveated = OffscreenRenderer::new(job.device, job.content, job.settings)?;
    let mut full = None;
    let start_ns = frames.first().map_or(0, |frame| frame.display_ns);
    let mut finished = Finished { job, start_ns, frames: Vec::new(), tiles: Vec::new() };
    let mut known_px = job.settings.display.center_px();
    // The first frame's time holds what the driver compiles when it first runs a pass.
    foveated.render(&FrameInput { world_from_view: job.world_from_view, gaze_px: known_px })?;
    let mut on_its_way = None;
    for frame in frames {
        steps.next("rendering");
        let world_from_view = job.world_from_view * turned(job, frame);
        let gaze_px = frame.direction.and_then(|direction| job.settings.display.px_of_ray(direction));
        let begun = Instant::now();
        let Some(gaze_px) = gaze_px else {
            finished.take(&mut foveated, on_its_way.take())?;
            let full = match &mut full {
                Some(full) => full,
                none => none.insert(full_renderer(job)?),
            };
            let stats = full.render(&FrameInput { world_from_view, gaze_px: known_px })?;
            let cpu_ms = (milliseconds(begun.elapsed()) - stats.gpu_ms).max(0.0);
            let pending = Pending { frame, gaze_px: None, cpu_ms, latch_gain_ms: None };
            finished.push(full, &pending, &stats)?;
            continue;
        };
        let slot = foveated.record(&FrameInput { world_from_view, gaze_px: known_px })?;
        let recorded = begun.elapsed();
        foveated.wait()?;
        let waited = begun.elapsed();
        finished.take(&mut foveated, on_its_way.take())?;
        let latch = Instant::now();
        foveated.late_latch(slot, gaze_px);
        known_px = gaze_px;
        foveated.launch()?;
        let pending = Pending {
            frame,
            gaze_px: Some(gaze_px),
            cpu_ms: milliseconds(recorded),
            latch_gain_ms: Some(milliseconds(waited + latch.elapsed())),
        };
        on_its_way = Some((slot, pending));
    }
    foveated.wait()?;
    finished.take(&mut foveated, on_its_way)?;
    Ok((finished.frames, finished.tiles))
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// Shades every pixel: what is left to do where the gaze is not known.
fn full_renderer(job: &Job<'_>) -> Result<OffscreenRenderer, Failure> {
    let settings = RenderSettings { method: Method::Full, ..job.settings.clone() };
    let mut full = OffscreenRenderer::new(job.device, job.content, &settings)?;
    let gaze_px = settings.display.center_px();
    full.render(&FrameInput { world_from_view: job.world_from_view, gaze_px })?;
    Ok(full)
}

/// How the head has turned since the session began, where that is asked for and known.
fn turned(job: &Job<'_>, frame: &Frame) -> DMat4 {
    let turn = || {
        let head_of = |index| job.head?.get(index)?.head;
        let first = job.head?.samples().find_map(|sample| sample.head)?;
        let now = head_of(frame.sample?)?;
        Some(DMat4::from_quat(first.world_from_view.inverse() * now.world_from_view))
    };
    turn().unwrap_or(DMat4::IDENTITY)
}

/// A direction as fractions of the display.
fn fraction(display: &DisplayGeometry, direction: Option<glam::DVec3>) -> Option<DVec2> {
    let size = DVec2::from_array(display.size_px.map(f64::from));
    direction.and_then(|direction| display.px_of_ray(direction)).map(|px| px / size)
}

impl Finished<'_> {
    /// Reads back the frame that the renderer has finished, if there is one.
    fn take(
        &mut self,
        renderer: &mut OffscreenRenderer,
        rendered: Option<(macula::renderer::FrameSlot, Pending<'_>)>,
    ) -> Result<(), Failure> {
        let Some((slot, pending)) = rendered else { return Ok(()) };
        renderer.wait()?;
        let stats = renderer.read_stats(slot)?;
        self.push(renderer, &pending, &stats)
    }

    fn push(
        &mut self,
        renderer: &mut OffscreenRenderer,
        pending: &Pending<'_>,
        stats: &FrameStats,
    ) -> Result<(), Failure> {
        let display = &self.job.settings.display;
        let frame = pending.frame;
        let used = pending.gaze_px.map(|px| px / DVec2::from_array(display.size_px.map(f64::from)));
        let truth = fraction(display, frame.truth);
        let file = self.job.folder.map(|folder| folder.join(format!("{:06}.png", frame.refresh)));
        if file.is_some() || self.job.tiles {
            let pixels = renderer.read_rgba8()?;
            if let Some(file) = &file {
                library::write_png(file, display.size_px, &pixels)?;
            }
            let verdict = match (frame.counted, frame.outside) {
                (false, _) => Verdict::NotCounted,
                (true, true) => Verdict::Outside,
                (true, false) => Verdict::Inside,
            };
            if self.job.tiles {
                self.tiles.extend(Tile::new(display.size_px, pixels, verdict, used, truth));
            }
        }
        self.frames.push(RenderedFrame {
            refresh: frame.refresh,
            display_s: (frame.display_ns - self.start_ns) as f64 * 1e-9,
            gaze: used.map(|at| at.to_array()),
            true_gaze: truth.map(|at| at.to_array()),
            age_ms: frame.age_ns.map(|age_ns| age_ns as f64 * 1e-6),
            error_deg: frame.error_deg,
            state: frame.state.name(),
            suppressed: frame.suppressed,
            outside: frame.outside,
            gpu_ms: stats.gpu_ms,
            cpu_ms: pending.cpu_ms,
            latch_gain_ms: pending.latch_gain_ms,
            samples_shaded: stats.samples_shaded,
            non_finite: stats.non_finite.unwrap_or(0),
            holes: stats.holes.unwrap_or(0),
            file,
        });
        Ok(())
    }
}
