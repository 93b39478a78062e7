//! An interval cut into bins.

use super::TableError;
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
}

impl<R: Scalar> Axis<R> {
    /// The bins between these knots.
    ///
    /// # Errors
    /// Fewer than two knots; one that is not finite or not above the one before; an interval longer
    /// than the largest number.
    pub fn new(knots: &[R]) -> Result<Self, TableError> {
        let wrong = |index: usize, value: R| TableError::Knot { index, value: value.to_f64() };
        let (Some(first), Some(last)) = (knots.first(), knots.last()) else {
            return Err(TableError::Count { what: "knots", expected: 2, found: 0 });
        };
        if knots.len() < 2 {
            return Err(TableError::Count { what: "knots", expected: 2, found: 1 });
        }
        for (index, knot) in knots.iter().enumerate() {
            if !(knot.finite() && (index == 0 || knots[index - 1] < *knot)) {
                return Err(wrong(index, *knot));
            }
        }
        if !(*last - *first).finite() {
            return Err(wrong(knots.len() - 1, *last));
        }
        let slack = R::of(SLACK) * R::EPSILON * first.abs().max(last.abs());
        Ok(Axis { knots: knots.into(), slack })
    }

    /// `bins` equal bins from `low` to `high`.
    ///
    /// # Errors
    /// No bins; an end that is not finite, or `high` not above `low`; more bins than there are
    /// numbers between.
    pub fn even(low: R, high: R, bins: usize) -> Result<Self, TableError> {
        let share = |k: usize| R::of(k as f64 / bins as f64);
        // Symmetric, so that both ends are exact.
        let knots: Vec<R> = (0..=bins).map(|k| low * share(bins - k) + high * share(k)).collect();
        if bins == 0 {
            return Err(TableError::Count { what: "bins", expected: 1, found: 0 });
        }
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
        let index = self.knots.partition_point(|knot| *knot <= x).clamp(1, bins) - 1;
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
