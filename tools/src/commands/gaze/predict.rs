//! `macula gaze predict`: how far predictions of the gaze are off.

use super::GazeFileArgs;
use super::events::degrees;
use super::prepare::with_directions;
use crate::failure::Failure;
use crate::options::parse_within;
use crate::output;
use crate::progress::Steps;
use clap::Args;
use macula_trackers::evaluate::{LandingRow, PredictionReport, PredictionRow, predict_report};
use serde::Serialize;

/// How far predictions of the gaze are off, by predictor and horizon, and where saccades will land
///
/// Every predictor sees the recording sample by sample and is asked for the gaze some time ahead; the
/// answer is compared with where the recording itself has the gaze then. For saccades of 1 degree or more it
/// is also asked where they will end, after a quarter, half and three quarters of their duration. Saccades
/// are those of the recording's labels, or of the online classifier where it has none.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  macula gaze predict session.csv\n  \
                        macula gaze predict labelled.npy --horizons-ms 15,50 --json")]
pub struct PredictArgs {
    #[command(flatten)]
    input: GazeFileArgs,
    /// How far ahead, ms; no predictor goes on for more than 100
    #[arg(
        long,
        value_name = "MS,...",
        value_delimiter = ',',
        default_value = "10,20,30,50,100",
        value_parser = |text: &str| parse_within(text, 0.0, 1000.0)
    )]
    horizons_ms: Vec<f64>,
}

#[derive(Serialize)]
struct Report {
    samples: usize,
    rate_hz: Option<f64>,
    #[serde(flatten)]
    errors: PredictionReport,
}

/// Runs the command.
///
/// # Errors
/// A file that cannot be read or has no directions.
pub fn run(args: &PredictArgs, json: bool) -> Result<(), Failure> {
    let mut steps = Steps::short(2);
    steps.next("reading");
    let recording = with_directions(args.input.read()?)?;
    steps.next("predicting");
    let errors = predict_report(&recording, &args.horizons_ms);
    drop(steps);
    let report = Report { samples: recording.len(), rate_hz: recording.rate_hz(), errors };
    if json { output::print_json(&report) } else { output::print(&text(&report)) }
}

fn text(report: &Report) -> String {
    let errors = &report.errors;
    let rate = report.rate_hz.map_or("an unknown rate".into(), |rate_hz| format!("{rate_hz:.1} Hz"));
    let mut text = format!("{} samples at {rate}\n", output::grouped(report.samples as u64));
    text += "\nError of the predicted gaze, deg: median / 95 % are below\n";
    text += &horizon_table(&errors.horizons);
    text += &format!(
        "\nError of the predicted landing, deg: median, by share of the saccade's duration (saccades of the {})\n",
        errors.saccades
    );
    text += &landing_table(&errors.landings);
    text += "\nThe same at half of the duration, by amplitude\n";
    text += &amplitude_table(&errors.landings);
    text + &gain(&errors.landings)
}

/// The values of a field in the order in which they first appear.
fn distinct<Row, T: PartialEq>(rows: &[Row], field: impl Fn(&Row) -> T) -> Vec<T> {
    let mut found = Vec::new();
    for value in rows.iter().map(field) {
        if !found.contains(&value) {
            found.push(value);
        }
    }
    found
}

fn horizon_table(rows: &[PredictionRow]) -> String {
    let horizons = distinct(rows, |row| row.horizon_ms);
    let cell = |row: &PredictionRow| {
        if row.count > 0 { format!("{:.2} / {:.2}", row.median_deg, row.p95_deg) } else { "-".into() }
    };
    let line = |name: &&str| {
        let of = rows.iter().filter(|row| row.predictor == *name).map(cell);
        std::iter::once((*name).to_owned()).chain(of).collect()
    };
    let lines: Vec<Vec<String>> = distinct(rows, |row| row.predictor).iter().map(line).collect();
    let header: Vec<String> = std::iter::once("predictor".to_owned())
        .chain(horizons.iter().map(|horizon_ms| format!("{horizon_ms} ms")))
        .collect();
    output::table(&header.iter().map(String::as_str).collect::<Vec<_>>(), &lines)
}

/// All saccades of 1 degree or more: the first row of each predictor and share.
fn overall(row: &&LandingRow) -> bool {
    row.from_deg == 1.0 && row.to_deg.is_none()
}

fn degrees_or_dash(row: &LandingRow) -> String {
    row.landing_median_deg.map_or("-".into(), |error_deg| format!("{error_deg:.2}"))
}

fn landing_table(rows: &[LandingRow]) -> String {
    let line = |name: &&str| {
        let of = rows.iter().filter(overall).filter(|row| row.predictor == *name);
        let count = of.clone().map(|row| row.count).max().unwrap_or(0);
        std::iter::once((*name).to_owned())
            .chain(of.map(degrees_or_dash))
            .chain(std::iter::once(count.to_string()))
            .collect()
    };
    let lines: Vec<Vec<String>> = distinct(rows, |row| row.predictor).iter().map(line).collect();
    let shares = distinct(rows, |row| row.at_fraction);
    let header: Vec<String> = std::iter::once("predictor".to_owned())
        .chain(shares.iter().map(|share| format!("at {:.0} %", share * 100.0)))
        .chain(std::iter::once("saccades".to_owned()))
        .collect();
    output::table(&header.iter().map(String::as_str).collect::<Vec<_>>(), &lines)
}

fn amplitude_table(rows: &[LandingRow]) -> String {
    let half: Vec<&LandingRow> = rows.iter().filter(|row| row.at_fraction == 0.5).collect();
    let names = distinct(&half, |row| row.predictor);
    let classes = distinct(&half, |row| (row.from_deg, row.to_deg));
    let line = |&(from_deg, to_deg): &(f64, Option<f64>)| {
        let of = half.iter().filter(|row| (row.from_deg, row.to_deg) == (from_deg, to_deg));
        let count = of.clone().map(|row| row.count).max().unwrap_or(0);
        [degrees(from_deg, to_deg), count.to_string()]
            .into_iter()
            .chain(of.map(|row| degrees_or_dash(row)))
            .collect()
    };
    let lines: Vec<Vec<String>> = classes.iter().map(line).collect();
    let header: Vec<&str> = ["amplitude", "saccades"].into_iter().chain(names).collect();
    output::table(&header, &lines)
}

/// What predicting the landing gains, in a sentence.
fn gain(rows: &[LandingRow]) -> String {
    let median = |name: &str| {
        let of = rows.iter().filter(overall).find(|row| row.predictor == name && row.at_fraction == 0.5);
        of.and_then(|row| row.landing_median_deg).filter(|error_deg| *error_deg > 0.0)
    };
    let (Some(landing), Some(hold), Some(straight)) =
        (median("landing"), median("hold"), median("constant-velocity"))
    else {
        return String::new();
    };
    let below = |other: f64| {
        let percent = (1.0 - landing / other) * 100.0;
        format!("{:.0} % {}", percent.abs(), if percent >= 0.0 { "below" } else { "above" })
    };
    format!(
        "\nAt half of a saccade the landing predictor is {landing:.2} deg off: {} holding the last sample, {} going \
         straight on.\n",
        below(hold),
        below(straight)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn landing(predictor: &'static str, from_deg: f64, error_deg: Option<f64>) -> LandingRow {
        LandingRow {
            predictor,
            at_fraction: 0.5,
            from_deg,
            to_deg: None,
            count: 3,
            landing_median_deg: error_deg,
        }
    }

    #[test]
    fn the_gain_is_told_in_percent() {
        let rows = [
            landing("hold", 1.0, Some(4.0)),
            landing("constant-velocity", 1.0, Some(2.0)),
            landing("landing", 1.0, Some(1.0)),
            landing("landing", 20.0, None),
        ];
        let text = gain(&rows);
        assert!(text.contains("75 % below holding") && text.contains("50 % below going"), "{text}");
        assert_eq!(gain(&rows[..2]), "");
        assert!(amplitude_table(&rows).contains("20 deg and more"));
    }

    #[test]
    fn horizons_become_columns() {
        let row = |horizon_ms, count| PredictionRow {
            predictor: "hold",
            horizon_ms,
            count,
            median_deg: 0.25,
            p95_deg: 1.5,
        };
        let text = horizon_table(&[row(10.0, 5), row(20.0, 0)]);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].contains("10 ms") && lines[0].contains("20 ms"), "{text}");
        assert!(lines[2].contains("0.25 / 1.50") && lines[2].ends_with('-'), "{text}");
    }
}
