//! What makes samples of the reports of one kind of device, and the table of those that need one of
//! their own.

use super::decode::Reject;
use super::descriptor::Layout;
use super::feature::{Capabilities, Configuration, ModeRequest, Status};
use super::role::Role;
use super::transport::Transport;
use super::vendor;
use crate::error::{Error, Result};
use crate::sample::GazeSample;
use crate::time::Unwrapper;
use glam::DVec2;
use serde::Serialize;
use std::fmt;

/// What a device tells of itself besides samples.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct About {
    /// What it can do.
    pub capabilities: Option<Capabilities>,
    /// The display that it is calibrated to.
    pub configuration: Option<Configuration>,
    /// Its state.
    pub status: Option<Status>,
    /// What had to be assumed or did not work, a sentence each.
    pub notes: Vec<String>,
}

/// Makes samples of a device's reports. To support a device with a layout of its own, copy
/// `hid/vendor/example.rs` and enter it in [`vendor::TABLE`].
pub trait ReportDecoder: fmt::Debug + Send {
    /// The clock of `device_time_ns`, as in `tracker (1 us, 32 bit)`; empty without one.
    fn clock(&self) -> String;

    /// What the device tells of itself.
    fn about(&self) -> &About;

    /// Takes a report apart. `received_ns` is its arrival on the host clock. The sample's
    /// `device_time_ns` must not wrap ([`Unwrapper`]); `time_ns` is set later. `None` is a good report
    /// that tells no sample.
    ///
    /// # Errors
    /// [`Reject`] where it is none of the device's.
    fn decode(&mut self, report: &[u8], received_ns: i64) -> Result<Option<GazeSample>, Reject>;
}

/// What is asked of a device at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StartOptions {
    /// What it shall send. Default: all of it.
    pub mode: ModeRequest,
    /// Width and height of the display, m, instead of what the device says.
    pub screen_m: Option<DVec2>,
}

impl Default for StartOptions {
    fn default() -> Self {
        Self { mode: ModeRequest::ALL, screen_m: None }
    }
}

/// Prepares an open device and makes the decoder of its reports.
pub type Start = fn(&mut dyn Transport, &StartOptions) -> Result<Box<dyn ReportDecoder>>;

/// The way to start a device: its vendor's, or the standard one.
#[must_use]
pub fn start_of(vendor_id: u16, product_id: u16) -> Start {
    vendor::find(vendor_id, product_id).map_or(start_standard, |entry| entry.start)
}

/// Decodes the reports of usage page 0x12 by the report descriptor.
#[derive(Debug)]
pub struct StandardDecoder {
    layout: Layout,
    screen_m: Option<DVec2>,
    counter: Option<Unwrapper>,
    about: About,
}

impl StandardDecoder {
    /// For reports of this layout. `screen_m` is the display's width and height, without which gaze is
    /// told as a direction only.
    #[must_use]
    pub fn new(layout: Layout, screen_m: Option<DVec2>) -> Self {
        let counter = layout.timestamp().map(|(bits, tick_ns)| Unwrapper::new(bits, false, whole(tick_ns)));
        let about = About { notes: layout.notes.clone(), ..About::default() };
        Self { layout, screen_m, counter, about }
    }

    /// Where everything lies.
    #[must_use]
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Reads the feature report that has `role`, if there is one.
    fn read_feature(&mut self, transport: &mut dyn Transport, role: Role) -> Option<super::Decoded> {
        let mut report = self.layout.feature_with(role)?;
        let length = match transport.get_feature(&mut report) {
            Ok(length) => length.min(report.len()),
            Err(error) => {
                self.about.notes.push(error.to_string());
                return None;
            }
        };
        let from = usize::from(!self.layout.has_ids);
        match self.layout.decode_feature(report.get(from..length).unwrap_or_default()) {
            Ok(decoded) => Some(decoded),
            Err(why) => {
                self.about.notes.push(format!("the feature report with {role:?} is broken: {why}"));
                None
            }
        }
    }
}

/// Starts a device of usage page 0x12: reads its descriptor, capabilities, configuration and status, and
/// requests the mode. What of these fails is noted, not an error: gaze may come all the same.
///
/// # Errors
/// [`Error::Device`] where the descriptor cannot be read or tells no gaze.
pub fn start_standard(
    transport: &mut dyn Transport,
    options: &StartOptions,
) -> Result<Box<dyn ReportDecoder>> {
    let descriptor = transport.descriptor()?;
    let layout = Layout::parse(&descriptor).map_err(|error| Error::device(transport.name(), error))?;
    let mut decoder = StandardDecoder::new(layout, None);
    let capabilities = decoder.read_feature(transport, Role::TrackerQuality);
    decoder.about.capabilities = capabilities.map(|decoded| decoded.capabilities());
    let configuration = decoder.read_feature(transport, Role::ScreenWidth);
    decoder.about.configuration = configuration.map(|decoded| decoded.configuration());
    let told_m = decoder.about.configuration.and_then(|told| told.screen_m());
    decoder.screen_m = options.screen_m.or(told_m);
    if let Some(request) = decoder.layout.mode_report(options.mode)
        && let Err(error) = transport.set_feature(&request)
    {
        decoder.about.notes.push(format!("the mode could not be requested: {error}"));
    }
    // The mode may decide on the rate.
    let status = [Role::SamplingFrequency, Role::ConfigurationStatus]
        .into_iter()
        .find_map(|role| decoder.read_feature(transport, role));
    decoder.about.status = status.and_then(|decoded| decoded.status());
    Ok(Box::new(decoder))
}

impl ReportDecoder for StandardDecoder {
    fn clock(&self) -> String {
        self.layout.timestamp().map_or_else(String::new, |(bits, tick_ns)| {
            format!("tracker ({} us, {bits} bit)", tick_ns / 1000.0)
        })
    }

    fn about(&self) -> &About {
        &self.about
    }

    fn decode(&mut self, report: &[u8], received_ns: i64) -> Result<Option<GazeSample>, Reject> {
        let decoded = self.layout.decode(report)?;
        if let Some(status) = decoded.status() {
            self.about.status = Some(status);
        }
        if !decoded.is_tracking() {
            return Ok(None);
        }
        let mut sample = decoded.to_sample(self.screen_m, received_ns);
        if let (Some(counter), Some(raw)) = (&mut self.counter, decoded.raw(Role::Timestamp)) {
            sample.device_time_ns = Some(counter.unwrap(raw as u64, Some(received_ns)).time_ns);
        }
        Ok(Some(sample))
    }
}

/// Ticks are powers of ten of a second; those below 1 ns, which no tracker has, count as 1 ns.
fn whole(tick_ns: f64) -> i64 {
    (tick_ns.round() as i64).max(1)
}
