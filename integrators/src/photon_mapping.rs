//! Progressive photon mapping, probabilistic (Knaus and Zwicker 2011; Aether 2017, section 7.7).
//!
//! Each sample of the image has photons of its own, and a smaller radius than the one before. A path from the
//! camera and one from a light whose ends lie within the radius of each other are merged: their light is the
//! product of both, times the kernel. It is biased, and consistent: bias and noise vanish with the samples.

use std::sync::{PoisonError, RwLock};

use aether_core::estimator::{Estimator, Factors};
use glam::Vec3;

use crate::emission::LightStrategies;
use crate::integrand::Radiance;
use crate::integrator::Received;
use crate::kind::{NotCovered, SceneKind};
use crate::path::PathSettings;
use crate::photons::{Photon, PhotonMap, seen_size, shrunk};
use crate::render::{AnyKernel, Cancelled, Splats, Technique, Worker};
use crate::scene::{Filter, SamplerKind, Scene};
use crate::strategies::{Pixel, sample_bsdf};
use crate::subpaths::{Scratch, camera_path, is_atom, light_path};
use crate::uniforms::Uniforms;
use crate::work::in_parts;
use crate::world::World;

/// Surfaces all of whose lobes are less rough than this are followed like mirrors: hardly a photon comes from where
/// they reflect much.
const SMOOTH: f32 = 0.1;

/// More photons than paths mostly have that Russian roulette ends.
pub(crate) const COUNTED: usize = 8;

/// Where each photon is at once: with those of its thread, among all, sorted, and in the map of the pass before.
const COPIES: usize = 4;

/// What sorting them takes beside, in bytes: buckets, places and the beginnings of buckets.
pub(crate) const SORTED: usize = 32;

/// Settings of photon mapping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhotonMapping {
    /// Lengths of paths, Russian roulette.
    pub path: PathSettings,
    /// Light paths of each sample of the image; none for as many as there are pixels.
    pub light_paths: Option<u32>,
    /// The first radius over that of what is seen of the scene ([`seen_size`]).
    pub radius: f32,
    /// How fast the radius shrinks: 1 not at all, 0 so that the noise stays.
    pub alpha: f32,
}

impl PhotonMapping {
    /// With the usual settings.
    pub fn new(path: PathSettings) -> Self {
        PhotonMapping { path, light_paths: None, radius: 0.02, alpha: 2.0 / 3.0 }
    }

    /// About as many bytes as the photons of so many light paths may take. Where nothing else limits the lengths of these, they
    /// are counted as paths of eight.
    pub fn bytes(&self, light_paths: u32) -> u64 {
        let photons = self.path.light_vertices(COUNTED);
        u64::from(light_paths) * (photons * (COPIES * size_of::<Photon>() + SORTED)) as u64
    }
}

/// Photon mapping of a scene, as the render engine calls it.
pub struct PhotonKernel<'s, K: SceneKind> {
    world: World<'s, K>,
    /// What the radius is relative to.
    size: f32,
    settings: PhotonMapping,
    seed: u64,
    map: RwLock<PhotonMap>,
}

impl<'s, K: SceneKind> PhotonKernel<'s, K> {
    /// Photon mapping of a scene; the same seed gives the same image.
    ///
    /// # Errors
    /// If the scene needs what the kind leaves out.
    pub fn new(scene: &'s Scene, settings: PhotonMapping, seed: u64) -> Result<Self, NotCovered> {
        let world = World::new(scene)?;
        let size = seen_size(&world);
        Ok(PhotonKernel { world, size, settings, seed, map: RwLock::default() })
    }

    fn light_paths(&self) -> usize {
        self.settings.light_paths.map_or(self.world.pixels(), |paths| paths as usize)
    }

    /// The photons of some light paths of a sample; not all of them if the render is cancelled.
    fn shoot(
        &self,
        sample: u32,
        paths: std::ops::Range<usize>,
        cancelled: Cancelled<'_>,
    ) -> Vec<Photon> {
        let world = &self.world;
        let longest = self.settings.path.most_vertices();
        let Scratch { mut arena, estimator } = Scratch::<K, LightStrategies<K>>::new(world);
        let mut photons = Vec::new();
        for k in paths.take_while(|_| !cancelled()) {
            arena.clear();
            let uniforms =
                &mut Uniforms::independent(self.seed, u64::MAX - k as u64, u64::from(sample));
            let light = light_path(world, &arena, uniforms, (longest, self.settings.path.rr_depth));
            for size in 2..=light.len() {
                let path = light.slice(0..size).reverse();
                let (Some(here), Some(before)) = (path.vertex(0), path.vertex(1)) else { break };
                let Some(surface) = here.surface() else { break };
                let power = estimator.of(&path);
                if power == Vec3::ZERO || !power.is_finite() {
                    continue;
                }
                let towards = before.direction_from(here.position);
                let side = surface.normal.dot(towards).signum();
                photons.push(Photon {
                    position: here.position,
                    normal: side * surface.normal,
                    towards,
                    power,
                    edges: size as u32 - 1,
                });
            }
        }
        photons
    }

    /// What a pixel receives, given the photons.
    fn gather<'a>(
        &'a self,
        map: &PhotonMap,
        Gatherer { scratch, throughput }: &mut Gatherer<'a, K>,
        uniforms: &mut Uniforms,
        pixel: Pixel,
        splats: &mut Splats,
    ) -> Vec3 {
        let Scratch { arena, estimator: radiance } = scratch;
        arena.clear();
        let (world, path) = (&self.world, self.settings.path);
        let longest = path.most_vertices();
        let mut received = Received::new(pixel, splats);
        let aim = received.aim();
        let mut camera = camera_path(world, arena, uniforms, aim, (longest.min(2), 0));
        let response = received.begin_with(radiance.integrand(), &camera);
        let mut add = |by: Technique, value: Vec3| {
            if path.techniques.has(by) {
                received.add_own(by, value, value);
            }
        };
        if longest >= 2 && !path.hide_emitters {
            add(Technique::edge(camera.len(), 0), radiance.of(&camera) * response);
        }
        // What is seen in mirrors, and in what is nearly one, is followed; everything else is lit by the photons.
        while camera.is_complete() && camera.len() < longest {
            let (Some(here), Some(before)) = (camera.last(), camera.vertex(camera.len() - 2))
            else {
                break;
            };
            let scattering = world.scattering(&here, &before);
            let scattering = scattering.filter(|scattering| scattering.roughest() >= SMOOTH);
            let is_lit = scattering.is_some();
            if let (Some(surface), Some(scattering)) = (here.surface(), scattering) {
                let kernel = 1.0 / (std::f32::consts::PI * map.radius().powi(2));
                let share = response * kernel / self.light_paths() as f32;
                let carried = throughput.of(&camera) * share;
                map.near(here.position, |photon| {
                    let technique = Technique::merge(camera.len(), photon.edges as usize + 1);
                    let side = surface.normal.dot(photon.towards).signum();
                    let faces = side * surface.normal.dot(photon.normal) > 0.0;
                    if technique.vertices <= longest && faces {
                        add(technique, carried * scattering.value(photon.towards) * photon.power);
                    }
                });
            }
            camera.append(sample_bsdf(world, path.rr_depth, None)).sample(uniforms);
            let mirrored = |i| is_atom(&camera, i);
            if !camera.is_complete() || is_lit && !mirrored(camera.len() - 2) {
                break;
            }
            add(Technique::edge(camera.len(), 0), radiance.of(&camera) * response);
        }
        received.own
    }
}

/// What one thread reuses: the paths and estimators of what a path carries, and of what it would carry of any
/// radiance.
struct Gatherer<'a, K: SceneKind> {
    scratch: Scratch<'a, K, LightStrategies<'a, K>>,
    throughput: Estimator<Radiance<'a, 'a, K>, Factors<Vec3>>,
}

impl<K: SceneKind> AnyKernel for PhotonKernel<'_, K> {
    fn worker(&self) -> Worker<'_> {
        let world = &self.world;
        let throughput = Estimator::paths(Radiance::throughput(world));
        let mut gatherer = Gatherer { scratch: Scratch::new(world), throughput };
        let map = self.map.read().unwrap_or_else(PoisonError::into_inner);
        let film = &world.scene.film;
        Box::new(move |pixel, sample, splats| {
            let (kind, seed) = (SamplerKind::Independent, self.seed);
            let mut uniforms = Uniforms::of_pixel(kind, seed, pixel, film, sample);
            self.gather(&map, &mut gatherer, &mut uniforms, pixel, splats).to_array()
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
        let photons =
            in_parts(self.light_paths(), threads, |part| self.shoot(first, part, cancelled));
        if cancelled() {
            return false;
        }
        let radius = self.settings.radius * self.size * shrunk(self.settings.alpha, first);
        let map = PhotonMap::new(photons, radius);
        *self.map.write().unwrap_or_else(PoisonError::into_inner) = map;
        true
    }
}
