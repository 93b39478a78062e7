//! Paths of two walks that are weighed at once contribute what they do one by one.

use crate::world::{Camera, Light, Seen, Spot, Step, World};
use aether_core::estimator::{Connected, Connections, Factors, Techniques};
use aether_core::sequence::PathView;
use aether_core::strategy::{Conditional, Drawn, Reads, Strategy};
use aether_core::{
    Arena, BalanceHeuristic, Estimator, PathIntegrand, Pcg32, PowerHeuristic, RandomSequence,
    UniformSource, combine::Separable, combine_with, strategies,
};

/// A point, under a mixture that the last two vertices decide.
fn lobe(path: PathView<'_, Spot>) -> f64 {
    let [last, before] = [0, 1].map(|k| path.back(k).map_or(0.5, |spot| spot.0));
    0.7 * last + 0.2 * before
}

fn draw<U: UniformSource<f64> + ?Sized>(path: PathView<'_, Spot>, uniforms: &mut U) -> Spot {
    let (choice, u) = (uniforms.next(), uniforms.next());
    Spot(if choice < lobe(path) { u.sqrt() } else { u })
}

fn density(path: PathView<'_, Spot>, target: &Spot) -> f64 {
    let lobe = lobe(path);
    1.0 - lobe + lobe * 2.0 * target.0
}

/// A step that reads two vertices, and survives less often behind three.
#[derive(Clone, Copy)]
struct Fading;

impl Fading {
    fn survival(path: PathView<'_, Spot>) -> f64 {
        if path.len() < 3 { 1.0 } else { 0.9 }
    }
}

impl Strategy<Spot> for Fading {
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        path: PathView<'_, Spot>,
        uniforms: &mut U,
    ) -> Option<Drawn<Spot>> {
        let goes_on = uniforms.next() < Fading::survival(path);
        goes_on.then(|| Drawn::new(draw(path, uniforms)).visible())
    }
    fn pdf(&self, path: PathView<'_, Spot>, target: &Spot) -> Conditional<f64> {
        Conditional::density(Fading::survival(path) * density(path, target))
    }
    fn reads(&self) -> Reads {
        Reads { vertices: 2, length: true }
    }
    fn length_class(&self, len: usize) -> u32 {
        u32::from(len >= 3)
    }
    fn same(&self, _: &Self) -> bool {
        true
    }
}

/// A last vertex that two before it decide.
#[derive(Clone, Copy)]
struct Glance;

impl Strategy<Spot> for Glance {
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        path: PathView<'_, Spot>,
        uniforms: &mut U,
    ) -> Option<Drawn<Spot>> {
        Some(Drawn::new(draw(path, uniforms)))
    }
    fn pdf(&self, path: PathView<'_, Spot>, target: &Spot) -> Conditional<f64> {
        Conditional::density(density(path, target))
    }
    fn reads(&self) -> Reads {
        Reads::TWO
    }
    fn same(&self, _: &Self) -> bool {
        true
    }
}

/// A step that reads three vertices.
#[derive(Clone, Copy)]
struct Far;

impl Far {
    fn lobe(path: PathView<'_, Spot>) -> f64 {
        path.back(2).map_or(0.5, |spot| spot.0)
    }
}

impl Strategy<Spot> for Far {
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        path: PathView<'_, Spot>,
        uniforms: &mut U,
    ) -> Option<Drawn<Spot>> {
        let (choice, u) = (uniforms.next(), uniforms.next());
        Some(Drawn::new(Spot(if choice < Far::lobe(path) { u.sqrt() } else { u })))
    }
    fn pdf(&self, path: PathView<'_, Spot>, target: &Spot) -> Conditional<f64> {
        let lobe = Far::lobe(path);
        Conditional::density(1.0 - lobe + lobe * 2.0 * target.0)
    }
    fn reads(&self) -> Reads {
        Reads { vertices: 3, length: false }
    }
    fn same(&self, _: &Self) -> bool {
        true
    }
}

strategies! {
    #[derive(Clone, Copy)]
    enum Ways<'w> for Spot {
        Camera(Camera),
        Step(Step<'w>),
        Light(Light<'w>),
        Fading(Fading),
        Glance(Glance),
        Far(Far),
    }
}

/// An integrand that reads so few vertices.
struct Short(usize);

impl PathIntegrand for Short {
    type Vertex = Spot;
    type Value = f64;
    fn extend(&self, path: PathView<'_, Spot>) -> f64 {
        (0..self.0).map(|k| path.back(k).map_or(0.3, |spot| spot.0)).sum::<f64>() + 0.1
    }
    fn end(&self, path: PathView<'_, Spot>) -> f64 {
        path.last().map_or(0.0, |spot| 1.0 + spot.0)
    }
    fn reads(&self) -> usize {
        self.0
    }
}

type Walk<'a, 'w> = RandomSequence<'a, Spot, Ways<'w>>;

/// A walk, and strategies behind its end up to `size`.
fn walk<'a, 'w>(
    arena: &'a Arena<Spot, Ways<'w>>,
    (start, step): (Ways<'w>, Ways<'w>),
    (len, size): (usize, usize),
    uniforms: &mut Pcg32,
) -> Walk<'a, 'w> {
    let mut walk = arena.sequence();
    walk.append(start).sample(uniforms);
    while walk.is_complete() && walk.size() < len {
        walk.append(step).sample(uniforms);
    }
    while walk.size() < size {
        walk.append(step);
    }
    walk
}

/// What paths contribute, made one by one.
fn one_by_one<I: PathIntegrand<Vertex = Spot, Value = f64>, S: Strategy<Spot>, H>(
    estimator: &Estimator<I, Factors<f64>>,
    [first, second]: [&RandomSequence<'_, Spot, S>; 2],
    connections: &Connections<'_, S, f64, H, impl Fn(usize, usize) -> bool>,
    uniforms: &mut Pcg32,
) -> Vec<Connected<f64>>
where
    H: Separable<f64> + Clone,
{
    let mut connected = Vec::new();
    for n in connections.lengths.clone().filter(|n| *n > 0) {
        let samples = |by: usize| connections.techniques.samples(n, by);
        let ends = |by: usize| {
            connections.ending.is_some() && by + 1 == n && n >= connections.fewest_ending
        };
        let exists = |by: usize| by <= first.size() && (ends(by) || n - by <= second.size());
        let used: Vec<_> = (0..=n).filter(|by| exists(*by) && samples(*by) > 0).collect();
        let paths: Vec<_> = used
            .iter()
            .map(|by| {
                let mut path = first.slice(0..*by);
                match connections.ending.filter(|_| ends(*by)) {
                    Some(ending) => {
                        path.append(ending.clone());
                        // Steps behind the end of a walk are techniques.
                        if *by <= first.len() {
                            path.sample(uniforms);
                        }
                    }
                    None => path = path.concat(&second.slice(0..n - by).reverse()),
                }
                let path = if (connections.is_drawn)(n, *by) { path } else { path.technique() };
                (path, samples(*by))
            })
            .collect();
        let all = estimator.each(combine_with(connections.techniques.heuristic().clone(), &paths));
        connected.extend(all.map(|found| Connected {
            length: n,
            first: used[found.technique],
            value: found.value,
            alone: found.alone,
        }));
    }
    connected
}

/// A way to find what connections contribute.
#[derive(Clone, Copy, PartialEq)]
enum By {
    /// Paths of all lengths at once.
    Connections,
    /// Paths of one length after the other.
    Lengths,
    /// Paths that are made.
    Paths,
}

/// A contribution: the length of the path, how many of its vertices are those of the first walk, weight × f / p, f / p.
type Found = (usize, usize, f64, f64);

/// All that two walks contribute, asked for twice.
fn found<H: Separable<f64> + Clone>(
    world: &World,
    (seed, longest): (u64, usize),
    ending: Option<Ways<'_>>,
    heuristic: &H,
    by: By,
) -> Vec<Found> {
    let (arena, estimator) = (Arena::new(), Estimator::paths(Seen(world)));
    let uniforms = &mut Pcg32::new(1, 0, seed);
    let step = if world.mirror > 0.0 { Ways::from(Step(world)) } else { Fading.into() };
    let size = (longest, longest);
    let first = walk(&arena, (Camera.into(), step), size, uniforms);
    let second = walk(&arena, (Light(world).into(), step), size, uniforms);
    let mut all = Vec::new();
    let mut techniques = Techniques::new(heuristic.clone());
    techniques.reach(longest, |length, first| match first {
        // The eye is where it is: another walk does not find it.
        0 => 3,
        // One technique is not used.
        3 if length == 5 => 0,
        1 => 7,
        _ if first == length => 1,
        _ => 2,
    });
    for _ in 0..2 {
        let mut estimate = |lengths: std::ops::RangeInclusive<usize>| {
            let connections = Connections {
                lengths,
                ending: ending.as_ref(),
                fewest_ending: 3,
                techniques: &techniques,
                is_drawn: |length: usize, first: usize| first != 2 || length != 4,
            };
            let pieces = [&first, &second];
            let mut keep = |found: Connected<f64>| {
                all.push((found.length, found.first, found.value, found.alone));
            };
            if by == By::Paths {
                let found = one_by_one(&estimator, pieces, &connections, uniforms);
                return found.into_iter().for_each(&mut keep);
            }
            estimator.connections(pieces, &connections, uniforms, keep);
        };
        match by {
            By::Lengths => (0..=longest).for_each(|length| estimate(length..=length)),
            By::Connections | By::Paths => estimate(0..=longest),
        }
    }
    all
}

/// Compares both ways for many walks, and returns how many paths with each number of vertices of the first walk
/// contributed.
fn compare<H: Separable<f64> + Clone>(
    mirror: f64,
    seeds: std::ops::Range<u64>,
    longest: usize,
    heuristic: &H,
) -> Vec<usize> {
    let world = World::with_mirror(mirror);
    let mut count = vec![0; longest + 1];
    for seed in seeds {
        for ending in [None, Some(Ways::from(Light(&world))), Some(Glance.into())] {
            let [at_once, by_length, one_by_one] = [By::Connections, By::Lengths, By::Paths]
                .map(|by| found(&world, (seed, longest), ending, heuristic, by));
            assert_eq!(at_once.len(), one_by_one.len(), "seed {seed}");
            assert_eq!(by_length.len(), one_by_one.len(), "seed {seed}");
            let ways = at_once.iter().chain(&by_length);
            for (a, b) in ways.zip(one_by_one.iter().chain(&one_by_one)) {
                let is_near = |x: f64, y: f64| (x - y).abs() <= 1e-12 * y.abs();
                assert!((a.0, a.1) == (b.0, b.1), "seed {seed}: {a:?} {b:?}");
                assert!(is_near(a.2, b.2) && is_near(a.3, b.3), "seed {seed}: {a:?} {b:?}");
                count[a.1] += 1;
            }
        }
    }
    count
}

#[test]
fn connections_contribute_what_their_paths_do() {
    for mirror in [0.0, 0.4] {
        let counts = [
            compare(mirror, 0..300, 7, &PowerHeuristic),
            compare(mirror, 300..400, 7, &BalanceHeuristic),
        ];
        for count in counts {
            assert!(count[1..].iter().all(|count| *count > 50), "mirror {mirror}: {count:?}");
        }
    }
}

#[test]
fn walks_of_many_vertices_are_weighed_alike() {
    let count = compare(0.0, 0..1, 60, &PowerHeuristic);
    assert!(count[1..].iter().sum::<usize>() > 100, "{count:?}");
}

/// Asserts that connections contribute what their paths do, and returns how many did.
fn assert_alike<'w, I: PathIntegrand<Vertex = Spot, Value = f64>>(
    estimator: &Estimator<I, Factors<f64>>,
    walks: [&Walk<'_, 'w>; 2],
    ending: Option<Ways<'w>>,
    (heuristic, most, fewest): (&(impl Separable<f64> + Clone), usize, usize),
    uniforms: &mut Pcg32,
) -> usize {
    let mut techniques = Techniques::new(heuristic.clone());
    techniques.reach(7, |_, first| 1 + first % most);
    let connections = Connections {
        lengths: fewest..=7,
        ending: ending.as_ref(),
        fewest_ending: 1,
        techniques: &techniques,
        is_drawn: |_, _| true,
    };
    let mut found = Vec::new();
    let keep = |path: Connected<f64>| found.push(path);
    estimator.connections(walks, &connections, uniforms, keep);
    let expected = one_by_one(estimator, walks, &connections, uniforms);
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(&expected) {
        let is_near = |x: f64, y: f64| (x - y).abs() <= 1e-12 * y.abs();
        let alike = (a.length, a.first) == (b.length, b.first);
        assert!(alike && is_near(a.value, b.value) && is_near(a.alone, b.alone), "{a:?} {b:?}");
    }
    found.len()
}

/// Walks that part from another one, walks that are empty, integrands that read little, and steps that read much.
#[test]
fn walks_and_integrands_of_all_kinds_in_one_arena() {
    let world = World::with_mirror(0.0);
    let mut count = [0; 6];
    for seed in 0..100 {
        let (arena, seen) = (Arena::new(), Estimator::paths(Seen(&world)));
        let uniforms = &mut Pcg32::new(1, 0, seed);
        let light = Ways::from(Light(&world));
        let first = walk(&arena, (Camera.into(), Fading.into()), (5, 7), uniforms);
        let second = walk(&arena, (light, Fading.into()), (5, 7), uniforms);
        let mut parted = second.slice(0..2);
        parted.append(Fading).append(Fading).append(Fading).sample(uniforms);
        let (empty, power) = (arena.sequence(), (&PowerHeuristic, 2, 1));
        for ending in [None, Some(Glance.into())] {
            for second in [&second, &parted, &second, &empty] {
                count[0] += assert_alike(&seen, [&first, second], ending, power, uniforms);
            }
            // Steps are alike behind the third vertex.
            for (power, most) in [(true, 1), (false, 1), (true, 1), (true, 5), (false, 2)] {
                let walks = [&first, &second];
                count[1] += if power {
                    assert_alike(&seen, walks, ending, (&PowerHeuristic, most, 4), uniforms)
                } else {
                    assert_alike(&seen, walks, ending, (&BalanceHeuristic, most, 4), uniforms)
                };
            }
            for reads in [1, 2, 3] {
                let short = Estimator::paths(Short(reads));
                let walks = if reads == 3 { [&empty, &second] } else { [&first, &second] };
                count[1 + reads] += assert_alike(&short, walks, ending, power, uniforms);
            }
        }
        // The last one, as such a strategy is then known.
        let far = Some(Far.into());
        count[5] += assert_alike(&seen, [&first, &second], far, power, uniforms);
    }
    assert!(count.iter().all(|count| *count > 100), "{count:?}");
}
