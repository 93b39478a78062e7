//! Discrete random variables: a choice among items, uniform or weighted, and a coin.
//!
//! | choice | sampling | probability of an index |
//! | --- | --- | --- |
//! | [`discrete`], all equally likely | O(1) | O(1) |
//! | [`discrete_weighted`], an alias table | O(1) | O(1) |
//! | [`Cdf`], by inversion: keeps the order of uniforms | O(log N) | O(1) |
//! | [`Tree`], weights that depend on a query | O(log N) | O(log N) |
//! | [`shares`] of a few weights, no table, `Copy` | O(N) | O(1) |
//!
//! [`ProbabilityOf`] finds a probability by the item in place of the index. Which uniforms choose an index tell
//! [`Inversion`], where that is one interval, and [`Inverse`] of an alias table, where there are several.

mod alias;
mod cdf;
mod few;
mod inverse;
mod lookup;
#[cfg(test)]
mod tests;
mod tree;
pub(crate) mod weights;

pub use cdf::Cdf;
pub use few::{Shares, shares};
pub use inverse::Inverse;
pub use lookup::ProbabilityOf;
pub use tree::{ByWeight, Importance, NodeId, Tree, TreeBuilder, TreeError, TreeView};

use core::fmt;
use core::marker::PhantomData;

use crate::density::{Counting, Density};
use crate::real::Scalar;
use alias::{AliasTable, below_one, cell};

/// An outcome of a discrete random variable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice<T, R> {
    /// Which outcome, counted from zero.
    pub index: usize,
    /// The item chosen.
    pub item: T,
    /// Probability of this index; an equal item at another index has a probability of its own.
    pub probability: R,
}

/// A random variable with finitely many outcomes, numbered from zero.
pub trait Discrete<R: Scalar> {
    /// What is chosen: a reference to an item, or a value.
    type Item<'a>
    where
        Self: 'a;

    /// How many outcomes there are, those of probability zero included.
    fn len(&self) -> usize;

    /// Whether there is nothing to choose from.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The outcome that the uniform `u` in [0, 1) selects, and what is left of `u`: again a uniform
    /// in [0, 1), independent of the choice, with correspondingly fewer significant bits. Outcomes
    /// of probability zero are never selected.
    fn sample_reuse(&self, u: R) -> (Choice<Self::Item<'_>, R>, R);

    /// The outcome that the uniform `u` in [0, 1) selects.
    fn sample(&self, u: R) -> Choice<Self::Item<'_>, R> {
        self.sample_reuse(u).0
    }

    /// The outcome with this index, for one who can tell the index from elsewhere; `None` if there
    /// is no such index.
    fn get(&self, index: usize) -> Option<Choice<Self::Item<'_>, R>>;

    /// Calls `visit` with each outcome of positive probability, once an index, and its probability.
    fn for_each<'a>(&'a self, mut visit: impl FnMut(Self::Item<'a>, R)) {
        self.possible(|_| true).for_each(|choice| visit(choice.item, choice.probability));
    }

    /// The outcomes of positive probability, each index once. Those with items of which `matters` does not hold may
    /// be left out.
    #[inline]
    fn possible<'a>(
        &'a self,
        matters: impl Fn(Self::Item<'a>) -> bool,
    ) -> impl Iterator<Item = Choice<Self::Item<'a>, R>>
    where
        Self: 'a,
    {
        let _ = matters;
        let choices = (0..self.len()).filter_map(|i| self.get(i));
        choices.filter(|choice| choice.probability > R::ZERO)
    }
}

/// A random variable whose outcomes are chosen by one interval of uniforms each, so that the uniform
/// that belongs to an outcome can be recovered.
pub trait Inversion<R: Scalar>: Discrete<R> {
    /// The interval [low, high) of the uniforms that choose an index; `None` if none do.
    fn interval(&self, index: usize) -> Option<(R, R)>;

    /// The uniform that chooses `index` and of which `rest` is left: the inverse of
    /// [`Discrete::sample_reuse`]. `None` if no uniform chooses it.
    #[inline]
    fn uniform(&self, index: usize, rest: R) -> Option<R> {
        let (low, high) = self.interval(index)?;
        Some((low + rest * (high - low)).max(low).min(high.next_below()))
    }
}

/// A random variable whose outcomes are known from its type, whatever their probabilities: a
/// [`coin`], or the [`shares`] of some weights.
///
/// Only such a choice can have probabilities that depend on what a strategy drew before: its density
/// has to know the outcomes in order to invert, and evaluates the probabilities afterwards.
#[diagnostic::on_unimplemented(
    message = "the outcomes of this choice depend on what was drawn",
    label = "known only after inversion, but the density inverts once for each outcome",
    note = "use `coin(p)` or `shares([a, b, c])`, whose outcomes are fixed and only the \
            probabilities depend on what was drawn; `match` the outcome to get at anything else"
)]
pub trait FixedOutcomes<R: Scalar>: Discrete<R> {
    /// What is chosen.
    type Outcome: Copy;
    /// How many outcomes there are.
    const COUNT: usize;
    /// The outcome with an index below [`FixedOutcomes::COUNT`].
    fn outcome(index: usize) -> Self::Outcome;
}

/// A distribution that lives elsewhere, in a scene say; its items live as long as it does.
impl<'b, R: Scalar, D: Discrete<R>> Discrete<R> for &'b D {
    type Item<'a>
        = D::Item<'b>
    where
        Self: 'a;

    fn len(&self) -> usize {
        D::len(self)
    }

    #[inline]
    fn sample_reuse(&self, u: R) -> (Choice<D::Item<'b>, R>, R) {
        D::sample_reuse(*self, u)
    }

    #[inline]
    fn get(&self, index: usize) -> Option<Choice<D::Item<'b>, R>> {
        D::get(*self, index)
    }

    #[inline]
    fn possible<'a>(
        &'a self,
        matters: impl Fn(Self::Item<'a>) -> bool,
    ) -> impl Iterator<Item = Choice<Self::Item<'a>, R>>
    where
        Self: 'a,
    {
        D::possible(*self, matters)
    }
}

impl<R: Scalar, D: Inversion<R>> Inversion<R> for &D {
    #[inline]
    fn interval(&self, index: usize) -> Option<(R, R)> {
        D::interval(self, index)
    }
}

/// Why something cannot be chosen from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WeightError {
    /// There are no items.
    Empty,
    /// There are not as many weights as items.
    Length {
        /// How many items.
        items: usize,
        /// How many weights.
        weights: usize,
    },
    /// A weight is negative, NaN or infinite.
    Invalid {
        /// Which weight, counted from zero.
        index: usize,
        /// The weight.
        weight: f64,
    },
    /// All weights are zero.
    AllZero,
    /// More outcomes than there are uniforms to choose them with.
    TooMany {
        /// How many weights are positive.
        positive: usize,
        /// How many outcomes can be told apart.
        limit: usize,
    },
}

impl fmt::Display for WeightError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            WeightError::Empty => {
                write!(f, "there is nothing to choose from: pass one item or more")
            }
            WeightError::Length { items, weights } => {
                write!(f, "{items} items but {weights} weights: pass one weight an item")
            }
            WeightError::Invalid { index, weight } => {
                write!(f, "weight {index} is {weight}: weights are finite and not negative")
            }
            WeightError::AllZero => {
                write!(f, "all weights are zero: at least one must be positive")
            }
            WeightError::TooMany { positive, limit } => write!(
                f,
                "{positive} positive weights, but uniforms tell {limit} outcomes apart: use f64"
            ),
        }
    }
}

impl std::error::Error for WeightError {}

/// A choice among the items of a container `C`: made by [`discrete`] or [`discrete_weighted`].
#[derive(Clone, Debug)]
pub struct Choices<C, T, R = f64> {
    items: C,
    /// `None` if all items are equally likely.
    table: Option<AliasTable<R>>,
    item: PhantomData<fn() -> T>,
}

/// A choice among the items of a slice, array or vector (owned or borrowed), all equally likely.
///
/// # Errors
/// [`WeightError::Empty`] if there are no items.
///
/// ```
/// use aether_core::discrete::{Discrete, discrete};
/// let suits = discrete(["clubs", "diamonds", "hearts", "spades"])?;
/// assert_eq!(*suits.sample(0.6).item, "hearts");
/// assert_eq!(suits.pdf(&"hearts").value(), 0.25);
/// # Ok::<(), aether_core::discrete::WeightError>(())
/// ```
pub fn discrete<C: AsRef<[T]>, T, R: Scalar>(items: C) -> Result<Choices<C, T, R>, WeightError> {
    if items.as_ref().is_empty() {
        return Err(WeightError::Empty);
    }
    Ok(Choices { items, table: None, item: PhantomData })
}

/// A choice among the items of a container, with probabilities proportional to `weights`.
///
/// Sampling takes constant time. A weight so small that its probability rounds to zero in `R`
/// counts as zero.
///
/// # Errors
/// No items, not one weight an item, a weight that is negative, NaN or infinite, no positive weight.
pub fn discrete_weighted<C: AsRef<[T]>, T, R: Scalar>(
    items: C,
    weights: impl AsRef<[R]>,
) -> Result<Choices<C, T, R>, WeightError> {
    let (count, weights) = (items.as_ref().len(), weights.as_ref());
    if count != weights.len() {
        return Err(WeightError::Length { items: count, weights: weights.len() });
    }
    let table = Some(AliasTable::new(weights)?);
    Ok(Choices { items, table, item: PhantomData })
}

impl<C: AsRef<[T]>, T, R: Scalar> Choices<C, T, R> {
    /// The items.
    pub fn items(&self) -> &[T] {
        self.items.as_ref()
    }

    /// Probability of an index; zero if there is no such index.
    #[inline]
    pub fn probability(&self, index: usize) -> R {
        let count = self.items().len();
        match &self.table {
            _ if index >= count => R::ZERO,
            None => R::of(1.0 / count as f64),
            Some(table) => table.probability(index),
        }
    }

    /// Probability that the item chosen equals `item`: the sum over all equal items, zero if there
    /// is none. Takes time proportional to the number of items.
    pub fn pdf(&self, item: &T) -> Density<Counting, R>
    where
        T: PartialEq,
    {
        let equal = self.items().iter().enumerate().filter(|(_, other)| *other == item);
        Density::new(equal.map(|(index, _)| self.probability(index)).sum())
    }

    /// All choices of positive probability, each index once.
    pub fn choices(&self) -> impl Iterator<Item = Choice<&T, R>> {
        (0..self.items().len())
            .map(|index| self.at(index))
            .filter(|choice| choice.probability > R::ZERO)
    }

    #[inline]
    fn at(&self, index: usize) -> Choice<&T, R> {
        let item = &self.items()[index];
        Choice { index, item, probability: self.probability(index) }
    }
}

impl<C: AsRef<[T]>, T, R: Scalar> Discrete<R> for Choices<C, T, R> {
    type Item<'a>
        = &'a T
    where
        Self: 'a;

    fn len(&self) -> usize {
        self.items().len()
    }

    #[inline]
    fn sample_reuse(&self, u: R) -> (Choice<&T, R>, R) {
        let (index, rest) = match &self.table {
            Some(table) if self.items().len() > 1 => table.sample(u),
            _ => cell(u, self.items().len()),
        };
        (self.at(index), R::of(rest).min(below_one()))
    }

    fn get(&self, index: usize) -> Option<Choice<&T, R>> {
        (index < self.items().len()).then(|| self.at(index))
    }
}

/// A coin: true with probability p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bernoulli<R = f64> {
    p: R,
}

/// A coin that shows true with probability `p`, as Russian roulette tosses it. A probability
/// above one counts as one, below zero or NaN as zero.
pub fn coin<R: Scalar>(p: R) -> Bernoulli<R> {
    Bernoulli { p: if p > R::ZERO { p.min(R::ONE) } else { R::ZERO } }
}

impl<R: Scalar> Bernoulli<R> {
    /// The probability of an outcome.
    #[inline]
    pub fn pdf(&self, outcome: &bool) -> Density<Counting, R> {
        Density::new(if *outcome { self.p } else { R::ONE - self.p })
    }
}

/// Index 0 is false, index 1 is true.
impl<R: Scalar> Discrete<R> for Bernoulli<R> {
    type Item<'a> = bool;

    #[inline]
    fn len(&self) -> usize {
        2
    }

    #[inline]
    fn sample_reuse(&self, u: R) -> (Choice<bool, R>, R) {
        let item = u < self.p;
        let probability = self.pdf(&item).value();
        let rest = if item { u / probability } else { (u - self.p) / probability };
        (Choice { index: usize::from(item), item, probability }, rest.min(below_one()))
    }

    #[inline]
    fn get(&self, index: usize) -> Option<Choice<bool, R>> {
        let item = index == 1;
        (index < 2).then(|| Choice { index, item, probability: self.pdf(&item).value() })
    }

    #[inline(always)]
    fn possible<'a>(
        &'a self,
        matters: impl Fn(Self::Item<'a>) -> bool,
    ) -> impl Iterator<Item = Choice<Self::Item<'a>, R>>
    where
        Self: 'a,
    {
        let below = R::ONE - self.p;
        let misses = matters(false) && below > R::ZERO;
        let hits = matters(true) && self.p > R::ZERO;
        Sides { below, above: self.p, misses, hits }
    }
}

/// The sides of a coin that it can show.
struct Sides<R> {
    below: R,
    above: R,
    misses: bool,
    hits: bool,
}

impl<R: Scalar> Iterator for Sides<R> {
    type Item = Choice<bool, R>;

    #[inline(always)]
    fn next(&mut self) -> Option<Choice<bool, R>> {
        if self.misses {
            self.misses = false;
            return Some(Choice { index: 0, item: false, probability: self.below });
        }
        let hits = core::mem::take(&mut self.hits);
        hits.then_some(Choice { index: 1, item: true, probability: self.above })
    }
}

impl<R: Scalar> Inversion<R> for Bernoulli<R> {
    #[inline]
    fn interval(&self, index: usize) -> Option<(R, R)> {
        let (low, high) = if index == 1 { (R::ZERO, self.p) } else { (self.p, R::ONE) };
        (index < 2 && low < high).then_some((low, high))
    }
}

impl<R: Scalar> FixedOutcomes<R> for Bernoulli<R> {
    type Outcome = bool;
    const COUNT: usize = 2;
    #[inline]
    fn outcome(index: usize) -> bool {
        index == 1
    }
}
