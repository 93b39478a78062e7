//! Random samples of `f32` against `f64`: as many as there is time for, so that each costs little more than the
//! sampler itself.

use core::ops::Range;

use aether_core::{Pcg32, Scalar, UniformSource};

use super::few::Few;
use super::judge::{Judge, Origin};
use super::measure::Row;
use super::oracle::{Exact, Format};
use super::probe::{Answer, Question, ask};
use crate::registry::Item;

/// How many are drawn at once: samplers are made for each block, and blocks should stay in the cache.
const BLOCK: u64 = 1 << 8;

/// Of so many the textbook form is looked at too: few, as it is often far off, and where errors are large it takes long
/// to find how large they may be.
pub const BY_HAND: u64 = 20_000;

/// A uniform rounded to the precision, but not to one.
pub fn below_one<R: Scalar>(u: f64) -> f64 {
    R::of(u).min(R::ONE - R::EPSILON * R::of(0.5)).to_f64()
}

/// Uniforms below one, rounded to the precision.
pub fn draw<R: Scalar>(source: &mut Pcg32, dimensions: usize) -> Few<f64> {
    (0..dimensions).map(|_| below_one::<R>(source.next())).collect()
}

/// Adds samples to the row, with these sets of parameters in turns by the number of the sample.
pub fn against_double<R: Scalar>(
    row: &mut Row,
    item: &Item,
    sets: &[Vec<f64>],
    source: &mut Pcg32,
    dimensions: usize,
    samples: Range<u64>,
) {
    let format = Format::of::<R>();
    let mut first = samples.start;
    while first < samples.end {
        let size = BLOCK.min(samples.end - first) as usize;
        let set = |i: usize| (first as usize + i) % sets.len();
        let mut questions: Vec<Question> = Vec::with_capacity(size);
        questions.extend((0..size).map(|_| Question { u: draw::<R>(source, dimensions), x: None }));
        let exact: Vec<Option<Exact>> = by_set::<f64>(item, sets, &questions, set)
            .iter()
            .map(|found| Exact::of_double(found.as_ref()?))
            .collect();
        for (question, exact) in questions.iter_mut().zip(&exact) {
            question.x = Some(Judge::rounded::<R>(exact));
        }
        let found = by_set::<R>(item, sets, &questions, set);
        for (i, found) in found.iter().enumerate() {
            let (Some(found), Some(x)) = (found, questions[i].x) else { continue };
            let (numbers, u) = (&sets[set(i)][..], &questions[i].u[..]);
            let exact = exact[i];
            let (origin, by_hand) = (Origin::Random, first + (i as u64) < BY_HAND);
            let judge = Judge { item, numbers, u, exact, format, origin, by_hand };
            judge.enter::<R>(row, found, &x);
        }
        first += size as u64;
    }
}

/// The answers in the order of the questions, each to the sampler with its set of parameters.
fn by_set<R: Scalar>(
    item: &Item,
    sets: &[Vec<f64>],
    questions: &[Question],
    set: impl Fn(usize) -> usize,
) -> Vec<Option<Answer>> {
    let mut all = vec![None; questions.len()];
    for (s, numbers) in sets.iter().enumerate() {
        let mine: Vec<usize> = (0..questions.len()).filter(|i| set(*i) == s).collect();
        let asked: Vec<Question> = mine.iter().map(|i| questions[*i]).collect();
        for (i, found) in mine.iter().zip(ask::<R>(item, numbers, &asked)) {
            all[*i] = Some(found);
        }
    }
    all
}
