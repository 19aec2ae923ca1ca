//! Rows of numbers into columns, a piece of text at a time.

use super::text;

/// The most values of one recording, whether told or missing: 8 GiB of them, as much as the text of any
/// format. That is 7 hours of 1 kHz with all columns, or 50 with six.
const MAX_VALUES: usize = 1 << 30;
/// The most bytes of one row.
const MAX_ROW: usize = 1 << 20;
/// One unit of our own times is 10^9 ns: a second.
const SECONDS: u32 = 9;

/// What a field becomes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// The sample's time, of which one unit is 10^power ns.
    Time {
        /// That power.
        power: u32,
    },
    /// As our recordings have it.
    Received,
    /// As our recordings have it.
    Device,
    /// A number.
    Number,
}

/// Why rows were left out, or values.
#[derive(Debug, Default)]
pub struct Complaints {
    /// Rows without a time, with the first of them.
    pub no_time: u64,
    pub first_no_time: Option<(u64, String)>,
    /// Rows with fewer fields than columns.
    pub short: u64,
    /// Rows with more.
    pub long: u64,
    /// Fields that are no numbers, with the place (row, field) of the first.
    pub no_number: u64,
    pub first_no_number: Option<(u64, usize)>,
    /// The last row was cut.
    pub cut: bool,
    /// More rows than can be held.
    pub too_many: bool,
}

/// The rows so far.
#[derive(Debug)]
pub struct Rows {
    fields: Vec<Field>,
    /// Which of `fields` a short row may lack without complaint: those after this many.
    least: usize,
    pub time_ns: Vec<i64>,
    pub received_ns: Vec<i64>,
    pub device_ns: Vec<Option<i64>>,
    /// For each of the fields; empty for times.
    pub numbers: Vec<Vec<f64>>,
    pub complaints: Complaints,
    /// How many values may still be kept: rows that lack most of their fields must not cost the memory of
    /// whole ones without end.
    room: usize,
    /// A row that has begun in the piece before.
    carried: Vec<u8>,
    row: Vec<f64>,
    number: u64,
}

impl Rows {
    /// Where there is no time among the `fields`, rows are numbered instead. Rows may lack fields after
    /// the first `least`.
    pub fn new(fields: Vec<Field>, least: usize) -> Self {
        Self {
            least,
            time_ns: Vec::new(),
            received_ns: Vec::new(),
            device_ns: Vec::new(),
            numbers: vec![Vec::new(); fields.len()],
            complaints: Complaints::default(),
            room: MAX_VALUES,
            carried: Vec::new(),
            row: vec![f64::NAN; fields.len()],
            number: 0,
            fields,
        }
    }

    /// The next piece of text.
    pub fn feed(&mut self, mut piece: &[u8]) {
        if self.number == 0 && self.carried.is_empty() {
            // A byte order mark.
            piece = piece.strip_prefix(b"\xef\xbb\xbf").unwrap_or(piece);
        }
        if !self.carried.is_empty() {
            let Some(end) = piece.iter().position(|byte| *byte == b'\n') else {
                self.carry(piece);
                return;
            };
            let mut row = std::mem::take(&mut self.carried);
            row.extend_from_slice(&piece[..end]);
            self.row(&row);
            row.clear();
            self.carried = row;
            piece = &piece[end + 1..];
        }
        let whole = piece.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        let mut rest = &piece[..whole];
        while !rest.is_empty() {
            let used = self.row(rest);
            rest = &rest[used..];
        }
        self.carry(&piece[whole..]);
    }

    fn carry(&mut self, part: &[u8]) {
        // A row beyond that is none; what is kept of it is enough to say so.
        let room = MAX_ROW.saturating_sub(self.carried.len());
        self.carried.extend_from_slice(&part[..part.len().min(room)]);
    }

    /// The text has ended. A last row without a line end counts if it is `whole` as far as one can see.
    pub fn end(&mut self, may_be_whole: bool) {
        let row = std::mem::take(&mut self.carried);
        if row.is_empty() {
            return;
        }
        let fields = 1 + row.iter().filter(|byte| **byte == b'\t').count();
        if may_be_whole && fields == self.fields.len() {
            self.row(&row);
        } else {
            self.complaints.cut = true;
        }
    }

    /// One row at the start of `text`, up to a line end or the end; returns how far it went.
    fn row(&mut self, text: &[u8]) -> usize {
        self.number += 1;
        let mut at = 0;
        let mut time_ns = None;
        let mut received_ns = None;
        let mut device_ns = None;
        let mut count = 0;
        for (index, field) in self.fields.iter().enumerate() {
            let rest = &text[at..];
            let row_ended = matches!(rest.first(), None | Some(b'\n')) || rest.starts_with(b"\r\n");
            // After a tab there is a field, if an empty one.
            if row_ended && text[..at].last() != Some(&b'\t') {
                break;
            }
            count += 1;
            let used = match *field {
                Field::Number => match text::value(rest) {
                    Some((value, used)) if ends(rest, used) => {
                        self.row[index] = value;
                        used
                    }
                    _ => {
                        self.row[index] = f64::NAN;
                        self.complaints.no_number += 1;
                        self.complaints.first_no_number.get_or_insert((self.number, index));
                        field_end(rest)
                    }
                },
                Field::Time { power } => read_time(rest, power, &mut time_ns),
                Field::Received => read_time(rest, SECONDS, &mut received_ns),
                Field::Device => {
                    let mut told = None;
                    let used = read_time(rest, SECONDS, &mut told);
                    device_ns = Some(told);
                    used
                }
            };
            at += used;
            match text.get(at) {
                Some(b'\t') => at += 1,
                _ => break,
            }
        }
        let rest = &text[at..];
        let end = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
        let over = !rest[..end].is_empty() && rest[..end] != *b"\r";
        let next = (at + end + 1).min(text.len());
        if count == 0 && !over {
            return next;
        }
        self.keep(&text[..next], count, over, time_ns, received_ns, device_ns);
        next
    }

    fn keep(
        &mut self,
        text: &[u8],
        count: usize,
        over: bool,
        time_ns: Option<i64>,
        received_ns: Option<i64>,
        device_ns: Option<Option<i64>>,
    ) {
        let timed = self.fields.iter().any(|field| matches!(field, Field::Time { .. }));
        let time_ns = match time_ns {
            Some(time_ns) => time_ns,
            None if !timed => i64::try_from(self.time_ns.len()).unwrap_or(i64::MAX),
            None => {
                self.complaints.no_time += 1;
                if self.complaints.first_no_time.is_none() {
                    let shown = String::from_utf8_lossy(&text[..text.len().min(40)]).trim().to_owned();
                    self.complaints.first_no_time = Some((self.number, shown));
                }
                return;
            }
        };
        // At least the time.
        let Some(room) = self.room.checked_sub(self.fields.len().max(1)) else {
            self.complaints.too_many = true;
            return;
        };
        self.room = room;
        self.complaints.short += u64::from(count < self.least);
        self.complaints.long += u64::from(over && count == self.fields.len());
        self.time_ns.push(time_ns);
        for (index, field) in self.fields.iter().enumerate() {
            match field {
                Field::Time { .. } => {}
                Field::Received => self.received_ns.push(received_ns.unwrap_or(time_ns)),
                Field::Device => self.device_ns.push(device_ns.unwrap_or(Some(time_ns))),
                Field::Number => {
                    self.numbers[index].push(if index < count { self.row[index] } else { f64::NAN });
                }
            }
        }
    }
}

/// Reads a time field; returns where the field ends.
fn read_time(rest: &[u8], power: u32, time_ns: &mut Option<i64>) -> usize {
    match text::time_ns(rest, power) {
        Some((value, used)) if ends(rest, used) => {
            *time_ns = Some(value);
            used
        }
        _ => field_end(rest),
    }
}

/// A field ends there.
fn ends(rest: &[u8], at: usize) -> bool {
    matches!(rest.get(at), None | Some(b'\t' | b'\n'))
        || rest[at..].starts_with(b"\r\n")
        || rest[at..] == *b"\r"
}

fn field_end(rest: &[u8]) -> usize {
    rest.iter().position(|byte| matches!(byte, b'\t' | b'\n')).unwrap_or(rest.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_rows_cost_as_much_as_whole_ones() {
        let mut rows = Rows::new(vec![Field::Number; 100], 1);
        rows.room = 1099;
        rows.feed(&b"1\n".repeat(10));
        assert!(!rows.complaints.too_many);
        rows.feed(b"1\n");
        assert!(rows.complaints.too_many);
        assert_eq!((rows.time_ns.len(), rows.numbers[99].len()), (10, 10));
    }
}
