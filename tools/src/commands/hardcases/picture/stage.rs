//! Rendering frames for cases.

use super::super::bench::Bench;
use super::super::family::Finding;
use crate::failure::Failure;
use glam::{DMat4, DVec2};
use macula::fovea::DisplayGeometry;
use macula::headless::{Content, FrameInput, GpuContent, OffscreenRenderer};
use macula::scene::Scene;
use macula::scene::environment::Environment;
use macula::settings::{Method, RenderSettings};
use macula::stats::FrameStats;

/// One rendered frame.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Width and height, px.
    pub size: [u32; 2],
    /// Figures.
    pub stats: FrameStats,
    /// Linear radiance, RGBA.
    pub hdr: Vec<f32>,
}

impl Frame {
    /// Radiance at a pixel.
    pub fn at(&self, x: u32, y: u32) -> [f64; 3] {
        let first = 4 * (y as usize * self.size[0] as usize + x as usize);
        [0, 1, 2].map(|channel| f64::from(self.hdr[first + channel]))
    }

    /// Radiance at the pixel that holds a position on the display.
    pub fn at_px(&self, px: DVec2) -> [f64; 3] {
        self.at(px.x as u32, px.y as u32)
    }

    /// Takes into account what must not be in any frame: NaN and infinities in the engine's buffers and in
    /// the picture, pixels that no sample reached. Their number is the error.
    pub fn whole(&self, finding: &mut Finding, what: &str) {
        let holes = self.stats.holes.unwrap_or(u64::MAX);
        let in_buffers = self.stats.non_finite.unwrap_or(u64::MAX);
        let in_picture = self.hdr.iter().filter(|value| !value.is_finite()).count() as u64;
        finding.non_finite = finding.non_finite.saturating_add(in_buffers.max(in_picture));
        let bad = holes as f64 + in_buffers.max(in_picture) as f64;
        finding.error(bad, || {
            format!("{what}: {in_buffers} values not finite, {holes} pixels without a sample")
        });
    }

    /// As [`Self::whole`], where the family's error is another one.
    pub fn must_be_whole(&self, finding: &mut Finding, what: &str) {
        let mut own = Finding::default();
        self.whole(&mut own, what);
        finding.non_finite = finding.non_finite.saturating_add(own.non_finite);
        finding.holds(own.worst == 0.0, || own.at);
    }

    /// How many values differ from another frame's.
    pub fn differing(&self, other: &Self) -> u64 {
        let pairs = self.hdr.iter().zip(&other.hdr);
        let differing = pairs.filter(|(a, b)| a.to_bits() != b.to_bits()).count() as u64;
        differing + self.hdr.len().abs_diff(other.hdr.len()) as u64
    }
}

/// Settings that count what is not finite.
pub fn settings(display: &DisplayGeometry, method: &Method) -> RenderSettings {
    RenderSettings { check_finite: true, ..RenderSettings::new(*display, method.clone()) }
}

/// From the origin along `-Z`.
pub fn looking_ahead(gaze_px: DVec2) -> FrameInput {
    FrameInput { world_from_view: DMat4::IDENTITY, gaze_px }
}

/// A scene in GPU memory.
pub fn upload(
    bench: &Bench,
    scene: &Scene,
    environment: Option<&Environment>,
) -> Result<GpuContent, Failure> {
    Ok(GpuContent::upload(bench.device()?, &Content::Scene { scene, environment })?)
}

/// A renderer.
pub fn renderer(
    bench: &Bench,
    content: &GpuContent,
    display: &DisplayGeometry,
    method: &Method,
) -> Result<OffscreenRenderer, Failure> {
    Ok(OffscreenRenderer::new(bench.device()?, content, &settings(display, method))?)
}

/// The next frame of a renderer for a display of this size.
pub fn frame(renderer: &mut OffscreenRenderer, size: [u32; 2], input: &FrameInput) -> Result<Frame, Failure> {
    let stats = renderer.render(input)?;
    Ok(Frame { size, stats, hdr: renderer.read_hdr()? })
}

/// A single frame of a scene, from the origin along `-Z`.
pub fn picture(
    bench: &Bench,
    scene: &Scene,
    display: &DisplayGeometry,
    method: &Method,
    gaze_px: DVec2,
) -> Result<Frame, Failure> {
    let content = upload(bench, scene, None)?;
    let mut renderer = renderer(bench, &content, display, method)?;
    frame(&mut renderer, display.size_px, &looking_ahead(gaze_px))
}
