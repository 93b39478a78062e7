//! A short list on the stack.

/// The preimages of a point, in no particular order.
#[derive(Clone, Copy, Debug)]
pub struct Preimages<T> {
    items: [Option<T>; CAPACITY],
    len: usize,
}

/// The most preimages that a point can have.
pub const CAPACITY: usize = 16;

impl<T: Copy> Preimages<T> {
    /// No preimage yet.
    pub fn new() -> Self {
        Preimages { items: [None; CAPACITY], len: 0 }
    }

    /// Adds a preimage.
    ///
    /// # Panics
    /// If there are more than [`CAPACITY`]; the compiler derives no such map.
    pub fn push(&mut self, item: T) {
        self.items[self.len] = Some(item);
        self.len += 1;
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether the point lies outside the support.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The preimages.
    pub fn iter(&self) -> impl Iterator<Item = T> + '_ {
        self.items[..self.len].iter().flatten().copied()
    }
}

impl<T: Copy> Default for Preimages<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T> IntoIterator for Preimages<T> {
    type Item = T;
    type IntoIter = core::iter::Flatten<core::array::IntoIter<Option<T>, CAPACITY>>;
    fn into_iter(self) -> Self::IntoIter {
        self.items.into_iter().flatten()
    }
}
