//! Finding what a ray hits.
//!
//! * The tree ([`super::tree`]) holds the scene multiplied by a power of two, which is exact, such that the largest
//!   coordinate is between 2¹³ and 2¹⁴: nothing overflows, and hits do not depend on the unit of length.
//! * Boxes are padded by 3e-7 of the largest coordinate, by which the test of a triangle may be wrong about where it is.
//! * Triangles are tested by a watertight test, eight at a time ([`super::packet`]).
//! * Of hits at the same distance the first in the list of primitives counts, whatever the tree.
//!
//! A ray that starts on a surface must not hit that surface again. A planar primitive is left out by
//! identity, a sphere or cylinder is solved for its other root, and for the neighbours see [`Contact`]. None of
//! this is an absolute length.

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;

use super::hit;
use super::model::{Primitive, PrimitiveId};
use super::packet::{Meetings, Packet, Ray, t_errors};
use super::simd::{Eight, LANES, Machine, Plain, Points, Task, abs, dot, same};
use super::tree::{Below, Slabs, Tree, Visitor};
use super::tree_build::{Boxed, build};

/// Largest coordinate of the scaled scene, as an exponent of two.
const SCALED_EXPONENT: i32 = 14;
/// Padding of boxes relative to the largest coordinate.
const PADDING: f32 = 3e-7;
/// Bound of the rounding error of surface points relative to the coordinates of their primitive.
const LIFT: f32 = 4.0 * f32::EPSILON;

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
    packets: Vec<Packet>,
    /// What is no triangle.
    others: Vec<Item>,
    /// A power of two: lengths in the tree per length in the scene.
    scale: f32,
    /// How much larger boxes are than what is in them, to each side.
    padding: f32,
    machine: Machine,
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
        let padding = PADDING * largest * scale;
        let boxes = primitives.iter().map(|p| {
            let bounds = p.bounds();
            Boxed {
                bounds: Aabb::new(
                    Vec3A::from(bounds.min * scale - padding),
                    Vec3A::from(bounds.max * scale + padding),
                ),
                is_triangle: matches!(p, Primitive::Triangle { .. }),
            }
        });
        let (mut packets, mut others) = (Vec::new(), Vec::new());
        let tree = build(&boxes.collect::<Vec<_>>(), |indices| {
            let corners = |&index: &u32| match primitives[index as usize] {
                Primitive::Triangle { v0, v1, v2 } => {
                    Some((PrimitiveId(index), [v0, v1, v2].map(|v| v * scale)))
                }
                _ => None,
            };
            if indices.iter().all(|index| corners(index).is_some()) {
                packets.push(Packet::new(indices.iter().filter_map(corners)));
                return Below::Packet(packets.len() - 1);
            }
            let primitive = scaled(&primitives[indices[0] as usize], scale);
            others.push(Item { primitive, id: PrimitiveId(indices[0]) });
            Below::Other(others.len() - 1)
        });
        Self { tree, packets, others, scale, padding, machine: Machine::detect() }
    }

    /// The same without the machine's instructions.
    #[cfg(test)]
    pub fn on_any_machine(self) -> Self {
        Self { machine: Machine::Any, ..self }
    }

    /// The nearest hit of a ray. `start` is the surface that the ray starts on, if any.
    pub fn nearest(&self, from: End, start: Option<On>, direction: Vec3) -> Option<RawHit> {
        let query = Segment::new(self.scale, from, start, direction)?;
        let hit = self.machine.run(Nearest { tracer: self, query: &query, best: None })?;
        Some(RawHit { t: hit.t / self.scale, ..hit })
    }

    /// Whether a ray has no hit, as [`Tracer::nearest`] would find out by looking for the nearest one.
    pub fn is_open(&self, from: End, start: Option<On>, direction: Vec3) -> bool {
        let query = Segment::new(self.scale, from, start, direction);
        query.is_none_or(|query| {
            !self.machine.run(Any { tracer: self, query: &query, found: false })
        })
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
        !self.machine.run(Any { tracer: self, query: &query, found: false })
    }
}

/// Looks for the nearest hit.
struct Nearest<'a> {
    tracer: &'a Tracer,
    query: &'a Segment,
    best: Option<RawHit>,
}

impl Task for Nearest<'_> {
    type Output = Option<RawHit>;

    #[inline(always)]
    fn run<E: Eight>(mut self, machine: E::Machine) -> Option<RawHit> {
        let ray = Slabs::new(self.query.ray.origin, self.query.ray.direction);
        self.tracer.tree.walk::<E, true>(machine, &ray, f32::MAX, &mut self);
        self.best
    }
}

impl Visitor for Nearest<'_> {
    #[inline(always)]
    fn visit<E: Eight>(&mut self, machine: E::Machine, leaf: Below, limit: f32) -> f32 {
        match leaf {
            Below::Packet(index) => {
                let packet = &self.tracer.packets[index];
                if let Some(meetings) = self.query.meet::<E>(machine, packet, limit) {
                    self.take_nearest(packet, &meetings);
                }
            }
            Below::Other(index) => {
                if let Some(hit) = self.query.test(&self.tracer.others[index]) {
                    self.take(hit);
                }
            }
            Below::Node(_) => {}
        }
        self.best.as_ref().map_or(f32::MAX, |best| best.t)
    }
}

impl Nearest<'_> {
    #[inline(always)]
    fn take(&mut self, hit: RawHit) {
        let is_first = |best: &RawHit| (hit.t, hit.primitive.0) < (best.t, best.primitive.0);
        if self.best.as_ref().is_none_or(is_first) {
            self.best = Some(hit);
        }
    }

    #[inline(always)]
    fn take_nearest<E: Eight>(&mut self, packet: &Packet, meetings: &Meetings<E>) {
        let t = meetings.t.to_array();
        let [u, v, w] = &meetings.weights;
        let [u, v, w] = [u.to_array(), v.to_array(), w.to_array()];
        let mut met = meetings.met;
        while met != 0 {
            let lane = met.trailing_zeros() as usize % LANES;
            met &= met - 1;
            let primitive = packet.id(lane);
            if self.query.is_real(packet, lane, t[lane], self.tracer.padding) {
                let weights = Vec3::new(u[lane], v[lane], w[lane]);
                self.take(RawHit { primitive, t: t[lane].max(0.0), weights });
            }
        }
    }
}

/// Looks whether there is any hit.
struct Any<'a> {
    tracer: &'a Tracer,
    query: &'a Segment,
    found: bool,
}

impl Task for Any<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<E: Eight>(mut self, machine: E::Machine) -> bool {
        let ray = Slabs::new(self.query.ray.origin, self.query.ray.direction);
        let length = self.query.length.min(f32::MAX);
        self.tracer.tree.walk::<E, false>(machine, &ray, length, &mut self);
        self.found
    }
}

impl Visitor for Any<'_> {
    #[inline(always)]
    fn visit<E: Eight>(&mut self, machine: E::Machine, leaf: Below, limit: f32) -> f32 {
        self.found = match leaf {
            Below::Packet(index) => {
                let packet = &self.tracer.packets[index];
                // What ends on a surface may meet others slightly behind it.
                let meetings = self.query.meet::<E>(machine, packet, f32::MAX);
                meetings.is_some_and(|meetings| self.is_any_real(packet, &meetings))
            }
            Below::Other(index) => self.query.test(&self.tracer.others[index]).is_some(),
            Below::Node(_) => false,
        };
        if self.found { -1.0 } else { limit }
    }
}

impl Any<'_> {
    #[inline(always)]
    fn is_any_real<E: Eight>(&self, packet: &Packet, meetings: &Meetings<E>) -> bool {
        let t = meetings.t.to_array();
        let mut met = meetings.met;
        while met != 0 {
            let lane = met.trailing_zeros() as usize % LANES;
            met &= met - 1;
            if self.query.is_real(packet, lane, t[lane], self.tracer.padding) {
                return true;
            }
        }
        false
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

    /// Which planes met at distances of `t` from this end stand in the way. `error` bounds how far the ends and
    /// planes are off, times the lengths of the normals, `rise` how fast the segment goes through along the normals.
    #[inline(always)]
    fn is_met<E: Eight>(&self, machine: E::Machine, t: E, error: E, rise: E) -> u32 {
        let front = self.is_front(machine, rise);
        let height = t * rise.abs();
        let before = (E::splat(machine, 0.0) - error).below(height);
        (front & before) | (!front & error.below(height))
    }

    /// Of which planes errors may decide: fronts behind the end, and backs before it.
    #[inline(always)]
    fn is_doubtful<E: Eight>(&self, machine: E::Machine, t: E, rise: E) -> u32 {
        self.is_front(machine, rise) ^ E::splat(machine, 0.0).below(t * rise.abs())
    }

    #[inline(always)]
    fn is_front<E: Eight>(&self, machine: E::Machine, rise: E) -> u32 {
        let rises = E::splat(machine, 0.0).below(rise);
        if self.along_normal { !rises } else { rises }
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

    /// Whether it starts, and ends, on a primitive.
    #[inline(always)]
    fn touches(&self, primitive: PrimitiveId) -> (bool, bool) {
        let is_on = |contact: &Option<Contact>| contact.as_ref().is_some_and(|c| c.on == primitive);
        (is_on(&self.start), is_on(&self.end))
    }

    /// Whether a triangle that is met within the segment, but for rounding, counts: the segment neither starts nor ends
    /// on it, and comes by its box. A plane that it runs along is met within rounding anywhere.
    #[inline(always)]
    fn is_real(&self, packet: &Packet, lane: usize, t: f32, padding: f32) -> bool {
        if self.touches(packet.id(lane)) != (false, false) {
            return false;
        }
        let nearest = t.max(0.0).min(self.length);
        if nearest == t {
            return true;
        }
        let point = self.ray.origin + nearest * self.ray.direction;
        let (min, max) = packet.bounds(lane);
        point.cmpge(min - padding).all() && point.cmple(max + padding).all()
    }

    /// The triangles of a packet that are met within the segment, and no further than the limit; it may start or end
    /// on some of them.
    #[inline(always)]
    fn meet<E: Eight>(
        &self,
        machine: E::Machine,
        packet: &Packet,
        limit: f32,
    ) -> Option<Meetings<E>> {
        let mut meetings = packet.meet(machine, &self.ray, limit)?;
        meetings.met = if self.start.is_none() && self.end.is_none() {
            let (zero, end) = (E::splat(machine, 0.0), E::splat(machine, self.length));
            meetings.met & zero.below(meetings.t) & meetings.t.below(end)
        } else {
            let planes = PacketPlanes { packet, ray: &self.ray, meetings: &meetings };
            self.within(machine, meetings.met, meetings.t, &planes)
        };
        (meetings.met != 0).then_some(meetings)
    }

    /// The hit of one primitive that is no triangle, if it lies within the segment.
    #[inline(never)]
    fn test(&self, item: &Item) -> Option<RawHit> {
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
        let length = E::splat(machine, self.length);
        let normals = planes.normals(machine);
        let rise = dot(&normals, &same(machine, self.ray.direction));
        let doubtful = |contact: &Option<Contact>, t| match contact {
            Some(contact) => contact.is_doubtful(machine, t, rise),
            None => 0,
        };
        let mut error = E::splat(machine, 0.0);
        if met & (doubtful(&self.start, t) | doubtful(&self.end, length - t)) != 0 {
            let (size, t_error) = planes.errors(machine);
            let off = E::splat(machine, 4.0 * LIFT) * dot(&abs(&normals), &size);
            error = off + t_error * rise.abs();
        }
        let after_start = match &self.start {
            Some(start) => start.is_met(machine, t, error, rise),
            None => E::splat(machine, 0.0).below(t),
        };
        // Seen from the end, the segment runs the other way.
        let before_end = match &self.end {
            Some(end) => end.is_met(machine, length - t, error, rise),
            None => t.below(length),
        };
        met & after_start & before_end
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
