//! From the file's text to the `gltf` crate's own types, [`gltf::json`].
//!
//! Those types are what everything here reads; their indices may point nowhere, and an unknown
//! name or code is [`Checked::Invalid`](gltf::json::validation::Checked), so that one broken thing
//! that the scene never uses does not cost the whole file. The crate's validation is not asked: it
//! looks a primitive's positions up without a check, and refuses files for bounds that nobody reads.
//!
//! The types are stricter than they need to be here, and cut numbers off to 32 bits. So the JSON is
//! [mended](mend) before it is turned into them.

use gltf::json::{self, Index, Node, Root};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::context::Outcome;
use super::document::KNOWN_EXTENSIONS;

/// The index of what a file leaves out where the crate's types demand one; the crate does the same
/// for textures without an image. No list is as long.
pub const NO_INDEX: u32 = u32::MAX;

/// What may be larger than 32 bits hold, and is not cut off by the crate.
const LONG_NUMBERS: [&str; 4] = ["byteLength", "byteOffset", "byteStride", "count"];

/// A file's JSON.
pub struct Parsed {
    /// In the crate's types.
    pub root: Root,
    /// Where nodes that say so put their origin: in JSON's precision, since the crate's 32 bits
    /// would move a building in map coordinates by half a metre.
    pub origins: Vec<Option<[f64; 3]>>,
}

/// Reads the whole; `text` is of bounded size and not yet known to be JSON.
pub fn parse(text: &[u8]) -> Outcome<Parsed> {
    let value = mended(text)?;
    let origins = list(&value, "nodes").iter().map(origin).collect();
    match serde_json::from_value(value) {
        Ok(root) => Ok(Parsed { root, origins }),
        // The file is read again to find out which part it is, so that sound files, which may hold
        // large data URIs, are never kept twice.
        Err(error) => Err(culprit(&mended(text)?).unwrap_or_else(|| {
            // Only the lists are searched.
            format!("the JSON is not glTF 2.0: {}", reword(&error))
        })),
    }
}

/// The index that `index` stands for, or nothing where the file has none.
pub fn optional<T>(index: Index<T>) -> Option<usize> {
    Some(index.value()).filter(|&value| value != NO_INDEX as usize)
}

fn mended(text: &[u8]) -> Outcome<Value> {
    let mut value =
        serde_json::from_slice(text).map_err(|error| format!("the JSON cannot be read: {error}"))?;
    check_version(&value)?;
    tidy(&mut value);
    if let Value::Object(root) = &mut value {
        mend(root);
    }
    Ok(value)
}

/// Only glTF 2.x; must come before anything else, because glTF 1.0 differs everywhere.
fn check_version(root: &Value) -> Outcome<()> {
    let asset = root.get("asset").ok_or("has no \"asset\" and so is not glTF")?;
    let version = asset.get("version").and_then(Value::as_str).ok_or("does not say its glTF version")?;
    let numbers = |text: &str| {
        let (major, minor) = text.split_once('.')?;
        Some((major.parse::<u32>().ok()?, minor.parse::<u32>().ok()?))
    };
    let short = |text: &str| -> String { text.chars().take(20).flat_map(char::escape_debug).collect() };
    match numbers(version) {
        Some((2, _)) => {}
        _ => return Err(format!("is glTF version \"{}\"; version 2.0 is read", short(version))),
    }
    match asset.get("minVersion").filter(|least| !least.is_null()) {
        Some(least) => match least.as_str() {
            Some(text) if numbers(text).is_some_and(|least| least <= (2, 0)) => Ok(()),
            Some(text) => Err(format!("needs glTF version \"{}\"; version 2.0 is read", short(text))),
            None => Err("does not say in words which glTF version it needs".to_owned()),
        },
        None => Ok(()),
    }
}

/// What holds everywhere: takes out nulls, names that are no text, and what is never read
/// (`extras`, unknown extensions); keeps numbers within the 32 bits to which the crate would cut
/// them. JSON is nested 128 deep at most, which the parser has seen to.
fn tidy(value: &mut Value) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(tidy),
        Value::Object(fields) => {
            fields.retain(|key, value| match key.as_str() {
                "extras" => false,
                "name" => value.is_string(),
                "extensions" => value.is_object(),
                _ => !value.is_null(),
            });
            if let Some(Value::Object(extensions)) = fields.get_mut("extensions") {
                extensions
                    .retain(|name, value| KNOWN_EXTENSIONS.contains(&name.as_str()) && !value.is_null());
            }
            let short = |(key, _): &(&String, &mut Value)| !LONG_NUMBERS.contains(&key.as_str());
            fields.iter_mut().filter(short).for_each(|(_, value)| tidy(value));
        }
        Value::Number(number) => match (number.as_u64(), number.as_f64()) {
            // A fraction's type means the same number where a number is wanted; where an index or
            // a code is, 4294967296 is refused instead of read as 0.
            (Some(whole), _) if whole > u64::from(u32::MAX) => *value = (whole as f64).into(),
            (None, Some(float)) if float.abs() > f64::from(f32::MAX) => {
                *value = f64::from(f32::MAX).copysign(float).into();
            }
            _ => {}
        },
        Value::Null | Value::Bool(_) | Value::String(_) => {}
    }
}

/// Fills in what files leave out harmlessly, and takes out what the crate checks and nobody reads.
fn mend(root: &mut Map<String, Value>) {
    for asset in objects(root.get_mut("asset")) {
        asset.retain(|key, _| key == "version" || key == "minVersion");
    }
    each(root, "accessors", |accessor| without(accessor, &["min", "max"]));
    each(root, "animations", |animation| {
        fill(animation, "samplers", || Value::Array(Vec::new()));
        fill(animation, "channels", || Value::Array(Vec::new()));
        each(animation, "channels", |channel| {
            for target in objects(channel.get_mut("target")) {
                fill(target, "node", || NO_INDEX.into());
            }
        });
    });
    each(root, "bufferViews", |view| without(view, &["target"]));
    each(root, "cameras", |camera| {
        without(camera, &["orthographic"]);
        fill(camera, "type", || "".into());
        for perspective in objects(camera.get_mut("perspective")) {
            without(perspective, &["aspectRatio", "zfar", "znear"]);
            fill(perspective, "znear", || 0.into());
            fill(perspective, "yfov", || 0.into());
        }
    });
    each(root, "images", |image| without(image, &["mimeType"]));
    each(root, "materials", |material| {
        for extensions in objects(material.get_mut("extensions")) {
            if let Some(unlit) = extensions.get_mut("KHR_materials_unlit") {
                *unlit = Value::Object(Map::new());
            }
        }
    });
    each(root, "meshes", |mesh| {
        fill(mesh, "primitives", || Value::Array(Vec::new()));
        each(mesh, "primitives", |primitive| fill(primitive, "attributes", || Value::Object(Map::new())));
    });
    each(root, "scenes", |scene| fill(scene, "nodes", || Value::Array(Vec::new())));
    each(root, "skins", |skin| {
        without(skin, &["skeleton"]);
        fill(skin, "joints", || Value::Array(Vec::new()));
    });
    for extensions in objects(root.get_mut("extensions")) {
        for lights in objects(extensions.get_mut("KHR_lights_punctual")) {
            fill(lights, "lights", || Value::Array(Vec::new()));
            each(lights, "lights", |light| fill(light, "type", || "".into()));
        }
    }
}

/// `value`'s fields where it is an object; the crate says what is wrong with it where it is not.
fn objects(value: Option<&mut Value>) -> impl Iterator<Item = &mut Map<String, Value>> {
    value.and_then(Value::as_object_mut).into_iter()
}

fn each(fields: &mut Map<String, Value>, key: &str, change: impl Fn(&mut Map<String, Value>)) {
    let items = fields.get_mut(key).and_then(Value::as_array_mut);
    items.into_iter().flatten().filter_map(Value::as_object_mut).for_each(change);
}

fn fill(fields: &mut Map<String, Value>, key: &str, value: impl Fn() -> Value) {
    fields.entry(key).or_insert_with(value);
}

fn without(fields: &mut Map<String, Value>, keys: &[&str]) {
    for key in keys {
        fields.remove(*key);
    }
}

fn list<'a>(root: &'a Value, key: &str) -> &'a [Value] {
    root.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

/// Numbers 12 to 14 of a node's matrix, or else its translation.
fn origin(node: &Value) -> Option<[f64; 3]> {
    let numbers = match node.get("matrix") {
        Some(matrix) => matrix.as_array()?.get(12..15)?,
        None => node.get("translation")?.as_array()?,
    };
    let number = |i: usize| numbers.get(i).and_then(Value::as_f64);
    Some([number(0)?, number(1)?, number(2)?])
}

/// The first thing in the file that the crate's types cannot hold, and why.
fn culprit(root: &Value) -> Option<String> {
    if root.get("scene").is_some_and(|scene| !scene.is_u64()) {
        return Some("the file's \"scene\" is not an index".to_owned());
    }
    let empty = Value::Null;
    let lights =
        root.get("extensions").and_then(|extensions| extensions.get("KHR_lights_punctual")).unwrap_or(&empty);
    broken::<json::Accessor>(root, "accessors", "accessor")
        .or_else(|| broken::<json::Animation>(root, "animations", "animation"))
        .or_else(|| broken::<json::Buffer>(root, "buffers", "buffer"))
        .or_else(|| broken::<json::buffer::View>(root, "bufferViews", "buffer view"))
        .or_else(|| broken::<json::Camera>(root, "cameras", "camera"))
        .or_else(|| broken::<json::Image>(root, "images", "image"))
        .or_else(|| broken::<json::Material>(root, "materials", "material"))
        .or_else(|| broken::<json::Mesh>(root, "meshes", "mesh"))
        .or_else(|| broken::<Node>(root, "nodes", "node"))
        .or_else(|| broken::<json::texture::Sampler>(root, "samplers", "sampler"))
        .or_else(|| broken::<json::Scene>(root, "scenes", "scene"))
        .or_else(|| broken::<json::Skin>(root, "skins", "skin"))
        .or_else(|| broken::<json::Texture>(root, "textures", "texture"))
        .or_else(|| broken::<json::extensions::scene::khr_lights_punctual::Light>(lights, "lights", "light"))
}

fn broken<T: DeserializeOwned>(root: &Value, key: &str, kind: &str) -> Option<String> {
    let items = match root.get(key)? {
        Value::Array(items) => items,
        _ => return Some(format!("\"{key}\" is not a list")),
    };
    let error = |(index, item): (usize, &Value)| {
        T::deserialize(item).err().map(|error| format!("{kind} {index}: {}", reword(&error)))
    };
    items.iter().enumerate().find_map(error)
}

/// The crate's word on a broken value, without the names of its types and of bounded length.
pub fn reword(error: &serde_json::Error) -> String {
    let text = error.to_string();
    let mut words = Vec::new();
    let mut parts = text.split(' ').peekable();
    while let Some(part) = parts.next() {
        match part {
            "struct" => {
                // "struct Sampler", of which only the kind of value is of interest.
                parts.next();
                words.push("an object");
            }
            "f32" => words.push("a number"),
            "u32" | "u64" | "usize" => words.push("a whole number from 0 on"),
            _ => words.push(part),
        }
    }
    let text = words.join(" ").replace("index into child of root", "an index");
    text.chars().take(200).map(|letter| if letter.is_control() { ' ' } else { letter }).collect()
}
