//! Scenes that are stiff or extreme, with answers that are known or that must not change.

#[path = "../common/mod.rs"]
mod common;
mod geometry;
mod grazing;
mod lenses;
mod lights;
mod long_paths;
mod moved;
mod own_samples;

use std::path::Path;

use integrators::algorithm::Algorithm;
use integrators::kind;
use integrators::render::Film;
use integrators::scene::{SamplerKind, Scene};

/// A scene of these elements, seen through a box filter by the camera of a `<sensor>`'s insides.
fn scene(camera: &str, size: u32, depth: i32, elements: &str) -> Scene {
    scene_through("perspective", camera, size, depth, elements)
}

/// The same with another type of sensor.
fn scene_through(sensor: &str, camera: &str, size: u32, depth: i32, elements: &str) -> Scene {
    let text = format!(
        r#"<scene version="3.0.0">
            <integrator type="path">
                <integer name="max_depth" value="{depth}"/>
                <integer name="rr_depth" value="100000"/>
            </integrator>
            <sensor type="{sensor}">{camera}
                <film type="hdrfilm">
                    <integer name="width" value="{size}"/><integer name="height" value="{size}"/>
                    <rfilter type="box"/>
                </film>
            </sensor>{elements}</scene>"#
    );
    Scene::from_str(&text, Path::new("."), &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// A camera at `origin` that looks at `target`.
fn camera(origin: [f64; 3], target: [f64; 3], fov: f64) -> String {
    let list = |v: [f64; 3]| v.map(|x| x.to_string()).join(",");
    let up = if origin[0] == target[0] && origin[1] == target[1] { "1,0,0" } else { "0,0,1" };
    let (origin, target) = (list(origin), list(target));
    format!(
        r#"<float name="fov" value="{fov}"/><transform name="to_world">
            <lookat origin="{origin}" target="{target}" up="{up}"/></transform>"#
    )
}

fn rendered(scene: &mut Scene, samples: u32, seed: u64) -> Film {
    scene.sampler.kind = SamplerKind::Independent;
    common::film(&*common::path_tracer(scene, seed), scene, samples, None)
}

/// A render by an integrator, of the smallest kind that covers the scene.
fn rendered_by(algorithm: Algorithm, scene: &Scene, samples: u32, seed: u64) -> Film {
    let kernel = algorithm.kernel(kind::smallest(scene), scene, scene.sampler.seeded(seed));
    let kernel = kernel.expect("a precompiled kind").expect("a kind that covers the scene");
    common::film(&*kernel, scene, samples, None)
}

/// By how many standard errors the mean of a film is off from a number, and its relative error. The
/// number counts as met within rounding of 1e-5, as images do.
fn z_of_mean(film: &Film, expected: f64) -> (f64, f64) {
    let pixels = film.pixels();
    let (mut mean, mut variance) = (0.0, 0.0);
    for pixel in pixels {
        mean += pixel.mean()[0] / pixels.len() as f64;
        let of_pixel = pixel.variance_of_mean().expect("two samples a pixel")[0];
        variance += of_pixel / (pixels.len() as f64).powi(2);
    }
    let off = mean - expected;
    if off == 0.0 {
        return (0.0, 0.0);
    }
    ((off / (variance + (1e-5 * expected).powi(2)).sqrt()), off / expected)
}

/// The chance that one of these comparisons fails for no reason is 6e-5: two-sided, 4 standard errors.
const LIMIT: f64 = 4.0;

fn assert_mean(what: &str, film: &Film, expected: f64) {
    let (z, error) = z_of_mean(film, expected);
    println!("{what}: z = {z:.2}, relative error {error:.1e}");
    assert!(z.abs() < LIMIT, "{what}: {z:.2} standard errors off, relative error {error:.1e}");
}
