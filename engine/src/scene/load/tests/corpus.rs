//! Every file of the shared collection: loaded, or refused in one line that names it.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::{check_whole, shared_scenes};
use crate::scene::load::{LoadOptions, load};

/// Files outside of `negative/` are sound; these of `negative/` are at most unusual.
const HARMLESS: [&str; 7] = [
    "negative/assimp/BoxBadNormals-glTF-Binary/BoxBadNormals.glb",
    "negative/assimp/BoxTexcoords-glTF/boxTexcoords.gltf",
    "negative/assimp/TestNoRootNode/NoScene.gltf",
    "negative/assimp/TestNoRootNode/SceneWithoutNodes.gltf",
    "negative/gltf-rs/tests/box_sparse.glb",
    "negative/trimesh/nested.glb",
    "negative/trimesh/no_indices_3storybuilding.glb",
];

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).expect("a readable folder");
    for entry in entries {
        let path = entry.expect("a readable entry").path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "gltf" || extension == "glb") {
            files.push(path);
        }
    }
}

#[test]
fn every_shared_scene_loads_or_is_refused_in_one_line() {
    let Some(scenes) = shared_scenes() else {
        return;
    };
    let mut files = Vec::new();
    collect(&scenes, &mut files);
    files.sort();
    let mut refused = 0;
    for path in &files {
        let name = path.strip_prefix(&scenes).expect("found there").display().to_string();
        let start = Instant::now();
        let outcome = load(path, &LoadOptions { time_s: 0.3, scene_index: None });
        let took = start.elapsed();
        assert!(took < Duration::from_secs(10), "{name} took {took:?}");
        match outcome {
            Ok(scene) => {
                check_whole(&scene);
                println!(
                    "ok      {:5.0} ms {:>8} triangles {:>3} textures  {name}  {:?}",
                    took.as_secs_f64() * 1e3,
                    scene.triangle_count(),
                    scene.textures.len(),
                    scene.warnings
                );
            }
            Err(error) => {
                let line = error.to_string();
                let file_name = path.file_name().expect("a file").to_string_lossy();
                assert!(!line.contains('\n') && line.contains(&*file_name), "{line}");
                assert!(line.len() < 600, "{line}");
                let sound = !name.starts_with("negative/") || HARMLESS.contains(&name.as_str());
                assert!(!sound, "{name} should load: {line}");
                println!(
                    "refused {:5.0} ms {}",
                    took.as_secs_f64() * 1e3,
                    line.replace(&path.display().to_string(), &name)
                );
                refused += 1;
            }
        }
    }
    println!("{} files, {refused} refused", files.len());
}

/// Copies what a document at `path` refers to.
fn copy_neighbours(root: &Value, path: &Path, folder: &Path) {
    let things = |kind: &str| root[kind].as_array().cloned().unwrap_or_default();
    for thing in things("buffers").into_iter().chain(things("images")) {
        let uri = thing["uri"].as_str().filter(|uri| !uri.is_empty() && !uri.contains(['/', ':']));
        if let Some(uri) = uri.filter(|uri| path.with_file_name(uri).is_file()) {
            std::fs::copy(path.with_file_name(uri), folder.join(uri)).expect("a copy");
        }
    }
}

/// The validator's files mostly have no scene, so that nothing of them is read: here all of their
/// meshes are drawn, and all of their materials used.
#[test]
fn broken_files_without_a_scene_do_no_harm_in_one() {
    let Some(scenes) = shared_scenes() else {
        return;
    };
    let mut files = Vec::new();
    collect(&scenes.join("negative"), &mut files);
    let (mut loaded, mut refused) = (0, 0);
    for path in files {
        let Ok(Ok(mut root)) = std::fs::read(&path).map(|b| serde_json::from_slice::<Value>(&b)) else {
            continue;
        };
        let meshes = root["meshes"].as_array().map_or(0, Vec::len);
        let materials = root["materials"].as_array().map_or(0, Vec::len);
        if !root["scenes"].is_null() || !root["nodes"].is_null() || meshes + materials == 0 {
            continue;
        }
        root["nodes"] = (0..meshes).map(|mesh| json!({ "mesh": mesh })).collect();
        if meshes == 0 && root["accessors"].is_null() && root["bufferViews"].is_null() {
            // A triangle for each material; `buffers` only ever serve images in these files.
            let uri = format!("data:;base64,{}", "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA");
            let triangle = |material: usize| json!({ "primitives": [{ "attributes": { "POSITION": 0 }, "material": material }] });
            root["meshes"] = (0..materials).map(triangle).collect();
            root["nodes"] = (0..materials).map(|mesh| json!({ "mesh": mesh })).collect();
            root["accessors"] =
                json!([{ "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3 }]);
            root["bufferViews"] = json!([{ "buffer": 0, "byteLength": 36 }]);
            root["buffers"] = json!([{ "uri": uri, "byteLength": 36 }]);
        }
        let nodes = root["nodes"].as_array().map_or(0, Vec::len);
        root["scenes"] = json!([{ "nodes": (0..nodes).collect::<Vec<_>>() }]);
        let name = path.strip_prefix(&scenes).expect("found there").display();
        let folder = tempfile::tempdir().expect("a temporary folder");
        copy_neighbours(&root, &path, folder.path());
        let copy = folder.path().join("test.gltf");
        std::fs::write(&copy, root.to_string()).expect("room for a small file");
        match load(&copy, &LoadOptions { time_s: 0.3, scene_index: None }) {
            Ok(scene) => {
                check_whole(&scene);
                println!("drawn   {name} {} instances {:?}", scene.instances.len(), scene.warnings);
                loaded += 1;
            }
            Err(error) => {
                assert!(!error.to_string().contains('\n'));
                println!("refused {name} {}", error.to_string().split_once("test.gltf").map_or("", |s| s.1));
                refused += 1;
            }
        }
    }
    println!("{loaded} drawn, {refused} refused");
}

/// The tangents that a file brings and those that are made for it agree: most importantly in the
/// sign of the bitangent.
#[test]
fn generated_tangents_agree_with_given_ones() {
    let Some(scenes) = shared_scenes() else {
        return;
    };
    let path = scenes.join("water-bottle/WaterBottle.gltf");
    let text = std::fs::read_to_string(&path).expect("a readable file");
    let stripped = text.replace("\"TANGENT\"", "\"_TANGENT\"");
    assert_ne!(text, stripped, "the file has tangents");
    let root: Value = serde_json::from_str(&stripped).expect("JSON");
    let folder = tempfile::tempdir().expect("a temporary folder");
    copy_neighbours(&root, &path, folder.path());
    let bare = folder.path().join("bare.gltf");
    std::fs::write(&bare, stripped).expect("room for a small file");
    let given = load(&path, &LoadOptions::default()).expect("loads");
    let made = load(&bare, &LoadOptions::default()).expect("loads");
    let (given, made) = (&given.meshes[0], &made.meshes[0]);
    assert_eq!(given.indices.len(), made.indices.len());
    let agrees = |&(&a, &b): &(&u32, &u32)| {
        let (a, b) = (given.vertices[a as usize].tangent, made.vertices[b as usize].tangent);
        a[3] == b[3] && a[..3].iter().zip(&b[..3]).map(|(a, b)| a * b).sum::<f32>() > 0.9
    };
    let agreeing = given.indices.iter().zip(&made.indices).filter(agrees).count();
    let share = agreeing as f64 / given.indices.len() as f64;
    assert!(share > 0.95, "{share}");
}
