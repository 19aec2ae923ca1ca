//! The columns' names and what the side-car says of them.

use crate::recording::COLUMNS;
use serde_json::{Value, json};

/// Names in the order of [`crate::recording::values_of`].
pub const NAMES: [&str; COLUMNS] = [
    "gaze_valid",
    "gaze_confidence",
    "pupil_size",
    "gaze_openness",
    "gaze_origin_x",
    "gaze_origin_y",
    "gaze_origin_z",
    "gaze_direction_x",
    "gaze_direction_y",
    "gaze_direction_z",
    "x_coordinate",
    "y_coordinate",
    "left_valid",
    "left_confidence",
    "left_pupil_size",
    "left_openness",
    "left_origin_x",
    "left_origin_y",
    "left_origin_z",
    "left_direction_x",
    "left_direction_y",
    "left_direction_z",
    "left_x_coordinate",
    "left_y_coordinate",
    "right_valid",
    "right_confidence",
    "right_pupil_size",
    "right_openness",
    "right_origin_x",
    "right_origin_y",
    "right_origin_z",
    "right_direction_x",
    "right_direction_y",
    "right_direction_z",
    "right_x_coordinate",
    "right_y_coordinate",
    "head_position_x",
    "head_position_y",
    "head_position_z",
    "head_rotation_x",
    "head_rotation_y",
    "head_rotation_z",
    "head_rotation_w",
];

pub const TIME: &str = "timestamp";
pub const RECEIVED: &str = "received_time";
pub const DEVICE: &str = "device_time";

/// Places in [`NAMES`], of the combined eye; the left is [`EYE`] further, the right twice that.
pub const VALID: usize = 0;
pub const PUPIL: usize = 2;
pub const DIRECTION_X: usize = 7;
pub const POINT_X: usize = 10;
pub const POINT_Y: usize = 11;
pub const EYE: usize = 12;

/// What a column of a recording holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    Time,
    Received,
    Device,
    /// One of [`NAMES`].
    Value(usize),
    /// One of the recording's extra columns.
    Extra(usize),
}

impl Column {
    /// The name, except of an extra column.
    pub fn name(self) -> Option<&'static str> {
        match self {
            Self::Time => Some(TIME),
            Self::Received => Some(RECEIVED),
            Self::Device => Some(DEVICE),
            Self::Value(index) => NAMES.get(index).copied(),
            Self::Extra(_) => None,
        }
    }

    /// The side-car's description.
    pub fn description(self) -> Value {
        match self {
            Self::Time => json!({
                "Description": "Time at which the eye was like this, on the host clock",
                "Units": "s",
            }),
            Self::Received => json!({
                "Description": "Time at which the host received the sample, on the host clock",
                "Units": "s",
            }),
            Self::Device => json!({
                "Description": "Time that the device gave, on its own clock, unwrapped",
                "Units": "s",
            }),
            Self::Value(index) => described(NAMES.get(index).copied().unwrap_or_default()),
            Self::Extra(_) => json!({ "Description": "As in the recording this was made from" }),
        }
    }
}

fn described(name: &str) -> Value {
    let whose = match name.split('_').next() {
        Some("left") => "left eye",
        Some("right") => "right eye",
        Some("head") => "head",
        _ => "both eyes together",
    };
    let told = |what: &str, units: &str| json!({ "Description": format!("{what}, {whose}"), "Units": units });
    if name.ends_with("_valid") {
        let levels = json!({ "0": "The gaze cannot be used", "1": "The gaze can be used" });
        return json!({ "Description": format!("Validity as the source says it, {whose}"), "Levels": levels });
    }
    if name.ends_with("confidence") {
        told("Confidence as the source tells it", "1")
    } else if name.ends_with("pupil_size") {
        told("Pupil diameter", "mm")
    } else if name.ends_with("openness") {
        told("How far the lids are open, 0 closed to 1 open", "1")
    } else if name.contains("_origin_") {
        told("Origin of the gaze ray in view space (x right, y up, z backwards)", "m")
    } else if name.contains("_direction_") {
        told("Direction of the gaze ray in view space (x right, y up, z backwards), as told", "1")
    } else if name.ends_with("x_coordinate") {
        told("Gaze point as a fraction of the display's width, from its left edge", "1")
    } else if name.ends_with("y_coordinate") {
        told("Gaze point as a fraction of the display's height, from its top edge", "1")
    } else if name.starts_with("head_position") {
        told("Position in the world (right-handed, y up)", "m")
    } else {
        told("Quaternion that turns view space into the world", "1")
    }
}

/// The columns' names: extra ones get another where theirs is taken.
pub fn names(columns: &[Column], extra: &[String]) -> Vec<String> {
    columns
        .iter()
        .map(|column| match column {
            Column::Extra(index) => extra_name(*index, extra),
            other => other.name().unwrap_or_default().to_owned(),
        })
        .collect()
}

fn extra_name(index: usize, extra: &[String]) -> String {
    let Some(name) = extra.get(index) else { return String::new() };
    let taken = NAMES.contains(&name.as_str())
        || [TIME, RECEIVED, DEVICE].contains(&name.as_str())
        || extra[..index].contains(name)
        || name.starts_with("extra_")
        // The side-car's own keys, which are written in capitals.
        || name.starts_with(|first: char| first.is_ascii_uppercase())
        || name.is_empty();
    if taken { format!("extra_{index}_{name}") } else { name.clone() }
}
