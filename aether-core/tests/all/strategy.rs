//! Densities that `#[strategy]` derives, on vertices that are points of the real line.

use std::cell::Cell;

use aether_core::discrete::{Choices, coin, discrete, discrete_weighted};
use aether_core::prelude::*;
use aether_core::strategy::{Conditional, Dirac, Drawn, Reads, Recall, Strategy, Vertex};
use aether_core::uniform::Pcg32;
use aether_core::{Arena, Density, Discrete, PathView, PdfOf};

/// A vertex; `id` is what an external call found, `lobe` how the vertex came about.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Spot {
    x: f64,
    id: Option<u32>,
    lobe: usize,
}

impl Spot {
    fn at(x: f64) -> Spot {
        Spot { x, id: None, lobe: 0 }
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

/// Uniform on [a, b).
#[derive(Clone, Copy, Debug)]
struct Interval(f64, f64);

impl Sampler<f64> for Interval {
    type Uniforms = [f64; 1];
    type Point = f64;
    fn forward(&self, u: [f64; 1]) -> (f64, bool) {
        (self.0 + (self.1 - self.0) * u[0], true)
    }
    fn pdf(&self, x: &f64) -> PdfOf<Self, f64> {
        let inside = self.0 <= *x && *x < self.1;
        Density::new(if inside { 1.0 / (self.1 - self.0) } else { 0.0 })
    }
    fn pdf_of_uniforms(&self, _: [f64; 1]) -> PdfOf<Self, f64> {
        Density::new(1.0 / (self.1 - self.0))
    }
    fn preimages(&self, x: &f64, mut visit: impl FnMut([f64; 1], bool)) {
        visit([(x - self.0) / (self.1 - self.0)], self.0 <= *x && *x < self.1);
    }
}

/// y = x², defined for x below `limit` only.
#[derive(Clone, Copy, Debug)]
struct Square {
    limit: f64,
}

impl Map<f64> for Square {
    type Source = f64;
    type Target = f64;
    fn forward(&self, x: &f64) -> (f64, bool) {
        (x * x, *x < self.limit)
    }
    fn preimages(&self, y: &f64, mut visit: impl FnMut(f64, bool)) {
        let root = y.max(0.0).sqrt();
        visit(root, *y > 0.0 && root < self.limit);
        visit(-root, *y > 0.0);
    }
    fn jacobian(&self, x: &f64) -> f64 {
        2.0 * x.abs()
    }
}

/// y = scale x + offset.
#[derive(Clone, Copy, Debug)]
struct Affine {
    scale: f64,
    offset: f64,
}

impl Map<f64> for Affine {
    type Source = f64;
    type Target = f64;
    fn forward(&self, x: &f64) -> (f64, bool) {
        (self.scale * x + self.offset, true)
    }
    fn preimages(&self, y: &f64, mut visit: impl FnMut(f64, bool)) {
        visit((y - self.offset) / self.scale, true);
    }
    fn jacobian(&self, _: &f64) -> f64 {
        self.scale.abs()
    }
}

fn pdf<S: Strategy<Spot>>(strategy: &S, target: Spot) -> f64 {
    let here = [Spot::at(0.0)];
    let value = strategy.pdf(PathView::from_slice(&here), &target);
    assert_eq!(value.dirac, None);
    value.value
}

fn atom<S: Strategy<Spot>>(strategy: &S, kind: Dirac, target: Spot) -> f64 {
    let here = [Spot::at(0.0)];
    let value = strategy.pdf(PathView::from_slice(&here).asking(Some(kind)), &target);
    assert_eq!(value.dirac, Some(kind));
    value.value
}

fn samples<S: Strategy<Spot>>(strategy: &S, count: u64) -> Vec<Option<Drawn<Spot>>> {
    let here = [Spot::at(0.0)];
    let view = PathView::from_slice(&here);
    (0..count).map(|sample| strategy.sample(view, &mut Pcg32::new(3, 0, sample))).collect()
}

/// Compares how often samples fall into each cell of [from, to) with the integral of the density,
/// within five standard errors.
fn check<S: Strategy<Spot>>(strategy: &S, from: f64, to: f64, like: impl Fn(f64) -> Spot) {
    const CELLS: usize = 20;
    const COUNT: u64 = 40_000;
    let width = (to - from) / CELLS as f64;
    let mut found = [0.0; CELLS];
    for drawn in samples(strategy, COUNT).into_iter().flatten().filter(|d| d.dirac.is_none()) {
        if (from..to).contains(&drawn.vertex.x) {
            found[((drawn.vertex.x - from) / width) as usize] += 1.0 / COUNT as f64;
        }
    }
    for (cell, found) in found.iter().enumerate() {
        let x = |k: usize| from + width * (cell as f64 + (k as f64 + 0.5) / 100.0);
        let expected: f64 =
            (0..100).map(|k| pdf(strategy, like(x(k)))).sum::<f64>() * width / 100.0;
        let error = (expected * (1.0 - expected) / COUNT as f64).sqrt();
        assert!(
            (found - expected).abs() <= 5.0 * error + 1e-3 * expected,
            "{cell}: {found} {expected}"
        );
    }
}

/// Checks that what is drawn tells its density, the same as inversion finds; returns how often it does.
fn own_densities<S: Strategy<Spot>>(strategy: &S) -> usize {
    let drawn = samples(strategy, 2000).into_iter().flatten();
    let known = drawn.filter_map(|drawn| Some((drawn, drawn.value?)));
    let check = |(Drawn { vertex, dirac, .. }, own): (Drawn<Spot>, f64)| {
        let p = dirac.map_or_else(|| pdf(strategy, vertex), |kind| atom(strategy, kind, vertex));
        assert!((own / p - 1.0).abs() < 1e-12, "{vertex:?}: {own} {p}");
    };
    known.map(check).count()
}

/// One of some intervals, then uniformly in it.
#[strategy]
fn mixture(path: &PathView<Spot>, cells: &Choices<Vec<Interval>, Interval>) -> Spot {
    let cell = choose(cells);
    let x = draw(*cell);
    Spot::at(x)
}

#[test]
fn choices_are_marginalised_duplicates_included() {
    let intervals = vec![Interval(0.0, 1.0), Interval(0.5, 2.5), Interval(0.0, 1.0)];
    let cells = discrete_weighted(intervals, [0.2, 0.5, 0.3]).unwrap();
    let strategy = mixture(&cells);
    assert!((pdf(&strategy, Spot::at(0.25)) - 0.5).abs() < 1e-15);
    assert!((pdf(&strategy, Spot::at(0.75)) - 0.75).abs() < 1e-15);
    assert!((pdf(&strategy, Spot::at(2.0)) - 0.25).abs() < 1e-15);
    assert_eq!(pdf(&strategy, Spot::at(3.0)), 0.0);
    assert_eq!(strategy.reads(), Reads::NOTHING);
    let other = discrete([Interval(0.0, 1.0)].to_vec()).unwrap();
    assert!(strategy.same(&strategy.clone()) && !strategy.same(&mixture(&other)));
    check(&strategy, 0.0, 2.5, Spot::at);
}

#[strategy]
fn roulette(path: &PathView<Spot>, q: f64) -> Spot {
    let here = given(path.last());
    if !choose(coin(q)) {
        return stop();
    }
    let x = draw(Interval(here.x, here.x + 2.0));
    Spot::at(x)
}

#[test]
fn the_probability_to_stop_counts() {
    let strategy = roulette(0.7);
    assert!((pdf(&strategy, Spot::at(1.0)) - 0.35).abs() < 1e-15);
    let survivors = samples(&strategy, 10_000).iter().flatten().count();
    // Standard error 46.
    assert!(survivors.abs_diff(7_000) < 230, "{survivors}");
    assert_eq!(strategy.reads(), Reads { vertices: 1, length: false });
    // No vertex to start from: `given` ends.
    let nowhere = PathView::from_slice(&[]);
    assert_eq!(strategy.pdf(nowhere, &Spot::at(1.0)), Conditional::density(0.0));
    assert!(strategy.sample(nowhere, &mut || 0.1).is_none());
    assert!(strategy.same(&roulette(0.7)) && !strategy.same(&roulette(0.6)));
}

/// A scene whose walls count how often they are looked for.
#[derive(Default)]
struct Walls {
    casts: Cell<u32>,
}

impl Walls {
    /// Wall 0 below 0.5, nothing from 0.5 to 1, wall 7 beyond.
    fn cast(&self, _from: f64, x: f64) -> Option<u32> {
        self.casts.set(self.casts.get() + 1);
        if x < 0.5 { Some(0) } else { (x >= 1.0).then_some(7) }
    }
}

#[strategy]
fn to_wall(path: &PathView<Spot>, walls: &Walls) -> Spot {
    let here = given(path.back(0));
    let w = draw(Interval(0.0, 2.0));
    let doubled = 2.0 * w;
    let id = constant(walls.cast(here.x, doubled * 0.5));
    match id {
        0 => Spot { x: Affine { scale: 4.0, offset: 0.0 }.apply(&w), id: Some(id), lobe: 0 },
        _ => {
            let middle = Affine { scale: 0.5, offset: -1.0 }.apply(&w);
            let y = Affine { scale: 3.0, offset: 1.0 }.apply(&middle);
            Spot { x: y, id: Some(id), lobe: 0 }
        }
    }
}

#[test]
fn locally_constant_values_are_read_from_the_vertex() {
    let scene = Walls::default();
    let strategy = to_wall(&scene);
    let target = |x, id| Spot { x, id, lobe: 0 };
    assert!((pdf(&strategy, target(1.0, Some(0))) - 0.125).abs() < 1e-15);
    assert!((pdf(&strategy, target(0.0, Some(7))) - 1.0 / 3.0).abs() < 1e-15);
    // Not a hit of anything.
    assert_eq!(pdf(&strategy, target(1.0, None)), 0.0);
    assert_eq!(scene.casts.get(), 0);
    for drawn in samples(&strategy, 100).into_iter().flatten() {
        assert!(drawn.visible && drawn.dirac.is_none());
        assert!(pdf(&strategy, drawn.vertex) > 0.0);
    }
    assert_eq!(scene.casts.get(), 100);
}

/// A mirror, found by a ray, or a diffuse lobe; a pinhole besides.
#[strategy]
fn layered(path: &PathView<Spot>, scene: &Walls) -> Spot {
    let here = given(path.last());
    match *choose(discrete_weighted([0, 1, 2], [0.5, 0.3, 0.2]).expect("weights")) {
        0 => {
            let id = constant(scene.cast(here.x, 1.5));
            Spot { x: 1.5, id: Some(id), lobe: 0 }
        }
        1 => {
            let id = constant(Some(3));
            Spot { x: 9.0, id: Some(id), lobe: 1 }
        }
        _ => {
            let x = draw(Interval(0.0, 4.0));
            Spot { x, id: None, lobe: 2 }
        }
    }
}

#[test]
fn kinds_are_never_mixed() {
    let scene = Walls::default();
    let strategy = layered(&scene);
    let mirror = Spot { x: 1.5, id: Some(7), lobe: 0 };
    assert_eq!(atom(&strategy, Dirac::Direction, mirror), 0.5);
    // The pinhole is number 3, and no other.
    let pinhole = Spot { x: 9.0, id: Some(3), lobe: 1 };
    assert_eq!(atom(&strategy, Dirac::Position, pinhole), 0.3);
    assert_eq!(atom(&strategy, Dirac::Position, mirror), 0.0);
    assert!((pdf(&strategy, mirror) - 0.05).abs() < 1e-15);
    assert_eq!(atom(&strategy, Dirac::Direction, Spot::at(1.5)), 0.0);
    for drawn in samples(&strategy, 100).into_iter().flatten() {
        let kind = [Some(Dirac::Direction), Some(Dirac::Position), None][drawn.vertex.lobe];
        assert_eq!((drawn.dirac, drawn.visible), (kind, drawn.vertex.lobe == 0));
    }
    assert_eq!(own_densities(&strategy), 2000);
}

/// A pinhole that several outcomes lead to.
#[strategy]
fn pinholes(path: &PathView<Spot>, ways: &Choices<Vec<f64>, f64>) -> Spot {
    let way = choose(ways);
    if *way < 1.5 {
        let id = constant(Some(3));
        return Spot { x: 9.0, id: Some(id), lobe: 1 };
    }
    let x = draw(Interval(0.0, 4.0));
    Spot { x, id: None, lobe: 2 }
}

#[test]
fn an_atom_that_several_outcomes_lead_to_has_the_probability_of_all() {
    let ways = discrete_weighted(vec![0.0, 1.0, 2.0], [1.0, 2.0, 5.0]).unwrap();
    let strategy = pinholes(&ways);
    assert_eq!(atom(&strategy, Dirac::Position, Spot { x: 9.0, id: Some(3), lobe: 1 }), 0.375);
    assert_eq!(own_densities(&strategy), 2000);
}

#[strategy]
fn lights(path: PathView<Spot>, lights: &Choices<Vec<f64>, f64>, visits: &Cell<u32>) -> Spot {
    let from = choose(lights).identified_by(|v: &Spot| (v.lobe < 9).then_some(v.lobe));
    let _ = visits.replace(visits.get() + 1);
    let x = draw(Interval(*from, from + 1.0));
    Spot { x, id: None, lobe: *from as usize }
}

#[test]
fn identified_choices_are_not_enumerated() {
    let choices = discrete_weighted(vec![0.0, 1.0, 2.0], [1.0, 2.0, 5.0]).unwrap();
    let visits = Cell::new(0);
    let strategy = lights(&choices, &visits);
    assert_eq!(pdf(&strategy, Spot { x: 1.5, id: None, lobe: 1 }), 0.25);
    assert_eq!(visits.get(), 1);
    assert_eq!(pdf(&strategy, Spot { x: 1.5, id: None, lobe: 2 }), 0.0);
    // No such light, and no light at all.
    assert_eq!(pdf(&strategy, Spot { x: 1.5, id: None, lobe: 5 }), 0.0);
    assert_eq!(pdf(&strategy, Spot { x: 1.5, id: None, lobe: 9 }), 0.0);
    assert_eq!(visits.get(), 2);
}

/// Which map is taken depends by a probability on the point drawn (a Fresnel coefficient at a
/// sampled half vector); points beyond 1.5 are absorbed.
#[strategy]
fn fresnel(path: &PathView<Spot>) -> Spot {
    let h = draw(Interval(-1.0, 2.0));
    let reflectance = h * h / 4.0;
    if h > 1.5 {
        return stop();
    }
    let reflects = choose(coin(reflectance));
    let w = if reflects {
        Affine { scale: 2.0, offset: 5.0 }.apply(&h)
    } else {
        Square { limit: 1.2 }.apply(&h)
    };
    Spot::at(w)
}

#[test]
fn choices_that_depend_on_the_point_are_weighed_after_inversion() {
    let strategy = fresnel();
    // Reflected from h = 0.5.
    assert!((pdf(&strategy, Spot::at(6.0)) - 0.0625 / 3.0 / 2.0).abs() < 1e-15);
    // Refracted from h = 0.5 and h = -0.5.
    assert!((pdf(&strategy, Spot::at(0.25)) - 2.0 * 0.9375 / 3.0).abs() < 1e-15);
    // Reflected from h = 1.75, which is absorbed.
    assert_eq!(pdf(&strategy, Spot::at(8.5)), 0.0);
    // Not at the pole of the square root.
    check(&strategy, 0.5, 10.0, Spot::at);
}

#[strategy]
fn late_factor_on_the_point_itself(path: &PathView<Spot>) -> Spot {
    let x = draw(Interval(0.0, 1.0));
    let kept = choose(coin(x));
    if kept { Spot::at(x) } else { stop() }
}

#[test]
fn a_late_choice_weighs_the_point_itself() {
    let strategy = late_factor_on_the_point_itself();
    assert!((pdf(&strategy, Spot::at(0.3)) - 0.3).abs() < 1e-15);
    check(&strategy, 0.0, 1.0, Spot::at);
}

/// Generic in the vertex and in a parameter, which may be anything.
#[strategy]
fn generic<V>(path: &PathView<V>, distribution: impl Discrete<f64> + Clone, make: fn(f64) -> V) -> V
where
    V: Vertex<Real = f64, Point = f64>,
{
    let Some(_) = path.back(1) else { return stop() };
    let _ = choose(distribution);
    let x = draw(Interval(0.0, 1.0).then(Affine { scale: 2.0, offset: path.len() as f64 }));
    make(x)
}

#[test]
fn generic_strategies() {
    let strategy = generic(coin(0.25), Spot::at);
    let two = [Spot::at(0.0); 2];
    let p = |path| strategy.pdf(PathView::from_slice(path), &Spot::at(3.0)).value;
    assert_eq!((p(&two), p(&two[1..])), (0.5, 0.0));
    assert_eq!(strategy.reads(), Reads { vertices: 2, length: true });
}

/// Goes on for certain, and with less patience after some vertices.
#[strategy]
fn walk_until_tired(path: &PathView<Spot>, patience: u32) -> Spot {
    let goes_on = choose(coin(if path.len() > patience as usize { 0.5 } else { 1.0 }));
    if !goes_on {
        return stop();
    }
    let x = draw(Interval(0.0, 1.0));
    Spot::at(x)
}

#[test]
fn densities_are_shared_between_lengths_that_compare_alike() {
    let strategy = walk_until_tired(2);
    assert_eq!(strategy.reads(), Reads { vertices: 0, length: true });
    assert_eq!([0, 2, 3, 9].map(|len| strategy.length_class(len)), [0, 0, 1, 1]);
    assert_eq!(generic(coin(0.25), Spot::at).length_class(9), 9);
    let arena = Arena::<Spot, WalkUntilTired>::new();
    let mut path = arena.sequence();
    for _ in 0..8 {
        path.append(walk_until_tired(2));
    }
    path.sample(&mut || 0.25);
    let before = aether_core::work::densities();
    for from in 0..8 {
        let tired = 5_i32.saturating_sub(from).max(0);
        let expected = 0.5_f64.powi(tired);
        assert_eq!(path.slice(from as usize..).pdf().value(), expected, "from {from}");
    }
    // What drawing told, of those after the third, and the other class of each of them.
    let evaluated = aether_core::work::densities() - before;
    assert_eq!(evaluated, 5);
}

/// Up to 2 where the inverse of a slope is positive, else up to 4.
#[strategy]
fn sloping(_path: &PathView<Spot>, slope: f64) -> Spot {
    let x = draw(Interval(0.0, if 1.0 / slope > 0.0 { 2.0 } else { 4.0 }));
    Spot::at(x)
}

#[test]
fn zeros_of_different_signs_are_different_arguments() {
    let arena = Arena::<Spot, Sloping>::new();
    for (slope, density) in [(0.0, 0.5), (-0.0, 0.25), (0.0, 0.5)] {
        let mut path = arena.sequence();
        path.append(sloping(slope)).sample(&mut || 0.25);
        assert_eq!(path.pdf().value(), density, "{slope:?}");
        assert_eq!(path.vertex(0), Some(Spot::at(0.25 / density)));
    }
    assert!(!sloping(0.0).same(&sloping(-0.0)) && sloping(-0.0).same(&sloping(-0.0)));
}

/// Drawn points in either half go the same way, by different maps.
#[strategy]
fn folded(path: &PathView<Spot>) -> Spot {
    let h = draw(Interval(-1.0, 3.0));
    if h < 0.5 {
        Spot::at(Affine { scale: -1.0, offset: 1.0 }.apply(&h))
    } else {
        Spot::at(Square { limit: 9.0 }.apply(&h))
    }
}

#[test]
fn what_is_drawn_tells_its_density_among_several_ways() {
    let intervals = vec![Interval(0.0, 1.0), Interval(0.5, 2.5), Interval(0.0, 1.0)];
    let cells = discrete_weighted(intervals, [0.2, 0.5, 0.3]).unwrap();
    assert_eq!(own_densities(&mixture(&cells)), 2000);
    assert!(own_densities(&roulette(0.7)) > 1000);
    assert!(own_densities(&to_wall(&Walls::default())) > 1000);
    assert!(own_densities(&layered(&Walls::default())) > 200);
    let lamps = discrete_weighted(vec![0.0, 1.0, 2.0], [1.0, 2.0, 5.0]).unwrap();
    assert_eq!(own_densities(&lights(&lamps, &Cell::new(0))), 2000);
    assert!(own_densities(&late_factor_on_the_point_itself()) > 500);
    // Not where a square has two roots, each with a weight of its own.
    assert!((200..1800).contains(&own_densities(&fresnel())));
    assert!(own_densities(&folded()) > 500);
    // The image of the left half overlaps that of the right one, which has two roots too.
    let p = |x| pdf(&folded(), Spot::at(x));
    assert!((p(1.21) - 0.25 * (1.0 + 1.0 / 2.2)).abs() < 1e-14, "{}", p(1.21));
    check(&folded(), 0.3, 9.0, Spot::at);
    let two_roots = {
        let cells = discrete([Square { limit: 9.0 }; 2]).unwrap();
        move |sample| {
            let strategy = squared(&cells);
            (own_densities(&strategy), strategy.pdf(PathView::from_slice(&[]), &sample).value)
        }
    };
    let (known, p) = two_roots(Spot::at(0.25));
    assert!(known == 2000 && (p - 2.0 / 3.0).abs() < 1e-14, "{known} {p}");
}

/// Points of either sign, squared.
#[strategy]
fn squared(path: &PathView<Spot>, maps: &Choices<[Square; 2], Square>) -> Spot {
    let map = choose(maps);
    let x = draw(Interval(-1.0, 2.0));
    let y = (*map).apply(&x);
    Spot::at(y)
}

#[test]
fn rounded_over_the_rim_it_still_has_its_density() {
    // Two numbers of f64 fit into the second interval; the upper end is not in it.
    let far = Interval(1e8, 1e8 + 2.0_f64.powi(-25));
    let cells = discrete(vec![Interval(0.0, 1.0), far]).unwrap();
    let strategy = mixture(&cells);
    let nowhere = PathView::from_slice(&[]);
    let mut numbers = [0.75, 0.9].into_iter();
    let drawn = strategy.sample(nowhere, &mut || numbers.next().unwrap()).unwrap();
    assert_eq!(drawn.vertex.x, far.1);
    assert_eq!(pdf(&strategy, drawn.vertex), 0.0);
    assert_eq!(drawn.value, Some(0.5 * 2.0_f64.powi(25)));
}
