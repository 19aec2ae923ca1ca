//! CSV of FOVE's `GazeRecorder` for Unity. Groups of columns are there or not as the user chose; each may
//! have an `error` column, which is empty where all is well. The first column is empty.
//!
//! Unity's axes (z forward), origins in m, times in s (`Application Time`) and, in newer ones, us of the eye
//! cameras' frame (`Eye Frame Timestamp`). A direction of exactly (0, 0, 1) is FOVE's way to write
//! "unknown" (support.fove-inc.com, gaze vectors).

use super::axes::{of_unity, quaternion_of_unity, told};
use super::table::{Col, Row, Table, has_header, least_offset_ns, read_rows, unit_ns};
use super::{Format, Input, ReadOptions};
use crate::error::Result;
use crate::recording::{Recording, RecordingInfo, Space};
use crate::sample::{EyeSample, GazeSample, HeadPose};
use glam::DVec3;

/// The format.
pub const FORMAT: Format = Format { name: "fove-csv", matches, read };

const APPLICATION_TIME: &str = "application time";
const FRAME_TIME: &str = "eye frame timestamp";
/// The combined ray, as newer and older recorders name it.
const COMBINED: [&str; 2] = ["combined gaze ray", "gaze convergence ray"];
/// A ray of which at least one must be there.
const RAYS: [&str; 3] = ["combined gaze ray dir x", "gaze convergence ray dir x", "eye ray left dir x"];

fn matches(_: &Input, head: &str) -> bool {
    let times = [APPLICATION_TIME, FRAME_TIME];
    times.iter().any(|time| RAYS.iter().any(|ray| has_header(head, &[time, ray])))
}

#[derive(Clone, Copy)]
struct EyeColumns {
    origin: [Col; 3],
    direction: [Col; 3],
    error: Col,
    state: Col,
    pupil_radius: Col,
}

impl EyeColumns {
    fn take(table: &mut Table, ray: &str, side: &str) -> Self {
        Self {
            origin: table.take_xyz(&format!("{ray} pos {{}}")),
            direction: table.take_xyz(&format!("{ray} dir {{}}")),
            error: table.take(&format!("{ray} error")),
            state: table.take(&format!("eye state {side}")),
            pupil_radius: table.take(&format!("pupil radius {side}")),
        }
    }

    fn sample(&self, row: &Row) -> EyeSample {
        let raw = row.vector(self.direction);
        let direction = told(of_unity(raw));
        let openness = match row.text(self.state) {
            state if state.eq_ignore_ascii_case(b"opened") => Some(1.0),
            state if state.eq_ignore_ascii_case(b"closed") => Some(0.0),
            _ => None,
        };
        EyeSample {
            valid: direction.is_some() && raw != DVec3::Z && row.text(self.error).is_empty(),
            direction,
            origin_m: Some(of_unity(row.vector(self.origin))).filter(|origin| origin.is_finite()),
            pupil_mm: row.some(self.pupil_radius).map(|radius_mm| 2.0 * radius_mm),
            openness,
            ..EyeSample::default()
        }
    }
}

fn read(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let mut table = match Table::open(input, &[APPLICATION_TIME], &[]) {
        Ok(table) => table,
        Err(_) => Table::open(input, &[FRAME_TIME], &[])?,
    };
    let (application, frame) = (table.take(APPLICATION_TIME), table.take(FRAME_TIME));
    let name = COMBINED.into_iter().find(|name| table.find(&format!("{name} dir x")).is_some());
    let combined = EyeColumns::take(&mut table, name.unwrap_or(COMBINED[0]), "both");
    let [left, right] =
        ["left", "right"].map(|side| EyeColumns::take(&mut table, &format!("eye ray {side}"), side));
    let position = table.take_xyz("headset position {}");
    let rotation =
        ["x", "y", "z", "w"].map(|axis| table.take(&format!("headset orientation quaternion {axis}")));
    let note = "rays were taken to be relative to the headset; the recorder can also be set to world space, \
        which the file does not tell";
    table.notes.push(note.to_owned());
    let clock = if frame.is_some() { frame } else { application };
    let clock_unit_ns = unit_ns(&table, clock, options, if frame.is_some() { 1e3 } else { 1e9 })?;
    let application_ns = |row: &Row| frame.and_then(|_| row.time_ns(application, 1e9));
    let offset_ns = least_offset_ns(&table, |row| row.time_ns(clock, clock_unit_ns).zip(application_ns(row)));
    let info = RecordingInfo {
        device: "FOVE".to_owned(),
        space: Space::View,
        device_clock: if frame.is_some() { "eye frame (us)" } else { "application (s)" }.to_owned(),
        ..RecordingInfo::default()
    };
    read_rows(&table, info, |row| {
        let device_ns = row.time_ns(clock, clock_unit_ns).ok_or("there is no time")?;
        let time_ns = device_ns.saturating_add(offset_ns.unwrap_or(0));
        let position_m = Some(of_unity(row.vector(position))).filter(|position| position.is_finite());
        let head = quaternion_of_unity(rotation.map(|column| row.number(column))).zip(position_m);
        Ok(GazeSample {
            device_time_ns: Some(device_ns),
            received_ns: application_ns(row).unwrap_or(time_ns),
            time_ns,
            combined: combined.sample(row),
            left: left.sample(row),
            right: right.sample(row),
            head: head.map(|(world_from_view, position_m)| HeadPose { position_m, world_from_view }),
        })
    })
}

#[cfg(test)]
mod tests {
    use super::super::testing::input;
    use super::*;

    #[test]
    fn groups_are_found_by_name_and_errors_count() {
        let file = ",Application Time,Eye Frame Timestamp (micro-seconds),User Mark,Headset Position x,\
            Headset Position y,Headset Position z,Headset Position error,Headset Orientation Quaternion x,\
            Headset Orientation Quaternion y,Headset Orientation Quaternion z,Headset Orientation Quaternion w,\
            Headset Orientation Quaternion error,Combined Gaze Ray pos x,Combined Gaze Ray pos y,\
            Combined Gaze Ray pos z,Combined Gaze Ray dir x,Combined Gaze Ray dir y,Combined Gaze Ray dir z,\
            Combined Gaze Ray error,Gaze Depth,Gaze Depth error,Eye State left,Eye State left error,\
            Pupil Radius (millimeters) left,Pupil Radius (millimeters) left error\n\
            ,0.5100,2500000,X,1,1.5,-2,,0,0.70711,0,0.70711,,0,0,0,0.6,0,0.8,,1.25,,Opened,,1.75,\n\
            ,0.5300,2508000,,1,1.5,-2,,0,0,0,1,,0,0,0,0.6,0,0.8,Data_Unreliable,1.25,,Closed,,1.75,\n\
            ,0.5380,2516000,,1,1.5,-2,,0,0,0,1,,0,0,0,0,0,1,,1.25,,NotDetected,,1.75,\n";
        let recording = read(&input(file), &ReadOptions::default()).expect("well formed");
        let samples: Vec<_> = recording.samples().collect();
        assert_eq!(samples.len(), 3);
        assert_eq!(samples[0].device_time_ns, Some(2_500_000_000));
        assert_eq!(samples[1].received_ns, 530_000_000);
        // The first sample came with the least delay: 0.51 s less 2.5 s.
        assert_eq!(samples[1].time_ns, 518_000_000);
        assert_eq!(samples[0].combined.direction, Some(DVec3::new(0.6, 0.0, -0.8)));
        let valid: Vec<_> = samples.iter().map(|sample| sample.combined.valid).collect();
        assert_eq!(valid, [true, false, false]);
        let openness: Vec<_> = samples.iter().map(|sample| sample.left.openness).collect();
        assert_eq!(openness, [Some(1.0), Some(0.0), None]);
        assert_eq!(samples[0].left.pupil_mm, Some(3.5));
        let head = samples[0].head.expect("told");
        assert_eq!(head.position_m, DVec3::new(1.0, 1.5, 2.0));
        assert!((head.world_from_view * DVec3::NEG_Z).abs_diff_eq(DVec3::X, 1e-5));
        assert_eq!(recording.extra_column("Gaze Depth").map(|depths| depths[0]), Some(1.25));
    }

    #[test]
    fn the_older_recorder_has_only_its_own_time() {
        let file = ",Application Time,Gaze Convergence ray pos x,Gaze Convergence ray pos y,\
            Gaze Convergence ray pos z,Gaze Convergence ray dir x,Gaze Convergence ray dir y,\
            Gaze Convergence ray dir z,Gaze Convergence distance\n\
            ,1.2500,0.0,0.0,0.0,0.0,-0.6,0.8,2.5 - Data_Unreliable\n";
        let recording = read(&input(file), &ReadOptions::default()).expect("well formed");
        let sample = recording.get(0).expect("one");
        assert_eq!((sample.time_ns, sample.received_ns), (1_250_000_000, 1_250_000_000));
        assert_eq!(sample.combined.direction, Some(DVec3::new(0.0, -0.6, -0.8)));
        assert!(sample.combined.valid);
    }
}
