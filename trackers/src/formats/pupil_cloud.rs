//! Pupil Labs Neon and Invisible: `gaze.csv` of Pupil Cloud and of Neon Player (which has three columns
//! only), and `3d_eye_states.csv` (pupil-docs, neon/data-collection/data-format).
//!
//! Times are UTC ns of the companion device. Gaze is in px of the scene camera, azimuth positive to the
//! right and elevation positive up, both in degrees from the camera's axis.

use super::axes::{metres, of_azimuth_deg, of_camera, told};
use super::table::{Row, Table, has_header, read_rows, unit_ns};
use super::{Format, Input, ReadOptions};
use crate::error::Result;
use crate::recording::{Recording, RecordingInfo, Space};
use crate::sample::{EyeSample, GazeSample};
use glam::DVec2;

/// Gaze in the scene camera.
pub const FORMAT: Format = Format { name: "pupil-cloud-csv", matches, read };
/// The optical axes of the two eyes.
pub const EYE_STATE_FORMAT: Format =
    Format { name: "pupil-eye-state-csv", matches: matches_eye_states, read: read_eye_states };

const REQUIRED: [&str; 3] = ["timestamp [ns]", "gaze x [px]", "gaze y [px]"];
const EYE_STATES_REQUIRED: [&str; 3] = ["timestamp [ns]", "optical axis left x", "optical axis right x"];

fn matches(_: &Input, head: &str) -> bool {
    has_header(head, &REQUIRED)
}

fn matches_eye_states(_: &Input, head: &str) -> bool {
    has_header(head, &EYE_STATES_REQUIRED)
}

fn info() -> RecordingInfo {
    RecordingInfo {
        device: "Pupil Labs Neon or Invisible".to_owned(),
        space: Space::SceneCamera,
        device_clock: "UTC of the companion device".to_owned(),
        ..RecordingInfo::default()
    }
}

fn read(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let mut table = Table::open(input, &REQUIRED, &REQUIRED)?;
    let time = table.take("timestamp");
    let size_px = options.screen.map(|screen| screen.size_px);
    let px = if size_px.is_some() {
        ["gaze x", "gaze y"].map(|name| table.take(name))
    } else {
        let note = "the file does not tell the size of the scene camera's picture: gaze points stay in px, \
            in the extra columns gaze x [px] and gaze y [px]";
        table.notes.push(note.to_owned());
        ["gaze x", "gaze y"].map(|name| table.find(name))
    };
    let angles = ["azimuth", "elevation"].map(|name| table.take(name));
    let (worn, blink) = (table.take("worn"), table.find("blink id"));
    if blink.is_some() {
        table.notes.push("samples within a blink count as not valid".to_owned());
    }
    let unit_ns = unit_ns(&table, time, options, 1.0)?;
    read_rows(&table, info(), |row| {
        let time_ns = row.time_ns(time, unit_ns).ok_or("there is no time")?;
        let px = DVec2::from(px.map(|column| row.number(column)));
        let [azimuth, elevation] = angles.map(|column| row.number(column));
        let seen = !row.is(worn, "0") && !row.is(worn, "false") && row.text(blink).is_empty();
        let combined = EyeSample {
            valid: seen && px.is_finite(),
            direction: of_azimuth_deg(azimuth, elevation),
            point: size_px.map(|size_px| px / size_px).filter(|point| point.is_finite()),
            ..EyeSample::default()
        };
        Ok(GazeSample { combined, ..GazeSample::at(time_ns) })
    })
}

fn read_eye_states(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let mut table = Table::open(input, &EYE_STATES_REQUIRED, &[])?;
    let time = table.take("timestamp");
    let eyes = ["left", "right"].map(|side| {
        let axis = table.take_xyz(&format!("optical axis {side} {{}}"));
        let center = table.take_xyz(&format!("eye ball center {side} {{}}"));
        (axis, center, table.take(&format!("pupil diameter {side}")))
    });
    table.notes.push("directions are optical axes, some degrees away from the lines of sight".to_owned());
    let unit_ns = unit_ns(&table, time, options, 1.0)?;
    read_rows(&table, info(), |row: &Row| {
        let time_ns = row.time_ns(time, unit_ns).ok_or("there is no time")?;
        let [left, right] = eyes.map(|(axis, center, pupil)| {
            let direction = told(of_camera(row.vector(axis)));
            let origin_m = metres(of_camera(row.vector(center)));
            let pupil_mm = row.some(pupil);
            EyeSample { valid: direction.is_some(), direction, origin_m, pupil_mm, ..EyeSample::default() }
        });
        Ok(GazeSample { left, right, ..GazeSample::at(time_ns) })
    })
}

#[cfg(test)]
mod tests {
    use super::super::testing::input;
    use super::*;
    use crate::recording::Screen;
    use glam::DVec3;

    #[test]
    fn azimuth_and_elevation_become_directions() {
        let file = "section id,recording id,timestamp [ns],gaze x [px],gaze y [px],worn,fixation id,blink id,\
            azimuth [deg],elevation [deg]\n\
            a,b,1700000000000000001,400,300,1,5,,30,0\n\
            a,b,1700000000005000002,400,300,1,,2,0,-90\n\
            a,b,1700000000010000003,400,300,0,,,0,0\n\
            a,b,1700000000015000004,,,1,,,,\n";
        let screen = Screen { size_px: DVec2::new(1600.0, 1200.0), size_m: DVec2::ONE, distance_m: 1.0 };
        let options = ReadOptions { screen: Some(screen), ..ReadOptions::default() };
        let recording = read(&input(file), &options).expect("well formed");
        let samples: Vec<_> = recording.samples().map(|sample| sample.combined).collect();
        assert_eq!(recording.times_ns()[3], 1_700_000_000_015_000_004, "exact to the ns");
        assert_eq!(samples[0].point, Some(DVec2::splat(0.25)));
        let direction = samples[0].direction.expect("told");
        assert!(direction.abs_diff_eq(DVec3::new(0.5, 0.0, -0.75f64.sqrt()), 1e-15));
        assert!(samples[1].direction.expect("told").abs_diff_eq(DVec3::NEG_Y, 1e-15));
        let valid: Vec<_> = samples.iter().map(|sample| sample.valid).collect();
        assert_eq!(valid, [true, false, false, false], "a blink, not worn, no gaze");
        assert_eq!(recording.extra_column("fixation id").map(|ids| ids[0]), Some(5.0));
    }

    #[test]
    fn the_three_columns_of_neon_player_are_enough() {
        let file = "timestamp [ns],gaze x [px],gaze y [px]\n1000,10.5,20.25\n";
        let recording = read(&input(file), &ReadOptions::default()).expect("well formed");
        let sample = recording.get(0).expect("one");
        assert!(sample.combined.valid && sample.combined.point.is_none());
        assert_eq!(recording.extra_column("gaze y [px]"), Some([20.25].as_slice()));
        assert!(recording.info.notes[0].contains("stay in px"));
    }

    #[test]
    fn eye_states_tell_both_eyes() {
        let file = "section id,recording id,timestamp [ns],pupil diameter left [mm],pupil diameter right [mm],\
            eye ball center left x [mm],eye ball center left y [mm],eye ball center left z [mm],\
            eye ball center right x [mm],eye ball center right y [mm],eye ball center right z [mm],\
            optical axis left x,optical axis left y,optical axis left z,\
            optical axis right x,optical axis right y,optical axis right z,eyelid aperture left [mm]\n\
            a,b,5,3.5,3.25,-31,12,-40,32,12,-40,0.6,0,0.8,0,0.6,0.8,9.5\n";
        let recording = read_eye_states(&input(file), &ReadOptions::default()).expect("well formed");
        let sample = recording.get(0).expect("one");
        assert_eq!(sample.left.direction, Some(DVec3::new(0.6, 0.0, -0.8)));
        assert_eq!(sample.right.direction, Some(DVec3::new(0.0, -0.6, -0.8)));
        assert!(sample.left.origin_m.is_some_and(|m| m.abs_diff_eq(DVec3::new(-0.031, -0.012, 0.04), 1e-15)));
        assert_eq!((sample.left.pupil_mm, sample.right.pupil_mm), (Some(3.5), Some(3.25)));
        assert_eq!(recording.extra_column("eyelid aperture left [mm]"), Some([9.5].as_slice()));
    }
}
