//! `results.csv` and the schema of its columns.

use super::record::{Errors, Figures, Manifest, Outcome, Record, Ring, TemporalRing};
use crate::failure::Failure;
use macula::knobs::{KNOBS, Value};
use macula::quality::compare::RING_STARTS_DEG;
use serde::Serialize;

/// A column.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Column {
    /// Its name in the first row.
    pub name: String,
    /// `text`, `integer`, `number`, `boolean`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// Its unit, or nothing.
    pub unit: &'static str,
    /// What it holds. Empty cells: has no meaning, or was not measured.
    pub description: String,
}

fn column(
    name: impl Into<String>,
    kind: &'static str,
    unit: &'static str,
    description: impl Into<String>,
) -> Column {
    Column { name: name.into(), kind, unit, description: description.into() }
}

/// Columns and cells are made by the same walk, so that they cannot part.
type Of = Box<dyn Fn(&Record) -> Option<String>>;

fn cells() -> Vec<(Column, Of)> {
    let mut cells = Vec::new();
    let mut put = |column: Column, of: Of| cells.push((column, of));
    put(
        column("index", "integer", "", "place of the setting in the sweep, from 0"),
        Box::new(|of| text(of.index)),
    );
    put(column("width_px", "integer", "px", "the display's width"), Box::new(|of| text(of.size[0])));
    put(column("height_px", "integer", "px", "the display's height"), Box::new(|of| text(of.size[1])));
    put(column("failure", "text", "", "why there are no figures"), Box::new(failure));
    for knob in KNOBS {
        let kind = match knob.reference {
            macula::knobs::Reference::Switch(_) => "boolean",
            macula::knobs::Reference::Number(_) => "number",
            macula::knobs::Reference::Name(_) => "text",
        };
        let name = knob.name;
        put(
            column(name.replace('-', "_"), kind, "", format!("knob {name}: {}", knob.affects)),
            Box::new(move |of| of.setting.get(name).map(knob_text)),
        );
    }
    for (name, unit, description, of) in NUMBERS {
        put(
            column(*name, "number", unit, *description),
            Box::new(move |record| record.figures().and_then(of)),
        );
    }
    for (index, from_deg) in RING_STARTS_DEG.into_iter().enumerate() {
        let to = RING_STARTS_DEG.get(index + 1).map_or("up".to_owned(), f64::to_string);
        let ring = format!("{from_deg}_{to}");
        let where_ = format!("between {from_deg} and {to} degrees from the gaze");
        for (name, of) in RINGS {
            put(
                column(format!("{name}_{ring}"), "number", "1", format!("{name} {where_}")),
                Box::new(move |record| text_of(of(record.figures()?.errors.rings.get(index)?))),
            );
        }
        for (name, of) in MOVES {
            put(
                column(
                    format!("{name}_variance_{ring}"),
                    "number",
                    "1",
                    format!("variance over time of encoded luminance while the {name} moves, {where_}"),
                ),
                Box::new(move |record| text_of(of(record.figures()?).get(index)?.variance)),
            );
            put(
                column(
                    format!("{name}_variance_ratio_{ring}"),
                    "number",
                    "1",
                    format!("the same over the reference's, {where_}"),
                ),
                Box::new(move |record| text_of(of(record.figures()?).get(index)?.ratio)),
            );
        }
    }
    for (name, of) in PLACES {
        put(
            column(*name, "text", "", format!("{name} that it was measured on")),
            Box::new(move |record| Some(of(record))),
        );
    }
    cells
}

type OfFigures = fn(&Figures) -> Option<String>;
type OfRing = fn(&Ring) -> Option<f64>;
type OfMove = fn(&Figures) -> &Vec<TemporalRing>;
type OfRecord = fn(&Record) -> String;

const NUMBERS: &[(&str, &str, &str, OfFigures)] = &[
    ("pairs", "", "pairs of frames measured", |of| text(of.times.pairs)),
    ("gpu_ms", "ms", "GPU time of a frame, median", |of| text(of.times.setting_ms.median)),
    ("gpu_ms_least", "ms", "the least", |of| text(of.times.setting_ms.least)),
    ("gpu_ms_greatest", "ms", "the greatest", |of| text(of.times.setting_ms.greatest)),
    ("reference_ms", "ms", "GPU time of the reference's frame, median", |of| {
        text(of.times.reference_ms.median)
    }),
    ("time_ratio", "1", "GPU time over the reference's within pairs, median", |of| {
        text(of.times.ratio.median)
    }),
    ("time_ratio_low", "1", "lower end of the interval for its median", |of| {
        text(of.times.ratio_interval[0])
    }),
    ("time_ratio_high", "1", "upper end of the interval for its median", |of| {
        text(of.times.ratio_interval[1])
    }),
    ("time_ratio_confidence", "1", "probability that the interval holds the median", |of| {
        text(of.times.ratio_confidence)
    }),
    ("rmse", "1", "root mean square difference of encoded values, 0 to 1", |of| text(of.errors.rmse)),
    ("psnr_db", "dB", "the same as PSNR; empty where the pictures are equal", |of| psnr_db(&of.errors)),
    ("flip", "1", "FLIP, 0 to 1", |of| text(of.errors.flip)),
    ("acuity_rmse", "1", "root mean square difference that survives the acuity: the front's error", |of| {
        text(of.errors.acuity_rmse)
    }),
    ("seam_residual", "1", "step across the LP-buffer's seam", |of| text_of(of.errors.seam_residual)),
    ("samples_shaded", "", "samples shaded in a frame, mean", |of| text(of.samples_shaded)),
    ("memory_bytes", "bytes", "GPU memory beside the scene", |of| text(of.memory_bytes)),
    ("non_finite", "", "NaN and infinite values in buffers", |of| text(of.non_finite)),
    ("jod", "JOD", "FovVideoVDP, 10 for no difference", |of| text_of(of.jod)),
];

const RINGS: [(&str, OfRing); 3] =
    [("rmse", |of| of.rmse), ("flip", |of| of.flip), ("acuity_rmse", |of| of.acuity_rmse)];

const MOVES: [(&str, OfMove); 2] = [("camera", |of| &of.temporal.camera), ("gaze", |of| &of.temporal.gaze)];

const PLACES: &[(&str, OfRecord)] = &[
    ("device", |of| of.machine.device.clone()),
    ("driver", |of| of.machine.driver.clone()),
    ("cpu", |of| of.machine.cpu.clone()),
];

fn text(value: impl ToString) -> Option<String> {
    Some(value.to_string())
}

fn text_of(value: Option<f64>) -> Option<String> {
    value.map(|value| value.to_string())
}

fn failure(record: &Record) -> Option<String> {
    match &record.outcome {
        Outcome::Failed(line) => Some(line.clone()),
        Outcome::Measured(_) => None,
    }
}

fn knob_text(value: &Value) -> String {
    match value {
        Value::Switch(on) => on.to_string(),
        value => value.to_string(),
    }
}

/// None where the pictures are equal.
fn psnr_db(errors: &Errors) -> Option<String> {
    (errors.rmse > 0.0).then(|| (-20.0 * errors.rmse.log10()).to_string())
}

/// The table's columns.
pub fn columns() -> Vec<Column> {
    cells().into_iter().map(|(column, _)| column).collect()
}

/// The schema as JSON.
///
/// # Errors
/// None that can be caused from outside.
pub fn schema(manifest: &Manifest) -> Result<String, Failure> {
    #[derive(Serialize)]
    struct Schema<'a> {
        table: &'static str,
        version: u32,
        scene: &'a str,
        rows: &'static str,
        missing: &'static str,
        columns: Vec<Column>,
    }
    let schema = Schema {
        table: "results.csv",
        version: manifest.version,
        scene: &manifest.scene,
        rows: "one for each setting at each size; RFC 4180, UTF-8, a header row, decimal points",
        missing: "an empty cell: has no meaning there, or was not measured",
        columns: columns(),
    };
    serde_json::to_string_pretty(&schema)
        .map_err(|error| Failure::environment(format!("the schema cannot be written as JSON: {error}")))
}

/// The table as CSV.
///
/// # Errors
/// None that can be caused from outside.
pub fn csv(records: &[Record]) -> Result<Vec<u8>, Failure> {
    let cells = cells();
    let told =
        |error: csv::Error| Failure::environment(format!("the table cannot be written as CSV: {error}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(cells.iter().map(|(column, _)| &column.name)).map_err(told)?;
    for record in records {
        writer.write_record(cells.iter().map(|(_, of)| of(record).unwrap_or_default())).map_err(told)?;
    }
    writer.into_inner().map_err(|error| Failure::environment(format!("the table cannot be written: {error}")))
}
