//! What the eye does at a time, and whether it sees well.

use super::session::{EyeInterval, SessionGaze};
use crate::estimate::EyeState;

/// When vision is suppressed around a saccade, which hides a fovea that comes late.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Suppression {
    /// From this long before the onset, ms. The default is 70: neural suppression starts about 70 ms
    /// before a microsaccade (Hafed and Krauzlis 2010, PMC2922969). Makes little difference, for the eye
    /// still rests.
    pub before_onset_ms: f64,
    /// Until this long after the end, ms. The same source has it end about 70 ms after the end; the usual
    /// figure for perception is 50, and small detail is seen better than before as soon as the eye rests
    /// (Scholes et al. 2018, PMC6032122). The default is the cautious 50: a larger value forgives more
    /// latency.
    pub after_end_ms: f64,
}

impl Default for Suppression {
    fn default() -> Self {
        Self { before_onset_ms: 70.0, after_end_ms: 50.0 }
    }
}

/// The eye looks at something: what is not sharp would be seen.
pub(super) fn rests(state: EyeState) -> bool {
    matches!(state, EyeState::Fixation | EyeState::Pursuit)
}

/// What is known of one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct EyeAt {
    /// The first sample after it.
    pub row_after: usize,
    pub state: EyeState,
    pub suppressed: bool,
    /// The eye rests and sees.
    pub counts: bool,
}

/// Looks up times that mostly ascend.
#[derive(Debug)]
pub(super) struct EyeWalk<'a> {
    times_ns: &'a [i64],
    intervals: &'a [EyeInterval],
    /// Not overlapping, ascending, ns.
    windows: Vec<(i64, i64)>,
    row: usize,
    interval: usize,
    window: usize,
}

impl<'a> EyeWalk<'a> {
    pub(super) fn new(session: &'a SessionGaze, suppression: &Suppression) -> Self {
        let ns = |ms: f64| (ms * 1e6) as i64;
        let (before_ns, after_ns) = (ns(suppression.before_onset_ms), ns(suppression.after_end_ms));
        let mut windows: Vec<(i64, i64)> = Vec::new();
        for one in session.intervals().iter().filter(|one| one.state == EyeState::Saccade) {
            let (start, end) = (one.start_ns.saturating_sub(before_ns), one.end_ns.saturating_add(after_ns));
            match windows.last_mut() {
                Some(last) if start <= last.1 => last.1 = last.1.max(end),
                _ => windows.push((start, end)),
            }
        }
        Self {
            times_ns: session.times_ns(),
            intervals: session.intervals(),
            windows,
            row: 0,
            interval: 0,
            window: 0,
        }
    }

    pub(super) fn at(&mut self, time_ns: i64) -> EyeAt {
        self.row = walk(self.times_ns, self.row, |time| *time <= time_ns);
        self.interval = walk(self.intervals, self.interval, |one| one.start_ns <= time_ns);
        self.window = walk(&self.windows, self.window, |one| one.0 <= time_ns);
        let interval = self.interval.checked_sub(1).and_then(|index| self.intervals.get(index));
        let state = interval.filter(|one| time_ns < one.end_ns).map_or(EyeState::Unknown, |one| one.state);
        let window = self.window.checked_sub(1).and_then(|index| self.windows.get(index));
        let suppressed = window.is_some_and(|one| time_ns < one.1);
        let counts = !suppressed && (rests(state) || self.intervals.is_empty());
        EyeAt { row_after: self.row, state, suppressed, counts }
    }
}

/// The number of leading items that are `before`, searched from a guess.
fn walk<T>(items: &[T], from: usize, before: impl Fn(&T) -> bool) -> usize {
    let mut at = from;
    while items.get(at).is_some_and(&before) {
        at += 1;
    }
    while at > 0 && items.get(at - 1).is_some_and(|item| !before(item)) {
        at -= 1;
    }
    at
}
