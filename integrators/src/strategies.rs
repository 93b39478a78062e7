//! How light paths are extended, one vertex at a time: the strategies of the surface renderer.

use aether_core::prelude::*;
use aether_core::{PathView, coin, strategies};

use crate::samplers::*;
use crate::scene::{Filter, Primitive};
use crate::vertex::{Pinhole, SceneVertex, Surface};
use crate::world::{Light, World};

/// A pixel of the image: column and row.
pub type Pixel = (u32, u32);

/// The camera's pinhole: an atom.
#[strategy]
pub fn sample_camera(path: &PathView<SceneVertex>, world: &World<'_>) -> SceneVertex {
    let pinhole: Pinhole = constant(Some(world.pinhole()));
    SceneVertex::pinhole(pinhole)
}

/// A point of the film about the pixel's centre, distributed like the reconstruction filter, and
/// what the camera sees there.
#[strategy]
pub fn sample_camera_direction(
    path: &PathView<SceneVertex>,
    world: &World<'_>,
    pixel: Pixel,
) -> SceneVertex {
    let eye = given(path.last());
    let (x, y) = (pixel.0 as f32 + 0.5, pixel.1 as f32 + 0.5);
    let film = match world.scene.film.filter {
        Filter::Box => draw(film_box(x, y)),
        Filter::Tent { radius } => {
            let right = choose(coin(0.5f32));
            let below = choose(coin(0.5f32));
            let (rx, ry) =
                (if right { radius } else { -radius }, if below { radius } else { -radius });
            draw(film_tent(x, y, rx, ry))
        }
        Filter::Gaussian { stddev } => {
            // The corner of the filter's square lies at √2 · 4 standard deviations.
            let mass = 1.0 - (-16.0f32).exp();
            draw(film_gaussian(x, y, stddev, mass))
        }
    };
    let direction = pinhole(world.film_centre(), world.film_scale()).apply(&film);
    let w = rotate(world.camera_frame).apply(&direction);
    let hit: Surface = constant(world.cast(&eye, &w));
    let point = hit.seen_from(eye.position).apply(&w);
    SceneVertex::hit(hit, point)
}

/// Scatters at the last vertex and finds what the ray meets. From the vertex number `rr_depth` on,
/// the path may end: Russian roulette with the albedo as the probability to go on.
#[strategy]
pub fn sample_bsdf(path: &PathView<SceneVertex>, world: &World<'_>, rr_depth: u32) -> SceneVertex {
    let here = given(path.last());
    let before = given(path.back(1));
    let surface = given(here.surface);
    let lambert = given(world.scattering(&surface, before.position));
    let survival = if path.len() > rr_depth as usize { lambert.survival() } else { 1.0 };
    let survives = choose(coin(survival));
    if !survives {
        return stop();
    }
    let local = draw(cosine_hemisphere());
    let w = rotate(lambert.frame()).apply(&local);
    let hit: Surface = constant(world.cast(&here, &w));
    let point = hit.seen_from(here.position).apply(&w);
    SceneVertex::hit(hit, point)
}

/// A light, chosen by its power, and a point on it.
#[strategy]
pub fn sample_light(path: &PathView<SceneVertex>, world: &World<'_>) -> SceneVertex {
    let lights = given(world.lights.as_ref());
    let light: &Light = choose(lights)
        .identified_by(|v: &SceneVertex| v.surface.and_then(|s| s.emitter).map(|e| e as usize));
    let id = SurfaceId(light.emitter.primitive);
    let point = match light.shape {
        Primitive::Triangle { v0, v1, v2 } => {
            draw(uniform_triangle(v0.into(), v1.into(), v2.into(), id))
        }
        Primitive::Sphere { center, radius, .. } => {
            draw(uniform_sphere_surface(center.into(), radius, id))
        }
        Primitive::Disk { center, u_axis, v_axis, .. } => {
            draw(uniform_disk(center.into(), u_axis.into(), v_axis.into(), id))
        }
    };
    SceneVertex::on(world.light_surface(light, point.position.into()))
}

strategies! {
    /// How the integrators make their paths.
    #[derive(Clone)]
    pub enum PathStrategies<'a> for SceneVertex {
        /// The pinhole.
        Camera(SampleCamera<'a, 'a>),
        /// What the camera sees.
        CameraDirection(SampleCameraDirection<'a, 'a>),
        /// Scattering.
        Bsdf(SampleBsdf<'a, 'a>),
        /// Next-event estimation.
        Light(SampleLight<'a, 'a>),
    }
}
