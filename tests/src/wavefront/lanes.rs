//! What waves do eight at a time: the renderer's samplers and maps with lanes for numbers.

use std::f64::consts::FRAC_1_PI;

use aether_core::Lanes;
use aether_core::prelude::*;
use glam::Vec3 as Vector;
use integrators::kind::SceneKind;
use integrators::lights::Form;
use integrators::samplers::{
    cosine_hemisphere, film_box, hit_plane, pinhole, rotate, uniform_rectangle,
};
use integrators::scene::Rectangle;
use integrators::strategies::Pixel;
use integrators::vertex::SceneVertex;
use integrators::world::World;

use super::{Far, Matte, Near};

/// One number or eight.
pub trait Wide: Real<Lane = f32> {
    /// A number for each lane.
    fn gather(of: impl FnMut(usize) -> f32) -> Self;
}

impl Wide for f32 {
    #[inline(always)]
    fn gather(mut of: impl FnMut(usize) -> f32) -> f32 {
        of(0)
    }
}

impl Wide for Lanes {
    #[inline(always)]
    fn gather(of: impl FnMut(usize) -> f32) -> Lanes {
        Lanes::new(std::array::from_fn(of))
    }
}

#[inline(always)]
fn vectors<R: Wide>(mut of: impl FnMut(usize) -> Vector) -> Vec3<R> {
    Vec3::new(R::gather(|i| of(i).x), R::gather(|i| of(i).y), R::gather(|i| of(i).z))
}

#[inline(always)]
fn vector<R: Wide>(v: Vec3<R>, i: usize) -> Vector {
    Vector::new(v.x.lane(i), v.y.lane(i), v.z.lane(i))
}

#[inline(always)]
fn same<R: Wide>(v: impl Into<Vec3<f32>>) -> Vec3<R> {
    let v = v.into();
    vectors(|_| v.into())
}

/// The lanes that are used, as lanes beyond the last item repeat it.
#[inline(always)]
fn within(count: usize) -> impl Fn(usize) -> usize + Copy {
    move |i| i.min(count - 1)
}

/// Directions that a camera with a box filter looks in.
#[inline(always)]
pub fn camera<K: SceneKind, R: Wide>(
    world: &World<'_, K>,
    count: usize,
    mut next: impl FnMut(usize) -> (Pixel, [f32; 2]),
) -> [Direction<f32>; 8] {
    let mut drawn = [((0, 0), [0.0; 2]); 8];
    (0..count).for_each(|i| drawn[i] = next(i));
    let at = within(count);
    let x = R::gather(|i| drawn[at(i)].0.0 as f32 + 0.5);
    let y = R::gather(|i| drawn[at(i)].0.1 as f32 + 0.5);
    let u = [0, 1].map(|k| R::gather(|i| drawn[at(i)].1[k]));
    let (centre, scale) = (world.film_centre(&SceneVertex::eye(world.eye())), world.film_scale());
    let plane = |v: Vec2<f32>| Vec2::new(R::gather(|_| v.x), R::gather(|_| v.y));
    let film = film_box(x, y).sample(u).value();
    let local = pinhole(plane(centre), plane(scale)).apply(&film);
    let frame = world.camera_frame;
    let w = Mat3::from_cols(same(frame.x), same(frame.y), same(frame.z)) * local.vec();
    std::array::from_fn(|i| Direction::from_unit(vector(w, i).into()))
}

/// Points of rectangles that are sampled by area, each with what it carries of what they emit to a surface that would reflect
/// all, over the density of the point, and times the weight of this way to find it.
#[inline(always)]
pub(super) fn far<R: Wide>(
    connections: &[Far<'_>],
    position: impl Fn(usize) -> Vector,
) -> [(Vector, f32); 8] {
    let at = within(connections.len());
    let rectangle = |i: usize| match connections[at(i)].light.shape {
        Form::Rectangle(rectangle) => rectangle,
        Form::Single(_) => Rectangle { corner: Vector::ZERO, a: Vector::X, b: Vector::Y },
    };
    let u = [0, 1].map(|k| R::gather(|i| connections[at(i)].uniforms[k]));
    let id = SurfaceId(0);
    let origin = vectors::<R>(|i| position(at(i)));
    let normal = vectors::<R>(|i| connections[at(i)].matte.normal);
    let there = vectors::<R>(|i| connections[at(i)].light.flat.map_or(Vector::Z, |f| f.normals[0]));
    let corner = vectors(|i| rectangle(i).corner);
    let points =
        uniform_rectangle(corner, vectors(|i| rectangle(i).a), vectors(|i| rectangle(i).b), id);
    let sample = points.sample(u);
    let (point, chosen) = (sample.value(), R::gather(|i| connections[at(i)].probability));
    let density = sample.pdf().value() * chosen;
    // The integrand: scattering, both cosines and the squared distance.
    let offset = point.position - origin;
    let squared = offset.length_squared();
    let w = offset / squared.sqrt();
    let (cosine, other) = (normal.dot(w), (-there.dot(w)).max(R::ZERO));
    let value = R::of(FRAC_1_PI) * cosine.max(R::ZERO) * other / squared;
    let there = Direction::from_unit(there);
    let scattered = cosine_hemisphere()
        .then(rotate(Frame::around(Direction::from_unit(normal))))
        .then(hit_plane(origin, point.position, there, id));
    let survival = R::gather(|i| connections[at(i)].matte.survival);
    let ratio = survival * scattered.pdf(&point).value() / density;
    let carried = value / (density * (R::ONE + ratio * ratio));
    std::array::from_fn(|i| (vector(point.position, i), carried.lane(i)))
}

/// The same of directions to points that are there already, with their densities in solid angle.
#[inline(always)]
pub(super) fn near<K: SceneKind, R: Wide>(
    connections: &[Near<K>],
    way: impl Fn(usize) -> (Vector, f32),
) -> [f32; 8] {
    let at = within(connections.len());
    let normal = vectors::<R>(|i| connections[at(i)].matte.normal);
    let w = vectors::<R>(|i| way(at(i)).0);
    let density = R::gather(|i| way(at(i)).1);
    let value = R::of(FRAC_1_PI) * normal.dot(w).max(R::ZERO);
    let scattered = cosine_hemisphere().then(rotate(Frame::around(Direction::from_unit(normal))));
    let survival = R::gather(|i| connections[at(i)].matte.survival);
    let ratio = survival * scattered.pdf(&Direction::from_unit(w)).value() / density;
    let carried = value / (density * (R::ONE + ratio * ratio));
    std::array::from_fn(|i| carried.lane(i))
}

/// Directions that matte surfaces scatter into, with their densities, and with what they would carry on from a surface that
/// reflects all.
#[inline(always)]
pub(super) fn scatter<R: Wide>(
    surfaces: &[Matte],
    mut next: impl FnMut(usize) -> [f32; 2],
) -> [(Direction<f32>, f32, f32); 8] {
    let at = within(surfaces.len());
    let mut drawn = [[0.0; 2]; 8];
    (0..surfaces.len()).for_each(|i| drawn[i] = next(i));
    let u = [0, 1].map(|k| R::gather(|i| drawn[at(i)][k]));
    let normal = vectors::<R>(|i| surfaces[at(i)].normal);
    let frame = Frame::around(Direction::from_unit(normal));
    let sample = cosine_hemisphere().then(rotate(frame)).sample(u);
    let (w, density) = (sample.value(), sample.pdf().value());
    let gain = R::of(FRAC_1_PI) * normal.dot(w).max(R::ZERO) / density;
    std::array::from_fn(|i| {
        (Direction::from_unit(vector(w.vec(), i).into()), density.lane(i), gain.lane(i))
    })
}
