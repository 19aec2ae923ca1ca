//! The recent past of one gaze, in a ring of fixed capacity, with ascending times whatever the source
//! says.

use crate::ring::Ring;
use crate::sample::GazeSample;
use glam::{DQuat, DVec3};

/// A step back by more than this, ns, is a jump of the clock and no late sample.
const JUMP_BACK_NS: i64 = 1_000_000_000;
/// A step ahead by more than this, ns, is a jump of the clock and no gap in the stream: longer than any
/// pause after which the past would still matter.
const JUMP_AHEAD_NS: i64 = 60_000_000_000;
/// So many samples of a new time in a row prove that the clock has jumped; one alone is a broken stamp.
const PROOFS_OF_JUMP: u32 = 2;
/// So many late ones in a row, each after the one before, prove a small step back of the clock. More
/// than a burst that was delivered out of order.
const PROOFS_OF_STEP: u32 = 16;

/// What the history keeps of a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Entry {
    /// When the eye was like this, host clock, ns.
    pub time_ns: i64,
    /// Gaze as told, of length 1, view space; zero where none was told that could be used.
    pub direction: DVec3,
    /// The same after the filters, view space; equal to `direction` until a filter was applied.
    pub smoothed: DVec3,
    /// Turns a direction of view space into world space, where the source knows the head's pose.
    pub world_from_view: Option<DQuat>,
    /// There is a direction, and it can be used.
    pub valid: bool,
    /// Only one eye went into the direction.
    pub one_eye: bool,
    /// How far the lids are open, 0 to 1: the wider of the two eyes.
    pub openness: Option<f64>,
}

impl Entry {
    /// Makes an entry of a sample. A direction that is zero or not finite, or whose confidence is told
    /// and not at least `min_confidence` (0 to 1), is none; a confidence outside 0 to 1 is read as the
    /// nearer end, and one that is NaN as not told.
    #[must_use]
    pub fn of(sample: &GazeSample, min_confidence: f64) -> Self {
        let confident = sample
            .combined
            .confidence
            .or_else(|| most(sample.left.confidence, sample.right.confidence))
            .filter(|confidence| !confidence.is_nan())
            .is_none_or(|confidence| confidence.clamp(0.0, 1.0) >= min_confidence);
        // The length of a direction near the ends of the range of f64 comes out right the second time.
        let again = |(direction, one_eye): (DVec3, bool)| Some((direction.try_normalize()?, one_eye));
        let gaze = sample.gaze_direction().filter(|_| confident).and_then(again);
        let (direction, one_eye) = gaze.unwrap_or((DVec3::ZERO, false));
        // A combined gaze is of one eye where the source tells of both and only one is valid.
        let told = |eye: &crate::sample::EyeSample| eye.valid || eye.direction.is_some();
        let both_told = told(&sample.left) && told(&sample.right);
        let lone = both_told && sample.left.valid != sample.right.valid;
        let openness =
            most(sample.left.openness, sample.right.openness).or(sample.combined.openness).filter(finite);
        let turn = sample.head.map(|head| head.world_from_view);
        let turn = turn.filter(|turn| (1e-6..1e6).contains(&turn.length()));
        Self {
            time_ns: sample.time_ns,
            direction,
            smoothed: direction,
            world_from_view: turn.map(DQuat::normalize),
            valid: gaze.is_some(),
            one_eye: gaze.is_some() && (one_eye || lone),
            openness: openness.map(|openness| openness.clamp(0.0, 1.0)),
        }
    }

    /// `direction` in world space where the head's pose is known, else in view space. Movements of the
    /// eye are told apart in this space: in view space the eye also moves when only the head does.
    #[must_use]
    pub fn gaze(&self) -> DVec3 {
        self.world_from_view.map_or(self.direction, |turn| turn * self.direction)
    }

    /// As [`Self::gaze`], after the filters.
    #[must_use]
    pub fn smoothed_gaze(&self) -> DVec3 {
        self.world_from_view.map_or(self.smoothed, |turn| turn * self.smoothed)
    }

    /// Whether the directions of two entries may be compared: made of as many eyes, in the same space.
    #[must_use]
    pub fn comparable(&self, other: &Self) -> bool {
        self.one_eye == other.one_eye && self.world_from_view.is_some() == other.world_from_view.is_some()
    }
}

fn finite(value: &f64) -> bool {
    value.is_finite()
}

fn most(one: Option<f64>, other: Option<f64>) -> Option<f64> {
    one.zip(other).map(|(one, other)| one.max(other)).or(one).or(other)
}

/// What became of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pushed {
    /// It is the newest now.
    Kept,
    /// Its time is that of the newest, or before it: ignored.
    Late,
    /// Its time is so far off that it may be a broken stamp: ignored, unless more follow.
    Suspect,
    /// The clock has jumped: the past was forgotten and this is the first of a new one.
    Restarted,
}

/// The newest entries, in ascending order of time.
///
/// Entries with the time of the newest or an earlier one are ignored, and so is a single one more than
/// 1 s back or 60 s ahead. Two of those in a row, or sixteen late ones in ascending order, are taken for a
/// jump of the clock: the history starts anew.
#[derive(Clone, Debug)]
pub struct History {
    entries: Ring<Entry>,
    /// Time and number of the ignored entries in a row, each after the one before.
    ignored: Option<(i64, u32)>,
}

impl History {
    /// An empty history of `capacity` entries, brought within 1 to 65 536 (16 s at 4 kHz). Nothing allocates
    /// after this.
    #[must_use]
    pub fn new(capacity: usize) -> Self {
        Self { entries: Ring::new(capacity.min(1 << 16)), ignored: None }
    }

    /// Adds an entry.
    pub fn push(&mut self, entry: Entry) -> Pushed {
        let Some(step_ns) = self.newest().map(|newest| entry.time_ns.saturating_sub(newest.time_ns)) else {
            self.entries.push(entry);
            return Pushed::Kept;
        };
        if (1..=JUMP_AHEAD_NS).contains(&step_ns) {
            self.ignored = None;
            self.entries.push(entry);
            return Pushed::Kept;
        }
        let jump = !(-JUMP_BACK_NS..=JUMP_AHEAD_NS).contains(&step_ns);
        let count = match self.ignored {
            Some((before_ns, count))
                if (1..=JUMP_AHEAD_NS).contains(&entry.time_ns.saturating_sub(before_ns)) =>
            {
                count + 1
            }
            _ => 1,
        };
        self.ignored = Some((entry.time_ns, count));
        if count < if jump { PROOFS_OF_JUMP } else { PROOFS_OF_STEP } {
            return if jump { Pushed::Suspect } else { Pushed::Late };
        }
        self.clear();
        self.entries.push(entry);
        Pushed::Restarted
    }

    /// Sets the filtered direction of the newest entry; the raw one stays.
    pub fn smooth_newest(&mut self, smoothed: DVec3) {
        if let Some(newest) = self.entries.newest_mut() {
            newest.smoothed = smoothed;
        }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.entries.clear();
        self.ignored = None;
    }

    /// How many entries there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// There is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How many entries there can be.
    #[must_use]
    pub fn capacity(&self) -> usize {
        self.entries.capacity()
    }

    /// The newest entry.
    #[must_use]
    pub fn newest(&self) -> Option<&Entry> {
        self.entries.back(0)
    }

    /// From the newest to the oldest.
    pub fn newest_first(&self) -> impl Iterator<Item = &Entry> + '_ {
        self.entries.newest_first()
    }

    /// The last valid entry at or before a time, or else the first valid one after it.
    #[must_use]
    pub fn valid_near(&self, time_ns: i64) -> Option<&Entry> {
        let later = self.entries.partition(|entry| entry.time_ns > time_ns);
        let mut earlier = (later..self.len()).filter_map(|back| self.entries.back(back));
        let valid = |entry: &&Entry| entry.valid;
        let after = || (0..later).rev().filter_map(|back| self.entries.back(back)).find(valid);
        earlier.find(valid).or_else(after)
    }

    /// The last entry at or before a time, and the first after it.
    #[must_use]
    pub fn around(&self, time_ns: i64) -> (Option<&Entry>, Option<&Entry>) {
        let later = self.entries.partition(|entry| entry.time_ns > time_ns);
        let after = later.checked_sub(1).and_then(|back| self.entries.back(back));
        (self.entries.back(later), after)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{EyeSample, HeadPose};
    use proptest::prelude::*;

    const MS: i64 = 1_000_000;

    fn at(time_ns: i64) -> Entry {
        Entry { time_ns, direction: DVec3::NEG_Z, smoothed: DVec3::NEG_Z, valid: true, ..Entry::default() }
    }

    fn eye(direction: DVec3, confidence: Option<f64>) -> EyeSample {
        EyeSample { valid: true, direction: Some(direction), confidence, ..EyeSample::default() }
    }

    #[test]
    fn late_and_equal_times_are_ignored() {
        let mut history = History::new(8);
        let told: Vec<Pushed> = [0, 5, 5, 3, 6].map(|ms| history.push(at(ms * MS))).to_vec();
        use Pushed::{Kept, Late};
        assert_eq!(told, [Kept, Kept, Late, Late, Kept]);
        let times: Vec<i64> = history.newest_first().map(|entry| entry.time_ns / MS).collect();
        assert_eq!(times, [6, 5, 0]);
    }

    #[test]
    fn one_broken_stamp_is_ignored_and_a_jump_starts_anew() {
        let mut history = History::new(8);
        history.push(at(0));
        for broken in [i64::MAX, i64::MIN, 100_000 * MS] {
            assert_eq!(history.push(at(broken)), Pushed::Suspect);
        }
        assert_eq!(history.push(at(MS)), Pushed::Kept);
        assert_eq!(history.push(at(-5_000 * MS)), Pushed::Suspect);
        assert_eq!(history.push(at(-4_999 * MS)), Pushed::Restarted);
        assert_eq!(history.len(), 1);
        // A gap of seconds is no jump.
        assert_eq!(history.push(at(10_000 * MS)), Pushed::Kept);
        // Half a second back, for good: the sixteenth sample proves it.
        let told: Vec<Pushed> = (0..16).map(|ms| history.push(at((9_500 + ms) * MS))).collect();
        assert!(told[..15].iter().all(|pushed| *pushed == Pushed::Late));
        assert_eq!(told[15], Pushed::Restarted);
    }

    #[test]
    fn neighbours_of_a_time() {
        let mut history = History::new(4);
        assert_eq!(history.around(0), (None, None));
        for ms in [1, 2, 3, 4, 6] {
            history.push(at(ms * MS));
        }
        let around = |ms: i64| {
            let (before, after) = history.around(ms * MS);
            (before.map(|entry| entry.time_ns / MS), after.map(|entry| entry.time_ns / MS))
        };
        assert_eq!(around(1), (None, Some(2)));
        assert_eq!(around(4), (Some(4), Some(6)));
        assert_eq!(around(5), (Some(4), Some(6)));
        assert_eq!(around(7), (Some(6), None));
    }

    #[test]
    fn what_cannot_be_used_is_invalid() {
        let of = |eye| Entry::of(&GazeSample { combined: eye, ..GazeSample::at(1) }, 0.6);
        for bad in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
            assert!(!of(eye(bad, None)).valid, "{bad}");
        }
        let long = DVec3::new(0.0, 3.0, -4.0);
        for (confidence, valid) in
            [(0.5, false), (-3.0, false), (0.6, true), (70.0, true), (f64::INFINITY, true), (f64::NAN, true)]
        {
            assert_eq!(of(eye(long, Some(confidence))).valid, valid, "{confidence}");
        }
        assert!(of(eye(long, None)).direction.abs_diff_eq(DVec3::new(0.0, 0.6, -0.8), 1e-15));
    }

    #[test]
    fn a_lone_eye_is_told_even_where_the_source_combines() {
        let right = eye(DVec3::NEG_Z, None);
        let both = GazeSample { combined: right, left: right, right, ..GazeSample::at(0) };
        let shut = EyeSample { valid: false, ..right };
        assert!(!Entry::of(&both, 0.0).one_eye);
        assert!(Entry::of(&GazeSample { left: shut, ..both }, 0.0).one_eye);
        let alone = GazeSample { combined: right, ..GazeSample::at(0) };
        assert!(!Entry::of(&alone, 0.0).one_eye);
        assert!(Entry::of(&GazeSample { right, ..GazeSample::at(0) }, 0.0).one_eye);
    }

    #[test]
    fn the_head_takes_gaze_into_the_world() {
        let turn = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
        let head = HeadPose { position_m: DVec3::ZERO, world_from_view: turn * 2.0 };
        let sample = GazeSample { combined: eye(DVec3::NEG_Z, None), head: Some(head), ..GazeSample::at(0) };
        // Turned a quarter to the left, -Z of the view is -X of the world.
        assert!(Entry::of(&sample, 0.0).gaze().abs_diff_eq(DVec3::NEG_X, 1e-15));
        let broken = HeadPose { world_from_view: DQuat::from_array([f64::NAN; 4]), ..head };
        assert_eq!(Entry::of(&GazeSample { head: Some(broken), ..sample }, 0.0).world_from_view, None);
    }

    proptest! {
        #[test]
        fn times_always_ascend(times in prop::collection::vec(any::<i64>(), 0..80), small in prop::collection::vec(-40i64..40, 0..80)) {
            let mut history = History::new(16);
            for time_ns in times.into_iter().chain(small) {
                history.push(at(time_ns));
                let times: Vec<i64> = history.newest_first().map(|entry| entry.time_ns).collect();
                prop_assert!(times.windows(2).all(|pair| pair[0] > pair[1]) && times.len() <= 16);
            }
        }
    }
}
