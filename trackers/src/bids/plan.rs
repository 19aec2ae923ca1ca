//! What each column of a file means: ours by name, anybody's by name, unit and recorded eye.

use super::columns::{
    Column, DEVICE, DIRECTION_X, EYE, NAMES, POINT_X, POINT_Y, PUPIL, RECEIVED, TIME, VALID,
};
use super::rows::{Field, Rows};
use super::sidecar::Sidecar;
use super::text;
use crate::error::{Error, Result};
use crate::formats::ReadOptions;
use crate::recording::{COLUMNS, Columns, ExtraColumn, Recording, RecordingInfo, Screen, Space};
use glam::{DVec2, DVec3};
use std::path::Path;

/// Units of time and their power of ten in ns.
const TIME_UNITS: [(&[&str], u32); 4] = [
    (&["s", "sec", "second", "seconds"], 9),
    (&["ms", "msec", "millisecond", "milliseconds"], 6),
    (&["us", "µs", "μs", "usec", "microsecond", "microseconds"], 3),
    (&["ns", "nsec", "nanosecond", "nanoseconds"], 0),
];

/// How a file is read.
#[derive(Debug)]
pub struct Plan {
    pub fields: Vec<Field>,
    /// Fields that no row may lack.
    pub least: usize,
    columns: Vec<Column>,
    info: RecordingInfo,
    /// For files that are not ours.
    foreign: Option<Foreign>,
}

/// What is to be done with the columns of a file that is not ours.
#[derive(Debug)]
struct Foreign {
    /// The first of the recorded eye's columns.
    eye: usize,
    gaze: Gaze,
    /// Where there is no time: of the first row, ns, and between rows, s.
    regular: Option<(f64, f64)>,
}

/// What x and y are.
#[derive(Clone, Copy, Debug)]
enum Gaze {
    /// Lengths on a display of this size.
    Point(DVec2),
    /// Angles, in units of so many radians.
    Angle(f64),
    /// Not known: kept as extra columns.
    Unknown,
}

impl Plan {
    /// For a file with this side-car whose text begins with `head`.
    pub fn new(path: &Path, sidecar: &Sidecar, head: &[u8], options: &ReadOptions) -> Result<Self> {
        if let Some(own) = &sidecar.own {
            let info = Sidecar::own_info(own);
            let column = |name: &String| {
                let value = || NAMES.iter().position(|known| known == name).map(Column::Value);
                let extra = || own.extra.iter().position(|(column, _)| column == name).map(Column::Extra);
                match name.as_str() {
                    TIME => Some(Column::Time),
                    RECEIVED => Some(Column::Received),
                    DEVICE => Some(Column::Device),
                    _ => extra().or_else(value),
                }
            };
            let unknown = |name: &String| {
                Error::file(
                    path,
                    format!("its side-car names a column {name} that this version does not know"),
                )
            };
            let columns: Vec<Column> = sidecar
                .columns
                .iter()
                .map(|name| column(name).ok_or_else(|| unknown(name)))
                .collect::<Result<_>>()?;
            let fields = columns.iter().map(|column| match column {
                Column::Time => Field::Time { power: 9 },
                Column::Received => Field::Received,
                Column::Device => Field::Device,
                Column::Value(_) | Column::Extra(_) => Field::Number,
            });
            return Ok(Self { fields: fields.collect(), least: 3, columns, info, foreign: None });
        }
        Self::foreign(path, sidecar, head, options)
    }

    fn foreign(path: &Path, sidecar: &Sidecar, head: &[u8], options: &ReadOptions) -> Result<Self> {
        let mut info = foreign_info(sidecar, options);
        let rate_hz = info.nominal_rate_hz.filter(|rate| *rate > 0.0);
        let time_at = sidecar.columns.iter().position(|name| name == TIME);
        let mut regular = None;
        let mut power = 9;
        if let Some(at) = time_at {
            power = time_power(sidecar, at, head, options, &mut info)?;
        } else {
            let rate_hz = rate_hz.ok_or_else(|| {
                Error::file(path, "has neither a column timestamp nor a SamplingFrequency; name one of them")
            })?;
            info.notes.push("There is no column timestamp; samples are taken as evenly spaced.".into());
            regular = Some((sidecar.number("StartTime").unwrap_or(0.0) * 1e9, 1.0 / rate_hz));
        }
        let eye = match sidecar.text("RecordedEye").to_ascii_lowercase().as_str() {
            "left" => EYE,
            "right" => 2 * EYE,
            _ => 0,
        };
        let gaze = gaze(sidecar, options, &mut info);
        let known_gaze = !matches!(gaze, Gaze::Unknown);
        let pupil_mm = sidecar.units("pupil_size") == "mm";
        let mut taken = [false; COLUMNS];
        let mut columns = Vec::new();
        for (index, name) in sidecar.columns.iter().enumerate() {
            let value = match name.as_str() {
                TIME if Some(index) == time_at => {
                    columns.push(Column::Time);
                    continue;
                }
                "x_coordinate" if known_gaze => Some(eye + POINT_X),
                "y_coordinate" if known_gaze => Some(eye + POINT_Y),
                "pupil_size" if pupil_mm => Some(eye + PUPIL),
                _ => None,
            };
            columns.push(match value {
                Some(value) if !std::mem::replace(&mut taken[value], true) => Column::Value(value),
                _ => Column::Extra(index),
            });
        }
        let field = |column: &Column| match column {
            Column::Time => Field::Time { power },
            _ => Field::Number,
        };
        let fields: Vec<Field> = columns.iter().map(field).collect();
        let foreign = Some(Foreign { eye, gaze, regular });
        Ok(Self { least: fields.len(), fields, columns, info, foreign })
    }

    /// The recording of the rows.
    pub fn recording(self, sidecar: &Sidecar, rows: Rows) -> Recording {
        let Rows { mut time_ns, received_ns, device_ns, numbers, .. } = rows;
        let mut values: Vec<Option<Vec<f64>>> = vec![None; COLUMNS];
        let mut extra = Vec::new();
        for (column, numbers) in self.columns.iter().zip(numbers) {
            match *column {
                Column::Value(index) => values[index] = Some(numbers),
                Column::Extra(index) => {
                    let own = sidecar.own.as_ref().and_then(|own| own.extra.get(index));
                    let name = own.map(|(_, name)| name).or(sidecar.columns.get(index));
                    extra.push(ExtraColumn { name: name.cloned().unwrap_or_default(), values: numbers });
                }
                Column::Time | Column::Received | Column::Device => {}
            }
        }
        let mut info = self.info;
        if let Some(foreign) = self.foreign {
            foreign.interpret(&mut values);
            if let Some((start_ns, step_s)) = foreign.regular {
                for time in &mut time_ns {
                    *time = (start_ns + *time as f64 * step_s * 1e9).round() as i64;
                }
            }
            extra.retain(|column| {
                let numeric = column.values.iter().any(|value| !value.is_nan());
                if !numeric {
                    info.notes.push(format!("The column {} has no numbers and is left out.", column.name));
                }
                numeric
            });
        }
        let columns = Columns { time_ns, received_ns, device_ns, values };
        let mut recording = Recording::of_columns(info, columns);
        recording.extra = extra;
        recording
    }
}

impl Foreign {
    /// Makes points, directions and validity of what was read as x and y.
    fn interpret(&self, values: &mut [Option<Vec<f64>>]) {
        let x = values[self.eye + POINT_X].take();
        let y = values[self.eye + POINT_Y].take();
        let (Some(mut x), Some(mut y)) = (x, y) else { return };
        let valid = x.iter().zip(&y).map(|(x, y)| f64::from(x.is_finite() && y.is_finite())).collect();
        values[self.eye + VALID] = Some(valid);
        match self.gaze {
            Gaze::Point(size) => {
                for (column, size) in [(&mut x, size.x), (&mut y, size.y)] {
                    for value in column.iter_mut() {
                        *value /= size;
                    }
                }
                values[self.eye + POINT_X] = Some(x);
                values[self.eye + POINT_Y] = Some(y);
            }
            Gaze::Angle(unit_rad) => {
                let mut z = vec![f64::NAN; x.len()];
                for ((x, y), z) in x.iter_mut().zip(&mut y).zip(&mut z) {
                    let (right, up) = (*x * unit_rad, *y * unit_rad);
                    let direction = DVec3::new(right.sin() * up.cos(), up.sin(), -right.cos() * up.cos());
                    [*x, *y, *z] = direction.to_array();
                }
                for (offset, column) in [x, y, z].into_iter().enumerate() {
                    values[self.eye + DIRECTION_X + offset] = Some(column);
                }
            }
            Gaze::Unknown => {}
        }
    }
}

fn foreign_info(sidecar: &Sidecar, options: &ReadOptions) -> RecordingInfo {
    let device = [sidecar.text("Manufacturer"), sidecar.text("ManufacturersModelName")];
    let presentation = &sidecar.screen;
    let told = (presentation.size_px.zip(presentation.size_m)).zip(presentation.distance_m);
    let told = told.map(|((size_px, size_m), distance_m)| Screen { size_px, size_m, distance_m });
    RecordingInfo {
        format: "bids",
        device: device.join(" ").trim().to_owned(),
        space: match sidecar.text("SampleCoordinateSystem") {
            "gaze-on-screen" => Space::Display,
            "eye-in-head" => Space::View,
            _ => Space::Unknown,
        },
        nominal_rate_hz: sidecar.number("SamplingFrequency"),
        screen: options.screen.or(told),
        device_clock: format!("timestamp ({})", sidecar.units(TIME)),
        ..RecordingInfo::default()
    }
}

fn gaze(sidecar: &Sidecar, options: &ReadOptions, info: &mut RecordingInfo) -> Gaze {
    let size_px = options.screen.map(|screen| screen.size_px).or(sidecar.screen.size_px);
    let size_m = options.screen.map(|screen| screen.size_m).or(sidecar.screen.size_m);
    let units = sidecar.units("x_coordinate").to_ascii_lowercase();
    let length = |per_m: f64| size_m.map_or(Gaze::Unknown, |size_m| Gaze::Point(size_m * per_m));
    let gaze = match units.as_str() {
        "pixel" | "pixels" | "px" => size_px.map_or(Gaze::Unknown, Gaze::Point),
        "1" | "fraction" | "normalized" | "normalised" => Gaze::Point(DVec2::ONE),
        "m" => length(1.0),
        "cm" => length(100.0),
        "mm" => length(1000.0),
        "deg" | "degree" | "degrees" | "°" => Gaze::Angle(1f64.to_radians()),
        "rad" | "radian" | "radians" => Gaze::Angle(1.0),
        _ => Gaze::Unknown,
    };
    match gaze {
        Gaze::Point(_) => {}
        Gaze::Angle(_) => {
            info.notes.push("Angles are taken as to the right and upwards from straight ahead.".into());
        }
        Gaze::Unknown => info.notes.push(format!(
            "The gaze is in {}, and the display's size is not known; x_coordinate and y_coordinate are kept \
             as extra columns. Give the display.",
            if units.is_empty() { "unknown units" } else { &units }
        )),
    }
    gaze
}

/// The power of ten of the time's unit in ns: as asked, as the side-car says, or else as it fits the rate.
fn time_power(
    sidecar: &Sidecar,
    at: usize,
    head: &[u8],
    options: &ReadOptions,
    info: &mut RecordingInfo,
) -> Result<u32> {
    if let Some(unit_s) = options.time_unit_s {
        let power = (unit_s * 1e9).log10();
        if !(-0.001..=12.001).contains(&power) || (power - power.round()).abs() > 1e-3 {
            return Err(Error::Setting(format!(
                "a time unit of {unit_s} s cannot be read; give a power of ten from 1e-9 to 1000"
            )));
        }
        return Ok(power.round() as u32);
    }
    let units = sidecar.units(TIME).trim().to_lowercase();
    if let Some((_, power)) = TIME_UNITS.iter().find(|(names, _)| names.contains(&units.as_str())) {
        return Ok(*power);
    }
    let guess = info.nominal_rate_hz.and_then(|rate_hz| guessed_power(at, head, rate_hz));
    let power = guess.unwrap_or(9);
    let name = TIME_UNITS.iter().find(|unit| unit.1 == power).map_or("s", |unit| unit.0[0]);
    let why = if guess.is_some() { "by the sampling frequency" } else { "for want of anything better" };
    info.notes.push(format!("The timestamp has no known unit ({units:?}); taken as {name} {why}."));
    Ok(power)
}

/// The unit in which the middle one of the first steps is nearest to one over the rate.
fn guessed_power(at: usize, head: &[u8], rate_hz: f64) -> Option<u32> {
    let times = head.split(|byte| *byte == b'\n').take(1000).filter_map(|row| {
        let field = row.split(|byte| *byte == b'\t').nth(at)?;
        text::value(field).map(|(value, _)| value)
    });
    let times: Vec<f64> = times.filter(|time| time.is_finite()).collect();
    let mut steps: Vec<f64> =
        times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    if steps.is_empty() {
        return None;
    }
    let middle = steps.len() / 2;
    let (_, step, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
    let power = (1e9 / (rate_hz * *step)).log10();
    let distance = |unit: &u32| (f64::from(*unit) - power).abs();
    TIME_UNITS.iter().map(|unit| unit.1).min_by(|a, b| distance(a).total_cmp(&distance(b)))
}
