//! A tracker as a source of gaze.

use super::decoder::{About, Start, StartOptions, start_of, start_standard};
use super::discover::{DeviceInfo, HidPort, discover};
use super::queue::Queue;
use super::reader::Reader;
use super::transport::Port;
use crate::error::{Error, Result};
use crate::source::{GazeSource, SourceEvent, SourceInfo};
use crate::time::{FreshnessSettings, HOST_CLOCK};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

/// How a tracker is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HidOptions {
    /// What is asked of it.
    pub start: StartOptions,
    /// Events kept until the next poll. Beyond that the oldest samples are dropped and told as lost.
    /// Default 4096: four seconds at 1 kHz, in 3 MB.
    pub queue: usize,
    /// How often a tracker that is gone is looked for. Default 250 ms: soon enough for a person, and
    /// rare enough not to be noticed (a look takes about a millisecond).
    pub retry: Duration,
    /// When it counts as stalled.
    pub freshness: FreshnessSettings,
}

impl Default for HidOptions {
    fn default() -> Self {
        Self {
            start: StartOptions::default(),
            queue: 4096,
            retry: Duration::from_millis(250),
            freshness: FreshnessSettings::default(),
        }
    }
}

/// A tracker, read by a thread of its own at its full rate. The thread ends when this is dropped.
#[derive(Debug)]
pub struct HidSource {
    info: SourceInfo,
    queue: Arc<Queue>,
    thread: Option<JoinHandle<()>>,
}

impl HidSource {
    /// Opens a tracker.
    ///
    /// # Errors
    /// [`Error::Device`]: no permission (it says which udev rule to add), gone, or no tracker.
    pub fn open(device: &DeviceInfo, options: HidOptions) -> Result<Self> {
        let start = start_of(device.vendor_id, device.product_id);
        Self::with_port(device.name(), Box::new(HidPort(device.clone())), start, options)
    }

    /// Opens the first tracker that can be opened.
    ///
    /// # Errors
    /// [`Error::Device`]: none is plugged in, or none can be opened; then why.
    pub fn open_first(options: HidOptions) -> Result<Self> {
        let devices = discover()?;
        let device = devices.iter().find(|device| device.accessible).or(devices.first());
        let none = || {
            Error::device(
                "HID devices",
                "there is no eye tracker of usage page 0x12 or a known layout; plug one in, or use a \
                 recording or the bridge",
            )
        };
        Self::open(device.ok_or_else(none)?, options)
    }

    /// Reads whatever a port opens, by usage page 0x12 unless `start` says otherwise
    /// ([`start_standard`]).
    ///
    /// # Errors
    /// [`Error::Device`] where the port or the start fails this first time. Later that is an event.
    pub fn with_port(
        name: String,
        mut port: Box<dyn Port>,
        start: Start,
        options: HidOptions,
    ) -> Result<Self> {
        let mut transport = port.open()?;
        let decoder = start(transport.as_mut(), &options.start)?;
        let rate_hz = decoder.about().status.and_then(|status| status.sampling_hz);
        let info =
            SourceInfo { name, device_clock: decoder.clock(), host_clock: HOST_CLOCK.to_owned(), rate_hz };
        let queue = Arc::new(Queue::new(options.queue));
        queue.set_about(decoder.about());
        let reader = Reader::new(port, start, options, Arc::clone(&queue));
        let thread = std::thread::Builder::new()
            .name("hid tracker".to_owned())
            .spawn(move || reader.run(transport, decoder))
            .map_err(|error| Error::device(&info.name, format!("no thread for it: {error}")))?;
        Ok(Self { info, queue, thread: Some(thread) })
    }

    /// As [`Self::with_port`], of usage page 0x12.
    ///
    /// # Errors
    /// As there.
    pub fn standard(name: String, port: Box<dyn Port>, options: HidOptions) -> Result<Self> {
        Self::with_port(name, port, start_standard, options)
    }

    /// What the tracker has told of itself so far.
    #[must_use]
    pub fn about(&self) -> About {
        self.queue.about()
    }
}

impl GazeSource for HidSource {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    /// Tells all that the thread has read; its own clock decides, not `now_ns`.
    fn poll(&mut self, _now_ns: i64, events: &mut Vec<SourceEvent>) -> Result<()> {
        self.queue.drain(events);
        let ended = self.thread.as_ref().is_none_or(JoinHandle::is_finished);
        if ended {
            Err(Error::device(&self.info.name, "its reader has ended unexpectedly; open it again"))
        } else {
            Ok(())
        }
    }
}

impl Drop for HidSource {
    fn drop(&mut self) {
        self.queue.stop();
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // A panic there has been printed already.
            let _ = thread.join();
        }
    }
}
