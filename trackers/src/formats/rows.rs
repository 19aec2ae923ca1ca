//! What the readers of text and of records share: lines with their numbers, rows left out, units.

use crate::error::Error;
use crate::recording::{ExtraColumn, Recording};
use glam::DVec3;
use std::borrow::Cow;
use std::fmt::Display;
use std::path::Path;

/// Lines of a file with their numbers, counted from 1; without the line end, and without the byte order
/// mark. What is no UTF-8 is replaced.
pub(super) fn lines(bytes: &[u8]) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let trimmed = |line: &'_ [u8]| line.len() - usize::from(line.ends_with(b"\r"));
    let lines = bytes.split(|byte| *byte == b'\n').zip(1..);
    lines.map(move |(line, number)| (number, String::from_utf8_lossy(&line[..trimmed(line)])))
}

/// The error for a recording without samples, with why its rows were left out.
pub(super) fn no_samples(path: &Path, recording: &Recording) -> Error {
    let cause = match recording.info.skipped.first() {
        None => "holds a header but no samples; was the recording ever started?".to_owned(),
        Some(first) => format!("holds no samples: {} rows were left out: {}", first.rows, first.why),
    };
    Error::file(path, cause)
}

/// How much of an example is told.
const EXAMPLE_LETTERS: usize = 120;

/// Rows that were left out for one reason, with the first of them as an example.
#[derive(Debug, Default)]
pub(super) struct Rejects {
    rows: u64,
    first: String,
}

impl Rejects {
    /// Counts a row; `place` says where it is, as in `line 7`, `what` is wrong with it.
    pub(super) fn add(&mut self, place: impl Display, what: impl Display) {
        if self.rows == 0 {
            let told = format!("{place}: {what}");
            let clean = |letter: char| if letter.is_control() { ' ' } else { letter };
            self.first = told.chars().take(EXAMPLE_LETTERS).map(clean).collect();
        }
        self.rows += 1;
    }

    /// Tells the recording.
    pub(super) fn report(self, recording: &mut Recording, why: &str) {
        if self.rows > 0 {
            recording.skip(self.rows, format!("{why}, first at {}", self.first));
        }
    }
}

/// Extra columns in the making. One that never gets a value is left out.
#[derive(Debug, Default)]
pub(super) struct Extras(Vec<ExtraColumn>);

impl Extras {
    /// Columns of these names, set by their place in the list.
    pub(super) fn new(names: impl IntoIterator<Item: Into<String>>) -> Self {
        let column = |name: String| ExtraColumn { name, values: Vec::new() };
        Self(names.into_iter().map(|name| column(name.into())).collect())
    }

    /// Sets a column's value of the sample with this index; indices ascend.
    pub(super) fn set(&mut self, column: usize, index: usize, value: f64) {
        if let Some(column) = self.0.get_mut(column)
            && !value.is_nan()
        {
            column.values.resize(index, f64::NAN);
            column.values.push(value);
        }
    }

    /// Gives the recording the columns, each as long as it has samples.
    pub(super) fn finish(self, recording: &mut Recording) {
        let samples = recording.len();
        for mut column in self.0.into_iter().filter(|column| !column.values.is_empty()) {
            column.values.resize(samples, f64::NAN);
            recording.extra.push(column);
        }
    }
}

/// A time in ns; `None` where it is not finite or beyond 64 bits.
pub(super) fn ns_of(value: f64, unit_s: f64) -> Option<i64> {
    let ns = (value * (unit_s * 1e9)).round();
    // The largest double below 2^63; the comparison fails for NaN.
    (ns.abs() <= 9_223_372_036_854_774_784.0).then_some(ns as i64)
}

/// The direction of visual angles in degrees on a flat screen, seen from straight ahead: x to the right,
/// y up. View space, of length 1; `None` at 90 degrees and more or where an angle is no number.
pub(super) fn direction_of_deg(x_deg: f64, y_deg: f64) -> Option<DVec3> {
    let within = x_deg.abs() < 90.0 && y_deg.abs() < 90.0;
    let direction = DVec3::new(x_deg.to_radians().tan(), y_deg.to_radians().tan(), -1.0);
    within.then(|| direction.normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_have_numbers_and_no_ends() {
        let all: Vec<_> = lines(b"\xef\xbb\xbfa\r\nb\n\xff\n\nc").collect();
        let expected = [(1, "a"), (2, "b"), (3, "\u{fffd}"), (4, ""), (5, "c")];
        assert_eq!(all, expected.map(|(number, line)| (number, Cow::from(line))));
    }

    #[test]
    fn times_beyond_64_bits_are_no_times() {
        assert_eq!(ns_of(2_154_556.5, 1e-3), Some(2_154_556_500_000));
        assert_eq!(ns_of(0.006684, 1.0), Some(6_684_000));
        assert_eq!(ns_of(-9.3e9, 1.0), None);
        assert_eq!(ns_of(f64::NAN, 1.0), None);
        assert_eq!(ns_of(9_223_372_036.0, 1.0), Some(9_223_372_036_000_000_000));
    }

    #[test]
    fn visual_angles_are_those_of_a_flat_screen() {
        let direction = direction_of_deg(45.0, -45.0).expect("within");
        assert!(direction.abs_diff_eq(DVec3::new(1.0, -1.0, -1.0) / 3f64.sqrt(), 1e-15), "{direction}");
        assert_eq!(direction_of_deg(0.0, 90.0), None);
        assert_eq!(direction_of_deg(f64::NAN, 0.0), None);
    }
}
