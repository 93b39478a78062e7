//! Pairs of a path and what a shift makes of it (Kettunen et al. 2015; Aether 2017, section 7.5).

use core::fmt;

use crate::combine::Heuristic;
use crate::path_density::PathDensity;
use crate::real::Real;
use crate::sequence::RandomSequence;
use crate::strategy::{Strategy, Vertex};

/// What an invertible map of paths makes of a *base* path, in the same arena, and by how much it stretches
/// the space of paths there.
pub struct Shifted<'a, V: Vertex, S> {
    /// The shifted path.
    pub path: RandomSequence<'a, V, S>,
    /// |∂path/∂base|: measure of the shifted path per measure of the base path.
    pub jacobian: V::Real,
}

impl<V: Vertex, S> Clone for Shifted<'_, V, S> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<V: Vertex, S> Copy for Shifted<'_, V, S> {}

impl<V: Vertex, S> fmt::Debug for Shifted<'_, V, S>
where
    V::Real: fmt::Debug,
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Shifted({:?}, jacobian {:?})", self.path, self.jacobian)
    }
}

impl<'a, V: Vertex, S: Strategy<V>> Shifted<'a, V, S> {
    /// The density with which `technique` makes the shifted path, per measure of the base path.
    pub fn pdf_by(&self, technique: &RandomSequence<'a, V, S>) -> PathDensity<V::Real> {
        technique.pdf_of(&self.path) * self.jacobian
    }

    /// What f / p of the shifted path ([`Estimator::of`](crate::Estimator::of)) is to be multiplied by, so that
    /// it becomes an estimate from the base path: the integrand at the shifted path, brought to the measure
    /// of the base path, over the density of the base path.
    pub fn rescaling(&self, base: &RandomSequence<'a, V, S>) -> V::Real {
        (self.path.pdf() * self.jacobian).ratio(base.pdf())
    }
}

impl<'a, V: Vertex, S: Strategy<V>> RandomSequence<'a, V, S> {
    /// The weight of this path, a sample of `techniques[own]`, and of what a shift made of it, as one sample
    /// of their difference. The same pair could have been made by sampling the shifted path by one of
    /// `theirs` and shifting it back, with the density [`Shifted::pdf_by`]; a path that the shift does not
    /// reach or leave (`None`) has only its own techniques.
    ///
    /// Ratios of densities are those at this path, and equal those at the shifted one, because both
    /// sides are divided by the same Jacobian.
    pub fn weight_with<H: Heuristic<V::Real>>(
        &self,
        heuristic: &H,
        (techniques, own): (&[Self], usize),
        shifted: Option<(&Shifted<'a, V, S>, &[Self])>,
    ) -> V::Real {
        let mut ratios = core::mem::take(&mut *self.arena.ratios.borrow_mut());
        ratios.clear();
        let density = self.pdf();
        ratios.extend(techniques.iter().enumerate().map(|(i, technique)| {
            if i == own { V::Real::ONE } else { technique.pdf_of(self).ratio(density) }
        }));
        if let Some((shifted, theirs)) = shifted {
            ratios.extend(theirs.iter().map(|other| shifted.pdf_by(other).ratio(density)));
        }
        let weight = heuristic.weight(&ratios, own);
        *self.arena.ratios.borrow_mut() = ratios;
        weight
    }
}
