//! The folder that a Pupil Labs Companion phone records, of Neon and Invisible: `gaze ps1.raw` with the
//! gaze in px of the scene camera and `gaze ps1.time` with the times, continued in `ps2` and so on; or
//! `gaze_200hz`, computed afterwards at the full rate. Beside them may lie `eye_state`, `worn`,
//! `fixations` and `blinks`, and a `.dtype` for each that names the fields of a record.
//!
//! The raw files have no mark to know them by, so this format alone is recognised by the names: any of
//! the gaze files, `info.json` or the folder can be given. Times are UTC in ns. Eyes are told in mm in the
//! frame of the scene camera, as their values show: x right, y down, z forward. Directions are optical
//! axes, which differ from the line of sight by a few degrees that are the wearer's own.

mod record;

use super::rows::Extras;
use super::{Format, Input, MAX_BYTES, ReadOptions};
use crate::EyeState;
use crate::error::{Error, Result};
use crate::recording::{EventEye, RecordedEvent, Recording, RecordingInfo, Space};
use crate::sample::{EyeSample, GazeSample};
use glam::{DVec2, DVec3};
use record::{Field, Layout, Part, Series};
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::fs;
use std::path::{Path, PathBuf};

/// The format.
pub const FORMAT: Format = Format { name: "neon-native", matches, read };

/// Eye state and worn belong to a gaze sample up to this far away, ns: half a period at 200 Hz. Larger
/// gives a sample the eyes of its neighbour where its own are missing.
const SAME_SAMPLE_NS: u64 = 2_500_000;
/// Sizes of the scene pictures by Pupil Labs' documentation; no file of the recording tells them.
const NEON_PX: DVec2 = DVec2::new(1600.0, 1200.0);
const INVISIBLE_PX: DVec2 = DVec2::new(1088.0, 1080.0);
/// Fields of the eye state that have no place in a sample.
const EYE_COLUMNS: [&str; 6] = [
    "eyelid_angle_top_left",
    "eyelid_angle_bottom_left",
    "eyelid_aperture_left_mm",
    "eyelid_angle_top_right",
    "eyelid_angle_bottom_right",
    "eyelid_aperture_right_mm",
];

/// What `info.json` tells.
#[derive(Default, Deserialize)]
struct Info {
    android_device_name: Option<String>,
    module_serial_number: Option<IgnoredAny>,
    glasses_serial_number: Option<IgnoredAny>,
    gaze_frequency: Option<f64>,
}

/// The folder with the names in it.
struct Folder {
    path: PathBuf,
    names: Vec<String>,
}

fn matches(input: &Input, head: &str) -> bool {
    let Some(name) = input.path.file_name().and_then(|name| name.to_str()) else { return false };
    let gaze = gaze_stem(name).is_some() && [".raw", ".time", ".dtype"].iter().any(|end| name.ends_with(end));
    let told = gaze || name == "info.json" && head.contains("\"data_format_version\"");
    told && Folder::of(&input.path).is_some_and(|folder| folder.has_gaze())
}

/// Of a folder that holds such a recording, the file to give to [`read`].
pub(super) fn file_in(path: &Path) -> Option<PathBuf> {
    let folder = Folder::of(&path.join("info.json"))?;
    let gaze = folder.names.iter().find(|name| name.ends_with(".raw") && gaze_stem(name).is_some())?;
    let info = folder.names.iter().any(|name| name == "info.json");
    Some(path.join(if info { "info.json" } else { gaze }))
}

/// `gaze` or `gaze_200hz`, where a file name is one of theirs.
fn gaze_stem(name: &str) -> Option<&'static str> {
    let stem = name.rsplit_once('.')?.0;
    match stem {
        "gaze_200hz" => Some("gaze_200hz"),
        _ if stem == "gaze" || stem.starts_with("gaze ps") => Some("gaze"),
        _ => None,
    }
}

impl Folder {
    /// The folder that a file lies in.
    fn of(file: &Path) -> Option<Self> {
        let parent = file.parent()?;
        let path = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
        let names = fs::read_dir(path).ok()?.flatten();
        let mut names: Vec<_> = names.filter_map(|entry| entry.file_name().into_string().ok()).collect();
        names.sort_unstable();
        Some(Self { path: path.to_owned(), names })
    }

    fn has_gaze(&self) -> bool {
        ["gaze", "gaze_200hz"].iter().any(|stem| !self.parts(stem).is_empty())
    }

    /// The parts of a series: the names of its raw files without `.raw`, in order.
    fn parts(&self, stem: &str) -> Vec<&str> {
        let number = |name: &str| match name.strip_prefix(stem)? {
            "" => Some(0),
            rest => rest.strip_prefix(" ps")?.parse::<u64>().ok(),
        };
        let bases = self.names.iter().filter_map(|name| name.strip_suffix(".raw"));
        let mut parts: Vec<_> = bases.filter_map(|base| Some((number(base)?, base))).collect();
        parts.sort_unstable();
        parts.into_iter().map(|(_, base)| base).collect()
    }

    /// A file's bytes; never unpacked, as any bytes may be a record. `None` where it is absent.
    fn bytes(&self, name: &str) -> Result<Option<Vec<u8>>> {
        if !self.names.iter().any(|known| known == name) {
            return Ok(None);
        }
        let path = self.path.join(name);
        let size = fs::metadata(&path).map_err(|error| Error::io(&path, error))?.len();
        if size > MAX_BYTES {
            return Err(Error::file(&path, format!("is larger than {MAX_BYTES} bytes")));
        }
        fs::read(&path).map(Some).map_err(|error| Error::io(&path, error))
    }

    /// A series with all its parts. `timed_by` is the series whose times it has where it has none.
    fn series(&self, stem: &str, timed_by: &str, recording: &mut Recording) -> Result<Series> {
        let told = self.bytes(&format!("{stem}.dtype"))?;
        let told = told.map(|bytes| Layout::of(&String::from_utf8_lossy(&bytes)));
        let layout = match (told, stem) {
            (Some(Some(layout)), _) => layout,
            // Invisible has no `.dtype`, and `gaze_200hz` is like `gaze`.
            (_, "gaze" | "gaze_200hz") => Layout::of_floats(&["x", "y"]),
            (Some(None), _) => {
                recording.info.notes.push(format!("{stem}.dtype cannot be understood; it was not read"));
                return Ok(Series::default());
            }
            (None, _) => return Ok(Series::default()),
        };
        let mut series = Series::new(layout);
        for base in self.parts(stem) {
            let raw = self.bytes(&format!("{base}.raw"))?.unwrap_or_default();
            let timed = base.replacen(stem, timed_by, 1);
            let time = match self.bytes(&format!("{base}.time"))? {
                Some(time) => Some(time),
                None => self.bytes(&format!("{timed}.time"))?,
            };
            let Some(time) = time else {
                recording.skip(0, format!("{base}.time is missing, so {base}.raw was not read"));
                continue;
            };
            let rest = series.add(Part { raw: &raw, time: &time });
            recording
                .skip_any(rest.unpaired, &format!("{base}: records without a time, or times without one"));
            recording.skip_any(rest.cut, &format!("{base}: a record or time at the end is cut off"));
        }
        Ok(series)
    }
}

/// From x right, y down, z forward to view space.
fn view_of(values: [f64; 3]) -> Option<DVec3> {
    let [x, y, z] = values;
    let vector = DVec3::new(x, -y, -z);
    (!vector.is_nan()).then_some(vector)
}

/// The fields of one eye in the eye state.
struct EyeFields {
    origin: [Option<Field>; 3],
    direction: [Option<Field>; 3],
    pupil: Option<Field>,
}

impl EyeFields {
    fn of(series: &Series, side: &str) -> Self {
        let vector = |name: &str| ["x", "y", "z"].map(|axis| series.field(&format!("{name}_{side}_{axis}")));
        Self {
            origin: vector("eyeball_center"),
            direction: vector("optical_axis"),
            pupil: series.field(&format!("pupil_diameter_{side}_mm")),
        }
    }

    fn eye(&self, series: &Series, index: usize, worn: bool) -> EyeSample {
        let vector = |fields: [Option<Field>; 3]| view_of(fields.map(|field| series.value(index, field)));
        let direction = vector(self.direction);
        let pupil_mm = series.value(index, self.pupil);
        EyeSample {
            valid: worn && direction.is_some(),
            origin_m: vector(self.origin).map(|mm| mm * 1e-3),
            direction,
            pupil_mm: (!pupil_mm.is_nan()).then_some(pupil_mm),
            ..EyeSample::default()
        }
    }
}

/// Eye movements that the phone found, by the numbers of Pupil Labs' real-time interface.
fn events_of(series: &Series) -> impl Iterator<Item = RecordedEvent> + '_ {
    let fields = ["event_type", "start_timestamp_ns", "end_timestamp_ns"].map(|name| series.field(name));
    (0..series.times_ns.len()).filter_map(move |index| {
        let [number, start_ns, end_ns] = fields.map(|field| series.integer(index, field));
        let kind = match number? {
            0 => EyeState::Saccade,
            1 => EyeState::Fixation,
            4 => EyeState::Blink,
            _ => return None,
        };
        Some(RecordedEvent { kind, start_ns: start_ns?, end_ns: end_ns?, eye: EventEye::Both })
    })
}

fn info_of(folder: &Folder, stem: &str, options: &ReadOptions) -> Result<(RecordingInfo, Option<DVec2>)> {
    let bytes = folder.bytes("info.json")?.unwrap_or_default();
    let info: Info = serde_json::from_slice(&bytes).unwrap_or_default();
    let name = info.android_device_name.unwrap_or_default();
    let (device, size_px) = if name.contains("Neon") || info.module_serial_number.is_some() {
        ("Pupil Labs Neon", Some(NEON_PX))
    } else if name.contains("Invisible") || info.glasses_serial_number.is_some() {
        ("Pupil Labs Invisible", Some(INVISIBLE_PX))
    } else {
        ("Pupil Labs", options.screen.map(|screen| screen.size_px))
    };
    let points = match size_px {
        Some(size) => format!("the scene picture is taken as {} x {} px, as of this device", size.x, size.y),
        None => "info.json does not say whose it is, so gaze is only told in px; give the screen".into(),
    };
    let read = format!("read was {stem}; directions are optical axes, not lines of sight");
    let info = RecordingInfo {
        device: device.into(),
        space: Space::SceneCamera,
        nominal_rate_hz: info.gaze_frequency.filter(|rate| *rate > 0.0),
        device_clock: "UTC (ns)".into(),
        notes: vec![points, read],
        ..RecordingInfo::default()
    };
    Ok((info, size_px))
}

fn read(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let folder = Folder::of(&input.path)
        .ok_or_else(|| Error::file(&input.path, "lies in no folder; give a recording on disk"))?;
    let named = input.path.file_name().and_then(|name| gaze_stem(name.to_str()?));
    let asked = named.filter(|_| input.path.extension().is_none_or(|extension| extension != "dtype"));
    let full = !folder.parts("gaze_200hz").is_empty();
    let stem = asked.unwrap_or(if full { "gaze_200hz" } else { "gaze" });
    let (info, size_px) = info_of(&folder, stem, options)?;
    let mut recording = Recording::new(info);
    let gaze = folder.series(stem, stem, &mut recording)?;
    if gaze.times_ns.is_empty() {
        let cause = format!("{stem}: no record with a time; the .raw and .time files belong together");
        return Err(Error::file(&input.path, cause));
    }
    let eyes = folder.series("eye_state", "eye_state", &mut recording)?;
    let worn = folder.series("worn", "gaze", &mut recording)?;
    let [x, y] = ["x", "y"].map(|name| gaze.field(name));
    let [left, right] = ["left", "right"].map(|side| EyeFields::of(&eyes, side));
    let (is_worn, lids) = (worn.field("worn"), EYE_COLUMNS.map(|name| eyes.field(name)));
    let mut extras = Extras::new(["x_px", "y_px"].into_iter().chain(EYE_COLUMNS));
    for (index, &time_ns) in gaze.times_ns.iter().enumerate() {
        let at_px = DVec2::new(gaze.value(index, x), gaze.value(index, y));
        let told = worn.nearest(time_ns, SAME_SAMPLE_NS).and_then(|at| worn.integer(at, is_worn));
        let is_worn = told.is_none_or(|told| told > 0);
        let mut sample = GazeSample::at(time_ns);
        sample.combined.valid = is_worn && at_px.is_finite();
        sample.combined.point = size_px.map(|size| at_px / size).filter(|point| !point.is_nan());
        extras.set(0, index, at_px.x);
        extras.set(1, index, at_px.y);
        if let Some(at) = eyes.nearest(time_ns, SAME_SAMPLE_NS) {
            sample.left = left.eye(&eyes, at, is_worn);
            sample.right = right.eye(&eyes, at, is_worn);
            for (column, field) in (2..).zip(lids) {
                extras.set(column, index, eyes.value(at, field));
            }
        }
        recording.push(&sample);
    }
    extras.finish(&mut recording);
    for stem in ["fixations", "blinks"] {
        let series = folder.series(stem, stem, &mut recording)?;
        recording.events.extend(events_of(&series));
    }
    Ok(recording)
}

#[cfg(test)]
mod tests;
