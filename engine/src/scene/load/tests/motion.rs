//! Animations, skins and morph targets.

use glam::{DVec3, Vec3};
use serde_json::{Value, json};

use super::{File, TRIANGLE, check_whole, load_text};
use crate::scene::Scene;
use crate::scene::load::LoadOptions;

/// A triangle's node moved by one channel, at `time_s`.
fn animated(path: &str, interpolation: &str, times: &[f32], output: &[f32], time_s: f64) -> Scene {
    let mut file = File::default();
    let positions = file.floats("VEC3", &TRIANGLE);
    let input = file.floats("SCALAR", times);
    let output = file.floats(if path == "rotation" { "VEC4" } else { "VEC3" }, output);
    let text = file.text(json!({
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "translation": [9, 9, 9] }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": positions } }] }],
        "animations": [{
            "samplers": [{ "input": input, "output": output, "interpolation": interpolation }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": path } }],
        }],
    }));
    load_text(&text, &LoadOptions { time_s, scene_index: None }).expect("valid")
}

fn translation(scene: &Scene) -> DVec3 {
    scene.instances[0].world_from_mesh.w_axis.truncate()
}

#[test]
fn linear_and_step() {
    let moved = |interpolation: &str, time_s| {
        translation(&animated("translation", interpolation, &[1.0, 3.0], &[0., 0., 0., 4., 0., 0.], time_s)).x
    };
    assert_eq!(moved("LINEAR", 0.0), 0.0);
    assert_eq!(moved("LINEAR", 1.5), 1.0);
    assert_eq!(moved("LINEAR", 3.0), 4.0);
    // Wrapped: 4.5 is 1.5 again, and -0.5 is 2.5.
    assert_eq!(moved("LINEAR", 4.5), 1.0);
    assert_eq!(moved("LINEAR", -0.5), 3.0);
    assert_eq!(moved("STEP", 2.9), 0.0);
    assert_eq!(moved("STEP", 3.0), 4.0);
}

#[test]
fn cubic_spline() {
    // From 0 leaving at 1 m/s to 1 arriving at 0 m/s, within 2 s; in the middle of a Hermite spline
    // (p0 + p1) / 2 + 2 s * (m0 - m1) / 8.
    #[rustfmt::skip]
    let output = [
        0., 0., 0.,  0., 0., 0.,  1., 0., 0.,
        0., 0., 0.,  1., 0., 0.,  0., 0., 0.,
    ];
    let scene = animated("translation", "CUBICSPLINE", &[0.0, 2.0], &output, 1.0);
    assert!((translation(&scene).x - 0.75).abs() < 1e-12);
}

#[test]
fn rotations_take_the_shorter_way() {
    // From 0 to 90 degrees about z, the second quaternion with the other sign.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let output = [0., 0., 0., 1., 0., 0., -half, -half];
    let scene = animated("rotation", "LINEAR", &[0.0, 1.0], &output, 0.5);
    let turned = scene.instances[0].world_from_mesh.transform_vector3(DVec3::X);
    assert!(turned.distance(DVec3::new(0.5f64.sqrt(), 0.5f64.sqrt(), 0.0)) < 1e-6, "{turned}");
}

/// A triangle bound to two joints; `weights` of the second joint for each corner.
fn skinned(second_joint: Value, weights: [f32; 3]) -> Scene {
    let mut file = File::default();
    let positions = file.floats("VEC3", &TRIANGLE);
    let normals = file.floats("VEC3", &[0., 0., 1., 0., 0., 1., 0., 0., 1.]);
    let joints = json!({ "componentType": 5121, "type": "VEC4", "count": 3 });
    let joints = file.accessor(&[0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0], joints);
    let weights: Vec<f32> = weights.iter().flat_map(|&weight| [1.0 - weight, weight, 0., 0.]).collect();
    let weights = file.floats("VEC4", &weights);
    let mut matrices = glam::Mat4::IDENTITY.to_cols_array().to_vec();
    matrices.extend(glam::Mat4::from_translation(Vec3::new(-10., 0., 0.)).to_cols_array());
    let matrices = file.floats("MAT4", &matrices);
    let rest = json!({
        "scenes": [{ "nodes": [0, 1, 2] }],
        "nodes": [
            { "mesh": 0, "skin": 0, "translation": [100, 100, 100] },
            {},
            second_joint,
        ],
        "meshes": [{ "primitives": [{ "attributes": {
            "POSITION": positions, "NORMAL": normals, "JOINTS_0": joints, "WEIGHTS_0": weights
        } }] }],
        "skins": [{ "joints": [1, 2], "inverseBindMatrices": matrices }],
    });
    let scene = file.load(rest).expect("valid");
    check_whole(&scene);
    scene
}

#[test]
fn skins_blend_joints_and_ignore_the_node() {
    let scene = skinned(json!({ "translation": [10, 0, 4] }), [0.0, 1.0, 0.5]);
    let positions: Vec<_> = scene.meshes[0].vertices.iter().map(|vertex| vertex.position).collect();
    assert_eq!(positions, [Vec3::ZERO, Vec3::new(1.0, 0.0, 4.0), Vec3::new(1.0, 1.0, 2.0)]);
    assert_eq!(scene.instances[0].world_from_mesh, glam::DMat4::IDENTITY);
}

#[test]
fn mirroring_joints_keep_the_outside_outside() {
    let scene = skinned(json!({ "translation": [10, 0, 0], "scale": [1, 1, -1] }), [1.0; 3]);
    let mesh = &scene.meshes[0];
    let [a, b, c] = [0, 1, 2].map(|i| mesh.vertices[mesh.indices[i] as usize].position);
    assert_eq!((b - a).cross(c - a).normalize(), Vec3::NEG_Z);
    assert!(mesh.vertices.iter().all(|vertex| vertex.normal == Vec3::NEG_Z));
}

#[test]
fn far_skins_keep_their_precision() {
    let scene = skinned(json!({ "translation": [1_000_010, 0, 0.001] }), [1.0; 3]);
    let world = scene.instances[0].world_from_mesh;
    let corner = world.transform_point3(scene.meshes[0].vertices[0].position.as_dvec3());
    assert!(corner.distance(DVec3::new(1e6, 0.0, 0.001)) < 1e-6, "{corner}");
}

#[test]
fn morph_targets_add_up() {
    let mut file = File::default();
    let positions = file.floats("VEC3", &TRIANGLE);
    let first = file.floats("VEC3", &[0., 0., 1., 0., 0., 1., 0., 0., 1.]);
    let second = file.floats("VEC3", &[2., 0., 0., 2., 0., 0., 2., 0., 0.]);
    let times = file.floats("SCALAR", &[0.0, 1.0]);
    let output = file.accessor(
        &[0, 0, 255, 255],
        json!({
            "componentType": 5121, "type": "SCALAR", "count": 4, "normalized": true
        }),
    );
    let rest = json!({
        "scenes": [{ "nodes": [0, 1, 2] }],
        "nodes": [{ "mesh": 0 }, { "mesh": 0, "weights": [0, 1] }, { "mesh": 0 }],
        "meshes": [{ "weights": [0.5, 0.5], "primitives": [{
            "attributes": { "POSITION": positions },
            "targets": [{ "POSITION": first }, { "POSITION": second }],
        }] }],
        "animations": [{
            "samplers": [{ "input": times, "output": output }],
            "channels": [{ "sampler": 0, "target": { "node": 2, "path": "weights" } }],
        }],
    });
    let options = LoadOptions { time_s: 0.25, scene_index: None };
    let scene = load_text(&file.text(rest), &options).expect("valid");
    check_whole(&scene);
    let corner = |mesh: usize| scene.meshes[mesh].vertices[0].position;
    assert_eq!(corner(0), Vec3::new(1.0, 0.0, 0.5));
    assert_eq!(corner(1), Vec3::new(2.0, 0.0, 0.0));
    assert_eq!(corner(2), Vec3::new(0.5, 0.0, 0.25));
}
