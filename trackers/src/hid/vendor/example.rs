//! An example to copy: a tracker within a headset, with firmware of one's own. Its ids are those that
//! pid.codes sets aside for tests, so it is no product.
//!
//! Input report 1, little-endian:
//!
//! | byte | type | meaning |
//! |---|---|---|
//! | 0 | u8 | report id, 1 |
//! | 1 | u8 | bit 0: left eye seen, bit 1: right eye seen |
//! | 2 | u32 | middle of the exposure, in units of 10 us; wraps after 11.9 h |
//! | 6 | 4 x i16 | tangents of the gaze: left right-wards, left up-wards, right the same; 16384 is 1 |
//! | 14 | 2 x u16 | pupil diameter of left and right eye, um; 0: not measured |
//! | 18 | 2 x u8 | openness of left and right eye, 255 is fully open |
//! | 20 | u8 | checksum: all bytes of the report add up to 0 modulo 256 |

use super::Vendor;
use crate::error::Result;
use crate::hid::bytes::Bytes;
use crate::hid::decode::Reject;
use crate::hid::decoder::{About, ReportDecoder, StartOptions};
use crate::hid::transport::Transport;
use crate::sample::{EyeSample, GazeSample};
use crate::time::Unwrapper;
use glam::DVec3;

/// The entry in the table.
pub const VENDOR: Vendor = Vendor { vendor_id: 0x1209, product_id: 0x0001, name: "example tracker", start };

const REPORT_ID: u8 = 1;
const REPORT_BYTES: usize = 21;
const TICK_NS: i64 = 10_000;
const TANGENT_ONE: f64 = 16384.0;

/// Decoder of the example's reports.
#[derive(Debug)]
struct Example {
    counter: Unwrapper,
    about: About,
}

/// A device that must be switched on is sent its feature report here.
fn start(_transport: &mut dyn Transport, _options: &StartOptions) -> Result<Box<dyn ReportDecoder>> {
    Ok(Box::new(Example { counter: Unwrapper::new(u32::BITS, false, TICK_NS), about: About::default() }))
}

impl ReportDecoder for Example {
    fn clock(&self) -> String {
        "tracker (10 us, 32 bit)".to_owned()
    }

    fn about(&self) -> &About {
        &self.about
    }

    fn decode(&mut self, report: &[u8], received_ns: i64) -> Result<Option<GazeSample>, Reject> {
        match report.first() {
            None => return Err(Reject::Empty),
            Some(&REPORT_ID) => {}
            Some(&id) => return Err(Reject::UnknownId(id)),
        }
        if report.len() != REPORT_BYTES {
            return Err(Reject::Length { got: report.len(), expected: REPORT_BYTES });
        }
        if report.iter().fold(0u8, |sum, byte| sum.wrapping_add(*byte)) != 0 {
            return Err(Reject::Checksum);
        }
        let bytes = Bytes(report);
        let ticks = bytes.u32(2)?;
        Ok(Some(GazeSample {
            device_time_ns: Some(self.counter.unwrap(ticks.into(), Some(received_ns)).time_ns),
            received_ns,
            time_ns: received_ns,
            left: eye(bytes, 0)?,
            right: eye(bytes, 1)?,
            ..GazeSample::default()
        }))
    }
}

/// Left is 0, right 1.
fn eye(bytes: Bytes<'_>, side: usize) -> Result<EyeSample, Reject> {
    let seen = bytes.u8(1)? >> side & 1 == 1;
    let tangent = |axis: usize| bytes.i16(6 + 4 * side + 2 * axis).map(|raw| f64::from(raw) / TANGENT_ONE);
    let direction = DVec3::new(tangent(0)?, tangent(1)?, -1.0);
    let pupil_um = bytes.u16(14 + 2 * side)?;
    Ok(EyeSample {
        valid: seen,
        direction: seen.then_some(direction),
        pupil_mm: (seen && pupil_um > 0).then(|| f64::from(pupil_um) / 1000.0),
        openness: Some(f64::from(bytes.u8(18 + side)?) / 255.0),
        ..EyeSample::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hid::transport::RecordedTransport;

    /// Left eye seen, 22.5 degrees to the right (tangent 0.41421) and 45 up, pupil 3.2 mm, open.
    const REPORT: [u8; REPORT_BYTES] =
        [1, 1, 0x10, 0x27, 0, 0, 0x82, 0x1a, 0, 0x40, 0, 0, 0, 0, 0x80, 0x0c, 0, 0, 255, 0, 0x60];

    fn decoder() -> Box<dyn ReportDecoder> {
        start(&mut RecordedTransport::default(), &StartOptions::default()).expect("nothing can fail")
    }

    #[test]
    fn a_report_tells_both_eyes() {
        let sample = decoder().decode(&REPORT, 5).expect("a good report").expect("a sample");
        assert_eq!((sample.device_time_ns, sample.received_ns), (Some(100_000_000), 5));
        let direction = sample.left.direction.expect("a left eye");
        assert!((direction.x - 22.5f64.to_radians().tan()).abs() < 1e-4);
        assert_eq!((direction.y, direction.z), (1.0, -1.0));
        assert_eq!((sample.left.pupil_mm, sample.left.openness), (Some(3.2), Some(1.0)));
        let closed = EyeSample { openness: Some(0.0), ..EyeSample::default() };
        assert_eq!(sample.right, closed);
    }

    #[test]
    fn the_clock_goes_on_where_its_counter_wraps() {
        let mut decoder = decoder();
        let mut at = |ticks: u32, received_ns| {
            let mut report = REPORT;
            report[2..6].copy_from_slice(&ticks.to_le_bytes());
            report[20] = report[..20].iter().fold(0u8, |sum, byte| sum.wrapping_sub(*byte));
            decoder.decode(&report, received_ns).expect("a good report").and_then(|it| it.device_time_ns)
        };
        assert_eq!(at(u32::MAX, 0), Some(i64::from(u32::MAX) * TICK_NS));
        assert_eq!(at(99, 1_000_000), Some((i64::from(u32::MAX) + 100) * TICK_NS));
    }

    #[test]
    fn broken_reports_are_rejected() {
        let mut decoder = decoder();
        assert_eq!(decoder.decode(&[], 0), Err(Reject::Empty));
        assert_eq!(decoder.decode(&[2], 0), Err(Reject::UnknownId(2)));
        assert_eq!(decoder.decode(&REPORT[..20], 0), Err(Reject::Length { got: 20, expected: 21 }));
        for byte in 1..REPORT_BYTES {
            let mut report = REPORT;
            report[byte] ^= 0x10;
            assert_eq!(decoder.decode(&report, 0), Err(Reject::Checksum), "byte {byte}");
        }
    }
}
