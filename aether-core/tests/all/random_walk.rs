//! The integrators of the paper's Figures 5 and 6 in a world with an exact answer.
//!
//! Each test compares one mean with the exact value; |z| > 5 is a false alarm with probability
//! 6e-7, and the seeds are fixed.

use std::ops::RangeInclusive;

use crate::world::{Camera, Light, Mean, Seen, Spot, Step, Walks, Ways, World};
use aether_core::estimator::{Ending, Endings, Factors, Steps};
use aether_core::{
    Arena, BalanceHeuristic, Estimator, Heuristic, MaximumHeuristic, Pcg32, PowerHeuristic,
    RandomSequence, UniformSource, combine, combine_with,
};

const SAMPLES: u64 = 100_000;
const LIMIT: f64 = 5.0;

type Walk<'a, 'w> = RandomSequence<'a, Spot, Ways<'w>>;
type Seer<'w> = Estimator<Seen<'w>, Factors<f64>>;

fn exact(world: &World, edges: std::ops::RangeInclusive<usize>) -> f64 {
    edges.map(|edges| world.exact(edges)).sum()
}

/// Figure 5, for paths of 2 to `max_depth` edges.
fn path_tracer<'w, H: Heuristic<f64> + Default>(
    world: &'w World,
    arena: &Walks<'w>,
    estimator: &Seer<'w>,
    max_depth: usize,
    uniforms: &mut Pcg32,
) -> f64 {
    let mut cam = arena.sequence();
    cam.append(Camera);
    while cam.size() <= max_depth {
        cam.append(Step(world));
    }
    cam.sample(uniforms);

    let mut seen = 0.0;
    for length in 2..cam.size() {
        let bsdf = cam.slice(0..length + 1);
        let mut direct = cam.slice(0..length);
        direct.append(Light(world)).sample(uniforms);
        for path in combine::<H, _>(&[bsdf, direct]) {
            seen += path.weight * estimator.of(&path);
        }
    }
    seen
}

/// Runs an estimate many times and returns its distance from the exact value.
fn z(
    mirror: f64,
    exact: impl Fn(&World) -> f64,
    estimate: impl for<'w> Fn(&'w World, &Walks<'w>, &Seer<'w>, &mut Pcg32) -> f64,
) -> f64 {
    let world = World::with_mirror(mirror);
    let estimator = Estimator::paths(Seen(&world));
    let mut arena = Arena::new();
    let mut mean = Mean::default();
    for sample in 0..SAMPLES {
        arena.clear();
        mean.add(estimate(&world, &arena, &estimator, &mut Pcg32::new(1, 0, sample)));
    }
    mean.z(exact(&world))
}

/// A contribution: the length of the path, the number of its ending, weight × f / p, f / p.
type Found = (usize, usize, f64, f64);

/// What a walk's paths of some lengths contribute, in several ways to end them.
fn ended<'w>(
    world: &'w World,
    seed: u64,
    lengths: impl Fn(usize) -> RangeInclusive<usize>,
    each: impl Fn(Walk<'_, 'w>, RangeInclusive<usize>, &Seer<'w>, &mut Pcg32) -> Vec<Found>,
) -> Vec<Found> {
    let (arena, estimator) = (Arena::new(), Estimator::paths(Seen(world)));
    let mut uniforms = Pcg32::new(1, 0, seed);
    let mut walk = arena.sequence();
    walk.append(Camera).sample(&mut uniforms);
    while walk.is_complete() && walk.size() < 6 {
        walk.append(Step(world)).sample(&mut uniforms);
    }
    each(walk, lengths(walk.size()), &estimator, &mut uniforms)
}

/// Which ways end paths of some length, in these tests.
fn is_used(length: usize, steps: &[Ways<'_>]) -> bool {
    length != 4 || steps.len() == 1
}

/// The contribution of an ending, with the number of its way.
fn numbered<'w>(ways: &[&[Ways<'w>]], end: &Ending<'_, Ways<'w>, f64>) -> Found {
    let way = ways.iter().position(|way| way.as_ptr() == end.steps.as_ptr());
    (end.length, way.expect("one of them"), end.value, end.alone)
}

/// The contributions of a walk that is made first, in some ways to end it.
fn ended_at_once<'w>(world: &'w World, seed: u64, ways: &[&[Ways<'w>]]) -> Vec<Found> {
    let lengths = |size: usize| 3..=size;
    ended(world, seed, lengths, |walk, lengths, estimator, uniforms| {
        let (endings, mut all) = (Endings { lengths, ways, is_used }, Vec::new());
        estimator.endings(&walk, &endings, &PowerHeuristic, uniforms, |end| {
            all.push(numbered(ways, &end));
        });
        all
    })
}

#[test]
fn endings_contribute_what_their_paths_do() {
    let world = World::with_mirror(0.4);
    let [light, step] = [Ways::from(Light(&world)), Ways::from(Step(&world))];
    let short: [&[_]; 3] = [&[], &[light], &[step]];
    let long: [&[_]; 3] = [&[], &[light], &[step, light]];
    let mut found = [0; 3];
    for (seed, ways) in (0..2000).flat_map(|seed| [(seed, short), (seed, long)]) {
        let lengths = |size: usize| 3..=size;
        let at_once = ended_at_once(&world, seed, &ways);
        let by_paths = ended(&world, seed, lengths, |walk, lengths, estimator, uniforms| {
            let mut all = Vec::new();
            for length in lengths {
                let used: Vec<_> = (0..3).filter(|way| is_used(length, ways[*way])).collect();
                let of_way = |way: &usize| {
                    let mut path = walk.slice(0..length - ways[*way].len());
                    for step in ways[*way] {
                        path.append(*step).sample(uniforms);
                    }
                    path
                };
                let paths: Vec<_> = used.iter().map(of_way).collect();
                for found in estimator.each(combine::<PowerHeuristic, _>(&paths)) {
                    all.push((length, used[found.technique], found.value, found.alone));
                }
            }
            all
        });
        assert_eq!(at_once.len(), by_paths.len());
        for (a, b) in at_once.iter().zip(&by_paths) {
            let is_near = |x: f64, y: f64| (x - y).abs() <= 1e-14 * y.abs();
            assert!((a.0, a.1) == (b.0, b.1), "{a:?} {b:?}");
            assert!(is_near(a.2, b.2) && is_near(a.3, b.3), "{a:?} {b:?}");
            found[a.1] += 1;
        }
    }
    assert!(found.iter().all(|count| *count > 1000), "{found:?}");
}

/// The contributions of a walk from the camera that is not kept, in some ways to end it. Its first strategies are told.
fn walked<'w>(world: &'w World, (seed, first): (u64, usize), ways: &[&[Ways<'w>]]) -> Vec<Found> {
    let (arena, estimator) = (Arena::new(), Estimator::paths(Seen(world)));
    let mut uniforms = Pcg32::new(1, 0, seed);
    let step = Ways::from(Step(world));
    let strategies = [Ways::from(Camera), step];
    let steps = Steps { first: &strategies[..first], then: &step };
    let (endings, mut all) = (Endings { lengths: 3..=6, ways, is_used }, Vec::new());
    estimator.walk(&arena, &steps, &endings, &PowerHeuristic, &mut uniforms, |end| {
        all.push(numbered(ways, &end));
    });
    all
}

#[test]
fn walks_that_are_not_kept_contribute_the_same() {
    let world = World::with_mirror(0.4);
    let [light, step] = [Ways::from(Light(&world)), Ways::from(Step(&world))];
    let short: [&[_]; 3] = [&[], &[light], &[step]];
    let long: [&[_]; 3] = [&[], &[light], &[step, light]];
    let mut more = 0;
    for (seed, ways) in (0..2000).flat_map(|seed| [(seed, short), (seed, long)]) {
        let made = ended_at_once(&world, seed, &ways);
        let went_on = walked(&world, (seed, 1), &ways);
        assert_eq!(walked(&world, (seed, 2), &ways), went_on);
        // Behind the end of a walk, an ending of several steps may find something yet.
        assert!(ways[2].len() > 1 || went_on.len() == made.len(), "{went_on:?} {made:?}");
        assert!(went_on.starts_with(&made), "{went_on:?} {made:?}");
        more += went_on.len() - made.len();
    }
    assert!(more > 100, "{more}");
}

#[test]
fn path_tracer_finds_the_exact_value() {
    for mirror in [0.0, 0.4] {
        let z = [
            z(
                mirror,
                |w| exact(w, 2..=5),
                |w, a, e, u| path_tracer::<PowerHeuristic>(w, a, e, 5, u),
            ),
            z(
                mirror,
                |w| exact(w, 2..=5),
                |w, a, e, u| path_tracer::<BalanceHeuristic>(w, a, e, 5, u),
            ),
            z(
                mirror,
                |w| exact(w, 2..=5),
                |w, a, e, u| path_tracer::<MaximumHeuristic>(w, a, e, 5, u),
            ),
        ];
        assert!(z.iter().all(|z| z.abs() < LIMIT), "mirror {mirror}: {z:?}");
    }
}

#[test]
fn an_error_of_five_percent_would_be_found() {
    let z = z(
        0.4,
        |w| 1.05 * exact(w, 2..=5),
        |w, a, e, u| path_tracer::<PowerHeuristic>(w, a, e, 5, u),
    );
    assert!(z.abs() > LIMIT, "{z}");
}

#[test]
fn several_light_samples_with_their_count() {
    let z = z(
        0.4,
        |w| w.exact(2),
        |world, arena, estimator, uniforms| {
            let mut cam = arena.sequence();
            cam.append(Camera).append(Step(world)).append(Step(world)).sample(uniforms);
            let mut seen = 0.0;
            let mut bsdf = Some(cam);
            for block in 0..4 {
                let mut direct = cam.slice(0..2);
                direct.append_in(1000 + block, Light(world)).sample(uniforms);
                let combined = combine::<PowerHeuristic, _>([(cam, 1), (direct, 4)]);
                for path in combined {
                    // The path that the four lists share counts once.
                    if path.last() != cam.last() || bsdf.take().is_some() {
                        seen += path.weight * estimator.of(&path);
                    }
                }
            }
            seen
        },
    );
    assert!(z.abs() < LIMIT, "{z}");
}

/// Figure 6, for paths of 1 to `max_depth` edges.
fn bidirectional<'w>(
    world: &'w World,
    arena: &Walks<'w>,
    estimator: &Seer<'w>,
    max_depth: usize,
    uniforms: &mut Pcg32,
) -> f64 {
    let (mut cam, mut emt) = (arena.sequence(), arena.sequence());
    cam.append(Camera);
    emt.append(Light(world));
    while cam.size() <= max_depth {
        cam.append(Step(world));
        emt.append(Step(world));
    }
    cam.sample(uniforms);
    emt.sample(uniforms);

    let mut seen = 0.0;
    for length in 2..=max_depth + 1 {
        let paths = arena.collect(
            (0..=length)
                .map(|size| cam.slice(0..size).concat(&emt.slice(0..length - size).reverse())),
        );
        seen += estimator.sum(combine::<PowerHeuristic, _>(paths));
    }
    seen
}

#[test]
fn bidirectional_finds_the_exact_value() {
    for mirror in [0.0, 0.4] {
        let z = z(mirror, |w| exact(w, 1..=4), |w, a, e, u| bidirectional(w, a, e, 4, u));
        assert!(z.abs() < LIMIT, "mirror {mirror}: {z}");
    }
}

#[test]
fn weights_agree_with_densities_and_sum_to_one() {
    let world = World::with_mirror(0.4);
    let mut arena = Arena::new();
    let mut checked = [0; 2];
    for sample in 0..300 {
        arena.clear();
        let arena: &Walks<'_> = &arena;
        let mut uniforms = Pcg32::new(2, 0, sample);
        let (mut cam, mut emt) = (arena.sequence(), arena.sequence());
        cam.append(Camera);
        emt.append(Light(&world));
        for _ in 0..4 {
            cam.append(Step(&world));
            emt.append(Step(&world));
        }
        cam.sample(&mut uniforms);
        emt.sample(&mut uniforms);
        for length in 2..=5 {
            let paths: Vec<_> = (0..=length)
                .map(|s| cam.slice(0..s).concat(&emt.slice(0..length - s).reverse()))
                .collect();
            for path in combine::<PowerHeuristic, _>(&paths) {
                let own = path.pdf();
                assert!(own.is_regular());
                let p: Vec<f64> = paths.iter().map(|t| t.pdf_of(&path).ratio(own)).collect();
                let expected = 1.0 / p.iter().map(|p| p * p).sum::<f64>();
                assert!((path.weight - expected).abs() < 1e-12, "{} {expected}", path.weight);
                checked[usize::from(expected < 1.0)] += 1;
            }
            // The same with equal weights to all techniques that can make the path: each path's
            // weights sum to one by counting.
            let count =
                |ratios: &[f64], _: usize| ratios.iter().filter(|r| **r > 0.0).count() as f64;
            for path in combine_with(count, &paths) {
                let able = paths.iter().filter(|t| !t.pdf_of(&path).is_zero()).count();
                assert_eq!(path.weight, able as f64);
            }
        }
    }
    assert!(checked.iter().all(|n| *n > 100), "{checked:?}");
}

#[test]
fn only_connections_need_shadow_rays() {
    let world = World::default();
    let estimator = Estimator::paths(Seen(&world));
    let arena: Walks<'_> = Arena::new();
    // Always survives.
    let mut uniforms = || 0.25;
    let (mut cam, mut emt) = (arena.sequence(), arena.sequence());
    cam.append(Camera).append(Step(&world)).append(Step(&world)).sample(&mut uniforms);
    emt.append(Light(&world)).append(Step(&world)).sample(&mut uniforms);
    assert!(estimator.of(&cam) > 0.0);
    assert_eq!(world.shadow_rays.get(), 0);
    let path = cam.concat(&emt.reverse());
    assert!(estimator.of(&path) > 0.0);
    assert_eq!(world.shadow_rays.get(), 1);
    assert!(estimator.of(&cam.slice(0..2).concat(&emt.reverse())) > 0.0);
    assert_eq!(world.shadow_rays.get(), 2);
}

/// Vertex connection and merging (Georgiev et al. 2012) for paths of `edges` edges: the technique that the
/// camera follows to the end, all connections with one light path, and all merges with `LIGHTS`, within a
/// distance of `RADIUS`. `with` says which of the kinds of techniques are used.
fn connecting_and_merging<'w>(
    world: &'w World,
    arena: &Walks<'w>,
    estimator: &Seer<'w>,
    edges: usize,
    with: [bool; 2],
    uniforms: &mut Pcg32,
) -> f64 {
    const LIGHTS: usize = 8;
    const RADIUS: f64 = 0.01;
    let n = edges + 1;
    let walk = |first: crate::world::Ways<'w>, uniforms: &mut Pcg32| {
        let mut path = arena.sequence();
        path.append(first);
        while path.size() < n {
            path.append(Step(world));
        }
        *path.sample(uniforms)
    };
    let cam = walk(Camera.into(), uniforms);
    let seed: f64 = uniforms.next();
    let mut seen = 0.0;
    for number in 0..LIGHTS {
        let mut source = Pcg32::new(seed.to_bits(), number as u64, 0);
        let light = walk(Light(world).into(), &mut source);
        let connections = (2..=n).filter(|_| with[0]).map(|t| {
            let path = cam.slice(0..t).concat(&light.slice(0..n - t).reverse());
            (if number == 0 { path } else { path.technique() }, 1)
        });
        let merges = (2..=n).filter(|_| with[1]).map(|t| {
            let (here, there) = (cam.slice(0..t), light.slice(0..n + 1 - t).reverse());
            let met = match (here.vertex(t - 1), there.vertex(0)) {
                (Some(x), Some(y)) => (x.0 - y.0).abs() < RADIUS,
                _ => false,
            };
            let path = here.merge(&there, 2.0 * RADIUS);
            (if met { path } else { path.technique() }, LIGHTS)
        });
        let paths = arena.collect_counted(connections.chain(merges));
        seen += estimator.sum(combine::<PowerHeuristic, _>(paths));
    }
    seen
}

fn assert_merging_is_exact(with: [bool; 2]) {
    for mirror in [0.0, 0.4] {
        let z = z(mirror, |w| w.exact(4), |w, a, e, u| connecting_and_merging(w, a, e, 4, with, u));
        assert!(z.abs() < LIMIT, "mirror {mirror}: {z}");
    }
}

#[test]
fn merging_finds_the_exact_value() {
    assert_merging_is_exact([false, true]);
}

#[test]
fn merging_beside_connections_finds_the_exact_value() {
    assert_merging_is_exact([true, true]);
}
