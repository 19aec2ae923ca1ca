//! Which trackers are plugged in, and opening them.

use super::role::USAGE_PAGE;
use super::transport::{HidapiTransport, Port, Transport};
use super::{udev, vendor};
use crate::error::{Error, Result};
use hidapi::HidApi;
use rustix::fs::{Access, access};
use rustix::io::Errno;
use serde::Serialize;
use std::ffi::{CStr, CString};

/// A tracker that is plugged in.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DeviceInfo {
    /// Its file, as in `/dev/hidraw0`.
    pub path: String,
    /// Vendor id.
    pub vendor_id: u16,
    /// Product id.
    pub product_id: u16,
    /// Who made it; may be empty.
    pub manufacturer: String,
    /// What it is; may be empty.
    pub product: String,
    /// Serial number, if it has one.
    pub serial: Option<String>,
    /// Usage page of the collection by which it was found.
    pub usage_page: u16,
    /// Usage of that collection.
    pub usage: u16,
    /// Decoded by a layout of its vendor's instead of by usage page 0x12.
    pub vendor_layout: bool,
    /// It can be opened.
    pub accessible: bool,
    /// Why not, and what to do; one line.
    pub problem: Option<String>,
}

/// All trackers: devices of usage page 0x12 and those of [`vendor::TABLE`], by path.
///
/// # Errors
/// [`Error::Device`] where HID devices cannot be listed. That there are none is no error.
pub fn discover() -> Result<Vec<DeviceInfo>> {
    let api = HidApi::new().map_err(|error| Error::device("HID devices", error))?;
    let mut found: Vec<DeviceInfo> = api.device_list().filter_map(tracker).collect();
    // A device is listed once for each of its top-level collections.
    found.sort_by(|a, b| (&a.path, a.usage).cmp(&(&b.path, b.usage)));
    found.dedup_by(|later, first| later.path == first.path);
    Ok(found)
}

fn tracker(device: &hidapi::DeviceInfo) -> Option<DeviceInfo> {
    let (vendor_id, product_id) = (device.vendor_id(), device.product_id());
    let vendor_layout = vendor::find(vendor_id, product_id).is_some();
    if device.usage_page() != USAGE_PAGE && !vendor_layout {
        return None;
    }
    let text = |told: Option<&str>| told.unwrap_or_default().trim().to_owned();
    let problem = problem(device.path(), vendor_id, product_id);
    Some(DeviceInfo {
        path: device.path().to_string_lossy().into_owned(),
        vendor_id,
        product_id,
        manufacturer: text(device.manufacturer_string()),
        product: text(device.product_string()),
        serial: Some(text(device.serial_number())).filter(|serial| !serial.is_empty()),
        usage_page: device.usage_page(),
        usage: device.usage(),
        vendor_layout,
        accessible: problem.is_none(),
        problem,
    })
}

fn problem(path: &CStr, vendor_id: u16, product_id: u16) -> Option<String> {
    let error = access(path, Access::READ_OK | Access::WRITE_OK).err()?;
    Some(explain(error, vendor_id, product_id))
}

fn explain(error: Errno, vendor_id: u16, product_id: u16) -> String {
    match error {
        Errno::ACCESS | Errno::PERM => udev::advice(vendor_id, product_id),
        error => format!("it cannot be opened: {error}"),
    }
}

impl DeviceInfo {
    /// Manufacturer and product in one, or the ids where it tells neither.
    #[must_use]
    pub fn name(&self) -> String {
        let name = format!("{} {}", self.manufacturer, self.product).trim().to_owned();
        if name.is_empty() { format!("{:04x}:{:04x}", self.vendor_id, self.product_id) } else { name }
    }

    /// Opens it.
    ///
    /// # Errors
    /// [`Error::Device`]; without permission it says which udev rule to add.
    pub fn open(&self) -> Result<HidapiTransport> {
        let fail = |cause: String| Error::device(&self.path, cause);
        let path = CString::new(self.path.as_str()).map_err(|_| fail("is no path".to_owned()))?;
        if let Some(problem) = problem(&path, self.vendor_id, self.product_id) {
            return Err(fail(problem));
        }
        let api = HidApi::new().map_err(|error| fail(error.to_string()))?;
        let device = api.open_path(&path).map_err(|error| fail(error.to_string()))?;
        Ok(HidapiTransport::new(format!("{} ({})", self.name(), self.path), device))
    }
}

/// Finds one device again by its ids and serial number, wherever it is plugged in.
#[derive(Clone, Debug)]
pub struct HidPort(pub DeviceInfo);

impl Port for HidPort {
    fn open(&mut self) -> Result<Box<dyn Transport>> {
        let here = discover()?;
        let found =
            again(&self.0, &here).ok_or_else(|| Error::device(self.0.name(), "it is not plugged in"))?;
        Ok(Box::new(found.open()?))
    }
}

/// The device among those that are here: the same interface of the same kind, and of several such ones
/// without serial numbers the one at the same path.
fn again<'a>(device: &DeviceInfo, here: &'a [DeviceInfo]) -> Option<&'a DeviceInfo> {
    let alike = |info: &&DeviceInfo| {
        (info.vendor_id, info.product_id, &info.serial, info.usage_page, info.usage)
            == (device.vendor_id, device.product_id, &device.serial, device.usage_page, device.usage)
    };
    let mut found = here.iter().filter(alike);
    found.clone().find(|info| info.path == device.path).or_else(|| found.next())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info(path: &str) -> DeviceInfo {
        DeviceInfo {
            path: path.to_owned(),
            vendor_id: 0x1209,
            product_id: 0xee01,
            manufacturer: String::new(),
            product: String::new(),
            serial: None,
            usage_page: USAGE_PAGE,
            usage: 1,
            vendor_layout: false,
            accessible: true,
            problem: None,
        }
    }

    #[test]
    fn a_device_without_names_goes_by_its_ids() {
        assert_eq!(info("/dev/hidraw0").name(), "1209:ee01");
        assert_eq!(DeviceInfo { product: "Tracker".to_owned(), ..info("") }.name(), "Tracker");
    }

    #[test]
    fn a_device_is_found_again_at_another_path_and_not_mistaken() {
        let serial = |path: &str, serial: &str| DeviceInfo { serial: Some(serial.to_owned()), ..info(path) };
        // Another interface of the same device, which a vendor's entry lists too.
        let keys = DeviceInfo { usage_page: 1, usage: 6, ..serial("/dev/hidraw0", "a") };
        let here = [keys, serial("/dev/hidraw1", "b"), serial("/dev/hidraw2", "a"), info("/dev/hidraw3")];
        let found = |device: &DeviceInfo| again(device, &here).map(|info| info.path.clone());
        assert_eq!(found(&serial("/dev/hidraw0", "a")).as_deref(), Some("/dev/hidraw2"));
        assert_eq!(found(&info("/dev/hidraw9")).as_deref(), Some("/dev/hidraw3"));
        assert_eq!(found(&serial("/dev/hidraw1", "c")), None);
        let twins = [info("/dev/hidraw3"), info("/dev/hidraw4")];
        assert_eq!(again(&info("/dev/hidraw4"), &twins), Some(&twins[1]));
    }

    #[test]
    fn what_cannot_be_opened_says_why() {
        let absent = info("/dev/no-such-hidraw").open().expect_err("it is not there").to_string();
        assert!(absent.starts_with("/dev/no-such-hidraw: it cannot be opened: No such file"), "{absent}");
        assert_eq!(explain(Errno::ACCESS, 1, 2), udev::advice(1, 2));
        let file = tempfile::NamedTempFile::new().expect("a temporary file");
        let path = file.path().to_str().expect("a path in UTF-8");
        // A file that is no device is refused by the system, not taken for one.
        assert!(info(path).open().expect_err("no device").to_string().contains(path));
    }

    #[test]
    fn listing_works_without_any_device() {
        for found in discover().expect("a list") {
            assert!(found.usage_page == USAGE_PAGE || found.vendor_layout);
            assert_eq!(found.accessible, found.problem.is_none());
        }
    }
}
