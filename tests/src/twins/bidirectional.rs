//! A bidirectional path tracer by hand: no sequences, and the weight of a connection from sums that grow with
//! the two pieces of path (in the way of Georgiev, "Implementing Vertex Connection and Merging", 2012), so that
//! each costs the same, however long the path is. Rays, scattering functions, lights and film are the
//! renderer's, and so are the numbers it draws: both make the same pieces and the same connections.
//!
//! A piece of path has vertices v₀, v₁, … from its own end, v_k with the density `own` per area; let `other` be the
//! density with which the other end would have made it. Against a connection at v_k, the techniques that
//! have fewer vertices from this end count, by the power heuristic,
//! S_k = (other_k / own_k)² (one_k + S_{k-1}), where one_k is 1, or whatever the technique that ends at v_{k-1} has
//! beside densities: how many samples it counts as, squared, or that it finds the light in another way. A
//! connection at v_k decides `other` of v_k and v_{k-1} only, so S_{k-2} is kept with v_k.

use std::f32::consts::{FRAC_1_PI, PI};

use aether_core::discrete::Discrete;
use aether_core::prelude::{Direction, Frame};
use aether_core::uniform::{UniformSource, draw_uniforms};
use aether_core::work::count_densities;
use glam::Vec3;
use integrators::bidirectional::DIRECT;
use integrators::integrator::Integrator;
use integrators::kind::{Presence, SceneKind};
use integrators::lights::{AreaLight, Form, Light};
use integrators::path::PathSettings;
use integrators::render::Splats;
use integrators::scattering::Scattering;
use integrators::scene::bsdf::Bsdf;
use integrators::scene::{Filter, Primitive, Scene};
use integrators::strategies::Pixel;
use integrators::vertex::SceneVertex;
use integrators::world::World;

use super::path::{
    BLOCKS, Lit, TO_LIGHT, camera_direction, light_density, meet, sample_light, scatter,
    scattering_density, to_world,
};

/// The bidirectional path tracer by hand; without Russian roulette, whatever its settings say.
#[derive(Clone, Copy, Debug)]
pub struct BidirectionalByHand(pub PathSettings);

/// Where blocks of sampling dimensions of the piece from a light begin.
const FROM_LIGHT: u32 = 2;

/// Whether a scene has no more than this one knows: beside what the path tracer needs, matte materials, which
/// scatter alike in both directions, and pixels that take what falls on them.
pub fn supports(scene: &Scene) -> bool {
    let matte = |bsdf: &Bsdf| match bsdf {
        Bsdf::Diffuse(_) => true,
        Bsdf::TwoSided(sides) => sides.iter().all(|side| matches!(side, Bsdf::Diffuse(_))),
        _ => false,
    };
    super::path::supports(scene)
        && scene.bsdfs.iter().all(matte)
        && scene.film.filter == Filter::Box
}

/// The end of a piece of path.
#[derive(Clone, Copy)]
struct End<'a, K: SceneKind> {
    vertex: SceneVertex<K>,
    /// How it scatters to the vertex before.
    scattering: Option<Scattering<'a, K>>,
    /// What the piece carries: contribution over density.
    carries: Vec3,
    /// Density per area.
    own: f32,
    /// What stands in the place of one for the technique that ends at the vertex before.
    one: f32,
    /// The sum over techniques, up to two vertices before.
    sum: f32,
}

/// The pieces of path of one sample.
pub struct Pieces<'a, K: SceneKind> {
    camera: Vec<End<'a, K>>,
    light: Vec<End<'a, K>>,
}

/// The cosine at a vertex as seen from a point, over the squared distance: solid angle at the point per area.
fn per_area<K: SceneKind>(from: Vec3, to: &SceneVertex<K>) -> f32 {
    let offset = to.position - from;
    let squared = offset.length_squared();
    let cosine = to.surface().map_or(0.0, |s| s.normal.dot(offset).abs() / squared.sqrt());
    cosine / squared
}

/// The density per area with which scattering at `here` leads to `there`.
fn leads_to<K: SceneKind>(
    scattering: &Scattering<'_, K>,
    here: &SceneVertex<K>,
    there: &SceneVertex<K>,
) -> f32 {
    let w = there.direction_from(here.position);
    scattering_density(scattering, w) * per_area(here.position, there)
}

/// The density per area with which a path that comes from `from` scatters at `here` to `there`.
fn turns_to<K: SceneKind>(
    world: &World<'_, K>,
    from: &SceneVertex<K>,
    here: &SceneVertex<K>,
    there: &SceneVertex<K>,
) -> f32 {
    world.scattering(here, from).map_or(0.0, |scattering| leads_to(&scattering, here, there))
}

/// The density per area with which light leaves a point for another.
fn shines_on<K: SceneKind>(light: &SceneVertex<K>, there: &SceneVertex<K>) -> f32 {
    count_densities(1);
    let w = there.direction_from(light.position);
    let cosine = light.surface().map_or(0.0, |surface| surface.normal.dot(w).max(0.0));
    FRAC_1_PI * cosine * per_area(light.position, there)
}

/// The density per area with which paths from lights begin at a vertex.
fn begins_at<K: SceneKind>(world: &World<'_, K>, vertex: &SceneVertex<K>) -> f32 {
    count_densities(1);
    let density = || {
        let choice = world.lights.choice.as_ref()?.get(world.lights.index_of(vertex)?)?;
        let Light::Area(light) = choice.item else { return None };
        Some(choice.probability / K::Area::get_ref(light).emitter.area)
    };
    density().unwrap_or(0.0)
}

/// The sum at the last vertex of a piece, if the other end has these densities there and at the one before.
fn sum_at<K: SceneKind>(piece: &[End<'_, K>], other: f32, other_before: f32) -> f32 {
    sum_by(piece, other, other_before, 1.0)
}

/// The same where the technique that ends at the vertex before the last counts so much more.
fn sum_by<K: SceneKind>(piece: &[End<'_, K>], other: f32, other_before: f32, more: f32) -> f32 {
    let [.., end] = piece else { return 0.0 };
    let before = match piece {
        [.., before, end] => (other_before / before.own).powi(2) * (before.one + end.sum),
        _ => 0.0,
    };
    (other / end.own).powi(2) * (end.one * more + before)
}

/// How much the technique that looks for the light counts of a path that the camera begins with so many vertices.
fn counts(camera: usize) -> f32 {
    if camera == 2 { (DIRECT as f32).powi(2) } else { 1.0 }
}

/// Extends a piece by scattering until it has `longest` vertices; `block` numbers the blocks that it draws from.
fn extend<'a, K: SceneKind>(
    world: &'a World<'a, K>,
    piece: &mut Vec<End<'a, K>>,
    uniforms: &mut impl UniformSource<f32>,
    longest: usize,
    block: u32,
) {
    while piece.len() < longest {
        let [.., before, end] = &piece[..] else { return };
        let Some(scattering) = end.scattering else { return };
        uniforms.start(BLOCKS * piece.len() as u32 + block);
        // The number that Russian roulette takes.
        uniforms.choice();
        let Some(scattered) = scatter(&scattering, uniforms) else { return };
        let Some(density) = scattered.density else { return };
        let Some(vertex) = meet(world, &end.vertex, &scattered.w) else { return };
        let own = density * per_area(end.vertex.position, &vertex);
        let back = turns_to(world, &vertex, &end.vertex, &before.vertex);
        let sum = (back / before.own).powi(2) * (before.one + end.sum);
        let (scattering, carries) =
            (world.scattering(&vertex, &end.vertex), end.carries * scattered.weight);
        piece.push(End { vertex, scattering, carries, own, one: 1.0, sum });
    }
}

impl<'a, K: SceneKind> Pieces<'a, K> {
    /// The piece from the camera.
    fn make_camera_piece(
        &mut self,
        world: &'a World<'a, K>,
        uniforms: &mut impl UniformSource<f32>,
        pixel: Pixel,
        longest: usize,
    ) {
        self.camera.clear();
        let vertex = SceneVertex::eye(world.eye());
        let eye =
            End { vertex, scattering: None, carries: Vec3::ONE, own: 1.0, one: 0.0, sum: 0.0 };
        self.camera.push(eye);
        uniforms.start(BLOCKS);
        let w = camera_direction(world, &vertex, pixel, uniforms);
        let Some(first) = meet(world, &vertex, &w).filter(|_| longest > 1) else { return };
        let Some((_, own)) = seen_at(world, &vertex, &first) else { return };
        let one = (world.pixels() as f32).powi(2);
        let scattering = world.scattering(&first, &vertex);
        self.camera.push(End { vertex: first, scattering, own, one, ..eye });
        extend(world, &mut self.camera, uniforms, longest, 0);
    }

    /// The piece from a light.
    fn make_light_piece(
        &mut self,
        world: &'a World<'a, K>,
        uniforms: &mut impl UniformSource<f32>,
        longest: usize,
    ) {
        self.light.clear();
        uniforms.start(FROM_LIGHT);
        let Some(start) = begin(world, uniforms).filter(|_| longest > 0) else { return };
        self.light.push(start);
        let Some(surface) = start.vertex.surface().filter(|_| longest > 1) else { return };
        uniforms.start(BLOCKS + FROM_LIGHT);
        let [u, v]: [f32; 2] = draw_uniforms(uniforms);
        let (s, c) = (std::f32::consts::TAU * v).sin_cos();
        let local = Vec3::new(u.sqrt() * c, u.sqrt() * s, (1.0 - u).sqrt());
        let frame = Frame::around(Direction::from_unit(surface.normal.into()));
        let Some(vertex) = meet(world, &start.vertex, &to_world(&frame, local)) else { return };
        let own = shines_on(&start.vertex, &vertex);
        // The technique that ends at the light looks for it from here.
        let looks =
            light_density(world, &vertex, &start.vertex) * per_area(vertex.position, &start.vertex);
        let emitted = world.emitted(&start.vertex, &vertex);
        let (scattering, carries) =
            (world.scattering(&vertex, &start.vertex), emitted * (PI / start.own));
        let one = (looks / start.own).powi(2);
        self.light.push(End { vertex, scattering, carries, own, one, sum: 0.0 });
        extend(world, &mut self.light, uniforms, longest, FROM_LIGHT);
    }
}

/// A point of a light, chosen by power.
fn begin<'a, K: SceneKind>(
    world: &'a World<'a, K>,
    uniforms: &mut impl UniformSource<f32>,
) -> Option<End<'a, K>> {
    let choice = world.lights.choice.as_ref()?.sample(uniforms.choice());
    let Light::Area(light) = choice.item else { return None };
    let light: &AreaLight = K::Area::get_ref(light);
    let [u, v]: [f32; 2] = draw_uniforms(uniforms);
    let point = match light.shape {
        Form::Rectangle(rectangle) => rectangle.corner + u * rectangle.a + v * rectangle.b,
        Form::Single(Primitive::Triangle { v0, v1, v2 }) => {
            let s = u.sqrt();
            v0 + s * (1.0 - v) * (v1 - v0) + s * v * (v2 - v0)
        }
        Form::Single(Primitive::Sphere { center, radius, .. }) => {
            let z = 1.0 - 2.0 * u;
            let (s, c) = (std::f32::consts::TAU * v).sin_cos();
            let r = (1.0 - z * z).max(0.0).sqrt();
            center + radius * Vec3::new(r * c, r * s, z)
        }
        _ => return None,
    };
    count_densities(1);
    let own = choice.probability / light.emitter.area;
    let vertex = SceneVertex::on(world.light_surface(light, point));
    Some(End { vertex, scattering: None, carries: Vec3::ONE / own, own, one: 1.0, sum: 0.0 })
}

/// The pixel in which a pinhole sees a vertex, and the density per area with which a path of that pixel begins
/// there; `None` if it lies outside of the image.
fn seen_at<K: SceneKind>(
    world: &World<'_, K>,
    eye: &SceneVertex<K>,
    vertex: &SceneVertex<K>,
) -> Option<(Pixel, f32)> {
    count_densities(1);
    let w =
        world.camera_frame.to_local(aether_core::Vec3::from(vertex.direction_from(eye.position)));
    if w.z <= 0.0 {
        return None;
    }
    let (centre, scale) = (world.film_centre(eye), world.film_scale());
    let film = (centre.x + w.x / (w.z * scale.x), centre.y + w.y / (w.z * scale.y));
    let (width, height) = (world.scene.film.width as f32, world.scene.film.height as f32);
    let inside = (0.0..width).contains(&film.0) && (0.0..height).contains(&film.1);
    let density = per_area(eye.position, vertex) / (w.z * w.z * w.z * scale.x * scale.y);
    inside.then_some(((film.0 as u32, film.1 as u32), density))
}

/// What a path carries that scattering from the camera has led to a light.
fn found<K: SceneKind>(world: &World<'_, K>, camera: &[End<'_, K>]) -> Vec3 {
    let [.., before, end] = camera else { return Vec3::ZERO };
    let emitted = world.emitted(&end.vertex, &before.vertex);
    if emitted == Vec3::ZERO {
        return Vec3::ZERO;
    }
    let begins = begins_at(world, &end.vertex);
    let others = if camera.len() == 2 {
        sum_at(camera, begins, 0.0)
    } else {
        let looks = light_density(world, &before.vertex, &end.vertex)
            * per_area(before.vertex.position, &end.vertex);
        let back = shines_on(&end.vertex, &before.vertex);
        let further = (back / before.own).powi(2) * (before.one + end.sum);
        (looks / end.own).powi(2) * counts(camera.len() - 1) + (begins / end.own).powi(2) * further
    };
    end.carries * emitted / (1.0 + others)
}

/// What a path carries that looks for a light from the end of a piece.
fn looked_for<K: SceneKind>(
    world: &World<'_, K>,
    camera: &[End<'_, K>],
    uniforms: &mut impl UniformSource<f32>,
) -> Vec3 {
    let [.., before, end] = camera else { return Vec3::ZERO };
    uniforms.start(BLOCKS * camera.len() as u32 + TO_LIGHT);
    let Some(Lit { vertex, density }) = sample_light(world, &end.vertex, uniforms) else {
        return Vec3::ZERO;
    };
    let Some(scattering) = &end.scattering else { return Vec3::ZERO };
    let w = vertex.direction_from(end.vertex.position);
    let value = end.carries * scattering.value(w) * world.emitted(&vertex, &end.vertex);
    if value == Vec3::ZERO || !world.visible(&end.vertex, &vertex) {
        return Vec3::ZERO;
    }
    let area = per_area(end.vertex.position, &vertex);
    let scattered = leads_to(scattering, &end.vertex, &vertex) / (density * area);
    let begins = begins_at(world, &vertex) / (density * area);
    let shines = shines_on(&vertex, &end.vertex);
    let back = turns_to(world, &vertex, &end.vertex, &before.vertex);
    let others = scattered * scattered + begins * begins * sum_at(camera, shines, back);
    value / (density * (1.0 + others / counts(camera.len())))
}

/// What a path carries that joins two pieces by an edge.
fn joined<K: SceneKind>(world: &World<'_, K>, camera: &[End<'_, K>], light: &[End<'_, K>]) -> Vec3 {
    let ([.., z_before, z], [.., y_before, y]) = (camera, light) else { return Vec3::ZERO };
    let (Some(at_z), Some(at_y)) = (&z.scattering, &y.scattering) else { return Vec3::ZERO };
    let w = y.vertex.direction_from(z.vertex.position);
    let squared = y.vertex.position.distance_squared(z.vertex.position);
    let value = z.carries * at_z.value(w) * at_y.value(-w) * y.carries / squared;
    if value == Vec3::ZERO || !value.is_finite() || !world.visible(&z.vertex, &y.vertex) {
        return Vec3::ZERO;
    }
    let to_light = sum_at(
        light,
        leads_to(at_z, &z.vertex, &y.vertex),
        turns_to(world, &z.vertex, &y.vertex, &y_before.vertex),
    );
    let to_camera = sum_at(
        camera,
        leads_to(at_y, &y.vertex, &z.vertex),
        turns_to(world, &y.vertex, &z.vertex, &z_before.vertex),
    );
    value / (1.0 + to_light + to_camera)
}

/// The pixel that sees the end of a piece from a light, and what that carries there.
fn splatted<K: SceneKind>(
    world: &World<'_, K>,
    eye: &SceneVertex<K>,
    light: &[End<'_, K>],
) -> Option<(Pixel, Vec3)> {
    let end = light.last()?;
    let (pixel, density) = seen_at(world, eye, &end.vertex)?;
    let w = eye.direction_from(end.vertex.position);
    let scattered = match &end.scattering {
        Some(scattering) => {
            // The cosine at the vertex is that of the density.
            let cosine = end.vertex.surface()?.normal.dot(w).abs();
            scattering.value(w) / cosine
        }
        None if light.len() == 1 => world.emitted(&end.vertex, eye),
        None => return None,
    };
    let value = end.carries * scattered * density;
    if value == Vec3::ZERO || !value.is_finite() || !world.visible(&end.vertex, eye) {
        return None;
    }
    let back = match light {
        [.., before, end] => turns_to(world, eye, &end.vertex, &before.vertex),
        _ => 0.0,
    };
    // As many samples as pixels, of which each is to count once.
    let samples = world.pixels() as f32;
    let others = sum_by(light, density, back, counts(light.len())) / (samples * samples);
    Some((pixel, value / (samples * (1.0 + others))))
}

impl Integrator for BidirectionalByHand {
    type Scratch<'a, K: SceneKind> = Pieces<'a, K>;
    const SPLATS: bool = true;

    fn scratch<'a, K: SceneKind>(&'a self, _: &'a World<'a, K>) -> Pieces<'a, K> {
        Pieces { camera: Vec::new(), light: Vec::new() }
    }

    fn sample<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
        pieces: &mut Pieces<'a, K>,
        uniforms: &mut impl UniformSource<f32>,
        pixel: Pixel,
        splats: &mut Splats,
    ) -> Vec3 {
        let longest = self.0.most_vertices();
        pieces.make_camera_piece(world, uniforms, pixel, longest);
        pieces.make_light_piece(world, uniforms, longest - 1);
        let Pieces { camera, light } = pieces;
        let mut radiance = Vec3::ZERO;
        for t in 2..=camera.len() {
            let camera = &camera[..t];
            radiance += found(world, camera);
            if t < longest {
                radiance += looked_for(world, camera, uniforms);
            }
            for s in 2..=light.len().min(longest - t) {
                radiance += joined(world, camera, &light[..s]);
            }
        }
        let eye = &camera[0].vertex;
        for s in 1..=light.len() {
            if let Some((receiver, value)) = splatted(world, eye, &light[..s]) {
                if receiver == pixel {
                    radiance += value;
                } else {
                    splats.add(receiver, value.to_array());
                }
            }
        }
        radiance
    }
}
