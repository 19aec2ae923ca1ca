//! The page of a run: one HTML file that needs nothing else, not even a network or a script.

use super::figures::Figures;
use super::plot::{Labels, Plot, escaped, number};
use super::report::{Bin, ClosePoint, Histogram, ReportData};
use super::stage::Stage;
use super::verdict::{Verdict, verdict};
use std::fmt::Write;

const TEMPLATE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");

/// Sizes of full-width plots for a wide page and for a phone, px.
const WIDE: f64 = 1080.0;
const NARROW: f64 = 400.0;

/// The page's text.
#[must_use]
pub fn page(data: &ReportData) -> String {
    let Verdict { class, headline, sentences } = verdict(&data.summary);
    let conclusion: String =
        sentences.iter().fold(String::new(), |text, one| text + "<p>" + &escaped(one) + "</p>\n");
    let close = |label: &str, axis: usize| both(|width| close_gaze(data, width, label, axis));
    let length_s = data.close.first().zip(data.close.last()).map_or(0.0, |(a, b)| b.time_s - a.time_s);
    let values = [
        ("style", STYLE.to_owned()),
        ("title", escaped(&data.title)),
        ("about", escaped(&data.about)),
        ("class", class.to_owned()),
        ("headline", escaped(&headline)),
        ("conclusion", conclusion),
        ("cards", cards(data)),
        ("group_names", group_names()),
        ("stages", both(|width| stages(data, width))),
        ("stage_rows", stage_rows(data)),
        ("close_s", number((length_s * 10.0).round() / 10.0)),
        ("azimuth", close("Azimuth, deg", 0)),
        ("elevation", close("Elevation, deg", 1)),
        ("error", both(|width| close_error(data, width))),
        ("overview_gaze", both(|width| overview_gaze(data, width))),
        ("overview_error", both(|width| overview_error(data, width))),
        ("age_histogram", age_histogram(data)),
        ("error_histogram", error_histogram(data)),
        ("inside", number((1.0 - data.summary.budget.target_outside) * 100.0)),
        ("curve", both(|width| curve(data, width))),
        ("figure_rows", figure_rows(data)),
        ("facts", facts(data)),
        ("notes", notes(data)),
    ];
    let mut html = String::with_capacity(1 << 19);
    let mut rest = TEMPLATE;
    while let Some((before, after)) = rest.split_once("{{") {
        html.push_str(before);
        let Some((name, after)) = after.split_once("}}") else { break };
        html.push_str(values.iter().find(|(key, _)| *key == name).map_or("", |(_, value)| value));
        rest = after;
    }
    html + rest
}

fn both(draw: impl Fn(f64) -> String) -> String {
    format!("<div class=\"wide\">{}</div><div class=\"narrow\">{}</div>", draw(WIDE), draw(NARROW))
}

fn cards(data: &ReportData) -> String {
    let summary = &data.summary;
    let card = |value: String, what: &str| format!("<div><b>{value}</b><span>{what}</span></div>");
    let percent = |share: Option<f64>| {
        share.map_or("none".into(), |share| format!("{} %", number((share * 10_000.0).round() / 100.0)))
    };
    card(percent(summary.outside_fraction), "of resting time the gaze lies outside")
        + &card(format!("{:.1} ms", summary.age_ms.p50), "age of the gaze at the light (median)")
        + &card(format!("{:.2}°", summary.error_deg.p95), "error that 95 % of refreshes keep below")
        + &card(
            summary.budget.needed_radius_deg.map_or("none".into(), |radius| format!("{radius:.2}°")),
            "radius that would be needed",
        )
}

/// A stage's class of colour.
fn group(stage: Stage) -> &'static str {
    match stage {
        Stage::Exposure | Stage::Readout | Stage::TrackerProcessing => "tracker",
        Stage::Polling | Stage::Wakeup | Stage::FilterDelay | Stage::SamplingWait => "host",
        Stage::Cpu | Stage::Gpu => "renderer",
        Stage::Compositor | Stage::Pacing | Stage::Scanout | Stage::Panel => "display",
    }
}

fn group_names() -> String {
    ["tracker", "host", "renderer", "display"]
        .into_iter()
        .map(|name| format!("<span class=\"group\"><span class=\"chip {name}\"></span> {name}</span> "))
        .collect()
}

fn words(stage: Stage) -> String {
    stage.name().replace('_', " ")
}

/// All stages as one bar, and below it each where it lies in the bar.
fn stages(data: &ReportData, width: f64) -> String {
    const ROW: f64 = 22.0;
    let stages = &data.summary.budget.stages;
    let total_ms: f64 = stages.iter().map(|stage| stage.mean_ms.max(0.0)).sum();
    let (left, right) = (136.0, width - 62.0);
    let height = (stages.len() + 1) as f64 * ROW + 8.0;
    let x = |ms: f64| left + (right - left) * ms / total_ms.max(1e-9);
    let mut svg = format!(
        "<svg viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\"><title>Latency by stage, {total_ms:.1} ms in \
         all</title><text x=\"{:.0}\" y=\"17\" text-anchor=\"end\">all</text>\
         <text x=\"{:.1}\" y=\"17\">{total_ms:.1} ms</text>",
        left - 8.0,
        right + 6.0
    );
    let mut at_ms = 0.0;
    for (stage, row) in stages.iter().zip(1..) {
        let (from, to) = (x(at_ms), x(at_ms + stage.mean_ms.max(0.0)));
        at_ms += stage.mean_ms.max(0.0);
        let y = f64::from(row) * ROW;
        let name = words(stage.stage);
        let class = group(stage.stage);
        let bar = |y: f64, height: f64| {
            format!(
                "<rect class=\"{class}\" x=\"{from:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{height}\">\
                 <title>{name}: {:.2} ms</title></rect>",
                (to - from - 0.6).max(0.6),
                stage.mean_ms
            )
        };
        svg += &bar(3.0, 18.0);
        svg += &bar(y + 6.0, 14.0);
        // Before the bar where there is no room behind it.
        let (at, anchor) = if to + 90.0 < width { (to + 5.0, "start") } else { (from - 5.0, "end") };
        _ = write!(
            svg,
            "<text x=\"{:.0}\" y=\"{:.1}\" text-anchor=\"end\">{name}</text>\
             <text class=\"tick\" x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{:.1}{}</text>",
            left - 8.0,
            y + 18.0,
            y + 18.0,
            stage.mean_ms,
            if stage.guess && stage.mean_ms > 0.0 { " (guess)" } else { "" }
        );
    }
    svg + "</svg>"
}

fn stage_rows(data: &ReportData) -> String {
    let mut rows = String::new();
    for stage in &data.summary.budget.stages {
        let guess = if stage.guess { "<span class=\"guess\">guess: </span>" } else { "" };
        _ = writeln!(
            rows,
            "<tr><th scope=\"row\"><span class=\"chip {}\"></span> {}</th><td>{:.2}</td><td>{:.1}</td>\
             <td>{:.2}</td><td>{:.2}</td><td>{guess}{}</td></tr>",
            group(stage.stage),
            words(stage.stage),
            stage.mean_ms,
            stage.share * 100.0,
            stage.saved_if_half_deg,
            stage.saved_if_zero_deg,
            escaped(&stage.source)
        );
    }
    rows
}

/// The range of some values with a margin; at least 1 wide.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let found = values.filter(|value| value.is_finite());
    let [low, high] = found
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
    if low > high {
        return [-1.0, 1.0];
    }
    let margin = ((high - low) * 0.06).max(0.5);
    [low - margin, high + margin]
}

fn times(points: &[ClosePoint]) -> [f64; 2] {
    points.first().zip(points.last()).map_or([0.0, 1.0], |(first, last)| [first.time_s, last.time_s])
}

fn shade(plot: &mut Plot, data: &ReportData) {
    for span in data.spans.iter().filter(|span| !matches!(span.state, "fixation" | "unknown")) {
        let length_ms = (span.end_s - span.start_s) * 1e3;
        let title = format!("{}, {:.0} ms", span.state, length_ms);
        plot.band(span.start_s, span.end_s, &format!("ev-{}", span.state), &title);
    }
}

fn close_gaze(data: &ReportData, width: f64, label: &str, axis: usize) -> String {
    let pick = |angles: Option<[f64; 2]>| angles.and_then(|angles| angles.get(axis).copied());
    let all = data.close.iter().flat_map(|point| [pick(point.used_deg), pick(point.true_deg)]);
    let labels = Labels { title: &format!("{label}, true and used, over time"), x: "Time, s", y: label };
    let mut plot = Plot::new([width, 210.0], times(&data.close), range(all.flatten()), &labels);
    shade(&mut plot, data);
    plot.steps(data.close.iter().map(|point| (point.time_s, pick(point.used_deg))), "used");
    plot.line(data.close.iter().map(|point| (point.time_s, pick(point.true_deg))), "true");
    plot.finish()
}

fn radius_name(data: &ReportData) -> String {
    format!("radius {}°", number(data.summary.budget.radius_deg))
}

fn close_error(data: &ReportData, width: f64) -> String {
    let radius_deg = data.summary.budget.radius_deg;
    let most = data.close.iter().filter_map(|point| point.error_deg).fold(radius_deg, f64::max);
    let labels = Labels { title: "Error over time, with the radius", x: "Time, s", y: "Error, deg" };
    let mut plot = Plot::new([width, 230.0], times(&data.close), [0.0, most * 1.15 + 0.1], &labels);
    shade(&mut plot, data);
    plot.line(data.close.iter().map(|point| (point.time_s, point.error_deg)), "error");
    plot.level(radius_deg, "radius", &radius_name(data));
    for point in data.close.iter().filter(|point| point.missed) {
        plot.dot(point.time_s, point.error_deg.unwrap_or(0.0), "miss");
    }
    plot.finish()
}

fn session_times(bins: &[Bin]) -> [f64; 2] {
    bins.first().zip(bins.last()).map_or([0.0, 1.0], |(first, last)| [first.time_s, last.time_s])
}

fn overview_gaze(data: &ReportData, width: f64) -> String {
    let bins = &data.overview;
    let ends = bins.iter().flat_map(|bin| [bin.azimuth_deg, bin.elevation_deg]).flatten().flatten();
    let labels = Labels { title: "Gaze over the whole session", x: "Time, s", y: "Gaze, deg" };
    let mut plot = Plot::new([width, 210.0], session_times(bins), range(ends), &labels);
    plot.ranges(bins.iter().filter_map(|bin| Some((bin.time_s, bin.azimuth_deg?))), "true-range");
    plot.ranges(bins.iter().filter_map(|bin| Some((bin.time_s, bin.elevation_deg?))), "used-range");
    plot.finish()
}

fn overview_error(data: &ReportData, width: f64) -> String {
    let bins = &data.overview;
    let radius_deg = data.summary.budget.radius_deg;
    let most = bins.iter().filter_map(|bin| bin.error_deg).fold(radius_deg, f64::max);
    let labels = Labels { title: "Largest errors over the whole session", x: "Time, s", y: "Error, deg" };
    let mut plot = Plot::new([width, 210.0], session_times(bins), [0.0, most * 1.1 + 0.1], &labels);
    plot.ranges(bins.iter().filter_map(|bin| Some((bin.time_s, [0.0, bin.error_deg?]))), "low");
    let counted = || bins.iter().filter_map(|bin| Some((bin.time_s, [0.0, bin.counted_error_deg?])));
    plot.ranges(counted(), "true-range");
    plot.ranges(counted().filter(|(_, [_, error_deg])| *error_deg > radius_deg), "miss-range");
    plot.level(radius_deg, "radius", &radius_name(data));
    plot.finish()
}

fn bars(histogram: &Histogram, labels: &Labels<'_>, unit: &str, out_from: f64) -> Plot {
    let to = histogram.from + histogram.width * histogram.shares.len() as f64;
    let most = histogram.shares.iter().copied().fold(0.0, f64::max) * 100.0;
    let mut plot = Plot::new([460.0, 260.0], [histogram.from, to], [0.0, most * 1.2 + 0.1], labels);
    for (number_of, share) in histogram.shares.iter().enumerate().filter(|(_, share)| **share > 0.0) {
        let from = histogram.from + histogram.width * number_of as f64;
        let class = if from >= out_from { "bar out" } else { "bar" };
        let title =
            format!("{} to {} {unit}: {:.2} %", number(from), number(from + histogram.width), share * 100.0);
        plot.bar(from, from + histogram.width, share * 100.0, class, &title);
    }
    plot
}

fn age_histogram(data: &ReportData) -> String {
    let age = data.summary.age_ms;
    let labels = Labels { title: "Distribution of the age", x: "Age, ms", y: "Refreshes, %" };
    let mut plot = bars(&data.age_ms, &labels, "ms", f64::INFINITY);
    plot.marks(vec![
        (age.p50, "now", format!("half {:.1}", age.p50)),
        (age.p95, "p95", format!("95 % {:.1}", age.p95)),
    ]);
    plot.finish()
}

fn error_histogram(data: &ReportData) -> String {
    let error = data.summary.counted_error_deg;
    let radius_deg = data.summary.budget.radius_deg;
    let labels = Labels { title: "Distribution of the error", x: "Error, deg", y: "Refreshes, %" };
    let mut plot = bars(&data.error_deg, &labels, "deg", radius_deg);
    plot.marks(vec![
        (error.p95, "p95", format!("95 % {:.2}", error.p95)),
        (radius_deg, "radius", radius_name(data)),
    ]);
    plot.finish()
}

fn curve(data: &ReportData, width: f64) -> String {
    let budget = &data.summary.budget;
    let to_ms = budget.curve.last().map_or(1.0, |last| last.latency_ms);
    let most = budget.curve.iter().map(|point| point.radius_deg).fold(budget.radius_deg, f64::max);
    let labels =
        Labels { title: "Radius needed by latency", x: "Mean age of the gaze, ms", y: "Radius needed, deg" };
    let mut plot = Plot::new([width, 300.0], [0.0, to_ms], [0.0, most * 1.15 + 0.1], &labels);
    if let Some(tolerated) = budget.references.iter().find(|reference| !reference.added) {
        let title = format!("{}, {}", tolerated.what, tolerated.source);
        plot.band(tolerated.from_ms, tolerated.to_ms, "ev-tolerated", &title);
    }
    let points = || budget.curve.iter();
    plot.line(points().map(|point| (point.latency_ms, Some(point.radius_p95_deg))), "low");
    plot.line(points().map(|point| (point.latency_ms, Some(point.radius_deg))), "true");
    plot.level(budget.radius_deg, "radius", &radius_name(data));
    let mut marks = vec![(budget.latency_ms, "now", format!("now {:.1} ms", budget.latency_ms))];
    let largest_ms = budget.largest_latency_ms.filter(|_| !budget.beyond_sweep);
    marks.extend(largest_ms.map(|largest_ms| (largest_ms, "p95", format!("at most {largest_ms:.1} ms"))));
    plot.marks(marks);
    plot.finish()
}

fn figure_rows(data: &ReportData) -> String {
    let summary = &data.summary;
    let row = |name: &str, figures: &Figures| {
        format!(
            "<tr><th scope=\"row\">{name}</th><td>{:.2}</td><td>{:.2}</td><td>{:.2}</td>\
             <td class=\"num\">{:.2}</td></tr>\n",
            figures.p50, figures.p95, figures.max, figures.mean
        )
    };
    row("Age, ms", &summary.age_ms)
        + &row("Error, all refreshes, deg", &summary.error_deg)
        + &row("Error, resting and seeing, deg", &summary.counted_error_deg)
}

fn facts(data: &ReportData) -> String {
    let summary = &data.summary;
    let percent =
        |share: Option<f64>| share.map_or("no such time".into(), |share| format!("{:.2} %", share * 100.0));
    let late = &summary.late_latch;
    let facts = [
        ("Outside, resting and seeing", percent(summary.outside_fraction)),
        ("Outside, resting, suppressed time too", percent(summary.outside_fraction_unsuppressed)),
        ("Outside, all refreshes", percent(summary.outside_fraction_raw)),
        (
            "Eye movement to its first light",
            summary.eye_to_photon_ms.map_or("unknown".into(), |ms| format!("{ms:.1} ms (mean)")),
        ),
        (
            if late.used { "Late latch gains" } else { "A late latch would gain" },
            format!("{:.1} ms, {:.2} deg", late.gain_ms, late.gain_deg),
        ),
        ("Session", format!("{:.1} s, {:.0} samples a second", summary.duration_s, summary.rate_hz)),
        ("Tracker", format!("{:.0} samples a second", summary.tracker_rate_hz)),
        ("Display", format!("{} refreshes a second", number(summary.refresh_hz))),
        ("Refreshes", summary.frames.to_string()),
        ("that show a picture again", summary.frames_repeated.to_string()),
        ("without any gaze", summary.frames_without_gaze.to_string()),
        ("with an older gaze over a loss", summary.frames_over_loss.to_string()),
        ("where the true gaze is unknown", summary.frames_not_judged.to_string()),
        ("that count", summary.frames_counted.to_string()),
    ];
    facts.iter().map(|(name, value)| format!("<dt>{name}</dt><dd>{}</dd>\n", escaped(value))).collect()
}

fn notes(data: &ReportData) -> String {
    if data.summary.notes.is_empty() {
        return String::new();
    }
    let items: String = data.summary.notes.iter().map(|note| format!("<li>{}</li>", escaped(note))).collect();
    format!("<h2>To know when reading this</h2><ul>{items}</ul>")
}
