//! The scene as the bytes of a binary glTF file.

use super::HallOptions;
use super::lights::{Kind, Lamp, lights};
use super::materials::{Look, TABLE};
use super::math::look;
use super::mesh::Part;
use super::model::Model;
use super::textures;
use crate::error::{Error, Result};
use glam::{DQuat, DVec3, dvec3};
use rayon::prelude::*;
use serde_json::{Map, Value, json};

/// glTF's numbers for buffer targets and component types.
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;

/// Standing points: name, eye, what is looked at, vertical field of view in radians.
const CAMERAS: [(&str, DVec3, DVec3, f64); 3] = [
    ("main", dvec3(-1.5, 1.7, 23.2), dvec3(0.5, 3.3, -8.0), 1.05),
    ("aisle", dvec3(8.6, 1.7, 22.0), dvec3(8.2, 2.6, -10.0), 1.05),
    ("dais", dvec3(2.6, 2.4, -20.0), dvec3(-0.6, 3.4, -26.0), 1.05),
];

/// The binary chunk, and what the JSON says of it.
#[derive(Default)]
struct Binary {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Binary {
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.bytes.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, bytes: &[u8], target: u32, count: usize, component: u32, kind: &str) -> usize {
        let view = self.view(bytes, Some(target));
        self.accessors
            .push(json!({"bufferView": view, "componentType": component, "count": count, "type": kind}));
        self.accessors.len() - 1
    }

    fn primitive(&mut self, part: &Part) -> Value {
        let count = part.positions.len();
        let position = self.accessor(bytemuck::cast_slice(&part.positions), VERTICES, count, FLOAT, "VEC3");
        let bound = |pick: fn(f32, f32) -> f32| {
            part.positions.iter().copied().reduce(|a, b| std::array::from_fn(|k| pick(a[k], b[k])))
        };
        self.accessors[position]["min"] = json!(bound(f32::min));
        self.accessors[position]["max"] = json!(bound(f32::max));
        let normal = self.accessor(bytemuck::cast_slice(&part.normals), VERTICES, count, FLOAT, "VEC3");
        let tangent = self.accessor(bytemuck::cast_slice(&part.tangents), VERTICES, count, FLOAT, "VEC4");
        let uv = self.accessor(bytemuck::cast_slice(&part.uvs), VERTICES, count, FLOAT, "VEC2");
        let indices = bytemuck::cast_slice(&part.indices);
        let indices = self.accessor(indices, INDICES, part.indices.len(), UNSIGNED_INT, "SCALAR");
        json!({
            "attributes": {"POSITION": position, "NORMAL": normal, "TANGENT": tangent, "TEXCOORD_0": uv},
            "indices": indices,
            "material": part.material as u32,
        })
    }
}

fn material(look: &Look) -> Value {
    let [base, surface, normal, occlusion, emission] =
        look.pictures.map(|picture| picture.map(|picture| json!({"index": picture as u32})));
    let mut metal = json!({
        "baseColorFactor": [look.color[0], look.color[1], look.color[2], 1.0],
        "metallicFactor": look.metallic,
        "roughnessFactor": look.roughness,
    });
    let mut value = json!({"name": look.name, "doubleSided": look.double_sided});
    let put = |value: &mut Value, key: &str, texture: Option<Value>| {
        if let Some(texture) = texture {
            value[key] = texture;
        }
    };
    put(&mut metal, "baseColorTexture", base);
    put(&mut metal, "metallicRoughnessTexture", surface);
    put(&mut value, "normalTexture", normal);
    put(&mut value, "occlusionTexture", occlusion);
    put(&mut value, "emissiveTexture", emission);
    value["pbrMetallicRoughness"] = metal;
    if look.mask {
        value["alphaMode"] = "MASK".into();
        value["alphaCutoff"] = 0.5.into();
    }
    let strength = look.emission.into_iter().fold(0.0, f64::max);
    if strength > 0.0 {
        value["emissiveFactor"] = json!(look.emission.map(|part| part / strength));
        value["extensions"] = json!({"KHR_materials_emissive_strength": {"emissiveStrength": strength}});
    }
    value
}

fn light(lamp: &Lamp, ranged: bool) -> Value {
    let mut value = json!({"name": lamp.name, "color": lamp.color, "intensity": lamp.intensity});
    match lamp.kind {
        Kind::Sun => value["type"] = "directional".into(),
        Kind::Point(range) => {
            value["type"] = "point".into();
            if ranged {
                value["range"] = range.into();
            }
        }
        Kind::Spot(range, [inner, outer]) => {
            value["type"] = "spot".into();
            if ranged {
                value["range"] = range.into();
            }
            value["spot"] = json!({"innerConeAngle": inner, "outerConeAngle": outer});
        }
    }
    value
}

fn node(name: &str, translation: DVec3, rotation: DQuat) -> Value {
    let mut value = json!({"name": name, "translation": translation.to_array()});
    if rotation != DQuat::IDENTITY {
        value["rotation"] = json!(rotation.to_array());
    }
    value
}

/// Nodes of meshes, lights and cameras.
fn nodes(model: &Model, lamps: &[Lamp]) -> Vec<Value> {
    let mut nodes = Vec::new();
    for place in &model.places {
        let mut value = node(model.meshes[place.mesh].name, place.translation, place.rotation);
        value["mesh"] = place.mesh.into();
        nodes.push(value);
    }
    for (number, lamp) in lamps.iter().enumerate() {
        let mut value = node(lamp.name, lamp.position, look(lamp.direction));
        value["extensions"] = json!({"KHR_lights_punctual": {"light": number}});
        nodes.push(value);
    }
    for (number, (name, eye, target, _)) in CAMERAS.iter().enumerate() {
        let mut value = node(name, *eye, look(*target - *eye));
        value["camera"] = number.into();
        nodes.push(value);
    }
    nodes
}

/// The file's bytes.
pub fn file(options: &HallOptions) -> Result<Vec<u8>> {
    let model = Model::new(options);
    let lamps = lights(options.lights, options.seed);
    let pictures: Vec<Vec<u8>> = (0..textures::COUNT)
        .into_par_iter()
        .map(|k| textures::png(k, options.seed))
        .collect::<Result<_>>()?;
    let mut binary = Binary::default();
    let mut meshes = Vec::new();
    for mesh in &model.meshes {
        let primitives: Vec<Value> = mesh.parts.iter().map(|part| binary.primitive(part)).collect();
        meshes.push(json!({"name": mesh.name, "primitives": primitives}));
    }
    let mut images = Vec::new();
    for (number, bytes) in pictures.iter().enumerate() {
        let view = binary.view(bytes, None);
        images.push(json!({"name": textures::name(number), "bufferView": view, "mimeType": "image/png"}));
    }
    let sources: Vec<Value> = (0..images.len()).map(|k| json!({"sampler": 0, "source": k})).collect();
    let nodes = nodes(&model, &lamps);
    let cameras = CAMERAS.map(|(name, _, _, yfov)| {
        json!({"name": name, "type": "perspective", "perspective": {"yfov": yfov, "znear": 0.05}})
    });
    binary.bytes.resize(binary.bytes.len().next_multiple_of(4), 0);
    let mut root = Map::new();
    let mut put = |key: &str, value: Value| root.insert(key.to_owned(), value);
    put("asset", json!({"version": "2.0", "generator": "macula scene hall"}));
    put("extensionsUsed", json!(["KHR_lights_punctual", "KHR_materials_emissive_strength"]));
    put("scene", json!(0));
    put("scenes", json!([{"name": "hall", "nodes": (0..nodes.len()).collect::<Vec<_>>()}]));
    put("nodes", nodes.into());
    put("meshes", meshes.into());
    put("materials", TABLE.iter().map(material).collect());
    put("textures", sources.into());
    put("images", images.into());
    // Linear within and between the levels; repeated on both axes.
    put("samplers", json!([{"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}]));
    put("cameras", json!(cameras));
    let all: Vec<Value> = lamps.iter().map(|lamp| light(lamp, options.ranged_lights)).collect();
    put("extensions", json!({"KHR_lights_punctual": {"lights": all}}));
    put("accessors", std::mem::take(&mut binary.accessors).into());
    put("bufferViews", std::mem::take(&mut binary.views).into());
    put("buffers", json!([{"byteLength": binary.bytes.len()}]));
    container(&Value::Object(root), &binary.bytes)
}

/// The two chunks behind the file's head.
fn container(root: &Value, binary: &[u8]) -> Result<Vec<u8>> {
    let too_much = |cause: &dyn std::fmt::Display| Error::Setting(format!("hall: {cause}"));
    let mut text = serde_json::to_vec(root).map_err(|cause| too_much(&cause))?;
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + text.len() + 8 + binary.len();
    let length32 = u32::try_from(length).map_err(|_| too_much(&"more than 4 GiB"))?;
    let mut bytes = Vec::with_capacity(length);
    bytes.extend_from_slice(b"glTF");
    // Each chunk is shorter than the whole, whose length fits.
    for word in [2, length32, text.len() as u32] {
        bytes.extend_from_slice(&word.to_le_bytes());
    }
    bytes.extend_from_slice(b"JSON");
    bytes.extend_from_slice(&text);
    bytes.extend_from_slice(&(binary.len() as u32).to_le_bytes());
    bytes.extend_from_slice(b"BIN\0");
    bytes.extend_from_slice(binary);
    Ok(bytes)
}
