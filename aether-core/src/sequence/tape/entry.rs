//! Steps of paths, and the places on the tape that paths have.

use crate::strategy::Dirac;

/// Marks a step that has no vertex (yet).
pub(crate) const NONE: u32 = u32::MAX;

/// Which vertex of a draw a step makes: counted in the direction of travel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Part(u8);

impl Part {
    /// Vertex `index` of `len`.
    pub fn new(index: usize, len: usize) -> Self {
        Part((index | (len - 1) << 4) as u8)
    }

    /// As a byte, and back.
    pub fn byte(self) -> u8 {
        self.0
    }

    /// The part whose byte this is.
    pub fn from_byte(byte: u8) -> Self {
        Part(byte)
    }

    /// Its number.
    #[inline]
    pub fn index(self) -> usize {
        usize::from(self.0 & 15)
    }

    /// How many vertices the draw yields.
    #[inline]
    pub fn len(self) -> usize {
        usize::from(self.0 >> 4) + 1
    }

    /// Whether the draw yields others too.
    #[inline]
    pub fn is_joint(self) -> bool {
        self.0 != 0
    }

    /// Whether the draw yields no further vertex.
    #[inline]
    pub fn is_last(self) -> bool {
        self.index() + 1 == self.len()
    }
}

/// How a step makes its vertex, as one number, so that ways compare at once: from the lowest bit the id of the
/// strategy (32 bits), which part of its draw it is (8), whether it goes against the order of the tape (1), and
/// one more than the number of the [`Merger`] by which the vertex is also reached from the other side (23).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Way(u64);

impl Way {
    const BACKWARD: u32 = 40;
    const MERGER: u32 = 41;
    /// How many mergers there are numbers for.
    pub const MERGERS: usize = (1 << (64 - Self::MERGER)) - 1;
    /// That of no step.
    pub const NONE: Way = Way(u64::MAX);

    /// A part of what a strategy draws.
    pub fn new(strategy: u32, part: Part) -> Self {
        Way(u64::from(strategy) | u64::from(part.byte()) << 32)
    }

    /// The same read in the opposite direction, if `turned`.
    #[inline(always)]
    pub fn turned(self, turned: bool) -> Self {
        Way(self.0 ^ u64::from(turned) << Self::BACKWARD)
    }

    /// The same by another strategy.
    pub fn by(self, strategy: u32) -> Self {
        Way(self.0 >> 32 << 32 | u64::from(strategy))
    }

    /// The same, with a second step to the vertex, from the other side.
    pub fn merging(self, merger: u32) -> Self {
        Way(self.0 & ((1 << Self::MERGER) - 1) | u64::from(merger + 1) << Self::MERGER)
    }

    /// The id of the strategy.
    #[inline(always)]
    pub fn strategy(self) -> u32 {
        self.0 as u32
    }

    /// Which vertex of the draw it is.
    #[inline(always)]
    pub fn part(self) -> Part {
        Part((self.0 >> 32) as u8)
    }

    /// Whether it goes against the order of the tape, or of the place that it was read from.
    #[inline(always)]
    pub fn is_backward(self) -> bool {
        self.0 >> Self::BACKWARD & 1 == 1
    }

    /// Whether the step goes in a direction, alone or beside one in the other.
    #[inline]
    pub fn goes(self, backward: bool) -> bool {
        self.is_backward() == backward || self.merger().is_some()
    }

    /// The number of the merger, if there is one.
    #[inline(always)]
    pub fn merger(self) -> Option<u32> {
        ((self.0 >> Self::MERGER) as u32).checked_sub(1)
    }
}

/// One step of a path: a strategy, and the vertex that it made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    /// How it makes the vertex.
    pub way: Way,
    /// Id of the vertex, or [`NONE`].
    pub vertex: u32,
    /// Block of sampling dimensions.
    pub block: u32,
    /// How many steps, this one included, have been taken since the path's origin, all of them in
    /// the direction of this one and neighbours on the tape; zero if that is not so. Such a run is named by
    /// the vertex that it ends with, so that copies of it share what is known about it.
    pub run: u32,
    /// Whether the vertex is known to see the one that it was made from.
    pub visible: bool,
    /// The Dirac factor that the vertex was drawn with.
    pub dirac: Option<Dirac>,
}

impl Entry {
    /// A step that is not taken yet.
    pub fn pending(way: Way, block: u32) -> Self {
        Entry { way, vertex: NONE, block, run: 0, visible: false, dirac: None }
    }

    /// Forgets how the vertex that it was made from is related to its own.
    pub fn forget_origin(&mut self) {
        self.visible = false;
        self.dirac = self.dirac.filter(|dirac| *dirac == Dirac::Position);
    }
}

/// A second step to a vertex, from the other side: it has led to a place next to it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Merger<R> {
    /// Id of its strategy.
    pub strategy: u32,
    /// The Dirac factor that its vertex was drawn with.
    pub dirac: Option<Dirac>,
    /// The measure of the places that count as next to the vertex.
    pub kernel: R,
}

/// A range of the tape, read in one direction or the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    start: u32,
    pub reversed: bool,
    pub len: u32,
}

impl Place {
    pub fn new(start: usize, len: usize) -> Self {
        Place { start: start as u32, reversed: false, len: len as u32 }
    }

    /// Position on the tape of step `i`.
    #[inline(always)]
    pub fn at(self, i: usize) -> usize {
        let i = i as u32;
        (if self.reversed { self.start.wrapping_sub(i) } else { self.start + i }) as usize
    }

    /// Steps `from..to`.
    #[inline]
    pub fn range(self, from: usize, to: usize) -> Self {
        let start = if from < to { self.at(from) } else { 0 };
        Place { start: start as u32, reversed: self.reversed, len: to.saturating_sub(from) as u32 }
    }

    /// Of a place that is read in the order of the tape, its first steps and what follows them there, so many.
    #[inline(always)]
    pub fn lengthened(self, len: usize) -> Self {
        Place { len: len as u32, ..self }
    }

    /// The same steps in opposite order.
    #[inline]
    pub fn reverse(self) -> Self {
        let start = if self.len == 0 { 0 } else { self.at(self.len as usize - 1) };
        Place { start: start as u32, reversed: !self.reversed, len: self.len }
    }
}

/// A step of the tape, and whether it is read against the order of the tape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Step(u32);

impl Step {
    /// The step at a position.
    #[inline(always)]
    pub fn new(at: usize, turned: bool) -> Self {
        Step((at as u32) << 1 | u32::from(turned))
    }

    /// Its position on the tape.
    #[inline(always)]
    pub fn at(self) -> usize {
        (self.0 >> 1) as usize
    }

    /// Whether it is read against the order of the tape.
    #[inline(always)]
    pub fn is_turned(self) -> bool {
        self.0 & 1 == 1
    }
}

/// What a conditional density is asked for, apart from vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Question {
    /// The strategy, and the kind of density.
    pub tag: u32,
    /// The class of the length of the path before, if that matters.
    pub class: u32,
}

impl Question {
    /// No question: what nobody asks for.
    pub const NOTHING: Question = Question { tag: NONE, class: NONE };

    /// How a strategy distributes vertices of a kind, after paths whose lengths are of a class.
    #[inline]
    pub fn new(strategy: u32, dirac: Option<Dirac>, class: u32) -> Self {
        let kind = match dirac {
            None => 0,
            Some(Dirac::Position) => 1,
            Some(Dirac::Direction) => 2,
        };
        Question { tag: strategy * 4 + kind, class }
    }
}
