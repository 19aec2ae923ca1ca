//! What waits between the thread that receives and the one that polls.

use crate::sample::GazeSample;
use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The most items that wait: 4 s at 1 kHz. More bridges longer pauses of the one who polls.
const MAX_WAITING: usize = 4096;

/// Something that happened.
// Nearly every item is a sample: a box would allocate for each of them.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// A sample, with its device time on the host clock already, or not.
    Sample { sample: GazeSample, on_host_clock: bool },
    /// What was no sample.
    Rejected { count: u64, why: String },
    /// The sender that is heard is there.
    Joined,
    /// It has gone.
    Left { why: String },
}

#[derive(Debug, Default)]
struct Waiting {
    items: VecDeque<(i64, Item)>,
    overflowed: u64,
}

impl Waiting {
    /// Samples go first, so that the one who polls learns that a sender, and with it its clock, changed.
    fn make_room(&mut self) {
        let oldest = self.items.iter().position(|(_, item)| matches!(item, Item::Sample { .. }));
        self.overflowed += u64::from(oldest.is_some());
        self.items.remove(oldest.unwrap_or(0));
    }
}

/// A queue of limited length: the oldest samples are given up first.
#[derive(Debug, Default)]
pub struct Inbox(Mutex<Waiting>);

impl Inbox {
    fn waiting(&self) -> MutexGuard<'_, Waiting> {
        // Nothing in here is ever left half done.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Appends what happened at a host time.
    pub fn put(&self, at_ns: i64, item: Item) {
        let mut waiting = self.waiting();
        if let (Item::Rejected { count: more, why: newest }, Some((_, Item::Rejected { count, why }))) =
            (&item, waiting.items.back_mut())
        {
            *count = count.saturating_add(*more);
            why.clone_from(newest);
            return;
        }
        if waiting.items.len() >= MAX_WAITING {
            waiting.make_room();
        }
        waiting.items.push_back((at_ns, item));
    }

    /// Takes the oldest if it happened up to `now_ns`.
    pub fn take(&self, now_ns: i64) -> Option<Item> {
        let mut waiting = self.waiting();
        let due = waiting.items.front().is_some_and(|(at_ns, _)| *at_ns <= now_ns);
        if due { waiting.items.pop_front().map(|(_, item)| item) } else { None }
    }

    /// Nothing waits.
    pub fn is_empty(&self) -> bool {
        self.waiting().items.is_empty()
    }

    /// How many samples were given up since the last call.
    pub fn take_overflowed(&self) -> u64 {
        std::mem::take(&mut self.waiting().overflowed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_much_is_counted_and_the_newest_kept() {
        let inbox = Inbox::default();
        for number in 0..5000 {
            inbox.put(number, Item::Sample { sample: GazeSample::at(number), on_host_clock: false });
        }
        assert_eq!((inbox.take_overflowed(), inbox.take_overflowed()), (904, 0));
        let times = std::iter::from_fn(|| inbox.take(i64::MAX));
        let times: Vec<i64> = times
            .filter_map(
                |item| if let Item::Sample { sample, .. } = item { Some(sample.time_ns) } else { None },
            )
            .collect();
        assert_eq!(times, (904..5000).collect::<Vec<_>>());
    }

    #[test]
    fn who_came_and_went_is_not_given_up_for_samples() {
        let inbox = Inbox::default();
        inbox.put(0, Item::Joined);
        for number in 1..=5000 {
            inbox.put(number, Item::Sample { sample: GazeSample::at(number), on_host_clock: false });
        }
        inbox.put(5001, Item::Left { why: "closed".into() });
        assert_eq!(inbox.take_overflowed(), 5002 - MAX_WAITING as u64);
        let items: Vec<Item> = std::iter::from_fn(|| inbox.take(i64::MAX)).collect();
        assert_eq!((items.len(), items.first()), (MAX_WAITING, Some(&Item::Joined)));
        assert!(matches!(items.last(), Some(Item::Left { .. })));
    }

    #[test]
    fn rejections_in_a_row_are_one() {
        let inbox = Inbox::default();
        for why in ["a", "b", "c"] {
            inbox.put(1, Item::Rejected { count: 1, why: why.into() });
        }
        assert_eq!(inbox.take(0), None);
        assert_eq!(inbox.take(1), Some(Item::Rejected { count: 3, why: "c".into() }));
        assert_eq!(inbox.take(1), None);
    }
}
