//! An interval cut into bins.

use super::{TableError, at_least};
use crate::real::Scalar;

/// How far outside a bin a point may lie by rounding, in units of the spacing of numbers at the far
/// end of the axis: that much is lost when a point goes through a map and back.
const SLACK: f64 = 8.0;

/// An interval of the line cut into bins by increasing knots. A bin includes its lower end.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis<R = f64> {
    /// One more than there are bins.
    knots: Box<[R]>,
    slack: R,
    /// Bins per length, on average.
    scale: R,
}

impl<R: Scalar> Axis<R> {
    /// The bins between these knots.
    ///
    /// # Errors
    /// Fewer than two knots; one that is not finite or not above the one before; an interval longer
    /// than the largest number.
    pub fn new(knots: &[R]) -> Result<Self, TableError> {
        let wrong = |index: usize, value: R| TableError::Knot { index, value: value.to_f64() };
        let [first, .., last] = knots else {
            return Err(TableError::TooFew { what: "knots", least: 2, found: knots.len() });
        };
        for (index, knot) in knots.iter().enumerate() {
            if !(knot.finite() && (index == 0 || knots[index - 1] < *knot)) {
                return Err(wrong(index, *knot));
            }
        }
        if !(*last - *first).finite() {
            return Err(wrong(knots.len() - 1, *last));
        }
        let slack = R::of(SLACK) * R::EPSILON * first.abs().max(last.abs());
        let scale = R::of((knots.len() - 1) as f64) / (*last - *first);
        Ok(Axis { knots: knots.into(), slack, scale })
    }

    /// `bins` equal bins from `low` to `high`.
    ///
    /// # Errors
    /// No bins; an end that is not finite, or `high` not above `low`; more bins than there are
    /// numbers between.
    pub fn even(low: R, high: R, bins: usize) -> Result<Self, TableError> {
        at_least(1, "bins", bins)?;
        let share = |k: usize| R::of(k as f64 / bins as f64);
        // Symmetric, so that both ends are exact.
        let knots: Vec<R> = (0..=bins).map(|k| low * share(bins - k) + high * share(k)).collect();
        Self::new(&knots)
    }

    /// The same bins in another precision: exactly, if `S` has the digits of `R`.
    ///
    /// # Errors
    /// Knots that are the same number in `S`.
    pub fn cast<S: Scalar>(&self) -> Result<Axis<S>, TableError> {
        Axis::new(&self.knots.iter().map(|k| S::of(k.to_f64())).collect::<Vec<S>>())
    }

    /// How many bins there are.
    pub fn bins(&self) -> usize {
        self.knots.len() - 1
    }

    /// The ends of a bin.
    ///
    /// # Panics
    /// If there is no such bin.
    #[inline]
    pub fn bin(&self, index: usize) -> (R, R) {
        (self.knots[index], self.knots[index + 1])
    }

    /// The width of a bin relative to the whole.
    ///
    /// # Panics
    /// If there is no such bin.
    pub fn share(&self, index: usize) -> f64 {
        let ((low, high), whole) = (self.bin(index), self.bins());
        let (first, last) = (self.knots[0].to_f64(), self.knots[whole].to_f64());
        (high.to_f64() - low.to_f64()) / (last - first)
    }

    /// The bin that `x` lies in, and the one beside it if `x` is next to their border, or next to the
    /// end of the axis, within rounding. None if `x` lies outside or is NaN.
    #[inline]
    pub fn locate(&self, x: R) -> [Option<usize>; 2] {
        let bins = self.bins();
        if !(x >= self.knots[0] - self.slack && x <= self.knots[bins] + self.slack) {
            return [None, None];
        }
        let index = self.bin_of(x);
        let (low, high) = self.bin(index);
        let beside = if x - low <= self.slack {
            index.checked_sub(1)
        } else if high - x <= self.slack && index + 1 < bins {
            Some(index + 1)
        } else {
            None
        };
        [Some(index), beside]
    }

    /// The bin that a number lies in, of one outside the nearest.
    #[inline]
    fn bin_of(&self, x: R) -> usize {
        let bins = self.bins();
        // Of equal bins the number is all but known; rounding, and other bins, take a search.
        let guess = ((x - self.knots[0]) * self.scale).to_f64() as usize;
        let is_found = guess < bins && self.knots[guess] <= x && x < self.knots[guess + 1];
        if is_found { guess } else { self.knots.partition_point(|k| *k <= x).clamp(1, bins) - 1 }
    }

    /// The number in a bin that is nearest to `x`.
    ///
    /// # Panics
    /// If there is no such bin.
    #[inline]
    pub fn confine(&self, index: usize, x: R) -> R {
        let (low, high) = self.bin(index);
        x.max(low).min(high.next_below())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_lies_in_the_bin_between_the_knots_around_it() {
        let uneven = [-3.0f32, -1.0, -0.999, 0.0, 1e-9, 0.25, 7.0, 1e4];
        for axis in [Axis::even(-0.3f32, 1.7, 97).unwrap(), Axis::new(&uneven).unwrap()] {
            let near = |x: f32| [x.next_down(), x, x.next_up(), x + 1e-3];
            for x in axis.knots.iter().flat_map(|x| near(*x)) {
                let inside = x.clamp(axis.knots[0], axis.knots[axis.bins()].next_down());
                let expected = (0..axis.bins()).find(|k| inside < axis.bin(*k).1);
                assert_eq!(Some(axis.bin_of(x)), expected, "{x}");
            }
        }
    }
}
