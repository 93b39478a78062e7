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
