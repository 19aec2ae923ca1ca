//! From rows to a recording, with an account of what was left out.

use super::super::rows::no_samples;
use super::number::{Field, flag_of};
use super::split::Row;
use super::{Column, Table};
use crate::error::Result;
use crate::recording::{ExtraColumn, Recording, RecordingInfo};
use crate::sample::GazeSample;
use std::cell::Cell;

/// A column whose first so many values are no numbers is one of text.
const TEXT_VALUES: u64 = 64;

/// Rows left out or harmed for one reason.
#[derive(Debug, Default)]
struct Count {
    rows: u64,
    first_line: u64,
}

impl Count {
    fn add(&mut self, line: u64) {
        if self.rows == 0 {
            self.first_line = line;
        }
        self.rows += 1;
    }

    fn report(&self, recording: &mut Recording, why: &str) {
        if self.rows > 0 {
            recording.skip(self.rows, format!("{why}, first in line {}", self.first_line));
        }
    }
}

/// A column that no sample has a place for.
#[derive(Debug)]
struct Extra {
    column: usize,
    /// Empty until there is a number.
    values: Vec<f64>,
    numbers: u64,
    texts: u64,
}

impl Extra {
    fn add(&mut self, row: &Row, index: usize, expected: usize) {
        if self.numbers == 0 && self.texts > TEXT_VALUES {
            return;
        }
        let value = match flag_of(row.text(Some(self.column))) {
            Field::Number(value) => value,
            Field::Missing => f64::NAN,
            Field::Text => {
                self.texts += 1;
                f64::NAN
            }
        };
        if self.numbers == 0 && value.is_nan() {
            return;
        }
        if self.numbers == 0 {
            self.values.reserve_exact(expected.max(index + 1));
            self.values.resize(index, f64::NAN);
        }
        self.numbers += u64::from(!value.is_nan());
        self.values.push(value);
    }
}

/// A recording in the making.
#[derive(Debug)]
struct Reading {
    recording: Recording,
    expected: usize,
    extras: Vec<Extra>,
    rejected: Vec<(&'static str, Count)>,
    wrong_width: Count,
    wrong_fields: usize,
    text_for_number: Count,
    broken_off: Option<u64>,
}

impl Reading {
    fn new(table: &Table, mut info: RecordingInfo) -> Self {
        info.notes.extend(table.notes.iter().cloned());
        let mut recording = Recording::new(info);
        let expected = table.rows_at_most();
        recording.reserve(expected);
        let free =
            table.columns.iter().enumerate().filter(|(_, column)| !column.taken && !column.name.is_empty());
        let extra = |column: usize| Extra { column, values: Vec::new(), numbers: 0, texts: 0 };
        Self {
            recording,
            expected,
            extras: free.map(|(column, _)| extra(column)).collect(),
            rejected: Vec::new(),
            wrong_width: Count::default(),
            wrong_fields: 0,
            text_for_number: Count::default(),
            broken_off: None,
        }
    }

    fn add(&mut self, row: &Row, sample: Result<GazeSample, &'static str>) {
        match sample {
            Ok(sample) => {
                let index = self.recording.len();
                self.recording.push(&sample);
                for extra in &mut self.extras {
                    extra.add(row, index, self.expected);
                }
                if row.text_for_number.replace(false) {
                    self.text_for_number.add(row.line);
                }
            }
            Err(why) => {
                row.text_for_number.set(false);
                let known = self.rejected.iter().position(|(reason, _)| *reason == why);
                let place = known.unwrap_or_else(|| {
                    self.rejected.push((why, Count::default()));
                    self.rejected.len() - 1
                });
                if let Some((_, count)) = self.rejected.get_mut(place) {
                    count.add(row.line);
                }
            }
        }
    }

    fn reports(&mut self, width: usize, delimiter: u8) {
        let recording = &mut self.recording;
        for (why, count) in &self.rejected {
            count.report(recording, why);
        }
        let fields = self.wrong_fields;
        let mut why = format!("the row has not the {width} fields of the header but, as the first, {fields}");
        if delimiter == b',' && fields > width {
            why += " (between fields, decimal commas need a semicolon or tab)";
        }
        self.wrong_width.report(recording, &why);
        if let Some(line) = self.broken_off {
            recording.skip(1, format!("the file breaks off in line {line}"));
        }
        let why = "text where a number belongs was taken as missing";
        self.text_for_number.report(recording, why);
    }

    fn finish(mut self, columns: &[Column], table: &Table) -> Result<Recording> {
        self.reports(columns.len(), table.delimiter);
        if self.recording.is_empty() {
            return Err(no_samples(table.path, &self.recording));
        }
        let samples = self.recording.len();
        let mut text = Vec::new();
        for mut extra in self.extras {
            let name = columns.get(extra.column).map(|column| column.name.clone()).unwrap_or_default();
            if extra.texts > extra.numbers {
                text.push(name);
            } else if extra.numbers > 0 {
                extra.values.resize(samples, f64::NAN);
                self.recording.extra.push(ExtraColumn { name, values: extra.values });
            }
        }
        if !text.is_empty() {
            self.recording.info.notes.push(format!("columns of text were left out: {}", text.join(", ")));
        }
        Ok(self.recording)
    }
}

/// Makes a sample of each row that has a field for each column; what `sample` refuses is counted under
/// the reason it gives. Columns that were not taken become extra ones.
///
/// # Errors
/// [`Error::File`] where there is no sample at all.
pub(in super::super) fn read_rows(
    table: &Table,
    info: RecordingInfo,
    mut sample: impl FnMut(&Row) -> Result<GazeSample, &'static str>,
) -> Result<Recording> {
    let mut reading = Reading::new(table, info);
    let width = table.columns.len();
    let text_for_number = Cell::new(false);
    let mut splitter = table.splitter();
    while let Some(line) = splitter.next_line() {
        if line.filled == 0 {
            continue;
        }
        if splitter.fields.len() < width || line.filled > width {
            if line.ended {
                if reading.wrong_width.rows == 0 {
                    reading.wrong_fields = splitter.fields.len();
                }
                reading.wrong_width.add(line.number);
            } else {
                reading.broken_off = Some(line.number);
            }
            continue;
        }
        let row = Row { line: line.number, fields: &splitter.fields, text_for_number: &text_for_number };
        let sample = sample(&row);
        reading.add(&row, sample);
    }
    reading.finish(&table.columns, table)
}
