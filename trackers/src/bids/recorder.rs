//! Writes a recording while it is made.

use super::layout::Layout;
use super::names::paths;
use super::sidecar::{Ending, folder_of, temporary, write_whole, written};
use super::write::fill_up;
use crate::error::{Error, Result};
use crate::recording::{RecordingInfo, Skipped};
use crate::sample::GazeSample;
use crate::time::host_now_ns;
use flate2::{Compression, write::GzEncoder};
use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Samples wait for so long at most until they are on the disk. Shorter loses less in a crash and
/// compresses worse.
const FLUSH_NS: i64 = 1_000_000_000;
/// Text that waits is at most so long; at 8 kHz with all columns a second is less.
const MAX_WAITING: usize = 4 << 20;
/// Level 3: a second of 1 kHz compresses in a few ms, 15 % larger than at level 6.
const LEVEL: Compression = Compression::new(3);

/// Where compressed members go.
pub(super) trait Sink: std::fmt::Debug + Send {
    /// Appends bytes and has them written to the disk.
    fn append(&mut self, bytes: &[u8]) -> io::Result<()>;
    /// Removes what lies beyond `length`.
    fn cut(&mut self, length: u64) -> io::Result<()>;
}

impl Sink for File {
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.write_all(bytes)?;
        self.sync_data()
    }

    fn cut(&mut self, length: u64) -> io::Result<()> {
        self.set_len(length)?;
        self.seek(SeekFrom::Start(length)).map(drop)
    }
}

/// Writes samples as they come, so that a crash or a full disk loses at most the last second and what
/// is there can be read: see [`crate::bids`].
///
/// About once a second [`Recorder::push`] waits until the disk has what it was given, which may take
/// tens of ms: not for the thread that reads a device.
#[derive(Debug)]
pub struct Recorder {
    data: PathBuf,
    sidecar: PathBuf,
    sink: Box<dyn Sink>,
    info: RecordingInfo,
    extra: Vec<String>,
    layout: Layout,
    /// The side-car does not name all columns of the rows that wait.
    unnamed: bool,
    /// Rows with fewer fields than the last were written.
    ragged: bool,
    waiting: Vec<u8>,
    waiting_rows: u64,
    waiting_since_ns: i64,
    written: u64,
    rows: u64,
    first_ns: i64,
    last_ns: i64,
    /// The last try to write failed so.
    failed: Option<io::ErrorKind>,
    /// Samples that found no place while the disk was full.
    refused: u64,
}

impl Recorder {
    /// Begins a recording; [`crate::bids::paths`] says which files it consists of. `extra` names columns
    /// beside the samples' own ([`Recorder::push_with`]).
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::File`] where the recording is there already: nothing is overwritten.
    pub fn create(path: &Path, info: &RecordingInfo, extra: &[String]) -> Result<Self> {
        let (data, sidecar) = paths(path);
        if sidecar.exists() {
            return Err(Error::file(&sidecar, "is there already; choose another name or remove it"));
        }
        let file = File::create_new(&data).map_err(|error| match error.kind() {
            io::ErrorKind::AlreadyExists => {
                Error::file(&data, "is there already; choose another name or remove it")
            }
            _ => Error::io(&data, error),
        })?;
        let recorder = Self::on(Box::new(file), data, sidecar, info, extra);
        if let Err(error) = recorder.write_sidecar(Ending::Unfinished) {
            // An empty file would be in the way of the next attempt.
            let _ = std::fs::remove_file(&recorder.data);
            return Err(error);
        }
        Ok(recorder)
    }

    /// On a sink that stands for the data file; writes no side-car yet.
    pub(super) fn on(
        sink: Box<dyn Sink>,
        data: PathBuf,
        sidecar: PathBuf,
        info: &RecordingInfo,
        extra: &[String],
    ) -> Self {
        Self {
            data,
            sidecar,
            sink,
            info: info.clone(),
            extra: extra.to_vec(),
            layout: Layout::new(extra.len()),
            unnamed: false,
            ragged: false,
            waiting: Vec::new(),
            waiting_rows: 0,
            waiting_since_ns: 0,
            written: 0,
            rows: 0,
            first_ns: i64::MAX,
            last_ns: i64::MIN,
            failed: None,
            refused: 0,
        }
    }

    /// The data file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.data
    }

    /// Samples that were given up because the disk was full.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.refused
    }

    /// The last try to write failed.
    #[must_use]
    pub fn is_failing(&self) -> bool {
        self.failed.is_some()
    }

    /// Appends a sample.
    ///
    /// # Errors
    /// [`Error::Io`], as of a full disk. The recording can go on: what waits is written when that works
    /// again, as long as it is not too much; samples beyond that are counted as skipped.
    pub fn push(&mut self, sample: &GazeSample) -> Result<()> {
        self.push_with(sample, &[])
    }

    /// Appends a sample and its extra values, in the order of their names; missing ones are none.
    ///
    /// # Errors
    /// As [`Recorder::push`].
    pub fn push_with(&mut self, sample: &GazeSample, extra: &[f64]) -> Result<()> {
        if self.waiting.len() > MAX_WAITING {
            // The disk is full. Tried again once a second: a try compresses all that waits.
            self.tick()?;
            if let Some(kind) = self.failed {
                self.refused += 1;
                return Err(Error::io(&self.data, kind.into()));
            }
        }
        if self.layout.add(sample) {
            self.unnamed = true;
            self.ragged |= self.rows + self.waiting_rows > 0;
        }
        let value = |index: usize| extra.get(index).copied().unwrap_or(f64::NAN);
        self.layout.write_row(&mut self.waiting, sample, value);
        self.first_ns = self.first_ns.min(sample.time_ns);
        self.last_ns = self.last_ns.max(sample.time_ns);
        if self.waiting_rows == 0 {
            self.waiting_since_ns = host_now_ns();
        }
        self.waiting_rows += 1;
        self.tick()
    }

    /// Counts rows that became no sample, in the side-car's list when the recording ends.
    pub fn skip(&mut self, rows: u64, why: &str) {
        match self.info.skipped.iter_mut().find(|skipped| skipped.why == why) {
            Some(skipped) => skipped.rows = skipped.rows.saturating_add(rows),
            None => self.info.skipped.push(Skipped { rows, why: why.to_owned() }),
        }
    }

    /// Adds a sentence to the side-car's notes when the recording ends.
    pub fn note(&mut self, note: impl Into<String>) {
        self.info.notes.push(note.into());
    }

    /// Writes what has waited for a second. To be called now and then while no sample comes.
    ///
    /// # Errors
    /// As [`Recorder::push`].
    pub fn tick(&mut self) -> Result<()> {
        let due = self.waiting_rows > 0
            && (host_now_ns().saturating_sub(self.waiting_since_ns) >= FLUSH_NS
                || self.waiting.len() > MAX_WAITING && self.failed.is_none());
        if due { self.flush() } else { Ok(()) }
    }

    /// Writes everything that waits, now.
    ///
    /// # Errors
    /// As [`Recorder::push`].
    pub fn flush(&mut self) -> Result<()> {
        if self.waiting.is_empty() {
            return Ok(());
        }
        self.waiting_since_ns = host_now_ns();
        if self.unnamed {
            // Before the rows that need it.
            self.write_sidecar(Ending::Unfinished).inspect_err(|error| self.failed = Some(kind_of(error)))?;
            self.unnamed = false;
        }
        let member = compressed(&self.waiting).map_err(|error| Error::io(&self.data, error))?;
        if let Err(error) = self.sink.append(&member) {
            // Half a member would end the file for all that is appended later. If even this fails, a
            // reader still takes everything before it.
            let _ = self.sink.cut(self.written);
            self.failed = Some(error.kind());
            return Err(Error::io(&self.data, error));
        }
        self.failed = None;
        self.written += member.len() as u64;
        self.rows += self.waiting_rows;
        self.waiting_rows = 0;
        self.waiting.clear();
        Ok(())
    }

    /// Ends the recording: writes what waits, fills up short rows, completes the side-car.
    ///
    /// # Errors
    /// [`Error::Io`]. What was written before stays, and can be read.
    pub fn finish(mut self) -> Result<PathBuf> {
        let flushed = self.flush();
        let lost = self.refused + self.waiting_rows;
        if lost > 0 {
            match self.failed {
                None | Some(io::ErrorKind::StorageFull) => self.skip(lost, "the disk was full"),
                Some(kind) => self.skip(lost, &format!("could not be written: {kind}")),
            }
        }
        // What could not be written is not tried again when this is dropped.
        self.waiting.clear();
        let filled = if self.ragged { fill_up(&self.data, &self.layout.columns) } else { Ok(()) };
        let span_ns = i128::from(self.last_ns) - i128::from(self.first_ns);
        let rate_hz = (self.rows > 1 && span_ns > 0).then(|| (self.rows - 1) as f64 * 1e9 / span_ns as f64);
        self.write_sidecar(Ending::Finished { rate_hz, events: 0 })?;
        flushed.and(filled)?;
        Ok(std::mem::take(&mut self.data))
    }

    fn write_sidecar(&self, ending: Ending) -> Result<()> {
        let text = written(&self.info, &self.layout.columns, &self.extra, ending);
        write_whole(&self.sidecar, text.as_bytes())
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        // Nobody is left to hear of an error.
        let _ = self.flush();
    }
}

fn kind_of(error: &Error) -> io::ErrorKind {
    if let Error::Io { source, .. } = error { source.kind() } else { io::ErrorKind::Other }
}

/// One gzip member.
fn compressed(text: &[u8]) -> io::Result<Vec<u8>> {
    let mut encoder = GzEncoder::new(Vec::with_capacity(text.len() / 2), LEVEL);
    encoder.write_all(text)?;
    encoder.finish()
}

/// A temporary file beside `path`, compressed; [`ended`] has it on the disk.
pub(super) fn beside(path: &Path) -> io::Result<GzEncoder<io::BufWriter<tempfile::NamedTempFile>>> {
    Ok(GzEncoder::new(io::BufWriter::new(temporary(folder_of(path))?), LEVEL))
}

/// Ends what [`beside`] began: on the disk, and ready to take its place.
pub(super) fn ended(
    encoder: GzEncoder<io::BufWriter<tempfile::NamedTempFile>>,
) -> io::Result<tempfile::NamedTempFile> {
    let file = encoder.finish()?.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.as_file().sync_all()?;
    Ok(file)
}
