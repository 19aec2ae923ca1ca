//! Devices whose reports have a fixed layout of their own instead of usage page 0x12.

pub mod example;

use super::decoder::Start;

/// A device known by its ids.
#[derive(Clone, Copy, Debug)]
pub struct Vendor {
    /// Vendor id.
    pub vendor_id: u16,
    /// Product id.
    pub product_id: u16,
    /// What it is, for a person.
    pub name: &'static str,
    /// Prepares it.
    pub start: Start,
}

/// All that are known.
pub const TABLE: &[Vendor] = &[example::VENDOR];

/// The entry of a device.
#[must_use]
pub fn find(vendor_id: u16, product_id: u16) -> Option<&'static Vendor> {
    TABLE.iter().find(|entry| (entry.vendor_id, entry.product_id) == (vendor_id, product_id))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_device_is_known_once() {
        for entry in TABLE {
            let same = TABLE
                .iter()
                .filter(|other| (other.vendor_id, other.product_id) == (entry.vendor_id, entry.product_id));
            assert_eq!(same.count(), 1, "{}", entry.name);
        }
        assert_eq!(find(0x1209, 0x0001).map(|entry| entry.name), Some("example tracker"));
        assert!(find(0x1209, 0x0002).is_none());
    }
}
