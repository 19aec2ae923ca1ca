//! Where gaze comes from, as arguments that commands share.

use super::input::ReadArgs;
use super::session::{Clock, Session};
use crate::failure::Failure;
use clap::Args;
use macula_trackers::bridge::{Bridge, BridgeSettings};
use macula_trackers::formats;
use macula_trackers::hid::{DeviceInfo, HidOptions, HidSource, discover};
use macula_trackers::recording::{RecordingInfo, Space};
use macula_trackers::replay::{Replay, ReplaySettings};
use macula_trackers::source::GazeSource;
use macula_trackers::stamp::StampSettings;
use macula_trackers::synthetic::{SyntheticEye, SyntheticSettings};
use macula_trackers::time::host_now_ns;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A source of gaze; without any of these, the first HID tracker that can be opened.
#[derive(Args, Clone, Debug)]
pub struct SourceArgs {
    /// A HID tracker by its ids or its file, as `macula gaze devices` lists them
    #[arg(long, value_name = "VID:PID|PATH", group = "source")]
    device: Option<String>,
    /// Listen for JSON lines of another program: unix:PATH is a socket, udp:PORT a port of the loopback
    /// address (0 takes a free one)
    #[arg(long, value_name = "unix:PATH|udp:PORT", group = "source", value_parser = parse_bridge)]
    bridge: Option<BridgeAddress>,
    /// Samples per second that the bridge's sender promises: gaps in its time are counted as losses
    #[arg(long, value_name = "HZ", requires = "bridge", conflicts_with_all = ["device", "replay", "synth"], value_parser = parse_rate)]
    rate: Option<f64>,
    /// Replay a recording of any known format
    #[arg(long, value_name = "FILE", group = "source")]
    replay: Option<PathBuf>,
    /// Recorded seconds in one second of the replay
    #[arg(long, value_name = "S", requires = "replay", conflicts_with_all = ["device", "bridge", "synth"])]
    speed: Option<f64>,
    /// A synthetic eye: target-task, free-viewing, reading, pursuit or vr-exploration
    #[arg(long, value_name = "PRESET", group = "source")]
    synth: Option<String>,
    /// The synthetic eye's seed
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    read: ReadArgs,
}

/// Where a bridge listens.
#[derive(Clone, Debug, PartialEq, Eq)]
enum BridgeAddress {
    Unix(PathBuf),
    Udp(u16),
}

fn parse_bridge(text: &str) -> Result<BridgeAddress, String> {
    let form = || "expected unix:PATH or udp:PORT, as in udp:5005".to_owned();
    match text.split_once(':').ok_or_else(form)? {
        ("unix", path) if !path.is_empty() => Ok(BridgeAddress::Unix(path.into())),
        ("udp", port) => port.parse().map(BridgeAddress::Udp).map_err(|_| form()),
        _ => Err(form()),
    }
}

fn parse_rate(text: &str) -> Result<f64, String> {
    let rate_hz = text.parse::<f64>().ok().filter(|rate| (1.0..=1e5).contains(rate));
    rate_hz.ok_or_else(|| "expected Hz, 1 to 100000".into())
}

impl SourceArgs {
    /// Opens it. `stepped` runs recordings and synthetic eyes by a clock of their own, as fast as they
    /// are taken.
    ///
    /// # Errors
    /// A source that cannot be opened, or one that cannot be stepped.
    pub fn open(&self, stepped: bool) -> Result<Session, Failure> {
        if let Some(path) = &self.replay {
            return self.open_replay(path, stepped);
        }
        if let Some(preset) = &self.synth {
            return self.open_synth(preset, stepped);
        }
        if stepped {
            return Err(Failure::usage("only --replay and --synth can run --fast; leave it out"));
        }
        let (source, space): (Box<dyn GazeSource>, _) = match &self.bridge {
            // By its protocol, directions are in view space.
            Some(address) => (Box::new(self.open_bridge(address)?), Space::View),
            None => (Box::new(self.open_device()?), Space::Display),
        };
        let info = RecordingInfo { space, ..info_of(source.as_ref()) };
        Ok(Session { source, info, clock: Clock::Host, untold: Vec::new() })
    }

    fn open_bridge(&self, address: &BridgeAddress) -> Result<Bridge, Failure> {
        let settings =
            BridgeSettings { stamp: StampSettings { rate_hz: self.rate, ..StampSettings::default() } };
        Ok(match address {
            BridgeAddress::Unix(path) => Bridge::unix(path, settings)?,
            BridgeAddress::Udp(port) => Bridge::udp(*port, settings)?,
        })
    }

    fn open_device(&self) -> Result<HidSource, Failure> {
        let options = HidOptions::default();
        let Some(wanted) = &self.device else { return Ok(HidSource::open_first(options)?) };
        let devices = discover()?;
        let found = devices.iter().find(|device| is_meant(device, wanted));
        let Some(found) = found else {
            let there = devices.iter().map(|device| format!("{} {}", ids(device), device.path));
            let there = there.collect::<Vec<_>>().join(", ");
            let there = if there.is_empty() { "none".to_owned() } else { there };
            return Err(Failure::environment(format!(
                "{wanted}: there is no such tracker; found are: {there}; plug it in, or see `macula gaze devices`"
            )));
        };
        Ok(HidSource::open(found, options)?)
    }

    fn open_replay(&self, path: &Path, stepped: bool) -> Result<Session, Failure> {
        let recording = Arc::new(formats::read(path, &self.read.options())?);
        let first_ns = recording.samples().map(|sample| sample.received_ns).min().unwrap_or(0);
        // Stepped, times are as recorded.
        let start_ns = if stepped { first_ns } else { host_now_ns() };
        let settings =
            ReplaySettings { start_ns, speed: self.speed.unwrap_or(1.0), ..ReplaySettings::default() };
        let mut untold = recording.extra.iter().map(|column| column.name.clone()).collect::<Vec<_>>();
        if !recording.events.is_empty() {
            untold.push(format!("{} events", recording.events.len()));
        }
        let source = Replay::new(Arc::clone(&recording), settings)?;
        Ok(Session {
            info: recording.info.clone(),
            source: Box::new(source),
            clock: Clock::starting_at(start_ns, stepped),
            untold,
        })
    }

    fn open_synth(&self, preset: &str, stepped: bool) -> Result<Session, Failure> {
        let start_ns = if stepped { 0 } else { host_now_ns() };
        let eye = SyntheticEye::new(SyntheticSettings::preset(preset)?, self.seed)?.starting_at(start_ns);
        let info = RecordingInfo { space: Space::View, ..info_of(&eye) };
        Ok(Session {
            source: Box::new(eye),
            info,
            clock: Clock::starting_at(start_ns, stepped),
            untold: Vec::new(),
        })
    }

    /// The source goes on without end.
    pub fn is_endless(&self) -> bool {
        self.replay.is_none()
    }
}

fn info_of(source: &dyn GazeSource) -> RecordingInfo {
    let told = source.info();
    RecordingInfo {
        format: "live",
        device: told.name.clone(),
        device_clock: told.device_clock.clone(),
        nominal_rate_hz: told.rate_hz,
        ..RecordingInfo::default()
    }
}

/// A device's ids, as in `04d8:003f`.
pub fn ids(device: &DeviceInfo) -> String {
    format!("{:04x}:{:04x}", device.vendor_id, device.product_id)
}

fn is_meant(device: &DeviceInfo, wanted: &str) -> bool {
    device.path == wanted || ids(device).eq_ignore_ascii_case(wanted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bridges_are_a_socket_or_a_port() {
        assert_eq!(parse_bridge("unix:gaze/a:b"), Ok(BridgeAddress::Unix("gaze/a:b".into())));
        assert_eq!(parse_bridge("udp:5005"), Ok(BridgeAddress::Udp(5005)));
        for bad in ["", "udp", "udp:", "udp:65536", "udp:-1", "unix:", "tcp:1", "5005"] {
            assert!(parse_bridge(bad).is_err(), "{bad}");
        }
    }
}
