//! Tab-separated recordings of a Pico Neo 3 Pro Eye by Unity, with columns as in `Combine Eye Gaze
//! Vector. x`.
//!
//! `Timeline` is in s. The combined gaze vector is Unity's (z forward); the vector of the foveation beside it
//! has z backward, so which way z goes is asked of the column itself. The headset has no gaze of the
//! single eyes, but their openness. `Head Rotation` is Unity's Euler angles in degrees.

use super::axes::{of_unity, quaternion_of_unity_deg, told};
use super::table::{Col, Table, has_header, read_rows, unit_ns};
use super::{Format, Input, ReadOptions};
use crate::error::Result;
use crate::recording::{Recording, RecordingInfo, Space};
use crate::sample::{EyeSample, GazeSample, HeadPose};
use glam::DVec3;

/// The format.
pub const FORMAT: Format = Format { name: "pico-csv", matches, read };

const COMBINED: &str = "combine eye gaze vector. {}";
const FOVEATED: &str = "foveated gaze direction. {}";

fn matches(_: &Input, head: &str) -> bool {
    has_header(head, &["timeline", "combine eye gaze vector. x"])
        || has_header(head, &["timeline", "foveated gaze direction. x"])
}

/// 1 where forward is positive z, -1 where it is negative.
fn forward(table: &Table, z: Col) -> f64 {
    let mut sum = 0i64;
    table.for_rows(|row| {
        let z = row.number(z);
        sum += i64::from(z > 0.0) - i64::from(z < 0.0);
        true
    });
    if sum < 0 { -1.0 } else { 1.0 }
}

fn read(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let mut table = Table::open(input, &["timeline"], &[])?;
    let time = table.take("timeline");
    let mut gaze = table.take_xyz(COMBINED);
    if gaze.contains(&None) {
        gaze = table.take_xyz(FOVEATED);
        table.notes.push("gaze is the direction of the foveation; there is no combined vector".to_owned());
    }
    let forward = forward(&table, gaze[2]);
    let origin = table.take_xyz("combine eye gaze point. {}");
    let openness = ["left", "right"].map(|side| table.take(&format!("{side} eye gaze openness")));
    let (position, rotation) = (table.take_xyz("head position. {}"), table.take_xyz("head rotation. {}"));
    table
        .notes
        .push("the head's angles were taken as Unity's: degrees, applied z, x, y, left-handed".to_owned());
    let unit_ns = unit_ns(&table, time, options, 1e9)?;
    let info = RecordingInfo {
        device: "Pico Neo 3 Pro Eye".to_owned(),
        space: Space::View,
        device_clock: "Unity timeline (s)".to_owned(),
        ..RecordingInfo::default()
    };
    read_rows(&table, info, |row| {
        let time_ns = row.time_ns(time, unit_ns).ok_or("there is no time")?;
        let direction = told(of_unity(row.vector(gaze) * DVec3::new(1.0, 1.0, forward)));
        let origin_m = told(of_unity(row.vector(origin)));
        let combined = EyeSample { valid: direction.is_some(), direction, origin_m, ..EyeSample::default() };
        let [left, right] =
            openness.map(|column| EyeSample { openness: row.some(column), ..EyeSample::default() });
        let head = quaternion_of_unity_deg(row.vector(rotation)).zip(told(of_unity(row.vector(position))));
        let head = head.map(|(world_from_view, position_m)| HeadPose { position_m, world_from_view });
        Ok(GazeSample { combined, left, right, head, ..GazeSample::at(time_ns) })
    })
}

#[cfg(test)]
mod tests {
    use super::super::testing::input;
    use super::*;

    const HEADER: &str = "User Name\tTimeline\tHead Position. x\tHead Position. y\tHead Position. z\t\
        Head Rotation. x\tHead Rotation. y\tHead Rotation. z\tEye Left Blinking\tLeft Eye Gaze Openness\t\
        Right Eye Gaze Openness\tCombine Eye Gaze Point. x\tCombine Eye Gaze Point. y\t\
        Combine Eye Gaze Point. z\tCombine Eye Gaze Vector. x\tCombine Eye Gaze Vector. y\t\
        Combine Eye Gaze Vector. z\tFoveated Gaze Direction. x\tFoveated Gaze Direction. y\t\
        Foveated Gaze Direction. z\tNameOfLookedObject\n";

    #[test]
    fn unity_axes_become_view_space() {
        let rows = "A\t0.5\t1\t1.5\t-2\t0\t90\t0\tFalse\t1\t0.5\t0.001\t0.002\t0.03\t0.6\t0\t0.8\t0.6\t0\t-0.8\tbox\n\
            A\t0.51\t1\t1.5\t-2\t0\t90\t0\tTrue\t0\t0\t0\t0\t0\t0\t0\t0\t0\t0\t0\tbox\n";
        let recording =
            read(&input(format!("{HEADER}{rows}")), &ReadOptions::default()).expect("well formed");
        let sample = recording.get(0).expect("two");
        assert_eq!(sample.time_ns, 500_000_000);
        assert_eq!(sample.combined.direction, Some(DVec3::new(0.6, 0.0, -0.8)));
        assert_eq!(sample.combined.origin_m, Some(DVec3::new(0.001, 0.002, -0.03)));
        assert_eq!((sample.left.openness, sample.right.openness), (Some(1.0), Some(0.5)));
        let head = sample.head.expect("told");
        assert_eq!(head.position_m, DVec3::new(1.0, 1.5, 2.0));
        assert!((head.world_from_view * DVec3::NEG_Z).abs_diff_eq(DVec3::X, 1e-15));
        let blink = recording.get(1).expect("two");
        assert!(!blink.combined.valid && blink.combined.direction.is_none());
        assert_eq!(recording.extra_column("Eye Left Blinking"), Some([0.0, 1.0].as_slice()));
    }

    #[test]
    fn a_forward_that_is_negative_is_noticed() {
        let header = HEADER.replace("Combine Eye Gaze Vector", "Other");
        let row = "A\t0.5\t1\t1.5\t-2\t0\t0\t0\tFalse\t1\t1\t0\t0\t0\t9\t9\t9\t0.6\t0\t-0.8\tbox\n";
        let recording = read(&input(format!("{header}{row}")), &ReadOptions::default()).expect("well formed");
        let sample = recording.get(0).expect("one");
        assert_eq!(sample.combined.direction, Some(DVec3::new(0.6, 0.0, -0.8)));
    }
}
