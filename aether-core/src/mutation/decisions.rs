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
pub(crate) struct Decided<R> {
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
    /// Whether the path has all vertices of the current one but those of a range.
    fn replaces(&self, range: &Range<usize>) -> bool {
        let kept = [range.start, self.current.saturating_sub(range.end)];
        self.common == kept[0] + kept[1] && kept[0] <= self.ends[0] && kept[1] <= self.ends[1]
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
            Mode::Draw(uniforms) => distribution.sample(uniforms.next()),
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
        if let Mode::Replay { decided, .. } = &mut self.mode
            && let Some(level) = decided.get_mut(self.count)
        {
            // The same choice as in the run before, at the same outcome or at a later one.
            if level.probability.is_none() {
                let weights = Weights { count, weight, sum: level.sum };
                level.find(&weights);
            }
            let (index, probability) = (level.index, level.probability);
            self.take(probability.unwrap_or(R::ZERO));
            return probability.map(|_| index);
        }
        let weights = Weights::new(count, weight)?;
        let (sum, depth) = (weights.sum, self.count);
        let item = self.choose(&weights);
        if let Mode::Replay { decided, .. } = &mut self.mode
            && let Some(level) = decided.get_mut(depth)
        {
            level.sum = sum;
        }
        item
    }

    /// Whether a proposal of `size` vertices is of any use: always when one is made; when a density
    /// is evaluated, only the size of the path in question. A mutation that knows the size of what it
    /// will return saves work with `decide.wants(size).then_some(())?` and changes nothing else.
    pub fn wants(&self, size: usize) -> bool {
        match &self.mode {
            Mode::Draw(_) => true,
            Mode::Replay { wanted, .. } => size == wanted.size,
        }
    }

    /// Whether a proposal is of any use in which these vertices of the current path are replaced and all
    /// others are kept: always when one is made; when a density is evaluated, only if the path in question
    /// has exactly the others. It saves work as [`Decisions::wants`] does.
    pub fn replaces(&self, vertices: Range<usize>) -> bool {
        match &self.mode {
            Mode::Draw(_) => true,
            Mode::Replay { wanted, .. } => wanted.replaces(&vertices),
        }
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
    decided[depth].find(distribution)
}

impl<R: Scalar> Decided<R> {
    /// The outcome whose turn it is, from the present one on. Outcomes of probability zero have no turn; only
    /// the last choice can be at one, since [`advance`] has just moved it there.
    fn find<'i, D: Discrete<R>>(&mut self, distribution: &'i D) -> Option<Choice<D::Item<'i>, R>> {
        while self.index < self.len {
            let choice = distribution.get(self.index);
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
