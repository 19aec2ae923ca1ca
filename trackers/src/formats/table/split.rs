//! A text table split into rows and fields, without copies.

use super::number::{Field, field_of, time_ns};
use glam::DVec3;
use std::cell::Cell;

/// Stands for fields separated by any number of blanks and tabs.
pub const BLANKS: u8 = b' ';

/// The most fields of a row that are looked at.
pub const MAX_COLUMNS: usize = 4096;

/// A line split into fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line {
    /// Its number, from 1.
    pub number: u64,
    /// Fields up to the last one that is not empty, also those beyond [`MAX_COLUMNS`].
    pub filled: usize,
    /// It has an end: not the last line of a file that breaks off.
    pub ended: bool,
}

/// Splits bytes into lines and these into fields. Lines end with LF, CR LF or CR, mixed at will. A field
/// that begins with a quotation mark goes to the next lone one, or, where that is missing, to the end
/// of its line: a stray mark must not swallow the file.
#[derive(Clone, Debug)]
pub struct Splitter<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
    delimiter: u8,
    /// The fields of the last line.
    pub fields: Vec<&'a [u8]>,
}

impl<'a> Splitter<'a> {
    /// Starts at `at`, which is the begin of the line after number `line`.
    pub fn new(bytes: &'a [u8], at: usize, line: u64, delimiter: u8) -> Self {
        Self { bytes, at, line, delimiter, fields: Vec::new() }
    }

    /// Where the next line starts.
    pub fn position(&self) -> usize {
        self.at
    }

    /// Splits the next line; `None` at the end.
    pub fn next_line(&mut self) -> Option<Line> {
        if self.at >= self.bytes.len() {
            return None;
        }
        self.fields.clear();
        self.line += 1;
        let (mut start, mut at, mut fields, mut filled) = (self.at, self.at, 0, 0);
        let end = loop {
            let byte = self.bytes.get(at).copied();
            match byte {
                None | Some(b'\n' | b'\r') => {
                    self.field(start, at, &mut fields, &mut filled);
                    break byte;
                }
                Some(b'"') if at == start => {
                    at = self.end_of_quotes(at);
                    continue;
                }
                Some(byte) if byte == self.delimiter || (self.delimiter == BLANKS && byte == b'\t') => {
                    self.field(start, at, &mut fields, &mut filled);
                    start = at + 1;
                }
                Some(_) => {}
            }
            at += 1;
        };
        let two = end == Some(b'\r') && self.bytes.get(at + 1) == Some(&b'\n');
        self.at = at + 1 + usize::from(two);
        Some(Line { number: self.line, filled, ended: end.is_some() })
    }

    fn field(&mut self, start: usize, end: usize, fields: &mut usize, filled: &mut usize) {
        let field = self.bytes.get(start..end).unwrap_or_default();
        if field.is_empty() && self.delimiter == BLANKS {
            return;
        }
        *fields += 1;
        if !field.is_empty() {
            *filled = *fields;
        }
        if self.fields.len() < MAX_COLUMNS {
            let quoted = field.strip_prefix(b"\"").map(|rest| rest.strip_suffix(b"\"").unwrap_or(rest));
            self.fields.push(quoted.unwrap_or(field));
        }
    }

    /// Behind the mark that ends the quotation begun at `at`; doubled ones are part of it.
    fn end_of_quotes(&self, at: usize) -> usize {
        let mut here = at + 1;
        while let Some(byte) = self.bytes.get(here) {
            match byte {
                b'\n' | b'\r' => break,
                b'"' if self.bytes.get(here + 1) == Some(&b'"') => here += 2,
                b'"' => return here + 1,
                _ => here += 1,
            }
        }
        // Unbalanced: the mark is an ordinary character of its field.
        at + 1
    }
}

/// A column's place, if the file has it.
pub type Col = Option<usize>;

/// A row of the table's body: one value a column.
#[derive(Debug)]
pub struct Row<'a, 'b> {
    /// Its line in the file, from 1.
    pub line: u64,
    pub(super) fields: &'b [&'a [u8]],
    /// Set where a field that must be a number is none.
    pub(super) text_for_number: &'b Cell<bool>,
}

impl<'a> Row<'a, '_> {
    /// A field without the blanks around it; empty where there is no such column.
    pub fn text(&self, column: Col) -> &'a [u8] {
        column.and_then(|column| self.fields.get(column)).map_or(&[], |field| field.trim_ascii())
    }

    /// A number; NaN where missing.
    pub fn number(&self, column: Col) -> f64 {
        let Some(field) = column.and_then(|column| self.fields.get(column)) else { return f64::NAN };
        match field_of(field) {
            Field::Number(value) => value,
            Field::Missing => f64::NAN,
            Field::Text => {
                self.text_for_number.set(true);
                f64::NAN
            }
        }
    }

    /// As [`Self::number`], `None` where missing.
    pub fn some(&self, column: Col) -> Option<f64> {
        Some(self.number(column)).filter(|value| !value.is_nan())
    }

    /// Three numbers; NaN where missing.
    pub fn vector(&self, columns: [Col; 3]) -> DVec3 {
        DVec3::from(columns.map(|column| self.number(column)))
    }

    /// A time in ns, exactly; `None` where missing or no time.
    pub fn time_ns(&self, column: Col, unit_ns: f64) -> Option<i64> {
        time_ns(self.text(column), unit_ns)
    }

    /// The field says this, in any case.
    pub fn is(&self, column: Col, text: &str) -> bool {
        self.text(column).eq_ignore_ascii_case(text.as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(text: &str, delimiter: u8) -> Vec<Vec<String>> {
        let mut splitter = Splitter::new(text.as_bytes(), 0, 0, delimiter);
        let mut lines = Vec::new();
        while splitter.next_line().is_some() {
            let field = |field: &&[u8]| String::from_utf8_lossy(field).into_owned();
            lines.push(splitter.fields.iter().map(field).collect());
        }
        lines
    }

    #[test]
    fn lines_end_in_three_ways() {
        assert_eq!(
            split("a,b\r\nc,\rd\n\ne", b','),
            [vec!["a", "b"], vec!["c", ""], vec!["d"], vec![""], vec!["e"]]
        );
        assert_eq!(split("", b','), Vec::<Vec<String>>::new());
        assert_eq!(split("\n", b','), [[""]]);
    }

    #[test]
    fn quotes_hold_delimiters_but_no_lines() {
        assert_eq!(split(r#""a,b",c,"d ""e"", f""#, b','), [["a,b", "c", r#"d ""e"", f"#]]);
        assert_eq!(split("\"a,b\n2,3", b','), [vec!["a", "b"], vec!["2", "3"]]);
        assert_eq!(split("5\" wide,2", b','), [["5\" wide", "2"]]);
    }

    #[test]
    fn runs_of_blanks_are_one_delimiter() {
        assert_eq!(split("  1 \t 2   3 \n4", BLANKS), [vec!["1", "2", "3"], vec!["4"]]);
    }

    #[test]
    fn a_line_knows_its_number_and_whether_it_ends() {
        let mut splitter = Splitter::new(b"1,2,,\r\n3", 0, 6, b',');
        assert_eq!(splitter.next_line(), Some(Line { number: 7, filled: 2, ended: true }));
        assert_eq!(splitter.next_line(), Some(Line { number: 8, filled: 1, ended: false }));
        assert_eq!(splitter.next_line(), None);
    }

    #[test]
    fn endless_rows_take_no_memory() {
        let text = ",".repeat(1_000_000);
        let mut splitter = Splitter::new(text.as_bytes(), 0, 0, b',');
        splitter.next_line();
        assert_eq!(splitter.fields.len(), MAX_COLUMNS);
    }
}
