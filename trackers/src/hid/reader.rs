//! The thread that reads a tracker, and goes on looking for it when it is gone.

use super::decoder::{ReportDecoder, Start};
use super::queue::Queue;
use super::rate::RateEstimate;
use super::source::HidOptions;
use super::transport::{MAX_REPORT_BYTES, Port, Transport};
use crate::error::Error;
use crate::sample::GazeSample;
use crate::source::SourceEvent;
use crate::stamp::{StampSettings, Stamper};
use crate::time::host_now_ns;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

/// How long a read waits: the longest that a stop or a stall stays unnoticed.
const WAIT: Duration = Duration::from_millis(20);

type Device = (Box<dyn Transport>, Box<dyn ReportDecoder>);

pub(super) struct Reader {
    port: Box<dyn Port>,
    start: Start,
    options: HidOptions,
    queue: Arc<Queue>,
    stamper: Stamper,
    rate: RateEstimate,
    events: Vec<SourceEvent>,
}

impl Reader {
    pub fn new(port: Box<dyn Port>, start: Start, options: HidOptions, queue: Arc<Queue>) -> Self {
        let rate_hz = queue.about().status.and_then(|status| status.sampling_hz);
        let stamper = Stamper::new(StampSettings { freshness: options.freshness, rate_hz });
        Self { port, start, options, queue, stamper, rate: RateEstimate::default(), events: Vec::new() }
    }

    pub fn run(mut self, mut transport: Box<dyn Transport>, mut decoder: Box<dyn ReportDecoder>) {
        loop {
            let Some(error) = self.read(transport.as_mut(), decoder.as_mut()) else { return };
            // Closed at once, so that the file is free for the device that comes next.
            drop(transport);
            self.queue.push([SourceEvent::Disconnected { why: error.to_string() }]);
            let Some(found) = self.find_again() else { return };
            (transport, decoder) = found;
            self.stamper.reconnected();
            self.queue.push([SourceEvent::Reconnected]);
        }
    }

    /// Reads until the device is gone, which is returned, or the source is dropped.
    fn read(&mut self, transport: &mut dyn Transport, decoder: &mut dyn ReportDecoder) -> Option<Error> {
        self.rate = RateEstimate::default();
        self.take_in_about(decoder);
        let mut report = vec![0; MAX_REPORT_BYTES];
        while !self.queue.is_stopped() {
            let length = match transport.read(&mut report, WAIT) {
                Ok(length) => length,
                Err(error) => return Some(error),
            };
            let received_ns = host_now_ns();
            match report.get(..length) {
                None | Some([]) => self.stamper.check(received_ns, &mut self.events),
                Some(bytes) => match decoder.decode(bytes, received_ns) {
                    Ok(Some(sample)) => self.stamp(sample),
                    Ok(None) => self.take_in_about(decoder),
                    Err(why) => self.events.push(SourceEvent::Rejected { count: 1, why: why.to_string() }),
                },
            }
            if !self.events.is_empty() {
                self.queue.push(self.events.drain(..));
            }
        }
        None
    }

    /// The one place where a sample gets its time and losses are counted.
    fn stamp(&mut self, sample: GazeSample) {
        if let Some(device_ns) = sample.device_time_ns
            && let Some(rate_hz) = self.rate.observe(device_ns)
        {
            self.stamper.set_rate(Some(rate_hz));
        }
        if self.stamper.stamp(sample, &mut self.events) {
            self.rate.clock_jumped();
        }
    }

    fn take_in_about(&mut self, decoder: &dyn ReportDecoder) {
        let about = decoder.about();
        self.queue.set_about(about);
        self.rate.set_nominal(about.status.and_then(|status| status.sampling_hz));
        self.stamper.set_rate(self.rate.rate_hz());
    }

    fn find_again(&mut self) -> Option<Device> {
        loop {
            // Woken early when the source is dropped.
            thread::park_timeout(self.options.retry);
            if self.queue.is_stopped() {
                return None;
            }
            let mut found = self.port.open();
            let Ok(transport) = &mut found else { continue };
            let Ok(decoder) = (self.start)(transport.as_mut(), &self.options.start) else { continue };
            return found.ok().map(|transport| (transport, decoder));
        }
    }
}
