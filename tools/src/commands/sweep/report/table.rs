//! Tables that scroll in their own box and can be sorted.

use super::text::NONE;
use crate::page::escaped;
use std::fmt::Write;

/// One cell.
pub enum Cell {
    /// Text.
    Text(String),
    /// What it is sorted by, and its text.
    Number(f64, String),
    /// Nothing to show.
    Nothing,
}

/// A table.
pub struct Table {
    /// What it shows.
    pub caption: String,
    /// Heads of the columns; the first one's cells name the rows.
    pub head: Vec<String>,
    /// Names of the rows, with their links' targets, and their other cells.
    pub rows: Vec<(String, Option<String>, Vec<Cell>)>,
    /// A class for its looks.
    pub class: &'static str,
    /// Whether readers may sort it.
    pub sortable: bool,
}

impl Table {
    /// As HTML; nothing where there are no rows.
    pub fn html(&self) -> String {
        if self.rows.is_empty() {
            return String::new();
        }
        let caption = escaped(&self.caption);
        let sortable = if self.sortable { " data-sortable=\"\"" } else { "" };
        let mut html = format!(
            "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{caption}\">\
             <table class=\"{}\"{sortable}>\n<caption>{caption}</caption>\n<thead><tr>",
            self.class
        );
        for head in &self.head {
            _ = write!(html, "<th scope=\"col\">{}</th>", escaped(head));
        }
        html += "</tr></thead>\n<tbody>\n";
        for (name, target, cells) in &self.rows {
            let name = escaped(name);
            let name = match target {
                Some(key) => format!("<a href=\"#{key}\" data-key=\"{key}\">{name}</a>"),
                None => name,
            };
            _ = write!(html, "<tr><th scope=\"row\">{name}</th>");
            html.extend(cells.iter().map(Cell::html));
            html += "</tr>\n";
        }
        html + "</tbody></table></div>\n"
    }
}

impl Cell {
    fn html(&self) -> String {
        match self {
            Self::Text(text) => format!("<td class=\"text\">{}</td>", escaped(text)),
            Self::Number(value, text) if value.is_finite() => {
                format!("<td data-value=\"{value}\">{}</td>", escaped(text))
            }
            Self::Number(..) | Self::Nothing => format!("<td>{NONE}</td>"),
        }
    }
}
