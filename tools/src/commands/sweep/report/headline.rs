//! What a reader takes away first: what was measured, and one sentence read off the front.

use super::sheet::{Row, Sheet};
use super::text::{between, figure, per_cent};
use crate::commands::sweep::front::{Measure, Point, Time, front};
use crate::commands::sweep::record::{Figures, Manifest};
use crate::page::escaped;

/// A setting of the front that is faster than the reference.
struct Choice<'a> {
    row: &'a Row<'a>,
    figures: &'a Figures,
    point: Point,
}

/// The sentence, for the first size that has one.
pub fn sentence(sheets: &[Sheet<'_>]) -> String {
    if sheets.iter().all(|sheet| sheet.measured().next().is_none()) {
        let failed = sheets.iter().map(|sheet| sheet.rows.len()).sum::<usize>();
        return match failed {
            0 => "No setting has been measured yet.".to_owned(),
            _ => format!("All {failed} settings failed: the reasons are below."),
        };
    }
    let told = sheets.iter().find_map(|sheet| {
        let choices = choices(sheet);
        let choice = bend(&choices)?;
        let times = &choice.figures.times;
        Some(format!(
            "At {} px <strong>{}</strong> takes <strong>{}</strong> of the reference's time ({}, {} sure) at an \
             acuity-surviving error of <strong>{}</strong>.",
            sheet.size_text(),
            escaped(&choice.row.label),
            figure(choice.point.time),
            between(times.ratio_interval),
            per_cent(times.ratio_confidence),
            figure(choice.point.error)
        ))
    });
    told.unwrap_or_else(|| "No setting that was measured is faster than the reference.".to_owned())
}

/// The front's settings that are faster than the reference, from the fastest on.
fn choices<'a>(sheet: &'a Sheet<'_>) -> Vec<Choice<'a>> {
    let points: Vec<_> =
        sheet.rows.iter().map(|row| Point::of(row.record, Time::Ratio, Measure::AcuityRmse)).collect();
    let of = |place: usize| {
        let row = &sheet.rows[place];
        Some(Choice { row, figures: row.figures()?, point: points[place].filter(|point| point.time < 1.0)? })
    };
    front(&points).into_iter().filter_map(of).collect()
}

/// Where the front bends most: farthest below the straight line between its ends. The fastest of fewer than
/// three, and where the front bends outwards.
fn bend<'c, 'a>(choices: &'c [Choice<'a>]) -> Option<&'c Choice<'a>> {
    let (first, last) = (choices.first()?.point, choices.last()?.point);
    let (time, error) = (last.time - first.time, first.error - last.error);
    if time <= 0.0 || error <= 0.0 {
        return choices.first();
    }
    let below = |choice: &Choice<'_>| {
        1.0 - (choice.point.time - first.time) / time - (choice.point.error - last.error) / error
    };
    choices.iter().rev().max_by(|a, b| below(a).total_cmp(&below(b)))
}

/// Large figures: settings, ends of the front.
pub fn cards(manifest: &Manifest, sheets: &[Sheet<'_>]) -> String {
    let card = |value: &str, what: &str| {
        format!("<div><b>{}</b><span>{}</span></div>", escaped(value), escaped(what))
    };
    let measured = sheets.iter().map(|sheet| sheet.measured().count()).sum::<usize>();
    let failed = sheets.iter().flat_map(|sheet| &sheet.rows).filter(|row| row.failure().is_some()).count();
    let asked = manifest.settings.len() * manifest.sizes.len();
    let missing = asked.saturating_sub(measured + failed);
    let sizes =
        if manifest.sizes.len() == 1 { String::new() } else { format!(" at {} sizes", manifest.sizes.len()) };
    let mut what = format!("settings measured{sizes}");
    if failed > 0 {
        what += &format!(", {failed} failed");
    }
    if missing > 0 {
        what += &format!(", {missing} not yet run");
    }
    let mut html = card(&format!("{measured} of {asked}"), &what);
    let sized = |what: &str, label: &str, sheet: &Sheet<'_>| {
        let size = if sheets.len() > 1 { format!(", {} px", sheet.size_text()) } else { String::new() };
        format!("{what}: {label}{size}")
    };
    if let Some((sheet, choices)) =
        sheets.iter().map(|sheet| (sheet, choices(sheet))).find(|(_, choices)| !choices.is_empty())
    {
        let [fastest, finest] = [&choices[0], &choices[choices.len() - 1]];
        let time = |choice: &Choice<'_>| format!("{} of the time", figure(choice.point.time));
        html += &card(&time(fastest), &sized("the fastest", &fastest.row.label, sheet));
        if choices.len() > 1 {
            html += &card(&time(finest), &sized("the most accurate faster one", &finest.row.label, sheet));
        }
    }
    html
}
