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
    let summaries = summaries(&groups, &binary);
    Builder { groups, binary, summaries, nodes: vec![Node::empty()], leaf }.run()
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

    fn are_triangles(&self, members: &[u32]) -> bool {
        members.iter().all(|i| self.boxes[*i as usize].is_triangle)
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

/// What is below a node of the binary tree.
#[derive(Clone, Copy, Debug)]
struct Summary {
    /// What rays cost below it, if it takes one place of a node, two, ... eight: the surface of all nodes and leaves
    /// that are tested, as it takes about as long to test eight boxes as eight triangles (Ylitie, Karras and Laine,
    /// "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", 2017, section 3).
    costs: [f32; LANES],
    /// The number of primitives.
    count: u32,
    /// Whether all of them are triangles.
    are_triangles: bool,
    /// Whether they fit into one leaf.
    is_leaf: bool,
}

impl Summary {
    /// Of primitives in a box. `opened` is what it costs if it takes two, three, ... eight places.
    fn new(count: u32, are_triangles: bool, surface: f32, opened: [f32; LANES]) -> Self {
        let is_leaf = count as usize <= most_in_leaf(are_triangles);
        let mut costs = opened;
        costs[0] = if is_leaf { surface } else { surface + opened[LANES - 1] };
        // Nobody has to use all places.
        for places in 1..LANES {
            costs[places] = costs[places].min(costs[places - 1]);
        }
        Summary { costs, count, are_triangles, is_leaf }
    }
}

/// How many primitives a leaf holds.
fn most_in_leaf(are_triangles: bool) -> usize {
    if are_triangles { LANES } else { 1 }
}

/// How to share places, at least two, between two halves, and what that costs.
fn shared([a, b]: [&Summary; 2], places: usize) -> (f32, usize) {
    let cost = |first: usize| a.costs[first - 1] + b.costs[places - first - 1];
    let shares = (1..places).map(|first| (cost(first), first));
    shares.min_by(|x, y| x.0.total_cmp(&y.0)).unwrap_or((f32::INFINITY, 1))
}

/// A part of the scene that goes into one box.
#[derive(Clone, Debug)]
enum Part {
    /// A node of the binary tree.
    Binary(u32),
    /// Primitives with the same box, which are too many for a leaf.
    Equal { bounds: Aabb, members: Vec<u32> },
}

struct Builder<'a, L> {
    groups: Groups<'a>,
    binary: Bvh2,
    summaries: Vec<Summary>,
    nodes: Vec<Node>,
    leaf: L,
}

impl<L: FnMut(&[u32]) -> Below> Builder<'_, L> {
    /// Depth first, so that what is near in space is near in memory.
    fn run(mut self) -> Tree {
        if self.binary.nodes.is_empty() {
            return Tree { nodes: self.nodes };
        }
        let mut waiting = vec![(0, self.opened(Part::Binary(0)))];
        while let Some((index, parts)) = waiting.pop() {
            for (place, part) in parts.into_iter().enumerate() {
                let Aabb { min, max } = self.bounds(&part);
                let below = match self.leaf_of(&part) {
                    Some(members) => (self.leaf)(&members),
                    None => {
                        self.nodes.push(Node::empty());
                        waiting.push((self.nodes.len() - 1, self.opened(part)));
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

    /// What a node has in its places if it is made of a part.
    fn opened(&self, part: Part) -> Vec<Part> {
        let mut parts = Vec::new();
        match part {
            Part::Binary(node) if self.summaries[node as usize].is_leaf => parts.push(part),
            Part::Binary(node) if halves(&self.binary, node).is_some() => {
                self.share_out(node, LANES, &mut parts);
            }
            Part::Binary(node) => {
                let bounds = self.binary.nodes[node as usize].aabb;
                parts.extend(
                    self.eighths(bounds, members_of_leaf(&self.groups, &self.binary, node)),
                );
            }
            Part::Equal { bounds, members } => parts.extend(self.eighths(bounds, &members)),
        }
        parts
    }

    /// Shares places of a node out to the halves of what it is made of.
    fn share_out(&self, node: u32, places: usize, parts: &mut Vec<Part>) {
        let Some(halves) = halves(&self.binary, node).filter(|_| places > 1) else {
            return parts.push(Part::Binary(node));
        };
        let (_, first) = shared(halves.map(|half| &self.summaries[half as usize]), places);
        for (half, places) in halves.into_iter().zip([first, places - first]) {
            let costs = &self.summaries[half as usize].costs;
            let needed =
                1 + costs[..places].iter().take_while(|cost| **cost > costs[places - 1]).count();
            self.share_out(half, needed, parts);
        }
    }

    /// As many pieces as a node has places, of leaves if that is enough.
    fn eighths(&self, bounds: Aabb, members: &[u32]) -> impl Iterator<Item = Part> {
        let are_triangles = self.groups.are_triangles(members);
        let size = members.len().div_ceil(LANES).max(most_in_leaf(are_triangles));
        members.chunks(size).map(move |members| Part::Equal { bounds, members: members.to_vec() })
    }

    /// What is in a part, if that is to be a leaf.
    fn leaf_of(&self, part: &Part) -> Option<Vec<u32>> {
        match part {
            Part::Binary(node) => {
                self.summaries[*node as usize].is_leaf.then(|| self.members(*node))
            }
            Part::Equal { members, .. } => {
                let are_triangles = self.groups.are_triangles(members);
                (members.len() <= most_in_leaf(are_triangles)).then(|| members.clone())
            }
        }
    }

    /// The primitives below a node.
    fn members(&self, node: u32) -> Vec<u32> {
        let (mut found, mut stack) = (Vec::new(), vec![node]);
        while let Some(node) = stack.pop() {
            match halves(&self.binary, node) {
                Some([a, b]) => stack.extend([b, a]),
                None => found.extend(members_of_leaf(&self.groups, &self.binary, node)),
            }
        }
        found
    }
}

/// The halves of a node of the binary tree, unless it is a leaf of that.
fn halves(binary: &Bvh2, node: u32) -> Option<[u32; 2]> {
    let node = &binary.nodes[node as usize];
    (!node.is_leaf()).then(|| [node.first_index, node.first_index + 1])
}

/// The primitives in a leaf of the binary tree: obvhs makes leaves of one box.
fn members_of_leaf<'a>(groups: &'a Groups, binary: &Bvh2, node: u32) -> &'a [u32] {
    let first = binary.nodes[node as usize].first_index;
    groups.members(binary.primitive_indices[first as usize])
}

/// What is below each node of the binary tree.
fn summaries(groups: &Groups, binary: &Bvh2) -> Vec<Summary> {
    let nothing = Summary::new(0, true, 0.0, [0.0; LANES]);
    let mut summaries = vec![nothing; binary.nodes.len()];
    let mut stack: Vec<(u32, bool)> =
        binary.nodes.first().map(|_| (0, false)).into_iter().collect();
    while let Some((node, has_halves)) = stack.pop() {
        let surface = binary.nodes[node as usize].aabb.half_area();
        summaries[node as usize] = match halves(binary, node) {
            Some([a, b]) if !has_halves => {
                stack.extend([(node, true), (a, false), (b, false)]);
                continue;
            }
            Some(halves) => {
                let [a, b] = halves.map(|half| &summaries[half as usize]);
                let opened = std::array::from_fn(|i| shared([a, b], i + 1).0);
                let are_triangles = a.are_triangles && b.are_triangles;
                Summary::new(a.count + b.count, are_triangles, surface, opened)
            }
            None => {
                let members = members_of_leaf(groups, binary, node);
                let are_triangles = groups.are_triangles(members);
                let leaves = members.len().div_ceil(most_in_leaf(are_triangles));
                let opened = [surface * leaves as f32; LANES];
                let summary = Summary::new(members.len() as u32, are_triangles, surface, opened);
                // They cannot be shared out.
                Summary { costs: [summary.costs[0]; LANES], ..summary }
            }
        };
    }
    summaries
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;

    use super::*;
    use crate::scene::simd::{Eight, Plain};
    use crate::scene::stack::ROOM;
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
        ROOM.with(|room| {
            tree.walk::<Plain, true>(((), room), &ray, f32::MAX, &mut seen);
            tree.walk::<Plain, false>(((), room), &ray, f32::MAX, &mut seen);
        });
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
