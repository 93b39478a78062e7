//! A choice among a few, made and forgotten for a single sample.

use super::alias::below_one;
use super::{Choice, Discrete, FixedOutcomes, Inversion};
use crate::real::Scalar;

/// A choice among `N` outcomes, numbered from zero. Made by [`shares`].
///
/// Like [`Cdf`](super::Cdf) it samples by inversion, and the probability of an index is the length of
/// its interval as it is stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shares<R, const N: usize> {
    /// Where the interval of each outcome ends.
    ends: [R; N],
}

/// The choice of an index with probability proportional to its weight. It neither allocates nor
/// fails: it is meant for weights that are computed anew for each sample, such as those of the lobes
/// of a material.
///
/// A weight that is negative or NaN counts as zero; infinite weights share everything among them. If
/// no weight is positive, all outcomes are equally likely.
///
/// ```
/// use aether_core::discrete::{Discrete, shares};
/// let lobes = shares([0.5, 0.0, 1.5]);
/// let (choice, rest) = lobes.sample_reuse(0.625);
/// assert_eq!((choice.item, choice.probability, rest), (2, 0.75, 0.5));
/// assert_eq!(lobes.probability(1), 0.0);
/// ```
pub fn shares<R: Scalar, const N: usize>(weights: [R; N]) -> Shares<R, N> {
    const { assert!(N > 0, "shares of no weights: there is nothing to choose from") };
    let weights = relative(weights.map(|w| w.to_f64()));
    let spacing = 0.5 * R::EPSILON.to_f64();
    let mut ends = [0; N];
    super::cdf::ends(&weights, (1.0 / spacing) as u64, &mut ends);
    Shares { ends: ends.map(|end| R::of(end as f64 * spacing)) }
}

/// Weights of which the largest is one.
fn relative<const N: usize>(weights: [f64; N]) -> [f64; N] {
    let largest = weights.iter().copied().fold(0.0, f64::max);
    weights.map(|w| {
        if largest == f64::INFINITY {
            f64::from(u8::from(w == largest))
        } else if largest == 0.0 {
            1.0
        } else if w > 0.0 {
            (w / largest).max(f64::MIN_POSITIVE)
        } else {
            0.0
        }
    })
}

impl<R: Scalar, const N: usize> Shares<R, N> {
    /// Probability of an index; zero if there is no such index.
    #[inline]
    pub fn probability(&self, index: usize) -> R {
        if index < N { self.ends[index] - self.start(index) } else { R::ZERO }
    }

    fn start(&self, index: usize) -> R {
        if index == 0 { R::ZERO } else { self.ends[index - 1] }
    }
}

/// The item chosen is the index.
impl<R: Scalar, const N: usize> Discrete<R> for Shares<R, N> {
    type Item<'a> = usize;

    fn len(&self) -> usize {
        N
    }

    #[inline]
    fn sample_reuse(&self, u: R) -> (Choice<usize, R>, R) {
        // Takes NaN to zero. The last end is one.
        let u = u.max(R::ZERO).min(below_one());
        let index = self.ends.partition_point(|end| *end <= u);
        let probability = self.probability(index);
        let rest = (u - self.start(index)) / probability;
        (Choice { index, item: index, probability }, rest.min(below_one()))
    }

    #[inline]
    fn get(&self, index: usize) -> Option<Choice<usize, R>> {
        let probability = self.probability(index);
        (index < N).then_some(Choice { index, item: index, probability })
    }
}

impl<R: Scalar, const N: usize> Inversion<R> for Shares<R, N> {
    #[inline]
    fn interval(&self, index: usize) -> Option<(R, R)> {
        (self.probability(index) > R::ZERO).then(|| (self.start(index), self.ends[index]))
    }
}

impl<R: Scalar, const N: usize> FixedOutcomes<R> for Shares<R, N> {
    type Outcome = usize;
    const COUNT: usize = N;
    #[inline]
    fn outcome(index: usize) -> usize {
        index
    }
}
