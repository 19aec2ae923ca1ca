//! Files that lie beside recordings and hold no samples: what they are, and what to give instead.

use super::table::has_header;
use super::{Input, neon_native};

/// Tables, by columns that they have; the more particular first.
const TABLES: &[(&[&str], &str)] = &[
    (
        &["blink id", "start timestamp [ns]"],
        "holds the blinks that Pupil found, no gaze; give gaze.csv of the same folder",
    ),
    (
        &["fixation id", "start timestamp [ns]"],
        "holds the fixations that Pupil found, no gaze; give gaze.csv of the same folder",
    ),
    (
        &["saccade id", "start timestamp [ns]"],
        "holds the saccades that Pupil found, no gaze; give gaze.csv of the same folder",
    ),
    (&["gyro x", "acceleration x"], "holds motion of the head, no gaze; give gaze.csv of the same folder"),
    (&["recording id", "timestamp [ns]", "name"], "holds events, no gaze; give gaze.csv of the same folder"),
    (&["timestamp [ns]"], "holds times or states but no gaze; give gaze.csv of the same folder"),
    (
        &["pupil_timestamp", "eye_id", "diameter"],
        "holds pupils in the eye cameras, no gaze; give gaze_positions.csv of the same folder",
    ),
    (
        &["start_timestamp", "duration"],
        "holds the events that Pupil Player found, no gaze; give gaze_positions.csv of the same folder",
    ),
    (
        &["acc_valid_mean", "user"],
        "is a summary with a line for each person, without samples; give a recording",
    ),
    (
        &["eye_tracker", "rmsi", "session"],
        "is a summary with a line for each validation, without samples; give a recording",
    ),
    (
        &["avgx", "avgy", "offx"],
        "is a summary with a line for each target, without samples; give a recording",
    ),
    (&["onset", "duration"], "holds events of a BIDS data set, no gaze; give a *_physio.tsv.gz file"),
];

/// What a file of no known format is, if it is a known companion of one; the end of an error message.
pub(super) fn what_it_is(input: &Input, head: &str) -> Option<String> {
    if input.bytes.starts_with(b"\xff\xfe") || input.bytes.starts_with(b"\xfe\xff") {
        return Some("is text in UTF-16; save it as UTF-8".to_owned());
    }
    let part = input.path.extension().is_some_and(|end| end == "raw" || end == "time");
    if part && input.path.parent().and_then(neon_native::file_in).is_some() {
        return Some(
            "is a part without gaze of a Pupil Labs recording; give the folder it lies in".to_owned(),
        );
    }
    let start = head.trim_start();
    if start.starts_with('{') {
        return Some(
            "is JSON without gaze samples, perhaps a side-car; give the file that it describes".to_owned(),
        );
    }
    if start.starts_with('[') && head.contains("(\"") {
        return Some("describes the fields of a .raw file; give that file, as in `gaze ps1.raw`".to_owned());
    }
    let table = TABLES.iter().find(|(columns, _)| has_header(head, columns));
    table.map(|(_, what)| (*what).to_owned())
}

#[cfg(test)]
mod tests {
    use super::super::testing::input;
    use super::super::{ReadOptions, read, read_input};
    use crate::testing::shared;

    fn error_of(content: impl AsRef<[u8]>) -> String {
        read_input(&input(content), &ReadOptions::default()).expect_err("no samples").to_string()
    }

    #[test]
    fn a_companion_is_called_what_it_is() {
        for (content, words) in [
            ("section id,recording id,blink id,start timestamp [ns],end timestamp [ns]\n", "blinks"),
            ("recording id,timestamp [ns],gyro x [deg/s],acceleration x [g]\n", "motion"),
            ("id,start_timestamp,duration,end_timestamp\n1,2,3,4\n", "gaze_positions.csv"),
            ("pupil_timestamp,world_index,eye_id,confidence,norm_pos_x,norm_pos_y,diameter\n", "eye cameras"),
            ("{\"Columns\": [\"timestamp\"]}", "side-car"),
            ("[\n(\"x\", \"float32\"),\n]\n", ".raw"),
            ("\u{feff}onset\tduration\n1\t2\n", "BIDS"),
            ("nothing that anyone knows", "no known format"),
        ] {
            let error = error_of(content);
            assert!(error.contains(words) && !error.contains('\n'), "{error}");
        }
        assert!(error_of(b"\xff\xfeR\0e\0c\0").contains("UTF-8"));
    }

    #[test]
    fn companions_of_the_shared_recordings_are_known() {
        let Some(folder) = shared("data/gaze") else { return };
        for (file, words) in [
            ("eyedentify3d_pupil_invisible/blinks.csv", "give gaze.csv"),
            ("jemr2022_vive_pro_eye_accuracy/table1.csv", "each person"),
            ("jemr2022_vive_pro_eye_accuracy/data_validations.csv", "each validation"),
            ("irf_lookAtPoint_EL/db_config.json", "JSON"),
            ("pl_neon_native/worn ps1.raw", "give the folder"),
            ("pl_neon_native/eye_state ps1.time", "give the folder"),
            ("bids_eyetracking_binocular/task-FreeView_physio.json", "is not beside it"),
            ("bids_eyetracking_binocular/sub-01_task-FreeView_run-01_events.tsv", "BIDS"),
        ] {
            let error = read(&folder.join(file), &ReadOptions::default())
                .map(|read| read.len())
                .expect_err(file)
                .to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
