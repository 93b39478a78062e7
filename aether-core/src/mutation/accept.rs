//! Whether a chain goes on to a proposal.

use crate::mutation::{Mutation, conditional_pdf};
use crate::path_density::PathDensity;
use crate::real::Real;
use crate::sequence::RandomSequence;
use crate::strategy::{Strategy, Vertex};

/// A path with the value of the target function there, which the chain is to be distributed as.
#[derive(Clone, Copy, Debug)]
pub struct Rated<'a, V: Vertex, S> {
    /// The path.
    pub path: RandomSequence<'a, V, S>,
    /// The target function, up to a constant: the luminance of the integrand, say.
    pub target: PathDensity<V::Real>,
}

impl<'a, V: Vertex, S> Rated<'a, V, S> {
    /// A path with the value of the target function. Negative values and NaN count as zero; so do
    /// infinite ones, because a pole has no mass.
    pub fn new(path: RandomSequence<'a, V, S>, target: impl Into<PathDensity<V::Real>>) -> Self {
        let target = target.into();
        let target = if target.is_infinite() { PathDensity::ZERO } else { target };
        Rated { path, target }
    }
}

/// The probability of going on from the current path to a proposal that `mutation` has made of it,
/// min(1, f(y) T(x | y) / (f(x) T(y | x))) with y for the proposal (Metropolis and Hastings; Aether
/// 2017, Eq. 3). Then f(x) T(y | x) a(x, y) is symmetric in x and y: detailed balance, so that the
/// chain keeps the distribution f.
///
/// The quotient is formed of numbers with a wide exponent. The probability is zero if f is zero at
/// the proposal, if there is no way back, or if a density has a pole; it is one if f is zero at the
/// current path (a chain that was begun outside the support) and the proposal is a good one. Where f
/// is zero at the proposal no density is evaluated.
///
/// For several mutations, see [`Mutations`](crate::mutation::Mutations).
pub fn accept_probability<'a, V, S, M>(
    mutation: &M,
    current: &Rated<'a, V, S>,
    proposal: &Rated<'a, V, S>,
) -> V::Real
where
    V: Vertex,
    S: Strategy<V>,
    M: Mutation<V, S> + ?Sized,
{
    if !proposal.target.is_regular() {
        return V::Real::ZERO;
    }
    let there = conditional_pdf(mutation, &current.path, &proposal.path);
    if !there.is_regular() {
        return V::Real::ZERO;
    }
    let back = conditional_pdf(mutation, &proposal.path, &current.path);
    if !back.is_regular() {
        return V::Real::ZERO;
    }
    if !current.target.is_regular() {
        return V::Real::ONE;
    }
    ((proposal.target * back) / (current.target * there)).value().min(V::Real::ONE)
}
