//! The scenes of `tests/scenes`, their reference images, and renders of them.

use std::path::{Path, PathBuf};

use aether_core::{Conditional, Drawn, PathView, Reads, Strategy, UniformSource, strategies};
use integrators::image::RgbImage;
use integrators::image::block_test::{BlockScore, BlockTestOptions, block_scores};
use integrators::image::exr::Exr;
use integrators::integrator::Received;
use integrators::kind::DiffuseRooms;
use integrators::path::{PathSettings, Techniques, trace};
use integrators::render::{AnyKernel, Film, Splats, Worker};
use integrators::scene::{Bsdf, Filter, SamplerKind, Scene};
use integrators::strategies::{
    Pixel, SampleBsdf, SampleCamera, SampleCameraDirection, SampleLight, sample_bsdf, sample_light,
};
use integrators::subpaths::Scratch;
use integrators::uniforms::Uniforms;
use integrators::vertex::SceneVertex;
use integrators::world::World;

pub use crate::common::{film, path_tracer, settings};

/// The vertices of scenes of matte surfaces.
type Vertex = SceneVertex<DiffuseRooms>;

fn directory() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests")
}

/// Loads `tests/scenes/NAME.xml`.
///
/// # Panics
/// If it cannot be loaded.
pub fn scene(name: &str) -> Scene {
    let path = directory().join("scenes").join(name).with_extension("xml");
    Scene::load(&path, &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// What a render of a scene should converge to, with the variance of the mean of each pixel.
#[derive(Clone, Debug)]
pub struct Reference {
    /// The expected image.
    pub rgb: RgbImage,
    /// Its uncertainty; zero where the answer is known exactly.
    pub variance: RgbImage,
}

impl Reference {
    /// The stored image of a scene.
    ///
    /// # Panics
    /// If it cannot be read or has no variance.
    pub fn stored(name: &str) -> Self {
        let path = directory().join("reference/renders").join(name).with_extension("exr");
        let exr = Exr::read(Path::new(&path)).unwrap_or_else(|error| panic!("{error}"));
        let variance = exr.variance.unwrap_or_else(|| panic!("{name} has no variance"));
        Reference { rgb: exr.rgb, variance }
    }
}

/// Renders with the path tracer as the program does.
pub fn path_traced(
    name: &str,
    sampler: SamplerKind,
    samples: u32,
    threads: Option<usize>,
    seed: u64,
) -> Film {
    let mut scene = scene(name);
    scene.sampler.kind = sampler;
    if name.ends_with("-mitsuba3") {
        scene.bsdfs.iter_mut().for_each(Bsdf::lose_energy);
    }
    film(&*path_tracer(&scene, seed), &scene, samples, threads)
}

/// Scores a render: each block of 8x8 pixels, the mean of the image, and a mean to which blocks
/// contribute the more the less noise they have, in three channels each.
///
/// An error that is alike everywhere shows in the means long before it shows in a block; and unlike
/// the plain mean, the weighted one is not drowned by a few noisy blocks at the rim of a light.
///
/// # Panics
/// If the sizes differ or a pixel has fewer than two samples.
pub fn scores(film: &Film, reference: &Reference) -> Vec<BlockScore> {
    let image = film.image();
    let mut variance = film.variance().expect("two samples a pixel");
    let correlation = film.correlation() as f32;
    variance.pixels_mut().iter_mut().for_each(|pixel| *pixel = pixel.map(|v| v * correlation));
    let Reference { rgb, variance: noise } = reference;
    let blocks = score([&image, &variance, rgb, noise], 8);
    let mean = score([&image, &variance, rgb, noise], image.width().max(image.height()));
    let black = RgbImage::filled(image.width(), image.height(), [0.0; 3]);
    // Weights come from the reference alone: they must not depend on what they weigh.
    let quality = score([rgb, noise, &black, &black], 8);
    [blocks.clone(), mean, weighted_mean(&blocks, &quality)].concat()
}

fn score([image, variance, reference, noise]: [&RgbImage; 4], block: usize) -> Vec<BlockScore> {
    let options = BlockTestOptions { block, ..BlockTestOptions::default() };
    block_scores(image, variance, reference, noise, &options)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// The mean of blocks in units of the reference's standard error, as the only pixel of an image.
fn weighted_mean(blocks: &[BlockScore], quality: &[BlockScore]) -> Vec<BlockScore> {
    let [mut mean, mut variance, mut reference] = [[0.0; 3]; 3];
    for (block, quality) in blocks.iter().zip(quality) {
        // Blocks without noise, black or filled by a light, say nothing about densities.
        if block.z == 0.0 || quality.mean == 0.0 {
            continue;
        }
        let weight = quality.z / quality.mean;
        let error = (block.mean - block.reference_mean) / block.z;
        mean[block.channel] += weight * block.mean;
        reference[block.channel] += weight * block.reference_mean;
        variance[block.channel] += (weight * error).powi(2);
    }
    let pixel = |value: [f64; 3]| RgbImage::filled(1, 1, value.map(|v| v as f32));
    score([&pixel(mean), &pixel(variance), &pixel(reference), &pixel([0.0; 3])], 1)
}

/// A strategy whose densities are wrong by a constant factor.
#[derive(Clone, Copy, Debug)]
pub struct Misjudged<S> {
    /// What draws the vertices.
    pub strategy: S,
    /// By what its densities are multiplied.
    pub factor: f32,
}

impl<S: Strategy<Vertex>> Strategy<Vertex> for Misjudged<S> {
    fn sample<U: UniformSource<f32> + ?Sized>(
        &self,
        path: PathView<'_, Vertex>,
        uniforms: &mut U,
    ) -> Option<Drawn<Vertex>> {
        let drawn = self.strategy.sample(path, uniforms)?;
        Some(Drawn { value: drawn.value.map(|p| p * self.factor), ..drawn })
    }

    fn pdf(&self, path: PathView<'_, Vertex>, target: &Vertex) -> Conditional<f32> {
        let right = self.strategy.pdf(path, target);
        Conditional { value: right.value * self.factor, ..right }
    }

    fn reads(&self) -> Reads {
        self.strategy.reads()
    }

    fn same(&self, other: &Self) -> bool {
        self.factor == other.factor && self.strategy.same(&other.strategy)
    }
}

strategies! {
    /// The strategies of the path tracer, two of them with densities that may be wrong.
    #[derive(Clone)]
    pub enum MisjudgedStrategies<'a> for Vertex {
        /// The pinhole.
        Camera(SampleCamera<'a, 'a, DiffuseRooms>),
        /// What the camera sees.
        CameraDirection(SampleCameraDirection<'a, 'a, DiffuseRooms>),
        /// Scattering.
        Bsdf(Misjudged<SampleBsdf<'a, 'a, DiffuseRooms>>),
        /// Next-event estimation.
        Light(Misjudged<SampleLight<'a, 'a, DiffuseRooms>>),
    }
}

/// The path tracer with factors on the densities of scattering and of light sampling. With factors
/// of one it is the path tracer.
pub struct MisjudgingTracer<'s> {
    world: World<'s, DiffuseRooms>,
    settings: PathSettings,
    seed: u64,
    /// The error of the density of scattering.
    pub scatter_factor: f32,
    /// The error of the density of light sampling.
    pub light_factor: f32,
}

impl<'s> MisjudgingTracer<'s> {
    /// A tracer of independent samples, right until a factor is changed.
    ///
    /// # Panics
    /// If the scene has other than matte surfaces.
    pub fn new(scene: &'s Scene, seed: u64) -> Self {
        MisjudgingTracer {
            world: World::new(scene).expect("matte surfaces"),
            settings: settings(scene),
            seed,
            scatter_factor: 1.0,
            light_factor: 1.0,
        }
    }

    fn sample<'a>(
        &'a self,
        scratch: &mut Scratch<'a, DiffuseRooms, MisjudgedStrategies<'a>>,
        pixel: Pixel,
        sample: u32,
        splats: &mut Splats,
    ) -> [f32; 3] {
        let world = &self.world;
        let scatter = sample_bsdf(world, self.settings.rr_depth, None);
        let light = Misjudged { strategy: sample_light(world), factor: self.light_factor };
        let scatter = Misjudged { strategy: scatter, factor: self.scatter_factor };
        let techniques = Techniques { scatter: scatter.into(), endings: &[&[], &[light.into()]] };
        let (kind, film) = (SamplerKind::Independent, &world.scene.film);
        let mut uniforms = Uniforms::of_pixel(kind, self.seed, pixel, film, sample);
        let mut received = Received::new(pixel, splats);
        trace(world, &self.settings, &techniques, scratch, &mut uniforms, &mut received);
        received.own.to_array()
    }
}

impl AnyKernel for MisjudgingTracer<'_> {
    fn worker(&self) -> Worker<'_> {
        let mut scratch = Scratch::new(&self.world);
        Box::new(move |pixel, sample, splats| self.sample(&mut scratch, pixel, sample, splats))
    }

    fn filter(&self) -> Option<Filter> {
        Some(self.world.scene.film.filter)
    }

    fn brightness_exponent(&self) -> i32 {
        self.world.scene.brightness_exponent()
    }
}
