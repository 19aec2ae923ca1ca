//! Lights and cameras, put into the world by their nodes.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use glam::{DMat3, DMat4, DVec3, Vec3};

use gltf::json::camera::Type as CameraType;
use gltf::json::extensions::scene::khr_lights_punctual::{self as punctual, Type};
use gltf::json::validation::Checked;

use super::context::{Context, Outcome, get, label, name_or};
use crate::scene::{Camera, Light, LightKind};

/// The least difference between a spot light's angles, radians: shaders divide by it.
const LEAST_SPOT_EDGE: f32 = 1e-3;

/// The light that a node holds; `None`, with a warning, where its node leaves it no direction.
pub fn light(context: &Context, index: usize, world: &DMat4, user: &str) -> Outcome<Option<Light>> {
    let file = get(context.document.lights(), "light", index, user)?;
    let user = label("light", index, file.name.as_deref());
    let kind = match file.type_ {
        Checked::Valid(Type::Directional) => LightKind::Directional,
        Checked::Valid(Type::Point) => LightKind::Point { range: range(context, file, &user) },
        Checked::Valid(Type::Spot) => spot(context, file, &user),
        Checked::Invalid => {
            return Err(format!("{user} is neither directional nor a point nor a spot light"));
        }
    };
    let direction = world.transform_vector3(DVec3::NEG_Z);
    let position = world.w_axis.truncate();
    let Some(direction) = direction.try_normalize().filter(|_| position.is_finite()) else {
        context.warn(format!("{user} ignored: its node's transform is singular or not finite"));
        return Ok(None);
    };
    let intensity = file.color.map(|channel| {
        let product = f64::from(channel) * f64::from(file.intensity);
        let clamped = product.clamp(0.0, f64::from(f32::MAX));
        if clamped != product {
            context.warn(format!("{user}: negative or too large intensity clamped"));
        }
        clamped as f32
    });
    let name = name_or(file.name.as_deref(), "light", index);
    Ok(Some(Light { name, intensity: Vec3::from_array(intensity), position, direction, kind }))
}

fn range(context: &Context, file: &punctual::Light, user: &str) -> f32 {
    match file.range {
        None => f32::INFINITY,
        // Beyond what 32 bits hold it was cut off; infinite is what it means.
        Some(f32::MAX) => f32::INFINITY,
        Some(range) if range > 0.0 => range,
        Some(_) => {
            context.warn(format!("{user}: its range is not positive and taken as infinite"));
            f32::INFINITY
        }
    }
}

fn spot(context: &Context, file: &punctual::Light, user: &str) -> LightKind {
    let (given_inner, given_outer) = match &file.spot {
        Some(spot) => (spot.inner_cone_angle, spot.outer_cone_angle),
        None => {
            context.warn(format!("{user}: a spot light without angles, taken as glTF's defaults"));
            (0.0, FRAC_PI_4)
        }
    };
    let outer = given_outer.clamp(LEAST_SPOT_EDGE, FRAC_PI_2);
    let inner = given_inner.clamp(0.0, outer - LEAST_SPOT_EDGE);
    if outer != given_outer || inner != given_inner {
        // Equal angles are common and meant as a hard edge.
        context.warn(format!("{user}: spot angles brought into 0 to 90 degrees, inner below outer"));
    }
    LightKind::Spot { range: range(context, file, user), inner_angle: inner, outer_angle: outer }
}

/// The camera that a node holds; `None`, with a warning, where its node leaves it no direction.
pub fn camera(
    context: &Context,
    index: usize,
    node_name: Option<&str>,
    world: &DMat4,
    user: &str,
) -> Outcome<Option<Camera>> {
    let file = get(&context.document.root.cameras, "camera", index, user)?;
    let user = label("camera", index, file.name.as_deref());
    let Some(world_from_view) = without_scale(world) else {
        context.warn(format!("{user} ignored: its node's transform is singular or not finite"));
        return Ok(None);
    };
    let yfov_rad = match (file.type_, &file.perspective) {
        (Checked::Valid(CameraType::Perspective), Some(perspective)) => {
            let valid = perspective.yfov > 0.0 && perspective.yfov < PI;
            if !valid {
                context.warn(format!("{user}: its field of view is not between 0 and 180 degrees"));
            }
            valid.then_some(f64::from(perspective.yfov))
        }
        (Checked::Valid(CameraType::Orthographic), _) => None,
        _ => return Err(format!("{user} is neither perspective nor orthographic")),
    };
    let own_name = file.name.as_deref().filter(|name| !name.is_empty());
    let name = name_or(own_name.or(node_name), "camera", index);
    Ok(Some(Camera { name, world_from_view, yfov_rad }))
}

/// The right-handed orthonormal frame with the transform's forward direction and about its up.
fn without_scale(world: &DMat4) -> Option<DMat4> {
    let back = world.z_axis.truncate().try_normalize()?;
    let up = world.y_axis.truncate().try_normalize()?;
    let right = up.cross(back);
    // Nearly the same direction: the rest would be rounding errors.
    let right = if right.length() > 1e-9 { right.normalize() } else { return None };
    let position = world.w_axis.truncate();
    let frame = DMat3::from_cols(right, back.cross(right).normalize(), back);
    (frame.is_finite() && position.is_finite()).then(|| {
        let mut matrix = DMat4::from_mat3(frame);
        matrix.w_axis = position.extend(1.0);
        matrix
    })
}
