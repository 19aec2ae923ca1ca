//! `macula gaze devices`: which trackers are plugged in.

use super::source::ids;
use crate::failure::Failure;
use crate::output;
use clap::Args;
use macula_trackers::hid::{DeviceInfo, discover, udev, vendor};
use serde::Serialize;

const NONE: &str = "\
No eye tracker was found.

Found are HID devices of usage page 0x12 (\"Eye and Head Trackers\") and those whose own layout is known.
Many trackers do not speak HID on Linux: FOVE (cameras and a closed library), Tobii Eye Tracker 5 and Pro
(USB or network protocols of the maker), Vive Pro Eye (SRanipal) and Varjo (Varjo SDK).

Three ways in for them:
  bridge     macula gaze record --bridge udp:5005 -o NAME
             and the maker's SDK in a program that sends each sample there as a line of JSON
  host       a program that uses the library hands samples over (macula_trackers::bridge::host_source),
             as from OpenXR's XR_EXT_eye_gaze_interaction
  recording  macula gaze monitor --replay FILE
             and whatever else reads a FILE of any known format
";

/// List the HID eye trackers, and what to do where one cannot be opened
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  macula gaze devices\n  macula gaze devices --json")]
pub struct DevicesArgs {}

#[derive(Serialize)]
struct Listed<'a> {
    id: String,
    name: String,
    decoder: &'a str,
    /// The udev rule that gives access, and its file, where it is missing.
    udev_rule: Option<String>,
    udev_path: Option<String>,
    #[serde(flatten)]
    device: &'a DeviceInfo,
}

#[derive(Serialize)]
struct List<'a> {
    devices: Vec<Listed<'a>>,
}

fn listed(device: &DeviceInfo) -> Listed<'_> {
    let (vendor_id, product_id) = (device.vendor_id, device.product_id);
    let known = vendor::find(vendor_id, product_id).filter(|_| device.vendor_layout);
    Listed {
        id: ids(device),
        name: device.name(),
        decoder: known.map_or("usage page 0x12", |known| known.name),
        udev_rule: (!device.accessible).then(|| udev::rule(vendor_id, product_id)),
        udev_path: (!device.accessible).then(|| udev::rule_path(vendor_id, product_id)),
        device,
    }
}

/// Runs the command.
///
/// # Errors
/// HID devices cannot be listed. That there are none is no error.
pub fn run(_: &DevicesArgs, json: bool) -> Result<(), Failure> {
    let devices = discover()?;
    let list = List { devices: devices.iter().map(listed).collect() };
    if json { output::print_json(&list) } else { output::print(&text(&list)) }
}

fn text(list: &List<'_>) -> String {
    if list.devices.is_empty() {
        return NONE.to_owned();
    }
    let row = |listed: &Listed<'_>| {
        let device = listed.device;
        vec![
            device.path.clone(),
            listed.id.clone(),
            listed.name.clone(),
            device.serial.clone().unwrap_or_else(|| "-".to_owned()),
            format!("{:04x}:{:04x}", device.usage_page, device.usage),
            listed.decoder.to_owned(),
            if device.accessible { "yes" } else { "no" }.to_owned(),
        ]
    };
    let header = ["path", "vid:pid", "name", "serial", "usage", "decoder", "usable"];
    let mut text = output::table(&header, &list.devices.iter().map(row).collect::<Vec<_>>());
    for device in list.devices.iter().map(|listed| listed.device) {
        if let Some(problem) = &device.problem {
            text += &format!("\n{}: {problem}\n", device.path);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_without_permission_comes_with_its_rule() {
        let device = DeviceInfo {
            path: "/dev/hidraw3".into(),
            vendor_id: 0x04d8,
            product_id: 0x3f,
            manufacturer: "Maker".into(),
            product: "Eye".into(),
            serial: None,
            usage_page: 0x12,
            usage: 1,
            vendor_layout: false,
            accessible: false,
            problem: Some(udev::advice(0x04d8, 0x3f)),
        };
        let list = List { devices: vec![listed(&device)] };
        let told = text(&list);
        assert!(told.contains("/dev/hidraw3  04d8:003f  Maker Eye  -       0012:0001"), "{told}");
        assert!(told.contains(r#"/dev/hidraw3: no permission; write the line 'KERNEL=="hidraw*""#), "{told}");
        let json = serde_json::to_value(&list).expect("JSON");
        assert_eq!(json["devices"][0]["udev_path"], "/etc/udev/rules.d/70-macula-04d8-003f.rules");
        assert_eq!(json["devices"][0]["vendor_id"], 0x04d8);
    }
}
