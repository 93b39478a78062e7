//! The paths along a walk and shifted ones, where they have to be made.

use crate::combine::Heuristic;
use crate::estimator::endings::vertices;
use crate::estimator::{Ending, Endings, Estimator, Factors, PathIntegrand, RealOf, Shifts, Value};
use crate::path_density::PathDensity;
use crate::sequence::RandomSequence;
use crate::shift::Shift;
use crate::strategy::{Strategy, Vertex};
use crate::uniform::UniformSource;

impl<I: PathIntegrand> Estimator<I, Factors<I::Value>> {
    /// [`Estimator::differences`] by sequences of their own, for a walk whose steps have been taken.
    pub(super) fn differences_of_sequences<'a, 't, S, P, H, U, M, F, const N: usize>(
        &self,
        walk: &RandomSequence<'a, I::Vertex, S>,
        endings: &Endings<'t, S, P>,
        shifts: &Shifts<M, F, N>,
        heuristic: &H,
        uniforms: &mut U,
        mut visit: impl FnMut(Ending<'t, S, I::Value>),
    ) -> [I::Value; N]
    where
        I::Vertex: 'a,
        S: Strategy<I::Vertex> + 't + 'a,
        P: Fn(usize, &[S]) -> bool,
        H: Heuristic<RealOf<I>>,
        U: UniformSource<RealOf<I>> + ?Sized,
        M: Shift<I::Vertex, S>,
        F: Fn(&I::Vertex, &I::Vertex) -> bool,
    {
        let mut differences = [I::Value::zero(); N];
        for length in *endings.lengths.start()..=walk.size().min(*endings.lengths.end()) {
            let ways: Vec<_> = endings.of_length::<I::Vertex>(length).collect();
            let techniques = |walk: &RandomSequence<'a, I::Vertex, S>| {
                let ended = |steps: &&[S]| {
                    let mut path = walk.slice(0..length - vertices(steps));
                    steps.iter().for_each(|step| _ = path.append(step.clone()));
                    path
                };
                ways.iter().map(ended).collect::<Vec<_>>()
            };
            let mut ours = techniques(walk);
            ours.iter_mut().for_each(|path| _ = path.sample(uniforms));
            let samples = ours.iter().zip(&ways).enumerate();
            for (way, (base, steps)) in samples.filter(|(_, (base, _))| base.pdf().is_regular()) {
                let alone = self.of(base);
                if !alone.is_zero() {
                    let value = alone.times(base.weight_with(heuristic, (&ours, way), None));
                    visit(Ending { length, steps, value, alone });
                }
                let asked = differences.iter_mut().zip(&shifts.shifts);
                for (difference, shift) in asked.filter(|_| length >= shifts.shortest) {
                    let Some(shift) = shift else { continue };
                    let shifted = base.shifted(shift, &shifts.sees);
                    let there = shifted.as_ref().map_or(I::Value::zero(), |shifted| {
                        // Its own strategies may not be able to make it.
                        if !shifted.path.pdf().is_regular() {
                            let stretch = PathDensity::new(shifted.jacobian) / base.pdf();
                            return self.integrand_at(&shifted.path).times(stretch.value());
                        }
                        let value = self.of(&shifted.path);
                        if value.is_zero() { value } else { value.times(shifted.rescaling(base)) }
                    });
                    if there.is_zero() && alone.is_zero() {
                        continue;
                    }
                    let finds =
                        |k: &usize| *k == way || shifts.finds(base, vertices(ways[*k]), alone);
                    let used: Vec<_> = (0..ways.len()).filter(finds).collect();
                    let number = used.iter().filter(|k| **k < way).count();
                    let ours: Vec<_> = used.iter().map(|k| ours[*k]).collect();
                    let pair = shifted.as_ref().map(|shifted| {
                        let theirs = techniques(&walk.as_shifted(shift)).into_iter().zip(&ways);
                        let theirs = theirs.filter(|(_, steps)| {
                            shifts.finds(&shifted.path, vertices(steps), there)
                        });
                        (shifted, theirs.map(|(path, _)| path).collect::<Vec<_>>())
                    });
                    let pair = pair.as_ref().map(|(shifted, theirs)| (*shifted, &theirs[..]));
                    let weight = base.weight_with(heuristic, (&ours, number), pair);
                    *difference = difference.plus(there.times(weight)).plus(alone.times(-weight));
                }
            }
        }
        differences
    }
}

impl<M, F, const N: usize> Shifts<M, F, N> {
    /// Whether the steps of a walk can have found all but the last `steps` vertices of a path that carries `value`.
    fn finds<V, S, T>(&self, path: &RandomSequence<'_, V, S>, steps: usize, value: T) -> bool
    where
        V: Vertex,
        S: Strategy<V>,
        T: Value<V::Real>,
        F: Fn(&V, &V) -> bool,
    {
        let edges = path.len().saturating_sub(steps + 1);
        !value.is_zero() || (0..edges).all(|i| path.sees_next(i, &self.sees))
    }
}
