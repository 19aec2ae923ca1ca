use super::*;
use crate::classify::ClassifierSettings;
use crate::estimate::EyeState;
use crate::formats::ReadOptions;
use crate::predict::{LandingPredictor, LandingSettings, Predictor, PredictorKind};
use crate::recording::{ExtraColumn, Recording, RecordingInfo};
use crate::sample::{EyeSample, GazeSample};
use glam::DVec3;

/// The hand-labelled recording, at most `rate_hz` samples a second: the nearest sample to each multiple of
/// the period, with its own time, and no interpolation, as a slower tracker would take them.
fn labelled(rate_hz: f64) -> Option<Recording> {
    let path = crate::testing::shared("data/gaze/irf_lookAtPoint_EL/lookAtPoint_EL_S1.npy")?;
    let all = crate::formats::read(&path, &ReadOptions::default()).expect("reads");
    let told = all.extra_column("evt").expect("labels");
    let mut recording = Recording::new(RecordingInfo::default());
    let mut values = Vec::new();
    let count = (all.len() as f64 * rate_hz / 1000.0) as usize;
    for index in (0..count).map(|index| (index as f64 * 1000.0 / rate_hz).round() as usize) {
        let Some((sample, label)) = all.get(index).zip(told.get(index)) else { break };
        recording.push(&sample);
        values.push(*label);
    }
    recording.extra.push(ExtraColumn { name: "evt".into(), values });
    Some(recording)
}

fn row(kind: EyeState, start_s: f64, end_s: f64, amplitude_deg: f64) -> EventRow {
    EventRow {
        kind: kind.name(),
        start_s,
        end_s,
        amplitude_deg,
        peak_deg_s: 0.0,
        detected_s: start_s + 0.004,
    }
}

/// Worked by hand: two of three labels found, one too small to count, one found in undefined time, one
/// false.
#[test]
fn scores_are_those_worked_by_hand() {
    use EyeState::{Fixation, Saccade, Unknown};
    let labelled = [
        row(Saccade, 1.0, 1.04, 8.0),
        row(Saccade, 2.0, 2.04, 8.0),
        row(Saccade, 3.0, 3.04, 8.0),
        row(Saccade, 4.0, 4.02, 0.9),
        row(Unknown, 5.0, 6.0, 9.0),
        row(Fixation, 1.04, 2.0, 2.0),
    ];
    let found = [
        row(Saccade, 1.002, 1.042, 8.0),
        // Covers half of the union, just so.
        row(Saccade, 2.0, 2.08, 8.0),
        // Covers less.
        row(Saccade, 3.03, 3.07, 8.0),
        // Large enough by its own measure, and its partner is labelled: right.
        row(Saccade, 4.0, 4.02, 1.1),
        row(Saccade, 5.5, 5.52, 8.0),
        row(Fixation, 1.04, 2.0, 2.0),
    ];
    let score = score_events(&found, &labelled, &MatchSettings::default());
    assert_eq!((score.labelled, score.found), (3, 4));
    assert!((score.recall - 2.0 / 3.0).abs() < 1e-12 && (score.precision - 0.75).abs() < 1e-12);
    assert!((score.f1 - 2.0 * 0.5 / (17.0 / 12.0)).abs() < 1e-12, "{}", score.f1);
    assert!((score.start_error_ms - 1.0).abs() < 1e-9 && (score.onset_delay_ms - 5.0).abs() < 1e-9);
    assert!((score.end_error_ms - 21.0).abs() < 1e-9);
    let nothing = score_events(&[], &labelled, &MatchSettings::default());
    assert_eq!((nothing.precision, nothing.recall, nothing.f1), (0.0, 0.0, 0.0));
}

/// Each event once: two halves of a saccade are not two hits.
#[test]
fn matching_is_one_to_one() {
    let label = [row(EyeState::Saccade, 1.0, 1.04, 8.0)];
    let halves = [row(EyeState::Saccade, 1.0, 1.02, 4.0), row(EyeState::Saccade, 1.02, 1.04, 4.0)];
    let score = score_events(&halves, &label, &MatchSettings::default());
    assert_eq!((score.recall, score.precision), (1.0, 0.5));
}

fn f1_and_delay(rate_hz: f64, settings: &ClassifierSettings, labels: &[EventRow]) -> Option<(f64, f64)> {
    let score = score_events(&events_of(&labelled(rate_hz)?, settings), labels, &MatchSettings::default());
    Some((score.f1, score.onset_delay_ms))
}

/// The figures to reach: event F1 of 0.90 at 1 kHz and 0.85 at 120 Hz by intersection over union, known
/// within 12 ms of the labelled onset.
#[test]
fn saccades_agree_with_hand_labels() {
    let Some(truth) = labelled(1000.0) else { return };
    let labels = labelled_events(&truth).expect("labels");
    for (rate_hz, least_f1, most_ms) in [
        (1000.0, 0.90, 12.0),
        (500.0, 0.90, 12.0),
        (250.0, 0.90, 12.0),
        (120.0, 0.85, 20.0),
        (90.0, 0.85, 20.0),
    ] {
        let recording = labelled(rate_hz).expect("there");
        let found = events_of(&recording, &ClassifierSettings::default());
        let score = score_events(&found, &labels, &MatchSettings::default());
        println!("{rate_hz} Hz: {score:.3?}");
        assert!(score.labelled > 80, "{score:?}");
        assert!(score.f1 >= least_f1 && score.onset_delay_ms <= most_ms, "{rate_hz} Hz: {score:?}");
        let all = MatchSettings { least_amplitude_deg: 0.0, ..MatchSettings::default() };
        let naive = score_events(&naive_saccades(&recording, 30.0), &labels, &all);
        println!("  of any amplitude {:.3?}", score_events(&found, &labels, &all));
        println!("  30 deg/s from sample to sample, of any amplitude {naive:.3?}");
        assert!(naive.precision < score.precision, "{naive:?}");
    }
}

/// No constant is so finely tuned that 20 % more or less of it would miss the figures.
#[test]
fn the_tuning_is_not_fine() {
    let Some(truth) = labelled(1000.0) else { return };
    let labels = labelled_events(&truth).expect("labels");
    type Knob = (&'static str, fn(&mut ClassifierSettings, f64));
    let knobs: [Knob; 12] = [
        ("window_ns", |s, by| s.window_ns = (s.window_ns as f64 * by) as i64),
        ("onset_noise", |s, by| s.onset_noise *= by),
        ("offset_noise", |s, by| s.offset_noise *= by),
        ("floors", |s, by| {
            s.onset_floor_deg_s *= by;
            s.offset_floor_deg_s *= by;
        }),
        ("offset_peak_share", |s, by| s.offset_peak_share *= by),
        ("noise_memory_s", |s, by| s.noise_memory_s *= by),
        ("drift_tau_s", |s, by| s.drift_tau_s *= by),
        ("settle_ns", |s, by| s.settle_ns = (s.settle_ns as f64 * by) as i64),
        ("settle_peak_share", |s, by| s.settle_peak_share *= by),
        ("settle_tau_s", |s, by| s.settle_tau_s *= by),
        ("min_amplitude_deg", |s, by| s.min_amplitude_deg *= by),
        ("reopen_ns", |s, by| s.reopen_ns = (s.reopen_ns as f64 * by) as i64),
    ];
    for (name, turn) in knobs {
        for by in [0.8, 1.2] {
            let mut settings = ClassifierSettings::default();
            turn(&mut settings, by);
            for (rate_hz, least_f1) in [(1000.0, 0.90), (120.0, 0.85)] {
                let (f1, delay_ms) = f1_and_delay(rate_hz, &settings, &labels).expect("there");
                println!("{name} x {by} at {rate_hz} Hz: F1 {f1:.3}, {delay_ms:.1} ms");
                assert!(f1 >= least_f1 && delay_ms <= 12.0, "{name} x {by} at {rate_hz} Hz: {f1}");
            }
        }
    }
}

/// The figures to reach: at half of a saccade the landing point is half as far off as the last sample, and
/// 30 % less than straight on.
#[test]
fn landings_are_predicted() {
    let Some(truth) = labelled(1000.0) else { return };
    let report = predict_report(&truth, &[10.0, 20.0, 50.0]);
    assert_eq!(report.saccades, "labels");
    for row in &report.horizons {
        println!(
            "{} {} ms: median {:.3}, p95 {:.3}",
            row.predictor, row.horizon_ms, row.median_deg, row.p95_deg
        );
    }
    for row in &report.landings {
        let LandingRow { predictor, at_fraction, from_deg, to_deg, count, landing_median_deg } = row;
        let to = to_deg.map_or(String::new(), |to| to.to_string());
        println!("{predictor} at {at_fraction}, {from_deg}-{to} deg ({count}): {landing_median_deg:.3?}");
    }
    let at_half = |name: &str| {
        let all = |row: &&LandingRow| {
            row.predictor == name && row.at_fraction == 0.5 && row.from_deg == 1.0 && row.to_deg.is_none()
        };
        report.landings.iter().find(all).and_then(|row| row.landing_median_deg).expect("all saccades")
    };
    let (landing, hold, straight) = (at_half("landing"), at_half("hold"), at_half("constant-velocity"));
    assert!(landing <= 0.5 * hold && landing <= 0.7 * straight, "{landing} against {hold} and {straight}");
}

/// Nor is the predictor finely tuned: each of its constants off by 20 % keeps the figures, and so does each
/// half of the saccades, halved so that both have the same mix of amplitudes.
#[test]
fn the_tuning_of_the_landing_is_not_fine() {
    let Some(truth) = labelled(1000.0) else { return };
    let labels = labelled_events(&truth).expect("labels");
    let errors_of = |predictor: Box<dyn Predictor>| {
        let mut errors = landing_errors(&truth, &labels, &ClassifierSettings::default(), predictor, 0.5);
        errors.sort_by(|one, other| one.0.total_cmp(&other.0));
        errors
    };
    let median = |errors: &[(f64, f64)], parts: usize, part: usize| {
        let mut chosen: Vec<f64> = errors.iter().skip(part).step_by(parts).map(|(_, error)| *error).collect();
        quantile(&mut chosen, 0.5)
    };
    let hold = errors_of(PredictorKind::Hold.make());
    let straight = errors_of(PredictorKind::ConstantVelocity.make());
    let judge = |name: &str, errors: &[(f64, f64)], parts: usize, part: usize| {
        let [landing, hold, straight] = [errors, &hold, &straight].map(|errors| median(errors, parts, part));
        println!("{name}: {landing:.3} deg, hold {hold:.3}, straight on {straight:.3}");
        assert!(landing <= 0.5 * hold && landing <= 0.7 * straight, "{name}: {landing}");
    };
    let usual = errors_of(PredictorKind::Landing.make());
    judge("one half", &usual, 2, 0);
    judge("the other half", &usual, 2, 1);
    let mut ratios: Vec<f64> = usual.iter().zip(&hold).map(|(landing, hold)| landing.1 / hold.1).collect();
    println!("median of the ratio to hold, saccade by saccade: {:.3}", quantile(&mut ratios, 0.5));
    type Knob = (&'static str, fn(&mut LandingSettings, f64));
    let knobs: [Knob; 9] = [
        ("duration_s", |s, by| s.duration_s *= by),
        ("duration_s_per_deg", |s, by| s.duration_s_per_deg *= by),
        ("duration_spread", |s, by| s.duration_spread *= by),
        ("usual_amplitude_deg", |s, by| s.usual_amplitude_deg *= by),
        ("amplitude_spread", |s, by| s.amplitude_spread *= by),
        ("shape_error", |s, by| s.shape_error *= by),
        ("speed_error", |s, by| s.speed_error *= by),
        ("independent_points", |s, by| s.independent_points *= by),
        ("speed_window_ns", |s, by| s.speed_window_ns = (s.speed_window_ns as f64 * by) as i64),
    ];
    for (name, turn) in knobs {
        for by in [0.8, 1.2] {
            let mut settings = LandingSettings::default();
            turn(&mut settings, by);
            let errors = errors_of(Box::new(LandingPredictor::new(settings)));
            judge(&format!("{name} x {by}"), &errors, 1, 0);
        }
    }
}

#[test]
fn a_report_is_json() {
    let mut recording = Recording::new(RecordingInfo::default());
    for ms in 0..500_i64 {
        let direction = DVec3::new((ms.min(250) as f64 * 1e-3).sin(), 0.0, -1.0);
        let eye = EyeSample { valid: true, direction: Some(direction), ..EyeSample::default() };
        recording.push(&GazeSample { combined: eye, ..GazeSample::at(ms * 1_000_000) });
    }
    assert!(labelled_events(&recording).is_none());
    let report = serde_json::to_value(predict_report(&recording, &[20.0])).expect("json");
    assert_eq!(report["saccades"], "classifier");
    assert_eq!(report["horizons"][0]["predictor"], "hold");
    assert!(report["horizons"][0]["p95_deg"].is_f64() && report["landings"][0]["at_fraction"].is_f64());
    let events = serde_json::to_value(events_of(&recording, &ClassifierSettings::default())).expect("json");
    for name in ["kind", "start_s", "end_s", "amplitude_deg", "peak_deg_s"] {
        assert!(events[0].get(name).is_some(), "{name}");
    }
}

#[test]
fn an_empty_recording_gives_an_empty_report() {
    let empty = Recording::new(RecordingInfo::default());
    assert!(events_of(&empty, &ClassifierSettings::default()).is_empty());
    let report = predict_report(&empty, &[20.0]);
    assert!(report.horizons.iter().all(|row| row.count == 0));
    assert!(report.landings.iter().all(|row| row.landing_median_deg.is_none()));
}

#[test]
fn quantiles_are_those_of_the_sorted_values() {
    assert_eq!(quantile(&mut [3.0, 1.0, 2.0], 0.5), 2.0);
    assert_eq!(quantile(&mut [4.0, 1.0, 2.0, 3.0], 0.5), 2.5);
    assert!(quantile(&mut [], 0.5).is_nan());
}
