//! What the tests of several readers share.

use super::Input;
use std::path::Path;

/// A file in memory.
pub(crate) fn input(content: impl AsRef<[u8]>) -> Input {
    Input::of_bytes(Path::new("test"), content.as_ref().to_vec()).expect("not compressed")
}
