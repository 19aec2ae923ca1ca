//! The published data sets GazeBase (Griffith et al. 2021, EyeLink 1000, left eye), GazeBaseVR (Lohr et
//! al. 2023, SMI in a Vive) and JuDo1000 (Makowski et al. 2020, EyeLink 1000), and anything written like
//! them. Times are ms.
//!
//! Angles are degrees of visual angle, each axis for itself: `x = atan(X / D)`, to the right, `y = atan(Y /
//! D)`, up; so the direction is `(tan x, tan y, -1)`.

use super::axes::{of_unity, told};
use super::rows::direction_of_deg;
use super::table::{Col, Row, Table, has_header, read_rows, unit_ns};
use super::{Format, Input, ReadOptions};
use crate::error::Result;
use crate::recording::{Recording, RecordingInfo, Screen, Space};
use crate::sample::{EyeSample, GazeSample};
use glam::DVec2;

/// GazeBase.
pub const FORMAT: Format = Format { name: "gazebase-csv", matches, read };
/// GazeBaseVR.
pub const VR_FORMAT: Format = Format { name: "gazebase-vr-csv", matches: matches_vr, read: read_vr };
/// JuDo1000.
pub const JUDO_FORMAT: Format = Format { name: "judo1000-tsv", matches: matches_judo, read: read_judo };

/// `val` is 0 where the gaze can be used; without it, every gaze can.
const REQUIRED: [&str; 3] = ["n", "x", "y"];
const DOCUMENTED: [&str; 8] = ["n", "x", "y", "val", "dP", "lab", "xT", "yT"];
const VR_REQUIRED: [&str; 7] = ["n", "x", "y", "lx", "ly", "rx", "ry"];
const VR_DOCUMENTED: [&str; 16] =
    ["n", "x", "y", "lx", "ly", "rx", "ry", "xT", "yT", "zT", "clx", "cly", "clz", "crx", "cry", "crz"];
const JUDO_REQUIRED: [&str; 5] = ["time", "x_left", "y_left", "x_right", "y_right"];
const JUDO_DOCUMENTED: [&str; 7] = ["trialId", "pointId", "time", "x_left", "y_left", "x_right", "y_right"];
/// The display of JuDo1000, as its authors give it.
const JUDO_SCREEN: Screen =
    Screen { size_px: DVec2::new(1280.0, 1024.0), size_m: DVec2::new(0.38, 0.302), distance_m: 0.68 };

fn matches(_: &Input, head: &str) -> bool {
    has_header(head, &REQUIRED)
}

fn matches_vr(_: &Input, head: &str) -> bool {
    has_header(head, &VR_REQUIRED)
}

fn matches_judo(_: &Input, head: &str) -> bool {
    has_header(head, &JUDO_REQUIRED)
}

fn info(device: &str, space: Space, rate_hz: f64) -> RecordingInfo {
    RecordingInfo {
        device: device.to_owned(),
        space,
        nominal_rate_hz: Some(rate_hz),
        device_clock: "ms of the recording".to_owned(),
        ..RecordingInfo::default()
    }
}

fn looking(row: &Row, [x, y]: [Col; 2]) -> EyeSample {
    let direction = direction_of_deg(row.number(x), row.number(y));
    EyeSample { valid: direction.is_some(), direction, ..EyeSample::default() }
}

fn read(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let mut table = Table::open(input, &REQUIRED, &DOCUMENTED)?;
    let (time, validity) = (table.take("n"), table.take("val"));
    let angles = ["x", "y"].map(|name| table.take(name));
    let note = "angles are taken as degrees to the right and up of the display's middle, of the left eye";
    table.notes.push(note.to_owned());
    let unit_ns = unit_ns(&table, time, options, 1e6)?;
    let info = info("EyeLink 1000 (GazeBase)", Space::Display, 1000.0);
    read_rows(&table, info, |row| {
        let time_ns = row.time_ns(time, unit_ns).ok_or("there is no time")?;
        let mut left = looking(row, angles);
        left.valid &= row.some(validity).is_none_or(|validity| validity == 0.0);
        Ok(GazeSample { left, ..GazeSample::at(time_ns) })
    })
}

fn read_vr(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let mut table = Table::open(input, &VR_REQUIRED, &VR_DOCUMENTED)?;
    let time = table.take("n");
    let angles = [["x", "y"], ["lx", "ly"], ["rx", "ry"]].map(|names| names.map(|name| table.take(name)));
    let centers = ["cl{}", "cr{}"].map(|name| table.take_xyz(name));
    table.notes.push("angles are taken as degrees to the right and up of straight ahead".to_owned());
    let unit_ns = unit_ns(&table, time, options, 1e6)?;
    let info = info("SMI in HTC Vive (GazeBaseVR)", Space::View, 250.0);
    read_rows(&table, info, |row| {
        let time_ns = row.time_ns(time, unit_ns).ok_or("there is no time")?;
        let [combined, mut left, mut right] = angles.map(|angles| looking(row, angles));
        [left.origin_m, right.origin_m] = centers.map(|center| told(of_unity(row.vector(center))));
        Ok(GazeSample { combined, left, right, ..GazeSample::at(time_ns) })
    })
}

fn read_judo(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let mut table = Table::open(input, &JUDO_REQUIRED, &JUDO_DOCUMENTED)?;
    let time = table.take("time");
    let eyes = ["left", "right"]
        .map(|side| [format!("x_{side}"), format!("y_{side}")].map(|name| table.take(&name)));
    let screen = options.screen.unwrap_or(JUDO_SCREEN);
    if options.screen.is_none() {
        let note = "the display was taken to be that of JuDo1000: 1280 x 1024 px, 38 x 30.2 cm, at 68 cm";
        table.notes.push(note.to_owned());
    }
    let unit_ns = unit_ns(&table, time, options, 1e6)?;
    let mut info = info("EyeLink 1000 (JuDo1000)", Space::Display, 1000.0);
    info.screen = Some(screen);
    read_rows(&table, info, |row| {
        let time_ns = row.time_ns(time, unit_ns).ok_or("there is no time")?;
        let [left, right] = eyes.map(|eye| {
            let point = DVec2::from(eye.map(|column| row.number(column))) / screen.size_px;
            let point = point.is_finite().then_some(point);
            let direction = point.map(|point| screen.direction_of(point));
            EyeSample { valid: point.is_some(), direction, point, ..EyeSample::default() }
        });
        Ok(GazeSample { left, right, ..GazeSample::at(time_ns) })
    })
}

#[cfg(test)]
mod tests;
