//! What the GPU says of a method: where it maps points, and how much it shades.

use super::count::Forward;
use super::totals::FrameSamples;
use crate::failure::Failure;
use crate::library;
use glam::DMat4;
use macula::fovea::Mapping;
use macula::headless::{Content, FrameInput, GpuContent, GpuMapping, HeadlessDevice, OffscreenRenderer};
use macula::settings::{Method, RenderSettings};

/// A device with something to look at.
pub struct Gpu {
    device: HeadlessDevice,
    content: GpuContent,
}

impl Gpu {
    /// The engine's device.
    ///
    /// # Errors
    /// What the device reports.
    pub fn new() -> Result<Self, Failure> {
        let device = library::device(true)?;
        // What is shaded does not depend on the scene; this one needs no files.
        let content = GpuContent::upload(&device, &Content::SdfPrimitives)?;
        Ok(Self { device, content })
    }

    /// Maps points by the functions that the passes use, in single precision; `None` for full shading.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn forward<'a>(
        &self,
        mapping: &'a dyn Mapping,
        method: &Method,
    ) -> Result<Option<Box<Forward<'a>>>, Failure> {
        if *method == Method::Full {
            return Ok(None);
        }
        let settings = RenderSettings::new(*mapping.display(), method.clone());
        let mut on_gpu = GpuMapping::new(&self.device, &settings)?;
        Ok(Some(Box::new(move |points| {
            let mapped = on_gpu.forward(mapping.gaze_px(), points)?;
            Ok(mapped.into_iter().map(|mapped| Some(mapped.point)).collect())
        })))
    }

    /// Renders a frame and counts what it shaded.
    ///
    /// # Errors
    /// A display larger than the device's images, and what the device reports.
    pub fn frame(&self, mapping: &dyn Mapping, method: &Method) -> Result<FrameSamples, Failure> {
        let settings = RenderSettings::new(*mapping.display(), method.clone());
        let mut renderer = OffscreenRenderer::new(&self.device, &self.content, &settings)?;
        let input = FrameInput { world_from_view: DMat4::IDENTITY, gaze_px: mapping.gaze_px() };
        let stats = renderer.render(&input)?;
        Ok(FrameSamples::new(stats.samples_shaded, stats.lp.as_ref()))
    }
}
