//! Where the shared scenes and oracles lie. Tests that need them say so and pass where they are absent.

use std::path::{Path, PathBuf};

/// The workspace's folder.
#[must_use]
pub fn workspace() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.parent().unwrap_or(package).to_owned()
}

/// A file or folder of the shared data: in `MACULA_SHARED`, or else in `shared` beside the workspace.
/// `None`, with a printed line, where it is absent.
#[must_use]
pub fn shared(relative: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("MACULA_SHARED").map(PathBuf::from);
    let folders = match folder {
        Some(folder) => vec![folder],
        None => workspace().ancestors().take(3).skip(1).map(|parent| parent.join("shared")).collect(),
    };
    let found = folders.iter().map(|folder| folder.join(relative)).find(|path| path.exists());
    if found.is_none() {
        println!("skipped: no {relative} in the shared data; MACULA_SHARED says where that lies");
    }
    found
}

/// A recording that the project carries, by its path below `trackers/tests/data`.
#[must_use]
pub fn recording(relative: &str) -> String {
    workspace().join("trackers/tests/data").join(relative).to_string_lossy().into_owned()
}

/// All glTF files below a folder, in order.
///
/// # Panics
/// Where the folder cannot be read.
#[must_use]
pub fn gltf_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a readable folder") {
            let path = entry.expect("a readable entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "glb" || extension == "gltf") {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}
