//! Instant radiosity (Keller 1997; Aether 2017, section 7.6): light paths that all pixels share, whose
//! vertices are virtual point lights.

use std::sync::{PoisonError, RwLock};

use aether_core::Snapshot;
use glam::Vec3;

use crate::emission::LightStrategies;
use crate::integrand::Radiance;
use crate::integrator::Received;
use crate::kind::{Everything, NotCovered, SceneKind};
use crate::path::PathSettings;
use crate::render::{AnyKernel, Cancelled, Splats, Technique, Worker};
use crate::scene::{Filter, Sampler, Scene};
use crate::strategies::{Pixel, sample_bsdf};
use crate::subpaths::{
    LightPath, Path, Scratch, camera_path, is_atom, light_step, shared_light_paths,
};
use crate::uniforms::Uniforms;
use crate::vertex::SceneVertex;
use crate::work::in_parts;
use crate::world::World;

/// Settings of instant radiosity. It does not find caustics: light that mirrors or glass throw on what the camera sees,
/// since virtual lights on these shine in one direction only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InstantRadiosity {
    /// Lengths of paths, Russian roulette.
    pub path: PathSettings,
    /// How many light paths there are. Each sample of the image has others.
    pub light_paths: u32,
    /// What the geometry term of a connection is at most; none for the unbiased, spiky image.
    pub clamp: Option<f32>,
}

impl InstantRadiosity {
    /// About as many bytes as the light paths of a sample may take. Where nothing else limits their lengths, they are
    /// counted as paths of 32 vertices.
    pub fn bytes(&self) -> u64 {
        let vertices = self.path.light_vertices(COUNTED);
        let path = size_of::<LightPath<Everything>>() + HEAP;
        let path = path + vertices * LightPath::<Everything>::BYTES_OF_A_STEP;
        u64::from(self.light_paths) * path as u64
    }
}

/// How many light paths a camera path is connected to before the arena, which keeps all that is made in it, is cleared.
const AT_ONCE: usize = 256;

/// More vertices than paths mostly have that Russian roulette ends.
const COUNTED: usize = 32;

/// What an allocation takes beside its contents, in bytes.
pub(crate) const HEAP: usize = 16;

/// What one thread reuses: memory for paths, and the camera path that is connected to one part of the light paths after the
/// other.
struct Connector<'a, K: SceneKind> {
    scratch: Scratch<'a, K, LightStrategies<'a, K>>,
    begun: Snapshot<SceneVertex<K>, LightStrategies<'a, K>>,
}

/// Instant radiosity in a scene, as the render engine calls it.
pub struct RadiosityKernel<'s, K: SceneKind> {
    world: World<'s, K>,
    settings: InstantRadiosity,
    sampler: Sampler,
    /// The light paths of a sample, which all threads share.
    paths: RwLock<Vec<LightPath<K>>>,
}

impl<'s, K: SceneKind> RadiosityKernel<'s, K> {
    /// Instant radiosity in a scene, with the kind and the seed of `sampler`; the same seed gives the same image.
    ///
    /// # Errors
    /// If the scene needs what the kind leaves out.
    pub fn new(
        scene: &'s Scene,
        settings: InstantRadiosity,
        sampler: Sampler,
    ) -> Result<Self, NotCovered> {
        let world = World::new(scene)?;
        Ok(RadiosityKernel { world, settings, sampler, paths: RwLock::default() })
    }

    /// One sample of a pixel; given up if the render is cancelled meanwhile.
    fn sample<'a>(
        &'a self,
        paths: &[LightPath<K>],
        Connector { scratch, begun }: &mut Connector<'a, K>,
        uniforms: &mut Uniforms,
        (pixel, splats): (Pixel, &mut Splats),
        cancelled: Cancelled<'_>,
    ) -> Vec3 {
        let Scratch { arena, estimator } = scratch;
        arena.clear();
        let (world, settings) = (&self.world, self.settings.path);
        let (longest, rr) = (settings.most_vertices(), settings.rr_depth);
        let mut received = Received::new(pixel, splats);
        let aim = received.aim();
        let mut camera = camera_path(world, arena, uniforms, aim, (longest.min(2), 0));
        let response = received.begin_with(estimator.integrand(), &camera);
        let mut add = |by: Technique, path: &Path<'_, K, _>, share: f32| {
            if settings.techniques.has(by) {
                let value = estimator.of(path) * share;
                received.add_own(by, value, value);
            }
        };
        if longest >= 2 && !settings.hide_emitters {
            add(Technique::edge(camera.len(), 0), &camera, response);
        }
        // What is seen in mirrors is followed; everything else is lit by the virtual lights.
        while camera.is_complete() && camera.len() < longest {
            begun.store(&camera);
            for lights in paths.chunks(AT_ONCE) {
                if cancelled() {
                    received.give_up();
                    return Vec3::ZERO;
                }
                arena.clear();
                let camera = arena.restore(begun);
                for light in lights {
                    let light = arena.restore_with(light, |i, ()| light_step(world, i, rr));
                    for s in 1..=light.len().min(longest - camera.len()) {
                        let path = camera.concat(&light.slice(0..s).reverse());
                        let share = response / self.settings.light_paths as f32;
                        add(Technique::edge(camera.len(), s), &path, share);
                    }
                }
            }
            arena.clear();
            camera = arena.restore(begun);
            camera.append(sample_bsdf(world, rr, None)).sample(uniforms);
            let mirrored = |i| is_atom(&camera, i);
            if !camera.is_complete() || !mirrored(camera.len() - 2) {
                break;
            }
            add(Technique::edge(camera.len(), 0), &camera, response);
        }
        received.own
    }
}

impl<K: SceneKind> AnyKernel for RadiosityKernel<'_, K> {
    fn worker(&self) -> Worker<'_> {
        self.worker_until(&|| false)
    }

    fn worker_until<'a>(&'a self, cancelled: Cancelled<'a>) -> Worker<'a> {
        let limit = self.settings.clamp.unwrap_or(f32::INFINITY);
        let scratch = Scratch::with(Radiance::clamped(&self.world, limit));
        let mut connector = Connector { scratch, begun: Snapshot::new() };
        let paths = self.paths.read().unwrap_or_else(PoisonError::into_inner);
        let film = &self.world.scene.film;
        Box::new(move |pixel, sample, splats| {
            let Sampler { kind, seed, .. } = self.sampler;
            let mut uniforms = Uniforms::of_pixel(kind, seed, pixel, film, sample);
            let to = (pixel, splats);
            self.sample(&paths, &mut connector, &mut uniforms, to, cancelled).to_array()
        })
    }

    fn brightness_exponent(&self) -> i32 {
        self.world.scene.brightness_exponent()
    }

    fn filter(&self) -> Option<Filter> {
        Some(self.world.scene.film.filter)
    }

    fn largest_pass(&self) -> u32 {
        1
    }

    fn begin_pass(&self, first: u32, threads: usize, cancelled: Cancelled<'_>) -> bool {
        let mut known = self.paths.write().unwrap_or_else(PoisonError::into_inner);
        // There is never memory for those of two samples.
        *known = Vec::new();
        let count = self.settings.light_paths as usize;
        let path = self.settings.path;
        let (number, lengths) =
            ((self.sampler.seed, first), (path.most_vertices() - 1, path.rr_depth));
        *known = in_parts(count, threads, |part| {
            shared_light_paths(&self.world, number, lengths, part, cancelled)
        });
        known.len() == count
    }
}
