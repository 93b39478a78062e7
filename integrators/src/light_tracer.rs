//! Light tracing: paths from lights, each of whose vertices is connected to the camera (Dutré et al. 1993).

use aether_core::estimator::{Estimator, Factors};
use aether_core::{Arena, UniformSource};
use glam::Vec3;

use crate::bidirectional::BidirectionalArena;
use crate::emission::{sample_emission, sample_emitter};
use crate::integrand::Radiance;
use crate::integrator::Integrator;
use crate::kind::SceneKind;
use crate::path::PathSettings;
use crate::render::Splats;
use crate::strategies::{Pixel, sample_bsdf, sample_camera};
use crate::world::World;

/// The light tracer, with the settings of a path tracer. It does not find what is seen directly in a
/// mirror.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightTracer {
    /// Lengths of paths, Russian roulette.
    pub path: PathSettings,
}

/// What one thread reuses.
pub struct Scratch<'a, K: SceneKind> {
    arena: BidirectionalArena<'a, K>,
    estimator: Estimator<Radiance<'a, 'a, K>, Factors<Vec3>>,
}

impl Integrator for LightTracer {
    type Scratch<'a, K: SceneKind> = Scratch<'a, K>;
    const SPLATS: bool = true;

    fn scratch<'a, K: SceneKind>(&self, world: &'a World<'a, K>) -> Scratch<'a, K> {
        Scratch { arena: Arena::new(), estimator: Estimator::paths(Radiance::new(world)) }
    }

    fn sample<'a, K: SceneKind>(
        &self,
        world: &'a World<'a, K>,
        Scratch { arena, estimator }: &mut Scratch<'a, K>,
        uniforms: &mut impl UniformSource<f32>,
        pixel: Pixel,
        splats: &mut Splats,
    ) -> Vec3 {
        arena.clear();
        let longest = self.path.max_depth.map_or(usize::MAX, |edges| edges as usize);
        let mut eye = arena.sequence();
        eye.append(sample_camera(world)).sample(uniforms);
        let mut light = arena.sequence();
        light.append(sample_emitter(world));
        light.append(sample_emission(world)).sample(uniforms);
        while light.is_complete() && light.size() < longest {
            light.append(sample_bsdf(world, self.path.rr_depth)).sample(uniforms);
        }

        let mut own = Vec3::ZERO;
        let first = 1 + usize::from(self.path.hide_emitters);
        for length in first..=light.len().min(longest) {
            let path = eye.concat(&light.slice(0..length).reverse());
            let value = estimator.of(&path) / world.pixels() as f32;
            for receiver in world.receivers(pixel, &path) {
                let share = value * estimator.integrand().response(receiver, &path);
                if receiver == pixel {
                    own += share;
                } else {
                    splats.add(receiver, share.to_array());
                }
            }
        }
        own
    }
}
