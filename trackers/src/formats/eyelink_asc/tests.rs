use super::*;
use crate::formats::{read_input, testing::input};
use crate::testing::shared;

fn read_text(text: &str) -> Recording {
    read_input(&input(text), &ReadOptions::default()).expect("read")
}

const BINOCULAR: &str = "** CONVERTED FROM a.edf\n\
    MSG\t10 DISPLAY_COORDS 0 0 99 49\n\
    MSG\t10 !CAL Cal coeff\n  132.75 -13.023  242.52 -0.051945  1.6939\n\
    MSG\t11 GAZE_COORDS 0.00 0.00 1919.00 1079.00\n\
    START\t12 \tLEFT\tRIGHT\tSAMPLES\tEVENTS\n\
    SAMPLES\tGAZE\tLEFT\tRIGHT\tRATE\t 500.00\tTRACKING\tCR\n\
    SFIX L   12\n\
    12\t  960.0\t  540.0\t  288.0\t  480.0\t  810.0\t  305.0\t.....\n\
    14\t   .\t   .\t    0.0\t  933.4\t  568.2\t  298.0\t.C...\n\
    EFIX L   12\t14\t4\t  961.2\t  540.5\t    284\n\
    EBLINK R 14\t16\t4\n\
    ESACC R  12\t16\t6\t   .\t   .\t  852.1\t  616.2\t 2.3e+06\t    102\n\
    16\t  9\n\
    END\t18 \tSAMPLES\tEVENTS\tRES\t  37.17\t  37.75\n";

#[test]
fn both_eyes_events_and_the_calibration_in_between() {
    let recording = read_text(BINOCULAR);
    assert_eq!(recording.info.format, "eyelink-asc");
    assert_eq!(recording.times_ns(), [12_000_000, 14_000_000]);
    assert_eq!(recording.info.nominal_rate_hz, Some(500.0));
    let [first, second] = [0, 1].map(|index| recording.get(index).expect("there"));
    assert_eq!(first.left.point, Some(DVec2::new(0.5, 0.5)));
    assert_eq!(first.right.point, Some(DVec2::new(0.25, 0.75)));
    assert_eq!(first.left.direction, None);
    assert_eq!((second.left, second.right.valid), (EyeSample::default(), true));
    assert_eq!(recording.extra_column("pupil_right"), Some(&[305.0, 298.0][..]));
    let event = |kind, eye, start, end| RecordedEvent { kind, start_ns: start, end_ns: end, eye };
    let expected = [
        event(EyeState::Fixation, EventEye::Left, 12_000_000, 14_000_000),
        event(EyeState::Blink, EventEye::Right, 14_000_000, 16_000_000),
        event(EyeState::Saccade, EventEye::Right, 12_000_000, 16_000_000),
    ];
    assert_eq!(recording.events, expected);
    assert_eq!(recording.info.skipped.len(), 1);
    assert_eq!(recording.info.skipped[0].rows, 1);
    assert!(recording.info.skipped[0].why.contains("line 14"), "{}", recording.info.skipped[0].why);
}

#[test]
fn a_screen_gives_directions() {
    let screen = Screen { size_px: DVec2::ONE, size_m: DVec2::new(0.4, 0.3), distance_m: 0.1 };
    let options = ReadOptions { screen: Some(screen), ..ReadOptions::default() };
    let recording = read_input(&input(BINOCULAR), &options).expect("read");
    // A quarter of the width left of the centre, a quarter of the height below it.
    let expected = DVec3::new(-0.1, -0.075, -0.1).normalize();
    let direction = recording.get(0).and_then(|sample| sample.right.direction).expect("known");
    assert!(direction.abs_diff_eq(expected, 1e-15), "{direction}");
    assert_eq!(recording.info.screen.map(|screen| screen.size_px), Some(DVec2::new(1920.0, 1080.0)));
}

#[test]
fn sizes_told_as_such_and_as_last_pixels() {
    for (sides, expected) in [("0 0 1919 1079", (1920.0, 1080.0)), ("0 0 1920.00 1080.00", (1920.0, 1080.0))]
    {
        let words: Vec<_> = sides.split(' ').collect();
        assert_eq!(display_of(&words), Some((DVec2::ZERO, DVec2::from(expected))));
    }
    for bad in ["0 0 1919", "0 0 0 0", "0 0 x 9", "0 0 nan 9", "9 9 1 1"] {
        assert_eq!(display_of(&bad.split(' ').collect::<Vec<_>>()), None, "{bad}");
    }
}

#[test]
fn two_samples_in_one_millisecond_are_half_apart() {
    let recording = read_text(
        "START 1 RIGHT SAMPLES\nSAMPLES GAZE RIGHT RATE 2000.00\n5 1 1 1 ...\n5 1 1 1 ...\n6.0 1 1 1 ...\n6.5 1 1 1 ...\n",
    );
    assert_eq!(recording.times_ns(), [5_000_000, 5_500_000, 6_000_000, 6_500_000]);
    assert!(recording.info.notes.iter().any(|note| note.starts_with("1 samples")));
    assert!(recording.get(0).is_some_and(|sample| sample.right.valid && sample.right.point.is_none()));
    assert_eq!(recording.extra_column("x_right"), Some(&[1.0; 4][..]));
}

#[test]
fn href_is_an_angle_and_raw_is_no_gaze() {
    let href = read_text("START 1 LEFT SAMPLES\nSAMPLES HREF LEFT RATE 1000\n5 15000 -15000 1 ...\n");
    let up_right = DVec3::new(1.0, 1.0, -1.0).normalize();
    let direction = href.get(0).and_then(|sample| sample.left.direction).expect("known");
    assert!(direction.abs_diff_eq(up_right, 1e-15), "{direction}");
    let raw = read_text("START 1 LEFT SAMPLES\nSAMPLES RAW LEFT RATE 1000\n5 -100 200 1 ...\n");
    assert!(raw.get(0).is_some_and(|sample| !sample.left.valid));
    assert_eq!(raw.extra_column("x_left"), Some(&[-100.0][..]));
}

#[test]
fn missing_values_of_older_converters() {
    let recording = read_text("START 1 LEFT SAMPLES\n5 -32768 -32768 0\n6 1e8 1e8 0\n7 -5 3 0\n");
    let valid: Vec<_> = recording.samples().map(|sample| sample.left.valid).collect();
    assert_eq!(valid, [false, false, true]);
}

/// Counts by awk: lines that begin with a digit, those of them without a dot in the columns of the eye,
/// and lines that begin with EFIX, ESACC or EBLINK.
#[test]
fn the_real_files_read() {
    let Some(folder) = shared("data/gaze/pymovements_samples") else { return };
    let all = [
        ("binocular", 1000.0, 368, [271, 288], 8),
        ("monocular_2khz", 2000.0, 16, [16, 0], 3),
        ("monocular", 1000.0, 16, [16, 0], 3),
        ("monocular_no_dummy", 500.0, 297, [228, 0], 6),
    ];
    for (name, rate_hz, samples, valid, events) in all {
        let path = folder.join(format!("eyelink_{name}_example.asc"));
        let recording = crate::formats::read(&path, &ReadOptions::default()).expect("read");
        let left = recording.samples().filter(|sample| sample.left.valid).count();
        let right = recording.samples().filter(|sample| sample.right.valid).count();
        let told = (recording.len(), [left, right], recording.events.len());
        assert_eq!(told, (samples, valid, events), "{name}");
        assert_eq!(recording.info.nominal_rate_hz, Some(rate_hz), "{name}");
        assert!(recording.info.skipped.is_empty(), "{name}: {:?}", recording.info.skipped);
    }
}
