//! Real sockets, and the program's own samples.

use super::*;
use crate::sample::{EyeSample, GazeSample};
use crate::source::{GazeSource, SourceEvent, SourceInfo};
use crate::stamp::StampSettings;
use crate::time::host_now_ns;
use glam::{DVec2, DVec3};
use std::io::Write;
use std::net::UdpSocket;
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

/// Polls until `enough` of the events is true, for 5 s at most. Stalls are left out: they depend on how
/// busy the machine is.
fn poll_until(source: &mut dyn GazeSource, enough: impl Fn(&[SourceEvent]) -> bool) -> Vec<SourceEvent> {
    let start = Instant::now();
    let mut events = Vec::new();
    loop {
        source.poll(host_now_ns(), &mut events).expect("no error");
        events.retain(|event| !matches!(event, SourceEvent::Stalled { .. } | SourceEvent::Recovered { .. }));
        if enough(&events) {
            return events;
        }
        assert!(start.elapsed() < Duration::from_secs(5), "{events:?}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn is_rejection(event: &SourceEvent, number: u64, part: &str) -> bool {
    matches!(event, SourceEvent::Rejected { count, why } if *count == number && why.contains(part))
}

fn sample(event: &SourceEvent) -> &GazeSample {
    match event {
        SourceEvent::Sample(sample) => sample,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_program_connects_sends_rubbish_goes_and_comes_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("gaze");
    let mut bridge = Bridge::unix(&path, BridgeSettings::default()).expect("a bridge");
    let mut program = UnixStream::connect(&path).expect("connected");
    let before_ns = host_now_ns();
    program.write_all(b"{\"t_ns\": 5, \"dir\": [0, 0, -1]}\nrub").expect("sent");
    let events = poll_until(&mut bridge, |events| events.len() >= 2);
    assert_eq!(events[0], SourceEvent::Reconnected);
    let first = sample(&events[1]);
    assert_eq!((first.device_time_ns, first.combined.direction), (Some(5), Some(DVec3::NEG_Z)));
    assert!((before_ns..=host_now_ns()).contains(&first.received_ns) && first.time_ns <= first.received_ns);

    program.write_all(b"bish\n\xff\n").expect("sent");
    program.write_all(&vec![b'x'; 100_000]).expect("sent");
    program.write_all(b"\n{\"point\": [0.25, 0.5]}").expect("sent");
    drop(program);
    let events = poll_until(&mut bridge, |events| {
        events.iter().any(|event| matches!(event, SourceEvent::Disconnected { .. }))
    });
    let rejected: u64 = events
        .iter()
        .map(|event| if let SourceEvent::Rejected { count, .. } = event { *count } else { 0 })
        .sum();
    assert_eq!(rejected, 3);
    let last: Vec<_> = events.iter().filter(|event| matches!(event, SourceEvent::Sample(_))).collect();
    assert_eq!(last.len(), 1);
    assert_eq!(sample(last[0]).combined.point, Some(DVec2::new(0.25, 0.5)));

    let mut program = UnixStream::connect(&path).expect("connected");
    program.write_all(b"{\"left\": {\"valid\": false}}\n").expect("sent");
    let events = poll_until(&mut bridge, |events| events.len() >= 2);
    assert!(events[0] == SourceEvent::Reconnected && !sample(&events[1]).left.valid);
}

#[test]
fn one_program_is_heard_at_a_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("gaze");
    let mut bridge = Bridge::unix(&path, BridgeSettings::default()).expect("a bridge");
    let send = |program: &mut UnixStream| program.write_all(b"{\"point\": [0, 0]}\n").expect("sent");
    let mut first = UnixStream::connect(&path).expect("connected");
    send(&mut first);
    poll_until(&mut bridge, |events| events.len() == 2);
    let mut second = UnixStream::connect(&path).expect("connected");
    send(&mut second);
    let events = poll_until(&mut bridge, |events| events.len() == 1);
    assert!(is_rejection(&events[0], 1, "another program is heard"), "{events:?}");
    drop(first);
    poll_until(&mut bridge, |events| matches!(events, [SourceEvent::Disconnected { .. }]));
    send(&mut second);
    let events = poll_until(&mut bridge, |events| events.len() == 2);
    assert_eq!(events[0], SourceEvent::Reconnected);
}

#[test]
fn sockets_are_not_taken_from_others_nor_left_behind() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("gaze");
    let open = || Bridge::unix(&path, BridgeSettings::default());
    let bridge = open().expect("a bridge");
    let error = open().expect_err("in use").to_string();
    assert!(error.contains("another program listens"), "{error}");
    drop(bridge);
    assert!(!path.exists());
    // A socket that outlived its program.
    drop(std::os::unix::net::UnixListener::bind(&path).expect("a socket"));
    assert!(path.exists());
    drop(open().expect("a bridge"));
    std::fs::write(&path, "text").expect("a file");
    assert!(open().expect_err("a file").to_string().contains("no socket"));
}

#[test]
fn datagrams_are_samples() {
    let mut bridge = Bridge::udp(0, BridgeSettings::default()).expect("a bridge");
    let port = bridge.port().expect("a port");
    let program = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    let send = |bytes: &[u8]| program.send_to(bytes, ("127.0.0.1", port)).expect("sent");
    send(b"{\"point\": [0.5, 0.5]}\n");
    send(b"rubbish");
    send(&[b'x'; 20_000]);
    let events = poll_until(&mut bridge, |events| events.len() == 3 && is_rejection(&events[2], 2, "longer"));
    assert_eq!(events[0], SourceEvent::Reconnected);
    assert_eq!(sample(&events[1]).combined.point, Some(DVec2::splat(0.5)));
    let taken = Bridge::udp(port, BridgeSettings::default()).expect_err("taken").to_string();
    assert!(taken.contains(&port.to_string()), "{taken}");
}

#[test]
fn the_program_feeds_a_source_from_any_thread() {
    let (feeder, mut source) = host_source(SourceInfo::default(), StampSettings::default());
    let looking = |x: f64| GazeSample {
        combined: EyeSample {
            valid: true,
            direction: Some(DVec3::new(x, 0.0, -1.0)),
            ..EyeSample::default()
        },
        ..GazeSample::default()
    };
    let other = feeder.clone();
    std::thread::spawn(move || {
        assert!(other.push_at(looking(0.0), SampleTime::of_openxr(0), 100));
        assert!(other.push_at(looking(0.1), SampleTime::of_openxr(90), 200));
        assert!(other.push_at(looking(0.2), SampleTime::of_openxr(350), 300));
        assert!(other.push_at(looking(0.3), SampleTime::Device(7), 400));
    })
    .join()
    .expect("pushed");
    let mut events = Vec::new();
    source.poll(350, &mut events).expect("no error");
    let times = |events: &[SourceEvent]| -> Vec<_> {
        events
            .iter()
            .map(sample)
            .map(|sample| (sample.device_time_ns, sample.received_ns, sample.time_ns))
            .collect()
    };
    assert_eq!(times(&events), [(None, 100, 100), (Some(90), 200, 90), (Some(350), 300, 300)]);
    events.clear();
    source.poll(400, &mut events).expect("no error");
    assert_eq!(times(&events), [(Some(7), 400, 400)]);
    events.clear();
    drop(feeder);
    source.poll(401, &mut events).expect("no error");
    source.poll(402, &mut events).expect("no error");
    assert_eq!(events, [SourceEvent::Ended]);
    let (feeder, source) = host_source(SourceInfo::default(), StampSettings::default());
    drop(source);
    assert!(!feeder.push(looking(0.0), SampleTime::Unknown));
}
