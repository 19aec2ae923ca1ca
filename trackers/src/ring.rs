//! A ring of fixed capacity: what is pushed beyond it replaces the oldest. Never allocates after it was
//! made.

/// The newest `capacity` values pushed.
#[derive(Clone, Debug)]
pub(crate) struct Ring<T> {
    slots: Box<[T]>,
    /// Where the next value goes.
    next: usize,
    len: usize,
}

impl<T: Copy + Default> Ring<T> {
    /// An empty ring of at least one slot.
    pub(crate) fn new(capacity: usize) -> Self {
        Self { slots: vec![T::default(); capacity.max(1)].into_boxed_slice(), next: 0, len: 0 }
    }

    pub(crate) fn capacity(&self) -> usize {
        self.slots.len()
    }

    pub(crate) fn len(&self) -> usize {
        self.len
    }

    pub(crate) fn clear(&mut self) {
        self.next = 0;
        self.len = 0;
    }

    pub(crate) fn push(&mut self, value: T) {
        if let Some(slot) = self.slots.get_mut(self.next) {
            *slot = value;
        }
        self.next = (self.next + 1) % self.slots.len();
        self.len = (self.len + 1).min(self.slots.len());
    }

    /// The value `back` places before the newest, which is number 0.
    pub(crate) fn back(&self, back: usize) -> Option<&T> {
        if back >= self.len {
            return None;
        }
        // `back < len <= slots.len()`, so the sum is positive and the remainder within the slots.
        self.slots.get((self.next + self.slots.len() - 1 - back) % self.slots.len())
    }

    pub(crate) fn newest_mut(&mut self) -> Option<&mut T> {
        let newest = (self.next + self.slots.len() - 1) % self.slots.len();
        if self.len == 0 { None } else { self.slots.get_mut(newest) }
    }

    /// From the newest to the oldest.
    pub(crate) fn newest_first(&self) -> impl Iterator<Item = &T> + '_ {
        (0..self.len).filter_map(|back| self.back(back))
    }

    /// How many values from the newest on satisfy `newer`, which must hold for a first part (counted
    /// from the newest) and for none after it.
    pub(crate) fn partition(&self, newer: impl Fn(&T) -> bool) -> usize {
        let (mut low, mut high) = (0, self.len);
        while low < high {
            let middle = low + (high - low) / 2;
            if self.back(middle).is_some_and(&newer) { low = middle + 1 } else { high = middle }
        }
        low
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_replace_the_oldest() {
        let mut ring = Ring::new(3);
        assert_eq!(ring.back(0), None);
        for value in 1..=5 {
            ring.push(value);
        }
        assert_eq!(ring.newest_first().copied().collect::<Vec<_>>(), [5, 4, 3]);
        assert_eq!((ring.len(), ring.back(3)), (3, None));
        assert_eq!([6, 5, 4, 3, 2].map(|least| ring.partition(|value| *value >= least)), [0, 1, 2, 3, 3]);
        ring.clear();
        assert_eq!(ring.newest_first().count(), 0);
        assert_eq!(Ring::<u8>::new(0).capacity(), 1);
    }
}
