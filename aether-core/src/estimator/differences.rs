//! The paths along a walk, and how much more what shifts make of them contributes.

use crate::combine::Heuristic;
use crate::estimator::endings::taken;
use crate::estimator::last::{Found, Ways};
use crate::estimator::sides::{Next, Side, Sides};
use crate::estimator::steps::{Fork, RING, Steps, Walk, bits};
use crate::estimator::{Ending, Endings, Estimator, Factors, PathIntegrand, RealOf, Value};
use crate::sequence::RandomSequence;
use crate::shift::{AT_HAND, Shift};
use crate::strategy::{Dirac, Strategy};
use crate::uniform::UniformSource;

/// What paths along a walk are compared with.
#[derive(Clone, Debug)]
pub struct Shifts<M, F, const N: usize> {
    /// The shifts; `None` takes the place of one that is not asked for.
    pub shifts: [Option<M>; N],
    /// How many vertices paths that are compared have at least.
    pub shortest: usize,
    /// Whether nothing lies between two vertices. The step that a walk goes on with finds what it sees; its density
    /// says nothing of what lies in between, and the other path of a pair may be visible. What the steps of endings find
    /// may be hidden, as for next-event estimation.
    pub sees: F,
}

impl<I: PathIntegrand> Estimator<I, Factors<I::Value>> {
    /// Goes on from the end of a path with a step again and again, as [`Estimator::walk`] does with its steps, once those that
    /// the path has but has not taken yet are taken. Estimates all paths along this walk, and of each shift how much more
    /// all shifted paths carry than these (Kettunen et al. 2015): the sum over paths of
    /// (f(T x) |∂T x/∂x| − f(x)) × weight / p, zero for a shift that is `None`.
    ///
    /// A pair of a path and its shifted one could have been made from either of the two, in each way that
    /// `endings` uses: its weight is that of a heuristic over all of these. A path that has no shifted one has
    /// only its own ways. With the estimate of the shift back, from paths that are sampled as shifted ones are
    /// ([`Shift::technique`]), the sum is the difference of both integrals.
    ///
    /// Where [`Estimator::walk`] makes no paths and a shift looks at two vertices at most, none is made, and from a
    /// few vertices on after both paths have met the shifted one costs nothing. Nothing may be added to the arena
    /// meanwhile.
    #[expect(clippy::too_many_arguments, reason = "those of a walk, and the shifts")]
    pub fn differences<'t, S, P, H, U, M, F, const N: usize>(
        &self,
        start: &RandomSequence<'_, I::Vertex, S>,
        step: &S,
        endings: &Endings<'t, S, P>,
        shifts: &Shifts<M, F, N>,
        heuristic: &H,
        uniforms: &mut U,
        visit: impl FnMut(Ending<'t, S, I::Value>),
    ) -> [I::Value; N]
    where
        S: Strategy<I::Vertex> + 't,
        P: Fn(usize, &[S]) -> bool,
        H: Heuristic<RealOf<I>> + Clone,
        U: UniformSource<RealOf<I>> + ?Sized,
        M: Shift<I::Vertex, S>,
        F: Fn(&I::Vertex, &I::Vertex) -> bool,
    {
        let is_short = |shift: &M| shift.reads() <= AT_HAND;
        let steps = Steps { first: &[], then: step };
        if self.is_short(start, Some(&steps), endings)
            && shifts.shifts.iter().flatten().all(is_short)
        {
            return self
                .differences_at_last(start, &steps, endings, shifts, heuristic, uniforms, visit);
        }
        let walk = taken(start, step, endings, uniforms);
        self.differences_of_sequences(&walk, endings, shifts, heuristic, uniforms, visit)
    }

    /// The same without paths.
    #[expect(clippy::too_many_arguments, reason = "those of a walk, and the shifts")]
    fn differences_at_last<'t, S, P, H, U, M, F, const N: usize>(
        &self,
        walk: &RandomSequence<'_, I::Vertex, S>,
        steps: &Steps<'_, S>,
        endings: &Endings<'t, S, P>,
        shifts: &Shifts<M, F, N>,
        heuristic: &H,
        uniforms: &mut U,
        mut visit: impl FnMut(Ending<'t, S, I::Value>),
    ) -> [I::Value; N]
    where
        S: Strategy<I::Vertex> + 't,
        P: Fn(usize, &[S]) -> bool,
        H: Heuristic<RealOf<I>>,
        U: UniformSource<RealOf<I>> + ?Sized,
        M: Shift<I::Vertex, S>,
        F: Fn(&I::Vertex, &I::Vertex) -> bool,
    {
        let tape = &walk.arena.tape.unfolded();
        let steps = Walk::made(walk, tape, Some(steps));
        let pairs = Sides { estimator: self, sees: &shifts.sees };
        let mut sides = shifts.shifts.each_ref().map(|shift| shift.as_ref().map(Side::new));
        let (mut carried, mut recent, mut length) = (I::Value::one(), [None; RING], 0);
        let mut before: Option<Found<RealOf<I>, I::Value>> = None;
        while length < *endings.lengths.end() {
            length += 1;
            let i = length - 1;
            let Some(own) = steps.strategy(i) else { break };
            let fork = Fork::new(&recent, i);
            let drawn = steps.draw(i, own, &fork, uniforms);
            let found = drawn.as_ref().and_then(|drawn| self.found(&fork, own, drawn));
            let directed =
                drawn.as_ref().is_some_and(|drawn| drawn.dirac == Some(Dirac::Direction));
            let fork_before = Fork::new(&recent, i.saturating_sub(1));
            let next = before.and_then(|found| {
                let (i, drawn) = (i - 1, recent[(i - 1) % RING].as_ref()?);
                Some(Next { i, fork: &fork_before, drawn, own: steps.strategy(i)?, found })
            });
            if let Some(next) = &next {
                sides.iter_mut().flatten().for_each(|side| pairs.go_on(side, next, directed));
            }
            let asked = *endings.lengths.start() <= length;
            let used = if asked { endings.used::<I::Vertex>(length) } else { 0 };
            let ways = Ways::new(bits(used).map(|way| {
                let steps = endings.ways[way];
                (steps.first().unwrap_or(own), steps.is_empty())
            }));
            for (number, way) in bits(used).enumerate() {
                let (steps, other) = (endings.ways[way], &mut None);
                let (last, found) = match steps.first() {
                    None => (&drawn, found),
                    Some(step) => {
                        uniforms.start(walk.block_after(i));
                        *other = fork.draw(step, uniforms);
                        let found = other.as_ref().and_then(|last| self.found(&fork, step, last));
                        (&*other, found)
                    }
                };
                let (Some(drawn), Some(found)) = (last, found) else { continue };
                let last = &mut self.last(&fork, drawn, found, (number, carried));
                if length >= shifts.shortest {
                    for side in sides.iter_mut().flatten() {
                        pairs.compare(side, last, &ways, (next.as_ref(), directed), heuristic);
                    }
                }
                if !last.alone.is_zero() {
                    let (alone, weight) = (last.alone, last.weight(&ways, heuristic));
                    visit(Ending { length, steps, value: alone.times(weight), alone });
                }
            }
            let (Some(drawn), Some(found)) = (drawn, found) else { break };
            carried = carried.multiply(found.gain);
            if carried.is_zero() && !sides.iter().flatten().any(Side::carries) {
                break;
            }
            recent[i % RING] = Some(drawn);
            before = Some(found);
        }
        sides.map(|side| side.map_or(I::Value::zero(), |side| side.difference))
    }
}
