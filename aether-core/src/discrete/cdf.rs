//! A weighted choice by inversion of its cumulative distribution.

use super::alias::below_one;
use super::weights::{Sum, relative};
use super::{Choice, Discrete, Inversion, WeightError};
use crate::real::Scalar;

/// A weighted choice among indices, sampled by inversion: index i is chosen by the uniforms of one
/// interval, which follow each other in the order of the indices. Sampling takes O(log N), the
/// probability of an index O(1).
///
/// The probability of an index is the length of its interval as it is stored, exactly, so that
/// sampling and density cannot disagree. Borders of intervals are whole multiples of `R::EPSILON` / 2,
/// the spacing of uniforms below one (of 2^-53, if `R` has more digits than `f64`). A positive weight has an interval of at least this length,
/// however small it is (in `f64` 2^-53); so nothing that has weight goes without samples. A zero
/// weight has no interval.
///
/// Unlike an alias table it is monotone: uniforms that are stratified make choices that are
/// stratified, and the uniform that belongs to an outcome can be recovered.
///
/// ```
/// use aether_core::discrete::{Cdf, Discrete};
/// let cdf = Cdf::new(&[1.0, 0.0, 3.0])?;
/// let (choice, rest) = cdf.sample_reuse(0.625);
/// assert_eq!((choice.index, choice.probability, rest), (2, 0.75, 0.5));
/// assert_eq!(cdf.uniform(2, 0.5), Some(0.625));
/// assert_eq!(cdf.interval(1), None);
/// # Ok::<(), aether_core::discrete::WeightError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Cdf<R = f64> {
    /// From zero to one, one more than there are indices.
    knots: Box<[R]>,
}

impl<R: Scalar> Cdf<R> {
    /// The choice of an index with probability proportional to its weight.
    ///
    /// # Errors
    /// No weights; a weight that is negative, NaN or infinite; no positive weight; more positive
    /// weights than there are uniforms (2^24 in `f32`).
    pub fn new(weights: &[R]) -> Result<Self, WeightError> {
        Self::from_relative(&relative(weights)?)
    }

    /// The same from weights in `f64` that are checked, and whose sum does not overflow.
    pub(crate) fn from_relative(weights: &[f64]) -> Result<Self, WeightError> {
        // Weights have the digits of `f64`, whatever `R` has.
        let spacing = 0.5 * R::EPSILON.to_f64().max(f64::EPSILON);
        let knots = round(weights, (1.0 / spacing) as u64)?;
        Ok(Cdf { knots: knots.iter().map(|k| R::of(*k as f64 * spacing)).collect() })
    }

    /// The same choice in another precision, with the probabilities that are stored here: exactly, if `S` has the
    /// digits of `R`. Otherwise borders are rounded, and what has no interval left is not chosen.
    pub fn cast<S: Scalar>(&self) -> Cdf<S> {
        Cdf { knots: self.knots.iter().map(|k| S::of(k.to_f64())).collect() }
    }

    /// Probability of an index; zero if there is no such index.
    #[inline]
    pub fn probability(&self, index: usize) -> R {
        match self.knots.get(index..) {
            Some([low, high, ..]) => *high - *low,
            _ => R::ZERO,
        }
    }

    /// The interval [low, high) of the uniforms that choose an index; `None` if none do.
    #[inline]
    pub fn interval(&self, index: usize) -> Option<(R, R)> {
        match self.knots.get(index..) {
            Some([low, high, ..]) if low < high => Some((*low, *high)),
            _ => None,
        }
    }

    /// The uniform that chooses `index` and of which `rest` is left: the inverse of
    /// [`Discrete::sample_reuse`]. `None` if no uniform chooses it.
    #[inline]
    pub fn uniform(&self, index: usize, rest: R) -> Option<R> {
        Inversion::uniform(self, index, rest)
    }
}

impl<R: Scalar> Inversion<R> for Cdf<R> {
    #[inline]
    fn interval(&self, index: usize) -> Option<(R, R)> {
        Cdf::interval(self, index)
    }
}

/// The item chosen is the index.
impl<R: Scalar> Discrete<R> for Cdf<R> {
    type Item<'a> = usize;

    fn len(&self) -> usize {
        self.knots.len() - 1
    }

    #[inline]
    fn sample_reuse(&self, u: R) -> (Choice<usize, R>, R) {
        // Takes NaN to zero.
        let u = u.max(R::ZERO).min(below_one());
        // The first knot is zero and the last is one: there is one below, and the knot after is above.
        let index = self.knots.partition_point(|knot| *knot <= u) - 1;
        let probability = self.probability(index);
        let rest = (u - self.knots[index]) / probability;
        (Choice { index, item: index, probability }, rest.min(below_one()))
    }

    #[inline]
    fn get(&self, index: usize) -> Option<Choice<usize, R>> {
        let probability = self.probability(index);
        (index < self.len()).then_some(Choice { index, item: index, probability })
    }
}

/// The cumulative sums of the weights in whole units, from zero, `units` being the sum of all.
fn round(weights: &[f64], units: u64) -> Result<Vec<u64>, WeightError> {
    let positive = weights.iter().filter(|w| **w > 0.0).count();
    match positive {
        0 if weights.is_empty() => return Err(WeightError::Empty),
        0 => return Err(WeightError::AllZero),
        _ if positive as u64 > units => {
            return Err(WeightError::TooMany { positive, limit: units as usize });
        }
        _ => {}
    }
    let mut knots = vec![0; weights.len() + 1];
    ends(weights, units, &mut knots[1..]);
    Ok(knots)
}

/// The cumulative sums of weights, some of which are positive, in whole units, `units` being the sum
/// of all, such that every positive weight has one unit at least and a zero weight has none.
pub(super) fn ends(weights: &[f64], units: u64, ends: &mut [u64]) {
    let total = super::weights::sum(weights.iter().copied());
    let (mut sum, mut last) = (Sum::default(), 0);
    for (w, end) in weights.iter().zip(ends.iter_mut()) {
        if *w > 0.0 {
            sum += *w;
            last = ((sum.value() / total * units as f64).round() as u64).max(last + 1);
        }
        *end = last;
    }
    // The end is fixed: what was moved up too far moves down again, a unit at least for each.
    let mut most = units;
    for (end, w) in ends.iter_mut().zip(weights).rev() {
        *end = most.min(*end);
        if *w > 0.0 {
            most = *end - 1;
        }
    }
}
