//! Where the time goes: stacked bars of the passes, and the same as a table.

use super::marks::color_class;
use super::sheet::Sheet;
use super::table::{Cell, Table};
use super::text::figure;
use crate::commands::sweep::record::Pass;
use crate::measure::median;
use crate::page::axis::COLORS;
use crate::page::escaped;
use std::fmt::Write;

/// Passes with a colour of their own; the others share one.
const OWN_COLORS: usize = COLORS.len() - 1;
const OTHERS: usize = OWN_COLORS;

/// A bar: what it is of, the card that it links to, and its passes.
struct Bar {
    name: String,
    key: Option<String>,
    passes: Vec<Pass>,
}

impl Bar {
    fn time_of(&self, name: &str) -> Option<f64> {
        let of: Vec<f64> =
            self.passes.iter().filter(|pass| pass.name == name).map(|pass| pass.gpu_ms).collect();
        (!of.is_empty()).then(|| of.iter().sum::<f64>()).filter(|ms| ms.is_finite() && *ms >= 0.0)
    }

    fn total(&self) -> f64 {
        self.passes.iter().map(|pass| pass.gpu_ms).filter(|ms| ms.is_finite() && *ms >= 0.0).sum()
    }
}

/// All passes of all sizes, which give a pass the same colour everywhere; those that take the most time first.
pub fn all_names(sheets: &[Sheet<'_>]) -> Vec<String> {
    names(&sheets.iter().flat_map(bars).collect::<Vec<_>>())
}

/// One size's bars and table; `names` as from [`all_names`].
pub fn section(sheet: &Sheet<'_>, names: &[String]) -> String {
    let bars = bars(sheet);
    let most = bars.iter().map(Bar::total).fold(0.0, f64::max);
    if names.is_empty() || most <= 0.0 {
        return "<p>No pass was measured at this size.</p>\n".to_owned();
    }
    let colored = &names[..names.len().min(OWN_COLORS)];
    let rest = names.len() - colored.len();
    let mut html = String::from("<ul class=\"legend\" aria-hidden=\"true\">");
    for (place, name) in colored.iter().enumerate() {
        _ = write!(html, "<li><i class=\"swatch {}\"></i> {}</li>", color_class(place), escaped(name));
    }
    if rest > 0 {
        _ = write!(html, "<li><i class=\"swatch {}\"></i> {rest} other passes</li>", color_class(OTHERS));
    }
    html += "</ul>\n<div class=\"bars\">\n";
    html.extend(bars.iter().map(|bar| stacked(bar, colored, most)));
    html + "</div>\n" + &table(sheet, &bars, names)
}

/// The reference's, then the settings'.
fn bars(sheet: &Sheet<'_>) -> Vec<Bar> {
    let mut reference: Vec<(String, Vec<f64>)> = Vec::new();
    for (_, figures) in sheet.measured() {
        for pass in &figures.times.reference_passes {
            match reference.iter_mut().find(|(name, _)| *name == pass.name) {
                Some((_, times)) => times.push(pass.gpu_ms),
                None => reference.push((pass.name.clone(), vec![pass.gpu_ms])),
            }
        }
    }
    let passes =
        reference.into_iter().filter_map(|(name, times)| Some(Pass { name, gpu_ms: median(&times)? }));
    let reference = Bar { name: "reference".to_owned(), key: None, passes: passes.collect() };
    let settings = sheet.measured().map(|(row, figures)| Bar {
        name: row.label.clone(),
        key: Some(row.key.clone()),
        passes: figures.times.passes.clone(),
    });
    let bars = [reference].into_iter().chain(settings);
    bars.filter(|bar| !bar.passes.is_empty()).collect()
}

/// All passes, those that take the most time in all bars together first.
fn names(bars: &[Bar]) -> Vec<String> {
    let mut names: Vec<(String, f64)> = Vec::new();
    for pass in bars.iter().flat_map(|bar| &bar.passes).filter(|pass| pass.gpu_ms.is_finite()) {
        match names.iter_mut().find(|(name, _)| *name == pass.name) {
            Some((_, ms)) => *ms += pass.gpu_ms,
            None => names.push((pass.name.clone(), pass.gpu_ms)),
        }
    }
    names.sort_by(|a, b| b.1.total_cmp(&a.1));
    names.into_iter().map(|(name, _)| name).collect()
}

fn stacked(bar: &Bar, colored: &[String], most: f64) -> String {
    let total = bar.total();
    let own: Vec<(usize, &str, f64)> = colored
        .iter()
        .enumerate()
        .filter_map(|(place, name)| Some((place, name.as_str(), bar.time_of(name)?)))
        .collect();
    let others = total - own.iter().map(|(_, _, ms)| ms).sum::<f64>();
    let others = (others > total * 1e-9).then_some((OTHERS, "other passes", others));
    let mut parts = String::new();
    for (place, name, ms) in own.into_iter().chain(others) {
        _ = write!(
            parts,
            "<i class=\"{}\" style=\"width:{:.2}%\" title=\"{}: {} ms\"></i>",
            color_class(place),
            (ms / most * 100.0).clamp(0.0, 100.0),
            escaped(name),
            figure(ms)
        );
    }
    let name = escaped(&bar.name);
    let linked = match &bar.key {
        Some(key) => format!("<a href=\"#{key}\">{name}</a>"),
        None => format!("<b>{name}</b>"),
    };
    let total = figure(total);
    format!(
        "<div class=\"bar-row\"><span>{linked} <small>{total} ms</small></span>\
         <div class=\"stacked\" role=\"img\" aria-label=\"{name}: {total} ms in all; by pass in the table\">{parts}\
         </div></div>\n"
    )
}

fn table(sheet: &Sheet<'_>, bars: &[Bar], names: &[String]) -> String {
    let row = |bar: &Bar| {
        let of = |ms: f64| Cell::Number(ms, figure(ms));
        let cells = names.iter().map(|name| bar.time_of(name).map_or(Cell::Nothing, of));
        (bar.name.clone(), bar.key.clone(), [of(bar.total())].into_iter().chain(cells).collect())
    };
    let head = ["setting", "all, ms"].into_iter().chain(names.iter().map(String::as_str));
    Table {
        caption: format!("Passes at {} px, medians, ms", sheet.size_text()),
        head: head.map(str::to_owned).collect(),
        rows: bars.iter().map(row).collect(),
        class: "passes",
        sortable: true,
    }
    .html()
}
