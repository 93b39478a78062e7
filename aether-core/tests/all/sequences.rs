//! What paths are made of: slices, concatenations, reversals, densities and what they cost.

use crate::oracle::LIMIT;
use crate::world::{Camera, Light, Mean, PINHOLE, SURVIVAL, Seen, Spot, Step, Walks, Ways, World};
use aether_core::estimator::{Connections, Techniques};
use aether_core::sequence::{Arena, DynStrategy, Erased, PathView, RandomSequence};
use aether_core::strategy::{Conditional, Dirac, Drawn, Reads, Strategy, Vertex};
use aether_core::{
    BalanceHeuristic, Estimator, PathDensity, PathIntegrand, Pcg32, UniformSource, combine,
};

type Walk<'a, 'w> = RandomSequence<'a, Spot, Ways<'w>>;

fn spots(path: &Walk<'_, '_>) -> Vec<f64> {
    path.vertices().map(|spot| spot.0).collect()
}

/// A path of `n` vertices that never dies.
fn path<'a, 'w>(arena: &'a Walks<'w>, world: &'w World, first: Ways<'w>, n: usize) -> Walk<'a, 'w> {
    let mut numbers = (1..).map(|i| f64::from(i) * 0.618_034 % SURVIVAL);
    let mut path = arena.sequence();
    path.append(first);
    while path.size() < n {
        path.append(Step(world));
    }
    path.sample(&mut || numbers.next().unwrap_or(0.5));
    path
}

#[test]
fn slice_concat_and_reverse_are_what_they_say() {
    let world = World::with_mirror(0.4);
    let arena: Walks<'_> = Arena::new();
    let a = path(&arena, &world, Camera.into(), 5);
    let b = path(&arena, &world, Light(&world).into(), 4);
    let (x, y) = (spots(&a), spots(&b));
    assert_eq!((x.len(), y.len()), (5, 4));
    assert_eq!(spots(&a.slice(1..4)), x[1..4]);
    assert_eq!(spots(&a.slice(1..).slice(..=2)), x[1..4]);
    assert_eq!(spots(&a.reverse().slice(1..3).reverse()), x[2..4]);
    assert_eq!(spots(&a.concat(&b.reverse())), [&x[..], &[y[3], y[2], y[1], y[0]]].concat());
    assert_eq!(spots(&a.reverse().concat(&b).reverse()).len(), 9);
    assert_eq!(spots(&a.slice(0..2).concat(&a.slice(2..5))), x);
    assert!(a.slice(2..2).is_complete() && a.slice(2..2).is_empty());
    // The densities follow: cutting behind and turning around changes no factor.
    let factor = |path: &Walk<'_, '_>, i: usize| path.conditional(i).unwrap_or(f64::NAN);
    for i in 0..4 {
        assert_eq!(factor(&a, i), factor(&a.slice(0..4), i));
        assert_eq!(factor(&a, i), factor(&a.reverse(), 4 - i));
        assert_eq!(factor(&b, i), factor(&a.concat(&b.reverse()), 8 - i));
    }
    assert_eq!(a.pdf(), a.reverse().pdf());
    assert_eq!(a.pdf(), a.slice(0..2).concat(&a.slice(2..5)).pdf());
    let close = |p: PathDensity<f64>, q: PathDensity<f64>| (p.ratio(q) - 1.0).abs() < 1e-14;
    assert!(close(a.concat(&b.reverse()).pdf(), a.pdf() * b.pdf()));
    assert!(close(b.concat(&a.reverse()).reverse().pdf(), a.pdf() * b.pdf()));
}

#[test]
fn the_density_is_the_product_of_the_conditionals() {
    let world = World::default();
    let arena: Walks<'_> = Arena::new();
    let a = path(&arena, &world, Camera.into(), 4);
    let x = spots(&a);
    let step = |x: f64, y: f64| SURVIVAL * (1.0 - x + 2.0 * x * y);
    let expected = step(x[0], x[1]) * step(x[1], x[2]) * step(x[2], x[3]);
    assert!((a.pdf().value() / expected - 1.0).abs() < 1e-14);
    // Any other path under the same strategies.
    let b = path(&arena, &world, Light(&world).into(), 3);
    let other = a.slice(0..1).concat(&b.reverse());
    let x = spots(&other);
    let expected = step(x[0], x[1]) * step(x[1], x[2]) * step(x[2], x[3]);
    assert!((a.pdf_of(&other).value() / expected - 1.0).abs() < 1e-14);
    // And turned around: the light's strategies see the path from its other end.
    let long = path(&arena, &world, Light(&world).into(), 4);
    let expected = 2.0 * x[3] * step(x[3], x[2]) * step(x[2], x[1]);
    // The pinhole is an atom that no step can hit.
    assert!(long.reverse().pdf_of(&other).is_zero());
    let (tail, tail_technique) = (other.slice(1..4), long.slice(0..3).reverse());
    assert!((tail_technique.pdf_of(&tail).value() / expected - 1.0).abs() < 1e-14);
    assert!(a.slice(0..3).pdf_of(&a).is_zero() && a.pdf_of(&a.slice(0..3)).is_zero());
    assert_eq!(arena.sequence().pdf(), PathDensity::ONE);
}

#[test]
fn densities_are_evaluated_once() {
    let world = World::default();
    let arena: Walks<'_> = Arena::new();
    let a = path(&arena, &world, Camera.into(), 8);
    let b = path(&arena, &world, Light(&world).into(), 8);
    assert_eq!(world.evaluations.get(), 0);
    a.pdf();
    assert_eq!(world.evaluations.get(), 7);
    for n in 0..=8 {
        a.slice(0..n).pdf();
        a.slice(0..n).reverse().pdf();
        a.pdf_of(&a);
    }
    assert_eq!(world.evaluations.get(), 7);
    // What the light strategy returned with its sample is not evaluated again.
    b.pdf();
    assert_eq!(world.evaluations.get(), 14);
    // All techniques of all connections: beyond these 14, for each connection of a camera's vertex i
    // to a light's vertex j the steps across the edge (four: two in each direction) at most, and
    // once each vertex's own step the other way.
    let list = |s: usize, t: usize| a.slice(0..s).concat(&b.slice(0..t).reverse());
    for length in 2..=8 {
        let paths = arena.collect((1..length).map(|s| list(s, length - s)));
        assert_eq!(combine::<BalanceHeuristic, _>(paths).count(), length - 1);
    }
    let connections = (2..=8).map(|length| length - 1).sum::<usize>();
    let evaluated = world.evaluations.get();
    assert!(evaluated <= 14 + 4 * connections + 2 * 8 + 8, "{evaluated}");
    for length in 2..=8 {
        let paths = arena.collect((1..length).map(|s| list(s, length - s)));
        combine::<BalanceHeuristic, _>(paths).for_each(drop);
    }
    assert_eq!(world.evaluations.get(), evaluated);
}

#[test]
fn shared_factors_are_not_evaluated() {
    let world = World::default();
    let arena: Walks<'_> = Arena::new();
    let a = path(&arena, &world, Camera.into(), 6);
    let mut direct = a.slice(0..5);
    direct.append(Light(&world)).sample(&mut || 0.5);
    assert_eq!(combine::<BalanceHeuristic, _>([a, direct]).count(), 2);
    // The last vertex of each under the step, and of the first under the light's.
    assert_eq!(world.evaluations.get(), 3);
}

#[test]
fn what_dies_remains_a_technique() {
    let world = World::default();
    let arena: Walks<'_> = Arena::new();
    let mut a = arena.sequence();
    a.append(Camera).append(Step(&world)).append(Step(&world)).append(Step(&world));
    let mut numbers = [0.1, 0.5, 0.5, 0.5, 0.99].into_iter();
    a.sample(&mut || numbers.next().unwrap_or(0.0));
    assert_eq!((a.len(), a.size()), (2, 4));
    assert!(!a.is_complete() && a.pdf().is_zero() && a.vertex(2).is_none());
    a.sample(&mut || 0.0);
    assert_eq!(a.len(), 2, "the path has ended");
    let mut direct = a.slice(0..2);
    direct.append(Light(&world)).sample(&mut || 0.75);
    assert!(direct.is_complete());
    let combined: Vec<_> = combine::<BalanceHeuristic, _>([a.slice(0..3), direct]).collect();
    assert_eq!(combined.len(), 1);
    let [x, y] = [1, 2].map(|i| direct.vertex(i).map_or(f64::NAN, |spot| spot.0));
    let (light, step) = (2.0 * y, SURVIVAL * (1.0 - x + 2.0 * x * y));
    assert!((combined[0].weight - light / (light + step)).abs() < 1e-14);
    // A slice out of range is no technique at all.
    assert!(a.slice(0..5).size() == 0 && !a.slice(0..5).is_complete());
    let beyond: Vec<_> = combine::<BalanceHeuristic, _>([a.slice(0..5), direct]).collect();
    assert_eq!(beyond[0].weight, 1.0);
}

#[test]
fn copies_are_independent() {
    let world = World::default();
    let arena: Walks<'_> = Arena::new();
    let mut a = arena.sequence();
    a.append(Camera).append(Step(&world));
    let mut b = a;
    a.sample(&mut || 0.25);
    b.append(Step(&world)).sample(&mut || 0.6);
    assert_eq!(spots(&a).len(), 2);
    assert_eq!(spots(&b).len(), 3);
    assert_ne!(a.vertex(1), b.vertex(1));
    let mut c = a.slice(0..1);
    c.append(Light(&world)).sample(&mut || 0.0);
    a.append(Step(&world)).sample(&mut || 0.125);
    assert_eq!(spots(&c), [PINHOLE, 1.0]);
    assert_eq!(a.len(), 3);
    // A cut and glued path knows nothing of the run that it was cut from.
    let glued = c.concat(&a.slice(1..3));
    let product: f64 = (0..4).filter_map(|i| glued.conditional(i)).product();
    a.pdf();
    assert!((glued.pdf().value() / product - 1.0).abs() < 1e-14);
}

#[test]
fn dirac_factors_must_agree() {
    let world = World::with_mirror(0.4);
    let arena: Walks<'_> = Arena::new();
    // Camera, a diffuse step, then the mirror; and the same from a light.
    let mut numbers = [0.1, 0.9, 0.9, 0.2, 0.1, 0.1].into_iter();
    let mut mirrored = arena.sequence();
    mirrored.append(Camera).append(Step(&world)).append(Step(&world));
    mirrored.sample(&mut || numbers.next().unwrap_or(0.5));
    assert_eq!(spots(&mirrored), [PINHOLE, 0.2, 1.0 - PINHOLE]);
    let view = mirrored.view();
    assert!(view.carries(1, Dirac::Direction) && !view.carries(2, Dirac::Direction));
    assert!(view.carries(0, Dirac::Position) && !view.carries(1, Dirac::Position));
    let p = mirrored.pdf().value();
    assert!((p - SURVIVAL * SURVIVAL * 0.3 * (1.0 - PINHOLE + 2.0 * PINHOLE * 0.2)).abs() < 1e-14);
    // A light sampled at the last vertex cannot have come by the mirror, although it is there.
    let mut direct = mirrored.slice(0..2);
    direct.append(Light(&world)).sample(&mut || 1.0 - (1.0 - PINHOLE) * (1.0 - PINHOLE));
    assert!(direct.pdf_of(&mirrored).is_zero());
    let weights: Vec<_> =
        combine::<BalanceHeuristic, _>([mirrored, direct]).map(|path| path.weight).collect();
    assert_eq!(weights[0], 1.0);
    assert!(weights[1] > 0.0 && weights[1] < 1.0, "compared as densities: {weights:?}");
    // Turned around, the factor stays with the vertex on the mirror.
    let view = mirrored.reverse().view();
    assert!(view.carries(1, Dirac::Direction) && !view.carries(0, Dirac::Direction));
    // Coming from the light, the same factor arises.
    let light = path(&arena, &world, Light(&world).into(), 3);
    let tail = light.reverse().pdf_of(&mirrored.reverse().reverse());
    assert!(tail.is_zero(), "a step cannot hit the pinhole");
    let mut numbers = [0.5, 0.1, 0.9, 0.9, 0.4, 0.1, 0.1].into_iter();
    let mut traced = arena.sequence();
    traced.append(Light(&world)).append(Step(&world)).append(Step(&world));
    traced.sample(&mut || numbers.next().unwrap_or(0.5));
    let back = light.pdf_of(&traced.reverse());
    assert!(back.is_regular(), "both ways make the same mirror path");
}

/// A vertex in single precision, and steps with tiny densities.
#[derive(Clone, Copy, Debug)]
struct Speck(f32);
impl Vertex for Speck {
    type Real = f32;
    type Point = f32;
    fn point(&self) -> f32 {
        self.0
    }
}
#[derive(Clone, Copy)]
struct Far;
impl Strategy<Speck> for Far {
    fn sample<U: UniformSource<f32> + ?Sized>(
        &self,
        _: PathView<'_, Speck>,
        uniforms: &mut U,
    ) -> Option<Drawn<Speck>> {
        Some(Drawn::new(Speck(1e20 * uniforms.next())))
    }
    fn pdf(&self, _: PathView<'_, Speck>, _: &Speck) -> Conditional<f32> {
        Conditional::density(1e-20)
    }
    fn reads(&self) -> Reads {
        Reads::NOTHING
    }
}
struct Bright;
impl PathIntegrand for Bright {
    type Vertex = Speck;
    type Value = f32;
    fn extend(&self, path: PathView<'_, Speck>) -> f32 {
        if path.len() == 1 { 1e-20 } else { 0.999e-20 }
    }
    fn end(&self, _: PathView<'_, Speck>) -> f32 {
        2.0
    }
}

#[test]
fn a_thousand_vertices_in_f32() {
    let arena = Arena::<Speck, Far>::new();
    let mut path = arena.sequence();
    (0..1000).for_each(|_| _ = path.append(Far));
    path.sample(&mut Pcg32::new(3, 0, 0));
    assert_eq!(path.len(), 1000);
    assert!((path.pdf().ln() / (1000.0 * 1e-20_f64.ln()) - 1.0).abs() < 1e-6);
    let estimate = Estimator::paths(Bright).of(&path);
    assert!((f64::from(estimate) / (2.0 * 0.999_f64.powi(999)) - 1.0).abs() < 1e-3, "{estimate}");
    let mut other = path.slice(0..999);
    other.append(Far).sample(&mut Pcg32::new(3, 0, 1));
    let weights: Vec<_> = combine::<BalanceHeuristic, _>([path, other]).map(|p| p.weight).collect();
    assert_eq!(weights, [0.5, 0.5]);
}

#[test]
fn an_estimate_extends_the_one_before() {
    let world = World::default();
    let estimator = Estimator::paths(Seen(&world));
    let mut arena: Walks<'_> = Arena::new();
    for _ in 0..2 {
        world.shadow_rays.set(0);
        let a = path(&arena, &world, Camera.into(), 6);
        let b = path(&arena, &world, Light(&world).into(), 3);
        let fresh = |path: &Walk<'_, '_>| Estimator::paths(Seen(&world)).of(path);
        for n in 1..=6 {
            assert_eq!(estimator.of(&a.slice(0..n)), fresh(&a.slice(0..n)));
            let joined = a.slice(0..n).concat(&b.reverse());
            let expected = {
                let f: f64 = (1..n + 3)
                    .map(|i| {
                        let [x, y] = [i - 1, i].map(|i| joined.vertex(i).map_or(0.0, |v| v.0));
                        (1.0 + x * y) / 2.0
                    })
                    .product();
                f * 2.0 * joined.last().map_or(0.0, |v| v.0) / joined.pdf().value()
            };
            assert!((estimator.of(&joined) / expected - 1.0).abs() < 1e-13);
        }
        arena.clear();
    }
}

#[test]
fn strategies_behind_pointers() {
    let world = World::default();
    let (camera, step) = (Camera, Step(&world));
    let chosen: [&dyn DynStrategy<Spot>; 3] = [&camera, &step, &step];
    let arena = Arena::<Spot, Erased<'_, Spot>>::new();
    let mut a = arena.sequence();
    for strategy in chosen {
        a.append(Erased(strategy));
    }
    a.sample(&mut || 0.25);
    assert_eq!(a.len(), 3);
    let b = path(&Arena::new(), &world, Camera.into(), 3).len();
    assert_eq!(b, 3);
    assert!(a.pdf().is_regular());
}

#[test]
fn blocks_follow_the_structure_of_the_path() {
    #[derive(Default)]
    struct Blocks(Vec<u32>);
    impl UniformSource<f64> for Blocks {
        fn next(&mut self) -> f64 {
            0.5
        }
        fn start(&mut self, block: u32) {
            self.0.push(block);
        }
    }
    let world = World::default();
    let arena: Walks<'_> = Arena::new();
    let mut blocks = Blocks::default();
    let (mut a, mut b) = (arena.sequence(), arena.sequence());
    a.append(Camera).append(Step(&world)).append(Step(&world));
    b.append(Light(&world)).append(Step(&world)).append(Step(&world));
    a.sample(&mut blocks);
    b.sample(&mut blocks);
    for n in 1..=3 {
        a.slice(0..n).append(Light(&world)).sample(&mut blocks);
    }
    let mut sorted = blocks.0.clone();
    sorted.sort_unstable();
    sorted.dedup();
    assert_eq!(sorted.len(), 9, "{:?}", blocks.0);
}

#[test]
fn a_path_goes_on_from_both_of_its_ends_by_other_numbers() {
    // From a vertex in the middle, x one way and y the other, both with density 2 x: the mean of x y is (2/3)² = 4/9. Drawn by
    // the same numbers it would be that of a square, 1/2.
    let world = World::default();
    let mut arena: Walks<'_> = Arena::new();
    let mut products = Mean::default();
    for sample in 0..20_000 {
        arena.clear();
        let mut uniforms = Pcg32::new(3, 0, sample);
        let mut middle = arena.sequence();
        middle.append(Light(&world)).sample(&mut uniforms);
        let (mut ahead, mut back, mut turned_twice) =
            (middle, middle.reverse(), middle.reverse().reverse());
        for way in [&mut ahead, &mut back, &mut turned_twice] {
            way.append(Light(&world)).sample(&mut uniforms);
        }
        let path = back.reverse().concat(&ahead.slice(1..));
        assert_eq!(path.len(), 3);
        products.add(spots(&path)[0] * spots(&path)[2]);
        // A path that has been turned twice goes on as if it had never been.
        assert_eq!(turned_twice.vertex(1), ahead.vertex(1));
    }
    assert!(products.z(4.0 / 9.0).abs() < LIMIT, "{}", products.z(4.0 / 9.0));
}

#[test]
fn going_on_takes_the_steps_that_are_pending_first() {
    let world = World::default();
    let arena: Walks<'_> = Arena::new();
    let mut path = arena.sequence();
    path.append(Camera).append(Step(&world)).go_on(5, Step(&world), &mut || 0.25);
    assert_eq!((path.len(), path.size()), (5, 5));
    // Where a step finds nothing, none follows it.
    let mut died = arena.sequence();
    died.append(Camera).append(Step(&world)).go_on(5, Step(&world), &mut || 0.99);
    assert_eq!((died.len(), died.size()), (1, 2));
    died.go_on(5, Step(&world), &mut || 0.25);
    assert_eq!((died.len(), died.size()), (1, 2));
}

#[test]
#[should_panic(expected = "paths of different arenas cannot be combined")]
fn paths_of_two_arenas_are_not_combined() {
    let world = World::default();
    let (one, other): (Walks<'_>, Walks<'_>) = (Arena::new(), Arena::new());
    let ours = path(&one, &world, Camera.into(), 3);
    let theirs = path(&other, &world, Camera.into(), 3);
    let weights = combine::<BalanceHeuristic, _>([ours, theirs]).map(|path| path.weight);
    // Each would have a weight of one half, and not one of them one.
    assert_eq!(weights.sum::<f64>(), 1.0);
}

#[test]
fn a_technique_that_takes_no_samples_contributes_nothing() {
    let world = World::default();
    let arena: Walks<'_> = Arena::new();
    let a = path(&arena, &world, Camera.into(), 3);
    let estimator = Estimator::paths(Seen(&world));
    let all = || combine::<BalanceHeuristic, _>([(a, 0), (a, 2)]);
    let found: Vec<_> = estimator.each(all()).collect();
    assert_eq!(found.len(), 1);
    let half = 0.5 * estimator.of(&a);
    assert_eq!((found[0].technique, found[0].value, found[0].alone), (1, half, half));
    assert_eq!(all().map(|path| path.weight).collect::<Vec<_>>(), [0.0, 0.5]);
}

#[test]
#[should_panic(expected = "paths of different arenas cannot be joined")]
fn paths_of_two_arenas_are_not_joined() {
    let world = World::default();
    let (one, other): (Walks<'_>, Walks<'_>) = (Arena::new(), Arena::new());
    let eye = path(&one, &world, Camera.into(), 3);
    let light = path(&other, &world, Light(&world).into(), 2);
    assert_eq!(eye.concat(&light.reverse()).len(), 5);
}

#[test]
#[should_panic(expected = "walks of different arenas cannot be joined")]
fn walks_of_two_arenas_are_not_joined() {
    let world = World::default();
    let (one, other): (Walks<'_>, Walks<'_>) = (Arena::new(), Arena::new());
    let eye = path(&one, &world, Camera.into(), 3);
    let light = path(&other, &world, Light(&world).into(), 2);
    let mut techniques = Techniques::new(BalanceHeuristic);
    techniques.reach(5, |_, _| 1);
    let connections = Connections {
        lengths: 2..=5,
        ending: None,
        fewest_ending: 0,
        techniques: &techniques,
        is_drawn: |_, _| true,
    };
    let mut sum = 0.0;
    let estimator = Estimator::paths(Seen(&world));
    estimator.connections([&eye, &light], &connections, &mut || 0.5, |path| sum += path.value);
    assert!(sum > 0.0, "nothing was found, and nothing said");
}
