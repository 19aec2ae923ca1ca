//! Hand-labelled recordings as NumPy structured arrays, in the layout of the irf data sets: `t` in
//! seconds, `x` and `y` in degrees on the screen, `status` (0 where tracking was lost) and `evt` (0
//! undefined, 1 fixation, 2 saccade, 3 post-saccadic oscillation, 4 pursuit, 5 blink).
//!
//! The file does not say which way y points. In the recordings y rises by 7 to 19 degrees in the last
//! 40 ms before a blink, where the lid that covers the pupil from above draws the measured gaze down: so y
//! points down. File layout: NumPy's `lib.format` documentation, versions 1 to 3.

use super::rows::{Extras, direction_of_deg, ns_of};
use super::{Format, Input, ReadOptions};
use crate::error::{Error, Result};
use crate::recording::{Recording, RecordingInfo, Space};
use crate::sample::{EyeSample, GazeSample};

/// The format.
pub const FORMAT: Format = Format { name: "irf-npy", matches, read };

const MAGIC: &[u8] = b"\x93NUMPY";

/// One field of a record.
struct Field {
    name: String,
    /// As in `<f4`, without the byte order.
    kind: String,
    big_endian: bool,
    offset: usize,
    size: usize,
}

/// The array as its header tells it.
struct Array<'a> {
    fields: Vec<Field>,
    record: usize,
    rows: usize,
    data: &'a [u8],
}

fn matches(input: &Input, _: &str) -> bool {
    input.bytes.starts_with(MAGIC)
}

impl Field {
    /// The field's value in a record that is long enough.
    fn value(&self, record: &[u8]) -> Option<f64> {
        let mut bytes = [0; 8];
        let told = record.get(self.offset..)?.get(..self.size)?;
        bytes.get_mut(..self.size)?.copy_from_slice(told);
        if self.big_endian {
            bytes[..self.size].reverse();
        }
        let unsigned = u64::from_le_bytes(bytes);
        let unused_bits = 64 - 8 * self.size as u32;
        Some(match (self.kind.as_bytes().first()?, self.size) {
            (b'f', 4) => f64::from(f32::from_bits(unsigned as u32)),
            (b'f', 8) => f64::from_bits(unsigned),
            (b'i', _) => ((unsigned << unused_bits) as i64 >> unused_bits) as f64,
            _ => unsigned as f64,
        })
    }
}

/// The quoted strings of a text: the names and types of `descr`.
fn quoted(text: &str) -> Vec<&str> {
    text.split('\'').skip(1).step_by(2).collect()
}

/// The text between two marks.
fn between<'a>(text: &'a str, open: &str, close: &str) -> Option<&'a str> {
    let (_, rest) = text.split_once(open)?;
    rest.split_once(close).map(|(inner, _)| inner)
}

fn fields_of(header: &str) -> Option<(Vec<Field>, usize)> {
    let mut fields = Vec::new();
    let mut offset = 0usize;
    for pair in quoted(between(header, "'descr': [", "]")?).chunks_exact(2) {
        let (order, kind) = pair[1].split_at_checked(1)?;
        let size: usize = kind.get(1..)?.parse().ok()?;
        let known = matches!((kind.as_bytes()[0], size), (b'f', 4 | 8) | (b'i' | b'u' | b'b', 1 | 2 | 4 | 8));
        if !known {
            return None;
        }
        let (name, kind) = (pair[0].to_owned(), kind.to_owned());
        fields.push(Field { name, kind, big_endian: order == ">", offset, size });
        offset += size;
    }
    (offset > 0).then_some((fields, offset))
}

/// Reads the header. An error says what is wrong with it.
fn array_of(bytes: &[u8]) -> Result<Array<'_>, &'static str> {
    let cut = "its header is cut off";
    let (version, rest) = bytes.get(MAGIC.len()..).and_then(|rest| rest.split_at_checked(2)).ok_or(cut)?;
    let wide = version[0] >= 2;
    let (length, rest) = rest.split_at_checked(if wide { 4 } else { 2 }).ok_or(cut)?;
    let length = length.iter().rev().fold(0, |length, byte| length << 8 | usize::from(*byte));
    let (header, data) = rest.split_at_checked(length).ok_or(cut)?;
    let header = std::str::from_utf8(header).map_err(|_| "its header is no text")?;
    let (fields, record) = fields_of(header)
        .ok_or("it is no structured array of plain numbers; the fields needed are t, x, y")?;
    let shape = between(header, "'shape': (", ")").ok_or("its header has no shape")?;
    let rows = shape.trim_end_matches([',', ' ']).parse().map_err(|_| "it is not of one dimension")?;
    Ok(Array { fields, record, rows, data })
}

fn read(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let array = array_of(&input.bytes).map_err(|cause| Error::file(&input.path, cause))?;
    let field = |name: &str| array.fields.iter().find(|field| field.name == name);
    let (Some(t), Some(x), Some(y)) = (field("t"), field("x"), field("y")) else {
        let names: Vec<_> = array.fields.iter().map(|field| field.name.as_str()).collect();
        let cause = format!("has the fields {}; those needed are t, x, y", names.join(", "));
        return Err(Error::file(&input.path, cause));
    };
    let status = field("status");
    let mut recording = Recording::new(RecordingInfo {
        space: Space::Display,
        device_clock: "seconds since the recording began".into(),
        notes: vec![
            "x and y are visual angles on a flat screen straight ahead; y is taken to point down".into(),
        ],
        ..RecordingInfo::default()
    });
    let others =
        array.fields.iter().filter(|field| !["t", "x", "y", "status"].contains(&field.name.as_str()));
    let others: Vec<_> = others.collect();
    let mut extras = Extras::new(others.iter().map(|field| field.name.as_str()));
    let mut timeless = 0;
    for record in array.data.chunks_exact(array.record).take(array.rows) {
        let value = |field: &Field| field.value(record).unwrap_or(f64::NAN);
        let Some(time_ns) = ns_of(value(t), options.time_unit_s.unwrap_or(1.0)) else {
            timeless += 1;
            continue;
        };
        let direction = direction_of_deg(value(x), -value(y));
        let tracked = status.is_none_or(|field| value(field) != 0.0);
        let valid = tracked && direction.is_some();
        let combined = EyeSample { valid, direction, ..EyeSample::default() };
        for (column, field) in others.iter().enumerate() {
            extras.set(column, recording.len(), value(field));
        }
        recording.push(&GazeSample { combined, ..GazeSample::at(time_ns) });
    }
    extras.finish(&mut recording);
    recording.skip_any(timeless, "records have no time");
    let there = array.data.len() / array.record;
    let missing = array.rows.saturating_sub(there) as u64;
    recording.skip_any(missing, "records are missing at the end: the file is cut off");
    Ok(recording)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::{read_input, testing::input};
    use crate::testing::shared;
    use glam::DVec3;

    fn file(header: &str, data: &[u8]) -> Vec<u8> {
        let length = (header.len() as u16).to_le_bytes();
        [MAGIC, b"\x01\x00", &length, header.as_bytes(), data].concat()
    }

    fn record(t: f64, x: f32, y: f32, status: u8, evt: u8) -> Vec<u8> {
        [&t.to_le_bytes()[..], &x.to_le_bytes(), &y.to_le_bytes(), &[status, evt]].concat()
    }

    const HEADER: &str = "{'descr': [('t', '<f8'), ('x', '<f4'), ('y', '<f4'), ('status', '|b1'), ('evt', '|u1')], 'fortran_order': False, 'shape': (3,), }\n";

    #[test]
    fn degrees_become_directions_and_labels_a_column() {
        let data = [
            record(0.001, 45.0, 45.0, 1, 2),
            record(0.002, f32::NAN, 1.0, 1, 5),
            record(0.003, 0.0, 0.0, 0, 1),
        ]
        .concat();
        let recording = read_input(&input(file(HEADER, &data)), &ReadOptions::default()).expect("read");
        assert_eq!(recording.info.format, "irf-npy");
        assert_eq!(recording.times_ns(), [1_000_000, 2_000_000, 3_000_000]);
        let samples: Vec<_> = recording.samples().map(|sample| sample.combined).collect();
        let down_right = DVec3::new(1.0, -1.0, -1.0) / 3f64.sqrt();
        assert!(samples[0].direction.is_some_and(|direction| direction.abs_diff_eq(down_right, 1e-7)));
        assert_eq!(samples.iter().map(|eye| eye.valid).collect::<Vec<_>>(), [true, false, false]);
        assert_eq!(samples[2].direction, Some(DVec3::NEG_Z));
        assert_eq!(recording.extra_column("evt"), Some(&[2.0, 5.0, 1.0][..]));
    }

    #[test]
    fn cut_files_keep_whole_records() {
        let mut data = [record(0.0, 0.0, 0.0, 1, 1), record(f64::NAN, 0.0, 0.0, 1, 1)].concat();
        data.extend([0; 17]);
        let recording = read_input(&input(file(HEADER, &data)), &ReadOptions::default()).expect("read");
        assert_eq!(recording.len(), 1);
        let rows: Vec<_> = recording.info.skipped.iter().map(|skipped| skipped.rows).collect();
        assert_eq!(rows, [1, 1]);
    }

    #[test]
    fn big_endian_and_signed_fields_read() {
        let header =
            "{'descr': [('y', '>i2'), ('t', '>f8'), ('x', '>f4')], 'fortran_order': False, 'shape': (1,), }";
        let data = [&(-45i16).to_be_bytes()[..], &2f64.to_be_bytes(), &0f32.to_be_bytes()].concat();
        let recording = read_input(&input(file(header, &data)), &ReadOptions::default()).expect("read");
        let sample = recording.get(0).expect("one");
        assert_eq!(sample.time_ns, 2_000_000_000);
        let up = DVec3::new(0.0, 1.0, -1.0).normalize();
        assert!(sample.combined.direction.is_some_and(|direction| direction.abs_diff_eq(up, 1e-15)));
    }

    #[test]
    fn what_is_no_such_array_is_refused() {
        let plain = "{'descr': '<f8', 'fortran_order': False, 'shape': (3,), }";
        let square = HEADER.replace("(3,)", "(3, 2)");
        let huge = HEADER.replace("(3,)", "(99999999999999999999999,)");
        let nameless = HEADER.replace("'t'", "'time'");
        let text = HEADER.replace("'<f8'", "'<U8'");
        for header in [plain, &square, &huge, &nameless, &text] {
            let error = read_input(&input(file(header, &[])), &ReadOptions::default());
            assert!(error.is_err(), "{header}");
        }
        for length in 0..HEADER.len() + 10 {
            let cut = &file(HEADER, &[])[..length];
            assert!(read_input(&input(cut), &ReadOptions::default()).is_err());
        }
    }

    /// Counts by an independent reading of the file (Python's struct module).
    #[test]
    fn the_real_file_reads() {
        let Some(path) = shared("data/gaze/irf_lookAtPoint_EL/lookAtPoint_EL_S1.npy") else { return };
        let recording = crate::formats::read(&path, &ReadOptions::default()).expect("read");
        assert_eq!(recording.len(), 81_003);
        assert_eq!(recording.samples().filter(|sample| sample.combined.valid).count(), 79_141);
        let evt = recording.extra_column("evt").expect("labels");
        let count = |label| evt.iter().filter(|value| **value == label).count();
        assert_eq!([0.0, 1.0, 2.0, 3.0, 4.0, 5.0].map(count), [1204, 68_451, 4753, 2480, 0, 4115]);
        assert!(recording.rate_hz().is_some_and(|rate| (rate - 1000.0).abs() < 1e-6));
        assert!(recording.info.skipped.is_empty());
    }
}
