//! A table that forgets everything at once and then needs no heap.

/// What a remembered value depends on.
pub(crate) type Key = [u32; KEY];

/// The length of a [`Key`].
pub(crate) const KEY: usize = 6;

#[derive(Clone, Copy, Debug)]
struct Slot<T> {
    /// The round that the slot was filled in; others are empty.
    round: u32,
    key: Key,
    value: T,
}

/// An open-addressing hash table with constant-time [`Memo::clear`].
#[derive(Clone, Debug)]
pub(crate) struct Memo<T> {
    slots: Vec<Slot<T>>,
    count: usize,
    round: u32,
}

impl<T: Copy> Memo<T> {
    pub fn new() -> Self {
        Memo { slots: Vec::new(), count: 0, round: 1 }
    }

    /// Forgets everything; the capacity stays.
    pub fn clear(&mut self) {
        self.count = 0;
        self.round = self.round.wrapping_add(1);
        if self.round == 0 {
            // After 2^32 rounds the marks repeat: start afresh.
            self.slots.clear();
            self.round = 1;
        }
    }

    /// The slot of a key, or the empty one where it belongs.
    #[inline]
    fn find(&self, key: &Key) -> usize {
        let pair = |i: usize| u64::from(key[i]) | u64::from(key[i + 1]) << 32;
        // Odd factors; the upper half of a product depends on all bits.
        let hash = pair(0).wrapping_mul(0x517c_c1b7_2722_0a95)
            ^ pair(2).wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ pair(4).wrapping_mul(0xd6e8_feb8_6659_fd93);
        let mask = self.slots.len() - 1;
        let mut i = (hash >> 40) as usize & mask;
        while self.slots[i].round == self.round && self.slots[i].key != *key {
            i = (i + 1) & mask;
        }
        i
    }

    pub fn get(&self, key: &Key) -> Option<T> {
        if self.slots.is_empty() {
            return None;
        }
        let slot = &self.slots[self.find(key)];
        (slot.round == self.round).then_some(slot.value)
    }

    /// What is remembered, or from now on what `compute` finds.
    #[inline]
    pub fn get_or_insert_with(&mut self, key: &Key, compute: impl FnOnce() -> T) -> T {
        if self.count * 2 >= self.slots.len() {
            return self.get(key).unwrap_or_else(|| {
                let value = compute();
                self.insert(*key, value);
                value
            });
        }
        let i = self.find(key);
        if self.slots[i].round == self.round {
            return self.slots[i].value;
        }
        let value = compute();
        self.count += 1;
        self.slots[i] = Slot { round: self.round, key: *key, value };
        value
    }

    pub fn insert(&mut self, key: Key, value: T) {
        if self.count * 2 >= self.slots.len() {
            self.grow(value);
        }
        let i = self.find(&key);
        if self.slots[i].round != self.round {
            self.count += 1;
        }
        self.slots[i] = Slot { round: self.round, key, value };
    }

    fn grow(&mut self, filler: T) {
        let size = (self.slots.len() * 2).max(64);
        let empty = Slot { round: 0, key: Key::default(), value: filler };
        let old = core::mem::replace(&mut self.slots, vec![empty; size]);
        for slot in old.into_iter().filter(|slot| slot.round == self.round) {
            let i = self.find(&slot.key);
            self.slots[i] = slot;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remembers_until_cleared() {
        let mut memo = Memo::new();
        let key = |i: u32| [i, i * i, 7, 0, u32::MAX, i % 3];
        for i in 0..1000 {
            memo.insert(key(i), i);
        }
        assert!((0..1000).all(|i| memo.get(&key(i)) == Some(i)));
        assert_eq!(memo.get(&key(1000)), None);
        for i in 0..3000 {
            assert_eq!(
                memo.get_or_insert_with(&key(i), || i + 1),
                if i < 1000 { i } else { i + 1 }
            );
            assert_eq!(memo.get(&key(i)), Some(if i < 1000 { i } else { i + 1 }));
        }
        memo.clear();
        assert!((0..3000).all(|i| memo.get(&key(i)).is_none()));
        memo.insert(key(3), 9);
        assert_eq!(memo.get(&key(3)), Some(9));
    }
}
