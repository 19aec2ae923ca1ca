//! Eye trackers that speak HID: the standard usage page 0x12, and fixed layouts of vendors.
//!
//! The codec ([`Layout`], [`Decoded`], [`StandardDecoder`]) is pure and knows no device; [`Transport`] brings
//! reports from a device or a recording; [`HidSource`] reads a device in a thread of its own.

mod bytes;
mod decode;
mod decoder;
mod descriptor;
mod discover;
mod feature;
mod guard;
mod queue;
mod rate;
mod reader;
mod role;
mod source;
#[cfg(test)]
mod tests;
mod transport;
pub mod udev;
pub mod vendor;

pub use bytes::Bytes;
pub use decode::{Decoded, RawField, Reject};
pub use decoder::{About, ReportDecoder, StandardDecoder, Start, StartOptions, start_of, start_standard};
pub use descriptor::{DescriptorError, Field, Layout, ReportKind, ReportLayout};
pub use discover::{DeviceInfo, HidPort, discover};
pub use feature::{Capabilities, Configuration, ConfigurationStatus, ModeRequest, Status};
pub use role::{Role, USAGE_PAGE};
pub use source::{HidOptions, HidSource};
pub use transport::{HidapiTransport, Port, RecordedTransport, Transport};
