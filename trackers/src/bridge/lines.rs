//! Bytes of a stream into lines of limited length.

/// The longest line, bytes: a message with everything in it is under 2 KiB.
pub const MAX_LINE: usize = 16 << 10;

/// A line, or the news that one was too long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line<'a> {
    /// Without its end.
    Whole(&'a [u8]),
    /// It was left out.
    TooLong,
}

/// The line that has begun.
#[derive(Debug, Default)]
pub struct Lines {
    begun: Vec<u8>,
    too_long: bool,
}

impl Lines {
    /// Calls `told` for each line that these bytes end. Empty lines are none.
    pub fn feed(&mut self, bytes: &[u8], mut told: impl FnMut(Line<'_>)) {
        for part in bytes.split_inclusive(|byte| *byte == b'\n') {
            let (part, ends) = part.strip_suffix(b"\n").map_or((part, false), |part| (part, true));
            if self.too_long || self.begun.len() + part.len() > MAX_LINE {
                self.begun.clear();
                self.too_long = true;
            } else {
                self.begun.extend_from_slice(part);
            }
            if ends {
                self.end(&mut told);
            }
        }
    }

    /// The stream has ended: what has begun is a line too.
    pub fn end(&mut self, told: &mut impl FnMut(Line<'_>)) {
        let line = self.begun.trim_ascii();
        if self.too_long {
            told(Line::TooLong);
        } else if !line.is_empty() {
            told(Line::Whole(line));
        }
        self.begun.clear();
        self.too_long = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(parts: &[&[u8]]) -> Vec<String> {
        let mut lines = Lines::default();
        let mut told = Vec::new();
        let mut tell = |line: Line<'_>| {
            told.push(match line {
                Line::Whole(line) => String::from_utf8_lossy(line).into_owned(),
                Line::TooLong => "too long".into(),
            });
        };
        for part in parts {
            lines.feed(part, &mut tell);
            assert!(lines.begun.len() <= MAX_LINE);
        }
        lines.end(&mut tell);
        told
    }

    #[test]
    fn lines_are_put_together_and_long_ones_left_out() {
        assert_eq!(lines(&[b"a\nb", b"c\r\n\n  \nd"]), ["a", "bc", "d"]);
        let long = vec![b'x'; 10_000];
        assert_eq!(lines(&[b"a\n", &long, &long, &long, b"y\nb\n"]), ["a", "too long", "b"]);
        assert_eq!(lines(&[&[b'x'; MAX_LINE]])[0].len(), MAX_LINE);
    }
}
