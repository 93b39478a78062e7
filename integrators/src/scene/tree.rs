//! A tree of boxes, eight to a node, and how a ray goes through it.
//!
//! It is what `super::tree_build` makes of a binary tree. A node holds the boxes of its children side by side, so that
//! they are tested at once.

use glam::Vec3;

use super::simd::{At, Eight, LANES};
use super::stack::{Entries, Stack};

/// What is below a box: a node, or what the one who built the tree keeps there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Child(pub(super) u32);

/// The kinds of children.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Below {
    /// The node with that index.
    Node(usize),
    /// The packet of triangles with that index.
    Packet(usize),
    /// The other primitive with that index.
    Other(usize),
}

impl Child {
    const PACKET: u32 = 1 << 31;
    const OTHER: u32 = 1 << 30;

    /// Indices are below 2³⁰.
    pub fn new(below: Below) -> Self {
        Self(match below {
            Below::Node(index) => index as u32,
            Below::Packet(index) => Self::PACKET | index as u32,
            Below::Other(index) => Self::OTHER | index as u32,
        })
    }

    #[inline(always)]
    fn below(self) -> Below {
        let index = (self.0 & (Self::OTHER - 1)) as usize;
        match self.0 & (Self::PACKET | Self::OTHER) {
            0 => Below::Node(index),
            Self::OTHER => Below::Other(index),
            _ => Below::Packet(index),
        }
    }
}

/// Eight boxes and what is in them.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub struct Node {
    /// By coordinate the lower sides and the upper ones. A box that is not there is inside out.
    sides: [[[f32; LANES]; 2]; 3],
    children: [Child; LANES],
}

impl Node {
    /// A node without children.
    pub fn empty() -> Self {
        let (low, high) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
        let nothing = Child::new(Below::Node(0));
        Self { sides: [[low, high]; 3], children: [nothing; LANES] }
    }

    /// Puts something into one of the eight places.
    pub fn put(&mut self, place: usize, min: Vec3, max: Vec3, child: Child) {
        for axis in 0..3 {
            self.sides[axis][0][place] = min[axis];
            self.sides[axis][1][place] = max[axis];
        }
        self.children[place] = child;
    }

    /// Which boxes a ray meets up to a distance, and at what distances it enters all of them.
    #[inline(always)]
    fn meet<E: Eight>(&self, machine: E::Machine, ray: &Slabs, limit: f32) -> (u32, E) {
        let zero = E::splat(machine, 0.0);
        let near: E = self.distance::<E>(machine, ray, 0, false);
        let near = near.max(self.distance::<E>(machine, ray, 1, false));
        let near = near.max(self.distance::<E>(machine, ray, 2, false).max(zero));
        let far: E = self.distance::<E>(machine, ray, 0, true);
        let far = far.min(self.distance::<E>(machine, ray, 1, true));
        let far = far.min(self.distance::<E>(machine, ray, 2, true).min(E::splat(machine, limit)));
        (near.at_most(far * E::splat(machine, ROUNDING)), near)
    }

    /// How far away the sides across a coordinate are along the ray: those met first, or the `far` ones.
    #[inline(always)]
    fn distance<E: Eight>(&self, machine: E::Machine, ray: &Slabs, axis: usize, far: bool) -> E {
        let origin = E::splat(machine, ray.origin[axis]);
        let inverse = E::splat(machine, ray.inverse[axis]);
        let side = &self.sides[axis][usize::from(ray.falls[axis] ^ far)];
        (E::load(machine, side) - origin) * inverse
    }
}

/// The distances to two sides of a box are rounded three times each: by half a unit the difference, the inverse and the
/// product (Ize, "Robust BVH Ray Traversal", 2013).
const ROUNDING: f32 = 1.0 + 4.0 * f32::EPSILON;

/// A ray prepared for the boxes.
#[derive(Clone, Copy, Debug)]
pub struct Slabs {
    origin: [f32; 3],
    inverse: [f32; 3],
    /// Along which coordinates it goes down, and meets upper sides first.
    falls: [bool; 3],
}

impl Slabs {
    /// A ray from `origin` along the unit vector `direction`.
    #[inline(always)]
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        // An infinite inverse would make NaN of a side that the origin lies on.
        let inverse = direction.to_array().map(|x| match x {
            x if x.abs() >= 1e-20 => 1.0 / x,
            x => 1e20f32.copysign(x),
        });
        Self { origin: origin.to_array(), inverse, falls: inverse.map(|x| x < 0.0) }
    }
}

/// What a ray does on its way through a tree.
pub trait Visitor {
    /// Looks at a packet or another primitive in whose box the ray is before the distance `limit`. Returns the limit
    /// from then on; below zero that is the end.
    fn visit<E: Eight>(&mut self, machine: E::Machine, leaf: Below, limit: f32) -> f32;
}

/// A tree over boxes.
pub struct Tree {
    /// The nodes; the first is the root.
    pub nodes: Vec<Node>,
}

impl Tree {
    /// Follows a ray up to a distance; if `NEAREST`, nearer boxes come first, more or less.
    #[inline(always)]
    pub fn walk<E: Eight, const NEAREST: bool>(
        &self,
        (machine, room): At<'_, E>,
        ray: &Slabs,
        mut limit: f32,
        visitor: &mut impl Visitor,
    ) {
        let mut stack = Stack::new(room);
        let mut next = Child::new(Below::Node(0));
        loop {
            match next.below() {
                Below::Node(index) => {
                    let node = &self.nodes[index];
                    let (met, near) = node.meet::<E>(machine, ray, limit);
                    if met & met.wrapping_sub(1) != 0 {
                        let entries = Entries { near: near.to_array(), children: &node.children };
                        next = stack.push_but_one::<NEAREST>(met, &entries).child();
                        continue;
                    } else if met != 0 {
                        next = node.children[met.trailing_zeros() as usize];
                        continue;
                    }
                }
                leaf => {
                    limit = visitor.visit::<E>(machine, leaf, limit);
                    if limit < 0.0 {
                        return;
                    }
                }
            }
            next = loop {
                let Some(entry) = stack.pop() else { return };
                if entry.near() <= limit {
                    break entry.child();
                }
            };
        }
    }
}
