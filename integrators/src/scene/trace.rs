//! Finding what a ray hits.
//!
//! * The tree ([`super::tree`]) holds the scene multiplied by a power of two, which is exact, such that the largest
//!   coordinate is between 2¹³ and 2¹⁴: nothing overflows, and hits do not depend on the unit of length.
//! * Boxes are padded by 3e-7 of the largest coordinate, by which the test of a triangle may be wrong about where it is.
//! * Triangles are tested by a watertight test, eight at a time ([`super::packet`]).
//! * Of hits at the same distance the first in the list of primitives counts, whatever the tree.
//!
//! A ray that starts on a surface must not hit that surface again. A planar primitive is left out by
//! identity, a sphere or cylinder is solved for its other root, and neighbours by the side that they are met from ([`super::segment`]). None of
//! this is an absolute length.

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;

use super::model::{Primitive, PrimitiveId};
use super::packet::{Meetings, Packet};
use super::segment::{End, Item, On, RawHit, Segment};
use super::simd::{At, Eight, LANES, Machine};
use super::tree::{Below, Slabs, Tree, Visitor};
use super::tree_build::{Boxed, build};

/// Largest coordinate of the scaled scene, as an exponent of two.
const SCALED_EXPONENT: i32 = 14;
/// Padding of boxes relative to the largest coordinate.
const PADDING: f32 = 3e-7;

/// The search structure over the primitives of a scene.
pub struct Tracer {
    tree: Tree,
    packets: Vec<Packet>,
    /// What is no triangle.
    others: Vec<Item>,
    /// A power of two: lengths in the tree per length in the scene.
    scale: f32,
    /// One over it, which is exact.
    unit: f32,
    /// How much larger boxes are than what is in them, to each side.
    padding: f32,
    machine: Machine,
}

impl Tracer {
    /// Builds the tree. `camera` is where most rays come from: rounding errors grow with its
    /// distance too.
    pub fn new(primitives: &[Primitive], camera: Vec3) -> Self {
        let all: Vec<u32> = (0..primitives.len() as u32).collect();
        Self::among(primitives, &all, camera)
    }

    /// The same over some of the primitives of a scene, by their numbers in ascending order.
    pub fn among(primitives: &[Primitive], chosen: &[u32], camera: Vec3) -> Self {
        let largest = primitives.iter().map(|p| {
            let bounds = p.bounds();
            bounds.min.abs().max(bounds.max.abs()).max_element()
        });
        let largest = largest.fold(camera.abs().max_element(), f32::max);
        let scale = power_of_two_scale(largest);
        let padding = PADDING * largest * scale;
        let boxes = chosen.iter().map(|&index| {
            let p = &primitives[index as usize];
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
            let corners = |&place: &u32| match primitives[chosen[place as usize] as usize] {
                Primitive::Triangle { v0, v1, v2 } => {
                    Some((PrimitiveId(chosen[place as usize]), [v0, v1, v2].map(|v| v * scale)))
                }
                _ => None,
            };
            if indices.iter().all(|index| corners(index).is_some()) {
                packets.push(Packet::new(indices.iter().filter_map(corners)));
                return Below::Packet(packets.len() - 1);
            }
            let id = chosen[indices[0] as usize];
            let primitive = scaled(&primitives[id as usize], scale);
            others.push(Item { primitive, id: PrimitiveId(id) });
            Below::Other(others.len() - 1)
        });
        let unit = 1.0 / scale;
        Self { tree, packets, others, scale, unit, padding, machine: Machine::detect() }
    }

    /// The same without the machine's instructions.
    #[cfg(test)]
    pub fn on_any_machine(self) -> Self {
        Self { machine: Machine::Any, ..self }
    }

    /// What runs the tasks in which rays are followed.
    #[inline(always)]
    pub fn machine(&self) -> Machine {
        self.machine
    }

    /// The nearest hit of a ray. `start` is the surface that the ray starts on, if any.
    #[inline(always)]
    pub fn nearest<E: Eight>(
        &self,
        at: At<'_, E>,
        (from, start): (End, Option<On>),
        direction: Vec3,
    ) -> Option<RawHit> {
        let query = Segment::new(self.scale, from, start, direction)?;
        let ray = Slabs::new(query.ray.origin, query.ray.direction);
        let mut nearest = Nearest { tracer: self, query: &query, best: RawHit::NONE };
        self.tree.walk::<E, true>(at, &ray, f32::MAX, &mut nearest);
        let hit = nearest.best.found()?;
        Some(RawHit { t: hit.t * self.unit, ..hit })
    }

    /// Whether a ray has no hit, as [`Tracer::nearest`] would find out by looking for the nearest one.
    #[inline(always)]
    pub fn is_open<E: Eight>(
        &self,
        at: At<'_, E>,
        (from, start): (End, Option<On>),
        direction: Vec3,
    ) -> bool {
        let Some(query) = Segment::new(self.scale, from, start, direction) else { return true };
        !self.meets_any::<E>(at, &query)
    }

    /// Whether nothing lies between two points, surfaces that they lie on aside.
    #[inline(always)]
    pub fn unoccluded<E: Eight>(
        &self,
        at: At<'_, E>,
        from: (End, Option<On>),
        to: (End, Option<On>),
    ) -> bool {
        let Some(query) = Segment::between(self.scale, from, to) else { return true };
        !self.meets_any::<E>(at, &query)
    }

    #[inline(always)]
    fn meets_any<E: Eight>(&self, at: At<'_, E>, query: &Segment) -> bool {
        let ray = Slabs::new(query.ray.origin, query.ray.direction);
        let mut any = Any { tracer: self, query, found: false };
        self.tree.walk::<E, false>(at, &ray, query.length.min(f32::MAX), &mut any);
        any.found
    }
}

/// Looks for the nearest hit.
struct Nearest<'a> {
    tracer: &'a Tracer,
    query: &'a Segment,
    best: RawHit,
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
                // A copy, so that the query itself need not be in memory for triangles.
                let query = *self.query;
                if let Some(hit) = query.test(&self.tracer.others[index])
                    && self.best.gives_way_to(hit.primitive, hit.t)
                {
                    self.best = hit;
                }
            }
            Below::Node(_) => {}
        }
        self.best.t
    }
}

impl Nearest<'_> {
    #[inline(always)]
    fn take_nearest<E: Eight>(&mut self, packet: &Packet, meetings: &Meetings<E>) {
        let t = meetings.t.to_array();
        let [u, v, w] = &meetings.weights;
        let [u, v, w] = [u.to_array(), v.to_array(), w.to_array()];
        let mut met = meetings.met;
        while met != 0 {
            let lane = met.trailing_zeros() as usize % LANES;
            met &= met - 1;
            let (primitive, distance) = (packet.id(lane), t[lane].max(0.0));
            if self.best.gives_way_to(primitive, distance)
                && self.query.is_real(packet, lane, t[lane], self.tracer.padding)
            {
                let weights = Vec3::new(u[lane], v[lane], w[lane]);
                self.best = RawHit { primitive, t: distance, weights };
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
            Below::Other(index) => {
                let query = *self.query;
                query.test(&self.tracer.others[index]).is_some()
            }
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
