//! Bidirectional path tracing (Aether 2017, Figure 6; Veach 1997, chapter 10).
//!
//! A path of n vertices can be made in as many ways as there are splits of it into a piece from the camera
//! and one from a light. Weights are those of the pixel that receives the light: the camera's techniques
//! have the density of that pixel's film samples and are taken once a sample, while the technique that
//! connects light paths to the camera gets a sample from every light path of the image.

use aether_core::estimator::{Estimator, Factors};
use aether_core::{Arena, PowerHeuristic, UniformSource, combine};
use glam::Vec3;

use crate::emission::{LightStrategies, sample_emission, sample_emitter};
use crate::integrand::Radiance;
use crate::integrator::{Integrator, Kernel};
use crate::kind::{Everything, SceneKind};
use crate::path::PathSettings;
use crate::render::Splats;
use crate::selection::Selection;
use crate::strategies::{Pixel, sample_bsdf, sample_camera, sample_camera_direction, sample_light};
use crate::vertex::SceneVertex;
use crate::world::World;

/// Settings of bidirectional path tracing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bidirectional {
    /// Lengths of paths, Russian roulette.
    pub path: PathSettings,
    /// Which techniques are used.
    pub techniques: Selection,
}

/// The paths of one sample.
pub type BidirectionalArena<'a, K = Everything> = Arena<SceneVertex<K>, LightStrategies<'a, K>>;

/// What one thread reuses.
pub struct Scratch<'a, K: SceneKind> {
    arena: BidirectionalArena<'a, K>,
    estimator: Estimator<Radiance<'a, 'a, K>, Factors<Vec3>>,
}

impl Integrator for Bidirectional {
    type Scratch<'a, K: SceneKind> = Scratch<'a, K>;
    const SPLATS: bool = true;

    fn scratch<'a, K: SceneKind>(&self, world: &'a World<'a, K>) -> Scratch<'a, K> {
        Scratch { arena: Arena::new(), estimator: Estimator::paths(Radiance::new(world)) }
    }

    fn sample<'a, K: SceneKind>(
        &self,
        world: &'a World<'a, K>,
        scratch: &mut Scratch<'a, K>,
        uniforms: &mut impl UniformSource<f32>,
        pixel: Pixel,
        splats: &mut Splats,
    ) -> Vec3 {
        let mut own = Vec3::ZERO;
        self.paths(world, scratch, uniforms, pixel, |receiver, value| {
            if receiver == pixel {
                own += value;
            } else {
                splats.add(receiver, value.to_array());
            }
        });
        own
    }
}

impl Bidirectional {
    /// One sample: calls `record` with a pixel and what it receives.
    fn paths<'a, K: SceneKind>(
        &self,
        world: &'a World<'a, K>,
        Scratch { arena, estimator }: &mut Scratch<'a, K>,
        uniforms: &mut impl UniformSource<f32>,
        pixel: Pixel,
        mut record: impl FnMut(Pixel, Vec3),
    ) {
        arena.clear();
        let scatter = sample_bsdf(world, self.path.rr_depth);
        let longest = self.path.max_depth.map_or(usize::MAX, |edges| edges as usize + 1);

        let mut camera = arena.sequence();
        camera.append(sample_camera(world));
        camera.append(sample_camera_direction(world, pixel)).sample(uniforms);
        while camera.is_complete() && camera.size() < longest {
            camera.append(scatter.clone()).sample(uniforms);
        }
        let mut light = arena.sequence();
        light.append(sample_emitter(world));
        light.append(sample_emission(world)).sample(uniforms);
        while light.is_complete() && light.size() + 1 < longest {
            light.append(scatter.clone()).sample(uniforms);
        }
        // What has ended might have gone on: it remains a technique.
        let total = (camera.len() + light.len()).min(longest);
        for path in [&mut camera, &mut light] {
            while path.size() < total {
                path.append(scatter.clone());
            }
        }

        let eye = camera.slice(0..1);
        for length in 2 + usize::from(self.path.hide_emitters)..=total {
            let seen = eye.concat(&light.slice(0..length - 1).reverse());
            for receiver in world.receivers(pixel, &seen) {
                let mut view = camera;
                if receiver != pixel {
                    view = arena.sequence();
                    view.append(sample_camera(world));
                    view.append(sample_camera_direction(world, receiver));
                    view = view.concat(&camera.slice(2..));
                }
                let splits = (1..=length).filter(|t| self.techniques.has(length - t, *t));
                let techniques = arena.collect_counted(splits.map(|t| match (length - t, t) {
                    (_, 1) => (seen, world.pixels()),
                    (1, t) => {
                        let mut direct = view.slice(0..t);
                        direct.append(sample_light(world)).sample(uniforms);
                        (direct, 1)
                    }
                    (s, t) => (view.slice(0..t).concat(&light.slice(0..s).reverse()), 1),
                }));
                for (path, value) in estimator.each(combine::<PowerHeuristic, _>(techniques)) {
                    let response = estimator.integrand().response(receiver, &path);
                    record(receiver, value * response);
                }
            }
        }
    }
}

/// Bidirectional path tracing for a kind of scene.
pub type BidirectionalTracer<'s, K = Everything> = Kernel<'s, K, Bidirectional>;
