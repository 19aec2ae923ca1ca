//! Text tables: comma, semicolon, tab or blanks between fields, a header somewhere near the top or none,
//! columns by name. Rows are streamed from the file's bytes.

mod number;
mod read;
mod split;
mod time;

pub(super) use read::read_rows;
pub(super) use split::{Col, Row};
pub(super) use time::{UNIX_FROM_NET_TICKS, guess_unit_ns, least_offset_ns, unit_ns};

use super::{Input, ReadOptions};
use crate::error::{Error, Result};
use split::{BLANKS, Splitter};
use std::path::Path;

/// A header is looked for in so many lines and bytes from the start: exports put at most some tens of
/// lines before it.
const HEADER_LINES: u64 = 100;
const HEADER_BYTES: usize = 1 << 20;

/// A column as the header names it.
#[derive(Clone, Debug, Default)]
struct Column {
    /// As in the file, without the blanks around it.
    name: String,
    /// Lower case.
    whole: String,
    /// Lower case, what stands in brackets taken out, single blanks.
    key: String,
    /// What stands in brackets, lower case.
    unit: String,
    /// Goes into the samples, so not into the extra columns.
    taken: bool,
}

impl Column {
    fn of(field: &[u8]) -> Self {
        let text = String::from_utf8_lossy(field).replace(['\u{a0}', '\0'], " ");
        let name = text.trim().to_owned();
        let whole = name.to_lowercase();
        let (mut key, mut unit, mut inside) = (String::new(), String::new(), false);
        for letter in whole.chars() {
            match letter {
                '[' | '(' => inside = true,
                ']' | ')' => inside = false,
                _ if inside => unit.push(letter),
                _ => key.push(letter),
            }
        }
        let key = key.split_whitespace().collect::<Vec<_>>().join(" ");
        Self { name, whole, key, unit: unit.trim().to_owned(), taken: false }
    }

    fn is_named(&self, name: &str) -> bool {
        self.whole == name || self.key == name
    }
}

/// Where a header was found.
struct Header {
    columns: Vec<Column>,
    delimiter: u8,
    /// Start of the line behind it, and the number of its own line.
    body: usize,
    line: u64,
}

/// The likeliest delimiter of a line; a tab before a semicolon before a comma where they are as many.
fn delimiter_of(line: &[u8]) -> u8 {
    let count = |delimiter: u8| line.iter().filter(|byte| **byte == delimiter).count();
    let best = [b',', b';', b'\t'].into_iter().max_by_key(|delimiter| count(*delimiter));
    best.filter(|delimiter| count(*delimiter) > 0).unwrap_or(BLANKS)
}

fn without_bom(bytes: &[u8]) -> usize {
    if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 }
}

/// Lines near the top: start, number, content.
fn top_lines(bytes: &[u8]) -> impl Iterator<Item = (usize, u64, &[u8])> {
    let top = bytes.get(..HEADER_BYTES.min(bytes.len())).unwrap_or_default();
    // A byte that no line contains: the splitter finds the ends of lines only.
    let mut at = Splitter::new(top, without_bom(top), 0, b'\n');
    std::iter::from_fn(move || {
        let start = at.position();
        let line = at.next_line()?;
        let end = at.position().min(top.len());
        Some((start, line.number, top.get(start..end).unwrap_or_default()))
    })
    .take_while(|(_, number, _)| *number <= HEADER_LINES)
}

fn contains(line: &[u8], lower_case: &str) -> bool {
    line.windows(lower_case.len().max(1)).any(|part| part.eq_ignore_ascii_case(lower_case.as_bytes()))
}

/// The first line that names all of `required` (lower case, with or without the unit).
fn find_header(bytes: &[u8], required: &[&str]) -> Option<Header> {
    let first_word = required.first()?.split(['[', '(', ' ']).next()?;
    top_lines(bytes).filter(|(_, _, line)| contains(line, first_word)).find_map(|(start, number, line)| {
        let delimiter = delimiter_of(line);
        let mut splitter = Splitter::new(bytes, start, number - 1, delimiter);
        splitter.next_line()?;
        let mut columns: Vec<Column> = splitter.fields.iter().map(|field| Column::of(field)).collect();
        // A delimiter behind the last name makes no column.
        let named = columns.iter().rposition(|column| !column.name.is_empty())?;
        columns.truncate(named + 1);
        let has = |name: &&str| columns.iter().any(|column| column.is_named(name));
        required.iter().all(has).then(|| Header {
            columns,
            delimiter,
            body: splitter.position(),
            line: number,
        })
    })
}

/// A file has a header with all these columns (lower case).
pub(super) fn has_header(head: &str, required: &[&str]) -> bool {
    find_header(head.as_bytes(), required).is_some()
}

/// A table whose header is known.
#[derive(Debug)]
pub(super) struct Table<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    body: usize,
    header_line: u64,
    delimiter: u8,
    columns: Vec<Column>,
    /// What had to be assumed.
    pub notes: Vec<String>,
}

impl<'a> Table<'a> {
    /// Finds the header, which names at least `required` (lower case). A file without one is taken to
    /// have the columns of `documented` in this order, if it has as many.
    ///
    /// # Errors
    /// [`Error::File`] where there is neither.
    pub(super) fn open(input: &'a Input, required: &[&str], documented: &[&str]) -> Result<Self> {
        let bytes = input.text();
        let (header, notes) = match find_header(bytes, required) {
            Some(header) => (header, Vec::new()),
            None => {
                let header = headerless(bytes, documented).ok_or_else(|| {
                    let wanted = required.join(", ");
                    Error::file(&input.path, format!("has no header line with the columns {wanted}"))
                })?;
                let note = "there is no header; the columns were taken in the documented order";
                (header, vec![note.to_owned()])
            }
        };
        Ok(Self {
            path: &input.path,
            bytes,
            body: header.body,
            header_line: header.line,
            delimiter: header.delimiter,
            columns: header.columns,
            notes,
        })
    }

    /// The column of this name: the whole of it, or without its unit; lower case.
    pub(super) fn find(&self, name: &str) -> Col {
        let whole = self.columns.iter().position(|column| column.whole == name);
        whole.or_else(|| self.columns.iter().position(|column| column.key == name))
    }

    /// The column of this name that has one of these units, both lower case, the unit without blanks.
    pub(super) fn find_with_unit(&self, name: &str, units: &[&str]) -> Col {
        let fits = |column: &Column| column.key == name && units.contains(&&*column.unit.replace(' ', ""));
        self.columns.iter().position(fits)
    }

    /// As [`Self::find`], for a column that goes into the samples and so not into the extra ones.
    pub(super) fn take(&mut self, name: &str) -> Col {
        let column = self.find(name);
        self.mark_taken(column);
        column
    }

    /// The column goes into the samples, and so not into the extra ones.
    pub(super) fn mark_taken(&mut self, column: Col) {
        if let Some(column) = column.and_then(|column| self.columns.get_mut(column)) {
            column.taken = true;
        }
    }

    /// Three columns whose names differ in a letter: `{}` in the name stands for x, y and z.
    pub(super) fn take_xyz(&mut self, name: &str) -> [Col; 3] {
        ["x", "y", "z"].map(|axis| self.take(&name.replace("{}", axis)))
    }

    /// The unit of a column, lower case, as in `ms`; empty where it has none.
    pub(super) fn unit(&self, column: Col) -> &str {
        column.and_then(|column| self.columns.get(column)).map_or("", |column| &column.unit)
    }

    /// At most so many rows: from the ends of lines, and from the bytes that a row needs at least.
    fn rows_at_most(&self) -> usize {
        let body = self.bytes.get(self.body..).unwrap_or_default();
        let ends = memchr::memchr_iter(b'\n', body).count().max(memchr::memchr_iter(b'\r', body).count());
        (ends + 1).min(body.len() / self.columns.len().max(1) + 1)
    }

    fn splitter(&self) -> Splitter<'a> {
        Splitter::new(self.bytes, self.body, self.header_line, self.delimiter)
    }

    /// Goes through the rows that have a field for each column, until `row` says false.
    pub(super) fn for_rows(&self, mut row: impl FnMut(&Row) -> bool) {
        let mut splitter = self.splitter();
        let text_for_number = std::cell::Cell::new(false);
        while let Some(line) = splitter.next_line() {
            if splitter.fields.len() >= self.columns.len() && line.filled <= self.columns.len() {
                let fields = &splitter.fields;
                if !row(&Row { line: line.number, fields, text_for_number: &text_for_number }) {
                    return;
                }
            }
        }
    }
}

/// The columns of a file that begins with numbers, if it has as many as are documented.
fn headerless(bytes: &[u8], documented: &[&str]) -> Option<Header> {
    let (start, number, line) = top_lines(bytes).find(|(_, _, line)| !line.trim_ascii().is_empty())?;
    let delimiter = delimiter_of(line);
    let mut splitter = Splitter::new(bytes, start, number - 1, delimiter);
    splitter.next_line()?;
    let is_number = |field: &&[u8]| !matches!(number::field_of(field), number::Field::Text);
    let fits = splitter.fields.len() == documented.len() && splitter.fields.iter().all(is_number);
    let columns = documented.iter().map(|name| Column::of(name.as_bytes())).collect();
    fits.then_some(Header { columns, delimiter, body: start, line: number - 1 })
}

#[cfg(test)]
mod tests;
