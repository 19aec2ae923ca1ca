//! From the clock of the machine that sent a stream to that of the machine that recorded it.

/// A jump of the offset by more than this, in s, means that a clock was set or a machine restarted;
/// drift between two measurements (5 s apart) is about a millisecond. Larger hides a small reset in one
/// line through both sides of it; smaller takes network jitter for resets.
const RESET_S: f64 = 1.0;

/// The most segments that are told apart, so that a hostile file costs no more than a long one.
const MAX_SEGMENTS: usize = 256;

/// Measured offsets of one stream, in the order of the file.
#[derive(Debug, Default)]
pub(super) struct Clock {
    /// Time on the sender's clock and what is to be added to it, s.
    offsets: Vec<(f64, f64)>,
}

/// A stretch without a reset: the least-squares line through its offsets.
#[derive(Debug)]
struct Segment {
    first_s: f64,
    last_s: f64,
    middle_s: f64,
    offset_s: f64,
    slope: f64,
}

/// The clock's lines.
#[derive(Debug)]
pub(super) struct Fitted(Vec<Segment>);

impl Segment {
    fn of(offsets: &[(f64, f64)]) -> Option<Self> {
        let ((first_s, _), (last_s, _)) = (*offsets.first()?, *offsets.last()?);
        let count = offsets.len() as f64;
        let middle_s = offsets.iter().map(|(time, _)| time).sum::<f64>() / count;
        let offset_s = offsets.iter().map(|(_, offset)| offset).sum::<f64>() / count;
        let spread: f64 = offsets.iter().map(|(time, _)| (time - middle_s).powi(2)).sum();
        let product: f64 = offsets.iter().map(|(time, offset)| (time - middle_s) * (offset - offset_s)).sum();
        let slope = if spread > 0.0 { product / spread } else { 0.0 };
        Some(Self { first_s, last_s, middle_s, offset_s, slope })
    }

    /// How far a time lies outside.
    fn distance_s(&self, time_s: f64) -> f64 {
        (self.first_s - time_s).max(time_s - self.last_s).max(0.0)
    }
}

impl Clock {
    /// Adds a measurement; one that is not finite is left out.
    pub(super) fn add(&mut self, time_s: f64, offset_s: f64) {
        if time_s.is_finite() && offset_s.is_finite() {
            self.offsets.push((time_s, offset_s));
        }
    }

    pub(super) fn fitted(&self) -> Fitted {
        let steady = |before: &(f64, f64), after: &(f64, f64)| {
            after.0 >= before.0 && (after.1 - before.1).abs() <= RESET_S
        };
        Fitted(self.offsets.chunk_by(steady).filter_map(Segment::of).take(MAX_SEGMENTS).collect())
    }
}

impl Fitted {
    /// A time of the sender on the clock of the recording machine: by the segment it lies in or next to.
    /// Without offsets both clocks are the same.
    pub(super) fn local_s(&self, time_s: f64) -> f64 {
        let nearer = |a: &&Segment, b: &&Segment| a.distance_s(time_s).total_cmp(&b.distance_s(time_s));
        match self.0.iter().min_by(nearer) {
            Some(segment) => time_s + segment.offset_s + segment.slope * (time_s - segment.middle_s),
            None => time_s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fitted(offsets: &[(f64, f64)]) -> Fitted {
        let mut clock = Clock::default();
        for (time, offset) in offsets {
            clock.add(*time, *offset);
        }
        clock.fitted()
    }

    #[test]
    fn offsets_drift_and_resets() {
        assert_eq!(fitted(&[]).local_s(5.0), 5.0);
        assert_eq!(fitted(&[(6.0, -0.5), (f64::NAN, 3.0)]).local_s(5.0), 4.5);
        // A drift of 1 ms in 10 s, extrapolated.
        let drift = fitted(&[(0.0, 1.0), (10.0, 1.001)]);
        assert!((drift.local_s(20.0) - 21.002).abs() < 1e-12);
        // The sender restarts: its clock begins again at 0.
        let reset = fitted(&[(1000.0, -900.0), (1005.0, -900.0), (10.0, 98.0), (15.0, 98.0)]);
        assert_eq!(reset.0.len(), 2);
        assert_eq!([1001.0, 1008.0, 8.0, 12.0].map(|time| reset.local_s(time)), [101.0, 108.0, 106.0, 110.0]);
    }
}
