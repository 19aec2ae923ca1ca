//! All settings in one table, those that failed, and errors and change over time by ring.

use super::sheet::{Row, Sheet};
use super::table::{Cell, Table};
use super::text::{between, bytes, figure, per_cent};
use crate::commands::sweep::front::{Measure, Point, Time, front};
use crate::commands::sweep::record::{Figures, Ring, TemporalRing};
use crate::output::grouped;

/// A column: its head and its cell.
type Column = (&'static str, fn(&Figures) -> Cell);

const COLUMNS: &[Column] = &[
    ("time / reference", |of| number(of.times.ratio.median)),
    ("interval", |of| Cell::Number(of.times.ratio_interval[0], between(of.times.ratio_interval))),
    ("confidence", |of| Cell::Number(of.times.ratio_confidence, per_cent(of.times.ratio_confidence))),
    ("pairs", |of| Cell::Number(of.times.pairs.into(), of.times.pairs.to_string())),
    ("GPU ms", |of| number(of.times.setting_ms.median)),
    ("reference, ms", |of| number(of.times.reference_ms.median)),
    ("acuity-surviving RMSE", |of| number(of.errors.acuity_rmse)),
    ("FLIP", |of| number(of.errors.flip)),
    ("RMSE", |of| number(of.errors.rmse)),
    ("seam residual", |of| of.errors.seam_residual.map_or(Cell::Nothing, number)),
    ("samples shaded", |of| count(of.samples_shaded)),
    ("GPU memory", |of| Cell::Number(of.memory_bytes as f64, bytes(of.memory_bytes))),
    ("NaN or infinite", |of| count(of.non_finite)),
];

const JOD: Column = ("JOD", |of| of.jod.map_or(Cell::Nothing, number));

fn number(value: f64) -> Cell {
    Cell::Number(value, figure(value))
}

fn count(value: u64) -> Cell {
    Cell::Number(value as f64, grouped(value))
}

/// Every setting that was measured.
pub fn settings(sheet: &Sheet<'_>) -> String {
    let with_jod = sheet.measured().any(|(_, figures)| figures.jod.is_some());
    let columns: Vec<&Column> = COLUMNS.iter().chain(with_jod.then_some(&JOD)).collect();
    let points: Vec<_> =
        sheet.rows.iter().map(|row| Point::of(row.record, Time::Ratio, Measure::AcuityRmse)).collect();
    let on_front = front(&points);
    let row = |(place, row): (usize, &Row<'_>)| {
        let figures = row.figures()?;
        let mut cells: Vec<Cell> = columns.iter().map(|(_, cell)| cell(figures)).collect();
        cells.push(Cell::Text(if on_front.contains(&place) { "yes" } else { "no" }.to_owned()));
        Some((row.label.clone(), Some(row.key.clone()), cells))
    };
    let head = ["setting"].into_iter().chain(columns.iter().map(|(head, _)| *head)).chain(["on the front"]);
    Table {
        caption: format!("Every measured setting at {} px", sheet.size_text()),
        head: head.map(str::to_owned).collect(),
        rows: sheet.rows.iter().enumerate().filter_map(row).collect(),
        class: "settings",
        sortable: true,
    }
    .html()
}

/// Every setting that failed, and why.
pub fn failed(sheets: &[Sheet<'_>]) -> String {
    let rows = sheets.iter().flat_map(|sheet| {
        let failed = sheet.rows.iter().filter_map(|row| Some((row, row.failure()?)));
        failed.map(|(row, why)| {
            (row.label.clone(), None, vec![Cell::Text(sheet.size_text()), Cell::Text(why.to_owned())])
        })
    });
    Table {
        caption: "Settings that failed".to_owned(),
        head: ["setting", "size, px", "why"].map(str::to_owned).to_vec(),
        rows: rows.collect(),
        class: "failed",
        sortable: false,
    }
    .html()
}

/// `2–5°`, `40°+`.
fn ring_name(from_deg: f64, to_deg: Option<f64>) -> String {
    match to_deg {
        Some(to_deg) => format!("{from_deg}–{to_deg}°"),
        None => format!("{from_deg}°+"),
    }
}

/// Begins and ends of all rings that any of these has, from the gaze outwards.
fn all_rings(rings: impl Iterator<Item = (f64, Option<f64>)>) -> Vec<(f64, Option<f64>)> {
    let mut all: Vec<_> = rings.collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.unwrap_or(f64::MAX).total_cmp(&b.1.unwrap_or(f64::MAX))));
    all.dedup();
    all
}

fn ring_table<'a, R: 'a>(
    sheet: &Sheet<'a>,
    caption: String,
    rings_of: impl Fn(&'a Figures) -> &'a [R],
    bounds: impl Fn(&R) -> (f64, Option<f64>),
    cell: impl Fn(&R) -> Cell,
) -> String {
    let rings = all_rings(sheet.measured().flat_map(|(_, figures)| rings_of(figures).iter().map(&bounds)));
    let row = |(row, figures): (&Row<'_>, &'a Figures)| {
        let own = rings_of(figures);
        let of = |ring: &(f64, Option<f64>)| own.iter().find(|own| bounds(own) == *ring);
        let cells = rings.iter().map(|ring| of(ring).map_or(Cell::Nothing, &cell));
        (row.label.clone(), Some(row.key.clone()), cells.collect())
    };
    let names = rings.iter().map(|&(from_deg, to_deg)| ring_name(from_deg, to_deg));
    Table {
        caption,
        head: ["setting".to_owned()].into_iter().chain(names).collect(),
        rows: if rings.is_empty() { vec![] } else { sheet.measured().map(row).collect() },
        class: "rings",
        sortable: true,
    }
    .html()
}

/// An error by ring.
pub fn errors(sheet: &Sheet<'_>, what: &str, error: impl Fn(&Ring) -> Option<f64>) -> String {
    ring_table(
        sheet,
        format!("{what} by eccentricity at {} px", sheet.size_text()),
        |figures| &figures.errors.rings,
        |ring| (ring.from_deg, ring.to_deg),
        |ring| error(ring).map_or(Cell::Nothing, number),
    )
}

/// Temporal variance by ring, in millionths, with its multiple of the reference's where there is one.
pub fn temporal<'a>(
    sheet: &Sheet<'a>,
    what: &str,
    rings: impl Fn(&'a Figures) -> &'a [TemporalRing],
) -> String {
    let cell = |ring: &TemporalRing| {
        let Some(variance) = ring.variance else { return Cell::Nothing };
        let millionths = figure(variance * 1e6);
        let text = match ring.ratio {
            Some(ratio) if ratio.is_finite() => format!("{millionths} (×{})", figure(ratio)),
            _ => millionths,
        };
        Cell::Number(variance, text)
    };
    ring_table(
        sheet,
        format!("Temporal variance ×10⁻⁶ by eccentricity while {what} moves, {} px", sheet.size_text()),
        rings,
        |ring| (ring.from_deg, ring.to_deg),
        cell,
    )
}
