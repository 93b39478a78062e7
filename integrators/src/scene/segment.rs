//! A piece of a ray, and what it meets: the ends lie on surfaces, which are left out.

use glam::Vec3;

use super::hit;
use super::model::{Primitive, PrimitiveId};
use super::packet::{Meetings, Packet, Ray, t_errors};
use super::simd::{Eight, Plain, Points, abs, dot, same};
use super::vectors::{is_finite, try_unit};

/// Bound of the rounding error of surface points relative to the coordinates of their primitive.
const LIFT: f32 = 4.0 * f32::EPSILON;

/// No primitive has this number.
const NOTHING: u32 = u32::MAX;

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
pub struct On {
    /// Its unit normal at the end.
    pub normal: Vec3,
    /// A bound of how far rounding puts points of it off, along the normal.
    pub off: f32,
}

impl On {
    /// A surface with its unit normal at a point.
    pub fn new(surface: &Primitive, normal: Vec3) -> Self {
        let bounds = surface.bounds();
        let size = bounds.min.abs().max(bounds.max.abs());
        On { normal, off: LIFT * normal.abs().dot(size) }
    }
}

/// A primitive in the scaled scene, and its place in the list of the scene.
#[derive(Clone, Copy, Debug)]
pub struct Item {
    /// The primitive.
    pub primitive: Primitive,
    /// Its place.
    pub id: PrimitiveId,
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

impl RawHit {
    /// What stands for no hit: it [`gives way`](RawHit::gives_way_to) to every hit.
    pub const NONE: Self =
        Self { primitive: PrimitiveId(NOTHING), t: f32::MAX, weights: Vec3::ZERO };

    /// The hit, if it is one.
    #[inline(always)]
    pub fn found(self) -> Option<Self> {
        (self.primitive.0 != NOTHING).then_some(self)
    }

    /// Whether a hit of `primitive` at the distance `t` counts rather than this one.
    #[inline(always)]
    pub fn gives_way_to(&self, primitive: PrimitiveId, t: f32) -> bool {
        t < self.t || (t == self.t && primitive.0 < self.primitive.0)
    }
}

/// A ray or segment in the scaled scene.
#[derive(Clone, Copy)]
pub struct Segment {
    /// The ray along it.
    pub ray: Ray,
    start: Option<Contact>,
    end: Option<Contact>,
    /// The primitives that it starts and ends on, or [`NOTHING`].
    on: [u32; 2],
    end_point: Vec3,
    /// Infinite for a ray.
    pub length: f32,
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
#[derive(Clone, Copy)]
struct Contact {
    /// Whether the segment runs along the normal of the surface rather than against it.
    along_normal: bool,
}

impl Contact {
    #[inline(always)]
    fn new(surface: Option<On>, direction: Vec3) -> Option<Self> {
        Some(Self { along_normal: surface?.normal.dot(direction) > 0.0 })
    }

    /// Which planes met at some height above this end stand in the way. `error` bounds how far the ends and
    /// planes are off, as heights, and the segment goes through the planes that it `rises` through along the normals.
    #[inline(always)]
    fn is_met<E: Eight>(&self, machine: E::Machine, height: E, error: E, rises: u32) -> u32 {
        let front = self.is_front(rises);
        let before = (E::splat(machine, 0.0) - error).below(height);
        (front & before) | (!front & error.below(height))
    }

    /// Of which planes errors may decide: fronts behind the end, and backs that lie `before` it.
    #[inline(always)]
    fn is_doubtful(&self, before: u32, rises: u32) -> u32 {
        self.is_front(rises) ^ before
    }

    #[inline(always)]
    fn is_front(&self, rises: u32) -> u32 {
        if self.along_normal { !rises } else { rises }
    }
}

impl Segment {
    /// A ray from a point; none if that or the direction is no number. `scale` is that of the scene.
    #[inline(always)]
    pub fn new(scale: f32, from: End, start: Option<On>, direction: Vec3) -> Option<Self> {
        let direction = try_unit(direction)?;
        if !is_finite(from.point) {
            return None;
        }
        Some(Self {
            ray: Ray::new(lifted(from.point, start, direction) * scale, direction),
            start: Contact::new(start, direction),
            end: None,
            on: [number(from), NOTHING],
            end_point: Vec3::ZERO,
            length: f32::INFINITY,
        })
    }

    /// What lies between two points; none if that is nothing.
    #[inline(always)]
    pub fn between(scale: f32, from: (End, Option<On>), to: (End, Option<On>)) -> Option<Self> {
        let towards = to.0.point - from.0.point;
        let a = lifted(from.0.point, from.1, towards);
        let offset = lifted(to.0.point, to.1, -towards) - a;
        let direction = try_unit(offset)?;
        Some(Self {
            ray: Ray::new(a * scale, direction),
            start: Contact::new(from.1, direction),
            end: Contact::new(to.1, direction),
            on: [number(from.0), number(to.0)],
            end_point: to.0.point * scale,
            length: offset.length() * scale,
        })
    }

    /// Whether it starts, and ends, on a primitive.
    #[inline(always)]
    fn touches(&self, primitive: PrimitiveId) -> (bool, bool) {
        (self.on[0] == primitive.0, self.on[1] == primitive.0)
    }

    /// Whether a triangle that is met within the segment, but for rounding, counts: the segment comes by its box. A plane
    /// that it runs along is met within rounding anywhere.
    #[inline(always)]
    pub fn is_real(&self, packet: &Packet, lane: usize, t: f32, padding: f32) -> bool {
        if t >= 0.0 && t <= self.length {
            return true;
        }
        let nearest = t.max(0.0).min(self.length);
        packet.is_next_to(lane, self.ray.origin + nearest * self.ray.direction, padding)
    }

    /// The triangles of a packet that are met within the segment, and no further than the limit, but for those that it
    /// starts or ends on.
    #[inline(always)]
    pub fn meet<E: Eight>(
        &self,
        machine: E::Machine,
        packet: &Packet,
        limit: f32,
    ) -> Option<Meetings<E>> {
        let mut meetings = packet.meet(machine, &self.ray, self.on, limit)?;
        let (zero, end) = (E::splat(machine, 0.0), E::splat(machine, self.length));
        let (after, before) = (zero.below(meetings.t), meetings.t.below(end));
        let (met, rises) = (meetings.met, meetings.rises);
        meetings.met = if met & self.doubtful(after, before, rises) == 0 {
            met & after & before
        } else {
            let planes = PacketPlanes { packet, ray: &self.ray, meetings: &meetings };
            self.within(machine, met, meetings.t, &planes)
        };
        (meetings.met != 0).then_some(meetings)
    }

    /// Of which planes errors may decide whether they lie within the segment, as they seem to lie `after` its start and
    /// `before` its end.
    #[inline(always)]
    fn doubtful(&self, after: u32, before: u32, rises: u32) -> u32 {
        let doubtful = |contact: &Option<Contact>, sure| {
            contact.as_ref().map_or(0, |contact| contact.is_doubtful(sure, rises))
        };
        doubtful(&self.start, after) | doubtful(&self.end, before)
    }

    /// The hit of one primitive that is no triangle, if it lies within the segment.
    #[inline(never)]
    pub fn test(&self, item: &Item) -> Option<RawHit> {
        let (starts_here, ends_here) = self.touches(item.id);
        let (ray, d) = (&self.ray, self.ray.direction);
        let (t, weights) = match item.primitive {
            Primitive::Triangle { .. } => return None,
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
            Primitive::Disk { .. } if starts_here || ends_here => return None,
            Primitive::Disk { center, normal, u_axis, v_axis } => {
                let (t, [a, b]) = hit::disk(ray.origin, d, center, u_axis, v_axis)?;
                let size = center.abs() + u_axis.abs() + v_axis.abs();
                let met = self.within((), 1, Plain::splat((), t), &DiskPlane { normal, size });
                (met != 0).then_some(())?;
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

    /// Which of the meetings with planes, a bit for each, lie within the segment.
    #[inline(always)]
    fn within<E: Eight>(
        &self,
        machine: E::Machine,
        met: u32,
        t: E,
        planes: &impl Planes<E>,
    ) -> u32 {
        let (zero, length) = (E::splat(machine, 0.0), E::splat(machine, self.length));
        let normals = planes.normals(machine);
        let rise = dot(&normals, &same(machine, self.ray.direction));
        let (rises, steepness) = (zero.below(rise), rise.abs());
        // Seen from the end, the segment runs the other way.
        let heights = [t * steepness, (length - t) * steepness];
        let after = match self.start {
            Some(_) => zero.below(heights[0]),
            None => zero.below(t),
        };
        let before = match self.end {
            Some(_) => zero.below(heights[1]),
            None => t.below(length),
        };
        if met & self.doubtful(after, before, rises) == 0 {
            return met & after & before;
        }
        let (size, t_error) = planes.errors(machine);
        let off = E::splat(machine, 4.0 * LIFT) * dot(&abs(&normals), &size);
        let error = off + t_error * steepness;
        let is_met = |contact: &Option<Contact>, height, sure| {
            contact.as_ref().map_or(sure, |contact| contact.is_met(machine, height, error, rises))
        };
        met & is_met(&self.start, heights[0], after) & is_met(&self.end, heights[1], before)
    }
}

/// Planes that a segment meets, as far as it matters whether they lie within it.
trait Planes<E: Eight> {
    /// Normals, of any length.
    fn normals(&self, machine: E::Machine) -> Points<E>;
    /// Bounds of the coordinates on them, and of the rounding errors of the distances at which they are met.
    fn errors(&self, machine: E::Machine) -> (Points<E>, E);
}

struct PacketPlanes<'a, E> {
    packet: &'a Packet,
    ray: &'a Ray,
    meetings: &'a Meetings<E>,
}

impl<E: Eight> Planes<E> for PacketPlanes<'_, E> {
    #[inline(always)]
    fn normals(&self, machine: E::Machine) -> Points<E> {
        self.packet.normals(machine)
    }
    #[inline(always)]
    fn errors(&self, machine: E::Machine) -> (Points<E>, E) {
        (self.packet.sizes(machine), t_errors(machine, self.ray, self.meetings))
    }
}

struct DiskPlane {
    normal: Vec3,
    size: Vec3,
}

impl<E: Eight> Planes<E> for DiskPlane {
    #[inline(always)]
    fn normals(&self, machine: E::Machine) -> Points<E> {
        same(machine, self.normal)
    }
    #[inline(always)]
    fn errors(&self, machine: E::Machine) -> (Points<E>, E) {
        (same(machine, self.size), E::splat(machine, 0.0))
    }
}

/// The number of the primitive that an end lies on.
#[inline]
fn number(end: End) -> u32 {
    end.on.map_or(NOTHING, |id| id.0)
}

/// A point on a surface moved off it to the side of `direction` by a bound of its rounding error.
#[inline(always)]
fn lifted(point: Vec3, surface: Option<On>, direction: Vec3) -> Vec3 {
    let Some(On { normal, off }) = surface else {
        return point;
    };
    point + normal * off.copysign(normal.dot(direction))
}
