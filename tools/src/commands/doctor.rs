//! `macula doctor`: what the system offers and what is missing.

use crate::failure::Failure;
use crate::library::{self, DeviceReport};
use crate::output;
use clap::Args;
use serde::Serialize;
use std::fmt::Write;

/// Show Vulkan devices, their drivers, and what each feature needs and lacks
///
/// Exits with 1 where no device can run macula, so that scripts can ask.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  macula doctor\n  macula doctor --json\n  \
                        VK_DRIVER_FILES=/path/to/icd.json macula doctor    (only that driver)")]
pub struct DoctorArgs {}

#[derive(Serialize)]
struct Report {
    version: &'static str,
    devices: Vec<DeviceReport>,
    /// Whether the validation layer is installed; `None` where no device could be asked.
    validation_layer: Option<bool>,
}

/// Runs the command.
///
/// # Errors
/// [`Failure::Environment`] where no device is usable.
pub fn run(_args: &DoctorArgs, json: bool) -> Result<(), Failure> {
    let devices = library::device_reports()?;
    let usable = devices.iter().any(|device| device.usable);
    let validation_layer = if usable { library::validation_is_installed() } else { None };
    let report = Report { version: env!("CARGO_PKG_VERSION"), devices, validation_layer };
    if json {
        output::print_json(&report)?;
    } else {
        output::print(&text(&report))?;
    }
    if usable {
        return Ok(());
    }
    Err(Failure::environment(
        "no Vulkan 1.3 device can be used; install a driver (on Debian and Ubuntu the packages libvulkan1 \
         and mesa-vulkan-drivers, which also bring a software driver)",
    ))
}

fn text(report: &Report) -> String {
    let mut text = format!("macula {}\n", report.version);
    for device in &report.devices {
        let usable = if device.usable { "usable" } else { "NOT usable" };
        let kind = if device.device_type.is_empty() { "device" } else { &device.device_type };
        _ = write!(text, "\n{} ({kind}, {usable})\n  driver  {}\n", device.name, device.driver);
        _ = writeln!(text, "  Vulkan  {}", device.api_version);
        for feature in &device.features {
            let state = if feature.present { "has " } else { "LACKS" };
            _ = writeln!(text, "  {state:<5} {:<28} for {}", feature.name, feature.needed_for);
        }
        for (name, value) in &device.limits {
            _ = writeln!(text, "  limit {name:<28} {}", output::grouped(*value));
        }
    }
    let layer = match report.validation_layer {
        Some(true) => "installed",
        Some(false) => "not installed; `render` checks less (Debian and Ubuntu: vulkan-validationlayers)",
        None => "unknown without a device",
    };
    _ = write!(text, "\nvalidation layer: {layer}\n");
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::library::FeatureReport;

    #[test]
    fn the_text_names_what_is_missing() {
        let feature = |name: &str, present| FeatureReport {
            name: name.into(),
            present,
            needed_for: "everything".into(),
        };
        let device = DeviceReport {
            name: "GPU".into(),
            driver: "driver 1".into(),
            api_version: "1.3.0".into(),
            device_type: "discrete".into(),
            usable: false,
            features: vec![feature("synchronization2", true), feature("dynamicRendering", false)],
            limits: vec![("maxImageDimension2D".into(), 16384)],
        };
        let text = text(&Report { version: "1", devices: vec![device], validation_layer: None });
        assert!(text.contains("NOT usable") && text.contains("LACKS dynamicRendering"), "{text}");
        assert!(text.contains("16 384"), "{text}");
    }
}
