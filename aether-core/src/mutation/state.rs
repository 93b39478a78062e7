//! The state of a Markov chain, and its steps.

use crate::discrete::Discrete;
use crate::mutation::accept::acceptance;
use crate::mutation::decisions::Weights;
use crate::mutation::draft::ACCEPTANCE;
use crate::mutation::{Mutation, Mutations, Rated, accept_probability, conditional_pdf, propose};
use crate::path_density::PathDensity;
use crate::real::{Real, Scalar};
use crate::sequence::{Arena, RandomSequence, Snapshot};
use crate::strategy::{Strategy, Vertex};
use crate::uniform::UniformSource;

/// Where a Markov chain is: a path, the value of the target function there, and what the path
/// contributes to the result (a pixel and a colour, say), in whatever form the user likes.
///
/// The target function maps a path to a pair: its value, which the chain is distributed as, and the
/// contribution. It sees vertices and Dirac factors like any integrand, and must not depend on the
/// strategies that made the path. [`Estimator::scaled_integrand_at`](crate::Estimator::scaled_integrand_at) serves.
#[derive(Clone, Debug)]
pub struct MarkovChainState<V: Vertex, S, C> {
    path: Snapshot<V, S>,
    target: PathDensity<V::Real>,
    contribution: C,
    steps: u64,
    /// The weights of several mutations at the path, none until they are known, and room for those at a proposal.
    weights: [Vec<V::Real>; 2],
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
    /// Which of several mutations was selected ([`MarkovChainState::step_among`]).
    pub selected: Option<usize>,
}

impl<R: Scalar, C> Transition<R, C> {
    /// The contributions with the probabilities that their paths come next, of those that may. They sum to one; to
    /// count all of them instead of only the path that comes next makes for less variance (Veach
    /// and Guibas 1997).
    ///
    /// A proposal at which the target function is zero never comes next: what it contributes may be no number, as a colour
    /// over its brightness is.
    pub fn weighted(self) -> impl Iterator<Item = (C, R)> {
        let stay = R::ONE - self.probability;
        let probability = self.probability;
        core::iter::once((self.current, stay))
            .chain(self.proposal.map(|contribution| (contribution, probability)))
            .filter(|(_, probability)| *probability > R::ZERO)
    }
}

impl<V: Vertex, S: Strategy<V>, C: Clone> MarkovChainState<V, S, C> {
    /// A chain that begins at a path.
    ///
    /// If the target is zero there, the chain moves on with the first proposal for which it is not. It counts as zero for a
    /// path that has no [`Snapshot::of`], whose place the empty path takes: one that is not complete, or has been merged.
    pub fn new<T: Into<PathDensity<V::Real>>>(
        path: &RandomSequence<'_, V, S>,
        target: &impl Fn(&RandomSequence<'_, V, S>) -> (T, C),
    ) -> Self {
        let (value, contribution) = target(path);
        let start = Snapshot::of(path);
        let is_kept = path.is_complete() && start.len() == path.len();
        let target = if is_kept { Rated::new(*path, value).target } else { PathDensity::ZERO };
        Self::resumed(start, target, contribution, 0)
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
        let weights = [Vec::new(), Vec::new()];
        MarkovChainState { path, target, contribution, steps, weights }
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
        let (current, mut uniforms) = self.begin(arena, uniforms);
        let mut transition = self.stay();
        let Some((proposal, contribution)) = rated(mutation, &current, target, &mut uniforms)
        else {
            return transition;
        };
        transition.proposal = Some(contribution.clone());
        transition.probability = accept_probability(mutation, &current, &proposal);
        uniforms.start(ACCEPTANCE);
        transition.accepted = uniforms.next() < transition.probability;
        if transition.accepted {
            self.go_to(&proposal, contribution);
            self.weights[0].clear();
        }
        transition
    }

    /// Selects one of several mutations by their weights, and makes a step with it that is accepted with what was selected
    /// alone ([`Mutations::only`]). The weights are found once for each path.
    ///
    /// The mutations have to be the same, and to have the same weights, in all steps of a chain.
    pub fn step_among<T, U>(
        &mut self,
        arena: &mut Arena<V, S>,
        mutations: &Mutations<'_, V, S>,
        target: &impl Fn(&RandomSequence<'_, V, S>) -> (T, C),
        uniforms: impl FnOnce(u64) -> U,
    ) -> Transition<V::Real, C>
    where
        T: Into<PathDensity<V::Real>>,
        U: UniformSource<V::Real>,
    {
        let (current, mut uniforms) = self.begin(arena, uniforms);
        let mut transition = self.stay();
        if self.weights[0].is_empty() {
            mutations.weigh(&current.path, &mut self.weights[0]);
        }
        uniforms.start(ACCEPTANCE);
        let [selecting, accepting] = [uniforms.next(), uniforms.next()];
        let here = probabilities(&self.weights[0]).map(|here| here.sample(selecting));
        let Some(selected) = here else { return transition };
        let (i, mutation) = (selected.item, mutations.0[selected.item]);
        transition.selected = Some(i);
        let Some((proposal, contribution)) = rated(mutation, &current, target, &mut uniforms)
        else {
            return transition;
        };
        transition.proposal = Some(contribution.clone());
        // Known once there is a way back to be weighed.
        let weights = &mut self.weights[1];
        weights.clear();
        transition.probability = acceptance(
            [current.target, proposal.target],
            || conditional_pdf(mutation, &current.path, &proposal.path) * selected.probability,
            || {
                mutations.weigh(&proposal.path, weights);
                let selected = probabilities(weights).and_then(|there| there.get(i));
                selected.filter(|back| back.probability > V::Real::ZERO).map_or(
                    PathDensity::ZERO,
                    |back| {
                        conditional_pdf(mutation, &proposal.path, &current.path) * back.probability
                    },
                )
            },
        );
        transition.accepted = accepting < transition.probability;
        if transition.accepted {
            self.go_to(&proposal, contribution);
            self.weights.swap(0, 1);
        }
        transition
    }

    /// The current path in an arena that it has for itself, and the numbers for the next step.
    fn begin<'a, U>(
        &mut self,
        arena: &'a mut Arena<V, S>,
        uniforms: impl FnOnce(u64) -> U,
    ) -> (Rated<'a, V, S>, U) {
        arena.clear();
        let uniforms = uniforms(self.steps);
        self.steps += 1;
        (Rated { path: arena.restore(&self.path), target: self.target }, uniforms)
    }

    /// What happens if no proposal is made.
    fn stay(&self) -> Transition<V::Real, C> {
        Transition {
            current: self.contribution.clone(),
            proposal: None,
            probability: V::Real::ZERO,
            accepted: false,
            selected: None,
        }
    }

    fn go_to(&mut self, proposal: &Rated<'_, V, S>, contribution: C) {
        self.path.store(&proposal.path);
        self.target = proposal.target;
        self.contribution = contribution;
    }
}

/// A proposal with the value of the target function there, and what it contributes.
fn rated<'a, V, S, M, T, C>(
    mutation: &M,
    current: &Rated<'a, V, S>,
    target: &impl Fn(&RandomSequence<'_, V, S>) -> (T, C),
    uniforms: &mut impl UniformSource<V::Real>,
) -> Option<(Rated<'a, V, S>, C)>
where
    V: Vertex,
    S: Strategy<V>,
    M: Mutation<V, S> + ?Sized,
    T: Into<PathDensity<V::Real>>,
{
    let path = propose(mutation, &current.path, uniforms)?;
    let (value, contribution) = target(&path);
    Some((Rated::new(path, value), contribution))
}

/// Which mutation is selected how often, by the weights of all.
fn probabilities<R: Scalar>(weights: &[R]) -> Option<Weights<impl Fn(usize) -> R + '_, R>> {
    Weights::new(weights.len(), |i| weights[i])
}
