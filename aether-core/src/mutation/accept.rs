//! Whether a chain goes on to a proposal.

use crate::mutation::{Mutation, conditional_pdf};
use crate::path_density::PathDensity;
use crate::real::Scalar;
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
/// current path (a chain that was begun outside the support), to which no way back is needed, and the
/// mutation makes the proposal. Where f is zero at the proposal no density is evaluated.
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
    acceptance(
        [current.target, proposal.target],
        || conditional_pdf(mutation, &current.path, &proposal.path),
        || conditional_pdf(mutation, &proposal.path, &current.path),
    )
}

/// The same of the values of the target function at both paths, and of the densities of going there and back.
pub(super) fn acceptance<R: Scalar>(
    [current, proposal]: [PathDensity<R>; 2],
    there: impl FnOnce() -> PathDensity<R>,
    back: impl FnOnce() -> PathDensity<R>,
) -> R {
    if !proposal.is_regular() {
        return R::ZERO;
    }
    let there = there();
    if !there.is_regular() {
        return R::ZERO;
    }
    if !current.is_regular() {
        return R::ONE;
    }
    let back = back();
    if !back.is_regular() {
        return R::ZERO;
    }
    ((proposal * back) / (current * there)).value().min(R::ONE)
}
