//! Samplers, with and without atoms, and the maps that come after them.

use super::{Mixed, Parts, forward, forward_with_pdf, log_pdf, pdf_by, preimages};
use crate::map::{Map, Then as Composition};
use crate::point::Point;
use crate::real::{Real, Scalar};
use crate::sampler::{Errors, PdfOf, Sampler};

/// A sampler of points `P` that maps of the space `X` may follow. It says what [`Sampler::then`] makes of them: of a
/// sampler without atoms (`P` is `X`) a [`Then`](crate::Then), of one with atoms (`P` is [`Mixed<X>`](Mixed)) a
/// [`mixed::Then`](Then).
///
/// Nobody else implements it: a sampler has it by its points.
#[diagnostic::on_unimplemented(
    message = "the map takes points of `{X}`, but the sampler `{Self}` has points of `{P}`",
    label = "no map of `{X}` can follow this sampler",
    note = "a map follows a sampler of the space that it maps from, or one with atoms in it (`Mixed<{X}>`)"
)]
pub trait Followed<R: Real, P, X>: Sampler<R> {
    /// The random variable `map(self)`.
    type Then<M: Map<R, Source = X>>: Sampler<R, Uniforms = Self::Uniforms>;

    /// What [`Sampler::then`] makes.
    fn followed_by<M: Map<R, Source = X>>(self, map: M) -> Self::Then<M>;
}

impl<R: Real, X: Point<R>, S: Sampler<R, Point = X>> Followed<R, X, X> for S {
    type Then<M: Map<R, Source = X>> = Composition<S, M>;

    #[inline(always)]
    fn followed_by<M: Map<R, Source = X>>(self, map: M) -> Composition<S, M> {
        Composition::new(self, map)
    }
}

impl<R: Scalar, X: Point<R>, S: Parts<R, Place = X>> Followed<R, Mixed<X>, X> for S {
    type Then<M: Map<R, Source = X>> = Then<S, M>;

    #[inline(always)]
    fn followed_by<M: Map<R, Source = X>>(self, map: M) -> Then<S, M> {
        Then { first: self, second: map }
    }
}

/// A sampler with atoms, and a map of the space that they lie in. Made by [`Sampler::then`].
///
/// An atom goes where the map leads from its place, with its number and its probability: no change of measure, since a
/// probability has none. The continuous part is that of a composition without atoms. If the place of an atom has no image,
/// the atom is gone: its uniforms have no sample, and its number has probability zero.
///
/// ```
/// use aether_core::mixed::Parts;
/// use aether_core::prelude::*;
///
/// /// Free flight that ends at a wall, if it gets there.
/// #[sampler(wall in 0.0..=1e3)]
/// fn flight(u: [Uniform; 1], wall: f64) -> Mixed {
///     let t = -(-u[0]).ln_1p();
///     if t < wall { Mixed::Continuous(t) } else { Mixed::Atom(0, wall) }
/// }
///
/// /// The point of a ray at a distance.
/// #[map]
/// fn along(t: f64, from: f64, slope: f64) -> f64 {
///     from + slope * t
/// }
///
/// let heights = flight(3.0)?.then(along(10.0, -2.0));
/// let wall = heights.sample([0.999]);
/// assert_eq!(wall.value(), Mixed::Atom(0, 4.0));
/// assert!((wall.pdf().value() - (-3.0f64).exp()).abs() < 1e-16);
/// // The density of the continuous part is per height, not per distance.
/// assert!((heights.pdf(&Mixed::Continuous(8.0)).value() - 0.5 * (-1.0f64).exp()).abs() < 1e-15);
/// assert_eq!(heights.place(0), Some(4.0));
/// # Ok::<(), aether_core::DomainError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Then<S, M> {
    first: S,
    second: M,
}

impl<R: Scalar, S: Parts<R>, M: Map<R, Source = S::Place>> Parts<R> for Then<S, M> {
    type Place = M::Target;
    type Continuous = Composition<S::Continuous, M>;
    const ATOMS: &'static [usize] = S::ATOMS;

    #[inline(always)]
    fn continuous(&self) -> Self::Continuous {
        Composition::new(self.first.continuous(), self.second)
    }

    /// `None` also where the map has no image of the place of the atom: the continuous part has no sample there either.
    #[inline(always)]
    fn atom(&self, u: Self::Uniforms) -> Option<(usize, M::Target)> {
        let (number, place) = self.first.atom(u)?;
        image(&self.second, &place).map(|place| (number, place))
    }

    #[inline]
    fn place(&self, number: usize) -> Option<M::Target> {
        image(&self.second, &self.first.place(number)?)
    }

    #[inline]
    fn probability(&self, number: usize) -> R {
        self.place(number).map_or(R::ZERO, |_| self.first.probability(number))
    }

    #[inline]
    fn log_probability(&self, number: usize) -> R {
        self.place(number).map_or(-R::INFINITY, |_| self.first.log_probability(number))
    }
}

/// The image of `x`, if there is one.
#[inline(always)]
fn image<R: Scalar, M: Map<R>>(map: &M, x: &M::Source) -> Option<M::Target> {
    let (y, valid) = map.forward(x);
    valid.then_some(y)
}

impl<R: Scalar, S: Parts<R>, M: Map<R, Source = S::Place>> Sampler<R> for Then<S, M> {
    type Uniforms = S::Uniforms;
    type Point = Mixed<M::Target>;

    #[inline(always)]
    fn forward(&self, u: S::Uniforms) -> (Self::Point, bool) {
        forward(self, u)
    }

    #[inline(always)]
    fn pdf(&self, x: &Self::Point) -> PdfOf<Self, R> {
        pdf_by(self, x, |part, x| part.pdf(x))
    }

    #[inline(always)]
    fn pdf_as_is(&self, x: &Self::Point) -> PdfOf<Self, R> {
        pdf_by(self, x, |part, x| part.pdf_as_is(x))
    }

    #[inline]
    fn pdf_near(&self, x: &Self::Point, errors: Errors<'_, Self::Point, R>) -> PdfOf<Self, R> {
        pdf_by(self, x, |part, x| part.pdf_near(x, errors))
    }

    #[inline(always)]
    fn pdf_of_uniforms(&self, u: S::Uniforms) -> PdfOf<Self, R> {
        forward_with_pdf(self, u).2
    }

    #[inline(always)]
    fn forward_with_pdf(&self, u: S::Uniforms) -> (Self::Point, bool, PdfOf<Self, R>) {
        forward_with_pdf(self, u)
    }

    #[inline]
    fn preimages(&self, x: &Self::Point, visit: impl FnMut(S::Uniforms, bool)) {
        preimages(self, x, visit);
    }

    #[inline]
    fn log_pdf(&self, x: &Self::Point) -> R {
        log_pdf(self, x)
    }
}
