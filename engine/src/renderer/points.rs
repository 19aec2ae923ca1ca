//! Single points mapped on the GPU by the functions that the passes use: for tests, for counting rates,
//! and for whoever wants to know where a sample lies.

use super::foveation::Foveation;
use crate::error::Result;
use crate::fovea::LpPoint;
use crate::headless::HeadlessDevice;
use crate::passes::{PointMapper, Way};
use crate::settings::RenderSettings;
use glam::DVec2;

/// A method's mapping in single precision on a device.
pub struct GpuMapping {
    foveation: Foveation,
    mapper: PointMapper,
}

/// Where a display position lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MappedPoint {
    /// In the LP-buffer.
    pub point: LpPoint,
    /// How far past the native region: 0 or less where pixels are shaded themselves, 1 or more where the
    /// picture comes from the LP-buffer alone.
    pub past_native: f64,
}

impl GpuMapping {
    /// For checked settings of a foveated method.
    ///
    /// # Errors
    /// [`crate::Error::Setting`] for settings out of range, or full shading, which has no mapping;
    /// [`crate::Error::Memory`] and [`crate::Error::Vulkan`].
    pub fn new(device: &HeadlessDevice, settings: &RenderSettings) -> Result<Self> {
        settings.check()?;
        if !settings.foveated() {
            return Err(crate::Error::Setting(
                "full shading has no mapping; choose a foveated method".into(),
            ));
        }
        let foveation = Foveation::new(settings);
        let mapper = foveation.point_mapper(device.context(), &settings.method)?;
        Ok(Self { foveation, mapper })
    }

    /// Display positions, px, to the LP-buffer. Positions are rounded to single precision.
    ///
    /// # Errors
    /// [`crate::Error::DeviceLost`] and [`crate::Error::Vulkan`].
    pub fn forward(&mut self, gaze_px: DVec2, points_px: &[DVec2]) -> Result<Vec<MappedPoint>> {
        let points: Vec<_> = points_px.iter().map(|px| [px.x as f32, px.y as f32, 0.0, 0.0]).collect();
        let mapped = self.map(gaze_px, Way::ToLp, &points)?;
        let read = |row: [f32; 4]| {
            let [u, v_share, past_native, _] = row.map(f64::from);
            MappedPoint { point: LpPoint { u, v_share }, past_native }
        };
        Ok(mapped.into_iter().map(read).collect())
    }

    /// Points of the LP-buffer to display positions, px; far off the display where a direction does not
    /// meet the display's plane.
    ///
    /// # Errors
    /// As [`Self::forward`].
    pub fn inverse(&mut self, gaze_px: DVec2, points: &[LpPoint]) -> Result<Vec<DVec2>> {
        let points: Vec<_> = points.iter().map(|at| [at.u as f32, at.v_share as f32, 0.0, 0.0]).collect();
        let mapped = self.map(gaze_px, Way::ToDisplay, &points)?;
        Ok(mapped.into_iter().map(|[x, y, ..]| DVec2::new(f64::from(x), f64::from(y))).collect())
    }

    fn map(&mut self, gaze_px: DVec2, way: Way, points: &[[f32; 4]]) -> Result<Vec<[f32; 4]>> {
        if points.is_empty() {
            return Ok(Vec::new());
        }
        self.foveation.map_points(&mut self.mapper, gaze_px, way, points)
    }
}
