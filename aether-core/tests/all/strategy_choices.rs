//! Choices in strategies: nested, dependent on each other and on what was drawn, among many, among
//! other strategies; and mixtures of samplers. Expected values are enumerated by hand.
//!
//! Distributions are compared by Pearson's test with a false-alarm rate of one in a million.

use std::cell::Cell;

use crate::oracle::{LIMIT, chi_square, midpoint};
use aether_core::discrete::{
    Cdf, Choices, Discrete, Tree, TreeBuilder, WeightError, coin, discrete_weighted, shares,
};
use aether_core::mixture::{Mixture, mixture};
use aether_core::prelude::*;
use aether_core::strategy::{Conditional, Dirac, Drawn, Reads, Recall, Strategy, Vertex};
use aether_core::{
    Arena, PathView, Pcg32, PdfOf, PowerHeuristic, UniformSource, battery, combine, strategies,
};

/// A point of the line; `id` names what it lies on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Spot {
    x: f64,
    id: Option<u32>,
}

impl Spot {
    fn at(x: f64) -> Spot {
        Spot { x, id: None }
    }
}

impl Vertex for Spot {
    type Real = f64;
    type Point = f64;
    fn point(&self) -> f64 {
        self.x
    }
}

impl Recall<u32> for Spot {
    fn recall(&self) -> Option<u32> {
        self.id
    }
}

/// Uniform on [a, a + length).
#[sampler(length in 1e-3..=1e3)]
fn interval(u: [Uniform; 1], a: f64, length: f64) -> f64 {
    a + length * u[0]
}

/// Uniform on [a, a + 1).
#[sampler]
fn unit(u: [Uniform; 1], a: f64) -> f64 {
    a + u[0]
}

/// Density 2 (x - a) on [a, a + 1).
#[sampler]
fn ramp(u: [Uniform; 1], a: f64) -> f64 {
    a + u[0].sqrt()
}

/// Shifts by a distance.
#[map]
fn shift(x: f64, distance: f64) -> f64 {
    x + distance
}

/// A sampler that counts how often its density is evaluated.
#[derive(Clone, Copy, Debug)]
struct Counted<'c, S>(S, &'c Cell<usize>);

impl<S: Sampler<f64>> Sampler<f64> for Counted<'_, S> {
    type Uniforms = S::Uniforms;
    type Point = S::Point;
    fn forward(&self, u: S::Uniforms) -> (S::Point, bool) {
        self.0.forward(u)
    }
    fn pdf(&self, x: &S::Point) -> PdfOf<S, f64> {
        self.1.set(self.1.get() + 1);
        self.0.pdf(x)
    }
    fn pdf_of_uniforms(&self, u: S::Uniforms) -> PdfOf<S, f64> {
        self.0.pdf_of_uniforms(u)
    }
    fn preimages(&self, x: &S::Point, visit: impl FnMut(S::Uniforms, bool)) {
        self.0.preimages(x, visit);
    }
}

fn pdf<S: Strategy<Spot>>(strategy: &S, target: Spot) -> f64 {
    let here = [Spot::at(0.5)];
    strategy.pdf(PathView::from_slice(&here), &target).value
}

/// The score of samples on [from, to), and of those that are not there, in a density.
fn score<S: Strategy<Spot>>(strategy: &S, from: f64, to: f64, density: impl Fn(f64) -> f64) -> f64 {
    const COUNT: u64 = 50_000;
    let here = [Spot::at(0.5)];
    let mut found = Vec::new();
    for k in 0..COUNT {
        let drawn = strategy.sample(PathView::from_slice(&here), &mut Pcg32::new(6, 0, k));
        found.push(drawn.filter(|drawn| drawn.dirac.is_none()).map(|drawn| drawn.vertex.x));
    }
    score_of(&found, from, to, density)
}

fn score_of(found: &[Option<f64>], from: f64, to: f64, density: impl Fn(f64) -> f64) -> f64 {
    let (cells, count) = (40, found.len() as f64);
    let width = (to - from) / cells as f64;
    let mut counts = vec![0.0; cells + 1];
    for x in found {
        let cell =
            x.filter(|x| (from..to).contains(x)).map_or(cells, |x| ((x - from) / width) as usize);
        counts[cell.min(cells)] += 1.0;
    }
    let start = |k: usize| from + width * k as f64;
    let mut expected: Vec<f64> =
        (0..cells).map(|k| count * midpoint(start(k), start(k + 1), 500, &density)).collect();
    expected.push(count - expected.iter().sum::<f64>());
    chi_square(&counts, &expected)
}

fn follows<S: Strategy<Spot>>(strategy: &S, from: f64, to: f64) {
    let right = score(strategy, from, to, |x| pdf(strategy, Spot::at(x)));
    assert!(right < LIMIT, "{right}");
    // It can fail: for a density that is wrong by a few per cent in a part.
    let wrong = |x: f64| pdf(strategy, Spot::at(x)) * if x < (from + to) / 2.0 { 0.9 } else { 1.1 };
    assert!(score(strategy, from, to, wrong) > LIMIT);
}

/// Rooms, the doors of which lead to corners; the first coin depends on the path, the second choice
/// on the first, the third exists in some rooms only.
#[strategy]
fn nested(path: &PathView<Spot>, rooms: &Choices<Vec<f64>, f64>) -> Spot {
    let here = given(path.last());
    let &room = choose(rooms);
    let corner = choose(shares([1.0, 1.0 + room, here.x]));
    let start = room + 0.25 * corner as f64;
    let x = if corner == 2 {
        let leaps = choose(coin(0.2 + 0.1 * room));
        if leaps { draw(ramp(start + 1.0)) } else { draw(unit(start)) }
    } else {
        draw(unit(start))
    };
    Spot::at(x)
}

#[test]
fn nested_and_dependent_choices_add_up_over_all_outcomes() {
    let rooms = discrete_weighted(vec![0.0, 1.0, 2.0], [0.5, 0.2, 0.3]).unwrap();
    let strategy = nested(&rooms);
    let expected = |x: f64| {
        let within = |x: f64| f64::from(u8::from((0.0..1.0).contains(&x)));
        let mut sum = 0.0;
        for (room, p) in [(0.0, 0.5), (1.0, 0.2), (2.0, 0.3)] {
            let total = 1.0 + 1.0 + room + 0.5;
            sum += p * (1.0 / total) * within(x - room);
            sum += p * ((1.0 + room) / total) * within(x - room - 0.25);
            let (leap, y) = (0.2 + 0.1 * room, x - room - 0.5);
            sum += p * (0.5 / total) * (1.0 - leap) * within(y);
            sum += p * (0.5 / total) * leap * 2.0 * (y - 1.0) * within(y - 1.0);
        }
        sum
    };
    for k in 0..400 {
        let x = 0.012 * f64::from(k) - 0.1937;
        assert!((pdf(&strategy, Spot::at(x)) - expected(x)).abs() < 1e-14, "{x}");
    }
    follows(&strategy, 0.0, 4.6);
}

/// Two choices after a draw, the second of which depends on it and on the first.
#[strategy]
fn late(path: &PathView<Spot>) -> Spot {
    let h = draw(unit(0.0));
    let square = h * h;
    let way = choose(shares([square, h, 1.0]));
    let x = match way {
        0 => shift(2.0).apply(&h),
        1 => {
            let again = choose(coin(1.0 - h));
            if again { shift(4.0).apply(&h) } else { shift(1.0).apply(&shift(5.0).apply(&h)) }
        }
        _ => return stop(),
    };
    Spot::at(x)
}

#[test]
fn several_outcomes_may_depend_on_what_was_drawn() {
    let strategy = late();
    let p = |x| pdf(&strategy, Spot::at(x));
    for h in [0.05, 0.3, 0.77, 0.999] {
        let total = h * h + h + 1.0;
        // The probabilities of `shares` are whole multiples of 2^-53.
        let near = |found: f64, expected: f64| (found - expected).abs() < 1e-14;
        assert!(near(p(2.0 + h), h * h / total));
        assert!(near(p(4.0 + h), h / total * (1.0 - h)));
        assert!(near(p(6.0 + h), h / total * h));
        assert_eq!((p(h), p(3.0 + h)), (0.0, 0.0));
    }
    follows(&strategy, 2.0, 7.0);
}

/// The same by a rule that tells the way from the vertex, with the inner choice enumerated.
#[strategy]
fn late_identified(path: &PathView<Spot>) -> Spot {
    let h = draw(unit(0.0));
    let way = choose(shares([h * h, h])).identified_by(|v: &Spot| (v.x > 2.0).then_some(0));
    let x = if way == 0 { shift(2.0).apply(&h) } else { shift(1.5).apply(&h) };
    Spot::at(x)
}

#[test]
fn a_choice_that_depends_on_what_was_drawn_may_be_identified() {
    let p = |x| pdf(&late_identified(), Spot::at(x));
    assert!((p(2.25) - 0.25 / 1.25).abs() < 1e-14);
    // The rule says that nothing leads there.
    assert_eq!(p(1.75), 0.0);
}

/// A lamp at a place; lamp k covers [place, place + 1).
type Lamps = Tree<u32, (f64, f64)>;

fn lamps(count: u32) -> Lamps {
    let mut builder = TreeBuilder::new();
    for k in 0..count {
        let place = 0.01 * f64::from(k);
        // Every tenth lamp is there twice.
        for _ in 0..if k % 10 == 0 { 2 } else { 1 } {
            builder.leaf(k, 1.0 + f64::from(k % 3), (place, place));
        }
    }
    builder.pair_up(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    builder.build().unwrap()
}

/// How important lamps between two places are, seen from x.
fn importance<'c>(x: f64, calls: &'c Cell<usize>) -> impl Fn(&(f64, f64), f64) -> f64 + 'c {
    move |range, weight| {
        calls.set(calls.get() + 1);
        let distance = x - x.clamp(range.0, range.1);
        weight / (0.1 + distance * distance)
    }
}

/// A lamp by its importance here, and a point near it.
#[strategy]
fn lamp(path: &PathView<Spot>, lamps: &Lamps, calls: &Cell<usize>) -> Spot {
    let here = given(path.last());
    let &lamp = choose(lamps.seen_by(importance(here.x, calls))).identified_by(|v: &Spot| {
        v.id.map(|id| lamps.leaves_of(&id).iter().copied()).into_iter().flatten()
    });
    let x = draw(unit(0.01 * f64::from(lamp)));
    Spot { x, id: Some(lamp) }
}

/// The same lamps without a rule: any of them may have made the vertex, which does not say which.
#[strategy]
fn any_lamp(path: &PathView<Spot>, lamps: &Lamps, calls: &Cell<usize>) -> Spot {
    let here = given(path.last());
    let &lamp = choose(lamps.seen_by(importance(here.x, calls)));
    let x = draw(unit(0.01 * f64::from(lamp)));
    Spot { x, id: None }
}

#[test]
fn of_many_lamps_the_one_that_made_a_vertex_is_looked_up() {
    let (lamps, calls) = (lamps(1000), Cell::new(0));
    let (known, any) = (lamp(&lamps, &calls), any_lamp(&lamps, &calls));
    // Each lamp by its own: the sum of its leaves.
    let view = lamps.seen_by(importance(0.5, &calls));
    let expected = |id: u32| view.pdf(&id).value();
    for id in [0, 7, 50, 333, 990, 999] {
        let x = 0.01 * f64::from(id) + 0.5;
        calls.set(0);
        let found = pdf(&known, Spot { x, id: Some(id) });
        // Two branches a level, eleven levels, two leaves.
        assert!(calls.get() <= 44, "{} importances for lamp {id}", calls.get());
        assert!((found - expected(id)).abs() < 1e-15);
        assert_eq!(pdf(&known, Spot { x: x + 1.0, id: Some(id) }), 0.0);
    }
    assert_eq!(pdf(&known, Spot { x: 0.5, id: None }), 0.0);
    assert_eq!(pdf(&known, Spot { x: 0.5, id: Some(1000) }), 0.0);
    // What is not known is enumerated, and is the sum.
    for x in [0.004, 0.5, 3.217, 10.503] {
        let covers = |id: &u32| (0.0..1.0).contains(&(x - 0.01 * f64::from(*id)));
        let sum: f64 = (0..1000).filter(covers).map(expected).sum();
        calls.set(0);
        assert!((pdf(&any, Spot::at(x)) - sum).abs() < 1e-12, "{x}");
        // Each branch once: 1100 leaves.
        assert_eq!(calls.get(), 2 * 1099);
    }
}

#[test]
fn of_lamps_that_cannot_be_told_apart_all_add_up() {
    let (lamps, calls) = (lamps(60), Cell::new(0));
    follows(&any_lamp(&lamps, &calls), 0.0, 1.7);
}

/// Outcomes without probability, and atoms beside densities.
#[strategy]
fn pruned(path: &PathView<Spot>, weights: [f64; 3], count: &Cell<usize>) -> Spot {
    let mirror = choose(coin(0.5)).identified_by(|v: &Spot| Some(usize::from(v.id.is_some())));
    if mirror {
        let id = constant(Some(3));
        return Spot { x: 9.0, id: Some(id) };
    }
    let which = choose(shares(weights));
    let x = draw(Counted(unit(which as f64), count));
    Spot::at(x)
}

#[test]
fn impossible_choices_are_not_evaluated() {
    let count = Cell::new(0);
    let here = [Spot::at(0.5)];
    let view = PathView::from_slice(&here);
    let evaluations = |weights, view: PathView<'_, Spot>, target: Spot| {
        count.set(0);
        let _ = pruned(weights, &count).pdf(view, &target);
        count.get()
    };
    assert_eq!(evaluations([1.0, 2.0, 1.0], view, Spot::at(0.5)), 3);
    assert_eq!(evaluations([1.0, 0.0, 0.0], view, Spot::at(0.5)), 1);
    // The rule says that it was the mirror, and the mirror has no density.
    let mirrored = Spot { x: 9.0, id: Some(3) };
    assert_eq!(evaluations([1.0, 2.0, 1.0], view, mirrored), 0);
    // An atom is asked for: samplers cannot make it.
    let atom = view.asking(Some(Dirac::Position));
    assert_eq!(evaluations([1.0, 2.0, 1.0], atom, Spot::at(0.5)), 0);
    assert_eq!(pruned([1.0; 3], &count).pdf(atom, &mirrored).value, 0.5);
}

#[strategy]
fn late_pruned(path: &PathView<Spot>, count: &Cell<usize>) -> Spot {
    let h = draw(unit(0.0));
    let first = choose(coin(f64::from(u8::from(h < 0.5))));
    let second = choose(coin(tally(count, h)));
    let x = match (first, second) {
        (true, true) => shift(1.0).apply(&h),
        (true, false) => shift(2.0).apply(&h),
        _ => return stop(),
    };
    Spot::at(x)
}

fn tally(count: &Cell<usize>, p: f64) -> f64 {
    count.set(count.get() + 1);
    p
}

#[test]
fn after_an_impossible_outcome_nothing_more_is_weighed() {
    let count = Cell::new(0);
    let p = pdf(&late_pruned(&count), Spot::at(1.25));
    assert_eq!((p, count.get()), (0.25, 1));
    // h = 0.75: the first coin never shows heads, so the second one is not looked at.
    count.set(0);
    assert_eq!((pdf(&late_pruned(&count), Spot::at(1.75)), count.get()), (0.0, 0));
}

#[strategy]
fn step(path: &PathView<Spot>, start: f64) -> Spot {
    let here = given(path.last());
    let x = draw(unit(here.x + start));
    Spot::at(x)
}

#[strategy]
fn remembering(path: &PathView<Spot>) -> Spot {
    let earlier = given(path.back(2));
    if path.len() > 7 {
        return stop();
    }
    let x = draw(ramp(earlier.x));
    Spot::at(x)
}

#[strategy]
fn mirror(path: &PathView<Spot>, id: u32) -> Spot {
    let found = constant(Some(id));
    Spot { x: f64::from(id), id: Some(found) }
}

/// One of three strategies, or none; one of them is given.
#[strategy]
fn composite<S: Strategy<Spot>>(path: &PathView<Spot>, other: S, q: f64) -> Spot {
    if choose(coin(q)) {
        return delegate(other);
    }
    match choose(shares([1.0, 2.0, 1.0])) {
        0 => delegate(step(2.0 * q)),
        1 => {
            let x = draw(unit(0.25));
            Spot::at(x)
        }
        _ => stop(),
    }
}

#[test]
fn strategies_of_strategies_add_up() {
    let strategy = composite(step(0.0), 0.5);
    // [0.5, 1.5) by the one, [1.5, 2.5) by the other, [0.25, 1.25) here.
    let p = |x| pdf(&strategy, Spot::at(x));
    let expected = [(0.3, 0.25), (1.0, 0.75), (1.4, 0.5), (2.0, 0.125), (2.6, 0.0)];
    for (x, expected) in expected {
        assert!((p(x) - expected).abs() < 1e-15, "{x}: {}", p(x));
    }
    follows(&strategy, 0.0, 3.0);
}

#[test]
fn what_another_strategy_knows_of_its_density_is_used() {
    let strategy = composite(step(0.0), 0.5);
    let here = [Spot::at(0.5)];
    let mut known = 0;
    for k in 0..1000 {
        let drawn = strategy.sample(PathView::from_slice(&here), &mut Pcg32::new(4, 0, k));
        if let Some(drawn) = drawn {
            let (own, p) = (drawn.value.expect("known"), pdf(&strategy, drawn.vertex));
            assert!((own / p - 1.0).abs() < 1e-14, "{own} {p}");
            known += 1;
        }
    }
    assert!(known > 700, "{known}");
}

#[test]
fn a_strategy_reads_what_those_that_it_is_made_of_read() {
    assert_eq!(composite(step(0.0), 0.5).reads(), Reads { vertices: 1, length: false });
    assert_eq!(composite(remembering(), 0.5).reads(), Reads { vertices: 3, length: true });
    let path = [0.0, 10.0, 20.0].map(Spot::at);
    let p = |path: &[Spot], x| {
        composite(remembering(), 0.5).pdf(PathView::from_slice(path), &Spot::at(x)).value
    };
    // The ramp starts at the vertex two places back.
    assert!((p(&path, 0.1) - 0.5 * 2.0 * 0.1).abs() < 1e-15);
    assert_eq!(p(&path[1..], 0.1), 0.0);
    let (a, b) = (composite(step(1.0), 0.5), composite(step(2.0), 0.5));
    assert!(a.same(&a.clone()) && !a.same(&b));
}

#[test]
fn atoms_pass_through_strategies_of_strategies() {
    let strategy = composite(mirror(3), 0.25);
    let here = [Spot::at(0.5)];
    let view = PathView::from_slice(&here);
    let target = Spot { x: 3.0, id: Some(3) };
    let atom = strategy.pdf(view.asking(Some(Dirac::Position)), &target);
    assert_eq!(atom, Conditional::atom(Dirac::Position, 0.25));
    assert_eq!(strategy.pdf(view.asking(Some(Dirac::Direction)), &target).value, 0.0);
    let mut atoms = 0;
    for k in 0..10_000 {
        let drawn = strategy.sample(view, &mut Pcg32::new(1, 0, k));
        atoms += u32::from(drawn.is_some_and(|drawn| drawn.dirac == Some(Dirac::Position)));
    }
    // Standard deviation 43: false alarm once in two million.
    assert!(atoms.abs_diff(2500) < 217, "{atoms}");
}

#[test]
fn an_atom_is_not_that_of_another_strategy_of_the_same_kind() {
    let there = Spot { x: 3.0, id: Some(3) };
    let view = PathView::from_slice(&[]).asking(Some(Dirac::Position));
    assert_eq!(mirror(3).pdf(view, &there).value, 1.0);
    assert_eq!(mirror(4).pdf(view, &there).value, 0.0);
    // Two techniques that find a lamp each: neither finds what the other does, so that both count fully.
    let arena = Arena::<Spot, Mirrors>::new();
    let paths = [3, 4].map(|id| {
        let mut path = arena.sequence();
        *path.append(mirror(id)).sample(&mut Pcg32::new(1, 0, 0))
    });
    let weights: Vec<f64> = combine::<PowerHeuristic, _>(paths).map(|it| it.weight).collect();
    assert_eq!(weights, [1.0, 1.0]);
}

strategies! {
    /// Lamps alone.
    #[derive(Clone)]
    enum Mirrors for Spot {
        Mirror(Mirror),
    }
}

/// Knows its density from sampling.
#[derive(Clone, Copy)]
struct Knowing;
impl Strategy<Spot> for Knowing {
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        _: PathView<'_, Spot>,
        u: &mut U,
    ) -> Option<Drawn<Spot>> {
        Some(Drawn::new(Spot::at(0.25 + u.next())).with_value(1.0))
    }
    fn pdf(&self, _: PathView<'_, Spot>, target: &Spot) -> Conditional<f64> {
        Conditional::density(f64::from(u8::from((0.25..1.25).contains(&target.x))))
    }
}

strategies! {
    #[derive(Clone)]
    enum Ways for Spot { Composite(Composite<Knowing>), Start(Step), First(Remembering) }
}

#[test]
fn the_density_of_a_path_is_that_of_the_whole_strategy() {
    let arena = Arena::<Spot, Ways>::new();
    let mut path = arena.sequence();
    // The density that `Knowing` knows is not the density of the composite.
    let mut uniforms = [0.1, 0.5].into_iter();
    path.append(composite(Knowing, 0.5)).sample(&mut || uniforms.next().unwrap_or(0.0));
    assert_eq!(path.last(), Some(Spot::at(0.75)));
    assert_eq!(path.pdf().value(), 0.5 + 0.5 * 0.5);
}

/// One-sample multiple importance sampling within a strategy, by a mixture as a sampler.
#[strategy]
fn mixed(path: &PathView<Spot>, cdf: &Cdf<f64>, parts: &[Interval]) -> Spot {
    let here = given(path.last());
    let cells = given(mixture(parts, cdf).ok());
    let both = given(mixture((ramp(here.x), ramp(here.x + 0.5)), coin(0.25)).ok());
    let x = if choose(coin(0.5)) { draw(cells) } else { draw(both) };
    Spot::at(x)
}

fn parts() -> ([Interval; 3], Cdf<f64>) {
    let parts = [(0.0, 2.0), (1.0, 1.0), (1.0, 4.0)];
    (parts.map(|(a, length)| interval(a, length).unwrap()), Cdf::new(&[1.0, 0.0, 3.0]).unwrap())
}

#[test]
fn mixtures_are_samplers_in_strategies() {
    let (parts, cdf) = parts();
    let strategy = mixed(&cdf, &parts);
    let within = |x: f64, a: f64, b: f64| f64::from(u8::from((a..b).contains(&x)));
    for k in 0..300 {
        let x = 0.02 * f64::from(k) - 0.113;
        let cells = 0.25 * within(x, 0.0, 2.0) / 2.0 + 0.75 * within(x, 1.0, 5.0) / 4.0;
        let ramps = 0.75 * 2.0 * (x - 0.5) * within(x, 0.5, 1.5)
            + 0.25 * 2.0 * (x - 1.0) * within(x, 1.0, 2.0);
        let found = pdf(&strategy, Spot::at(x));
        assert!((found - 0.5 * (cells + ramps)).abs() < 1e-14, "{x}");
    }
    follows(&strategy, 0.0, 5.0);
}

/// Checks that what samples a mixture has as preimages leads back, and that its own density is that
/// of its point.
fn inverts<S: Sampler<f64, Uniforms = [f64; 1], Point = f64>>(sampler: &S) {
    let mut source = Pcg32::new(3, 0, 0);
    for _ in 0..2000 {
        let u: f64 = source.next();
        let x = sampler.sample([u]);
        let found = sampler.invert(&x);
        assert!(found.iter().any(|[v]| (v - u).abs() < 1e-14), "{u}: {found:?}");
        for v in found.iter() {
            assert!((sampler.sample(v).value() - x.value()).abs() < 1e-13);
        }
        let (own, of_point) = (x.pdf().value(), sampler.pdf(&x).value());
        assert!((own - of_point).abs() < 1e-12 * own, "{u}: {own} {of_point}");
    }
}

#[test]
fn mixtures_are_inverted() {
    let (parts, cdf) = parts();
    inverts(&mixture(parts, &cdf).unwrap());
    inverts(&mixture(&parts[..2], coin(0.3)).unwrap());
    let weights = shares([0.1, 0.2, 0.3, 0.4]);
    inverts(&mixture((unit(0.0), ramp(0.5), unit(2.0), ramp(-1.0)), weights).unwrap());
}

/// Directions about +z, distributed as a power of the cosine.
#[sampler]
fn power_cosine(u: [Uniform; 2], exponent: f64) -> Direction {
    let z = (1.0 - u[0]).powf(1.0 / (exponent + 1.0));
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), z)
}

#[sampler]
fn uniform_sphere(u: [Uniform; 2]) -> Direction {
    let z = 1.0 - 2.0 * u[0];
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), z)
}

#[test]
fn a_mixture_of_lobes_passes_the_battery() {
    let lobes = (power_cosine(1.0), power_cosine(20.0), uniform_sphere());
    let all = mixture(lobes, shares([0.5, 0.3, 0.2])).unwrap();
    battery::Battery::<Mixture<_, _>, f64>::new(&all).jumps(0, [0.0]).run().assert_ok();
}

#[test]
fn components_without_probability_are_not_evaluated() {
    let count = Cell::new(0);
    let parts = [unit(0.0), unit(0.5), unit(1.0)].map(|part| Counted(part, &count));
    let weights = shares([1.0, 0.0, 1.0]);
    assert_eq!(mixture(parts, weights).unwrap().pdf(&0.75).value(), 0.5);
    assert_eq!(count.get(), 2);
    let mismatch = mixture(parts, shares([1.0, 2.0])).unwrap_err();
    assert_eq!(mismatch, WeightError::Length { items: 3, weights: 2 });
}

#[test]
fn shares_are_proportional_and_total() {
    let p = |weights: [f64; 3]| [0, 1, 2].map(|i| shares(weights).probability(i));
    assert_eq!(p([1.0, 0.0, 3.0]), [0.25, 0.0, 0.75]);
    assert_eq!(p([f64::NAN, -1.0, 3.0]), [0.0, 0.0, 1.0]);
    assert_eq!(p([f64::INFINITY, 1.0, f64::INFINITY]), [0.5, 0.0, 0.5]);
    let third = 1.0 / 3.0;
    assert!(p([0.0; 3]).iter().all(|p| (p - third).abs() < 1e-15));
    assert_eq!(p([f64::MAX, f64::MAX, 0.0]), [0.5, 0.5, 0.0]);
    // None is lost, however small.
    let small = shares([1e-30_f32, 1.0, 1e-38]);
    assert!(small.probability(0) > 0.0 && small.probability(2) > 0.0);
    assert_eq!(small.sample(0.0).index, 0);
    assert_eq!(small.sample(1.0_f32.next_down()).index, 2);
    assert_eq!(Discrete::<f64>::sample(&shares([0.0, 1.0]), f64::NAN).index, 1);
    assert_eq!((shares([1.0]).get(1), shares([1.0]).probability(7)), (None, 0.0));
}
