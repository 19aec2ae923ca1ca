//! The side-car: written for our recordings, read for anybody's.

use super::columns::{Column, names};
use super::names::{sidecars, stem};
use crate::error::{Error, Result};
use crate::recording::{RecordingInfo, Screen, Skipped, Space};
use glam::DVec2;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;

/// The most bytes of a side-car, and the most columns in one.
const MAX_BYTES: u64 = 4 << 20;
const MAX_COLUMNS: usize = 1000;

/// What BIDS has no name for.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(default, rename_all = "PascalCase")]
pub struct Own {
    pub version: u32,
    /// The recording was ended, not broken off.
    pub finished: bool,
    pub space: String,
    pub device: String,
    pub device_clock: String,
    pub nominal_rate_hz: Option<f64>,
    pub screen: Option<OwnScreen>,
    /// Column and original name.
    pub extra: Vec<(String, String)>,
    pub skipped: Vec<OwnSkipped>,
    pub notes: Vec<String>,
    /// How many events lie beside it.
    pub events: u64,
    /// The format this was converted from.
    pub source_format: String,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "PascalCase")]
pub struct OwnScreen {
    size_px: [f64; 2],
    size_m: [f64; 2],
    distance_m: f64,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "PascalCase")]
pub struct OwnSkipped {
    rows: u64,
    why: String,
}

/// The names of [`Space`] in BIDS; the last is free.
fn coordinate_system(space: Space) -> &'static str {
    match space {
        Space::View => "eye-in-head",
        Space::Display => "gaze-on-screen",
        Space::SceneCamera | Space::Unknown => "custom",
    }
}

/// The text of the side-car of our recording.
pub fn written(info: &RecordingInfo, columns: &[Column], extra: &[String], ending: Ending) -> String {
    let (finished, measured, events) = match ending {
        Ending::Unfinished => (false, None, 0),
        Ending::Finished { rate_hz, events } => (true, rate_hz, events),
    };
    let names = names(columns, extra);
    let extra = columns.iter().zip(&names).filter_map(|(column, name)| match column {
        Column::Extra(index) => Some((name.clone(), extra.get(*index)?.clone())),
        _ => None,
    });
    let own = Own {
        version: 1,
        finished,
        space: info.space.name().to_owned(),
        device: info.device.clone(),
        device_clock: info.device_clock.clone(),
        nominal_rate_hz: info.nominal_rate_hz.filter(|rate| rate.is_finite()),
        screen: info.screen.and_then(OwnScreen::of),
        extra: extra.collect(),
        skipped: info
            .skipped
            .iter()
            .map(|skipped| OwnSkipped { rows: skipped.rows, why: skipped.why.clone() })
            .collect(),
        notes: info.notes.clone(),
        events,
        source_format: info.format.to_owned(),
    };
    let rate = own.nominal_rate_hz.or(measured.filter(|rate| rate.is_finite()));
    let mut keys = Map::new();
    let mut set = |key: &str, value: Value| keys.insert(key.to_owned(), value);
    set("PhysioType", json!("eyetrack"));
    set("Columns", json!(names));
    set("SamplingFrequency", rate.map_or(json!("n/a"), |rate| json!(rate)));
    set("StartTime", json!(0));
    set("RecordedEye", json!("cyclopean"));
    set("SampleCoordinateSystem", json!(coordinate_system(info.space)));
    set("EnvironmentCoordinates", json!("top-left"));
    if !info.device.is_empty() {
        set("ManufacturersModelName", json!(info.device));
    }
    if let Some(screen) = &own.screen {
        let presentation = json!({
            "ScreenResolution": screen.size_px,
            "ScreenSize": screen.size_m,
            "ScreenDistance": screen.distance_m,
        });
        set("StimulusPresentation", presentation);
    }
    for (column, name) in columns.iter().zip(&names) {
        set(name, column.description());
    }
    // The structures above hold nothing that JSON cannot.
    set("MaculaRecording", serde_json::to_value(own).unwrap_or_default());
    let mut text = serde_json::to_string_pretty(&keys).unwrap_or_default();
    text.push('\n');
    text
}

/// Whether a recording goes on.
#[derive(Clone, Copy, Debug)]
pub enum Ending {
    Unfinished,
    Finished {
        /// As measured over the recording.
        rate_hz: Option<f64>,
        /// How many events lie beside it.
        events: u64,
    },
}

/// Writes a file so that at any time either the old or the new content is there, whole.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<()> {
    let io = |source| Error::io(path, source);
    let folder = folder_of(path);
    let mut file = temporary(folder).map_err(io)?;
    file.write_all(content).map_err(io)?;
    file.as_file().sync_all().map_err(io)?;
    file.persist(path).map_err(|error| io(error.error))?;
    // The name too, and with it that of a data file which has just been made beside it.
    File::open(folder).and_then(|folder| folder.sync_all()).map_err(io)
}

/// The folder that a file lies in.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A temporary file that gets the usual access rights when it is kept.
pub fn temporary(folder: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    use std::os::unix::fs::PermissionsExt;
    // What the process's mask leaves of it.
    let rights = std::fs::Permissions::from_mode(0o666);
    tempfile::Builder::new().prefix(".recording-").permissions(rights).tempfile_in(folder)
}

impl OwnScreen {
    fn of(screen: Screen) -> Option<Self> {
        let Screen { size_px, size_m, distance_m } = screen;
        let finite = size_px.is_finite() && size_m.is_finite() && distance_m.is_finite();
        finite.then_some(Self { size_px: size_px.to_array(), size_m: size_m.to_array(), distance_m })
    }
}

/// What is known of a data file from all side-cars that apply to it.
#[derive(Debug)]
pub struct Sidecar {
    keys: Map<String, Value>,
    pub columns: Vec<String>,
    pub own: Option<Own>,
    pub screen: Presentation,
}

/// What a data set says of its display.
#[derive(Clone, Copy, Debug, Default)]
pub struct Presentation {
    pub size_px: Option<DVec2>,
    pub size_m: Option<DVec2>,
    pub distance_m: Option<f64>,
}

impl Sidecar {
    /// Of a data file.
    ///
    /// # Errors
    /// A side-car is broken, or none names the columns.
    pub fn of(data: &Path) -> Result<Self> {
        let mut keys = Map::new();
        for path in sidecars(data, "physio") {
            keys.extend(read_object(&path)?);
        }
        let mut presentation = keys.get("StimulusPresentation").cloned();
        for suffix in ["physioevents", "events"] {
            for path in sidecars(data, suffix) {
                let events = read_object(&path)?;
                presentation = presentation.or_else(|| events.get("StimulusPresentation").cloned());
            }
        }
        // A pair that is not named as BIDS would have it.
        let name = data.file_name().unwrap_or_default().to_string_lossy();
        let beside = data.with_file_name(format!("{}.json", stem(&name).unwrap_or(&name)));
        if keys.is_empty() {
            if !beside.exists() {
                let cause = format!(
                    "has no side-car {}, which would name its columns; put it beside",
                    beside.file_name().unwrap_or_default().to_string_lossy()
                );
                return Err(Error::file(data, cause));
            }
            keys = read_object(&beside)?;
        }
        Self::of_keys(&beside, keys, presentation.as_ref())
    }

    /// Of the keys of a side-car.
    ///
    /// # Errors
    /// It does not name the columns.
    pub fn of_keys(path: &Path, keys: Map<String, Value>, presentation: Option<&Value>) -> Result<Self> {
        let listed = keys.get("Columns").and_then(Value::as_array);
        let columns: Option<Vec<String>> =
            listed.map(|names| names.iter().filter_map(Value::as_str).map(str::to_owned).collect());
        let columns = match (listed, columns) {
            (Some(listed), Some(columns))
                if listed.len() == columns.len() && (1..=MAX_COLUMNS).contains(&columns.len()) =>
            {
                columns
            }
            _ => return Err(Error::file(path, "has no list of 1 to 1000 names as Columns; add it")),
        };
        let own = match keys.get("MaculaRecording") {
            None => None,
            Some(value) => Some(
                Own::deserialize(value)
                    .map_err(|error| Error::file(path, format!("MaculaRecording is broken: {error}")))?,
            ),
        };
        let screen = Presentation::of(presentation);
        Ok(Self { keys, columns, own, screen })
    }

    /// A key's text.
    pub fn text(&self, key: &str) -> &str {
        self.keys.get(key).and_then(Value::as_str).unwrap_or_default()
    }

    /// A key's number, also where it is written as text.
    pub fn number(&self, key: &str) -> Option<f64> {
        let value = self.keys.get(key)?;
        value.as_f64().or_else(|| value.as_str()?.trim().parse().ok()).filter(|number| number.is_finite())
    }

    /// The unit of a column, as written.
    pub fn units(&self, column: &str) -> &str {
        self.keys
            .get(column)
            .and_then(|column| column.get("Units"))
            .and_then(Value::as_str)
            .unwrap_or_default()
    }

    /// What our own side-car says of the recording.
    pub fn own_info(own: &Own) -> RecordingInfo {
        let spaces = [Space::View, Space::Display, Space::SceneCamera];
        RecordingInfo {
            format: "bids",
            device: own.device.clone(),
            space: spaces.into_iter().find(|space| space.name() == own.space).unwrap_or_default(),
            nominal_rate_hz: own.nominal_rate_hz,
            screen: own.screen.as_ref().map(|screen| Screen {
                size_px: DVec2::from_array(screen.size_px),
                size_m: DVec2::from_array(screen.size_m),
                distance_m: screen.distance_m,
            }),
            device_clock: own.device_clock.clone(),
            skipped: own
                .skipped
                .iter()
                .map(|skipped| Skipped { rows: skipped.rows, why: skipped.why.clone() })
                .collect(),
            notes: own.notes.clone(),
        }
    }
}

impl Presentation {
    fn of(value: Option<&Value>) -> Self {
        let number = |key: &str| value?.get(key)?.as_f64().filter(|number| *number > 0.0);
        let pair = |key: &str| {
            let pair = value?.get(key)?.as_array()?;
            let size = DVec2::new(pair.first()?.as_f64()?, pair.get(1)?.as_f64()?);
            (size.is_finite() && size.min_element() > 0.0).then_some(size)
        };
        Self {
            size_px: pair("ScreenResolution"),
            size_m: pair("ScreenSize"),
            distance_m: number("ScreenDistance"),
        }
    }
}

/// The object in a JSON file, which may begin with a byte order mark.
pub fn read_object(path: &Path) -> Result<Map<String, Value>> {
    let io = |source| Error::io(path, source);
    let mut bytes = Vec::new();
    File::open(path).map_err(io)?.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(Error::file(path, format!("is longer than {MAX_BYTES} bytes, so no side-car")));
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
    serde_json::from_slice(bytes)
        .map_err(|error| Error::file(path, format!("is no side-car, a JSON object: {error}")))
}
