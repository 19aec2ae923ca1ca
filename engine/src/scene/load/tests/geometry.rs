//! Positions, indices and instances.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::{DVec3, Vec2, Vec3};
use serde_json::json;

use super::{File, SQUARE, TRIANGLE, check_whole};
use crate::scene::Mesh;

/// The corners of each triangle, in their order.
fn triangles(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    let corner = |index: u32| mesh.vertices[index as usize].position;
    mesh.indices.chunks_exact(3).map(|t| [corner(t[0]), corner(t[1]), corner(t[2])]).collect()
}

fn normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a).normalize()
}

#[test]
fn strips_keep_their_winding() {
    let mut file = File::default();
    let positions = file.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0., 0., 2., 0.]);
    let scene = file.load_primitive(json!({ "attributes": { "POSITION": positions }, "mode": 5 }));
    check_whole(&scene);
    let triangles = triangles(&scene.meshes[0]);
    assert_eq!(triangles.len(), 3);
    assert!(triangles.iter().all(|&triangle| normal(triangle) == Vec3::Z));
}

#[test]
fn fans_keep_their_winding() {
    let mut file = File::default();
    let positions = file.floats("VEC3", &SQUARE);
    let indices = file.indices(&[0, 1, 2, 3]);
    let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices, "mode": 6 });
    let scene = file.load_primitive(primitive);
    let triangles = triangles(&scene.meshes[0]);
    assert_eq!(triangles.len(), 2);
    assert!(triangles.iter().all(|&triangle| normal(triangle) == Vec3::Z));
    assert_eq!(scene.meshes[0].bounds, [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0)]);
}

#[test]
fn missing_normals_are_flat_and_vertices_unshared() {
    let mut file = File::default();
    // Two triangles folded along the edge from (0, 0, 0) to (0, 1, 0).
    let positions = file.floats("VEC3", &[0., 0., 0., 0., 1., 0., 1., 0., 0., 0., 0., 1.]);
    let indices = file.indices(&[0, 2, 1, 0, 1, 3]);
    let scene = file.load_primitive(json!({ "attributes": { "POSITION": positions }, "indices": indices }));
    check_whole(&scene);
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.vertices.len(), 6);
    assert!(mesh.vertices[..3].iter().all(|vertex| vertex.normal == Vec3::Z));
    assert!(mesh.vertices[3..].iter().all(|vertex| vertex.normal == Vec3::X));
}

#[test]
fn broken_normals_are_mended() {
    let mut file = File::default();
    let positions = file.floats("VEC3", &SQUARE);
    let normals = file.floats("VEC3", &[0., 0., 2., 0., 0., 0., f32::NAN, 0., 0., 0., 0., 1.]);
    let indices = file.indices(&[0, 1, 2, 0, 2, 3]);
    let attributes = json!({ "POSITION": positions, "NORMAL": normals });
    let scene = file.load_primitive(json!({ "attributes": attributes, "indices": indices }));
    check_whole(&scene);
    assert_eq!(scene.meshes[0].vertices.len(), 4);
    assert!(scene.meshes[0].vertices.iter().all(|vertex| vertex.normal == Vec3::Z));
    assert_eq!(scene.warnings, ["mesh 0 \"thing\", primitive 0: normals without a direction computed anew"]);
}

#[test]
fn sparse_accessors_replace_elements() {
    let mut file = File::default();
    let positions = file.floats("VEC3", &TRIANGLE);
    let indices = file.view(&[2, 0, 0, 0]);
    let values = file.view(bytemuck::cast_slice(&[5.0f32, 6.0, 7.0]));
    let sparse = json!({
        "count": 1,
        "indices": { "bufferView": indices, "componentType": 5121 },
        "values": { "bufferView": values },
    });
    file.accessors[positions]["sparse"] = sparse.clone();
    let scene = file.load_primitive(json!({ "attributes": { "POSITION": positions } }));
    assert_eq!(triangles(&scene.meshes[0])[0][2], Vec3::new(5.0, 6.0, 7.0));
    assert_eq!(triangles(&scene.meshes[0])[0][1], Vec3::X);

    // Without a buffer view the others are zero: one point, and no triangle with an area.
    file.accessors.push(json!({ "componentType": 5126, "type": "VEC3", "count": 3, "sparse": sparse }));
    let scene = file.load_primitive(json!({ "attributes": { "POSITION": file.accessors.len() - 1 } }));
    assert!(scene.instances.is_empty() && scene.meshes.is_empty());
}

#[test]
fn integer_attributes_are_fractions_where_they_say_so() {
    let mut file = File::default();
    let positions: [i16; 12] = [0, 0, 0, 0, 32767, 0, 0, 0, 0, 32767, -32768, 0];
    let fields = json!({ "componentType": 5122, "type": "VEC3", "count": 3, "normalized": true });
    let positions = file.accessor(bytemuck::cast_slice(&positions), fields);
    file.views[0]["byteStride"] = json!(8);
    let uvs = json!({ "componentType": 5121, "type": "VEC2", "count": 3, "normalized": true });
    let uvs = file.accessor(&[0, 255, 51, 102, 0, 0], uvs);
    let raw = json!({ "componentType": 5120, "type": "VEC2", "count": 3 });
    let raw = file.accessor(&[0, 255, 51, 102, 0, 0], raw);
    let colors = json!({ "componentType": 5123, "type": "VEC3", "count": 3 });
    let colors = file.accessor(bytemuck::cast_slice(&[65535u16, 0, 32768, 0, 0, 0, 0, 0, 0]), colors);
    let scene = file.load_primitive(json!({ "attributes": {
        "POSITION": positions, "TEXCOORD_0": uvs, "TEXCOORD_1": raw, "COLOR_0": colors
    }}));
    check_whole(&scene);
    let mesh = &scene.meshes[0];
    assert_eq!(triangles(mesh)[0], [Vec3::ZERO, Vec3::X, Vec3::new(0.0, 1.0, -1.0)]);
    assert_eq!(mesh.vertices[0].uv0, Vec2::new(0.0, 1.0));
    assert_eq!(mesh.vertices[1].uv0, Vec2::new(0.2, 0.4));
    assert_eq!(mesh.vertices[0].uv1, Vec2::new(0.0, -1.0));
    assert_eq!(mesh.vertices[0].color, [255, 0, 128, 255]);
    assert!(mesh.has_colors);
}

#[test]
fn degenerate_triangles_are_dropped() {
    let mut file = File::default();
    let positions = file.floats("VEC3", &[0., 0., 0., 1., 0., 0., 1., 1., 0., 2., 0., 0.]);
    let indices = file.indices(&[0, 1, 1, 0, 1, 3, 0, 1, 2]);
    let scene = file.load_primitive(json!({ "attributes": { "POSITION": positions }, "indices": indices }));
    assert_eq!(scene.meshes[0].indices.len(), 3);
}

#[test]
fn transforms_multiply_and_singular_ones_are_skipped() {
    let mut file = File::default();
    let positions = file.floats("VEC3", &TRIANGLE);
    let rest = json!({
        "scenes": [{ "nodes": [0, 3] }],
        "nodes": [
            { "translation": [1e6, 0, 0], "scale": [2, -1, 1], "children": [1, 2] },
            { "mesh": 0, "rotation": [0, 0, FRAC_1_SQRT_2, FRAC_1_SQRT_2] },
            { "mesh": 0, "scale": [1, 0, 1] },
            { "mesh": 0, "matrix": [0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0.1, 1] },
        ],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": positions } }] }],
    });
    let scene = file.load(rest).expect("valid");
    check_whole(&scene);
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 2));
    // Breadth first: the second root comes before the first one's children.
    let world = scene.instances[1].world_from_mesh;
    assert!(world.determinant() < 0.0);
    // (1, 0, 0) turned to (0, 1, 0), scaled to (0, -1, 0), moved.
    assert!(world.transform_point3(DVec3::X).distance(DVec3::new(1e6, -1.0, 0.0)) < 1e-9);
    assert_eq!(scene.instances[0].world_from_mesh.transform_point3(DVec3::X), DVec3::new(0.0, 1.0, 0.1));
    assert_eq!(scene.warnings, ["node 2 ignored: its transform is singular or not finite"]);
}

#[test]
fn deep_hierarchies_need_no_stack() {
    let count = 100_000;
    let mut nodes: Vec<_> = (1..count).map(|child| json!({ "children": [child] })).collect();
    nodes.push(json!({ "mesh": 0, "translation": [0, 0, 1] }));
    let mut file = File::default();
    let positions = file.floats("VEC3", &TRIANGLE);
    let scene = file.load(json!({
        "scenes": [{ "nodes": [0] }],
        "nodes": nodes,
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": positions } }] }],
    }));
    assert_eq!(scene.expect("valid").instances[0].world_from_mesh.w_axis.z, 1.0);
}

#[test]
fn points_and_lines_are_left_out() {
    let mut file = File::default();
    let positions = file.floats("VEC3", &TRIANGLE);
    let scene = file.load_primitive(json!({ "attributes": { "POSITION": positions }, "mode": 1 }));
    assert!(scene.meshes.is_empty() && scene.bounds().is_none());
    assert_eq!(scene.warnings, ["mesh 0 \"thing\", primitive 0 ignored: it holds points or lines"]);
}
