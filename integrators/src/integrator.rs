//! What an integrator is to the renderer: an estimator of pixels, for every kind of scene.

use aether_core::estimator::Contribution;
use aether_core::prelude::Vec2;
use aether_core::{RandomSequence, Strategy, UniformSource};
use glam::Vec3;

use crate::integrand::Radiance;
use crate::kind::{NotCovered, SceneKind};
use crate::render::{AnyKernel, Layer, Splats, Technique, Worker};
use crate::scene::{Film, Filter, SamplerKind, Scene};
use crate::strategies::{Aim, Pixel};
use crate::uniforms::Uniforms;
use crate::vertex::SceneVertex;
use crate::world::World;

/// A light transport algorithm with its settings, written once for all kinds of scenes.
pub trait Integrator: Send + Sync {
    /// What one thread reuses from sample to sample: the arena of paths, what an estimator remembers.
    type Scratch<'a, K: SceneKind>
    where
        Self: 'a;

    /// Whether samples contribute to other pixels than their own.
    const SPLATS: bool = false;

    /// Whether what samples find counts for all pixels that see it: they say where on the film they lie
    /// ([`Received::begin_with`]), to be shared among the pixels whose filters reach that.
    const SHARES: bool = false;

    /// A new scratch object.
    fn scratch<'a, K: SceneKind>(&'a self, world: &'a World<'a, K>) -> Self::Scratch<'a, K>;

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

    /// Whether what the sample carries is shared among the pixels that see its film point.
    pub fn is_shared(&self) -> bool {
        self.splats.is_shared
    }

    /// How a camera path is to be made that finds nothing which others find too: for its pixel, or for all that see its film
    /// point.
    pub fn aim(&self) -> Aim {
        if self.is_shared() { Aim::Image(self.pixel) } else { Aim::Pixel(self.pixel) }
    }

    /// The sample lies where a camera path begins that is so made. What the path carries is to be given times what is
    /// returned.
    pub fn begin_with<K: SceneKind, S: Strategy<SceneVertex<K>>>(
        &mut self,
        radiance: &Radiance<'_, '_, K>,
        camera: &RandomSequence<'_, SceneVertex<K>, S>,
    ) -> f32 {
        if !self.is_shared() {
            return radiance.response(self.pixel, camera);
        }
        self.begin_for_all(radiance, camera)
    }

    /// The same where a camera path is made for all pixels that see its film point ([`Aim::Image`]), whether it is shared among
    /// them or not.
    pub fn begin_for_all<K: SceneKind, S: Strategy<SceneVertex<K>>>(
        &mut self,
        radiance: &Radiance<'_, '_, K>,
        camera: &RandomSequence<'_, SceneVertex<K>, S>,
    ) -> f32 {
        let own = radiance.own_film_point(self.pixel, camera);
        own.map_or(0.0, |film| self.begin_at(radiance.world(), film))
    }

    /// The sample lies at a film point, and is made for all pixels that see it ([`Aim::Image`]): what it
    /// carries is to be given times what is returned, Σ_j |f_j|, or, if it is not shared, what it counts for its own pixel.
    pub fn begin_at<K: SceneKind>(&mut self, world: &World<'_, K>, film: Vec2<f32>) -> f32 {
        let Some(shares) = self.splats.lie() else { return world.counts_alone(self.pixel, film) };
        world.share(shares, self.pixel, film);
        shares.total()
    }

    /// Adds what a technique contributes by the sample's own film point: by its weight, and what it would contribute
    /// alone.
    pub fn add_own(&mut self, technique: Technique, value: Vec3, alone: Vec3) {
        self.own += value;
        let (pixel, values) = (self.pixel, [value, alone].map(|v| v.to_array()));
        self.splats.share_by(technique, pixel, values);
    }

    /// Adds to a pixel what a technique contributes: by its weight, and what it would contribute alone.
    pub fn add_by(&mut self, technique: Technique, receiver: Pixel, value: Vec3, alone: Vec3) {
        self.add(receiver, value);
        self.splats.add_by(technique, receiver, [value, alone].map(|v| v.to_array()));
    }

    /// Adds to each pixel that sees a film point what it receives of what a technique contributes there: by its weight, and
    /// what it would contribute alone.
    pub fn add_at(
        &mut self,
        film: &Film,
        point: Vec2<f32>,
        technique: Technique,
        [value, alone]: [Vec3; 2],
    ) {
        // Mostly there is one that has all of it.
        if let Some(receiver) = film.only_receiver(point) {
            return self.add_by(technique, receiver, value, alone);
        }
        for (receiver, response) in film.receivers(point) {
            self.add_by(technique, receiver, value * response, alone * response);
        }
    }

    /// Adds what a technique has found: to all pixels that see its path, if that is not seen where the sample lies, and
    /// otherwise to the sample, which `counts` what beginning with it has returned.
    pub fn add_found<K: SceneKind, S: Strategy<SceneVertex<K>>>(
        &mut self,
        radiance: &Radiance<'_, '_, K>,
        (technique, is_elsewhere): (Technique, bool),
        found: &Contribution<'_, SceneVertex<K>, S, Vec3>,
        counts: f32,
    ) {
        if !is_elsewhere {
            self.add_own(technique, found.value * counts, found.alone * counts);
        } else if let Some(point) = radiance.film_point(&found.path) {
            self.add_at(&radiance.world().scene.film, point, technique, [found.value, found.alone]);
        }
    }

    /// Has nothing of the sample count, as the render is cancelled before it is complete.
    pub fn give_up(&mut self) {
        self.splats.give_up();
    }

    /// Adds to its own pixel of a layer.
    pub fn add_to(&mut self, layer: Layer, value: Vec3) {
        self.splats.add_to(layer, self.pixel, value.to_array());
    }

    /// Adds to a pixel.
    pub fn add(&mut self, receiver: Pixel, value: Vec3) {
        if receiver == self.pixel && !self.is_shared() {
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
    let film = &world.scene.film;
    Box::new(move |pixel, sample, splats| {
        let mut uniforms = Uniforms::of_pixel(sampler, seed, pixel, film, sample);
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

    fn brightness_exponent(&self) -> i32 {
        self.world.scene.brightness_exponent()
    }

    fn filter(&self) -> Option<Filter> {
        I::SHARES.then_some(self.world.scene.film.filter)
    }
}
