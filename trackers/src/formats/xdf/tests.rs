use super::*;
use crate::formats::{read_input, testing::input};
use crate::recording::{Screen, Space};
use crate::testing::shared;
use glam::{DVec2, DVec3};

/// A chunk as the specification lays it out, its length in `size` bytes.
fn chunk(size: u8, tag: u16, body: &[u8]) -> Vec<u8> {
    let length = (body.len() as u64 + 2).to_le_bytes();
    [&[size], &length[..usize::from(size)], &tag.to_le_bytes(), body].concat()
}

fn header(id: u32, kind: &str, format: &str, rate: &str, channels: &[[&str; 4]]) -> Vec<u8> {
    let described: String = channels
        .iter()
        .map(|[label, eye, kind, unit]| {
            format!(
                "<channel><label>{label}</label><eye>{eye}</eye><type>{kind}</type><unit>{unit}</unit></channel>"
            )
        })
        .collect();
    let xml = format!(
        "<?xml version=\"1.0\"?><info><name>Eyes</name><type>{kind}</type><channel_count>{}</channel_count>\
         <nominal_srate>{rate}</nominal_srate><channel_format>{format}</channel_format>\
         <desc><channels>{described}</channels></desc></info>",
        channels.len()
    );
    chunk(4, 2, &[&id.to_le_bytes()[..], xml.as_bytes()].concat())
}

fn samples(id: u32, rows: &[(Option<f64>, &[f32])]) -> Vec<u8> {
    let mut body = [&id.to_le_bytes()[..], &[1, rows.len() as u8]].concat();
    for (time, values) in rows {
        match time {
            Some(time) => body.extend([&[8], &time.to_le_bytes()[..]].concat()),
            None => body.push(0),
        }
        body.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    }
    chunk(8, 3, &body)
}

fn offset(id: u32, time: f64, value: f64) -> Vec<u8> {
    chunk(1, 4, &[&id.to_le_bytes()[..], &time.to_le_bytes(), &value.to_le_bytes()].concat())
}

fn file(chunks: &[Vec<u8>]) -> Vec<u8> {
    let start = chunk(1, 1, b"<?xml version=\"1.0\"?><info><version>1.0</version></info>");
    [MAGIC.to_vec(), start, chunks.concat()].concat()
}

const EYES: [[&str; 4]; 9] = [
    ["lx", "left", "ScreenX", "normalized"],
    ["ly", "left", "ScreenY", "normalized"],
    ["rdx", "right", "DirectionX", "normalized"],
    ["rdy", "right", "DirectionY", "normalized"],
    ["rdz", "right", "DirectionZ", "normalized"],
    ["roz", "right", "PositionZ", "mm"],
    ["rp", "right", "Radius", "mm"],
    ["c", "both", "Confidence", "normalized"],
    ["lamp", "both", "Luminance", "lux"],
];

#[test]
fn a_gaze_stream_by_the_specification() {
    let rows: [(Option<f64>, &[f32]); 3] = [
        (Some(10.0), &[0.25, 0.75, 0.5, 0.5, 2.0, 1.0, 1.5, 1.0, 7.0]),
        (None, &[0.5, f32::NAN, 0.0, 0.0, 1.0, 1.0, 1.5, 1.0, 8.0]),
        (None, &[0.5, 0.5, 0.0, 0.0, 1.0, 1.0, 1.5, 0.5, 9.0]),
    ];
    let bytes = file(&[
        header(9, "Markers", "string", "0", &[["m", "", "", ""]]),
        header(7, "Gaze", "float32", "100", &EYES),
        samples(9, &[]),
        samples(7, &rows),
        offset(7, 10.0, 0.5),
        samples(404, &rows),
    ]);
    let recording = read_input(&input(bytes), &ReadOptions::default()).expect("read");
    assert_eq!((recording.info.format, recording.info.space), ("xdf", Space::View));
    assert_eq!(recording.info.nominal_rate_hz, Some(100.0));
    assert_eq!(recording.times_ns(), [10_500_000_000, 10_510_000_000, 10_520_000_000]);
    let all: Vec<_> = recording.samples().collect();
    assert_eq!(all[1].device_time_ns, Some(10_010_000_000));
    assert_eq!(all[0].left.point, Some(DVec2::new(0.25, 0.75)));
    assert_eq!(all[0].right.direction, Some(DVec3::new(0.5, 0.5, -2.0)));
    assert_eq!((all[0].right.origin_m, all[0].right.pupil_mm), (None, Some(3.0)));
    assert_eq!(all[0].combined.confidence, Some(1.0));
    let valid: Vec<_> = all.iter().map(|sample| (sample.left.valid, sample.right.valid)).collect();
    assert_eq!(valid, [(true, true), (false, true), (false, false)]);
    assert_eq!(recording.extra_column("lamp"), Some(&[7.0, 8.0, 9.0][..]));
    assert!(recording.info.skipped.is_empty(), "{:?}", recording.info.skipped);
}

#[test]
fn pupil_capture_has_the_axes_of_its_camera() {
    let labels = [
        ["norm_pos_x", "both", "ScreenX", "normalized"],
        ["norm_pos_y", "both", "ScreenY", "normalized"],
        ["gaze_normal0_x", "right", "PositionX", "mm"],
        ["gaze_normal0_y", "right", "PositionY", "mm"],
        ["gaze_normal0_z", "right", "PositionZ", "mm"],
    ];
    let bytes = file(&[
        header(1, "gaze", "float32", "0", &labels),
        samples(1, &[(Some(1.0), &[0.25, 0.25, 0.5, 0.25, 1.0])]),
    ]);
    let recording = read_input(&input(bytes), &ReadOptions::default()).expect("read");
    let sample = recording.get(0).expect("one");
    assert_eq!(sample.combined.point, Some(DVec2::new(0.25, 0.75)));
    assert_eq!(sample.right.direction, Some(DVec3::new(0.5, -0.25, -1.0)));
    assert_eq!(recording.info.space, Space::SceneCamera);
}

#[test]
fn pixels_need_the_screen_and_labels_stand_in_for_types() {
    let labels = [
        ["gaze_x", "left", "ScreenX", "pixels"],
        ["gaze_y", "left", "ScreenY", "pixels"],
        ["right_gaze_point_on_display_area_0", "", "", ""],
        ["right_gaze_point_on_display_area_1", "", "", ""],
        ["right_pupil_diameter", "", "", "mm"],
    ];
    let bytes = file(&[
        header(1, "Eye-Tracking", "float32", "0", &labels),
        samples(1, &[(Some(1.0), &[960.0, 270.0, 0.5, 0.25, 3.0])]),
    ]);
    let bare = read_input(&input(&bytes), &ReadOptions::default()).expect("read");
    let sample = bare.get(0).expect("one");
    assert_eq!((sample.left.point, sample.right.point), (None, Some(DVec2::new(0.5, 0.25))));
    assert_eq!(sample.right.pupil_mm, Some(3.0));
    assert_eq!(bare.extra_column("gaze_x"), Some(&[960.0][..]));
    let screen = Screen { size_px: DVec2::new(1920.0, 1080.0), size_m: DVec2::ONE, distance_m: 1.0 };
    let options = ReadOptions { screen: Some(screen), ..ReadOptions::default() };
    let known = read_input(&input(&bytes), &options).expect("read");
    assert_eq!(known.get(0).and_then(|sample| sample.left.point), Some(DVec2::new(0.5, 0.25)));
}

#[test]
fn damage_is_passed_over_up_to_the_next_boundary() {
    let row: &[(Option<f64>, &[f32])] = &[(Some(1.0), &[1.0])];
    let one = [["c", "both", "Confidence", "normalized"]];
    let boundary = chunk(1, 5, &BOUNDARY);
    let huge = [&[8][..], &(1u64 << 60).to_le_bytes(), &[3, 0, 1, 2, 3]].concat();
    let many = chunk(4, 3, &[&1u32.to_le_bytes()[..], &[8], &u64::MAX.to_le_bytes(), &[0, 0, 0]].concat());
    let bytes = file(&[header(1, "Gaze", "float32", "0", &one), huge, boundary, many, samples(1, row)]);
    let recording = read_input(&input(&bytes), &ReadOptions::default()).expect("read");
    assert_eq!(recording.times_ns(), [1_000_000_000]);
    let told: Vec<_> = recording.info.skipped.iter().map(|skipped| skipped.rows).collect();
    assert_eq!(told, [1, 1], "{:?}", recording.info.skipped);
    // Without a boundary what follows the damage is lost, but nothing else is.
    for length in MAGIC.len()..bytes.len() {
        let _ = read_input(&input(&bytes[..length]), &ReadOptions::default());
    }
}

#[test]
fn hostile_headers_are_no_streams() {
    let deep = format!("{}{}", "<a>".repeat(100_000), "</a>".repeat(100_000));
    let laughs = "<!DOCTYPE l [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;\">]><info>&b;</info>";
    let wide = "<info><channel_count>4000000000</channel_count><channel_format>int8</channel_format></info>";
    for xml in [deep.as_str(), laughs, wide, "<info>", "\u{0}", ""] {
        let body = [&1u32.to_le_bytes()[..], xml.as_bytes()].concat();
        let error = read_input(&input(file(&[chunk(8, 2, &body)])), &ReadOptions::default());
        assert!(error.is_err_and(|error| error.to_string().contains("it holds: nothing")));
    }
}

/// The expected values are those of the chunks, decoded by hand and listed in the files' own footers.
#[test]
fn the_real_files_hold_no_gaze_but_read_as_streams() {
    let Some(folder) = shared("data/gaze/xdf_examples") else { return };
    let all = [
        ("minimal.xdf", "SendDataC (EEG, 3 channels), SendDataString (StringMarker, 1 channels)"),
        ("empty_streams.xdf", "Empty data stream"),
        ("clock_resets.xdf", "MyMarkerStream (Markers, 1 channels), BioSemi (EEG, 8 channels)"),
    ];
    for (name, held) in all {
        let error = crate::formats::read(&folder.join(name), &ReadOptions::default()).expect_err("no gaze");
        assert!(error.to_string().contains(held), "{error}");
    }
    let bytes = std::fs::read(folder.join("minimal.xdf")).expect("there");
    let (streams, damaged) = streams_of(&bytes);
    let mut told = Vec::new();
    assert_eq!(streams[0].for_each(|time, values| told.push((time, values.to_vec()))), 0);
    assert_eq!((told.len(), damaged), (9, 0));
    assert_eq!(told[0], (5.1, vec![192.0, 255.0, 238.0]));
    assert!(told.iter().enumerate().all(|(index, (time, _))| (time - 5.1 - 0.1 * index as f64).abs() < 1e-9));
    let sync = streams[0].clock.fitted();
    assert!((sync.local_s(5.1) - 5.0).abs() < 1e-12);
    let mut strings = 0;
    assert_eq!(streams[1].for_each(|_, _| strings += 1), 0);
    assert_eq!(strings, 9);

    let bytes = std::fs::read(folder.join("clock_resets.xdf")).expect("there");
    let (streams, damaged) = streams_of(&bytes);
    assert_eq!(damaged, 0);
    let counts: Vec<_> = streams
        .iter()
        .map(|stream| {
            let (mut count, mut ends) = (0, [f64::NAN; 2]);
            let broken = stream.for_each(|time, _| {
                count += 1;
                ends = [if count == 1 { time } else { ends[0] }, time];
            });
            (count, broken, ends)
        })
        .collect();
    assert_eq!(counts[0].0, 175);
    assert_eq!(counts[1].0, 27_815);
    assert!(counts.iter().all(|(_, broken, _)| *broken == 0));
    assert!((counts[1].2[0] - 653_150.379_117).abs() < 1e-6 && (counts[1].2[1] - 261.926_703_3).abs() < 1e-6);
}
