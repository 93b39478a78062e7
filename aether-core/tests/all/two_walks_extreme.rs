//! Weights of paths that are made of pieces of two walks, where densities go from zero to infinity and paths have a
//! thousand vertices, in single precision, against sums of logarithms.

use aether_core::estimator::{Connections, Factors, Techniques};
use aether_core::strategy::{Conditional, Drawn, Reads, Strategy, Vertex};
use aether_core::{
    Arena, Estimator, PathIntegrand, PathView, Pcg32, PowerHeuristic, RandomSequence, UniformSource,
};

/// A vertex, and which walk has made it.
#[derive(Clone, Copy, Debug)]
struct Spot {
    walk: usize,
    x: f32,
}

impl Vertex for Spot {
    type Real = f32;
    type Point = f32;
    fn point(&self) -> f32 {
        self.x
    }
}

/// The exponent of a density that is a power of two, infinities included: of a vertex of another walk it may be
/// anything.
fn exponent(walk: usize, before: Option<Spot>, target: &Spot) -> f64 {
    if target.walk == walk {
        return 0.0;
    }
    let bits = |spot: &Spot| u64::from(spot.x.to_bits());
    let mut hash = bits(target) << 32 | before.as_ref().map_or(0, bits);
    for factor in [0xbf58_476d_1ce4_e5b9, 0x94d0_49bb_1331_11eb] {
        hash = (hash ^ (hash >> 29)).wrapping_mul(factor);
    }
    let (class, size) = ((hash >> 48) % 64, ((hash >> 32) % 1024) as f64);
    match class {
        0 => f64::NEG_INFINITY,
        1 => f64::INFINITY,
        2..=32 => (size % 3.0) - 1.0,
        _ => (size % 121.0) - 80.0,
    }
}

/// Draws a number, whatever was before.
#[derive(Clone, Copy)]
struct Step {
    walk: usize,
}

impl Strategy<Spot> for Step {
    fn sample<U: UniformSource<f32> + ?Sized>(
        &self,
        _: PathView<'_, Spot>,
        uniforms: &mut U,
    ) -> Option<Drawn<Spot>> {
        Some(Drawn::new(Spot { walk: self.walk, x: uniforms.next() }))
    }
    fn pdf(&self, path: PathView<'_, Spot>, target: &Spot) -> Conditional<f32> {
        Conditional::density(exponent(self.walk, path.last(), target).exp2() as f32)
    }
    fn reads(&self) -> Reads {
        Reads { vertices: 1, length: false }
    }
    fn same(&self, other: &Self) -> bool {
        self.walk == other.walk
    }
}

struct One;

impl PathIntegrand for One {
    type Vertex = Spot;
    type Value = f32;
    fn extend(&self, _: PathView<'_, Spot>) -> f32 {
        1.0
    }
    fn end(&self, _: PathView<'_, Spot>) -> f32 {
        1.0
    }
}

/// The weight of a path by the power heuristic: `first` of its vertices are of the first walk.
fn expected(path: &[Spot], first: usize) -> f64 {
    // The exponents of all techniques relative to its own; what cannot arise has none, whatever its poles.
    let mut others = Vec::new();
    let mut add = |steps: &mut dyn Iterator<Item = f64>| {
        let (mut sum, mut poles) = (0.0, 0);
        for e in steps {
            if e == f64::NEG_INFINITY {
                return;
            }
            if e == f64::INFINITY {
                poles += 1;
            } else {
                sum += e;
            }
            others.push(if poles > 0 { f64::INFINITY } else { sum });
        }
    };
    let before = |i: usize| i.checked_sub(1).map(|i| path[i]);
    add(&mut (first..path.len()).map(|i| exponent(0, before(i), &path[i])));
    add(&mut (0..first).rev().map(|i| exponent(1, path.get(i + 1).copied(), &path[i])));
    1.0 / (1.0 + others.iter().map(|e| (2.0 * e).exp2()).sum::<f64>())
}

/// How many weights of the paths of one length that two walks make are next to zero, next to one, and neither.
fn compare(seed: u64, length: usize) -> [usize; 3] {
    let arena = Arena::<Spot, Step>::new();
    let uniforms = &mut Pcg32::new(seed, 0, 0);
    let mut walk = |walk: usize| {
        let mut path = arena.sequence();
        (0..length).for_each(|_| _ = path.append(Step { walk }));
        path.sample(uniforms);
        path
    };
    let walks: [RandomSequence<'_, Spot, Step>; 2] = [walk(0), walk(1)];
    let estimator: Estimator<One, Factors<f32>> = Estimator::paths(One);
    let mut techniques = Techniques::new(PowerHeuristic);
    techniques.reach(length, |_, _| 1);
    let connections = Connections {
        lengths: length..=length,
        ending: None::<&Step>,
        fewest_ending: 1,
        techniques: &techniques,
        is_drawn: |_, _| true,
    };
    let mut weights = vec![None; length + 1];
    let pieces = [&walks[0], &walks[1]];
    estimator.connections(pieces, &connections, uniforms, |found| {
        assert_eq!(found.alone, 1.0);
        weights[found.first] = Some(f64::from(found.value));
    });
    let mut counts = [0; 3];
    for (first, weight) in weights.iter().enumerate() {
        let vertex = |i: usize| {
            let (walk, i) = if i < first { (0, i) } else { (1, length - 1 - i) };
            walks[walk].vertex(i).expect("a vertex")
        };
        let path: Vec<Spot> = (0..length).map(vertex).collect();
        let (weight, expected) = (weight.expect("a path"), expected(&path, first));
        // Sums of a thousand terms, each of which is rounded once.
        let error = 1e3 * f64::from(f32::EPSILON) * expected + f64::from(f32::MIN_POSITIVE);
        assert!((weight - expected).abs() <= error, "{seed} {first}: {weight} {expected}");
        counts[if expected < 1e-3 { 0 } else { 1 + usize::from(expected < 0.999) }] += 1;
    }
    counts
}

#[test]
fn weights_of_short_paths_with_any_densities() {
    let mut counts = [0; 3];
    for seed in 0..2000 {
        for length in 1..8 {
            let found = compare(seed, length);
            (0..3).for_each(|i| counts[i] += found[i]);
        }
    }
    assert!(counts.iter().all(|count| *count > 5000), "{counts:?}");
}

#[test]
fn weights_of_paths_of_a_thousand_vertices() {
    let counts = compare(1, 1000);
    assert!(counts.iter().all(|count| *count > 20), "{counts:?}");
}
