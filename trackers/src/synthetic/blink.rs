//! Stretches of time that come now and then: blinks, and losses of the tracker.

use super::random::Random;
use super::saccade::smooth;

/// From a time to another, in the block's own time, ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Span {
    pub(super) start_ns: i64,
    pub(super) end_ns: i64,
}

impl Span {
    pub(super) fn contains(&self, time_ns: i64) -> bool {
        (self.start_ns..self.end_ns).contains(&time_ns)
    }
}

/// How spans are spread.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spread {
    pub(super) per_min: f64,
    pub(super) median_ms: f64,
    /// Within which part of the block.
    pub(super) within: Span,
    /// How long the whole block is, so that the rate holds over all of it.
    pub(super) block_ns: i64,
}

/// Shortest time between two spans, ns.
const GAP_NS: f64 = 200e6;
/// Standard deviation of the logarithm of their length.
const LENGTH_SIGMA: f64 = 0.25;

/// Spans in ascending order that do not touch, at random times.
pub(super) fn spans(random: &mut Random, spread: &Spread) -> Vec<Span> {
    let mut found = Vec::new();
    if spread.per_min <= 0.0 {
        return found;
    }
    let Span { start_ns, end_ns } = spread.within;
    let usable = (end_ns - start_ns) as f64 / spread.block_ns as f64;
    let median_ns = spread.median_ms * 1e6;
    let every_ns = 60e9 / spread.per_min * usable;
    let gap_ns = (every_ns - median_ns - GAP_NS).max(1e6);
    // The first may come at once: as if the block had been cut out of a longer time.
    let mut at_ns = start_ns + random.exponential(every_ns) as i64;
    loop {
        let length_ns = random.log_normal(median_ns, LENGTH_SIGMA).min(4.0 * median_ns) as i64;
        if at_ns + length_ns >= end_ns {
            return found;
        }
        found.push(Span { start_ns: at_ns, end_ns: at_ns + length_ns });
        at_ns += length_ns + (GAP_NS + random.exponential(gap_ns)) as i64;
    }
}

/// The span that contains a time.
pub(super) fn span_at(spans: &[Span], time_ns: i64) -> Option<Span> {
    let begun = spans.partition_point(|span| span.start_ns <= time_ns);
    let last = begun.checked_sub(1).and_then(|index| spans.get(index))?;
    last.contains(time_ns).then_some(*last)
}

/// When the lids are down, and when they begin to rise, as fractions of a blink: they close faster than
/// they open. Together with the median length this gives the 160 to 220 ms of the hand-labelled blinks.
const CLOSED: [f64; 2] = [0.3, 0.5];

/// How far the lids are open at a time of a blink, 0 to 1.
pub(super) fn openness(blink: Span, time_ns: i64) -> f64 {
    let along = (time_ns - blink.start_ns) as f64 / (blink.end_ns - blink.start_ns) as f64;
    let [down, up] = CLOSED;
    if along < up { 1.0 - smooth(along / down) } else { smooth((along - up) / (1.0 - up)) }
}

/// When the lids are less than half open, and so cover the pupil.
pub(super) fn covered(blink: Span) -> Span {
    let length = (blink.end_ns - blink.start_ns) as f64;
    let [down, up] = CLOSED;
    // Both movements are half done at half their time.
    let from = (length * down * 0.5) as i64;
    let to = (length * (up + (1.0 - up) * 0.5)) as i64;
    Span { start_ns: blink.start_ns + from, end_ns: blink.start_ns + to }
}
