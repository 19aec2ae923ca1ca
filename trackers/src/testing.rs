//! What the unit tests of several modules share.

use std::path::{Path, PathBuf};

/// A file or folder of the shared data: in `MACULA_SHARED`, or else in `shared` beside the workspace or
/// a folder above it. `None`, with a printed line, where it is absent.
#[allow(dead_code)]
pub fn shared(relative: &str) -> Option<PathBuf> {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    let named = std::env::var_os("MACULA_SHARED").map(PathBuf::from);
    let beside = manifest.ancestors().skip(2).take(2).map(|folder| folder.join("shared"));
    let found =
        named.into_iter().chain(beside).map(|folder| folder.join(relative)).find(|path| path.exists());
    if found.is_none() {
        println!("skipped: no {relative} in the shared data; MACULA_SHARED says where that lies");
    }
    found
}
