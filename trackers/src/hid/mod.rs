//! Eye trackers that speak HID: the standard usage page 0x12, and fixed layouts of vendors.
//!
//! The codec ([`Layout`], [`Decoded`]) is pure and knows no device.

mod bytes;
mod decode;
mod descriptor;
mod feature;
mod guard;
mod role;
#[cfg(test)]
mod tests;

pub use bytes::Bytes;
pub use decode::{Decoded, RawField, Reject};
pub use descriptor::{DescriptorError, Field, Layout, ReportKind, ReportLayout};
pub use feature::{Capabilities, Configuration, ConfigurationStatus, ModeRequest, Status};
pub use role::{Role, USAGE_PAGE};
