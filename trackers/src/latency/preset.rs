//! The models that come with the crate.

use super::model::LatencyModel;
use crate::error::{Error, Result};
use std::path::Path;

macro_rules! presets {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_str!(concat!("presets/", $name, ".toml")))),*]
    };
}

/// Names and TOML texts, headsets first.
pub const PRESETS: [(&str, &str); 11] = presets![
    "fove-0",
    "vive-pro-eye",
    "varjo-aero",
    "varjo-xr-3",
    "pimax-crystal",
    "quest-pro",
    "psvr2",
    "pico-neo3",
    "tobii-eye-tracker-5-desktop",
    "pupil-neon",
    "generic-90hz",
];

/// The model of that name.
///
/// # Errors
/// [`Error::Setting`] with all names where there is none.
pub fn preset(name: &str) -> Result<LatencyModel> {
    let Some((name, text)) = PRESETS.iter().find(|(known, _)| *known == name) else {
        let names: Vec<&str> = PRESETS.iter().map(|(name, _)| *name).collect();
        let message = format!("there is no latency preset {name}; known are {}", names.join(", "));
        return Err(Error::Setting(message));
    };
    LatencyModel::from_toml(Path::new(name), text)
}
