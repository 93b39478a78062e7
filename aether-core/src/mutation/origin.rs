//! What a proposal inherits from the path that it was made from, and how likely it is given that.

use crate::mutation::decisions::Wanted;
use crate::path_density::PathDensity;
use crate::sequence::{Arena, NONE, Place, RandomSequence};
use crate::strategy::{Dirac, Strategy, Vertex};

/// The path that a mutation starts from. Its vertices are known by their ids in the arena, never by
/// their coordinates.
pub(super) struct Origin<'a, V: Vertex, S> {
    arena: &'a Arena<V, S>,
    path: Place,
}

impl<'a, V: Vertex, S: Strategy<V>> Origin<'a, V, S> {
    /// `None` if the path is not complete.
    pub fn new(path: &RandomSequence<'a, V, S>) -> Option<Self> {
        path.is_complete().then_some(Origin { arena: path.arena, path: path.handle.place })
    }

    pub fn arena(&self) -> &'a Arena<V, S> {
        self.arena
    }

    /// The id of vertex `i` of a place; `None` beyond its ends.
    fn id(&self, place: Place, i: usize) -> Option<u32> {
        (i < place.len as usize).then(|| self.arena.tape.entry(place.at(i)).vertex)
    }

    /// Where in the origin a vertex is.
    fn position(&self, vertex: u32) -> Option<usize> {
        (vertex != NONE).then_some(())?;
        (0..self.path.len as usize).find(|i| self.id(self.path, *i) == Some(vertex))
    }

    /// What a mutation may know of a path whose density is evaluated.
    pub fn wanted(&self, to: Place) -> Wanted {
        let current = self.path.len as usize;
        let shared = |i: &usize| {
            let id = self.id(self.path, *i);
            (0..to.len as usize).any(|k| self.id(to, k) == id)
        };
        let ends = [
            (0..current).take_while(shared).count(),
            (0..current).rev().take_while(shared).count(),
        ];
        let common = (0..current).filter(shared).count();
        Wanted { size: to.len as usize, current, common, ends }
    }

    /// Whether vertex `m` of a place has the Dirac factor of a direction because it had it in the
    /// origin: the factor belongs to the vertex, but involves both of its neighbours.
    fn inherits_direction(&self, place: Place, m: usize) -> bool {
        let Some(p) = self.id(place, m).and_then(|id| self.position(id)) else { return false };
        let neighbours =
            |place, i: usize| (self.id(place, i.wrapping_sub(1)), self.id(place, i + 1));
        let (before, after) = neighbours(place, m);
        let was = neighbours(self.path, p);
        (was == (before, after) || was == (after, before))
            && self.arena.tape.unfolded().carries(self.path, p, Dirac::Direction)
    }

    /// What kept vertex `k` of a place knows about the vertex that it was made from: whether it is
    /// seen from there, and its Dirac factor. `None` if it is no vertex of the origin.
    pub fn inherited(&self, place: Place, k: usize) -> Option<(bool, Option<Dirac>)> {
        let parent = |i: usize, backward| if backward { i + 1 } else { i.wrapping_sub(1) };
        let was = self.position(self.id(place, k)?)?;
        let (old, new) = (self.arena.tape.step(self.path, was), self.arena.tape.step(place, k));
        let made_from = parent(k, new.way.is_backward());
        let parent_kept =
            self.id(self.path, parent(was, old.way.is_backward())) == self.id(place, made_from);
        let dirac = old.dirac.filter(|dirac| match dirac {
            Dirac::Position => true,
            Dirac::Direction => parent_kept && self.inherits_direction(place, made_from),
        });
        Some((old.visible && parent_kept, dirac))
    }

    /// Whether the new vertices of a draft can be drawn in the order in which they are: no strategy
    /// that travels forwards reads a vertex that another one makes on its way back.
    pub fn can_draw(&self, draft: Place) -> bool {
        let tape = &self.arena.tape;
        let strategies = self.arena.strategies.borrow();
        (0..draft.len as usize).all(|k| {
            let step = tape.step(draft, k);
            if step.vertex != NONE || step.way.is_backward() {
                return true;
            }
            let reads = strategies[step.way.strategy() as usize].reads().vertices;
            (k.saturating_sub(reads)..k).all(|before| {
                let before = tape.step(draft, before);
                before.vertex != NONE || !before.way.is_backward()
            })
        })
    }

    /// Whether a draft keeps exactly those vertices that the origin and `to` have in common, each in
    /// its place. What keeps fewer of them would have to hit the others by chance: infinitely less
    /// likely.
    fn keeps_what_is_common(&self, draft: Place, to: Place) -> bool {
        (0..to.len as usize).all(|k| {
            let (kept, vertex) = (self.id(draft, k), self.id(to, k));
            let common = vertex.is_some_and(|vertex| self.position(vertex).is_some());
            if kept == Some(NONE) { !common } else { common && kept == vertex }
        })
    }

    /// Whether a draft leads to the Dirac factors of `to`: each is inherited, or is one that a
    /// new vertex can be drawn with.
    fn leads_to_factors(&self, draft: Place, to: Place) -> bool {
        let tape = &self.arena.tape;
        let is_new = |k: usize, backward: bool| {
            k < to.len as usize && {
                let step = tape.step(draft, k);
                step.vertex == NONE && step.way.is_backward() == backward
            }
        };
        (0..to.len as usize).all(|m| {
            let drawn = is_new(m + 1, false) || is_new(m.wrapping_sub(1), true);
            drawn
                || tape.unfolded().carries(to, m, Dirac::Direction)
                    == self.inherits_direction(draft, m)
        })
    }

    /// The density with which drawing the new vertices of a draft makes it `to`.
    pub fn density(&self, draft: Place, to: Place) -> PathDensity<V::Real> {
        let possible = draft.len == to.len
            && self.keeps_what_is_common(draft, to)
            && self.leads_to_factors(draft, to)
            && self.can_draw(draft);
        if !possible {
            return PathDensity::ZERO;
        }
        (0..to.len as usize)
            .filter(|k| self.id(draft, *k) == Some(NONE))
            .map(|k| self.arena.factor(draft, k, to))
            .fold(PathDensity::ONE, |product, factor| product * factor)
    }
}
