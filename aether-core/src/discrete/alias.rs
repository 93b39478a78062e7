//! Sampling a weighted choice in constant time.

use super::WeightError;
use super::weights::{Sum, relative, sum};
use crate::real::Scalar;

/// The largest number below one.
#[inline]
pub(super) fn below_one<R: Scalar>() -> R {
    R::ONE - R::EPSILON * R::of(0.5)
}

/// Which of `count` equal cells of [0, 1) `u` lies in, and where in the cell, in [0, 1).
#[inline]
pub(super) fn cell<R: Scalar>(u: R, count: usize) -> (usize, f64) {
    if count == 1 {
        return (0, u.to_f64().clamp(0.0, below_one()));
    }
    // Signed, as the machine converts those alone in one instruction; nothing in memory has more parts.
    let count = count as i64;
    let scaled = u.to_f64() * count as f64;
    // The product of a number next to one may round up to `count`. The cast takes NaN to zero.
    let index = (scaled as i64).min(count - 1).max(0);
    (index as usize, (scaled - index as f64).clamp(0.0, below_one()))
}

/// Walker's alias table, built by Vose's method (1991): each of n equal cells of [0, 1) holds one
/// outcome up to a threshold, and another beyond it.
#[derive(Clone, Debug)]
pub(super) struct AliasTable<R> {
    slots: Box<[Slot<R>]>,
}

#[derive(Clone, Debug)]
struct Slot<R> {
    probability: R,
    /// In the cell's own coordinate in [0, 1].
    threshold: f64,
    alias: usize,
}

impl<R: Scalar> AliasTable<R> {
    /// The table for these weights.
    pub(super) fn new(weights: &[R]) -> Result<Self, WeightError> {
        let probabilities = normalise(weights)?;
        let count = weights.len() as f64;
        // A cell's share of probability in units of one cell.
        let mut share: Vec<f64> = probabilities.iter().map(|p| p * count).collect();
        let likeliest = (0..share.len()).max_by(|a, b| share[*a].total_cmp(&share[*b]));
        let likeliest = likeliest.ok_or(WeightError::Empty)?;
        let mut slots: Vec<_> = probabilities
            .iter()
            .enumerate()
            .map(|(alias, _)| Slot { probability: R::ZERO, threshold: 1.0, alias })
            .collect();
        let (mut small, mut large): (Vec<_>, Vec<_>) =
            (0..share.len()).partition(|i| share[*i] < 1.0);
        while let (Some(s), Some(l)) = (small.pop(), large.pop()) {
            (slots[s].threshold, slots[s].alias) = (share[s], l);
            share[l] -= 1.0 - share[s];
            if share[l] < 1.0 { &mut small } else { &mut large }.push(l);
        }
        // What is left over is one but for rounding; what has no probability must not get any.
        for i in small {
            if probabilities[i] == 0.0 {
                (slots[i].threshold, slots[i].alias) = (0.0, likeliest);
            }
        }
        let actual = actual(&slots);
        slots.iter_mut().zip(actual).for_each(|(slot, p)| slot.probability = R::of(p));
        Ok(AliasTable { slots: slots.into() })
    }

    /// Probability of an outcome.
    #[inline]
    pub(super) fn probability(&self, index: usize) -> R {
        self.slots[index].probability
    }

    /// Up to where in a cell its own outcome is selected, and which one from there.
    pub(super) fn cell(&self, index: usize) -> (f64, usize) {
        (self.slots[index].threshold, self.slots[index].alias)
    }

    /// The outcome that `u` selects, and what is left of `u`.
    #[inline]
    pub(super) fn sample(&self, u: R) -> (usize, f64) {
        let (index, within) = cell(u, self.slots.len());
        let slot = &self.slots[index];
        if within < slot.threshold {
            (index, within / slot.threshold)
        } else {
            (slot.alias, (within - slot.threshold) / (1.0 - slot.threshold))
        }
    }
}

/// The probabilities that outcomes have in the finished table: those of the weights but for rounding,
/// and the ones that sampling has.
fn actual<R>(slots: &[Slot<R>]) -> Vec<f64> {
    let mut shares = vec![Sum::default(); slots.len()];
    for (index, slot) in slots.iter().enumerate() {
        shares[index] += slot.threshold;
        shares[slot.alias] += 1.0 - slot.threshold;
    }
    shares.iter().map(|share| share.value() / slots.len() as f64).collect()
}

/// The probabilities that weights stand for; exactly zero where `R` cannot represent them.
fn normalise<R: Scalar>(weights: &[R]) -> Result<Vec<f64>, WeightError> {
    let weights = relative(weights)?;
    let total = sum(weights.iter().copied());
    let representable = |p: f64| if R::of(p) == R::ZERO { 0.0 } else { p };
    Ok(weights.iter().map(|w| representable(w / total)).collect())
}
