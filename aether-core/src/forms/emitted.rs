//! What the code emitted by `#[strategy]` calls.

use crate::discrete::Discrete;
use crate::map::Map;
use crate::real::{Real, Scalar};
use crate::sampler::Sampler;
use crate::strategy::{Recall, Vertex};
use crate::uniform::{UniformSource, draw_uniforms};

/// A sample of `sampler`; `None` if it has none for the uniforms drawn.
#[inline(always)]
pub fn draw<R: Scalar, S: Sampler<R>, U: UniformSource<R> + ?Sized>(
    sampler: &S,
    uniforms: &mut U,
) -> Option<S::Point> {
    let (point, valid) = sampler.forward(draw_uniforms::<R, S::Uniforms>(uniforms));
    valid.then_some(point)
}

/// The image of `x`, if there is one.
#[inline(always)]
pub fn mapped<R: Scalar, M: Map<R>>(map: &M, x: &M::Source) -> Option<M::Target> {
    let (y, valid) = map.forward(x);
    valid.then_some(y)
}

/// The locally constant value that `target` came from; `call` only names its type and is not called.
#[inline(always)]
pub fn recall<V: Recall<T>, T>(target: &V, call: impl FnOnce() -> Option<T>) -> Option<T> {
    let _ = call;
    target.recall()
}

/// Stands for a drawn point in a call that is never made.
///
/// # Panics
/// Always.
pub fn point_of<R: Real, S: Sampler<R>>(sampler: &S) -> S::Point {
    let _ = sampler;
    unreachable!("a locally constant call is not repeated")
}

/// Which outcome `target` came from, by the user's rule.
#[inline(always)]
pub fn identify<V>(target: &V, rule: impl Fn(&V) -> Option<usize>) -> Option<usize> {
    rule(target)
}

/// The probability of outcome `index`, zero if there is none.
#[inline(always)]
pub fn probability<R: Scalar, D: Discrete<R>>(distribution: &D, index: usize) -> R {
    distribution.get(index).map_or(R::ZERO, |choice| choice.probability)
}

/// The density of `sampler` at the point of `target`.
#[inline(always)]
pub fn density<V: Vertex, S: Sampler<V::Real, Point = V::Point>>(
    sampler: &S,
    target: &V,
) -> V::Real {
    sampler.pdf(&target.point()).value()
}

/// The density of `sampler` at the point of `target`, times a factor that depends on that point.
#[inline(always)]
pub fn density_times<V: Vertex, S: Sampler<V::Real, Point = V::Point>>(
    sampler: &S,
    target: &V,
    mut factor: impl FnMut(V::Point) -> V::Real,
) -> V::Real {
    let point = target.point();
    let p = sampler.pdf(&point).value();
    // The factor may be undefined outside the support.
    if p > V::Real::ZERO { product(p, factor(point)) } else { V::Real::ZERO }
}

/// The density of `map(sampler)` at the point of `target`, each preimage weighted with a factor that
/// depends on it: the sum over preimages w of p(w) factor(w) / J(w).
#[inline(always)]
pub fn density_through<V, S, M>(
    sampler: &S,
    map: &M,
    target: &V,
    mut factor: impl FnMut(S::Point) -> V::Real,
) -> V::Real
where
    V: Vertex,
    S: Sampler<V::Real>,
    M: Map<V::Real, Source = S::Point, Target = V::Point>,
{
    let mut sum = V::Real::ZERO;
    map.preimages(&target.point(), |w, valid| {
        if valid {
            let p = sampler.pdf(&w).value();
            // Where there is no density the map need not have a derivative.
            if p > V::Real::ZERO {
                sum += product(p / map.jacobian(&w), factor(w));
            }
        }
    });
    sum
}

/// The product of a density and a probability: zero if the probability is, even at a pole.
#[inline(always)]
fn product<R: Scalar>(density: R, probability: R) -> R {
    if probability > R::ZERO { density * probability } else { R::ZERO }
}
