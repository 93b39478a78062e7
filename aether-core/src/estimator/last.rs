//! Last vertices of paths along a walk, with the ways to find them.

use crate::combine::Heuristic;
use crate::estimator::range::is_regular;
use crate::estimator::steps::{Fork, MOST_WAYS};
use crate::estimator::{Estimator, Factors, PathIntegrand, RealOf, Value};
use crate::real::Real;
use crate::strategy::{Drawn, Strategy, Vertex};

/// How a vertex was found.
#[derive(Clone, Copy)]
pub(super) struct Found<R, T> {
    /// Its density under the strategy that made it.
    pub density: R,
    /// The factor that it brings, over this density.
    pub gain: T,
}

/// The ways in which paths with some number of vertices end.
pub(super) struct Ways<'s, S> {
    /// What makes the last vertex in each.
    strategies: [Option<&'s S>; MOST_WAYS],
    /// How many there are.
    pub count: usize,
    /// Which of them is that of the walk itself.
    pub walk: Option<usize>,
}

impl<'s, S> Ways<'s, S> {
    /// Ways to make the last vertex, and whether they are the walk's own.
    #[inline(always)]
    pub fn new(ways: impl Iterator<Item = (&'s S, bool)>) -> Self {
        let mut all = Ways { strategies: [None; MOST_WAYS], count: 0, walk: None };
        for (strategy, is_walk) in ways {
            if is_walk {
                all.walk = Some(all.count);
            }
            all.strategies[all.count] = Some(strategy);
            all.count += 1;
        }
        all
    }

    /// Their numbers and strategies.
    #[inline(always)]
    pub fn iter(&self) -> impl Iterator<Item = (usize, &'s S)> {
        self.strategies.iter().take(self.count).copied().flatten().enumerate()
    }
}

/// A last vertex of a path along the walk.
pub(super) struct Last<'l, V: Vertex, T> {
    /// What is before it.
    pub fork: &'l Fork<'l, V>,
    /// The vertex.
    pub drawn: &'l Drawn<V>,
    /// Its density under the strategy that made it.
    pub density: V::Real,
    /// What it brings to f / p, closed.
    pub tail: T,
    /// f / p of the path that it ends.
    pub alone: T,
    /// The number of the way in which it was found.
    pub way: usize,
    /// Whether the vertex before sees it, once that has been asked.
    seen: Option<bool>,
    /// How much likelier each way finds it, once that has been asked.
    ratios: Option<[V::Real; MOST_WAYS]>,
}

impl<'l, V: Vertex, T: Value<V::Real>> Last<'l, V, T> {
    /// Whether the vertex before sees it.
    #[inline]
    pub fn is_seen(&mut self, sees: &impl Fn(&V, &V) -> bool) -> bool {
        let Last { fork, drawn, tail, .. } = self;
        *self.seen.get_or_insert_with(|| drawn.visible || !tail.is_zero() || fork.sees(drawn, sees))
    }

    /// How much likelier each way finds it than the one that has.
    #[inline]
    pub fn ratios<S: Strategy<V>>(&mut self, ways: &Ways<'_, S>) -> [V::Real; MOST_WAYS] {
        let Last { fork, drawn, density, way, .. } = *self;
        *self.ratios.get_or_insert_with(|| {
            let mut ratios = [V::Real::ONE; MOST_WAYS];
            for (k, strategy) in ways.iter().filter(|(k, _)| *k != way) {
                ratios[k] = fork.density(strategy, drawn) / density;
            }
            ratios
        })
    }

    /// The weight of the path among those of the walk.
    #[inline]
    pub fn weight<S: Strategy<V>>(
        &mut self,
        ways: &Ways<'_, S>,
        heuristic: &impl Heuristic<V::Real>,
    ) -> V::Real {
        heuristic.weight(&self.ratios(ways)[..ways.count], self.way)
    }
}

impl<I: PathIntegrand> Estimator<I, Factors<I::Value>> {
    /// How a vertex was found that a strategy has drawn; `None` if its density is no number to divide by.
    #[inline(always)]
    pub(super) fn found<S: Strategy<I::Vertex>>(
        &self,
        fork: &Fork<'_, I::Vertex>,
        strategy: &S,
        drawn: &Drawn<I::Vertex>,
    ) -> Option<Found<RealOf<I>, I::Value>> {
        let gain = self.extended(fork.then(drawn));
        let density = fork.own_density(strategy, drawn);
        is_regular(density).then(|| Found { density, gain: gain.over(density) })
    }

    /// The last vertex that one of the ways has found, of a path that carries something up to the vertex before.
    #[inline(always)]
    pub(super) fn last<'l>(
        &self,
        fork: &'l Fork<'l, I::Vertex>,
        drawn: &'l Drawn<I::Vertex>,
        Found { density, gain }: Found<RealOf<I>, I::Value>,
        (way, carried): (usize, I::Value),
    ) -> Last<'l, I::Vertex, I::Value> {
        let closing = || gain.multiply(self.closing(fork.then(drawn)));
        let tail = if gain.is_zero() { gain } else { closing() };
        let alone = carried.multiply(tail);
        Last { fork, drawn, density, tail, alone, way, seen: None, ratios: None }
    }
}
