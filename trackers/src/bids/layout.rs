//! Which columns a recording has so far, and how a sample becomes a row.

use super::columns::{Column, POINT_X, POINT_Y};
use super::text::{NONE, write_seconds, write_value};
use crate::recording::{COLUMNS, values_of};
use crate::sample::GazeSample;

/// The columns, growing with what samples need.
#[derive(Clone, Debug)]
pub struct Layout {
    pub columns: Vec<Column>,
    has: [bool; COLUMNS],
}

impl Layout {
    /// What BIDS demands, and `extra` columns.
    pub fn new(extra: usize) -> Self {
        let mut has = [false; COLUMNS];
        (has[POINT_X], has[POINT_Y]) = (true, true);
        let points = [POINT_X, POINT_Y].map(Column::Value);
        let columns = std::iter::once(Column::Time).chain(points).chain((0..extra).map(Column::Extra));
        Self { columns: columns.collect(), has }
    }

    /// Adds the columns that this sample is the first to need; says whether there were any.
    pub fn add(&mut self, sample: &GazeSample) -> bool {
        let before = self.columns.len();
        if sample.received_ns != sample.time_ns && !self.columns.contains(&Column::Received) {
            self.columns.push(Column::Received);
        }
        if sample.device_time_ns != Some(sample.time_ns) && !self.columns.contains(&Column::Device) {
            self.columns.push(Column::Device);
        }
        for ((index, value), has) in values_of(sample).iter().enumerate().zip(&mut self.has) {
            if !value.is_nan() && !*has {
                *has = true;
                self.columns.push(Column::Value(index));
            }
        }
        self.columns.len() > before
    }

    /// Appends a row. `extra(index)` is the value of an extra column.
    pub fn write_row(&self, text: &mut Vec<u8>, sample: &GazeSample, extra: impl Fn(usize) -> f64) {
        let values = values_of(sample);
        for (place, column) in self.columns.iter().enumerate() {
            if place > 0 {
                text.push(b'\t');
            }
            match *column {
                Column::Time => write_seconds(text, sample.time_ns),
                Column::Received => write_seconds(text, sample.received_ns),
                Column::Device => match sample.device_time_ns {
                    Some(device_ns) => write_seconds(text, device_ns),
                    None => text.extend_from_slice(NONE),
                },
                Column::Value(index) => write_value(text, values[index]),
                Column::Extra(index) => write_value(text, extra(index)),
            }
        }
        text.push(b'\n');
    }
}
