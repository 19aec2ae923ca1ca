//! What one HID report costs: `cargo bench -p macula-trackers --bench hid`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec2;
use macula_trackers::hid::{Layout, ReportDecoder, StandardDecoder};
use std::hint::black_box;

/// The tracking data of the usage page's reference: a clock of eight bytes, gaze and both eyes.
#[rustfmt::skip]
const DESCRIPTOR: &[u8] = &[
    0x05, 0x12, 0x09, 0x01, 0xa1, 0x01, 0x09, 0x10, 0xa1, 0x02, 0x85, 0x10,
    0x15, 0x00, 0x26, 0xff, 0x00, 0x66, 0x01, 0x10, 0x55, 0x0a, 0x75, 0x08, 0x95, 0x08, 0x09, 0x20, 0x81, 0x02,
    0x17, 0x80, 0x7b, 0xe1, 0xff, 0x27, 0x80, 0x84, 0x1e, 0x00, 0x65, 0x11, 0x55, 0x0c, 0x75, 0x20,
    0x09, 0x24, 0xa1, 0x00, 0x95, 0x02, 0x09, 0x21, 0x09, 0x22, 0x81, 0x03, 0xc0,
    0x09, 0x25, 0xa1, 0x00, 0x95, 0x03, 0x09, 0x21, 0x09, 0x22, 0x09, 0x23, 0x81, 0x03, 0xc0,
    0x09, 0x26, 0xa1, 0x00, 0x95, 0x03, 0x09, 0x21, 0x09, 0x22, 0x09, 0x23, 0x81, 0x03, 0xc0,
    0x95, 0x06, 0x81, 0x03, 0xc0, 0xc0,
];

fn reports() -> Vec<[u8; 65]> {
    let report = |index: u64| {
        let mut bytes = [0x10; 65];
        bytes[1..9].copy_from_slice(&(index * 1000).to_le_bytes());
        let wave = (index % 1000) as i32 * 300;
        let numbers = [wave, 150_000, 230_000, 150_000, 600_000, 293_000, 150_000, 600_000];
        for (index, number) in numbers.into_iter().enumerate() {
            bytes[9 + 4 * index..13 + 4 * index].copy_from_slice(&i32::to_le_bytes(number));
        }
        bytes
    };
    (0..1000).map(report).collect()
}

fn hid(criterion: &mut Criterion) {
    let layout = Layout::parse(DESCRIPTOR).expect("a good descriptor");
    let reports = reports();
    let mut group = criterion.benchmark_group("hid");
    group.throughput(Throughput::Elements(reports.len() as u64));
    group.bench_function("1000 reports to numbers", |bencher| {
        bencher
            .iter(|| reports.iter().filter(|report| black_box(layout.decode(&report[..])).is_ok()).count());
    });
    let mut decoder = StandardDecoder::new(layout.clone(), Some(DVec2::new(0.527, 0.296)));
    group.bench_function("1000 reports to samples", |bencher| {
        bencher.iter(|| {
            reports.iter().filter(|report| black_box(decoder.decode(&report[..], 0)).is_ok()).count()
        });
    });
    group.finish();
    criterion.bench_function("hid/descriptor", |bencher| {
        bencher.iter(|| Layout::parse(black_box(DESCRIPTOR)).is_ok());
    });
}

criterion_group!(benches, hid);
criterion_main!(benches);
