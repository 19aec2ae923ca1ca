//! CSV of Vive Pro Eye recordings by SRanipal and Unity: there is no standard, this is the layout with
//! `time_stamp(ms)`, `eye_valid_L`, `gaze_direct_L.x` and so on.
//!
//! `time_stamp(ms)` is the device's clock, 32 bits of ms that wrap and are often written signed, so that
//! it runs below zero. `time(100ns)` is the host's, in .NET ticks of its local time. The bits of
//! `eye_valid` say which values can be used. Gaze axes are x to the wearer's left, y up, z forward: the left
//! eye's origin has a positive x in recordings, and only so does gaze in the world stand still
//! while the head turns. The helmet's pose is Unity's: metres, and Euler angles in degrees applied z, x, y.

use super::axes::{metres, of_left_up_forward, of_unity, quaternion_of_unity_deg, told};
use super::table::{Col, Row, Table, UNIX_FROM_NET_TICKS, has_header, least_offset_ns, read_rows, unit_ns};
use super::{Format, Input, ReadOptions};
use crate::error::Result;
use crate::recording::{Recording, RecordingInfo, Space};
use crate::sample::{EyeSample, GazeSample, HeadPose};
use crate::time::Unwrapper;

/// The format.
pub const FORMAT: Format = Format { name: "sranipal-csv", matches, read };

const REQUIRED: [&str; 4] = ["time_stamp(ms)", "gaze_direct_l.x", "gaze_direct_l.y", "gaze_direct_l.z"];

/// Bits of `eye_valid`: SRanipal's `SingleEyeDataValidity`, counted from 0. Pupil position is bit 4.
const ORIGIN: u64 = 1;
const DIRECTION: u64 = 1 << 1;
const PUPIL: u64 = 1 << 2;
const OPENNESS: u64 = 1 << 3;

fn matches(_: &Input, head: &str) -> bool {
    has_header(head, &REQUIRED)
}

#[derive(Clone, Copy)]
struct EyeColumns {
    validity: Col,
    openness: Col,
    pupil: Col,
    origin: [Col; 3],
    direction: [Col; 3],
}

impl EyeColumns {
    fn take(table: &mut Table, eye: &str) -> Self {
        Self {
            validity: table.take(&format!("eye_valid_{eye}")),
            openness: table.take(&format!("openness_{eye}")),
            pupil: table.take(&format!("pupil_diameter_{eye}")),
            origin: table.take_xyz(&format!("gaze_origin_{eye}.{{}}")),
            direction: table.take_xyz(&format!("gaze_direct_{eye}.{{}}")),
        }
    }

    fn sample(&self, row: &Row) -> EyeSample {
        // Without a mask, what is not zero is valid.
        let mask = row.some(self.validity).map_or(u64::MAX, |mask| mask as u64);
        let has = |bit: u64| mask & bit != 0;
        let direction = told(of_left_up_forward(row.vector(self.direction)));
        EyeSample {
            valid: has(DIRECTION) && direction.is_some(),
            direction,
            origin_m: metres(of_left_up_forward(row.vector(self.origin))).filter(|_| has(ORIGIN)),
            pupil_mm: row.some(self.pupil).filter(|mm| has(PUPIL) && *mm >= 0.0),
            openness: row.some(self.openness).filter(|open| has(OPENNESS) && *open >= 0.0),
            ..EyeSample::default()
        }
    }
}

/// The two clocks of a row.
struct Clocks {
    device: Col,
    /// 1 ms, or what the options ask for.
    device_unit_ns: f64,
    ticks: Col,
    unwrapper: Unwrapper,
}

impl Clocks {
    /// Device time without wraps and the time of arrival since 1970, ns.
    fn read(&mut self, row: &Row) -> Option<(i64, Option<i64>)> {
        let received_ns = row
            .time_ns(self.ticks, 1.0)
            .and_then(|ticks| ticks.checked_sub(UNIX_FROM_NET_TICKS)?.checked_mul(100));
        let count = row.time_ns(self.device, 1.0)?;
        let wraps = i32::try_from(count).is_ok() || u32::try_from(count).is_ok();
        if !wraps || self.device_unit_ns != 1e6 {
            return Some((row.time_ns(self.device, self.device_unit_ns)?, received_ns));
        }
        Some((self.unwrapper.unwrap(count.cast_unsigned(), received_ns).time_ns, received_ns))
    }
}

fn clocks(device: Col, ticks: Col, device_unit_ns: f64) -> Clocks {
    Clocks { device, device_unit_ns, ticks, unwrapper: Unwrapper::new(32, false, 1_000_000) }
}

fn read(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let mut table = Table::open(input, &REQUIRED, &[])?;
    let (device, ticks) = (table.take("time_stamp(ms)"), table.take("time(100ns)"));
    let unit_ns = unit_ns(&table, device, options, 1e6)?;
    let [left, right, combined] = ["l", "r", "c"].map(|eye| EyeColumns::take(&mut table, eye));
    let (position, rotation) = (table.take_xyz("helmet_pos_{}"), table.take_xyz("helmet_rot_{}"));
    if rotation[0].is_some() {
        let note = "the helmet's angles were taken as Unity's: degrees, applied z, x, y, left-handed";
        table.notes.push(note.to_owned());
    }
    // On the host's clock, as far as the file tells it.
    let mut first = clocks(device, ticks, unit_ns);
    let offset_ns = least_offset_ns(&table, |row| {
        let (device_ns, received_ns) = first.read(row)?;
        Some((device_ns, received_ns?))
    });
    if offset_ns.is_some() {
        table.notes.push("the host's clock was taken as UTC, but may be local time".to_owned());
    }
    let mut clocks = clocks(device, ticks, unit_ns);
    let info = RecordingInfo {
        device: "HTC Vive Pro Eye (SRanipal)".to_owned(),
        space: Space::View,
        device_clock: "device (ms, 32 bit)".to_owned(),
        ..RecordingInfo::default()
    };
    read_rows(&table, info, |row| {
        let (device_ns, received_ns) = clocks.read(row).ok_or("there is no time")?;
        let time_ns = device_ns.saturating_add(offset_ns.unwrap_or(0));
        let head = quaternion_of_unity_deg(row.vector(rotation)).zip(told(of_unity(row.vector(position))));
        Ok(GazeSample {
            device_time_ns: Some(device_ns),
            received_ns: received_ns.unwrap_or(time_ns),
            time_ns,
            combined: combined.sample(row),
            left: left.sample(row),
            right: right.sample(row),
            head: head.map(|(world_from_view, position_m)| HeadPose { position_m, world_from_view }),
        })
    })
}

#[cfg(test)]
mod tests;
