//! The longest run: eight vertices of one draw, against eight draws of one vertex.

use aether_core::prelude::*;
use aether_core::{Arena, BalanceHeuristic, PathView, Pcg32, RandomSequence, combine, strategies};

use super::algebra::Spot;

/// Eight points, each within a reach of the one before that grows with its distance.
#[sampler(a in -10.0..=10.0)]
fn eight_points(u: [Uniform; 8], a: f64) -> (f64, f64, f64, f64, f64, f64, f64, f64) {
    let x1 = a + (1.0 + a * a) * u[0];
    let x2 = x1 + (1.0 + x1 * x1).sqrt() * u[1];
    let x3 = x2 + (1.0 + x2 * x2).sqrt() * u[2];
    let x4 = x3 - (1.0 + x3 * x3).sqrt() * u[3];
    let x5 = x4 + (1.0 + x4 * x4).sqrt() * u[4];
    let x6 = x5 - (1.0 + x5 * x5).sqrt() * u[5];
    let x7 = x6 + (1.0 + x6 * x6).sqrt() * u[6];
    let x8 = x7 - (1.0 + x7 * x7).sqrt() * u[7];
    (x1, x2, x3, x4, x5, x6, x7, x8)
}

/// Uniform between two points.
#[sampler]
fn between(u: [Uniform; 1], from: f64, to: f64) -> f64 {
    from + (to - from) * u[0]
}

#[strategy]
fn start(path: &PathView<Spot>) -> Spot {
    let x = draw(between(0.0, 1.0));
    Spot(x)
}

#[strategy]
fn run(path: &PathView<Spot>) -> [Spot; 8] {
    let here = given(path.last());
    let points = given(eight_points(here.0).ok());
    let x = draw(points);
    [Spot(x.0), Spot(x.1), Spot(x.2), Spot(x.3), Spot(x.4), Spot(x.5), Spot(x.6), Spot(x.7)]
}

/// Within twice the reach of the run, to either side.
#[strategy]
fn step(path: &PathView<Spot>) -> Spot {
    let here = given(path.last());
    let reach = 2.0 + 2.0 * here.0 * here.0;
    let x = draw(between(here.0 - reach, here.0 + reach));
    Spot(x)
}

strategies! {
    #[derive(Clone)]
    enum Ways for Spot { Start(Start), Run(Run), Step(Step) }
}

type Walk<'a> = RandomSequence<'a, Spot, Ways>;

/// The density of the last eight vertices by hand.
fn by_hand(x: &[f64]) -> f64 {
    let reach = |x: f64| if (0.0..1.0).contains(&x) { 1.0 + x * x } else { f64::NAN };
    let rest: f64 = x[1..8].iter().map(|x| 1.0 / (1.0 + x * x).sqrt()).product();
    rest / reach(x[0])
}

fn spots(path: &Walk<'_>) -> Vec<f64> {
    path.vertices().map(|spot| spot.0).collect()
}

#[test]
fn a_run_of_eight_has_the_product_of_its_densities() {
    let mut arena = Arena::new();
    for sample in 0..200 {
        arena.clear();
        let mut path: Walk<'_> = arena.sequence();
        path.append(start()).append(run()).sample(&mut Pcg32::new(3, 0, sample));
        let x = spots(&path);
        assert_eq!(x.len(), 9);
        let expected = by_hand(&x);
        let found = path.pdf().value();
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} is not {expected} at {x:?}");
    }
}

#[test]
fn a_run_of_eight_is_weighed_against_eight_steps() {
    let mut arena = Arena::new();
    for sample in 0..200 {
        arena.clear();
        let mut joint: Walk<'_> = arena.sequence();
        joint.append(start()).append(run());
        let mut single: Walk<'_> = arena.sequence();
        single.append(start());
        for _ in 0..8 {
            single.append(step());
        }
        let uniforms = &mut Pcg32::new(4, 0, sample);
        joint.sample(uniforms);
        single.sample(uniforms);
        let x = spots(&joint);
        let steps: f64 = x[..8].iter().map(|x| 0.25 / (1.0 + x * x)).product();
        let expected = by_hand(&x) / (by_hand(&x) + steps);
        let mut paths = combine::<BalanceHeuristic, _>(&[joint, single]);
        let weight = paths.next().expect("the run").weight;
        assert!((weight / expected - 1.0).abs() < 1e-12, "{weight} is not {expected}");
    }
}
