//! The rows as text, in the manner of the published tables.

use super::paper;
use super::run::{Results, Row};
use crate::measure::PassMedian;
use crate::output::{grouped, table};
use std::fmt::Write;

/// The whole report.
pub fn text(results: &Results) -> String {
    let mut text = format!(
        "{} ({})\nsigma {}, kernel {}, gaze ({}, {}), {} degrees across\n",
        results.device,
        results.driver,
        results.sigma,
        results.kernel,
        results.gaze[0],
        results.gaze[1],
        results.hfov_deg
    );
    text += "Speed-ups are medians of the ratios in alternating pairs of frames.\n";
    text += "Published figures: GTX 1080; times compare only within one device, ratios everywhere.\n";
    section(&mut text, "Speed-up (published: table 4.2)", &speedups(&results.rows));
    section(&mut text, "What the post filter of Eq. 2.14 adds", &post_filter(results));
    if !results.light_sweep.is_empty() {
        section(&mut text, "Speed-up over the number of lights (hall)", &speedups(&results.light_sweep));
    }
    let mut shown = Vec::new();
    for row in &results.rows {
        if shown.contains(&&row.scene) {
            continue;
        }
        shown.push(&row.scene);
        let title = format!("Passes of {} at {}x{}, ms", row.scene, row.size[0], row.size[1]);
        section(&mut text, &title, &passes(row));
    }
    section(
        &mut text,
        "Passes as published (table 4.1: Bistro at 1920x1080, GTX 1080), ms",
        &published_passes(),
    );
    text
}

fn section(text: &mut String, title: &str, body: &str) {
    _ = write!(text, "\n{title}\n{body}");
}

fn speedups(rows: &[Row]) -> String {
    let published = rows.iter().any(|row| row.published_speedup.is_some());
    let header = ["scene", "lights", "size", "full ms", "KFR ms", "pairs", "speed-up", "least..greatest"];
    let header = header.into_iter().chain(published.then_some("published"));
    let header = header.chain(["samples full", "samples KFR", "filter+inverse", "foveation"]);
    let cells = rows.iter().map(|row| {
        let mut cells = vec![
            row.scene.clone(),
            row.lights.map_or("-".into(), |lights| lights.to_string()),
            format!("{}x{}", row.size[0], row.size[1]),
            format!("{:.2}", row.full_ms),
            format!("{:.2}", row.kfr_ms),
            row.runs.to_string(),
            format!("{:.2}x", row.speedup),
            format!("{:.2}..{:.2}", row.spread.low, row.spread.high),
        ];
        if published {
            cells.push(row.published_speedup.map_or("-".into(), |speedup| format!("{speedup:.1}x")));
        }
        cells.extend([
            grouped(row.samples_full),
            grouped(row.samples_kfr),
            format!("{:.1} %", row.added_share * 100.0),
            if row.pays { "pays".into() } else { "does not pay".into() },
        ]);
        cells
    });
    table(&header.collect::<Vec<_>>(), &cells.collect::<Vec<_>>())
}

fn post_filter(results: &Results) -> String {
    let cells = results.post_filter.iter().map(|row| {
        vec![
            row.scene.clone(),
            format!("{}x{}", row.size[0], row.size[1]),
            format!("{:.2}", row.kfr_with_post_filter_ms),
            format!("{:.2}", row.post_filter_ms),
            format!("{:.1} %", row.share * 100.0),
        ]
    });
    let header = ["scene", "size", "KFR with it, ms", "the filter, ms", "of the full frame"];
    table(&header, &cells.collect::<Vec<_>>())
}

/// Every pass of either variant, in the order in which they run.
fn passes(row: &Row) -> String {
    let time_in = |passes: &[PassMedian], name: &str| {
        let found = passes.iter().find(|pass| pass.name == name);
        found.map_or("-".into(), |pass| format!("{:.3}", pass.gpu_ms))
    };
    let mut names = row.passes_full.iter().map(|pass| pass.name).collect::<Vec<_>>();
    for (place, pass) in row.passes_kfr.iter().enumerate() {
        if !names.contains(&pass.name) {
            // After the pass that precedes it in the KFR frame.
            let before = row.passes_kfr[..place].last();
            let at = before.and_then(|before| names.iter().position(|name| *name == before.name));
            names.insert(at.map_or(0, |at| at + 1), pass.name);
        }
    }
    let cells =
        |name: &str| vec![name.to_owned(), time_in(&row.passes_full, name), time_in(&row.passes_kfr, name)];
    let mut rows = names.into_iter().map(cells).collect::<Vec<_>>();
    rows.push(vec!["total".into(), format!("{:.3}", row.full_ms), format!("{:.3}", row.kfr_ms)]);
    table(&["pass", "full", "KFR"], &rows)
}

fn published_passes() -> String {
    let time = |ms: Option<f64>| ms.map_or("-".into(), |ms| format!("{ms:.3}"));
    let row = |pass: &paper::PublishedPass| vec![pass.name.into(), time(pass.full_ms), time(pass.kfr_ms)];
    table(&["pass", "full", "KFR"], &paper::PASSES.iter().map(row).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::super::run::{PostFilterRow, Spread};
    use super::*;

    fn row(scene: &str, speedup: f64) -> Row {
        let pass = |name, gpu_ms| PassMedian { name, gpu_ms };
        Row {
            size: [1920, 1080],
            scene: scene.into(),
            lights: Some(256),
            runs: 3,
            full_ms: 30.0,
            kfr_ms: 30.0 / speedup,
            speedup,
            spread: Spread { kind: "", low: speedup - 0.1, high: speedup + 0.1 },
            samples_full: 2_073_600,
            samples_kfr: 500_000,
            passes_full: vec![pass("gbuffer", 3.0), pass("full_shade", 27.0)],
            passes_kfr: vec![pass("gbuffer", 3.0), pass("lp_shade", 6.0), pass("inverse", 1.0)],
            added_share: 0.033,
            published_speedup: Some(2.0),
            pays: speedup >= 1.05,
        }
    }

    fn results(rows: Vec<Row>) -> Results {
        Results {
            device: "GPU".into(),
            driver: "driver".into(),
            method: "kfr",
            sigma: 1.8,
            kernel: "Power".into(),
            hfov_deg: 100.0,
            gaze: [0.5, 0.5],
            warnings: vec![],
            rows,
            light_sweep: vec![row("hall", 0.9)],
            post_filter: vec![PostFilterRow {
                size: [1920, 1080],
                scene: "hall".into(),
                kfr_with_post_filter_ms: 12.0,
                post_filter_ms: 2.0,
                share: 0.066,
            }],
            published_rates: paper::RATES,
            published_passes: paper::PASSES,
        }
    }

    #[test]
    fn it_says_where_foveation_does_not_pay() {
        let text = text(&results(vec![row("hall", 2.5)]));
        assert_eq!(text.matches("does not pay").count(), 1, "{text}");
        assert!(text.contains("2.50x") && text.contains("2.0x") && text.contains("3.3 %"), "{text}");
    }

    #[test]
    fn passes_stand_in_frame_order() {
        let text = passes(&row("hall", 3.0));
        let place = |name: &str| text.find(name);
        assert!(place("gbuffer") < place("lp_shade") && place("lp_shade") < place("inverse"), "{text}");
        assert!(place("inverse") < place("total"), "{text}");
    }
}
