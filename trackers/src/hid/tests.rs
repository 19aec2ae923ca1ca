//! The codec against descriptors and reports put together by hand.

mod fuzz;
mod hostile;

use super::*;
use crate::testing::shared;
use glam::{DVec2, DVec3};

/// Eye tracker, tracking data in report 1: a clock of eight bytes in us, gaze and both eyes in um, the
/// positions marked as constants. Report 2: configuration. Report 3: status, both ways. Report 4: mode.
#[rustfmt::skip]
pub(super) const TRACKER: &[u8] = &[
    0x05, 0x12, 0x09, 0x01, 0xa1, 0x01, // page, Eye Tracker, application
    0x85, 0x01, 0x09, 0x10, 0xa1, 0x02, // report 1, Tracking Data, logical
    0x15, 0x00, 0x26, 0xff, 0x00, 0x66, 0x01, 0x10, 0x55, 0x0a, // 0..255, 10^-6 s
    0x75, 0x08, 0x95, 0x08, 0x09, 0x20, 0x81, 0x02, // 8 x 8 bits, Sensor Timestamp
    0x17, 0x80, 0x7b, 0xe1, 0xff, 0x27, 0x80, 0x84, 0x1e, 0x00, // -2000000..2000000
    0x65, 0x11, 0x55, 0x0c, 0x75, 0x20, 0x95, 0x02, // 10^-4 cm, 32 bits
    0x09, 0x24, 0xa1, 0x00, 0x09, 0x21, 0x09, 0x22, 0x81, 0x03, 0xc0, // Gaze Point: X Y
    0x95, 0x03,
    0x09, 0x25, 0xa1, 0x00, 0x09, 0x21, 0x09, 0x22, 0x09, 0x23, 0x81, 0x03, 0xc0, // left eye
    0x09, 0x26, 0xa1, 0x00, 0x09, 0x21, 0x09, 0x22, 0x09, 0x23, 0x81, 0x03, 0xc0, // right eye
    0xc0,
    0x85, 0x02, 0x09, 0x12, 0xa1, 0x02, // report 2, Configuration
    0x15, 0x00, 0x27, 0xff, 0xff, 0xff, 0x7f, 0x95, 0x02,
    0x0a, 0x04, 0x02, 0x0a, 0x05, 0x02, 0xb1, 0x03, 0xc0, // Calibrated Screen Width, Height
    0x85, 0x03, 0x65, 0x00, 0x55, 0x00, 0x95, 0x01, // report 3, no unit
    0x09, 0x13, 0xa1, 0x02, 0x75, 0x08, 0x25, 0x04, 0x0a, 0x01, 0x03, 0xb1, 0x02, // status
    0x75, 0x10, 0x27, 0xff, 0xff, 0x00, 0x00, 0x66, 0x01, 0xf0, 0x0a, 0x00, 0x03, 0xb1, 0x02, 0xc0, // Hz
    0x09, 0x13, 0xa1, 0x02, 0x75, 0x08, 0x25, 0x04, 0x0a, 0x01, 0x03, 0x81, 0x02, // the same as input
    0x75, 0x10, 0x27, 0xff, 0xff, 0x00, 0x00, 0x0a, 0x00, 0x03, 0x81, 0x02, 0xc0,
    0x85, 0x04, 0x09, 0x14, 0xa1, 0x02, 0x65, 0x00, // report 4, Control
    0x75, 0x08, 0x25, 0x07, 0x0a, 0x00, 0x04, 0xb1, 0x02, 0xc0, // Device Mode Request
    0xc0,
];

/// A report 1 of [`TRACKER`].
pub(super) fn report(time_us: u64, values: [i32; 8]) -> Vec<u8> {
    let mut report = vec![1];
    report.extend(time_us.to_le_bytes());
    report.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    report
}

/// A descriptor with gaze X and Y of these items, which end in an Input of two fields.
fn gaze_only(items: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0x05, 0x12, 0x09, 0x01, 0xa1, 0x01, 0x09, 0x24, 0xa1, 0x00, 0x95, 0x02];
    bytes.extend_from_slice(items);
    bytes.extend([0xc0, 0xc0]);
    bytes
}

fn layout(descriptor: &[u8]) -> Layout {
    Layout::parse(descriptor).expect("a good descriptor")
}

#[test]
fn the_saved_descriptors_tell_gaze_eyes_and_time() {
    let Some(folder) = shared("data/hid") else { return };
    for (name, has_head) in
        [("gazehid_report_descriptor.bin", false), ("dmf_virtualeyegaze_report_descriptor.bin", true)]
    {
        let bytes = std::fs::read(folder.join(name)).expect("a saved descriptor");
        let layout = layout(&bytes);
        for role in [Role::GazeX, Role::GazeY, Role::LeftX, Role::LeftZ, Role::RightY, Role::RightZ] {
            assert!(layout.has(role), "{name}: {role:?}");
        }
        assert_eq!(layout.has(Role::HeadZ), has_head, "{name}");
        let (bits, tick_ns) = layout.timestamp().expect("a clock");
        assert_eq!((bits, tick_ns.round()), (64, 1000.0), "{name}");
        let tracking = layout.find(ReportKind::Input, Role::GazeX).expect("tracking data");
        assert_eq!((tracking.id, tracking.bytes), (0x10, 65), "{name}");
        let lengths: Vec<_> = layout
            .reports
            .iter()
            .filter(|report| report.kind == ReportKind::Feature)
            .map(|report| (report.id, report.bytes))
            .collect();
        assert_eq!(lengths, [(0x11, 22), (0x12, 19), (0x13, 4), (0x14, 2)], "{name}");
        assert_eq!(layout.find(ReportKind::Input, Role::ConfigurationStatus).map(|r| r.id), Some(0x13));
    }
}

#[test]
fn a_report_tells_time_gaze_and_eyes() {
    let layout = layout(TRACKER);
    let (um, gaze_um) = (600_000, [150_000, 90_000]);
    let bytes = report(1_000_000, [gaze_um[0], gaze_um[1], -31_500, 4000, um, 31_500, -4000, um]);
    let decoded = layout.decode(&bytes).expect("a good report");
    assert_eq!(decoded.device_time_ns(), Some(1_000_000_000));
    assert!(decoded.gaze_m().is_some_and(|gaze| gaze.abs_diff_eq(DVec2::new(0.15, 0.09), 1e-12)));
    // Down becomes up.
    let left = decoded.left_eye_m().expect("a left eye");
    assert!(left.abs_diff_eq(DVec3::new(-0.0315, -0.004, 0.6), 1e-12), "{left}");
    assert_eq!(decoded.raw(Role::RightX), Some(31_500));
    assert_eq!(decoded.raw(Role::HeadX), None);
    let sample = decoded.to_sample(Some(DVec2::new(0.6, 0.36)), 7);
    assert_eq!((sample.received_ns, sample.device_time_ns), (7, Some(1_000_000_000)));
    assert!(sample.combined.point.is_some_and(|point| point.abs_diff_eq(DVec2::splat(0.25), 1e-12)));
    assert!(sample.combined.valid && sample.left.valid && sample.right.valid);
    assert_eq!(sample.head, None);
}

#[test]
fn the_direction_leads_from_the_eye_to_the_gaze_point() {
    // Both eyes half a metre before the display and 0.2 m right of and below its corner. Gaze 0.5 m tan 10
    // degrees further right, then as far further down.
    let away_um = (0.5e6 * 10f64.to_radians().tan()).round() as i32;
    let eyes = [170_000, 200_000, 500_000, 230_000, 200_000, 500_000];
    let look = |x: i32, y: i32| {
        let values = [x, y, eyes[0], eyes[1], eyes[2], eyes[3], eyes[4], eyes[5]];
        let decoded = layout(TRACKER).decode(&report(0, values)).expect("a good report");
        decoded.to_sample(None, 0)
    };
    let (sine, cosine) = 10f64.to_radians().sin_cos();
    let right = look(200_000 + away_um, 200_000);
    assert_eq!(right.combined.point, None, "the display's size is not known");
    let direction = right.combined.direction.expect("a direction");
    assert!(direction.abs_diff_eq(DVec3::new(sine, 0.0, -cosine), 2e-6), "{direction}");
    let down = look(200_000, 200_000 + away_um).combined.direction.expect("a direction");
    assert!(down.abs_diff_eq(DVec3::new(0.0, -sine, -cosine), 2e-6), "{down}");
    // The left eye, 30 mm further left, turns right a little to look at the middle.
    let left = look(200_000, 200_000).left.direction.expect("a direction");
    assert!((left.x.atan2(-left.z) - 0.03f64.atan2(0.5)).abs() < 1e-9);
}

#[test]
fn numbers_that_say_nothing_are_absent_but_kept() {
    let layout = layout(TRACKER);
    let none = i32::MAX;
    let decoded = layout.decode(&report(5, [100, 2_000_001, none, none, none, 0, 0, 0])).expect("a report");
    assert_eq!(decoded.gaze_m(), None);
    assert_eq!(decoded.value(Role::GazeY), None);
    assert_eq!(decoded.raw(Role::GazeY), Some(2_000_001));
    assert_eq!(decoded.raw(Role::LeftX), Some(i64::from(none)));
    assert_eq!((decoded.left_eye_m(), decoded.right_eye_m()), (None, None));
    let sample = decoded.to_sample(Some(DVec2::ONE), 0);
    assert!(!sample.combined.valid && !sample.left.valid && sample.device_time_ns == Some(5000));
    // The bounds themselves are values.
    let decoded = layout.decode(&report(0, [-2_000_000, 2_000_000, 0, 0, 1, 0, 0, 0])).expect("a report");
    assert_eq!(decoded.gaze_m(), Some(DVec2::new(-2.0, 2.0)));
    let sample = decoded.to_sample(None, 0);
    assert!(sample.combined.valid && sample.left.valid && !sample.right.valid);
    assert_eq!(sample.combined.origin_m, sample.left.origin_m);
}

#[test]
fn broken_reports_are_rejected() {
    let layout = layout(TRACKER);
    let good = report(1, [0; 8]);
    assert_eq!(layout.decode(&[]), Err(Reject::Empty));
    assert_eq!(layout.decode(&[9, 0, 0]), Err(Reject::UnknownId(9)));
    for length in 1..good.len() {
        assert_eq!(layout.decode(&good[..length]), Err(Reject::Length { got: length, expected: 41 }));
    }
    let long = [good.as_slice(), &[0]].concat();
    assert_eq!(layout.decode(&long), Err(Reject::Length { got: 42, expected: 41 }));
    // Report 2 exists, but not as an input.
    assert_eq!(layout.decode(&[2; 9]), Err(Reject::UnknownId(2)));
}

#[test]
fn status_is_told_both_ways() {
    let layout = layout(TRACKER);
    for decoded in [layout.decode(&[3, 4, 0xe8, 0x03]), layout.decode_feature(&[3, 4, 0xe8, 0x03])] {
        let decoded = decoded.expect("a status report");
        let status = decoded.status().expect("a status");
        assert_eq!(status.configuration, Some(ConfigurationStatus::UserCalibrationNeeded));
        assert_eq!(status.sampling_hz, Some(1000.0));
        assert!(!decoded.is_tracking());
    }
    assert!(layout.decode(&report(0, [0; 8])).is_ok_and(|decoded| decoded.is_tracking()));
}

#[test]
fn features_are_read_and_modes_asked_for() {
    let layout = layout(TRACKER);
    let mut configuration = vec![2];
    configuration.extend(527_000u32.to_le_bytes());
    configuration.extend(296_000u32.to_le_bytes());
    let told = layout.decode_feature(&configuration).expect("a configuration").configuration();
    assert!(told.screen_m().is_some_and(|size| size.abs_diff_eq(DVec2::new(0.527, 0.296), 1e-12)));
    assert_eq!(layout.mode_report(ModeRequest::GAZE.and(ModeRequest::HEAD)), Some(vec![4, 5]));
    assert_eq!(layout.feature_with(Role::ScreenWidth), Some(vec![2, 0, 0, 0, 0, 0, 0, 0, 0]));
    assert_eq!(layout.feature_with(Role::TrackerQuality), None);
}

#[test]
fn clocks_may_have_any_width_and_unit() {
    let clock = |items: &[u8]| {
        let mut bytes = vec![0x05, 0x12, 0x09, 0x01, 0xa1, 0x01, 0x09, 0x10, 0xa1, 0x02, 0x15, 0x00];
        bytes.extend([0x27, 0xff, 0xff, 0xff, 0x7f]);
        bytes.extend_from_slice(items);
        bytes.extend([0x09, 0x24, 0xa1, 0x00, 0x75, 0x08, 0x95, 0x02, 0x09, 0x21, 0x09, 0x22, 0x81, 0x02]);
        bytes.extend([0xc0, 0xc0, 0xc0]);
        layout(&bytes)
    };
    // 1 x 32 bits in 10^-4 s; 1 x 64 bits in ns (the exponent as a signed byte); 4 x 8 bits without a
    // unit, which means us.
    let narrow = clock(&[0x66, 0x01, 0x10, 0x55, 0x0c, 0x75, 0x20, 0x95, 0x01, 0x09, 0x20, 0x81, 0x02]);
    let decoded = narrow.decode(&[0xff, 0xff, 0xff, 0xff, 1, 2]).expect("a report");
    assert_eq!(decoded.device_time_ns(), Some(0xffff_ffff * 100_000));
    let wide = clock(&[0x66, 0x01, 0x10, 0x55, 0xf7, 0x75, 0x40, 0x95, 0x01, 0x09, 0x20, 0x81, 0x02]);
    let decoded = wide.decode(&[1, 0, 0, 0, 0, 0, 0, 0x10, 1, 2]).expect("a report");
    assert_eq!(decoded.device_time_ns(), Some(0x1000_0000_0000_0001));
    let bytes = clock(&[0x75, 0x08, 0x95, 0x04, 0x09, 0x20, 0x81, 0x02]);
    let decoded = bytes.decode(&[0, 0, 1, 0, 1, 2]).expect("a report");
    assert_eq!(decoded.device_time_ns(), Some(65_536_000));
    assert_eq!(bytes.timestamp().map(|(bits, _)| bits), Some(32));
    assert!(bytes.notes.iter().any(|note| note.contains("microseconds are assumed")), "{:?}", bytes.notes);
    // What i64 ns cannot hold is no time.
    let decoded = layout(TRACKER).decode(&report(u64::MAX, [0; 8])).expect("a report");
    assert_eq!((decoded.device_time_ns(), decoded.raw(Role::Timestamp)), (None, Some(-1)));
}

#[test]
fn units_and_physical_ranges_scale() {
    let metres = |items: &[u8], report: &[u8]| {
        let decoded = layout(&gaze_only(items)).decode(report).expect("a report");
        decoded.gaze_m().expect("a gaze point")
    };
    let input = |mut items: Vec<u8>| {
        items.extend([0x09, 0x21, 0x09, 0x22, 0x81, 0x02]);
        items
    };
    // Thousandths of an inch, 16 bits.
    let inches = input(vec![0x15, 0x00, 0x26, 0xff, 0x7f, 0x65, 0x13, 0x55, 0x0d, 0x75, 0x10]);
    assert!(metres(&inches, &[0xe8, 0x03, 0xd0, 0x07]).abs_diff_eq(DVec2::new(0.0254, 0.0508), 1e-12));
    // 0..1000 stand for -100..400 mm.
    let range = [0x15, 0x00, 0x26, 0xe8, 0x03, 0x35, 0x9c, 0x46, 0x90, 0x01, 0x65, 0x11, 0x55, 0x0f];
    let physical = input([range.as_slice(), &[0x75, 0x10]].concat());
    assert!(metres(&physical, &[0, 0, 0xe8, 0x03]).abs_diff_eq(DVec2::new(-0.1, 0.4), 1e-12));
    // 12 bits side by side, without a unit: um.
    let packed = input(vec![0x16, 0x00, 0xf8, 0x26, 0xff, 0x07, 0x75, 0x0c]);
    assert!(metres(&packed, &[0x01, 0xf0, 0xff]).abs_diff_eq(DVec2::new(1e-6, -1e-6), 1e-15));
}

#[test]
fn push_and_pop_restore_what_held() {
    let pushed = [
        0x15, 0x00, 0x26, 0xff, 0x7f, 0x65, 0x11, 0x55, 0x0c, 0x75, 0x10, 0xa4, // um, 16 bits, Push
        0x65, 0x13, 0x75, 0x08, 0x25, 0x7f, 0x06, 0x00, 0xff, 0x09, 0x01, 0x81,
        0x02, // two vendor's bytes
        0xb4, 0x09, 0x21, 0x09, 0x22, 0x81, 0x02, // Pop
    ];
    let layout = layout(&gaze_only(&pushed));
    let bytes = [7, 8, 0x10, 0x27, 0x20, 0x4e];
    let decoded = layout.decode(&bytes).expect("a report");
    assert_eq!(decoded.gaze_m(), Some(DVec2::new(0.01, 0.02)));
    let raw: Vec<_> = layout.raw_fields(&bytes).expect("a report").collect();
    let told: Vec<_> = raw.iter().map(|raw| (raw.field.usage, raw.value)).collect();
    assert_eq!(told, [(0xff00_0001, 7), (0xff00_0001, 8), (0x12_0021, 10_000), (0x12_0022, 20_000)]);
}

#[test]
fn constants_with_usages_count_even_as_arrays() {
    let items = [0x15, 0x00, 0x25, 0x7f, 0x75, 0x08, 0x09, 0x21, 0x09, 0x22, 0x81, 0x01];
    let decoded = layout(&gaze_only(&items)).decode(&[3, 5]).expect("a report");
    assert_eq!((decoded.raw(Role::GazeX), decoded.raw(Role::GazeY)), (Some(3), Some(5)));
}
