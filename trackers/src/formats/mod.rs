//! Readers of recorded sessions. A file is recognised by its content, never by its name.

mod arff;
mod aria;
mod axes;
mod bids;
mod companions;
mod eyelink_asc;
mod fove;
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
        let file = File::open(path).map_err(io)?;
        let metadata = file.metadata().map_err(io)?;
        if metadata.is_dir() {
            return Err(Error::file(path, "is a folder; give a file in it"));
        }
        if metadata.len() > MAX_BYTES {
            return Err(Error::file(path, too_large("is")));
        }
        let mut bytes = Vec::new();
        // A device or a pipe tells no length, so what is read is counted.
        file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(io)?;
        if bytes.len() as u64 > MAX_BYTES {
            return Err(Error::file(path, too_large("is")));
        }
        Self::of_bytes(path, bytes)
    }

    /// As [`Self::open`], of bytes that are there already.
    ///
    /// # Errors
    /// [`Error::File`] where they decompress to too much, or not at all.
    pub fn of_bytes(path: &Path, bytes: Vec<u8>) -> Result<Self> {
        if !bytes.starts_with(&[0x1f, 0x8b]) {
            return Ok(Self { path: path.to_owned(), bytes, truncated: false });
        }
        let mut unpacked = Vec::new();
        let read = MultiGzDecoder::new(bytes.as_slice()).take(MAX_BYTES + 1).read_to_end(&mut unpacked);
        if unpacked.len() as u64 > MAX_BYTES {
            return Err(Error::file(path, too_large("decompresses to")));
        }
        if unpacked.is_empty() && read.is_err() {
            return Err(Error::file(path, "begins like gzip but cannot be unpacked; get another copy of it"));
        }
        Ok(Self { path: path.to_owned(), bytes: unpacked, truncated: read.is_err() })
    }

    /// The bytes of a text. Where a compressed file broke off, its last line may look whole and hold half
    /// a number: it is left out.
    fn text(&self) -> &[u8] {
        let end = memchr::memrchr2(b'\n', b'\r', &self.bytes).map_or(0, |at| at + 1);
        if self.truncated { &self.bytes[..end] } else { &self.bytes }
    }

    /// The first lines as text, for recognition: at most 64 KiB, what is no UTF-8 replaced, no BOM.
    #[must_use]
    pub fn head(&self) -> String {
        let bytes = &self.bytes[..self.bytes.len().min(1 << 16)];
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        String::from_utf8_lossy(bytes).into_owned()
    }
}

fn too_large(what: &str) -> String {
    format!("{what} more than {MAX_BYTES} bytes; split it")
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
    (b"PK\x03\x04", "is a zip archive or a spreadsheet; unpack it, or save the sheet as CSV"),
];

/// Reads a recording of any known format; also a folder, where the format is one.
///
/// # Errors
/// [`Error::Io`] and [`Error::File`], with what is wrong and where.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Recording> {
    // An hour of text takes more memory than its samples: this one is read as a stream.
    if options.format.as_deref().is_none_or(|name| name == bids::FORMAT.name) && bids::is_recording(path) {
        let mut recording = bids::read_path(path, options)?;
        note_times(&mut recording);
        return Ok(recording);
    }
    let within = path.is_dir().then(|| neon_native::file_in(path)).flatten();
    read_input(&Input::open(within.as_deref().unwrap_or(path))?, options)
}

/// As [`read`], of a file in memory.
///
/// # Errors
/// [`Error::File`], also where there is no sample; [`Error::Setting`] for an unknown format name.
pub fn read_input(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let format = match &options.format {
        Some(name) => named(name)?,
        None => recognised(input)?,
    };
    let mut recording = (format.read)(input, options).map_err(|error| match error {
        Error::File { path, cause }
            if options.format.is_some() && !(format.matches)(input, &input.head()) =>
        {
            let name = format.name;
            Error::file(path, format!("{cause}; it does not look like {name}: name another format, or none"))
        }
        error => error,
    })?;
    if recording.is_empty() {
        return Err(rows::no_samples(&input.path, &recording));
    }
    recording.info.format = format.name;
    if input.truncated {
        recording.skip(0, "the compressed file breaks off; what came before was read");
    }
    let fixed = [neon_native::FORMAT.name, hid_recorder::FORMAT.name].contains(&format.name);
    if fixed && options.time_unit_s.is_some() {
        recording
            .info
            .notes
            .push("the format fixes the unit of time, so the one given was not used".to_owned());
    }
    note_times(&mut recording);
    Ok(recording)
}

fn names() -> String {
    FORMATS.iter().map(|format| format.name).collect::<Vec<_>>().join(", ")
}

fn named(name: &str) -> Result<&'static Format> {
    let named = FORMATS.iter().find(|format| format.name == name);
    named.ok_or_else(|| Error::Setting(format!("there is no format {name}; known are {}", names())))
}

fn recognised(input: &Input) -> Result<&'static Format> {
    if input.bytes.is_empty() {
        return Err(Error::file(&input.path, "is empty; there is nothing to read"));
    }
    let head = input.head();
    let found = FORMATS.iter().find(|format| (format.matches)(input, &head));
    found.ok_or_else(|| {
        let known = UNREADABLE.iter().find(|(start, _)| input.bytes.starts_with(start));
        let known = known.map(|(_, cause)| (*cause).to_owned());
        let unknown = || format!("is of no known format; convert it to one of: {}", names());
        let cause = known.or_else(|| companions::what_it_is(input, &head));
        Error::file(&input.path, cause.unwrap_or_else(unknown))
    })
}

/// Notes how many samples do not come later than the one before them.
fn note_times(recording: &mut Recording) {
    let count = |is: fn(&i64, &i64) -> bool| {
        recording.times_ns().windows(2).filter(|pair| is(&pair[1], &pair[0])).count()
    };
    let (repeated, earlier) = (count(i64::eq), count(i64::lt));
    for (samples, what) in [(repeated, "the same time as"), (earlier, "an earlier time than")] {
        if samples > 0 {
            recording.info.notes.push(format!("{samples} samples have {what} the one before them"));
        }
    }
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
        assert!(told(b"\0\0").contains("no known format; convert it to one of: bids"));
        assert!(told(b"PK\x03\x04\x14\0").contains("unpack it"));
        assert!(told(b"").contains("empty"));
        let named = ReadOptions { format: Some("no-such".into()), ..ReadOptions::default() };
        assert!(
            read_input(&testing::input(b"x"), &named)
                .is_err_and(|error| error.to_string().contains("no-such"))
        );
    }

    #[test]
    fn a_format_named_wrongly_and_a_file_without_samples_say_so() {
        let told = |content: &[u8], format: Option<&str>| {
            let options = ReadOptions { format: format.map(str::to_owned), ..ReadOptions::default() };
            read_input(&testing::input(content), &options).expect_err("nothing to read").to_string()
        };
        let gazebase = b"n,x,y\n0,1,2\n";
        assert!(told(gazebase, Some("aria-csv")).contains("does not look like aria-csv"));
        let header =
            b"@RELATION r\n@ATTRIBUTE time INTEGER\n@ATTRIBUTE x NUMERIC\n@ATTRIBUTE y NUMERIC\n@DATA\n";
        assert!(told(header, None).contains("a header but no samples"));
        let broken = [&header[..], b"1,2,c\n"].concat();
        assert!(told(&broken, None).contains("1 rows were left out: rows are no sample, first at line 6"));
    }

    #[test]
    fn what_compression_cut_off_is_no_number() {
        use std::io::Write;
        // Without compression, so that the cut lies where it should: within the last number.
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::none());
        packed.write_all(b"n,x,y\n0,1.5,2.5\n1,1.5,2.5\n").expect("in memory");
        let packed = packed.finish().expect("in memory");
        // The end of gzip takes 8 bytes, ".5" and the line's end 3.
        let input = Input::of_bytes(Path::new("cut"), packed[..packed.len() - 11].to_vec()).expect("a part");
        let recording = read_input(&input, &ReadOptions::default()).expect("one row");
        assert_eq!(recording.len(), 1);
        assert!(recording.info.skipped[0].why.contains("breaks off"));
        let broken = Input::of_bytes(Path::new("x.gz"), b"\x1f\x8b\x08\0\xff\xff\xff\xff".to_vec());
        assert!(broken.is_err_and(|error| error.to_string().contains("cannot be unpacked")));
    }

    #[test]
    fn times_that_do_not_rise_are_noted() {
        let recording =
            read_input(&testing::input("n,x,y\n1,0,0\n1,0,0\n3,0,0\n2,0,0\n"), &ReadOptions::default());
        let notes = recording.expect("four rows").info.notes;
        assert!(
            notes.contains(&"1 samples have the same time as the one before them".to_owned()),
            "{notes:?}"
        );
        assert!(notes.contains(&"1 samples have an earlier time than the one before them".to_owned()));
    }

    #[test]
    fn names_of_formats_are_their_own() {
        let mut names: Vec<_> = FORMATS.iter().map(|format| format.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), FORMATS.len());
    }
}
