//! Weights of multiple importance sampling against exact arithmetic: densities from zero to infinity,
//! atoms included, and paths of a thousand vertices in single precision.

use aether_core::strategy::{Conditional, Dirac, Drawn, Reads, Strategy, Vertex};
use aether_core::{
    Arena, BalanceHeuristic, Estimator, Heuristic, PathIntegrand, PathView, Pcg32, PowerHeuristic,
    RandomSequence, Scalar, UniformSource, combine,
};

/// A sum of whole multiples of powers of two, exactly: fixed point with bits on both sides.
struct Exact {
    limbs: [u64; 2 * Exact::MIDDLE],
}

impl Exact {
    /// The limb that holds the units; squares of densities of four vertices reach 2^±8200.
    const MIDDLE: usize = 140;

    fn zero() -> Self {
        Exact { limbs: [0; 2 * Exact::MIDDLE] }
    }

    /// Adds m 2^e.
    fn add(&mut self, m: u64, e: i32) {
        let place = e + 64 * Exact::MIDDLE as i32;
        let (at, shift) = (place as usize / 64, place as usize % 64);
        let mut carry = u128::from(m) << shift;
        for limb in &mut self.limbs[at..] {
            carry += u128::from(*limb);
            *limb = carry as u64;
            carry >>= 64;
            if carry == 0 {
                return;
            }
        }
    }

    /// m 2^e over this, to 63 bits.
    fn under(&self, m: u64, e: i32) -> f64 {
        let top = (0..self.limbs.len()).rev().find(|i| self.limbs[*i] > 0).expect("a sum");
        let two = u128::from(self.limbs[top]) << 64 | u128::from(self.limbs[top - 1]);
        let exponent = e - 64 * (top as i32 - 1 - Exact::MIDDLE as i32);
        // Two steps, as the power may leave the range of a float where the quotient does not.
        let half = exponent / 2;
        m as f64 / two as f64 * 2f64.powi(half) * 2f64.powi(exponent - half)
    }
}

/// A density, exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Size {
    Zero,
    /// m 2^e
    Finite(u64, i32),
    Infinite,
}

impl Size {
    fn value<R: Scalar>(self) -> R {
        match self {
            Size::Zero => R::ZERO,
            Size::Finite(m, e) => {
                let half = e / 2;
                R::of(m as f64) * R::of(2.0).powi(half) * R::of(2.0).powi(e - half)
            }
            Size::Infinite => R::INFINITY,
        }
    }

    /// A path that cannot arise does not arise at a pole either.
    fn times(self, other: Size) -> Size {
        match (self, other) {
            (Size::Zero, _) | (_, Size::Zero) => Size::Zero,
            (Size::Infinite, _) | (_, Size::Infinite) => Size::Infinite,
            (Size::Finite(m, e), Size::Finite(n, f)) => Size::Finite(m * n, e + f),
        }
    }
}

/// What a strategy of the test has: a number, a density, and a kind.
#[derive(Clone, Copy, Debug)]
struct Given {
    id: usize,
    size: Size,
    dirac: Option<Dirac>,
}

#[derive(Clone, Copy, Debug)]
struct Spot<R>(R);

impl<R: Scalar> Vertex for Spot<R> {
    type Real = R;
    type Point = R;
    fn point(&self) -> R {
        self.0
    }
}

impl<R: Scalar> Strategy<Spot<R>> for Given {
    fn sample<U: UniformSource<R> + ?Sized>(
        &self,
        _: PathView<'_, Spot<R>>,
        _: &mut U,
    ) -> Option<Drawn<Spot<R>>> {
        Some(Drawn { dirac: self.dirac, ..Drawn::new(Spot(R::ZERO)) })
    }
    fn pdf(&self, _: PathView<'_, Spot<R>>, _: &Spot<R>) -> Conditional<R> {
        Conditional { value: self.size.value(), dirac: self.dirac }
    }
    fn reads(&self) -> Reads {
        Reads::NOTHING
    }
    fn same(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

/// The techniques of one test: which strategies, and how many samples.
struct Case {
    techniques: Vec<(Vec<Given>, u64)>,
}

impl Case {
    fn random(seed: u64, reach: i32) -> Case {
        let mut source = Pcg32::new(seed, 0, 0);
        let mut below = |n: usize| (UniformSource::<f64>::next(&mut source) * n as f64) as usize;
        let (vertices, count) = (1 + below(4), 2 + below(5));
        // Few strategies a vertex, so that techniques share factors.
        let pool: Vec<Vec<Given>> = (0..vertices)
            .map(|k| {
                let mut strategy = |i| {
                    let wide = below(2 * reach as usize) as i32 - reach;
                    let size = match below(12) {
                        0 => Size::Zero,
                        1 => Size::Infinite,
                        2..7 => Size::Finite(1 + below(15) as u64, below(9) as i32 - 4),
                        _ => Size::Finite(1 + below(15) as u64, wide),
                    };
                    let dirac = match below(8) {
                        0 => Some(Dirac::Position),
                        1 if k > 0 => Some(Dirac::Direction),
                        _ => None,
                    };
                    Given { id: 3 * k + i, size, dirac }
                };
                (0..3).map(&mut strategy).collect()
            })
            .collect();
        let technique = |_| (pool.iter().map(|p| p[below(3)]).collect(), below(4) as u64);
        Case { techniques: (0..count).map(technique).collect() }
    }

    /// The density of a path of technique `own` under technique j, without the poles that both have in
    /// common; infinite if there are others.
    fn density(&self, own: usize, j: usize) -> Size {
        let pairs = self.techniques[own].0.iter().zip(&self.techniques[j].0);
        pairs.fold(Size::Finite(1, 0), |product, (a, b)| match b.size {
            _ if a.dirac != b.dirac => Size::Zero,
            Size::Infinite if a.id == b.id => product,
            size => product.times(size),
        })
    }

    /// Whether technique j lacks a pole that technique `own` has.
    fn lacks_pole(&self, own: usize, j: usize) -> bool {
        let mut pairs = self.techniques[own].0.iter().zip(&self.techniques[j].0);
        pairs.any(|(a, b)| a.size == Size::Infinite && a.id != b.id)
    }

    /// The weight of a path of technique `own` over its number of samples, where (n p) to the power of
    /// `beta` counts; `None` if it is no sample.
    fn weight(&self, own: usize, beta: u32) -> Option<f64> {
        let samples = self.techniques[own].1;
        let Size::Finite(m, e) = self.density(own, own) else { return None };
        if samples == 0 {
            return None;
        }
        let power = |n: u64, m: u64, e: i32| ((n * m).pow(beta), e * beta as i32);
        let mut sum = Exact::zero();
        for j in 0..self.techniques.len() {
            let n = self.techniques[j].1;
            let (m, e) = match (self.density(own, j), self.lacks_pole(own, j)) {
                _ if n == 0 => continue,
                (Size::Zero, _) | (Size::Finite(..), true) => continue,
                // At a pole of both the densities are alike.
                (Size::Infinite, true) => (m, e),
                (Size::Infinite, false) => return Some(0.0),
                (Size::Finite(m, e), false) => (m, e),
            };
            let (m, e) = power(n, m, e);
            sum.add(m, e);
        }
        let (m, e) = power(samples, m, e);
        Some(sum.under(m, e) / samples as f64)
    }
}

/// Compares all weights of random cases; returns how many were strictly between zero and one.
fn compare<R: Scalar, H: Heuristic<R> + Default>(reach: i32, beta: u32, tolerance: f64) -> usize {
    let mut between = 0;
    for seed in 0..4000 {
        let case = Case::random(seed, reach);
        let arena = Arena::<Spot<R>, Given>::new();
        let paths: Vec<(RandomSequence<'_, Spot<R>, Given>, usize)> = case
            .techniques
            .iter()
            .map(|(strategies, count)| {
                let mut path = arena.sequence();
                strategies.iter().for_each(|given| _ = path.append(*given));
                path.sample(&mut || R::ZERO);
                (path, *count as usize)
            })
            .collect();
        for (own, weighted) in combine::<H, _>(&paths).enumerate() {
            let found = weighted.weight.to_f64();
            assert!((0.0..=1.0).contains(&found), "{seed} {own}: {found}");
            let Some(expected) = case.weight(own, beta) else { continue };
            // Beyond the range of R a ratio is zero or infinite.
            let close =
                (found - expected).abs() <= tolerance * expected + 64.0 * R::MIN_POSITIVE.to_f64();
            assert!(close, "{seed} {own}: {found:e} {expected:e}");
            between += usize::from(0.01 < expected && expected < 0.99);
        }
    }
    between
}

#[test]
fn weights_are_those_of_exact_arithmetic() {
    assert!(compare::<f64, BalanceHeuristic>(1020, 1, 1e-14) > 2000);
    assert!(compare::<f64, PowerHeuristic>(1020, 2, 1e-14) > 2000);
    assert!(compare::<f32, BalanceHeuristic>(120, 1, 4e-6) > 2000);
    assert!(compare::<f32, PowerHeuristic>(120, 2, 4e-6) > 2000);
}

#[test]
fn the_exact_arithmetic_is_exact() {
    let mut sum = Exact::zero();
    sum.add(3, -5000);
    sum.add(u64::MAX, 17);
    sum.add(1, 17);
    assert_eq!(sum.under(1, 81), 1.0);
    assert_eq!(sum.under(6, 80), 3.0);
    let mut small = Exact::zero();
    small.add(3, -8200);
    assert_eq!(small.under(1, -8200), 1.0 / 3.0);
}

/// Steps between the points of a fixed path, in single precision: forwards from point k with the density
/// of that point, backwards with another one.
#[derive(Clone, Copy, Debug)]
struct Hop {
    backwards: bool,
}

const LENGTH: usize = 1000;

/// The density of reaching point k, between 1e-12 and 1e12, mostly far from one.
fn hop(k: usize, backwards: bool) -> f64 {
    let phase = if backwards { 0.3 } else { 0.0 };
    let x = (0.05 * k as f64).sin() + 0.05 * (1.3 * k as f64 + phase).cos();
    f64::from(10f64.powf(12.0 * x / 1.05) as f32)
}

impl Strategy<Spot<f32>> for Hop {
    fn sample<U: UniformSource<f32> + ?Sized>(
        &self,
        path: PathView<'_, Spot<f32>>,
        _: &mut U,
    ) -> Option<Drawn<Spot<f32>>> {
        let end = if self.backwards { LENGTH as f32 - 1.0 } else { 0.0 };
        let step = if self.backwards { -1.0 } else { 1.0 };
        Some(Drawn::new(Spot(path.last().map_or(end, |spot| spot.0 + step))))
    }
    fn pdf(&self, _: PathView<'_, Spot<f32>>, target: &Spot<f32>) -> Conditional<f32> {
        Conditional::density(hop(target.0 as usize, self.backwards) as f32)
    }
    fn reads(&self) -> Reads {
        Reads { vertices: 1, length: false }
    }
    fn same(&self, other: &Self) -> bool {
        self.backwards == other.backwards
    }
}

/// A measurement that is as large as the density of the technique that goes forwards all the way.
struct Forwards;

impl PathIntegrand for Forwards {
    type Vertex = Spot<f32>;
    type Value = f32;
    fn extend(&self, path: PathView<'_, Spot<f32>>) -> f32 {
        path.last().map_or(0.0, |spot| hop(spot.0 as usize, false) as f32)
    }
    fn end(&self, _: PathView<'_, Spot<f32>>) -> f32 {
        2.0
    }
}

#[test]
fn weights_of_a_thousand_vertices_sum_to_one_in_single_precision() {
    let arena = Arena::<Spot<f32>, Hop>::new();
    let subpath = |backwards| {
        let mut path = arena.sequence();
        (0..LENGTH).for_each(|_| _ = path.append(Hop { backwards }));
        path.sample(&mut || 0.0f32);
        path
    };
    let (camera, light) = (subpath(false), subpath(true));
    let joined = |s: usize| camera.slice(0..s).concat(&light.slice(0..LENGTH - s).reverse());
    // All of them would take seconds; where they are joined does not matter.
    let joints: Vec<usize> = (0..=LENGTH).step_by(5).collect();
    let techniques = arena.collect(joints.iter().map(|s| joined(*s)));
    // ln(p / p_forwards) in double precision.
    let relative: Vec<f64> = joints
        .iter()
        .map(|s| (*s..LENGTH).map(|k| (hop(k, true) / hop(k, false)).ln()).sum())
        .collect();
    let total: f64 = relative.iter().map(|ln| ln.exp()).sum();
    let estimator = Estimator::paths(Forwards);
    let mut sum = 0.0;
    let mut extremes = (f64::INFINITY, 0.0f64);
    for (k, path) in combine::<BalanceHeuristic, _>(techniques).enumerate() {
        let (weight, expected) = (f64::from(path.weight), relative[k].exp() / total);
        assert!((weight / expected - 1.0).abs() < 1e-4, "{k}: {weight} {expected}");
        sum += path.weight;
        extremes = (extremes.0.min(weight), extremes.1.max(weight));
        assert!(path.pdf().is_regular());
        let throughput = f64::from(estimator.of(&path));
        let expected = 2.0 * (-relative[k]).exp();
        assert!((throughput / expected - 1.0).abs() < 1e-3, "{k}: {throughput} {expected}");
    }
    assert!((sum - 1.0).abs() < 1e-4, "{sum}");
    // The weights are not all alike.
    assert!(extremes.1 > 1.5 * extremes.0, "{extremes:?}");
    // The product of the densities along the way leaves the range of a float many times.
    let mut product = 0.0f64;
    let ranges = (0..LENGTH).map(|k| {
        product += hop(k, false).log10();
        product
    });
    let (low, high) = ranges.fold((0.0f64, 0.0f64), |(a, b), x| (a.min(x), b.max(x)));
    assert!(high - low > 200.0, "{low} {high}");
}
