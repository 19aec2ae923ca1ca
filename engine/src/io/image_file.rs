//! Pictures and texts in files, each written whole or not at all.

use crate::error::{Error, Result};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage,
};
use image::codecs::png::{PngDecoder, PngEncoder};
use image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageError, Limits};
use std::ffi::OsString;
use std::fs::{File, OpenOptions};
use std::io::{BufReader, BufWriter, Cursor, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// The longest side of a picture that is read, px.
const MAX_SIDE: u32 = 16384;

/// The most bytes that reading a picture may take.
const MAX_DECODED_BYTES: u64 = 1 << 29;

/// A file under a temporary name, which disappears unless it is renamed.
struct Temporary {
    path: PathBuf,
    renamed: bool,
}

impl Temporary {
    /// Creates a new file beside `target`.
    fn beside(target: &Path) -> std::io::Result<(Self, File)> {
        static COUNTER: AtomicU64 = AtomicU64::new(0);
        loop {
            let number = COUNTER.fetch_add(1, Ordering::Relaxed);
            let name = OsString::from(format!(".macula-{}-{number}.tmp", std::process::id()));
            let path = target.with_file_name(name);
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => return Ok((Self { path, renamed: false }, file)),
                // Left by a process of the same number that was killed: the next number is free.
                Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
    }

    fn rename(mut self, target: &Path) -> std::io::Result<()> {
        std::fs::rename(&self.path, target)?;
        self.renamed = true;
        Ok(())
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.renamed {
            // Already on the way out with an error or a panic; a second one helps nobody.
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Writes a file so that it appears, or replaces the old one, only when it is whole: `write` gets a
/// buffered temporary file in the same folder, which is then flushed, synchronised with the disk and
/// renamed. After an error the temporary file is gone and an old file is as it was.
///
/// # Errors
/// [`Error::Io`] about `path` for an error of `write` or of the system.
pub fn write_atomically(
    path: impl AsRef<Path>,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<()> {
    let path = path.as_ref();
    let attempt = || -> std::io::Result<()> {
        if path.file_name().is_none() || path.is_dir() {
            return Err(std::io::Error::new(
                std::io::ErrorKind::IsADirectory,
                "is a folder; give the name of a file",
            ));
        }
        let (temporary, file) = Temporary::beside(path)?;
        let mut buffered = BufWriter::new(file);
        write(&mut buffered)?;
        buffered.flush()?;
        buffered.get_ref().sync_all()?;
        drop(buffered);
        temporary.rename(path)
    };
    attempt().map_err(|source| Error::io(path, source))
}

/// Writes a text with [`write_atomically`].
///
/// # Errors
/// As there.
pub fn write_text_atomically(path: impl AsRef<Path>, text: &str) -> Result<()> {
    write_atomically(path, |file| file.write_all(text.as_bytes()))
}

/// Checks that there are `4 * width * height` values and at least one.
fn check_length(path: &Path, [width, height]: [u32; 2], length: usize) -> Result<()> {
    let expected = (width as usize).checked_mul(height as usize).and_then(|texels| texels.checked_mul(4));
    if expected == Some(length) && length > 0 {
        return Ok(());
    }
    Err(Error::Setting(format!(
        "{}: {length} values given for a picture of {width}x{height} RGBA pixels",
        path.display()
    )))
}

/// Writes a PNG of `4 * width * height` bytes: RGBA, rows from the top, sRGB-encoded, alpha not
/// multiplied in.
///
/// # Errors
/// [`Error::Setting`] if the size is 0 or is not that of `rgba`; [`Error::Io`] as in
/// [`write_atomically`].
pub fn write_png_rgba8(path: impl AsRef<Path>, size: [u32; 2], rgba: &[u8]) -> Result<()> {
    let path = path.as_ref();
    check_length(path, size, rgba.len())?;
    write_atomically(path, |file| {
        PngEncoder::new(file)
            .write_image(rgba, size[0], size[1], ExtendedColorType::Rgba8)
            .map_err(io_of_image)
    })
}

/// Writes an OpenEXR file of `4 * width * height` linear values, RGBA, rows from the top, as 32 bit
/// floats in ZIP compression.
///
/// # Errors
/// As in [`write_png_rgba8`].
pub fn write_exr_rgba(path: impl AsRef<Path>, size: [u32; 2], rgba: &[f32]) -> Result<()> {
    let path = path.as_ref();
    check_length(path, size, rgba.len())?;
    let channel = |(index, name): (usize, &str)| {
        let values = rgba.iter().skip(index).step_by(4).copied().collect();
        AnyChannel::new(name, FlatSamples::F32(values))
    };
    let channels = ["R", "G", "B", "A"].into_iter().enumerate().map(channel).collect();
    let size = (size[0] as usize, size[1] as usize);
    let layer =
        Layer::new(size, LayerAttributes::default(), Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .map_err(|error| Error::io(path, std::io::Error::other(error.to_string())))?;
    write_atomically(path, |file| file.write_all(bytes.get_ref()))
}

/// Reads a PNG of any colour type as RGBA, 8 bits each, rows from the top: its width and height, and
/// `4 * width * height` bytes.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read; [`Error::File`] if it is no PNG, damaged, or larger than
/// 16384 px along a side or 512 MB decoded.
pub fn read_png_rgba8(path: impl AsRef<Path>) -> Result<([u32; 2], Vec<u8>)> {
    let path = path.as_ref();
    let file = File::open(path).map_err(|source| Error::io(path, source))?;
    if !file.metadata().map_err(|source| Error::io(path, source))?.is_file() {
        return Err(Error::file(path, "not a file; give a PNG file"));
    }
    let decode = || -> image::ImageResult<DynamicImage> {
        let mut limits = Limits::default();
        limits.max_image_width = Some(MAX_SIDE);
        limits.max_image_height = Some(MAX_SIDE);
        limits.max_alloc = Some(MAX_DECODED_BYTES);
        let mut decoder = PngDecoder::with_limits(BufReader::new(file), limits.clone())?;
        limits.reserve(decoder.total_bytes())?;
        decoder.set_limits(limits)?;
        DynamicImage::from_decoder(decoder)
    };
    let picture = decode()
        .map_err(|error| match error {
            ImageError::IoError(source) if source.kind() != std::io::ErrorKind::UnexpectedEof => {
                Error::io(path, source)
            }
            other => Error::file(path, format!("{other}; give an undamaged PNG of at most 16384 px a side")),
        })?
        .into_rgba8();
    Ok(([picture.width(), picture.height()], picture.into_raw()))
}

/// The system's own error inside the encoder's, where there is one.
fn io_of_image(error: ImageError) -> std::io::Error {
    match error {
        ImageError::IoError(source) => source,
        other => std::io::Error::other(other.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::environment::Environment;

    fn names(folder: &Path) -> Vec<String> {
        let name = |entry: std::io::Result<std::fs::DirEntry>| {
            entry.unwrap().file_name().to_string_lossy().into_owned()
        };
        std::fs::read_dir(folder).unwrap().map(name).collect()
    }

    #[test]
    fn png_comes_back_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        let bytes: Vec<u8> = (0..4 * 7 * 5).map(|i| (i * 37 % 256) as u8).collect();
        write_png_rgba8(&path, [7, 5], &bytes).unwrap();
        assert_eq!(read_png_rgba8(&path).unwrap(), ([7, 5], bytes));
        assert_eq!(names(folder.path()), ["picture.png"]);
    }

    #[test]
    fn exr_comes_back_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.exr");
        let values: Vec<f32> =
            (0..4 * 6 * 3).map(|i| if i % 4 == 3 { 1.0 } else { i as f32 * 0.37 }).collect();
        write_exr_rgba(&path, [6, 3], &values).unwrap();
        let read = Environment::load(&path).unwrap();
        assert_eq!(read.size, [6, 3]);
        assert_eq!(read.pixels.concat(), values);
        assert_eq!(names(folder.path()), ["picture.exr"]);
    }

    #[test]
    fn wrong_lengths_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture");
        for (size, length) in [([2, 2], 15), ([0, 2], 0), ([u32::MAX, u32::MAX], 16)] {
            assert!(matches!(write_png_rgba8(&path, size, &vec![0; length]), Err(Error::Setting(_))));
            assert!(matches!(write_exr_rgba(&path, size, &vec![0.0; length]), Err(Error::Setting(_))));
        }
        assert!(names(folder.path()).is_empty());
    }

    #[test]
    fn failed_writes_leave_nothing_and_keep_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("report.json");
        write_text_atomically(&path, "old").unwrap();
        let full = write_atomically(&path, |file| {
            file.write_all(&[b'x'; 100_000])?;
            Err(std::io::ErrorKind::StorageFull.into())
        });
        let message = full.unwrap_err().to_string();
        assert!(message.contains("report.json") && !message.contains('\n'), "{message}");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(folder.path()), ["report.json"]);
        write_text_atomically(&path, "new").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "new");
    }

    #[test]
    fn a_panic_while_writing_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("report.json");
        let result = std::panic::catch_unwind(|| write_atomically(&path, |_| panic!("on purpose")));
        assert!(result.is_err() && names(folder.path()).is_empty());
    }

    #[test]
    fn folders_are_no_targets() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("inner");
        std::fs::create_dir(&inner).unwrap();
        assert!(matches!(write_text_atomically(&inner, "x"), Err(Error::Io { path, .. }) if path == inner));
        let missing = folder.path().join("missing/file.txt");
        assert!(
            matches!(write_text_atomically(&missing, "x"), Err(Error::Io { path, .. }) if path == missing)
        );
        assert!(matches!(write_text_atomically("", "x"), Err(Error::Io { .. })));
        assert_eq!(names(folder.path()), ["inner"]);
        assert!(names(&inner).is_empty());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn unwritable_folders_are_named() {
        // Not even root may create files here.
        let path = Path::new("/proc/macula-test.txt");
        let error = write_text_atomically(path, "x").unwrap_err();
        assert!(error.to_string().contains("/proc/macula-test.txt"), "{error}");
    }

    #[test]
    fn no_png_is_refused_in_one_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        write_png_rgba8(&path, [64, 64], &[7; 4 * 64 * 64]).unwrap();
        let whole = std::fs::read(&path).unwrap();
        let mut huge = whole.clone();
        huge[16..24].copy_from_slice(&[0, 0, 64, 0, 0, 0, 64, 0]);
        for bytes in [&whole[..whole.len() / 2], &whole[..0], b"no picture at all", &huge] {
            std::fs::write(&path, bytes).unwrap();
            let error = read_png_rgba8(&path).unwrap_err();
            assert!(matches!(error, Error::File { .. }) && !error.to_string().contains('\n'), "{error}");
        }
        assert!(matches!(read_png_rgba8(folder.path()), Err(Error::File { .. })));
        assert!(matches!(read_png_rgba8(folder.path().join("none")), Err(Error::Io { .. })));
    }
}
