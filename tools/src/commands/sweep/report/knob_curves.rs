//! A pair of small drawings for each knob: time and error against its value, all else being equal.

use super::marks::{color_class, legend, shape};
use super::sheet::{Row, Sheet, words};
use super::text::{figure, tick};
use crate::commands::sweep::front::{Measure, Time};
use crate::commands::sweep::record::Figures;
use crate::page::axis::{Axis, COLORS};
use crate::page::escaped;
use macula::knobs::{KNOBS, Knob, Range, Value};
use std::fmt::Write;

const SIZE: [f64; 2] = [360.0, 250.0];
/// Around the axes: left, top, right.
const MARGIN: [f64; 3] = [56.0, 26.0, 14.0];
/// Below the axes, for level and for slanted names of values.
const BOTTOM: [f64; 2] = [44.0, 82.0];
const CHARACTER_PX: f64 = 7.0;

/// Settings that differ in one knob only.
struct Line<'a> {
    rest: String,
    points: Vec<(&'a Value, &'a Row<'a>, &'a Figures)>,
}

/// One of the two drawings.
#[derive(Clone, Copy)]
enum Drawing {
    Time,
    Error,
}

/// One size's drawings, for each knob that has several values.
pub fn section(sheet: &Sheet<'_>) -> String {
    let mut html = String::new();
    for knob in KNOBS {
        let mut lines = lines(sheet, knob);
        if lines.is_empty() {
            continue;
        }
        let left_out = lines.len().saturating_sub(COLORS.len());
        lines.truncate(COLORS.len());
        _ = write!(
            html,
            "<section class=\"knob\">\n<h4>{}</h4>\n<p class=\"hint\">{}.</p>\n<div class=\"small-multiples\">\n",
            knob.name,
            escaped(knob.affects)
        );
        for drawing in [Drawing::Time, Drawing::Error] {
            html += &svg(sheet, knob, &lines, drawing);
        }
        html += "</div>\n";
        if lines.len() > 1 {
            html += &legend(lines.iter().map(|line| line.rest.clone()).enumerate());
        } else if !lines[0].rest.is_empty() {
            _ = writeln!(html, "<p class=\"hint\">With {}.</p>", escaped(&lines[0].rest));
        }
        if left_out > 0 {
            _ = writeln!(
                html,
                "<p class=\"hint\">{left_out} more lines would hide these: see the table.</p>"
            );
        }
        html += "</section>\n";
    }
    if html.is_empty() { "<p>No two settings differ in one knob only.</p>\n".to_owned() } else { html }
}

/// Groups of settings in which only this knob has different values, those with the most values first.
fn lines<'a>(sheet: &'a Sheet<'_>, knob: &Knob) -> Vec<Line<'a>> {
    let mut lines: Vec<(String, Line<'_>)> = Vec::new();
    for row in &sheet.rows {
        let (Some(value), Some(figures)) = (row.setting.get(knob.name), row.figures()) else { continue };
        // Methods have knobs of their own: two of them are comparable where all else is as the base has it.
        let compared = if knob.name == "method" { &row.record.setting } else { &row.setting };
        let key = words(compared, |name| name != knob.name);
        let point = (value, row, figures);
        if let Some((_, line)) = lines.iter_mut().find(|(other, _)| *other == key) {
            line.points.push(point);
            continue;
        }
        let told = |name: &str| name != knob.name && (name == "method" || sheet.differing.contains(&name));
        lines.push((key, Line { rest: words(compared, told), points: vec![point] }));
    }
    let several = |line: &Line<'_>| line.points.iter().any(|(value, ..)| *value != line.points[0].0);
    let mut lines: Vec<_> = lines.into_iter().map(|(_, line)| line).filter(several).collect();
    for line in &mut lines {
        line.points.sort_by(|a, b| place(knob, a.0).total_cmp(&place(knob, b.0)));
    }
    lines.sort_by_key(|line| std::cmp::Reverse(line.points.len()));
    lines
}

/// Numbers by themselves; names and switches by their place in the range.
fn place(knob: &Knob, value: &Value) -> f64 {
    match (value, knob.range) {
        (Value::Number(number), _) => *number,
        (Value::Switch(on), _) => f64::from(u8::from(*on)),
        (Value::Name(name), Range::Names(names)) => {
            names.iter().position(|other| other == name).unwrap_or(names.len()) as f64
        }
        (Value::Name(_), _) => 0.0,
    }
}

/// Where the values lie along a drawing, and those to write.
struct Across {
    /// Place of a value and its distance from the left.
    at: Vec<(f64, f64)>,
    ticks: Vec<(f64, String)>,
    slanted: bool,
}

impl Across {
    fn new(knob: &Knob, lines: &[Line<'_>]) -> Self {
        let values = lines.iter().flat_map(|line| &line.points);
        let mut values: Vec<(f64, &Value)> = values.map(|(value, ..)| (place(knob, value), *value)).collect();
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        values.dedup_by(|a, b| a.0 == b.0);
        let [left, _, right] = MARGIN;
        let text = |value: &Value| match value {
            Value::Number(number) => tick(*number),
            other => other.to_string(),
        };
        let width = |text: &str| text.chars().count() as f64 * CHARACTER_PX;
        // The last value's text must not leave the drawing.
        let last_width = values.last().map_or(0.0, |(_, value)| width(&text(value)));
        let (from, to) = (left + 18.0, SIZE[0] - f64::max(right + 18.0, last_width / 2.0 + 4.0));
        let numbers = matches!(knob.range, Range::Numbers { .. });
        let (first, last) = (values[0].0, values[values.len() - 1].0);
        // Powers of two and the like would crowd at the left.
        let logarithmic = numbers && first > 0.0 && last >= 8.0 * first;
        let share = |index: usize, place: f64| match (numbers, logarithmic) {
            (true, true) => (place / first).ln() / (last / first).ln(),
            (true, false) => (place - first) / (last - first),
            (false, _) => index as f64 / (values.len() - 1).max(1) as f64,
        };
        let at: Vec<_> = values
            .iter()
            .enumerate()
            .map(|(index, &(place, _))| (place, from + (to - from) * share(index, place).clamp(0.0, 1.0)))
            .collect();
        let texts: Vec<_> = at.iter().zip(&values).map(|((_, x), (_, value))| (*x, text(value))).collect();
        let crowded = |pair: &[(f64, String)]| {
            (width(&pair[0].1) + width(&pair[1].1)) / 2.0 + 6.0 > pair[1].0 - pair[0].0
        };
        let slanted = !numbers && texts.windows(2).any(crowded);
        let mut ticks: Vec<(f64, String)> = Vec::new();
        for tick in texts {
            // Numbers between can be told from their neighbours; names cannot.
            let free = ticks.last().is_none_or(|last| !crowded(&[last.clone(), tick.clone()]));
            if !numbers || free {
                ticks.push(tick);
            }
        }
        Self { at, ticks, slanted }
    }

    fn x(&self, place: f64) -> f64 {
        self.at.iter().find(|(own, _)| *own == place).map_or(MARGIN[0], |(_, x)| *x)
    }

    fn bottom(&self) -> f64 {
        SIZE[1] - BOTTOM[usize::from(self.slanted)]
    }
}

/// The figure, and the ends of its bar where there is one.
fn height(figures: &Figures, drawing: Drawing) -> (f64, Option<[f64; 2]>) {
    match drawing {
        Drawing::Time => (Time::Ratio.of(figures), Some(figures.times.ratio_interval)),
        Drawing::Error => (Measure::AcuityRmse.of(figures), None),
    }
}

fn svg(sheet: &Sheet<'_>, knob: &Knob, lines: &[Line<'_>], drawing: Drawing) -> String {
    let [width, full_height] = SIZE;
    let across = Across::new(knob, lines);
    let heights = lines.iter().flat_map(|line| &line.points).flat_map(|(_, _, figures)| {
        let (value, bar) = height(figures, drawing);
        [value].into_iter().chain(bar.into_iter().flatten())
    });
    let (axis, title) = match drawing {
        Drawing::Time => {
            let axis = Axis::from_zero(heights.chain([1.0]), across.bottom(), MARGIN[1]);
            (axis, "GPU time / reference's")
        }
        Drawing::Error => (Axis::fitting(heights, across.bottom(), MARGIN[1]), "acuity-surviving RMSE"),
    };
    let id =
        format!("k{}-{}-{}", sheet.at, knob.name, if matches!(drawing, Drawing::Time) { "t" } else { "e" });
    let mut svg = format!(
        "<svg class=\"small\" viewBox=\"0 0 {width} {full_height}\" role=\"group\" aria-labelledby=\"{id}-t {id}-d\">\n\
         <title id=\"{id}-t\">{title} against {}, {} px</title>\n<desc id=\"{id}-d\">{} lines; every point is a \
         setting of the table.</desc>\n",
        knob.name,
        sheet.size_text(),
        lines.len()
    );
    svg += &frame(knob, &across, &axis, title);
    if matches!(drawing, Drawing::Time) {
        let (left, right, one) = (MARGIN[0], width - MARGIN[2], axis.at(1.0));
        _ = writeln!(svg, "<path class=\"one\" d=\"M{left} {one:.1}H{right}\"/>");
    }
    for (place, line) in lines.iter().enumerate() {
        svg += &drawn(knob, line, place, &across, &axis, drawing);
    }
    svg + "</svg>\n"
}

fn frame(knob: &Knob, across: &Across, axis: &Axis, title: &str) -> String {
    let [left, top, right] = MARGIN;
    let (right, bottom) = (SIZE[0] - right, across.bottom());
    let mut svg = format!("<text class=\"soft\" x=\"2\" y=\"14\">{title}</text>\n");
    for value in axis.ticks(6) {
        let at = axis.at(value);
        _ = writeln!(
            svg,
            "<path class=\"grid\" d=\"M{left} {at:.1}H{right}\"/><text class=\"soft\" x=\"{}\" y=\"{:.1}\" \
             text-anchor=\"end\">{}</text>",
            left - 7.0,
            at + 4.0,
            tick(value)
        );
    }
    for (x, text) in &across.ticks {
        let place = if across.slanted {
            format!(
                "transform=\"translate({:.1} {}) rotate(-38)\" text-anchor=\"end\"",
                x + 4.0,
                bottom + 15.0
            )
        } else {
            format!("x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\"", bottom + 19.0)
        };
        _ = writeln!(
            svg,
            "<path class=\"axis\" d=\"M{x:.1} {bottom}v5\"/><text class=\"soft\" {place}>{}</text>",
            escaped(text)
        );
    }
    let broken = match axis.break_at() {
        Some(at) => format!("V{:.1}m-5 3l10 -6m-10 10l10 -6M{left} {:.1}", at - 3.0, at + 3.0),
        None => String::new(),
    };
    svg + &format!(
        "<path class=\"axis\" d=\"M{left} {top}{broken}V{bottom}H{right}\"/>\n\
         <text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
        f64::midpoint(left, right),
        SIZE[1] - 6.0,
        knob.name
    )
}

/// Points with bars, joined where the knob is a number.
fn drawn(
    knob: &Knob,
    line: &Line<'_>,
    color: usize,
    across: &Across,
    axis: &Axis,
    drawing: Drawing,
) -> String {
    let mut path = String::new();
    let mut svg = String::new();
    for (value, row, figures) in &line.points {
        let (figure_value, bar) = height(figures, drawing);
        if !figure_value.is_finite() || figure_value < 0.0 {
            continue;
        }
        let (x, y) = (across.x(place(knob, value)), axis.at(figure_value));
        _ = write!(path, "{}{x:.1} {y:.1}", if path.is_empty() { 'M' } else { 'L' });
        if let Some([low, high]) = bar.filter(|bar| bar.iter().all(|end| end.is_finite() && *end >= 0.0)) {
            let (low, high) = (axis.at(low), axis.at(high));
            _ = write!(
                svg,
                "<path class=\"bar-line\" d=\"M{x:.1} {low:.1}V{high:.1}M{:.1} {low:.1}h6M{:.1} {high:.1}h6\"/>",
                x - 3.0,
                x - 3.0
            );
        }
        let told = escaped(&format!("{}: {}", row.label, figure(figure_value)));
        _ = writeln!(
            svg,
            "<a class=\"point\" href=\"#{key}\" data-key=\"{key}\" aria-label=\"{told}\"><title>{told}</title>\
             <circle class=\"hit\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"9\"/>\
             <path class=\"mark\" transform=\"translate({x:.1} {y:.1}) scale(.75)\" d=\"{}\"/></a>",
            shape(color),
            key = row.key
        );
    }
    let joined = if matches!(knob.range, Range::Numbers { .. }) {
        format!("<path class=\"joined\" d=\"{path}\"/>\n")
    } else {
        String::new()
    };
    format!("<g class=\"{}\">\n{joined}{svg}</g>\n", color_class(color))
}
