//! A tracker made by `/dev/uhid` (linux/uhid.h), with the reports of the usage page's reference.

use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

pub const VENDOR_ID: u16 = 0x1209;
pub const PRODUCT_ID: u16 = 0xee01;
pub const SERIAL: &str = "SN-0001";
pub const NAME: &str = "Virtual Eye Tracker";
pub const RATE_HZ: u16 = 1000;
/// Of the display, um.
pub const SCREEN_UM: [u32; 2] = [527_000, 296_000];

const BUS_USB: u16 = 3;
const DESTROY: u32 = 1;
const GET_REPORT: u32 = 9;
const GET_REPORT_REPLY: u32 = 10;
const CREATE2: u32 = 11;
const INPUT2: u32 = 12;
const SET_REPORT: u32 = 13;
const SET_REPORT_REPLY: u32 = 14;
/// `sizeof(struct uhid_event)`, rounded up.
const EVENT_BYTES: usize = 4380;
const EIO: u16 = 5;

/// Report 0x10: clock, gaze, both eyes and six numbers without a meaning; features 0x11 capabilities,
/// 0x12 configuration, 0x13 status (also an input), 0x14 control. Positions and settings are constants.
#[rustfmt::skip]
pub const DESCRIPTOR: &[u8] = &[
    0x05, 0x12, 0x09, 0x01, 0xa1, 0x01, // page, Eye Tracker
    0x09, 0x10, 0xa1, 0x02, 0x85, 0x10, // Tracking Data
    0x15, 0x00, 0x26, 0xff, 0x00, 0x66, 0x01, 0x10, 0x55, 0x0a, // us
    0x75, 0x08, 0x95, 0x08, 0x09, 0x20, 0x81, 0x02, // Sensor Timestamp, 8 x 8 bits
    0x17, 0x80, 0x7b, 0xe1, 0xff, 0x27, 0x80, 0x84, 0x1e, 0x00, 0x65, 0x11, 0x55, 0x0c, // +-2 m in um
    0x75, 0x20,
    0x09, 0x24, 0xa1, 0x00, 0x95, 0x02, 0x09, 0x21, 0x09, 0x22, 0x81, 0x03, 0xc0, // Gaze Point
    0x09, 0x25, 0xa1, 0x00, 0x95, 0x03, 0x09, 0x21, 0x09, 0x22, 0x09, 0x23, 0x81, 0x03, 0xc0, // left
    0x09, 0x26, 0xa1, 0x00, 0x95, 0x03, 0x09, 0x21, 0x09, 0x22, 0x09, 0x23, 0x81, 0x03, 0xc0, // right
    0x95, 0x06, 0x81, 0x03, 0xc0, // six without usages
    0x09, 0x11, 0xa1, 0x02, 0x85, 0x11, // Capabilities
    0x15, 0x00, 0x25, 0x01, 0x65, 0x00, 0x55, 0x00, 0x75, 0x08, 0x95, 0x01, 0x0a, 0x00, 0x01, 0xb1, 0x03,
    0x27, 0x80, 0x84, 0x1e, 0x00, 0x65, 0x11, 0x55, 0x0c, 0x75, 0x20, 0x95, 0x05,
    0x0a, 0x01, 0x01, 0x0a, 0x02, 0x01, 0x0a, 0x03, 0x01, 0x0a, 0x04, 0x01, 0x0a, 0x05, 0x01, 0xb1, 0x03, 0xc0,
    0x09, 0x12, 0xa1, 0x02, 0x85, 0x12, // Configuration: four of the display's EDID, its size
    0x27, 0xff, 0xff, 0x00, 0x00, 0x65, 0x00, 0x55, 0x00, 0x75, 0x10, 0x95, 0x02,
    0x0a, 0x00, 0x02, 0x0a, 0x01, 0x02, 0xb1, 0x03,
    0x27, 0xff, 0xff, 0xff, 0x7f, 0x75, 0x20, 0x95, 0x01, 0x0a, 0x02, 0x02, 0xb1, 0x03,
    0x27, 0xff, 0xff, 0x00, 0x00, 0x75, 0x10, 0x0a, 0x03, 0x02, 0xb1, 0x03,
    0x27, 0xff, 0xff, 0xff, 0x7f, 0x65, 0x11, 0x55, 0x0c, 0x75, 0x20, 0x95, 0x02,
    0x0a, 0x04, 0x02, 0x0a, 0x05, 0x02, 0xb1, 0x03, 0xc0,
    0x09, 0x13, 0xa1, 0x02, 0x85, 0x13, 0x65, 0x00, 0x55, 0x00, 0x95, 0x01, // Status
    0x75, 0x08, 0x25, 0x04, 0x0a, 0x01, 0x03, 0xb1, 0x02,
    0x75, 0x10, 0x27, 0xff, 0xff, 0x00, 0x00, 0x66, 0x01, 0xf0, 0x0a, 0x00, 0x03, 0xb1, 0x02, 0xc0,
    0x09, 0x13, 0xa1, 0x02, 0x85, 0x13, 0x65, 0x00, 0x75, 0x08, 0x25, 0x04, 0x0a, 0x01, 0x03, 0x81, 0x02,
    0x75, 0x10, 0x27, 0xff, 0xff, 0x00, 0x00, 0x66, 0x01, 0xf0, 0x0a, 0x00, 0x03, 0x81, 0x02, 0xc0,
    0x09, 0x14, 0xa1, 0x02, 0x85, 0x14, 0x65, 0x00, 0x75, 0x08, 0x25, 0x07, 0x0a, 0x00, 0x04, 0xb1, 0x02, 0xc0,
    0xc0,
];

/// Where the eyes are, um.
pub const LEFT_UM: [i32; 3] = [230_000, 150_000, 600_000];
pub const RIGHT_UM: [i32; 3] = [293_000, 150_000, 600_000];
/// Height of every gaze point, um. Its X in um is the number of the sample, which is its time in ms.
pub const GAZE_Y_UM: i32 = 100_000;

/// Reports sent at once where the firmware has fallen behind: far fewer than the kernel keeps for a
/// reader, so that a machine under load delays samples but loses none.
const BURST: u64 = 8;

/// A tracker that is plugged in. A thread of its own is its firmware: it answers feature reports, and takes
/// a sample each millisecond once it has been asked for some.
pub struct Tracker {
    file: File,
    firmware: Arc<Firmware>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Firmware {
    unplugged: AtomicBool,
    mode: AtomicU8,
    trouble: Mutex<Vec<String>>,
}

impl Tracker {
    /// Plugs it in.
    pub fn plug_in() -> Self {
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .custom_flags(rustix::fs::OFlags::NONBLOCK.bits() as i32)
            .open("/dev/uhid")
            .expect("/dev/uhid");
        let mut event = vec![0; 4 + 128 + 64 + 64];
        event[..4].copy_from_slice(&CREATE2.to_le_bytes());
        event[4..4 + NAME.len()].copy_from_slice(NAME.as_bytes());
        event[196..196 + SERIAL.len()].copy_from_slice(SERIAL.as_bytes());
        event.extend((DESCRIPTOR.len() as u16).to_le_bytes());
        event.extend(BUS_USB.to_le_bytes());
        // Vendor, product, version, country.
        for number in [VENDOR_ID.into(), PRODUCT_ID.into(), 0x100u32, 0] {
            event.extend(number.to_le_bytes());
        }
        event.extend(DESCRIPTOR);
        file.write_all(&event).expect("a new device");
        let firmware = Arc::new(Firmware::default());
        let events = file.try_clone().expect("a second handle");
        let shared = Arc::clone(&firmware);
        let thread = std::thread::spawn(move || shared.run(events));
        Self { file, firmware, thread: Some(thread) }
    }

    /// The mode that was asked for last.
    pub fn mode(&self) -> u8 {
        self.firmware.mode.load(Ordering::Acquire)
    }

    /// Sends anything as a report.
    pub fn send(&mut self, report: &[u8]) {
        self.file.write_all(&input(report)).expect("a report");
    }

    /// Pulls the plug.
    pub fn unplug(mut self) {
        self.firmware.unplugged.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.join().expect("the firmware's thread");
        }
        self.file.write_all(&DESTROY.to_le_bytes()).expect("the end of the device");
        let trouble = self.firmware.trouble.lock().unwrap_or_else(PoisonError::into_inner);
        assert!(trouble.is_empty(), "{trouble:?}");
    }
}

fn input(report: &[u8]) -> Vec<u8> {
    let mut event = INPUT2.to_le_bytes().to_vec();
    event.extend((report.len() as u16).to_le_bytes());
    event.extend(report);
    event
}

/// The report of the sample taken at this time.
fn sample(time_ms: u64) -> Vec<u8> {
    let mut report = vec![0x10];
    report.extend((time_ms * 1000).to_le_bytes());
    let gaze_um = [time_ms as i32, GAZE_Y_UM];
    let numbers = gaze_um.iter().chain(&LEFT_UM).chain(&RIGHT_UM).chain(&[i32::MAX; 6]);
    report.extend(numbers.flat_map(|number| number.to_le_bytes()));
    assert_eq!(report.len(), 65);
    report
}

impl Firmware {
    fn run(&self, mut file: File) {
        let mut event = vec![0; EVENT_BYTES];
        let mut clock: Option<Instant> = None;
        let mut taken = 0;
        while !self.unplugged.load(Ordering::Acquire) {
            match file.read(&mut event) {
                Ok(length) => {
                    if let Some(answer) = self.answer(&event[..length]) {
                        file.write_all(&answer).expect("an answer");
                    }
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(error) => panic!("reading /dev/uhid: {error}"),
            }
            if self.mode.load(Ordering::Acquire) != 0 {
                let now_ms = clock.get_or_insert_with(Instant::now).elapsed().as_millis() as u64;
                for _ in 0..now_ms.saturating_sub(taken).min(BURST) {
                    taken += 1;
                    file.write_all(&input(&sample(taken))).expect("a sample");
                }
            }
            std::thread::sleep(Duration::from_micros(200));
        }
    }

    /// Kind, request number, report id, report kind, and for a set the length and the bytes.
    fn answer(&self, event: &[u8]) -> Option<Vec<u8>> {
        let kind = u32::from_le_bytes(event[..4].try_into().ok()?);
        let answer = match kind {
            GET_REPORT => GET_REPORT_REPLY,
            SET_REPORT => SET_REPORT_REPLY,
            _ => return None,
        };
        let id = event[8];
        let mut bytes = answer.to_le_bytes().to_vec();
        bytes.extend_from_slice(&event[4..8]);
        match (kind, feature(id)) {
            (GET_REPORT, Some(report)) => {
                bytes.extend([0, 0]);
                bytes.extend((report.len() as u16).to_le_bytes());
                bytes.extend(report);
            }
            (SET_REPORT, _) if event[10..13] == [2, 0, 0x14] => {
                self.mode.store(event[13], Ordering::Release);
                bytes.extend([0, 0]);
            }
            _ => {
                let trouble = format!("report {id:#04x}: {:x?}", &event[..16]);
                self.trouble.lock().unwrap_or_else(PoisonError::into_inner).push(trouble);
                bytes.extend(EIO.to_le_bytes());
                bytes.extend([0, 0]);
            }
        }
        Some(bytes)
    }
}

fn feature(id: u8) -> Option<Vec<u8>> {
    let mut report = vec![id];
    match id {
        0x11 => {
            report.push(1);
            report.extend(
                [500_000u32, 650_000, 900_000, 600_000, 350_000].iter().flat_map(|um| um.to_le_bytes()),
            );
        }
        0x12 => {
            report.extend([0x4d, 0x10, 0xd0, 0x40, 0x4c, 0x35, 0x33, 0x30, 0x1e, 0x21]);
            report.extend(SCREEN_UM.iter().flat_map(|um| um.to_le_bytes()));
        }
        0x13 => {
            report.push(1);
            report.extend(RATE_HZ.to_le_bytes());
        }
        _ => return None,
    }
    Some(report)
}
