use super::*;
use crate::kind::Everything;
use crate::scene::Scene;
use crate::strategies::sample_bsdf;
use aether_core::conditional_pdf;
use aether_core::mutation::{Rated, accept_probability, propose};

/// Glass, plastic and a rough ball of small roughness under a small lamp.
const SCENE: &str = r#"<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="6"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="40"/>
        <transform name="to_world"><lookat origin="0,1,5" target="0,0.4,0" up="0,1,0"/></transform>
        <film type="hdrfilm">
            <integer name="width" value="32"/><integer name="height" value="32"/><rfilter type="box"/>
        </film>
    </sensor>
    <shape type="rectangle">
        <transform name="to_world"><rotate x="1" angle="-90"/><scale value="5"/></transform>
        <bsdf type="diffuse"/>
    </shape>
    <shape type="sphere">
        <point name="center" x="-1" y="0.5" z="0"/><float name="radius" value="0.5"/>
        <bsdf type="dielectric"/>
    </shape>
    <shape type="sphere">
        <point name="center" x="0.2" y="0.5" z="0"/><float name="radius" value="0.5"/>
        <bsdf type="roughconductor"><float name="alpha" value="0.1"/></bsdf>
    </shape>
    <shape type="sphere">
        <point name="center" x="1.4" y="0.5" z="0"/><float name="radius" value="0.5"/>
        <bsdf type="roughdielectric"><float name="alpha" value="0.1"/></bsdf>
    </shape>
    <shape type="sphere">
        <point name="center" x="0" y="3" z="1"/><float name="radius" value="0.3"/>
        <emitter type="area"><rgb name="radiance" value="20"/></emitter>
    </shape>
</scene>"#;

fn brightness<'a>(
    metropolis: &Metropolis,
    world: &'a World<'a, Everything>,
    estimator: &PathEstimator<'a, Everything>,
) -> impl Fn(&Path<'_, 'a, Everything>) -> f32 {
    |path| metropolis.contribution(world, estimator, path).0.value()
}

/// f(x) T(y | x) a(x, y) = f(y) T(x | y) a(y, x) for pairs of paths that each mutation makes.
///
/// The numbers are of single precision: each side is a product of four of them, one of which is a quotient
/// of products, so that eight roundings of 6e-8 may add up to 5e-7.
#[test]
fn every_mutation_is_in_detailed_balance() {
    let scene = Scene::from_str(SCENE, std::path::Path::new("."), &[]).unwrap();
    let world: World<'_, Everything> = World::new(&scene).unwrap();
    let path = PathSettings::new(&scene);
    let metropolis = Metropolis::new(path);
    let (mut scratch, mut arena) = (Scratch::new(&world), Arena::new());
    let estimator = Scratch::<_, MutationStrategies<'_, _>>::new(&world).estimator;
    let world = &world;
    let target = brightness(&metropolis, world, &estimator);
    let mutations: [&dyn Mutation<_, _>; 4] = [
        &BidirectionalMutation { world, lengths: 2..=7 },
        &LensPerturbation { world, chains: false },
        &LensPerturbation { world, chains: true },
        &CausticPerturbation { world },
    ];
    let (mut pairs, mut through_rough, mut worst) = ([0; 4], [0; 4], 0.0_f32);
    for sample in 0..16_000 {
        let mut paths = Vec::new();
        let uniforms = &mut Pcg32::new(3, sample, 0);
        metropolis.seeds(world, &mut scratch, uniforms, |_, path| paths.push(Snapshot::of(path)));
        for (k, x) in paths.iter().enumerate() {
            for (i, mutation) in mutations.iter().enumerate() {
                arena.clear();
                let x = arena.restore(x);
                let uniforms = &mut Pcg32::new(4, sample, 8 * k as u64 + i as u64);
                if mutation.weight(&x) == 0.0 {
                    continue;
                }
                let Some(y) = propose(*mutation, &x, uniforms) else { continue };
                let [x, y] = [x, y].map(|path| Rated::new(path, target(&path)));
                let flow = |x: &Rated<'_, _, _>, y: &Rated<'_, _, _>| {
                    let there = conditional_pdf(*mutation, &x.path, &y.path);
                    let accepted = accept_probability(*mutation, x, y);
                    (x.target * there * accepted, accepted)
                };
                let ((there, a), (back, b)) = (flow(&x, &y), flow(&y, &x));
                assert_eq!(there.is_zero(), back.is_zero(), "{}", MUTATIONS[i]);
                // A probability as small as 1e-38 has fewer digits.
                if a.min(b) >= f32::MIN_POSITIVE {
                    worst = worst.max((there.ratio(back) - 1.0).abs());
                    pairs[i] += 1;
                    let rough = |v: SceneVertex<_>| (0.05..0.2).contains(&world.roughness(&v));
                    through_rough[i] += usize::from(y.path.vertices().any(rough));
                }
            }
        }
    }
    println!("pairs {pairs:?}, of these with rough chains {through_rough:?}, worst {worst:.1e}");
    assert!(pairs.iter().all(|count| *count > 20), "{pairs:?}");
    assert!(through_rough.iter().all(|count| *count > 5), "{through_rough:?}");
    assert!(worst < 1e-6, "{worst}");
}

/// The brightness of a candidate is that of the paths of which a chain takes its first, to rounding: each is a sum of
/// some twenty products of twenty numbers. One of them may be smaller than the smallest that has all its digits.
#[test]
fn candidates_are_as_bright_as_their_paths() {
    let scene = Scene::from_str(SCENE, std::path::Path::new("."), &[]).unwrap();
    let world: World<'_, Everything> = World::new(&scene).unwrap();
    let metropolis = Metropolis::new(PathSettings::new(&scene));
    let mut scratch = Scratch::new(&world);
    let mut techniques = Techniques::new(PowerHeuristic);
    let mut bright = 0;
    for candidate in 0..6000 {
        let uniforms = || uniforms_of(5, candidate);
        let mut sum = 0.0;
        metropolis.seeds(&world, &mut scratch, &mut uniforms(), |b, _| sum += b);
        let (scratch, techniques) = (&mut scratch, &mut techniques);
        let found = metropolis.brightness_of_seeds(&world, scratch, techniques, &mut uniforms());
        let error = 1e-4 * sum + f32::MIN_POSITIVE;
        assert!((found - sum).abs() <= error, "{candidate}: {found} {sum}");
        bright += usize::from(sum > 0.0);
    }
    assert!(bright > 500, "{bright}");
}

/// A pinhole is where it was; to replace it would waste proposals.
#[test]
fn a_pinhole_stays() {
    let scene = Scene::from_str(SCENE, std::path::Path::new("."), &[]).unwrap();
    let world: World<'_, Everything> = World::new(&scene).unwrap();
    let metropolis = Metropolis::new(PathSettings::new(&scene));
    let (mut scratch, mut arena) = (Scratch::new(&world), Arena::new());
    let world = &world;
    let mutation = BidirectionalMutation { world, lengths: 2..=7 };
    let (mut proposals, mut anew) = (0, 0);
    for sample in 0..6000 {
        let mut paths = Vec::new();
        let uniforms = &mut Pcg32::new(3, sample, 0);
        metropolis.seeds(world, &mut scratch, uniforms, |_, path| paths.push(Snapshot::of(path)));
        for x in &paths {
            arena.clear();
            let x = arena.restore(x);
            let Some(y) = propose(&mutation, &x, &mut Pcg32::new(4, sample, 0)) else {
                continue;
            };
            assert_eq!(y.position_of(&x, 0), Some(0));
            proposals += 1;
            anew += usize::from((1..x.len()).all(|i| y.position_of(&x, i).is_none()));
        }
    }
    assert!(proposals > 100 && anew > 10, "{proposals} {anew}");
}

/// Replaces a vertex of a path by two, some of which come from the camera.
struct OneByTwo<'a> {
    world: &'a World<'a, Everything>,
    first: usize,
    from_camera: usize,
}

impl<'a> Mutation<SceneVertex<Everything>, MutationStrategies<'a, Everything>> for OneByTwo<'a> {
    fn propose<'r>(
        &self,
        path: &Path<'r, 'a, Everything>,
        _: &mut Decisions<'_, f32>,
    ) -> Option<Draft<'r, SceneVertex<Everything>, MutationStrategies<'a, Everything>>> {
        let mut camera = path.slice(0..self.first).keep();
        let mut light = path.slice(self.first + 1..).reverse().keep();
        for _ in 0..self.from_camera {
            camera.append(sample_bsdf(self.world, u32::MAX, None));
        }
        for _ in self.from_camera..2 {
            light.append(light_step::<_, MutationStrategies<'_, _>>(
                self.world,
                light.size(),
                u32::MAX,
            ));
        }
        Some(camera.concat(&light.reverse()))
    }
}

/// What is drawn has the density that is derived: the expected ratio of the density of one way to make a proposal to
/// that of all ways is the probability that this way makes one. Of paths whose edges are free, that is: a density does
/// not know what lies in between.
///
/// Each way is drawn alone and within the mixture of all, 10,000 times for each of some paths. Of 120 z-values one is
/// beyond 5 in magnitude by chance in 14,000 runs. With densities that are found for the wrong direction there are values
/// beyond 20.
#[test]
fn proposals_are_drawn_with_their_densities() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes");
    let text = std::fs::read_to_string(folder.join("cornell-box.xml")).unwrap();
    let scene = Scene::from_str(&text, &folder, &[]).unwrap();
    let world: World<'_, Everything> = World::new(&scene).unwrap();
    let metropolis = Metropolis::new(PathSettings::new(&scene));
    let (mut scratch, mut arena) = (Scratch::new(&world), Arena::new());
    let estimator = Scratch::<_, MutationStrategies<'_, _>>::new(&world).estimator;
    let world = &world;
    let target = brightness(&metropolis, world, &estimator);
    let mut paths = Vec::new();
    for sample in 0..200 {
        let uniforms = &mut Pcg32::new(3, sample, 0);
        metropolis.seeds(world, &mut scratch, uniforms, |_, path| {
            if (4..=5).contains(&path.len()) {
                paths.push(Snapshot::of(path));
            }
        });
    }
    let draws = 10_000_u32;
    let (mut compared, mut worst) = (0, 0.0_f64);
    for (number, path) in paths.iter().take(40).enumerate() {
        let uniforms = |of: u64, i: u32| Pcg32::new(of, number as u64, u64::from(i));
        let ways = [0, 1, 2].map(|from_camera| OneByTwo { world, first: 2, from_camera });
        let all = ways.each_ref().map(|way| way as &dyn Mutation<_, _>);
        let mixture = Mutations(&all);
        let mut ratios = [(0.0_f64, 0.0_f64); 3];
        for i in 0..draws {
            arena.clear();
            let x = arena.restore(path);
            let Some(y) = propose(&mixture, &x, &mut uniforms(4, i)) else { continue };
            if target(&y) == 0.0 {
                continue;
            }
            let of_all = conditional_pdf(&mixture, &x, &y);
            for (way, sum) in ways.iter().zip(&mut ratios) {
                let ratio = f64::from(conditional_pdf(way, &x, &y).ratio(of_all));
                *sum = (sum.0 + ratio, sum.1 + ratio * ratio);
            }
        }
        for (way, (sum, squares)) in ways.iter().zip(ratios) {
            let made = (0..draws).filter(|i| {
                arena.clear();
                let x = arena.restore(path);
                propose(way, &x, &mut uniforms(5 + way.from_camera as u64, *i))
                    .is_some_and(|y| target(&y) > 0.0)
            });
            let n = f64::from(draws);
            let (mean, expected) = (sum / n, made.count() as f64 / n);
            let variance = (squares / n - mean * mean + expected * (1.0 - expected)) / n;
            if variance > 0.0 {
                worst = worst.max((mean - expected).abs() / variance.sqrt());
                compared += 1;
            }
        }
    }
    println!("{compared} compared, worst {worst:.1}");
    assert!(compared > 100, "{compared}");
    assert!(worst < 5.0, "{worst}");
}

#[test]
fn sets_of_mutations() {
    let set: MutationSet = "lens, caustic".parse().unwrap();
    assert_eq!(set, MutationSet([false, true, false, true]));
    let error = "lens,warp".parse::<MutationSet>().unwrap_err();
    assert!(error.contains("`warp`") && error.contains("multi-chain"), "{error}");
}
