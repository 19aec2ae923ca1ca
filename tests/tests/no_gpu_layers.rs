//! The law of dependencies: data flows one way, and `use` follows it. Read from the sources themselves.

use macula_tests::data::workspace;
use std::path::{Path, PathBuf};

fn sources(folder: &Path, ending: &[&str]) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a readable folder") {
            let path = entry.expect("a readable entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().and_then(|of| of.to_str()).is_some_and(|of| ending.contains(&of)) {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

/// Fails where code (comments aside) in an engine module names one of the paths.
fn knows_nothing_of(module: &str, unknown: &[&str]) {
    let source = workspace().join("engine/src");
    let mut files = vec![source.join(format!("{module}.rs"))];
    files.retain(|path| path.is_file());
    if source.join(module).is_dir() {
        files.extend(sources(&source.join(module), &["rs"]));
    }
    assert!(!files.is_empty(), "there is no module {module}");
    for path in files {
        let text = std::fs::read_to_string(&path).unwrap();
        for (number, line) in (1..).zip(text.lines()) {
            let code = line.split("//").next().unwrap_or_default();
            for name in unknown {
                assert!(!code.contains(name), "{}:{number} uses {name}", path.display());
            }
        }
    }
}

#[test]
fn modules_use_only_what_lies_before_them() {
    knows_nothing_of("fovea", &["ash::", "crate::gpu", "crate::graph", "crate::passes", "crate::renderer"]);
    knows_nothing_of("scene", &["ash::", "crate::gpu", "crate::graph", "crate::passes", "crate::renderer"]);
    knows_nothing_of("quality", &["ash::", "crate::gpu", "crate::passes", "crate::renderer"]);
    knows_nothing_of("gpu", &["crate::fovea", "crate::graph", "crate::passes", "crate::renderer"]);
    knows_nothing_of("graph", &["crate::passes", "crate::renderer", "crate::scene", "crate::fovea"]);
    knows_nothing_of("passes", &["crate::renderer"]);
}

#[test]
fn trackers_know_no_vulkan_and_no_engine() {
    let manifest = std::fs::read_to_string(workspace().join("trackers/Cargo.toml")).unwrap();
    for name in ["ash", "gpu-allocator", "macula"] {
        let depends = manifest.lines().any(|line| line.split(['=', '.', ' ']).next() == Some(name));
        assert!(!depends, "trackers depend on {name}");
    }
}

#[test]
fn every_pass_has_its_shader_folder() {
    let shaders = workspace().join("shaders");
    let passes = workspace().join("engine/src/passes");
    for folder in std::fs::read_dir(&shaders).unwrap().map(|entry| entry.unwrap().path()) {
        let name = folder.file_name().unwrap().to_string_lossy().into_owned();
        if folder.is_dir() && name != "shared" {
            assert!(passes.join(format!("{name}.rs")).exists(), "shaders/{name} belongs to no pass");
        }
    }
}

#[test]
fn no_file_is_longer_than_can_be_read() {
    for part in ["engine", "trackers", "tools", "tests", "shaders"] {
        for path in sources(&workspace().join(part), &["rs", "glsl", "comp", "frag", "vert"]) {
            let lines = std::fs::read_to_string(&path).unwrap().lines().count();
            assert!(lines <= 600, "{} has {lines} lines", path.display());
        }
    }
}
