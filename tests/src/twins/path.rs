//! A path tracer by hand: one loop, no sequences, the two densities that multiple importance sampling needs
//! side by side. Rays, scattering functions, lights and film are the renderer's, and so are the numbers it draws:
//! block by block those of the derived one, so that both make the same paths.

use std::f32::consts::FRAC_1_PI;

use aether_core::discrete::Discrete;
use aether_core::prelude::{Direction, Frame, Sampler, Vec2};
use aether_core::uniform::{UniformSource, draw_uniforms};
use aether_core::work::count_densities;
use glam::Vec3;
use integrators::integrator::Integrator;
use integrators::kind::{Facetted, Presence, SceneKind};
use integrators::lights::{AreaLight, Form, Light};
use integrators::path::PathSettings;
use integrators::render::Splats;
use integrators::samplers::uniform_cone;
use integrators::scattering::facets::{HalfVectors, reflect};
use integrators::scattering::{Lobe, Scattering};
use integrators::scene::{Filter, Primitive, Scene};
use integrators::seen::{cone_of, triangle_of};
use integrators::strategies::Pixel;
use integrators::vertex::{SceneVertex, Seen};
use integrators::world::World;

/// The path tracer by hand.
#[derive(Clone, Copy, Debug)]
pub struct PathByHand(pub PathSettings);

/// Numbers of the blocks of sampling dimensions for a vertex: by scattering, and on a light.
pub(super) const BLOCKS: u32 = 8;
pub(super) const TO_LIGHT: u32 = 1;

/// Whether a scene has no more than this path tracer knows: a pinhole, a filter that is nowhere negative, and lights
/// that are triangles or spheres.
pub fn supports(scene: &Scene) -> bool {
    let known = |e: &integrators::scene::Emitter| {
        let shape = &scene.primitives[e.primitive as usize];
        matches!(shape, Primitive::Triangle { .. } | Primitive::Sphere { .. })
    };
    let is_signed = matches!(scene.film.filter, Filter::Cubic { .. } | Filter::Lanczos { .. });
    !is_signed
        && scene.sky.is_none()
        && scene.bulbs.is_empty()
        && scene.distant.is_empty()
        && scene.emitters.iter().all(known)
}

/// A direction that scattering has found, and what it carries.
pub(super) struct Scattered {
    pub(super) w: Direction<f32>,
    /// Density in solid angle; of an atom, nothing.
    pub(super) density: Option<f32>,
    /// Scattering and cosine over density or probability.
    pub(super) weight: Vec3,
}

/// A point of a light, and the density of its direction in solid angle.
pub(super) struct Lit<K: SceneKind> {
    pub(super) vertex: SceneVertex<K>,
    pub(super) density: f32,
}

impl Integrator for PathByHand {
    type Scratch<'a, K: SceneKind> = ();

    fn scratch<'a, K: SceneKind>(&'a self, _: &'a World<'a, K>) {}

    fn sample<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
        _: &mut (),
        uniforms: &mut impl UniformSource<f32>,
        pixel: Pixel,
        _: &mut Splats,
    ) -> Vec3 {
        let longest = self.0.most_vertices();
        let mut before = SceneVertex::eye(world.eye());
        uniforms.start(BLOCKS);
        let w = camera_direction(world, &before, pixel, uniforms);
        if longest < 2 {
            return Vec3::ZERO;
        }
        let Some(mut here) = meet(world, &before, &w) else { return Vec3::ZERO };
        let mut radiance =
            if self.0.hide_emitters { Vec3::ZERO } else { world.emitted(&here, &before) };
        let mut throughput = Vec3::ONE;
        for length in 2..longest {
            let Some(scattering) = world.scattering(&here, &before) else { break };
            let survival = if length > self.0.rr_depth as usize {
                scattering.albedo().max_element().min(0.95)
            } else {
                1.0
            };
            let block = BLOCKS * length as u32;
            uniforms.start(block + TO_LIGHT);
            radiance += throughput * direct(world, &here, &scattering, survival, uniforms);
            uniforms.start(block);
            // Choices take a number each, whatever they are between.
            if uniforms.choice() >= survival {
                break;
            }
            let Some(scattered) = scatter(&scattering, uniforms) else { break };
            throughput *= scattered.weight / survival;
            if throughput == Vec3::ZERO {
                break;
            }
            let Some(next) = meet(world, &here, &scattered.w) else { break };
            let emitted = world.emitted(&next, &here);
            if emitted != Vec3::ZERO {
                let weight = scattered.density.map_or(1.0, |density| {
                    let ratio = light_density(world, &here, &next) / (density * survival);
                    1.0 / (1.0 + ratio * ratio)
                });
                radiance += throughput * emitted * weight;
            }
            (before, here) = (here, next);
        }
        radiance
    }
}

/// A direction through the film, distributed by the filter: what it carries is one.
pub(super) fn camera_direction<K: SceneKind>(
    world: &World<'_, K>,
    eye: &SceneVertex<K>,
    pixel: Pixel,
    uniforms: &mut impl UniformSource<f32>,
) -> Direction<f32> {
    let offset = match world.scene.film.filter {
        Filter::Box => {
            let [u, v]: [f32; 2] = draw_uniforms(uniforms);
            (u - 0.5, v - 0.5)
        }
        Filter::Tent { radius } => {
            let [right, below] = [(); 2].map(|()| uniforms.choice());
            let [u, v]: [f32; 2] = draw_uniforms(uniforms);
            let signed = |first: bool| if first { radius } else { -radius };
            (
                signed(right < 0.5) * (1.0 - (1.0 - u).sqrt()),
                signed(below < 0.5) * (1.0 - (1.0 - v).sqrt()),
            )
        }
        Filter::Gaussian { stddev } => {
            let [u, v]: [f32; 2] = draw_uniforms(uniforms);
            let mass = 1.0 - (-16.0f32).exp();
            let r = stddev * (-2.0 * (-u * mass).ln_1p()).sqrt();
            let (s, c) = (std::f32::consts::TAU * v).sin_cos();
            (r * c, r * s)
        }
        Filter::Cubic { .. } | Filter::Lanczos { .. } => (0.0, 0.0),
    };
    let (centre, scale) = (world.film_centre(eye), world.film_scale());
    let film = Vec2::new(pixel.0 as f32 + 0.5 + offset.0, pixel.1 as f32 + 0.5 + offset.1);
    let local = Direction::new(scale.x * (film.x - centre.x), scale.y * (film.y - centre.y), 1.0);
    to_world(&world.camera_frame, local.vec().into())
}

/// A vector of a frame in world coordinates.
#[inline]
pub(super) fn to_world(frame: &Frame<f32>, local: Vec3) -> Direction<f32> {
    Direction::from_unit(frame.to_world(aether_core::Vec3::from(local)))
}

/// The surface that a ray meets.
pub(super) fn meet<K: SceneKind>(
    world: &World<'_, K>,
    from: &SceneVertex<K>,
    w: &Direction<f32>,
) -> Option<SceneVertex<K>> {
    match world.cast(from, w)? {
        Seen::Surface(surface) => Some(SceneVertex::on(surface)),
        Seen::Sky(_) => None,
    }
}

/// A direction by one of the lobes.
pub(super) fn scatter<K: SceneKind>(
    scattering: &Scattering<'_, K>,
    uniforms: &mut impl UniformSource<f32>,
) -> Option<Scattered> {
    let choice = scattering.lobes(None).sample(uniforms.choice());
    let local: Vec3 = match choice.item.lobe {
        Lobe::Matte(_) => {
            let [u, v]: [f32; 2] = draw_uniforms(uniforms);
            let (s, c) = (std::f32::consts::TAU * v).sin_cos();
            let r = u.sqrt();
            Vec3::new(r * c, r * s, (1.0 - u).sqrt())
        }
        Lobe::Facets(facets) => {
            let normals = HalfVectors::new(&Facetted::<K>::get(facets), scattering.pose.view())?;
            let sample =
                normals.then(reflect(scattering.pose.view())).sample(draw_uniforms(uniforms));
            if !sample.is_valid() {
                return None;
            }
            sample.value().vec().into()
        }
        Lobe::Mirror(_) | Lobe::Refraction(_) | Lobe::Passage(_) => {
            let direction = scattering.direction(&choice.item)?;
            let coefficient = choice.item.coefficient;
            let w = to_world(&scattering.pose.frame(), direction.vec().into());
            let weight = coefficient / choice.probability;
            return Some(Scattered { w, density: None, weight });
        }
        Lobe::Nothing | Lobe::Glossy(_) | Lobe::Interface(_) => return None,
    };
    let w = to_world(&scattering.pose.frame(), local);
    let density = scattering_density(scattering, w.vec().into());
    let value = scattering.value(w.vec().into());
    let usable = density > 0.0 && value != Vec3::ZERO;
    usable.then(|| Scattered { w, density: Some(density), weight: value / density })
}

/// The density of a direction, of unit length, in solid angle, by all lobes.
pub(super) fn scattering_density<K: SceneKind>(scattering: &Scattering<'_, K>, w: Vec3) -> f32 {
    count_densities(1);
    let pose = &scattering.pose;
    let density = |index: usize| {
        let weighted = scattering.lobe(index)?;
        let density = match weighted.lobe {
            Lobe::Matte(_) => FRAC_1_PI * pose.cosine(w).max(0.0),
            Lobe::Facets(facets) => {
                let normals = HalfVectors::new(&Facetted::<K>::get(facets), pose.view())?;
                let w = Direction::from_unit(pose.frame().to_local(w));
                normals.then(reflect(pose.view())).pdf(&w).value()
            }
            _ => 0.0,
        };
        Some(weighted.chance * density)
    };
    (0..scattering.count()).filter_map(density).sum()
}

/// What a light contributes directly, weighed against finding it by scattering.
fn direct<K: SceneKind>(
    world: &World<'_, K>,
    here: &SceneVertex<K>,
    scattering: &Scattering<'_, K>,
    survival: f32,
    uniforms: &mut impl UniformSource<f32>,
) -> Vec3 {
    let Some(Lit { vertex, density }) = sample_light(world, here, uniforms) else {
        return Vec3::ZERO;
    };
    let w = vertex.direction_from(here.position);
    let value = scattering.value(w) * world.emitted(&vertex, here);
    if value == Vec3::ZERO || !world.visible(here, &vertex) {
        return Vec3::ZERO;
    }
    let by_scattering = scattering_density(scattering, w);
    let ratio = survival * by_scattering / density;
    value / (density * (1.0 + ratio * ratio))
}

/// A point of a light.
pub(super) fn sample_light<K: SceneKind>(
    world: &World<'_, K>,
    here: &SceneVertex<K>,
    uniforms: &mut impl UniformSource<f32>,
) -> Option<Lit<K>> {
    let lights = world.lights.seen_from(here)?;
    count_densities(1);
    let choice = lights.sample(uniforms.choice());
    let Light::Area(light) = choice.item else { return None };
    let light = K::Area::get_ref(light);
    let through = |w: Direction<f32>, density: f32| {
        let vertex = SceneVertex::on(world.lit(light, here, &w)?);
        Some(Lit { vertex, density: choice.probability * density })
    };
    match light.shape {
        Form::Rectangle(rectangle) => {
            if !world.faces(light, here.position) {
                return None;
            }
            if let Some((frame, directions)) = light.seen_as_rectangle(here.position) {
                let sample = directions.sample(draw_uniforms(uniforms));
                let w = to_world(&frame, sample.value().vec().into());
                return through(w, sample.pdf().value());
            }
            let [u, v]: [f32; 2] = draw_uniforms(uniforms);
            let point = rectangle.corner + u * rectangle.a + v * rectangle.b;
            let vertex = SceneVertex::on(world.light_surface(light, point));
            let density = choice.probability * by_area(light, here, &vertex);
            (density > 0.0).then_some(Lit { vertex, density })
        }
        Form::Single(Primitive::Triangle { v0, v1, v2 }) => {
            if !world.faces(light, here.position) {
                return None;
            }
            if let Some((frame, directions)) =
                triangle_of(here.position, [v0, v1, v2], light.emitter.area)
            {
                let sample = directions.sample(draw_uniforms(uniforms));
                let w = to_world(&frame, sample.value().vec().into());
                return through(w, sample.pdf().value());
            }
            let [u, v]: [f32; 2] = draw_uniforms(uniforms);
            let s = u.sqrt();
            let point = v0 + s * (1.0 - v) * (v1 - v0) + s * v * (v2 - v0);
            let vertex = SceneVertex::on(world.light_surface(light, point));
            let density = choice.probability * by_area(light, here, &vertex);
            (density > 0.0).then_some(Lit { vertex, density })
        }
        Form::Single(Primitive::Sphere { center, radius, .. }) => {
            let (axis, depth) = cone_of(here.position, center, radius)?;
            let local = uniform_cone(depth).ok()?.sample(draw_uniforms(uniforms)).value();
            let w = to_world(&Frame::around(axis), local.vec().into());
            through(w, 0.5 * FRAC_1_PI / depth)
        }
        _ => None,
    }
}

/// The density in solid angle of a point that is uniform on a light.
fn by_area<K: SceneKind>(light: &AreaLight, here: &SceneVertex<K>, there: &SceneVertex<K>) -> f32 {
    let Some(surface) = there.surface() else { return 0.0 };
    let offset = there.position - here.position;
    let squared = offset.length_squared();
    let cosine = surface.normal.dot(offset).abs() / squared.sqrt();
    squared / (cosine * light.emitter.area)
}

/// The density in solid angle with which [`sample_light`] finds a vertex.
pub(super) fn light_density<K: SceneKind>(
    world: &World<'_, K>,
    here: &SceneVertex<K>,
    there: &SceneVertex<K>,
) -> f32 {
    count_densities(1);
    let density = || {
        let choice = world.lights.seen_from(here)?.get(world.lights.index_of(there)?)?;
        let Light::Area(light) = choice.item else { return None };
        let light = K::Area::get_ref(light);
        let seen_along = |frame: &Frame<f32>| {
            let w = there.direction_from(here.position);
            Direction::from_unit(frame.to_local(aether_core::Vec3::from(w)))
        };
        let density = match light.shape {
            Form::Rectangle(_) => {
                if !world.faces(light, here.position) {
                    return None;
                }
                match light.seen_as_rectangle(here.position) {
                    Some((frame, directions)) => directions.pdf(&seen_along(&frame)).value(),
                    None => by_area(light, here, there),
                }
            }
            Form::Single(Primitive::Triangle { v0, v1, v2 }) => {
                if !world.faces(light, here.position) {
                    return None;
                }
                match triangle_of(here.position, [v0, v1, v2], light.emitter.area) {
                    Some((frame, directions)) => directions.pdf(&seen_along(&frame)).value(),
                    None => by_area(light, here, there),
                }
            }
            Form::Single(Primitive::Sphere { center, radius, .. }) => {
                0.5 * FRAC_1_PI / cone_of(here.position, center, radius)?.1
            }
            _ => return None,
        };
        Some(choice.probability * density)
    };
    density().unwrap_or(0.0)
}
