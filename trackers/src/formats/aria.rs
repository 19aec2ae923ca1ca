//! Project Aria: `general_eye_gaze.csv` and `personalized_eye_gaze.csv` of its Machine Perception Services
//! (projectaria_tools, data formats). Angles are radians in the central pupil frame (x to the wearer's
//! left, y up, z forward), and the direction is `(tan yaw, tan pitch, 1)` there.

use super::axes::{of_left_up_forward, told};
use super::table::{Col, Table, has_header, read_rows, unit_ns};
use super::{Format, Input, ReadOptions};
use crate::error::Result;
use crate::recording::{Recording, RecordingInfo, Space};
use crate::sample::{EyeSample, GazeSample};
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;

/// The format.
pub const FORMAT: Format = Format { name: "aria-csv", matches, read };

const TIME: &str = "tracking_timestamp_us";

fn matches(_: &Input, head: &str) -> bool {
    has_header(head, &[TIME, "yaw_rads_cpf"]) || has_header(head, &[TIME, "left_yaw_rads_cpf"])
}

/// Straight through the frame's axes; `None` at a right angle and beyond.
fn direction(yaw_rad: f64, pitch_rad: f64) -> Option<DVec3> {
    let within = yaw_rad.abs() < FRAC_PI_2 && pitch_rad.abs() < FRAC_PI_2;
    let ray = DVec3::new(yaw_rad.tan(), pitch_rad.tan(), 1.0).normalize();
    within.then(|| of_left_up_forward(ray))
}

fn read(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let mut table = Table::open(input, &[TIME], &[])?;
    let time = table.take(TIME);
    let pitch = table.take("pitch_rads_cpf");
    let eyes: [(Col, Col, [Col; 3]); 3] = ["", "left_", "right_"].map(|side| {
        let origin = ["x", "y", "z"].map(|axis| table.take(&format!("t{axis}_{side}eye_cpf")));
        let own_pitch = table.take(&format!("{side}pitch_rads_cpf"));
        (table.take(&format!("{side}yaw_rads_cpf")), own_pitch.or(pitch), origin)
    });
    let unit_ns = unit_ns(&table, time, options, 1e3)?;
    let info = RecordingInfo {
        device: "Project Aria".to_owned(),
        space: Space::View,
        device_clock: "device time (us)".to_owned(),
        ..RecordingInfo::default()
    };
    read_rows(&table, info, |row| {
        let time_ns = row.time_ns(time, unit_ns).ok_or("there is no time")?;
        let [combined, left, right] = eyes.map(|(yaw, pitch, origin)| {
            let direction = direction(row.number(yaw), row.number(pitch));
            let origin_m = told(of_left_up_forward(row.vector(origin)));
            EyeSample { valid: direction.is_some(), direction, origin_m, ..EyeSample::default() }
        });
        Ok(GazeSample { combined, left, right, ..GazeSample::at(time_ns) })
    })
}

#[cfg(test)]
mod tests {
    use super::super::testing::input;
    use super::*;

    #[test]
    fn yaw_is_to_the_left_and_pitch_up() {
        let file = "tracking_timestamp_us,left_yaw_rads_cpf,right_yaw_rads_cpf,pitch_rads_cpf,depth_m,\
            tx_left_eye_cpf,ty_left_eye_cpf,tz_left_eye_cpf\n\
            2500000,0.7853981633974483,-0.7853981633974483,0,1.5,0.0315,0,0\n";
        let recording = read(&input(file), &ReadOptions::default()).expect("well formed");
        let sample = recording.get(0).expect("one");
        assert_eq!(sample.time_ns, 2_500_000_000);
        let half = 0.5f64.sqrt();
        assert!(sample.left.direction.is_some_and(|d| d.abs_diff_eq(DVec3::new(-half, 0.0, -half), 1e-15)));
        assert!(sample.right.direction.is_some_and(|d| d.abs_diff_eq(DVec3::new(half, 0.0, -half), 1e-15)));
        assert_eq!(sample.left.origin_m, Some(DVec3::new(-0.0315, 0.0, 0.0)));
        assert!(!sample.combined.valid, "the file does not combine the eyes");
        assert_eq!(recording.extra_column("depth_m"), Some([1.5].as_slice()));
    }

    #[test]
    fn the_older_layout_has_one_direction() {
        let file = "tracking_timestamp_us,yaw_rads_cpf,pitch_rads_cpf\n7,0,0.7853981633974483\n8,2.0,0\n";
        let recording = read(&input(file), &ReadOptions::default()).expect("well formed");
        let half = 0.5f64.sqrt();
        let combined = recording.get(0).expect("two").combined;
        assert!(combined.direction.is_some_and(|d| d.abs_diff_eq(DVec3::new(0.0, half, -half), 1e-15)));
        assert!(!recording.get(1).expect("two").combined.valid, "no eye turns so far");
    }
}
