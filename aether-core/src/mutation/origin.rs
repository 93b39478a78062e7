//! What a proposal inherits from the path that it was made from, and how likely it is given that.

use crate::mutation::decisions::Wanted;
use crate::path_density::PathDensity;
use crate::sequence::{Arena, NONE, Place, RandomSequence, Unfolded};
use crate::strategy::{Dirac, Strategy, Vertex};

/// The path that a mutation starts from. Its vertices are known by their ids in the arena, never by
/// their coordinates.
pub(super) struct Origin<'a, V: Vertex, S> {
    arena: &'a Arena<V, S>,
    path: Place,
    /// How many steps the tape had before the mutation.
    pub steps: usize,
}

/// What is known of a kept vertex.
pub(super) struct Inherited {
    /// Where in the origin it is.
    pub was: usize,
    /// Whether it is seen from the vertex that it was made from.
    pub visible: bool,
    /// Its Dirac factor.
    pub dirac: Option<Dirac>,
}

/// The id of vertex `i` of a place; `None` beyond its ends.
fn id<V: Vertex>(tape: &Unfolded<'_, V>, place: Place, i: usize) -> Option<u32> {
    (i < place.len as usize).then(|| tape.id(place, i))
}

/// Where in a place a vertex is, which is mostly at `likely`.
#[inline]
fn position<V: Vertex>(
    tape: &Unfolded<'_, V>,
    vertex: u32,
    place: Place,
    likely: usize,
) -> Option<usize> {
    (vertex != NONE).then_some(())?;
    let is = |i: &usize| tape.id(place, *i) == vertex;
    let n = place.len as usize;
    Some(likely).filter(|i| *i < n && is(i)).or_else(|| (0..n).find(is))
}

impl<'a, V: Vertex, S: Strategy<V>> Origin<'a, V, S> {
    /// `None` if the path is not complete.
    pub fn new(path: &RandomSequence<'a, V, S>) -> Option<Self> {
        let (arena, steps) = (path.arena, path.arena.tape.len());
        path.is_complete().then_some(Origin { arena, path: path.handle.place, steps })
    }

    pub fn arena(&self) -> &'a Arena<V, S> {
        self.arena
    }

    /// How many vertices it has.
    pub fn len(&self) -> usize {
        self.path.len as usize
    }

    /// What a mutation may know of a path whose density is evaluated. Tells of each of its vertices whether the origin has
    /// it, too.
    pub fn wanted(&self, to: Place, in_common: &mut Vec<bool>) -> Wanted {
        let tape = self.arena.tape.unfolded();
        let (current, size) = (self.path.len as usize, to.len as usize);
        // Mostly a path begins and ends with vertices of the other, and has none of it between.
        let (most, same) = (current.min(size), |i: usize, k: usize| {
            let id = tape.id(self.path, i);
            id != NONE && id == tape.id(to, k)
        });
        let begin = (0..most).take_while(|i| same(*i, *i)).count();
        let rest = most - begin;
        let end = (1..rest + 1).take_while(|i| same(current - i, size - i)).count();
        let found = |vertex, place| position(&tape, vertex, place, begin).is_some();
        in_common.clear();
        in_common.resize(begin, true);
        in_common.extend((begin..size - end).map(|k| found(tape.id(to, k), self.path)));
        in_common.resize(size, true);
        if !in_common[begin..size - end].contains(&true) {
            let common = begin + end;
            let ends = if common == current { [current; 2] } else { [begin, end] };
            return Wanted { size, current, common, ends };
        }
        let shared =
            |i: &usize| *i < begin || *i >= current - end || found(tape.id(self.path, *i), to);
        let first = (0..current).take_while(shared).count();
        let last = (0..current).rev().take_while(shared).count();
        let common = (0..current).filter(shared).count();
        Wanted { size, current, common, ends: [first, last] }
    }

    /// Whether vertex `m` of a place has the Dirac factor of a direction because it had it in the
    /// origin: the factor belongs to the vertex, but involves both of its neighbours.
    fn inherits_direction(&self, tape: &Unfolded<'_, V>, place: Place, m: usize) -> bool {
        let vertex = id(tape, place, m);
        let was = vertex.and_then(|vertex| position(tape, vertex, self.path, m));
        let Some(p) = was else { return false };
        let neighbours =
            |place, i: usize| (id(tape, place, i.wrapping_sub(1)), id(tape, place, i + 1));
        let (before, after) = neighbours(place, m);
        let was = neighbours(self.path, p);
        (was == (before, after) || was == (after, before))
            && tape.carries(self.path, p, Dirac::Direction)
    }

    /// What kept vertex `k` of a place knows about the vertex that it was made from. `None` if it is no vertex of the origin.
    pub fn inherited(&self, place: Place, k: usize) -> Option<Inherited> {
        let tape = &self.arena.tape.unfolded();
        let parent = |i: usize, backward| if backward { i + 1 } else { i.wrapping_sub(1) };
        let vertex = tape.id(place, k);
        let as_far_from_end = (k + self.path.len as usize).wrapping_sub(place.len as usize);
        let is_there = id(tape, self.path, k) == Some(vertex);
        let was = position(tape, vertex, self.path, if is_there { k } else { as_far_from_end })?;
        let made_from = parent(k, tape.way(place, k).is_backward());
        let parent_was = parent(was, tape.way(self.path, was).is_backward());
        let parent_kept = id(tape, self.path, parent_was) == id(tape, place, made_from);
        let (_, visible, dirac) = tape.kept(self.path.at(was));
        let dirac = dirac.filter(|dirac| match dirac {
            Dirac::Position => true,
            Dirac::Direction => parent_kept && self.inherits_direction(tape, place, made_from),
        });
        Some(Inherited { was, visible: visible && parent_kept, dirac })
    }

    /// Whether the new vertices of a draft can be drawn in the order in which they are: no strategy
    /// that travels forwards reads a vertex that another one makes on its way back.
    pub fn can_draw(&self, draft: Place) -> bool {
        self.can_draw_from(&self.arena.tape.unfolded(), draft)
    }

    fn can_draw_from(&self, tape: &Unfolded<'_, V>, draft: Place) -> bool {
        let strategies = self.arena.strategies.borrow();
        let is_new = |k: usize, backward: bool| {
            tape.id(draft, k) == NONE && tape.way(draft, k).is_backward() == backward
        };
        if !(0..draft.len as usize).any(|k| is_new(k, true)) {
            return true;
        }
        (0..draft.len as usize).all(|k| {
            if !is_new(k, false) {
                return true;
            }
            let strategy = &strategies[tape.way(draft, k).strategy() as usize];
            !(k.saturating_sub(strategy.reads().vertices)..k).any(|before| is_new(before, true))
        })
    }

    /// Whether a draft leads to the Dirac factors of `to`: each is inherited, or is one that a
    /// new vertex can be drawn with.
    fn leads_to_factors(&self, tape: &Unfolded<'_, V>, draft: Place, to: Place) -> bool {
        let is_new = |k: usize, backward: bool| {
            id(tape, draft, k) == Some(NONE) && tape.way(draft, k).is_backward() == backward
        };
        (0..to.len as usize).all(|m| {
            let drawn = is_new(m + 1, false) || is_new(m.wrapping_sub(1), true);
            drawn
                || tape.carries(to, m, Dirac::Direction) == self.inherits_direction(tape, draft, m)
        })
    }

    /// The density with which drawing the new vertices of a draft makes it `to`, of whose vertices the origin has some in
    /// common.
    ///
    /// A draft has to keep exactly these, each in its place: what keeps fewer of them would have to hit the others by
    /// chance, infinitely less likely.
    pub fn density(&self, draft: Place, to: Place, in_common: &[bool]) -> PathDensity<V::Real> {
        let densities = &mut self.arena.densities();
        let tape = &densities.tape;
        let keeps =
            |k: usize| tape.id(draft, k) == if in_common[k] { tape.id(to, k) } else { NONE };
        let possible = draft.len == to.len
            && (0..to.len as usize).all(keeps)
            && (tape.tape.is_undirected() || self.leads_to_factors(tape, draft, to))
            && self.can_draw_from(tape, draft);
        if !possible {
            return PathDensity::ZERO;
        }
        let new = (0..to.len as usize).filter(|k| !in_common[*k]);
        new.map(|k| densities.factor(draft, k, to))
            .fold(PathDensity::ONE, |product, factor| product * factor)
    }
}
