//! The state of a Markov chain, and its steps.

use crate::mutation::draft::ACCEPTANCE;
use crate::mutation::{Mutation, Rated, accept_probability, propose};
use crate::path_density::PathDensity;
use crate::real::Real;
use crate::sequence::{Arena, RandomSequence, Snapshot};
use crate::strategy::{Strategy, Vertex};
use crate::uniform::UniformSource;

/// Where a Markov chain is: a path, the value of the target function there, and what the path
/// contributes to the result (a pixel and a colour, say), in whatever form the user likes.
///
/// The target function maps a path to a pair: its value, which the chain is distributed as, and the
/// contribution. It sees vertices and Dirac factors like any integrand, and must not depend on the
/// strategies that made the path. [`Estimator::integrand_at`](crate::Estimator::integrand_at) serves.
#[derive(Clone, Debug)]
pub struct MarkovChainState<V: Vertex, S, C> {
    path: Snapshot<V, S>,
    target: PathDensity<V::Real>,
    contribution: C,
    steps: u64,
}

/// What happened in a step of a chain.
#[derive(Clone, Copy, Debug)]
pub struct Transition<R, C> {
    /// The contribution of the path before.
    pub current: C,
    /// The contribution of the proposal, accepted or not; `None` if none was made.
    pub proposal: Option<C>,
    /// The probability with which the proposal is accepted.
    pub probability: R,
    /// Whether it was.
    pub accepted: bool,
}

impl<R: Real, C> Transition<R, C> {
    /// The contributions with the probabilities that their paths come next. They sum to one; to
    /// count all of them instead of only the path that comes next makes for less variance (Veach
    /// and Guibas 1997).
    pub fn weighted(self) -> impl Iterator<Item = (C, R)> {
        let stay = R::ONE - self.probability;
        let probability = self.probability;
        core::iter::once((self.current, stay))
            .chain(self.proposal.map(|contribution| (contribution, probability)))
    }
}

impl<V: Vertex, S: Strategy<V>, C: Clone> MarkovChainState<V, S, C> {
    /// A chain that begins at a path.
    ///
    /// If the target is zero there, which it is for a path that is not complete, the chain moves on
    /// with the first proposal for which it is not.
    pub fn new<T: Into<PathDensity<V::Real>>>(
        path: &RandomSequence<'_, V, S>,
        target: &impl Fn(&RandomSequence<'_, V, S>) -> (T, C),
    ) -> Self {
        let (value, contribution) = target(path);
        let target = Rated::new(*path, value).target;
        MarkovChainState { path: Snapshot::of(path), target, contribution, steps: 0 }
    }

    /// A chain that goes on where another was after so many steps: at its path, where the target function and the
    /// contribution have these values. Its steps are then those of the other, whatever strategies the path has: a
    /// mutation sees vertices and Dirac factors alone.
    pub fn resumed(
        path: Snapshot<V, S>,
        target: PathDensity<V::Real>,
        contribution: C,
        steps: u64,
    ) -> Self {
        MarkovChainState { path, target, contribution, steps }
    }

    /// The current path.
    pub fn path(&self) -> &Snapshot<V, S> {
        &self.path
    }

    /// The value of the target function at the current path.
    pub fn target(&self) -> PathDensity<V::Real> {
        self.target
    }

    /// What the current path contributes.
    pub fn contribution(&self) -> &C {
        &self.contribution
    }

    /// How many steps have been taken.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Makes a proposal, and goes there with the probability that keeps the distribution
    /// ([`accept_probability`]).
    ///
    /// `uniforms` is called with the number of the step and returns the source for it alone, such as
    /// `|step| Pcg32::new(seed, chain, step)`: so that no two steps draw the same numbers. The arena
    /// is cleared; any one will do, and once it is warm no heap is used.
    pub fn step<M, T, U>(
        &mut self,
        arena: &mut Arena<V, S>,
        mutation: &M,
        target: &impl Fn(&RandomSequence<'_, V, S>) -> (T, C),
        uniforms: impl FnOnce(u64) -> U,
    ) -> Transition<V::Real, C>
    where
        M: Mutation<V, S> + ?Sized,
        T: Into<PathDensity<V::Real>>,
        U: UniformSource<V::Real>,
    {
        arena.clear();
        let mut uniforms = uniforms(self.steps);
        self.steps += 1;
        let current = Rated { path: arena.restore(&self.path), target: self.target };
        let mut transition = Transition {
            current: self.contribution.clone(),
            proposal: None,
            probability: V::Real::ZERO,
            accepted: false,
        };
        let Some(path) = propose(mutation, &current.path, &mut uniforms) else {
            return transition;
        };
        let (value, contribution) = target(&path);
        let proposal = Rated::new(path, value);
        transition.proposal = Some(contribution.clone());
        transition.probability = accept_probability(mutation, &current, &proposal);
        uniforms.start(ACCEPTANCE);
        transition.accepted = uniforms.next() < transition.probability;
        if transition.accepted {
            self.path.store(&path);
            self.target = proposal.target;
            self.contribution = contribution;
        }
        transition
    }
}
