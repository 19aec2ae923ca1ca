//! Recordings there and back, cut off anywhere, on a full disk, and made by others.

mod killed;

use super::recorder::Sink;
use super::*;
use crate::error::Error;
use crate::formats::{ReadOptions, read};
use crate::recording::{ExtraColumn, Recording, RecordingInfo, Screen, Space};
use crate::sample::{EyeSample, GazeSample, HeadPose};
use flate2::{Compression, write::GzEncoder};
use glam::{DQuat, DVec2, DVec3};
use proptest::prelude::*;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

fn load(path: &Path) -> Recording {
    read(path, &ReadOptions::default()).expect("a recording")
}

/// A sample at 1 kHz with a direction of many digits.
fn sample(number: i64) -> GazeSample {
    let x = (number as f64 * 0.37).sin() * 0.3;
    let combined =
        EyeSample { valid: true, direction: Some(DVec3::new(x, 0.1, -1.0)), ..EyeSample::default() };
    GazeSample { combined, ..GazeSample::at(number * 1_000_000) }
}

fn samples_of(recording: &Recording) -> Vec<GazeSample> {
    recording.samples().collect()
}

fn gzip(text: &str) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(text.as_bytes()).expect("memory");
    encoder.finish().expect("memory")
}

// Numbers of every kind but NaN, which stands for no value.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        3 => -1.0f64..1.0,
        1 => any::<f64>().prop_filter("no NaN", |value| !value.is_nan()),
        1 => prop::sample::select(vec![0.0, -0.0, 1.0, 1e-310, f64::INFINITY, 9_007_199_254_740_993.0]),
    ]
}

fn eye() -> impl Strategy<Value = EyeSample> {
    let vector = || prop::option::of([number(), number(), number()].prop_map(DVec3::from_array));
    let point = prop::option::of([number(), number()].prop_map(DVec2::from_array));
    let told = || prop::option::of(number());
    (any::<bool>(), vector(), vector(), point, told(), told(), told()).prop_map(
        |(valid, origin_m, direction, point, confidence, pupil_mm, openness)| EyeSample {
            valid,
            origin_m,
            direction,
            point,
            confidence,
            pupil_mm,
            openness,
        },
    )
}

fn any_sample() -> impl Strategy<Value = GazeSample> {
    let head = prop::option::of(prop::array::uniform7(number()).prop_map(|values| HeadPose {
        position_m: DVec3::from_slice(&values),
        world_from_view: DQuat::from_slice(&values[3..]),
    }));
    let device = prop::option::of(any::<i64>());
    let simple = prop_oneof![Just(EyeSample::default()), eye()];
    (any::<i64>(), any::<i64>(), device, eye(), simple.clone(), simple, head).prop_map(
        |(time_ns, received_ns, device_time_ns, combined, left, right, head)| GazeSample {
            device_time_ns,
            received_ns,
            time_ns,
            combined,
            left,
            right,
            head,
        },
    )
}

/// All bits of all fields, so that zeros of different sign differ.
fn bits(sample: &GazeSample) -> Vec<u64> {
    let values = crate::recording::values_of(sample);
    let times = [sample.time_ns, sample.received_ns].map(|time| time as u64);
    let device = [u64::from(sample.device_time_ns.is_some()), sample.device_time_ns.unwrap_or(0) as u64];
    let values = values.iter().map(|value| if value.is_nan() { u64::MAX } else { value.to_bits() });
    times.into_iter().chain(device).chain(values).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_field_comes_back_bit_by_bit(samples in prop::collection::vec(any_sample(), 0..20)) {
        let folder = folder();
        let mut recording = Recording::new(RecordingInfo::default());
        let mut recorder = Recorder::create(&folder.path().join("live"), &RecordingInfo::default(), &[])
            .expect("created");
        for (number, sample) in samples.iter().enumerate() {
            recording.push(sample);
            recorder.push(sample).expect("written");
            if number % 3 == 0 {
                recorder.flush().expect("flushed");
            }
        }
        let live = load(&recorder.finish().expect("finished"));
        let whole = write_recording(&recording, &folder.path().join("whole.tsv.gz")).expect("written");
        let whole = load(&whole);
        for read in [&live, &whole] {
            prop_assert_eq!(read.len(), samples.len());
            for (read, sample) in read.samples().zip(&samples) {
                prop_assert_eq!(bits(&read), bits(sample));
            }
            prop_assert!(read.info.skipped.is_empty() && read.info.notes.iter().all(|note| note.contains("before them")));
        }
    }

    /// Our own pair with some bytes changed, which may be the names of columns or what they mean.
    #[test]
    fn no_damage_panics(
        of_sidecar in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..4),
        of_rows in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..8),
        digits: bool,
    ) {
        let folder = folder();
        let mut recording = Recording::new(RecordingInfo::default());
        for number in 0..5 {
            recording.push(&GazeSample { received_ns: number, ..sample(number) });
        }
        let written = write_recording(&recording, &folder.path().join("me_physio")).expect("written");
        let sidecar = written.with_file_name("me_physio.json");
        let data = written.with_file_name("me_physio.tsv");
        let mut text = Vec::new();
        let file = std::fs::File::open(&written).expect("the file");
        io::Read::read_to_end(&mut flate2::read::MultiGzDecoder::new(file), &mut text).expect("text");
        let mut json = std::fs::read(&sidecar).expect("the side-car");
        for (bytes, edits) in [(&mut json, of_sidecar), (&mut text, of_rows)] {
            for (at, byte) in edits {
                // Digits mostly leave it whole and change what it says.
                let byte = if digits { b'0' + byte % 10 } else { byte };
                let at = at.index(bytes.len());
                bytes[at] = byte;
            }
        }
        std::fs::write(&data, &text).expect("a file");
        std::fs::write(&sidecar, &json).expect("a file");
        match read(&data, &ReadOptions::default()) {
            Ok(recording) => prop_assert!(recording.len() <= text.len()),
            Err(error) => prop_assert!(!error.to_string().contains('\n'), "{}", error),
        }
    }

    /// Hostile text: never a panic, and never more samples than rows.
    #[test]
    fn no_data_panics(
        bytes in prop::collection::vec(any::<u8>(), 0..300),
        words in prop::collection::vec(prop::sample::select(
            vec!["1", "\t", "\n", "\r\n", "n/a", "-", "1e400", "nan", ".", "\t\t", "99999999999999999999"],
        ), 0..60),
    ) {
        let folder = folder();
        let data = folder.path().join("x_physio.tsv");
        let sidecar = r#"{"Columns": ["timestamp", "x_coordinate", "y_coordinate", "other"],
            "timestamp": {"Units": "s"}, "SamplingFrequency": 100}"#;
        std::fs::write(data.with_extension("json"), sidecar).expect("a file");
        for content in [bytes, words.concat().into_bytes()] {
            std::fs::write(&data, &content).expect("a file");
            let rows = content.iter().filter(|byte| **byte == b'\n').count() + 1;
            if let Ok(recording) = read(&data, &ReadOptions::default()) {
                prop_assert!(recording.len() <= rows);
            }
        }
    }
}

#[test]
fn what_is_known_of_a_recording_comes_back() {
    let info = RecordingInfo {
        format: "bids",
        device: "Tracker 5 (\"left\", \u{e9})".into(),
        space: Space::SceneCamera,
        nominal_rate_hz: Some(119.88),
        screen: Some(Screen {
            size_px: DVec2::new(1920.0, 1080.0),
            size_m: DVec2::new(0.1 + 0.2, 0.3),
            distance_m: 0.6,
        }),
        device_clock: "tracker (us, 32 bit)".into(),
        ..RecordingInfo::default()
    };
    let mut recording = Recording::new(info);
    recording.info.notes.push("A note.".into());
    recording.skip(3, "no gaze");
    for number in 0..4 {
        recording.push(&sample(number));
    }
    let values = |first: f64| vec![first, f64::NAN, -0.5, 1e-9];
    for (name, first) in [("frame", 1.0), ("timestamp", 2.0), ("frame", 3.0), ("Columns", 4.0), ("", 5.0)] {
        recording.extra.push(ExtraColumn { name: name.into(), values: values(first) });
    }
    let folder = folder();
    let read = load(&write_recording(&recording, &folder.path().join("me")).expect("written"));
    assert_eq!((&read.info, samples_of(&read)), (&recording.info, samples_of(&recording)));
    for (read, written) in read.extra.iter().zip(&recording.extra) {
        let bits =
            |column: &ExtraColumn| column.values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!((&read.name, bits(read)), (&written.name, bits(written)));
    }
    assert_eq!(read.extra.len(), 5);
    // Again over itself: replaced, and nothing else is left in the folder.
    let path = write_recording(&read, &folder.path().join("me_recording-eye3_physio.json")).expect("written");
    assert_eq!(load(&path).info, recording.info);
    assert_eq!(folder.path().read_dir().expect("a folder").count(), 2);
}

#[test]
fn the_file_is_what_bids_asks_for() {
    let folder = folder();
    let mut recorder = Recorder::create(&folder.path().join("sub-1_task-x"), &RecordingInfo::default(), &[])
        .expect("created");
    let eye = EyeSample {
        valid: true,
        point: Some(DVec2::new(0.25, 0.75)),
        pupil_mm: Some(3.5),
        ..EyeSample::default()
    };
    for time_ns in [1_500_000_000, 1_510_000_001] {
        recorder.push(&GazeSample { combined: eye, ..GazeSample::at(time_ns) }).expect("written");
    }
    let path = recorder.finish().expect("finished");
    assert_eq!(
        path.file_name().and_then(|name| name.to_str()),
        Some("sub-1_task-x_recording-eye3_physio.tsv.gz")
    );
    let mut text = String::new();
    let file = std::fs::File::open(&path).expect("the file");
    io::Read::read_to_string(&mut flate2::read::MultiGzDecoder::new(file), &mut text).expect("text");
    assert_eq!(text, "1.500000000\t0.25\t0.75\t1\t3.5\n1.510000001\t0.25\t0.75\t1\t3.5\n");
    let sidecar: serde_json::Value = serde_json::from_slice(
        &std::fs::read(folder.path().join("sub-1_task-x_recording-eye3_physio.json")).expect("the side-car"),
    )
    .expect("JSON");
    let columns = ["timestamp", "x_coordinate", "y_coordinate", "gaze_valid", "pupil_size"];
    assert_eq!(sidecar["Columns"], serde_json::json!(columns));
    assert_eq!(sidecar["PhysioType"], "eyetrack");
    assert_eq!(sidecar["RecordedEye"], "cyclopean");
    assert_eq!(sidecar["timestamp"]["Units"], "s");
    assert_eq!(sidecar["MaculaRecording"]["Finished"], true);
    let rate_hz = sidecar["SamplingFrequency"].as_f64().expect("a rate");
    assert!((rate_hz - 100.0).abs() < 1e-4, "{rate_hz}");
}

#[test]
fn a_file_cut_anywhere_gives_what_came_before() {
    let folder = folder();
    let mut recorder =
        Recorder::create(&folder.path().join("me"), &RecordingInfo::default(), &[]).expect("created");
    let data = recorder.path().to_owned();
    let mut ends = vec![(0, 0)];
    for second in 0..4 {
        for number in 0..25 {
            recorder.push(&sample(second * 25 + number)).expect("written");
        }
        recorder.flush().expect("flushed");
        ends.push((std::fs::metadata(&data).expect("the file").len(), (second + 1) * 25));
    }
    // The process is killed: nothing is ended or written any more.
    std::mem::forget(recorder);
    let written = std::fs::read(&data).expect("the file");
    assert_eq!(load(&data).len(), 100);
    for length in 0..=written.len() {
        std::fs::write(&data, &written[..length]).expect("a file");
        let read = load(&data);
        let whole = ends.iter().filter(|end| end.0 <= length as u64).map(|end| end.1).max();
        assert!(read.len() as i64 >= whole.unwrap_or(0), "{length}: {} of {whole:?}", read.len());
        for (number, read) in read.samples().enumerate() {
            assert_eq!(read, sample(number as i64), "{length}");
        }
        let complete = ends.iter().any(|end| end.0 == length as u64);
        assert_eq!(read.info.skipped.is_empty(), complete, "{length}: {:?}", read.info.skipped);
    }
    // Of the members before the damage nothing is lost either.
    let mut damaged = written.clone();
    damaged[ends[2].0 as usize + 30] ^= 0xff;
    std::fs::write(&data, &damaged).expect("a file");
    assert!(load(&data).len() >= 50);
}

#[test]
fn what_a_sample_needs_later_is_added() {
    let folder = folder();
    let mut recorder =
        Recorder::create(&folder.path().join("me"), &RecordingInfo::default(), &["frame".into()])
            .expect("created");
    let data = recorder.path().to_owned();
    let later = GazeSample { device_time_ns: None, received_ns: 9, right: sample(3).combined, ..sample(1) };
    recorder.push_with(&GazeSample::at(5), &[1.0]).expect("written");
    recorder.flush().expect("flushed");
    recorder.push_with(&later, &[2.0]).expect("written");
    recorder.flush().expect("flushed");
    let expected = [GazeSample::at(5), later];
    let unfinished = load(&data);
    assert_eq!(samples_of(&unfinished), expected);
    assert!(unfinished.info.skipped.is_empty() && unfinished.info.notes.len() == 1);
    let finished = load(&recorder.finish().expect("finished"));
    assert_eq!(samples_of(&finished), expected);
    assert_eq!(finished.extra[0].values, [1.0, 2.0]);
    // Filled up, so that others can read it.
    let mut text = String::new();
    let file = std::fs::File::open(&data).expect("the file");
    io::Read::read_to_string(&mut flate2::read::MultiGzDecoder::new(file), &mut text).expect("text");
    let fields: Vec<usize> = text.lines().map(|row| row.split('\t').count()).collect();
    assert_eq!(fields.len(), 2);
    assert_eq!(fields[0], fields[1]);
}

#[test]
fn nothing_is_overwritten_by_a_recorder() {
    let folder = folder();
    let create = || Recorder::create(&folder.path().join("me"), &RecordingInfo::default(), &[]);
    let mut recorder = create().expect("created");
    recorder.push(&sample(1)).expect("written");
    drop(recorder);
    let error = create().expect_err("it is there").to_string();
    assert!(error.contains("is there already"), "{error}");
    assert_eq!(load(&folder.path().join("me_recording-eye3_physio.json")).len(), 1);
}

/// A disk of limited size.
#[derive(Clone, Debug)]
struct Disk {
    bytes: Arc<Mutex<Vec<u8>>>,
    room: Arc<Mutex<usize>>,
}

impl Sink for Disk {
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut disk = self.bytes.lock().expect("unpoisoned");
        let room = self.room.lock().expect("unpoisoned").saturating_sub(disk.len());
        disk.extend_from_slice(&bytes[..bytes.len().min(room)]);
        if bytes.len() > room { Err(io::Error::from(io::ErrorKind::StorageFull)) } else { Ok(()) }
    }

    fn cut(&mut self, length: u64) -> io::Result<()> {
        self.bytes.lock().expect("unpoisoned").truncate(length as usize);
        Ok(())
    }
}

#[test]
fn a_full_disk_is_one_line_and_what_is_there_stays() {
    let folder = folder();
    let (data, sidecar) = paths(&folder.path().join("me"));
    let disk = Disk { bytes: Arc::default(), room: Arc::new(Mutex::new(2000)) };
    let info = RecordingInfo::default();
    let mut recorder = Recorder::on(Box::new(disk.clone()), data.clone(), sidecar, &info, &[]);
    let mut error = None;
    let mut pushed = 0;
    while error.is_none() {
        recorder.push(&sample(pushed)).expect("waits");
        pushed += 1;
        if pushed % 10 == 0 {
            error = recorder.flush().err();
        }
    }
    let message = error.map(|error| error.to_string()).unwrap_or_default();
    assert!(message.contains("me_recording-eye3_physio.tsv.gz") && !message.contains('\n'), "{message}");
    let save = |disk: &Disk| std::fs::write(&data, &*disk.bytes.lock().expect("unpoisoned")).expect("a file");
    save(&disk);
    let read = load(&data);
    assert_eq!(read.len() as i64, pushed - 10);
    assert!(read.info.skipped.is_empty());
    // There is room again: what waited is written, and nothing is missing.
    *disk.room.lock().expect("unpoisoned") = 1 << 20;
    recorder.push(&sample(pushed)).expect("waits");
    recorder.flush().expect("written");
    save(&disk);
    assert_eq!(samples_of(&load(&data)), (0..=pushed).map(sample).collect::<Vec<_>>());
}

#[test]
fn a_disk_that_stays_full_takes_no_endless_memory() {
    let folder = folder();
    let (data, sidecar) = paths(&folder.path().join("me"));
    let disk = Disk { bytes: Arc::default(), room: Arc::new(Mutex::new(0)) };
    let info = RecordingInfo::default();
    let mut recorder = Recorder::on(Box::new(disk), data, sidecar.clone(), &info, &[]);
    let errors = (0..200_000).filter(|number| recorder.push(&sample(*number)).is_err()).count();
    assert!(errors > 0);
    assert!(recorder.finish().is_err());
    let sidecar = std::fs::read_to_string(sidecar).expect("the side-car");
    assert!(sidecar.contains("the disk was full") && sidecar.contains("\"Rows\": 200000"), "{sidecar}");
}

#[test]
fn a_side_car_that_cannot_be_written_costs_no_sample() {
    let folder = folder();
    let later = folder.path().join("later");
    let (data, sidecar) = paths(&later.join("me"));
    let disk = Disk { bytes: Arc::default(), room: Arc::new(Mutex::new(usize::MAX)) };
    let info = RecordingInfo::default();
    // The folder is not there, so that the side-car cannot be written.
    let mut recorder = Recorder::on(Box::new(disk.clone()), data.clone(), sidecar, &info, &[]);
    for number in 0..5 {
        recorder.push(&sample(number)).expect("waits");
    }
    let message = recorder.flush().expect_err("no side-car").to_string();
    assert!(message.contains("me_recording-eye3_physio.json") && !message.contains('\n'), "{message}");
    assert!(disk.bytes.lock().expect("unpoisoned").is_empty(), "no rows without their names");
    std::fs::create_dir(&later).expect("a folder");
    recorder.flush().expect("written");
    std::fs::write(&data, &*disk.bytes.lock().expect("unpoisoned")).expect("a file");
    assert_eq!(samples_of(&load(&data)), (0..5).map(sample).collect::<Vec<_>>());
}

#[test]
fn a_recording_that_cannot_be_replaced_stays() {
    let folder = folder();
    let mut recording = Recording::new(RecordingInfo::default());
    recording.push(&sample(1));
    let data = write_recording(&recording, &folder.path().join("me")).expect("written");
    let before = std::fs::read(&data).expect("the data");
    // A side-car that no file can replace.
    let sidecar = paths(&data).1;
    std::fs::remove_file(&sidecar).expect("removed");
    std::fs::create_dir(&sidecar).expect("a folder");
    recording.push(&sample(2));
    write_recording(&recording, &data).expect_err("a folder in its place");
    assert!(std::fs::read(&data).is_ok_and(|after| after == before));
    assert_eq!(folder.path().read_dir().expect("a folder").count(), 2, "nothing else is left");
}

/// Writes a pair of files and reads it.
fn foreign(sidecar: &str, rows: &str, options: &ReadOptions) -> Result<Recording, Error> {
    let folder = folder();
    let data = folder.path().join("sub-1_task-a_recording-eye1_physio.tsv.gz");
    std::fs::write(&data, gzip(rows)).expect("a file");
    std::fs::write(folder.path().join("sub-1_task-a_recording-eye1_physio.json"), sidecar).expect("a file");
    read(&data, options)
}

#[test]
fn files_of_others_read_in_their_units() {
    let sidecar = "\u{feff}{\"Columns\": [\"timestamp\", \"x_coordinate\", \"y_coordinate\", \"pupil_size\"],
        \"RecordedEye\": \"right\", \"SamplingFrequency\": 500, \"SampleCoordinateSystem\": \"gaze-on-screen\",
        \"timestamp\": {\"Units\": \"ms\"}, \"x_coordinate\": {\"Units\": \"pixel\"},
        \"y_coordinate\": {\"Units\": \"pixel\"}, \"Manufacturer\": \"A\", \"ManufacturersModelName\": \"B\",
        \"StimulusPresentation\": {\"ScreenResolution\": [1000, 500], \"ScreenSize\": [0.5, 0.25],
        \"ScreenDistance\": 0.7}}";
    let rows =
        "100\t250\t125\t812\r\n102\tn/a\tn/a\tn/a\r\n\r\nx\t1\t2\t3\r\n104.5\t-10\t600\t811\t7\r\n106\t1";
    let read = foreign(sidecar, rows, &ReadOptions::default()).expect("a recording");
    assert_eq!(read.times_ns(), [100_000_000, 102_000_000, 104_500_000]);
    let rights: Vec<_> = read.samples().map(|sample| (sample.right.valid, sample.right.point)).collect();
    let point = |x, y| Some(DVec2::new(x, y));
    assert_eq!(rights, [(true, point(0.25, 0.25)), (false, None), (true, point(-0.01, 1.2))]);
    assert!(read.samples().all(|sample| sample.left == EyeSample::default()));
    assert_eq!((read.info.device.as_str(), read.info.space), ("A B", Space::Display));
    assert_eq!(read.info.nominal_rate_hz, Some(500.0));
    assert!(read.info.screen.is_some_and(|screen| screen.distance_m == 0.7));
    assert_eq!(read.extra.len(), 1, "a pupil in arbitrary units");
    assert_eq!(read.extra[0].values[2], 811.0);
    let why: Vec<_> = read.info.skipped.iter().map(|skipped| (skipped.rows, skipped.why.as_str())).collect();
    assert_eq!(
        why,
        [
            (1, "no time, first in row 4: x\t1\t2\t3"),
            (1, "row with more fields than the side-car names; the rest left out"),
            (1, "the last row is cut"),
        ]
    );
}

#[test]
fn units_are_guessed_from_the_rate_and_points_need_a_display() {
    let sidecar = r#"{"Columns": ["timestamp", "x_coordinate", "y_coordinate"], "SamplingFrequency": 250,
        "x_coordinate": {"Units": "pixel"}}"#;
    let rows = "1000\t10\t20\n5000\t10\t20\n9000\t10\t20\n";
    let read = foreign(sidecar, rows, &ReadOptions::default()).expect("a recording");
    assert_eq!(read.times_ns(), [1_000_000, 5_000_000, 9_000_000], "microseconds");
    assert_eq!((read.info.notes.len(), read.extra.len()), (2, 2));
    assert_eq!(read.get(0).and_then(|sample| sample.gaze_point()), None);
    let screen = Screen { size_px: DVec2::new(100.0, 80.0), size_m: DVec2::new(0.5, 0.4), distance_m: 0.6 };
    let options = ReadOptions { screen: Some(screen), time_unit_s: Some(1e-3), ..ReadOptions::default() };
    let read = foreign(sidecar, rows, &options).expect("a recording");
    assert_eq!(read.times_ns()[0], 1_000_000_000);
    assert_eq!(read.get(0).and_then(|sample| sample.gaze_point()), Some(DVec2::new(0.1, 0.25)));
}

#[test]
fn angles_become_directions_and_rates_times() {
    let sidecar = r#"{"Columns": ["x_coordinate", "y_coordinate"], "SamplingFrequency": "200", "StartTime": -1.5,
        "RecordedEye": "left", "x_coordinate": {"Units": "deg"}}"#;
    let read = foreign(sidecar, "30\t0\n0\t-90\n0\t0", &ReadOptions::default()).expect("a recording");
    assert_eq!(read.times_ns(), [-1_500_000_000, -1_495_000_000, -1_490_000_000]);
    let directions: Vec<DVec3> = read.samples().filter_map(|sample| sample.left.direction).collect();
    let expected = [DVec3::new(0.5, 0.0, -(0.75f64.sqrt())), DVec3::NEG_Y, DVec3::NEG_Z];
    assert!(directions.iter().zip(expected).all(|(a, b)| a.abs_diff_eq(b, 1e-15)), "{directions:?}");
}

#[test]
fn what_is_missing_or_broken_is_named() {
    let folder = folder();
    let data = folder.path().join("sub-1_physio.tsv.gz");
    let message = |path: &Path| {
        let message = read(path, &ReadOptions::default()).expect_err("an error").to_string();
        assert!(!message.contains('\n'), "{message}");
        message
    };
    std::fs::write(&data, gzip("1\t2\t3\n")).expect("a file");
    assert!(message(&data).contains("has no side-car sub-1_physio.json"));
    let sidecar = folder.path().join("sub-1_physio.json");
    for (text, expected) in [
        ("{\"Columns\": 5}", "Columns"),
        ("{\"Columns\": [\"a\", 1]}", "Columns"),
        ("[1,\n2]", "no side-car"),
        ("{\"Columns\": [\"x_coordinate\"]}", "SamplingFrequency"),
        ("{\"Columns\": [\"timestamp\"], \"MaculaRecording\": 3}", "MaculaRecording"),
    ] {
        std::fs::write(&sidecar, text).expect("a file");
        let message = message(&data);
        assert!(message.contains(expected), "{message}");
    }
    std::fs::remove_file(&data).expect("removed");
    assert!(message(&sidecar).contains("sub-1_physio.tsv.gz is not beside it"));
}

#[test]
fn the_side_cars_of_a_data_set_are_joined() {
    let Some(source) = crate::testing::shared("data/gaze/bids_eyetracking_binocular") else { return };
    let root = folder();
    let beh = root.path().join("sub-01/beh");
    std::fs::create_dir_all(&beh).expect("folders");
    let copy = |name: &str, to: &Path| std::fs::copy(source.join(name), to.join(name)).expect("copied");
    for name in ["dataset_description.json", "task-FreeView_physio.json", "task-FreeView_physioevents.json"] {
        copy(name, root.path());
    }
    copy("sub-01_task-FreeView_run-01_recording-eye1_physio.json", &beh);
    let data: PathBuf = beh.join("sub-01_task-FreeView_run-01_recording-eye1_physio.tsv.gz");
    std::fs::write(&data, gzip("767983\t960.1\t540\t1200\n767984\t961\t541\t1201\n")).expect("a file");
    let read = load(&data);
    assert_eq!(read.times_ns(), [767_983_000_000, 767_984_000_000]);
    assert!(read.info.device.starts_with("SR-Research EYELINK II"));
    assert_eq!(read.info.nominal_rate_hz, Some(1000.0));
    // The set does not tell the display's size.
    assert_eq!(
        read.extra.iter().map(|column| column.name.as_str()).collect::<Vec<_>>(),
        ["x_coordinate", "y_coordinate", "pupil_size"]
    );
    let screen = Screen { size_px: DVec2::new(1920.0, 1080.0), size_m: DVec2::ONE, distance_m: 0.6 };
    let read =
        read_path(&data, &ReadOptions { screen: Some(screen), ..ReadOptions::default() }).expect("read");
    assert_eq!(
        read.get(1).and_then(|sample| sample.left.point),
        Some(DVec2::new(961.0 / 1920.0, 541.0 / 1080.0))
    );
}
