//! Small files with known answers, and every file of the shared collection.

mod corpus;
mod geometry;
mod motion;
mod refusals;
mod surfaces;

use std::path::PathBuf;

use serde_json::{Value, json};

use super::{LoadOptions, load};
use crate::error::Result;
use crate::scene::Scene;

/// A glTF file in the making: one buffer, in a data URI.
#[derive(Default)]
struct File {
    buffer: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl File {
    /// Adds bytes as a buffer view of their own.
    fn view(&mut self, bytes: &[u8]) -> usize {
        self.views.push(json!({
            "buffer": 0, "byteOffset": self.buffer.len(), "byteLength": bytes.len()
        }));
        self.buffer.extend(bytes);
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    /// Adds an accessor over `bytes`; `fields` complete it.
    fn accessor(&mut self, bytes: &[u8], mut fields: Value) -> usize {
        fields["bufferView"] = json!(self.view(bytes));
        self.accessors.push(fields);
        self.accessors.len() - 1
    }

    /// Adds an accessor of floats.
    fn floats(&mut self, shape: &str, values: &[f32]) -> usize {
        let lanes = match shape {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let fields = json!({ "componentType": 5126, "type": shape, "count": values.len() / lanes });
        self.accessor(bytemuck::cast_slice(values), fields)
    }

    /// Adds an accessor of indices.
    fn indices(&mut self, values: &[u16]) -> usize {
        let fields = json!({ "componentType": 5123, "type": "SCALAR", "count": values.len() });
        self.accessor(bytemuck::cast_slice(values), fields)
    }

    /// The file's text; `rest` is everything but buffers and accessors.
    fn text(&self, mut rest: Value) -> String {
        let digits: String = self.buffer.iter().map(|byte| format!("%{byte:02x}")).collect();
        let uri = format!("data:application/octet-stream,{digits}");
        rest["asset"] = json!({ "version": "2.0" });
        rest["buffers"] = json!([{ "byteLength": self.buffer.len(), "uri": uri }]);
        rest["bufferViews"] = json!(self.views);
        rest["accessors"] = json!(self.accessors);
        rest.to_string()
    }

    /// Loads the file with `rest`.
    fn load(&self, rest: Value) -> Result<Scene> {
        load_text(&self.text(rest), &LoadOptions::default())
    }

    /// Loads a scene of one node with one mesh of one primitive.
    fn load_primitive(&self, primitive: Value) -> Scene {
        self.load(one_primitive(primitive)).expect("the file is valid")
    }
}

fn one_primitive(primitive: Value) -> Value {
    json!({
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "name": "thing", "primitives": [primitive] }],
    })
}

/// Loads a file `test.gltf` with this text.
fn load_text(text: &str, options: &LoadOptions) -> Result<Scene> {
    load_bytes("test.gltf", text.as_bytes(), options)
}

fn load_bytes(name: &str, bytes: &[u8], options: &LoadOptions) -> Result<Scene> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("room for a small file");
    load(&path, options)
}

/// The corners of a unit square in the plane z = 0, counter-clockwise from the origin.
const SQUARE: [f32; 12] = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];

/// The first three corners of [`SQUARE`].
const TRIANGLE: [f32; 9] = [0., 0., 0., 1., 0., 0., 1., 1., 0.];

/// The shared collection of scenes, where it is there.
fn shared_scenes() -> Option<PathBuf> {
    let shared = match std::env::var_os("MACULA_SHARED") {
        Some(shared) => PathBuf::from(shared),
        None => PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared"),
    };
    let scenes = shared.join("data/scenes");
    if scenes.is_dir() {
        return Some(scenes);
    }
    println!("skipped: no shared scenes; set MACULA_SHARED to the shared folder");
    None
}

/// Panics where a scene is not in the form that its documentation promises.
fn check_whole(scene: &Scene) {
    for mesh in &scene.meshes {
        assert!(!mesh.indices.is_empty() && mesh.indices.len() % 3 == 0, "{}", mesh.name);
        assert!(mesh.indices.iter().all(|&index| (index as usize) < mesh.vertices.len()), "{}", mesh.name);
        for vertex in &mesh.vertices {
            let [x, y, z, sign] = vertex.tangent;
            let tangent = glam::Vec3::new(x, y, z);
            assert!(vertex.position.is_finite() && vertex.uv0.is_finite() && vertex.uv1.is_finite());
            assert!((vertex.normal.length() - 1.0).abs() < 1e-3, "{}: {vertex:?}", mesh.name);
            assert!((tangent.length() - 1.0).abs() < 1e-3, "{}: {vertex:?}", mesh.name);
            assert!(sign == 1.0 || sign == -1.0, "{}: {vertex:?}", mesh.name);
            assert!(
                vertex.position.cmpge(mesh.bounds[0]).all() && vertex.position.cmple(mesh.bounds[1]).all()
            );
        }
    }
    for instance in &scene.instances {
        assert!(instance.mesh < scene.meshes.len() && instance.material < scene.materials.len());
        let matrix = instance.world_from_mesh;
        assert!(matrix.is_finite() && matrix.inverse().is_finite());
        assert_eq!(matrix.row(3), glam::DVec4::W);
    }
    for material in &scene.materials {
        let uses = [
            material.base_color_texture,
            material.metallic_roughness_texture,
            material.normal_texture,
            material.occlusion_texture,
            material.emissive_texture,
        ];
        for used in uses.into_iter().flatten() {
            assert!(used.texture < scene.textures.len() && used.uv_set < 2);
            assert!(used.uv_transform.iter().all(|row| row.is_finite()));
        }
        let numbers = [material.metallic, material.roughness, material.occlusion_strength];
        assert!(numbers.iter().all(|number| (0.0..=1.0).contains(number)));
        assert!(material.base_color.is_finite() && material.emissive.is_finite());
        assert!(material.normal_scale.is_finite());
    }
    for texture in &scene.textures {
        let [width, height] = texture.size;
        assert!(width > 0 && height > 0);
        assert_eq!(texture.rgba8.len(), 4 * width as usize * height as usize);
    }
    for light in &scene.lights {
        assert!(light.intensity.is_finite() && light.intensity.min_element() >= 0.0);
        assert!(light.position.is_finite() && (light.direction.length() - 1.0).abs() < 1e-9);
    }
    for camera in &scene.cameras {
        let axes = glam::DMat3::from_mat4(camera.world_from_view);
        assert!(camera.world_from_view.is_finite() && (axes.determinant() - 1.0).abs() < 1e-9);
    }
    assert!(scene.warnings.len() <= 20 && scene.warnings.iter().all(|line| !line.contains('\n')));
}
