//! Sequences with joint runs: slices, reversals, concatenations, densities and weights, on a line.

use std::cell::Cell;

use aether_core::prelude::*;
use aether_core::sequence::{DynStrategy, Erased};
use aether_core::strategy::{Recall, Strategy, Vertex};
use aether_core::{
    Arena, BalanceHeuristic, PathView, Pcg32, PowerHeuristic, RandomSequence, Snapshot, coin,
    combine, combine_with, strategies,
};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot(pub f64);

impl Vertex for Spot {
    type Real = f64;
    type Point = f64;
    fn point(&self) -> f64 {
        self.0
    }
}

impl Recall<f64> for Spot {
    fn recall(&self) -> Option<f64> {
        Some(self.0)
    }
}

/// Uniform on [0, b).
#[sampler(b in 1e-6..=1e6)]
fn up_to(u: [Uniform; 1], b: f64) -> f64 {
    b * u[0]
}

/// The ends of a segment: its middle beyond a, half of its length up to 3.
#[sampler(width in 1e-6..=1e6)]
fn ends(u: [Uniform; 2], a: f64, width: f64) -> (f64, f64) {
    let (middle, half) = (a + width * u[0], 3.0 * u[1]);
    (middle - half, middle + half)
}

/// How often something happened.
#[derive(Debug, Default)]
pub struct Count(Cell<usize>);

impl Count {
    fn up(&self) -> f64 {
        self.0.set(self.0.get() + 1);
        1.0
    }
}

#[strategy]
pub fn start(path: &PathView<Spot>) -> Spot {
    let interval = given(up_to(6.0).ok());
    let x = draw(interval);
    Spot(x)
}

#[strategy]
pub fn step(path: &PathView<Spot>) -> Spot {
    let here = given(path.last());
    let interval = given(up_to(4.0 + here.0.abs()).ok());
    let x = draw(interval);
    Spot(x)
}

/// Two vertices, near the one before or anywhere.
#[strategy]
pub fn pair(path: &PathView<Spot>, evaluations: &Count) -> [Spot; 2] {
    let here = given(path.last());
    let unit = evaluations.up();
    let near = choose(coin(0.75 * unit));
    let segments =
        given(if near { ends(here.0, 1.0).ok() } else { ends(-2.0, 4.0 + here.0.abs()).ok() });
    let x = draw(segments);
    [Spot(x.0), Spot(x.1)]
}

/// At one place.
#[strategy]
fn lamp(path: &PathView<Spot>, place: f64) -> Spot {
    let place = constant(Some(place));
    Spot(place)
}

/// In a fixed direction from the vertex before.
#[strategy]
fn mirror(path: &PathView<Spot>) -> Spot {
    let here = given(path.last());
    let there = constant(Some(4.0 - here.0));
    Spot(there)
}

/// Two vertices in one of two places, the nearer the likelier to be kept.
#[strategy]
fn one_of_two(path: &PathView<Spot>) -> [Spot; 2] {
    let far = choose(coin(0.25)).identified_by(|run: &[Spot; 2]| [usize::from(run[0].0 > 10.0)]);
    let segments = given(ends(if far { 20.0 } else { 0.0 }, 1.0).ok());
    let x = draw(segments);
    let length = x.1 - x.0;
    let kept = choose(coin(1.0 - length / 6.0));
    if !kept {
        return stop();
    }
    [Spot(x.0), Spot(x.1)]
}

/// The same, at the beginning of a path; its parameter cannot be compared.
#[strategy]
pub fn first_pair(path: &PathView<Spot>, middle: (f64, f64)) -> [Spot; 2] {
    let segments = given(ends(middle.0, middle.1).ok());
    let x = draw(segments);
    [Spot(x.0), Spot(x.1)]
}

strategies! {
    #[derive(Clone)]
    pub enum Ways<'c> for Spot {
        Start(Start), Step(Step), Pair(Pair<'c>), FirstPair(FirstPair), Lamp(Lamp), Mirror(Mirror)
    }
}

pub type Walk<'a, 'c> = RandomSequence<'a, Spot, Ways<'c>>;

fn spots(path: &Walk<'_, '_>) -> Vec<f64> {
    path.vertices().map(|spot| spot.0).collect()
}

// The densities by hand.
fn p_start(x: f64) -> f64 {
    f64::from((0.0..6.0).contains(&x)) / 6.0
}
fn p_step(x: f64, y: f64) -> f64 {
    let b = 4.0 + x.abs();
    f64::from((0.0..b).contains(&y)) / b
}
fn p_ends(a: f64, width: f64, y: f64, z: f64) -> f64 {
    let (middle, half) = ((y + z) / 2.0, (z - y) / 2.0);
    let inside = (a..a + width).contains(&middle) && (0.0..3.0).contains(&half);
    f64::from(inside) / (6.0 * width)
}
fn p_pair(x: f64, y: f64, z: f64) -> f64 {
    0.75 * p_ends(x, 1.0, y, z) + 0.25 * p_ends(-2.0, 4.0 + x.abs(), y, z)
}

/// One of the techniques for paths of four vertices.
fn technique<'a, 'c>(
    arena: &'a Arena<Spot, Ways<'c>>,
    count: &'c Count,
    which: usize,
    uniforms: &mut Pcg32,
) -> Walk<'a, 'c> {
    let mut path = arena.sequence();
    match which {
        0 | 4 => path.append(start()).append(step()).append(step()).append(step()),
        1 | 5 => path.append(start()).append(pair(count)).append(step()),
        2 | 6 => path.append(start()).append(step()).append(pair(count)),
        _ => path.append(first_pair((1.0, 2.0))).append(pair(count)),
    };
    path.sample(uniforms);
    if which >= 4 { path.reverse() } else { path }
}

fn by_hand(which: usize, x: &[f64]) -> f64 {
    let mut x = x.to_vec();
    if which >= 4 {
        x.reverse();
    }
    match which {
        0 | 4 => p_start(x[0]) * p_step(x[0], x[1]) * p_step(x[1], x[2]) * p_step(x[2], x[3]),
        1 | 5 => p_start(x[0]) * p_pair(x[0], x[1], x[2]) * p_step(x[2], x[3]),
        2 | 6 => p_start(x[0]) * p_step(x[0], x[1]) * p_pair(x[1], x[2], x[3]),
        _ => p_ends(1.0, 2.0, x[0], x[1]) * p_pair(x[1], x[2], x[3]),
    }
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * b.abs()
}

#[test]
fn every_technique_knows_the_density_of_every_path() {
    let count = Count::default();
    let mut arena = Arena::new();
    let mut regular = 0;
    for sample in 0..200 {
        arena.clear();
        let mut uniforms = Pcg32::new(5, 0, sample);
        let paths: Vec<_> =
            (0..8).map(|which| technique(&arena, &count, which, &mut uniforms)).collect();
        for path in &paths {
            let x = spots(path);
            assert_eq!(x.len(), 4);
            let p: Vec<f64> = (0..8).map(|which| by_hand(which, &x)).collect();
            for (technique, expected) in paths.iter().zip(&p) {
                let found = technique.pdf_of(path).value();
                assert!(close(found, *expected), "{found} {expected}");
                regular += usize::from(*expected > 0.0);
            }
        }
        for (which, path) in paths.iter().enumerate() {
            assert!(close(path.pdf().value(), by_hand(which, &spots(path))));
        }
        let weights = combine::<PowerHeuristic, _>(&paths);
        for (which, path) in weights.enumerate() {
            let p: Vec<f64> = (0..8).map(|other| by_hand(other, &spots(&path))).collect();
            let expected = p[which].powi(2) / p.iter().map(|p| p * p).sum::<f64>();
            assert!(close(path.weight, expected), "{} {expected}", path.weight);
        }
    }
    // Not only zeros were compared.
    assert!(regular > 4000, "{regular}");
}

#[test]
fn a_run_reaches_no_atoms() {
    let (count, arena) = (Count::default(), Arena::new());
    let mut joint = arena.sequence();
    joint.append(first_pair((1.0, 2.0))).append(pair(&count)).sample(&mut Pcg32::new(1, 0, 0));
    let atoms: [fn(&mut Walk<'_, '_>); 4] = [
        |path| _ = path.append(lamp(0.5)).append(step()).append(step()).append(step()),
        |path| _ = path.append(start()).append(mirror()).append(step()).append(step()),
        |path| _ = path.append(start()).append(step()).append(mirror()).append(step()),
        |path| _ = path.append(start()).append(step()).append(step()).append(mirror()),
    ];
    let mut steps = arena.sequence();
    steps.append(start()).append(step()).append(step()).append(step());
    let mut possible = 0;
    for sample in 0..200 {
        for append in atoms {
            let mut path = arena.sequence();
            append(&mut path);
            path.sample(&mut Pcg32::new(2, 0, sample));
            assert!(path.is_complete() && joint.pdf_of(&path).is_zero());
            assert!(joint.reverse().pdf_of(&path).is_zero());
        }
        let mut path = steps;
        path.sample(&mut Pcg32::new(2, 0, sample));
        possible += usize::from(!joint.pdf_of(&path).is_zero());
    }
    assert!(possible > 5, "{possible}");
}

#[test]
fn choices_are_identified_by_the_run_and_weighed_after_inversion() {
    let nothing = PathView::from_slice(&[]);
    let mut kept = [0; 2];
    for sample in 0..2000 {
        let Some(run) = one_of_two().sample_joint(nothing, &mut Pcg32::new(9, 0, sample)) else {
            continue;
        };
        let &[y, z] = run.vertices() else { panic!("{run:?}") };
        let far = y.0 > 10.0;
        kept[usize::from(far)] += 1;
        let (weight, a) = if far { (0.25, 20.0) } else { (0.75, 0.0) };
        let expected = weight * p_ends(a, 1.0, y.0, z.0) * (1.0 - (z.0 - y.0) / 6.0);
        let found = one_of_two().pdf_joint(nothing, &[y, z]);
        assert!(expected > 0.0 && close(found, expected), "{found} {expected}");
    }
    // Half are kept; standard errors 22 and 15.
    assert!((640..860).contains(&kept[0]) && (175..325).contains(&kept[1]), "{kept:?}");
}

#[test]
fn a_run_is_one_factor_wherever_its_path_is_put() {
    let (count, arena) = (Count::default(), Arena::new());
    let mut uniforms = Pcg32::new(1, 0, 0);
    let mut path = arena.sequence();
    path.append(start()).append(pair(&count)).append(step()).sample(&mut uniforms);
    assert_eq!((path.len(), path.size()), (4, 4));
    let x = spots(&path);
    let p = p_pair(x[0], x[1], x[2]);
    let factors: Vec<_> = (0..4).filter_map(|i| path.conditional(i)).collect();
    assert!(factors[1] == 1.0 && close(factors[2], p));
    let reversed = path.reverse();
    assert!(reversed.conditional(2) == Some(1.0) && reversed.conditional(1) == Some(factors[2]));
    assert_eq!(path.pdf(), reversed.pdf());
    assert_eq!(path.pdf(), path.slice(0..1).concat(&path.slice(1..)).pdf());
    assert!(close(path.slice(0..3).pdf().value(), p_start(x[0]) * p));
    let glued = reversed.slice(0..1).concat(&reversed.slice(1..4)).reverse();
    assert_eq!(spots(&glued), x);
    assert_eq!(glued.pdf(), path.pdf());
    // Told from what was drawn or evaluated: either way it is remembered.
    let before = count.0.get();
    (0..4).for_each(|_| _ = (path.pdf(), glued.pdf(), path.pdf_of(&glued)));
    assert!(count.0.get() <= before + 1);
}

#[test]
fn a_run_cannot_be_cut() {
    let (count, arena) = (Count::default(), Arena::new());
    let mut uniforms = Pcg32::new(2, 0, 0);
    let mut path = arena.sequence();
    path.append(start()).append(pair(&count)).append(step()).sample(&mut uniforms);
    let x = spots(&path);
    path.pdf();
    for (from, to) in [(0, 2), (2, 4), (2, 3), (1, 2)] {
        let piece = path.slice(from..to);
        assert_eq!(spots(&piece), x[from..to]);
        assert!(piece.is_complete() && piece.pdf().is_zero() && piece.reverse().pdf().is_zero());
        assert!(piece.pdf_of(&piece).is_zero());
    }
    // What is cut has its density again when it is joined.
    let joined = path.slice(0..2).concat(&path.slice(2..4));
    assert_eq!(joined.pdf(), path.pdf());
    // The halves in another order are no run.
    let crossed = path.slice(2..3).concat(&path.slice(1..2));
    assert!(crossed.pdf().is_zero());
    assert!(path.slice(0..2).concat(&path.slice(2..3).reverse()).pdf().is_zero());
    // A piece is no technique: it weighs nothing, and takes no weight from the others.
    let mut other = path.slice(0..1);
    other.append(step()).sample(&mut uniforms);
    let weights: Vec<_> =
        combine::<BalanceHeuristic, _>([path.slice(0..2), other]).map(|p| p.weight).collect();
    assert_eq!(weights, [0.0, 1.0]);
    // Also where the rest of the path is whole, and the factors that are left out are the same.
    let mut steps = arena.sequence();
    steps.append(start()).append(step()).append(step()).append(step()).sample(&mut uniforms);
    let patched = path.slice(0..2).concat(&steps.slice(2..4));
    assert!(patched.pdf().is_zero() && patched.pdf_of(&path).is_zero());
    let ratio_of_other = |ratios: &[f64], own: usize| ratios[1 - own];
    let ratios: Vec<_> = combine_with(ratio_of_other, [path, patched]).map(|p| p.weight).collect();
    assert_eq!(ratios, [0.0, f64::INFINITY]);
    // Nor can a piece be drawn.
    let mut pending = arena.sequence();
    pending.append(start()).append(pair(&count));
    let mut half = pending.slice(0..2);
    half.sample(&mut uniforms);
    assert_eq!((half.len(), half.is_complete()), (1, false));
    pending.sample(&mut uniforms);
    assert_eq!(pending.len(), 3);
}

#[test]
fn copies_and_snapshots() {
    let (count, mut arena) = (Count::default(), Arena::new());
    let mut snapshot = Snapshot::new();
    for which in 0..8 {
        arena.clear();
        let path = technique(&arena, &count, which, &mut Pcg32::new(3, 0, 0));
        let (x, p) = (spots(&path), path.pdf());
        snapshot.store(&path);
        arena.clear();
        let again = arena.restore(&snapshot);
        assert!(spots(&again) == x && close(again.pdf().ratio(p), 1.0), "{which}");
    }
    // A copy that goes on for itself.
    let mut a = arena.sequence();
    a.append(start()).append(pair(&count));
    let mut b = a;
    a.sample(&mut Pcg32::new(3, 0, 0));
    b.append(step()).sample(&mut Pcg32::new(3, 0, 1));
    assert_eq!((a.len(), b.len()), (3, 4));
    assert_ne!(a.vertex(1), b.vertex(1));
    assert!(a.pdf().is_regular() && b.pdf().is_regular());
}

#[test]
fn behind_pointers() {
    let count = Count::default();
    let (start, pair, step) = (start(), pair(&count), step());
    let chosen: [&dyn DynStrategy<Spot>; 3] = [&start, &pair, &step];
    let arena = Arena::<Spot, Erased<'_, Spot>>::new();
    let mut path = arena.sequence();
    for strategy in chosen {
        path.append(Erased(strategy));
    }
    path.sample(&mut Pcg32::new(4, 0, 0));
    let x: Vec<f64> = path.vertices().map(|spot| spot.0).collect();
    assert!(close(path.pdf().value(), by_hand(1, &x)));
    assert!(close(path.reverse().pdf().value(), by_hand(1, &x)));
}
