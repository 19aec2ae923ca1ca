use super::*;
use crate::formats;
use crate::testing::shared;
use tempfile::TempDir;

const INFO: &str =
    r#"{"data_format_version":"2.5","android_device_name":"Neon Companion","gaze_frequency":200}"#;
const EYE_STATE: &str = r#"[("optical_axis_left_x","float32"),("optical_axis_left_y","float32"),
    ("optical_axis_left_z","float32"),("eyeball_center_left_x","float32"),("eyeball_center_left_y","float32"),
    ("eyeball_center_left_z","float32"),("pupil_diameter_left_mm","float32"),("eyelid_aperture_left_mm","float32")]"#;

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn times(values: &[i64]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn folder(files: &[(&str, Vec<u8>)]) -> TempDir {
    let folder = TempDir::new().expect("a place for files");
    for (name, content) in files {
        fs::write(folder.path().join(name), content).expect("written");
    }
    folder
}

fn recorded() -> Vec<(&'static str, Vec<u8>)> {
    let second = floats(&[1600.0, 0.0]);
    vec![
        ("info.json", INFO.into()),
        ("gaze ps1.raw", floats(&[800.0, 300.0, 400.0, 600.0])),
        ("gaze ps1.time", times(&[1000, 5_001_000])),
        ("gaze ps10.raw", second[..7].into()),
        ("gaze ps10.time", times(&[15_001_000])),
        ("gaze ps2.raw", second),
        ("gaze ps2.time", times(&[10_001_000])),
        ("eye_state.dtype", EYE_STATE.into()),
        ("eye_state ps1.raw", floats(&[0.6, 0.0, 0.8, -31.0, 10.0, -35.0, 3.5, 8.0])),
        ("eye_state ps1.time", times(&[5_001_002])),
        ("worn.dtype", "(\"worn\", \"uint8\")".into()),
        ("worn ps1.raw", vec![255, 0]),
        (
            "blinks.dtype",
            "(\"event_type\",\"int32\"),(\"start_timestamp_ns\",\"int64\"),(\"end_timestamp_ns\",\"int64\")"
                .into(),
        ),
        ("blinks ps1.raw", [&4i32.to_le_bytes()[..], &times(&[7, 9])].concat()),
        ("blinks ps1.time", times(&[9])),
    ]
}

#[test]
fn parts_are_joined_and_eyes_belong_by_time() {
    let folder = folder(&recorded());
    let recording = formats::read(folder.path(), &ReadOptions::default()).expect("read");
    assert_eq!(recording.info.format, "neon-native");
    assert_eq!(
        (recording.info.device.as_str(), recording.info.nominal_rate_hz),
        ("Pupil Labs Neon", Some(200.0))
    );
    assert_eq!(recording.times_ns(), [1000, 5_001_000, 10_001_000]);
    let all: Vec<_> = recording.samples().collect();
    let points: Vec<_> = all.iter().map(|sample| sample.combined.point.expect("known")).collect();
    assert_eq!(points, [(0.5, 0.25), (0.25, 0.5), (1.0, 0.0)].map(DVec2::from));
    assert_eq!(all.iter().map(|sample| sample.combined.valid).collect::<Vec<_>>(), [true, false, true]);
    let left = all[1].left;
    assert_eq!((left.valid, left.pupil_mm), (false, Some(3.5)));
    assert!(left.direction.is_some_and(|told| told.abs_diff_eq(DVec3::new(0.6, 0.0, -0.8), 1e-7)));
    assert!(left.origin_m.is_some_and(|told| told.abs_diff_eq(DVec3::new(-0.031, -0.01, 0.035), 1e-9)));
    assert_eq!((all[0].left, all[1].right), (EyeSample::default(), EyeSample::default()));
    assert_eq!(recording.extra_column("x_px"), Some(&[800.0, 400.0, 1600.0][..]));
    let blink = RecordedEvent { kind: EyeState::Blink, start_ns: 7, end_ns: 9, eye: EventEye::Both };
    assert_eq!(recording.events, [blink]);
    let skipped: Vec<_> =
        recording.info.skipped.iter().map(|skipped| (skipped.rows, skipped.why.as_str())).collect();
    assert_eq!(skipped.len(), 2, "{skipped:?}");
    assert!(skipped.iter().all(|(rows, why)| *rows == 1 && why.starts_with("gaze ps10")), "{skipped:?}");
}

#[test]
fn any_of_the_files_can_be_given_and_the_full_rate_is_preferred() {
    let mut files = recorded();
    files.push(("gaze_200hz.raw", floats(&[80.0, 60.0])));
    files.push(("gaze_200hz.time", times(&[3])));
    let folder = folder(&files);
    let samples =
        |name: &str| formats::read(&folder.path().join(name), &ReadOptions::default()).expect(name).len();
    assert_eq!(samples(""), 1);
    assert_eq!(samples("info.json"), 1);
    assert_eq!(samples("gaze_200hz.time"), 1);
    assert_eq!(samples("gaze ps2.raw"), 3);
    assert_eq!(samples("gaze ps1.time"), 3);
}

#[test]
fn without_information_gaze_stays_in_px() {
    let files = [("gaze ps1.raw", floats(&[800.0, 300.0])), ("gaze ps1.time", times(&[1]))];
    let bare = folder(&files);
    let recording = formats::read(bare.path(), &ReadOptions::default()).expect("read");
    let sample = recording.get(0).expect("one");
    assert_eq!((sample.combined.point, sample.combined.valid), (None, true));
    assert_eq!(recording.extra_column("y_px"), Some(&[300.0][..]));

    let timeless = folder(&files[..1]);
    let error = formats::read(timeless.path(), &ReadOptions::default()).expect_err("no times").to_string();
    assert!(error.contains("no record with a time"), "{error}");
    let empty = folder(&[]);
    assert!(formats::read(empty.path(), &ReadOptions::default()).is_err());
}

/// Counts and first values by an independent reading of the files (Python's struct module).
#[test]
fn the_real_recording_reads() {
    let Some(folder) = shared("data/gaze/pl_neon_native") else { return };
    let recording = formats::read(&folder, &ReadOptions::default()).expect("read");
    assert_eq!((recording.len(), recording.info.skipped.len()), (1788, 0));
    assert!(
        recording.samples().all(|sample| sample.combined.valid && sample.left.valid && sample.right.valid)
    );
    assert!(recording.rate_hz().is_some_and(|rate| (rate - 200.0).abs() < 1.0));
    assert_eq!(recording.times_ns()[0], 1_760_676_790_465_965_534);
    assert_eq!(recording.times_ns()[1787], 1_760_676_799_429_223_534);
    assert_eq!(recording.events.len(), 47);
    for sample in recording.samples() {
        let (left, right) = (sample.left.origin_m.expect("told"), sample.right.origin_m.expect("told"));
        assert!(left.x < -0.029 && right.x > 0.029, "{left} {right}");
        assert!(sample.left.direction.is_some_and(|direction| (direction.length() - 1.0).abs() < 1e-5));
    }
    let part = formats::read(&folder.join("gaze ps1.raw"), &ReadOptions::default()).expect("read");
    let x_px = part.extra_column("x_px").expect("told");
    assert_eq!((part.len(), x_px[0]), (1788, f64::from(719.783_2_f32)));
}
