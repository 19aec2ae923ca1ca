//! What a sweep runs on.

use super::record::Machine;
use macula::headless::HeadlessDevice;

/// This machine, as far as it says.
pub fn this_machine(device: &HeadlessDevice) -> Machine {
    let threads = std::thread::available_parallelism().map_or(0, |threads| threads.get() as u32);
    let value_of = |file: &str, key: &str, separator: char| {
        let text = std::fs::read_to_string(file).ok()?;
        let lines = text.lines().filter_map(|line| line.split_once(separator));
        let mut values =
            lines.filter(|(name, _)| name.trim() == key).map(|(_, value)| value.trim().trim_matches('"'));
        values.next().map(str::to_owned)
    };
    let known = |value: Option<String>| value.unwrap_or_else(|| "unknown".to_owned());
    Machine {
        device: device.name().to_owned(),
        driver: device.driver().to_owned(),
        cpu: known(value_of("/proc/cpuinfo", "model name", ':')),
        threads,
        system: known(value_of("/etc/os-release", "PRETTY_NAME", '=')),
    }
}
