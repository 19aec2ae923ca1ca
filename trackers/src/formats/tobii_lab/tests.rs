use super::super::testing::input;
use super::*;

/// A header with the units written in one of the three ways, and rows in the fields' order.
fn file(unit: impl Fn(&str, &str) -> String, rows: &[[&str; 14]]) -> String {
    let names = [
        unit("Recording timestamp", "µs"),
        "Sensor".to_owned(),
        "Event".to_owned(),
        "Recording resolution width".to_owned(),
        "Recording resolution height".to_owned(),
        unit("Gaze point X", "DACS px"),
        unit("Gaze point Y", "DACS px"),
        unit("Gaze point left X", "DACS px"),
        unit("Gaze point left Y", "DACS px"),
        unit("Gaze direction left X", "DACS norm"),
        unit("Gaze direction left Y", "DACS norm"),
        unit("Gaze direction left Z", "DACS norm"),
        unit("Pupil diameter left", "mm"),
        "Validity left".to_owned(),
    ];
    let mut text = names.join("\t");
    for row in rows {
        text = format!("{text}\r\n{}", row.join("\t"));
    }
    text + "\r\n"
}

const ROWS: &[[&str; 14]] = &[
    ["0", "", "RecordingStart", "2000", "1000", "", "", "", "", "", "", "", "", ""],
    [
        "1000",
        "Eye Tracker",
        "",
        "2000",
        "1000",
        "500",
        "750",
        "400",
        "500",
        "0,6",
        "0",
        "-0,8",
        "3,5",
        "Valid",
    ],
    ["2000", "Mouse", "", "2000", "1000", "", "", "", "", "", "", "", "", ""],
    ["9333", "Eye Tracker", "", "2000", "1000", "", "", "", "", "0", "0,6", "-0,8", "", "Invalid"],
    ["17666", "Eye Tracker", "", "2000", "1000", "", "", "", "", "", "", "", "", "Invalid"],
];

#[test]
fn three_spellings_of_units_are_one_format() {
    let spellings: [fn(&str, &str) -> String; 3] = [
        |name, _| name.to_owned(),
        |name, unit| format!("{name} ({})", unit.replace(' ', "")),
        |name, unit| format!("{name} [{unit}]"),
    ];
    for spelling in spellings {
        let text = format!("\u{feff}{}", file(spelling, ROWS));
        let recording = super::super::read_input(&input(text), &ReadOptions::default()).expect("well formed");
        assert_eq!(recording.info.format, "tobii-pro-lab-tsv");
        assert_eq!(recording.times_ns(), [1_000_000, 9_333_000, 17_666_000]);
        let samples: Vec<_> = recording.samples().collect();
        assert_eq!(samples[0].combined.point, Some(DVec2::new(0.25, 0.75)));
        assert_eq!(samples[0].left.point, Some(DVec2::new(0.2, 0.5)));
        assert_eq!(samples[0].left.direction, Some(DVec3::new(0.6, 0.0, -0.8)), "decimal commas");
        assert_eq!(samples[0].left.pupil_mm, Some(3.5));
        let down = samples[1].left.direction.expect("told, if not valid");
        assert_eq!(down, DVec3::new(0.0, -0.6, -0.8));
        let valid: Vec<_> = samples.iter().map(|sample| (sample.combined.valid, sample.left.valid)).collect();
        assert_eq!(valid, [(true, true), (false, false), (false, false)]);
        let skipped: Vec<_> = recording.info.skipped.iter().map(|s| (s.rows, s.why.as_str())).collect();
        assert_eq!(
            skipped,
            [
                (1, "the row is an event, no sample, first in line 2"),
                (1, "the row is of another sensor than the eye tracker, first in line 4")
            ]
        );
    }
}

#[test]
fn the_unit_of_time_is_guessed_or_given() {
    let rows: Vec<[&str; 14]> = ["0", "8", "17", "25", "33"]
        .map(|time| [time, "Eye Tracker", "", "", "", "1", "1", "", "", "", "", "", "", "Valid"])
        .to_vec();
    let text = file(|name, _| name.to_owned(), &rows);
    let guessed = read(&input(&text), &ReadOptions::default()).expect("well formed");
    assert_eq!(guessed.times_ns()[4], 33_000_000);
    assert!(
        guessed.info.notes.iter().any(|note| note.contains("taken to be ms")),
        "{:?}",
        guessed.info.notes
    );
    let options = ReadOptions { time_unit_s: Some(1e-6), ..ReadOptions::default() };
    let given = read(&input(&text), &options).expect("well formed");
    assert_eq!(given.times_ns()[4], 33_000);
    for time_unit_s in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let options = ReadOptions { time_unit_s: Some(time_unit_s), ..ReadOptions::default() };
        assert!(read(&input(&text), &options).expect_err("no unit").to_string().contains("time unit"));
    }
}

#[test]
fn points_of_glasses_lie_in_their_camera() {
    let text = "Recording timestamp [ms]\tSensor\tGaze point X [MCS px]\tGaze point Y [MCS px]\n\
        0\tEye Tracker\t960\t540\n20\tEye Tracker\t480\t270\n";
    let screen = Screen { size_px: DVec2::new(1920.0, 1080.0), size_m: DVec2::ONE, distance_m: 1.0 };
    let options = ReadOptions { screen: Some(screen), ..ReadOptions::default() };
    let recording = read(&input(text), &options).expect("well formed");
    assert_eq!(recording.info.space, Space::SceneCamera);
    let combined = recording.get(1).expect("two").combined;
    assert_eq!((combined.point, combined.direction), (Some(DVec2::splat(0.25)), None));
}

#[test]
fn points_stay_px_until_the_size_is_known() {
    let rows = [["0", "Eye Tracker", "", "", "", "960", "270", "", "", "", "", "", "", "Valid"]];
    let text = file(|name, _| name.to_owned(), &rows);
    let recording = read(&input(&text), &ReadOptions::default()).expect("well formed");
    assert_eq!(recording.get(0).and_then(|sample| sample.combined.point), None);
    assert_eq!(recording.extra_column("Gaze point X"), Some([960.0].as_slice()));
    let screen = Screen { size_px: DVec2::new(1920.0, 1080.0), size_m: DVec2::ONE, distance_m: 1.0 };
    let options = ReadOptions { screen: Some(screen), ..ReadOptions::default() };
    let recording = read(&input(&text), &options).expect("well formed");
    let combined = recording.get(0).expect("one").combined;
    assert_eq!(combined.point, Some(DVec2::new(0.5, 0.25)));
    // A quarter of a display of 1 m above its middle, at 1 m.
    let direction = combined.direction.expect("the display is known");
    assert!(direction.abs_diff_eq(DVec3::new(0.0, 0.25, -1.0).normalize(), 1e-15), "{direction}");
    assert_eq!(recording.extra_column("Gaze point X"), None);
}
