//! Weights of samples that belong to no path, and the heuristics.

use aether_core::preimages::Preimages;
use aether_core::{
    BalanceHeuristic, Density, Estimator, Heuristic, MaximumHeuristic, PathDensity, Pcg32, PdfOf,
    PowerHeuristic, Sampler, UniformSource, combine, combine_with,
};

/// x = u on [0, 1].
#[derive(Clone, Copy, Debug)]
struct Flat;
/// x = √u, density 2 x.
#[derive(Clone, Copy, Debug)]
struct Rising;

macro_rules! sampler {
    ($name:ident, $forward:expr, $pdf:expr, $inverse:expr) => {
        impl Sampler<f64> for $name {
            type Uniforms = [f64; 1];
            type Point = f64;
            fn forward(&self, [u]: [f64; 1]) -> (f64, bool) {
                let forward: fn(f64) -> f64 = $forward;
                (forward(u), true)
            }
            fn pdf(&self, x: &f64) -> PdfOf<Self, f64> {
                let pdf: fn(f64) -> f64 = $pdf;
                Density::new(if (0.0..=1.0).contains(x) { pdf(*x) } else { 0.0 })
            }
            fn pdf_of_uniforms(&self, u: [f64; 1]) -> PdfOf<Self, f64> {
                self.pdf(&self.forward(u).0)
            }
            fn preimages(&self, x: &f64, mut visit: impl FnMut([f64; 1], bool)) {
                let inverse: fn(f64) -> f64 = $inverse;
                visit([inverse(*x)], (0.0..=1.0).contains(x));
            }
        }
    };
}
sampler!(Flat, |u| u, |_| 1.0, |x| x);
sampler!(Rising, f64::sqrt, |x| 2.0 * x, |x| x * x);

/// The integral of 3 x² over [0, 1] is one.
fn z_of(estimate: impl Fn(&mut Pcg32) -> f64) -> f64 {
    let n = 50_000;
    let values: Vec<f64> = (0..n).map(|i| estimate(&mut Pcg32::new(4, 0, i))).collect();
    let mean = values.iter().sum::<f64>() / n as f64;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1) as f64;
    (mean - 1.0) / (variance / n as f64).sqrt()
}

#[test]
fn combined_estimates_are_unbiased() {
    let estimator = Estimator::new(|x: &f64| 3.0 * x * x);
    let z = [
        z_of(|u| {
            let (a, b) = (Flat.sample([u.next()]), Rising.sample([u.next()]));
            estimator.sum(combine::<PowerHeuristic, _>((&a, &b)))
        }),
        z_of(|u| {
            let (a, b) = (Flat.sample([u.next()]), Rising.sample([u.next()]));
            estimator.sum(combine::<MaximumHeuristic, _>((&a, &b)))
        }),
        z_of(|u| {
            let (a, b) = (Flat.sample([u.next()]), Rising.sample([u.next()]));
            let mine =
                |ratios: &[f64], _: usize| 1.0 / ratios.iter().map(|r| r.sqrt()).sum::<f64>();
            estimator.sum(combine_with(mine, (&a, &b)))
        }),
        // Three samples of one technique and one of the other, listed with their counts.
        z_of(|u| {
            let b = Rising.sample([u.next()]);
            let first = Flat.sample([u.next()]);
            let [one, flat] = combine::<BalanceHeuristic, _>(((&b, 1), (&first, 3)));
            let mut sum = one.weight * estimator.of::<_, f64>(&one);
            sum += flat.weight * estimator.of::<_, f64>(&flat);
            for _ in 0..2 {
                let next = Flat.sample([u.next()]);
                let [_, flat] = combine::<BalanceHeuristic, _>(((&b, 1), (&next, 3)));
                sum += flat.weight * estimator.of::<_, f64>(&flat);
            }
            sum
        }),
        z_of(|u| {
            let samples = [0; 4].map(|_| Rising.sample([u.next()]));
            estimator.sum(combine::<PowerHeuristic, _>(samples.each_ref()))
        }),
    ];
    // |z| > 5 is a false alarm with probability 6e-7 for each of the five.
    assert!(z.iter().all(|z| z.abs() < 5.0), "{z:?}");
}

#[test]
fn weights_and_densities_of_two_samples() {
    let (a, b) = (Flat.sample([0.25]), Rising.sample([0.25]));
    let [x, y] = combine::<PowerHeuristic, _>((&a, &b));
    assert_eq!((*x, x.pdf, *y, y.pdf), (0.25, 1.0, 0.5, 1.0));
    assert_eq!((x.weight, y.weight), (1.0 / 1.25, 0.5));
    let estimator = Estimator::new(|x: &f64| 3.0 * x * x);
    assert_eq!(estimator.of::<_, f64>(&b), 0.75);
    // No density, no estimate.
    let none = Rising.sample([0.0]);
    assert_eq!(Estimator::new(|_: &f64| 1.0).of::<_, f64>(&none), 0.0);
    let [_, none] = combine::<BalanceHeuristic, _>((&a, &none));
    assert_eq!(none.weight, 0.0);
    assert!(Preimages::<f64>::new().is_empty());
}

/// The weights of one point over all techniques.
fn weights(heuristic: &impl Heuristic<f64>, densities: &[f64]) -> Vec<f64> {
    let own = |i: usize| PathDensity::new(densities[i]);
    (0..densities.len())
        .map(|i| {
            if densities[i] == 0.0 {
                return 0.0;
            }
            let ratios: Vec<f64> = (0..densities.len())
                .map(|j| if i == j { 1.0 } else { own(j).ratio(own(i)) })
                .collect();
            heuristic.weight(&ratios, i)
        })
        .collect()
}

#[test]
fn the_weights_of_a_point_sum_to_one() {
    let infinite = f64::INFINITY;
    let cases: [&[f64]; 8] = [
        &[1.0],
        &[1.0, 2.0, 3.0],
        &[0.0, 2.0, 0.0, 1e-300],
        &[infinite, 1.0, 0.0],
        &[infinite, infinite, 5.0],
        &[1e-320, 1e300, 1e308],
        &[0.1 + 0.2, 0.3, 0.3],
        &[5e-324, 5e-324],
    ];
    for densities in cases {
        let all = [
            weights(&BalanceHeuristic, densities),
            weights(&PowerHeuristic, densities),
            weights(&MaximumHeuristic, densities),
        ];
        for weights in all {
            let sum: f64 = weights.iter().sum();
            assert!((sum - 1.0).abs() < 1e-14, "{densities:?}: {weights:?}");
            assert!(weights.iter().all(|w| (0.0..=1.0).contains(w)));
        }
    }
    assert_eq!(weights(&MaximumHeuristic, &[1.0, 3.0, 2.0]), [0.0, 1.0, 0.0]);
    assert!((weights(&PowerHeuristic, &[1.0, 3.0])[1] - 0.9).abs() < 1e-15);
}
