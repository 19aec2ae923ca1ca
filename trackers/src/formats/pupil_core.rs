//! Pupil Core: `gaze_positions.csv` of Pupil Player (pupil-docs, core/software/pupil-player).
//!
//! Times are seconds of Pupil's own monotonic clock, whose zero means nothing; rows of the two eyes
//! are not in the order of time. `norm_pos` counts from the bottom left of the scene camera's picture; 3D
//! values are mm in the scene camera's frame (x right, y down, z forward). Eye 0 is the right one.

use super::axes::{metres, of_camera, told};
use super::table::{Col, Row, Table, has_header, read_rows, unit_ns};
use super::{Format, Input, ReadOptions};
use crate::error::Result;
use crate::recording::{Recording, RecordingInfo, Space};
use crate::sample::{EyeSample, GazeSample};
use glam::DVec2;

/// The format.
pub const FORMAT: Format = Format { name: "pupil-core-csv", matches, read };

/// Below it, the makers advise, gaze is not to be used. Larger loses more samples, smaller lets in those
/// around blinks.
const MIN_CONFIDENCE: f64 = 0.6;

/// With this, `pupil_positions.csv` is ruled out.
const REQUIRED: [&str; 4] = ["confidence", "norm_pos_x", "norm_pos_y", "base_data"];

fn matches(_: &Input, head: &str) -> bool {
    has_header(head, &REQUIRED)
}

struct Columns {
    time: Col,
    confidence: Col,
    norm_pos: [Col; 2],
    point_3d: [Col; 3],
    /// Of the left and the right eye.
    centers: [[Col; 3]; 2],
    normals: [[Col; 3]; 2],
}

fn read(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let mut table = Table::open(input, &REQUIRED, &[])?;
    let time = table.take("gaze_timestamp").or_else(|| table.take("timestamp"));
    let columns = Columns {
        time,
        confidence: table.take("confidence"),
        norm_pos: ["norm_pos_x", "norm_pos_y"].map(|name| table.take(name)),
        // Kept among the extra columns too: its length is the viewing distance.
        point_3d: ["x", "y", "z"].map(|axis| table.find(&format!("gaze_point_3d_{axis}"))),
        centers: ["eye_center1_3d_{}", "eye_center0_3d_{}"].map(|name| table.take_xyz(name)),
        normals: ["gaze_normal1_{}", "gaze_normal0_{}"].map(|name| table.take_xyz(name)),
    };
    let unit_ns = unit_ns(&table, time, options, 1e9)?;
    let note = format!("gaze with a confidence below {MIN_CONFIDENCE} counts as not valid");
    let info = RecordingInfo {
        device: "Pupil Core".to_owned(),
        space: Space::SceneCamera,
        device_clock: "Pupil time (monotonic, its own zero)".to_owned(),
        notes: vec![note],
        ..RecordingInfo::default()
    };
    read_rows(&table, info, |row| sample_of(row, &columns, unit_ns))
}

fn sample_of(row: &Row, columns: &Columns, unit_ns: f64) -> Result<GazeSample, &'static str> {
    let time_ns = row.time_ns(columns.time, unit_ns).ok_or("there is no time")?;
    let confidence = row.some(columns.confidence);
    let sure = confidence.is_none_or(|confidence| confidence >= MIN_CONFIDENCE);
    let [x, y] = columns.norm_pos.map(|column| row.number(column));
    let point = DVec2::new(x, 1.0 - y);
    let direction = told(of_camera(row.vector(columns.point_3d)));
    let combined = EyeSample {
        valid: sure && (point.is_finite() || direction.is_some()),
        direction: direction.map(|point| point.normalize()),
        point: point.is_finite().then_some(point),
        confidence,
        ..EyeSample::default()
    };
    let eye = |number: usize| {
        let direction = columns.normals.get(number).and_then(|normal| told(of_camera(row.vector(*normal))));
        let origin_m = columns.centers.get(number).and_then(|center| metres(of_camera(row.vector(*center))));
        EyeSample { valid: sure && direction.is_some(), direction, origin_m, ..EyeSample::default() }
    };
    Ok(GazeSample { combined, left: eye(0), right: eye(1), ..GazeSample::at(time_ns) })
}

#[cfg(test)]
mod tests {
    use super::super::testing::input;
    use super::*;
    use glam::DVec3;

    #[test]
    fn rows_become_samples_of_the_scene_camera() {
        let file = "gaze_timestamp,world_index,confidence,norm_pos_x,norm_pos_y,base_data,\
            gaze_point_3d_x,gaze_point_3d_y,gaze_point_3d_z,eye_center0_3d_x,eye_center0_3d_y,\
            eye_center0_3d_z,gaze_normal0_x,gaze_normal0_y,gaze_normal0_z,eye_center1_3d_x,eye_center1_3d_y,\
            eye_center1_3d_z,gaze_normal1_x,gaze_normal1_y,gaze_normal1_z\n\
            100.25,7,0.9,0.25,0.75,100.2-0 100.3-1,300,400,1200,30,-20,-25,0,0.6,0.8,-30,-20,-25,0,0,1\n\
            100.2,7,0.3,0.5,0.5,100.2-0,,,,30,-20,-25,0,0.6,0.8,,,,,,\n";
        let recording = read(&input(file), &ReadOptions::default()).expect("well formed");
        let first = recording.get(0).expect("two samples");
        assert_eq!(first.time_ns, 100_250_000_000);
        assert_eq!(first.combined.point, Some(DVec2::new(0.25, 0.25)), "the origin moves to the top left");
        let direction = first.combined.direction.expect("told");
        assert!(direction.abs_diff_eq(DVec3::new(3.0, -4.0, -12.0) / 13.0, 1e-15));
        assert_eq!(first.right.direction, Some(DVec3::new(0.0, -0.6, -0.8)), "eye 0 is the right one");
        let origin_m = first.left.origin_m.expect("told");
        assert!(origin_m.abs_diff_eq(DVec3::new(-0.03, 0.02, 0.025), 1e-15));
        assert!(first.combined.valid && first.left.valid && first.right.valid);
        let second = recording.get(1).expect("two samples");
        assert_eq!(second.time_ns, 100_200_000_000, "the order of the file, not of time");
        assert!(!second.combined.valid && !second.left.valid && !second.right.valid);
        assert_eq!(second.combined.confidence, Some(0.3));
        assert_eq!(second.left.direction, None);
        assert_eq!(recording.extra_column("world_index"), Some([7.0, 7.0].as_slice()));
    }
}
