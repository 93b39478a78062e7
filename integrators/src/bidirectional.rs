//! Bidirectional path tracing (Aether 2017, Figure 6; Veach 1997, chapter 10).
//!
//! A path of n vertices can be made in as many ways as there are splits of it into a piece from the camera
//! and one from a light. Weights are those of the pixel that receives the light: the camera's techniques
//! have the density of that pixel's film samples and are taken once a sample, while the technique that
//! connects light paths to the camera gets a sample from every light path of the image. A sample may have several
//! light paths: then what needs one has so many samples.

use std::ops::RangeInclusive;

use aether_core::estimator::Connections;
use aether_core::uniform::Piece;
use aether_core::{PowerHeuristic, UniformSource};
use glam::Vec3;

use crate::emission::LightStrategies;
use crate::integrator::{Integrator, Kernel, Received};
use crate::kind::{Everything, SceneKind};
use crate::path::PathSettings;
use crate::render::{Splats, Technique};
use crate::strategies::{Pixel, sample_camera_direction, sample_light};
use crate::subpaths::{Scratch, camera_path, extend, light_path};
use crate::world::World;

/// Settings of bidirectional path tracing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bidirectional {
    /// Lengths of paths, Russian roulette, techniques.
    pub path: PathSettings,
    /// How many light paths a sample takes beside its camera path: at least one, and at most
    /// [`MOST_PIECES`](aether_core::uniform::MOST_PIECES).
    pub light_paths: u32,
    /// Paths with fewer vertices are left out; all have two at least.
    pub fewest_vertices: usize,
}

impl Bidirectional {
    /// One light path for each camera path, and paths of all lengths.
    pub fn new(path: PathSettings) -> Self {
        Bidirectional { path, light_paths: 1, fewest_vertices: 2 }
    }
}

impl Integrator for Bidirectional {
    type Scratch<'a, K: SceneKind> = Scratch<'a, K, LightStrategies<'a, K>>;
    const SPLATS: bool = true;

    fn scratch<'a, K: SceneKind>(&'a self, world: &'a World<'a, K>) -> Self::Scratch<'a, K> {
        Scratch::new(world)
    }

    fn sample<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
        scratch: &mut Self::Scratch<'a, K>,
        uniforms: &mut impl UniformSource<f32>,
        pixel: Pixel,
        splats: &mut Splats,
    ) -> Vec3 {
        let mut received = Received::new(pixel, splats);
        self.paths(world, scratch, uniforms, pixel, |technique, receiver, value, alone| {
            received.add_by(technique, receiver, value, alone);
        });
        received.own
    }
}

impl Bidirectional {
    /// One sample: calls `record` with a technique, a pixel, what that receives from it, and what it would if
    /// there were no other technique.
    pub fn paths<'a, K: SceneKind>(
        &self,
        world: &'a World<'a, K>,
        Scratch { arena, estimator }: &mut Scratch<'a, K, LightStrategies<'a, K>>,
        uniforms: &mut impl UniformSource<f32>,
        pixel: Pixel,
        mut record: impl FnMut(Technique, Pixel, Vec3, Vec3),
    ) {
        arena.clear();
        let rr = self.path.rr_depth;
        let longest = self.path.most_vertices();
        let seen_by = camera_path(world, arena, uniforms, pixel, (longest, rr));
        let radiance = estimator.integrand();
        let response = radiance.response(pixel, &seen_by);
        let count = self.light_paths.max(1) as usize;
        let fewest = self.fewest_vertices.max(2 + usize::from(self.path.hide_emitters));
        let look = sample_light(world).into();
        for number in 0..count {
            let uniforms = &mut Piece::new(uniforms, number as u32);
            let mut camera = seen_by;
            let mut light = light_path(world, arena, uniforms, (longest.saturating_sub(1), rr));
            // What has ended might have gone on: it remains a technique.
            let total = (camera.len() + light.len()).min(longest);
            extend(&mut camera, world, (total, rr));
            extend(&mut light, world, (total, rr));

            // What the eye sees of the light paths of each length, and the pixels that receive it: of the pixel's own
            // sample everything counts, of the others only that.
            let eye = camera.vertex(0);
            let seen = |length: usize| Some([eye?, light.vertex(length - 2)?]);
            let direct = |length: usize, receiver: Pixel| {
                seen(length)
                    .map_or(0.0, |[eye, seen]| radiance.response_to(receiver, [&eye, &seen]))
            };
            let mut estimate = |lengths: RangeInclusive<usize>, receiver: Pixel| {
                let is_own = receiver == pixel;
                let other = sample_camera_direction(world, receiver.into()).into();
                let by = |length: usize, first: usize| Technique::edge(first, length - first);
                let connections = Connections {
                    lengths,
                    replaced: (!is_own).then_some((1, &other)),
                    ending: Some(&look),
                    fewest_ending: 3,
                    samples: |length, first| match first {
                        _ if first == 0 || !self.path.techniques.has(by(length, first)) => 0,
                        1 => count * world.pixels(),
                        _ if first == length => 1,
                        _ => count,
                    },
                    is_drawn: |length, first| match first {
                        1 => direct(length, receiver) != 0.0,
                        _ => is_own && (first < length || number == 0),
                    },
                };
                let walks = [&camera, &light];
                estimator.connections(walks, &connections, &PowerHeuristic, uniforms, |found| {
                    let is_direct = found.first == 1;
                    let response =
                        if is_direct { direct(found.length, receiver) } else { response };
                    let [value, alone] = [found.value, found.alone].map(|v| v * response);
                    record(by(found.length, found.first), receiver, value, alone);
                });
            };
            estimate(fewest..=total, pixel);
            for length in fewest..=total {
                for receiver in radiance.receivers(pixel, [seen(length)]).skip(1) {
                    if direct(length, receiver) != 0.0 {
                        estimate(length..=length, receiver);
                    }
                }
            }
        }
    }
}

/// Bidirectional path tracing for a kind of scene.
pub type BidirectionalTracer<'s, K = Everything> = Kernel<'s, K, Bidirectional>;
