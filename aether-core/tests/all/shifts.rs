//! Differences of paths along a walk and shifted ones, in a world with an exact answer.
//!
//! Two pixels share the interval: the first sees [0, 1/4), the second the rest. A shift moves the first vertex that is seen from
//! one to the other, q ↦ q ± 1/2 with q its square root, and copies steps until both paths are in the bright part
//! of the world, where they meet.

use std::cell::Cell;

use crate::world::{Camera, Mean, Seen, Spot, Step, World};
use aether_core::estimator::{Ending, Endings, Shifts};
use aether_core::shift::{Moved, Shift, Turn};
use aether_core::{
    Arena, Conditional, Dirac, Drawn, Estimator, PathIntegrand, PathView, Pcg32, PowerHeuristic,
    RandomSequence, Reads, Strategy, UniformSource, strategies,
};

/// What a pixel sees: the second, or the first.
#[derive(Clone, Copy, PartialEq)]
struct Pixel {
    second: bool,
}

impl Strategy<Spot> for Pixel {
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        _: PathView<'_, Spot>,
        uniforms: &mut U,
    ) -> Option<Drawn<Spot>> {
        let u: f64 = uniforms.next();
        Some(Drawn::new(Spot(if self.second { 0.25 + 0.75 * u } else { 0.25 * u })).visible())
    }
    fn pdf(&self, _: PathView<'_, Spot>, target: &Spot) -> Conditional<f64> {
        let density = if self.second { 1.0 / 0.75 } else { 4.0 };
        Conditional::density(if (target.0 >= 0.25) == self.second { density } else { 0.0 })
    }
    fn reads(&self) -> Reads {
        Reads::NOTHING
    }
    fn same(&self, other: &Self) -> bool {
        self == other
    }
}

/// A spot about a place that is told in a coordinate of its own: its square root, or its quotient by what the spot
/// before makes of it.
#[derive(Clone, Copy, PartialEq)]
struct About {
    middle: f64,
    first: bool,
}

impl About {
    /// How the coordinate is drawn: it cancels.
    const WIDTH: f64 = 0.01;

    fn scale(path: PathView<'_, Spot>) -> f64 {
        path.last().map_or(f64::NAN, |before| 0.5 + 0.5 * before.0)
    }

    fn coordinate(first: bool, path: PathView<'_, Spot>, spot: Spot) -> f64 {
        if first { spot.0.sqrt() } else { spot.0 / Self::scale(path) }
    }
}

impl Strategy<Spot> for About {
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        path: PathView<'_, Spot>,
        uniforms: &mut U,
    ) -> Option<Drawn<Spot>> {
        let q = self.middle + Self::WIDTH * (uniforms.next() - 0.5);
        let x = if self.first { q * q } else { q * Self::scale(path) };
        (q > 0.0 && x <= 1.0).then(|| Drawn::new(Spot(x)).visible())
    }
    fn pdf(&self, path: PathView<'_, Spot>, target: &Spot) -> Conditional<f64> {
        let q = Self::coordinate(self.first, path, *target);
        let inside = (q - self.middle).abs() <= 0.5 * Self::WIDTH;
        let change = if self.first { 2.0 * q } else { Self::scale(path) };
        Conditional::density(if inside { 1.0 / (Self::WIDTH * change) } else { 0.0 })
    }
    fn reads(&self) -> Reads {
        Reads { vertices: 1, length: false }
    }
    fn same(&self, other: &Self) -> bool {
        self == other
    }
}

/// Where a mirror leads.
#[derive(Clone, Copy)]
struct Mirror;
impl Strategy<Spot> for Mirror {
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        path: PathView<'_, Spot>,
        _: &mut U,
    ) -> Option<Drawn<Spot>> {
        Some(Drawn::atom(Spot(1.0 - path.back(1)?.0), Dirac::Direction).visible())
    }
    fn pdf(&self, _: PathView<'_, Spot>, _: &Spot) -> Conditional<f64> {
        Conditional::atom(Dirac::Direction, 1.0)
    }
    fn reads(&self) -> Reads {
        Reads::TWO
    }
    fn same(&self, _: &Self) -> bool {
        true
    }
}

/// A point of one half of the light: which one depends on the two vertices before.
#[derive(Clone, Copy)]
struct Half;
impl Half {
    /// Where the half begins.
    fn start(path: PathView<'_, Spot>) -> f64 {
        let [here, before] = [0, 1].map(|k| path.back(k).map_or(0.0, |spot| spot.0));
        if here + before < 0.9 { 0.0 } else { 0.5 }
    }
}
impl Strategy<Spot> for Half {
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        path: PathView<'_, Spot>,
        uniforms: &mut U,
    ) -> Option<Drawn<Spot>> {
        Some(Drawn::new(Spot(Self::start(path) + 0.5 * uniforms.next())))
    }
    fn pdf(&self, path: PathView<'_, Spot>, target: &Spot) -> Conditional<f64> {
        let inside = (0.0..0.5).contains(&(target.0 - Self::start(path)));
        Conditional::density(if inside { 2.0 } else { 0.0 })
    }
    fn reads(&self) -> Reads {
        Reads::TWO
    }
    fn same(&self, _: &Self) -> bool {
        true
    }
}

strategies! {
    #[derive(Clone)]
    enum Ways<'w> for Spot {
        Camera(Camera),
        Pixel(Pixel),
        Step(Step<'w>),
        Half(Half),
        About(About),
        Mirror(Mirror),
    }
}

/// What happened to vertices: kept, copied, copied at a mirror, lost.
#[derive(Default, Debug)]
struct Met([Cell<u32>; 4]);

impl Met {
    fn note(&self, what: usize) {
        self.0[what].set(self.0[what].get() + 1);
    }
}

/// To the second pixel, or to the first.
#[derive(Clone, Copy)]
struct Across<'m> {
    to_second: bool,
    /// How many vertices it says that it reads.
    reads: usize,
    /// Whether it keeps vertices at mirrors too.
    hasty: bool,
    met: &'m Met,
}

impl<'w> Shift<Spot, Ways<'w>> for Across<'_> {
    fn inverse(&self) -> Self {
        Across { to_second: !self.to_second, ..*self }
    }
    fn vertex(&self, turn: &Turn<'_, Spot>) -> Moved<Ways<'w>> {
        let Turn { base, shifted, ends, directed } = *turn;
        let (i, Some(spot)) = (shifted.len(), base.last()) else { return Moved::Lost };
        if i == 0 {
            return Moved::Kept;
        }
        if i == 1 {
            let middle = spot.0.sqrt() + if self.to_second { 0.5 } else { -0.5 };
            return Moved::Copied(About { middle, first: true }.into());
        }
        let bright = |spot: Option<Spot>| spot.is_some_and(|spot| spot.0 >= 0.2);
        let leaves = base.carries(i - 1, Dirac::Direction);
        let meet = (!leaves || self.hasty) && bright(base.back(1)) && bright(shifted.last());
        if meet && (ends || ((!directed || self.hasty) && bright(Some(spot)))) {
            self.met.note(0);
            return Moved::Kept;
        }
        if leaves {
            self.met.note(2);
            return Moved::Copied(Mirror.into());
        }
        let Some(before) = base.back(1) else { return Moved::Lost };
        self.met.note(1);
        let middle = spot.0 / (0.5 + 0.5 * before.0);
        Moved::Copied(About { middle, first: false }.into())
    }
    fn technique(&self, i: usize) -> Option<Ways<'w>> {
        (i == 1).then_some(Pixel { second: self.to_second }.into())
    }
    fn reads(&self) -> usize {
        self.reads
    }
}

/// The light of the world through fog with holes, where edges pass that no step has found.
struct Foggy<'w>(Seen<'w>);
impl PathIntegrand for Foggy<'_> {
    type Vertex = Spot;
    type Value = f64;
    fn extend(&self, path: PathView<'_, Spot>) -> f64 {
        let i = path.len() - 1;
        let hidden = match (path.back(1), path.last()) {
            (Some(from), Some(to)) if i > 0 => !path.visible(i) && !passes(&from, &to),
            _ => false,
        };
        let before = path.back(2).map_or(0.0, |spot| spot.0);
        let dark = hidden || (0.6..0.7).contains(&before);
        if dark { 0.0 } else { self.0.extend(path) * (1.0 + before) }
    }
    fn end(&self, path: PathView<'_, Spot>) -> f64 {
        // Some is dark.
        path.last().map_or(0.0, |spot| {
            if ((spot.0 * 7.0) as u32).is_multiple_of(2) { 0.0 } else { spot.0 }
        })
    }
}

fn passes(from: &Spot, to: &Spot) -> bool {
    !(((from.0 + to.0) * 9.0) as u32).is_multiple_of(3)
}

/// What is found: contributions by length and number of steps, and the differences of the shift across and of none.
type Found = (Vec<(usize, usize, f64, f64)>, [f64; 2]);

fn found<I: PathIntegrand<Vertex = Spot, Value = f64>>(
    integrand: I,
    world: &World,
    shift: Across<'_>,
    sees: impl Fn(&Spot, &Spot) -> bool,
    (seed, longest): (u64, usize),
    long: bool,
) -> Found {
    let (arena, estimator) = (Arena::new(), Estimator::paths(integrand));
    let mut uniforms = Pcg32::new(3, 0, seed);
    let mut start: RandomSequence<'_, Spot, Ways<'_>> = arena.sequence();
    start.append(Camera).append(Pixel { second: !shift.to_second });
    let (half, step): ([Ways<'_>; 1], Ways<'_>) = ([Half.into()], Step(world).into());
    let two = [step.clone(), Half.into()];
    let ways: [&[Ways<'_>]; 3] = [&[], &half, &two];
    let ways = if long { &ways[..] } else { &ways[..2] };
    let is_used = |_: usize, _: &[Ways<'_>]| true;
    let endings = Endings { lengths: 3..=longest, ways, is_used };
    let shifts = Shifts { shifts: [Some(shift), None], shortest: 3, sees };
    let mut all = Vec::new();
    let visit = |end: Ending<'_, Ways<'_>, f64>| {
        all.push((end.length, end.steps.len(), end.value, end.alone));
    };
    let differences = estimator.differences(
        &start,
        &step,
        &endings,
        &shifts,
        &PowerHeuristic,
        &mut uniforms,
        visit,
    );
    (all, differences)
}

#[test]
fn differences_are_those_of_paths_that_are_made() {
    let world = World::with_mirror(0.4);
    let met = Met::default();
    let is_near = |x: f64, y: f64| (x - y).abs() <= 1e-12 * (x.abs() + y.abs()) + 1e-14;
    let (mut nonzero, mut paths) = (0, 0);
    for seed in 0..4000 {
        let to_second = seed % 2 == 0;
        let of = |reads: usize| {
            let shift = Across { to_second, reads, hasty: seed % 4 < 2, met: &met };
            found(Foggy(Seen(&world)), &world, shift, passes, (seed, 7), false)
        };
        let ((short, a), (made, b)) = (of(2), of(3));
        assert_eq!(short.len(), made.len());
        for (x, y) in short.iter().zip(&made) {
            assert!((x.0, x.1) == (y.0, y.1), "{seed}: {x:?} {y:?}");
            assert!(is_near(x.2, y.2) && is_near(x.3, y.3), "{seed}: {x:?} {y:?}");
        }
        assert!(is_near(a[0], b[0]) && a[1] == 0.0 && b[1] == 0.0, "{seed}: {a:?} {b:?}");
        (nonzero, paths) = (nonzero + usize::from(a[0] != 0.0), paths + short.len());
    }
    assert!(nonzero > 2000 && paths > 2000, "{nonzero} {paths}");
    assert!(met.0[..3].iter().all(|n| n.get() > 300), "{met:?}");
}

/// Differences there and back against what both pixels see, estimated from the same walks: |z| > 5 is a false alarm
/// with probability 6e-7.
#[test]
fn differences_there_and_back_add_up_to_that_of_both_pixels() {
    let (short, long) = (60_000, 20_000);
    for (mirror, error, samples) in [
        (0.0, 1.0, short),
        (0.4, 1.0, short),
        (0.4, 1.05, short),
        (0.0, 1.0, long),
        (0.4, 1.0, long),
    ] {
        let world = World::with_mirror(mirror);
        let (met, mut mean, mut plain) = (Met::default(), Mean::default(), Mean::default());
        let mut squares = [0.0; 2];
        for seed in 0..samples {
            let [(first, across), (second, back)] = [true, false].map(|to_second| {
                let hasty = seed % 2 == 0;
                let shift = Across { to_second, reads: 2, hasty, met: &met };
                let seen = |_: &Spot, _: &Spot| true;
                let seed = 2 * seed + u64::from(to_second);
                found(Seen(&world), &world, shift, seen, (seed, 6), samples == long)
            });
            let sum = |found: &[(usize, usize, f64, f64)]| found.iter().map(|f| f.2).sum::<f64>();
            let direct = sum(&second) - sum(&first);
            let shifted = across[0] - back[0];
            mean.add(error * shifted - direct);
            plain.add(direct);
            squares = [squares[0] + shifted * shifted, squares[1] + direct * direct];
        }
        let z = mean.z(0.0);
        assert_eq!(z.abs() > 5.0, error != 1.0, "mirror {mirror}, times {error}: {z}");
        // Both pixels do not see the same.
        assert!(plain.z(0.0).abs() > 5.0);
        println!("mean squares {squares:?}");
    }
}
