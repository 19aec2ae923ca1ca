//! The project's own recordings: BIDS eye-tracking (physiological recordings of type `eyetrack`, known as
//! BEP020), with columns of its own for gaze in three dimensions.
//!
//! A recording is two files of one name: `NAME.tsv.gz`, rows without a header, and `NAME.json`, the
//! side-car that names the columns. `NAME` ends in `_physio`, and where this crate chooses it, in
//! `_recording-eye3_physio`.
//!
//! **One file for all eyes.** BIDS knows one file for each eye (`recording-eye1`, `recording-eye2`) and
//! `recording-eye3` for the gaze of both together. This crate writes only the last, with the eyes and
//! the head in further columns, because a sample is one row: a crash cannot part the eyes, both keep one
//! time, and a reader that knows BIDS alone still finds the gaze of both in the first three columns.
//!
//! **Columns.** `timestamp`, `x_coordinate` and `y_coordinate` come first, as BIDS demands. The others
//! are there only if some sample has a value in them, in the order in which they were first needed:
//!
//! | column | what | unit |
//! |---|---|---|
//! | `timestamp` | `time_ns`, host clock | s, nine decimals: whole ns |
//! | `received_time` | `received_ns`; where absent, equal to `timestamp` | s, nine decimals |
//! | `device_time` | `device_time_ns`; where absent, equal to `timestamp` | s, nine decimals |
//! | `x_coordinate`, `y_coordinate` | point on the display, right and down from its top left | 1: fraction |
//! | `pupil_size` | pupil diameter | mm |
//! | `gaze_valid` | 1 or 0 | |
//! | `gaze_confidence`, `gaze_openness` | as the source tells them | 1 |
//! | `gaze_origin_x`, `_y`, `_z` | origin of the ray, view space | m |
//! | `gaze_direction_x`, `_y`, `_z` | direction of the ray, view space, as told | 1 |
//! | `left_...`, `right_...` | the same of one eye, as in `left_x_coordinate`, `left_origin_x` | |
//! | `head_position_x` ... `head_rotation_w` | head pose in the world | m, 1 |
//!
//! Columns of a [`Recording`](crate::recording::Recording) that have no place in a sample follow under
//! their own names. Numbers are the shortest text that reads back to the same bits; `n/a` is no value.
//! The side-car's `MaculaRecording` holds what BIDS has no name for.
//!
//! **Events** that the recording's own software found lie beside it in `..._physioevents.tsv.gz` and its
//! side-car: `onset` and `duration` (s), `trial_type` (fixation, saccade, pursuit, blink, lost, unknown) and
//! `eye` (both, left, right).
//!
//! **A crash or a full disk.** [`Recorder`] ends a gzip member and has it written to the disk once a
//! second (a gzip file may consist of many members), and the side-car is there before the first row. So
//! an unfinished file lacks at most its last second and reads as any other. A column that is needed only
//! later is named in the side-car first; earlier rows are then shorter, which this crate reads, and
//! finishing fills them up.

mod columns;
mod events;
mod layout;
mod names;
mod plan;
mod reader;
mod recorder;
mod rows;
mod sidecar;
mod text;
mod write;

pub use events::paths as event_paths;
pub use names::paths;
pub(crate) use reader::{is_recording, read_input, read_path};
pub use recorder::Recorder;
pub use write::write_recording;

#[cfg(test)]
mod tests;
