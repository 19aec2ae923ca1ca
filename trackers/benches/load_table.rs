//! How long an hour at 1 kHz takes to load, 3.6 million rows laid out like GazeBase, and what memory.

use criterion::{Criterion, criterion_group, criterion_main};
use macula_trackers::formats::{ReadOptions, read};
use std::fs::File;
use std::hint::black_box;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::time::Instant;

/// An hour at 1 kHz.
const ROWS: u32 = 3_600_000;

/// Six columns that all hold numbers, with as many digits as the data set has.
fn write_session(path: &Path) -> io::Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    writeln!(file, "n,x,y,val,dP,lab")?;
    for row in 0..ROWS {
        let seconds = f64::from(row) * 1e-3;
        let (x, y) = (15.0 * (seconds * 0.7).sin(), 8.0 * (seconds * 1.1).cos());
        writeln!(file, "{row},{x:.6},{y:.6},0,{},{}", 3000 + row % 400, row % 3)?;
    }
    file.flush()
}

/// The most memory that this process has had, MB.
fn peak_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024.0 / 1e6)
}

fn load(c: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a folder for the session");
    let path = folder.path().join("session.csv");
    write_session(&path).expect("room for 150 MB");
    let begin = Instant::now();
    let recording = read(&path, &ReadOptions::default()).expect("well formed");
    assert_eq!(recording.len(), ROWS as usize);
    let peak = peak_mb().map_or("unknown".to_owned(), |megabytes| format!("{megabytes:.0} MB"));
    println!("first load: {:.2} s; most memory of the process: {peak}", begin.elapsed().as_secs_f64());
    drop(recording);
    let mut group = c.benchmark_group("formats");
    group.sample_size(10);
    group.bench_function("load an hour of CSV at 1 kHz", |bencher| {
        bencher.iter(|| read(black_box(&path), &ReadOptions::default()).expect("well formed").len());
    });
    group.finish();
}

criterion_group!(benches, load);
criterion_main!(benches);
