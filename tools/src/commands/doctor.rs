//! `macula doctor`: what the system offers and what is missing.

use crate::failure::Failure;
use crate::library;
use crate::output;
use clap::Args;
use macula::headless::DeviceReport;
use serde::Serialize;
use std::fmt::Write;

/// Show Vulkan devices, their drivers, and what each feature needs and lacks
///
/// Devices stand in the order of preference: commands that render take the first usable one. Exits
/// with 1 where no device can run macula, so that scripts can ask.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  macula doctor\n  macula doctor --json\n  \
                        VK_DRIVER_FILES=/path/to/icd.json macula doctor    (only that driver)")]
pub struct DoctorArgs {}

#[derive(Serialize)]
struct Report {
    version: &'static str,
    devices: Vec<Device>,
    /// Whether the validation layer is installed; `None` where there is no driver to ask with.
    validation_layer: Option<bool>,
}

/// A [`DeviceReport`] as JSON has it.
#[derive(Serialize)]
struct Device {
    name: String,
    driver: String,
    api_version: String,
    device_type: &'static str,
    usable: bool,
    missing: Vec<String>,
    features: Vec<Feature>,
    limits: Limits,
}

#[derive(Serialize)]
struct Feature {
    name: &'static str,
    present: bool,
    required: bool,
    needed_for: &'static str,
}

#[derive(Serialize)]
struct Limits {
    max_image_px: u32,
    max_storage_bytes: u32,
    timestamp_period_ns: f32,
}

impl From<DeviceReport> for Device {
    fn from(report: DeviceReport) -> Self {
        let features = report.features.iter().map(|feature| Feature {
            name: feature.name,
            present: feature.present,
            required: feature.required,
            needed_for: feature.needed_for,
        });
        Self {
            features: features.collect(),
            limits: Limits {
                max_image_px: report.max_image_px,
                max_storage_bytes: report.max_storage_bytes,
                timestamp_period_ns: report.timestamp_period_ns,
            },
            name: report.name,
            driver: report.driver,
            api_version: report.api_version,
            device_type: report.device_type,
            usable: report.usable,
            missing: report.missing,
        }
    }
}

/// Runs the command.
///
/// # Errors
/// [`Failure::Environment`] where no device is usable.
pub fn run(_args: &DoctorArgs, json: bool) -> Result<(), Failure> {
    let (found, failure) = match library::device_reports() {
        Ok(found) => (Some(found), None),
        Err(failure) => (None, Some(failure)),
    };
    let (devices, validation_layer) = match found {
        Some((reports, layer)) => (reports.into_iter().map(Device::from).collect(), Some(layer)),
        None => (Vec::new(), None),
    };
    let report = Report { version: env!("CARGO_PKG_VERSION"), devices, validation_layer };
    if json {
        output::print_json(&report)?;
    } else {
        output::print(&text(&report))?;
    }
    match failure {
        Some(failure) => Err(failure),
        None if report.devices.iter().any(|device| device.usable) => Ok(()),
        None => Err(Failure::environment(
            "no device can run macula; update its driver, or install a software driver (Debian and Ubuntu: \
             apt-get install mesa-vulkan-drivers)",
        )),
    }
}

fn text(report: &Report) -> String {
    let mut text = format!("macula {}\n", report.version);
    if report.devices.is_empty() {
        text += "\nno Vulkan devices\n";
    }
    for device in &report.devices {
        let usable = if device.usable { "usable" } else { "NOT usable" };
        _ = write!(text, "\n{} ({}, {usable})\n", device.name, device.device_type);
        _ = writeln!(text, "  driver  {}", device.driver);
        _ = writeln!(text, "  Vulkan  {}", device.api_version);
        for feature in &device.features {
            let state = if feature.present { "has" } else { "LACKS" };
            let need = if feature.required { "needed for" } else { "used for" };
            _ = writeln!(text, "  {state:<5}   {:<30}  {need} {}", feature.name, feature.needed_for);
        }
        let known = |lack: &String| device.features.iter().any(|feature| feature.name == lack);
        for lack in device.missing.iter().filter(|lack| !known(lack)) {
            _ = writeln!(text, "  LACKS   {lack}");
        }
        let limits = &device.limits;
        _ = writeln!(text, "  images up to {} px a side", output::grouped(limits.max_image_px.into()));
        _ = writeln!(text, "  buffers up to {} bytes", output::grouped(limits.max_storage_bytes.into()));
        _ = writeln!(text, "  timestamps in steps of {} ns", limits.timestamp_period_ns);
    }
    let layer = match report.validation_layer {
        Some(true) => "installed",
        Some(false) => {
            "not installed; `render` checks less, the tests need it (Debian and Ubuntu: apt-get install \
             vulkan-validationlayers)"
        }
        None => "unknown without a driver",
    };
    _ = write!(text, "\nvalidation layer: {layer}\n");
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use macula::headless::FeatureReport;

    #[test]
    fn the_text_names_what_is_missing() {
        let feature =
            |name, present| FeatureReport { name, present, needed_for: "everything", required: true };
        let device = DeviceReport {
            name: "GPU".into(),
            driver: "driver 1".into(),
            api_version: "1.3.0".into(),
            device_type: "discrete",
            usable: false,
            missing: vec!["dynamicRendering".into(), "a queue for graphics".into()],
            features: vec![feature("synchronization2", true), feature("dynamicRendering", false)],
            max_image_px: 16384,
            max_storage_bytes: 1 << 27,
            timestamp_period_ns: 1.0,
        };
        let text = text(&Report { version: "1", devices: vec![device.into()], validation_layer: None });
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        for part in ["GPU (discrete, NOT usable)", "LACKS dynamicRendering", "LACKS a queue", "16 384 px"] {
            assert!(words.contains(part), "{part} in {text}");
        }
        assert_eq!(words.matches("LACKS").count(), 2, "{text}");
    }
}
