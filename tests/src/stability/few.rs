//! A few numbers on the stack: uniforms or coordinates, millions of which are looked at.

use core::ops::Deref;

/// As many as there can be: no sampler of the registry has more coordinates.
const MOST: usize = 16;

/// Some numbers.
#[derive(Clone, Copy, Debug, Default)]
pub struct Few<T> {
    items: [T; MOST],
    len: usize,
}

impl<T: Copy + Default> Few<T> {
    /// The same numbers.
    ///
    /// # Panics
    /// If there are too many.
    pub fn new(from: &[T]) -> Self {
        from.iter().copied().collect()
    }
}

impl<T: Copy + Default> FromIterator<T> for Few<T> {
    fn from_iter<I: IntoIterator<Item = T>>(from: I) -> Self {
        let mut few = Few { items: [T::default(); MOST], len: 0 };
        for item in from {
            few.items[few.len] = item;
            few.len += 1;
        }
        few
    }
}

impl<T> Deref for Few<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        &self.items[..self.len]
    }
}
