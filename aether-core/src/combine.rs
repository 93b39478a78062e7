//! Multiple importance sampling: the weights of samples that several techniques could have made
//! (Veach and Guibas 1995; Aether 2017, section 5.4).

mod heuristic;
mod loose;
mod paths;
mod shifted;

pub use heuristic::{BalanceHeuristic, Heuristic, MaximumHeuristic, PowerHeuristic, Separable};
pub(crate) use loose::weighted_ratio;
pub use loose::{LooseTechnique, WeightedSample};
pub use paths::{Combined, Paths, Weighted};
pub use shifted::Shifted;

/// Things that [`combine`] can weigh against each other: paths (an array, slice or `Vec` of
/// [`RandomSequence`](crate::sequence::RandomSequence)s, or
/// [`Arena::collect`](crate::sequence::Arena::collect)ed ones), or samples of samplers of one space
/// (a tuple or array of `&Sample`). In place of each, a pair with the number of samples that its
/// technique takes.
///
/// A technique stands once in the list, with one of its samples: where it takes several, the others are combined in
/// lists of their own, with the same numbers, and a sample that stands in several lists counts once. (All of them in one list,
/// each with their number, would count as that many techniques of so many samples, and the estimate would be too small.
/// Without numbers they are techniques that take one sample each, which is right too.)
pub trait Combine<H> {
    /// The weighted samples: an iterator or an array.
    type Output: IntoIterator;
    /// Weighs them by a heuristic.
    fn combine_with(self, heuristic: H) -> Self::Output;
}

/// The samples with their weights, `combine::<PowerHeuristic, _>(...)`.
///
/// The estimate is the sum of weight × f / p over all items, where an item's weight is that of the
/// heuristic divided by the number of samples of its technique. Weights are computed from ratios of
/// densities, so that neither zeros nor poles nor densities out of the range of a float hurt; factors
/// that two techniques share cancel exactly and are not evaluated.
///
/// Paths without a sample yield no item, but take part as techniques: what matters to the weights is
/// what could have been sampled.
///
/// # Panics
/// If the techniques are paths of different arenas.
pub fn combine<H: Default, C: Combine<H>>(techniques: C) -> C::Output {
    techniques.combine_with(H::default())
}

/// [`combine`] with a heuristic that is a value: a user's own, or a closure
/// `|ratios: &[f64], own: usize| ...` as in [`Heuristic::weight`].
pub fn combine_with<H, C: Combine<H>>(heuristic: H, techniques: C) -> C::Output {
    techniques.combine_with(heuristic)
}
