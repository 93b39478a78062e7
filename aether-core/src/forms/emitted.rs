//! What the code emitted by `#[strategy]` calls.

use core::ops::Range;

use crate::discrete::{Choice, Discrete, FixedOutcomes};
use crate::map::{Map, by_way_of, other_preimages};
use crate::point::Includes;
use crate::real::{Real, Scalar};
use crate::sampler::Sampler;
use crate::sequence::PathView;
use crate::strategy::{Atoms, Drawn, Recall, Strategy, Vertex};
use crate::uniform::{UniformSource, draw_uniforms};

/// A sample of `sampler` with its density, told from the uniforms; `None` if it has none for these.
#[inline(always)]
pub fn draw_with_density<R: Scalar, S: Sampler<R>, U: UniformSource<R> + ?Sized>(
    sampler: &S,
    uniforms: &mut U,
) -> Option<(S::Point, Option<R>)> {
    let u = draw_uniforms::<R, S::Uniforms>(uniforms);
    let (point, valid, density) = sampler.forward_with_pdf(u);
    valid.then(|| (point, Some(density.value())))
}

/// The image of `x`, if there is one, and its density if that of `x`, a sample of `sampler`, is known. If
/// `weighed`, preimages count with different weights, and it is not known where there are several.
#[inline(always)]
pub fn mapped_with_density<R: Scalar, S: Sampler<R>, M: Map<R, Source = S::Point>>(
    sampler: &S,
    map: &M,
    x: &M::Source,
    density: Option<R>,
    weighed: bool,
) -> Option<(M::Target, Option<R>)> {
    let (y, valid) = map.forward(x);
    let mut density = density.map(|p| p / map.jacobian(x));
    let mut others = false;
    other_preimages(map, x, &y, |z, valid| {
        others = true;
        density = density.map(|sum| sum + by_way_of(sampler, map, (&z, &y), valid));
    });
    valid.then_some((y, density.filter(|_| !(weighed && others))))
}

/// The product of what is known of a density.
#[inline(always)]
pub fn own_times<R: Scalar>(own: Option<R>, factor: Option<R>) -> Option<R> {
    Some(product(own?, factor?))
}

/// Whether the rule tells of the vertex that it may have come from other outcomes than `index`; `None` if
/// it does not tell that it may have come from this one.
#[inline(always)]
pub fn several_identified<V, I: IntoIterator<Item = usize>>(
    vertex: &V,
    rule: impl Fn(&V) -> I,
    index: usize,
) -> Option<bool> {
    let (mut found, mut several) = (false, false);
    for other in identify(vertex, rule) {
        found |= other == index;
        several |= other != index;
    }
    found.then_some(several)
}

/// Whether more outcomes than one may lead anywhere.
#[inline(always)]
pub fn several<'d, R: Scalar, D: Discrete<R>>(
    distribution: &'d D,
    leads: impl Fn(D::Item<'d>) -> bool,
) -> bool {
    if distribution.len() > 2 {
        return true;
    }
    let mut count = 0;
    distribution.for_each(|item, _| count += usize::from(leads(item)));
    count > 1
}

/// The density by the way that was taken, and by the others if there are several.
#[inline(always)]
pub fn with_others<R: Scalar>(
    own: Option<R>,
    several: bool,
    others: impl FnOnce() -> R,
) -> Option<R> {
    own.map(|p| if several { p + others() } else { p })
}

/// The locally constant value that `target` came from; `call` only names its type and is not called.
#[inline(always)]
pub fn recall<V: Recall<T>, T>(target: &V, call: impl FnOnce() -> Option<T>) -> Option<T> {
    let _ = call;
    target.recall()
}

/// The same beside the value that the call returns now; `None` if either has none. For atoms, of which no ray is cast.
#[inline(always)]
pub fn recall_called<V: Recall<T>, T>(
    target: &V,
    call: impl FnOnce() -> Option<T>,
) -> Option<(T, T)> {
    Some((target.recall()?, call()?))
}

/// Stands for a drawn point in a call that is never made.
///
/// # Panics
/// Always.
pub fn point_of<R: Real, S: Sampler<R>>(sampler: &S) -> S::Point {
    let _ = sampler;
    unreachable!("a locally constant call is not repeated")
}

/// Which outcomes `target` may have come from, by the user's rule.
#[inline(always)]
pub fn identify<V, I: IntoIterator<Item = usize>>(
    target: &V,
    rule: impl Fn(&V) -> I,
) -> I::IntoIter {
    rule(target).into_iter()
}

/// The probability of outcome `index`, zero if there is none.
#[inline(always)]
pub fn probability<R: Scalar, D: Discrete<R>>(distribution: &D, index: usize) -> R {
    distribution.get(index).map_or(R::ZERO, |choice| choice.probability)
}

/// The outcomes of a choice whose probabilities are not known yet.
pub struct OutcomesOf<T> {
    count: usize,
    outcome: fn(usize) -> T,
}

/// The outcomes of a distribution; `make` only names its type and is not called.
#[inline(always)]
pub fn outcomes_of<R: Scalar, D: FixedOutcomes<R>>(
    make: impl FnOnce() -> D,
) -> OutcomesOf<D::Outcome> {
    let _ = make;
    OutcomesOf { count: D::COUNT, outcome: D::outcome }
}

impl<T> OutcomesOf<T> {
    /// The indices of all outcomes.
    #[inline(always)]
    pub fn indices(&self) -> Range<usize> {
        0..self.count
    }

    /// The outcome with this index, if there is one.
    #[inline(always)]
    pub fn outcome(&self, index: usize) -> Option<T> {
        (index < self.count).then(|| (self.outcome)(index))
    }
}

/// An outcome drawn from `distribution`: the choice, and what was chosen.
#[inline(always)]
pub fn outcome<'d, R: Scalar, D: FixedOutcomes<R>>(
    distribution: &'d D,
    u: R,
) -> (Choice<D::Item<'d>, R>, D::Outcome) {
    let choice = distribution.sample(u);
    let outcome = D::outcome(choice.index);
    (choice, outcome)
}

/// The vertex that another strategy yields for the same path. What is known of its density is that under
/// the other strategy alone.
#[inline(always)]
pub fn delegated<V: Vertex, S: Strategy<V>, U: UniformSource<V::Real> + ?Sized>(
    strategy: &S,
    path: PathView<'_, V>,
    uniforms: &mut U,
) -> Option<Drawn<V>> {
    const {
        assert!(
            S::VERTICES == 1,
            "a strategy that may yield several vertices with one draw makes no single vertex: it \
             cannot be delegated to"
        );
    }
    strategy.sample_limited(path, uniforms)
}

/// The probability of delegating times the density (or probability) under the other strategy.
#[inline(always)]
pub fn delegated_pdf<V: Vertex, S: Strategy<V>>(
    strategy: &S,
    path: &PathView<'_, V>,
    target: &V,
    probability: V::Real,
) -> V::Real {
    let value = strategy.pdf_limited(*path, target);
    product(value.of_kind(path.dirac()), probability)
}

/// Refuses to compile if two strategies, between which an unidentified choice decides, may yield
/// atoms of the same kind. They are not made.
#[inline(always)]
pub fn apart_from<V: Vertex, A: Strategy<V>, B: Strategy<V>>(
    a: impl FnOnce() -> A,
    b: impl FnOnce() -> B,
) {
    const {
        assert!(
            !A::ATOMS.overlaps(B::ATOMS),
            "two strategies that a choice decides between may yield atoms of the same kind, and \
             which of them it was cannot be told by comparing coordinates: add \
             `.identified_by(|vertex| ..)` to the `choose(..)`"
        );
    }
    let _ = (a, b);
}

/// Refuses to compile if a strategy may yield atoms of the same kind (a direction or a position) as
/// the body that delegates to it. It is not made.
#[inline(always)]
pub fn apart_from_atom<V: Vertex, S: Strategy<V>, const DIRECTION: bool>(
    strategy: impl FnOnce() -> S,
) {
    const {
        assert!(
            !S::ATOMS.overlaps(Atoms { position: !DIRECTION, direction: DIRECTION }),
            "a strategy that a choice delegates to may yield atoms of the same kind as another \
             outcome of the choice, and which of them it was cannot be told by comparing \
             coordinates: add `.identified_by(|vertex| ..)` to the `choose(..)`"
        );
    }
    let _ = strategy;
}

/// Two values that are to be compared if their type knows equality: `(&Alike(a, b)).alike()` with both traits below in
/// scope.
#[derive(Debug)]
pub struct Alike<'a, T>(pub &'a T, pub &'a T);

/// Values of types that know equality.
pub trait ByEquality {
    /// Whether they are equal.
    fn alike(&self) -> Option<bool>;
}

impl<T: PartialEq> ByEquality for Alike<'_, T> {
    #[inline(always)]
    fn alike(&self) -> Option<bool> {
        Some(self.0 == self.1)
    }
}

/// All others: method lookup comes here last.
pub trait Otherwise {
    /// It is not known whether they are equal.
    #[inline(always)]
    fn alike(&self) -> Option<bool> {
        None
    }
}

impl<T> Otherwise for &Alike<'_, T> {}

/// The density of `sampler` at the point of `target`, as it is: other outcomes of a choice may have made it.
#[inline(always)]
pub fn density<V, S>(sampler: &S, target: &V) -> V::Real
where
    V: Vertex<Point: Includes<S::Point>>,
    S: Sampler<V::Real>,
{
    let Some(x) = Includes::<S::Point>::part(&target.point()) else { return V::Real::ZERO };
    sampler.pdf_as_is(&x).value()
}

/// The density of `sampler` at the point of `target`, times a factor that depends on that point.
#[inline(always)]
pub fn density_times<V, S>(
    sampler: &S,
    target: &V,
    mut factor: impl FnMut(S::Point) -> V::Real,
) -> V::Real
where
    V: Vertex<Point: Includes<S::Point>>,
    S: Sampler<V::Real>,
{
    let Some(x) = Includes::<S::Point>::part(&target.point()) else { return V::Real::ZERO };
    let p = sampler.pdf_as_is(&x).value();
    // The factor may be undefined outside the support.
    if p > V::Real::ZERO { product(p, factor(x)) } else { V::Real::ZERO }
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
    V: Vertex<Point: Includes<M::Target>>,
    S: Sampler<V::Real>,
    M: Map<V::Real, Source = S::Point>,
{
    let mut sum = V::Real::ZERO;
    let Some(y) = Includes::<M::Target>::part(&target.point()) else { return sum };
    map.preimages(&y, |w, valid| {
        let p = by_way_of(sampler, map, (&w, &y), valid);
        if p > V::Real::ZERO {
            sum += product(p, factor(w));
        }
    });
    sum
}

/// The product of a density and a probability: zero if the probability is, even at a pole.
#[inline(always)]
fn product<R: Scalar>(density: R, probability: R) -> R {
    if probability > R::ZERO { density * probability } else { R::ZERO }
}
