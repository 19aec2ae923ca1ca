//! What is made of the records once all are there: table, schema, front, report.

use super::folder::{Folder, Picture};
use super::record::{Manifest, Outcome, Record};
use super::report::{self, Pictures, Thumbnails};
use super::table;
use crate::failure::Failure;
use crate::library;
use crate::output;
use serde::Serialize;
use std::path::PathBuf;

/// The result; its field names are an interface.
#[derive(Serialize)]
struct Report<'a> {
    scene: &'a str,
    settings: usize,
    measured: usize,
    failed: usize,
    missing: usize,
    files: Vec<PathBuf>,
    records: &'a [Record],
}

/// Writes what follows from the records, and says how far the sweep is. Where records are missing, only that
/// is said.
///
/// # Errors
/// What cannot be read or written.
pub fn finish(folder: &Folder, manifest: &Manifest, json: bool) -> Result<(), Failure> {
    let records = folder.records(manifest)?;
    let missing = manifest.units().count() - records.len();
    let mut files = Vec::new();
    if missing == 0 {
        files = write_all(folder, manifest, &records)?;
    }
    let failed = records.iter().filter(|record| matches!(record.outcome, Outcome::Failed(_))).count();
    let report = Report {
        scene: &manifest.scene,
        settings: manifest.settings.len(),
        measured: records.len() - failed,
        failed,
        missing,
        files,
        records: &records,
    };
    if json { output::print_json(&report) } else { output::print(&text(&report)) }
}

fn write_all(folder: &Folder, manifest: &Manifest, records: &[Record]) -> Result<Vec<PathBuf>, Failure> {
    let files = [
        ("results.csv", table::csv(records)?),
        ("schema.json", table::schema(manifest)?.into_bytes()),
        ("report.html", page(folder, manifest, records)?.into_bytes()),
    ];
    let mut written = Vec::new();
    for (name, bytes) in files {
        let path = folder.file(name);
        library::write_file(&path, &bytes)?;
        written.push(path);
    }
    Ok(written)
}

/// The report, with the pictures that are there.
fn page(folder: &Folder, manifest: &Manifest, records: &[Record]) -> Result<String, Failure> {
    let mut thumbnails = Thumbnails::default();
    for (place, &size) in manifest.sizes.iter().enumerate() {
        let of = |picture| folder.picture(size, picture);
        thumbnails.references.extend(of(Picture::Reference).map(|bytes| (place, bytes)));
        for index in 0..manifest.settings.len() {
            if let (Some(picture), Some(difference)) =
                (of(Picture::Of(index)), of(Picture::Difference(index)))
            {
                thumbnails.settings.insert((place, index), Pictures { picture, difference });
            }
        }
    }
    Ok(report::html(manifest, records, folder.effects()?.as_ref(), &thumbnails))
}

fn text(report: &Report<'_>) -> String {
    let mut text = String::new();
    let rows: Vec<_> = report.records.iter().filter_map(row).collect();
    if !rows.is_empty() {
        let header = ["size", "setting", "GPU ms", "ratio", "interval", "acuity error", "FLIP", "samples"];
        text += &output::table(&header, &rows);
        text += "\nratio: GPU time over the reference's, median of pairs; acuity error: RMSE that survives the acuity\n";
    }
    for record in report.records {
        if let Outcome::Failed(line) = &record.outcome {
            text += &format!("failed: {}: {line}\n", record.setting);
        }
    }
    if report.missing > 0 {
        text += &format!(
            "{} records are not there yet; run the other parts, or --resume, and then `macula sweep merge`\n",
            report.missing
        );
    }
    for file in &report.files {
        text += &format!("wrote      {}\n", file.display());
    }
    text
}

fn row(record: &Record) -> Option<Vec<String>> {
    let figures = record.figures()?;
    let [width, height] = record.size;
    let [low, high] = figures.times.ratio_interval;
    Some(vec![
        format!("{width}x{height}"),
        record.setting.to_string(),
        format!("{:.2}", figures.times.setting_ms.median),
        format!("{:.3}", figures.times.ratio.median),
        format!("{low:.3}..{high:.3}"),
        format!("{:.5}", figures.errors.acuity_rmse),
        format!("{:.4}", figures.errors.flip),
        output::grouped(figures.samples_shaded),
    ])
}
