//! A report descriptor, its length in front in two bytes, and after it any bytes as a report.
#![no_main]

use libfuzzer_sys::fuzz_target;
use macula_trackers::hid::{Layout, ReportDecoder, StandardDecoder};

fuzz_target!(|bytes: &[u8]| {
    let [low, high, rest @ ..] = bytes else { return };
    let length = usize::from(u16::from_le_bytes([*low, *high]));
    let Some((descriptor, report)) = rest.split_at_checked(length) else { return };
    let Ok(layout) = Layout::parse(descriptor) else { return };
    if let Ok(fields) = layout.raw_fields(report) {
        assert!(fields.count() <= report.len() * 8);
    }
    if let Ok(Some(sample)) = StandardDecoder::new(layout, None).decode(report, 0) {
        for eye in [sample.combined, sample.left, sample.right] {
            assert!(!eye.valid || eye.direction.is_some_and(|direction| direction.is_finite()));
        }
    }
});
