//! TSV with the field names of the Tobii Analytics SDK, as I2MC's example data: `LGazePos2dx`,
//! `LValidity`, `LEyePos3dx` and the same with `R`.
//!
//! Times are us. `GazePos2d` are fractions of the display from the top left; 3D positions are mm in the user
//! coordinate system (x right, y up, z from the display to the user). Validity goes from 0, surely this
//! eye, to 4, not found. -1 and 0 stand for "missing".

use super::axes::told;
use super::table::{Col, Row, Table, guess_unit_ns, has_header, read_rows};
use super::{Format, Input, ReadOptions};
use crate::error::Result;
use crate::recording::{Recording, RecordingInfo, Screen, Space};
use crate::sample::{EyeSample, GazeSample};
use glam::{DVec2, DVec3};

/// The format.
pub const FORMAT: Format = Format { name: "tobii-sdk-tsv", matches, read };

const REQUIRED: [&str; 4] = ["time", "lgazepos2dx", "lgazepos2dy", "lvalidity"];
/// The worst validity that can be used: "probably this eye". At 2 it may be the other one.
const WORST_VALIDITY: f64 = 1.0;

fn matches(_: &Input, head: &str) -> bool {
    has_header(head, &REQUIRED)
}

#[derive(Clone, Copy)]
struct EyeColumns {
    point: [Col; 2],
    eye_mm: [Col; 3],
    gaze_mm: [Col; 3],
    pupil: Col,
    validity: Col,
}

impl EyeColumns {
    fn take(table: &mut Table, eye: &str) -> Self {
        Self {
            point: ["x", "y"].map(|axis| table.take(&format!("{eye}gazepos2d{axis}"))),
            // Relative to the display, not to the head: they stay among the extra columns.
            eye_mm: ["x", "y", "z"].map(|axis| table.find(&format!("{eye}eyepos3d{axis}"))),
            gaze_mm: ["x", "y", "z"].map(|axis| table.find(&format!("{eye}gazepos3d{axis}"))),
            pupil: table.take(&format!("{eye}pupildm")),
            validity: table.take(&format!("{eye}validity")),
        }
    }

    fn sample(&self, row: &Row, screen: Option<Screen>) -> EyeSample {
        let point = DVec2::from(self.point.map(|column| row.number(column)));
        let point = Some(point).filter(|point| point.is_finite() && *point != DVec2::NEG_ONE);
        let seen = |v: DVec3| told(v).filter(|v| *v != DVec3::NEG_ONE);
        let (eye_mm, gaze_mm) = (seen(row.vector(self.eye_mm)), seen(row.vector(self.gaze_mm)));
        let direction = eye_mm.zip(gaze_mm).and_then(|(eye_mm, gaze_mm)| (gaze_mm - eye_mm).try_normalize());
        let direction = direction.or_else(|| Some(screen?.direction_of(point?)));
        let usable = row.some(self.validity).is_none_or(|validity| validity <= WORST_VALIDITY);
        EyeSample {
            valid: usable && point.is_some(),
            direction,
            point,
            pupil_mm: row.some(self.pupil).filter(|mm| *mm > 0.0),
            ..EyeSample::default()
        }
    }
}

fn read(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let mut table = Table::open(input, &REQUIRED, &[])?;
    let time = table.take("time");
    let eyes = ["l", "r"].map(|eye| EyeColumns::take(&mut table, eye));
    let unit_ns = guess_unit_ns(&mut table, time, options, 1e3, |_| true)?;
    table.notes.push("directions are relative to the display's axes, not to the head".to_owned());
    let info = RecordingInfo {
        device: "Tobii (Analytics SDK)".to_owned(),
        space: Space::Display,
        screen: options.screen,
        device_clock: "eye tracker (us)".to_owned(),
        ..RecordingInfo::default()
    };
    read_rows(&table, info, |row| {
        let time_ns = row.time_ns(time, unit_ns).ok_or("there is no time")?;
        let [left, right] = eyes.map(|eye| eye.sample(row, options.screen));
        Ok(GazeSample { left, right, ..GazeSample::at(time_ns) })
    })
}

#[cfg(test)]
mod tests {
    use super::super::testing::input;
    use super::*;

    #[test]
    fn minus_one_and_zero_are_missing_and_validity_is_kept() {
        let mut file = "Time\tLEyePos3dx\tLEyePos3dy\tLEyePos3dz\tLGazePos2dx\tLGazePos2dy\tLGazePos3dx\t\
            LGazePos3dy\tLGazePos3dz\tLPupilDm\tLValidity\tREyePos3dx\tREyePos3dy\tREyePos3dz\tRGazePos2dx\t\
            RGazePos2dy\tRGazePos3dx\tRGazePos3dy\tRGazePos3dz\tRPupilDm\tRValidity\tRelTimestamp\n"
            .to_owned();
        let lost = "0\t0\t0\t-1\t-1\t0\t0\t0\t-1\t4";
        let right = "30\t0\t600\t0.75\t0.25\t30\t450\t0\t3.5\t0";
        let unsure = "0\t0\t600\t0.5\t0.5\t0\t0\t0\t3\t2";
        for (time, left) in [(5_000_000, lost), (5_003_333, unsure)] {
            file += &format!("{time}\t{left}\t{right}\t0\n");
        }
        let recording = read(&input(file), &ReadOptions::default()).expect("well formed");
        let first = recording.get(0).expect("two");
        assert_eq!(first.left, EyeSample::default());
        assert_eq!(first.right.point, Some(DVec2::new(0.75, 0.25)));
        let direction = first.right.direction.expect("told");
        assert!(direction.abs_diff_eq(DVec3::new(0.0, 0.6, -0.8), 1e-15), "{direction}");
        assert!(first.right.valid && first.right.pupil_mm == Some(3.5));
        let second = recording.get(1).expect("two");
        assert_eq!(second.time_ns - first.time_ns, 3_333_000, "us, by the rate they make");
        assert!(!second.left.valid && second.left.point.is_some(), "which eye it is, is not sure");
    }
}
