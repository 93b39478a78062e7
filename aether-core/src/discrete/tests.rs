//! Frequencies, borders and bad weights.

use super::*;

/// Borders of the cells and both ends, and what lies next to them.
fn borders(count: usize) -> impl Iterator<Item = f64> {
    let inner = (0..=4 * count).map(move |k| k as f64 / (4 * count) as f64);
    inner
        .flat_map(|u| [u, u.next_down(), u.next_up()])
        .chain([1e-300, f64::MIN_POSITIVE])
        .filter(|u| (0.0..1.0).contains(u))
}

#[test]
fn frequencies_are_the_weights() {
    let weights = [1.0, 0.0, 5.0, 2.0, 0.0, 0.5, 1.5];
    let choices = discrete_weighted([0, 1, 2, 3, 4, 5, 6], weights).unwrap();
    let mut counts = [0.0; 7];
    let n = 70_000;
    (0..n).for_each(|k| counts[choices.sample((k as f64 + 0.5) / n as f64).index] += 1.0);
    for i in 0..7 {
        assert!((counts[i] / n as f64 - weights[i] / 10.0).abs() < 1e-3, "{i}: {counts:?}");
        assert!((choices.probability(i) - weights[i] / 10.0).abs() < 1e-15);
    }
}

#[test]
fn what_is_left_of_a_uniform_is_uniform() {
    let choices = discrete_weighted(["a", "b", "c"], [0.2, 0.5, 0.3]).unwrap();
    let mut sum = [0.0; 3];
    (0..30_000).for_each(|k| {
        let (choice, rest) = choices.sample_reuse((f64::from(k) + 0.5) / 3e4);
        assert!((0.0..1.0).contains(&rest));
        sum[choice.index] += rest / (choice.probability * 3e4);
    });
    assert!(sum.iter().all(|mean| (mean - 0.5).abs() < 1e-3), "{sum:?}");
    let (toss, rest) = coin(0.25).sample_reuse(0.625);
    assert!(!toss.item && rest == 0.5);
}

#[test]
fn zero_weights_are_never_chosen() {
    for weights in
        [vec![0.0, 1.0], vec![1.0, 0.0, 0.0], vec![0.0, 0.1, 0.0, 0.7, 0.0, 0.3, 0.1, 0.0]]
    {
        let single: Vec<f32> = weights.iter().map(|w| *w as f32).collect();
        let items: Vec<usize> = (0..weights.len()).collect();
        let fine = discrete_weighted(&items, &weights).unwrap();
        let coarse = discrete_weighted(&items, &single).unwrap();
        for u in borders(weights.len()) {
            assert!(fine.sample(u).probability > 0.0, "{u} of {weights:?}");
            let u = (u as f32).min(1.0_f32.next_down());
            assert!(coarse.sample(u).probability > 0.0, "{u} of {weights:?}");
        }
        assert!(fine.choices().all(|c| weights[c.index] > 0.0));
    }
    assert!(borders(9).all(|u| coin(1.0).sample(u).item && !coin(0.0).sample(u).item));
}

#[test]
fn a_probability_that_rounds_to_zero_is_zero() {
    let choices = discrete_weighted([0, 1], [1e-38_f32, 1e38]).unwrap();
    assert_eq!(choices.probability(0), 0.0);
    assert_eq!(choices.sample(0.0).index, 1);
    // Huge weights do not overflow.
    let huge: Choices<_, _> = discrete_weighted([0, 1], [f64::MAX, f64::MAX]).unwrap();
    assert_eq!(huge.probability(1), 0.5);
}

#[test]
fn equal_items_add_up_and_are_enumerated_each() {
    let choices = discrete_weighted(vec!['x', 'y', 'x'], [0.25, 0.5, 0.25]).unwrap();
    assert_eq!(choices.pdf(&'x').value(), 0.5);
    assert_eq!(choices.pdf(&'z').value(), 0.0);
    let mut seen = Vec::new();
    choices.for_each(|item, p| seen.push((*item, p)));
    assert_eq!(seen, [('x', 0.25), ('y', 0.5), ('x', 0.25)]);
    assert_eq!(choices.choices().count(), 3);
    assert_eq!(choices.get(1).map(|c| *c.item), Some('y'));
    assert_eq!(choices.get(3), None);
}

#[test]
fn bad_weights_are_named() {
    let error = |weights: &[f64]| discrete_weighted([1, 2], weights).err();
    assert_eq!(error(&[1.0]), Some(WeightError::Length { items: 2, weights: 1 }));
    assert_eq!(error(&[1.0, -2.0]), Some(WeightError::Invalid { index: 1, weight: -2.0 }));
    assert!(matches!(error(&[f64::NAN, 1.0]), Some(WeightError::Invalid { index: 0, .. })));
    assert!(matches!(error(&[1.0, f64::INFINITY]), Some(WeightError::Invalid { .. })));
    assert_eq!(error(&[0.0, -0.0]), Some(WeightError::AllZero));
    let none: [u8; 0] = [];
    assert_eq!(discrete::<_, _, f64>(none).err(), Some(WeightError::Empty));
    assert_eq!(discrete_weighted::<_, _, f64>(none, []).err(), Some(WeightError::Empty));
}

#[test]
fn a_coin_clamps_its_probability() {
    assert_eq!(coin(f64::NAN).pdf(&true).value(), 0.0);
    assert_eq!(coin(7.0_f32).pdf(&true).value(), 1.0);
    let mut outcomes = 0;
    coin(1.0).for_each(|item, p: f64| {
        assert!(item && p == 1.0);
        outcomes += 1;
    });
    assert_eq!(outcomes, 1);
}

/// The intervals of all indices in ascending order, each with its index.
fn intervals<C: AsRef<[T]>, T, R: Scalar>(choices: &Choices<C, T, R>) -> Vec<(R, R, usize)> {
    let inverse = choices.inverse();
    let of = |index: usize| inverse.intervals(index).map(move |(low, high)| (low, high, index));
    let mut all: Vec<_> = (0..choices.len() + 2).flat_map(of).collect();
    all.sort_by(|a, b| a.0.partial_cmp(&b.0).unwrap());
    all
}

/// Weights of all sizes, with zeros and equal ones among them.
fn many_weights(count: usize) -> Vec<f64> {
    let weight = |k: usize| match k % 5 {
        0 => 0.0,
        1 => 1.0,
        2 => 1e-9 * k as f64,
        3 => (k as f64).sqrt(),
        _ => 40.0 / (1.0 + k as f64),
    };
    (0..count).map(weight).collect()
}

/// That intervals tile [0, 1), choose their index up to the last number, and have the length of its probability.
fn tiles<C: AsRef<[T]>, T, R: Scalar>(choices: &Choices<C, T, R>) {
    let all = intervals(choices);
    let mut end = R::ZERO;
    let mut lengths = vec![weights::Sum::default(); choices.len()];
    for (low, high, index) in &all {
        assert!(*low == end && low < high, "{low:?}..{high:?} after {end:?}");
        let middle = R::of(0.5) * (*low + *high);
        for u in [*low, middle.min(high.next_below()), high.next_below()] {
            assert_eq!(choices.sample(u).index, *index, "{u:?} in {low:?}..{high:?}");
        }
        end = *high;
        lengths[*index] += (*high - *low).to_f64();
    }
    assert!(end == R::ONE, "{end:?}");
    for (index, length) in lengths.iter().enumerate() {
        let p = choices.probability(index).to_f64();
        let parts = all.iter().filter(|part| part.2 == index).count();
        let bound = R::EPSILON.to_f64() * (1.0 + parts as f64);
        assert!((length.value() - p).abs() <= bound, "{index}: {} of {p}", length.value());
        assert!(p > 0.0 || parts == 0, "{index} has no probability");
    }
}

#[test]
fn the_intervals_of_an_alias_table_tile_the_uniforms() {
    for count in [1, 2, 3, 7, 64, 1000] {
        let mut weights = many_weights(count);
        weights[count - 1] += 3.0;
        let single: Vec<f32> = weights.iter().map(|w| *w as f32).collect();
        let items: Vec<usize> = (0..count).collect();
        tiles(&discrete_weighted(&items, &weights).unwrap());
        tiles(&discrete_weighted(&items, &single).unwrap());
        tiles::<_, _, f64>(&discrete(&items).unwrap());
        tiles::<_, _, f32>(&discrete(&items).unwrap());
    }
    // One part of an index in its own cell, and others in those of less likely ones.
    let choices = discrete_weighted([0, 1, 2], [0.5, 0.25, 2.25]).unwrap();
    assert_eq!(choices.inverse().intervals(2).len(), 3);
    assert_eq!(choices.inverse().intervals(3).len(), 0);
}

#[test]
fn what_is_left_of_a_uniform_leads_back_to_it() {
    let weights = many_weights(50);
    let choices = discrete_weighted((0..50).collect::<Vec<usize>>(), &weights).unwrap();
    let inverse = choices.inverse();
    for k in 0..10_000 {
        let u = (f64::from(k) + 0.5) / 1e4;
        let (choice, rest) = choices.sample_reuse(u);
        let candidates = inverse.uniforms(choice.index, rest);
        assert_eq!(candidates.clone().filter(|v| (u - v).abs() < 1e-14).count(), 1, "{u}");
        assert!(candidates.clone().all(|v| choices.sample(v).index == choice.index));
    }
}

#[test]
fn equal_items_have_intervals_of_their_own() {
    let choices = discrete_weighted(vec!['x', 'y', 'x', 'z'], [0.125, 0.5, 0.375, 0.0]).unwrap();
    let inverse = choices.inverse();
    let length = |index| inverse.intervals(index).map(|(low, high)| high - low).sum::<f64>();
    assert_eq!((length(0), length(2), length(3)), (0.125, 0.375, 0.0));
    assert_eq!(length(0) + length(2), choices.pdf(&'x').value());
    tiles(&choices);
}
