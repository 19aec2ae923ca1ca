//! Any bytes as a recording: to the format they look like, and to each by name.
#![no_main]

use libfuzzer_sys::fuzz_target;
use macula_trackers::formats::{FORMATS, Input, ReadOptions, read_input};
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    // What is compressed may unpack to gigabytes, as a good file may.
    if bytes.starts_with(&[0x1f, 0x8b]) {
        return;
    }
    let Ok(input) = Input::of_bytes(Path::new("fuzz"), bytes.to_vec()) else { return };
    let named = FORMATS.iter().map(|format| Some(format.name.to_owned()));
    for format in named.chain([None]) {
        if let Ok(recording) = read_input(&input, &ReadOptions { format, ..ReadOptions::default() }) {
            assert!(recording.len() <= bytes.len());
            assert!(recording.extra.iter().all(|column| column.values.len() == recording.len()));
        }
    }
});
