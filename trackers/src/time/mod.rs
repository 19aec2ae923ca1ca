//! Clocks: the host's own, a device's as seen from it, and whether what a source tells is new.

mod freshness;
mod mapper;
mod unwrap;

pub use freshness::{Freshness, FreshnessMonitor, FreshnessSettings, content_hash};
pub use mapper::{ClockMapper, Mapped};
pub use unwrap::{Unwrapped, Unwrapper};

/// Now on the host clock, in ns: `CLOCK_MONOTONIC`, which is OpenXR's time on Linux too.
#[must_use]
pub fn host_now_ns() -> i64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    now.tv_sec * 1_000_000_000 + now.tv_nsec
}

/// The name of the clock of [`host_now_ns`].
pub const HOST_CLOCK: &str = "CLOCK_MONOTONIC";

/// A device time this much earlier than the latest one is a clock that was set back; anything less is
/// a sample out of order. Half a second is far above the disorder of a network on one machine. Larger
/// hides steps of the clock for longer, smaller takes disorder for steps.
const SET_BACK_NS: i64 = 500_000_000;

/// The nearest `i64`.
fn clamp_i64(value: i128) -> i64 {
    value.clamp(i128::from(i64::MIN), i128::from(i64::MAX)) as i64
}
