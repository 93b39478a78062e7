//! Tridirectional path tracing (Aether 2017, section 7.4 and Figure 10): beside the pieces of paths from the
//! camera and from the lights, segments through openings that light has to pass. Light from infinitely far away is
//! sampled through openings too.

use aether_core::{PowerHeuristic, UniformSource, combine};
use glam::Vec3;

use crate::daylight::{sample_emission_and_openings, sample_light_and_openings};
use crate::emission::sample_emitter;
use crate::integrator::{Integrator, Received};
use crate::kind::SceneKind;
use crate::path::PathSettings;
use crate::portals::{PortalStrategies, Portals, sample_portal};
use crate::render::{Splats, Technique};
use crate::strategies::{Aim, Pixel, sample_bsdf};
use crate::subpaths::{Scratch, camera_path, extend, splits};
use crate::world::World;

/// Settings of tridirectional path tracing.
#[derive(Clone, Debug)]
pub struct Tridirectional {
    /// Lengths of paths, Russian roulette.
    pub path: PathSettings,
    /// The openings.
    pub portals: Portals,
}

impl Integrator for Tridirectional {
    type Scratch<'a, K: SceneKind>
        = Scratch<'a, K, PortalStrategies<'a, K>>
    where
        Self: 'a;
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
        let rr = self.path.rr_depth;
        let longest = self.path.most_vertices();
        let mut camera = camera_path(world, arena, uniforms, Aim::Image(pixel), (longest, rr));
        let mut light = arena.sequence();
        light.append(sample_emitter(world));
        light.append(sample_emission_and_openings(world, &self.portals)).sample(uniforms);
        while light.is_complete() && light.size() + 1 < longest {
            light.append(sample_bsdf(world, rr, None)).sample(uniforms);
        }
        let mut segment = arena.sequence();
        segment.append(sample_portal(world, &self.portals)).sample(uniforms);
        let total = (camera.len() + light.len() + segment.len()).min(longest);
        extend(&mut camera, world, (total, rr));
        extend(&mut light, world, (total, rr));

        let mut received = Received::new(pixel, splats);
        let radiance = estimator.integrand();
        let counts = received.begin_for_all(radiance, &camera);
        let eye = camera.slice(0..1);
        for length in 2 + usize::from(self.path.hide_emitters)..=total {
            let lit = |s: usize| light.slice(0..s).reverse();
            let through_portal =
                (1..length.saturating_sub(1)).map(|t| Technique::portal(t, length - t - 2));
            let used = self.path.techniques.among(splits(length).chain(through_portal));
            let techniques = used.clone().map(|by| match (by.joint, by.light, by.camera) {
                (Technique::PORTAL, s, t) => {
                    let count = if t == 1 { world.pixels() } else { 1 };
                    (camera.slice(0..t).concat(&segment).concat(&lit(s)), count)
                }
                (_, s, 1) => (eye.concat(&lit(s)), world.pixels()),
                (_, 1, t) => {
                    let mut direct = camera.slice(0..t);
                    direct.append(sample_light_and_openings(world, &self.portals));
                    direct.sample(uniforms);
                    (direct, 1)
                }
                (_, s, t) => (camera.slice(0..t).concat(&lit(s)), 1),
            });
            let techniques = arena.collect_counted(techniques);
            for found in estimator.each(combine::<PowerHeuristic, _>(techniques)) {
                let Some(by) = used.clone().nth(found.technique) else { continue };
                received.add_found(radiance, (by, by.camera == 1), &found, counts);
            }
        }
        received.own
    }
}
