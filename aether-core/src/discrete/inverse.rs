//! Which uniforms choose an index of an alias table.

use super::Choices;
use super::alias::cell;
use crate::real::Scalar;

/// The uniforms that choose each index of a [`discrete_weighted`](super::discrete_weighted) or
/// [`discrete`](super::discrete) choice. Made by [`Choices::inverse`] in O(N); the choice itself stays as it is.
///
/// Unlike a [`Cdf`](super::Cdf), an alias table gives an index several intervals of uniforms: the first part of its own cell,
/// and what the cells of less likely indices leave over. Their lengths add up to the probability of the index, up to one
/// rounding an interval; together the intervals of all indices are [0, 1).
///
/// ```
/// use aether_core::discrete::{Discrete, discrete_weighted};
/// let choices = discrete_weighted(["a", "b", "c"], [0.25, 1.0, 1.75])?;
/// let inverse = choices.inverse();
/// let c: Vec<(f64, f64)> = inverse.intervals(2).collect();
/// assert!(c.len() > 1 && c.iter().all(|(low, _)| *choices.sample(*low).item == "c"));
/// let length: f64 = c.iter().map(|(low, high)| high - low).sum();
/// assert!((length - choices.probability(2)).abs() < 1e-15);
/// // What was left of a uniform, and the index, lead back to it.
/// let (choice, rest) = choices.sample_reuse(0.7);
/// assert!(inverse.uniforms(choice.index, rest).any(|u: f64| (u - 0.7).abs() < 1e-15));
/// # Ok::<(), aether_core::discrete::WeightError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Inverse<R = f64> {
    /// Where the intervals of each index begin in the list, and, at the end, its length.
    starts: Box<[usize]>,
    /// The intervals [low, high) of all indices, in order.
    intervals: Box<[(R, R)]>,
}

impl<R: Scalar> Inverse<R> {
    /// The intervals [low, high) of the uniforms that choose an index, in ascending order; none if it has probability zero,
    /// or if there is no such index. They are those of the numbers that there are: every uniform inside of one chooses
    /// the index, and none outside of all does.
    pub fn intervals(&self, index: usize) -> impl ExactSizeIterator<Item = (R, R)> + Clone {
        let part = match self.starts.get(index..) {
            Some([start, end, ..]) => &self.intervals[*start..*end],
            _ => &[],
        };
        part.iter().copied()
    }

    /// The uniforms that choose an index and of which `rest` is left, one an interval: the inverse of
    /// [`Discrete::sample_reuse`](super::Discrete::sample_reuse).
    pub fn uniforms(&self, index: usize, rest: R) -> impl ExactSizeIterator<Item = R> + Clone {
        let inside =
            move |(low, high): (R, R)| (low + rest * (high - low)).max(low).min(high.next_below());
        self.intervals(index).map(inside)
    }
}

impl<C: AsRef<[T]>, T, R: Scalar> Choices<C, T, R> {
    /// Which uniforms choose each index.
    pub fn inverse(&self) -> Inverse<R> {
        let count = self.items().len();
        let mut found: Vec<Vec<(R, R)>> = vec![Vec::new(); count];
        let mut low = R::ZERO;
        for slot in 0..count {
            // A cell belongs to its own index up to a threshold, and to another one from there.
            let (threshold, alias) = match &self.table {
                None => (1.0, slot),
                Some(table) => table.cell(slot),
            };
            for (side, (index, end)) in [(slot, threshold), (alias, 1.0)].into_iter().enumerate() {
                let high = self.border(low, (slot as f64 + end) / count as f64, (slot, side));
                if low < high {
                    found[index].push((low, high));
                }
                low = high;
            }
        }
        let mut starts = vec![0];
        for own in &found {
            starts.push(starts[starts.len() - 1] + own.len());
        }
        Inverse { starts: starts.into(), intervals: found.concat().into() }
    }

    /// The least uniform beyond one side of a cell, which is rounding away from `near`; not less than `low`.
    fn border(&self, low: R, near: f64, side: (usize, usize)) -> R {
        let beyond = |u: R| u >= R::ONE || self.side(u) > side;
        let mut border = R::of(near).max(low).min(R::ONE);
        while low < border && beyond(border.next_below()) {
            border = border.next_below();
        }
        while !beyond(border) {
            border = -((-border).next_below());
        }
        border
    }

    /// The cell that a uniform lies in, and on which side of the threshold: ascends with the uniform.
    fn side(&self, u: R) -> (usize, usize) {
        let (index, within) = cell(u, self.items().len());
        let threshold = self.table.as_ref().map_or(1.0, |table| table.cell(index).0);
        (index, usize::from(within >= threshold))
    }
}
