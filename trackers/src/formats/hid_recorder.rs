//! Reports of a HID eye tracker as `hid-recorder` writes them (hid-tools and the hid-recorder program):
//! text lines `N:` with the device's name, `R:` with the report descriptor and `E:` with a report, each
//! as `length bytes...` in hexadecimal, `E:` after the time of arrival in seconds. `D:` says of which
//! device what follows is; read is the first that is an eye tracker.
//!
//! The time of arrival is that of the host, and the device's own stamps are brought onto it as those of a
//! device at hand are.

use super::rows::{Rejects, lines};
use super::{Format, Input, ReadOptions};
use crate::error::{Error, Result};
use crate::hid::{Decoded, Layout, Role};
use crate::recording::{Recording, RecordingInfo, Space};
use crate::time::{ClockMapper, Unwrapper};

/// The format.
pub const FORMAT: Format = Format { name: "hid-recorder", matches, read };

/// What one device's lines have told.
#[derive(Default)]
struct Device {
    name: String,
    /// Which `D:` it is.
    number: u64,
    layout: Option<Layout>,
    unwrapper: Option<Unwrapper>,
    clock: ClockMapper,
}

fn matches(_: &Input, head: &str) -> bool {
    head.lines().any(|line| line.strip_prefix("R:").and_then(bytes_of).is_some_and(|bytes| !bytes.is_empty()))
}

/// Bytes told as `length bytes...`, the length in decimal; `None` where they are not as many.
fn bytes_of(text: &str) -> Option<Vec<u8>> {
    let mut words = text.split_ascii_whitespace();
    let length: usize = words.next()?.parse().ok()?;
    let bytes: Option<Vec<u8>> = words.map(|word| u8::from_str_radix(word, 16).ok()).collect();
    bytes.filter(|bytes| bytes.len() == length)
}

/// A time told as `seconds.microseconds`, exactly.
fn time_ns_of(text: &str) -> Option<i64> {
    let (seconds, micros) = text.split_once('.')?;
    let six_digits = micros.len() == 6 && micros.bytes().all(|byte| byte.is_ascii_digit());
    let micros: i64 = six_digits.then(|| micros.parse().ok())??;
    seconds.parse::<i64>().ok()?.checked_mul(1_000_000_000)?.checked_add(micros.checked_mul(1000)?)
}

impl Device {
    fn learn(&mut self, layout: Layout) {
        self.unwrapper = layout.timestamp().and_then(|(bits, tick_ns)| {
            // The unwrapper counts whole ns; a tick that is none is not unwrapped.
            let whole = tick_ns >= 1.0 && (tick_ns - tick_ns.round()).abs() < 1e-6 * tick_ns;
            whole.then(|| Unwrapper::new(bits, false, tick_ns.round() as i64))
        });
        self.layout = Some(layout);
    }

    fn device_ns(&mut self, decoded: &Decoded, received_ns: i64) -> Option<i64> {
        match (&mut self.unwrapper, decoded.raw(Role::Timestamp)) {
            (Some(unwrapper), Some(raw)) => Some(unwrapper.unwrap(raw as u64, Some(received_ns)).time_ns),
            _ => decoded.device_time_ns(),
        }
    }

    /// Takes the rest of an `E:` line; what is wrong with it otherwise.
    fn event(&mut self, text: &str, options: &ReadOptions, recording: &mut Recording) -> Result<(), String> {
        let layout = self.layout.as_ref().ok_or("a report before the report descriptor")?;
        let (time, report) = text.trim_start().split_once(' ').ok_or("no time")?;
        let received_ns = time_ns_of(time).ok_or("a time that is not seconds.microseconds")?;
        let report = bytes_of(report).ok_or("its length is not that of its bytes")?;
        let decoded = layout.decode(&report).map_err(|reject| reject.to_string())?;
        if let Some(rate_hz) = decoded.status().and_then(|status| status.sampling_hz) {
            recording.info.nominal_rate_hz = Some(rate_hz);
        }
        if !decoded.is_tracking() {
            return Ok(());
        }
        let mut sample = decoded.to_sample(options.screen.map(|screen| screen.size_m), received_ns);
        sample.device_time_ns = self.device_ns(&decoded, received_ns);
        if let Some(device_ns) = sample.device_time_ns {
            sample.time_ns = self.clock.observe(device_ns, received_ns).time_ns;
        }
        recording.push(&sample);
        Ok(())
    }
}

fn read(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let mut recording = Recording::new(RecordingInfo {
        space: Space::Display,
        screen: options.screen,
        device_clock: "timestamp of the reports".into(),
        ..RecordingInfo::default()
    });
    if options.screen.is_none() {
        let note =
            "the size of the display is not known, so gaze is told as a direction only; give the screen";
        recording.info.notes.push(note.into());
    }
    let (mut device, mut number) = (Device::default(), 0);
    let (mut rejects, mut descriptors, mut others) = (Rejects::default(), Rejects::default(), 0);
    for (line_number, line) in lines(input.text()) {
        let place = format_args!("line {line_number}");
        let Some((kind, text)) = line.split_once(':') else { continue };
        let ours = device.layout.is_none() || device.number == number;
        match kind {
            "D" => number = text.trim().parse().unwrap_or(0),
            "N" if ours => text.trim().clone_into(&mut device.name),
            "R" if device.layout.is_none() => {
                let layout = bytes_of(text).ok_or_else(|| "its length is not that of its bytes".to_owned());
                match layout.and_then(|bytes| Layout::parse(&bytes).map_err(|error| error.to_string())) {
                    Ok(layout) => {
                        device.number = number;
                        device.learn(layout);
                    }
                    Err(what) => descriptors.add(place, what),
                }
            }
            "E" if ours => {
                if let Err(what) = device.event(text, options, &mut recording) {
                    rejects.add(place, what);
                }
            }
            "E" => others += 1,
            _ => {}
        }
    }
    descriptors.report(&mut recording, "report descriptors are of no eye tracker or broken");
    let Some(layout) = device.layout else {
        let whys: Vec<_> = recording.info.skipped.iter().map(|skipped| skipped.why.as_str()).collect();
        let cause = format!("has no report descriptor of an eye tracker: {}", whys.join("; "));
        return Err(Error::file(&input.path, cause));
    };
    recording.info.device = device.name;
    recording.info.notes.extend(layout.notes);
    rejects.report(&mut recording, "reports were rejected");
    recording.skip_any(others, "reports are of another device");
    Ok(recording)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::{read_input, testing::input};
    use crate::recording::Screen;
    use crate::testing::shared;
    use glam::{DVec2, DVec3};

    /// Report 1: a timestamp of 16 bits in ms, gaze X and Y of 16 bits in mm. Written by hand from the
    /// usage table: page 0x12, eye tracker 0x01, tracking data 0x10, timestamp 0x20, gaze point 0x24.
    const DESCRIPTOR: &str = "05 12 09 01 a1 01 09 10 a1 02 85 01 15 00 27 ff ff 00 00 75 10 95 01 66 01 10 \
        55 0d 09 20 81 02 16 00 80 26 ff 7f 65 11 55 0f 09 24 a1 00 95 02 09 21 09 22 81 02 c0 c0 c0";

    fn recording_of(events: &str) -> String {
        let length = DESCRIPTOR.split_ascii_whitespace().count();
        format!("# a comment\nN: Test tracker\nI: 3 1 2\nR: {length} {DESCRIPTOR}\n{events}")
    }

    fn screen() -> ReadOptions {
        let screen = Screen { size_px: DVec2::ONE, size_m: DVec2::new(0.4, 0.2), distance_m: 0.6 };
        ReadOptions { screen: Some(screen), ..ReadOptions::default() }
    }

    #[test]
    fn reports_become_samples_on_the_arrival_clock() {
        // 65 530 ms and, after the wrap, 4 ms: 10 ms later.
        let text = recording_of(
            "E: 000001.000000 7 01 fa ff 64 00 32 00\nE: 000001.010000 7 01 04 00 c8 00 64 00\n\
             X: unknown\nE: 000001.020000 7 01 04 00 c8 00 64\nE: 1.02 7 01 04 00 c8 00 64 00\n\
             E: 000001.030000 2 07 04\n\nE:\n",
        );
        let options = ReadOptions { time_unit_s: Some(1e-3), ..screen() };
        let recording = read_input(&input(text), &options).expect("read");
        assert!(recording.info.notes.iter().any(|note| note.contains("fixes the unit of time")));
        assert_eq!((recording.info.format, recording.info.device.as_str()), ("hid-recorder", "Test tracker"));
        assert_eq!(recording.len(), 2);
        let [first, second] = [0, 1].map(|index| recording.get(index).expect("there"));
        assert_eq!((first.received_ns, second.received_ns), (1_000_000_000, 1_010_000_000));
        assert_eq!(first.device_time_ns, Some(65_530_000_000));
        assert_eq!(second.device_time_ns, Some(65_540_000_000));
        assert_eq!((first.time_ns, second.time_ns), (1_000_000_000, 1_010_000_000));
        // 100 of 400 mm and 50 of 200 mm.
        assert!(first.combined.point.is_some_and(|point| point.abs_diff_eq(DVec2::splat(0.25), 1e-12)));
        assert!(first.combined.valid);
        let skipped = &recording.info.skipped;
        assert_eq!((skipped.len(), skipped[0].rows), (1, 4));
        assert!(skipped[0].why.contains("line 8"), "{}", skipped[0].why);
    }

    #[test]
    fn other_devices_are_left_out() {
        let mouse = "D: 3\nN: Mouse\nR: 2 05 01\nE: 000000.000000 1 00\n";
        let text = format!(
            "{mouse}D: 4\n{}D: 3\nE: 000001.000000 1 00\n",
            recording_of("E: 000001.000000 7 01 00 00 00 00 00 00\n")
        );
        let recording = read_input(&input(text), &screen()).expect("read");
        assert_eq!((recording.len(), recording.info.device.as_str()), (1, "Test tracker"));
        let rows: Vec<_> = recording.info.skipped.iter().map(|skipped| skipped.rows).collect();
        assert_eq!(rows, [1, 1, 1], "{:?}", recording.info.skipped);
        let error = read_input(&input(mouse), &screen()).expect_err("no tracker").to_string();
        assert!(error.contains("no report descriptor of an eye tracker"), "{error}");
    }

    #[test]
    fn times_and_lengths_that_lie_are_refused() {
        assert_eq!(time_ns_of("000012.000345"), Some(12_000_345_000));
        for bad in ["12", "12.5", "9223372036854775807.000000", "9223372037.000000", "a.000000", "1.+00001"] {
            assert_eq!(time_ns_of(bad), None, "{bad}");
        }
        for bad in ["", "2 00", "1 00 00", "1 100", "-1", "99999999999999999999 00"] {
            assert_eq!(bytes_of(bad), None, "{bad}");
        }
        assert_eq!(bytes_of(" 2 0f A0 "), Some(vec![0x0f, 0xa0]));
    }

    /// The expected values are decoded by hand from the bytes of the first report: time 0x0f4240 us, gaze
    /// 0x0249f0 and 0x015f90 um, left eye 0xffff84f4 um.
    #[test]
    fn the_real_descriptor_with_reports_reads() {
        let Some(path) = shared("data/hid/gazehid_synthetic.hid") else { return };
        let recording = crate::formats::read(&path, &screen()).expect("read");
        assert_eq!((recording.len(), recording.info.nominal_rate_hz), (5, Some(100.0)));
        let first = recording.get(0).expect("there");
        assert_eq!((first.device_time_ns, first.received_ns), (Some(1_000_000_000), 0));
        let point = DVec2::new(0.15 / 0.4, 0.09 / 0.2);
        assert!(first.combined.point.is_some_and(|told| told.abs_diff_eq(point, 1e-9)));
        assert!(first.left.origin_m.is_some_and(|at| at.abs_diff_eq(DVec3::new(-0.0315, 0.0, 0.6), 1e-3)));
        assert_eq!(recording.times_ns(), [0, 10_000_000, 20_000_000, 30_000_000, 40_000_000]);
        assert!(recording.info.skipped.is_empty(), "{:?}", recording.info.skipped);
    }
}
