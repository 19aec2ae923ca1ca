//! The rows as text, in the manner of the published table I and figures 11, 12 and 16 to 18.

use super::run::{Results, Row};
use crate::output::{grouped, table};
use std::fmt::Write;

/// The whole report.
pub fn text(results: &Results) -> String {
    let mut text = format!(
        "{} ({})\ngaze ({}, {}), {} samples for each pixel or texel of the ray-marched scene\n",
        results.device, results.driver, results.gaze[0], results.gaze[1], results.spp
    );
    text += "Speed-ups are medians of the ratios within rounds in which each method renders one frame.\n";
    text += "Limit: samples that acuity and display together call for.\n";
    section(
        &mut text,
        "Speed-up over full shading (published: VaFR, deferred and ray cast)",
        &speedups(results),
    );
    section(&mut text, "Samples shaded for one eye", &samples(results));
    section(&mut text, "Samples as published (table I), thousands", &published(results));
    for row in &results.rows {
        let title = format!("Passes of {} at {}x{}, ms", row.scene, row.size[0], row.size[1]);
        section(&mut text, &title, &passes(row));
    }
    text
}

fn section(text: &mut String, title: &str, body: &str) {
    _ = write!(text, "\n{title}\n{body}");
}

fn size_of(row: &Row) -> String {
    format!("{}x{}", row.size[0], row.size[1])
}

fn speedups(results: &Results) -> String {
    let mut cells = Vec::new();
    for row in &results.rows {
        for of in &row.methods {
            let published =
                row.published_speedup.filter(|_| of.method == "vafr" || of.method == "vafr-planar");
            cells.push(vec![
                row.scene.clone(),
                size_of(row),
                of.method.into(),
                format!("{:.0}", row.full_ms),
                format!("{:.0}", of.gpu_ms),
                row.rounds.to_string(),
                format!("{:.2}x", of.speedup.median),
                format!("{:.2}..{:.2}", of.speedup.least, of.speedup.greatest),
                published.map_or("-".into(), |[low, high]| {
                    if low < high { format!("{low}..{high}x") } else { format!("{low}x") }
                }),
            ]);
        }
    }
    let header =
        ["scene", "size", "method", "full ms", "ms", "rounds", "speed-up", "least..greatest", "published"];
    table(&header, &cells)
}

fn samples(results: &Results) -> String {
    let mut cells = Vec::new();
    for row in &results.rows {
        for of in &row.methods {
            cells.push(vec![
                row.scene.clone(),
                size_of(row),
                of.method.into(),
                grouped(row.pixels),
                grouped(row.limit as u64),
                grouped(of.samples),
                format!("{:.2}", of.samples_over_limit),
                format!("{:.1}", row.pixels as f64 / of.samples.max(1) as f64),
                grouped(of.native_pixels),
                of.landed.map_or("-".into(), |landed| format!("{:.1} %", 100.0 * landed)),
            ]);
        }
    }
    let header = [
        "scene",
        "size",
        "method",
        "pixels",
        "limit",
        "samples",
        "of limit",
        "pixels/samples",
        "native",
        "landed",
    ];
    table(&header, &cells)
}

fn published(results: &Results) -> String {
    let cells = results.published_samples.iter().map(|row| {
        vec![
            format!("{}x{}", row.size[0], row.size[1]),
            row.vafr_rep_k.to_string(),
            row.vafr_k.to_string(),
            row.lafr_2_2_k.to_string(),
            row.lafr_1_8_k.to_string(),
            row.full_k.to_string(),
        ]
    });
    let header = ["size", "VaFR Rep", "VaFR", "LaFR 2.2", "LaFR 1.8", "full"];
    table(&header, &cells.collect::<Vec<_>>())
}

/// Every pass of any method, in the order in which they run.
fn passes(row: &Row) -> String {
    let lists: Vec<_> =
        std::iter::once(&row.full_passes).chain(row.methods.iter().map(|of| &of.passes)).collect();
    let mut names: Vec<&str> = Vec::new();
    for list in &lists {
        for (place, pass) in list.iter().enumerate() {
            if !names.contains(&pass.name) {
                let before = list[..place].last();
                let at = before.and_then(|before| names.iter().position(|name| *name == before.name));
                names.insert(at.map_or(0, |at| at + 1), pass.name);
            }
        }
    }
    let time = |list: &[crate::measure::PassMedian], name: &str| {
        let found = list.iter().find(|pass| pass.name == name);
        found.map_or("-".into(), |pass| format!("{:.1}", pass.gpu_ms))
    };
    let cells = names.iter().map(|name| {
        std::iter::once((*name).to_owned()).chain(lists.iter().map(|list| time(list, name))).collect()
    });
    let header: Vec<_> = ["pass", "full"].into_iter().chain(row.methods.iter().map(|of| of.method)).collect();
    table(&header, &cells.collect::<Vec<Vec<String>>>())
}
