//! What a ray has still to visit.

use std::cell::Cell;

use super::simd::LANES;
use super::tree::Child;

/// More than a ray through an ordinary tree needs; where one needs more, they go below.
const ENTRIES: usize = 48;

/// A child and where the ray enters it, as a number that is greater for what is further away.
#[derive(Clone, Copy)]
pub struct Entry(u64);

impl Entry {
    /// Distances are not negative.
    #[inline(always)]
    fn new(near: f32, child: Child) -> Self {
        Self(u64::from(near.to_bits()) << 32 | u64::from(child.0))
    }

    /// Where the ray enters it.
    #[inline(always)]
    pub fn near(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    /// The child.
    #[inline(always)]
    pub fn child(self) -> Child {
        Child(self.0 as u32)
    }
}

/// The children of a node and where a ray enters them.
pub struct Entries<'a> {
    /// Distances.
    pub near: [f32; LANES],
    /// In the same order.
    pub children: &'a [Child; LANES],
}

/// Room for entries, whatever is in it.
pub type Room = [Cell<Entry>; ENTRIES];

thread_local! {
    /// Of this thread: a ray that had its own would have to fill it first, which takes as long as meeting a node.
    pub static ROOM: Room = const { [const { Cell::new(Entry(0)) }; ENTRIES] };
}

/// A stack that only allocates for the deepest trees.
pub struct Stack<'r> {
    entries: &'r Room,
    len: usize,
    /// What lies below the entries.
    below: Vec<Entry>,
}

impl<'r> Stack<'r> {
    /// An empty one.
    #[inline(always)]
    pub fn new(entries: &'r Room) -> Self {
        Self { entries, len: 0, below: Vec::new() }
    }

    /// Pushes the children of the lanes whose bits are set, two at least, but for one which it returns: the nearest, if
    /// `SORTED`, in which case the others are popped from the nearest on.
    #[inline(always)]
    pub fn push_but_one<const SORTED: bool>(
        &mut self,
        mut lanes: u32,
        children: &Entries,
    ) -> Entry {
        if self.len > ENTRIES - LANES {
            self.sink();
        }
        let first = self.len;
        // Apart from the stack, which is in memory.
        let mut len = first;
        let mut taken = || {
            let lane = lanes.trailing_zeros() as usize % LANES;
            lanes &= lanes.wrapping_sub(1);
            (Entry::new(children.near[lane], children.children[lane]), lanes != 0)
        };
        let (mut nearest, _) = taken();
        loop {
            let (new, more) = taken();
            let is_farther = SORTED && nearest.0 < new.0;
            let (near, far) = if is_farther { (nearest, new) } else { (new, nearest) };
            let mut place = len;
            while SORTED && place > first && self.entries[place - 1].get().0 < far.0 {
                self.entries[place].set(self.entries[place - 1].get());
                place -= 1;
            }
            self.entries[place].set(far);
            (nearest, len) = (near, len + 1);
            if !more {
                self.len = len;
                return nearest;
            }
        }
    }

    /// The last entry.
    #[inline(always)]
    pub fn pop(&mut self) -> Option<Entry> {
        if self.len == 0 {
            return self.below.pop();
        }
        self.len -= 1;
        Some(self.entries[self.len].get())
    }

    /// Makes room.
    #[cold]
    #[inline(never)]
    fn sink(&mut self) {
        self.below.extend(self.entries[..self.len].iter().map(Cell::get));
        self.len = 0;
    }
}
