//! Light tracing: paths from lights, each of whose vertices is connected to the camera (Dutré et al. 1993).

use aether_core::UniformSource;
use glam::Vec3;

use crate::emission::LightStrategies;
use crate::integrator::{Integrator, Received};
use crate::kind::SceneKind;
use crate::path::PathSettings;
use crate::render::{Splats, Technique};
use crate::strategies::{Pixel, sample_camera};
use crate::subpaths::{Scratch, light_path};
use crate::world::World;

/// The light tracer, with the settings of a path tracer. It does not find what is seen directly in a
/// mirror.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightTracer {
    /// Lengths of paths, Russian roulette.
    pub path: PathSettings,
}

impl Integrator for LightTracer {
    type Scratch<'a, K: SceneKind> = Scratch<'a, K, LightStrategies<'a, K>>;
    const SPLATS: bool = true;
    const SHARES: bool = true;

    fn scratch<'a, K: SceneKind>(&'a self, world: &'a World<'a, K>) -> Self::Scratch<'a, K> {
        Scratch::new(world)
    }

    fn sample<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
        Scratch { arena, estimator }: &mut Self::Scratch<'a, K>,
        uniforms: &mut impl UniformSource<f32>,
        pixel: Pixel,
        splats: &mut Splats,
    ) -> Vec3 {
        arena.clear();
        let longest = self.path.most_vertices() - 1;
        let mut eye = arena.sequence();
        eye.append(sample_camera(world)).sample(uniforms);
        let light = light_path(world, arena, uniforms, (longest, self.path.rr_depth));

        let mut received = Received::new(pixel, splats);
        let first = 1 + usize::from(self.path.hide_emitters);
        for length in first..=light.len().min(longest) {
            let by = Technique::edge(1, length);
            if !self.path.techniques.has(by) {
                continue;
            }
            let path = eye.concat(&light.slice(0..length).reverse());
            let value = estimator.of(&path) / world.pixels() as f32;
            if let Some(film) = estimator.integrand().film_point(&path) {
                received.add_at(&world.scene.film, film, by, [value; 2]);
            }
        }
        received.own
    }
}
