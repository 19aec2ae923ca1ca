//! Scene files with numbers that are none: refused in one line that names the file, or mended.

use super::super::family::{Case, Family, Finding, Part, Place};
use crate::failure::Failure;
use macula::scene::Scene;
use macula::scene::load::{LoadOptions, load};
use serde_json::{Value, json};

pub fn families() -> Vec<Family> {
    vec![Family {
        name: "files",
        what: "a glTF file with NaN or infinite numbers is refused in one line, or mended with a warning",
        part: Part::Shading,
        place: Place::Cpu,
        bound: 0.0,
        unit: "values",
        cases,
    }]
}

/// What becomes of a file.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fate {
    Refused,
    /// Loaded with finite numbers only, and a warning.
    Mended,
    /// Loaded with finite numbers only: colours, which are clamped in any case.
    Clamped,
}

const BAD: [(&str, f32); 3] = [("nan", f32::NAN), ("inf", f32::INFINITY), ("minus-inf", f32::NEG_INFINITY)];

/// Vertex attributes: name, components, a triangle's good values, what becomes of bad ones.
const ATTRIBUTES: [(&str, usize, [f32; 12], Fate); 5] = [
    ("POSITION", 3, [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0], Fate::Refused),
    ("NORMAL", 3, [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], Fate::Mended),
    ("TANGENT", 4, [1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0], Fate::Mended),
    ("TEXCOORD_0", 2, [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], Fate::Mended),
    ("COLOR_0", 4, [1.0; 12], Fate::Clamped),
];

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (attribute, (name, ..)) in ATTRIBUTES.iter().enumerate() {
        for (bad_name, bad) in BAD {
            let fate = ATTRIBUTES[attribute].3;
            let id = format!("{}-{bad_name}", name.to_lowercase().replace('_', "-"));
            cases.push(Case::new(id, true, move |_| check(&file(Some((attribute, bad)), None), fate)));
        }
    }
    let numbers: [(&'static str, &'static str); 6] = [
        ("node-translation", "\"nodes\":[{\"mesh\":0,\"translation\":[1e999,0,0]}]"),
        ("node-matrix", "\"nodes\":[{\"mesh\":0,\"matrix\":[1,0,0,0,0,1e999,0,0,0,0,1,0,0,0,0,1]}]"),
        ("node-scale-nan", "\"nodes\":[{\"mesh\":0,\"scale\":[NaN,1,1]}]"),
        ("node-translation-infinity", "\"nodes\":[{\"mesh\":0,\"translation\":[Infinity,0,0]}]"),
        ("emissive-factor", "\"materials\":[{\"emissiveFactor\":[1e999,0,0]}]"),
        (
            "light-intensity",
            "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\",\"intensity\":1e999}]}}",
        ),
    ];
    cases.extend(
        numbers.map(|(name, text)| {
            Case::new(name, true, move |_| check(&file(None, Some(text)), Fate::Refused))
        }),
    );
    cases.push(Case::new("sound", true, |_| sound()));
    cases
}

/// A triangle's file; with a bad number in an attribute, or a member replaced by text that need not be JSON.
fn file(bad: Option<(usize, f32)>, replaced: Option<&str>) -> String {
    let (mut bytes, mut views, mut accessors) = (Vec::new(), Vec::new(), Vec::new());
    let mut attributes = serde_json::Map::new();
    for (index, (name, components, values, _)) in ATTRIBUTES.iter().enumerate() {
        let mut values = *values;
        if let Some((_, bad)) = bad.filter(|(attribute, _)| *attribute == index) {
            // The second vertex's second component.
            values[components + 1] = bad;
        }
        let used = &values[..3 * components];
        views.push(json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": 4 * used.len() }));
        let kind = ["SCALAR", "SCALAR", "VEC2", "VEC3", "VEC4"][*components];
        accessors.push(json!({ "bufferView": index, "componentType": 5126, "type": kind, "count": 3 }));
        attributes.insert((*name).to_owned(), json!(index));
        bytes.extend(used.iter().flat_map(|value| value.to_le_bytes()));
    }
    let data = base64::encode(&bytes);
    let uri = format!("data:application/octet-stream;base64,{data}");
    let mut document = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": attributes, "material": 0 }] }],
        "materials": [{}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{ "byteLength": bytes.len(), "uri": uri }],
    });
    let Some((replaced, member)) = replaced.and_then(|text| Some((text, text.split('"').nth(1)?))) else {
        return document.to_string();
    };
    if let Value::Object(members) = &mut document {
        members.remove(member);
    }
    let rest = document.to_string();
    format!("{{{replaced},{}", rest.strip_prefix('{').unwrap_or(&rest))
}

fn check(text: &str, fate: Fate) -> Result<Finding, Failure> {
    let mut finding = Finding::default();
    let folder =
        tempfile::tempdir().map_err(|error| Failure::environment(format!("no temporary folder: {error}")))?;
    let path = folder.path().join("hard.gltf");
    std::fs::write(&path, text).map_err(|error| macula::Error::io(&path, error))?;
    match load(&path, &LoadOptions::default()) {
        Err(error) => {
            let line = error.to_string();
            finding.holds(fate == Fate::Refused, || format!("refused: {line}"));
            let one_line = !line.contains('\n') && line.contains("hard.gltf");
            finding.holds(one_line, || format!("the error is not one line about the file: {line}"));
        }
        Ok(scene) => {
            finding.holds(fate != Fate::Refused, || "loaded".to_owned());
            let told = fate != Fate::Mended || !scene.warnings.is_empty();
            finding.holds(told, || "mended without a warning".to_owned());
            all_finite(&scene, &mut finding);
        }
    }
    Ok(finding)
}

/// The file that the others are changed from loads as it is.
fn sound() -> Result<Finding, Failure> {
    let mut finding = Finding::default();
    let folder =
        tempfile::tempdir().map_err(|error| Failure::environment(format!("no temporary folder: {error}")))?;
    let path = folder.path().join("sound.gltf");
    std::fs::write(&path, file(None, None)).map_err(|error| macula::Error::io(&path, error))?;
    let scene = load(&path, &LoadOptions::default())?;
    finding.holds(scene.triangle_count() == 1, || format!("{} triangles", scene.triangle_count()));
    finding.holds(scene.warnings.is_empty(), || scene.warnings.join("; "));
    all_finite(&scene, &mut finding);
    Ok(finding)
}

fn all_finite(scene: &Scene, finding: &mut Finding) {
    let mut bad = 0;
    for vertex in scene.meshes.iter().flat_map(|mesh| &mesh.vertices) {
        let tangent = vertex.tangent.iter().all(|value| value.is_finite());
        let whole =
            vertex.position.is_finite() && vertex.normal.is_finite() && tangent && vertex.uv0.is_finite();
        bad += u32::from(!whole);
    }
    for instance in &scene.instances {
        bad += u32::from(!instance.world_from_mesh.is_finite());
    }
    finding.error(f64::from(bad), || "vertices and transforms".to_owned());
    finding.non_finite += u64::from(bad);
}
