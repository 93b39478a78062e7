//! What a mutation returns: a path some of whose vertices are still to be drawn.

use core::fmt;
use core::ops::RangeBounds;

use crate::sequence::{NONE, Place, RandomSequence};
use crate::strategy::{Strategy, Vertex};
use crate::uniform::UniformSource;

use super::origin::{Inherited, Origin};

/// Block of sampling dimensions of the choices of a mutation.
pub(super) const DECISIONS: u32 = 0;
/// Block of the decision whether a proposal is accepted.
pub(super) const ACCEPTANCE: u32 = 1;
/// Block of a proposal's first vertex; the others follow.
const VERTICES: u32 = 2;

/// A path in the making: vertices that are kept from the current path, and strategies of new ones.
///
/// A mutation cuts it out of the current path ([`RandomSequence::keep`]), appends strategies and
/// joins the pieces. New vertices are drawn when the mutation has returned: first those whose
/// strategies travel forwards, from the first on, then those that travel backwards, from the last
/// on. So how many there are and what strategies make them can depend on the current path and on
/// choices, but never on other new vertices; strategies see those, and may decline.
///
/// A draft that keeps a vertex twice makes no proposal, nor does one that keeps a vertex of another path than the current one.
pub struct Draft<'a, V: Vertex, S> {
    path: RandomSequence<'a, V, S>,
}

impl<V: Vertex, S> Clone for Draft<'_, V, S> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<V: Vertex, S> Copy for Draft<'_, V, S> {}

impl<V: Vertex, S> fmt::Debug for Draft<'_, V, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Draft({} vertices)", self.path.handle.place.len)
    }
}

impl<'a, V: Vertex, S: Strategy<V>> RandomSequence<'a, V, S> {
    /// This path, or piece of a path, as the beginning of a mutation's proposal: its vertices are
    /// kept. A path that is not complete makes a draft that does not exist.
    pub fn keep(&self) -> Draft<'a, V, S> {
        Draft { path: if self.is_complete() { *self } else { self.absent() } }
    }
}

impl<'a, V: Vertex, S: Strategy<V>> Draft<'a, V, S> {
    /// How many vertices it has, kept ones and new ones.
    pub fn size(&self) -> usize {
        self.path.size()
    }

    /// Adds a new vertex, to be drawn by `strategy`, or the several ones of a joint strategy.
    pub fn append(&mut self, strategy: impl Into<S>) -> &mut Self {
        self.path.append(strategy);
        // A new vertex counts as one that is there, so that it can be cut, turned and joined.
        self.path.handle.len = self.path.handle.place.len;
        self
    }

    /// A piece, `slice(a..b)`. A range beyond [`Draft::size`] yields a draft that does not exist,
    /// and makes no proposal.
    pub fn slice(&self, range: impl RangeBounds<usize>) -> Self {
        Draft { path: self.path.slice(range) }
    }

    /// The draft in opposite order; its strategies go on to travel as they did.
    pub fn reverse(&self) -> Self {
        Draft { path: self.path.reverse() }
    }

    /// This draft, then `other`.
    ///
    /// # Panics
    /// If they are of different arenas.
    pub fn concat(&self, other: &Self) -> Self {
        Draft { path: self.path.concat(&other.path) }
    }

    /// The steps; `None` if the draft does not exist.
    pub(super) fn place(&self) -> Option<Place> {
        self.path.is_complete().then_some(self.path.handle.place)
    }

    /// The path with its new vertices drawn; `None` if a strategy yields no vertex, or if something
    /// is kept that is not of the current path, or is kept twice.
    pub(super) fn draw<U: UniformSource<V::Real> + ?Sized>(
        &self,
        origin: &Origin<'a, V, S>,
        uniforms: &mut U,
    ) -> Option<RandomSequence<'a, V, S>> {
        let (arena, draft) = (self.path.arena, self.place()?);
        if !core::ptr::eq(arena, origin.arena()) || !origin.can_draw(draft) {
            return None;
        }
        let n = draft.len as usize;
        // What the mutation has put together is nowhere else.
        let place = if !draft.reversed && draft.at(0) >= origin.steps {
            draft
        } else {
            let place = Place::new(arena.tape.len(), n);
            arena.tape.copy(draft, n);
            place
        };
        {
            let is_kept = &mut arena.replay.borrow_mut().in_common;
            is_kept.clear();
            is_kept.resize(origin.len(), false);
            for k in (0..n).filter(|k| arena.tape.step(place, *k).vertex != NONE) {
                let Inherited { was, visible, dirac } = origin.inherited(place, k)?;
                if core::mem::replace(&mut is_kept[was], true) {
                    return None;
                }
                arena.tape.set_origin(place.at(k), visible, dirac);
            }
        }
        let is_new = |k: usize, backward: bool| {
            let step = arena.tape.step(place, k);
            step.vertex == NONE && step.way.is_backward() == backward
        };
        for k in (0..n).filter(|k| is_new(*k, false)) {
            uniforms.start(VERTICES + k as u32);
            arena.draw(place, k, uniforms).then_some(())?;
        }
        for k in (0..n).rev().filter(|k| is_new(*k, true)) {
            uniforms.start(VERTICES + k as u32);
            arena.draw(place.reverse(), n - 1 - k, uniforms).then_some(())?;
        }
        let mut path = self.path;
        path.occupy(place.at(0), n);
        Some(path)
    }
}
