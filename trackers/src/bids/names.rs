//! Which two files a recording consists of, and which side-cars apply to it.

use super::sidecar::folder_of;
use std::path::{Path, PathBuf};

/// Folders above a data set's file in which side-cars may lie: session, subject, root and one to spare.
const LEVELS: usize = 4;
/// The most entries of a folder that are looked at for side-cars.
const MAX_ENTRIES: usize = 100_000;

/// The data file and the side-car that are written for a name. `NAME.tsv.gz` and `NAME.json` are taken as
/// they are; to any other name `_recording-eye3_physio` is added, unless it ends in `_physio` already.
#[must_use]
pub fn paths(path: &Path) -> (PathBuf, PathBuf) {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let stem = match stem(&name) {
        Some(stem) => stem.to_owned(),
        None if name.ends_with("_physio") => name.into_owned(),
        None => format!("{name}_recording-eye3_physio"),
    };
    (path.with_file_name(format!("{stem}.tsv.gz")), path.with_file_name(format!("{stem}.json")))
}

/// The name without the ending of a data file or side-car.
pub fn stem(name: &str) -> Option<&str> {
    [".tsv.gz", ".tsv", ".json"].into_iter().find_map(|ending| name.strip_suffix(ending))
}

/// All side-cars of `suffix` (as in `physio`) that apply to a data file, the most general first: those of
/// its folder, and in a data set (a folder with `dataset_description.json`) of the folders up to it,
/// whose entities (as in `task-rest`) all are the file's.
pub fn sidecars(data: &Path, suffix: &str) -> Vec<PathBuf> {
    let name = data.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let stem = stem(&name).unwrap_or(&name);
    let entities: Vec<&str> = stem.split('_').collect();
    let folder = folder_of(data);
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    let root =
        folder.ancestors().take(LEVELS).position(|folder| folder.join("dataset_description.json").exists());
    let mut found = Vec::new();
    for (depth, folder) in folder.ancestors().take(root.unwrap_or(0) + 1).enumerate() {
        let Ok(entries) = folder.read_dir() else { continue };
        for entry in entries.take(MAX_ENTRIES).flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let Some(other) = name.strip_suffix(".json") else { continue };
            let mut parts: Vec<&str> = other.split('_').collect();
            let own = depth == 0 && other == stem && stem.ends_with(suffix);
            let applies = parts.pop() == Some(suffix) && parts.iter().all(|part| entities.contains(part));
            if own || applies {
                found.push((std::cmp::Reverse(depth), parts.len(), entry.path()));
            }
        }
    }
    found.sort();
    found.into_iter().map(|(_, _, path)| path).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_pairs() {
        let pair = |name: &str| {
            let (data, sidecar) = paths(Path::new(name));
            (data.display().to_string(), sidecar.display().to_string())
        };
        let both = |stem: &str| (format!("{stem}.tsv.gz"), format!("{stem}.json"));
        assert_eq!(pair("a/me"), both("a/me_recording-eye3_physio"));
        assert_eq!(pair("a/sub-1_physio"), both("a/sub-1_physio"));
        assert_eq!(pair("a/x.tsv.gz"), both("a/x"));
        assert_eq!(pair("x.json"), both("x"));
        assert_eq!(pair("v1.5"), both("v1.5_recording-eye3_physio"));
    }

    #[test]
    fn sidecars_are_inherited_by_entities_and_folders() {
        let root = tempfile::tempdir().expect("a folder");
        let folder = root.path().join("sub-01/beh");
        std::fs::create_dir_all(&folder).expect("folders");
        let touch = |path: PathBuf| std::fs::write(path, "{}").expect("a file");
        touch(root.path().join("dataset_description.json"));
        touch(root.path().join("task-see_physio.json"));
        touch(root.path().join("task-other_physio.json"));
        touch(root.path().join("task-see_events.json"));
        touch(folder.join("sub-01_task-see_recording-eye1_physio.json"));
        touch(folder.join("sub-01_physio.json"));
        let data = folder.join("sub-01_task-see_recording-eye1_physio.tsv.gz");
        let names: Vec<String> = sidecars(&data, "physio")
            .iter()
            .map(|path| path.file_name().unwrap_or_default().to_string_lossy().into_owned())
            .collect();
        assert_eq!(
            names,
            ["task-see_physio.json", "sub-01_physio.json", "sub-01_task-see_recording-eye1_physio.json"]
        );
        assert_eq!(sidecars(&data, "events").len(), 1);
    }
}
