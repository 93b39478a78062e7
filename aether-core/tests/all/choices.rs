//! Weighted choices: by inversion, by alias table, by a tree; what one knows of them exactly.

use aether_core::Scalar;
use aether_core::discrete::*;
use aether_core::uniform::{Pcg32, UniformSource};
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, RngSeed};

/// Pearson's test with a false-alarm rate of 10^-6, by the normal approximation of Wilson and
/// Hilferty; outcomes with fewer than five expected are pooled.
fn follows<R: Scalar, D: Discrete<R>>(choice: &D, seed: u64) {
    let n = 200_000;
    let mut counts = vec![0.0; choice.len()];
    let mut source = Pcg32::new(seed, 0, 0);
    for _ in 0..n {
        counts[choice.sample(UniformSource::<R>::next(&mut source)).index] += 1.0;
    }
    let (mut statistic, mut degrees) = (0.0, -1.0);
    let (mut rest, mut rest_expected) = (0.0, 0.0);
    for (index, count) in counts.iter().enumerate() {
        let p = choice.get(index).unwrap().probability.to_f64();
        assert!(p > 0.0 || *count == 0.0, "outcome {index} of probability zero was chosen");
        if p * f64::from(n) < 5.0 {
            (rest, rest_expected) = (rest + count, rest_expected + p * f64::from(n));
        } else {
            statistic += (count - p * f64::from(n)).powi(2) / (p * f64::from(n));
            degrees += 1.0;
        }
    }
    if rest_expected >= 5.0 {
        statistic += (rest - rest_expected).powi(2) / rest_expected;
        degrees += 1.0;
    }
    let spread = 2.0 / (9.0 * degrees);
    let z = ((statistic / degrees).cbrt() - (1.0 - spread)) / spread.sqrt();
    assert!(z < 4.75, "chi-square {statistic} with {degrees} degrees of freedom, z = {z}");
}

const WEIGHTS: [f64; 9] = [0.0, 1.0, 0.25, 0.0, 4.0, 1.0, 1e-3, 2.0, 0.0];

fn single(weights: &[f64]) -> Vec<f32> {
    weights.iter().map(|w| *w as f32).collect()
}

/// The tree that joins the leaves with these weights in pairs; a node knows its first leaf.
fn pairs(weights: &[f64]) -> Tree<usize, usize> {
    let mut builder = TreeBuilder::new();
    for (leaf, w) in weights.iter().enumerate() {
        builder.leaf(leaf, *w, leaf);
    }
    builder.pair_up(|a, b| *a.min(b));
    builder.build().unwrap()
}

#[test]
fn frequencies_are_the_probabilities() {
    follows(&Cdf::new(&WEIGHTS).unwrap(), 1);
    follows(&Cdf::new(&single(&WEIGHTS)).unwrap(), 2);
    follows(&discrete_weighted::<_, _, f64>(vec![(); 9], WEIGHTS).unwrap(), 3);
    follows(&discrete_weighted::<_, _, f32>(vec![(); 9], single(&WEIGHTS)).unwrap(), 4);
    let tree = pairs(&WEIGHTS);
    follows::<f64, _>(&tree.seen_by(ByWeight), 5);
    follows::<f32, _>(&tree.seen_by(ByWeight), 6);
    let tilted = |first: &usize, weight: f64| weight / (1.0 + *first as f64);
    follows::<f64, _>(&tree.seen_by(tilted), 7);
}

/// Weights over thirty orders of magnitude, in no particular order.
fn many() -> Vec<f64> {
    let exponent =
        |k: u64| (k.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 11) as f64 * 2.0_f64.powi(-53);
    (0..1_000_000).map(|k| 10.0_f64.powf(30.0 * exponent(k) - 15.0)).collect()
}

#[test]
fn a_million_weights_over_thirty_orders_of_magnitude() {
    let weights = many();
    let mut sorted = weights.clone();
    sorted.sort_by(f64::total_cmp);
    let total: f64 = sorted.chunks(1000).map(|part| part.iter().sum::<f64>()).sum();

    let cdf = Cdf::new(&weights).unwrap();
    let alias: Choices<_, (), f64> = discrete_weighted(vec![(); weights.len()], &weights).unwrap();
    let spacing = 0.5 * f64::EPSILON;
    let mut sum = 0.0;
    for (k, w) in weights.iter().enumerate() {
        let p = cdf.probability(k);
        assert!(p >= spacing, "weight {w} is lost");
        // Each weight below the spacing moves the others by as much at most.
        assert!((p - w / total).abs() <= 1e6 * spacing + 1e-14 * p, "{p:e} for {:e}", w / total);
        let q = alias.probability(k);
        assert!((q - w / total).abs() <= 1e-12 * q, "{q:e} for {:e}", w / total);
        sum += p;
    }
    assert!((sum - 1.0).abs() < 1e-12, "{sum}");

    let coarse = Cdf::new(&single(&weights)).unwrap();
    let sum: f64 = (0..weights.len()).map(|k| f64::from(coarse.probability(k))).sum();
    assert!(sum == 1.0 && (0..weights.len()).all(|k| coarse.probability(k) > 0.0), "{sum}");
}

#[test]
fn more_weights_than_uniforms_are_refused() {
    let error = Cdf::new(&vec![1.0_f32; (1 << 24) + 1]).unwrap_err();
    assert_eq!(error, WeightError::TooMany { positive: (1 << 24) + 1, limit: 1 << 24 });
    assert!(error.to_string().contains("16777217 positive weights"));
    assert!(Cdf::new(&vec![1.0_f32; 1 << 24]).is_ok());
}

#[test]
fn bad_weights_are_named() {
    assert_eq!(Cdf::<f64>::new(&[]), Err(WeightError::Empty));
    assert_eq!(Cdf::new(&[0.0, -0.0]), Err(WeightError::AllZero));
    assert_eq!(Cdf::new(&[1.0, -2.0]), Err(WeightError::Invalid { index: 1, weight: -2.0 }));
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert!(matches!(Cdf::new(&[1.0, 1.0, bad]), Err(WeightError::Invalid { index: 2, .. })));
        let mut builder = TreeBuilder::new();
        builder.leaf('a', 1.0, ());
        builder.leaf('b', f64::from(bad), ());
        builder.pair_up(|_, _| ());
        let error = builder.build().unwrap_err();
        assert!(error.to_string().starts_with("leaves of a tree: weight 1 is"), "{error}");
    }
}

#[test]
fn uniforms_outside_the_interval_choose_an_end() {
    let cdf = Cdf::new(&WEIGHTS).unwrap();
    let index = |u: f64| cdf.sample(u).index;
    assert_eq!([index(f64::NAN), index(-1.0), index(1.0), index(7.0)], [1, 1, 7, 7]);
    let tree = pairs(&WEIGHTS);
    let index = |u: f64| tree.seen_by(ByWeight).sample(u).index;
    assert_eq!([index(-1.0), index(0.0), index(1.0), index(7.0)], [1, 1, 7, 7]);
    assert_eq!((cdf.get(9), cdf.probability(9), cdf.interval(usize::MAX)), (None, 0.0, None));
}

#[test]
fn a_tree_of_another_shape_is_refused() {
    let mut builder = TreeBuilder::new();
    let (a, b) = (builder.leaf(1, 1.0, ()), builder.leaf(2, 1.0, ()));
    assert_eq!(builder.join(a, a, ()), Err(TreeError::Joined(a)));
    let both = builder.join(a, b, ()).unwrap();
    let again = builder.join(both, b, ());
    assert!(matches!(again, Err(TreeError::Joined(id)) if id == b), "{again:?}");
    let c = builder.leaf(3, 1.0, ());
    assert_eq!(builder.clone().build().unwrap_err(), TreeError::Roots(2));
    assert_eq!(TreeBuilder::<u8>::new().join(c, b, ()), Err(TreeError::Unknown(c)));
    builder.join(both, c, ()).unwrap();
    assert_eq!(builder.build().unwrap().leaf_count(), 3);
    let none = TreeBuilder::<u8>::new().build().unwrap_err();
    assert_eq!(none, TreeError::Weights(WeightError::Empty));
}

#[test]
fn importances_that_make_no_sense_leave_the_weights() {
    let tree = pairs(&[1.0, 3.0]);
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(tree.seen_by(|_: &usize, _: f64| bad).probability(0), 0.25, "{bad}");
    }
    // One branch is excluded, and huge or tiny importances are but a ratio.
    let only = |leaf: &usize, _: f64| if *leaf == 0 { 1e-300 } else { 0.0 };
    assert_eq!(tree.seen_by(only).probability(0), 1.0);
    let huge = |_: &usize, _: f64| f64::MAX;
    assert_eq!(tree.seen_by(huge).probability(1), 0.5);
    // A branch is not lost because the other outshines it.
    let bright = |leaf: &usize, _: f32| if *leaf == 0 { 1e-30 } else { 1e30 };
    let view = tree.seen_by(bright);
    let p: f32 = view.probability(0);
    assert!(p > 0.0 && view.sample(0.0_f32).index == 0 && view.sample(2.0 * p).index == 1);
}

#[test]
fn items_in_several_leaves_add_up() {
    let mut builder = TreeBuilder::new();
    for (item, weight) in [("b", 1.0), ("a", 2.0), ("b", 0.0), ("c", 4.0), ("b", 1.0)] {
        builder.leaf(item, weight, weight);
    }
    builder.pair_up(|a, b| a + b);
    let tree = builder.build().unwrap();
    let mut leaves = tree.leaves_of(&"b").to_vec();
    leaves.sort();
    assert_eq!(leaves, [0, 2, 4]);
    assert!(
        tree.leaves_of(&"z").is_empty() && tree.item(3) == Some(&"c") && tree.item(5).is_none()
    );
    let view = tree.seen_by(|sum: &f64, _: f64| *sum);
    let p = |item: &str| view.pdf(&item).value();
    assert!((p("b") - 0.25).abs() < 1e-15 && (p("c") - 0.5).abs() < 1e-15 && p("z") == 0.0);
    let lookup = ProbabilityOf::<_, f64>::new(&view);
    for item in ["a", "b", "c", "z"] {
        assert!((lookup.pdf(&&item).value() - p(item)).abs() < 1e-15);
    }
}

fn settings() -> ProptestConfig {
    ProptestConfig {
        cases: 500,
        failure_persistence: None,
        rng_algorithm: RngAlgorithm::ChaCha,
        rng_seed: RngSeed::Fixed(20_170_730),
        ..ProptestConfig::default()
    }
}

/// Many zeros, many equal, and some of very different size.
fn weights() -> impl Strategy<Value = Vec<f64>> {
    let weight = prop_oneof![
        3 => Just(0.0),
        2 => Just(1.0),
        2 => 0.01..10.0_f64,
        1 => (-30.0..3.0_f64).prop_map(|e| 10.0_f64.powf(e)),
    ];
    proptest::collection::vec(weight, 1..40)
        .prop_filter("some weight", |w| w.iter().any(|w| *w > 0.0))
}

/// The intervals of a [`Cdf`] tile [0, 1), and sampling agrees with each exactly.
fn tiles<R: Scalar + std::fmt::Display>(weights: &[R]) -> Result<(), TestCaseError> {
    let cdf = Cdf::new(weights).unwrap();
    let below = |x: R| x.next_below();
    let mut end = R::ZERO;
    for (index, w) in weights.iter().enumerate() {
        let Some((low, high)) = cdf.interval(index) else {
            prop_assert!(*w == R::ZERO && cdf.probability(index) == R::ZERO);
            continue;
        };
        prop_assert!(*w > R::ZERO && low == end && high - low == cdf.probability(index));
        end = high;
        // In an interval as short as can be the middle may round to its end.
        let middle = (low + (high - low) * R::of(0.5)).min(below(high));
        for u in [low, below(high), middle] {
            let (choice, rest) = cdf.sample_reuse(u);
            prop_assert_eq!((choice.index, choice.probability), (index, high - low));
            prop_assert!(rest >= R::ZERO && rest < R::ONE);
            let back = cdf.uniform(index, rest).unwrap();
            prop_assert!((back - u).abs() <= R::EPSILON * u, "{} back to {}", u, back);
        }
        prop_assert!(cdf.sample_reuse(low).1 == R::ZERO);
    }
    prop_assert!(end == R::ONE);
    let total: f64 = weights.iter().map(|w| w.to_f64()).sum();
    for (index, w) in weights.iter().enumerate() {
        let (p, ideal) = (cdf.probability(index).to_f64(), w.to_f64() / total);
        let slack = (weights.len() + 2) as f64 * R::EPSILON.to_f64();
        prop_assert!((p - ideal).abs() <= slack, "{} for {}", p, ideal);
    }
    Ok(())
}

/// Each outcome's share of equidistant uniforms is its probability, up to one uniform for each of
/// the intervals that choose it.
fn shares<D: Discrete<f64>>(choice: &D, intervals: f64) -> Result<(), TestCaseError> {
    let n = 8192;
    let mut counts = vec![0.0; choice.len()];
    for k in 0..n {
        let u = (f64::from(k) + 0.5) / f64::from(n);
        let (chosen, rest) = choice.sample_reuse(u);
        prop_assert!((0.0..1.0).contains(&rest));
        let p = choice.get(chosen.index).unwrap().probability;
        prop_assert!((chosen.probability - p).abs() <= 1e-14 * p && p > 0.0);
        counts[chosen.index] += 1.0;
    }
    let mut total = 0.0;
    for (index, count) in counts.iter().enumerate() {
        let p = choice.get(index).unwrap().probability;
        total += p;
        let limit = (intervals + 1.0) / f64::from(n);
        prop_assert!((count / f64::from(n) - p).abs() <= limit, "{} of {}: {}", count, n, p);
    }
    prop_assert!((total - 1.0).abs() < 1e-12, "probabilities add up to {}", total);
    Ok(())
}

/// A tree of random shape: joins two random nodes without a parent until one is left.
fn random_tree(weights: &[f64], mut seed: u64) -> Tree<usize, u64> {
    let mut next = |below: usize| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as usize % below
    };
    let mut builder = TreeBuilder::new();
    let mut roots: Vec<NodeId> = weights
        .iter()
        .enumerate()
        .map(|(k, w)| builder.leaf(k % 5, *w, next(1 << 20) as u64))
        .collect();
    while roots.len() > 1 {
        let a = roots.swap_remove(next(roots.len()));
        let b = roots.swap_remove(next(roots.len()));
        roots.push(builder.join(a, b, next(1 << 20) as u64).unwrap());
    }
    builder.build().unwrap()
}

proptest! {
    #![proptest_config(settings())]

    #[test]
    fn inversion_has_the_probabilities_of_its_intervals(weights in weights()) {
        tiles(&weights)?;
        let single = single(&weights);
        if single.iter().any(|w| *w > 0.0) {
            tiles(&single)?;
        }
        shares(&Cdf::new(&weights).unwrap(), 1.0)?;
    }

    #[test]
    fn alias_tables_have_the_probabilities_of_their_cells(weights in weights()) {
        let choices: Choices<_, usize, f64> =
            discrete_weighted((0..weights.len()).map(|k| k % 5).collect::<Vec<_>>(), &weights).unwrap();
        shares(&choices, weights.len() as f64)?;
        let total: f64 = weights.iter().sum();
        for (index, w) in weights.iter().enumerate() {
            let p = choices.probability(index);
            prop_assert!((p - w / total).abs() <= 1e-13 * p, "{} for {}", p, w / total);
        }
        let lookup = ProbabilityOf::new(&choices);
        for item in 0..6 {
            let (found, summed) = (lookup.pdf(&&item).value(), choices.pdf(&item).value());
            prop_assert!((found - summed).abs() <= 1e-14);
        }
    }

    #[test]
    fn trees_have_the_probabilities_of_their_walks(weights in weights(), seed in any::<u64>()) {
        let tree = random_tree(&weights, seed);
        let total: f64 = weights.iter().sum();
        let by_weight = tree.seen_by(ByWeight);
        for (leaf, w) in weights.iter().enumerate() {
            let p: f64 = by_weight.probability(leaf);
            prop_assert!((p - w / total).abs() <= 1e-14, "{} for {}", p, w / total);
            prop_assert_eq!(p == 0.0, *w == 0.0);
        }
        // Any importance: some zero, some NaN, the same for all queries of a node.
        let any = |data: &u64, _: f64| match data % 7 { 0 => 0.0, 1 => f64::NAN, k => 10.0_f64.powi(k as i32) };
        let view = tree.seen_by(any);
        shares(&view, 1.0)?;
        let empty = |leaf: &usize| weights[*leaf] == 0.0;
        prop_assert!((0..weights.len()).filter(empty).all(|leaf| view.probability(leaf) == 0.0));
        shares(&by_weight, 1.0)?;
        for item in 0..5_usize {
            let leaves = (0..weights.len()).filter(|k| k % 5 == item);
            let sum: f64 = leaves.map(|leaf| view.probability(leaf)).sum();
            prop_assert!((view.pdf(&item).value() - sum).abs() <= 1e-15);
        }
    }
}
