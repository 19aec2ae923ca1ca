//! Tobii Pro Lab: the TSV of its data export. The same names are written with units in three ways:
//! `Gaze direction left X`, `Eye position left X (DACSmm)`, `Eye position left X [DACS mm]`. Numbers have a
//! decimal comma where the language of Windows has. Rows of other sensors and of events are in between.
//!
//! Gaze points are px of the display (or of the scene camera) from the top left; `Recording resolution` tells
//! how many there are. Directions of a screen-based tracker are in the display's coordinates: x right, y
//! down, z towards the user; those of glasses (HUCS) x left, y up, z forward.

use super::axes::{of_left_up_forward, told};
use super::table::{Col, Row, Table, guess_unit_ns, has_header, read_rows};
use super::{Format, Input, ReadOptions};
use crate::error::Result;
use crate::recording::{Recording, RecordingInfo, Screen, Space};
use crate::sample::{EyeSample, GazeSample};
use glam::{DVec2, DVec3};

/// The format.
pub const FORMAT: Format = Format { name: "tobii-pro-lab-tsv", matches, read };

const TIME: &str = "recording timestamp";
/// Units of a gaze point in px.
const PX: &[&str] = &["", "px", "dacspx", "mcspx"];
const SIDES: [&str; 2] = ["left", "right"];

fn matches(_: &Input, head: &str) -> bool {
    ["gaze point x", "gaze point left x", "gaze direction left x"]
        .iter()
        .any(|name| has_header(head, &[TIME, name]))
}

#[derive(Clone, Copy)]
struct EyeColumns {
    point_px: [Col; 2],
    direction: [Col; 3],
    pupil: Col,
    validity: Col,
}

struct Columns {
    time: Col,
    eye_tracker_time: Col,
    sensor: Col,
    event: Col,
    point_px: [Col; 2],
    eyes: [EyeColumns; 2],
    /// It is of glasses: directions are in their coordinates, points in those of their camera.
    glasses: bool,
}

impl Columns {
    fn take(table: &mut Table, points: bool) -> Self {
        let mut px = |prefix: &str| {
            ["x", "y"].map(|axis| {
                let column = table.find_with_unit(&format!("{prefix} {axis}"), PX);
                if points {
                    table.mark_taken(column);
                }
                column
            })
        };
        let (both_px, eyes_px) = (px("gaze point"), SIDES.map(|side| px(&format!("gaze point {side}"))));
        let mut eye = |side: &str, point_px| EyeColumns {
            point_px,
            direction: table.take_xyz(&format!("gaze direction {side} {{}}")),
            pupil: table.take(&format!("pupil diameter {side}")),
            validity: table.take(&format!("validity {side}")),
        };
        let eyes = [eye("left", eyes_px[0]), eye("right", eyes_px[1])];
        let points_x = [both_px[0], eyes_px[0][0], eyes_px[1][0]];
        let glasses = eyes.iter().any(|eye| table.unit(eye.direction[0]).contains("hucs"))
            || points_x.into_iter().any(|column| table.unit(column).contains("mcs"));
        // Told once for all samples.
        for side in ["width", "height"] {
            table.take(&format!("recording resolution {side}"));
        }
        Self {
            glasses,
            point_px: both_px,
            eyes,
            time: table.take(TIME),
            eye_tracker_time: table.take("eyetracker timestamp"),
            sensor: table.take("sensor"),
            event: table.take("event"),
        }
    }

    /// Why a row is none of the eye tracker's.
    fn other(&self, row: &Row) -> Option<&'static str> {
        let sensor = row.text(self.sensor);
        if !sensor.is_empty() {
            let own =
                sensor.eq_ignore_ascii_case(b"eye tracker") || sensor.eq_ignore_ascii_case(b"eyetracker");
            return (!own).then_some("the row is of another sensor than the eye tracker");
        }
        let tells = |eye: &EyeColumns| {
            let columns = eye.point_px.iter().chain(&eye.direction).chain([&eye.validity]);
            columns.into_iter().any(|column| !row.text(*column).is_empty())
        };
        let event = self.sensor.is_some() || !row.text(self.event).is_empty();
        let gaze = !row.text(self.point_px[0]).is_empty() || self.eyes.iter().any(tells);
        (event && !gaze).then_some("the row is an event, no sample")
    }
}

/// The pixels that points are counted in: as the file tells, else as the options do.
fn size_px(table: &Table, options: &ReadOptions) -> Option<DVec2> {
    let columns = ["width", "height"].map(|side| table.find(&format!("recording resolution {side}")));
    let mut told = None;
    table.for_rows(|row| {
        let size_px = DVec2::from(columns.map(|column| row.number(column)));
        told = (size_px.min_element() >= 1.0).then_some(size_px);
        told.is_none() && columns[0].is_some()
    });
    told.or(options.screen.map(|screen| screen.size_px))
}

fn read(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let mut table = Table::open(input, &[TIME], &[])?;
    let size_px = size_px(&table, options);
    let columns = Columns::take(&mut table, size_px.is_some());
    if size_px.is_none() {
        let note =
            "the file does not tell the size of the display: gaze points stay in px, in the extra columns";
        table.notes.push(note.to_owned());
    }
    let unit_ns = guess_unit_ns(&mut table, columns.time, options, 1e3, |row| columns.other(row).is_none())?;
    if columns.eyes[0].direction[0].is_some() && !columns.glasses {
        table
            .notes
            .push("directions were taken to have y down and z from the display to the user".to_owned());
    }
    let info = RecordingInfo {
        device: "Tobii (Pro Lab)".to_owned(),
        space: if columns.glasses { Space::SceneCamera } else { Space::Display },
        screen: options.screen,
        device_clock: "eye tracker (us)".to_owned(),
        ..RecordingInfo::default()
    };
    read_rows(&table, info, |row| match columns.other(row) {
        Some(why) => Err(why),
        None => sample_of(row, &columns, size_px, options.screen, unit_ns),
    })
}

fn sample_of(
    row: &Row,
    columns: &Columns,
    size_px: Option<DVec2>,
    screen: Option<Screen>,
    unit_ns: f64,
) -> Result<GazeSample, &'static str> {
    let time_ns = row.time_ns(columns.time, unit_ns).ok_or("there is no time")?;
    let px = |columns: [Col; 2]| DVec2::from(columns.map(|column| row.number(column)));
    let fraction = |px: DVec2| size_px.map(|size_px| px / size_px).filter(|point| point.is_finite());
    // Points of glasses are those of their camera.
    let screen = screen.filter(|_| !columns.glasses);
    let on_screen = |point: Option<DVec2>| Some(screen?.direction_of(point?));
    let [left, right] = columns.eyes.map(|eye| {
        let point_px = px(eye.point_px);
        let raw = row.vector(eye.direction);
        let direction =
            if columns.glasses { of_left_up_forward(raw) } else { DVec3::new(raw.x, -raw.y, raw.z) };
        let point = fraction(point_px);
        let direction = told(direction).or_else(|| on_screen(point));
        let claimed = eye.validity.is_none() || row.is(eye.validity, "valid");
        EyeSample {
            valid: claimed && (direction.is_some() || point_px.is_finite()),
            direction,
            point,
            pupil_mm: row.some(eye.pupil),
            ..EyeSample::default()
        }
    });
    let both_px = px(columns.point_px);
    let point = fraction(both_px);
    // The combined point has no validity of its own: it is there or not.
    let combined =
        EyeSample { valid: both_px.is_finite(), direction: on_screen(point), point, ..EyeSample::default() };
    let device_time_ns = row.time_ns(columns.eye_tracker_time, 1e3).or(Some(time_ns));
    Ok(GazeSample { device_time_ns, combined, left, right, ..GazeSample::at(time_ns) })
}

#[cfg(test)]
mod tests;
