//! Descriptors that lie, break off or ask for too much.

use super::{TRACKER, gaze_only, layout};
use crate::hid::{Layout, Role};

fn why(descriptor: &[u8]) -> String {
    Layout::parse(descriptor).expect_err("a bad descriptor").to_string()
}

#[test]
fn a_descriptor_that_breaks_off_says_where() {
    for length in 0..TRACKER.len() {
        let error = Layout::parse(&TRACKER[..length]).expect_err("a cut descriptor");
        assert!(error.at <= length, "{length}: {error}");
    }
    assert!(why(&[0x05]).contains("byte 0: ends within an item"));
    assert!(why(&[0xfe, 0x05]).contains("ends within an item"));
    assert!(why(&TRACKER[..TRACKER.len() - 1]).contains("leaves 1 collections open"));
}

#[test]
fn limits_hold() {
    assert!(why(&[0; 4097]).contains("longer than 4096"));
    // Sixteen collections in one another: the parser would copy 2^16 of them for each field.
    let nested = [[0xa1, 0x00].repeat(16), [0xc0].repeat(16)].concat();
    assert!(why(&nested).contains("nests collections deeper"));
    // 2^32 - 1 fields, and a product of size and count that overflows.
    let many = [0x15, 0, 0x25, 1, 0x75, 1, 0x97, 0xff, 0xff, 0xff, 0xff, 0x09, 0x21, 0x81, 0x02];
    assert!(why(&gaze_only(&many)).contains("makes the reports longer"));
    let wide = [0x77, 0xff, 0xff, 0xff, 0xff, 0x97, 0xff, 0xff, 0xff, 0xff, 0x81, 0x02];
    assert!(why(&gaze_only(&wide)).contains("makes the reports longer"));
    let empty = [0x15, 0, 0x25, 1, 0x75, 0, 0x97, 0xff, 0xff, 0xff, 0xff, 0x09, 0x21, 0x81, 0x02];
    assert!(why(&gaze_only(&empty)).contains("makes the reports longer"));
    // Each of 65535 fields of an array would hold a copy of 500 usages.
    let mut array = vec![0x15, 0, 0x25, 1, 0x75, 1, 0x96, 0xff, 0xff];
    array.extend([0x09, 0x21].repeat(500));
    array.extend([0x81, 0x00]);
    assert!(why(&gaze_only(&array)).contains("too many fields"));
    assert!(why(&[0xa4].repeat(9)).contains("pushes more than"));
}

#[test]
fn what_makes_no_sense_is_told() {
    assert!(why(&[0xc0]).contains("ends a collection that none began"));
    assert!(why(&[0xb4]).contains("pops a state that none pushed"));
    assert!(why(&[0x85, 0x00]).contains("report id outside"));
    assert!(why(&[0x86, 0x00, 0x01]).contains("report id outside"));
    assert!(why(&[0xa4, 0x85, 0x01, 0xb4]).contains("without"));
    assert!(why(&[0xf5, 0x00]).contains("unknown tag"));
    assert!(why(&[0xa9, 0x01]).contains("cannot be parsed"), "delimiters");
    // A mouse.
    let mouse = [0x05, 1, 0x09, 2, 0xa1, 1, 0x15, 0, 0x25, 1, 0x75, 8, 0x95, 1, 0x09, 0x30, 0x81, 2, 0xc0];
    assert!(why(&mouse).contains("this is no eye tracker"));
    assert!(why(&[]).contains("this is no eye tracker"));
}

#[test]
fn a_report_with_an_impossible_range_is_left_out() {
    let inverted = [0x15, 5, 0x25, 2, 0x75, 8, 0x09, 0x21, 0x09, 0x22, 0x81, 2];
    assert!(why(&gaze_only(&inverted)).contains("InvalidReportLogicalRange"));
    // Report 1 has one, report 2 is good.
    let mut two = vec![0x85, 1];
    two.extend(inverted);
    two.extend([0x85, 2, 0x25, 9, 0x09, 0x21, 0x09, 0x22, 0x81, 2]);
    let layout = layout(&gaze_only(&two));
    assert!(layout.decode(&[2, 6, 7]).is_ok_and(|decoded| decoded.raw(Role::GazeY) == Some(7)));
    assert!(layout.notes.iter().any(|note| note.contains("0x01 is left out")), "{:?}", layout.notes);
}

#[test]
fn fields_of_no_bits_and_of_too_many_are_passed_over() {
    let items = [
        0x15, 0, 0x25, 0x7f, 0x75, 0, 0x09, 0x21, 0x81, 2, // two of no bits
        0x75, 72, 0x95, 1, 0x09, 0x29, 0x81, 2, // one of 72
        0x75, 8, 0x95, 2, 0x09, 0x21, 0x09, 0x22, 0x81, 2,
    ];
    let layout = layout(&gaze_only(&items));
    let decoded = layout.decode(&[0, 0, 0, 0, 0, 0, 0, 0, 0, 11, 12]).expect("a report");
    assert_eq!((decoded.raw(Role::GazeX), decoded.raw(Role::GazeY)), (Some(11), Some(12)));
    assert_eq!(decoded.raw(Role::HeadRotationX), None);
}

#[test]
fn long_and_reserved_items_are_passed_over() {
    let mut items = vec![0xfe, 0x03, 0x99, 1, 2, 3, 0x0d, 0x55];
    items.extend([0x15, 0, 0x25, 0x7f, 0x75, 8, 0x09, 0x21, 0x09, 0x22, 0x81, 2]);
    assert!(layout(&gaze_only(&items)).has(Role::GazeY));
    // A page in four bytes.
    let page = [0x15, 0, 0x25, 0x7f, 0x75, 8, 0x07, 0x12, 0, 0, 0, 0x09, 0x21, 0x09, 0x22, 0x81, 2];
    assert!(layout(&gaze_only(&page)).has(Role::GazeY));
}
