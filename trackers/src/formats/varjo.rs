//! Varjo: the CSV of Varjo Base, and the log of the Unity example (semicolons, vectors as `(x, y, z)`).
//!
//! Axes are x right, y up, z forward; origins in m (developer.varjo.com, eye tracking). Status of the gaze: 0
//! invalid, 1 while it adjusts, 2 valid; of an eye: 0 invalid, 1 visible, 2 compensated, 3 tracked.

use super::axes::{of_unity, quaternion_of_unity, told};
use super::table::{Col, Row, Table, UNIX_FROM_NET_TICKS, has_header, least_offset_ns, read_rows, unit_ns};
use super::{Format, Input, ReadOptions};
use crate::error::Result;
use crate::recording::{Recording, RecordingInfo, Space};
use crate::sample::{EyeSample, GazeSample, HeadPose};
use glam::DVec3;

/// Of Varjo Base.
pub const FORMAT: Format = Format { name: "varjo-csv", matches, read };
/// Of the Unity example.
pub const UNITY_FORMAT: Format = Format { name: "varjo-unity-csv", matches: matches_unity, read: read_unity };

const REQUIRED: [&str; 3] = ["raw_timestamp", "gaze_forward_x", "status"];
const UNITY_REQUIRED: [&str; 3] = ["capturetime", "combinedgazeforward", "gazestatus"];
/// The least status of an eye, and of both, whose gaze can be used.
const USABLE: f64 = 2.0;
/// .NET ticks of 100 ns in the ms of the log's time.
const TICKS_PER_MS: i64 = 10_000;

fn matches(_: &Input, head: &str) -> bool {
    has_header(head, &REQUIRED)
}

fn matches_unity(_: &Input, head: &str) -> bool {
    has_header(head, &UNITY_REQUIRED)
}

fn info() -> RecordingInfo {
    RecordingInfo {
        device: "Varjo".to_owned(),
        space: Space::View,
        device_clock: "Varjo (ns)".to_owned(),
        ..RecordingInfo::default()
    }
}

fn read(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let mut table = Table::open(input, &REQUIRED, &[])?;
    let (device, unix) = (table.take("raw_timestamp"), table.take("relative_to_unix_epoch_timestamp"));
    let rays = ["gaze", "left", "right"].map(|name| {
        let forward = table.take_xyz(&format!("{name}_forward_{{}}"));
        (forward, table.take_xyz(&format!("{name}_origin_{{}}")))
    });
    let status = ["status", "left_status", "right_status"].map(|name| table.take(name));
    let [left_mm, right_mm] =
        ["left", "right"].map(|side| table.take(&format!("{side}_pupil_diameter_in_mm")));
    let [left_open, right_open] = ["left", "right"].map(|side| table.take(&format!("{side}_eye_openness")));
    let unit_ns = unit_ns(&table, device, options, 1.0)?;
    read_rows(&table, info(), |row| {
        let device_ns = row.time_ns(device, unit_ns).ok_or("there is no time")?;
        let time_ns = row.time_ns(unix, unit_ns).unwrap_or(device_ns);
        let [mut combined, mut left, mut right] = rays.map(|(forward, origin)| EyeSample {
            direction: told(of_unity(row.vector(forward))),
            origin_m: Some(of_unity(row.vector(origin))).filter(|origin| origin.is_finite()),
            ..EyeSample::default()
        });
        for (eye, status) in [&mut combined, &mut left, &mut right].into_iter().zip(status) {
            eye.valid = eye.direction.is_some() && row.some(status).is_none_or(|status| status >= USABLE);
        }
        (left.pupil_mm, right.pupil_mm) = (row.some(left_mm), row.some(right_mm));
        (left.openness, right.openness) = (row.some(left_open), row.some(right_open));
        let received_ns = time_ns;
        Ok(GazeSample {
            device_time_ns: Some(device_ns),
            received_ns,
            time_ns,
            combined,
            left,
            right,
            head: None,
        })
    })
}

/// The numbers of `(1.0, 2.0, 3.0)`; with decimal commas `(1,0, 2,0, 3,0)`. NaN where there are too few.
fn vector_of<const N: usize>(field: &[u8]) -> [f64; N] {
    let text = String::from_utf8_lossy(field);
    let inner = text.trim().trim_start_matches('(').trim_end_matches(')');
    let separator = if inner.contains(", ") { ", " } else { "," };
    let mut parts = inner.split(separator);
    std::array::from_fn(|_| {
        let number = parts.next().map(|part| part.trim().replace(',', "."));
        number.and_then(|number| number.parse().ok()).unwrap_or(f64::NAN)
    })
}

fn vector(row: &Row, column: Col) -> DVec3 {
    of_unity(DVec3::from(vector_of(row.text(column))))
}

fn read_unity(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let mut table = Table::open(input, &UNITY_REQUIRED, &[])?;
    let (device, log) = (table.take("capturetime"), table.take("logtime"));
    let (position, rotation) = (table.take("hmdposition"), table.take("hmdrotation"));
    let rays = [("combinedgaze", "gazestatus"), ("lefteye", "lefteyestatus"), ("righteye", "righteyestatus")]
        .map(|(name, status)| {
            let forward = table.take(&format!("{name}forward"));
            (forward, table.take(&format!("{name}position")), table.take(status))
        });
    let [left_mm, right_mm] = ["left", "right"].map(|side| table.take(&format!("{side}pupildiameterinmm")));
    let unit_ns = unit_ns(&table, device, options, 1.0)?;
    let logged_ns = |row: &Row| -> Option<i64> {
        let ticks = row.time_ns(log, 1.0)?.checked_mul(TICKS_PER_MS)?;
        ticks.checked_sub(UNIX_FROM_NET_TICKS)?.checked_mul(100)
    };
    let offset_ns = least_offset_ns(&table, |row| row.time_ns(device, unit_ns).zip(logged_ns(row)));
    if offset_ns.is_some() {
        table.notes.push("the log's clock was taken as UTC, but may be local time".to_owned());
    }
    read_rows(&table, info(), |row| {
        let device_ns = row.time_ns(device, unit_ns).ok_or("there is no time")?;
        let time_ns = device_ns.saturating_add(offset_ns.unwrap_or(0));
        let [combined, mut left, mut right] = rays.map(|(forward, origin, status)| {
            let direction = told(vector(row, forward));
            let valid = direction.is_some() && (status.is_none() || row.is(status, "valid"));
            let origin_m = Some(vector(row, origin)).filter(|origin| origin.is_finite());
            EyeSample { valid, direction, origin_m, ..EyeSample::default() }
        });
        (left.pupil_mm, right.pupil_mm) = (row.some(left_mm), row.some(right_mm));
        let position_m = Some(vector(row, position)).filter(|position| position.is_finite());
        let head = quaternion_of_unity(vector_of(row.text(rotation))).zip(position_m);
        Ok(GazeSample {
            device_time_ns: Some(device_ns),
            received_ns: logged_ns(row).unwrap_or(time_ns),
            time_ns,
            combined,
            left,
            right,
            head: head.map(|(world_from_view, position_m)| HeadPose { position_m, world_from_view }),
        })
    })
}

#[cfg(test)]
mod tests;
