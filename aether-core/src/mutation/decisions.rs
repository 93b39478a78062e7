//! The discrete choices of a mutation: drawn, or run through one after the other.

use core::fmt;
use core::ops::Range;

use crate::discrete::{Choice, Discrete};
use crate::path_density::PathDensity;
use crate::real::Scalar;
use crate::uniform::UniformSource;

/// Most choices that one proposal can take; whoever asks for more gets none.
const MAX_DECISIONS: usize = 64;

/// Which outcome of a choice is being evaluated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Decided<R> {
    index: usize,
    len: usize,
    /// The sum of all weights, of a choice by weights.
    sum: R,
    /// How likely the outcome is, once that is known.
    probability: Option<R>,
}

/// Moves on to the next combination of outcomes, the last choice first; returns whether there is
/// one.
pub(super) fn advance<R>(decided: &mut Vec<Decided<R>>) -> bool {
    while let Some(last) = decided.last_mut() {
        last.index += 1;
        last.probability = None;
        if last.index < last.len {
            return true;
        }
        decided.pop();
    }
    false
}

/// What the density of a path is evaluated for: how many vertices it has, and which of the current path's.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    /// How many vertices it has.
    pub size: usize,
    /// How many vertices the current path has.
    pub current: usize,
    /// How many of these it has in common with the path.
    pub common: usize,
    /// How many of them lie before the first that the path does not have, and after the last.
    pub ends: [usize; 2],
}

impl Wanted {
    /// Whether the path has a vertex of the current one twice, by what is told of each of its vertices. No mutation makes such
    /// a path: it has one place less to differ in than its density is stated for.
    pub fn repeats(&self, in_common: &[bool]) -> bool {
        in_common.iter().filter(|is_common| **is_common).count() > self.common
    }
}

/// What a mutation is run for: to make a proposal, or to find the density of one path. A mutation that asks here
/// saves work, and changes nothing else.
#[derive(Clone, Copy, Debug)]
pub struct Purpose(Option<Wanted>);

impl Purpose {
    /// Whether a proposal of `size` vertices is of any use: always when one is made; when a density
    /// is evaluated, only the size of the path in question. A mutation that knows the size of what it
    /// will return can go on with `wants(size).then_some(())?`.
    pub fn wants(self, size: usize) -> bool {
        self.0.is_none_or(|wanted| size == wanted.size)
    }

    /// Whether a proposal is of any use in which these vertices of the current path are replaced and all
    /// others are kept: always when one is made; when a density is evaluated, only if the path in question
    /// has exactly the others.
    pub fn replaces(self, vertices: Range<usize>) -> bool {
        let Some(wanted) = self.0 else { return true };
        let kept = [vertices.start, wanted.current.saturating_sub(vertices.end)];
        wanted.common == kept[0] + kept[1] && kept[0] <= wanted.ends[0] && kept[1] <= wanted.ends[1]
    }

    /// Whether there may be a range of so many vertices of which [`Purpose::replaces`] holds.
    pub fn replaces_so_many(self, vertices: usize) -> bool {
        self.0.is_none_or(|wanted| wanted.common + vertices == wanted.current)
    }
}

/// What a mutation decides by chance. When a proposal is made each choice is drawn; when a
/// conditional density is evaluated the mutation is run once for each combination of outcomes, and
/// what the outcomes' probabilities have to do with it is kept account of here.
///
/// Every choice yields an `Option`, to be passed on with `?`: `None` says that this run leads
/// nowhere, because there is nothing to choose from, all combinations have had their turn, or the
/// 64 choices that a proposal may take are used up.
pub struct Decisions<'d, R: Scalar> {
    mode: Mode<'d, R>,
    count: usize,
    probability: PathDensity<R>,
}

enum Mode<'d, R> {
    Draw(&'d mut dyn UniformSource<R>),
    Replay { decided: &'d mut Vec<Decided<R>>, wanted: Wanted },
}

impl<R: Scalar> fmt::Debug for Decisions<'_, R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mode = if matches!(self.mode, Mode::Draw(_)) { "drawn" } else { "replayed" };
        write!(f, "Decisions({} {mode}, probability {:?})", self.count, self.probability)
    }
}

impl<'d, R: Scalar> Decisions<'d, R> {
    pub(super) fn draw(uniforms: &'d mut dyn UniformSource<R>) -> Self {
        Decisions { mode: Mode::Draw(uniforms), count: 0, probability: PathDensity::ONE }
    }

    /// Replays what is `decided`, and adds to it the first outcomes of the choices that follow.
    pub(super) fn replay(decided: &'d mut Vec<Decided<R>>, wanted: Wanted) -> Self {
        let mode = Mode::Replay { decided, wanted };
        Decisions { mode, count: 0, probability: PathDensity::ONE }
    }

    /// Ends a replay: the probability of the outcomes, with what was not asked for forgotten.
    pub(super) fn finish(self) -> PathDensity<R> {
        if let Mode::Replay { decided, .. } = self.mode {
            decided.truncate(self.count);
        }
        self.probability
    }

    /// A choice of a distribution: [`discrete`](crate::discrete::discrete),
    /// [`discrete_weighted`](crate::discrete::discrete_weighted), [`coin`](crate::discrete::coin) or
    /// one of the user's.
    pub fn choose<'i, D: Discrete<R>>(&mut self, distribution: &'i D) -> Option<D::Item<'i>> {
        if distribution.is_empty() || self.count >= MAX_DECISIONS {
            return None;
        }
        let choice = match &mut self.mode {
            Mode::Draw(uniforms) => distribution.sample(uniforms.choice()),
            Mode::Replay { decided, .. } => match replayed(decided, self.count, distribution) {
                Some(choice) => choice,
                None => {
                    self.probability = PathDensity::ZERO;
                    return None;
                }
            },
        };
        self.take(choice.probability);
        Some(choice.item)
    }

    /// One more choice, with the probability of its outcome.
    fn take(&mut self, probability: R) {
        self.count += 1;
        self.probability = self.probability * probability;
    }

    /// One of the numbers `0..count`, all equally likely; none if `count` is zero.
    pub fn index(&mut self, count: usize) -> Option<usize> {
        self.weighted(count, |_| R::ONE)
    }

    /// One of the numbers `0..count` with probability proportional to its weight; needs no heap.
    /// Negative weights and NaN count as zero. None if the weights do not have a positive, finite
    /// sum.
    pub fn weighted(&mut self, count: usize, weight: impl Fn(usize) -> R) -> Option<usize> {
        self.weighted_among(count, weight, |_| true)
    }

    /// The same where, of some numbers, the mutation knows that no proposal of use would come of them
    /// ([`Decisions::purpose`]): where a density is evaluated they have no turn, and nothing else changes.
    pub fn weighted_among(
        &mut self,
        count: usize,
        weight: impl Fn(usize) -> R,
        is_useful: impl Fn(usize) -> bool,
    ) -> Option<usize> {
        if count == 0 || self.count >= MAX_DECISIONS {
            return None;
        }
        let (index, probability) = match &mut self.mode {
            Mode::Draw(uniforms) => {
                let choice = Weights::new(count, weight)?.sample(uniforms.choice());
                (choice.item, choice.probability)
            }
            Mode::Replay { decided, .. } => {
                if self.count >= decided.len() {
                    let sum = Weights::new(count, &weight)?.sum;
                    decided.push(Decided { index: 0, len: count, sum, probability: None });
                }
                let level = &mut decided[self.count];
                if level.probability.is_none() {
                    level.find(&Weights { count, weight, sum: level.sum }, is_useful);
                }
                let Some(probability) = level.probability else {
                    self.probability = PathDensity::ZERO;
                    return None;
                };
                (level.index, probability)
            }
        };
        self.take(probability);
        Some(index)
    }

    /// What the mutation is run for.
    pub fn purpose(&self) -> Purpose {
        match &self.mode {
            Mode::Draw(_) => Purpose(None),
            Mode::Replay { wanted, .. } => Purpose(Some(*wanted)),
        }
    }

    /// [`Purpose::wants`].
    pub fn wants(&self, size: usize) -> bool {
        self.purpose().wants(size)
    }

    /// [`Purpose::replaces`].
    pub fn replaces(&self, vertices: Range<usize>) -> bool {
        self.purpose().replaces(vertices)
    }

    /// Takes a factor into account that was decided elsewhere.
    pub(super) fn given(&mut self, probability: R) {
        self.probability = self.probability * probability;
    }
}

/// The outcome whose turn it is in choice number `depth`.
fn replayed<'i, R: Scalar, D: Discrete<R>>(
    decided: &mut Vec<Decided<R>>,
    depth: usize,
    distribution: &'i D,
) -> Option<Choice<D::Item<'i>, R>> {
    if depth >= decided.len() {
        let len = distribution.len();
        decided.push(Decided { index: 0, len, sum: R::ZERO, probability: None });
    }
    decided[depth].find(distribution, |_| true)
}

impl<R: Scalar> Decided<R> {
    /// The outcome whose turn it is, from the present one on. Outcomes that are of no use or have probability zero
    /// have no turn; only the last choice can be at one, since [`advance`] has just moved it there.
    fn find<'i, D: Discrete<R>>(
        &mut self,
        distribution: &'i D,
        is_useful: impl Fn(usize) -> bool,
    ) -> Option<Choice<D::Item<'i>, R>> {
        while self.index < self.len {
            let choice = is_useful(self.index).then(|| distribution.get(self.index)).flatten();
            if let Some(choice) = choice.filter(|choice| choice.probability > R::ZERO) {
                self.probability = Some(choice.probability);
                return Some(choice);
            }
            self.index += 1;
        }
        None
    }
}

/// Numbers with weights that are computed when they are needed.
pub(super) struct Weights<F, R> {
    count: usize,
    weight: F,
    sum: R,
}

impl<R: Scalar, F: Fn(usize) -> R> Weights<F, R> {
    pub fn new(count: usize, weight: F) -> Option<Self> {
        let sum: R = (0..count).map(|i| positive(weight(i))).sum();
        (sum > R::ZERO && sum < R::INFINITY).then_some(Weights { count, weight, sum })
    }
}

fn positive<R: Scalar>(weight: R) -> R {
    if weight > R::ZERO { weight } else { R::ZERO }
}

impl<R: Scalar, F: Fn(usize) -> R> Discrete<R> for Weights<F, R> {
    type Item<'a>
        = usize
    where
        Self: 'a;

    fn len(&self) -> usize {
        self.count
    }

    fn sample_reuse(&self, u: R) -> (Choice<usize, R>, R) {
        let (mut below, target) = (R::ZERO, u * self.sum);
        let mut last = Choice { index: 0, item: 0, probability: R::ZERO };
        let below_one = R::ONE - R::EPSILON;
        for index in 0..self.count {
            let weight = positive((self.weight)(index));
            if weight > R::ZERO {
                last = Choice { index, item: index, probability: weight / self.sum };
                if target < below + weight {
                    return (last, ((target - below) / weight).min(below_one));
                }
                below += weight;
            }
        }
        // Rounding only: u is less than one.
        (last, below_one)
    }

    fn get(&self, index: usize) -> Option<Choice<usize, R>> {
        (index < self.count).then(|| {
            let probability = positive((self.weight)(index)) / self.sum;
            Choice { index, item: index, probability }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discrete::{coin, discrete};

    /// All runs of `f`, each with its probability.
    fn runs<T>(f: impl Fn(&mut Decisions<'_, f64>) -> Option<T>) -> Vec<(Option<T>, f64)> {
        let (mut decided, mut all) = (Vec::new(), Vec::new());
        loop {
            let wanted = Wanted { size: 3, current: 5, common: 3, ends: [2, 1] };
            let mut decide = Decisions::replay(&mut decided, wanted);
            let result = f(&mut decide);
            all.push((result, decide.finish().value()));
            if !advance(&mut decided) {
                return all;
            }
        }
    }

    #[test]
    fn every_combination_has_its_turn_once() {
        let all = runs(|decide| {
            let a = decide.weighted(4, |i| [0.0, 1.0, 0.0, 3.0][i])?;
            let b = if a == 1 { decide.index(2)? } else { 7 };
            Some((a, b, decide.choose(&coin(if a == 3 { 1.0 } else { 0.25 }))?))
        });
        let expected = [
            (Some((1, 0, false)), 0.25 * 0.5 * 0.75),
            (Some((1, 0, true)), 0.25 * 0.5 * 0.25),
            (Some((1, 1, false)), 0.25 * 0.5 * 0.75),
            (Some((1, 1, true)), 0.25 * 0.5 * 0.25),
            (Some((3, 7, true)), 0.75),
        ];
        let possible: Vec<_> = all.into_iter().filter(|(_, p)| *p > 0.0).collect();
        assert_eq!(possible, expected);
    }

    #[test]
    fn what_is_of_no_use_has_no_turn_and_changes_no_probability() {
        let all = |useful: fn(usize) -> bool| {
            let found = runs(|decide| {
                let weight = |i: usize| [1.0, 0.0, 2.0, 1.0][i];
                let a = decide.weighted_among(4, weight, useful)?;
                Some((a, decide.index(2)?))
            });
            found.into_iter().filter(|(_, p)| *p > 0.0).collect::<Vec<_>>()
        };
        let expected = [(Some((2, 0)), 0.25), (Some((2, 1)), 0.25)];
        assert_eq!(all(|i| i < 3 && i > 0), expected);
        assert_eq!(all(|_| true).len(), 6);
        assert!(all(|_| false).is_empty());
        // When a proposal is made all have their turn.
        let mut uniforms = || 0.1;
        let drawn = Decisions::draw(&mut uniforms).weighted_among(4, |_| 1.0, |_| false);
        assert_eq!(drawn, Some(0));
        let purpose = Purpose(Some(Wanted { size: 3, current: 5, common: 3, ends: [2, 1] }));
        let ranges = (0..5).flat_map(|i| (i + 1..6).map(move |k| i..k));
        let replaced = ranges.filter(|r| purpose.replaces(r.clone()));
        let replaced: Vec<_> = replaced.map(|r| (r.start, r.end)).collect();
        assert_eq!(replaced, [(2, 4)]);
        assert!((0..6).all(|n| purpose.replaces_so_many(n) == (n == 2)));
    }

    #[test]
    fn nothing_to_choose_from_and_endless_choices_end() {
        assert_eq!(runs(|decide| decide.index(0)), [(None, 1.0)]);
        assert_eq!(runs(|decide| decide.weighted(2, |_| f64::NAN)), [(None, 1.0)]);
        let endless = runs(|decide| {
            let mut n = 0;
            while decide.choose(&coin(0.5))? {
                n += 1;
            }
            Some(n)
        });
        let sum: f64 = endless.iter().filter(|(n, _)| n.is_some()).map(|(_, p)| p).sum();
        assert!((sum - 1.0).abs() < 1e-15, "{sum}");
        let items = [2, 3, 5];
        let choices = discrete::<_, _, f64>(&items).expect("not empty");
        let found: Vec<_> = runs(|decide| decide.choose(&choices).copied());
        assert_eq!(found.iter().filter_map(|(item, _)| *item).collect::<Vec<_>>(), items);
    }

    #[test]
    fn drawn_as_often_as_replayed() {
        let weights = [1.0, 0.0, 2.0, 5.0];
        let mut counts = [0; 4];
        for i in 0..800 {
            let mut uniforms = || (f64::from(i) + 0.5) / 800.0;
            let chosen = Decisions::draw(&mut uniforms).weighted(4, |i| weights[i]);
            counts[chosen.expect("positive weights")] += 1;
        }
        assert_eq!(counts, [100, 0, 200, 500]);
    }
}
