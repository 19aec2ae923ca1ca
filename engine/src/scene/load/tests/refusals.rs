//! Broken and hostile files: one clear line each.

use serde_json::{Value, json};

use super::{File, TRIANGLE, load_bytes, load_text, one_primitive};
use crate::scene::load::{LoadOptions, load};

fn refusal(text: &str) -> String {
    let line = load_text(text, &LoadOptions::default()).expect_err("broken").to_string();
    assert!(!line.contains('\n') && line.contains("test.gltf: "), "{line}");
    line.split_once("test.gltf: ").map(|(_, cause)| cause.to_owned()).unwrap_or_default()
}

/// The refusal of a triangle after `change` to the file.
fn refused_triangle(change: impl Fn(&mut File, &mut Value)) -> String {
    let mut file = File::default();
    let positions = file.floats("VEC3", &TRIANGLE);
    let mut rest = one_primitive(json!({ "attributes": { "POSITION": positions } }));
    change(&mut file, &mut rest);
    refusal(&file.text(rest))
}

#[test]
fn versions_and_extensions() {
    let asset = |asset: Value| json!({ "asset": asset }).to_string();
    assert_eq!(refusal(&asset(json!({ "version": "1.0" }))), "is glTF version \"1.0\"; version 2.0 is read");
    assert_eq!(
        refusal(&asset(json!({ "version": "2.2", "minVersion": "2.1" }))),
        "needs glTF version \"2.1\"; version 2.0 is read"
    );
    assert_eq!(refusal("{}"), "has no \"asset\" and so is not glTF");
    let text = json!({
        "asset": { "version": "2.1" },
        "extensionsUsed": ["KHR_materials_sheen", "KHR_materials_sheen", "KHR_texture_transform"],
    });
    let scene = load_text(&text.to_string(), &LoadOptions::default()).expect("valid");
    assert_eq!(
        scene.warnings,
        ["extension KHR_materials_sheen ignored", "the file has no scene: nothing is drawn"]
    );
    assert_eq!(scene.materials.len(), 1);
    let text = json!({
        "asset": { "version": "2.0" },
        "extensionsRequired": ["KHR_draco_mesh_compression"],
    });
    assert_eq!(
        refusal(&text.to_string()),
        "requires the extension KHR_draco_mesh_compression, which is not supported"
    );
}

#[test]
fn other_kinds_of_file() {
    let refusal = |name: &str, bytes: &[u8]| {
        load_bytes(name, bytes, &LoadOptions::default()).expect_err("broken").to_string()
    };
    assert!(refusal("a.obj", b"v 0 0 0\n").ends_with(
        "a.obj: is not a glTF file, but an .obj file; scenes are .gltf (JSON) or .glb (binary) files"
    ));
    assert!(refusal("a.gltf", b"").ends_with("a.gltf: the file is empty"));
    assert!(refusal("a.glb", b"glTF\x01\0\0\0\x0c\0\0\0").contains("GLB of version 1"));
    assert!(refusal("a.glb", b"glTF\x02\0\0\0\xff\0\0\0").contains("promises 255 bytes and has 12"));
    assert!(refusal("a.glb", b"glTF\x02\0\0\0\x0c\0\0\0").contains("no JSON chunk"));
    let missing = load("nowhere/a.gltf".as_ref(), &LoadOptions::default());
    assert!(missing.expect_err("missing").to_string().contains("nowhere/a.gltf"));
    assert!(load(&std::env::temp_dir(), &LoadOptions::default()).is_err());
}

/// A GLB of these chunks; its header is right.
fn glb(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let mut bytes = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    for (kind, content) in chunks {
        bytes.extend((content.len() as u32).to_le_bytes());
        bytes.extend(*kind);
        bytes.extend(*content);
    }
    let length = bytes.len() as u32;
    bytes[8..12].copy_from_slice(&length.to_le_bytes());
    bytes
}

#[test]
fn chunks_of_binary_files() {
    let mut rest = one_primitive(json!({ "attributes": { "POSITION": 0 } }));
    rest["asset"] = json!({ "version": "2.0" });
    rest["buffers"] = json!([{ "byteLength": 36 }]);
    rest["bufferViews"] = json!([{ "buffer": 0, "byteLength": 36 }]);
    rest["accessors"] = json!([{ "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3 }]);
    let text = rest.to_string();
    let (json, binary) = ((b"JSON", text.as_bytes()), (b"BIN\0", bytemuck::cast_slice(&TRIANGLE)));
    let load = |bytes: &[u8]| load_bytes("a.glb", bytes, &LoadOptions::default());
    let mut whole = glb(&[json, binary]);
    whole.extend(b"what follows");
    assert_eq!(load(&whole).expect("valid").triangle_count(), 1);
    let more = glb(&[json, binary, (b"MORE", b"1234")]);
    assert_eq!(load(&more).expect("valid").triangle_count(), 1);
    let bare = json!({ "asset": { "version": "2.0" } }).to_string();
    assert!(load(&glb(&[(b"JSON", bare.as_bytes()), (b"MORE", b"1234")])).is_ok());
    let refusal = |bytes: &[u8]| load(bytes).expect_err("broken").to_string();
    assert!(refusal(&glb(&[json, (b"MORE", b"1234")])).contains("buffer 0 has no data"));
    assert!(refusal(&glb(&[binary, json])).contains("no JSON chunk"));
    assert!(refusal(&glb(&[(b"MORE", b"1234"), json])).contains("no JSON chunk"));
    assert!(refusal(&glb(&[json, json])).contains("two JSON chunks"));
    let mut cut = glb(&[json, binary]);
    for length in 0..12u8 {
        cut[8..12].copy_from_slice(&[length, 0, 0, 0]);
        assert!(refusal(&cut).contains("fewer than its header has"));
    }
    cut[8..12].copy_from_slice(&[22, 0, 0, 0]);
    assert!(refusal(&cut).contains("reaches beyond the end of the file"));
}

/// Numbers that the crate would cut off to small ones.
#[test]
fn large_numbers_do_not_wrap() {
    let wrapped = |change: &dyn Fn(&mut File, &mut Value)| refused_triangle(change);
    let cause = wrapped(&|_, rest| rest["nodes"][0]["mesh"] = json!(1u64 << 32));
    assert_eq!(cause, "node 0: invalid type: floating point `4294967296.0`, expected an index");
    let cause = wrapped(&|file, _| file.accessors[0]["componentType"] = json!((1u64 << 32) + 5126));
    assert!(cause.starts_with("accessor 0: invalid type"), "{cause}");
    let cause = wrapped(&|_, rest| rest["scene"] = json!(1u64 << 32));
    assert_eq!(cause, "the file's \"scene\" is not an index");
}

#[test]
fn broken_things_are_named() {
    let cause = refused_triangle(|file, _| file.accessors[0] = json!({ "count": 3 }));
    assert_eq!(cause, "accessor 0: missing field `componentType`");
    let cause = refused_triangle(|_, rest| rest["materials"] = json!([{}, { "doubleSided": 1 }]));
    assert_eq!(cause, "material 1: invalid type: integer `1`, expected a boolean");
    let cause = refused_triangle(|_, rest| rest["skins"] = json!("none"));
    assert_eq!(cause, "\"skins\" is not a list");
    let info = json!({ "index": 0, "extensions": { "KHR_texture_transform": { "scale": "a\nb" } } });
    let cause = refused_triangle(|_, rest| {
        rest["materials"] = json!([{ "normalTexture": info }]);
        rest["meshes"][0]["primitives"][0]["material"] = json!(0);
    });
    assert!(cause.starts_with("material 0: KHR_texture_transform: invalid type"), "{cause}");
}

/// What the crate's types demand or check, and no scene needs.
#[test]
fn what_is_not_read_may_be_odd() {
    let mut file = File::default();
    let positions = file.floats("VEC3", &TRIANGLE);
    file.accessors[0]["min"] = json!("none");
    file.views[0]["target"] = json!("anything");
    let rest = json!({
        "scenes": [{ "nodes": [0, 1] }, {}],
        "nodes": [
            { "mesh": 0, "name": 7, "extras": [1e300], "translation": [5_000_000_000i64, 0.001, 4_500_000.123] },
            { "camera": 0, "matrix": null, "extensions": { "EXT_other": 5 } },
        ],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": positions }, "extensions": 3 }] }, {}],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 1, "zfar": "far" }, "orthographic": [] }],
        "animations": [{}, { "channels": [{ "sampler": 0, "target": { "path": "pointer" } }] }],
        "images": [{ "mimeType": 1 }],
        "materials": [{ "extensions": { "KHR_materials_unlit": true } }],
        "skins": [{ "skeleton": "none" }],
        "textures": [{ "extensions": { "EXT_texture_webp": "none" } }],
    });
    let scene = file.load(rest).expect("harmless");
    super::check_whole(&scene);
    assert_eq!(scene.cameras.len(), 1);
    // In JSON's precision, not in that of 32 bits.
    let origin = scene.instances[0].world_from_mesh.w_axis.truncate();
    assert_eq!(origin, glam::DVec3::new(5e9, 0.001, 4_500_000.123));
}

#[test]
fn deep_json_is_refused() {
    let text = format!("{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":{}", "[".repeat(1 << 20));
    assert!(refusal(&text).contains("JSON"));
}

#[test]
fn ranges_and_indices() {
    let cause = refused_triangle(|file, _| file.accessors[0]["count"] = json!(4));
    assert_eq!(
        cause,
        "mesh 0 \"thing\", primitive 0, POSITION: accessor 0 reaches beyond the end of its buffer view"
    );
    let cause = refused_triangle(|file, _| file.accessors[0]["byteOffset"] = json!(u64::MAX));
    assert!(cause.contains("reaches beyond"), "{cause}");
    let cause = refused_triangle(|file, _| file.views[0]["byteLength"] = json!(u64::MAX));
    assert!(cause.contains("buffer view 0 takes"), "{cause}");
    let cause = refused_triangle(|file, _| {
        file.accessors[0] = json!({ "componentType": 5126, "type": "VEC3", "count": 4_000_000_000u32 });
    });
    assert!(cause.contains("beyond 2 GiB"), "{cause}");
    let cause = refused_triangle(|file, _| file.accessors[0]["count"] = json!(u64::MAX));
    assert!(cause.contains("impossible count"), "{cause}");
    let cause =
        refused_triangle(|_, rest| rest["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(7));
    assert!(cause.contains("names accessor 7, but the file has 1"), "{cause}");
    let cause = refused_triangle(|file, rest| {
        rest["meshes"][0]["primitives"][0]["indices"] = json!(file.indices(&[0, 1, 3]));
    });
    assert!(cause.ends_with("indices: 3 is out of range, there are 3 vertices"), "{cause}");
    let cause = refused_triangle(|_, rest| rest["nodes"][0]["mesh"] = json!(1));
    assert_eq!(cause, "node 0 names mesh 1, but the file has 1");
    let cause = refused_triangle(|file, _| file.buffer.truncate(8));
    assert!(cause.contains("buffer view 0 takes"), "{cause}");
}

#[test]
fn numbers_that_are_not_finite() {
    for bad in [f32::NAN, f32::INFINITY] {
        let cause = refused_triangle(|file, rest| {
            let mut positions = TRIANGLE;
            positions[4] = bad;
            let positions = file.floats("VEC3", &positions);
            rest["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(positions);
        });
        assert_eq!(cause, "mesh 0 \"thing\", primitive 0, POSITION: vertex 1 is not finite");
    }
}

#[test]
fn node_graphs_that_are_no_trees() {
    let refused = |nodes: Value| {
        refusal(
            &json!({ "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0] }], "nodes": nodes })
                .to_string(),
        )
    };
    let circle = json!([{}, { "name": "a\nb", "children": [2] }, { "children": [1] }]);
    assert_eq!(refused(circle), "node 1 \"a\\nb\" is its own ancestor");
    assert_eq!(refused(json!([{ "children": [0] }])), "node 0 is its own ancestor");
    let shared = json!([{ "children": [2] }, { "children": [2] }, {}]);
    assert_eq!(refused(shared), "node 2 has two parents, nodes 0 and 1");
    assert_eq!(refused(json!([{ "children": [9] }])), "node 0 names node 9, but the file has 1");
}

#[test]
fn uris_elsewhere_are_refused() {
    for uri in ["/dev/zero", "http://example.org/a.bin", "file:///a.bin"] {
        let text = json!({
            "asset": { "version": "2.0" },
            "scenes": [{ "nodes": [0] }],
            "nodes": [{ "mesh": 0 }],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
            "accessors": [{ "componentType": 5126, "type": "VEC3", "count": 3, "bufferView": 0 }],
            "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
            "buffers": [{ "uri": uri, "byteLength": 36 }],
        });
        let cause = refusal(&text.to_string());
        assert!(cause.contains("only relative paths and data URIs are read"), "{cause}");
    }
}

#[test]
fn work_is_limited() {
    // A hundred thousand morph targets of the same zeros on a million vertices.
    let targets: Vec<_> = (0..100_000).map(|_| json!({ "POSITION": 1 })).collect();
    let cause = refused_triangle(|file, rest| {
        file.accessors.push(json!({ "componentType": 5126, "type": "VEC3", "count": 1_000_000 }));
        let primitive = &mut rest["meshes"][0]["primitives"][0];
        primitive["attributes"]["POSITION"] = json!(1);
        primitive["targets"] = json!(targets);
        rest["meshes"][0]["weights"] = json!(vec![1.0; targets.len()]);
    });
    assert!(cause.contains("unreasonable amount of work"), "{cause}");
}

#[test]
fn objects_are_limited() {
    let text = format!(r#"{{"asset":{{"version":"2.0"}},"materials":[{}{{}}]}}"#, "{},".repeat(2_000_000));
    assert_eq!(refusal(&text), "the JSON holds more objects than could be meant");
}

#[test]
fn warnings_are_few() {
    let names: Vec<_> = (0..100).map(|i| format!("EXT_unknown_{i}")).collect();
    let text = json!({ "asset": { "version": "2.0" }, "extensionsUsed": names });
    let scene = load_text(&text.to_string(), &LoadOptions::default()).expect("valid");
    assert_eq!(scene.warnings.len(), 20);
    assert_eq!(scene.warnings[19], "and 82 more");
}

#[test]
fn times_and_scenes_that_do_not_exist() {
    let text = json!({ "asset": { "version": "2.0" }, "scenes": [{}] }).to_string();
    let time = LoadOptions { time_s: f64::NAN, scene_index: None };
    assert!(load_text(&text, &time).is_err());
    let scene = LoadOptions { time_s: 0.0, scene_index: Some(1) };
    let line = load_text(&text, &scene).expect_err("none").to_string();
    assert!(line.ends_with("the request names scene 1, but the file has 1"), "{line}");
}

/// Files with bytes overwritten at random: anything may come back, but it comes back.
#[test]
fn mutated_files_never_panic() {
    let mut file = File::default();
    let positions = file.floats("VEC3", &super::SQUARE);
    let indices = file.indices(&[0, 1, 2, 0, 2, 3]);
    let text = file.text(json!({
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "children": [1] }, { "camera": 0, "scale": [1, 2, 3] }],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 1, "znear": 1 } }],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": positions, "NORMAL": positions, "COLOR_0": positions },
            "indices": indices, "mode": 4, "material": 0, "targets": [{ "POSITION": positions }],
        }], "weights": [0.5] }],
        "materials": [{ "alphaMode": "MASK", "emissiveFactor": [0, 1, 2] }],
        "animations": [{
            "samplers": [{ "input": indices, "output": positions }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
        }],
    }));
    let mut random = 0x9e37_79b9_7f4a_7c15u64;
    for _ in 0..2000 {
        let mut bytes = text.clone().into_bytes();
        for _ in 0..3 {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let at = (random >> 33) as usize % bytes.len();
            bytes[at] = b"0123456789-.e[]{}\",: fA"[(random >> 20) as usize % 23];
        }
        if let Ok(scene) = load_bytes("test.gltf", &bytes, &LoadOptions::default()) {
            super::check_whole(&scene);
        }
    }
}
