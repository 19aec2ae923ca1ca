//! Loading an hour of 1 kHz in the project's own format (3.6 million rows of 8 columns), and what a
//! sample of a live source costs. Prints the time, the file's size and the peak memory too.

use criterion::{Criterion, criterion_group, criterion_main};
use glam::{DVec2, DVec3};
use macula_trackers::bids::Recorder;
use macula_trackers::formats::{ReadOptions, read};
use macula_trackers::recording::RecordingInfo;
use macula_trackers::sample::{EyeSample, GazeSample};
use macula_trackers::stamp::{StampSettings, Stamper};
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

const ROWS: i64 = 3_600_000;

/// Values with all their digits, as trackers tell them.
fn sample(number: i64) -> GazeSample {
    let phase = number as f64 * 1e-3;
    let combined = EyeSample {
        valid: true,
        direction: Some(DVec3::new(phase.sin() * 0.3, (phase * 1.7).cos() * 0.2, -1.0).normalize()),
        point: Some(DVec2::new(0.5 + phase.sin() * 0.4, 0.5 - phase.cos() * 0.3)),
        pupil_mm: Some(3.0 + (phase * 0.1).sin()),
        ..EyeSample::default()
    };
    GazeSample { combined, ..GazeSample::at(number * 1_000_000) }
}

fn write(folder: &Path) -> PathBuf {
    let mut recorder =
        Recorder::create(&folder.join("hour"), &RecordingInfo::default(), &[]).expect("a new recording");
    for number in 0..ROWS {
        recorder.push(&sample(number)).expect("room on the disk");
    }
    recorder.finish().expect("room on the disk")
}

/// Peak memory of this process since the last reset, MiB; `None` where the system does not tell.
fn peak_mib() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kib| kib / 1024)
}

fn load(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a folder");
    let start = Instant::now();
    let path = write(folder.path());
    let written = start.elapsed();
    let size = std::fs::metadata(&path).map_or(0, |metadata| metadata.len());
    // Has the system count the peak anew.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
    let start = Instant::now();
    let recording = read(&path, &ReadOptions::default()).expect("the recording");
    println!(
        "an hour at 1 kHz: {} samples, {} MiB on disk; written in {written:.2?}, loaded in {:.2?}, peak {:?} MiB",
        recording.len(),
        size >> 20,
        start.elapsed(),
        peak_mib(),
    );
    assert_eq!(recording.get(1_234_567), Some(sample(1_234_567)));
    drop(recording);
    let mut group = criterion.benchmark_group("recording");
    group.sample_size(10).warm_up_time(Duration::from_millis(1)).measurement_time(Duration::from_secs(10));
    group.bench_function("load an hour at 1 kHz", |bench| {
        bench.iter(|| read(black_box(&path), &ReadOptions::default()).expect("the recording"));
    });
    group.finish();
}

fn stamp(criterion: &mut Criterion) {
    let mut stamper = Stamper::new(StampSettings::default());
    let mut events = Vec::new();
    let mut number = 0;
    criterion.bench_function("stamp a sample", |bench| {
        bench.iter(|| {
            number += 1;
            events.clear();
            stamper.stamp(black_box(sample(number)), &mut events);
        });
    });
}

criterion_group!(benches, stamp, load);
criterion_main!(benches);
