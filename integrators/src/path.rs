//! The path tracer with next-event estimation (Aether 2017, Figure 5).

use aether_core::{Arena, PowerHeuristic, Strategy, UniformSource, combine};
use glam::Vec3;

use crate::integrator::{Integrator, Kernel};
use crate::kind::{Everything, SceneKind};
use crate::render::Splats;
use crate::strategies::{
    PathStrategies, Pixel, SampleCamera, SampleCameraDirection, sample_bsdf, sample_camera,
    sample_camera_direction, sample_light,
};
use crate::subpaths::Scratch;
use crate::vertex::SceneVertex;
use crate::world::World;

/// Settings of the path tracer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathSettings {
    /// The longest path in edges, as Mitsuba counts them; `None` for any length.
    pub max_depth: Option<u32>,
    /// The number of vertices from which Russian roulette may end a path.
    pub rr_depth: u32,
    /// Emitters that the camera sees directly are left out.
    pub hide_emitters: bool,
}

impl PathSettings {
    /// The most vertices of a path.
    pub fn most_vertices(&self) -> usize {
        self.max_depth.map_or(usize::MAX, |edges| edges as usize + 1)
    }
}

/// The paths of one sample.
pub type PathArena<'a, K = Everything> = Arena<SceneVertex<K>, PathStrategies<'a, K>>;

/// The strategies that a path is extended with: how to scatter, and how to reach a light.
#[derive(Clone, Copy, Debug)]
pub struct Techniques<B, L> {
    /// Continues a path by scattering.
    pub scatter: B,
    /// Ends a path on a light.
    pub light: L,
}

/// One estimate of the radiance that a pixel receives.
///
/// `S` is the set of strategies that the paths are made of; a user's own set and his own
/// [`Techniques`] work as well as the renderer's.
pub fn radiance<'a, K, S, B, L>(
    world: &'a World<'a, K>,
    settings: &PathSettings,
    techniques: &Techniques<B, L>,
    Scratch { arena, estimator }: &Scratch<'a, K, S>,
    uniforms: &mut impl UniformSource<f32>,
    pixel: Pixel,
) -> Vec3
where
    K: SceneKind,
    S: Strategy<SceneVertex<K>>
        + From<SampleCamera<'a, 'a, K>>
        + From<SampleCameraDirection<'a, 'a, K>>,
    B: Clone + Into<S>,
    L: Clone + Into<S>,
{
    let longest = settings.most_vertices();
    let mut camera = arena.sequence();
    camera.append(sample_camera(world));
    camera.append(sample_camera_direction(world, pixel.into())).sample(uniforms);
    while camera.is_complete() && camera.size() < longest {
        camera.append(techniques.scatter.clone()).sample(uniforms);
    }

    let mut radiance = Vec3::ZERO;
    if !settings.hide_emitters && longest > 1 {
        radiance += estimator.of(&camera.slice(0..2));
    }
    for length in 2..camera.size() {
        // The path that scattering found, and the one that goes to a light instead.
        let scattered = camera.slice(0..length + 1);
        let mut direct = camera.slice(0..length);
        direct.append(techniques.light.clone()).sample(uniforms);
        radiance += estimator.sum(combine::<PowerHeuristic, _>([scattered, direct]));
    }
    radiance * estimator.integrand().response(pixel, &camera)
}

impl Integrator for PathSettings {
    type Scratch<'a, K: SceneKind> = Scratch<'a, K, PathStrategies<'a, K>>;

    fn scratch<'a, K: SceneKind>(&'a self, world: &'a World<'a, K>) -> Self::Scratch<'a, K> {
        Scratch::new(world)
    }

    fn sample<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
        scratch: &mut Self::Scratch<'a, K>,
        uniforms: &mut impl UniformSource<f32>,
        pixel: Pixel,
        _: &mut Splats,
    ) -> Vec3 {
        scratch.arena.clear();
        let scatter = sample_bsdf(world, self.rr_depth, None);
        let techniques = Techniques { scatter, light: sample_light(world) };
        radiance(world, self, &techniques, scratch, uniforms, pixel)
    }
}

/// The path tracer for a kind of scene.
pub type PathTracer<'s, K = Everything> = Kernel<'s, K, PathSettings>;
