use super::*;
use crate::classify::ClassifierSettings;
use crate::estimate::EyeState;
use crate::recording::{ExtraColumn, Recording, RecordingInfo};
use crate::sample::{EyeSample, GazeSample};
use glam::DVec3;

/// The hand-labelled recording, at most `rate_hz` samples a second: the nearest sample to each multiple of
/// the period, with its own time, and no interpolation, as a slower tracker would take them.
fn labelled(rate_hz: f64) -> Option<Recording> {
    let path = crate::testing::shared("data/gaze/irf_lookAtPoint_EL/lookAtPoint_EL_S1.npy")?;
    let bytes = std::fs::read(path).ok()?;
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let records: Vec<&[u8]> = bytes[start..].chunks_exact(18).collect();
    let mut recording = Recording::new(RecordingInfo::default());
    let mut labels = Vec::new();
    let count = (records.len() as f64 * rate_hz / 1000.0) as usize;
    for index in (0..count).map(|index| (index as f64 * 1000.0 / rate_hz).round() as usize) {
        let Some(record) = records.get(index) else { break };
        let f32_at = |at: usize| f64::from(f32::from_le_bytes(record[at..at + 4].try_into().unwrap()));
        let t_s = f64::from_le_bytes(record[..8].try_into().unwrap());
        let direction = DVec3::new(f32_at(8).to_radians().tan(), -f32_at(12).to_radians().tan(), -1.0);
        let eye = EyeSample { valid: record[16] != 0, direction: Some(direction), ..EyeSample::default() };
        recording
            .push(&GazeSample { combined: eye, ..GazeSample::at((t_s * 1e9).round() as i64) });
        labels.push(f64::from(record[17]));
    }
    recording.extra.push(ExtraColumn { name: "evt".into(), values: labels });
    Some(recording)
}

#[test]
fn print_figures() {
    let Some(truth) = labelled(1000.0) else { return };
    let labels = labelled_events(&truth).expect("labels");
    for rate_hz in [1000.0, 500.0, 250.0, 120.0, 90.0, 60.0] {
        let recording = labelled(rate_hz).expect("there");
        let found = events_of(&recording, &ClassifierSettings::default());
        println!("{rate_hz} Hz: {:?}", score_events(&found, &labels, &MatchSettings::default()));
        let naive = naive_saccades(&recording, 30.0);
        println!("   naive {:?}", score_events(&naive, &labels, &MatchSettings::default()));
        let kinds = ["fixation", "saccade", "pursuit", "blink", "lost"];
        println!("   {:?}", kinds.map(|kind| found.iter().filter(|row| row.kind == kind).count()));
    }
    let report = predict_report(&truth, &[10.0, 20.0, 50.0]);
    for row in report.horizons {
        println!("{row:?}");
    }
    for row in report.landings {
        println!("{row:?}");
    }
}
