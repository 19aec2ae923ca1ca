//! Axes and marks as SVG text. Colours are classes of the page's style, so that it may be light or dark.

use std::fmt::Write;

/// Width of a letter of a name, px: of 12 px type, with some air.
const LETTER: f64 = 6.8;

/// A plot's area and the ranges of its axes.
pub(super) struct Plot {
    size: [f64; 2],
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
    x: [f64; 2],
    y: [f64; 2],
    svg: String,
}

/// What stands at the axes.
pub(super) struct Labels<'a> {
    /// The plot's name for those who do not see it.
    pub title: &'a str,
    pub x: &'a str,
    pub y: &'a str,
}

impl Plot {
    /// An empty plot with axes; `x` and `y` are the ranges.
    pub(super) fn new(size: [f64; 2], x: [f64; 2], y: [f64; 2], labels: &Labels<'_>) -> Self {
        let range = |[low, high]: [f64; 2]| {
            let sound = low.is_finite() && high.is_finite() && high > low;
            if sound { [low, high] } else { [0.0, 1.0] }
        };
        let (left, bottom) = (46.0, size[1] - 40.0);
        let (right, top) = (size[0] - 12.0, 22.0);
        let mut plot = Self { size, left, top, right, bottom, x: range(x), y: range(y), svg: String::new() };
        plot.axes(labels);
        plot
    }

    pub(super) fn x(&self, value: f64) -> f64 {
        let [low, high] = self.x;
        self.left + (self.right - self.left) * ((value - low) / (high - low)).clamp(-0.01, 1.01)
    }

    pub(super) fn y(&self, value: f64) -> f64 {
        let [low, high] = self.y;
        self.bottom - (self.bottom - self.top) * ((value - low) / (high - low)).clamp(0.0, 1.0)
    }

    fn axes(&mut self, labels: &Labels<'_>) {
        let (left, right, top, bottom) = (self.left, self.right, self.top, self.bottom);
        for value in ticks(self.y, ((bottom - top) / 34.0) as usize) {
            let y = self.y(value);
            _ = write!(
                self.svg,
                "<path class=\"grid\" d=\"M{left:.1} {y:.1}H{right:.1}\"/>\
                 <text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                left - 6.0,
                y + 4.0,
                number(value)
            );
        }
        for value in ticks(self.x, ((right - left) / 64.0) as usize) {
            let x = self.x(value);
            _ = write!(
                self.svg,
                "<path class=\"axis\" d=\"M{x:.1} {bottom:.1}v4\"/>\
                 <text class=\"tick\" x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                bottom + 16.0,
                number(value)
            );
        }
        _ = write!(
            self.svg,
            "<path class=\"axis\" d=\"M{left:.1} {bottom:.1}H{right:.1}\"/>\
             <text class=\"label\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\
             <text class=\"label\" x=\"2\" y=\"13\">{}</text>",
            right,
            bottom + 34.0,
            escaped(labels.x),
            escaped(labels.y)
        );
        self.svg.insert_str(
            0,
            &format!(
                "<svg viewBox=\"0 0 {:.0} {:.0}\" role=\"img\"><title>{}</title>",
                self.size[0],
                self.size[1],
                escaped(labels.title)
            ),
        );
    }

    /// A coloured stretch of the x axis over the whole height.
    pub(super) fn band(&mut self, from: f64, to: f64, class: &str, title: &str) {
        let (from, to) = (self.x(from).max(self.left), self.x(to).min(self.right));
        if to > from {
            let (top, height) = (self.top, self.bottom - self.top);
            _ = write!(
                self.svg,
                "<rect class=\"{class}\" x=\"{from:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{height:.1}\">\
                 <title>{}</title></rect>",
                to - from,
                escaped(title)
            );
        }
    }

    /// A line through points; it breaks where one is missing.
    pub(super) fn line(&mut self, points: impl Iterator<Item = (f64, Option<f64>)>, class: &str) {
        let mut path = String::new();
        let mut pen = 'M';
        for (x, y) in points {
            let Some(y) = y.filter(|y| y.is_finite()) else {
                pen = 'M';
                continue;
            };
            _ = write!(path, "{pen}{:.1} {:.1}", self.x(x), self.y(y));
            pen = 'L';
        }
        _ = write!(self.svg, "<path class=\"{class}\" d=\"{path}\"/>");
    }

    /// As [`Self::line`], with steps: a picture stays until the next.
    pub(super) fn steps(&mut self, points: impl Iterator<Item = (f64, Option<f64>)>, class: &str) {
        let mut path = String::new();
        let mut pen = true;
        for (x, y) in points {
            let Some(y) = y.filter(|y| y.is_finite()) else {
                pen = true;
                continue;
            };
            let (x, y) = (self.x(x), self.y(y));
            _ = if pen { write!(path, "M{x:.1} {y:.1}") } else { write!(path, "H{x:.1}V{y:.1}") };
            pen = false;
        }
        _ = write!(self.svg, "<path class=\"{class}\" d=\"{path}\"/>");
    }

    /// Upright bars from one value to another, as one path.
    pub(super) fn ranges(&mut self, bars: impl Iterator<Item = (f64, [f64; 2])>, class: &str) {
        let mut path = String::new();
        for (x, [low, high]) in bars {
            let (x, low, high) = (self.x(x), self.y(low), self.y(high));
            _ = write!(path, "M{x:.1} {:.1}V{high:.1}", low.max(high + 1.0));
        }
        _ = write!(self.svg, "<path class=\"{class}\" d=\"{path}\"/>");
    }

    /// A bar that stands on the x axis.
    pub(super) fn bar(&mut self, from: f64, to: f64, height: f64, class: &str, title: &str) {
        let (x, y) = (self.x(from), self.y(height));
        let width = (self.x(to) - x - 1.0).max(0.5);
        _ = write!(
            self.svg,
            "<rect class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{:.1}\">\
             <title>{}</title></rect>",
            self.bottom - y,
            escaped(title)
        );
    }

    /// A line across at a value, with its name at the right end above it.
    pub(super) fn level(&mut self, value: f64, class: &str, name: &str) {
        let (y, left, right) = (self.y(value), self.left, self.right);
        _ = write!(
            self.svg,
            "<path class=\"{class}\" d=\"M{left:.1} {y:.1}H{right:.1}\"/>\
             <text class=\"name\" x=\"{right:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            y - 4.0,
            escaped(name)
        );
    }

    /// Upright lines at values with their names beside them: class and name. The names of neighbours
    /// point away from each other, one line below the other.
    pub(super) fn marks(&mut self, mut marks: Vec<(f64, &str, String)>) {
        marks.sort_by(|one, other| one.0.total_cmp(&other.0));
        let (top, bottom) = (self.top, self.bottom);
        for ((value, class, name), row) in marks.into_iter().zip(0_u32..) {
            let x = self.x(value);
            // Letters are about half as wide as high; where there is no room, the name stands on the other side.
            let width = name.chars().count() as f64 * LETTER + 4.0;
            let leftwards = if row == 0 { x - width > self.left } else { x + width > self.right };
            let (at, anchor) = if leftwards { (x - 4.0, "end") } else { (x + 4.0, "start") };
            _ = write!(
                self.svg,
                "<path class=\"{class}\" d=\"M{x:.1} {top:.1}V{bottom:.1}\"/>\
                 <text class=\"name\" x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{}</text>",
                top + 11.0 + 15.0 * f64::from(row),
                escaped(&name)
            );
        }
    }

    /// A dot.
    pub(super) fn dot(&mut self, x: f64, y: f64, class: &str) {
        _ = write!(
            self.svg,
            "<circle class=\"{class}\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"2.5\"/>",
            self.x(x),
            self.y(y)
        );
    }

    pub(super) fn finish(self) -> String {
        self.svg + "</svg>"
    }
}

/// Round values within a range: steps of 1, 2 or 5 times a power of ten, at most about `most` of them.
pub(super) fn ticks([low, high]: [f64; 2], most: usize) -> Vec<f64> {
    let least = (high - low) / most.max(2) as f64;
    if !(least > 0.0 && least.is_finite()) {
        return Vec::new();
    }
    let power = 10_f64.powf(least.log10().floor());
    let step =
        [1.0, 2.0, 5.0, 10.0].into_iter().map(|times| times * power).find(|step| *step >= least * 0.999);
    let step = step.unwrap_or(least);
    let first = (low / step - 1e-9).ceil();
    (0..=(most.max(2) * 2))
        .map(|index| (first + index as f64) * step)
        .take_while(|value| *value <= high + step * 1e-6)
        .collect()
}

/// As short as can be.
pub(super) fn number(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.replace('-', "\u{2212}") }
}

pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within() {
        assert_eq!(ticks([0.0, 10.0], 5), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(ticks([-7.0, 7.0], 3), [-5.0, 0.0, 5.0]);
        assert!(ticks([1.0, 1.0], 5).is_empty() && ticks([0.0, f64::NAN], 5).is_empty());
        assert_eq!([number(-0.0), number(2.50), number(-3.0)], ["0", "2.5", "\u{2212}3"]);
    }
}
