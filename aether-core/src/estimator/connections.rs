//! Paths that are made of a piece of each of two walks: bidirectional path tracing.

use crate::combine::{Separable, combine_with};
use crate::estimator::joints::Pieces;
use crate::estimator::{Estimator, Factors, PathIntegrand, RealOf};
use crate::sequence::{PathView, RandomSequence};
use crate::strategy::{Drawn, Strategy, Vertex};
use crate::uniform::UniformSource;

/// How paths of one length are made of a piece of each of two walks, from either end.
#[derive(Clone, Debug)]
pub struct Connections<'t, S, N, D> {
    /// How many vertices the paths have.
    pub length: usize,
    /// What draws the last vertex where all others are of the first walk, in place of the first vertex of the second
    /// walk: next-event estimation.
    pub ending: Option<&'t S>,
    /// How many samples the technique takes that has so many vertices of the first walk; none if it is not used.
    pub samples: N,
    /// Whether this is one of them: otherwise it is only a technique that others are weighed against.
    pub is_drawn: D,
}

/// What a path contributes that is made of a piece of each of two walks.
#[derive(Clone, Copy, Debug)]
pub struct Connected<T> {
    /// How many of its vertices are those of the first walk.
    pub first: usize,
    /// Its share of the combined estimate: weight × f / p.
    pub value: T,
    /// f / p over the number of samples that its technique takes.
    pub alone: T,
}

impl<S, N: Fn(usize) -> usize, D: Fn(usize) -> bool> Connections<'_, S, N, D> {
    /// Whether the last vertex is drawn after so many of the first walk.
    #[inline]
    pub(super) fn ends_after(&self, first: usize) -> bool {
        self.ending.is_some() && first + 1 == self.length
    }

    /// Draws the last vertex of the path whose others are of the first walk.
    fn draw<V, U>(&self, walk: &RandomSequence<'_, V, S>, uniforms: &mut U) -> Option<Drawn<V>>
    where
        V: Vertex,
        S: Strategy<V>,
        U: UniformSource<V::Real> + ?Sized,
    {
        let (strategy, first) = (self.ending?, self.length.checked_sub(1)?);
        if first > walk.len() || (self.samples)(first) == 0 || !(self.is_drawn)(first) {
            return None;
        }
        uniforms.start(walk.block_after(first));
        let (tape, place) = (walk.arena.tape.unfolded(), walk.handle.place.range(0, first));
        strategy.sample(PathView::of_unfolded(&tape, place, strategy.reads()), uniforms)
    }
}

impl<I: PathIntegrand> Estimator<I, Factors<I::Value>> {
    /// Estimates all paths of one length that consist of the first vertices of one walk and, in opposite order,
    /// the first ones of another. The ways to make a path are combined by a heuristic, and `visit` is given the paths
    /// that contribute; it adds nothing to the arena of the walks.
    ///
    /// It is what [`combine`](crate::combine::combine) makes of slices of the one walk, each concatenated with a reversed
    /// slice of the other or ended by a strategy of its own, and the same numbers are drawn. Where strategies read two
    /// vertices at most and nothing leads in a single direction, none of these paths is made, and the
    /// weight of each follows from sums over the techniques along either walk: it costs the same however
    /// long the path is (as in Georgiev, "Implementing Vertex Connection and Merging", 2012).
    pub fn connections<S, N, D, H, U>(
        &self,
        [first, second]: [&RandomSequence<'_, I::Vertex, S>; 2],
        connections: &Connections<'_, S, N, D>,
        heuristic: &H,
        uniforms: &mut U,
        mut visit: impl FnMut(Connected<I::Value>),
    ) where
        S: Strategy<I::Vertex>,
        N: Fn(usize) -> usize,
        D: Fn(usize) -> bool,
        H: Separable<RealOf<I>> + Clone,
        U: UniformSource<RealOf<I>> + ?Sized,
    {
        if connections.length == 0 || !core::ptr::eq(first.arena, second.arena) {
            return;
        }
        self.remember(first.arena.contents());
        let drawn = connections.draw(first, uniforms);
        let (walks, drawn_last) = ([first, second], drawn.as_ref());
        if Pieces::<I, S, N, D, H>::are_plain(self, walks, connections, drawn_last) {
            let arena = first.arena;
            let ending = connections.ending.map(|ending| arena.intern(ending.clone()));
            let last = drawn_last.map(|drawn| arena.tape.keep(drawn).at(0));
            let tape = arena.tape.unfolded();
            let pieces = Pieces::new(self, walks, connections, heuristic, &tape, ending, last);
            if let Some(mut pieces) = pieces {
                return pieces.visit(&mut visit);
            }
        }
        let used = (0..=connections.length)
            .filter(|by| *by <= first.size() && (connections.samples)(*by) > 0)
            .filter(|by| connections.ends_after(*by) || connections.length - by <= second.size());
        let paths = first.arena.collect_counted(used.clone().map(|by| {
            let mut path = first.slice(0..by);
            match connections.ending.filter(|_| connections.ends_after(by)) {
                Some(strategy) => path.append_drawn(strategy.clone(), drawn.as_ref()),
                None => path = path.concat(&second.slice(0..connections.length - by).reverse()),
            }
            let path = if (connections.is_drawn)(by) { path } else { path.technique() };
            (path, (connections.samples)(by))
        }));
        for found in self.each(combine_with(heuristic.clone(), paths)) {
            if let Some(first) = used.clone().nth(found.technique) {
                visit(Connected { first, value: found.value, alone: found.alone });
            }
        }
    }
}
