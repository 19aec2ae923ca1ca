//! The rates as an SVG plot: one panel for each gaze, one colour for each method and display.

use super::report::{Curve, Results};
use super::summary::{Rate, Row, Spread};
use crate::page::axis::{COLORS, decades, steps};
use crate::page::escaped;
use clap::ValueEnum;
use std::fmt::Write;

/// How rates lie along the y axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Scale {
    /// Equal ratios are equally far apart
    Log,
    /// From 0
    Linear,
}

/// Curves that a panel tells apart by colour.
pub const MOST_CURVES: usize = COLORS.len();

const PANEL: [f64; 2] = [560.0, 400.0];
/// Around a panel's axes: left, top, right, bottom.
const MARGIN: [f64; 4] = [58.0, 40.0, 14.0, 48.0];
const LEGEND_LINE: f64 = 22.0;

const STYLE: &str = "\
svg{background:#fff;font:13px system-ui,sans-serif}\
text{fill:#1b1d21}.soft{fill:#5b616b}.title{font-size:15px;font-weight:600}\
.grid{stroke:#e3e5e9}.axis{stroke:#5b616b}\
path{fill:none;stroke-width:1}\
.radial,.tangential{stroke-width:2;stroke-linejoin:round}.tangential{stroke-dasharray:7 4}\
.acuity{stroke:#000;stroke-opacity:.22;stroke-width:7;stroke-linejoin:round}\
.limit{stroke:#5b616b;stroke-width:1.5;stroke-dasharray:1.5 3.5}\
.band{fill-opacity:.13;stroke:none}.dot{stroke:none}";

const DARK_STYLE: &str = "\
svg{background:#14161a}text{fill:#e9ebef}.soft{fill:#a2a9b5}\
.grid{stroke:#2b3038}.axis{stroke:#a2a9b5}.acuity{stroke:#fff;stroke-opacity:.28}.limit{stroke:#a2a9b5}";

/// The plot as a file's text.
pub fn svg(results: &Results, scale: Scale) -> String {
    let panels: Vec<&[Curve]> = results.curves.chunk_by(|a, b| a.gaze.label == b.gaze.label).collect();
    let columns = panels.len().clamp(1, 2);
    let rows = panels.len().div_ceil(columns);
    let axes = Axes::new(&results.curves, scale);
    let legend = legend(results, panels.first().copied().unwrap_or_default());
    let width = PANEL[0] * columns as f64;
    let legend_top = PANEL[1] * rows as f64 + 8.0;
    let legend_lines = legend.curves.len().div_ceil(columns) + legend.common.len();
    let height = legend_top + LEGEND_LINE * legend_lines as f64 + 8.0;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
         height=\"{height}\" role=\"img\">\n<title>Shading rates over eccentricity</title>\n\
         <desc>Cycles per degree over degrees from the gaze; acuity: {}</desc>\n<style>{}</style>\n\
         <clipPath id=\"inside\"><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/></clipPath>\n",
        escaped(&results.acuity),
        style(),
        MARGIN[0],
        MARGIN[1],
        axes.size[0],
        axes.size[1]
    );
    for (at, curves) in panels.iter().enumerate() {
        let (x, y) = (PANEL[0] * (at % columns) as f64, PANEL[1] * (at / columns) as f64);
        _ = writeln!(svg, "<g transform=\"translate({x} {y})\">\n{}</g>", panel(curves, &axes));
    }
    let mut entry = |column: usize, line: usize, text: &str| {
        let x = MARGIN[0] + PANEL[0] * column as f64;
        let y = legend_top + LEGEND_LINE * line as f64;
        _ = writeln!(svg, "<g transform=\"translate({x} {y})\">{text}</g>");
    };
    for (at, text) in legend.curves.iter().enumerate() {
        entry(at % columns, at / columns, text);
    }
    for (at, text) in legend.common.iter().enumerate() {
        entry(0, legend_lines - legend.common.len() + at, text);
    }
    svg + "</svg>\n"
}

fn style() -> String {
    let colors = |ground: usize| {
        let color = |(at, color): (usize, &[&str; 2])| {
            let color = color[ground];
            format!(".c{at}{{stroke:{color}}}.f{at}{{fill:{color}}}")
        };
        COLORS.iter().enumerate().map(color).collect::<String>()
    };
    format!("{STYLE}{}@media (prefers-color-scheme:dark){{{DARK_STYLE}{}}}", colors(0), colors(1))
}

/// From degrees and cycles per degree to a panel.
struct Axes {
    scale: Scale,
    most_deg: f64,
    cpd: [f64; 2],
    size: [f64; 2],
}

impl Axes {
    /// Wide enough for all curves.
    fn new(curves: &[Curve], scale: Scale) -> Self {
        let rows = || curves.iter().flat_map(|curve| &curve.analytic.rows);
        let rates = || rows().flat_map(|row| [row.radial, row.tangential]).flatten();
        let most_deg = rows().map(|row| row.ecc_deg).fold(1.0, f64::max);
        let acuities = rates().map(|rate| rate.limits.acuity_cpd);
        let (least_acuity, most_acuity) = acuities
            .fold((f64::INFINITY, 1e-3), |(low, high), cpd| (f64::min(low, cpd), f64::max(high, cpd)));
        // Some methods' rates have no bound at the gaze; it is enough to see that they leave the panel.
        let most = rates().map(|rate| rate.cpd.max).filter(|cpd| cpd.is_finite()).fold(most_acuity, f64::max);
        let least = rates().map(|rate| rate.cpd.min).filter(|cpd| *cpd > 0.0).fold(least_acuity, f64::min);
        let high = most.min(2.0 * most_acuity) * 1.1;
        let low = match scale {
            Scale::Linear => 0.0,
            Scale::Log => least.max(least_acuity.min(high) / 20.0).min(high / 2.0) / 1.1,
        };
        let size = [PANEL[0] - MARGIN[0] - MARGIN[2], PANEL[1] - MARGIN[1] - MARGIN[3]];
        Self { scale, most_deg, cpd: [low, high], size }
    }

    fn x(&self, deg: f64) -> f64 {
        MARGIN[0] + self.size[0] * deg / self.most_deg
    }

    /// Clamped to a little outside, where it is clipped.
    fn y(&self, cpd: f64) -> f64 {
        let [low, high] = self.cpd;
        let share = match self.scale {
            Scale::Linear => (cpd - low) / (high - low),
            Scale::Log => (cpd.max(low / 2.0) / low).ln() / (high / low).ln(),
        };
        MARGIN[1] + self.size[1] * (1.0 - share.clamp(-0.1, 1.1))
    }

    fn ticks_deg(&self) -> Vec<f64> {
        steps(self.most_deg, 8.0)
    }

    fn ticks_cpd(&self) -> Vec<f64> {
        let [low, high] = self.cpd;
        if self.scale == Scale::Linear {
            return steps(high, 8.0);
        }
        decades(low, high, &[1.0, 2.0, 5.0])
    }
}

fn panel(curves: &[Curve], axes: &Axes) -> String {
    let mut svg = grid(axes);
    let gaze = curves.first().map_or("", |curve| &curve.gaze.label);
    _ = writeln!(
        svg,
        "<text class=\"title\" x=\"{}\" y=\"24\">{}</text>\n<g clip-path=\"url(#inside)\">",
        MARGIN[0],
        escaped(gaze)
    );
    if let Some(rows) = curves.iter().map(|curve| &curve.analytic.rows).max_by_key(|rows| rows.len()) {
        line(&mut svg, axes, "acuity", rows, |row| Some(row.radial?.limits.acuity_cpd));
    }
    let mut displays: Vec<&str> = vec![];
    for curve in curves {
        if !displays.contains(&curve.display.label.as_str()) {
            displays.push(&curve.display.label);
            line(&mut svg, axes, "limit", &curve.analytic.rows, |row| {
                let [radial, tangential] = [row.radial?, row.tangential?];
                Some((radial.limits.display_cpd * tangential.limits.display_cpd).sqrt())
            });
        }
    }
    for (at, curve) in (0..MOST_CURVES).cycle().zip(curves) {
        for (class, rate) in [("radial", radial as fn(&Row) -> Option<Rate>), ("tangential", tangential)] {
            band(&mut svg, axes, at, &curve.analytic.rows, |row| Some(rate(row)?.cpd));
            line(&mut svg, axes, &format!("{class} c{at}"), &curve.analytic.rows, |row| {
                Some(rate(row)?.cpd.mean)
            });
            dots(&mut svg, axes, at, &curve.counted.rows, |row| Some(rate(row)?.cpd.mean));
        }
    }
    svg + "</g>\n"
}

fn radial(row: &Row) -> Option<Rate> {
    row.radial
}

fn tangential(row: &Row) -> Option<Rate> {
    row.tangential
}

fn grid(axes: &Axes) -> String {
    let [left, top, ..] = MARGIN;
    let (right, bottom) = (left + axes.size[0], top + axes.size[1]);
    let mut svg = String::new();
    for tick in axes.ticks_cpd() {
        let y = axes.y(tick);
        _ = writeln!(
            svg,
            "<path class=\"grid\" d=\"M{left} {y:.1}H{right}\"/>\
             <text class=\"soft\" x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            left - 8.0,
            y + 4.0,
            number(tick)
        );
    }
    for tick in axes.ticks_deg() {
        let x = axes.x(tick);
        _ = writeln!(
            svg,
            "<path class=\"axis\" d=\"M{x:.1} {bottom}v5\"/>\
             <text class=\"soft\" x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            bottom + 19.0,
            number(tick)
        );
    }
    let (middle_x, middle_y) = (f64::midpoint(left, right), f64::midpoint(top, bottom));
    svg + &format!(
        "<path class=\"axis\" d=\"M{left} {top}V{bottom}H{right}\"/>\
         <text x=\"{middle_x}\" y=\"{}\" text-anchor=\"middle\">Eccentricity (degrees from the gaze)</text>\
         <text transform=\"translate(16 {middle_y}) rotate(-90)\" text-anchor=\"middle\">Shading rate \
         (cycles per degree)</text>\n",
        bottom + 38.0
    )
}

/// At most four decimals, without trailing zeros.
fn number(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

fn finite(axes: &Axes, row: &Row, cpd: f64) -> Option<(f64, f64)> {
    cpd.is_finite().then(|| (axes.x(row.ecc_deg), axes.y(cpd)))
}

/// A line through the rows; it breaks where a value is missing.
fn line(svg: &mut String, axes: &Axes, class: &str, rows: &[Row], value: impl Fn(&Row) -> Option<f64>) {
    let mut path = String::new();
    let mut pen = 'M';
    for row in rows {
        match value(row).and_then(|cpd| finite(axes, row, cpd)) {
            Some((x, y)) => {
                _ = write!(path, "{pen}{x:.1} {y:.1}");
                pen = 'L';
            }
            None => pen = 'M',
        }
    }
    _ = writeln!(svg, "<path class=\"{class}\" d=\"{path}\"/>");
}

/// The area between least and greatest.
fn band(svg: &mut String, axes: &Axes, color: usize, rows: &[Row], value: impl Fn(&Row) -> Option<Spread>) {
    let mut upper = vec![];
    let mut lower = vec![];
    for row in rows {
        let Some(spread) = value(row) else { continue };
        if let (Some(low), Some(high)) = (finite(axes, row, spread.min), finite(axes, row, spread.max)) {
            lower.push(low);
            upper.push(high);
        }
    }
    let points = upper.into_iter().chain(lower.into_iter().rev());
    let points = points.map(|(x, y)| format!("{x:.1},{y:.1}")).collect::<Vec<_>>().join(" ");
    _ = writeln!(svg, "<polygon class=\"band f{color}\" points=\"{points}\"/>");
}

fn dots(svg: &mut String, axes: &Axes, color: usize, rows: &[Row], value: impl Fn(&Row) -> Option<f64>) {
    /// More of them would hide the line.
    const APART_PX: f64 = 18.0;
    let mut last_x = f64::NEG_INFINITY;
    for row in rows {
        let Some((x, y)) = value(row).and_then(|cpd| finite(axes, row, cpd)) else { continue };
        if x - last_x >= APART_PX {
            _ = write!(svg, "<circle class=\"dot f{color}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\"/>");
            last_x = x;
        }
    }
    svg.push('\n');
}

/// What stands under the panels, as the insides of groups.
struct Legend {
    /// An entry for each curve of a panel.
    curves: Vec<String>,
    /// A line for each thing that all panels have.
    common: Vec<String>,
}

fn legend(results: &Results, curves: &[Curve]) -> Legend {
    let several_displays = curves.windows(2).any(|pair| pair[0].display.label != pair[1].display.label);
    let several_methods = curves.windows(2).any(|pair| pair[0].method != pair[1].method);
    let entry = |(at, curve): (usize, &Curve)| {
        let Curve { method, display, .. } = curve;
        let name = match (several_methods, several_displays) {
            (true, true) | (false, false) => format!("{method}, {}", display.label),
            (true, false) => (*method).to_owned(),
            (false, true) => display.label.clone(),
        };
        format!(
            "<path class=\"radial c{at}\" d=\"M0 8h28\"/><path class=\"tangential c{at}\" d=\"M34 8h28\"/>\
             <text x=\"70\" y=\"12\">{}</text>",
            escaped(&name)
        )
    };
    let acuity = escaped(&results.acuity);
    let soft = |text: &str| format!("<text class=\"soft\" x=\"0\" y=\"12\">{text}</text>");
    Legend {
        curves: (0..MOST_CURVES).cycle().zip(curves).map(entry).collect(),
        common: vec![
            format!(
                "<path class=\"acuity\" d=\"M0 8h28\"/><text x=\"36\" y=\"12\">acuity, {acuity}</text>"
            ),
            "<path class=\"limit\" d=\"M0 8h28\"/><text x=\"36\" y=\"12\">half the display's pixels per degree</text>"
                .into(),
            soft("Solid: radial. Dashed: tangential."),
            soft(&format!("Area: least to greatest about the gaze. Dots: counted ({}).", results.counted_on)),
        ],
    }
}

#[cfg(test)]
mod tests;
