//! Readers of recorded sessions. A file is recognised by its content, never by its name.

mod arff;
mod aria;
mod axes;
mod bids;
mod companions;
mod eyelink_asc;
mod fove;
#[cfg(test)]
mod fuzz_tests;
mod gazebase;
mod hid_recorder;
mod irf_npy;
mod neon_native;
mod pico;
mod pupil_cloud;
mod pupil_core;
mod rows;
#[cfg(test)]
mod shared_tests;
mod sranipal;
mod table;
#[cfg(test)]
pub(crate) mod testing;
mod tobii_glasses3;
mod tobii_lab;
mod tobii_sdk;
mod varjo;
mod xdf;

use crate::error::{Error, Result};
use crate::recording::{Recording, Screen};
use flate2::read::MultiGzDecoder;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The most bytes of one file, decompressed: about 60 hours at 1 kHz in a wide format.
const MAX_BYTES: u64 = 8 << 30;

/// What the file does not say, or says wrongly.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// The format by name, instead of by content.
    pub format: Option<String>,
    /// Seconds in one unit of the file's time, instead of what its names or values tell.
    pub time_unit_s: Option<f64>,
    /// The display, for formats that give points only.
    pub screen: Option<Screen>,
}

/// A file's content, decompressed, and where it came from.
#[derive(Clone, Debug)]
pub struct Input {
    /// For messages and for side-cars beside it.
    pub path: PathBuf,
    /// All bytes, after gzip where it was compressed.
    pub bytes: Vec<u8>,
    /// A compressed file ended early: what came before is in `bytes`.
    pub truncated: bool,
}

impl Input {
    /// Reads a file. One whose gzip stream breaks off gives what came before.
    ///
    /// # Errors
    /// [`Error::Io`] where it cannot be read, [`Error::File`] where it is a folder or too large.
    pub fn open(path: &Path) -> Result<Self> {
        let io = |source| Error::io(path, source);
        let mut file = File::open(path).map_err(io)?;
        let metadata = file.metadata().map_err(io)?;
        if metadata.is_dir() {
            return Err(Error::file(path, "is a folder; give a file in it"));
        }
        if metadata.len() > MAX_BYTES {
            return Err(Error::file(path, format!("is larger than {MAX_BYTES} bytes; split it")));
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(io)?;
        Self::of_bytes(path, bytes)
    }

    /// As [`Self::open`], of bytes that are there already.
    ///
    /// # Errors
    /// [`Error::File`] where they decompress to too much.
    pub fn of_bytes(path: &Path, bytes: Vec<u8>) -> Result<Self> {
        if !bytes.starts_with(&[0x1f, 0x8b]) {
            return Ok(Self { path: path.to_owned(), bytes, truncated: false });
        }
        let mut unpacked = Vec::new();
        let read = MultiGzDecoder::new(bytes.as_slice()).take(MAX_BYTES + 1).read_to_end(&mut unpacked);
        if unpacked.len() as u64 > MAX_BYTES {
            return Err(Error::file(path, format!("decompresses to more than {MAX_BYTES} bytes; split it")));
        }
        Ok(Self { path: path.to_owned(), bytes: unpacked, truncated: read.is_err() })
    }

    /// The first lines as text, for recognition: at most 64 KiB, what is no UTF-8 replaced, no BOM.
    #[must_use]
    pub fn head(&self) -> String {
        let bytes = &self.bytes[..self.bytes.len().min(1 << 16)];
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        String::from_utf8_lossy(bytes).into_owned()
    }
}

/// A format: how it is recognised and read.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// Its name, as in `sranipal-csv`: lower case, hyphens.
    pub name: &'static str,
    /// Whether a file of this content is of this format. Gets the input and its head.
    pub matches: fn(&Input, &str) -> bool,
    /// Reads it.
    pub read: fn(&Input, &ReadOptions) -> Result<Recording>,
}

/// All formats, the more particular before the more general.
pub const FORMATS: &[Format] = &[
    bids::FORMAT,
    xdf::FORMAT,
    irf_npy::FORMAT,
    neon_native::FORMAT,
    hid_recorder::FORMAT,
    eyelink_asc::FORMAT,
    arff::FORMAT,
    tobii_glasses3::FORMAT,
    sranipal::FORMAT,
    pico::FORMAT,
    varjo::FORMAT,
    varjo::UNITY_FORMAT,
    fove::FORMAT,
    pupil_cloud::FORMAT,
    pupil_cloud::EYE_STATE_FORMAT,
    pupil_core::FORMAT,
    tobii_lab::FORMAT,
    tobii_sdk::FORMAT,
    aria::FORMAT,
    gazebase::VR_FORMAT,
    gazebase::FORMAT,
    gazebase::JUDO_FORMAT,
];

/// Files that people have and that are not read: how they begin, and what to do.
const UNREADABLE: &[(&[u8], &str)] = &[
    (
        b"MATLAB ",
        "is a MATLAB file, which is not read; write its samples as a GazeBase CSV: n (ms), x and y (degrees)",
    ),
    (b"SR_RESEARCH_COMBINED_FILE", "is an EyeLink EDF, which is not read; convert it with edf2asc"),
];

/// Reads a recording of any known format; also a folder, where the format is one.
///
/// # Errors
/// [`Error::Io`] and [`Error::File`], with what is wrong and where.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Recording> {
    // An hour of text takes more memory than its samples: this one is read as a stream.
    if options.format.as_deref().is_none_or(|name| name == bids::FORMAT.name) && bids::is_recording(path) {
        return bids::read_path(path, options);
    }
    let within = path.is_dir().then(|| neon_native::file_in(path)).flatten();
    read_input(&Input::open(within.as_deref().unwrap_or(path))?, options)
}

/// As [`read`], of a file in memory.
///
/// # Errors
/// [`Error::File`], [`Error::Setting`] for an unknown format name.
pub fn read_input(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let names = || FORMATS.iter().map(|format| format.name).collect::<Vec<_>>().join(", ");
    let format = if let Some(name) = &options.format {
        let named = FORMATS.iter().find(|format| format.name == name);
        named.ok_or_else(|| Error::Setting(format!("there is no format {name}; known are {}", names())))?
    } else {
        if input.bytes.is_empty() {
            return Err(Error::file(&input.path, "is empty; there is nothing to read"));
        }
        let head = input.head();
        let found = FORMATS.iter().find(|format| (format.matches)(input, &head));
        found.ok_or_else(|| {
            let known = UNREADABLE.iter().find(|(start, _)| input.bytes.starts_with(start));
            let known = known.map(|(_, cause)| (*cause).to_owned());
            let unknown = || format!("is of no known format; known are {}", names());
            let cause = known.or_else(|| companions::what_it_is(input, &head));
            Error::file(&input.path, cause.unwrap_or_else(unknown))
        })?
    };
    let mut recording = (format.read)(input, options)?;
    recording.info.format = format.name;
    if input.truncated {
        recording.skip(0, "the compressed file breaks off; what came before was read");
    }
    Ok(recording)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_read_says_what_to_do() {
        let told = |content: &[u8]| {
            let error =
                read_input(&testing::input(content), &ReadOptions::default()).expect_err("unreadable");
            error.to_string()
        };
        assert!(told(b"MATLAB 5.0 MAT-file, Platform: GLNXA64").contains("GazeBase CSV"));
        assert!(told(b"SR_RESEARCH_COMBINED_FILE\0").contains("edf2asc"));
        assert!(told(b"\0\0").contains("no known format; known are bids"));
        assert!(told(b"").contains("empty"));
        let named = ReadOptions { format: Some("no-such".into()), ..ReadOptions::default() };
        assert!(
            read_input(&testing::input(b"x"), &named)
                .is_err_and(|error| error.to_string().contains("no-such"))
        );
    }

    #[test]
    fn names_of_formats_are_their_own() {
        let mut names: Vec<_> = FORMATS.iter().map(|format| format.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), FORMATS.len());
    }
}
