//! Every file in `tests/data` is read: a good one must give what its side-car expects, a broken one an error.

use macula_trackers::formats::{ReadOptions, read};
use macula_trackers::recording::Recording;
use serde::Deserialize;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

/// What a side-car says.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Expected {
    format: String,
    samples: usize,
    valid: usize,
    duration_s: f64,
    rate_hz: Option<f64>,
    skipped_rows: u64,
}

fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data")
}

fn side_car(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".toml");
    path.with_file_name(name)
}

/// The recordings below a folder.
fn recordings(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("readable").path();
        let name = path.file_name().and_then(OsStr::to_str).unwrap_or_default();
        if path.is_dir() {
            found.extend(recordings(&path));
        } else if !name.starts_with('.')
            && !name.ends_with(".toml")
            && !name.ends_with(".md")
            && name != "LICENSE"
            && !is_bids_side_car(&path)
        {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// It is read with the data beside it.
fn is_bids_side_car(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "json") && path.with_extension("tsv.gz").exists()
}

fn is_broken(path: &Path) -> bool {
    path.starts_with(data().join("broken"))
}

/// Whether a value is the expected one within 1 part in a million.
fn near(value: f64, expected: f64) -> bool {
    (value - expected).abs() <= 1e-6 * expected.abs().max(1e-3)
}

fn differences(recording: &Recording, expected: &Expected) -> Vec<String> {
    let usable = |sample: &macula_trackers::sample::GazeSample| {
        sample.combined.valid || sample.left.valid || sample.right.valid
    };
    let valid = recording.samples().filter(usable).count();
    let skipped: u64 = recording.info.skipped.iter().map(|skipped| skipped.rows).sum();
    let rate_hz = recording.rate_hz().unwrap_or(0.0);
    let checks = [
        ("format", recording.info.format == expected.format, recording.info.format.to_owned()),
        ("samples", recording.len() == expected.samples, recording.len().to_string()),
        ("valid", valid == expected.valid, valid.to_string()),
        ("duration_s", near(recording.duration_s(), expected.duration_s), recording.duration_s().to_string()),
        ("rate_hz", expected.rate_hz.is_none_or(|expected| near(rate_hz, expected)), rate_hz.to_string()),
        ("skipped_rows", skipped == expected.skipped_rows, format!("{:?}", recording.info.skipped)),
    ];
    let wrong = checks.into_iter().filter(|(_, good, _)| !good);
    wrong.map(|(name, _, value)| format!("{name} is {value}")).collect()
}

#[test]
fn good_recordings_give_what_their_side_cars_expect() {
    let good: Vec<_> = recordings(&data()).into_iter().filter(|path| !is_broken(path)).collect();
    assert!(good.len() >= 15, "only {} recordings", good.len());
    for path in good {
        let text = fs::read_to_string(side_car(&path));
        let text = text.unwrap_or_else(|error| panic!("{}: {error}", side_car(&path).display()));
        let expected: Expected = toml::from_str(&text).expect("a side-car as README.md tells");
        let recording = read(&path, &ReadOptions::default()).expect("a good recording");
        let wrong = differences(&recording, &expected);
        assert!(wrong.is_empty(), "{}: {}", path.display(), wrong.join("; "));
    }
}

#[test]
fn broken_recordings_give_an_error_of_one_line() {
    let broken = recordings(&data().join("broken"));
    assert!(broken.len() >= 5, "only {} files", broken.len());
    for path in broken {
        let error = read(&path, &ReadOptions::default()).expect_err("a broken file").to_string();
        let name = path.file_name().and_then(OsStr::to_str).unwrap_or_default();
        assert!(error.contains(name) && !error.contains('\n'), "{error}");
    }
}

#[test]
fn a_header_without_samples_says_so() {
    for name in ["sranipal_header_only.csv", "header_only.tsv"] {
        let error = read(&data().join("broken").join(name), &ReadOptions::default()).expect_err("no samples");
        assert!(error.to_string().contains("holds a header but no samples"), "{error}");
    }
}
