//! Broken recordings: every reader gets mutations of small real-like files. Whatever comes of it, there is
//! no panic, and memory stays within a multiple of the file's size. The same as the fuzz target
//! `formats`, bounded.

use glam::DVec2;
use macula_trackers::formats::{self, FORMATS, Input, ReadOptions};
use macula_trackers::recording::{Recording, Screen};
use proptest::prelude::*;
use proptest::sample::Index;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// Of longer files the front is taken: enough for a header and some rows.
const SEED_BYTES: usize = 4096;
/// Seeds are a few kilobytes, so a reader that needs this much trusted a length in the file.
const MAX_RESIDENT_KB: u64 = 512 * 1024;

const GLASSES: &str = "{\"type\":\"gaze\",\"timestamp\":0.5,\"data\":{\"gaze2d\":[0.25,0.75],\"gaze3d\":[-1.0,-5.0,100.0],\
    \"eyeleft\":{\"gazeorigin\":[30.0,-10.0,-25.0],\"gazedirection\":[-0.6,0.0,0.8],\"pupildiameter\":3.5},\"eyeright\":{}}}\n\
    {\"type\":\"gaze\",\"timestamp\":0.51,\"data\":{}}\n";
const EYELINK: &str = "** CONVERTED FROM a.edf\nMSG\t11 GAZE_COORDS 0.00 0.00 1919.00 1079.00\n\
    START\t12 \tLEFT\tRIGHT\tSAMPLES\tEVENTS\nSAMPLES\tGAZE\tLEFT\tRIGHT\tRATE\t2000.00\tTRACKING\tCR\n\
    12\t  960.0\t  540.0\t  288.0\t  480.0\t  810.0\t  305.0\t.....\n12\t   .\t   .\t    0.0\t  9.4\t  5.2\t  2.0\t.C...\n\
    EFIX L   12\t14\t4\t  961.2\t  540.5\t    284\nSAMPLES HREF RIGHT RATE 1000\n14 1 2 3 ...\nSAMPLES RAW LEFT\n15 1 2 3 ...\n";
const ARFF: &str = "@RELATION gaze_360\n%@METADATA width_px 1920\n%@METADATA height_px 1080\n%@METADATA distance_mm 450\n\
    %@METADATA width_mm 400\n%@METADATA height_mm 225\n@ATTRIBUTE time INTEGER\n@ATTRIBUTE x NUMERIC\n@ATTRIBUTE y NUMERIC\n\
    @ATTRIBUTE confidence NUMERIC\n@ATTRIBUTE x_head NUMERIC\n@ATTRIBUTE y_head NUMERIC\n@ATTRIBUTE angle_deg_head NUMERIC\n\
    @ATTRIBUTE label {unassigned,fixation,saccade}\n@DATA\n0,960,540,1.00,960,540,1.22,fixation\n5000,959,539,1,959,539,?,saccade\n";
const HID: &str = "N: Tracker\nR: 57 05 12 09 01 a1 01 09 10 a1 02 85 01 15 00 27 ff ff 00 00 75 10 95 01 66 01 10 55 0d 09 20 \
    81 02 16 00 80 26 ff 7f 65 11 55 0f 09 24 a1 00 95 02 09 21 09 22 81 02 c0 c0 c0\n\
    E: 000001.000000 7 01 fa ff 64 00 32 00\nE: 000001.010000 7 01 04 00 c8 00 64 00\n";

fn xdf() -> Vec<u8> {
    let chunk = |tag: u16, body: &[u8]| {
        [&[4][..], &(body.len() as u32 + 2).to_le_bytes(), &tag.to_le_bytes(), body].concat()
    };
    let xml = "<?xml version=\"1.0\"?><info><name>Eyes</name><type>Gaze</type><channel_count>2</channel_count>\
        <nominal_srate>100</nominal_srate><channel_format>float32</channel_format><desc><channels>\
        <channel><label>x</label><eye>left</eye><type>ScreenX</type><unit>normalized</unit></channel>\
        <channel><label>y</label><eye>left</eye><type>ScreenY</type><unit>normalized</unit></channel>\
        </channels></desc></info>";
    let header = [&1u32.to_le_bytes()[..], xml.as_bytes()].concat();
    let row = [&[8][..], &9.5f64.to_le_bytes(), &0.5f32.to_le_bytes(), &0.5f32.to_le_bytes()].concat();
    let rows = [&1u32.to_le_bytes()[..], &[1, 3], &row, &[0], &row[9..], &row].concat();
    let offset = [&1u32.to_le_bytes()[..], &9f64.to_le_bytes(), &(-0.5f64).to_le_bytes()].concat();
    let boundary = b"\x43\xA5\x46\xDC\xCB\xF5\x41\x0F\xB3\x0E\xD5\x46\x73\x83\xCB\xE4";
    let chunks = [chunk(2, &header), chunk(4, &offset), chunk(3, &rows), chunk(5, boundary), chunk(3, &rows)];
    [b"XDF:".to_vec(), chunks.concat()].concat()
}

fn npy() -> Vec<u8> {
    let header = "{'descr': [('t', '<f8'), ('x', '<f4'), ('y', '<f4'), ('status', '|b1'), ('evt', '|u1')], \
        'fortran_order': False, 'shape': (2,), }\n";
    let row = [&0.001f64.to_le_bytes()[..], &1f32.to_le_bytes(), &2f32.to_le_bytes(), &[1, 2]].concat();
    let length = (header.len() as u16).to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), &row, &row].concat()
}

/// The front of every file below a folder.
fn fronts(folder: &Path, seeds: &mut Vec<Vec<u8>>) {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            fronts(&path, seeds);
        } else if let Ok(input) = Input::open(&path) {
            seeds.push(input.bytes[..input.bytes.len().min(SEED_BYTES)].to_vec());
        }
    }
}

static SEEDS: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let texts = [GLASSES, EYELINK, ARFF, HID].map(|text| text.as_bytes().to_vec());
    let mut seeds: Vec<_> = texts.into_iter().chain([xdf(), npy()]).collect();
    fronts(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data"), &mut seeds);
    seeds
});

#[derive(Clone, Debug)]
enum Edit {
    Set(u8),
    Cut,
    Remove(usize),
    Repeat(usize),
    Insert(&'static [u8]),
    Splice { seed: Index, from: Index, length: usize },
}

fn edits() -> impl Strategy<Value = Vec<(Index, Edit)>> {
    // What a length, a count or a number should not be.
    let tokens: Vec<&'static [u8]> = vec![
        b"\xff\xff\xff\xff\xff\xff\xff\xff",
        b"\x08\0\0\0\0\0\0\0\x10",
        b"\x80",
        b"nan",
        b"inf",
        b"-1e308",
        b"1e999",
        b"99999999999999999999",
        b"-9223372036854775808",
        b"\n",
        b"\r",
        b"\t",
        b",",
        b";",
        b"\"",
        b"'",
        b"{",
        b"}",
        b"(",
        b"[",
        b"<",
        b"\0",
        b"\xef\xbb\xbf",
    ];
    let edit = prop_oneof![
        4 => any::<u8>().prop_map(Edit::Set),
        1 => Just(Edit::Cut),
        2 => (1usize..64).prop_map(Edit::Remove),
        2 => (1usize..256).prop_map(Edit::Repeat),
        4 => prop::sample::select(tokens).prop_map(Edit::Insert),
        1 => (any::<Index>(), any::<Index>(), 1usize..512).prop_map(|(seed, from, length)| Edit::Splice { seed, from, length }),
    ];
    prop::collection::vec((any::<Index>(), edit), 0..8)
}

fn mutate(bytes: &mut Vec<u8>, edits: &[(Index, Edit)]) {
    for (index, edit) in edits {
        if bytes.is_empty() {
            return;
        }
        let at = index.index(bytes.len());
        let until = |length: usize| (at + length).min(bytes.len());
        match edit {
            Edit::Set(byte) => bytes[at] = *byte,
            Edit::Cut => bytes.truncate(at),
            Edit::Remove(length) => drop(bytes.drain(at..until(*length))),
            Edit::Repeat(length) => bytes.extend_from_within(at..until(*length)),
            Edit::Insert(token) => drop(bytes.splice(at..at, token.iter().copied())),
            Edit::Splice { seed, from, length } => {
                let other = seed.get(&SEEDS);
                let from = from.index(other.len().max(1)).min(other.len());
                let end = (from + length).min(other.len());
                bytes.splice(at..at, other[from..end].iter().copied());
            }
        }
    }
}

/// What holds for everything that was read from so many bytes.
fn check(recording: &Recording, bytes: usize) {
    assert!(!recording.is_empty(), "a recording without samples is an error");
    assert!(recording.len() <= bytes, "{} samples of {bytes} bytes", recording.len());
    assert!(recording.extra.iter().all(|column| column.values.len() == recording.len()));
    let extra: usize = recording.extra.iter().map(|column| column.values.len()).sum();
    assert!(extra <= 4 * bytes, "{extra} extra values of {bytes} bytes");
    assert!(recording.events.len() <= bytes);
    assert_eq!(recording.samples().count(), recording.len());
    let text = recording.info.notes.iter().chain(recording.info.skipped.iter().map(|skipped| &skipped.why));
    assert!(text.clone().count() < 100 && text.clone().map(String::len).sum::<usize>() < 10_000 + 4 * bytes);
    assert!(recording.duration_s() >= 0.0 && recording.rate_hz().is_none_or(|rate| rate > 0.0));
}

/// As an unknown file, and as each format by name; with a display or without.
fn read_all(bytes: &[u8], screen: Option<Screen>) {
    let Ok(input) = Input::of_bytes(Path::new("mutated"), bytes.to_vec()) else { return };
    let named = FORMATS.iter().map(|format| Some(format.name.to_owned()));
    for format in named.chain([None]) {
        let options = ReadOptions { format, screen, ..ReadOptions::default() };
        match formats::read_input(&input, &options) {
            Ok(recording) => check(&recording, input.bytes.len()),
            Err(error) => assert!(!error.to_string().contains('\n'), "an error is one line: {error}"),
        }
    }
}

/// The most memory that this process ever had, kB; `None` where the system does not tell.
fn peak_resident_kb() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_ascii_whitespace().nth(1)?.parse().ok()
}

#[test]
fn seeds_are_readable() {
    for seed in SEEDS.iter() {
        read_all(seed, None);
    }
    for seed in [GLASSES.as_bytes(), EYELINK.as_bytes(), ARFF.as_bytes(), HID.as_bytes(), &xdf(), &npy()] {
        let input = Input::of_bytes(Path::new("seed"), seed.to_vec()).expect("not compressed");
        let recording = formats::read_input(&input, &ReadOptions::default()).expect("a good file");
        assert!(recording.len() >= 2 && recording.info.skipped.is_empty(), "{:?}", recording.info);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2048, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn mutated_files_give_an_error_or_a_recording(
        seed in any::<Index>(),
        edits in edits(),
        has_screen in any::<bool>(),
    ) {
        let size_px = DVec2::new(1600.0, 1200.0);
        let screen = has_screen.then_some(Screen { size_px, size_m: DVec2::ONE, distance_m: 1.0 });
        let mut bytes = seed.get(&SEEDS).clone();
        mutate(&mut bytes, &edits);
        read_all(&bytes, screen);
        prop_assert!(peak_resident_kb().is_none_or(|peak| peak < MAX_RESIDENT_KB));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// The folder of a Companion phone: one of its files is broken.
    #[test]
    fn mutated_folders_give_an_error_or_a_recording(broken in any::<Index>(), edits in edits()) {
        let folder = tempfile::tempdir().expect("a place for files");
        let dtype = "[(\"optical_axis_left_x\",\"float32\"),(\"optical_axis_left_y\",\"float32\"),(\"optical_axis_left_z\",\"float32\")]";
        let times: Vec<u8> = [5i64, 9, 13].iter().flat_map(|time| time.to_le_bytes()).collect();
        let floats: Vec<u8> = (0u8..9).flat_map(|value| f32::from(value).to_le_bytes()).collect();
        let mut files = [
            ("info.json", b"{\"android_device_name\":\"Neon Companion\",\"gaze_frequency\":200}".to_vec()),
            ("gaze.dtype", b"[(\"x\",\"float32\"),(\"y\",\"float32\")]".to_vec()),
            ("gaze ps1.raw", floats[..24].to_vec()),
            ("gaze ps1.time", times.clone()),
            ("eye_state.dtype", dtype.into()),
            ("eye_state ps1.raw", floats),
            ("eye_state ps1.time", times),
        ];
        let at = broken.index(files.len());
        mutate(&mut files[at].1, &edits);
        let bytes = files.iter().map(|(_, content)| content.len()).sum();
        for (name, content) in &files {
            fs::write(folder.path().join(name), content).expect("written");
        }
        if let Ok(recording) = formats::read(&folder.path().join("gaze ps1.raw"), &ReadOptions::default()) {
            check(&recording, bytes);
        }
    }
}
