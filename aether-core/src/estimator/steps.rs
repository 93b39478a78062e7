//! Walks that are estimated without being kept: where the ways to go on part, and what goes on.

use core::cell::Ref;

use crate::sequence::{LAST, LastDrawn, PathView, RandomSequence, Unfolded, each_last};
use crate::strategy::{Drawn, Strategy, Vertex};
use crate::uniform::UniformSource;
use crate::work::count_densities;

/// The strategies of the steps that a walk is to take.
#[derive(Clone, Copy, Debug)]
pub struct Steps<'t, S> {
    /// Those of its first vertices.
    pub first: &'t [S],
    /// The one that it goes on with.
    pub then: &'t S,
}

/// The steps of a walk that is one run, and those that it goes on with.
pub(super) struct Walk<'w, 't, V: Vertex, S> {
    walk: &'w RandomSequence<'t, V, S>,
    /// Where the walk's own steps are, and their strategies, if it has any.
    own: Option<(&'w Unfolded<'t, V>, Ref<'t, Vec<S>>)>,
    steps: Option<&'w Steps<'w, S>>,
}

impl<'w, 't, V: Vertex, S: Strategy<V>> Walk<'w, 't, V, S> {
    /// The steps of a walk on a tape, and then others.
    #[inline(always)]
    pub fn made(
        walk: &'w RandomSequence<'t, V, S>,
        tape: &'w Unfolded<'t, V>,
        steps: Option<&'w Steps<'w, S>>,
    ) -> Self {
        Walk { walk, own: Some((tape, walk.arena.strategies.borrow())), steps }
    }

    /// Steps of a walk that has none yet.
    #[inline(always)]
    pub fn new(walk: &'w RandomSequence<'t, V, S>, steps: &'w Steps<'w, S>) -> Self {
        Walk { walk, own: None, steps: Some(steps) }
    }

    /// The strategy of a step.
    #[inline(always)]
    pub fn strategy(&self, i: usize) -> Option<&S> {
        let beyond = match &self.own {
            Some((tape, strategies)) => match i.checked_sub(self.walk.size()) {
                Some(beyond) => beyond,
                None => {
                    let way = tape.way(self.walk.handle.place, i);
                    return Some(&strategies[way.strategy() as usize]);
                }
            },
            None => i,
        };
        self.steps.map(|steps| steps.first.get(beyond).unwrap_or(steps.then))
    }

    /// The block of sampling dimensions of what is appended to the first `len` steps.
    #[inline(always)]
    pub fn block_after(&self, len: usize) -> u32 {
        self.walk.block_after(len)
    }

    /// The vertex that a step, whose strategy this is, has found, or finds after those that are at hand.
    #[inline(always)]
    pub fn draw<U>(
        &self,
        i: usize,
        strategy: &S,
        fork: &Fork<'_, V>,
        uniforms: &mut U,
    ) -> Option<Drawn<V>>
    where
        U: UniformSource<V::Real> + ?Sized,
    {
        let walk = self.walk;
        let block = match &self.own {
            Some((tape, _)) if i < walk.len() => return kept(walk, tape, i),
            Some((tape, _)) if i < walk.size() => {
                if self.steps.is_none() || walk.handle.ended {
                    return None;
                }
                tape.block(walk.handle.place, i)
            }
            _ => walk.block_at(i),
        };
        uniforms.start(block);
        fork.draw(strategy, uniforms)
    }
}

/// Vertex `i` of a walk that is one run, as it was drawn, with its density.
fn kept<V: Vertex, S: Strategy<V>>(
    walk: &RandomSequence<'_, V, S>,
    tape: &Unfolded<'_, V>,
    i: usize,
) -> Option<Drawn<V>> {
    let place = walk.handle.place;
    let mut drawn = tape.drawn(place, i)?;
    drawn.value.get_or_insert_with(|| walk.arena.factor(place, i, place));
    Some(drawn)
}

/// The numbers of the bits that are set.
#[inline(always)]
pub(super) fn bits(mut set: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let first = (set != 0).then(|| set.trailing_zeros() as usize);
        set &= set.wrapping_sub(1);
        first
    })
}

/// The most ways to end a path that are told apart at once.
pub(super) const MOST_WAYS: usize = 16;

/// How many of the last vertices are kept, in turns: a power of two, so that turns are a few bits of a number.
pub(super) const RING: usize = LAST.next_power_of_two();

/// Where the ways to end a path part.
pub(super) struct Fork<'r, V: Vertex> {
    /// The last vertices that all ways share, the last one first.
    recent: LastDrawn<'r, V>,
    /// How many vertices all ways share.
    len: usize,
}

impl<'r, V: Vertex> Fork<'r, V> {
    /// After so many vertices, of which vertex `i` is kept at the place of the rest of `i`.
    #[inline(always)]
    pub fn new(kept: &'r [Option<Drawn<V>>; RING], len: usize) -> Self {
        let recent = each_last(|k| match len.checked_sub(k + 1) {
            Some(i) => kept[i % RING].as_ref(),
            None => None,
        });
        Fork { recent, len }
    }

    /// The last vertex that all ways share.
    #[inline(always)]
    pub fn last(&self) -> Option<&'r V> {
        self.recent[0].map(|drawn| &drawn.vertex)
    }

    /// Whether nothing lies between a vertex and the last one that all ways share, if there is one.
    #[inline]
    pub fn sees(&self, drawn: &Drawn<V>, sees: &impl Fn(&V, &V) -> bool) -> bool {
        self.last().is_some_and(|before| sees(before, &drawn.vertex))
    }

    /// The density of a vertex under the strategy that has drawn it, which may have told it.
    #[inline(always)]
    pub fn own_density<S: Strategy<V>>(&self, strategy: &S, drawn: &Drawn<V>) -> V::Real {
        drawn.value.unwrap_or_else(|| self.density(strategy, drawn))
    }

    /// The vertices that all ways share, as strategies see them.
    #[inline(always)]
    pub fn before(&self) -> PathView<'_, V> {
        PathView::of_drawn(self.recent, self.len)
    }

    /// The path with a last vertex.
    #[inline(always)]
    pub fn then<'p>(&'p self, last: &'p Drawn<V>) -> PathView<'p, V> {
        let [first, second, _] = self.recent;
        PathView::of_drawn([Some(last), first, second], self.len + 1)
    }

    /// What a strategy finds as the last vertex.
    #[inline(always)]
    pub fn draw<S, U>(&self, strategy: &S, uniforms: &mut U) -> Option<Drawn<V>>
    where
        S: Strategy<V>,
        U: UniformSource<V::Real> + ?Sized,
    {
        let drawn = strategy.sample_limited(self.before(), uniforms);
        // A vertex that is taken out to be looked at would be copied.
        if let Some(Drawn { value: Some(_), .. }) = &drawn {
            count_densities(1);
        }
        drawn
    }

    /// The density of a vertex under a strategy, or its probability if it was drawn with a Dirac factor.
    #[inline(always)]
    pub fn density<S: Strategy<V>>(&self, strategy: &S, drawn: &Drawn<V>) -> V::Real {
        count_densities(1);
        let before = self.before().asking(drawn.dirac);
        strategy.pdf_limited(before, &drawn.vertex).of_kind(drawn.dirac)
    }
}
