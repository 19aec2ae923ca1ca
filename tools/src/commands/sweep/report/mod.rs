//! The report of a sweep: one page that needs nothing else, not even a network or JavaScript.

mod cards;
mod effects;
#[cfg(test)]
pub(in crate::commands::sweep) mod fixture;
mod headline;
mod how;
mod knob_curves;
mod marks;
mod passes;
mod scatter;
mod sheet;
mod table;
mod tables;
#[cfg(test)]
mod tests;
mod text;

use super::record::{Effects, Manifest, Record, Ring};
use crate::page::{BASE_STYLE, escaped, filled};
use sheet::{Sheet, sheets, size_text};
use std::collections::BTreeMap;
use std::fmt::Write;

const TEMPLATE: &str = include_str!("report.html");
const STYLE: &str = include_str!("report.css");
const SCRIPT: &str = include_str!("report.js");

/// Small pictures of the first view, as PNG or JPEG files. What is missing is left out of the page.
#[derive(Debug, Default)]
pub struct Thumbnails {
    /// The reference's picture, by the size's place in [`Manifest::sizes`].
    pub references: BTreeMap<usize, Vec<u8>>,
    /// By the size's place and the setting's place in [`Manifest::settings`].
    pub settings: BTreeMap<(usize, usize), Pictures>,
}

/// A setting's pictures.
#[derive(Debug, Default)]
pub struct Pictures {
    /// As rendered.
    pub picture: Vec<u8>,
    /// Its difference to the reference's, times 4.
    pub difference: Vec<u8>,
}

/// The page's text.
pub fn html(
    manifest: &Manifest,
    records: &[Record],
    effects: Option<&Effects>,
    thumbnails: &Thumbnails,
) -> String {
    let sheets = sheets(manifest, records);
    let reference = manifest.reference.to_string();
    let passes = passes::all_names(&sheets);
    filled(
        TEMPLATE,
        &[
            ("style", format!("{BASE_STYLE}{STYLE}{}", marks::style())),
            ("scene", escaped(&manifest.scene)),
            ("intro", intro(manifest, records)),
            ("sentence", headline::sentence(&sheets)),
            ("cards", headline::cards(manifest, &sheets)),
            ("sizes", size_choice(&sheets)),
            ("times", choice("time", "Time", scatter::TIMES.map(|(_, name, _)| name))),
            ("measures", choice("error", "Error", scatter::MEASURES.map(|(_, name, _)| name))),
            ("fronts", by_size(&sheets, front)),
            ("settings", by_size(&sheets, tables::settings)),
            ("failed", tables::failed(&sheets)),
            ("curves", by_size(&sheets, knob_curves::section)),
            ("rings", by_size(&sheets, rings)),
            ("passes", by_size(&sheets, |sheet| passes::section(sheet, &passes))),
            ("effects", effects::section(effects)),
            ("grid", by_size(&sheets, |sheet| cards::section(sheet, &reference, thumbnails))),
            ("facts", how::facts(manifest, records)),
            ("measured", how::measured(manifest, records)),
            ("knobs", how::knobs()),
            ("command", how::command(manifest)),
            ("script", SCRIPT.to_owned()),
        ],
    )
}

fn intro(manifest: &Manifest, records: &[Record]) -> String {
    let sizes = manifest.sizes.iter().map(|size| size_text(*size)).collect::<Vec<_>>().join(", ");
    let mut text = format!("{}; {sizes} px; {} degrees across", manifest.scene, manifest.hfov_deg);
    let machines = how::machines(records);
    if let [(machine, _)] = machines[..] {
        _ = write!(text, "; {}, {}", machine.device, machine.driver);
    } else if !machines.is_empty() {
        _ = write!(text, "; {} machines", machines.len());
    }
    escaped(&text)
}

/// A part for each size; the script shows one of them at a time.
fn by_size(sheets: &[Sheet<'_>], part: impl Fn(&Sheet<'_>) -> String) -> String {
    if let [sheet] = sheets {
        return part(sheet);
    }
    let sized = |sheet: &Sheet<'_>| {
        format!(
            "<div data-size=\"{}\">\n<h3>{} px</h3>\n{}</div>\n",
            sheet.at,
            sheet.size_text(),
            part(sheet)
        )
    };
    sheets.iter().map(sized).collect()
}

fn front(sheet: &Sheet<'_>) -> String {
    format!(
        "<div class=\"front-view\">\n<div>{}</div>\n<aside class=\"panel\" aria-live=\"polite\" hidden=\"\"></aside>\n</div>\n",
        scatter::section(sheet)
    )
}

fn rings(sheet: &Sheet<'_>) -> String {
    let acuity = |ring: &Ring| ring.acuity_rmse;
    let mut html = tables::errors(sheet, "Acuity-surviving RMSE", acuity);
    html += &tables::errors(sheet, "FLIP", |ring| ring.flip);
    html += &tables::errors(sheet, "RMSE", |ring| ring.rmse);
    html += &tables::temporal(sheet, "the camera", |figures| &figures.temporal.camera);
    html + &tables::temporal(sheet, "the gaze", |figures| &figures.temporal.gaze)
}

/// Buttons of which one is chosen; the script shows what bears its value.
fn choice<const N: usize>(name: &str, title: &str, values: [&str; N]) -> String {
    buttons(name, title, values.map(|value| (value.to_owned(), value.to_owned())).as_slice())
}

fn size_choice(sheets: &[Sheet<'_>]) -> String {
    if sheets.len() < 2 {
        return String::new();
    }
    let values = sheets.iter().map(|sheet| (sheet.at.to_string(), format!("{} px", sheet.size_text())));
    let buttons = buttons("size", "Size, for all sections", &values.collect::<Vec<_>>());
    format!("<form class=\"controls\" hidden=\"\">{buttons}</form>\n")
}

fn buttons(name: &str, title: &str, values: &[(String, String)]) -> String {
    let mut html = format!("<fieldset><legend>{title}</legend>");
    for (at, (value, text)) in values.iter().enumerate() {
        let checked = if at == 0 { " checked=\"\"" } else { "" };
        _ = write!(
            html,
            "<label><input type=\"radio\" name=\"{name}\" value=\"{value}\"{checked}/><span>{text}</span></label>"
        );
    }
    html + "</fieldset>\n"
}
