//! What each effect costs in the scene, and what leaving out the others saves.

use super::table::{Cell, Table};
use super::text::{between, figure};
use crate::commands::sweep::record::{EffectCost, Effects};
use crate::page::escaped;

/// The section's inside.
pub fn section(effects: Option<&Effects>) -> String {
    let Some(effects) = effects.filter(|effects| !effects.effects.is_empty()) else {
        return "<p>The effects were not measured in this sweep.</p>\n".to_owned();
    };
    let table = Table {
        caption: "Effects: cost of those that run, saving of those left out".to_owned(),
        head: [
            "effect",
            "plan",
            "ms, median",
            "least to greatest",
            "pairs",
            "values changed by, at most",
            "why",
        ]
        .map(str::to_owned)
        .to_vec(),
        rows: effects.effects.iter().map(row).collect(),
        class: "effects",
        sortable: false,
    };
    format!("<p>{}</p>\n<p>{}</p>\n{}", saving(effects), unchanged(&effects.effects), table.html())
}

fn row(effect: &EffectCost) -> (String, Option<String>, Vec<Cell>) {
    let what = if effect.runs { "runs, costs" } else { "left out, saves" };
    let spread = effect.gpu_ms;
    let cells = vec![
        Cell::Text(what.to_owned()),
        Cell::Number(spread.median, figure(spread.median)),
        Cell::Number(spread.least, between([spread.least, spread.greatest])),
        Cell::Number(effect.pairs.into(), effect.pairs.to_string()),
        Cell::Number(effect.most_changed.into(), format!("{} of 255", effect.most_changed)),
        Cell::Text(effect.why.clone()),
    ];
    (effect.name.clone(), None, cells)
}

fn saving(effects: &Effects) -> String {
    let Effects { planned_ms, forced_ms, .. } = *effects;
    let runs = effects.effects.iter().filter(|effect| effect.runs).count();
    let left_out = effects.effects.len() - runs;
    let counts = format!("In this scene {runs} effects run and {left_out} are left out.");
    if !(planned_ms.is_finite() && forced_ms.is_finite() && forced_ms > 0.0) {
        return counts;
    }
    let saved = forced_ms - planned_ms;
    let times = format!(
        "The frame as planned takes {} ms, with every effect forced {} ms",
        figure(planned_ms),
        figure(forced_ms)
    );
    if saved <= 0.0 {
        return format!("{counts} {times}: leaving them out saved nothing that could be measured.");
    }
    format!(
        "{counts} {times}: leaving them out saves {} ms, {:.0} % of it.",
        figure(saved),
        saved / forced_ms * 100.0
    )
}

/// What leaving effects out did to the picture.
fn unchanged(effects: &[EffectCost]) -> String {
    let left_out = || effects.iter().filter(|effect| !effect.runs);
    let changed: Vec<String> = left_out()
        .filter(|effect| effect.most_changed > 0)
        .map(|effect| format!("{} (by up to {} of 255)", escaped(&effect.name), effect.most_changed))
        .collect();
    if left_out().next().is_none() {
        "Nothing was left out.".to_owned()
    } else if changed.is_empty() {
        "Forcing what was left out changed not one 8-bit value of the picture: nothing is lost.".to_owned()
    } else {
        format!("<strong>Leaving out changed the picture: {}.</strong>", changed.join(", "))
    }
}
