//! What goes to stdout: text, tables, JSON. A closed pipe ends the program quietly.

use crate::failure::Failure;
use serde::Serialize;
use std::fmt::Write as _;
use std::io::{self, Write as _};

/// Writes to stdout.
///
/// # Errors
/// [`Failure::StdoutClosed`], or [`Failure::Environment`] where stdout is a file on a full disk.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()).map_err(|error| match error.kind() {
        io::ErrorKind::BrokenPipe => Failure::StdoutClosed,
        _ => Failure::environment(format!("standard output: {error}; nothing more was printed")),
    })
}

/// Writes one JSON document to stdout.
///
/// # Errors
/// As [`print`].
pub fn print_json(document: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(document)
        .map_err(|error| Failure::environment(format!("the result cannot be written as JSON: {error}")))?;
    print(&format!("{text}\n"))
}

/// Writes one JSON document to stdout, on a line of its own.
///
/// # Errors
/// As [`print`].
pub fn print_json_line(document: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string(document)
        .map_err(|error| Failure::environment(format!("the result cannot be written as JSON: {error}")))?;
    print(&format!("{text}\n"))
}

/// Names and values, a line each; those without a value are left out.
pub fn fields(rows: &[(&str, String)]) -> String {
    let told = rows.iter().filter(|(_, value)| !value.is_empty());
    told.map(|(name, value)| format!("{name:<10} {value}\n")).collect()
}

/// A note on stderr; a closed stderr is of no interest.
pub fn note(text: &str) {
    _ = writeln!(io::stderr().lock(), "{text}");
}

/// Columns padded to their widest cell, those that hold numbers to the right.
pub fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    let head = header.iter().map(|&cell| cell.to_owned()).collect::<Vec<_>>();
    let cells_of = |column: usize| rows.iter().filter_map(move |row| row.get(column));
    let width_of = |column: usize| {
        let cells = cells_of(column).chain(head.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let starts_with_digit = |cell: &String| cell.starts_with(|first: char| first.is_ascii_digit());
    // The first column names the row, even where names begin with digits.
    let to_right = |column: usize| column > 0 && cells_of(column).any(starts_with_digit);
    let columns = (0..header.len()).map(|column| (width_of(column), to_right(column))).collect::<Vec<_>>();
    let rule = columns.iter().map(|&(width, _)| "-".repeat(width)).collect();
    let mut text = String::new();
    for row in [&head, &rule].into_iter().chain(rows) {
        let mut line = String::new();
        for (cell, &(width, to_right)) in row.iter().zip(&columns) {
            _ = if to_right { write!(line, "{cell:>width$}  ") } else { write!(line, "{cell:<width$}  ") };
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

/// A count with its thousands apart.
pub fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let rows = [["gbuffer", "1.5", "x"], ["lp", "12.25", "yes"]];
        let text = table(&["pass", "ms", "runs"], &rows.map(|row| row.map(str::to_owned).to_vec()));
        let expected = "pass        ms  runs\n-------  -----  ----\ngbuffer    1.5  x\nlp       12.25  yes\n";
        assert_eq!(text, expected);
    }

    #[test]
    fn thousands_stand_apart() {
        assert_eq!(grouped(7), "7");
        assert_eq!(grouped(1000), "1 000");
        assert_eq!(grouped(2_073_600), "2 073 600");
    }
}
