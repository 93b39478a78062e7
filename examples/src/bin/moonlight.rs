//! What you learn here: how to add a technique of your own to the path tracer, from outside its crate, that makes
//! more than one vertex.
//!
//! At night a path has to find the moon before it can find the sun. Scattering hardly ever finds a thing so
//! small, and looking for lights finds the sun from the moon only. The new technique goes to the moon and then to
//! the sun. It is weighted against the others without anything being said about its density.
//!
//! Renders the scene with the renderer's techniques, and with the new one among them, and compares.

use std::path::Path;

use aether_core::prelude::*;
use aether_core::{PathView, Pcg32, strategies};
use glam::Vec3 as Vector;
use integrators::image::exr::Exr;
use integrators::integrator::Received;
use integrators::kind::NotCovered;
use integrators::path::{PathSettings, PathTracer, Techniques, trace};
use integrators::render::{AnyKernel, Budget, Film, RenderSettings, Worker, render};
use integrators::samplers::{rotate, uniform_cone};
use integrators::scene::{Primitive, Scene};
use integrators::scene_kind;
use integrators::seen::cone_of;
use integrators::strategies::{
    SampleBsdf, SampleCamera, SampleCameraDirection, SampleLight, sample_bsdf, sample_light,
};
use integrators::subpaths::Scratch;
use integrators::vertex::{SceneVertex, Surface};
use integrators::world::World;

scene_kind! {
    /// Matte surfaces and point lights.
    struct Night: Diffuse, Point;
}

/// Looks at a ball, and finds what is there.
#[strategy]
fn sample_moon(
    path: &PathView<SceneVertex<Night>>,
    world: &World<'_, Night>,
    centre: Vector,
    radius: f32,
) -> SceneVertex<Night> {
    let here = given(path.last());
    let (axis, depth) = given(cone_of(here.position, centre, radius));
    let directions = given(uniform_cone(depth).ok());
    let local = draw(directions);
    let w = rotate(Frame::around(axis)).apply(&local);
    let seen: Surface<Night> = constant(world.hit(&here, &w));
    let point = seen.seen_from(here.position).apply(&w);
    SceneVertex::hit(seen, point)
}

strategies! {
    /// What the paths of this program are made of.
    #[derive(Clone)]
    enum Strategies<'a> for SceneVertex<Night> {
        Camera(SampleCamera<'a, 'a, Night>),
        CameraDirection(SampleCameraDirection<'a, 'a, Night>),
        Scatter(SampleBsdf<'a, 'a, Night>),
        Light(SampleLight<'a, 'a, Night>),
        Moon(SampleMoon<'a, 'a>),
    }
}

/// The path tracer with the new technique, as the render engine calls it.
struct Moonlight<'s> {
    world: World<'s, Night>,
    settings: PathSettings,
    moon: (Vector, f32),
}

impl AnyKernel for Moonlight<'_> {
    fn worker(&self) -> Worker<'_> {
        let Moonlight { world, settings, moon: (centre, radius) } = self;
        let mut scratch = Scratch::<Night, Strategies<'_>>::new(world);
        Box::new(move |pixel, sample, splats| {
            let scatter = sample_bsdf(world, settings.rr_depth, None).into();
            let by_way_of_the_moon: [Strategies<'_>; 2] =
                [sample_moon(world, *centre, *radius).into(), sample_light(world).into()];
            let light = &by_way_of_the_moon[1..];
            let techniques = Techniques { scatter, endings: &[&[], light, &by_way_of_the_moon] };
            let stream =
                u64::from(pixel.1) * u64::from(world.scene.film.width) + u64::from(pixel.0);
            let mut uniforms = Pcg32::new(2, stream, u64::from(sample));
            let mut received = Received::new(pixel, splats);
            trace(world, settings, &techniques, &mut scratch, &mut uniforms, &mut received);
            received.own.to_array()
        })
    }
}

/// The place and the size of the ball with the name `moon`.
fn moon(scene: &Scene) -> Option<(Vector, f32)> {
    let shape = scene.shapes.iter().find(|shape| shape.name == "moon")?;
    match scene.primitives.get(shape.first_primitive as usize)? {
        Primitive::Sphere { center, radius, .. } => Some((*center, *radius)),
        _ => None,
    }
}

/// Renders the scene with the renderer's techniques, and with the new one among them.
fn both(scene: &Scene, settings: PathSettings, samples: u32) -> Result<[Film; 2], NotCovered> {
    let standard = PathTracer::<Night>::new(scene, settings, 2)?;
    let moon = moon(scene).unwrap_or_else(|| panic!("the scene has no ball with the id `moon`"));
    let moonlight = Moonlight { world: World::new(scene)?, settings, moon };
    let size = (scene.film.width, scene.film.height);
    let effort = RenderSettings::new(size, Budget::Samples(samples));
    Ok([render(&standard, &effort, &()).film, render(&moonlight, &effort, &()).film])
}

/// The mean of all pixels and channels, and its standard error.
fn mean_and_error(film: &Film) -> (f64, f64) {
    let count = film.pixels().len() as f64;
    let average = |values: &dyn Fn(usize) -> [f64; 3]| {
        (0..film.pixels().len()).map(|i| values(i).iter().sum::<f64>() / 3.0).sum::<f64>() / count
    };
    let mean = average(&|i| film.pixels()[i].mean());
    // The channels of a sample share their noise: their errors add up at worst.
    let variance = average(&|i| film.pixels()[i].variance_of_mean().unwrap_or_default());
    (mean, (variance / count).sqrt())
}

fn night(defines: &[(&str, &str)]) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/moonlit.xml");
    let defines: Vec<_> =
        defines.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect();
    Scene::load(&path, &defines).unwrap_or_else(|error| panic!("{error}"))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = night(&[]);
    let [standard, moonlight] = both(&scene, PathSettings::new(&scene), 64)?;
    for (name, film) in [("standard", &standard), ("moonlight", &moonlight)] {
        let (mean, error) = mean_and_error(film);
        println!("{name:<10} mean {mean:.5} ± {error:.5}");
        let (rgb, variance) = (film.image(), film.variance());
        let exr = Exr { rgb, variance, layers: Default::default(), attributes: Default::default() };
        let output = format!("{name}.exr");
        exr.write(Path::new(&output))?;
        integrators::image::png::write(&exr.rgb, &Path::new(&output).with_extension("png"))?;
        println!("wrote {output}");
    }
    Ok(())
}

#[test]
fn a_technique_of_ones_own_can_be_left_out() {
    let scene = night(&[("width", "32"), ("height", "18"), ("moon", "3")]);
    let rendered = |techniques: &str| {
        let techniques = techniques.parse().unwrap();
        let settings = PathSettings { techniques, ..PathSettings::new(&scene) };
        let [standard, moonlight] = both(&scene, settings, 16).unwrap();
        [standard, moonlight].map(|film| mean_and_error(&film))
    };
    // Without that of two vertices from the light, what is left is the path tracer.
    let [standard, moonlight] = rendered("0:*,1:*");
    assert_eq!(standard, moonlight);
    // Alone, it has the light of the moon.
    let [standard, moonlight] = rendered("2:*");
    assert!(standard.0 == 0.0 && moonlight.0 > 0.0);
}

#[test]
fn the_technique_does_not_change_the_expected_image() {
    // With a moon so large that scattering finds it now and then.
    let scene = night(&[("width", "32"), ("height", "18"), ("moon", "3")]);
    let [standard, moonlight] =
        both(&scene, PathSettings::new(&scene), 768).unwrap().map(|film| mean_and_error(&film));
    let error = standard.1.hypot(moonlight.1);
    assert!((standard.0 - moonlight.0).abs() < 4.0 * error, "{standard:?}, {moonlight:?}");
    assert!(error < 0.03 * standard.0, "too few samples to tell: {standard:?}, {moonlight:?}");
    assert!(moonlight.1 < 0.7 * standard.1, "{standard:?}, {moonlight:?}");
}
