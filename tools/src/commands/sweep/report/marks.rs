//! Marks of the methods: a colour and a shape each, so that neither is needed alone.

use crate::page::axis::COLORS;
use crate::page::escaped;
use std::fmt::Write;

/// Outlines around (0, 0), about 12 units wide.
const SHAPES: [&str; 8] = [
    "M-5.5 0a5.5 5.5 0 1 0 11 0a5.5 5.5 0 1 0 -11 0Z",
    "M-5 -5H5V5H-5Z",
    "M0 -6.5L6.2 4.5H-6.2Z",
    "M0 -6.8L6.8 0L0 6.8L-6.8 0Z",
    "M0 6.5L6.2 -4.5H-6.2Z",
    "M-2 -6H2V-2H6V2H2V6H-2V2H-6V-2H-2Z",
    "M-6 0L-3 -5.5H3L6 0L3 5.5H-3Z",
    "M0 -7L1.8 -2.3L6.7 -2.2L2.8 0.9L4.1 5.7L0 3L-4.1 5.7L-2.8 0.9L-6.7 -2.2L-1.8 -2.3Z",
];

/// The reference's mark.
pub const REFERENCE: &str = "M-7 0H7M0 -7V7M-5 -5L5 5M-5 5L5 -5";

/// A shape's path.
pub fn shape(place: usize) -> &'static str {
    SHAPES[place % SHAPES.len()]
}

/// The class that gives a colour as `--c`.
pub fn color_class(place: usize) -> String {
    format!("c{}", place % COLORS.len())
}

/// A mark by itself, for legends and headings.
pub fn icon(place: usize) -> String {
    let (shape, class) = (shape(place), color_class(place));
    format!(
        "<svg class=\"icon {class}\" viewBox=\"-8 -8 16 16\" aria-hidden=\"true\"><path class=\"mark\" d=\"{shape}\"/></svg>"
    )
}

/// A list of marks and what they stand for.
pub fn legend(entries: impl Iterator<Item = (usize, String)>) -> String {
    let mut html = String::from("<ul class=\"legend\">");
    for (place, name) in entries {
        _ = write!(html, "<li>{} {}</li>", icon(place), escaped(&name));
    }
    html + "</ul>\n"
}

/// The colours, for a light and a dark ground and for paper.
pub fn style() -> String {
    let colors = |ground: usize| {
        let color = |(at, color): (usize, &[&str; 2])| format!(".c{at}{{--c:{}}}", color[ground]);
        COLORS.iter().enumerate().map(color).collect::<String>()
    };
    let light = colors(0);
    format!("{light}\n@media (prefers-color-scheme:dark){{\n{}\n}}\n@media print{{\n{light}\n}}\n", colors(1))
}
