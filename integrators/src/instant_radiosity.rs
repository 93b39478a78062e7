//! Instant radiosity (Keller 1997; Aether 2017, section 7.6): light paths that all pixels share, whose
//! vertices are virtual point lights.

use aether_core::{Arena, Snapshot, UniformSource};
use glam::Vec3;

use crate::emission::LightStrategies;
use crate::integrand::Radiance;
use crate::integrator::{Integrator, Received};
use crate::kind::SceneKind;
use crate::path::PathSettings;
use crate::render::{Splats, Technique};
use crate::strategies::{Pixel, sample_bsdf};
use crate::subpaths::{Path, Scratch, camera_path, is_atom, light_path};
use crate::uniforms::Uniforms;
use crate::vertex::SceneVertex;
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

/// What one thread reuses: the light paths of a sample.
pub struct VirtualLights<'a, K: SceneKind> {
    scratch: Scratch<'a, K, LightStrategies<'a, K>>,
    paths: Vec<Snapshot<SceneVertex<K>, LightStrategies<'a, K>>>,
}

impl Integrator for InstantRadiosity {
    type Scratch<'a, K: SceneKind> = VirtualLights<'a, K>;
    const SHARES: bool = true;

    fn scratch<'a, K: SceneKind>(&'a self, world: &'a World<'a, K>) -> VirtualLights<'a, K> {
        let limit = self.clamp.unwrap_or(f32::INFINITY);
        let scratch = Scratch::with(Radiance::clamped(world, limit));
        VirtualLights { scratch, paths: Vec::new() }
    }

    fn begin<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
        VirtualLights { paths, .. }: &mut VirtualLights<'a, K>,
        seed: u64,
        sample: u32,
    ) {
        let longest = self.path.most_vertices() - 1;
        let mut arena = Arena::new();
        paths.clear();
        for k in 0..self.light_paths {
            arena.clear();
            let uniforms =
                &mut Uniforms::independent(seed, u64::MAX - u64::from(k), u64::from(sample));
            let light = light_path(world, &arena, uniforms, (longest, self.path.rr_depth));
            paths.push(Snapshot::of(&light.slice(0..light.len())));
        }
    }

    fn sample<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
        VirtualLights { scratch, paths }: &mut VirtualLights<'a, K>,
        uniforms: &mut impl UniformSource<f32>,
        pixel: Pixel,
        splats: &mut Splats,
    ) -> Vec3 {
        let Scratch { arena, estimator } = scratch;
        arena.clear();
        let longest = self.path.most_vertices();
        let mut received = Received::new(pixel, splats);
        let aim = received.aim();
        let mut camera = camera_path(world, arena, uniforms, aim, (longest.min(2), 0));
        let response = received.begin_with(estimator.integrand(), &camera);
        let mut add = |by: Technique, path: &Path<'_, K, _>, share: f32| {
            if self.path.techniques.has(by) {
                let value = estimator.of(path) * share;
                received.add_own(by, value, value);
            }
        };
        if longest >= 2 && !self.path.hide_emitters {
            add(Technique::edge(camera.len(), 0), &camera, response);
        }
        // What is seen in mirrors is followed; everything else is lit by the virtual lights.
        while camera.is_complete() && camera.len() < longest {
            for light in paths.iter() {
                let light = arena.restore(light);
                for s in 1..=light.len().min(longest - camera.len()) {
                    let path = camera.concat(&light.slice(0..s).reverse());
                    let share = response / self.light_paths as f32;
                    add(Technique::edge(camera.len(), s), &path, share);
                }
            }
            camera.append(sample_bsdf(world, self.path.rr_depth, None)).sample(uniforms);
            let mirrored = |i| is_atom(&camera, i);
            if !camera.is_complete() || !mirrored(camera.len() - 2) {
                break;
            }
            add(Technique::edge(camera.len(), 0), &camera, response);
        }
        received.own
    }
}
