//! A latency run in words and tables.

use super::{LatencyArgs, PresetRow, Report};
use crate::output;
use macula_trackers::latency::{Budget, Figures, StageShare};

pub(super) fn text(report: &Report, args: &LatencyArgs) -> String {
    let summary = &report.summary;
    let mut text = format!("{}\n\n", report.conclusion.headline);
    for sentence in &report.conclusion.sentences {
        text += &format!("{sentence}\n");
    }
    text += &format!("\n{}, mean times from the eye to the light\n", summary.model);
    text += &stages(&summary.budget);
    text += &format!(
        "\n{}",
        figures(&[
            ("age, ms", summary.age_ms),
            ("error, all refreshes, deg", summary.error_deg),
            ("error, resting and seeing, deg", summary.counted_error_deg),
        ])
    );
    text += &format!("\n{}", budget(&summary.budget));
    let late = summary.late_latch;
    text += &format!(
        "late latch       {} {:.1} ms, {:.2} deg\n",
        if late.used { "gains" } else { "would gain" },
        late.gain_ms,
        late.gain_deg
    );
    text += &format!(
        "refreshes        {} at {:.0} Hz: {} counted, {} with a picture shown again, {} without a gaze, {} with an \
         older gaze over a loss, {} with the true gaze unknown\n\n",
        output::grouped(summary.frames as u64),
        summary.refresh_hz,
        output::grouped(summary.frames_counted as u64),
        output::grouped(summary.frames_repeated as u64),
        output::grouped(summary.frames_without_gaze as u64),
        output::grouped(summary.frames_over_loss as u64),
        output::grouped(summary.frames_not_judged as u64)
    );
    for note in &summary.notes {
        text += &format!("note: {note}\n");
    }
    for path in [&args.output, &args.ledger, &args.sample_ledger].into_iter().flatten() {
        text += &format!("wrote {}\n", path.display());
    }
    text
}

fn stages(budget: &Budget) -> String {
    let row = |stage: &StageShare| {
        vec![
            stage.stage.name().replace('_', " "),
            format!("{:.2}", stage.mean_ms),
            format!("{:.1}", stage.share * 100.0),
            format!("{:.2}", stage.saved_if_half_deg),
            if stage.guess { format!("guess: {}", stage.source) } else { stage.source.clone() },
        ]
    };
    let rows = budget.stages.iter().map(row).collect::<Vec<_>>();
    output::table(&["stage", "ms", "%", "deg saved if halved", "source"], &rows)
}

fn figures(rows: &[(&str, Figures)]) -> String {
    let row = |(name, figures): &(&str, Figures)| {
        let values = [figures.p50, figures.p95, figures.max];
        std::iter::once((*name).to_owned()).chain(values.map(|value| format!("{value:.2}"))).collect()
    };
    let rows = rows.iter().map(row).collect::<Vec<Vec<String>>>();
    output::table(&["", "half are at most", "95 % are at most", "largest"], &rows)
}

fn budget(budget: &Budget) -> String {
    let degrees = |value: Option<f64>| value.map_or("none".into(), |value| format!("{value:.2} deg"));
    let allowed = match budget.largest_latency_ms {
        Some(ms) if budget.beyond_sweep => format!("{ms:.0} ms and more"),
        Some(ms) => format!("{ms:.1} ms"),
        None => "none is small enough".into(),
    };
    format!(
        "radius           {} deg, gaze outside for at most {} % of the time\n\
         latency now      {:.1} ms\n\
         latency allowed  {allowed}\n\
         radius needed    {} ({} for 95 % of the time)\n",
        budget.radius_deg,
        budget.target_outside * 100.0,
        budget.latency_ms,
        degrees(budget.needed_radius_deg),
        degrees(budget.needed_radius_p95_deg)
    )
}

pub(super) fn presets(rows: &[PresetRow]) -> String {
    let row = |preset: &PresetRow| {
        let rate = preset.tracker_rate_hz.map_or("-".into(), |rate_hz| format!("{rate_hz}"));
        vec![preset.name.to_owned(), rate, format!("{}", preset.refresh_hz), preset.about.clone()]
    };
    let rows = rows.iter().map(row).collect::<Vec<_>>();
    output::table(&["preset", "tracker Hz", "display Hz", "model of"], &rows)
}
