//! Tobii Pro Glasses 3: `gazedata`, one JSON object a line, usually gzipped.
//!
//! The file's axes, as its values show: origin in the scene camera, x to the wearer's LEFT (the left eye
//! lies at positive x), y up, z forward, mm. `gaze2d` is a fraction of the scene picture, y down. A lost
//! sample has an empty `data`.

use super::rows::{Extras, Rejects, lines, ns_of};
use super::{Format, Input, ReadOptions};
use crate::error::{Error, Result};
use crate::recording::{Recording, RecordingInfo, Space};
use crate::sample::{EyeSample, GazeSample};
use glam::{DVec2, DVec3};
use serde::Deserialize;
use std::borrow::Cow;

/// The format.
pub const FORMAT: Format = Format { name: "tobii-glasses3-jsonl", matches, read };

/// Where the gaze rays meet, in the file's own axes.
const GAZE3D_COLUMNS: [&str; 3] = ["gaze3d_x_mm", "gaze3d_y_mm", "gaze3d_z_mm"];

#[derive(Deserialize)]
struct Line<'a> {
    #[serde(rename = "type", borrow)]
    kind: Cow<'a, str>,
    timestamp: f64,
    data: Option<Data>,
}

#[derive(Default, Deserialize)]
struct Data {
    gaze2d: Option<[f64; 2]>,
    gaze3d: Option<[f64; 3]>,
    eyeleft: Option<Eye>,
    eyeright: Option<Eye>,
}

#[derive(Default, Deserialize)]
struct Eye {
    gazeorigin: Option<[f64; 3]>,
    gazedirection: Option<[f64; 3]>,
    pupildiameter: Option<f64>,
}

fn matches(_: &Input, head: &str) -> bool {
    let gaze = head.contains("\"gaze2d\"") || head.contains("\"type\":\"gaze\"");
    gaze && head.trim_start().starts_with('{') && head.contains("\"timestamp\"")
}

/// From x left, y up, z forward to view space: half a turn about y.
fn view_of([x, y, z]: [f64; 3]) -> DVec3 {
    DVec3::new(-x, y, -z)
}

fn eye_of(eye: Option<Eye>) -> EyeSample {
    let eye = eye.unwrap_or_default();
    EyeSample {
        valid: eye.gazedirection.is_some(),
        origin_m: eye.gazeorigin.map(|mm| view_of(mm) * 1e-3),
        direction: eye.gazedirection.map(view_of),
        pupil_mm: eye.pupildiameter,
        ..EyeSample::default()
    }
}

fn read(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let mut recording = Recording::new(RecordingInfo {
        device: "Tobii Pro Glasses 3".into(),
        space: Space::SceneCamera,
        device_clock: "seconds since the recording began".into(),
        notes: vec![
            "points lie on the scene picture; directions and origins are turned from x left, y up, z forward"
                .into(),
        ],
        ..RecordingInfo::default()
    });
    let mut extras = Extras::new(GAZE3D_COLUMNS);
    let (mut broken, mut others) = (Rejects::default(), Rejects::default());
    for (number, text) in lines(input.text()) {
        if text.trim().is_empty() {
            continue;
        }
        let place = format_args!("line {number}");
        let line: Line = match serde_json::from_str(&text) {
            Ok(line) => line,
            Err(error) => {
                broken.add(place, error);
                continue;
            }
        };
        if line.kind != "gaze" {
            others.add(place, &line.kind);
            continue;
        }
        let Some(time_ns) = ns_of(line.timestamp, options.time_unit_s.unwrap_or(1.0)) else {
            broken.add(place, "its time is beyond 64 bits of nanoseconds");
            continue;
        };
        let data = line.data.unwrap_or_default();
        let point = data.gaze2d.map(DVec2::from);
        let index = recording.len();
        for (column, value) in data.gaze3d.into_iter().flatten().enumerate() {
            extras.set(column, index, value);
        }
        recording.push(&GazeSample {
            combined: EyeSample { valid: point.is_some(), point, ..EyeSample::default() },
            left: eye_of(data.eyeleft),
            right: eye_of(data.eyeright),
            ..GazeSample::at(time_ns)
        });
    }
    if recording.is_empty() {
        return Err(Error::file(&input.path, "holds no gaze sample; give the gazedata of the recording"));
    }
    extras.finish(&mut recording);
    broken.report(&mut recording, "lines are no complete JSON sample");
    others.report(&mut recording, "lines are of another kind than gaze");
    Ok(recording)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::{read_input, testing::agreement, testing::input};
    use crate::testing::shared;

    const GOOD: &str = r#"{"type":"gaze","timestamp":0.5,"data":{"gaze2d":[0.25,0.75],"gaze3d":[-100.0,-50.0,1000.0],"eyeleft":{"gazeorigin":[30.0,-10.0,-25.0],"gazedirection":[-0.6,0.0,0.8],"pupildiameter":3.5},"eyeright":{}}}"#;
    const LOST: &str = r#"{"type":"gaze","timestamp":0.51,"data":{}}"#;

    #[test]
    fn axes_units_and_lost_samples() {
        let text = format!("{GOOD}\n{LOST}\n");
        let recording = read_input(&input(&text), &ReadOptions::default()).expect("read");
        assert_eq!(recording.info.format, "tobii-glasses3-jsonl");
        let sample = recording.get(0).expect("first");
        assert_eq!(sample.time_ns, 500_000_000);
        assert_eq!(sample.combined.point, Some(DVec2::new(0.25, 0.75)));
        let left = EyeSample {
            valid: true,
            origin_m: Some(DVec3::new(-30.0, -10.0, 25.0) * 1e-3),
            direction: Some(DVec3::new(0.6, 0.0, -0.8)),
            pupil_mm: Some(3.5),
            ..EyeSample::default()
        };
        assert_eq!((sample.left, sample.right), (left, EyeSample::default()));
        assert_eq!(recording.extra_column("gaze3d_z_mm").expect("there")[0], 1000.0);
        let lost = recording.get(1).expect("second");
        assert_eq!(lost, GazeSample { ..GazeSample::at(510_000_000) });
        assert!(recording.info.skipped.is_empty());
    }

    #[test]
    fn broken_lines_are_counted() {
        let cut = &GOOD[..GOOD.len() - 9];
        let text = format!(
            "{GOOD}\r\n\nrubbish\n{{\"type\":\"imu\",\"timestamp\":1.0,\"data\":{{}}}}\n{LOST}\n{{\"type\":\"gaze\",\"timestamp\":1e300}}\n{cut}"
        );
        let recording = read_input(&input(&text), &ReadOptions::default()).expect("read");
        assert_eq!(recording.len(), 2);
        let skipped: Vec<_> = recording.info.skipped.iter().map(|skipped| skipped.rows).collect();
        assert_eq!(skipped, [3, 1]);
        assert!(recording.info.skipped[0].why.contains("line 3"), "{}", recording.info.skipped[0].why);
        assert!(recording.info.skipped[1].why.contains("line 4: imu"));
    }

    #[test]
    fn a_file_without_samples_is_an_error() {
        let text = "{\"type\":\"gaze\",\"timestamp\":";
        let error = read_input(&input(text), &ReadOptions::default()).expect_err("nothing in it");
        assert!(error.to_string().contains("no gaze sample"), "{error}");
    }

    /// Counts by `zcat gazedata.gz | wc -l`, `grep -c '"data":{}'`, and of the eyes by Python's JSON.
    #[test]
    fn the_real_file_reads() {
        let Some(path) = shared("data/gaze/eyedentify3d_tobii_glasses3/gazedata.gz") else { return };
        let recording = crate::formats::read(&path, &ReadOptions::default()).expect("read");
        assert_eq!(recording.len(), 6547);
        assert_eq!(recording.samples().filter(|sample| !sample.combined.valid).count(), 412);
        assert_eq!(recording.samples().filter(|sample| sample.left.valid).count(), 5960);
        assert_eq!(recording.samples().filter(|sample| sample.right.valid).count(), 5522);
        assert!(recording.info.skipped.is_empty());
        assert!(recording.rate_hz().is_some_and(|rate| (rate - 100.0).abs() < 1.0));
        let agreement = agreement(&recording);
        assert!(agreement.x > 0.9 && agreement.y < -0.9, "{agreement}");
        for sample in recording.samples() {
            assert!(sample.left.origin_m.is_none_or(|at| at.x < 0.0), "the left eye lies to the left");
            assert!(sample.left.direction.is_none_or(|direction| direction.z < 0.0));
        }
    }
}
