//! A sampler without its types: the checks are compiled once, and not again for each sampler.

use core::fmt;
use core::marker::PhantomData;

use super::space::{Kind, Space};
use crate::point::Point;
use crate::real::Scalar;
use crate::sampler::{Sampler, Uniforms};
use crate::uniform::{Pcg32, Sobol, draw_uniforms};

/// A sampler as it is asked with numbers in `f64`.
pub(super) trait Subject {
    /// How many uniforms a sample takes.
    fn uniforms(&self) -> usize;
    /// Dimension of the space of the samples.
    fn dimension(&self) -> usize;
    /// How that space lies in its coordinates.
    fn kind(&self) -> Kind;
    /// Whether samples may be on atoms.
    fn has_atoms(&self) -> bool;
    /// Rounding unit of the sampler's numbers.
    fn epsilon(&self) -> f64;
    /// Uniforms rounded to the sampler's numbers and kept below one.
    fn rounded(&self, u: &[f64]) -> Vec<f64>;
    /// Uniforms at random.
    fn draw(&self, source: &mut Pcg32) -> Vec<f64>;
    /// Uniforms of a stratified sequence.
    fn draw_stratified(&self, source: &mut Sobol) -> Vec<f64>;
    /// The sample of rounded uniforms, if there is one.
    fn forward(&self, u: &[f64]) -> Option<AnySpot<'_>>;
    /// The density of that sample, as the sample tells it.
    fn own_density(&self, u: &[f64]) -> f64;
}

/// A point of the sampler's space, or one that has its type.
pub(super) trait Spot<'a>: fmt::Debug {
    /// Its coordinates.
    fn coordinates(&self) -> Vec<f64>;
    /// The point with these coordinates that is otherwise like this one.
    fn moved_to(&self, coordinates: &[f64]) -> AnySpot<'a>;
    /// A point at the same place of another manifold, if points have an identity.
    fn elsewhere(&self) -> Option<AnySpot<'a>>;
    /// The number of the atom that it is on.
    fn atom(&self) -> Option<usize>;
    /// The atom with this number at the same place, if points may be on atoms.
    fn on_atom(&self, number: usize) -> Option<AnySpot<'a>>;
    /// The sampler's density there.
    fn pdf(&self) -> f64;
    /// All its preimages.
    fn preimages(&self) -> Vec<Vec<f64>>;
}

/// A point of whatever type.
pub(super) type AnySpot<'a> = Box<dyn Spot<'a> + 'a>;

/// A sampler whose type is to be forgotten.
pub(super) struct Typed<'a, S, R>(&'a S, PhantomData<R>);

/// A point together with the sampler that is asked about it.
struct At<'a, S: Sampler<R>, R: Scalar>(&'a S, S::Point);

impl<'a, S: Sampler<R>, R: Scalar> Typed<'a, S, R>
where
    S::Point: Space<R>,
{
    pub(super) fn new(sampler: &'a S) -> Self {
        Typed(sampler, PhantomData)
    }

    /// A point, to be asked about.
    pub(super) fn spot(&self, point: S::Point) -> AnySpot<'a> {
        Box::new(At::<S, R>(self.0, point))
    }

    fn array(u: &[f64]) -> S::Uniforms {
        let below_one = R::ONE - R::EPSILON * R::of(0.5);
        S::Uniforms::from_fn(|i| R::of(u[i]).max(R::ZERO).min(below_one))
    }
}

fn numbers<R: Scalar>(values: &[R]) -> Vec<f64> {
    values.iter().map(|value| value.to_f64()).collect()
}

impl<S: Sampler<R>, R: Scalar> Subject for Typed<'_, S, R>
where
    S::Point: Space<R>,
{
    fn uniforms(&self) -> usize {
        S::Uniforms::COUNT
    }
    fn dimension(&self) -> usize {
        <S::Point as Point<R>>::DIMENSION
    }
    fn kind(&self) -> Kind {
        <S::Point as Space<R>>::KIND
    }
    fn has_atoms(&self) -> bool {
        <S::Point as Space<R>>::ATOMS
    }
    fn epsilon(&self) -> f64 {
        R::EPSILON.to_f64()
    }
    fn rounded(&self, u: &[f64]) -> Vec<f64> {
        numbers(Self::array(u).as_ref())
    }
    fn draw(&self, source: &mut Pcg32) -> Vec<f64> {
        numbers(draw_uniforms::<R, S::Uniforms>(source).as_ref())
    }
    fn draw_stratified(&self, source: &mut Sobol) -> Vec<f64> {
        numbers(draw_uniforms::<R, S::Uniforms>(source).as_ref())
    }
    fn forward(&self, u: &[f64]) -> Option<AnySpot<'_>> {
        let (point, valid) = self.0.forward(Self::array(u));
        valid.then(|| self.spot(point))
    }
    fn own_density(&self, u: &[f64]) -> f64 {
        self.0.sample(Self::array(u)).pdf().value().to_f64()
    }
}

impl<S: Sampler<R>, R: Scalar> fmt::Debug for At<'_, S, R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.1.fmt(f)
    }
}

impl<'a, S: Sampler<R>, R: Scalar> Spot<'a> for At<'a, S, R>
where
    S::Point: Space<R>,
{
    fn coordinates(&self) -> Vec<f64> {
        numbers(self.1.coordinates().as_ref())
    }
    fn moved_to(&self, coordinates: &[f64]) -> AnySpot<'a> {
        Box::new(At::<S, R>(self.0, self.1.moved_to(coordinates)))
    }
    fn elsewhere(&self) -> Option<AnySpot<'a>> {
        let point = self.1.elsewhere()?;
        Some(Box::new(At::<S, R>(self.0, point)))
    }
    fn atom(&self) -> Option<usize> {
        Space::atom(&self.1)
    }
    fn on_atom(&self, number: usize) -> Option<AnySpot<'a>> {
        let point = self.1.on_atom(number)?;
        Some(Box::new(At::<S, R>(self.0, point)))
    }
    fn pdf(&self) -> f64 {
        self.0.pdf(&self.1).value().to_f64()
    }
    fn preimages(&self) -> Vec<Vec<f64>> {
        let mut found = Vec::new();
        self.0.preimages(&self.1, |u, valid| {
            if valid {
                found.push(numbers(u.as_ref()));
            }
        });
        found
    }
}
