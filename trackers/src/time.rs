//! Clocks: the host's own, and a device's as seen from it.

/// Now on the host clock, in ns: `CLOCK_MONOTONIC`, which is OpenXR's time on Linux too.
#[must_use]
pub fn host_now_ns() -> i64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    now.tv_sec * 1_000_000_000 + now.tv_nsec
}

/// The name of the clock of [`host_now_ns`].
pub const HOST_CLOCK: &str = "CLOCK_MONOTONIC";
