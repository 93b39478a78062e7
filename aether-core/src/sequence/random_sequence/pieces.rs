//! Pieces of paths: cut out, turned round, joined, merged, or with another strategy in the place of one.

use core::ops::{Bound, RangeBounds};

use super::{Handle, RandomSequence, TURNED};
use crate::sequence::Place;
use crate::sequence::tape::Merger;
use crate::strategy::{Strategy, Vertex};

impl<'a, V: Vertex, S: Strategy<V>> RandomSequence<'a, V, S> {
    /// The steps of a range, `slice(a..b)`. Strategies that lie before the range are forgotten, and
    /// the others no longer see their vertices. A range beyond [`RandomSequence::size`] yields a path
    /// that does not exist: it has no sample and is no technique to be weighed.
    ///
    /// A range that cuts through the vertices of one draw has vertices, which a mutation may keep, but
    /// no density of its own: alone, each of them has one only as an integral over the others. It is
    /// no technique, and its own density is zero, until the other piece is joined to it again.
    pub fn slice(&self, range: impl RangeBounds<usize>) -> Self {
        let from = match range.start_bound() {
            Bound::Included(&from) => from,
            Bound::Excluded(&before) => before.saturating_add(1),
            Bound::Unbounded => 0,
        };
        let to = match range.end_bound() {
            Bound::Included(&last) => last.saturating_add(1),
            Bound::Excluded(&to) => to,
            Bound::Unbounded => self.size(),
        };
        let h = self.handle;
        if h.absent || from > to || to > self.size() {
            return self.absent();
        }
        let len = h.len.min(to as u32).saturating_sub(from as u32);
        // Pending strategies without the vertices before them cannot be sampled.
        let cut = from > 0 && to as u32 > h.len;
        let ended = cut || (h.ended && to as u32 > h.len);
        self.with(Handle { place: h.place.range(from, to), len, ended, lane: h.lane | 1, ..h })
    }

    /// The path that does not exist.
    pub(crate) fn absent(&self) -> Self {
        let place = Place::new(0, 0);
        self.with(Handle { place, len: 0, ended: true, absent: true, ..self.handle })
    }

    /// The path in opposite order; its strategies go on to travel as they did. What is pending can
    /// no longer be sampled. A path may go on from both of its ends: what is appended in this order draws other numbers
    /// than what is appended in the other.
    pub fn reverse(&self) -> Self {
        let h = self.handle;
        let (len, ended) = if h.complete() { (h.len, h.ended) } else { (0, true) };
        self.with(Handle { place: h.place.reverse(), len, ended, lane: h.lane ^ TURNED, ..h })
    }

    /// This path, then `other`. What is pending in the middle can no longer be sampled.
    ///
    /// # Panics
    /// If the paths are of different arenas.
    pub fn concat(&self, other: &Self) -> Self {
        assert!(
            core::ptr::eq(self.arena, other.arena),
            "paths of different arenas cannot be joined: make both by `sequence` of one arena"
        );
        let (h, o) = (self.handle, other.handle);
        if h.absent || o.absent {
            return self.absent();
        }
        let tape = &self.arena.tape;
        // Where the tape ends with this path, the other one can follow it there.
        let follows = h.complete() && self.is_last();
        let start = if follows { h.place.at(0) } else { tape.len() };
        if !follows {
            tape.copy(h.place, h.len as usize);
        }
        tape.copy(o.place, o.len as usize);
        let place = Place::new(start, (h.place.len + o.place.len) as usize);
        let (len, ended) = if h.complete() { (h.len + o.len, o.ended) } else { (h.len, true) };
        self.with(Handle { place, len, ended, lane: h.lane | 1, ..h })
    }

    /// The strategies of this path without its vertices: a technique to weigh others against, and no sample.
    pub fn technique(&self) -> Self {
        self.with(Handle { len: 0, ended: true, ..self.handle })
    }

    /// The technique that differs from this path in the strategy of step `i`: the vertices before it remain, and it is
    /// no sample. Where the step is not there, or one of a joint draw, the result does not exist.
    pub fn replaced(&self, i: usize, strategy: impl Into<S>) -> Self {
        let (h, tape) = (self.handle, &self.arena.tape);
        if h.absent || i >= self.size() || tape.step(h.place, i).way.part().is_joint() {
            return self.absent();
        }
        let strategy = self.arena.intern(strategy.into());
        let (start, len) = (tape.len(), self.len().min(i));
        tape.copy(h.place, len);
        tape.set_strategy(start + i, strategy);
        let place = Place::new(start, self.size());
        self.with(Handle { place, len: len as u32, ended: true, lane: h.lane | 1, ..h })
    }

    /// This path, then `other` without its first vertex, which lies next to the last one of this path: two
    /// paths that have met (vertex merging, Georgiev et al. 2012; Hachisuka et al. 2012). What is known of
    /// `other` counts for the path as if it had ended at the vertex of this one, which it sees.
    ///
    /// `kernel` is the measure of the places that count as next to it. The density of the result is the product
    /// of both densities and the kernel: how often two samples meet like this, as long as the density of
    /// `other` hardly changes within the kernel (from which the bias of merging comes). Where one path could
    /// not have gone on from the other's end, or a joint draw would be cut, the result does not exist.
    ///
    /// # Panics
    /// As [`RandomSequence::concat`].
    pub fn merge(&self, other: &Self, kernel: V::Real) -> Self {
        let (h, o) = (self.handle, other.handle);
        if h.absent || o.absent || h.place.len == 0 || o.place.len == 0 {
            return self.absent();
        }
        let tape = &self.arena.tape;
        let at = h.place.len as usize - 1;
        let (last, first) = (tape.step(h.place, at), other.arena.tape.step(o.place, 0));
        let is_joint = last.way.part().is_joint() || first.way.part().is_joint();
        if last.way.is_backward() || !first.way.is_backward() || is_joint {
            return self.absent();
        }
        let joined = self.concat(&other.slice(1..));
        if !joined.handle.absent {
            let merger = Merger { strategy: first.way.strategy(), dirac: first.dirac, kernel };
            if !tape.merge(joined.handle.place.at(at), merger) {
                return self.absent();
            }
        }
        joined
    }
}
