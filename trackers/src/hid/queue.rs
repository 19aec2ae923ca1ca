//! What the reader's thread hands over.

use super::decoder::About;
use crate::source::SourceEvent;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Events on their way to the next poll, bounded.
#[derive(Debug)]
pub(super) struct Queue {
    capacity: usize,
    stopped: AtomicBool,
    content: Mutex<Content>,
}

#[derive(Debug, Default)]
struct Content {
    events: VecDeque<SourceEvent>,
    /// Samples that did not fit.
    dropped: u64,
    about: About,
}

impl Queue {
    pub fn new(capacity: usize) -> Self {
        Self { capacity: capacity.max(1), stopped: AtomicBool::new(false), content: Mutex::default() }
    }

    /// Nothing is left half done by a panic while the lock is held.
    fn lock(&self) -> MutexGuard<'_, Content> {
        self.content.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Appends events, and drops the oldest samples where there are too many.
    pub fn push(&self, events: impl IntoIterator<Item = SourceEvent>) {
        let mut content = self.lock();
        for event in events {
            let Some(event) = content.join(event) else { continue };
            if content.events.len() >= self.capacity {
                content.make_room();
            }
            content.events.push_back(event);
        }
    }

    /// Hands over all events.
    pub fn drain(&self, events: &mut Vec<SourceEvent>) {
        let mut content = self.lock();
        if content.dropped > 0 {
            events.push(SourceEvent::Lost { samples: content.dropped });
            content.dropped = 0;
        }
        events.extend(content.events.drain(..));
    }

    pub fn set_about(&self, about: &About) {
        self.lock().about = about.clone();
    }

    pub fn about(&self) -> About {
        self.lock().about.clone()
    }

    pub fn stop(&self) {
        self.stopped.store(true, Ordering::Release);
    }

    pub fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Acquire)
    }
}

impl Content {
    /// Samples and losses go first, so that a disconnect is not forgotten.
    fn make_room(&mut self) {
        let countable =
            |event: &SourceEvent| matches!(event, SourceEvent::Sample(_) | SourceEvent::Lost { .. });
        let oldest = self.events.iter().position(countable).unwrap_or(0);
        match self.events.remove(oldest) {
            Some(SourceEvent::Sample(_)) => self.dropped += 1,
            Some(SourceEvent::Lost { samples }) => self.dropped = self.dropped.saturating_add(samples),
            _ => {}
        }
    }

    /// Counts a rejection with those just before it; returns what needs a place of its own.
    fn join(&mut self, event: SourceEvent) -> Option<SourceEvent> {
        match (self.events.back_mut(), event) {
            (
                Some(SourceEvent::Rejected { count, why }),
                SourceEvent::Rejected { count: more, why: latest },
            ) => {
                *count = count.saturating_add(more);
                *why = latest;
                None
            }
            (_, event) => Some(event),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::GazeSample;

    fn sample(time_ns: i64) -> SourceEvent {
        SourceEvent::Sample(GazeSample::at(time_ns))
    }

    fn drained(queue: &Queue) -> Vec<SourceEvent> {
        let mut events = Vec::new();
        queue.drain(&mut events);
        events
    }

    #[test]
    fn the_oldest_samples_make_room_and_are_told_as_lost() {
        let queue = Queue::new(3);
        let gone = SourceEvent::Disconnected { why: "unplugged".to_owned() };
        queue.push([
            gone.clone(),
            SourceEvent::Lost { samples: 5 },
            sample(1),
            sample(2),
            sample(3),
            sample(4),
        ]);
        assert_eq!(drained(&queue), [SourceEvent::Lost { samples: 7 }, gone, sample(3), sample(4)]);
        assert_eq!(drained(&queue), []);
    }

    #[test]
    fn rejections_in_a_row_are_one() {
        let queue = Queue::new(8);
        let rejected = |count, why: &str| SourceEvent::Rejected { count, why: why.to_owned() };
        queue.push([rejected(1, "a"), rejected(1, "b"), sample(1), rejected(1, "c")]);
        assert_eq!(drained(&queue), [rejected(2, "b"), sample(1), rejected(1, "c")]);
    }

    #[test]
    fn rejections_that_join_others_cost_no_sample() {
        let queue = Queue::new(3);
        let rejected = || SourceEvent::Rejected { count: 1, why: String::new() };
        queue.push([sample(1), sample(2)]);
        queue.push(std::iter::repeat_with(rejected).take(100));
        let all = SourceEvent::Rejected { count: 100, why: String::new() };
        assert_eq!(drained(&queue), [sample(1), sample(2), all]);
    }
}
