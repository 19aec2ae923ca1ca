//! BIDS eye-tracking: see [`crate::bids`], which also writes it.

use super::Format;
pub(super) use crate::bids::{is_recording, read_path};

/// Recognised by its name and side-car: rows without a header tell nothing.
pub(super) const FORMAT: Format =
    Format { name: "bids", matches: |input, _| is_recording(&input.path), read: crate::bids::read_input };
