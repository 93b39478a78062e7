//! Metropolis light transport in path space (Veach and Guibas 1997; Aether 2017, section 7.3): chains of paths,
//! mutated by the functions of [`crate::mutations`]. The densities of mutations are derived.

use std::fmt;
use std::io::{self, Read, Write};
use std::ops::RangeInclusive;
use std::str::FromStr;

use aether_core::estimator::{Connections, Contribution, Estimator, Factors, Techniques};
use aether_core::mutation::{Decisions, Draft, Mutation, Mutations};
use aether_core::{
    Arena, MarkovChainState, PathDensity, Pcg32, PowerHeuristic, RandomSequence, Snapshot,
    UniformSource, combine,
};
use glam::Vec3;

use crate::chains::{ChainIntegrator, Contributions, Start, Statistics};
use crate::integrand::Radiance;
use crate::kind::SceneKind;
use crate::mutations::{
    BidirectionalMutation, CausticPerturbation, LensPerturbation, MutationStrategies,
};
use crate::path::{DIRECT, PathSettings};
use crate::render::{Chain, MarkovChain, Splats, Technique};
use crate::scene::SamplerKind;
use crate::stored::Stored;
use crate::strategies::{Aim, sample_camera, sample_light};
use crate::subpaths::{
    Scratch, camera_path, camera_step, connection, extend, first_edge, light_path, light_step,
    splits,
};
use crate::uniforms::Uniforms;
use crate::vertex::SceneVertex;
use crate::world::World;

/// Settings of Metropolis light transport.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Metropolis {
    /// Lengths of paths; for the paths that chains start with, Russian roulette. Of its techniques some may make these
    /// paths; the image then has the light of the paths alone that one of them can make.
    pub path: PathSettings,
    /// How many independent samples the brightness of the image is estimated from; `None` for a number that
    /// grows with the image ([`usual_candidates`](crate::chains::usual_candidates)).
    pub candidates: Option<usize>,
    /// Which mutations are used. Without the bidirectional one the image has the light of those paths alone that one
    /// of them fits. No chain leaves these, for from others there is no way back; and as chains start at paths that
    /// are distributed as they should be, the image is right even where they do not reach all of these.
    pub mutations: MutationSet,
    /// Whether direct light and lights that the camera sees are left to path tracing, where there is longer light and
    /// all techniques and mutations are used.
    pub direct: bool,
}

impl Metropolis {
    /// With the usual settings.
    pub fn new(path: PathSettings) -> Self {
        Metropolis { path, candidates: None, mutations: MutationSet::default(), direct: true }
    }

    /// The numbers of vertices that paths of chains have.
    fn lengths(&self) -> RangeInclusive<usize> {
        let shortest = match self.direct() {
            Some(_) => DIRECT + 1,
            None => 2 + usize::from(self.path.hide_emitters),
        };
        shortest..=self.path.most_vertices()
    }

    /// What a path contributes to the image, but for a factor, and how bright that is with it.
    fn contribution<'a, K: SceneKind>(
        &self,
        world: &'a World<'a, K>,
        estimator: &PathEstimator<'a, K>,
        path: &Path<'_, 'a, K>,
    ) -> (PathDensity<f32>, Contributions) {
        if !(self.lengths().contains(&path.len()) && self.covers(world, path)) {
            return (PathDensity::ZERO, Contributions::default());
        }
        let (value, scale) = estimator.scaled_integrand_at(path);
        let found = shares(estimator, path, value);
        (scale * found.brightness(), found)
    }

    /// The two walks of a bidirectional sample of the whole image, and how many vertices a path of theirs has at most.
    fn walks<'r, 'a, K: SceneKind>(
        &self,
        world: &'a World<'a, K>,
        arena: &'r Arena<SceneVertex<K>, MutationStrategies<'a, K>>,
        uniforms: &mut impl UniformSource<f32>,
    ) -> ([Path<'r, 'a, K>; 2], usize) {
        let (longest, rr) = (self.path.most_vertices(), self.path.rr_depth);
        let mut camera = camera_path(world, arena, uniforms, Aim::Film, (longest, rr));
        let mut light = light_path(world, arena, uniforms, (longest.saturating_sub(1), rr));
        let total = (camera.len() + light.len()).min(longest);
        extend(&mut camera, world, (total, rr));
        extend(&mut light, world, (total, rr));
        ([camera, light], total)
    }

    /// Bidirectional samples of the whole image: paths that fit, each with its share of the brightness.
    fn seeds<'a, K: SceneKind>(
        &self,
        world: &'a World<'a, K>,
        Scratch { arena, estimator }: &mut Scratch<'a, K, MutationStrategies<'a, K>>,
        uniforms: &mut impl UniformSource<f32>,
        mut found: impl FnMut(f32, &Path<'_, 'a, K>),
    ) {
        arena.clear();
        let ([camera, light], total) = self.walks(world, arena, uniforms);
        for length in *self.lengths().start()..=total {
            let used = self.path.techniques.among(splits(length));
            let techniques = arena.collect(used.map(|by| match (by.light, by.camera) {
                (1, t) if t > 1 => *connection(world, &camera, &light, (1, t)).sample(uniforms),
                (s, t) => connection(world, &camera, &light, (s, t)),
            }));
            for Contribution { path, value, .. } in
                estimator.each(combine::<PowerHeuristic, _>(techniques))
            {
                if self.fits(world, &path) {
                    found(shares(estimator, &path, value).brightness(), &path);
                }
            }
        }
    }

    /// The sum of the brightness of all [`Metropolis::seeds`] of a sample. Where all paths fit, none of them is made.
    fn brightness_of_seeds<'a, K: SceneKind>(
        &self,
        world: &'a World<'a, K>,
        scratch: &mut Scratch<'a, K, MutationStrategies<'a, K>>,
        techniques: &mut Techniques<f32, PowerHeuristic>,
        uniforms: &mut impl UniformSource<f32>,
    ) -> f32 {
        let mut sum = 0.0;
        if !self.mutations.fit_all() {
            self.seeds(world, scratch, uniforms, |brightness, _| sum += brightness);
            return sum;
        }
        let Scratch { arena, estimator } = scratch;
        arena.clear();
        let ([camera, light], total) = self.walks(world, arena, uniforms);
        let by_camera = first_edge(&camera.slice(0..camera.len().min(2)));
        let eye = camera.vertex(0);
        let look = sample_light(world).into();
        techniques.reach(total, |length, first| {
            let technique = || Technique::edge(first, length - first);
            usize::from(first > 0 && self.path.techniques.has(technique()))
        });
        let connections = Connections {
            lengths: *self.lengths().start()..=total,
            ending: Some(&look),
            fewest_ending: 3,
            techniques,
            is_drawn: |_, _| true,
        };
        let walks = [&camera, &light];
        estimator.connections(walks, &connections, uniforms, |found| {
            let seen = match found.first {
                1 => eye.zip(light.vertex(found.length - 2)).map(|(eye, seen)| [eye, seen]),
                _ => by_camera,
            };
            sum += shares_of(estimator, found.length, seen, found.value).brightness();
        });
        sum
    }

    /// Whether one of the techniques that are used can make a path.
    fn covers<'a, K: SceneKind>(&self, world: &'a World<'a, K>, path: &Path<'_, 'a, K>) -> bool {
        let n = path.len();
        let can_make = |by: Technique| {
            let (mut camera, mut light) = (path.slice(0..0), path.slice(0..0));
            for i in 0..by.camera {
                let step = camera_step::<K, MutationStrategies<'a, K>>;
                camera.append(step(world, i, Aim::Film, u32::MAX));
            }
            for i in 0..by.light {
                light.append(light_step::<K, MutationStrategies<'a, K>>(world, i, u32::MAX));
            }
            let technique = connection(world, &camera, &light, (by.light, by.camera));
            !technique.pdf_of(path).is_zero()
        };
        // Together they make all paths.
        let techniques = self.path.techniques;
        techniques.is_all() || techniques.among(splits(n)).any(can_make)
    }

    /// Whether one of the mutations that are used fits a path.
    fn fits<'a, K: SceneKind>(&self, world: &'a World<'a, K>, path: &Path<'_, 'a, K>) -> bool {
        let fits = |mutation: &&Proposes<'_, 'a, K>| mutation.weight(path) > 0.0;
        self.with_mutations(world, |all| all.iter().any(fits))
    }

    /// What `act` makes of the mutations in their order. Those that are not used have no weight.
    fn with_mutations<'a, K: SceneKind, T>(
        &self,
        world: &'a World<'a, K>,
        act: impl FnOnce(&[&Proposes<'_, 'a, K>]) -> T,
    ) -> T {
        let (MutationSet([bidirectional, lens, chains, caustic]), lengths) =
            (self.mutations, self.lengths());
        act(&[
            &Used(bidirectional, BidirectionalMutation { world, lengths }),
            &Used(lens, LensPerturbation { world, chains: false }),
            &Used(chains, LensPerturbation { world, chains: true }),
            &Used(caustic, CausticPerturbation { world }),
        ])
    }
}

/// What a path that carries `value` contributes to the pixels that see it.
fn shares<K: SceneKind>(
    estimator: &PathEstimator<'_, K>,
    path: &Path<'_, '_, K>,
    value: Vec3,
) -> Contributions {
    shares_of(estimator, path.len(), first_edge(path), value)
}

/// The same of a path with so many vertices that begins with an eye and what that sees.
fn shares_of<K: SceneKind>(
    estimator: &PathEstimator<'_, K>,
    vertices: usize,
    seen: Option<[SceneVertex<K>; 2]>,
    value: Vec3,
) -> Contributions {
    let mut found = Contributions::default();
    let Some([eye, first]) = &seen else { return found };
    let radiance = estimator.integrand();
    let (film, sight) = (radiance.world().scene.film, radiance.sight(eye, first));
    for (pixel, response) in sight.into_iter().flat_map(|sight| film.receivers(sight.film)) {
        let share = value * response;
        found.push(Technique::mutations(vertices), pixel, share, share);
    }
    found
}

type Path<'r, 'a, K> = RandomSequence<'r, SceneVertex<K>, MutationStrategies<'a, K>>;
type Proposes<'m, 'a, K> = dyn Mutation<SceneVertex<K>, MutationStrategies<'a, K>> + 'm;
type PathEstimator<'a, K> = Estimator<Radiance<'a, 'a, K>, Factors<Vec3>>;

/// The mutations by their names, in the order in which they are numbered.
pub const MUTATIONS: [&str; 4] = ["bidirectional", "lens", "multi-chain", "caustic"];

/// Which mutations are used. As text, a list of their names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MutationSet([bool; MUTATIONS.len()]);

impl MutationSet {
    /// Whether one of them fits all paths.
    fn fit_all(self) -> bool {
        self.0[0]
    }
}

impl Default for MutationSet {
    /// All of them.
    fn default() -> Self {
        MutationSet([true; MUTATIONS.len()])
    }
}

impl fmt::Display for MutationSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let used = MUTATIONS.iter().zip(self.0).filter(|(_, used)| *used);
        f.write_str(&used.map(|(name, _)| *name).collect::<Vec<_>>().join(","))
    }
}

impl FromStr for MutationSet {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut set = MutationSet([false; MUTATIONS.len()]);
        for name in text.split(',').map(str::trim) {
            let number = MUTATIONS.iter().position(|mutation| *mutation == name);
            let number = number.ok_or_else(|| {
                format!("`{name}` is no mutation: there are {}", MUTATIONS.join(", "))
            })?;
            set.0[number] = true;
        }
        Ok(set)
    }
}

/// A mutation that may be switched off.
struct Used<M>(bool, M);

impl<'a, K: SceneKind, M> Mutation<SceneVertex<K>, MutationStrategies<'a, K>> for Used<M>
where
    M: Mutation<SceneVertex<K>, MutationStrategies<'a, K>>,
{
    fn propose<'r>(
        &self,
        path: &Path<'r, 'a, K>,
        decide: &mut Decisions<'_, f32>,
    ) -> Option<Draft<'r, SceneVertex<K>, MutationStrategies<'a, K>>> {
        self.1.propose(path, decide)
    }

    fn weight(&self, path: &Path<'_, 'a, K>) -> f32 {
        if self.0 { self.1.weight(path) } else { 0.0 }
    }
}

impl ChainIntegrator for Metropolis {
    const STEPS: &'static [&'static str] = &MUTATIONS;

    fn direct(&self) -> Option<PathSettings> {
        let all = self.path.techniques.is_all() && self.mutations == MutationSet::default();
        let separate = self.direct && all && self.path.most_vertices() > DIRECT;
        separate.then(|| self.path.direct())
    }

    fn candidates(&self) -> Option<usize> {
        self.candidates
    }

    fn brightness<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
        seed: u64,
    ) -> impl FnMut(usize) -> f32 {
        let (mut scratch, mut techniques) = (Scratch::new(world), Techniques::new(PowerHeuristic));
        move |candidate| {
            let uniforms = &mut uniforms_of(seed, candidate);
            let sum = self.brightness_of_seeds(world, &mut scratch, &mut techniques, uniforms);
            // The steps of a sample of the image are as many as pixels.
            sum / world.pixels() as f32
        }
    }

    fn chain<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
        start: Start,
        statistics: &'a Statistics,
    ) -> Chain<'a> {
        let mut scratch = Scratch::new(world);
        let uniforms = &mut uniforms_of(start.seed, start.candidate);
        let mut paths = Vec::new();
        self.seeds(world, &mut scratch, uniforms, |brightness, path| {
            paths.push((brightness, Snapshot::of(path)));
        });
        let mut random = Pcg32::new(start.seed, start.number as u64, u64::MAX - 1);
        let path = drawn(paths, random.next());
        let Scratch { estimator, .. } = scratch;
        let mut arena = Arena::new();
        let target = |path: &Path<'_, 'a, K>| self.contribution(world, &estimator, path);
        let state = MarkovChainState::new(&arena.restore(&path), &target);
        arena.clear();
        Box::new(PathChain { metropolis: self, world, estimator, arena, state, start, statistics })
    }
}

/// A chain of paths.
struct PathChain<'a, K: SceneKind> {
    metropolis: &'a Metropolis,
    world: &'a World<'a, K>,
    estimator: PathEstimator<'a, K>,
    arena: Arena<SceneVertex<K>, MutationStrategies<'a, K>>,
    state: MarkovChainState<SceneVertex<K>, MutationStrategies<'a, K>, Contributions>,
    start: Start,
    statistics: &'a Statistics,
}

impl<'a, K: SceneKind> MarkovChain for PathChain<'a, K> {
    fn step(&mut self, splats: &mut Splats) {
        let PathChain { metropolis, world, estimator, start, .. } = self;
        let world = *world;
        let target = |path: &Path<'_, 'a, K>| metropolis.contribution(world, estimator, path);
        let uniforms = |step| Uniforms::independent(start.seed, start.number as u64, step);
        let (state, arena) = (&mut self.state, &mut self.arena);
        let step = metropolis.with_mutations(world, |all| {
            state.step_among(arena, &Mutations(all), &target, uniforms)
        });
        if let Some(mutation) = step.selected {
            self.statistics.count(start.number, mutation, step.proposal.is_some(), step.accepted);
        }
        for (contributions, weight) in step.weighted() {
            contributions.splat(weight * start.mean / contributions.brightness(), splats);
        }
    }

    fn save(&self, to: &mut dyn Write) -> io::Result<()> {
        let steps = self.state.path().steps();
        steps.map(|(vertex, _, code)| (*vertex, code)).collect::<Vec<_>>().store(to)?;
        (self.state.target().parts(), self.state.steps()).store(to)?;
        self.state.contribution().store(to)
    }

    fn restore(&mut self, from: &mut dyn Read) -> io::Result<()> {
        let steps: Vec<_> = Stored::load(from)?;
        let ((mantissa, exponent), count) = Stored::load(from)?;
        let made_by = |(vertex, code)| (vertex, sample_camera(self.world).into(), code);
        let path = Snapshot::from_steps(steps.into_iter().map(made_by));
        let target = PathDensity::from_parts(mantissa, exponent);
        self.state = MarkovChainState::resumed(path, target, Stored::load(from)?, count);
        Ok(())
    }
}

/// What a candidate is sampled by. Candidates are one set of points, which tells their mean more exactly than
/// independent ones would.
fn uniforms_of(seed: u64, candidate: usize) -> Uniforms {
    Uniforms::new(SamplerKind::LowDiscrepancy, seed, u64::MAX, candidate as u32)
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

#[cfg(test)]
mod tests;
