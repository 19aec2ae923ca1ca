//! Packed little-endian records whose fields a `.dtype` file names.

/// How one field is stored.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Float(usize),
    Signed(usize),
    Unsigned(usize),
}

/// Where a field of a record lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Field {
    kind: Kind,
    offset: usize,
}

/// The fields of a record.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Layout {
    fields: Vec<(String, Field)>,
    size: usize,
}

/// The files of one part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part<'a> {
    pub(super) raw: &'a [u8],
    pub(super) time: &'a [u8],
}

/// What of a part could not be used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rest {
    /// Records without a time, or times without a record.
    pub(super) unpaired: u64,
    /// Files that end within a record or time.
    pub(super) cut: u64,
}

/// All parts of one kind of data.
#[derive(Clone, Debug, Default)]
pub(super) struct Series {
    layout: Layout,
    pub(super) times_ns: Vec<i64>,
    records: Vec<u8>,
}

impl Kind {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "float32" => Self::Float(4),
            "float64" => Self::Float(8),
            "int8" => Self::Signed(1),
            "int16" => Self::Signed(2),
            "int32" => Self::Signed(4),
            "int64" => Self::Signed(8),
            "uint8" | "bool" => Self::Unsigned(1),
            "uint16" => Self::Unsigned(2),
            "uint32" => Self::Unsigned(4),
            "uint64" => Self::Unsigned(8),
            _ => return None,
        })
    }

    fn size(self) -> usize {
        let (Self::Float(size) | Self::Signed(size) | Self::Unsigned(size)) = self;
        size
    }
}

impl Layout {
    /// From a list of pairs of quoted names and types; `None` where it is none.
    pub(super) fn of(text: &str) -> Option<Self> {
        let quoted: Vec<_> = text.split('"').skip(1).step_by(2).collect();
        let mut layout = Self::default();
        for pair in quoted.chunks(2) {
            let [name, kind] = pair else { return None };
            layout.add(name, Kind::of(kind)?);
        }
        (layout.size > 0).then_some(layout)
    }

    pub(super) fn of_floats(names: &[&str]) -> Self {
        let mut layout = Self::default();
        for name in names {
            layout.add(name, Kind::Float(4));
        }
        layout
    }

    fn add(&mut self, name: &str, kind: Kind) {
        self.fields.push((name.into(), Field { kind, offset: self.size }));
        self.size += kind.size();
    }
}

impl Series {
    pub(super) fn new(layout: Layout) -> Self {
        Self { layout, ..Self::default() }
    }

    /// A field by its name.
    pub(super) fn field(&self, name: &str) -> Option<Field> {
        let found = self.layout.fields.iter().find(|(known, _)| known == name);
        found.map(|(_, field)| *field)
    }

    /// Appends what of a part has both a record and a time.
    pub(super) fn add(&mut self, part: Part<'_>) -> Rest {
        let size = self.layout.size.max(1);
        let (records, times) = (part.raw.len() / size, part.time.len() / 8);
        let count = records.min(times);
        self.records.extend_from_slice(&part.raw[..count * size]);
        let (whole, _) = part.time.as_chunks();
        self.times_ns.extend(whole.iter().take(count).map(|bytes| i64::from_le_bytes(*bytes)));
        let cut = [part.raw.len() % size, part.time.len() % 8].iter().filter(|rest| **rest > 0).count();
        Rest { unpaired: records.abs_diff(times) as u64, cut: cut as u64 }
    }

    fn bits(&self, index: usize, field: Field) -> Option<u64> {
        let start = index.checked_mul(self.layout.size)? + field.offset;
        let bytes = self.records.get(start..)?.get(..field.kind.size())?;
        Some(bytes.iter().rev().fold(0, |bits, byte| bits << 8 | u64::from(*byte)))
    }

    /// A field of a record as a number; NaN where there is none.
    pub(super) fn value(&self, index: usize, field: Option<Field>) -> f64 {
        let told = field.and_then(|field| Some((self.bits(index, field)?, field.kind)));
        match told {
            Some((bits, Kind::Float(4))) => f64::from(f32::from_bits(bits as u32)),
            Some((bits, Kind::Float(_))) => f64::from_bits(bits),
            _ => self.integer(index, field).map_or(f64::NAN, |value| value as f64),
        }
    }

    /// A field of whole numbers.
    pub(super) fn integer(&self, index: usize, field: Option<Field>) -> Option<i64> {
        let bits = self.bits(index, field?)?;
        match field?.kind {
            Kind::Float(_) => None,
            Kind::Unsigned(_) => i64::try_from(bits).ok(),
            Kind::Signed(size) => {
                let unused_bits = 64 - 8 * size as u32;
                Some((bits << unused_bits) as i64 >> unused_bits)
            }
        }
    }

    /// The record nearest in time, if it is near enough. Times ascend.
    pub(super) fn nearest(&self, time_ns: i64, within_ns: u64) -> Option<usize> {
        let after = self.times_ns.partition_point(|time| *time < time_ns);
        let around = [after.checked_sub(1), Some(after)].into_iter().flatten();
        let distances = around.filter_map(|at| Some((self.times_ns.get(at)?.abs_diff(time_ns), at)));
        distances.min().filter(|(distance_ns, _)| *distance_ns <= within_ns).map(|(_, at)| at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_are_read_from_text() {
        let layout = Layout::of("[\n(\"worn\", \"uint8\"),\n(\"t\", \"int64\"), \n]\n").expect("good");
        assert_eq!(layout.size, 9);
        for bad in ["", "[]", "(\"x\")", "(\"x\", \"complex64\")", "(\"x\", \"float32\", \"y\")"] {
            assert_eq!(Layout::of(bad), None, "{bad}");
        }
    }

    #[test]
    fn records_of_all_kinds() {
        let layout = Layout::of("\"a\",\"int16\",\"b\",\"float32\",\"c\",\"uint8\",\"d\",\"float64\"");
        let mut series = Series::new(layout.expect("good"));
        let record =
            [&(-2i16).to_le_bytes()[..], &0.5f32.to_le_bytes(), &[200], &0.25f64.to_le_bytes()].concat();
        let raw = [record.clone(), record.clone(), record, vec![0; 3]].concat();
        let time = [5i64, 10].map(i64::to_le_bytes).concat();
        assert_eq!(series.add(Part { raw: &raw, time: &time }), Rest { unpaired: 1, cut: 1 });
        assert_eq!(series.times_ns, [5, 10]);
        let values = ["a", "b", "c", "d"].map(|name| series.value(1, series.field(name)));
        assert_eq!(values, [-2.0, 0.5, 200.0, 0.25]);
        assert!(series.value(2, series.field("a")).is_nan() && series.value(0, series.field("e")).is_nan());
        assert_eq!(
            [series.integer(0, series.field("a")), series.integer(0, series.field("b"))],
            [Some(-2), None]
        );
    }

    #[test]
    fn the_nearest_record_is_found_if_near() {
        let series = Series { times_ns: vec![10, 20, 30], ..Series::default() };
        let found = [-9, 8, 14, 16, 25, 33, 36].map(|time| series.nearest(time, 5));
        assert_eq!(found, [None, Some(0), Some(0), Some(1), Some(1), Some(2), None]);
        assert_eq!(Series::default().nearest(i64::MIN, u64::MAX), None);
        assert_eq!(series.nearest(i64::MIN, u64::MAX), Some(0));
    }
}
