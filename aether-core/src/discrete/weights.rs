//! Checking and adding up weights.

use super::WeightError;
use crate::real::Scalar;

/// The weights relative to the largest one, so that their sum neither overflows nor vanishes; a
/// positive weight stays positive.
///
/// # Errors
/// No weights; a weight that is negative, NaN or infinite; no positive weight.
pub(crate) fn relative<R: Scalar>(weights: &[R]) -> Result<Vec<f64>, WeightError> {
    if weights.is_empty() {
        return Err(WeightError::Empty);
    }
    let mut weights: Vec<f64> = weights.iter().map(|w| w.to_f64()).collect();
    if let Some(index) = weights.iter().position(|w| !(*w >= 0.0 && w.is_finite())) {
        return Err(WeightError::Invalid { index, weight: weights[index] });
    }
    let largest = weights.iter().copied().fold(0.0, f64::max);
    if largest == 0.0 {
        return Err(WeightError::AllZero);
    }
    for w in weights.iter_mut().filter(|w| **w > 0.0) {
        *w = (*w / largest).max(f64::MIN_POSITIVE);
    }
    Ok(weights)
}

/// A running sum that loses nothing of small summands among large ones: the rounding error of each
/// addition is kept beside it (Knuth's two-sum).
#[derive(Clone, Copy, Default)]
pub(crate) struct Sum {
    high: f64,
    low: f64,
}

impl Sum {
    /// The sum so far.
    pub(crate) fn value(self) -> f64 {
        self.high + self.low
    }
}

impl core::ops::AddAssign<f64> for Sum {
    fn add_assign(&mut self, x: f64) {
        let sum = self.high + x;
        let part = sum - self.high;
        self.low += (self.high - (sum - part)) + (x - part);
        self.high = sum;
    }
}

/// The sum of numbers that may differ by many orders of magnitude.
pub(crate) fn sum(numbers: impl IntoIterator<Item = f64>) -> f64 {
    let mut sum = Sum::default();
    numbers.into_iter().for_each(|x| sum += x);
    sum.value()
}
