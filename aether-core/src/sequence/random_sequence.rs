//! The handle to a path.

mod pieces;

use core::fmt;

use crate::path_density::PathDensity;
use crate::sequence::evaluate::answered;
use crate::sequence::tape::Question;
use crate::sequence::{Arena, Part, PathView, Place};
use crate::strategy::{Drawn, Strategy, Vertex};
use crate::uniform::UniformSource;
use crate::work::count_densities;

/// Which steps of the arena make up a path, and what may still become of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Handle {
    pub place: Place,
    /// How many steps, from the first on, have vertices.
    pub len: u32,
    /// No more vertices will be sampled.
    pub ended: bool,
    /// A slice out of range: there is no such technique.
    pub absent: bool,
    /// Numbers the blocks of sampling dimensions.
    lane: u16,
}

impl Handle {
    /// Whether every step has its vertex.
    #[inline]
    pub fn complete(&self) -> bool {
        self.len == self.place.len && !self.absent
    }
}

/// Lanes of blocks: two for each of the first four sequences, one for the sequence itself and one
/// for what is appended to slices of it.
const LANES: u32 = 8;

/// What is added to the blocks of what is appended to a path in opposite order: half of those that a piece of a sample has.
const TURNED: u16 = 1 << 15;

/// The block of sampling dimensions from which the first path of an arena ([`Arena::sequence`]) draws a step.
pub const fn first_block(step: u32) -> u32 {
    step * LANES
}

/// A path: strategies, and the vertices that they made (Aether 2017, section 5.6).
///
/// It is a handle that is cheap to copy; copies are independent values. A path knows the strategies
/// of all its steps, also of those that yielded no vertex (the ray left the scene): it is then a
/// technique without a sample, which [`combine`](crate::combine::combine) still needs to weigh what
/// the other techniques sampled.
///
/// [`RandomSequence::slice`], [`RandomSequence::reverse`] and [`RandomSequence::concat`] work on
/// steps. A strategy sees the vertices of the path that it is evaluated in, in its direction of
/// travel: after [`RandomSequence::reverse`], the vertices that come later in the path.
pub struct RandomSequence<'a, V: Vertex, S> {
    pub(crate) arena: &'a Arena<V, S>,
    pub(crate) handle: Handle,
}

impl<V: Vertex, S> Clone for RandomSequence<'_, V, S> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<V: Vertex, S> Copy for RandomSequence<'_, V, S> {}

impl<V: Vertex, S> fmt::Debug for RandomSequence<'_, V, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let len = self.handle.len as usize;
        let vertices = (0..len).map(|i| self.arena.tape.vertex(self.handle.place.at(i)));
        f.debug_list().entries(vertices.flatten()).finish()
    }
}

impl<'a, V: Vertex, S: Strategy<V>> RandomSequence<'a, V, S> {
    pub(crate) fn empty(arena: &'a Arena<V, S>, number: u8) -> Self {
        let lane = u16::from(number.min(LANES as u8 / 2 - 1) * 2);
        let place = Place::new(0, 0);
        RandomSequence {
            arena,
            handle: Handle { place, len: 0, ended: false, absent: false, lane },
        }
    }

    fn with(&self, handle: Handle) -> Self {
        RandomSequence { arena: self.arena, handle }
    }

    /// Makes this the complete path of the last steps of the tape, from `start` on.
    pub(crate) fn occupy(&mut self, start: usize, len: usize) {
        let place = Place::new(start, len);
        self.handle = Handle { place, len: len as u32, ended: false, absent: false, ..self.handle };
    }

    /// How many vertices the path has.
    pub fn len(&self) -> usize {
        self.handle.len as usize
    }

    /// Whether the path has no vertex.
    pub fn is_empty(&self) -> bool {
        self.handle.len == 0
    }

    /// How many strategies the path has: the vertices that it has or would have.
    pub fn size(&self) -> usize {
        self.handle.place.len as usize
    }

    /// Whether every strategy has yielded its vertex. If not, the path is no sample, only a
    /// technique.
    pub fn is_complete(&self) -> bool {
        self.handle.complete()
    }

    /// Vertex `i`, if the path has it.
    #[inline]
    pub fn vertex(&self, i: usize) -> Option<V> {
        (i < self.len()).then(|| self.arena.tape.vertex(self.handle.place.at(i))).flatten()
    }

    /// The last vertex.
    pub fn last(&self) -> Option<V> {
        self.vertex(self.len().checked_sub(1)?)
    }

    /// Where this path has vertex `i` of `other`: that very vertex, kept by a slice, a mutation or a
    /// concatenation, not one that lies at the same place.
    pub fn position_of(&self, other: &Self, i: usize) -> Option<usize> {
        if i >= other.len() || !core::ptr::eq(self.arena, other.arena) {
            return None;
        }
        let id = |path: &Self, i: usize| self.arena.tape.entry(path.handle.place.at(i)).vertex;
        (0..self.len()).find(|k| id(self, *k) == id(other, i))
    }

    /// The vertices in order.
    pub fn vertices(&self) -> impl Iterator<Item = V> + use<'a, V, S> {
        let path = *self;
        (0..path.len()).filter_map(move |i| path.vertex(i))
    }

    /// The vertices as integrands see them.
    pub fn view(&self) -> PathView<'a, V> {
        PathView::of_tape(&self.arena.tape, self.handle.place.range(0, self.len()))
    }

    /// Adds a strategy for one more vertex, or a joint one for several. Nothing is sampled before
    /// [`RandomSequence::sample`].
    ///
    /// The vertex will draw from a block of sampling dimensions that its position in the path and
    /// the kind of the path (which [`Arena::sequence`], a slice or not, reversed or not) determine. So what is appended to two
    /// slices of one length draws the same numbers, of a source that numbers dimensions
    /// ([`UniformSource::start`]): where they are to be several samples, or vertices of one path, each needs a block of its own
    /// ([`RandomSequence::append_in`]).
    pub fn append(&mut self, strategy: impl Into<S>) -> &mut Self {
        self.append_in(self.block_at(self.size()), strategy)
    }

    /// [`RandomSequence::append`] of a strategy again and again, until the path has `size` steps, or more by the last ones of a
    /// joint strategy.
    pub fn append_up_to(&mut self, size: usize, strategy: impl Into<S>) -> &mut Self {
        if !self.handle.absent && self.size() < size {
            let known = self.intern(strategy);
            if known.1 == 1 {
                self.own();
                let blocks = (self.size()..size).map(|i| self.block_at(i));
                self.arena.tape.push_each(known.0, blocks);
                self.handle.place.len = size as u32;
            }
            while self.size() < size {
                self.push(self.block_at(self.size()), known);
            }
        }
        self
    }

    /// Samples what has been appended, and then appends a strategy and samples it again and again, until the path has `size`
    /// vertices, or more by the last draw of a joint strategy, or something finds nothing.
    pub fn go_on<U: UniformSource<V::Real> + ?Sized>(
        &mut self,
        size: usize,
        strategy: impl Into<S>,
        uniforms: &mut U,
    ) -> &mut Self {
        self.sample(uniforms);
        if self.is_complete() && self.size() < size {
            let known = self.intern(strategy);
            if S::VERTICES == 1 && self.is_run() && !self.handle.ended {
                self.draw_on(size, known.0, uniforms);
            }
            while self.is_complete() && self.size() < size {
                self.push(self.block_at(self.size()), known);
                self.sample(uniforms);
            }
        }
        self
    }

    /// Draws one vertex after the other behind a run by a strategy that is known, until there are `size` vertices or it finds
    /// nothing.
    fn draw_on<U>(&mut self, size: usize, id: u32, uniforms: &mut U)
    where
        U: UniformSource<V::Real> + ?Sized,
    {
        self.own();
        let (tape, strategies) = (&self.arena.tape, self.arena.strategies.borrow());
        let strategy = &strategies[id as usize];
        let (reads, mut len) = (strategy.reads(), self.len());
        while len < size {
            let block = self.block_at(len);
            uniforms.start(block);
            let unfolded = tape.unfolded();
            let place = self.handle.place.lengthened(len);
            let view = PathView::of_unfolded(&unfolded, place, reads);
            let drawn = strategy.sample(view, uniforms);
            drop(unfolded);
            let Some(drawn) = drawn else {
                tape.push(id, block, Part::new(0, 1));
                (self.handle.place.len, self.handle.ended) = (len as u32 + 1, true);
                self.handle.len = len as u32;
                return;
            };
            if drawn.value.is_some() {
                count_densities(1);
            }
            tape.extend_run((id, block), len, &drawn, answered(strategy, id, &drawn, len));
            len += 1;
        }
        (self.handle.len, self.handle.place.len) = (len as u32, len as u32);
    }

    /// The block of sampling dimensions of what is appended as step `i`.
    #[inline]
    pub(crate) fn block_at(&self, i: usize) -> u32 {
        i as u32 * LANES + u32::from(self.handle.lane)
    }

    /// The block of sampling dimensions of what is appended to the slice of the first `len` steps.
    #[inline]
    pub(crate) fn block_after(&self, len: usize) -> u32 {
        len as u32 * LANES + u32::from(self.handle.lane | 1)
    }

    /// Whether its vertices are known to be an unbroken run.
    #[inline]
    pub(crate) fn is_run(&self) -> bool {
        let Handle { place, absent, .. } = self.handle;
        !absent && !place.reversed && self.arena.tape.unfolded().is_run(place, self.len())
    }

    /// [`RandomSequence::append`] with a block of sampling dimensions of the caller's choice.
    pub fn append_in(&mut self, block: u32, strategy: impl Into<S>) -> &mut Self {
        if !self.handle.absent {
            let known = self.intern(strategy);
            self.push(block, known);
        }
        self
    }

    /// The id of a strategy, and how many vertices it draws.
    fn intern(&self, strategy: impl Into<S>) -> (u32, usize) {
        let strategy = strategy.into();
        let vertices = if S::VERTICES > 1 { strategy.vertices() } else { 1 };
        (self.arena.intern(strategy), vertices)
    }

    /// Adds the steps of a strategy that is known.
    fn push(&mut self, block: u32, (strategy, vertices): (u32, usize)) {
        self.own();
        for k in 0..vertices {
            self.arena.tape.push(strategy, block, Part::new(k, vertices));
        }
        self.handle.place.len += vertices as u32;
    }

    /// Adds a strategy whose vertex has been drawn already, if it drew one.
    pub(crate) fn append_drawn(&mut self, strategy: impl Into<S>, drawn: Option<&Drawn<V>>) {
        let is_next = self.is_complete();
        self.append(strategy);
        match drawn {
            Some(drawn) if is_next && !self.handle.absent => {
                self.arena.tape.take(self.handle.place, self.len(), drawn, Question::NOTHING);
                self.handle.len += 1;
            }
            _ => self.handle.ended = true,
        }
    }

    /// Makes sure that its steps are at the end of the tape, where this path alone can go on.
    fn own(&mut self) {
        if !self.is_last() {
            let start = self.arena.tape.len();
            self.arena.tape.copy(self.handle.place, self.len());
            self.handle.place = Place::new(start, self.size());
        }
    }

    /// Whether its steps are the last of the tape, in their order.
    fn is_last(&self) -> bool {
        let place = self.handle.place;
        !place.reversed && place.len > 0 && place.at(self.size()) == self.arena.tape.len()
    }

    /// Samples what has been appended, one strategy after the other. If one yields no vertex the
    /// path ends there, for good.
    pub fn sample<U: UniformSource<V::Real> + ?Sized>(&mut self, uniforms: &mut U) -> &mut Self {
        while !self.handle.ended && self.handle.len < self.handle.place.len {
            self.handle.ended = !self.sample_next(uniforms);
        }
        self
    }

    /// Samples the vertices of one draw; returns whether there are any.
    fn sample_next<U: UniformSource<V::Real> + ?Sized>(&mut self, uniforms: &mut U) -> bool {
        let i = self.len();
        let step = self.arena.tape.step(self.handle.place, i);
        if step.way.is_backward() || self.handle.place.reversed {
            return false;
        }
        if step.vertex != super::NONE {
            // A copy of this handle has sampled this step for itself.
            let start = self.arena.tape.len();
            self.arena.tape.copy(self.handle.place, i);
            self.handle.place = Place::new(start, self.size());
        }
        uniforms.start(step.block);
        let drawn = self.arena.draw(self.handle.place, i, uniforms);
        self.handle.len += if drawn { step.way.part().len() as u32 } else { 0 };
        drawn
    }

    /// The density of this path under its own strategies: the product of the conditional densities
    /// of its vertices (Aether 2017, Eq. 4), times the probabilities of its Dirac factors. Zero if
    /// it is not complete. Costs one step if the path extends one whose density is known.
    pub fn pdf(&self) -> PathDensity<V::Real> {
        if self.is_complete() {
            self.arena.own_density(self.handle.place)
        } else {
            PathDensity::ZERO
        }
    }

    /// The density of the vertices of `other` under the strategies of this path: how likely this
    /// technique makes that path. Zero if it cannot: if the lengths differ, or if `other` carries
    /// Dirac factors that no strategy here can produce.
    ///
    /// It compares with `other.pdf()`, since both are taken for the Dirac factors of `other`.
    pub fn pdf_of(&self, other: &Self) -> PathDensity<V::Real> {
        let same_arena = core::ptr::eq(self.arena, other.arena);
        if self.handle.absent || !other.is_complete() || !same_arena {
            return PathDensity::ZERO;
        }
        self.arena.density(self.handle.place, other.handle.place)
    }

    /// The conditional density (or probability) of vertex `i` under its strategy; `None` if the path
    /// does not have it. Of vertices that one draw yields, the last one in the direction of travel has
    /// the density of all, and the others have one.
    pub fn conditional(&self, i: usize) -> Option<V::Real> {
        (self.is_complete() && i < self.len())
            .then(|| self.arena.factor(self.handle.place, i, self.handle.place))
    }
}
