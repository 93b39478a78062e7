//! Bidirectional path tracing (Aether 2017, Figure 6; Veach 1997, chapter 10).
//!
//! A path of n vertices can be made in as many ways as there are splits of it into a piece from the camera
//! and one from a light. Weights are those of the pixel that receives the light: the camera's techniques
//! have the density of that pixel's film samples and are taken once a sample, while the technique that
//! connects light paths to the camera gets a sample from every light path of the image. A sample may have several
//! light paths: then what needs one has so many samples.

use aether_core::estimator::{Connections, Replaced};
use aether_core::uniform::Piece;
use aether_core::{PowerHeuristic, UniformSource};
use glam::Vec3;

use crate::emission::LightStrategies;
use crate::eye::Reached;
use crate::integrand::{Radiance, Sight};
use crate::integrator::{Integrator, Kernel, Received};
use crate::kind::{Everything, SceneKind};
use crate::path::PathSettings;
use crate::render::{Splats, Technique};
use crate::strategies::{Pixel, sample_camera_direction, sample_light};
use crate::subpaths::{Scratch, camera_path, extend, light_path};
use crate::vertex::SceneVertex;
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

/// As how many samples one of direct light counts, where the camera's path leads to it, when it is weighed against light paths
/// that happen to meet a pixel.
///
/// Densities do not tell that these samples differ less than others do: each pixel has the same number of them, and next-event
/// estimation spreads them over the light (variance-aware weights: Grittmann et al. 2019, "Variance-Aware Multiple Importance
/// Sampling"; here by a number that is known beforehand). Of Mitsuba's Cornell box the relMSE of `aether render --integrator bdpt
/// --sampler ldsampler --spp 16` is 3.73e-3 with one, 2.64e-3 with four and 2.59e-3 with sixteen. Of Veach's plates, where lights
/// are often found better by scattering, it is 1.00e-2, 8.7e-3 and 1.41e-2; of other scenes up to 3 % lower with four, or the same.
/// For longer paths there is nothing to be gained so.
pub const DIRECT: usize = 4;

/// How many samples one counts as that makes a path with so many vertices, the first number, of which so many are of the camera.
#[inline(always)]
fn worth(length: usize, first: usize) -> usize {
    if length == 3 && first == 2 { DIRECT } else { 1 }
}

/// What one thread reuses from sample to sample.
pub struct BidirectionalScratch<'a, K: SceneKind> {
    paths: Scratch<'a, K, LightStrategies<'a, K>>,
    /// What the eye sees of the light path, by the number of vertices of the path that joins both.
    looks: Vec<Option<Look<K>>>,
    /// How another pixel would make the camera path, by the number of vertices.
    others: Vec<Option<LightStrategies<'a, K>>>,
}

/// What the eye sees of a light path.
struct Look<K: SceneKind> {
    seen: SceneVertex<K>,
    sight: Sight,
    /// The pixels whose filters reach it.
    reached: Reached,
    /// The response of the pixel that the sample is made for.
    own: f32,
    /// Another pixel, and its response.
    other: (Pixel, f32),
}

impl<K: SceneKind> Look<K> {
    /// What an eye sees of a vertex, if it does, in a sample that is made for a pixel.
    fn new(
        radiance: &Radiance<'_, '_, K>,
        world: &World<'_, K>,
        pixel: Pixel,
        eye: &SceneVertex<K>,
        seen: SceneVertex<K>,
    ) -> Option<Self> {
        let sight = radiance.sight(eye, &seen)?;
        let own = radiance.response_at(pixel, &sight, [eye, &seen]);
        let reached = world.reached(sight.film);
        Some(Look { seen, sight, reached, own, other: (pixel, 0.0) })
    }

    /// Turns to one of the pixels that receive it, by its number: how a camera path of that pixel would find the vertex,
    /// if it is another one than that of the sample.
    fn turn<'a>(
        &mut self,
        radiance: &Radiance<'_, '_, K>,
        world: &'a World<'a, K>,
        pixel: Pixel,
        eye: &SceneVertex<K>,
        turn: u32,
    ) -> Option<LightStrategies<'a, K>> {
        let other = (turn < self.reached.count()).then(|| self.reached.pixel(turn))?;
        if other == pixel {
            return None;
        }
        let response = radiance.response_at(other, &self.sight, [eye, &self.seen]);
        self.other = (other, response);
        (response != 0.0).then(|| sample_camera_direction(world, other.into()).into())
    }
}

impl Integrator for Bidirectional {
    type Scratch<'a, K: SceneKind> = BidirectionalScratch<'a, K>;
    const SPLATS: bool = true;

    fn scratch<'a, K: SceneKind>(&'a self, world: &'a World<'a, K>) -> Self::Scratch<'a, K> {
        let (looks, others) = (Vec::new(), Vec::new());
        BidirectionalScratch { paths: Scratch::new(world), looks, others }
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
        scratch: &mut BidirectionalScratch<'a, K>,
        uniforms: &mut impl UniformSource<f32>,
        pixel: Pixel,
        mut record: impl FnMut(Technique, Pixel, Vec3, Vec3),
    ) {
        let BidirectionalScratch { paths: Scratch { arena, estimator }, looks, others } = scratch;
        arena.clear();
        let rr = self.path.rr_depth;
        let longest = self.path.most_vertices();
        let seen_by = camera_path(world, arena, uniforms, pixel, (longest, rr));
        let radiance = estimator.integrand();
        let response = radiance.response(pixel, &seen_by);
        let count = self.light_paths.max(1) as usize;
        let fewest = self.fewest_vertices.max(2 + usize::from(self.path.hide_emitters));
        let ending = sample_light(world).into();
        let by = |length: usize, first: usize| Technique::edge(first, length - first);
        let from_lights = count * world.pixels();
        let samples = |length: usize, first: usize| match first {
            0 => 0,
            _ if !self.path.techniques.has(by(length, first)) => 0,
            1 => from_lights,
            _ if first == length => 1,
            _ => count * worth(length, first),
        };
        for number in 0..count {
            let uniforms = &mut Piece::new(uniforms, number as u32);
            let mut camera = seen_by;
            let mut light = light_path(world, arena, uniforms, (longest.saturating_sub(1), rr));
            // What has ended might have gone on: it remains a technique.
            let total = (camera.len() + light.len()).min(longest);
            extend(&mut camera, world, (total, rr));
            extend(&mut light, world, (total, rr));
            let walks = [&camera, &light];
            // What the eye sees of the light paths of each length, and the pixels that receive it: of the pixel's own
            // sample everything counts, of the others only that.
            let eye = camera.vertex(0);
            looks.clear();
            looks.extend((0..total + 1).map(|length| {
                let seen = light.vertex(length.checked_sub(2)?)?;
                Look::new(radiance, world, pixel, eye.as_ref()?, seen)
            }));
            let own = |length: usize| looks[length].as_ref().map_or(0.0, |look| look.own);
            let connections = Connections {
                lengths: fewest..=total,
                replaced: None,
                ending: Some(&ending),
                fewest_ending: 3,
                samples,
                is_drawn: |length, first| match first {
                    1 => own(length) != 0.0,
                    _ => first < length || number == 0,
                },
            };
            estimator.connections(walks, &connections, &PowerHeuristic, uniforms, |found| {
                let response = if found.first == 1 { own(found.length) } else { response };
                // There is one sample where several are weighed.
                let response = response * worth(found.length, found.first) as f32;
                let [value, alone] = [found.value, found.alone].map(|v| v * response);
                record(by(found.length, found.first), pixel, value, alone);
            });
            let most = looks.iter().flatten().map(|look| look.reached.count()).max();
            for turn in 0..most.unwrap_or(0) {
                others.clear();
                others.extend(
                    looks.iter_mut().map(|look| {
                        look.as_mut()?.turn(radiance, world, pixel, eye.as_ref()?, turn)
                    }),
                );
                if others.iter().all(|other| other.is_none()) {
                    continue;
                }
                let connections = Connections {
                    lengths: fewest..=total,
                    replaced: Some(Replaced { step: 1, by: others }),
                    ending: Some(&ending),
                    fewest_ending: 3,
                    samples,
                    is_drawn: |_, first| first == 1,
                };
                estimator.connections(walks, &connections, &PowerHeuristic, uniforms, |found| {
                    let Some(look) = &looks[found.length] else { return };
                    let (other, response) = look.other;
                    let [value, alone] = [found.value, found.alone].map(|v| v * response);
                    record(by(found.length, found.first), other, value, alone);
                });
            }
        }
    }
}

/// Bidirectional path tracing for a kind of scene.
pub type BidirectionalTracer<'s, K = Everything> = Kernel<'s, K, Bidirectional>;
