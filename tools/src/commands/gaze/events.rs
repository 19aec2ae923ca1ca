//! `macula gaze events`: what the eye did, as the online classifier sees it.

use super::GazeFileArgs;
use super::prepare::{thinned, with_directions};
use crate::failure::Failure;
use crate::options::parse_within;
use crate::output;
use clap::Args;
use macula_trackers::EyeState;
use macula_trackers::classify::ClassifierSettings;
use macula_trackers::evaluate::{
    EventRow, MatchSettings, Score, events_of, labelled_events, naive_saccades, score_events,
};
use serde::Serialize;

/// The plainest threshold of a saccade, to compare with, deg/s.
const NAIVE_DEG_S: f64 = 30.0;
/// Classes of amplitude of the main sequence, deg.
const CLASSES_DEG: [(f64, Option<f64>); 7] = [
    (0.0, Some(1.0)),
    (1.0, Some(2.0)),
    (2.0, Some(5.0)),
    (5.0, Some(10.0)),
    (10.0, Some(20.0)),
    (20.0, Some(40.0)),
    (40.0, None),
];
const KINDS: [EyeState; 5] =
    [EyeState::Fixation, EyeState::Saccade, EyeState::Pursuit, EyeState::Blink, EyeState::Lost];

/// What the eye did: fixations, saccades, pursuits, blinks and losses
///
/// The recording goes through the same classifier as live gaze, sample by sample. Times are seconds on the
/// recording's own clock. Where the recording carries labels (an expert's in a column evt, the truth of a
/// synthetic eye in evt_truth) the saccades are scored against them: a found one counts where the
/// intersection of both intervals is at least half of their union, one to one.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  macula gaze events session.csv\n  \
                        macula gaze events labelled.npy --rate 120 --json")]
pub struct EventsArgs {
    #[command(flatten)]
    input: GazeFileArgs,
    /// Thin the recording to this rate first: for each time the nearest sample, unfiltered
    #[arg(long, value_name = "HZ", value_parser = |text: &str| parse_within(text, 1.0, 10_000.0))]
    rate: Option<f64>,
    /// Score saccades of at least this amplitude
    #[arg(long, value_name = "DEG", default_value = "1", value_parser = |text: &str| parse_within(text, 0.0, 180.0))]
    min_amplitude_deg: f64,
}

/// Saccades of similar amplitude: medians.
#[derive(Debug, PartialEq, Serialize)]
struct MainSequence {
    from_deg: f64,
    to_deg: Option<f64>,
    count: usize,
    amplitude_deg: f64,
    peak_deg_s: f64,
    duration_ms: f64,
}

#[derive(Debug, Default, Serialize)]
struct Counts {
    fixation: usize,
    saccade: usize,
    pursuit: usize,
    blink: usize,
    lost: usize,
}

#[derive(Serialize)]
struct Scores {
    /// How a found saccade is matched with a labelled one, in words.
    matching: String,
    min_amplitude_deg: f64,
    #[serde(flatten)]
    classifier: Score,
    any_amplitude: Score,
    naive_deg_s: f64,
    naive: Score,
    naive_any_amplitude: Score,
}

#[derive(Serialize)]
struct Report {
    samples: usize,
    rate_hz: Option<f64>,
    /// The rate that was asked for; the recording was thinned where it had more.
    thinned_to_hz: Option<f64>,
    counts: Counts,
    main_sequence: Vec<MainSequence>,
    score: Option<Scores>,
    events: Vec<EventRow>,
}

/// Runs the command.
///
/// # Errors
/// A file that cannot be read or has no directions.
pub fn run(args: &EventsArgs, json: bool) -> Result<(), Failure> {
    let whole = with_directions(args.input.read()?)?;
    let labels = labelled_events(&whole);
    let recording = match args.rate {
        Some(rate_hz) => thinned(&whole, rate_hz),
        None => whole,
    };
    let mut events = events_of(&recording, &ClassifierSettings::default());
    // What it did before anything was known of it is no event.
    events.retain(|event| event.kind != EyeState::Unknown.name());
    let score = |labels: &[EventRow]| {
        let naive = naive_saccades(&recording, NAIVE_DEG_S);
        let of = |found: &[EventRow], least_amplitude_deg: f64| {
            score_events(found, labels, &MatchSettings { least_amplitude_deg, ..MatchSettings::default() })
        };
        Scores {
            matching: matching(),
            min_amplitude_deg: args.min_amplitude_deg,
            classifier: of(&events, args.min_amplitude_deg),
            any_amplitude: of(&events, 0.0),
            naive_deg_s: NAIVE_DEG_S,
            naive: of(&naive, args.min_amplitude_deg),
            naive_any_amplitude: of(&naive, 0.0),
        }
    };
    let report = Report {
        samples: recording.len(),
        rate_hz: recording.rate_hz(),
        thinned_to_hz: args.rate,
        counts: counts(&events),
        main_sequence: main_sequence(&events),
        score: labels.as_deref().map(score),
        events,
    };
    if json { output::print_json(&report) } else { output::print(&text(&report)) }
}

fn matching() -> String {
    let percent = MatchSettings::default().overlap * 100.0;
    format!("intersection of both intervals at least {percent:.0} % of their union, one to one")
}

fn counts(events: &[EventRow]) -> Counts {
    let [fixation, saccade, pursuit, blink, lost] =
        KINDS.map(|kind| events.iter().filter(|event| event.kind == kind.name()).count());
    Counts { fixation, saccade, pursuit, blink, lost }
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    crate::measure::median(&values.collect::<Vec<_>>()).unwrap_or(f64::NAN)
}

fn main_sequence(events: &[EventRow]) -> Vec<MainSequence> {
    let classes = CLASSES_DEG.into_iter().map(|(from_deg, to_deg)| {
        let within = |event: &&EventRow| {
            event.kind == EyeState::Saccade.name()
                && event.amplitude_deg >= from_deg
                && to_deg.is_none_or(|to_deg| event.amplitude_deg < to_deg)
        };
        let saccades: Vec<&EventRow> = events.iter().filter(within).collect();
        MainSequence {
            from_deg,
            to_deg,
            count: saccades.len(),
            amplitude_deg: median(saccades.iter().map(|event| event.amplitude_deg)),
            peak_deg_s: median(saccades.iter().map(|event| event.peak_deg_s)),
            duration_ms: median(saccades.iter().map(|event| (event.end_s - event.start_s) * 1e3)),
        }
    });
    classes.filter(|class| class.count > 0).collect()
}

fn text(report: &Report) -> String {
    let row = |event: &EventRow| {
        vec![
            event.kind.to_owned(),
            format!("{:.3}", event.start_s),
            format!("{:.3}", event.end_s),
            format!("{:.1}", (event.end_s - event.start_s) * 1e3),
            format!("{:.2}", event.amplitude_deg),
            format!("{:.0}", event.peak_deg_s),
        ]
    };
    let rows = report.events.iter().map(row).collect::<Vec<_>>();
    let header = ["event", "start s", "end s", "length ms", "amplitude deg", "peak deg/s"];
    let mut text = output::table(&header, &rows) + "\n";
    let Counts { fixation, saccade, pursuit, blink, lost } = report.counts;
    let rate = report.rate_hz.map_or("an unknown rate".into(), |rate_hz| format!("{rate_hz:.1} Hz"));
    text += &format!("{} samples at {rate}", output::grouped(report.samples as u64));
    if let Some(rate_hz) = report.thinned_to_hz {
        text += &format!(" (thinned to {rate_hz} Hz, the nearest sample each)");
    }
    text += &format!(
        "\nfixations {fixation}, saccades {saccade}, pursuits {pursuit}, blinks {blink}, losses {lost}\n"
    );
    if !report.main_sequence.is_empty() {
        text += &format!("\nMain sequence, medians\n{}", main_sequence_table(&report.main_sequence));
    }
    if let Some(scores) = &report.score {
        text += &score_text(scores);
    }
    text
}

/// A range of degrees in words.
pub fn degrees(from_deg: f64, to_deg: Option<f64>) -> String {
    to_deg.map_or(format!("{from_deg} deg and more"), |to_deg| format!("{from_deg} to {to_deg} deg"))
}

fn main_sequence_table(classes: &[MainSequence]) -> String {
    let row = |class: &MainSequence| {
        vec![
            degrees(class.from_deg, class.to_deg),
            class.count.to_string(),
            format!("{:.2}", class.amplitude_deg),
            format!("{:.0}", class.peak_deg_s),
            format!("{:.1}", class.duration_ms),
        ]
    };
    let rows = classes.iter().map(row).collect::<Vec<_>>();
    output::table(&["amplitude", "saccades", "amplitude deg", "peak deg/s", "length ms"], &rows)
}

fn score_text(scores: &Scores) -> String {
    let ms = |value: f64| if value.is_finite() { format!("{value:.1}") } else { "-".into() };
    let row = |name: String, score: &Score| {
        vec![
            name,
            score.labelled.to_string(),
            score.found.to_string(),
            format!("{:.3}", score.precision),
            format!("{:.3}", score.recall),
            format!("{:.3}", score.f1),
            ms(score.onset_delay_ms),
            ms(score.start_error_ms),
            ms(score.end_error_ms),
        ]
    };
    let (least, naive) = (scores.min_amplitude_deg, scores.naive_deg_s);
    let rows = [
        row(format!("classifier, {least} deg and more"), &scores.classifier),
        row("classifier, any amplitude".into(), &scores.any_amplitude),
        row(format!("{naive} deg/s, {least} deg and more"), &scores.naive),
        row(format!("{naive} deg/s, any amplitude"), &scores.naive_any_amplitude),
    ];
    let header = [
        "saccades",
        "labelled",
        "found",
        "precision",
        "recall",
        "F1",
        "known after ms",
        "start off ms",
        "end off ms",
    ];
    format!(
        "\nAgainst the labels: {}. {naive} deg/s is a bare threshold from sample to sample, to compare with.\n{}",
        scores.matching,
        output::table(&header, &rows)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn saccade(start_s: f64, length_s: f64, amplitude_deg: f64, peak_deg_s: f64) -> EventRow {
        EventRow {
            kind: "saccade",
            start_s,
            end_s: start_s + length_s,
            amplitude_deg,
            peak_deg_s,
            detected_s: start_s,
        }
    }

    #[test]
    fn the_main_sequence_goes_by_amplitude() {
        let rest = EventRow { kind: "fixation", ..saccade(5.0, 1.0, 3.0, 1.0) };
        let events = [
            saccade(0.0, 0.020, 2.0, 100.0),
            saccade(1.0, 0.030, 4.0, 200.0),
            saccade(2.0, 0.040, 3.0, 150.0),
            saccade(3.0, 0.100, 45.0, 500.0),
            rest,
        ];
        let classes = main_sequence(&events);
        assert_eq!(classes.len(), 2);
        assert_eq!((classes[0].from_deg, classes[0].to_deg, classes[0].count), (2.0, Some(5.0), 3));
        assert_eq!((classes[0].amplitude_deg, classes[0].peak_deg_s), (3.0, 150.0));
        assert!((classes[0].duration_ms - 30.0).abs() < 1e-6);
        assert_eq!((classes[1].to_deg, classes[1].count), (None, 1));
        let counts = counts(&events);
        assert_eq!((counts.saccade, counts.fixation, counts.blink), (4, 1, 0));
    }
}
