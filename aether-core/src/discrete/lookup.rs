//! The probability of an item, found by the item.

use super::Discrete;
use crate::density::{Counting, Density};
use crate::real::Scalar;

/// The probabilities of the items of a discrete random variable, found in O(log N) by the item
/// itself, for one who does not know its index. An item that is there several times has the sum of
/// its probabilities.
///
/// ```
/// use aether_core::discrete::{ProbabilityOf, discrete_weighted};
/// let letters = discrete_weighted(['x', 'y', 'x'], [0.25, 0.5, 0.25])?;
/// let lookup = ProbabilityOf::new(&letters);
/// assert_eq!(lookup.pdf(&&'x').value(), 0.5);
/// assert_eq!(lookup.pdf(&&'z').value(), 0.0);
/// # Ok::<(), aether_core::discrete::WeightError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ProbabilityOf<T, R = f64> {
    /// In the order of the items, each once.
    entries: Box<[(T, R)]>,
}

impl<T: Ord, R: Scalar> ProbabilityOf<T, R> {
    /// The probabilities of all items that `distribution` may choose.
    pub fn new<'a, D: Discrete<R, Item<'a> = T>>(distribution: &'a D) -> Self {
        let mut entries = Vec::new();
        distribution.for_each(|item, p| entries.push((item, p)));
        entries.sort_by(|(a, _), (b, _)| a.cmp(b));
        entries.dedup_by(|(item, p), (kept, sum)| {
            let same = item == kept;
            if same {
                *sum += *p;
            }
            same
        });
        ProbabilityOf { entries: entries.into() }
    }

    /// The probability that the item chosen equals `item`; zero if there is no such item.
    pub fn pdf(&self, item: &T) -> Density<Counting, R> {
        let found = self.entries.binary_search_by(|(other, _)| other.cmp(item));
        found.map_or(Density::ZERO, |k| Density::new(self.entries[k].1))
    }
}
