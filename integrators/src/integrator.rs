//! What an integrator is to the renderer: an estimator of pixels, for every kind of scene.

use aether_core::estimator::Contribution;
use aether_core::{UniformSource, Vertex};
use glam::Vec3;

use crate::kind::{NotCovered, SceneKind};
use crate::render::{AnyKernel, Layer, Splats, Technique, Worker};
use crate::scene::{SamplerKind, Scene};
use crate::strategies::Pixel;
use crate::uniforms::Uniforms;
use crate::world::World;

/// A light transport algorithm with its settings, written once for all kinds of scenes.
pub trait Integrator: Send + Sync {
    /// What one thread reuses from sample to sample: the arena of paths, what an estimator remembers.
    type Scratch<'a, K: SceneKind>
    where
        Self: 'a;

    /// Whether samples contribute to other pixels than their own.
    const SPLATS: bool = false;

    /// A new scratch object.
    fn scratch<'a, K: SceneKind>(&'a self, world: &'a World<'a, K>) -> Self::Scratch<'a, K>;

    /// Called before the samples with a number, of one pixel or of many: makes what they have in common.
    fn begin<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
        scratch: &mut Self::Scratch<'a, K>,
        seed: u64,
        sample: u32,
    ) {
        let _ = (world, scratch, seed, sample);
    }

    /// One estimate of the linear Rec. 709 value of a pixel. What it contributes to others goes to
    /// `splats`; the sum over all pixels' samples with the same number is what counts.
    fn sample<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
        scratch: &mut Self::Scratch<'a, K>,
        uniforms: &mut impl UniformSource<f32>,
        pixel: Pixel,
        splats: &mut Splats,
    ) -> Vec3;
}

/// What a sample adds to its own pixel and to others.
pub struct Received<'s> {
    pixel: Pixel,
    /// What its own pixel gets.
    pub own: Vec3,
    splats: &'s mut Splats,
}

impl<'s> Received<'s> {
    /// Nothing so far, of a sample of a pixel.
    pub fn new(pixel: Pixel, splats: &'s mut Splats) -> Self {
        Received { pixel, own: Vec3::ZERO, splats }
    }

    /// The pixel that the sample was made for.
    pub fn pixel(&self) -> Pixel {
        self.pixel
    }

    /// Adds to a pixel what a path that a technique has found contributes, with the pixel's response to it.
    pub fn add_found<V: Vertex, S>(
        &mut self,
        technique: Technique,
        receiver: Pixel,
        found: &Contribution<'_, V, S, Vec3>,
        response: f32,
    ) {
        self.add_by(technique, receiver, found.value * response, found.alone * response);
    }

    /// Adds to a pixel what a technique contributes: by its weight, and what it would contribute alone.
    pub fn add_by(&mut self, technique: Technique, receiver: Pixel, value: Vec3, alone: Vec3) {
        self.add(receiver, value);
        self.splats.add_by(technique, receiver, [value, alone].map(|v| v.to_array()));
    }

    /// Adds to its own pixel of a layer.
    pub fn add_to(&mut self, layer: Layer, value: Vec3) {
        self.splats.add_to(layer, self.pixel, value.to_array());
    }

    /// Adds to a pixel.
    pub fn add(&mut self, receiver: Pixel, value: Vec3) {
        if receiver == self.pixel {
            self.own += value;
        } else {
            self.splats.add(receiver, value.to_array());
        }
    }
}

/// An integrator with a scene, as the render engine calls it: one sample of one pixel at a time.
pub struct Kernel<'s, K: SceneKind, I> {
    world: World<'s, K>,
    integrator: I,
    seed: u64,
    sampler: SamplerKind,
}

impl<'s, K: SceneKind, I: Integrator> Kernel<'s, K, I> {
    /// An integrator for a scene, with uniforms of the kind that the scene asks for; the same seed gives the same
    /// image.
    ///
    /// # Errors
    /// If the scene needs what the kind leaves out.
    pub fn new(scene: &'s Scene, integrator: I, seed: u64) -> Result<Self, NotCovered> {
        Ok(Kernel { world: World::new(scene)?, integrator, seed, sampler: scene.sampler.kind })
    }

    /// The same with uniforms of another kind.
    pub fn sampled_by(self, sampler: SamplerKind) -> Self {
        Kernel { sampler, ..self }
    }
}

/// What samples pixels by an integrator, with uniforms that the seed, the pixel, the number of the sample and the kind
/// of sampler determine.
pub(crate) fn worker<'a, K: SceneKind, I: Integrator>(
    world: &'a World<'_, K>,
    integrator: &'a I,
    seed: u64,
    sampler: SamplerKind,
) -> Worker<'a> {
    let mut scratch = integrator.scratch(world);
    let width = u64::from(world.scene.film.width);
    let mut begun = None;
    Box::new(move |pixel, sample, splats| {
        if begun != Some(sample) {
            integrator.begin(world, &mut scratch, seed, sample);
            begun = Some(sample);
        }
        let stream = u64::from(pixel.1) * width + u64::from(pixel.0);
        let mut uniforms = Uniforms::new(sampler, seed, stream, sample);
        let value = integrator.sample(world, &mut scratch, &mut uniforms, pixel, splats);
        value.to_array()
    })
}

impl<K: SceneKind, I: Integrator> AnyKernel for Kernel<'_, K, I> {
    fn worker(&self) -> Worker<'_> {
        worker(&self.world, &self.integrator, self.seed, self.sampler)
    }

    fn splats(&self) -> bool {
        I::SPLATS
    }
}
