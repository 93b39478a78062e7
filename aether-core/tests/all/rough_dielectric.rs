//! Scattering at dielectrics: a choice whose probability depends on the half vector drawn before it,
//! a density that depends on the two vertices before, and a choice between two atoms.

use std::cell::Cell;

use crate::oracle::{LIMIT, chi_square, midpoint};
use aether_core::PathView;
use aether_core::coin;
use aether_core::prelude::*;
use aether_core::strategy::{Dirac, Reads, Recall, Strategy, Vertex};
use aether_core::uniform::Pcg32;

/// Index of refraction below the plane z = 0; above it is one.
const INDEX: f64 = 1.5;

/// A place on a path, found in a direction from the one before.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stop {
    position: Vec3,
    arrived: Direction,
}

impl Stop {
    fn at(position: Vec3) -> Stop {
        Stop { position, arrived: Direction::new(0.0, 0.0, 1.0) }
    }
    /// One unit further.
    fn onwards(&self, w: Direction) -> Stop {
        Stop { position: self.position + w.vec(), arrived: w }
    }
}

impl Vertex for Stop {
    type Real = f64;
    type Point = Direction;
    fn point(&self) -> Direction {
        self.arrived
    }
}

/// Half vectors about +z with the distribution of GGX (Walter et al. 2007, Eqs. 35, 36).
#[sampler]
fn ggx(u: [Uniform; 2], alpha: f64) -> Direction {
    let t = alpha * (u[0] / (1.0 - u[0])).sqrt();
    let z = 1.0 / (1.0 + t * t).sqrt();
    let phi = TAU * u[1];
    Direction::new(t * z * phi.cos(), t * z * phi.sin(), z)
}

#[map]
fn rotate(w: Direction, frame: Frame) -> Direction {
    Direction::from_vec(frame.to_world(w))
}

/// Mirrors w about the half vector.
#[map]
fn reflect(h: Direction, w: Direction) -> Direction {
    let c = h.dot(w);
    require(c > 0.0);
    Direction::from_vec(2.0 * c * h - w)
}

/// Refracts w at the half vector, into the denser side.
#[map(eta in 0.2..=0.99)]
fn refract_in(h: Direction, w: Direction, eta: f64) -> Direction {
    let c = h.dot(w);
    require(c > 0.0);
    let k = (1.0 - eta * eta * (1.0 - c * c)).sqrt() - eta * c;
    Direction::from_vec(-(k * h + eta * w))
}

/// Refracts w at the half vector, into the thinner side, if it is not reflected totally.
#[map(eta in 1.05..=1.7)]
fn refract_out(h: Direction, w: Direction, eta: f64) -> Direction {
    let c = h.dot(w);
    require(c > 0.0);
    let s = 1.0 - eta * eta * (1.0 - c * c);
    require(s > 0.0);
    let k = eta * c - s.sqrt();
    Direction::from_vec(k * h - eta * w)
}

/// How much of what comes from the side of index n at the cosine c is reflected by index m, averaged
/// over polarisation (Fresnel); one where all is.
fn fresnel(c: f64, n: f64, m: f64) -> f64 {
    let sine = n / m * (1.0 - c * c).max(0.0).sqrt();
    if sine >= 1.0 {
        return 1.0;
    }
    let d = (1.0 - sine * sine).sqrt();
    let (s, p) = ((n * c - m * d) / (n * c + m * d), (m * c - n * d) / (m * c + n * d));
    0.5 * (s * s + p * p)
}

/// Fresnel's coefficient, counting how often it is needed.
fn counted_fresnel(c: f64, n: f64, m: f64, count: &Cell<usize>) -> f64 {
    count.set(count.get() + 1);
    fresnel(c, n, m)
}

/// Reflects or refracts at a half vector, with the probability that Fresnel gives there.
#[strategy]
fn scatter(path: &PathView<Stop>, alpha: f64, count: &Cell<usize>) -> Stop {
    let here = given(path.last());
    let before = given(path.back(1));
    let w = Direction::from_vec(before.position - here.position);
    let above = w.z > 0.0;
    let (n, m) = if above { (1.0, INDEX) } else { (INDEX, 1.0) };
    let frame = Frame::around(Direction::new(0.0, 0.0, if above { 1.0 } else { -1.0 }));
    let local = draw(ggx(alpha));
    let h = rotate(frame).apply(&local);
    let cosine = h.dot(w);
    if cosine <= 0.0 {
        return stop();
    }
    let reflects = choose(coin(counted_fresnel(cosine, n, m, count)));
    if reflects {
        return here.onwards(reflect(w).apply(&h));
    }
    if above {
        let refraction = given(refract_in(w, 1.0 / INDEX).ok());
        here.onwards(refraction.apply(&h))
    } else {
        let refraction = given(refract_out(w, INDEX).ok());
        here.onwards(refraction.apply(&h))
    }
}

/// The path that comes from direction w.
fn arriving(w: Direction) -> [Stop; 2] {
    [Stop::at(w.vec()), Stop::at(Vec3::ZERO)]
}

fn density<S: Strategy<Stop>>(strategy: &S, from: Direction, to: Direction) -> f64 {
    let path = arriving(from);
    strategy.pdf(PathView::from_slice(&path), &Stop::at(Vec3::ZERO).onwards(to)).value
}

/// The distribution of half vectors times their cosine (Walter et al. 2007, Eq. 33).
fn half_vectors(cosine: f64, alpha: f64) -> f64 {
    let (c2, a2) = (cosine * cosine, alpha * alpha);
    let d = c2 * (a2 - 1.0) + 1.0;
    if cosine > 0.0 { cosine * a2 / (PI * d * d) } else { 0.0 }
}

/// The density as the textbook has it (Walter et al. 2007, Eqs. 14, 17), for w above or below.
fn textbook(alpha: f64, i: Direction, o: Direction) -> f64 {
    let side = i.z.signum();
    let (n, m) = if side > 0.0 { (1.0, INDEX) } else { (INDEX, 1.0) };
    let mut sum = 0.0;
    // Reflection.
    let mut h = (i.vec() + o.vec()).normalize();
    if h.z * side < 0.0 {
        h = -h;
    }
    if i.dot(h) > 0.0 && o.dot(h) > 0.0 {
        sum += half_vectors(h.z.abs(), alpha) * fresnel(i.dot(h), n, m) / (4.0 * o.dot(h));
    }
    // Refraction.
    let mut h = -(n * i.vec() + m * o.vec()).normalize();
    if h.z * side < 0.0 {
        h = -h;
    }
    if i.dot(h) > 0.0 && o.dot(h) < 0.0 {
        let root = n * i.dot(h) + m * o.dot(h);
        let change = m * m * o.dot(h).abs() / (root * root);
        sum += half_vectors(h.z.abs(), alpha) * (1.0 - fresnel(i.dot(h), n, m)) * change;
    }
    sum
}

fn direction(z: f64, phi: f64) -> Direction {
    let r = (1.0 - z * z).sqrt();
    Direction::new(r * phi.cos(), r * phi.sin(), z)
}

const ARRIVALS: [(f64, f64); 4] = [(0.9, 0.3), (0.35, 2.0), (-0.95, 1.0), (-0.6, 5.0)];

#[test]
fn the_density_of_a_rough_dielectric_is_the_textbooks() {
    let count = Cell::new(0);
    for (alpha, (z, phi)) in [0.1, 0.4, 0.9].into_iter().flat_map(|a| ARRIVALS.map(|w| (a, w))) {
        let strategy = scatter(alpha, &count);
        let from = direction(z, phi);
        for k in 0..400 {
            let to = direction(((f64::from(k) + 0.5) / 200.0) - 1.0, 2.4 * f64::from(k));
            let (found, expected) = (density(&strategy, from, to), textbook(alpha, from, to));
            assert!(
                (found - expected).abs() <= 1e-10 * expected,
                "{found} {expected} from {from:?} to {to:?}"
            );
        }
    }
}

/// The integral of a density over the sphere, by polar angles from a pole where it may be infinite
/// like one over the distance.
fn mass(pole: Direction, f: impl Fn(Direction) -> f64) -> f64 {
    let frame = Frame::around(pole);
    midpoint(0.0, PI, 1200, |theta| {
        let (sine, cosine) = theta.sin_cos();
        let at = |phi: f64| Vec3::new(sine * phi.cos(), sine * phi.sin(), cosine);
        sine * midpoint(0.0, TAU, 600, |phi| f(Direction::from_vec(frame.to_world(at(phi)))))
    })
}

#[test]
fn the_density_of_a_rough_dielectric_integrates_to_what_is_not_lost() {
    let (alpha, count) = (0.4, Cell::new(0));
    let strategy = scatter(alpha, &count);
    for (z, phi) in ARRIVALS {
        let from = direction(z, phi);
        // Lost is what falls on the back of a half vector.
        let lost = mass(from, |h| {
            let faces = h.dot(from) > 0.0;
            if faces { 0.0 } else { half_vectors(h.z * from.z.signum(), alpha) }
        });
        // Where half vectors are seen edge on, the density of reflection has a pole.
        let straight_on = Direction::from_vec(-from.vec());
        let found = mass(straight_on, |w| density(&strategy, from, w));
        assert!((found - (1.0 - lost)).abs() < 2e-4, "{found} and {lost} lost, from {from:?}");
        assert!(z != 0.35 || lost > 1e-3, "nothing is lost: {lost}");
    }
}

/// The score of the samples of one strategy in the density of another, in cells of the sphere.
fn score<A: Strategy<Stop>, B: Strategy<Stop>>(samples: &A, like: &B, from: Direction) -> f64 {
    const COUNT: u64 = 100_000;
    let (rows, columns) = (16, 8);
    let path = arriving(from);
    let mut counts = vec![0.0; rows * columns + 1];
    for k in 0..COUNT {
        let drawn = samples.sample(PathView::from_slice(&path), &mut Pcg32::new(11, 0, k));
        let cell = drawn.map_or(rows * columns, |drawn| {
            let w = drawn.vertex.arrived;
            let phi = w.y.atan2(w.x).rem_euclid(TAU);
            let row = ((w.z + 1.0) / 2.0 * rows as f64) as usize;
            row.min(rows - 1) * columns + ((phi / TAU * columns as f64) as usize).min(columns - 1)
        });
        counts[cell] += 1.0;
    }
    let (dz, dphi) = (2.0 / rows as f64, TAU / columns as f64);
    let mut expected: Vec<f64> = (0..rows * columns)
        .map(|cell| {
            let (z, phi) = ((cell / columns) as f64 * dz - 1.0, (cell % columns) as f64 * dphi);
            let inner =
                |z| midpoint(phi, phi + dphi, 60, |phi| density(like, from, direction(z, phi)));
            COUNT as f64 * midpoint(z, z + dz, 60, inner)
        })
        .collect();
    expected.push(COUNT as f64 - expected.iter().sum::<f64>());
    chi_square(&counts, &expected)
}

#[test]
fn samples_of_a_rough_dielectric_follow_its_density() {
    let count = Cell::new(0);
    let strategy = scatter(0.5, &count);
    for (z, phi) in ARRIVALS {
        let from = direction(z, phi);
        let score = score(&strategy, &strategy, from);
        assert!(score < LIMIT, "{score} from {from:?}");
    }
    // The test can fail: ten per cent more roughness is another distribution.
    let other = scatter(0.55, &count);
    assert!(score(&strategy, &other, direction(0.9, 0.3)) > LIMIT);
}

#[test]
fn total_reflection_leaves_no_refraction() {
    let count = Cell::new(0);
    let strategy = scatter(1e-4, &count);
    // The critical angle is at the cosine 0.745; half vectors that differ enough have probability 1e-7.
    let from = direction(-0.5, 0.0);
    let path = arriving(from);
    for k in 0..1000 {
        let drawn = strategy.sample(PathView::from_slice(&path), &mut Pcg32::new(5, 0, k));
        let drawn = drawn.expect("all is reflected");
        assert!(drawn.vertex.arrived.z < 0.0, "{drawn:?}");
        assert!(density(&strategy, from, drawn.vertex.arrived) > 0.0);
    }
}

#[test]
fn fresnel_is_evaluated_where_there_is_a_half_vector_only() {
    let count = Cell::new(0);
    let strategy = scatter(0.3, &count);
    let above = direction(0.8, 0.0);
    let evaluations = |to: Direction| {
        count.set(0);
        let p = density(&strategy, above, to);
        (count.get(), p > 0.0)
    };
    // Reflected but not refracted there, and the other way round.
    assert_eq!(evaluations(direction(0.8, PI)), (1, true));
    assert_eq!(evaluations(direction(-0.9, PI)), (1, true));
    // Neither is possible.
    assert_eq!(evaluations(direction(-0.9, 0.0)), (0, false));
    assert_eq!(strategy.reads(), Reads::TWO);
}

/// Which way a vertex went at a smooth surface.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Went {
    Back,
    Through,
}

impl Went {
    /// Where what comes from w goes, at a smooth surface seen from above.
    fn away(self, w: Direction) -> Direction {
        match self {
            Went::Back => Direction::new(-w.x, -w.y, w.z),
            Went::Through => {
                let z = -(1.0 - (1.0 - w.z * w.z) / (INDEX * INDEX)).sqrt();
                Direction::new(-w.x / INDEX, -w.y / INDEX, z)
            }
        }
    }
}

impl Recall<Went> for Stop {
    fn recall(&self) -> Option<Went> {
        Some(if self.arrived.z > 0.0 { Went::Back } else { Went::Through })
    }
}

/// A smooth dielectric seen from above: two atoms.
#[strategy]
fn smooth(path: &PathView<Stop>) -> Stop {
    let here = given(path.last());
    let before = given(path.back(1));
    let w = Direction::from_vec(before.position - here.position);
    let reflects = choose(coin(fresnel(w.z, 1.0, INDEX)))
        .identified_by(|v: &Stop| Some(usize::from(v.arrived.z > 0.0)));
    let went = constant(smooth_way(&here, reflects));
    here.onwards(went.away(w))
}

fn smooth_way(_: &Stop, reflects: bool) -> Option<Went> {
    Some(if reflects { Went::Back } else { Went::Through })
}

#[test]
fn a_smooth_dielectric_has_two_atoms() {
    let path = arriving(direction(0.6, 0.0));
    let view = PathView::from_slice(&path);
    let reflectance = fresnel(0.6, 1.0, INDEX);
    let (mut back, count) = (0.0, 20_000);
    for k in 0..count {
        let drawn = smooth().sample(view, &mut Pcg32::new(2, 0, k)).expect("always scatters");
        assert_eq!((drawn.dirac, drawn.visible), (Some(Dirac::Direction), true));
        let probability = smooth().pdf(view.asking(drawn.dirac), &drawn.vertex).value;
        let reflected = drawn.vertex.arrived.z > 0.0;
        let expected = if reflected { reflectance } else { 1.0 - reflectance };
        assert_eq!(probability, expected);
        // It has no density, and is no atom of another kind.
        assert_eq!(smooth().pdf(view, &drawn.vertex).value, 0.0);
        assert_eq!(smooth().pdf(view.asking(Some(Dirac::Position)), &drawn.vertex).value, 0.0);
        back += f64::from(u8::from(reflected));
    }
    let deviation = (reflectance * (1.0 - reflectance) * count as f64).sqrt();
    // False alarm once in two million.
    assert!((back - reflectance * count as f64).abs() < 5.0 * deviation, "{back}");
}
