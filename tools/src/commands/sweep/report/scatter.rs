//! Time against error with the Pareto front, as static SVG.

use super::cards::reference_key;
use super::marks::{REFERENCE, color_class, legend, shape};
use super::sheet::{Row, Sheet, method_names};
use super::table::{Cell, Table};
use super::text::{between, cut, figure, tick};
use crate::commands::sweep::front::{Measure, Point, Time, front};
use crate::commands::sweep::record::Figures;
use crate::page::axis::Axis;
use crate::page::escaped;
use std::fmt::Write;

/// Times that can be chosen: the choice's name, and the axis's.
pub const TIMES: [(Time, &str, &str); 2] = [
    (Time::Ratio, "relative", "GPU time / reference's (below 1 is faster)"),
    (Time::GpuMs, "milliseconds", "GPU time, ms"),
];

/// Errors that can be chosen, in the same way.
pub const MEASURES: [(Measure, &str, &str); 3] = [
    (Measure::AcuityRmse, "acuity-surviving", "acuity-surviving RMSE (0 to 1)"),
    (Measure::Flip, "FLIP", "FLIP (0 to 1)"),
    (Measure::Rmse, "RMSE", "RMSE (0 to 1)"),
];

/// A drawing's size; a narrow one is made for phones, where a wide one's text would be too small.
#[derive(Clone, Copy)]
struct Format {
    class: &'static str,
    size: [f64; 2],
    /// Characters of a label, 0 for the number alone.
    label: usize,
    ticks: [usize; 2],
}

const FORMATS: [Format; 2] = [
    Format { class: "wide", size: [760.0, 470.0], label: 30, ticks: [10, 10] },
    Format { class: "narrow", size: [360.0, 400.0], label: 0, ticks: [5, 8] },
];

/// Around the axes: left, top, right, bottom.
const MARGIN: [f64; 4] = [62.0, 14.0, 14.0, 46.0];
const CHARACTER_PX: f64 = 6.9;

/// A setting in the drawing, or the reference.
struct Mark<'a> {
    point: Point,
    /// Ends of the time's bar.
    bar: Option<[f64; 2]>,
    row: Option<&'a Row<'a>>,
}

/// The drawing of one size with one time and one measure.
struct Chart<'a> {
    marks: Vec<Mark<'a>>,
    /// Places in `marks`.
    front: Vec<usize>,
    x_title: &'static str,
    y_title: &'static str,
    reference_key: String,
}

/// All drawings of a size: those not chosen at first are hidden.
pub fn section(sheet: &Sheet<'_>) -> String {
    if sheet.measured().next().is_none() {
        return "<p>No setting was measured at this size.</p>\n".to_owned();
    }
    let mut methods: Vec<usize> = sheet.measured().map(|(row, _)| row.method).collect();
    methods.sort_unstable();
    methods.dedup();
    let name =
        |place: &usize| (*place, (*method_names().get(*place).unwrap_or(&"method of the base")).to_owned());
    let mut html = legend(methods.iter().map(name));
    for (time, time_name, x_title) in TIMES {
        for (measure, measure_name, y_title) in MEASURES {
            let spare =
                if (time, measure) == (TIMES[0].0, MEASURES[0].0) { "" } else { " spare\" hidden=\"" };
            let chart = Chart::new(sheet, time, measure, [x_title, y_title]);
            let drawings = FORMATS.iter().enumerate().map(|(at, format)| {
                let id = format!("f{}-{time_name}-{measure_name}-{at}", sheet.at);
                chart.svg(format, &id, &sheet.size_text())
            });
            _ = writeln!(
                html,
                "<div class=\"chart{spare}\" data-time=\"{time_name}\" data-error=\"{measure_name}\">\n{}{}</div>",
                drawings.collect::<String>(),
                chart.table(time, measure_name, &sheet.size_text())
            );
        }
    }
    html
}

/// Ends of the bar: the interval of the ratio's median, or the least and the greatest time.
fn bar(figures: &Figures, time: Time) -> Option<[f64; 2]> {
    let ends = match time {
        Time::Ratio => figures.times.ratio_interval,
        Time::GpuMs => [figures.times.setting_ms.least, figures.times.setting_ms.greatest],
    };
    ends.iter().all(|end| end.is_finite() && *end >= 0.0).then_some(ends)
}

impl<'a> Chart<'a> {
    fn new(
        sheet: &'a Sheet<'_>,
        time: Time,
        measure: Measure,
        [x_title, y_title]: [&'static str; 2],
    ) -> Self {
        let of_row = |(row, figures): (&'a Row<'a>, &Figures)| {
            let point = Point::of(row.record, time, measure)?;
            Some(Mark { point, bar: bar(figures, time), row: Some(row) })
        };
        let measured = sheet.rows.iter().filter_map(|row| Some((row, row.figures()?)));
        let mut marks: Vec<Mark<'_>> = measured.filter_map(of_row).collect();
        let reference_time = if time == Time::Ratio { Some(1.0) } else { sheet.reference_ms() };
        let point = reference_time.and_then(|time| Point::new(time, 0.0));
        marks.extend(point.map(|point| Mark { point, bar: None, row: None }));
        let front = front(&marks.iter().map(|mark| Some(mark.point)).collect::<Vec<_>>());
        Self { marks, front, x_title, y_title, reference_key: reference_key(sheet) }
    }

    fn svg(&self, format: &Format, id: &str, size: &str) -> String {
        let [width, height] = format.size;
        let [left, top, right, bottom] = MARGIN;
        let bars = || self.marks.iter().filter_map(|mark| mark.bar).flatten();
        let times = self.marks.iter().map(|mark| mark.point.time).chain(bars());
        let errors = self.marks.iter().map(|mark| mark.point.error);
        let x = Axis::from_zero(times, left, width - right);
        let y = Axis::fitting(errors, height - bottom, top);
        let mut svg = format!(
            "<svg class=\"{}\" viewBox=\"0 0 {width} {height}\" role=\"group\" aria-labelledby=\"{id}-t {id}-d\">\n\
             <title id=\"{id}-t\">Error against time, {size} px</title>\n<desc id=\"{id}-d\">{} settings; across: {}; \
             upwards: {}. The stepped line is the front; the table below lists it.</desc>\n",
            format.class,
            self.marks.iter().filter(|mark| mark.row.is_some()).count(),
            self.x_title,
            self.y_title
        );
        svg += &grid(format, &x, &y, [self.x_title, self.y_title]);
        svg += &self.front_line(&x, &y);
        for place in self.drawing_order() {
            svg += &self.mark(place, &x, &y);
        }
        svg += &self.labels(format, &x, &y);
        svg + "</svg>\n"
    }

    /// Those on the front last, so that nothing hides them.
    fn drawing_order(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.marks.len()).collect();
        order.sort_by_key(|place| self.front.contains(place));
        order
    }

    /// Steps: between two settings nothing was measured, so nothing is drawn as if it had been.
    fn front_line(&self, x: &Axis, y: &Axis) -> String {
        let mut path = String::new();
        for &place in &self.front {
            let Point { time, error } = self.marks[place].point;
            let (x, y) = (x.at(time), y.at(error));
            _ = if path.is_empty() { write!(path, "M{x:.1} {y:.1}") } else { write!(path, "H{x:.1}V{y:.1}") };
        }
        format!("<path class=\"front-line\" d=\"{path}\"/>\n")
    }

    fn mark(&self, place: usize, x: &Axis, y: &Axis) -> String {
        let Mark { point, bar, row } = &self.marks[place];
        let (at_x, at_y) = (x.at(point.time), y.at(point.error));
        let place = if self.front.contains(&place) { "best" } else { "beaten" };
        let told = format!(
            "{}: time {}, error {}",
            row.map_or("reference", |row| &row.label),
            figure(point.time),
            figure(point.error)
        );
        let bar = bar.map_or(String::new(), |[low, high]| {
            let (low, high) = (x.at(low), x.at(high));
            format!("<path class=\"bar-line\" d=\"M{low:.1} {at_y:.1}H{high:.1}M{low:.1} {:.1}v6M{high:.1} {:.1}v6\"/>", at_y - 3.0, at_y - 3.0)
        });
        let (key, class, shape) = match row {
            Some(row) => (row.key.as_str(), color_class(row.method), shape(row.method)),
            None => (self.reference_key.as_str(), "reference".to_owned(), REFERENCE),
        };
        let told = escaped(&told);
        format!(
            "<a class=\"point {place} {class}\" href=\"#{key}\" data-key=\"{key}\" aria-label=\"{told}\"><title>{told}</title>\
             <circle class=\"hit\" cx=\"{at_x:.1}\" cy=\"{at_y:.1}\" r=\"12\"/>{bar}\
             <path class=\"mark\" transform=\"translate({at_x:.1} {at_y:.1})\" d=\"{shape}\"/></a>\n"
        )
    }

    /// Numbers of the front's points, with their names where there is room.
    fn labels(&self, format: &Format, x: &Axis, y: &Axis) -> String {
        let at = |mark: &Mark<'_>| [x.at(mark.point.time), y.at(mark.point.error)];
        let mut taken: Vec<[f64; 4]> = self.marks.iter().map(|mark| around(at(mark))).collect();
        let mut svg = String::new();
        for (number, &place) in (1..).zip(&self.front) {
            let mark = &self.marks[place];
            let name = mark.row.map_or("reference", |row| &row.label);
            let short = number.to_string();
            let long = format!("{number} {}", cut(name, format.label));
            let texts = if format.label > 0 { vec![long, short] } else { vec![short] };
            let found = texts.iter().find_map(|text| Some((text, room(format, at(mark), text, &taken)?)));
            // Without room a number may touch what is near: it is never left out.
            let (text, [left, top, right, bottom]) = found.unwrap_or_else(|| {
                let [x, y] = at(mark);
                (&texts[texts.len() - 1], [x + 8.0, y - 20.0, x + 8.0 + CHARACTER_PX * 2.0, y - 6.0])
            });
            taken.push([left, top, right, bottom]);
            _ = writeln!(
                svg,
                "<text class=\"label\" x=\"{left:.1}\" y=\"{:.1}\">{}</text>",
                bottom - 3.0,
                escaped(text)
            );
        }
        svg
    }

    /// The front's settings in order, as the labels number them.
    fn table(&self, time: Time, measure_name: &str, size: &str) -> String {
        let row = |(number, &place): (usize, &usize)| {
            let Mark { point, bar, row } = &self.marks[place];
            let name = format!("{number}. {}", row.map_or("reference", |row| &row.label));
            let key = row.map_or(&self.reference_key, |row| &row.key);
            let bar = bar.map_or(Cell::Nothing, |bar| Cell::Text(between(bar)));
            let number = |value: f64| Cell::Number(value, figure(value));
            (name, Some(key.clone()), vec![number(point.time), number(point.error), bar])
        };
        let (head, ends) = match time {
            Time::Ratio => ("time / reference", "interval"),
            Time::GpuMs => ("GPU ms", "least to greatest"),
        };
        Table {
            caption: format!("The front at {size} px, from the fastest to the most accurate"),
            head: ["setting", head, &format!("{measure_name} error"), ends].map(str::to_owned).to_vec(),
            rows: (1..).zip(&self.front).map(row).collect(),
            class: "front",
            sortable: false,
        }
        .html()
    }
}

fn around([x, y]: [f64; 2]) -> [f64; 4] {
    [x - 7.0, y - 7.0, x + 7.0, y + 7.0]
}

/// A free box for a text beside a mark: left, top, right, bottom.
fn room(format: &Format, [x, y]: [f64; 2], text: &str, taken: &[[f64; 4]]) -> Option<[f64; 4]> {
    let width = text.chars().count() as f64 * CHARACTER_PX;
    let [left, top, right, bottom] = MARGIN;
    let beside = |left: f64, top: f64| [left, top, left + width, top + 16.0];
    let places = [
        beside(x + 9.0, y - 18.0),
        beside(x + 10.0, y - 8.0),
        beside(x - width - 9.0, y - 18.0),
        beside(x + 9.0, y + 3.0),
        beside(x - width - 10.0, y - 8.0),
        beside(x - width - 9.0, y + 4.0),
        beside(x - width / 2.0, y - 26.0),
        beside(x - width / 2.0, y + 10.0),
    ];
    let inside = |place: &[f64; 4]| {
        place[0] >= left
            && place[1] >= top
            && place[2] <= format.size[0] - right + 8.0
            && place[3] <= format.size[1] - bottom
    };
    let free = |place: &[f64; 4]| {
        taken.iter().all(|other| {
            place[2] <= other[0] || other[2] <= place[0] || place[3] <= other[1] || other[3] <= place[1]
        })
    };
    places.into_iter().find(|place| inside(place) && free(place))
}

fn grid(format: &Format, x: &Axis, y: &Axis, [x_title, y_title]: [&str; 2]) -> String {
    let [width, height] = format.size;
    let [left, top, right, bottom] = MARGIN;
    let (right, bottom) = (width - right, height - bottom);
    let mut svg = String::new();
    for value in y.ticks(format.ticks[1]) {
        let at = y.at(value);
        _ = writeln!(
            svg,
            "<path class=\"grid\" d=\"M{left} {at:.1}H{right}\"/><text class=\"soft\" x=\"{}\" y=\"{:.1}\" \
             text-anchor=\"end\">{}</text>",
            left - 7.0,
            at + 4.0,
            tick(value)
        );
    }
    for value in x.ticks(format.ticks[0]) {
        let at = x.at(value);
        _ = writeln!(
            svg,
            "<path class=\"axis\" d=\"M{at:.1} {bottom}v5\"/><text class=\"soft\" x=\"{at:.1}\" y=\"{}\" \
             text-anchor=\"middle\">{}</text>",
            bottom + 19.0,
            tick(value)
        );
    }
    let axis = match y.break_at() {
        Some(at) => format!(
            "M{left} {top}V{:.1}m-5 3l10 -6m-10 10l10 -6M{left} {:.1}V{bottom}H{right}",
            at - 3.0,
            at + 3.0
        ),
        None => format!("M{left} {top}V{bottom}H{right}"),
    };
    svg + &format!(
        "<path class=\"axis\" d=\"{axis}\"/>\n<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{x_title}</text>\n\
         <text transform=\"translate(14 {}) rotate(-90)\" text-anchor=\"middle\">{y_title}</text>\n",
        f64::midpoint(left, right),
        height - 8.0,
        f64::midpoint(top, bottom)
    )
}
