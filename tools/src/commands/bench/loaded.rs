//! A scene with the view that is measured.

use super::paper::SceneKind;
use crate::content::{CameraArgs, Source, Subject, neutral_light};
use crate::failure::Failure;
use crate::options::{HallArgs, gaze_px};
use glam::DVec2;
use macula::fovea::DisplayGeometry;
use macula::headless::{FrameInput, GpuContent, HeadlessDevice};

/// A scene in GPU memory with the view that is measured.
pub struct Loaded<'a> {
    /// The device.
    pub device: &'a HeadlessDevice,
    /// In GPU memory.
    pub content: GpuContent,
    /// What was loaded.
    pub subject: Subject,
    /// As in reports.
    pub name: String,
}

impl Loaded<'_> {
    /// Loads a scene, with the generated hall's lights and triangles; adds to the warnings what was noticed.
    ///
    /// # Errors
    /// What loading reports.
    pub fn open<'a>(
        device: &'a HeadlessDevice,
        source: &Source,
        lights: u32,
        triangles: u32,
        warnings: &mut Vec<String>,
    ) -> Result<Loaded<'a>, Failure> {
        let hall = HallArgs { triangles: Some(triangles), lights: Some(lights), ..HallArgs::default() };
        let subject = source.open(&hall, 0.0)?;
        let mut noticed = subject.scene().map(|scene| scene.warnings.clone()).unwrap_or_default();
        let environment = neutral_light(&subject, &mut noticed);
        let content = GpuContent::upload(device, &subject.content(environment.as_ref()))?;
        warnings.extend(noticed.into_iter().map(|warning| format!("{}: {warning}", source.name())));
        Ok(Loaded { device, content, subject, name: source.name() })
    }

    /// Its kind in the published tables.
    pub fn kind(&self) -> SceneKind {
        match self.subject {
            Subject::Scene(_) => SceneKind::Triangles,
            Subject::Sdf => SceneKind::RayMarched,
        }
    }

    /// The scene's default view, with a gaze as fractions of the display.
    ///
    /// # Errors
    /// A scene without a usable view.
    pub fn input(&self, display: &DisplayGeometry, gaze: DVec2) -> Result<FrameInput, Failure> {
        let world_from_view = CameraArgs::default().world_from_view(&self.subject, display)?;
        Ok(FrameInput { world_from_view, gaze_px: gaze_px(gaze, display.size_px) })
    }
}
