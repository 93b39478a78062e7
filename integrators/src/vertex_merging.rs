//! Vertex connection and merging (Georgiev et al. 2012; Hachisuka et al. 2012): bidirectional path tracing whose
//! pieces of paths may also meet, as in photon mapping. A piece from the camera and one from a light whose ends
//! lie within a radius of each other are one path; it is made as often as the densities of both pieces and the
//! area within the radius say. That is one more technique for each inner vertex, which the light paths of all
//! pixels serve. It is biased, and consistent: the radius shrinks from sample to sample.

use std::f32::consts::PI;
use std::sync::{PoisonError, RwLock};

use aether_core::{Arena, PowerHeuristic, combine};
use glam::Vec3;

use crate::emission::LightStrategies;
use crate::instant_radiosity::HEAP;
use crate::integrator::Received;
use crate::kind::{Everything, NotCovered, SceneKind};
use crate::path::PathSettings;
use crate::photon_mapping::{COUNTED, SORTED};
use crate::photons::{PhotonMap, Placed, seen_size, shrunk};
use crate::render::{AnyKernel, Cancelled, Splats, Technique, Worker};
use crate::scene::{Filter, SamplerKind, Scene};
use crate::strategies::{Aim, Pixel};
use crate::subpaths::{
    LightPath, Path, Scratch, camera_path, connection, extend, light_step, shared_light_paths,
    splits,
};
use crate::uniforms::Uniforms;
use crate::vertex::SceneVertex;
use crate::work::in_parts;
use crate::world::World;

/// Settings of vertex connection and merging.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VertexMerging {
    /// Lengths of paths, Russian roulette, techniques.
    pub path: PathSettings,
    /// The first radius over that of what is seen of the scene ([`seen_size`]).
    pub radius: f32,
    /// How fast the radius shrinks: 1 not at all, 0 so that the noise stays.
    pub alpha: f32,
}

impl VertexMerging {
    /// With the usual settings.
    pub fn new(path: PathSettings) -> Self {
        VertexMerging { path, radius: 0.005, alpha: 0.75 }
    }

    /// About as many bytes as so many light paths and their ends may take, counted as those of photon mapping are: paths
    /// with their thread's and among all, and ends in a list, sorted, and in the map of the pass before.
    pub fn bytes(&self, light_paths: u64) -> u64 {
        let path = 2 * size_of::<LightPath<Everything>>() + HEAP;
        let vertex = LightPath::<Everything>::BYTES_OF_A_STEP + 3 * size_of::<End>() + SORTED;
        light_paths * (path + self.path.light_vertices(COUNTED) * vertex) as u64
    }
}

/// A vertex of a light path that camera paths may meet.
#[derive(Clone, Copy, Debug)]
struct End {
    position: Vec3,
    /// The unit normal, on the side that the light has come to.
    normal: Vec3,
    /// The number of the light path, and how many of its vertices lead here.
    path: u32,
    vertices: u32,
}

impl Placed for End {
    fn position(&self) -> Vec3 {
        self.position
    }
}

/// The light paths of a sample of the image, one for each pixel, and where they end.
struct LightPaths<K: SceneKind> {
    paths: Vec<LightPath<K>>,
    ends: PhotonMap<End>,
}

/// Vertex connection and merging in a scene, as the render engine calls it.
pub struct MergingKernel<'s, K: SceneKind> {
    world: World<'s, K>,
    /// What the radius is relative to.
    size: f32,
    settings: VertexMerging,
    seed: u64,
    lights: RwLock<LightPaths<K>>,
}

impl<'s, K: SceneKind> MergingKernel<'s, K> {
    /// An integrator for a scene; the same seed gives the same image.
    ///
    /// # Errors
    /// If the scene needs what the kind leaves out.
    pub fn new(scene: &'s Scene, settings: VertexMerging, seed: u64) -> Result<Self, NotCovered> {
        let lights = RwLock::new(LightPaths { paths: Vec::new(), ends: PhotonMap::default() });
        let world = World::new(scene)?;
        let size = seen_size(&world);
        Ok(MergingKernel { world, size, settings, seed, lights })
    }

    /// A light path, with the strategies that would go on to `size` vertices.
    fn light<'r, 'a>(
        &'a self,
        arena: &'r Arena<SceneVertex<K>, LightStrategies<'a, K>>,
        path: &LightPath<K>,
        size: usize,
    ) -> Path<'r, K, LightStrategies<'a, K>> {
        let (world, rr) = (&self.world, self.settings.path.rr_depth);
        let mut light = arena.restore_with(path, |i, ()| light_step(world, i, rr));
        for i in light.size()..size {
            light.append(light_step::<K, LightStrategies<'a, K>>(world, i, rr));
        }
        light
    }

    /// The techniques in use for paths of `n` vertices: connections by the number of vertices from the camera,
    /// from one to all, then merges by the number of the merged vertex, from the second to the last but one.
    fn techniques(&self, n: usize) -> impl Iterator<Item = Technique> + Clone {
        let merges = (2..n).map(move |t| Technique::merge(t, n + 1 - t));
        self.settings.path.techniques.among(splits(n).chain(merges))
    }

    /// The path that a technique makes of a camera path and a light path, and the number of its samples.
    fn made<'r, 'a>(
        &'a self,
        by: Technique,
        [camera, light]: [&Path<'r, K, LightStrategies<'a, K>>; 2],
        radius: f32,
    ) -> (Path<'r, K, LightStrategies<'a, K>>, usize) {
        let (world, pixels) = (&self.world, self.world.pixels());
        match (by.joint, by.light, by.camera) {
            (Technique::MERGE, s, t) => {
                let lit = light.slice(0..s).reverse();
                (camera.slice(0..t).merge(&lit, PI * radius * radius), pixels)
            }
            (_, s, 1) => (connection(world, camera, light, (s, 1)), pixels),
            (_, s, t) => (connection(world, camera, light, (s, t)), 1),
        }
    }

    /// One sample of a pixel.
    fn sample<'a>(
        &'a self,
        lights: &LightPaths<K>,
        Scratch { arena, estimator }: &mut Scratch<'a, K, LightStrategies<'a, K>>,
        uniforms: &mut Uniforms,
        pixel: Pixel,
        splats: &mut Splats,
    ) -> Vec3 {
        arena.clear();
        let (world, rr, radius) = (&self.world, self.settings.path.rr_depth, lights.ends.radius());
        let longest = self.settings.path.most_vertices();
        let mut camera = camera_path(world, arena, uniforms, Aim::Image(pixel), (longest, rr));
        let reached = camera.len();
        let own = &lights.paths[(pixel.1 * world.scene.film.width + pixel.0) as usize];
        let total = (reached + own.len()).min(longest);
        extend(&mut camera, world, (total, rr));
        let light = self.light(arena, own, total);

        let mut received = Received::new(pixel, splats);
        let radiance = estimator.integrand();
        let counts = received.begin_for_all(radiance, &camera);
        let eye = camera.slice(0..1);
        for n in 2 + usize::from(self.settings.path.hide_emitters)..=total {
            let seen = eye.concat(&light.slice(0..n - 1).reverse());
            let list = self.techniques(n).map(|by| {
                let (mut path, count) = self.made(by, [&camera, &light], radius);
                match (by.joint, by.light, by.camera) {
                    (Technique::MERGE, ..) => (path.technique(), count),
                    (_, _, 1) => (seen, count),
                    (_, 1, _) => (*path.sample(uniforms), count),
                    _ => (path, count),
                }
            });
            let techniques = arena.collect_counted(list);
            for found in estimator.each(combine::<PowerHeuristic, _>(techniques)) {
                let Some(by) = self.techniques(n).nth(found.technique) else { continue };
                received.add_found(radiance, (by, by.camera == 1), &found, counts);
            }
        }

        for t in 2..=reached.min(longest - 1) {
            let Some(here) = camera.vertex(t - 1) else { break };
            let Some(surface) = here.surface() else { break };
            lights.ends.near(here.position, |end| {
                let merged = Technique::merge(t, end.vertices as usize);
                let n = merged.vertices;
                let faces = surface.normal.dot(end.normal).abs() > 0.5;
                if n > longest || !faces || !self.settings.path.techniques.has(merged) {
                    return;
                }
                let light = self.light(arena, &lights.paths[end.path as usize], n);
                let mut camera = camera.slice(0..camera.size().min(n));
                extend(&mut camera, world, (n, rr));
                let list = self.techniques(n).map(|by| {
                    let (path, count) = self.made(by, [&camera, &light], radius);
                    (if by == merged { path } else { path.technique() }, count)
                });
                let techniques = arena.collect_counted(list);
                for found in estimator.each(combine::<PowerHeuristic, _>(techniques)) {
                    received.add_own(merged, found.value * counts, found.alone * counts);
                }
            });
        }
        received.own
    }
}

impl<K: SceneKind> AnyKernel for MergingKernel<'_, K> {
    fn worker(&self) -> Worker<'_> {
        let lights = self.lights.read().unwrap_or_else(PoisonError::into_inner);
        let mut scratch = Scratch::new(&self.world);
        let film = &self.world.scene.film;
        Box::new(move |pixel, sample, splats| {
            let (kind, seed) = (SamplerKind::Independent, self.seed);
            let mut uniforms = Uniforms::of_pixel(kind, seed, pixel, film, sample);
            self.sample(&lights, &mut scratch, &mut uniforms, pixel, splats).to_array()
        })
    }

    fn splats(&self) -> bool {
        true
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
        let path = self.settings.path;
        let (number, lengths) = ((self.seed, first), (path.most_vertices() - 1, path.rr_depth));
        let paths = in_parts(self.world.pixels(), threads, |part| {
            shared_light_paths(&self.world, number, lengths, part, cancelled)
        });
        if paths.len() < self.world.pixels() {
            return false;
        }
        let radius = self.settings.radius * self.size * shrunk(self.settings.alpha, first);
        let ends = PhotonMap::new(ends(&paths), radius);
        *self.lights.write().unwrap_or_else(PoisonError::into_inner) = LightPaths { paths, ends };
        true
    }
}

/// Where light paths end that camera paths may meet.
fn ends<K: SceneKind>(paths: &[LightPath<K>]) -> Vec<End> {
    let mut ends = Vec::new();
    for (path, number) in paths.iter().zip(0..) {
        for vertices in 2..=path.len() {
            let [before, here] = [vertices - 2, vertices - 1].map(|i| path.vertex(i));
            let (Some(before), Some(here)) = (before, here) else { break };
            let Some(surface) = here.surface() else { break };
            let side = surface.normal.dot(before.direction_from(here.position)).signum();
            let (normal, vertices) = (side * surface.normal, vertices as u32);
            ends.push(End { position: here.position, normal, path: number, vertices });
        }
    }
    ends
}
