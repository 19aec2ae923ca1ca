//! The eye of one frame: rays and projection in space rel (world axes, origin at the eye).

use crate::content::GpuEnvironment;
use crate::fovea::DisplayGeometry;
use crate::gpu::structs::FrameParams;
use crate::plan::EffectPlan;
use crate::settings::RenderSettings;
use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};

/// Near plane, m. Depth is reversed with an infinite far plane, so a small one costs no precision.
pub const NEAR_M: f64 = 5e-4;

/// The camera of one frame, in double precision.
#[derive(Clone, Copy, Debug)]
pub struct CameraFrame {
    /// Eye, world.
    pub eye: DVec3,
    /// Rotation: rel (world axes) from view.
    pub rel_from_view: DMat3,
    /// Frustum.
    pub display: DisplayGeometry,
}

impl CameraFrame {
    /// From the display and the view's place in the world. Scale in `world_from_view` is dropped.
    #[must_use]
    pub fn new(display: &DisplayGeometry, world_from_view: &DMat4) -> Self {
        let rotation = DMat3::from_mat4(*world_from_view);
        let z = rotation.z_axis.normalize_or(DVec3::Z);
        let x = rotation.y_axis.cross(z).normalize_or(z.any_orthonormal_vector());
        Self {
            eye: world_from_view.w_axis.truncate(),
            rel_from_view: DMat3::from_cols(x, z.cross(x), z),
            display: *display,
        }
    }

    /// Clip space from view space: reversed depth (near plane at 1, infinity at 0), y down.
    #[must_use]
    pub fn clip_from_view(&self) -> DMat4 {
        let d = &self.display;
        let width = d.tan_right - d.tan_left;
        let height = d.tan_up - d.tan_down;
        DMat4::from_cols(
            DVec4::new(2.0 / width, 0.0, 0.0, 0.0),
            DVec4::new(0.0, -2.0 / height, 0.0, 0.0),
            DVec4::new((d.tan_right + d.tan_left) / width, -(d.tan_up + d.tan_down) / height, 0.0, -1.0),
            DVec4::new(0.0, 0.0, NEAR_M, 0.0),
        )
    }

    /// Clip space from rel.
    #[must_use]
    pub fn clip_from_rel(&self) -> DMat4 {
        self.clip_from_view() * DMat4::from_mat3(self.rel_from_view.transpose())
    }

    /// Whether a world sphere may touch the frustum.
    #[must_use]
    pub fn may_see(&self, centre: DVec3, radius_m: f64) -> bool {
        let view = self.rel_from_view.transpose() * (centre - self.eye);
        let d = &self.display;
        if -view.z + radius_m < NEAR_M {
            return false;
        }
        // Each side plane goes through the eye; its normal points inwards.
        let planes = [
            DVec3::new(1.0, 0.0, d.tan_left),
            DVec3::new(-1.0, 0.0, -d.tan_right),
            DVec3::new(0.0, 1.0, d.tan_down),
            DVec3::new(0.0, -1.0, -d.tan_up),
        ];
        planes.iter().all(|plane| plane.normalize().dot(view) >= -radius_m)
    }

    /// The block that the shaders read.
    #[must_use]
    pub fn params(
        &self,
        settings: &RenderSettings,
        gaze_px: DVec2,
        effects: &EffectPlan,
        environment: Option<&GpuEnvironment>,
    ) -> FrameParams {
        let [width, height] = self.display.size_px.map(f64::from);
        let row = |v: DVec3| v.as_vec3().extend(0.0).to_array();
        let ray = |px: DVec2| self.rel_from_view * self.display.ray_of_px(px);
        let base = ray(DVec2::ZERO);
        let dx = (ray(DVec2::new(width, 0.0)) - base) / width;
        let dy = (ray(DVec2::new(0.0, height)) - base) / height;
        let pixel_angle_rad = dy.length().max(dx.length());
        FrameParams {
            clip_from_rel: self.clip_from_rel().as_mat4().to_cols_array_2d(),
            ray_base: row(base),
            ray_dx: row(dx),
            ray_dy: row(dy),
            gaze: [
                gaze_px.x as f32,
                gaze_px.y as f32,
                dx.length().recip() as f32,
                dy.length().recip() as f32,
            ],
            size: self.display.size_px,
            light_count: u32::try_from(effects.lights.len()).unwrap_or(u32::MAX),
            directional_count: effects.directional_count,
            near: NEAR_M as f32,
            exposure: settings.exposure,
            env_levels: environment.map_or(0.0, |of| (of.levels - 1) as f32),
            pixel_angle_rad: pixel_angle_rad as f32,
            env_sh: environment.map_or([[0.0; 4]; 9], |of| of.sh),
            shadowed_end: effects.shadowed_end,
            pad0: 0,
            pad1: 0,
            pad2: 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An asymmetric frustum, somewhere far from the origin, turned.
    fn camera() -> CameraFrame {
        let mut display = DisplayGeometry::symmetric([1440, 1600], 98.0);
        display.tan_left *= 1.3;
        display.tan_up *= 0.8;
        let rotation = DMat4::from_euler(glam::EulerRot::YXZ, 0.7, -0.3, 0.2);
        CameraFrame::new(&display, &(DMat4::from_translation(DVec3::new(1e6, -2e5, 3e6)) * rotation))
    }

    #[test]
    fn projection_and_rays_agree() {
        let camera = camera();
        for (x, y) in [(0.0, 0.0), (1440.0, 1600.0), (0.5, 1599.5), (700.25, 13.0)] {
            for depth_m in [1e-3, 1.0, 1e5] {
                let ray = camera.rel_from_view * camera.display.ray_of_px(DVec2::new(x, y));
                let clip = camera.clip_from_rel() * (ray * depth_m).extend(1.0);
                let ndc = clip / clip.w;
                let px = (ndc.truncate().truncate() * 0.5 + 0.5) * DVec2::new(1440.0, 1600.0);
                assert!(px.distance(DVec2::new(x, y)) < 1e-6, "{px} instead of {x}, {y}");
                assert!((ndc.z - NEAR_M / depth_m).abs() < 1e-9 * ndc.z.max(1e-9), "depth {}", ndc.z);
            }
        }
    }

    #[test]
    fn spheres_outside_are_not_drawn() {
        let camera = camera();
        let at = |view: DVec3| camera.eye + camera.rel_from_view * view;
        assert!(camera.may_see(at(DVec3::new(0.0, 0.0, -5.0)), 0.1));
        assert!(!camera.may_see(at(DVec3::new(0.0, 0.0, 5.0)), 0.1), "behind");
        assert!(camera.may_see(at(DVec3::new(0.0, 0.0, 5.0)), 6.0), "around the eye");
        assert!(!camera.may_see(at(DVec3::new(50.0, 0.0, -5.0)), 1.0), "to the right");
        assert!(!camera.may_see(at(DVec3::new(0.0, -50.0, -5.0)), 1.0), "below");
    }
}
