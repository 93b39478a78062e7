//! The path tracer with next-event estimation (Aether 2017, Figure 5).

use aether_core::estimator::{Endings, Steps};
use aether_core::{Arena, PowerHeuristic, Strategy, UniformSource};
use glam::Vec3;

use crate::integrator::{Integrator, Kernel, Received};
use crate::kind::{Everything, SceneKind};
use crate::render::{Splats, Technique};
use crate::scene::Scene;
use crate::selection::Selection;
use crate::strategies::{
    PathStrategies, Pixel, SampleCamera, SampleCameraDirection, sample_bsdf, sample_camera,
    sample_camera_direction, sample_light,
};
use crate::subpaths::Scratch;
use crate::vertex::SceneVertex;
use crate::world::World;

/// Settings of the path tracer, which other integrators have too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathSettings {
    /// The longest path in edges, as Mitsuba counts them; `None` for any length.
    pub max_depth: Option<u32>,
    /// The number of vertices from which Russian roulette may end a path.
    pub rr_depth: u32,
    /// Light that the camera sees at its source is left out. Whether the camera sees what is behind shapes that emit is up
    /// to the scene ([`Scene::sight_of_eyes`]), which both should be told of: [`PathSettings::new`] takes this from there.
    pub hide_emitters: bool,
    /// Which of an integrator's techniques are used.
    pub techniques: Selection,
}

/// The most vertices of paths of direct light: the eye, a surface, a light.
pub const DIRECT: usize = 3;

impl PathSettings {
    /// What a scene asks for, with all techniques.
    pub fn new(scene: &Scene) -> Self {
        let wanted = &scene.integrator;
        PathSettings {
            max_depth: wanted.max_depth,
            rr_depth: wanted.rr_depth,
            hide_emitters: wanted.hide_emitters,
            techniques: Selection::ALL,
        }
    }

    /// The same for direct light and for lights that the camera sees: for paths of [`DIRECT`] vertices at most.
    pub fn direct(&self) -> Self {
        let max_depth = self.max_depth.map_or(DIRECT as u32 - 1, |d| d.min(DIRECT as u32 - 1));
        PathSettings { max_depth: Some(max_depth), ..*self }
    }

    /// The paths that scattering has found, and those that go to a light in one of some ways instead.
    pub fn endings<'t, S>(
        &self,
        ways: &'t [&'t [S]],
    ) -> Endings<'t, S, impl Fn(usize, &[S]) -> bool + use<S>> {
        let techniques = self.techniques;
        Endings {
            lengths: 2 + usize::from(self.hide_emitters)..=self.most_vertices(),
            ways,
            is_used: move |length: usize, steps: &[S]| {
                let technique = ended(length, steps);
                technique.camera >= 2 && techniques.has(technique)
            },
        }
    }

    /// The most vertices of a path.
    pub fn most_vertices(&self) -> usize {
        self.max_depth.map_or(usize::MAX, |edges| edges as usize + 1)
    }

    /// How many vertices of a light path memory is needed for, if Russian roulette mostly ends it before it has `ended` ones:
    /// all that it may have without the eye, or those that Russian roulette leaves.
    pub fn light_vertices(&self, ended: usize) -> usize {
        (self.most_vertices() - 1).min(ended.max(self.rr_depth as usize))
    }
}

/// The technique of paths from the camera whose last vertices are made by some steps.
pub fn ended<S>(length: usize, steps: &[S]) -> Technique {
    Technique::edge(length.saturating_sub(steps.len()), steps.len())
}

/// The paths of one sample.
pub type PathArena<'a, K = Everything> = Arena<SceneVertex<K>, PathStrategies<'a, K>>;

/// The strategies that a path is extended with: how to scatter, and how to reach a light.
#[derive(Clone, Copy, Debug)]
pub struct Techniques<'t, S> {
    /// Continues a path by scattering.
    pub scatter: S,
    /// Ways to end a path on a light, in place of scattering as often as they have steps: none for the light that
    /// scattering itself finds, one for next-event estimation, several to reach a light by way of something.
    pub endings: &'t [&'t [S]],
}

/// One sample of the radiance that a pixel receives.
///
/// `S` is the set of strategies that the paths are made of; a user's own set and his own
/// [`Techniques`] work as well as the renderer's.
pub fn trace<'a, K, S>(
    world: &'a World<'a, K>,
    settings: &PathSettings,
    Techniques { scatter, endings }: &Techniques<'_, S>,
    Scratch { arena, estimator }: &mut Scratch<'a, K, S>,
    uniforms: &mut impl UniformSource<f32>,
    received: &mut Received<'_>,
) where
    K: SceneKind,
    S: Strategy<SceneVertex<K>>
        + From<SampleCamera<'a, 'a, K>>
        + From<SampleCameraDirection<'a, 'a, K>>,
{
    arena.clear();
    let aim = received.aim();
    let camera = [sample_camera(world).into(), sample_camera_direction(world, aim).into()];
    let steps = Steps { first: &camera, then: scatter };
    let endings = settings.endings(endings);
    estimator.integrand_mut().aim(Some(aim));
    let radiance = estimator.integrand();
    let mut counts = None;
    estimator.walk(arena, &steps, &endings, &PowerHeuristic, uniforms, |path| {
        // Where the sample lies on the film is known once it has found something.
        let counts = *counts.get_or_insert_with(|| {
            radiance.drawn_film_point().map_or(1.0, |film| received.begin_at(world, film))
        });
        let [value, alone] = [path.value, path.alone].map(|value| value * counts);
        received.add_own(ended(path.length, path.steps), value, alone);
    });
    estimator.integrand_mut().aim(None);
}

impl Integrator for PathSettings {
    type Scratch<'a, K: SceneKind> = Scratch<'a, K, PathStrategies<'a, K>>;
    const SHARES: bool = true;

    fn scratch<'a, K: SceneKind>(&'a self, world: &'a World<'a, K>) -> Self::Scratch<'a, K> {
        Scratch::new(world)
    }

    fn sample<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
        scratch: &mut Self::Scratch<'a, K>,
        uniforms: &mut impl UniformSource<f32>,
        pixel: Pixel,
        splats: &mut Splats,
    ) -> Vec3 {
        let scatter = sample_bsdf(world, self.rr_depth, None).into();
        let light = [sample_light(world).into()];
        let techniques = Techniques { scatter, endings: &[&[], &light] };
        let mut received = Received::new(pixel, splats);
        trace(world, self, &techniques, scratch, uniforms, &mut received);
        received.own
    }
}

/// The path tracer for a kind of scene.
pub type PathTracer<'s, K = Everything> = Kernel<'s, K, PathSettings>;
