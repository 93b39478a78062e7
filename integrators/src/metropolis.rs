//! Metropolis light transport in path space (Veach and Guibas 1997; Aether 2017, section 7.3): chains of paths,
//! mutated by the functions of [`crate::mutations`]. The densities of mutations are derived.

use aether_core::estimator::{Contribution, Estimator, Factors};
use aether_core::mutation::{Decisions, Draft, Mutation, Mutations};
use aether_core::{
    Arena, MarkovChainState, Pcg32, PowerHeuristic, RandomSequence, Snapshot, UniformSource,
    combine,
};
use glam::Vec3;

use crate::chains::{ChainIntegrator, Contributions, Start};
use crate::integrand::Radiance;
use crate::kind::SceneKind;
use crate::mutations::{
    BidirectionalMutation, CausticPerturbation, LensPerturbation, MutationStrategies,
};
use crate::path::PathSettings;
use crate::render::{Chain, Splats};
use crate::strategies::{Aim, sample_light};
use crate::subpaths::{Scratch, camera_path, extend, light_path};
use crate::vertex::SceneVertex;
use crate::world::World;

/// Settings of Metropolis light transport.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Metropolis {
    /// Lengths of paths; for the paths that chains start with, Russian roulette.
    pub path: PathSettings,
    /// How many independent samples the brightness of the image is estimated from.
    pub candidates: usize,
}

impl Metropolis {
    /// With the usual settings.
    pub fn new(path: PathSettings) -> Self {
        Metropolis { path, candidates: 50_000 }
    }

    /// What a path contributes to the image, and how bright that is.
    fn contribution<K: SceneKind>(
        &self,
        world: &World<'_, K>,
        estimator: &PathEstimator<'_, K>,
        path: &Path<'_, '_, K>,
    ) -> (f32, Contributions) {
        let shortest = 2 + usize::from(self.path.hide_emitters);
        let found = if (shortest..=self.path.most_vertices()).contains(&path.len()) {
            shares(world, estimator, path, estimator.integrand_at(path))
        } else {
            Contributions::default()
        };
        (found.brightness(), found)
    }

    /// Bidirectional samples of the whole image: paths, each with its share of the brightness.
    fn seeds<'a, K: SceneKind>(
        &self,
        world: &'a World<'a, K>,
        Scratch { arena, estimator }: &mut Scratch<'a, K, MutationStrategies<'a, K>>,
        uniforms: &mut impl UniformSource<f32>,
        mut found: impl FnMut(f32, &Path<'_, 'a, K>),
    ) {
        arena.clear();
        let (longest, rr) = (self.path.most_vertices(), self.path.rr_depth);
        let mut camera = camera_path(world, arena, uniforms, Aim::Film, (longest, rr));
        let mut light = light_path(world, arena, uniforms, (longest.saturating_sub(1), rr));
        let total = (camera.len() + light.len()).min(longest);
        extend(&mut camera, world, (total, rr));
        extend(&mut light, world, (total, rr));
        for length in 2 + usize::from(self.path.hide_emitters)..=total {
            let techniques = arena.collect((1..=length).map(|t| match (length - t, t) {
                (1, t) if t > 1 => {
                    let mut direct = camera.slice(0..t);
                    direct.append(sample_light(world)).sample(uniforms);
                    direct
                }
                (s, t) => camera.slice(0..t).concat(&light.slice(0..s).reverse()),
            }));
            for Contribution { path, value, .. } in
                estimator.each(combine::<PowerHeuristic, _>(techniques))
            {
                found(shares(world, estimator, &path, value).brightness(), &path);
            }
        }
    }
}

/// What a path that carries `value` contributes to the pixels that see it.
fn shares<K: SceneKind>(
    world: &World<'_, K>,
    estimator: &PathEstimator<'_, K>,
    path: &Path<'_, '_, K>,
    value: Vec3,
) -> Contributions {
    let mut found = Contributions::default();
    // No pixel is the path's own.
    for pixel in world.receivers((u32::MAX, u32::MAX), [path]) {
        found.push(pixel, value * estimator.integrand().response(pixel, path));
    }
    found
}

type Path<'r, 'a, K> = RandomSequence<'r, SceneVertex<K>, MutationStrategies<'a, K>>;
type PathEstimator<'a, K> = Estimator<Radiance<'a, 'a, K>, Factors<Vec3>>;

/// All mutations, one of which is selected for each step.
struct All<'a, K: SceneKind> {
    bidirectional: BidirectionalMutation<'a, K>,
    lens: LensPerturbation<'a, K>,
    multi_chain: LensPerturbation<'a, K>,
    caustic: CausticPerturbation<'a, K>,
}

impl<'a, K: SceneKind> Mutation<SceneVertex<K>, MutationStrategies<'a, K>> for All<'a, K> {
    fn propose<'r>(
        &self,
        path: &Path<'r, 'a, K>,
        decide: &mut Decisions<'_, f32>,
    ) -> Option<Draft<'r, SceneVertex<K>, MutationStrategies<'a, K>>> {
        Mutations(&[&self.bidirectional, &self.lens, &self.multi_chain, &self.caustic])
            .propose(path, decide)
    }
}

impl ChainIntegrator for Metropolis {
    fn candidates(&self) -> usize {
        self.candidates
    }

    fn brightness<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
        seed: u64,
    ) -> impl FnMut(usize) -> f32 {
        let mut scratch = Scratch::new(world);
        move |candidate| {
            let mut sum = 0.0;
            let uniforms = &mut Pcg32::new(seed, candidate as u64, 0);
            self.seeds(world, &mut scratch, uniforms, |brightness, _| sum += brightness);
            // The steps of a sample of the image are as many as pixels.
            sum / world.pixels() as f32
        }
    }

    fn chain<'a, K: SceneKind>(&'a self, world: &'a World<'a, K>, start: Start) -> Chain<'a> {
        let mut scratch = Scratch::new(world);
        let uniforms = &mut Pcg32::new(start.seed, start.candidate as u64, 0);
        let mut paths = Vec::new();
        self.seeds(world, &mut scratch, uniforms, |brightness, path| {
            paths.push((brightness, Snapshot::of(path)));
        });
        let mut random = Pcg32::new(start.seed, start.number as u64, u64::MAX - 1);
        let path = drawn(paths, random.next());
        let Scratch { estimator, .. } = scratch;
        let target = move |path: &Path<'_, 'a, K>| self.contribution(world, &estimator, path);
        let all = All {
            bidirectional: BidirectionalMutation { world, longest: self.path.most_vertices() },
            lens: LensPerturbation { world, chains: false },
            multi_chain: LensPerturbation { world, chains: true },
            caustic: CausticPerturbation { world },
        };
        let mut arena = Arena::new();
        let mut state = MarkovChainState::new(&arena.restore(&path), &target);
        Box::new(move |splats: &mut Splats| {
            let uniforms = |step| Pcg32::new(start.seed, start.number as u64, step);
            let step = state.step(&mut arena, &all, &target, uniforms);
            for (contributions, weight) in step.weighted() {
                contributions.splat(weight * start.mean / contributions.brightness(), splats);
            }
        })
    }
}

/// One of several paths, in proportion to their brightness; the empty one if there is none.
fn drawn<V: Default>(paths: Vec<(f32, V)>, u: f32) -> V {
    let mut rest = u * paths.iter().map(|(brightness, _)| brightness).sum::<f32>();
    let mut last = V::default();
    for (brightness, path) in paths {
        if brightness > 0.0 {
            last = path;
            rest -= brightness;
        }
        if rest < 0.0 {
            break;
        }
    }
    last
}
