//! Samplers with atoms. Expected values are closed forms written here by hand, from the distribution and not from what
//! was derived.

mod maps;

use aether_core::discrete::shares;
use aether_core::mixed::{Parts, WithAtoms};
use aether_core::prelude::*;
use aether_core::strategy::Vertex;
use aether_core::{
    Arena, BalanceHeuristic, Combine, Estimator, Heuristic, PathIntegrand, PathView, Pcg32,
    PowerHeuristic, combine, draw_uniforms, mixture,
};

/// Free flight that ends at a wall, if it gets there.
#[sampler(extinction in 0.0..=1e4, wall in 0.0..=1e4)]
fn flight(u: [Uniform; 1], extinction: f64, wall: f64) -> Mixed {
    let t = -(-u[0]).ln_1p() / extinction;
    if t < wall { Mixed::Continuous(t) } else { Mixed::Atom(0, wall) }
}

/// Distances that are equally likely, up to the same wall.
#[sampler(p in 0.0..=1.0, wall in 0.0..=1e4)]
fn uniform_flight(u: [Uniform; 1], p: f64, wall: f64) -> Mixed {
    if u[0] < p { Mixed::Atom(0, wall) } else { Mixed::Continuous(wall * (u[0] - p) / (1.0 - p)) }
}

/// A mirror beside a cosine lobe about +z.
#[sampler(p in 0.0..=1.0)]
fn mirror_and_lobe(u: [Uniform; 2], p: f64, mirror: Direction) -> Mixed<Direction> {
    if u[0] < p {
        return Mixed::Atom(0, mirror);
    }
    let v = (u[0] - p) / (1.0 - p);
    let r = v.sqrt();
    let phi = TAU * u[1];
    Mixed::Continuous(Direction::new(r * phi.cos(), r * phi.sin(), (1.0 - v).sqrt()))
}

/// A normal variable that is held up by a wall on either side.
#[sampler(left in -30.0..=30.0, right in -30.0..=30.0, where left < right)]
fn two_walls(u: [Uniform; 1], left: f64, right: f64) -> Mixed {
    let x = normal_quantile(u[0]);
    if x < left {
        Mixed::Atom(0, left)
    } else if x > right {
        Mixed::Atom(1, right)
    } else {
        Mixed::Continuous(x)
    }
}

/// A Cauchy variable between walls.
#[sampler(left in -1e9..=1e9, right in -1e9..=1e9, where left < right)]
fn cauchy_walls(u: [Uniform; 1], left: f64, right: f64) -> Mixed {
    let x = (PI * (u[0] - 0.5)).tan();
    if x < left {
        Mixed::Atom(0, left)
    } else if x > right {
        Mixed::Atom(1, right)
    } else {
        Mixed::Continuous(x)
    }
}

/// An interval of uniforms leads to an atom, of which the ends may lie outside.
#[sampler(a in -0.5..=1.5, b in 0.0..=2.0)]
fn band(u: [Uniform; 1], a: f64, b: f64) -> Mixed {
    if u[0] > a && u[0] < b { Mixed::Atom(0, -1.0) } else { Mixed::Continuous(u[0]) }
}

/// What is absorbed in a slab is taken to be at its front.
#[sampler(extinction in 0.1..=2.0, near in 0.0..=1.0, far in 0.0..=3.0, where near < far)]
fn slab(u: [Uniform; 1], extinction: f64, near: f64, far: f64) -> Mixed {
    let t = -(-u[0]).ln_1p() / extinction;
    if t > near && t < far { Mixed::Atom(2, near) } else { Mixed::Continuous(t) }
}

/// The root of a uniform, or an atom below a threshold that need not be positive.
#[sampler(c in -0.5..=1.5)]
fn threshold(u: [Uniform; 1], c: f64) -> Mixed {
    if u[0].sqrt() < c { Mixed::Atom(0, 0.0) } else { Mixed::Continuous(u[0].sqrt()) }
}

/// An atom by two uniforms, no sample by one of them alone, and the same atom by yet another way.
#[sampler(a in 0.0..=1.0, b in 0.0..=1.0)]
fn corner(u: [Uniform; 2], a: f64, b: f64) -> Option<Mixed<Vec2>> {
    let at = Vec2::new(a, b);
    if u[0] < a {
        return if u[1] < b { Some(Mixed::Atom(5, at)) } else { None };
    }
    if u[1] > 0.875 {
        return Some(Mixed::Atom(5, at));
    }
    Some(Mixed::Continuous(Vec2::new(u[0], u[1])))
}

/// No parameters.
#[sampler]
fn ends(u: [Uniform; 1]) -> Mixed {
    if u[0] < 0.25 {
        Mixed::Atom(0, -1.0)
    } else if u[0] > 0.875 {
        Mixed::Atom(7, 2.0)
    } else {
        Mixed::Continuous(u[0])
    }
}

/// An atom that is there only if the parameters say so.
#[sampler(extinction in 1e-3..=1e3)]
fn maybe_a_wall(u: [Uniform; 1], extinction: f64, wall: f64) -> Mixed {
    let t = -(-u[0]).ln_1p() / extinction;
    if wall > 0.0 && t > wall { Mixed::Atom(0, wall) } else { Mixed::Continuous(t) }
}

fn flight_of(extinction: f64, wall: f64) -> Flight {
    flight(extinction, wall).expect("legal parameters")
}

#[track_caller]
fn close(found: f64, expected: f64, ulp: f64) {
    let gap = (found - expected).abs();
    assert!(gap <= ulp * f64::EPSILON * expected.abs(), "{found:e}, expected {expected:e}");
}

/// Gauss's rule with five points in each of many cells.
fn integral(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    const NODES: [(f64, f64); 5] = [
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_1),
        (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    ];
    const CELLS: usize = 400;
    let h = (to - from) / CELLS as f64;
    let cell = |k: usize| {
        let middle = from + (k as f64 + 0.5) * h;
        NODES.iter().map(|(x, w)| 0.5 * h * w * f(middle + 0.5 * h * x)).sum::<f64>()
    };
    (0..CELLS).map(cell).sum()
}

/// The mass of the continuous part and of the atoms.
fn mass<S: Parts<f64, Place = f64>>(sampler: &S, from: f64, to: f64) -> (f64, f64) {
    let continuous = sampler.continuous();
    let atoms = S::ATOMS.iter().map(|number| sampler.probability(*number)).sum();
    (integral(from, to, |x| continuous.pdf(&x).value()), atoms)
}

/// Uniforms of a fixed sequence.
fn uniforms<S: Sampler<f64>>(seed: u64, k: u64) -> S::Uniforms {
    draw_uniforms(&mut Pcg32::new(seed, 0, k))
}

const DRAWS: u64 = 200_000;
/// A count that is further from its mean, in standard deviations: by chance in 7 of a million.
const FAR: f64 = 4.5;

/// Draws, and compares the counts of atoms with their probabilities, the density of each sample by its uniforms with that by
/// its value, and preimages with uniforms.
#[track_caller]
fn drawn<S>(sampler: S)
where
    S: Parts<f64, Place: PartialEq>,
{
    drawn_within(sampler, 64.0);
}

/// The same, with this many roundings between the density by uniforms and by value.
#[track_caller]
fn drawn_within<S>(sampler: S, ulp: f64)
where
    S: Parts<f64, Place: PartialEq>,
{
    let mut counts = vec![0.0; S::ATOMS.len()];
    for k in 0..DRAWS {
        let u = uniforms::<S>(7, k);
        let x = sampler.sample(u);
        if !x.is_valid() {
            assert_eq!(x.pdf().value(), 0.0);
            continue;
        }
        let (own, other) = (x.pdf().value(), sampler.pdf(&x).value());
        close(own, other, ulp);
        assert!(own > 0.0);
        let found = sampler.invert(&x);
        match x.value() {
            Mixed::Atom(number, at) => {
                let place = S::ATOMS.iter().position(|n| *n == number).expect("a known atom");
                counts[place] += 1.0;
                assert_eq!(sampler.place(number), Some(at));
                assert!(found.is_empty() && own == other);
            }
            Mixed::Continuous(_) => {
                let near = |v: S::Uniforms| {
                    v.as_ref().iter().zip(u.as_ref()).all(|(a, b)| (a - b).abs() < 1e-9)
                };
                assert!(found.iter().any(near), "{u:?} of {:?}", x.value());
            }
        }
    }
    for (number, count) in S::ATOMS.iter().zip(counts) {
        let (n, p) = (DRAWS as f64, sampler.probability(*number));
        let deviation = (n * p * (1.0 - p)).sqrt();
        assert!((count - n * p).abs() <= FAR * deviation, "atom {number}: {count} of {n}, {p}");
    }
}

#[test]
fn the_probability_of_a_wall_keeps_its_digits() {
    for depth in [1e-300, 1e-12, 1e-3, 0.5, 1.0, 7.0, 40.0, 300.0, 700.0] {
        // A product that is exact.
        let f = flight_of(2.0, 0.5 * depth);
        // The exponent is rounded relatively, which counts as often as it is large.
        close(f.probability(0), (-depth).exp(), 2.0);
        let log = f.log_probability(0);
        assert!((log + depth).abs() <= 4.0 * f64::EPSILON * depth.max(1.0), "{log:e}");
        // Beyond a depth of 40 there is nothing to be seen in double precision.
        let end = f.place(0).expect("one wall").min(20.0);
        let (continuous, atom) = mass(&f, 0.0, end);
        close(continuous, -(-depth).exp_m1(), 4096.0);
        close(continuous + atom, 1.0, 4096.0);
    }
    // Where the probability is no number any more, its logarithm is.
    let far = flight_of(1e3, 1e3);
    assert_eq!(far.probability(0), 0.0);
    assert_eq!(far.log_pdf(&Mixed::Atom(0, 1e3)), -1e6);
    assert_eq!(far.probability(1), 0.0);
    assert_eq!(far.log_pdf(&Mixed::Atom(1, 1e3)), f64::NEG_INFINITY);
    assert_eq!(far.place(1), None);
}

#[test]
fn an_atom_may_have_all_or_nothing() {
    // No medium, and no way to the wall.
    for f in [flight_of(0.0, 3.0), flight_of(2.0, 0.0)] {
        assert_eq!(f.probability(0), 1.0);
        for k in 0..1000 {
            let x = f.sample(uniforms::<Flight>(1, k));
            assert!(x.is_valid() && x.atom() == Some(0) && x.pdf().value() == 1.0);
        }
    }
    let up = Direction::new(0.0, 0.0, 1.0);
    for (p, atom) in [(0.0, None), (1.0, Some(0))] {
        let m = mirror_and_lobe(p, up).expect("legal");
        assert_eq!(m.probability(0), p);
        for k in 0..1000 {
            let x = m.sample(uniforms::<MirrorAndLobe>(1, k));
            assert!(x.is_valid() && x.atom() == atom && x.pdf().value() > 0.0);
        }
    }
    for (c, p) in [(-0.5, 0.0), (-1e-9, 0.0), (0.5, 0.25), (1.0, 1.0), (1.5, 1.0)] {
        assert_eq!(threshold(c).expect("legal").probability(0), p);
    }
    for (a, b, p) in [
        (-0.5, 2.0, 1.0),
        (-0.25, 0.25, 0.25),
        (0.75, 1.25, 0.25),
        (0.25, 0.75, 0.5),
        (0.75, 0.25, 0.0),
        (1.25, 2.0, 0.0),
        (-0.5, 0.0, 0.0),
        (1.5, 0.5, 0.0),
    ] {
        assert_eq!(band(a, b).expect("legal").probability(0), p, "between {a} and {b}");
    }
}

#[test]
fn tails_on_both_sides_keep_their_digits() {
    // Φ(-20) and Φ(-3), by mpmath at 50 digits.
    let (far, near) = (2.753_624_118_606_233_7e-89, 1.349_898_031_630_094_5e-3);
    // The rounding of x / √2 counts x² times.
    let walls = two_walls(-20.0, 3.0).expect("legal");
    close(walls.probability(0), far, 800.0);
    close(walls.probability(1), near, 18.0);
    let walls = two_walls(-3.0, 20.0).expect("legal");
    close(walls.probability(0), near, 18.0);
    close(walls.probability(1), far, 800.0);
    let (continuous, atoms) = mass(&walls, -3.0, 20.0);
    close(continuous + atoms, 1.0, 4096.0);
    // atan(1e-8) / π is the tail beyond 1e8.
    let walls = cauchy_walls(-1e8, 1e6).expect("legal");
    close(walls.probability(0), 1e-8f64.atan() / PI, 8.0);
    close(walls.probability(1), 1e-6f64.atan() / PI, 8.0);
    let walls = cauchy_walls(-0.5, 2.0).expect("legal");
    let (continuous, atoms) = mass(&walls, -0.5, 2.0);
    close(continuous + atoms, 1.0, 4096.0);
    // A thin slab: exp(-a) - exp(-b) for a next to b.
    let (near, thickness) = (0.5, 2f64.powi(-40));
    let thin = slab(1.0, near, near + thickness).expect("legal");
    close(thin.probability(2), (-near).exp() * -(-thickness).exp_m1(), 8.0);
}

#[test]
fn shares_of_samples_are_probabilities() {
    drawn(flight_of(2.0, 0.7));
    drawn(flight_of(0.01, 0.5));
    drawn(uniform_flight(0.3, 2.0).expect("legal"));
    drawn(mirror_and_lobe(0.25, Direction::new(0.6, 0.0, 0.8)).expect("legal"));
    drawn(two_walls(-0.5, 1.0).expect("legal"));
    drawn(cauchy_walls(-2.0, 0.5).expect("legal"));
    drawn(band(0.2, 0.6).expect("legal"));
    drawn(slab(0.7, 0.5, 2.0).expect("legal"));
    drawn(threshold(0.4).expect("legal"));
    drawn(corner(0.25, 0.5).expect("legal"));
    drawn(ends());
}

#[test]
fn ways_to_one_atom_add_up() {
    let c = corner(0.25, 0.5).expect("legal");
    assert_eq!(Corner::<f64>::ATOMS, [5]);
    assert_eq!(c.probability(5), 0.25 * 0.5 + 0.75 * 0.125);
    let far = Corner::<f64>::DERIVATION;
    assert!(far.pdf.contains("atom 5"), "{}", far.pdf);
    assert_eq!(ends().pdf(&Mixed::Atom(7, 2.0)).value(), 0.125);
    assert_eq!(<Ends as Parts<f64>>::ATOMS, [0, 7]);
}

#[test]
fn parameters_close_a_way() {
    let with = maybe_a_wall(2.0, 0.5).expect("legal");
    close(with.probability(0), (-1.0f64).exp(), 2.0);
    assert_eq!(with.place(0), Some(0.5));
    let without = maybe_a_wall(2.0, -0.5).expect("legal");
    assert_eq!(without.probability(0), 0.0);
    assert_eq!(without.place(0), None);
    close(without.pdf(&Mixed::Continuous(3.0)).value(), 2.0 * (-6.0f64).exp(), 8.0);
    drawn(with);
    drawn(without);
}

#[test]
fn a_point_at_the_place_of_an_atom_is_not_on_it() {
    let up = Direction::new(0.0, 0.0, 1.0);
    let m = mirror_and_lobe(0.25, up).expect("legal");
    let density: Density<WithAtoms<SolidAngle>> = m.pdf(&Mixed::Continuous(up));
    close(density.value(), 0.75 / PI, 4.0);
    assert_eq!(m.pdf(&Mixed::Atom(0, up)).value(), 0.25);
    let below = Direction::new(0.0, 0.6, -0.8);
    assert_eq!(m.pdf(&Mixed::Continuous(below)).value(), 0.0);
    // The lobe over the hemisphere, in rings of equal z.
    let ring = |z: f64| {
        let w = Direction::new((1.0 - z * z).sqrt(), 0.0, z);
        TAU * m.continuous().pdf(&w).value()
    };
    close(integral(0.0, 1.0, ring), 0.75, 4096.0);
}

#[test]
fn single_precision_has_the_same_atoms() {
    let f = flight::<f32>(2.0, 3.0).expect("legal");
    let p = f.probability(0);
    assert!((p - (-6f32).exp()).abs() <= 4.0 * f32::EPSILON * p);
    let x = f.sample([0.999f32]);
    assert_eq!(x.value(), Mixed::Atom(0, 3.0));
    assert_eq!(x.pdf().value(), p);
}

/// An integrand with a value on the wall: the integral of t² exp(-t) up to it, and half as much again at it.
fn integrand(x: &Mixed) -> f64 {
    match x {
        Mixed::Continuous(t) => t * t * (-t).exp(),
        Mixed::Atom(0, wall) => 0.5 * wall,
        Mixed::Atom(..) => unreachable!("there is one wall"),
    }
}

fn expected(wall: f64) -> f64 {
    2.0 - (wall * wall + 2.0 * wall + 2.0) * (-wall).exp() + 0.5 * wall
}

/// The mean of estimates, which must be no further from the expected value than chance explains (7 in a million).
#[track_caller]
fn unbiased(expected: f64, estimate: impl Fn(u64) -> f64) {
    let (mut sum, mut squares) = (0.0, 0.0);
    for k in 0..DRAWS {
        let e = estimate(k);
        sum += e;
        squares += e * e;
    }
    let n = DRAWS as f64;
    let (mean, spread) = (sum / n, ((squares / n - (sum / n).powi(2)) / n).sqrt());
    assert!((mean - expected).abs() <= FAR * spread, "{mean} ± {spread}, expected {expected}");
    assert!(spread < 0.01 * expected, "the test says nothing: {spread}");
}

fn by_two_techniques<H: Heuristic<f64> + Default>(wall: f64) {
    let (a, b) = (flight_of(1.5, wall), uniform_flight(0.125, wall).expect("legal"));
    unbiased(expected(wall), |k| {
        let (x, y) = (a.sample(uniforms::<Flight>(3, k)), b.sample(uniforms::<Flight>(4, k)));
        let weighted = combine::<H, _>((&x, (&y, 1)));
        weighted.iter().map(|w| w.weight * integrand(w) / w.pdf).sum()
    });
}

#[test]
fn techniques_with_one_atom_combine_without_bias() {
    by_two_techniques::<BalanceHeuristic>(2.0);
    by_two_techniques::<PowerHeuristic>(2.0);
    // On the atom, probabilities are weighed against probabilities.
    let (a, b) = (flight_of(1.5, 2.0), uniform_flight(0.125, 2.0).expect("legal"));
    let (x, y) = (a.sample([0.999]), b.sample([0.5]));
    let [on, off] = (&x, &y).combine_with(BalanceHeuristic);
    let wall = (-3.0f64).exp();
    close(on.weight, wall / (wall + 0.125), 8.0);
    let t = y.point();
    let (of_a, of_b) = (1.5 * (-1.5 * t).exp(), 0.875 / 2.0);
    close(off.weight, of_b / (of_a + of_b), 8.0);
}

#[test]
fn a_mixture_of_samplers_with_atoms_has_their_atoms() {
    let (a, b) = (flight_of(1.5, 2.0), uniform_flight(0.125, 2.0).expect("legal"));
    let both = mixture((a, b), shares([0.25, 0.75])).expect("two of both");
    let wall = Mixed::Atom(0, 2.0);
    close(both.pdf(&wall).value(), 0.25 * (-3.0f64).exp() + 0.75 * 0.125, 8.0);
    close(
        both.pdf(&Mixed::Continuous(1.0)).value(),
        0.25 * 1.5 * (-1.5f64).exp() + 0.75 * 0.875 / 2.0,
        8.0,
    );
    unbiased(expected(2.0), |k| {
        let x = both.sample(uniforms::<Flight>(5, k));
        close(x.pdf().value(), both.pdf(&x).value(), 64.0);
        integrand(&x) / x.pdf().value()
    });
}

/// A vertex that lives where flights end.
#[derive(Clone, Copy, Debug)]
struct Stop(Mixed);

impl Vertex for Stop {
    type Real = f64;
    type Point = Mixed;
    fn point(&self) -> Mixed {
        self.0
    }
}

/// Draws such a vertex.
#[strategy]
fn fly(path: &PathView<Stop>, extinction: f64, wall: f64) -> Stop {
    let x = draw(flight_of(extinction, wall));
    Stop(x)
}

struct AtTheEnd;

impl PathIntegrand for AtTheEnd {
    type Vertex = Stop;
    type Value = f64;
    fn extend(&self, _: PathView<'_, Stop>) -> f64 {
        1.0
    }
    fn end(&self, path: PathView<'_, Stop>) -> f64 {
        path.last().map_or(0.0, |stop| integrand(&stop.0))
    }
}

#[test]
fn a_strategy_draws_vertices_with_atoms() {
    let estimator = Estimator::paths(AtTheEnd);
    unbiased(expected(2.0), |k| {
        let arena: Arena<Stop, Fly> = Arena::new();
        let mut random = Pcg32::new(6, 0, k);
        let techniques = [0.5, 2.5].map(|extinction| {
            let mut path = arena.sequence();
            path.append(fly(extinction, 2.0)).sample(&mut random);
            path
        });
        estimator.sum(combine::<PowerHeuristic, _>(&techniques))
    });
}
