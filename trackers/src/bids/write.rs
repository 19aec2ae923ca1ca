//! Whole recordings, and short rows filled up.

use super::columns::Column;
use super::events;
use super::layout::Layout;
use super::names::paths;
use super::recorder::{beside, ended};
use super::sidecar::{Ending, folder_of, temporary, write_whole, written};
use super::text::NONE;
use crate::error::{Error, Result};
use crate::recording::Recording;
use flate2::read::MultiGzDecoder;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

/// Text is compressed in pieces of about this size.
const PIECE: usize = 256 << 10;

/// Writes a recording; [`crate::bids::paths`] says which files it consists of, and
/// [`crate::bids::event_paths`] which hold its events, where it has any. A recording of that name
/// is replaced, after the new one is on the disk. Returns the data file.
///
/// # Errors
/// [`Error::Io`].
pub fn write_recording(recording: &Recording, path: &Path) -> Result<PathBuf> {
    let (data, sidecar) = paths(path);
    let mut layout = Layout::new(recording.extra.len());
    for sample in recording.samples() {
        layout.add(&sample);
    }
    let io = |error| Error::io(&data, error);
    let mut encoder = beside(&data).map_err(io)?;
    let mut text = Vec::with_capacity(PIECE + 4096);
    for (row, sample) in recording.samples().enumerate() {
        let value = |index: usize| {
            let column = recording.extra.get(index).and_then(|column| column.values.get(row));
            column.copied().unwrap_or(f64::NAN)
        };
        layout.write_row(&mut text, &sample, value);
        if text.len() >= PIECE {
            encoder.write_all(&text).map_err(io)?;
            text.clear();
        }
    }
    encoder.write_all(&text).map_err(io)?;
    let extra: Vec<String> = recording.extra.iter().map(|column| column.name.clone()).collect();
    let ending = Ending::Finished { rate_hz: recording.rate_hz(), events: recording.events.len() as u64 };
    let described = written(&recording.info, &layout.columns, &extra, ending);
    let file = ended(encoder).map_err(io)?;
    // At no time do an old and a new file look like a pair; should the side-car fail, the old data returns.
    let aside = temporary(folder_of(&data)).map_err(io)?;
    let there = match std::fs::rename(&data, aside.path()) {
        Ok(()) => true,
        Err(error) if error.kind() == io::ErrorKind::NotFound => false,
        Err(error) => return Err(io(error)),
    };
    let replaced =
        events::write(&recording.events, &data).and_then(|()| write_whole(&sidecar, described.as_bytes()));
    if replaced.is_err() && there {
        std::fs::rename(aside.path(), &data).map_err(io)?;
    }
    replaced?;
    file.persist(&data).map_err(|error| io(error.error))?;
    Ok(data)
}

/// Fills up rows that were written before all columns were known.
///
/// # Errors
/// [`Error::Io`]; the file is as before.
pub(super) fn fill_up(data: &Path, columns: &[Column]) -> Result<()> {
    let filled = || -> io::Result<()> {
        let mut rows =
            BufReader::with_capacity(PIECE, MultiGzDecoder::new(BufReader::new(File::open(data)?)));
        let mut encoder = beside(data)?;
        let mut row = Vec::new();
        while rows.read_until(b'\n', &mut row)? > 0 {
            fill_up_row(&mut row, columns);
            encoder.write_all(&row)?;
            row.clear();
        }
        ended(encoder)?.persist(data)?;
        Ok(())
    };
    filled().map_err(|error| Error::io(data, error))
}

fn fill_up_row(row: &mut Vec<u8>, columns: &[Column]) {
    row.pop_if(|byte| *byte == b'\n');
    let fields = 1 + row.iter().filter(|byte| **byte == b'\t').count();
    let time = row.split(|byte| *byte == b'\t').next().unwrap_or_default().to_vec();
    for column in columns.iter().skip(fields) {
        row.push(b'\t');
        match column {
            Column::Received | Column::Device => row.extend_from_slice(&time),
            _ => row.extend_from_slice(NONE),
        }
    }
    row.push(b'\n');
}
