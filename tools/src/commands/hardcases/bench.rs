//! What cases run on: a device, made when the first case asks for it.

use crate::failure::Failure;
use crate::library;
use macula::headless::HeadlessDevice;
use std::cell::OnceCell;

/// Shared by all cases of a run.
#[derive(Default)]
pub struct Bench {
    device: OnceCell<HeadlessDevice>,
}

impl Bench {
    /// The device, with the validation layer where it is installed.
    ///
    /// # Errors
    /// Where there is no usable device.
    pub fn device(&self) -> Result<&HeadlessDevice, Failure> {
        if let Some(device) = self.device.get() {
            return Ok(device);
        }
        let made = library::device(false)?;
        Ok(self.device.get_or_init(|| made))
    }

    /// The device, where one has been made.
    pub fn device_in_use(&self) -> Option<&HeadlessDevice> {
        self.device.get()
    }

    /// Messages of the validation layer so far; 0 without a device or the layer.
    pub fn validation_messages(&self) -> u64 {
        self.device.get().and_then(HeadlessDevice::validation_messages).unwrap_or(0)
    }
}
