//! Distributions with atoms: points that lie on one of a few single points with positive probability, and anywhere else
//! by a density.
//!
//! A body that returns [`Mixed`] says on each way through it which of both it has drawn:
//!
//! ```
//! use aether_core::mixed::Parts;
//! use aether_core::prelude::*;
//!
//! /// Free flight that ends at a wall, if it gets there.
//! #[sampler(extinction in 0.0..=1e3, wall in 0.0..=1e3)]
//! fn flight(u: [Uniform; 1], extinction: f64, wall: f64) -> Mixed {
//!     let t = -(-u[0]).ln_1p() / extinction;
//!     if t < wall { Mixed::Continuous(t) } else { Mixed::Atom(0, wall) }
//! }
//!
//! let flight = flight(2.0, 3.0)?;
//! let (near, far) = (flight.sample([0.5]), flight.sample([0.999]));
//! assert_eq!(far.value(), Mixed::Atom(0, 3.0));
//! // The density of the continuous part, and the probability of the atom.
//! assert!((near.pdf().value() - 2.0 * (-2.0 * near.point()).exp()).abs() < 1e-15);
//! assert!((flight.pdf(&far).value() - (-6.0f64).exp()).abs() < 1e-18);
//! assert_eq!(flight.probability(0), flight.pdf(&Mixed::Atom(0, 3.0)).value());
//! # Ok::<(), aether_core::DomainError>(())
//! ```
//!
//! Maps of the space follow as they follow any sampler, by [`Sampler::then`]: see [`Then`].
//!
//! The probability is derived: the measure of the uniforms that lead to the atom. Two such random variables that share
//! atoms are weighted against each other like any others, since what their `pdf` says of a point is either a density of both
//! or a probability of both.

mod then;

pub use then::{Followed, Then};

use core::fmt;
use core::marker::PhantomData;

use crate::density::{Density, Measure};
use crate::point::Point;
use crate::real::{Real, Scalar};
use crate::sampler::{PdfOf, Sampler};

/// A point of the space `P` by a distribution with atoms.
///
/// Whether it lies on an atom is part of the value and never found by comparing coordinates: a point of the
/// continuous part that happens to lie at the place of an atom is not on it. Atoms are told apart by their numbers alone.
/// Who combines random variables gives the same number to the same point, and different points different ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mixed<P = f64> {
    /// A point of the continuous part, which has a density.
    Continuous(P),
    /// An atom by its number, and where it lies; it has a probability.
    Atom(usize, P),
}

impl<P: Copy> Mixed<P> {
    /// Where it lies, be it on an atom or not.
    #[inline(always)]
    pub fn point(&self) -> P {
        let (Mixed::Continuous(x) | Mixed::Atom(_, x)) = self;
        *x
    }

    /// The number of the atom that it lies on.
    #[inline(always)]
    pub fn atom(&self) -> Option<usize> {
        match self {
            Mixed::Continuous(_) => None,
            Mixed::Atom(number, _) => Some(*number),
        }
    }
}

/// The measure `M` of a space together with counting measure on atoms: a density with respect to it is one with respect to
/// `M` off the atoms and a probability on them.
///
/// It is a measure of its own, so that such a density does not add to one without atoms, which would make a probability of
/// the latter:
///
/// ```compile_fail
/// use aether_core::mixed::WithAtoms;
/// use aether_core::{Density, Length};
/// let wrong = Density::<WithAtoms<Length>>::new(1.0) + Density::<Length>::new(1.0);
/// ```
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct WithAtoms<M>(PhantomData<M>);

impl<M: Measure> Measure for WithAtoms<M> {
    const NAME: &'static str = "unit of a measure with atoms";
}

impl<M: Measure> fmt::Debug for WithAtoms<M> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} with atoms", M::NAME)
    }
}

/// A point with or without an atom; densities are with respect to [`WithAtoms`].
impl<R: Real, P: Point<R>> Point<R> for Mixed<P> {
    type Measure = WithAtoms<P::Measure>;
    type Coordinates = P::Coordinates;
    const DIMENSION: usize = P::DIMENSION;
    #[inline(always)]
    fn coordinates(&self) -> P::Coordinates {
        self.point().coordinates()
    }
}

/// The two parts of a random variable with atoms. `#[sampler]` implements it where a body returns [`Mixed`].
pub trait Parts<R: Scalar>: Sampler<R, Point = Mixed<Self::Place>> {
    /// The space without its atoms.
    type Place: Point<R>;
    /// The continuous part as a random variable of its own.
    type Continuous: Sampler<R, Uniforms = Self::Uniforms, Point = Self::Place>;
    /// The numbers of the atoms that there may be, in order.
    const ATOMS: &'static [usize];

    /// The continuous part. It is defective: it has no sample for the uniforms that lead to an atom, and its density integrates
    /// to what the atoms leave of one.
    fn continuous(&self) -> Self::Continuous;

    /// The atom that uniforms lead to, and where it lies; `None` if they lead to none.
    fn atom(&self, u: Self::Uniforms) -> Option<(usize, Self::Place)>;

    /// Where an atom lies; `None` if there is none of this number with these parameters.
    fn place(&self, number: usize) -> Option<Self::Place>;

    /// The probability of an atom; zero if there is none of this number.
    fn probability(&self, number: usize) -> R;

    /// The logarithm of the probability of an atom, also where that is too small for the number type.
    fn log_probability(&self, number: usize) -> R;
}

/// [`Sampler::forward`] by the parts.
#[doc(hidden)]
#[inline(always)]
pub fn forward<R: Scalar, S: Parts<R>>(sampler: &S, u: S::Uniforms) -> (Mixed<S::Place>, bool) {
    match sampler.atom(u) {
        Some((number, place)) => (Mixed::Atom(number, place), true),
        None => {
            let (x, valid) = sampler.continuous().forward(u);
            (Mixed::Continuous(x), valid)
        }
    }
}

/// A density of the sampler by `density` of the continuous part.
#[doc(hidden)]
#[inline(always)]
pub fn pdf_by<R: Scalar, S: Parts<R>>(
    sampler: &S,
    x: &Mixed<S::Place>,
    density: impl FnOnce(&S::Continuous, &S::Place) -> PdfOf<S::Continuous, R>,
) -> PdfOf<S, R> {
    Density::new(match x {
        Mixed::Continuous(x) => density(&sampler.continuous(), x).value(),
        Mixed::Atom(number, _) => sampler.probability(*number),
    })
}

/// [`Sampler::log_pdf`] by the parts.
#[doc(hidden)]
#[inline]
pub fn log_pdf<R: Scalar, S: Parts<R>>(sampler: &S, x: &Mixed<S::Place>) -> R {
    match x {
        Mixed::Continuous(x) => sampler.continuous().log_pdf(x),
        Mixed::Atom(number, _) => sampler.log_probability(*number),
    }
}

/// [`Sampler::forward_with_pdf`] by the parts.
#[doc(hidden)]
#[inline(always)]
pub fn forward_with_pdf<R: Scalar, S: Parts<R>>(
    sampler: &S,
    u: S::Uniforms,
) -> (Mixed<S::Place>, bool, PdfOf<S, R>) {
    match sampler.atom(u) {
        Some((number, place)) => {
            (Mixed::Atom(number, place), true, Density::new(sampler.probability(number)))
        }
        None => {
            let (x, valid, p) = sampler.continuous().forward_with_pdf(u);
            (Mixed::Continuous(x), valid, Density::new(p.value()))
        }
    }
}

/// [`Sampler::preimages`] by the parts: those of the continuous part. A whole set of uniforms leads to an atom, and none of
/// them is named.
#[doc(hidden)]
pub fn preimages<R: Scalar, S: Parts<R>>(
    sampler: &S,
    x: &Mixed<S::Place>,
    visit: impl FnMut(S::Uniforms, bool),
) {
    if let Mixed::Continuous(x) = x {
        sampler.continuous().preimages(x, visit);
    }
}
