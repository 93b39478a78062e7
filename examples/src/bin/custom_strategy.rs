//! What you learn here: how to put a scattering strategy of your own into the renderer's path
//! tracer, from outside its crate.
//!
//! The strategy is for rooms that are lit from the ceiling: with some probability it looks up
//! instead of sampling the material, which it leaves to the renderer's own strategy. That is a mixture
//! of two densities, each through a ray cast: every direction could have come from either. The
//! density of the mixture is derived from the sampling code, and so are the weights against light
//! sampling.
//!
//! The program names the kind of scenes that it is for. Nothing else is compiled into it: no glass, no sky.
//!
//! Renders the Cornell box twice, with the renderer's scattering and with the new one, and compares.

use std::path::Path;

use aether_core::prelude::*;
use aether_core::{PathView, Pcg32, coin, strategies};
use integrators::image::exr::Exr;
use integrators::integrator::Received;
use integrators::kind::NotCovered;
use integrators::path::{PathSettings, PathTracer, Techniques, trace};
use integrators::render::{AnyKernel, Budget, Film, RenderSettings, Splats, Worker, render};
use integrators::samplers::rotate;
use integrators::scene::Scene;
use integrators::scene_kind;
use integrators::strategies::{
    Pixel, SampleCamera, SampleCameraDirection, SampleLight, sample_bsdf, sample_light,
};
use integrators::subpaths::Scratch;
use integrators::vertex::{SceneVertex, Surface};
use integrators::world::World;

/// Directions about +z, distributed as a power of the cosine.
#[sampler]
fn power_cosine(u: [Uniform; 2], exponent: f64) -> Direction {
    let z = (1.0 - u[0]).powf(1.0 / (exponent + 1.0));
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), z)
}

scene_kind! {
    /// Rooms of matte walls, with lamps.
    struct Rooms: Diffuse, Area;
}

/// Looks up, and finds what the ray meets.
#[strategy]
fn look_up(path: &PathView<SceneVertex<Rooms>>, world: &World<'_, Rooms>) -> SceneVertex<Rooms> {
    let here = given(path.last());
    let local = draw(power_cosine(8.0f32));
    let w = rotate(Frame::around(Direction::new(0.0, 1.0, 0.0))).apply(&local);
    let hit: Surface<Rooms> = constant(world.hit(&here, &w));
    let point = hit.seen_from(here.position).apply(&w);
    SceneVertex::hit(hit, point)
}

/// Scatters like the material or looks up.
#[strategy]
fn scatter_or_look_up(
    path: &PathView<SceneVertex<Rooms>>,
    world: &World<'_, Rooms>,
    rr_depth: u32,
    upwards: f32,
) -> SceneVertex<Rooms> {
    if choose(coin(upwards)) {
        delegate(look_up(world))
    } else {
        delegate(sample_bsdf(world, rr_depth, None))
    }
}

strategies! {
    /// What the paths of this program are made of.
    #[derive(Clone)]
    enum Strategies<'a> for SceneVertex<Rooms> {
        Camera(SampleCamera<'a, 'a, Rooms>),
        CameraDirection(SampleCameraDirection<'a, 'a, Rooms>),
        Scatter(ScatterOrLookUp<'a, 'a>),
        Light(SampleLight<'a, 'a, Rooms>),
    }
}

/// The path tracer with the new strategy, as the render engine calls it.
struct Upward<'s> {
    world: World<'s, Rooms>,
    settings: PathSettings,
    seed: u64,
}

impl Upward<'_> {
    fn sample<'a>(
        &'a self,
        scratch: &mut Scratch<'a, Rooms, Strategies<'a>>,
        (x, y): Pixel,
        sample: u32,
        splats: &mut Splats,
    ) -> [f32; 3] {
        let world = &self.world;
        let scatter = scatter_or_look_up(world, self.settings.rr_depth, 0.3).into();
        let techniques = Techniques { scatter, endings: &[&[], &[sample_light(world).into()]] };
        let stream = u64::from(y) * u64::from(world.scene.film.width) + u64::from(x);
        let mut uniforms = Pcg32::new(self.seed, stream, u64::from(sample));
        let mut received = Received::new((x, y), splats);
        trace(world, &self.settings, &techniques, scratch, &mut uniforms, &mut received);
        received.own.to_array()
    }
}

impl AnyKernel for Upward<'_> {
    fn worker(&self) -> Worker<'_> {
        let mut scratch = Scratch::new(&self.world);
        Box::new(move |pixel, sample, splats| self.sample(&mut scratch, pixel, sample, splats))
    }
}

/// Renders the scene with the renderer's strategies, and with the new one.
fn both(scene: &Scene, samples: u32) -> Result<[Film; 2], NotCovered> {
    let settings = PathSettings::new(scene);
    let standard = PathTracer::<Rooms>::new(scene, settings, 1)?;
    let upward = Upward { world: World::new(scene)?, settings, seed: 2 };
    let size = (scene.film.width, scene.film.height);
    let effort = RenderSettings::new(size, Budget::Samples(samples));
    Ok([render(&standard, &effort, &()).film, render(&upward, &effort, &()).film])
}

/// The mean of all pixels and channels, and its standard error.
fn mean_and_error(film: &Film) -> (f64, f64) {
    let average = |values: &dyn Fn(usize) -> [f64; 3]| {
        let count = film.pixels().len();
        (0..count).map(|i| values(i).iter().sum::<f64>() / 3.0).sum::<f64>() / count as f64
    };
    let mean = average(&|i| film.pixels()[i].mean());
    // The channels of a sample share their noise: their errors add up at worst.
    let variance = average(&|i| film.pixels()[i].variance_of_mean().unwrap_or_default());
    (mean, (variance / film.pixels().len() as f64).sqrt())
}

fn cornell_box(side: u32) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box.xml");
    let side = side.to_string();
    let defines = [("width", side.clone()), ("height", side)].map(|(n, v)| (n.to_owned(), v));
    Scene::load(&path, &defines).unwrap_or_else(|error| panic!("{error}"))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = cornell_box(128);
    let [standard, upward] = both(&scene, 32)?;
    for (name, film) in [("standard", &standard), ("looking up", &upward)] {
        let (mean, error) = mean_and_error(film);
        println!("{name:<12} mean {mean:.4} ± {error:.4}");
    }
    let output = Path::new("custom-strategy.exr");
    let exr = Exr {
        rgb: upward.image(),
        variance: upward.variance(),
        layers: Default::default(),
        attributes: Default::default(),
    };
    exr.write(output)?;
    println!("wrote {}", output.display());
    Ok(())
}

#[test]
fn the_strategy_does_not_change_the_expected_image() {
    let [standard, upward] = both(&cornell_box(32), 64).unwrap().map(|film| mean_and_error(&film));
    let error = standard.1.hypot(upward.1);
    assert!((standard.0 - upward.0).abs() < 4.0 * error, "{standard:?}, {upward:?}");
    assert!(error < 0.02 * standard.0, "too few samples to tell: {standard:?}, {upward:?}");
}
