//! The events of a recording: `NAME_physioevents.tsv.gz` and its side-car, as BIDS has them beside the
//! samples.

use super::names::stem;
use super::recorder::{beside, ended};
use super::sidecar::write_whole;
use super::text::{time_ns, write_seconds};
use crate::EyeState;
use crate::error::{Error, Result};
use crate::recording::{EventEye, RecordedEvent, Recording};
use flate2::read::MultiGzDecoder;
use serde_json::json;
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

/// The most bytes of events, decompressed: several million of them.
const MAX_BYTES: u64 = 256 << 20;
const KINDS: [EyeState; 6] = [
    EyeState::Fixation,
    EyeState::Saccade,
    EyeState::Pursuit,
    EyeState::Blink,
    EyeState::Lost,
    EyeState::Unknown,
];
const EYES: [(EventEye, &str); 3] =
    [(EventEye::Both, "both"), (EventEye::Left, "left"), (EventEye::Right, "right")];

/// The files of the events that belong to a data file, and their side-car: `..._physioevents.tsv.gz` and
/// `..._physioevents.json`.
#[must_use]
pub fn paths(data: &Path) -> (PathBuf, PathBuf) {
    let name = data.file_name().unwrap_or_default().to_string_lossy();
    let stem = stem(&name).unwrap_or(&name);
    let stem = format!("{}_physioevents", stem.strip_suffix("_physio").unwrap_or(stem));
    (data.with_file_name(format!("{stem}.tsv.gz")), data.with_file_name(format!("{stem}.json")))
}

/// Writes the events beside the data file, or removes what an earlier recording of the name left there.
///
/// # Errors
/// [`Error::Io`].
pub fn write(events: &[RecordedEvent], data: &Path) -> Result<()> {
    let (path, sidecar) = paths(data);
    for old in [&path, &sidecar] {
        match std::fs::remove_file(old) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(Error::io(old, error)),
            _ => {}
        }
    }
    if events.is_empty() {
        return Ok(());
    }
    write_whole(&sidecar, described().as_bytes())?;
    let io = |error| Error::io(&path, error);
    let mut encoder = beside(&path).map_err(io)?;
    let mut row = Vec::new();
    for event in events {
        row.clear();
        write_seconds(&mut row, event.start_ns);
        row.push(b'\t');
        write_seconds(&mut row, event.end_ns.saturating_sub(event.start_ns));
        let eye = EYES.iter().find(|(eye, _)| *eye == event.eye).map_or("n/a", |(_, name)| name);
        row.extend_from_slice(format!("\t{}\t{eye}\n", event.kind.name()).as_bytes());
        encoder.write_all(&row).map_err(io)?;
    }
    ended(encoder).map_err(io)?.persist(&path).map_err(|error| io(error.error))?;
    Ok(())
}

fn described() -> String {
    let levels = json!({
        "fixation": "The eye rests on one place",
        "saccade": "The eye jumps to another place",
        "pursuit": "The eye follows what moves",
        "blink": "The lids are closed",
        "lost": "The tracker does not see the eye",
        "unknown": "It was not said what the eye does",
    });
    let described = json!({
        "Columns": ["onset", "duration", "trial_type", "eye"],
        "Description": "Events as the software that made the recording found them",
        "OnsetSource": "timestamp",
        "onset": { "Description": "Time of the first sample", "Units": "s" },
        "duration": { "Description": "From the first to the last sample", "Units": "s" },
        "trial_type": { "Description": "What the eye does", "Levels": levels },
        "eye": {
            "Description": "Whose event it is",
            "Levels": { "both": "Of both eyes, or not said", "left": "Left", "right": "Right" },
        },
    });
    // It holds nothing that JSON cannot.
    serde_json::to_string_pretty(&described).unwrap_or_default() + "\n"
}

/// Reads the `expected` events of our own recording; what is missing of them counts as skipped.
pub fn read(recording: &mut Recording, data: &Path, expected: u64) {
    let (path, _) = paths(data);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let mut text = Vec::new();
    let unpacked =
        File::open(&path).and_then(|file| MultiGzDecoder::new(file).take(MAX_BYTES).read_to_end(&mut text));
    // A row without its line end was cut, maybe within a number.
    let whole = memchr::memrchr(b'\n', &text).map_or(0, |end| end + 1);
    let rows = text[..whole].split(|byte| *byte == b'\n').filter(|row| !row.is_empty());
    recording.events = rows.filter_map(event).collect();
    let missing = expected.saturating_sub(recording.events.len() as u64);
    let why = match unpacked {
        Err(error) => format!("events that {name} should tell: {error}"),
        Ok(_) => format!("events that {name} should tell, but does not"),
    };
    recording.skip_any(missing, &why);
}

fn event(row: &[u8]) -> Option<RecordedEvent> {
    let mut fields = row.split(|byte| *byte == b'\t');
    let mut seconds = || {
        let field = fields.next()?;
        time_ns(field, 9).filter(|(_, end)| *end == field.len()).map(|(time_ns, _)| time_ns)
    };
    let (start_ns, duration_ns) = (seconds()?, seconds()?);
    let kind = fields.next()?;
    let kind = KINDS.into_iter().find(|known| known.name().as_bytes() == kind)?;
    let eye = fields.next()?;
    let (eye, _) = EYES.into_iter().find(|(_, name)| name.as_bytes() == eye)?;
    Some(RecordedEvent { kind, start_ns, end_ns: start_ns.checked_add(duration_ns)?, eye })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bids::write_recording;
    use crate::formats::{ReadOptions, read};
    use crate::recording::RecordingInfo;
    use crate::sample::GazeSample;

    fn recording() -> Recording {
        let mut recording = Recording::new(RecordingInfo::default());
        recording.push(&GazeSample::at(5));
        let event = |kind, start_ns, end_ns, eye| RecordedEvent { kind, start_ns, end_ns, eye };
        recording.events = vec![
            event(EyeState::Fixation, -1_500_000_001, 20, EventEye::Both),
            event(EyeState::Saccade, 20, 45_000_000, EventEye::Left),
            event(EyeState::Blink, 30, 30, EventEye::Right),
        ];
        recording
    }

    fn load(path: &Path) -> Recording {
        read(path, &ReadOptions::default()).expect("a recording")
    }

    #[test]
    fn events_come_back_and_are_bids() {
        let folder = tempfile::tempdir().expect("a folder");
        let data = write_recording(&recording(), &folder.path().join("sub-1")).expect("written");
        assert_eq!(load(&data).events, recording().events);
        let path = folder.path().join("sub-1_recording-eye3_physioevents.tsv.gz");
        let mut text = String::new();
        let file = File::open(&path).expect("beside the samples");
        MultiGzDecoder::new(file).read_to_string(&mut text).expect("gzip");
        let expected = "-1.500000001\t1.500000021\tfixation\tboth\n\
                        0.000000020\t0.044999980\tsaccade\tleft\n\
                        0.000000030\t0.000000000\tblink\tright\n";
        assert_eq!(text, expected);
        let sidecar = std::fs::read(path.with_file_name("sub-1_recording-eye3_physioevents.json"));
        let sidecar: serde_json::Value = serde_json::from_slice(&sidecar.expect("there")).expect("JSON");
        assert_eq!(sidecar["Columns"], json!(["onset", "duration", "trial_type", "eye"]));
        assert_eq!(sidecar["OnsetSource"], "timestamp");
        // What has none leaves none behind.
        let mut without = recording();
        without.events.clear();
        write_recording(&without, &data).expect("written");
        assert!(!path.exists() && load(&data).events.is_empty());
    }

    #[test]
    fn events_that_are_gone_are_told() {
        let folder = tempfile::tempdir().expect("a folder");
        let data = write_recording(&recording(), &folder.path().join("x.tsv.gz")).expect("written");
        let (path, _) = paths(&data);
        assert_eq!(path.file_name().and_then(|name| name.to_str()), Some("x_physioevents.tsv.gz"));
        let packed = |text: &str| {
            let mut encoder = beside(&path).expect("a file");
            encoder.write_all(text.as_bytes()).expect("written");
            ended(encoder).expect("on the disk").persist(&path).expect("written");
        };
        for (text, left) in [
            ("1.0\t0.5\tsaccade\tboth\n", 1),
            ("1.0\t0.5\tsaccade\tboth\n2.0\t0.5\tsaccade\tbo", 1),
            ("1.0\t0.5\tleap\tboth\n1.0x\t0.5\tblink\tboth\n\t\t\n1.0\n", 0),
            ("9223372036.8\t9223372036.8\tblink\tboth\n", 0),
        ] {
            packed(text);
            let read = load(&data);
            assert_eq!((read.len(), read.events.len()), (1, left), "{text}");
            assert_eq!(read.info.skipped.iter().map(|skipped| skipped.rows).sum::<u64>(), 3 - left as u64);
        }
        std::fs::write(&path, b"no gzip").expect("written");
        assert!(load(&data).events.is_empty());
        std::fs::remove_file(&path).expect("removed");
        let read = load(&data);
        assert!(read.events.is_empty() && read.info.skipped[0].why.contains("x_physioevents.tsv.gz"));
    }
}
