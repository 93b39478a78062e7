//! Walks that end in runs.

use aether_core::estimator::{Endings, PathIntegrand, Steps};
use aether_core::{Arena, Estimator, PathView, Pcg32, PowerHeuristic};

use super::algebra::{Count, Spot, Ways, pair, start, step};
use crate::world::Mean;

/// One for paths whose vertices all lie in [0, 4).
struct Inside;

impl PathIntegrand for Inside {
    type Vertex = Spot;
    type Value = f64;
    fn extend(&self, path: PathView<'_, Spot>) -> f64 {
        f64::from(path.last().is_some_and(|spot| (0.0..4.0).contains(&spot.0)))
    }
    fn end(&self, _: PathView<'_, Spot>) -> f64 {
        1.0
    }
}

/// A run takes the place of as many vertices of the walk as it yields: what paths of two to four vertices contribute is
/// 4² + 4³ + 4⁴. A false alarm has probability 6e-7, and the seed is fixed.
#[test]
fn an_ending_by_a_run_replaces_its_vertices() {
    let (count, estimator) = (Count::default(), Estimator::paths(Inside));
    let [one, two] = [Ways::from(step()), Ways::from(pair(&count))];
    let ways: [&[_]; 3] = [&[], std::slice::from_ref(&one), std::slice::from_ref(&two)];
    let (first, then) = ([Ways::from(start())], Ways::from(step()));
    let mut arena = Arena::new();
    let (mut whole, mut by_runs) = (Mean::default(), 0);
    for sample in 0..20_000 {
        arena.clear();
        let uniforms = &mut Pcg32::new(13, 0, sample);
        let steps = Steps { first: &first, then: &then };
        let endings = Endings { lengths: 2..=4, ways: &ways, is_used: |_: usize, _: &[_]| true };
        let mut sum = 0.0;
        estimator.walk(&arena, &steps, &endings, &PowerHeuristic, uniforms, |end| {
            sum += end.value;
            let is_run = end.steps.first().is_some_and(|step| matches!(step, Ways::Pair(_)));
            by_runs += usize::from(is_run);
        });
        whole.add(sum);
    }
    let z = whole.z(16.0 + 64.0 + 256.0);
    assert!(z.abs() < 5.0, "{z}");
    assert!(by_runs > 5_000, "{by_runs}");
}
