//! The path tracer with next-event estimation (Aether 2017, Figure 5).

use aether_core::{
    Arena, Estimator, Pcg32, PowerHeuristic, Sobol, Strategy, UniformSource, combine,
};
use glam::Vec3;

use crate::integrand::Radiance;
use crate::kind::{self, Everything, NotCovered, SceneKind};
use crate::render::{AnyKernel, Worker};
use crate::scene::{SamplerKind, Scene};
use crate::strategies::{
    PathStrategies, Pixel, SampleCamera, SampleCameraDirection, sample_bsdf, sample_camera,
    sample_camera_direction, sample_light,
};
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
    arena: &Arena<SceneVertex<K>, S>,
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
    let longest = settings.max_depth.map_or(usize::MAX, |d| d as usize);
    let mut camera = arena.sequence();
    camera.append(sample_camera(world));
    camera.append(sample_camera_direction(world, pixel)).sample(uniforms);
    while camera.is_complete() && camera.size() <= longest {
        camera.append(techniques.scatter.clone()).sample(uniforms);
    }

    let estimator = Estimator::paths(Radiance::new(world, pixel));
    let mut radiance = Vec3::ZERO;
    if !settings.hide_emitters && longest > 0 {
        radiance += estimator.of(&camera.slice(0..2));
    }
    for length in 2..camera.size() {
        // The path that scattering found, and the one that goes to a light instead.
        let scattered = camera.slice(0..length + 1);
        let mut direct = camera.slice(0..length);
        direct.append(techniques.light.clone()).sample(uniforms);
        radiance += estimator.sum(combine::<PowerHeuristic, _>([scattered, direct]));
    }
    radiance
}

/// The path tracer as the render engine calls it: one sample of one pixel at a time.
pub struct PathTracer<'s, K: SceneKind = Everything> {
    world: World<'s, K>,
    settings: PathSettings,
    seed: u64,
}

/// A path tracer for a scene by the name of a precompiled kind; `None` if there is no such kind. The same
/// seed gives the same image, whatever the kind.
///
/// # Errors
/// If the scene needs what the kind leaves out.
pub fn path_tracer<'s>(
    kind: &str,
    scene: &'s Scene,
    settings: PathSettings,
    seed: u64,
) -> Option<Result<Box<dyn AnyKernel + 's>, NotCovered>> {
    struct Make<'s>(&'s Scene, PathSettings, u64);
    impl<'s> kind::WithKind for Make<'s> {
        type Output = Box<dyn AnyKernel + 's>;
        fn with<K: SceneKind>(self) -> Result<Self::Output, NotCovered> {
            Ok(Box::new(PathTracer::<K>::new(self.0, self.1, self.2)?))
        }
    }
    kind::named(kind, Make(scene, settings, seed))
}

impl<'s, K: SceneKind> PathTracer<'s, K> {
    /// A path tracer for a scene; the same seed gives the same image.
    ///
    /// # Errors
    /// If the scene needs what the kind leaves out.
    pub fn new(scene: &'s Scene, settings: PathSettings, seed: u64) -> Result<Self, NotCovered> {
        Ok(PathTracer { world: World::new(scene)?, settings, seed })
    }

    fn sample<'a>(
        &'a self,
        arena: &mut PathArena<'a, K>,
        uniforms: &mut impl UniformSource<f32>,
        pixel: Pixel,
    ) -> [f32; 3] {
        arena.clear();
        let world = &self.world;
        let scatter = sample_bsdf(world, self.settings.rr_depth);
        let techniques = Techniques { scatter, light: sample_light(world) };
        radiance(world, &self.settings, &techniques, arena, uniforms, pixel).to_array()
    }
}

impl<K: SceneKind> AnyKernel for PathTracer<'_, K> {
    fn worker(&self) -> Worker<'_> {
        let mut arena = PathArena::<K>::new();
        let width = u64::from(self.world.scene.film.width);
        let independent = self.world.scene.sampler.kind == SamplerKind::Independent;
        Box::new(move |pixel, sample| {
            let stream = u64::from(pixel.1) * width + u64::from(pixel.0);
            if independent {
                let mut uniforms = Pcg32::new(self.seed, stream, u64::from(sample));
                self.sample(&mut arena, &mut uniforms, pixel)
            } else {
                let mut uniforms = Sobol::new(self.seed, stream, sample);
                self.sample(&mut arena, &mut uniforms, pixel)
            }
        })
    }
}
