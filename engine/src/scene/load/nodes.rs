//! The node hierarchy, without recursion: a file may be as deep as it likes.

use glam::{DMat3, DMat4, DQuat, DVec3, DVec4, Vec3};

use gltf::json::{Index, Node};

use super::context::{Context, Outcome, get, label};
use super::{LoadOptions, animation};

/// A node's local transform and morph weights.
#[derive(Clone)]
pub struct Pose {
    /// Instead of the other three.
    pub matrix: Option<DMat4>,
    pub translation: DVec3,
    pub rotation: DQuat,
    pub scale: DVec3,
    /// Overrides the mesh's.
    pub weights: Option<Vec<f32>>,
}

impl Pose {
    /// Nothing in it is infinite or NaN.
    pub fn is_finite(&self) -> bool {
        self.translation.is_finite()
            && self.rotation.is_finite()
            && self.scale.is_finite()
            && self.weights.iter().flatten().all(|weight| weight.is_finite())
    }

    fn matrix(&self) -> DMat4 {
        self.matrix.unwrap_or_else(|| {
            DMat4::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
        })
    }
}

/// The nodes at the wanted time.
pub struct Hierarchy {
    /// World from node, for all nodes of the file, since joints may lie outside of the scene.
    pub world: Vec<DMat4>,
    /// Morph weights that nodes or their animations set.
    pub weights: Vec<Option<Vec<f32>>>,
    /// The scene's nodes, parents before children.
    pub in_scene: Vec<usize>,
}

/// The unit quaternion of four numbers; the identity where they have no direction.
pub fn quaternion(xyzw: [f64; 4]) -> DQuat {
    let length = DVec4::from_array(xyzw).length();
    if length.is_finite() && length > 1e-12 {
        DQuat::from_vec4(DVec4::from_array(xyzw) / length)
    } else {
        DQuat::IDENTITY
    }
}

/// Poses all nodes and finds those of the scene.
pub fn evaluate(context: &Context, options: &LoadOptions) -> Outcome<Hierarchy> {
    let root = &context.document.root;
    let (order, parents) = order(context)?;
    let mut poses: Vec<Pose> = (0..root.nodes.len()).map(|node| rest_pose(context, node)).collect();
    animation::apply(context, options.time_s, &mut poses)?;
    let mut world = vec![DMat4::IDENTITY; poses.len()];
    for &node in &order {
        let local = poses[node].matrix();
        world[node] = parents[node].map_or(local, |parent| world[parent] * local);
    }
    let in_scene = scene_nodes(context, options, &parents)?;
    let weights = poses.into_iter().map(|pose| pose.weights).collect();
    Ok(Hierarchy { world, weights, in_scene })
}

/// All nodes with parents before their children, and each node's parent. That the nodes form trees
/// is checked here for the whole file.
fn order(context: &Context) -> Outcome<(Vec<usize>, Vec<Option<usize>>)> {
    let nodes = &context.document.root.nodes;
    let mut parents = vec![None; nodes.len()];
    for (index, node) in nodes.iter().enumerate() {
        for child in children(node) {
            let name = |i: usize| label("node", i, nodes[i].name.as_deref());
            get(nodes, "node", child, name(index))?;
            if let Some(other) = parents[child].replace(index) {
                return Err(format!("{} has two parents, nodes {other} and {index}", name(child)));
            }
        }
    }
    let mut order: Vec<usize> = (0..nodes.len()).filter(|&node| parents[node].is_none()).collect();
    let mut next = 0;
    while let Some(&node) = order.get(next) {
        order.extend(children(&nodes[node]));
        next += 1;
    }
    // Each node has at most one parent, so those that no root leads to run in circles.
    if order.len() < nodes.len() {
        let mut reached = vec![false; nodes.len()];
        order.iter().for_each(|&node| reached[node] = true);
        let lost = reached.iter().position(|reached| !reached).unwrap_or(0);
        return Err(format!("{} is its own ancestor", label("node", lost, nodes[lost].name.as_deref())));
    }
    Ok((order, parents))
}

fn children(node: &Node) -> impl Iterator<Item = usize> {
    node.children.iter().flatten().map(Index::value)
}

fn rest_pose(context: &Context, index: usize) -> Pose {
    let node = &context.document.root.nodes[index];
    let name = || label("node", index, node.name.as_deref());
    let has_parts = node.translation.is_some() || node.rotation.is_some() || node.scale.is_some();
    // In place of the crate's, which is rounded.
    let origin = context.document.origins.get(index).copied().flatten().map(DVec3::from_array);
    let matrix = node.matrix.map(|numbers| {
        let mut matrix = affine(DMat4::from_cols_array(&numbers.map(f64::from)));
        matrix.w_axis = origin.map_or(matrix.w_axis, |origin| origin.extend(1.0));
        matrix
    });
    if matrix.is_some() && has_parts {
        context.warn(format!("{}: its matrix is used, its translation, rotation and scale ignored", name()));
    }
    let rotation = node.rotation.unwrap_or_default().0.map(f64::from);
    if (DVec4::from_array(rotation).length() - 1.0).abs() > 1e-2 {
        context.warn(format!("{}: rotation brought to length 1", name()));
    }
    Pose {
        matrix,
        translation: origin.unwrap_or(DVec3::ZERO),
        rotation: quaternion(rotation),
        scale: node.scale.map_or(DVec3::ONE, |scale| Vec3::from_array(scale).as_dvec3()),
        weights: node.weights.clone(),
    }
}

/// The matrix with the last row that glTF demands.
pub fn affine(mut matrix: DMat4) -> DMat4 {
    matrix.x_axis.w = 0.0;
    matrix.y_axis.w = 0.0;
    matrix.z_axis.w = 0.0;
    matrix.w_axis.w = 1.0;
    matrix
}

fn scene_nodes(context: &Context, options: &LoadOptions, parents: &[Option<usize>]) -> Outcome<Vec<usize>> {
    let root = &context.document.root;
    let index = match (options.scene_index, root.scene) {
        (Some(index), _) => {
            get(&root.scenes, "scene", index, "the request")?;
            index
        }
        // A choice among no scenes at all is as harmless as none.
        (None, Some(index)) if !root.scenes.is_empty() => {
            let index = index.value();
            get(&root.scenes, "scene", index, "the file's \"scene\"")?;
            index
        }
        (None, _) => 0,
    };
    let Some(scene) = root.scenes.get(index) else {
        context.warn("the file has no scene: nothing is drawn");
        return Ok(Vec::new());
    };
    let user = label("scene", index, None);
    let mut listed = vec![false; root.nodes.len()];
    let mut nodes = Vec::new();
    for node in scene.nodes.iter().map(Index::value) {
        get(&root.nodes, "node", node, &user)?;
        if parents[node].is_some() {
            context.warn(format!("{user} lists node {node}, which is no root"));
        }
        if !std::mem::replace(&mut listed[node], true) {
            nodes.push(node);
        }
    }
    let mut next = 0;
    while let Some(&node) = nodes.get(next) {
        for child in children(&root.nodes[node]) {
            if !std::mem::replace(&mut listed[child], true) {
                nodes.push(child);
            }
        }
        next += 1;
    }
    Ok(nodes)
}

/// Whether a transform is finite and far enough from singular to be inverted.
pub fn is_invertible(matrix: &DMat4) -> bool {
    let axes = DMat3::from_mat4(*matrix);
    let size = axes.x_axis.length() * axes.y_axis.length() * axes.z_axis.length();
    matrix.is_finite()
        && size.is_finite()
        && size > 0.0
        && axes.determinant().abs() > 1e-12 * size
        && matrix.inverse().is_finite()
}
