//! Paths along a walk that end in one of several ways: next-event estimation.

use core::ops::RangeInclusive;

use crate::combine::{Heuristic, combine_with};
use crate::estimator::range::is_regular;
use crate::estimator::steps::{Fork, MOST_WAYS, RING, Steps, Walk};
use crate::estimator::{Estimator, Factors, PathIntegrand, RealOf, Value};
use crate::real::Real;
use crate::sequence::{Arena, LAST, RandomSequence};
use crate::strategy::{Drawn, Strategy, Vertex};
use crate::uniform::UniformSource;

/// How the paths along a walk may end.
#[derive(Clone, Debug)]
pub struct Endings<'t, S, P> {
    /// The numbers of vertices that paths may have; none is longer than the walk.
    pub lengths: RangeInclusive<usize>,
    /// The strategies of the last vertices of a path: each way takes the place of as many vertices of the walk as it yields,
    /// none for those of the walk itself.
    pub ways: &'t [&'t [S]],
    /// Whether paths with some number of vertices end in some way.
    pub is_used: P,
}

/// How many vertices steps yield together.
#[inline(always)]
pub(super) fn vertices<V: Vertex, S: Strategy<V>>(steps: &[S]) -> usize {
    if S::VERTICES == 1 { steps.len() } else { steps.iter().map(S::vertices).sum() }
}

/// What a path that ends in one of several ways contributes.
#[derive(Clone, Copy, Debug)]
pub struct Ending<'t, S, T> {
    /// How many vertices the path has.
    pub length: usize,
    /// The strategies of its last vertices; none for those of the walk itself.
    pub steps: &'t [S],
    /// Its share of the combined estimate: weight × f / p.
    pub value: T,
    /// f / p: what it would contribute if it were the only way.
    pub alone: T,
}

impl<'t, S, P: Fn(usize, &[S]) -> bool> Endings<'t, S, P> {
    /// A bit for each way, whether paths with so many vertices end in it.
    #[inline(always)]
    pub(super) fn used<V: Vertex>(&self, length: usize) -> u32
    where
        S: Strategy<V>,
    {
        let mut used = 0;
        for (way, steps) in self.ways.iter().enumerate() {
            used |= u32::from(self.has(length, steps)) << way;
        }
        used
    }

    /// Whether paths with so many vertices end in some way.
    #[inline(always)]
    fn has<V: Vertex>(&self, length: usize, steps: &[S]) -> bool
    where
        S: Strategy<V>,
    {
        vertices(steps) <= length && (self.is_used)(length, steps)
    }

    /// The ways that paths with so many vertices end in.
    #[inline(always)]
    pub(super) fn of_length<V: Vertex>(
        &self,
        length: usize,
    ) -> impl Iterator<Item = &'t [S]> + Clone
    where
        S: Strategy<V>,
    {
        self.ways.iter().copied().filter(move |steps| self.has(length, steps))
    }
}

impl<I: PathIntegrand> Estimator<I, Factors<I::Value>> {
    /// Estimates all paths along a walk: those of each length, all but the last vertices of which are the walk's, and
    /// which end in one of several ways. The ways to make a path are combined by a heuristic, and `visit` is
    /// given the paths that contribute; it adds nothing to the arena of the walk.
    ///
    /// It is what [`combine`](crate::combine::combine) makes of slices of the walk with the endings appended to them,
    /// and the same numbers are drawn. Where no way has more than one step, and three vertices at most are read, none of
    /// these paths is made.
    pub fn endings<'t, S, P, H, U>(
        &self,
        walk: &RandomSequence<'_, I::Vertex, S>,
        endings: &Endings<'t, S, P>,
        heuristic: &H,
        uniforms: &mut U,
        visit: impl FnMut(Ending<'t, S, I::Value>),
    ) where
        S: Strategy<I::Vertex> + 't,
        P: Fn(usize, &[S]) -> bool,
        H: Heuristic<RealOf<I>> + Clone,
        U: UniformSource<RealOf<I>> + ?Sized,
    {
        if self.is_short(walk, None, endings) {
            let tape = &walk.arena.tape.unfolded();
            self.last_steps(&Walk::made(walk, tape, None), endings, heuristic, uniforms, visit);
        } else {
            self.last_sequences(walk, endings, heuristic, uniforms, visit);
        }
    }

    /// Takes the steps of a new path of an arena, until one finds nothing or paths would be longer than the
    /// endings ask for, and estimates all paths along this walk: [`Estimator::endings`], whose terms for `visit` hold here.
    ///
    /// The same numbers are drawn as for a walk that is made first, by a source that tells blocks of dimensions apart
    /// ([`UniformSource::start`]). But vertices are not kept longer than they are read, and the walk ends where
    /// nothing is carried on.
    pub fn walk<'t, S, P, H, U>(
        &self,
        arena: &Arena<I::Vertex, S>,
        steps: &Steps<'_, S>,
        endings: &Endings<'t, S, P>,
        heuristic: &H,
        uniforms: &mut U,
        visit: impl FnMut(Ending<'t, S, I::Value>),
    ) where
        S: Strategy<I::Vertex> + 't,
        P: Fn(usize, &[S]) -> bool,
        H: Heuristic<RealOf<I>> + Clone,
        U: UniformSource<RealOf<I>> + ?Sized,
    {
        let mut start = arena.sequence();
        if self.is_short(&start, Some(steps), endings) {
            let walk = Walk::new(&start, steps);
            return self.last_steps(&walk, endings, heuristic, uniforms, visit);
        }
        for step in steps.first {
            start.append(step.clone());
        }
        let walk = taken(&start, steps.then, endings, uniforms);
        self.last_sequences(&walk, endings, heuristic, uniforms, visit);
    }

    /// Whether paths along a walk, and steps that it is to take, need not be made to be estimated: ways to end them
    /// have one step at most, and no more vertices are read than are at hand.
    #[inline(always)]
    pub(super) fn is_short<S: Strategy<I::Vertex>, P>(
        &self,
        walk: &RandomSequence<'_, I::Vertex, S>,
        steps: Option<&Steps<'_, S>>,
        endings: &Endings<'_, S, P>,
    ) -> bool {
        let read_few = |steps: &[S]| steps.iter().all(|step| step.reads().vertices <= LAST);
        S::VERTICES == 1
            && endings.ways.iter().all(|steps| steps.len() <= 1 && read_few(steps))
            && endings.ways.len() <= MOST_WAYS
            && self.reads() <= LAST
            && walk.arena.most_read.get() <= LAST
            && steps.is_none_or(|steps| {
                read_few(steps.first) && read_few(core::slice::from_ref(steps.then))
            })
            && walk.is_run()
    }

    /// The same by sequences of their own.
    fn last_sequences<'t, S, P, H, U>(
        &self,
        walk: &RandomSequence<'_, I::Vertex, S>,
        endings: &Endings<'t, S, P>,
        heuristic: &H,
        uniforms: &mut U,
        mut visit: impl FnMut(Ending<'t, S, I::Value>),
    ) where
        S: Strategy<I::Vertex> + 't,
        P: Fn(usize, &[S]) -> bool,
        H: Heuristic<RealOf<I>> + Clone,
        U: UniformSource<RealOf<I>> + ?Sized,
    {
        for length in *endings.lengths.start()..=walk.size().min(*endings.lengths.end()) {
            let ways = endings.of_length::<I::Vertex>(length);
            let paths = walk.arena.collect(ways.clone().map(|steps| {
                let mut path = walk.slice(0..length - vertices(steps));
                for step in steps {
                    path.append(step.clone()).sample(uniforms);
                }
                path
            }));
            for found in self.each(combine_with(heuristic.clone(), paths)) {
                let steps = ways.clone().nth(found.technique).unwrap_or_default();
                visit(Ending { length, steps, value: found.value, alone: found.alone });
            }
        }
    }

    /// The same of ways of at most one step.
    #[inline(always)]
    fn last_steps<'t, S, P, H, U>(
        &self,
        walk: &Walk<'_, '_, I::Vertex, S>,
        endings: &Endings<'t, S, P>,
        heuristic: &H,
        uniforms: &mut U,
        mut visit: impl FnMut(Ending<'t, S, I::Value>),
    ) where
        S: Strategy<I::Vertex> + 't,
        P: Fn(usize, &[S]) -> bool,
        H: Heuristic<RealOf<I>>,
        U: UniformSource<RealOf<I>> + ?Sized,
    {
        // f / p of the vertices before the last one, and the last ones with it.
        let (mut carried, mut recent, mut length) = (I::Value::one(), [None; RING], 0);
        while length < *endings.lengths.end() {
            length += 1;
            let fork = Fork::new(&recent, length - 1);
            let Some(own) = walk.strategy(length - 1) else { break };
            let drawn = walk.draw(length - 1, own, &fork, uniforms);
            let met = drawn.as_ref().and_then(|drawn| self.met(&fork, own, drawn, carried));
            let asked = *endings.lengths.start() <= length;
            let ways = if asked { endings.ways } else { &[] };
            for (way, steps) in ways.iter().copied().enumerate() {
                let (step, is_used) = (steps.first(), || endings.has::<I::Vertex>(length, steps));
                let other = match step {
                    Some(step) if is_used() => {
                        uniforms.start(walk.block_after(length - 1));
                        fork.draw(step, uniforms)
                    }
                    _ => None,
                };
                let (last, met) = match step {
                    None => (&drawn, met),
                    Some(step) => {
                        let met = other.as_ref();
                        (&other, met.and_then(|last| self.met(&fork, step, last, carried)))
                    }
                };
                let (Some(last), Some(met)) = (last, met) else { continue };
                let alone = met.carried.multiply(self.closing(fork.then(last)));
                // Mostly the walk has found no end, used or not.
                if alone.is_zero() || (step.is_none() && !is_used()) {
                    continue;
                }
                let (mut ratios, mut count, mut index) = ([RealOf::<I>::ONE; MOST_WAYS], 0, 0);
                for (other, steps) in ways.iter().enumerate() {
                    if other == way {
                        index = count;
                    } else if endings.has::<I::Vertex>(length, steps) {
                        let strategy = steps.first().unwrap_or(own);
                        ratios[count] = fork.density(strategy, last) / met.density;
                    } else {
                        continue;
                    }
                    count += 1;
                }
                let value = alone.times(heuristic.weight(&ratios[..count], index));
                visit(Ending { length, steps, value, alone });
            }
            let (Some(drawn), Some(met)) = (drawn, met) else { break };
            recent[(length - 1) % RING] = Some(drawn);
            carried = met.carried;
        }
    }

    /// What a last vertex carries that a strategy has drawn, if anything.
    #[inline(always)]
    fn met<S: Strategy<I::Vertex>>(
        &self,
        fork: &Fork<'_, I::Vertex>,
        strategy: &S,
        drawn: &Drawn<I::Vertex>,
        carried: I::Value,
    ) -> Option<Met<RealOf<I>, I::Value>> {
        let carried = carried.multiply(self.extended(fork.then(drawn)));
        if carried.is_zero() {
            return None;
        }
        let density = fork.own_density(strategy, drawn);
        is_regular(density).then(|| Met { density, carried: carried.over(density) })
    }
}

/// A walk with its steps taken and a strategy appended to it as often as endings ask for.
pub(super) fn taken<'a, V, S, P, U>(
    start: &RandomSequence<'a, V, S>,
    step: &S,
    endings: &Endings<'_, S, P>,
    uniforms: &mut U,
) -> RandomSequence<'a, V, S>
where
    V: Vertex,
    S: Strategy<V>,
    U: UniformSource<V::Real> + ?Sized,
{
    let (mut walk, longest) = (*start, *endings.lengths.end());
    walk.sample(uniforms);
    walk.go_on(longest, step.clone(), uniforms);
    // Where the walk has found nothing, an ending of several steps may.
    for _ in 1..endings.ways.iter().map(|steps| vertices(steps)).max().unwrap_or(1) {
        if walk.size() < longest {
            walk.append(step.clone());
        }
    }
    walk
}

/// What a last vertex carries.
#[derive(Clone, Copy)]
struct Met<R, T> {
    /// Its density under the strategy that made it.
    density: R,
    /// f / p of the path up to it.
    carried: T,
}
