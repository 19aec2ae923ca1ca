//! Morph targets and skins, applied once: a scene is evaluated at one time.

use glam::{DMat3, DMat4, DVec3, Vec3};

use gltf::json::Index;
use gltf::json::mesh::{Primitive, Semantic};

use super::accessor::Accessor;
use super::context::{Context, Outcome, get, label};
use super::geometry::{Surface, attribute};
use super::nodes::{Hierarchy, affine};

/// World space is moved to the mesh where it lies farther out than this, so that 32 bits hold it.
const FAR_METRES: f64 = 1024.0;

/// Adds the morph targets by their weights. Vertices are still those of the file.
pub fn morph(
    context: &Context,
    surface: &mut Surface,
    primitive: &Primitive,
    weights: &[f32],
    user: &str,
) -> Outcome<()> {
    for (index, (target, &weight)) in primitive.targets.iter().flatten().zip(weights).enumerate() {
        if weight == 0.0 {
            continue;
        }
        let user = format!("{user}, morph target {index}");
        // A mesh can have many targets that all show the same data.
        context.work(surface.source.len() as u64, &user)?;
        let open = |accessor: Option<Index<_>>, name: &str| -> Outcome<Option<Accessor>> {
            let Some(accessor) = accessor else {
                return Ok(None);
            };
            let user = format!("{user}, {name}");
            let accessor = Accessor::open(context, accessor, &user, &[3])?;
            match surface.source.iter().max() {
                Some(&last) if last as usize >= accessor.count => {
                    Err(format!("{user}: {} elements are too few", accessor.count))
                }
                _ => Ok(Some(accessor)),
            }
        };
        let positions = open(target.positions, "POSITION")?;
        let normals = open(target.normals, "NORMAL")?;
        let tangents = open(target.tangents, "TANGENT")?;
        for (vertex, &element) in surface.source.iter().enumerate() {
            let delta = |accessor: &Option<Accessor>| {
                accessor.as_ref().map(|accessor| accessor.vec3(element as usize) * weight)
            };
            if let Some(delta) = delta(&positions) {
                surface.positions[vertex] += delta;
            }
            if let (Some(delta), Some(normal)) = (delta(&normals), surface.normals.get_mut(vertex)) {
                *normal += delta;
            }
            if let (Some(delta), Some(tangent)) = (delta(&tangents), surface.tangents.get_mut(vertex)) {
                let [x, y, z, sign] = *tangent;
                *tangent = (Vec3::new(x, y, z) + delta).extend(sign).to_array();
            }
        }
    }
    check_finite(surface, user, "its morph targets")
}

fn check_finite(surface: &Surface, user: &str, cause: &str) -> Outcome<()> {
    match surface.positions.iter().all(|position| position.is_finite()) {
        true => Ok(()),
        false => Err(format!("{user}: {cause} lead to positions that are not finite")),
    }
}

/// The world from bind pose matrices of a skin's joints.
pub fn joint_matrices(context: &Context, hierarchy: &Hierarchy, index: usize) -> Outcome<Vec<DMat4>> {
    let root = &context.document.root;
    let skin = get(&root.skins, "skin", index, "a node")?;
    let user = label("skin", index, skin.name.as_deref());
    let inverse_bind = match skin.inverse_bind_matrices {
        Some(accessor) => Some(Accessor::open(context, accessor, &user, &[16])?),
        None => None,
    };
    if let Some(matrices) = inverse_bind.as_ref().filter(|matrices| matrices.count < skin.joints.len()) {
        return Err(format!("{user} has {} joints and {} matrices", skin.joints.len(), matrices.count));
    }
    context.work(skin.joints.len() as u64, &user)?;
    let mut joints = Vec::with_capacity(skin.joints.len());
    for (joint, &node) in skin.joints.iter().enumerate() {
        let node = node.value();
        get(&root.nodes, "node", node, &user)?;
        let bind = inverse_bind.as_ref().map_or(DMat4::IDENTITY, |matrices| affine(matrices.mat4(joint)));
        let matrix = hierarchy.world[node] * bind;
        if !matrix.is_finite() {
            return Err(format!("{user}: the matrix of joint {joint} is not finite"));
        }
        joints.push(matrix);
    }
    Ok(joints)
}

/// A primitive's joints and weights: one set or two of four.
struct Influences<'a> {
    sets: Vec<(Accessor<'a>, Accessor<'a>)>,
    joints: &'a [DMat4],
    user: &'a str,
}

impl Influences<'_> {
    /// The blended matrix of one element.
    fn matrix(&self, element: usize) -> Outcome<DMat4> {
        let (mut sum, mut total, mut first) = (DMat4::ZERO, 0.0, None);
        for (joints, weights) in &self.sets {
            for lane in 0..4 {
                let weight = f64::from(weights.number(element, lane));
                let joint = joints.integer(element, lane) as usize;
                first = first.or(self.joints.get(joint));
                if weight > 0.0 && weight.is_finite() {
                    let matrix = self.joints.get(joint).ok_or_else(|| {
                        let (user, count) = (self.user, self.joints.len());
                        format!("{user}: vertex {element} names joint {joint}, but the skin has {count}")
                    })?;
                    sum += *matrix * weight;
                    total += weight;
                }
            }
        }
        // Without any weight a vertex follows its first joint, as it mostly does elsewhere.
        if total > 0.0 { Ok(sum * (1.0 / total)) } else { Ok(first.copied().unwrap_or(DMat4::IDENTITY)) }
    }
}

/// Whether a primitive has what a skin needs.
pub fn is_skinnable(primitive: &Primitive) -> bool {
    attribute(primitive, Semantic::Joints(0)).is_some()
        && attribute(primitive, Semantic::Weights(0)).is_some()
}

/// Brings the surface into world space by its skin. Returns where in the world its origin lies.
pub fn skin(
    context: &Context,
    surface: &mut Surface,
    primitive: &Primitive,
    joints: &[DMat4],
    user: &str,
) -> Outcome<DVec3> {
    let sets = open_influences(context, surface, primitive, user)?;
    let influences = Influences { sets, joints, user };
    let mut positions = Vec::with_capacity(surface.source.len());
    let mut mirrored = Vec::with_capacity(surface.source.len());
    for (vertex, &element) in surface.source.iter().enumerate() {
        let matrix = influences.matrix(element as usize)?;
        positions.push(matrix.transform_point3(surface.positions[vertex].as_dvec3()));
        let linear = DMat3::from_mat4(matrix);
        let mirrors = linear.determinant() < 0.0;
        mirrored.push(mirrors);
        if let Some(normal) = surface.normals.get_mut(vertex) {
            *normal = transform_normal(linear, *normal);
        }
        if let Some(tangent) = surface.tangents.get_mut(vertex) {
            let [x, y, z, sign] = *tangent;
            let turned = linear * DVec3::new(x.into(), y.into(), z.into());
            let sign = if mirrors { -sign } else { sign };
            *tangent = turned.normalize_or_zero().as_vec3().extend(sign).to_array();
        }
    }
    // The outside has to stay outside.
    for triangle in &mut surface.triangles {
        if triangle.iter().all(|&vertex| mirrored[vertex as usize]) {
            triangle.swap(1, 2);
        }
    }
    let mean = positions.iter().sum::<DVec3>() / positions.len().max(1) as f64;
    let origin = if mean.length() > FAR_METRES { mean.round() } else { DVec3::ZERO };
    surface.positions = positions.into_iter().map(|position| (position - origin).as_vec3()).collect();
    check_finite(surface, user, "its joints")?;
    Ok(origin)
}

/// By the inverse transpose, whatever its length; by the cofactors, which exist for every matrix.
fn transform_normal(linear: DMat3, normal: Vec3) -> Vec3 {
    let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    let sign = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
    (cofactors * normal.as_dvec3() * sign).normalize_or_zero().as_vec3()
}

fn open_influences<'a>(
    context: &Context<'a>,
    surface: &Surface,
    primitive: &Primitive,
    user: &str,
) -> Outcome<Vec<(Accessor<'a>, Accessor<'a>)>> {
    let last = surface.source.iter().max().map_or(0, |&last| last as usize);
    let mut sets = Vec::new();
    for set in 0..2 {
        let attributes = [Semantic::Joints(set), Semantic::Weights(set)];
        let [Some(joints), Some(weights)] = attributes.map(|name| attribute(primitive, name)) else {
            break;
        };
        let open = |accessor, name: &str| {
            let user = format!("{user}, {name}");
            let accessor = Accessor::open(context, accessor, &user, &[4])?;
            match accessor.count > last {
                true => Ok(accessor),
                false => Err(format!("{user}: {} elements are too few", accessor.count)),
            }
        };
        let joints = open(joints, &format!("JOINTS_{set}"))?;
        let weights = open(weights, &format!("WEIGHTS_{set}"))?.normalized();
        if !joints.is_integer() {
            return Err(format!("{user}, JOINTS_{set}: not unsigned integers"));
        }
        sets.push((joints, weights));
    }
    if attribute(primitive, Semantic::Joints(2)).is_some() {
        context.warn(format!("{user}: more than eight joints for a vertex; the others ignored"));
    }
    Ok(sets)
}
