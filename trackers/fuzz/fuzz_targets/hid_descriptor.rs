//! Any bytes as a report descriptor. Seeds: real descriptors.
#![no_main]

use libfuzzer_sys::fuzz_target;
use macula_trackers::hid::{Layout, ReportKind};

fuzz_target!(|descriptor: &[u8]| {
    let Ok(layout) = Layout::parse(descriptor) else { return };
    for report in &layout.reports {
        let mut bytes = vec![0xff; report.bytes];
        if let Some(first) = bytes.first_mut().filter(|_| layout.has_ids) {
            *first = report.id;
        }
        match report.kind {
            ReportKind::Input => assert!(bytes.is_empty() || layout.decode(&bytes).is_ok()),
            ReportKind::Feature => assert!(bytes.is_empty() || layout.decode_feature(&bytes).is_ok()),
        }
    }
});
