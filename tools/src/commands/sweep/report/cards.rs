//! A card for each setting: its pictures and figures. The panel beside the front shows copies of them.

use super::marks::icon;
use super::sheet::{Row, Sheet};
use super::text::{between, bytes, figure, per_cent};
use super::{Pictures, Thumbnails};
use crate::commands::sweep::record::Figures;
use crate::output::grouped;
use crate::page::{data_url, escaped};
use std::fmt::Write;

/// The key of the reference's card.
pub fn reference_key(sheet: &Sheet<'_>) -> String {
    format!("r{}", sheet.at)
}

/// One size's cards: the reference's, then the settings'.
pub fn section(sheet: &Sheet<'_>, reference: &str, thumbnails: &Thumbnails) -> String {
    let mut html = String::from("<div class=\"pictures\">\n");
    let picture = thumbnails.references.get(&sheet.at);
    let figures = match sheet.reference_ms() {
        Some(ms) => format!("<dl><dt>GPU time</dt><dd>{} ms</dd></dl>", figure(ms)),
        None => String::new(),
    };
    _ = writeln!(
        html,
        "<article class=\"card\" id=\"{}\"><h4>reference</h4>\n<div class=\"pair\">{}</div>\n\
         <p class=\"whole\">{}</p>{figures}</article>",
        reference_key(sheet),
        picture.map(|bytes| shown(sheet, "setting", "The reference", "picture", bytes)).unwrap_or_default(),
        escaped(reference)
    );
    for row in &sheet.rows {
        let pictures = thumbnails.settings.get(&(sheet.at, row.record.index));
        html += &card(sheet, row, pictures);
    }
    html + "</div>\n"
}

fn card(sheet: &Sheet<'_>, row: &Row<'_>, pictures: Option<&Pictures>) -> String {
    let pair = pictures.map_or(String::new(), |pictures| {
        let name = &row.label;
        shown(sheet, "setting", name, "picture", &pictures.picture)
            + &shown(
                sheet,
                "difference",
                &format!("Difference to the reference, {name}"),
                "difference ×4",
                &pictures.difference,
            )
    });
    let found = match (row.figures(), row.failure()) {
        (Some(figures), _) => list(figures),
        (None, why) => format!("<p class=\"why\">Failed: {}</p>", escaped(why.unwrap_or_default())),
    };
    format!(
        "<article class=\"card\" id=\"{}\"><h4>{} {}</h4>\n<div class=\"pair\">{pair}</div>\n\
         <p class=\"whole\">{}</p>{found}</article>\n",
        row.key,
        icon(row.method),
        escaped(&row.label),
        escaped(&row.setting.to_string())
    )
}

fn shown(sheet: &Sheet<'_>, kind: &str, alt: &str, caption: &str, bytes: &[u8]) -> String {
    // What is no picture is left out: a broken image says less than none.
    let Ok(format) = image::guess_format(bytes) else { return String::new() };
    let [width, height] = sheet.size;
    format!(
        "<figure data-kind=\"{kind}\"><img alt=\"{}\" style=\"aspect-ratio:{width}/{height}\" src=\"{}\"/>\
         <figcaption>{caption}</figcaption></figure>",
        escaped(alt),
        data_url(format.to_mime_type(), bytes)
    )
}

fn list(figures: &Figures) -> String {
    let times = &figures.times;
    let errors = &figures.errors;
    let interval = format!("{} ({})", between(times.ratio_interval), per_cent(times.ratio_confidence));
    let mut html = String::from("<dl>");
    for (name, value) in [
        ("time / reference", figure(times.ratio.median)),
        ("interval", interval),
        ("GPU time", format!("{} ms", figure(times.setting_ms.median))),
        ("acuity-surviving RMSE", figure(errors.acuity_rmse)),
        ("FLIP", figure(errors.flip)),
        ("RMSE", figure(errors.rmse)),
        ("samples shaded", grouped(figures.samples_shaded)),
        ("GPU memory", bytes(figures.memory_bytes)),
    ] {
        _ = write!(html, "<dt>{name}</dt><dd>{value}</dd>");
    }
    html + "</dl>"
}
