//! Paths along a walk that end in one of several ways: next-event estimation.

use core::ops::RangeInclusive;

use crate::combine::{Heuristic, combine_with};
use crate::estimator::{Estimator, Factors, PathIntegrand, RealOf, Value, is_regular};
use crate::real::Real;
use crate::sequence::{LAST, PathView, Place, RandomSequence, Recent, Unfolded};
use crate::strategy::{Drawn, Strategy, Vertex};
use crate::uniform::UniformSource;
use crate::work::count_densities;

/// A last vertex that carries something, and what it carries.
type Found<I> = (Drawn<<I as PathIntegrand>::Vertex>, Met<RealOf<I>, <I as PathIntegrand>::Value>);

/// How the paths along a walk may end.
#[derive(Clone, Debug)]
pub struct Endings<'t, S, P> {
    /// The numbers of vertices that paths may have.
    pub lengths: RangeInclusive<usize>,
    /// The strategies of the last vertices of a path: each way takes the place of as many steps of the walk as it has,
    /// none for those of the walk itself.
    pub ways: &'t [&'t [S]],
    /// Whether paths with some number of vertices end in some way.
    pub is_used: P,
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
    fn used(&self, length: usize) -> u64 {
        let is_used = |steps: &[S]| steps.len() <= length && (self.is_used)(length, steps);
        let bits = self.ways.iter().enumerate();
        bits.fold(0, |used, (way, steps)| used | u64::from(is_used(steps)) << way)
    }

    /// The ways that paths with so many vertices end in.
    #[inline(always)]
    fn of_length(&self, length: usize) -> impl Iterator<Item = &'t [S]> + Clone {
        let ways = self.ways.iter().copied();
        ways.filter(move |steps| steps.len() <= length && (self.is_used)(length, steps))
    }
}

impl<I: PathIntegrand> Estimator<I, Factors<I::Value>> {
    /// Estimates all paths along a walk: those of each length, all but the last vertices of which are the walk's, and
    /// which end in one of several ways. The ways to make a path are combined by a heuristic, and `visit` is
    /// given the paths that contribute.
    ///
    /// It is what [`combine`](crate::combine::combine) makes of slices of the walk with the endings appended to them,
    /// and the same numbers are drawn; where no way has more than one step, none of these paths is made.
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
        let is_short = S::VERTICES == 1 && endings.ways.iter().all(|steps| steps.len() <= 1);
        if is_short && endings.ways.len() <= 64 && walk.is_run() {
            self.last_steps(walk, endings, heuristic, uniforms, visit);
        } else {
            self.last_sequences(walk, endings, heuristic, uniforms, visit);
        }
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
        for length in endings.lengths.clone() {
            let ways = endings.of_length(length);
            let paths = walk.arena.collect(ways.clone().map(|steps| {
                let mut path = walk.slice(0..length - steps.len());
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

    /// The same of ways of at most one step, along a walk that is one run.
    fn last_steps<'t, S, P, H, U>(
        &self,
        walk: &RandomSequence<'_, I::Vertex, S>,
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
        let arena = walk.arena;
        let (tape, strategies) = (&arena.tape.unfolded(), arena.strategies.borrow());
        let mut ratios = core::mem::take(&mut *arena.ratios.borrow_mut());
        // f / p of the vertices before the last one, and the last ones with it.
        let (mut carried, mut recent) = (I::Value::one(), [None; LAST + 1]);
        for length in 1..=walk.size().min(walk.len() + 1).min(*endings.lengths.end()) {
            let place = walk.handle.place.range(0, length);
            recent.rotate_right(1);
            recent[0] =
                if length <= walk.len() { tape.at_hand(place.at(length - 1)) } else { None };
            let fork = Fork { tape, place, recent };
            let own = &strategies[tape.way(place, length - 1).strategy() as usize];
            let met = if length <= walk.len() { self.met(walk, &fork, carried) } else { None };
            if endings.lengths.contains(&length) {
                let used = endings.used(length);
                let ways =
                    || endings.ways.iter().enumerate().filter(|(way, _)| used >> way & 1 == 1);
                for (index, (way, steps)) in ways().enumerate() {
                    let found = match steps.first() {
                        None => met.and_then(|met| self.closed(&fork, met)),
                        Some(step) => {
                            uniforms.start(walk.block_after(length - 1));
                            self.drawn(&fork, step, carried, uniforms)
                        }
                    };
                    let Some((drawn, Met { density, carried })) = found else { continue };
                    ratios.clear();
                    ratios.extend(ways().map(|(other, steps)| match other == way {
                        true => RealOf::<I>::ONE,
                        false => fork.density(steps.first().unwrap_or(own), &drawn) / density,
                    }));
                    let value = carried.times(heuristic.weight(&ratios, index));
                    visit(Ending { length, steps, value, alone: carried });
                }
            }
            match met {
                Some(met) if !met.carried.is_zero() => carried = met.carried,
                _ => break,
            }
        }
        *arena.ratios.borrow_mut() = ratios;
    }

    /// What the walk's own vertex carries on.
    #[inline]
    fn met<S: Strategy<I::Vertex>>(
        &self,
        walk: &RandomSequence<'_, I::Vertex, S>,
        fork: &Fork<'_, I::Vertex>,
        carried: I::Value,
    ) -> Option<Met<RealOf<I>, I::Value>> {
        let last = fork.place.len as usize - 1;
        let carried = carried.multiply(self.extended(fork.walked()));
        let known = fork.tape.own(fork.place, last);
        let density = known.unwrap_or_else(|| walk.arena.factor(fork.place, last, fork.place));
        is_regular(density).then(|| Met { density, carried: carried.over(density) })
    }

    /// The walk's own vertex as the last one, if it carries anything then.
    #[inline]
    fn closed(
        &self,
        fork: &Fork<'_, I::Vertex>,
        Met { density, carried }: Met<RealOf<I>, I::Value>,
    ) -> Option<Found<I>> {
        let carried = carried.multiply(self.closing(fork.walked()));
        if carried.is_zero() {
            return None;
        }
        let last = fork.place.len as usize - 1;
        let dirac = fork.tape.kind(fork.place, last, false);
        let drawn = Drawn { dirac, ..Drawn::new(*fork.recent[0]?) };
        Some((drawn, Met { density, carried }))
    }

    /// What a strategy finds as the last vertex, if it carries anything.
    #[inline]
    fn drawn<S, U>(
        &self,
        fork: &Fork<'_, I::Vertex>,
        strategy: &S,
        carried: I::Value,
        uniforms: &mut U,
    ) -> Option<Found<I>>
    where
        S: Strategy<I::Vertex>,
        U: UniformSource<RealOf<I>> + ?Sized,
    {
        let drawn = strategy.sample(fork.before().limited(strategy.reads()), uniforms)?;
        let path = fork.continued(&drawn);
        let carried = carried.multiply(self.extended(path));
        if carried.is_zero() {
            return None;
        }
        let density = match drawn.value {
            Some(density) => {
                count_densities(1);
                density
            }
            None => fork.density(strategy, &drawn),
        };
        if !is_regular(density) {
            return None;
        }
        let carried = carried.over(density).multiply(self.closing(path));
        (!carried.is_zero()).then_some((drawn, Met { density, carried }))
    }
}

/// What a last vertex carries.
#[derive(Clone, Copy)]
struct Met<R, T> {
    /// Its density under the strategy that made it.
    density: R,
    /// f / p of the path up to it.
    carried: T,
}

/// Where the ways to end a path part.
struct Fork<'r, V: Vertex> {
    tape: &'r Unfolded<'r, V>,
    /// The path as the walk itself goes on.
    place: Place,
    /// Its last vertices, the last one first.
    recent: [Option<&'r V>; LAST + 1],
}

impl<V: Vertex> Fork<'_, V> {
    /// The vertices that all ways share.
    #[inline]
    fn shared(&self) -> Place {
        self.place.range(0, self.place.len as usize - 1)
    }

    /// The last ones of these.
    #[inline(always)]
    fn last_shared(&self) -> Recent<'_, V> {
        let [_, last @ ..] = self.recent;
        last
    }

    /// The same as strategies see them.
    #[inline]
    fn before(&self) -> PathView<'_, V> {
        PathView::of_recent(self.tape, self.shared(), self.last_shared())
    }

    /// The path as the walk goes on.
    #[inline]
    fn walked(&self) -> PathView<'_, V> {
        let [last @ .., _] = self.recent;
        PathView::of_recent(self.tape, self.place, last)
    }

    /// The path with another last vertex.
    #[inline]
    fn continued<'p>(&'p self, drawn: &'p Drawn<V>) -> PathView<'p, V> {
        PathView::of_extended(self.tape, self.shared(), self.last_shared(), drawn)
    }

    /// The density of a vertex under a strategy, or its probability if it was drawn with a Dirac factor.
    #[inline]
    fn density<S: Strategy<V>>(&self, strategy: &S, drawn: &Drawn<V>) -> V::Real {
        let before = self.before().asking(drawn.dirac).limited(strategy.reads());
        count_densities(1);
        strategy.pdf(before, &drawn.vertex).of_kind(drawn.dirac)
    }
}
