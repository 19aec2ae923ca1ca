//! From a file to texels: what the file is, whether it is small enough, and values in range.

use super::{MAX_RADIANCE, MAX_SIDE, MAX_TEXELS, exr_file, radiance_file};
use crate::error::{Error, Result};
use rayon::prelude::*;
use std::io::Read;
use std::path::Path;

/// The largest file that is read, bytes.
const MAX_FILE_BYTES: u64 = 1 << 29;

/// What the readers of single formats return: why a file is refused, without its name.
pub(super) type Decoded = Result<Picture, String>;

/// A decoded file; values are not yet checked.
#[derive(Debug)]
pub(super) struct Picture {
    /// Width and height, each at least 1.
    pub size: [u32; 2],
    /// `width * height` RGB radiances, rows from the top; the fourth value is without meaning.
    pub pixels: Vec<[f32; 4]>,
}

/// Reads a file of either format.
///
/// # Errors
/// As in [`super::Environment::load`].
pub(super) fn read(path: &Path) -> Result<Picture> {
    let bytes = read_bytes(path)?;
    let decoded = if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        exr_file::decode(&bytes)
    } else if bytes.starts_with(b"#?") {
        radiance_file::decode(&bytes)
    } else {
        Err("neither an OpenEXR nor a Radiance HDR file; convert the environment map to one of them".into())
    };
    decoded.map_err(|cause| Error::file(path, cause))
}

/// The whole file, after a look at its kind and length: a device or a pipe may never end.
fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    let io = |source| Error::io(path, source);
    let mut file = std::fs::File::open(path).map_err(io)?;
    let metadata = file.metadata().map_err(io)?;
    if !metadata.is_file() {
        return Err(Error::file(path, "not a file; give an OpenEXR or Radiance HDR file"));
    }
    if metadata.len() > MAX_FILE_BYTES {
        return Err(Error::file(
            path,
            format!(
                "{} bytes long; environment maps may have at most {MAX_FILE_BYTES}; scale it down",
                metadata.len()
            ),
        ));
    }
    let mut bytes = Vec::new();
    // The file may grow meanwhile; the limit holds for what is read.
    (&mut file).take(MAX_FILE_BYTES).read_to_end(&mut bytes).map_err(io)?;
    Ok(bytes)
}

/// Whether a picture of this many texels is supported.
///
/// # Errors
/// What is wrong with the size.
pub(super) fn check_size([width, height]: [usize; 2]) -> Result<(), String> {
    if width == 0 || height == 0 {
        return Err(format!("the picture is {width}x{height}; both must be at least 1"));
    }
    let fits = width <= MAX_SIDE && height <= MAX_SIDE && width * height <= MAX_TEXELS;
    if !fits {
        return Err(format!(
            "the picture is {width}x{height}; at most 8192x4096 texels are supported; scale it down"
        ));
    }
    Ok(())
}

/// A radiance in range, and whether it had to be changed.
pub(super) fn repaired(value: f32) -> (f32, bool) {
    if value.is_nan() || value < 0.0 {
        (0.0, true)
    } else if value > MAX_RADIANCE {
        (MAX_RADIANCE, true)
    } else {
        (value, false)
    }
}

/// Brings all radiances into range, and the fourth values to 1. Returns the number of texels changed.
pub(super) fn repair(pixels: &mut [[f32; 4]]) -> u64 {
    let repair_texel = |texel: &mut [f32; 4]| {
        let mut changed = false;
        for value in &mut texel[..3] {
            let (good, bad) = repaired(*value);
            *value = good;
            changed |= bad;
        }
        texel[3] = 1.0;
        u64::from(changed)
    };
    pixels.par_chunks_mut(1 << 14).map(|chunk| chunk.iter_mut().map(repair_texel).sum::<u64>()).sum()
}
