//! Gaze from other programs: as lines of JSON over a socket of this machine ([`Bridge`]), or from the
//! program itself ([`host_source`]).
//!
//! **The line protocol.** One JSON object is one sample: a line on a Unix socket, a datagram on a UDP port
//! of the loopback address. Every key may be left out, but one of the eyes or `point` must be there;
//! unknown keys are ignored.
//!
//! | key | what |
//! |---|---|
//! | `t_ns` | time on the sender's clock, integer ns; without it the arrival counts |
//! | `combined`, `left`, `right` | an eye, see below |
//! | `dir`, `point` | the same of `combined`, in short |
//! | `head` | `{"position_m": [x, y, z], "rotation": [x, y, z, w]}`, world from view |
//!
//! An eye:
//!
//! | key | what |
//! |---|---|
//! | `valid` | whether the gaze can be used; without it, whether `dir` or `point` is there |
//! | `dir` | direction of the gaze ray, view space: x right, y up, -z forward |
//! | `origin_m` | where the ray starts, view space, metres |
//! | `point` | fractions of the display, x right, y down from its top left corner |
//! | `confidence`, `pupil_mm`, `openness` | numbers |
//!
//! ```text
//! {"t_ns": 1000000, "combined": {"dir": [0.1, 0.0, -1.0], "confidence": 0.9}}
//! {"point": [0.5, 0.5]}
//! {"t_ns": 2000000, "left": {"valid": false}, "right": {"dir": [0, 0, -1], "pupil_mm": 3.2}}
//! ```
//!
//! One sender is heard at a time, for two have two clocks: the first; another one when that has gone
//! (on UDP, when it has been silent for two seconds). What others send meanwhile is rejected, as is what
//! is no such object.
//!
//! From a shell, a sample for a socket `gaze.sock`, and one for port 5005:
//!
//! ```text
//! python3 -c 'import socket; s = socket.socket(socket.AF_UNIX); s.connect("gaze.sock"); s.sendall(b"{\"point\": [0.5, 0.5]}\n")'
//! python3 -c 'import socket; socket.socket(socket.AF_INET, socket.SOCK_DGRAM).sendto(b"{\"point\": [0.5, 0.5]}", ("127.0.0.1", 5005))'
//! ```

mod host;
mod inbox;
mod lines;
mod message;
mod socket;

pub use host::{Feeder, HostSource, SampleTime, host_source};
pub use message::parse;
pub use socket::{Bridge, BridgeSettings};

#[cfg(test)]
mod tests;
