//! What is checked on the real device, one step after the other.

use crate::uhid::{
    DESCRIPTOR, GAZE_Y_UM, LEFT_UM, NAME, PRODUCT_ID, RATE_HZ, RIGHT_UM, SCREEN_UM, SERIAL, Tracker,
    VENDOR_ID,
};
use glam::{DVec2, DVec3};
use macula_trackers::Result;
use macula_trackers::bids::Recorder;
use macula_trackers::formats::{self, ReadOptions};
use macula_trackers::hid::{
    ConfigurationStatus, DeviceInfo, HidOptions, HidPort, HidSource, Port, Transport, USAGE_PAGE, discover,
    udev,
};
use macula_trackers::recording::RecordingInfo;
use macula_trackers::sample::GazeSample;
use macula_trackers::source::{GazeSource, SourceEvent};
use macula_trackers::time::host_now_ns;
use std::fs;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// More than any of the steps takes, also under load.
const PATIENCE: Duration = Duration::from_secs(20);

pub fn run() {
    let mut tracker = Tracker::plug_in();
    let device = enumeration();
    descriptor(&device);
    let gate = Arc::new(Gate::default());
    let port = GatedPort { port: HidPort(device.clone()), gate: Arc::clone(&gate) };
    let mut source =
        HidSource::standard(device.name(), Box::new(port), HidOptions::default()).expect("a source");
    features(&source, &tracker);
    let samples = full_rate(&mut source);
    values(&samples);
    recording(&source, &samples);
    rubbish(&mut source, &mut tracker);
    overflow(&mut source, &gate);
    replug(&mut source, tracker);
}

fn told(step: &str, figures: &str) {
    println!("hid-vm: {step}: {figures}");
}

/// The number of a sample, which is its time on the tracker's clock in ms.
fn number(sample: &GazeSample) -> i64 {
    let point = sample.combined.point.expect("a point");
    let number = (point.x * f64::from(SCREEN_UM[0])).round() as i64;
    assert_eq!(sample.device_time_ns, Some(number * 1_000_000));
    number
}

fn enumeration() -> DeviceInfo {
    let start = Instant::now();
    loop {
        let found = discover().expect("a list of devices");
        if let [device] = found.as_slice() {
            told("enumeration", &format!("{} after {:?}", device.path, start.elapsed()));
            assert_eq!((device.vendor_id, device.product_id), (VENDOR_ID, PRODUCT_ID));
            assert_eq!((device.usage_page, device.usage), (USAGE_PAGE, 1));
            assert_eq!((device.name().as_str(), device.serial.as_deref()), (NAME, Some(SERIAL)));
            assert!(device.accessible, "{:?}", device.problem);
            udev_rule(device);
            return device.clone();
        }
        assert!(start.elapsed() < PATIENCE, "{found:?}");
        thread::sleep(Duration::from_millis(5));
    }
}

/// The device's parent has the name that the rule for udev asks for.
fn udev_rule(device: &DeviceInfo) {
    let file = device.path.trim_start_matches("/dev/");
    let parent = fs::read_link(format!("/sys/class/hidraw/{file}/device")).expect("a parent");
    let name = parent.file_name().and_then(|name| name.to_str()).expect("a name");
    let rule = udev::rule(device.vendor_id, device.product_id);
    let pattern = rule.split("KERNELS==\"*").nth(1).and_then(|rest| rest.split('*').next()).expect("a name");
    assert!(name.contains(pattern), "{name} is none of {rule}");
}

fn descriptor(device: &DeviceInfo) {
    let mut transport = device.open().expect("an open device");
    assert_eq!(transport.descriptor().expect("a descriptor"), DESCRIPTOR);
    told("descriptor", &format!("{} bytes", DESCRIPTOR.len()));
}

fn features(source: &HidSource, tracker: &Tracker) {
    let about = source.about();
    assert_eq!(about.notes, [""; 0]);
    let capabilities = about.capabilities.expect("capabilities");
    assert_eq!(capabilities.quality, Some(1));
    assert!(capabilities.optimum_distance_m.is_some_and(|distance| (distance - 0.65).abs() < 1e-12));
    let configuration = about.configuration.expect("a configuration");
    assert!(configuration.screen_m().is_some_and(|size| size.abs_diff_eq(DVec2::new(0.527, 0.296), 1e-12)));
    let edid =
        [configuration.display_manufacturer, configuration.display_product, configuration.display_serial];
    assert_eq!(edid, [Some(0x104d), Some(0x40d0), Some(0x3033_354c)]);
    let status = about.status.expect("a status");
    assert_eq!(status.configuration, Some(ConfigurationStatus::Ready));
    assert_eq!(source.info().rate_hz, Some(f64::from(RATE_HZ)));
    assert_eq!(source.info().device_clock, "tracker (1 us, 64 bit)");
    assert_eq!(tracker.mode(), 7);
    told("feature reports", "read, and the mode requested");
}

/// Polls as often as a renderer does; returns all events.
fn poll_until(source: &mut HidSource, done: impl Fn(&[SourceEvent]) -> bool) -> Vec<SourceEvent> {
    let start = Instant::now();
    let mut events = Vec::new();
    while !done(&events) {
        source.poll(host_now_ns(), &mut events).expect("a running source");
        assert!(start.elapsed() < PATIENCE, "{} events: {:?}", events.len(), events.last());
        thread::sleep(Duration::from_millis(11));
    }
    events
}

fn samples(events: &[SourceEvent]) -> Vec<GazeSample> {
    let sample =
        |event: &SourceEvent| if let SourceEvent::Sample(sample) = event { Some(*sample) } else { None };
    events.iter().filter_map(sample).collect()
}

/// Samples that were told to be lost, having checked that just these are missing.
fn lost(events: &[SourceEvent]) -> i64 {
    let (mut before, mut lost, mut all) = (None, 0, 0);
    for event in events {
        match event {
            SourceEvent::Lost { samples } => lost += *samples as i64,
            SourceEvent::Sample(sample) => {
                let number = number(sample);
                let missing = before.map_or(lost, |before| number - before - 1);
                assert_eq!(lost, missing, "before sample {number}");
                (before, all, lost) = (Some(number), all + lost, 0);
            }
            _ => {}
        }
    }
    all + lost
}

/// Two seconds without a loss. A busy host may hold the emulated machine up for longer than the kernel's
/// ring lasts, so there are three tries; a loss must be told exactly in each.
fn full_rate(source: &mut HidSource) -> Vec<GazeSample> {
    const SAMPLES: usize = 2 * RATE_HZ as usize;
    let mut tries = 0;
    let (events, elapsed) = loop {
        let start = Instant::now();
        let events = poll_until(source, |events| samples(events).len() >= SAMPLES);
        let lost = lost(&events);
        tries += 1;
        if lost == 0 {
            break (events, start.elapsed());
        }
        told("1 kHz for 2 s", &format!("{lost} lost in try {tries}"));
        assert!(tries < 3, "samples were lost in every try");
    };
    let samples = samples(&events);
    assert!(elapsed < Duration::from_secs(4), "{elapsed:?} for 2 s");
    let late_ns = samples.iter().map(|sample| sample.received_ns - sample.time_ns).max().unwrap_or_default();
    told(
        "1 kHz for 2 s",
        &format!("{} samples in {elapsed:?}, none lost, {late_ns} ns late at most", samples.len()),
    );
    samples
}

fn values(samples: &[GazeSample]) {
    let to_metres = |um: [i32; 3]| DVec3::new(um[0].into(), (-um[1]).into(), um[2].into()) * 1e-6;
    for sample in samples {
        assert!(sample.time_ns <= sample.received_ns);
        let left_m = sample.left.origin_m.expect("a left eye");
        assert!(left_m.abs_diff_eq(to_metres(LEFT_UM), 1e-12));
        let direction = sample.right.direction.expect("a direction");
        let gaze_m = to_metres([number(sample) as i32, GAZE_Y_UM, 0]);
        assert!(direction.abs_diff_eq((gaze_m - to_metres(RIGHT_UM)).normalize(), 1e-9));
    }
    // The mapping may hold two samples at one time while it still learns, but never turns back.
    assert!(samples.windows(2).all(|pair| pair[0].time_ns <= pair[1].time_ns), "time goes on");
}

/// To a file and back, bit for bit.
fn recording(source: &HidSource, samples: &[GazeSample]) {
    let info = RecordingInfo { device: source.info().name.clone(), ..RecordingInfo::default() };
    let mut recorder =
        Recorder::create(&std::env::temp_dir().join("tracker"), &info, &[]).expect("a recording");
    for sample in samples {
        recorder.push(sample).expect("a sample on the disk");
    }
    let file = recorder.finish().expect("the end of the recording");
    let read = formats::read(&file, &ReadOptions::default()).expect("a recording that reads");
    assert_eq!(read.info.device, NAME);
    assert!(read.samples().eq(samples.iter().copied()), "every bit of every sample");
    told("recording", &format!("{} samples written and read", read.len()));
}

fn rubbish(source: &mut HidSource, tracker: &mut Tracker) {
    // The kernel itself withholds reports that are too short or of an unknown id.
    tracker.send(&[0x10; 66]);
    let rejected = |event: &SourceEvent| matches!(event, SourceEvent::Rejected { .. });
    let events = poll_until(source, |events| events.iter().any(rejected));
    let why = "the report has 66 bytes, not 65".to_owned();
    assert!(events.contains(&SourceEvent::Rejected { count: 1, why }), "{events:?}");
    // A broken report is not taken for a lost sample: what is told as lost is missing.
    lost(&events);
    told("a broken report", "rejected");
}

/// The reader is held up for 200 ms: the kernel keeps 64 reports at most, and drops what comes after.
fn overflow(source: &mut HidSource, gate: &Gate) {
    let before = poll_until(source, |events| !samples(events).is_empty());
    gate.close();
    thread::sleep(Duration::from_millis(200));
    gate.open();
    let mut events = before;
    events.extend(poll_until(source, |events| samples(events).len() >= 500));
    let lost = lost(&events);
    assert!(lost >= 200 - 64 - 10, "{lost} lost");
    told("overflow", &format!("{lost} samples told as lost, just those that are missing"));
}

fn replug(source: &mut HidSource, tracker: Tracker) {
    tracker.unplug();
    let gone = |event: &SourceEvent| matches!(event, SourceEvent::Disconnected { .. });
    poll_until(source, |events| events.iter().any(gone));
    assert_eq!(discover().expect("a list of devices"), []);
    let start = Instant::now();
    let tracker = Tracker::plug_in();
    let events = poll_until(source, |events| samples(events).len() >= 100);
    told("replug", &format!("100 samples after {:?}", start.elapsed()));
    assert_eq!(events.first(), Some(&SourceEvent::Reconnected));
    assert_eq!(tracker.mode(), 7);
    // Its clock began anew; that is no loss.
    assert_eq!(lost(&events), 0);
    tracker.unplug();
}

/// Holds the reader up, as a busy machine would.
#[derive(Debug, Default)]
struct Gate {
    closed: AtomicBool,
    waiting: AtomicBool,
}

impl Gate {
    /// Returns when the reader waits.
    fn close(&self) {
        self.closed.store(true, Ordering::Release);
        while !self.waiting.load(Ordering::Acquire) {
            thread::sleep(Duration::from_millis(1));
        }
    }

    fn open(&self) {
        self.closed.store(false, Ordering::Release);
    }

    fn pass(&self) {
        while self.closed.load(Ordering::Acquire) {
            self.waiting.store(true, Ordering::Release);
            thread::sleep(Duration::from_millis(1));
        }
        self.waiting.store(false, Ordering::Release);
    }
}

#[derive(Debug)]
struct GatedPort {
    port: HidPort,
    gate: Arc<Gate>,
}

#[derive(Debug)]
struct Gated {
    transport: Box<dyn Transport>,
    gate: Arc<Gate>,
}

impl Port for GatedPort {
    fn open(&mut self) -> Result<Box<dyn Transport>> {
        let transport = self.port.open()?;
        Ok(Box::new(Gated { transport, gate: Arc::clone(&self.gate) }))
    }
}

impl Transport for Gated {
    fn name(&self) -> &str {
        self.transport.name()
    }

    fn descriptor(&mut self) -> Result<Vec<u8>> {
        self.transport.descriptor()
    }

    fn read(&mut self, report: &mut [u8], timeout: Duration) -> Result<usize> {
        self.gate.pass();
        self.transport.read(report, timeout)
    }

    fn get_feature(&mut self, report: &mut [u8]) -> Result<usize> {
        self.transport.get_feature(report)
    }

    fn set_feature(&mut self, report: &[u8]) -> Result<()> {
        self.transport.set_feature(report)
    }
}
