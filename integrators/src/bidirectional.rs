//! Bidirectional path tracing (Aether 2017, Figure 6; Veach 1997, chapter 10).
//!
//! A path of n vertices can be made in as many ways as there are splits of it into a piece from the camera
//! and one from a light. What one finds counts for all pixels that see it: the camera's techniques have the density of
//! the film points of all pixels, and the technique that connects light paths to the camera gets a sample from every light path of
//! the image, so that weights are the same for all pixels. A sample may have several
//! light paths: then what needs one has so many samples.

use aether_core::estimator::{Connections, Techniques};
use aether_core::prelude::Vec2;
use aether_core::{PowerHeuristic, UniformSource};
use glam::Vec3;

use crate::emission::LightStrategies;
use crate::integrator::{Integrator, Kernel, Received};
use crate::kind::{Everything, SceneKind};
use crate::path::PathSettings;
use crate::render::{Splats, Technique};
use crate::strategies::{Aim, Pixel, sample_light};
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
    techniques: Techniques<f32, PowerHeuristic>,
    /// Where the eye sees the light path, by the number of vertices of the path that joins both.
    films: Vec<Option<Vec2<f32>>>,
}

/// What a technique has found.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// The technique.
    pub technique: Technique,
    /// The film point, in pixels of the image, where it is seen: a pixel receives it times its filter there.
    pub film: Vec2<f32>,
    /// Whether that is the film point of the camera path.
    pub is_own: bool,
    /// What arrives there.
    pub value: Vec3,
    /// What would arrive if there were no other technique.
    pub alone: Vec3,
}

impl Integrator for Bidirectional {
    type Scratch<'a, K: SceneKind> = BidirectionalScratch<'a, K>;
    const SPLATS: bool = true;
    const SHARES: bool = true;

    fn scratch<'a, K: SceneKind>(&'a self, world: &'a World<'a, K>) -> Self::Scratch<'a, K> {
        let techniques = Techniques::new(PowerHeuristic);
        BidirectionalScratch { paths: Scratch::new(world), techniques, films: Vec::new() }
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
        let mut counts = None;
        self.paths(world, scratch, uniforms, pixel, |found| {
            let Found { technique, film, is_own, value, alone } = found;
            if is_own {
                let counts = *counts.get_or_insert_with(|| received.begin_at(world, film));
                received.add_own(technique, value * counts, alone * counts);
            } else {
                received.add_at(&world.scene.film, film, technique, [value, alone]);
            }
        });
        received.own
    }
}

impl Bidirectional {
    /// One sample of a pixel: calls `record` with what is found.
    pub fn paths<'a, K: SceneKind>(
        &self,
        world: &'a World<'a, K>,
        scratch: &mut BidirectionalScratch<'a, K>,
        uniforms: &mut impl UniformSource<f32>,
        pixel: Pixel,
        mut record: impl FnMut(Found),
    ) {
        let BidirectionalScratch { paths: Scratch { arena, estimator }, techniques, films } =
            scratch;
        arena.clear();
        let rr = self.path.rr_depth;
        let longest = self.path.most_vertices();
        let seen_by = camera_path(world, arena, uniforms, Aim::Image(pixel), (longest, rr));
        let radiance = estimator.integrand();
        let own = radiance.own_film_point(pixel, &seen_by);
        let count = self.light_paths.max(1) as usize;
        let fewest = self.fewest_vertices.max(2 + usize::from(self.path.hide_emitters));
        let ending = sample_light(world).into();
        for number in 0..count {
            uniforms.piece(number as u32);
            let mut camera = seen_by;
            let mut light = light_path(world, arena, uniforms, (longest.saturating_sub(1), rr));
            // What has ended might have gone on: it remains a technique.
            let total = (camera.len() + light.len()).min(longest);
            // That from the light was made last, and need not be copied to go on.
            extend(&mut light, world, (total, rr));
            extend(&mut camera, world, (total, rr));
            techniques.reach(total, |length, first| self.samples(world.pixels(), length, first));
            let eye = camera.vertex(0);
            films.clear();
            films.extend((0..total + 1).map(|length| {
                let seen = light.vertex(length.checked_sub(2)?)?;
                let film = radiance.sight(eye.as_ref()?, &seen)?.film;
                world.scene.film.is_near(film).then_some(film)
            }));
            let film = |length: usize, first: usize| if first == 1 { films[length] } else { own };
            let connections = Connections {
                lengths: fewest..=total,
                ending: Some(&ending),
                fewest_ending: 3,
                techniques,
                is_drawn: |length, first| {
                    film(length, first).is_some() && (first < length || number == 0)
                },
            };
            estimator.connections([&camera, &light], &connections, uniforms, |it| {
                let Some(film) = film(it.length, it.first) else { return };
                // There is one sample where several are weighed.
                let counts = worth(it.length, it.first) as f32;
                let [value, alone] = [it.value, it.alone].map(|v| v * counts);
                let technique = Technique::edge(it.first, it.length - it.first);
                record(Found { technique, film, is_own: it.first > 1, value, alone });
            });
        }
        uniforms.piece(0);
    }

    /// As how many samples of an image with so many pixels a technique counts that makes paths of so many vertices, of
    /// which the first ones, so many, are of the camera.
    fn samples(&self, pixels: usize, length: usize, first: usize) -> usize {
        let count = self.light_paths.max(1) as usize;
        match first {
            0 => 0,
            _ if !self.path.techniques.has(Technique::edge(first, length - first)) => 0,
            1 => count * pixels,
            _ if first == length => 1,
            _ => count * worth(length, first),
        }
    }
}

/// Bidirectional path tracing for a kind of scene.
pub type BidirectionalTracer<'s, K = Everything> = Kernel<'s, K, Bidirectional>;
