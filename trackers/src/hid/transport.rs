//! How reports get here. The decoders know only this, so that they run on a device, a recording or a test
//! alike.

use super::guard::MAX_BYTES;
use crate::error::{Error, Result};
use hidapi::{HidDevice, HidError, HidResult};
use std::collections::VecDeque;
use std::fmt;
use std::io;
use std::time::Duration;

/// The longest report of the Linux kernel (`HID_MAX_BUFFER_SIZE`), bytes.
pub const MAX_REPORT_BYTES: usize = 16384;

/// An open device.
pub trait Transport: fmt::Debug + Send {
    /// What it is, for messages.
    fn name(&self) -> &str;

    /// Its report descriptor.
    ///
    /// # Errors
    /// [`Error::Device`]
    fn descriptor(&mut self) -> Result<Vec<u8>>;

    /// Waits for the next input report and returns its length; 0 where none came in time.
    ///
    /// # Errors
    /// [`Error::Device`]: it is gone, for good.
    fn read(&mut self, report: &mut [u8], timeout: Duration) -> Result<usize>;

    /// Reads the feature report whose id is the first byte of `report` (0 without ids) into it, id
    /// first, and returns its length.
    ///
    /// # Errors
    /// [`Error::Device`]
    fn get_feature(&mut self, report: &mut [u8]) -> Result<usize>;

    /// Writes a feature report, id first (0 without ids).
    ///
    /// # Errors
    /// [`Error::Device`]
    fn set_feature(&mut self, report: &[u8]) -> Result<()>;
}

/// Where a device is found, and found again after it was unplugged.
pub trait Port: fmt::Debug + Send {
    /// Opens the device.
    ///
    /// # Errors
    /// [`Error::Device`] where it is not there, or may not be opened.
    fn open(&mut self) -> Result<Box<dyn Transport>>;
}

/// A device opened by hidapi.
#[derive(Debug)]
pub struct HidapiTransport {
    name: String,
    device: HidDevice,
}

impl HidapiTransport {
    /// Takes over an open device. `name` is for messages.
    #[must_use]
    pub fn new(name: String, device: HidDevice) -> Self {
        Self { name, device }
    }

    fn error(&self, doing: &str, error: &HidError) -> Error {
        Error::device(&self.name, format!("{doing} failed: {error}"))
    }
}

impl Transport for HidapiTransport {
    fn name(&self) -> &str {
        &self.name
    }

    fn descriptor(&mut self) -> Result<Vec<u8>> {
        let mut descriptor = vec![0; MAX_BYTES];
        let read = self.device.get_report_descriptor(&mut descriptor);
        let length = read.map_err(|error| self.error("reading the report descriptor", &error))?;
        descriptor.truncate(length);
        Ok(descriptor)
    }

    fn read(&mut self, report: &mut [u8], timeout: Duration) -> Result<usize> {
        let timeout_ms = i32::try_from(timeout.as_millis()).unwrap_or(i32::MAX);
        waited(self.device.read_timeout(report, timeout_ms)).map_err(|error| self.error("reading", &error))
    }

    fn get_feature(&mut self, report: &mut [u8]) -> Result<usize> {
        self.device.get_feature_report(report).map_err(|error| self.error("reading a feature report", &error))
    }

    fn set_feature(&mut self, report: &[u8]) -> Result<()> {
        let written = self.device.send_feature_report(report);
        written.map_err(|error| self.error("writing a feature report", &error))
    }
}

/// A signal ends the wait as a timeout does: the device is there.
fn waited(read: HidResult<usize>) -> HidResult<usize> {
    match read {
        Err(HidError::IoError { error }) if error.kind() == io::ErrorKind::Interrupted => Ok(0),
        read => read,
    }
}

/// A device that plays back reports, as fast as they are read, and is gone after the last.
#[derive(Clone, Debug, Default)]
pub struct RecordedTransport {
    /// Its report descriptor.
    pub descriptor: Vec<u8>,
    /// Input reports still to come. An empty one is silence: a read that times out.
    pub reports: VecDeque<Vec<u8>>,
    /// Feature reports, id first.
    pub features: Vec<Vec<u8>>,
    /// Feature reports that were written to it.
    pub written: Vec<Vec<u8>>,
}

const RECORDED: &str = "recorded device";

impl Transport for RecordedTransport {
    fn name(&self) -> &str {
        RECORDED
    }

    fn descriptor(&mut self) -> Result<Vec<u8>> {
        Ok(self.descriptor.clone())
    }

    fn read(&mut self, report: &mut [u8], timeout: Duration) -> Result<usize> {
        let next = self.reports.pop_front().ok_or_else(|| Error::device(RECORDED, "its reports are over"))?;
        if next.is_empty() {
            std::thread::sleep(timeout);
        }
        Ok(copy(&next, report))
    }

    fn get_feature(&mut self, report: &mut [u8]) -> Result<usize> {
        let id = report.first().copied();
        let told = self.features.iter().find(|feature| feature.first().copied() == id);
        let told = told.ok_or_else(|| Error::device(RECORDED, "it has no such feature report"))?;
        Ok(copy(told, report))
    }

    fn set_feature(&mut self, report: &[u8]) -> Result<()> {
        self.written.push(report.to_vec());
        Ok(())
    }
}

/// As much as fits, as a device does.
fn copy(from: &[u8], to: &mut [u8]) -> usize {
    from.iter().zip(to).map(|(from, to)| *to = *from).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signal_is_no_unplugging() {
        let failed = |kind: io::ErrorKind| Err(HidError::IoError { error: kind.into() });
        assert!(matches!(waited(failed(io::ErrorKind::Interrupted)), Ok(0)));
        assert!(waited(failed(io::ErrorKind::NotFound)).is_err());
        assert!(matches!(waited(Ok(65)), Ok(65)));
    }
}
