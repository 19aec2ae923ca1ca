//! Reads BIDS eye-tracking: as a stream, so that only the samples take memory, and unpacked on a thread
//! of its own.

use super::events;
use super::names::stem;
use super::plan::Plan;
use super::rows::Rows;
use super::sidecar::{Sidecar, read_object};
use crate::error::{Error, Result};
use crate::formats::{Input, ReadOptions};
use crate::recording::Recording;
use flate2::read::MultiGzDecoder;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};

/// The most bytes of one file, decompressed, as of any format.
const MAX_BYTES: u64 = 8 << 30;
/// Size of the pieces of text that go from one thread to the other, and how many there are: enough that
/// neither waits for the other for long, few enough to stay in the cache.
const PIECE: usize = 256 << 10;
const PIECES: usize = 4;

/// Whether this is the data or side-car of a BIDS eye-tracking recording: by its name, because rows
/// without a header tell nothing, and by what lies beside it.
pub fn is_recording(path: &Path) -> bool {
    let Some(name) = path.file_name().and_then(|name| name.to_str()) else { return false };
    let Some(stem) = stem(name) else { return false };
    if stem.ends_with("_physio") {
        return true;
    }
    // Of our own, under any name.
    let sidecar = path.with_file_name(format!("{stem}.json"));
    read_object(&sidecar).is_ok_and(|keys| keys.contains_key("MaculaRecording"))
}

/// Reads a recording, given its data file or its side-car.
///
/// # Errors
/// [`Error::Io`], [`Error::File`]: one of the two files is missing or broken.
pub fn read_path(path: &Path, options: &ReadOptions) -> Result<Recording> {
    let data = data_of(path)?;
    let sidecar = Sidecar::of(&data)?;
    let file = File::open(&data).map_err(|error| Error::io(&data, error))?;
    std::thread::scope(|scope| {
        let (full_sender, full) = sync_channel(PIECES);
        let (empty, empty_receiver) = channel();
        for _ in 0..PIECES {
            // The receiver is in this function: sending to it works.
            let _ = empty.send(Vec::with_capacity(PIECE));
        }
        let unpacking = scope.spawn(move || unpack(file, &full_sender, &empty_receiver));
        let first: Vec<u8> = full.recv().unwrap_or_default();
        let plan = Plan::new(&data, &sidecar, &first, options)?;
        let mut rows = Rows::new(plan.fields.clone(), plan.least);
        let mut next = Some(first);
        while let Some(piece) = next {
            rows.feed(&piece);
            let _ = empty.send(piece);
            next = full.recv().ok();
        }
        // A panic over there would be a bug over there.
        let end = unpacking.join().unwrap_or_else(|_| Err(io::Error::other("unpacking failed")));
        let end = end.map_err(|error| Error::io(&data, error))?;
        finish(&data, &sidecar, plan, rows, end)
    })
}

/// As [`read_path`], of a data file in memory; a side-car in memory names the data file beside it.
///
/// # Errors
/// As [`read_path`].
pub fn read_input(input: &Input, options: &ReadOptions) -> Result<Recording> {
    if input.path.extension().is_some_and(|extension| extension == "json") {
        return read_path(&input.path, options);
    }
    let sidecar = Sidecar::of(&input.path)?;
    let head = &input.bytes[..input.bytes.len().min(PIECE)];
    let plan = Plan::new(&input.path, &sidecar, head, options)?;
    let mut rows = Rows::new(plan.fields.clone(), plan.least);
    rows.feed(&input.bytes);
    let end = if input.truncated { End::BrokenOff } else { End::Whole };
    finish(&input.path, &sidecar, plan, rows, end)
}

/// How the data ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    Whole,
    BrokenOff,
    TooLong,
}

fn data_of(path: &Path) -> Result<PathBuf> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let Some(stem) = name.strip_suffix(".json") else { return Ok(path.to_owned()) };
    let packed = path.with_file_name(format!("{stem}.tsv.gz"));
    let plain = path.with_file_name(format!("{stem}.tsv"));
    match (packed.exists(), plain.exists()) {
        (true, _) => Ok(packed),
        (false, true) => Ok(plain),
        (false, false) => {
            let cause = format!("is a side-car, and its data {stem}.tsv.gz is not beside it; put it there");
            Err(Error::file(path, cause))
        }
    }
}

/// Sends the file's text in pieces until it ends, or nobody takes them.
fn unpack(file: File, full: &SyncSender<Vec<u8>>, empty: &Receiver<Vec<u8>>) -> io::Result<End> {
    let mut file = BufReader::with_capacity(PIECE, file);
    let packed = io::BufRead::fill_buf(&mut file)?.starts_with(&[0x1f, 0x8b]);
    let mut reader: Box<dyn Read> = if packed { Box::new(MultiGzDecoder::new(file)) } else { Box::new(file) };
    let mut left = MAX_BYTES;
    while let Ok(mut piece) = empty.recv() {
        piece.clear();
        let read = reader.by_ref().take(PIECE as u64).read_to_end(&mut piece);
        left = left.saturating_sub(piece.len() as u64);
        let ended = piece.len() < PIECE;
        if full.send(piece).is_err() {
            break;
        }
        match read {
            Err(error) if !packed => return Err(error),
            Err(_) => return Ok(End::BrokenOff),
            Ok(_) if left == 0 => return Ok(End::TooLong),
            Ok(_) if ended => break,
            Ok(_) => {}
        }
    }
    Ok(End::Whole)
}

fn finish(path: &Path, sidecar: &Sidecar, plan: Plan, mut rows: Rows, end: End) -> Result<Recording> {
    if end == End::TooLong || rows.complaints.too_many {
        return Err(Error::file(path, "holds more samples than can be read at once; split it"));
    }
    // Our own rows always end with a line end: what has none was cut, maybe within a number.
    rows.end(end == End::Whole && sidecar.own.is_none());
    let complaints = std::mem::take(&mut rows.complaints);
    let mut recording = plan.recording(sidecar, rows);
    let mut skip = |rows: u64, why: String| {
        if rows > 0 {
            recording.skip(rows, why);
        }
    };
    if let Some((row, shown)) = complaints.first_no_time {
        skip(complaints.no_time, format!("no time, first in row {row}: {shown}"));
    }
    skip(complaints.short, "row with fewer fields than the side-car names; the rest taken as missing".into());
    skip(complaints.long, "row with more fields than the side-car names; the rest left out".into());
    if let Some((row, field)) = complaints.first_no_number {
        let column = sidecar.columns.get(field).map_or("", String::as_str);
        skip(
            complaints.no_number,
            format!("no number, first in row {row}, column {column}; taken as missing"),
        );
    }
    skip(u64::from(complaints.cut), "the last row is cut".into());
    if end == End::BrokenOff {
        recording.skip(0, BROKEN_OFF);
    }
    if let Some(own) = sidecar.own.as_ref().filter(|own| own.events > 0) {
        events::read(&mut recording, path, own.events);
    }
    let unfinished = sidecar.own.as_ref().is_some_and(|own| !own.finished);
    if unfinished {
        recording.info.notes.push("The recording was not ended; up to a second may be missing.".into());
    }
    Ok(recording)
}

/// As the readers of other formats say it.
pub const BROKEN_OFF: &str = "the compressed file breaks off; what came before was read";
