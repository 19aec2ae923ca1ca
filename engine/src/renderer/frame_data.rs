//! What the CPU computes and writes for each frame: visible instances, transforms relative to the
//! eye, lights, shadow views. Works in buffers that exist; allocates nothing.

use super::camera::CameraFrame;
use crate::content::{DrawInstance, GpuScene};
use crate::gpu::structs::{self, SdfCamera, ShadowView};
use crate::passes::{FrameArgs, FrameBuffers};
use crate::plan::EffectPlan;
use crate::scene::{Light, LightKind};
use crate::settings::RenderSettings;
use glam::{DMat4, DVec2, DVec3, DVec4};
use std::f64::consts::TAU;

/// Fills the draw lists: what the view may see, opaque nearest first, blended farthest first.
pub(super) fn choose_visible(
    scene: &GpuScene,
    camera: &CameraFrame,
    args: &mut FrameArgs,
    order: &mut Vec<(f64, u32)>,
) {
    let distance = |instance: &DrawInstance| instance.centre.distance(camera.eye);
    for blend in [false, true] {
        order.clear();
        let indexed = (0u32..).zip(&scene.instances);
        let visible = indexed.filter(|(_, instance)| {
            instance.blend == blend && camera.may_see(instance.centre, instance.radius_m)
        });
        order.extend(visible.map(|(index, instance)| {
            let key = if blend { -distance(instance) } else { distance(instance) - instance.radius_m };
            (key, index)
        }));
        // The index breaks ties, so that equal distances draw in the file's order.
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let list = if blend { &mut args.blended } else { &mut args.opaque };
        list.clear();
        list.extend(order.iter().map(|(_, index)| index));
    }
}

/// Writes lights and shadow views, all relative to the eye.
pub(super) fn write_scene(
    scene: &GpuScene,
    effects: &EffectPlan,
    settings: &RenderSettings,
    camera: &CameraFrame,
    buffers: &mut FrameBuffers,
    slot: usize,
) {
    for (place, &(index, first_view)) in effects.lights.iter().enumerate() {
        let light = &scene.lights[index];
        let record = light_record(light, camera.eye, first_view);
        buffers.lights[slot].write(place * size_of::<structs::Light>(), &[record]);
        if let Some(first) = first_view {
            write_views(light, scene, settings, camera.eye, first, &mut |view: u32, record: ShadowView| {
                let offset = view as usize * size_of::<ShadowView>();
                buffers.shadow_views[slot].write(offset, &[record]);
            });
        }
    }
    if effects.shadows && effects.lights.iter().all(|(_, view)| view.is_none()) {
        // Forced: one view of everything, which no light reads.
        let down = Light {
            name: String::new(),
            intensity: glam::Vec3::ZERO,
            position: DVec3::ZERO,
            direction: DVec3::NEG_Y,
            kind: LightKind::Directional,
        };
        write_views(&down, scene, settings, camera.eye, 0, &mut |_, record| {
            buffers.shadow_views[slot].write(0, &[record]);
        });
    }
}

/// A squared range beyond every distance, small enough to stay finite when compared.
const NO_RANGE2: f32 = 1e30;

fn light_record(light: &Light, eye: DVec3, first_view: Option<u32>) -> structs::Light {
    let position = (light.position - eye).as_vec3();
    let (kind, range, spot) = match light.kind {
        LightKind::Directional => (0.0, f32::INFINITY, [0.0, 1.0]),
        LightKind::Point { range } => (1.0, range, [0.0, 1.0]),
        LightKind::Spot { range, inner_angle, outer_angle } => {
            let (inner, outer) = (inner_angle.cos(), outer_angle.cos());
            let scale = 1.0 / (inner - outer).max(1e-3);
            (2.0, range, [scale, -outer * scale])
        }
    };
    let range2 = range * range;
    let finite = range2.is_finite() && range2 > 0.0;
    structs::Light {
        position: position.extend(if finite { 1.0 / range2 } else { 0.0 }).to_array(),
        intensity: light.intensity.extend(if finite { range2 } else { NO_RANGE2 }).to_array(),
        direction: light.direction.as_vec3().extend(spot[0]).to_array(),
        kind,
        shadow: first_view.map_or(-1.0, |view| view as f32),
        spot_offset: spot[1],
        pad0: 0.0,
    }
}

/// Nothing nearer to a light than this casts a shadow, m.
const SHADOW_NEAR_M: f64 = 0.02;

/// A cube's faces overlap a little, so that the filter finds its neighbours.
const CUBE_TAN: f64 = 1.02;

fn write_views(
    light: &Light,
    scene: &GpuScene,
    settings: &RenderSettings,
    eye: DVec3,
    first: u32,
    write: &mut dyn FnMut(u32, ShadowView),
) {
    let texels = f64::from(settings.shadow_map_size);
    match light.kind {
        LightKind::Directional => {
            let [low, high] = scene.bounds;
            let centre = (low + high) * 0.5;
            let radius_m = ((high - low).length() * 0.5).max(1e-3);
            let clip = directional_view(light.direction, centre - eye, radius_m);
            write(first, view_record(clip, 2.0 * radius_m / texels));
        }
        LightKind::Spot { outer_angle, .. } => {
            let tangent = f64::from(outer_angle).min(1.5).tan() * 1.02;
            let clip = perspective_view(light.direction, light.position - eye, tangent);
            write(first, view_record(clip, 2.0 * tangent / texels));
        }
        LightKind::Point { .. } => {
            let faces = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
            for (face, direction) in (0u32..).zip(faces) {
                let clip = perspective_view(direction, light.position - eye, CUBE_TAN);
                write(first + face, view_record(clip, 2.0 * CUBE_TAN / texels));
            }
        }
    }
}

fn view_record(clip_from_rel: DMat4, texel_m: f64) -> ShadowView {
    ShadowView {
        clip_from_rel: clip_from_rel.transpose().as_mat4().to_cols_array_2d(),
        bias: [texel_m as f32, 0.0, 0.0, 0.0],
    }
}

/// Two unit vectors across a unit direction.
fn across(direction: DVec3) -> (DVec3, DVec3) {
    let right = direction.any_orthonormal_vector();
    (right, right.cross(direction))
}

/// The matrix whose rows are given, each as a vector and an offset.
fn from_rows(rows: [(DVec3, f64); 4]) -> DMat4 {
    let [x, y, z, w] = rows.map(|(row, offset)| row.extend(offset));
    DMat4::from_cols(x, y, z, w).transpose()
}

/// Orthographic over a sphere; depth 1 at its near side, 0 at its far side.
fn directional_view(direction: DVec3, centre: DVec3, radius_m: f64) -> DMat4 {
    let (right, up) = across(direction);
    let scaled = |axis: DVec3, scale: f64, offset: f64| (axis * scale, offset - axis.dot(centre) * scale);
    from_rows([
        scaled(right, 1.0 / radius_m, 0.0),
        scaled(up, 1.0 / radius_m, 0.0),
        scaled(direction, -0.5 / radius_m, 0.5),
        (DVec3::ZERO, 1.0),
    ])
}

/// Perspective from a point, reversed depth with an infinite far plane.
fn perspective_view(direction: DVec3, position: DVec3, tangent: f64) -> DMat4 {
    let (right, up) = across(direction);
    let row = |axis: DVec3| (axis, -axis.dot(position));
    let scaled = |axis: DVec3| row(axis / tangent);
    from_rows([scaled(right), scaled(up), (DVec3::ZERO, SHADOW_NEAR_M), row(direction)])
}

/// The ray-marched scene's camera. Its world is small and stands at the origin.
pub(super) fn write_sdf(
    settings: &RenderSettings,
    camera: &CameraFrame,
    lp_height: u32,
    buffers: &mut FrameBuffers,
    slot: usize,
) {
    let eye: DVec4 = camera.eye.extend(0.0);
    let record = SdfCamera {
        sdf_eye: eye.as_vec4().to_array(),
        samples_per_pixel: settings.samples_per_pixel,
        pad0: 0,
        pad1: 0,
        pad2: 0,
        sample_offsets: sample_offsets(lp_height),
    };
    buffers.sdf_camera[slot].write(0, &[record]);
}

/// Offsets of the samples of a pixel or LP texel, with the turn in an LP-buffer of that height: the
/// additive recurrence on the plastic number (R2), which fills the square evenly for any count. A single
/// sample sits in the centre.
fn sample_offsets(lp_height: u32) -> [[f32; 4]; 16] {
    const STEP: DVec2 = DVec2::new(0.754_877_666_246_692_7, 0.569_840_290_998_053_2);
    std::array::from_fn(|index| {
        let offset = (DVec2::splat(0.5) + index as f64 * STEP).fract() - 0.5;
        let turn = DVec2::from_angle(offset.y * TAU / f64::from(lp_height));
        [offset.x as f32, offset.y as f32, turn.x as f32, turn.y as f32]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn project(clip: DMat4, point: DVec3) -> DVec3 {
        let at = clip * point.extend(1.0);
        at.truncate() / at.w
    }

    #[test]
    fn a_directional_view_holds_its_sphere() {
        let direction = DVec3::new(0.3, -0.9, 0.2).normalize();
        let centre = DVec3::new(5.0, 1.0, -7.0);
        let clip = directional_view(direction, centre, 3.0);
        assert!(project(clip, centre).abs_diff_eq(DVec3::new(0.0, 0.0, 0.5), 1e-12));
        assert!((project(clip, centre - direction * 3.0).z - 1.0).abs() < 1e-12, "near side");
        assert!(project(clip, centre + direction * 3.0).z.abs() < 1e-12, "far side");
        let side = project(clip, centre + direction.any_orthonormal_vector() * 3.0);
        assert!((side.truncate().length() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_perspective_view_looks_along_its_direction() {
        let position = DVec3::new(1.0, 2.0, 3.0);
        let clip = perspective_view(DVec3::NEG_Z, position, 0.5);
        let ahead = project(clip, position + DVec3::NEG_Z * 4.0);
        assert!(ahead.abs_diff_eq(DVec3::new(0.0, 0.0, SHADOW_NEAR_M / 4.0), 1e-12), "{ahead}");
        let edge = project(clip, position + DVec3::new(2.0, 0.0, -4.0));
        assert!((edge.truncate().length() - 1.0).abs() < 1e-12, "tangent 0.5 is the edge: {edge}");
    }

    #[test]
    fn spot_cones_follow_the_extension() {
        let light = Light {
            name: String::new(),
            intensity: glam::Vec3::ONE,
            position: DVec3::new(1e6, 0.0, 0.0),
            direction: DVec3::NEG_Y,
            kind: LightKind::Spot { range: 2.0, inner_angle: 0.3, outer_angle: 0.6 },
        };
        let record = light_record(&light, DVec3::new(1e6, 0.5, 0.0), None);
        assert_eq!(record.position[..3], [0.0, -0.5, 0.0], "relative to the eye");
        let share = |angle: f32| (angle.cos() * record.direction[3] + record.spot_offset).clamp(0.0, 1.0);
        assert!((share(0.29) - 1.0).abs() < 1e-6 && share(0.61) == 0.0);
        assert!(share(0.45) > 0.0 && share(0.45) < 1.0);
        assert_eq!((record.intensity[3], record.position[3]), (4.0, 0.25));
    }
}
