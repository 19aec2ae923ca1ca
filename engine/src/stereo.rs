//! Both eyes of a headset in one frame.
//!
//! [`StereoMode::Dup`] renders each eye for itself. [`StereoMode::Rep`] renders the left eye and takes from
//! it what the right eye sees too and what looks the same from both eyes; only the rest is shaded (VaFR,
//! 2025, stereo). Both G-buffers are rasterised, so that visibility is exact in both modes.

use crate::content::GpuContent;
use crate::error::{Error, Result};
use crate::fovea::DisplayGeometry;
use crate::gpu::Context;
use crate::gpu::submit;
use crate::host::TargetImage;
use crate::renderer::{FrameInput, FrameSlot, Renderer, Role};
use crate::settings::RenderSettings;
use crate::stats::{Effects, FrameStats};
use ash::vk;
use glam::{DMat4, DVec2, DVec3};
use std::sync::Arc;

/// How the right eye comes about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StereoMode {
    /// Each eye by itself: the reference.
    #[default]
    Dup,
    /// The right eye takes from the left one what it can. Needs a foveated method and a scene of
    /// triangles: the ray-marched scene has no G-buffer to look surfaces up in.
    Rep,
}

/// What the right eye may take from the left one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReuseSettings {
    /// Least perceptual roughness, 0..=1; smoother surfaces are shaded for each eye. At 0.6 the highlight
    /// of a white dielectric adds at most a twelfth to its diffuse light, and over the 3.7 degrees between
    /// the eyes at 1 m changes by about a tenth of itself: less than a hundredth together. Lower: more is
    /// reused, and highlights stick to surfaces.
    pub least_roughness: f32,
    /// Greatest share of metal, 0..=1, whose reflection is as strong as its colour. At 0.05 it at most
    /// doubles the dielectric's. Higher: as with a lower roughness.
    pub greatest_metallic: f32,
    /// Relative difference of depths, above 0 and at most 0.1, up to which both eyes see one surface. What
    /// lies nearer than a surface by the share 0.001 hides less of it than 0.001 of the eyes' distance
    /// over its own: at 0.3 m 0.2 mrad, a quarter of a pixel at 20 pixels per degree. Higher: thin things
    /// leave ghosts on what is behind them. Below 1e-6 the depths' own rounding stops the reuse.
    pub depth_tolerance: f32,
    /// Least cosine of the angle between the normals that both eyes see, -1..=1. 0.98 is 11 degrees, more
    /// than a normal map's filtering differs between the eyes. Higher: more is shaded; lower: light leaks
    /// over creases that are too shallow for the depths to tell.
    pub least_normal_cosine: f32,
}

impl Default for ReuseSettings {
    fn default() -> Self {
        Self {
            least_roughness: 0.6,
            greatest_metallic: 0.05,
            depth_tolerance: 1e-3,
            least_normal_cosine: 0.98,
        }
    }
}

/// Everything that decides what is built for two eyes.
#[derive(Clone, Debug, PartialEq)]
pub struct StereoSettings {
    /// The left eye's.
    pub left: RenderSettings,
    /// The right eye's.
    pub right: RenderSettings,
    /// Distance between the eyes, m, 0 to 0.2; people have 0.054 to 0.074.
    pub ipd_m: f64,
    /// How the right eye comes about.
    pub mode: StereoMode,
    /// For [`StereoMode::Rep`].
    pub reuse: ReuseSettings,
}

impl StereoSettings {
    /// The right eye's settings are the left's, its display the mirror image.
    #[must_use]
    pub fn mirrored(left: RenderSettings, ipd_m: f64, mode: StereoMode) -> Self {
        let display = mirrored(&left.display);
        let right = RenderSettings { display, ..left.clone() };
        Self { left, right, ipd_m, mode, reuse: ReuseSettings::default() }
    }

    /// Checks what does not depend on a device.
    ///
    /// # Errors
    /// [`Error::Setting`]: a value out of range, or eyes between which nothing can be reused.
    pub fn check(&self) -> Result<()> {
        self.left.check()?;
        self.right.check()?;
        if !(0.0..=0.2).contains(&self.ipd_m) {
            let ipd_m = self.ipd_m;
            return Err(Error::Setting(format!(
                "the distance between the eyes is {ipd_m} m; it must lie between 0 and 0.2"
            )));
        }
        match self.mode {
            StereoMode::Dup => Ok(()),
            StereoMode::Rep => self.check_reuse(),
        }
    }

    fn check_reuse(&self) -> Result<()> {
        let ReuseSettings { least_roughness, greatest_metallic, depth_tolerance, least_normal_cosine } =
            self.reuse;
        let in_range = (0.0..=1.0).contains(&least_roughness)
            && (0.0..=1.0).contains(&greatest_metallic)
            && (depth_tolerance > 0.0 && depth_tolerance <= 0.1)
            && (-1.0..=1.0).contains(&least_normal_cosine);
        if !in_range {
            return Err(Error::Setting(format!(
                "{:?} is out of range; roughness and metallic lie within 0..=1, the depth tolerance above 0 and up to 0.1, the cosine within -1..=1",
                self.reuse
            )));
        }
        if !self.left.foveated() {
            return Err(Error::Setting(
                "reprojection needs a foveated method; choose one or render both eyes (dup)".into(),
            ));
        }
        let alike = RenderSettings { display: self.left.display, ..self.right.clone() } == self.left;
        if !alike || !nearly_equal(&self.right.display, &mirrored(&self.left.display)) {
            return Err(Error::Setting(
                "reprojection needs equal settings and mirrored displays for both eyes; render both eyes (dup)"
                    .into(),
            ));
        }
        Ok(())
    }
}

/// The other eye's display.
fn mirrored(display: &DisplayGeometry) -> DisplayGeometry {
    DisplayGeometry { tan_left: -display.tan_right, tan_right: -display.tan_left, ..*display }
}

fn nearly_equal(a: &DisplayGeometry, b: &DisplayGeometry) -> bool {
    let edges = |of: &DisplayGeometry| [of.tan_left, of.tan_right, of.tan_up, of.tan_down];
    // A thousandth of a pixel on a display of 10 000.
    let near = |(a, b): (f64, f64)| (a - b).abs() < 1e-7;
    a.size_px == b.size_px && edges(a).into_iter().zip(edges(b)).all(near)
}

/// Where both eyes look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StereoGaze {
    /// In parallel along a direction of the head's space, of any length.
    Direction(DVec3),
    /// At a point of the head's space, m.
    Point(DVec3),
}

impl StereoGaze {
    /// From the left eye's gaze pixel: in parallel, or at the point so far along that ray, m.
    #[must_use]
    pub fn of_left(settings: &StereoSettings, gaze_px: DVec2, fixation_m: Option<f64>) -> Self {
        let ray = settings.left.display.ray_of_px(gaze_px);
        match fixation_m {
            None => Self::Direction(ray),
            Some(distance_m) => Self::Point(eye_in_head(settings.ipd_m, 0) + ray.normalize() * distance_m),
        }
    }
}

/// What changes from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StereoInput {
    /// The point between the eyes: right-handed, `-Z` forward, `+X` to the right, no scale.
    pub world_from_head: DMat4,
    /// Where both eyes look. What has no point on an eye's display plane becomes a NaN gaze for that
    /// eye, for which its last valid one is held.
    pub gaze: StereoGaze,
}

/// The left (0) or right (1) eye's place in the head's space, m.
fn eye_in_head(ipd_m: f64, eye: usize) -> DVec3 {
    DVec3::new(if eye == 0 { -0.5 } else { 0.5 } * ipd_m, 0.0, 0.0)
}

impl StereoInput {
    /// The frames of the left and the right eye.
    #[must_use]
    pub fn eyes(&self, settings: &StereoSettings) -> [FrameInput; 2] {
        [(0, &settings.left), (1, &settings.right)].map(|(eye, of)| {
            let place = eye_in_head(settings.ipd_m, eye);
            let ray = match self.gaze {
                StereoGaze::Direction(direction) => direction,
                StereoGaze::Point(point) => point - place,
            };
            FrameInput {
                world_from_view: self.world_from_head * DMat4::from_translation(place),
                gaze_px: of.display.px_of_ray(ray).unwrap_or(DVec2::NAN),
            }
        })
    }
}

/// A recorded frame of both eyes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StereoSlot([FrameSlot; 2]);

/// Records both eyes of one content into one command buffer.
pub struct StereoRenderer {
    // Before the left eye: its passes read what that owns.
    right: Renderer,
    left: Renderer,
    settings: StereoSettings,
    context: Arc<Context>,
}

impl StereoRenderer {
    /// Builds everything for targets of `format`; both eyes share the content.
    ///
    /// # Errors
    /// [`Error::Setting`]: see [`StereoSettings::check`], and reprojection in the ray-marched scene;
    /// [`Error::Memory`], [`Error::Vulkan`], [`Error::DeviceLost`].
    pub fn new(
        context: &Arc<Context>,
        content: &GpuContent,
        settings: &StereoSettings,
        format: vk::Format,
    ) -> Result<Self> {
        settings.check()?;
        let make = |of: &RenderSettings, role| Renderer::for_eye(context, content, of, format, &role);
        let (left, right) = match settings.mode {
            StereoMode::Dup => (make(&settings.left, Role::Alone)?, make(&settings.right, Role::Alone)?),
            StereoMode::Rep => {
                if matches!(content, GpuContent::SdfPrimitives) {
                    return Err(Error::Setting(
                        "reprojection needs a G-buffer, which the ray-marched scene does not have; render both eyes (dup)"
                            .into(),
                    ));
                }
                let left = make(&settings.left, Role::Left)?;
                let right = make(&settings.right, Role::Right(&left, settings.reuse))?;
                (left, right)
            }
        };
        Ok(Self { right, left, settings: settings.clone(), context: context.clone() })
    }

    /// Records a frame of both eyes, the left one first. Allocates nothing and makes no Vulkan object.
    /// For submission and slots see [`Renderer::record_frame`].
    pub fn record_frame(
        &mut self,
        commands: vk::CommandBuffer,
        input: &StereoInput,
        [left_target, right_target]: &[TargetImage; 2],
    ) -> StereoSlot {
        let [left, right] = input.eyes(&self.settings);
        // The right eye reads what the left one has written; the left one writes what the right one has
        // read in the frame before. The eyes' own graphs know nothing of each other.
        submit::full_barrier(&self.context, commands);
        let left_slot = self.left.record_frame(commands, &left, left_target);
        submit::full_barrier(&self.context, commands);
        self.right.set_left_eye(left.world_from_view.w_axis.truncate());
        let right_slot = self.right.record_frame(commands, &right, right_target);
        StereoSlot([left_slot, right_slot])
    }

    /// Replaces the gaze of a frame that is recorded and not yet submitted; see [`Renderer::late_latch`].
    pub fn late_latch(&mut self, frame: StereoSlot, gaze: StereoGaze) {
        let [left, right] = StereoInput { world_from_head: DMat4::IDENTITY, gaze }.eyes(&self.settings);
        self.left.late_latch(frame.0[0], left.gaze_px);
        self.right.late_latch(frame.0[1], right.gaze_px);
    }

    /// Figures of both eyes of a frame that the GPU has finished.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn read_stats(&mut self, frame: StereoSlot) -> Result<[FrameStats; 2]> {
        Ok([self.left.read_stats(frame.0[0])?, self.right.read_stats(frame.0[1])?])
    }

    /// What the effect plan decided for both eyes.
    #[must_use]
    pub fn effects(&self) -> [&Effects; 2] {
        [self.left.effects(), self.right.effects()]
    }

    /// The eyes' frame graphs in words.
    #[must_use]
    pub fn plan_text(&self) -> String {
        format!("left eye\n{}\nright eye\n{}", self.left.plan_text(), self.right.plan_text())
    }

    /// The settings it was built for.
    #[must_use]
    pub fn settings(&self) -> &StereoSettings {
        &self.settings
    }

    pub(crate) fn eyes(&self) -> [&Renderer; 2] {
        [&self.left, &self.right]
    }
}
