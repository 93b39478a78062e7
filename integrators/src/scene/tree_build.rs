//! From boxes to a [`Tree`]: a binary tree by obvhs, of which a node takes up to three levels or more.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};

use glam::Vec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, reinsertion::ReinsertionOptimizer};
use obvhs::ploc::PlocBuilder;
use obvhs::{Boundable, BvhBuildParams};

use super::simd::LANES;
use super::tree::{Below, Child, Node, Tree};

/// A box, and whether packets can hold what is in it.
#[derive(Clone, Copy, Debug)]
pub struct Boxed {
    /// The box.
    pub bounds: Aabb,
    /// Whether it is a triangle.
    pub is_triangle: bool,
}

impl Boundable for Boxed {
    fn aabb(&self) -> Aabb {
        self.bounds
    }
}

/// Builds a tree. `leaf` is told the indices of up to eight triangles, or of one other primitive, in an order that keeps
/// neighbours together, and says where they are from now on.
pub fn build(boxes: &[Boxed], leaf: impl FnMut(&[u32]) -> Below) -> Tree {
    let (order, starts) = equal_boxes(boxes);
    let groups = Groups { boxes, order, starts };
    let binary = binary_tree(&groups);
    Builder { groups, binary, nodes: vec![Node::empty()], leaf }.run()
}

/// The indices of boxes, equal ones together, because a tree over them would be deep.
struct Groups<'a> {
    boxes: &'a [Boxed],
    order: Vec<u32>,
    /// Where each group begins, and the end.
    starts: Vec<u32>,
}

impl Groups<'_> {
    fn members(&self, group: u32) -> &[u32] {
        let [start, end] = [0, 1].map(|i| self.starts[group as usize + i] as usize);
        &self.order[start..end]
    }
}

fn equal_boxes(boxes: &[Boxed]) -> (Vec<u32>, Vec<u32>) {
    let key = |b: &Boxed| {
        ([b.bounds.min, b.bounds.max].map(|v| v.to_array().map(f32::to_bits)), b.is_triangle)
    };
    let hashed = |(index, b): (u32, &Boxed)| {
        let mut hasher = DefaultHasher::new();
        key(b).hash(&mut hasher);
        (hasher.finish(), index)
    };
    let mut hashed: Vec<(u64, u32)> = (0..).zip(boxes).map(hashed).collect();
    hashed.sort_unstable();
    let order: Vec<u32> = hashed.iter().map(|(_, index)| *index).collect();
    let of = |place: usize| key(&boxes[order[place] as usize]);
    let begins = |place: &usize| *place == 0 || of(*place - 1) != of(*place);
    let mut starts: Vec<u32> = (0..order.len()).filter(begins).map(|place| place as u32).collect();
    starts.push(order.len() as u32);
    (order, starts)
}

fn binary_tree(groups: &Groups) -> Bvh2 {
    let firsts = groups.starts[..groups.starts.len() - 1].iter();
    let leaves: Vec<Boxed> =
        firsts.map(|&start| groups.boxes[groups.order[start as usize] as usize]).collect();
    let params = BvhBuildParams::medium_build();
    let mut tree = PlocBuilder::with_capacity(leaves.len()).build(
        params.ploc_search_distance,
        &leaves,
        (0..leaves.len() as u32).collect(),
        params.sort_precision,
        params.search_depth_threshold,
    );
    ReinsertionOptimizer::default().run(&mut tree, params.reinsertion_batch_ratio, None);
    tree
}

/// A part of the scene that goes into one box.
#[derive(Clone, Debug)]
enum Part {
    /// A node of the binary tree.
    Binary(u32),
    /// Primitives with the same box.
    Equal { bounds: Aabb, members: Vec<u32> },
}

struct Builder<'a, L> {
    groups: Groups<'a>,
    binary: Bvh2,
    nodes: Vec<Node>,
    leaf: L,
}

impl<L: FnMut(&[u32]) -> Below> Builder<'_, L> {
    /// Depth first, so that what is near in space is near in memory.
    fn run(mut self) -> Tree {
        if self.binary.nodes.is_empty() {
            return Tree { nodes: self.nodes };
        }
        let mut waiting = vec![(0, Part::Binary(0))];
        while let Some((index, part)) = waiting.pop() {
            for (place, part) in self.opened(part).into_iter().enumerate() {
                let Aabb { min, max } = self.bounds(&part);
                let below = match self.leaf_of(&part) {
                    Some(members) => (self.leaf)(&members),
                    None => {
                        self.nodes.push(Node::empty());
                        waiting.push((self.nodes.len() - 1, part));
                        Below::Node(self.nodes.len() - 1)
                    }
                };
                self.nodes[index].put(place, Vec3::from(min), Vec3::from(max), Child::new(below));
            }
        }
        Tree { nodes: self.nodes }
    }

    fn bounds(&self, part: &Part) -> Aabb {
        match part {
            Part::Binary(node) => self.binary.nodes[*node as usize].aabb,
            Part::Equal { bounds, .. } => *bounds,
        }
    }

    /// Halves parts until there are eight: of those that are no leaves the one with the largest surface, as long as there
    /// is one, then leaves whose halves have less surface together.
    fn opened(&self, part: Part) -> Vec<Part> {
        let mut parts = vec![(self.gain(&part), part)];
        while parts.len() < LANES {
            let gains = parts.iter().enumerate().filter_map(|(i, (gain, _))| Some((i, (*gain)?)));
            let best = gains.max_by(|(_, a), (_, b)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
            let Some((best, _)) = best else { break };
            let Some(halves) = self.halves(&parts[best].1) else { break };
            parts.swap_remove(best);
            parts.extend(halves.map(|half| (self.gain(&half), half)));
        }
        parts.into_iter().map(|(_, part)| part).collect()
    }

    /// Whether a part has to be halved, and how much good that does.
    fn gain(&self, part: &Part) -> Option<(bool, f32)> {
        let [a, b] = self.halves(part)?;
        let area = self.bounds(part).half_area();
        if self.leaf_of(part).is_none() {
            return Some((true, area));
        }
        let gain = area - self.bounds(&a).half_area() - self.bounds(&b).half_area();
        (gain > 0.0).then_some((false, gain))
    }

    fn halves(&self, part: &Part) -> Option<[Part; 2]> {
        let half = |bounds: &Aabb, members: &[u32]| Part::Equal {
            bounds: *bounds,
            members: members.to_vec(),
        };
        let halved = |bounds: &Aabb, members: &[u32]| {
            let (a, b) = members.split_at(members.len() / 2);
            (!a.is_empty()).then(|| [half(bounds, a), half(bounds, b)])
        };
        match part {
            Part::Binary(index) => {
                let node = &self.binary.nodes[*index as usize];
                if node.is_leaf() {
                    halved(&node.aabb, self.members_of_leaf(*index))
                } else {
                    Some([0, 1].map(|i| Part::Binary(node.first_index + i)))
                }
            }
            Part::Equal { bounds, members } => halved(bounds, members),
        }
    }

    /// obvhs makes leaves of one box.
    fn members_of_leaf(&self, node: u32) -> &[u32] {
        let first = self.binary.nodes[node as usize].first_index;
        self.groups.members(self.binary.primitive_indices[first as usize])
    }

    /// What is in a part, if that fits into a leaf.
    fn leaf_of(&self, part: &Part) -> Option<Vec<u32>> {
        let members = match part {
            Part::Binary(node) => self.few_below(*node)?,
            Part::Equal { members, .. } => members.clone(),
        };
        let are_triangles = members.iter().all(|i| self.groups.boxes[*i as usize].is_triangle);
        let most = if are_triangles { LANES } else { 1 };
        (members.len() <= most).then_some(members)
    }

    /// The primitives below a node, if there are at most eight.
    fn few_below(&self, node: u32) -> Option<Vec<u32>> {
        let (mut found, mut stack) = (Vec::new(), vec![node]);
        let mut seen = 0;
        while let Some(index) = stack.pop() {
            let node = &self.binary.nodes[index as usize];
            seen += 1;
            if node.is_leaf() {
                found.extend(self.members_of_leaf(index));
            } else {
                stack.extend([node.first_index + 1, node.first_index]);
            }
            // A binary tree of eight leaves has fifteen nodes.
            if found.len() > LANES || seen >= 2 * LANES {
                return None;
            }
        }
        Some(found)
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;

    use super::*;
    use crate::scene::simd::{Eight, Plain};
    use crate::scene::tree::{Slabs, Visitor};

    fn nested(count: usize) -> Vec<Boxed> {
        let size = |i: usize| Vec3A::splat(1.0 + i as f32);
        let boxed = |i: usize| Boxed {
            bounds: Aabb::new(-size(i), size(i)),
            is_triangle: !i.is_multiple_of(3),
        };
        (0..count).map(boxed).collect()
    }

    struct Seen<'a> {
        leaves: &'a [Vec<u32>],
        times: Vec<u32>,
    }

    impl Visitor for Seen<'_> {
        fn visit<E: Eight>(&mut self, _: E::Machine, leaf: Below, limit: f32) -> f32 {
            let (Below::Packet(index) | Below::Other(index)) = leaf else { panic!("a leaf") };
            for member in &self.leaves[index] {
                self.times[*member as usize] += 1;
            }
            limit
        }
    }

    /// How often a ray that meets all boxes comes by each.
    fn visits(boxes: &[Boxed]) -> Vec<u32> {
        let mut leaves = Vec::new();
        let tree = build(boxes, |members| {
            let triangles = members.iter().filter(|i| boxes[**i as usize].is_triangle).count();
            assert!(triangles == members.len() && triangles <= LANES || members.len() == 1);
            leaves.push(members.to_vec());
            Below::Packet(leaves.len() - 1)
        });
        let mut seen = Seen { leaves: &leaves, times: vec![0; boxes.len()] };
        let ray = Slabs::new(Vec3::splat(0.25), Vec3::new(0.1, 0.2, 1.0).normalize());
        tree.walk::<Plain, true>((), &ray, f32::MAX, &mut seen);
        tree.walk::<Plain, false>((), &ray, f32::MAX, &mut seen);
        seen.times
    }

    #[test]
    fn no_box_is_lost_however_deep_the_tree() {
        for count in [0, 1, 3, 3000] {
            assert_eq!(visits(&nested(count)), vec![2; count]);
        }
    }

    #[test]
    fn equal_boxes_are_no_deep_tree() {
        for kind in 0..2 {
            let boxes = vec![nested(2)[kind]; 50_000];
            assert_eq!(visits(&boxes), vec![2; boxes.len()]);
        }
    }
}
