//! The source over recorded devices: what the thread makes of reports, gaps, rubbish and unplugging.

use super::{TRACKER, report};
use crate::error::{Error, Result};
use crate::hid::{
    ConfigurationStatus, HidOptions, HidSource, ModeRequest, Port, RecordedTransport, StartOptions,
    Transport, start_standard,
};
use crate::source::{GazeSource, SourceEvent};
use glam::DVec2;
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// Devices that are plugged in one after the other; `None` is an attempt that fails.
#[derive(Debug)]
struct Plugs(VecDeque<Option<RecordedTransport>>);

impl Port for Plugs {
    fn open(&mut self) -> Result<Box<dyn Transport>> {
        let next = self.0.pop_front().flatten();
        let next = next.ok_or_else(|| Error::device("tracker", "it is not plugged in"))?;
        Ok(Box::new(next))
    }
}

fn device(reports: impl IntoIterator<Item = Vec<u8>>) -> RecordedTransport {
    let configuration = [&[2][..], &600_000u32.to_le_bytes(), &300_000u32.to_le_bytes()].concat();
    RecordedTransport {
        descriptor: TRACKER.to_vec(),
        reports: reports.into_iter().collect(),
        features: vec![configuration, vec![3, 1, 0xe8, 0x03]],
        written: Vec::new(),
    }
}

/// Samples of a tracker at 1 kHz; numbers tell them apart.
fn sample(number: i32) -> Vec<u8> {
    report(number as u64 * 1000, [number, 0, -30_000, 0, 600_000, 30_000, 0, 600_000])
}

fn options() -> HidOptions {
    HidOptions { retry: Duration::from_millis(1), ..HidOptions::default() }
}

fn open(plugs: Vec<Option<RecordedTransport>>, options: HidOptions) -> Result<HidSource> {
    HidSource::standard("tracker".to_owned(), Box::new(Plugs(plugs.into())), options)
}

/// Polls until an event of the kind has come so many times.
fn poll_until(source: &mut HidSource, times: usize, kind: fn(&SourceEvent) -> bool) -> Vec<SourceEvent> {
    let start = Instant::now();
    let mut events = Vec::new();
    while events.iter().filter(|event| kind(event)).count() < times {
        source.poll(0, &mut events).expect("the thread runs");
        assert!(start.elapsed() < Duration::from_secs(10), "{events:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
    events
}

fn is_disconnect(event: &SourceEvent) -> bool {
    matches!(event, SourceEvent::Disconnected { .. })
}

/// Samples as the numbers that they were made with, and losses as negative numbers.
fn numbers(events: &[SourceEvent]) -> Vec<i64> {
    let number = |event: &SourceEvent| match event {
        SourceEvent::Sample(sample) => Some(sample.device_time_ns.expect("a clock") / 1_000_000),
        SourceEvent::Lost { samples } => Some(-(*samples as i64)),
        _ => None,
    };
    events.iter().filter_map(number).collect()
}

#[test]
fn a_device_is_asked_for_everything_at_the_start() {
    let mut transport = device([]);
    let options = StartOptions { mode: ModeRequest::GAZE.and(ModeRequest::EYES), ..StartOptions::default() };
    let decoder = start_standard(&mut transport, &options).expect("a good device");
    assert_eq!(transport.written, [[4, 3]]);
    assert_eq!(decoder.clock(), "tracker (1 us, 64 bit)");
    let about = decoder.about();
    assert_eq!(about.notes, [""; 0]);
    assert_eq!(about.capabilities, None);
    assert_eq!(about.configuration.and_then(|told| told.screen_m()), Some(DVec2::new(0.6, 0.3)));
    let status = about.status.expect("a status");
    assert_eq!((status.configuration, status.sampling_hz), (Some(ConfigurationStatus::Ready), Some(1000.0)));
    // Without its features it is usable all the same, and says what is missing.
    let mut bare = RecordedTransport { features: vec![vec![2, 0, 0]], ..device([]) };
    let decoder = start_standard(&mut bare, &options).expect("a usable device");
    let notes = decoder.about().notes.join("; ");
    assert!(notes.contains("the report has 3 bytes, not 9") && notes.contains("no such feature"), "{notes}");
}

#[test]
fn samples_gaps_and_rubbish_come_in_order() {
    let reports =
        [sample(1), sample(2), vec![9], vec![1, 2], sample(3), sample(8), vec![3, 2, 0xe8, 0x03], sample(9)];
    let mut source = open(vec![Some(device(reports))], options()).expect("a device");
    assert_eq!(source.info().rate_hz, Some(1000.0));
    let events = poll_until(&mut source, 1, is_disconnect);
    assert_eq!(numbers(&events), [1, 2, 3, -4, 8, 9]);
    let rejected = SourceEvent::Rejected { count: 2, why: "the report has 2 bytes, not 41".to_owned() };
    assert_eq!(events[2], rejected);
    let SourceEvent::Sample(sample) = &events[0] else { panic!("{events:?}") };
    let now_ns = crate::time::host_now_ns();
    assert!(
        (0..10_000_000_000).contains(&(now_ns - sample.received_ns)) && sample.time_ns <= sample.received_ns
    );
    assert_eq!(sample.combined.point, Some(DVec2::new(1e-6 / 0.6, 0.0)));
    // The status report in between told of a new state.
    let status = source.about().status.expect("a status");
    assert_eq!(status.configuration, Some(ConfigurationStatus::Configuring));
}

#[test]
fn a_device_that_is_unplugged_is_found_again() {
    // In between it is not there, there but unreadable, and there as something else.
    let mouse = RecordedTransport { descriptor: vec![0x05, 0x01], ..RecordedTransport::default() };
    let plugs =
        vec![Some(device([sample(5)])), None, Some(mouse), None, Some(device([sample(1), sample(2)]))];
    let mut source = open(plugs, options()).expect("a device");
    let events = poll_until(&mut source, 2, is_disconnect);
    // Its clock began anew, which is no loss.
    assert_eq!(numbers(&events), [5, 1, 2]);
    assert_eq!(events.iter().position(is_disconnect), Some(1));
    assert_eq!(events[2], SourceEvent::Reconnected);
}

/// A device that opens each time and fails at the first read.
#[derive(Debug, Default)]
struct Broken(Arc<AtomicU32>);

impl Port for Broken {
    fn open(&mut self) -> Result<Box<dyn Transport>> {
        self.0.fetch_add(1, Ordering::Relaxed);
        Ok(Box::new(device([])))
    }
}

#[test]
fn a_device_that_fails_on_and_on_is_tried_at_leisure() {
    let port = Broken::default();
    let opened = Arc::clone(&port.0);
    let options = HidOptions { retry: Duration::from_millis(20), ..options() };
    let start = Instant::now();
    let mut source = HidSource::standard("tracker".to_owned(), Box::new(port), options).expect("a device");
    let events = poll_until(&mut source, 4, is_disconnect);
    assert!(events.len() >= 7, "each comes back before it goes: {events:?}");
    drop(source);
    // The first attempt does not wait; all others do.
    let most = start.elapsed().as_millis() / 20 + 1;
    let opened = opened.load(Ordering::Relaxed);
    assert!(u128::from(opened) <= most, "{opened} attempts, {most} at most");
}

#[test]
fn what_nobody_polls_is_dropped_from_the_old_end() {
    let small = HidOptions { queue: 10, ..options() };
    let reports = (1..=100).map(sample).chain([vec![3, 4, 0xe8, 0x03]]).chain(vec![Vec::new(); 1000]);
    let mut source = open(vec![Some(device(reports))], small).expect("a device");
    let start = Instant::now();
    // All samples have been read when the status after them is known.
    while source.about().status.and_then(|status| status.configuration)
        != Some(ConfigurationStatus::UserCalibrationNeeded)
    {
        assert!(start.elapsed() < Duration::from_secs(10));
        std::thread::sleep(Duration::from_millis(1));
    }
    let mut events = Vec::new();
    source.poll(0, &mut events).expect("the thread runs");
    let expected: Vec<i64> = [-90].into_iter().chain(91..=100).collect();
    assert_eq!(numbers(&events), expected);
}

#[test]
fn silence_is_a_stall() {
    let reports = [sample(1), sample(2)].into_iter().chain(vec![Vec::new(); 1000]);
    let mut source = open(vec![Some(device(reports))], options()).expect("a device");
    poll_until(&mut source, 1, |event| matches!(event, SourceEvent::Stalled { .. }));
}

#[test]
fn the_first_attempt_must_succeed_and_dropping_ends_the_thread() {
    let error = open(vec![None], options()).expect_err("nothing there").to_string();
    assert_eq!(error, "tracker: it is not plugged in");
    let slow = HidOptions { retry: Duration::from_secs(3600), ..HidOptions::default() };
    let mut source = open(vec![Some(device([]))], slow).expect("a device");
    poll_until(&mut source, 1, is_disconnect);
    let start = Instant::now();
    drop(source);
    assert!(start.elapsed() < Duration::from_secs(5));
}
