//! obvhs's trees made safe: no recursion or stack is ever deeper than it may be.
//!
//! The 8-wide compressed tree is about 1.5 times as fast as the binary one, but its traversal
//! silently loses nodes that are more than 32 deep, and its construction recurses. Both happen with
//! many nested or equal boxes. So equal boxes share one leaf, and a tree that is still too deep
//! stays binary.

use std::collections::HashMap;
use std::ops::Range;

use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, reinsertion::ReinsertionOptimizer};
use obvhs::cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh};
use obvhs::ploc::PlocBuilder;
use obvhs::ray::{Ray, RayHit};
use obvhs::{Boundable, BvhBuildParams};

/// The binary tree is converted by recursion, a few hundred bytes each.
const MAX_BINARY_DEPTH: usize = 1000;
/// Less than the 32 entries of the stack of the wide tree.
const MAX_WIDE_DEPTH: usize = 30;

enum Nodes {
    Empty,
    Wide(CwBvh),
    Binary(Bvh2),
}

/// A tree over boxes.
pub struct Tree {
    nodes: Nodes,
    /// Where the boxes of each leaf begin, in the order of the leaves, and the end of the last.
    starts: Vec<u32>,
}

struct Leaf(Aabb);

impl Boundable for Leaf {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

impl Tree {
    /// Builds a tree. Also returns the order of the boxes in its leaves: traversals speak of
    /// positions in that list.
    pub fn new(boxes: &[Aabb]) -> (Self, Vec<u32>) {
        let groups = equal_boxes(boxes);
        let leaves = groups.iter().map(|group| Leaf(boxes[group[0] as usize]));
        let nodes = build(&leaves.collect::<Vec<_>>());
        let leaf_order: &[u32] = match &nodes {
            Nodes::Empty => &[],
            Nodes::Wide(tree) => &tree.primitive_indices,
            Nodes::Binary(tree) => &tree.primitive_indices,
        };
        let mut starts = vec![0];
        let mut order = Vec::with_capacity(boxes.len());
        for &leaf in leaf_order {
            order.extend(&groups[leaf as usize]);
            starts.push(order.len() as u32);
        }
        (Self { nodes, starts }, order)
    }

    fn leaf(&self, index: usize) -> Range<usize> {
        self.starts[index] as usize..self.starts[index + 1] as usize
    }

    /// Calls `test` for the boxes that the ray may hit. It returns a distance beyond which
    /// nothing matters any more, or infinity.
    #[inline]
    pub fn visit(&self, ray: Ray, mut test: impl FnMut(usize) -> f32) {
        let mut leaf =
            |_: &Ray, index: usize| self.leaf(index).map(&mut test).fold(f32::INFINITY, f32::min);
        match &self.nodes {
            Nodes::Empty => {}
            Nodes::Wide(tree) => drop(tree.ray_traverse(ray, &mut RayHit::none(), &mut leaf)),
            Nodes::Binary(tree) => drop(tree.ray_traverse(ray, &mut RayHit::none(), &mut leaf)),
        }
    }

    /// Whether `blocks` is false for all boxes that the ray may hit; stops at the first.
    #[inline]
    pub fn is_free(&self, ray: Ray, mut blocks: impl FnMut(usize) -> bool) -> bool {
        // obvhs takes a distance below the ray's limit for a hit.
        let leaf = |_: &Ray, index: usize| {
            let blocked = self.leaf(index).any(&mut blocks);
            if blocked { 0.0 } else { f32::INFINITY }
        };
        match &self.nodes {
            Nodes::Empty => true,
            Nodes::Wide(tree) => tree.ray_traverse_miss(ray, leaf),
            Nodes::Binary(tree) => tree.ray_traverse_miss(ray, leaf),
        }
    }
}

/// The indices of the boxes, equal boxes together.
fn equal_boxes(boxes: &[Aabb]) -> Vec<Vec<u32>> {
    let mut groups: Vec<Vec<u32>> = Vec::new();
    let mut known: HashMap<[[u32; 3]; 2], usize> = HashMap::new();
    for (index, b) in boxes.iter().enumerate() {
        let key = [b.min, b.max].map(|v| v.to_array().map(f32::to_bits));
        let group = *known.entry(key).or_insert_with(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        groups[group].push(index as u32);
    }
    groups
}

fn build(leaves: &[Leaf]) -> Nodes {
    if leaves.is_empty() {
        return Nodes::Empty;
    }
    let params = BvhBuildParams::medium_build();
    let mut tree = PlocBuilder::with_capacity(leaves.len()).build(
        params.ploc_search_distance,
        leaves,
        (0..leaves.len() as u32).collect(),
        params.sort_precision,
        params.search_depth_threshold,
    );
    ReinsertionOptimizer::default().run(&mut tree, params.reinsertion_batch_ratio, None);
    tree.max_depth = binary_depth(&tree);
    if tree.max_depth <= MAX_BINARY_DEPTH {
        let wide = bvh2_to_cwbvh(&tree, 3, true, false);
        if wide_depth(&wide) <= MAX_WIDE_DEPTH {
            return Nodes::Wide(wide);
        }
    }
    Nodes::Binary(tree)
}

fn binary_depth(tree: &Bvh2) -> usize {
    let mut deepest = 0;
    let mut stack = vec![(0, 1)];
    while let Some((index, depth)) = stack.pop() {
        deepest = deepest.max(depth);
        let node = &tree.nodes[index as usize];
        if !node.is_leaf() {
            stack.push((node.first_index, depth + 1));
            stack.push((node.first_index + 1, depth + 1));
        }
    }
    deepest
}

fn wide_depth(tree: &CwBvh) -> usize {
    let mut deepest = 0;
    let mut stack = vec![(0, 1)];
    while let Some((index, depth)) = stack.pop() {
        deepest = deepest.max(depth);
        let node = &tree.nodes[index as usize];
        let inner = (0..8).filter(|child| !node.is_leaf(*child));
        stack.extend(inner.map(|child| (node.child_node_index(child), depth + 1)));
    }
    deepest
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3A;

    fn nested(count: usize) -> Vec<Aabb> {
        let size = |i: usize| Vec3A::splat(1.0 + i as f32);
        (0..count).map(|i| Aabb::new(-size(i), size(i))).collect()
    }

    fn visited(boxes: &[Aabb]) -> usize {
        let (tree, order) = Tree::new(boxes);
        assert_eq!(order.len(), boxes.len());
        let ray = Ray::new_inf(Vec3A::splat(0.25), Vec3A::new(0.1, 0.2, 1.0).normalize());
        let mut seen = vec![false; boxes.len()];
        tree.visit(ray, |position| {
            seen[order[position] as usize] = true;
            f32::INFINITY
        });
        assert!(tree.is_free(ray, |_| false) && !tree.is_free(ray, |_| true));
        seen.iter().filter(|seen| **seen).count()
    }

    #[test]
    fn no_box_is_lost_however_deep_the_tree() {
        assert_eq!(visited(&nested(3)), 3);
        assert_eq!(visited(&nested(3000)), 3000);
    }

    #[test]
    fn equal_boxes_share_a_leaf() {
        let boxes = vec![nested(1)[0]; 50_000];
        assert_eq!(visited(&boxes), 50_000);
    }
}
