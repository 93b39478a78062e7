//! Paths that are made of a piece of each of two walks: bidirectional path tracing.

use core::ops::RangeInclusive;

use crate::combine::{Separable, combine_with};
use crate::estimator::joints::Pieces;
use crate::estimator::{Estimator, Factors, PathIntegrand, RealOf, Techniques};
use crate::real::Scalar;
use crate::sequence::{PathView, RandomSequence};
use crate::strategy::{Drawn, Strategy, Vertex};
use crate::uniform::UniformSource;

/// How paths are made of a piece of each of two walks, from either end.
#[derive(Clone, Debug)]
pub struct Connections<'t, S, R, H, D> {
    /// The numbers of vertices that paths may have. There are none of paths for which no techniques are known.
    pub lengths: RangeInclusive<usize>,
    /// What draws the last vertex where all others are of the first walk, in place of the first vertex of the second
    /// walk: next-event estimation.
    pub ending: Option<&'t S>,
    /// How many vertices paths have at least that end so.
    pub fewest_ending: usize,
    /// How many samples techniques take, and how they are combined.
    pub techniques: &'t Techniques<R, H>,
    /// Whether paths with so many vertices, the first number, are made of which so many are of the first walk, the second
    /// one: otherwise theirs is only a technique that others are weighed against.
    pub is_drawn: D,
}

/// What a path contributes that is made of a piece of each of two walks.
#[derive(Clone, Copy, Debug)]
pub struct Connected<T> {
    /// How many vertices it has.
    pub length: usize,
    /// How many of them are those of the first walk.
    pub first: usize,
    /// Its share of the combined estimate: weight × f / p.
    pub value: T,
    /// f / p over the number of samples that its technique takes.
    pub alone: T,
}

impl<S, R: Scalar, H: Separable<R>, D: Fn(usize, usize) -> bool> Connections<'_, S, R, H, D> {
    /// Whether the last vertex of paths with so many vertices is drawn, where all others are of the first walk.
    #[inline(always)]
    pub(super) fn end(&self, length: usize) -> bool {
        length >= self.fewest_ending.max(1) && self.ending.is_some()
    }

    /// How many vertices paths have at most, if they can be no longer than so much.
    pub(super) fn longest(&self, most: usize) -> usize {
        let known = self.techniques.longest().unwrap_or(0);
        most.min(known).min(*self.lengths.end())
    }

    /// Whether the last vertex of the path with so many vertices is to be drawn whose others are of the first walk, which has so
    /// many.
    #[inline]
    fn draws_last(&self, length: usize, walk: usize) -> bool {
        self.lengths.contains(&length)
            && self.end(length)
            && length <= walk + 1
            && self.techniques.samples(length, length - 1) > 0
            && (self.is_drawn)(length, length - 1)
    }
}

impl<I: PathIntegrand> Estimator<I, Factors<I::Value>> {
    /// Estimates all paths that consist of the first vertices of one walk and, in opposite order, the first ones of
    /// another. The ways to make a path are combined by the heuristic of the techniques, and `visit` is given the paths that
    /// contribute; it must not use the arena of the walks. `is_drawn` may be called several times for a path.
    ///
    /// A walk that has ended by chance, as by Russian roulette, might have gone on: it is to be lengthened by
    /// [`append_up_to`](RandomSequence::append_up_to) to as many vertices as paths may have, without being sampled, so that what it might
    /// have made counts as a technique. Otherwise the weights of long paths are too large.
    ///
    /// It is what [`combine`](crate::combine::combine) makes of slices of the one walk, each concatenated with a reversed
    /// slice of the other or ended by a strategy of its own, for each length; and the same numbers are drawn, by a source
    /// that tells blocks of dimensions apart ([`UniformSource::start`]). Where strategies read two vertices at most and
    /// nothing leads in a single direction, none of these paths is made, and the weight of each follows from sums over
    /// the techniques along either walk: it costs the same however long the path is (as in Georgiev, "Implementing Vertex
    /// Connection and Merging", 2012).
    ///
    /// # Panics
    /// If the walks are of different arenas.
    pub fn connections<S, H, D, U>(
        &self,
        walks: [&RandomSequence<'_, I::Vertex, S>; 2],
        connections: &Connections<'_, S, RealOf<I>, H, D>,
        uniforms: &mut U,
        mut visit: impl FnMut(Connected<I::Value>),
    ) where
        S: Strategy<I::Vertex>,
        H: Separable<RealOf<I>> + Clone,
        D: Fn(usize, usize) -> bool,
        U: UniformSource<RealOf<I>> + ?Sized,
    {
        let [first, second] = walks;
        assert!(
            core::ptr::eq(first.arena, second.arena),
            "walks of different arenas cannot be joined: make both by `sequence` of one arena"
        );
        let arena = first.arena;
        self.remember(arena.contents());
        let mut lasts = core::mem::take(&mut arena.joints.borrow_mut().lasts);
        draw_lasts(first, connections, uniforms, &mut lasts);
        self.connect([first, second], connections, &lasts, &mut visit);
        arena.joints.borrow_mut().lasts = lasts;
    }

    /// The same with the last vertices that were drawn for themselves, by the length of the path.
    fn connect<S, H, D>(
        &self,
        walks: [&RandomSequence<'_, I::Vertex, S>; 2],
        connections: &Connections<'_, S, RealOf<I>, H, D>,
        lasts: &[Option<Drawn<I::Vertex>>],
        visit: &mut impl FnMut(Connected<I::Value>),
    ) where
        S: Strategy<I::Vertex>,
        H: Separable<RealOf<I>> + Clone,
        D: Fn(usize, usize) -> bool,
    {
        if Pieces::<I, S, H, D>::are_plain(self, walks, connections) {
            let tape = walks[0].arena.tape.unfolded();
            let mut pieces = Pieces::new(self, walks, connections, &tape, lasts);
            if pieces.prepare() {
                return pieces.visit(visit);
            }
        }
        let longest = connections.longest(walks[0].size() + walks[1].size() + 1);
        for length in (*connections.lengths.start()).max(1)..=longest {
            let last = lasts.get(length).copied().flatten();
            self.connected_paths((length, last), walks, connections, visit);
        }
    }

    /// The same of one length by paths that are made, with what was drawn as the last vertex of one of them.
    fn connected_paths<S, H, D>(
        &self,
        (length, drawn): (usize, Option<Drawn<I::Vertex>>),
        [first, second]: [&RandomSequence<'_, I::Vertex, S>; 2],
        connections: &Connections<'_, S, RealOf<I>, H, D>,
        visit: &mut impl FnMut(Connected<I::Value>),
    ) where
        S: Strategy<I::Vertex>,
        H: Separable<RealOf<I>> + Clone,
        D: Fn(usize, usize) -> bool,
    {
        let samples = |by: usize| connections.techniques.samples(length, by);
        let ends = |by: usize| by + 1 == length && connections.end(length);
        let used = (0..=length)
            .filter(|by| *by <= first.size() && samples(*by) > 0)
            .filter(|by| ends(*by) || length - by <= second.size());
        let paths = first.arena.collect_counted(used.clone().map(|by| {
            let mut path = first.slice(0..by);
            match connections.ending.filter(|_| ends(by)) {
                Some(strategy) => path.append_drawn(strategy.clone(), drawn.as_ref()),
                None => path = path.concat(&second.slice(0..length - by).reverse()),
            }
            let is_drawn = (connections.is_drawn)(length, by);
            (if is_drawn { path } else { path.technique() }, samples(by))
        }));
        let heuristic = connections.techniques.heuristic().clone();
        for found in self.each(combine_with(heuristic, paths)) {
            if let Some(first) = used.clone().nth(found.technique) {
                visit(Connected { length, first, value: found.value, alone: found.alone });
            }
        }
    }
}

/// Draws last vertices for themselves, by the length of the path.
fn draw_lasts<V, S, H, D, U>(
    walk: &RandomSequence<'_, V, S>,
    connections: &Connections<'_, S, V::Real, H, D>,
    uniforms: &mut U,
    lasts: &mut Vec<Option<Drawn<V>>>,
) where
    V: Vertex,
    S: Strategy<V>,
    H: Separable<V::Real>,
    D: Fn(usize, usize) -> bool,
    U: UniformSource<V::Real> + ?Sized,
{
    lasts.clear();
    let Some(strategy) = connections.ending else { return };
    let (tape, reads) = (walk.arena.tape.unfolded(), strategy.reads());
    let longest = connections.longest(walk.len() + 1);
    for length in 0..longest + 1 {
        let drawn = match connections.draws_last(length, walk.len()) {
            true => {
                let first = walk.handle.place.range(0, length - 1);
                uniforms.start(walk.block_after(length - 1));
                strategy.sample(PathView::of_unfolded(&tape, first, reads), uniforms)
            }
            false => None,
        };
        // A vertex that is taken out to be looked at would be copied.
        if let Some(Drawn { dirac: Some(dirac), .. }) = &drawn {
            walk.arena.tape.note(Some(*dirac));
        }
        lasts.push(drawn);
    }
}
