//! Finding what a ray hits.
//!
//! The wide tree of obvhs ([`super::tree`]) skips boxes nearer than an absolute 1e-4 and loses rays
//! at shared edges, so:
//!
//! * The tree holds the scene multiplied by a power of two, which is exact, such that the largest
//!   coordinate is between 2¹³ and 2¹⁴: hits do not depend on the unit of length.
//! * Boxes are padded by 3e-7 of the largest coordinate, which is at least 2e-3: a box that holds a
//!   hit is never left within 1e-4, and rounding of the box test stays within the padding.
//! * Limits on the distance are kept here, and the tree only sees them raised above 1e-4.
//! * Triangles are tested by the watertight [`Ray::triangle`].
//!
//! A ray that starts on a surface must not hit that surface again. A planar primitive is left out by
//! identity, a sphere or cylinder is solved for its other root, and for the neighbours see [`Contact`]. None of
//! this is an absolute length.

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;

use super::hit::{self, Ray};
use super::model::{Primitive, PrimitiveId};
use super::tree::Tree;

/// Largest coordinate of the scaled scene, as an exponent of two.
const SCALED_EXPONENT: i32 = 14;
/// Padding of boxes relative to the largest coordinate.
const PADDING: f32 = 3e-7;
/// Bound of the rounding error of surface points relative to the coordinates of their primitive.
const LIFT: f32 = 4.0 * f32::EPSILON;
/// The least limit on distances that the tree is shown; its own epsilon is 1e-4.
const LEAST_LIMIT: f32 = 1e-3;

/// A point where a ray or a segment starts or ends.
#[derive(Clone, Copy, Debug)]
pub struct End {
    /// Where.
    pub point: Vec3,
    /// On which surface, if any.
    pub on: Option<PrimitiveId>,
}

/// A surface that an end lies on.
#[derive(Clone, Copy, Debug)]
pub struct On<'a> {
    /// The surface.
    pub surface: &'a Primitive,
    /// Its unit normal at the end.
    pub normal: Vec3,
}

/// A primitive in the scaled scene, and its place in the list of the scene.
#[derive(Clone, Copy, Debug)]
struct Item {
    primitive: Primitive,
    id: PrimitiveId,
}

/// The search structure over the primitives of a scene.
pub struct Tracer {
    tree: Tree,
    /// In the order of the leaves of the tree.
    items: Vec<Item>,
    /// A power of two: lengths in the tree per length in the scene.
    scale: f32,
}

/// What was hit, in the scaled scene.
#[derive(Clone, Copy, Debug)]
pub struct RawHit {
    /// Which primitive.
    pub primitive: PrimitiveId,
    /// Distance in lengths of the scene.
    pub t: f32,
    /// Weights of a triangle's corners, or a disk's coordinates, or nothing.
    pub weights: Vec3,
}

impl Tracer {
    /// Builds the tree. `camera` is where most rays come from: rounding errors grow with its
    /// distance too.
    pub fn new(primitives: &[Primitive], camera: Vec3) -> Self {
        let largest = primitives.iter().map(|p| {
            let bounds = p.bounds();
            bounds.min.abs().max(bounds.max.abs()).max_element()
        });
        let largest = largest.fold(camera.abs().max_element(), f32::max);
        let scale = power_of_two_scale(largest);
        let padding = Vec3::splat(PADDING * largest * scale);
        let boxes = primitives.iter().map(|p| {
            let bounds = p.bounds();
            Aabb::new(
                Vec3A::from(bounds.min * scale - padding),
                Vec3A::from(bounds.max * scale + padding),
            )
        });
        let (tree, order) = Tree::new(&boxes.collect::<Vec<_>>());
        let item = |index: &u32| Item {
            primitive: scaled(&primitives[*index as usize], scale),
            id: PrimitiveId(*index),
        };
        Self { tree, items: order.iter().map(item).collect(), scale }
    }

    /// The nearest hit of a ray. `start` is the surface that the ray starts on, if any.
    pub fn nearest(&self, from: End, start: Option<On>, direction: Vec3) -> Option<RawHit> {
        let query = Segment::new(self.scale, from, start, direction)?;
        let mut best: Option<RawHit> = None;
        self.tree.visit(query.tree_ray(f32::INFINITY), |index| {
            match query.test(&self.items[index]) {
                Some(hit) if best.is_none_or(|best| hit.t < best.t) => {
                    best = Some(hit);
                    hit.t.max(LEAST_LIMIT)
                }
                _ => f32::INFINITY,
            }
        });
        best.map(|hit| RawHit { t: hit.t / self.scale, ..hit })
    }

    /// Whether a ray has no hit, as [`Tracer::nearest`] would find out by looking for the nearest one.
    pub fn is_open(&self, from: End, start: Option<On>, direction: Vec3) -> bool {
        let Some(query) = Segment::new(self.scale, from, start, direction) else { return true };
        let ray = query.tree_ray(f32::INFINITY);
        self.tree.is_free(ray, |index| query.test(&self.items[index]).is_some())
    }

    /// Whether nothing lies between two points, surfaces that they lie on aside.
    pub fn unoccluded(&self, from: (End, Option<On>), to: (End, Option<On>)) -> bool {
        let towards = to.0.point - from.0.point;
        let a = lifted(from.0.point, from.1, towards);
        let offset = lifted(to.0.point, to.1, -towards) - a;
        let Some(direction) = offset.try_normalize() else {
            return true;
        };
        let query = Segment {
            ray: Ray::new(a * self.scale, direction),
            start: Contact::new(from.0, from.1, direction),
            end: Contact::new(to.0, to.1, direction),
            end_point: to.0.point * self.scale,
            length: offset.length() * self.scale,
        };
        let ray = query.tree_ray(query.length.max(LEAST_LIMIT));
        self.tree.is_free(ray, |index| query.test(&self.items[index]).is_some())
    }
}

/// A ray or segment in the scaled scene.
struct Segment {
    ray: Ray,
    start: Option<Contact>,
    end: Option<Contact>,
    end_point: Vec3,
    length: f32,
}

/// A surface that an end of a segment lies on.
///
/// The end is off the surface by its rounding error. First it is moved along the normal by a bound
/// of that error ([`lifted`], in the manner of Wächter and Binder, "A Fast and Robust Method for
/// Avoiding Self-Intersection", 2019): then the segment is on the right side of its own surface and
/// passes no edge to the next one underneath. But it may still lie on the wrong side of a
/// neighbour, be it one in the same plane or the other wall of a corner. If a hit is nearer to the
/// end than the error, then the side from which the neighbour is met tells whether it is a true
/// one: a ray that leaves the front of a surface meets the front of the other wall of a corner,
/// perhaps a little before its start, and the back of a surface that it should have started in
/// front of.
struct Contact {
    on: PrimitiveId,
    /// Whether the segment runs along the normal of the surface rather than against it.
    along_normal: bool,
}

impl Contact {
    #[inline]
    fn new(end: End, surface: Option<On>, direction: Vec3) -> Option<Self> {
        Some(Self { on: end.on?, along_normal: surface?.normal.dot(direction) > 0.0 })
    }

    /// Whether a plane met at a distance of `t ± t_error` from this end stands in the way.
    /// `normal` has any length, `size` bounds the coordinates.
    fn is_met(&self, t: f32, t_error: f32, rise: f32, normal: Vec3, size: Vec3) -> bool {
        let error = 4.0 * LIFT * normal.abs().dot(size) + t_error * rise.abs();
        let height = t * rise.abs();
        let is_front = (rise > 0.0) != self.along_normal;
        height > if is_front { -error } else { error }
    }
}

impl Segment {
    fn new(scale: f32, from: End, start: Option<On>, direction: Vec3) -> Option<Self> {
        let direction = direction.try_normalize()?;
        if !from.point.is_finite() {
            return None;
        }
        Some(Self {
            ray: Ray::new(lifted(from.point, start, direction) * scale, direction),
            start: Contact::new(from, start, direction),
            end: None,
            end_point: Vec3::ZERO,
            length: f32::INFINITY,
        })
    }

    fn tree_ray(&self, limit: f32) -> obvhs::ray::Ray {
        // obvhs replaces components below 1.2e-7 by that, which tilts the ray by more than the
        // padding allows for. So small ones are kept, and only zero is replaced; it counts as
        // positive even if it is -0, because obvhs orders the sides of boxes by `x < 0`.
        let inverse = |x: f32| match x {
            x if x.abs() >= 1e-20 => 1.0 / x,
            x if x < 0.0 => -1e20,
            _ => 1e20,
        };
        let d = self.ray.direction;
        obvhs::ray::Ray {
            origin: self.ray.origin.into(),
            direction: d.into(),
            inv_direction: Vec3A::new(inverse(d.x), inverse(d.y), inverse(d.z)),
            tmin: 0.0,
            tmax: limit,
        }
    }

    /// The hit of one primitive, if it lies within the segment.
    #[inline]
    fn test(&self, item: &Item) -> Option<RawHit> {
        let is_on = |contact: &Option<Contact>| contact.as_ref().is_some_and(|c| c.on == item.id);
        let (starts_here, ends_here) = (is_on(&self.start), is_on(&self.end));
        let (ray, d) = (&self.ray, self.ray.direction);
        let (t, weights) = match item.primitive {
            Primitive::Sphere { center, radius, .. } => {
                let t = match (starts_here, ends_here) {
                    // A chord does not leave its sphere on the way.
                    (true, true) => None,
                    (true, false) => hit::chord(ray.origin, d, center),
                    // Backwards from the end, which lies on the sphere.
                    (false, true) => hit::chord(self.end_point, -d, center)
                        .map(|back| self.length - back)
                        .filter(|t| *t > 0.0),
                    (false, false) => hit::sphere(ray.origin, d, center, radius),
                };
                (t.filter(|t| *t < self.length)?, Vec3::ZERO)
            }
            Primitive::Cylinder { .. } => {
                (self.cylinder(&item.primitive, starts_here, ends_here)?, Vec3::ZERO)
            }
            _ if starts_here || ends_here => return None,
            Primitive::Triangle { v0, v1, v2 } => {
                let hit = ray.triangle(&[v0, v1, v2])?;
                let size = v0.abs().max(v1.abs()).max(v2.abs());
                self.plane(hit.t, hit.t_error, || (v1 - v0).cross(v2 - v0), size)?;
                (hit.t, hit.weights)
            }
            Primitive::Disk { center, normal, u_axis, v_axis } => {
                let (t, [a, b]) = hit::disk(ray.origin, d, center, u_axis, v_axis)?;
                let size = center.abs() + u_axis.abs() + v_axis.abs();
                self.plane(t, 0.0, || normal, size)?;
                (t, Vec3::new(a as f32, b as f32, 0.0))
            }
        };
        Some(RawHit { primitive: item.id, t: t.max(0.0), weights })
    }

    /// The distance at which the segment meets the side of a cylinder, as for a sphere.
    #[inline(never)]
    fn cylinder(&self, cylinder: &Primitive, starts_here: bool, ends_here: bool) -> Option<f32> {
        let Primitive::Cylinder { base, axis, radius, .. } = *cylinder else { return None };
        let (origin, d) = (self.ray.origin, self.ray.direction);
        let chord = |point, d| hit::cylinder_chord(point, d, base, axis);
        let t = match (starts_here, ends_here) {
            (true, true) => None,
            (true, false) => chord(origin, d),
            (false, true) => {
                chord(self.end_point, -d).map(|back| self.length - back).filter(|t| *t > 0.0)
            }
            (false, false) => hit::cylinder(origin, d, base, axis, radius),
        };
        t.filter(|t| *t < self.length)
    }

    /// Whether the meeting with a plane lies within the segment.
    #[inline]
    fn plane(&self, t: f32, t_error: f32, normal: impl Fn() -> Vec3, size: Vec3) -> Option<()> {
        let is_within = if self.start.is_none() && self.end.is_none() {
            0.0 < t && t < self.length
        } else {
            let normal = normal();
            let rise = normal.dot(self.ray.direction);
            let after_start = match &self.start {
                Some(start) => start.is_met(t, t_error, rise, normal, size),
                None => t > 0.0,
            };
            // Seen from the end, the segment runs the other way.
            let before_end = match &self.end {
                Some(end) => end.is_met(self.length - t, t_error, rise, normal, size),
                None => t < self.length,
            };
            after_start && before_end
        };
        is_within.then_some(())
    }
}

/// A point on a surface moved off it to the side of `direction` by a bound of its rounding error.
#[inline]
fn lifted(point: Vec3, surface: Option<On>, direction: Vec3) -> Vec3 {
    let Some(On { surface, normal }) = surface else {
        return point;
    };
    let bounds = surface.bounds();
    let size = bounds.min.abs().max(bounds.max.abs());
    let distance = LIFT * normal.abs().dot(size);
    point + normal * distance.copysign(normal.dot(direction))
}

/// The power of two that brings `largest` just below 2^[`SCALED_EXPONENT`].
fn power_of_two_scale(largest: f32) -> f32 {
    if !(largest > 0.0 && largest.is_finite()) {
        return 1.0;
    }
    let exponent = largest.log2().floor() as i32 + 1;
    2.0_f32.powi((SCALED_EXPONENT - exponent).clamp(-100, 100))
}

fn scaled(primitive: &Primitive, scale: f32) -> Primitive {
    match *primitive {
        Primitive::Triangle { v0, v1, v2 } => {
            Primitive::Triangle { v0: v0 * scale, v1: v1 * scale, v2: v2 * scale }
        }
        Primitive::Sphere { center, radius, flipped } => {
            Primitive::Sphere { center: center * scale, radius: radius * scale, flipped }
        }
        Primitive::Cylinder { base, axis, radius, flipped } => Primitive::Cylinder {
            base: base * scale,
            axis: axis * scale,
            radius: radius * scale,
            flipped,
        },
        Primitive::Disk { center, normal, u_axis, v_axis } => Primitive::Disk {
            center: center * scale,
            normal,
            u_axis: u_axis * scale,
            v_axis: v_axis * scale,
        },
    }
}
