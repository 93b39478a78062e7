//! Several mutations.

use core::fmt;

use crate::discrete::Discrete;
use crate::mutation::decisions::Weights;
use crate::mutation::{Decisions, Draft, Mutation};
use crate::sequence::RandomSequence;
use crate::strategy::{Strategy, Vertex};

/// A mutation that consists in selecting one of several, with probabilities proportional to
/// [`Mutation::weight`] at the current path.
///
/// The selection is a choice like any other, so conditional densities and acceptance are those of
/// the mixture, averaged over all mutations that could have made the proposal: with T = Σ s_i T_i,
/// where s_i is the probability of selecting mutation i, detailed balance is that of one kernel T.
/// The alternative is to accept with what was selected alone ([`Mutations::only`]): then each i
/// satisfies f(x) s_i(x) T_i(y | x) a_i(x, y) = f(y) s_i(y) T_i(x | y) a_i(y, x), and so does the sum.
/// Averaging accepts at least as often, because Σ min(a_i, b_i) <= min(Σ a_i, Σ b_i); what was
/// selected alone costs less, and is what [`MarkovChainState::step_among`](crate::MarkovChainState::step_among) accepts with.
pub struct Mutations<'m, V: Vertex, S: Strategy<V>>(pub &'m [&'m dyn Mutation<V, S>]);

impl<V: Vertex, S: Strategy<V>> Clone for Mutations<'_, V, S> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<V: Vertex, S: Strategy<V>> Copy for Mutations<'_, V, S> {}

impl<V: Vertex, S: Strategy<V>> fmt::Debug for Mutations<'_, V, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Mutations({})", self.0.len())
    }
}

impl<'m, V: Vertex, S: Strategy<V>> Mutations<'m, V, S> {
    fn weights<'w>(
        &'w self,
        current: &'w RandomSequence<'_, V, S>,
    ) -> Option<Weights<impl Fn(usize) -> V::Real + 'w, V::Real>> {
        Weights::new(self.0.len(), |i| self.0[i].weight(current))
    }

    /// The weights of all mutations at a path, in the place of what `weights` held.
    pub(super) fn weigh(&self, current: &RandomSequence<'_, V, S>, weights: &mut Vec<V::Real>) {
        weights.clear();
        weights.extend(self.0.iter().map(|mutation| mutation.weight(current)));
    }

    /// The number of the mutation that the uniform `u` selects at a path; `None` if all weights are
    /// zero.
    pub fn select(&self, current: &RandomSequence<'_, V, S>, u: V::Real) -> Option<usize> {
        self.weights(current).map(|weights| weights.sample(u).item)
    }

    /// Mutation `i` alone, given that it has been [selected](Mutations::select). Its conditional
    /// density includes the probability of being selected, at `from`.
    pub fn only(&self, i: usize) -> Selected<'m, V, S> {
        Selected { mutations: *self, i }
    }
}

impl<V: Vertex, S: Strategy<V>> Mutation<V, S> for Mutations<'_, V, S> {
    fn propose<'a>(
        &self,
        current: &RandomSequence<'a, V, S>,
        decide: &mut Decisions<'_, V::Real>,
    ) -> Option<Draft<'a, V, S>> {
        let i = decide.weighted(self.0.len(), |i| self.0[i].weight(current))?;
        self.0[i].propose(current, decide)
    }
}

/// One of several mutations, selected already.
pub struct Selected<'m, V: Vertex, S: Strategy<V>> {
    mutations: Mutations<'m, V, S>,
    i: usize,
}

impl<V: Vertex, S: Strategy<V>> fmt::Debug for Selected<'_, V, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Selected({} of {})", self.i, self.mutations.0.len())
    }
}

impl<V: Vertex, S: Strategy<V>> Mutation<V, S> for Selected<'_, V, S> {
    fn propose<'a>(
        &self,
        current: &RandomSequence<'a, V, S>,
        decide: &mut Decisions<'_, V::Real>,
    ) -> Option<Draft<'a, V, S>> {
        decide.given(self.mutations.weights(current)?.get(self.i)?.probability);
        self.mutations.0.get(self.i)?.propose(current, decide)
    }
}
