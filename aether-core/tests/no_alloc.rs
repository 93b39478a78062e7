//! No heap allocation once the arena is warm.

#[path = "all/world.rs"]
mod world;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use aether_core::{
    Arena, Conditional, Drawn, DrawnRun, Estimator, MarkovChainState, PathView, Pcg32,
    PowerHeuristic, RandomSequence, Strategy, UniformSource, combine, mutation,
};
use world::{Camera, Light, Seen, Spot, Step, Walks, Ways, World};

/// The system's allocator, counting what this thread asks for.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call is passed on unchanged to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promises are those that the system asks for.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

fn sample<'w>(world: &'w World, arena: &Walks<'w>, seed: u64) -> (usize, f64) {
    let estimator = Estimator::paths(Seen(world));
    let mut uniforms = Pcg32::new(seed, 0, 0);
    let (mut cam, mut emt) = (arena.sequence(), arena.sequence());
    cam.append(Camera);
    emt.append(Light(world));
    for _ in 0..6 {
        cam.append(Step(world));
        emt.append(Step(world));
    }
    let before = ALLOCATIONS.with(Cell::get);
    cam.sample(&mut uniforms);
    emt.sample(&mut uniforms);
    let mut total = 0.0;
    for length in 2..7 {
        let mut direct = cam.slice(0..length);
        direct.append(Light(world)).sample(&mut uniforms);
        for path in combine::<PowerHeuristic, _>([cam.slice(0..length + 1), direct]) {
            total += path.weight;
        }
        let paths = arena.collect(
            (0..length)
                .map(|size| cam.slice(0..size).concat(&emt.slice(0..length - size).reverse())),
        );
        for path in combine::<PowerHeuristic, _>(paths) {
            total += path.weight * path.pdf().ln();
        }
    }
    let allocations = ALLOCATIONS.with(Cell::get) - before;
    (allocations, total + estimator.of(&cam))
}

#[test]
fn a_warm_arena_allocates_nothing() {
    let world = World::with_mirror(0.4);
    let mut arena = Arena::new();
    assert!(sample(&world, &arena, 0).0 > 0);
    for seed in 0..200 {
        arena.clear();
        sample(&world, &arena, seed);
    }
    for seed in 0..200 {
        arena.clear();
        let (allocations, total) = sample(&world, &arena, seed);
        assert_eq!(allocations, 0, "seed {seed}");
        assert!(total.is_finite());
    }
}

/// Two vertices of one draw.
#[derive(Clone)]
struct Pair;
impl Strategy<Spot> for Pair {
    const VERTICES: usize = 2;
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        _: PathView<'_, Spot>,
        _: &mut U,
    ) -> Option<Drawn<Spot>> {
        None
    }
    fn pdf(&self, _: PathView<'_, Spot>, _: &Spot) -> Conditional<f64> {
        Conditional::ZERO
    }
    fn sample_joint<U: UniformSource<f64> + ?Sized>(
        &self,
        _: PathView<'_, Spot>,
        uniforms: &mut U,
    ) -> Option<DrawnRun<Spot>> {
        Some(Drawn::new([(); 2].map(|()| Spot(uniforms.next()))).into())
    }
    fn pdf_joint(&self, _: PathView<'_, Spot>, _: &[Spot]) -> f64 {
        1.0
    }
}

#[test]
fn warm_runs_allocate_nothing() {
    let mut arena = Arena::<Spot, Pair>::new();
    let mut run = |seed: u64| {
        arena.clear();
        let before = ALLOCATIONS.with(Cell::get);
        let mut uniforms = Pcg32::new(seed, 0, 0);
        let (mut a, mut b) = (arena.sequence(), arena.sequence());
        a.append(Pair).append(Pair).append(Pair).sample(&mut uniforms);
        b.append(Pair).append(Pair).append(Pair).sample(&mut uniforms);
        let paths = arena
            .collect((0..=3).map(|k| a.slice(0..2 * k).concat(&b.slice(0..6 - 2 * k).reverse())));
        let weights = combine::<PowerHeuristic, _>(paths).map(|path| path.weight);
        assert!((weights.sum::<f64>() - 1.0).abs() < 1e-15);
        ALLOCATIONS.with(Cell::get) - before
    };
    assert!((0..20).map(&mut run).sum::<usize>() > 0);
    assert_eq!((0..20).map(run).sum::<usize>(), 0);
}

#[test]
fn a_warm_estimator_allocates_nothing() {
    let world = World::with_mirror(0.4);
    let estimator = Estimator::paths(Seen(&world));
    let mut arena: Walks<'_> = Arena::new();
    let mut run = |seed: u64| {
        arena.clear();
        let before = ALLOCATIONS.with(Cell::get);
        let mut uniforms = Pcg32::new(seed, 0, 0);
        let mut path = arena.sequence();
        path.append(Camera);
        for _ in 0..10 {
            path.append(Step(&world));
        }
        path.sample(&mut uniforms);
        let sum: f64 = (1..=path.len()).map(|len| estimator.of(&path.slice(0..len))).sum();
        assert!(sum.is_finite());
        ALLOCATIONS.with(Cell::get) - before
    };
    assert!((0..100).map(&mut run).sum::<usize>() > 0);
    assert_eq!((0..100).map(run).sum::<usize>(), 0);
}

#[test]
fn a_warm_chain_allocates_nothing() {
    let world = World::with_mirror(0.4);
    let estimator = Estimator::paths(Seen(&world));
    // Deletes from one vertex to another, and grows from both ends.
    let bidirectional = mutation(|path: &RandomSequence<'_, Spot, Ways<'_>>, decide| {
        let n = path.len();
        let begin = 1 + decide.index(n)?;
        let end = begin + decide.weighted(n + 1 - begin, |i| 0.5_f64.powi(i as i32))?;
        let mut front = path.slice(0..begin).keep();
        let mut back = path.slice(end..).keep().reverse();
        let (ahead, behind) = (decide.index(3)?, decide.index(3)?);
        let size = begin + ahead + behind + n - end;
        ((2..=6).contains(&size) && decide.wants(size)).then_some(())?;
        (0..ahead).for_each(|_| _ = front.append(Step(&world)));
        for _ in 0..behind {
            if back.size() == 0 {
                back.append(Light(&world))
            } else {
                back.append(Step(&world))
            };
        }
        Some(front.concat(&back.reverse()))
    });
    let target = |path: &RandomSequence<'_, Spot, Ways<'_>>| {
        (0.5_f64.powi(path.len() as i32) * estimator.integrand_at(path), path.len())
    };
    let mut arena: Walks<'_> = Arena::new();
    let mut path = arena.sequence();
    path.append(Camera).append(Light(&world)).sample(&mut || 0.5);
    let mut chain = MarkovChainState::new(&path, &target);
    let mut lengths = 0;
    let mut run = |steps: usize| {
        let before = ALLOCATIONS.with(Cell::get);
        for _ in 0..steps {
            let step = chain.step(&mut arena, &bidirectional, &target, |n| Pcg32::new(3, 0, n));
            lengths |= 1 << step.current;
        }
        ALLOCATIONS.with(Cell::get) - before
    };
    assert!(run(5000) > 0);
    assert_eq!(run(5000), 0);
    assert_eq!(lengths, 0b111_1100, "paths of 2 to 6 vertices");
}
