//! A choice among many items by a binary tree whose probabilities depend on a query.

mod builder;

pub use builder::{NodeId, TreeBuilder, TreeError};

use core::marker::PhantomData;

use super::alias::below_one;
use super::{Choice, Discrete};
use crate::density::{Counting, Density};
use crate::real::Scalar;

/// A binary tree with items in its leaves, such as a hierarchy of lights. Made by [`TreeBuilder`].
///
/// An item is chosen by a walk from the root that takes the left or the right branch with
/// probabilities proportional to their [`Importance`], which may depend on a query: the point to be
/// lit, say. [`Tree::seen_by`] fixes the query and gives the [`Discrete`] random variable. The
/// probability of a given leaf is found through the parents of its nodes, so that it takes as long as
/// the leaf is deep.
///
/// ```
/// use aether_core::discrete::{Discrete, TreeBuilder};
///
/// // Lamps along a street; nodes know the stretch that they cover.
/// let mut builder = TreeBuilder::new();
/// for (name, place) in [("first", 0.0), ("second", 10.0), ("third", 20.0)] {
///     builder.leaf(name, 1.0, (place, place));
/// }
/// builder.pair_up(|a, b| (f64::min(a.0, b.0), f64::max(a.1, b.1)));
/// let lamps = builder.build()?;
///
/// let here = 18.0_f64;
/// let near = |stretch: &(f64, f64), weight: f64| {
///     let distance = here - here.clamp(stretch.0, stretch.1);
///     weight / (1.0 + distance * distance)
/// };
/// let view = lamps.seen_by(near);
/// assert_eq!(*view.sample(0.5).item, "third");
/// let total: f64 = (0..3).map(|leaf| view.probability(leaf)).sum();
/// assert!((total - 1.0).abs() < 1e-15);
/// # Ok::<(), aether_core::discrete::TreeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Tree<T, N = ()> {
    /// The root first, the children of a branch side by side.
    nodes: Box<[Node<N>]>,
    leaves: Box<[Leaf<T>]>,
    /// Numbers of the leaves, in the order of their items.
    by_item: Box<[usize]>,
}

#[derive(Clone, Debug)]
struct Node<N> {
    data: N,
    /// Sum of the weights of the leaves below, relative to the heaviest leaf.
    weight: f64,
    /// [`NO_PARENT`] for the root.
    parent: u32,
    kind: Kind,
}

/// In place of the number of a parent.
const NO_PARENT: u32 = u32::MAX;

/// Numbers of nodes and leaves have 32 bits: there may be millions.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Leaf(u32),
    Branch([u32; 2]),
}

#[derive(Clone, Debug)]
struct Leaf<T> {
    item: T,
    node: u32,
}

/// How important a part of a tree is. Implement it for what a query is (a shading point), or pass a
/// closure.
pub trait Importance<N, R> {
    /// The importance of the part under the node with this data. `weight` is the sum of the weights
    /// of its leaves, in units of the heaviest leaf of the tree.
    ///
    /// The branches at a node are taken in proportion to their importance. One that is zero excludes
    /// the branch, unless the other is zero too: then, and if one is negative, NaN or infinite, both
    /// count by their weights.
    fn importance(&self, node: &N, weight: R) -> R;
}

impl<N, R, F: Fn(&N, R) -> R> Importance<N, R> for F {
    fn importance(&self, node: &N, weight: R) -> R {
        self(node, weight)
    }
}

/// The importance that is the weight itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct ByWeight;

impl<N, R> Importance<N, R> for ByWeight {
    fn importance(&self, _node: &N, weight: R) -> R {
        weight
    }
}

impl<T: Ord, N> Tree<T, N> {
    /// The random variable that chooses an item with these importances.
    pub fn seen_by<R: Scalar, I: Importance<N, R>>(
        &self,
        importance: I,
    ) -> TreeView<'_, T, N, I, R> {
        TreeView { tree: self, importance, number: PhantomData }
    }

    /// How many leaves there are.
    pub fn leaf_count(&self) -> usize {
        self.leaves.len()
    }

    /// The item of a leaf; leaves are numbered from zero as they were added.
    pub fn item(&self, leaf: usize) -> Option<&T> {
        self.leaves.get(leaf).map(|leaf| &leaf.item)
    }

    /// The numbers of all leaves that hold `item`, found in O(log N).
    pub fn leaves_of(&self, item: &T) -> &[usize] {
        let first = self.by_item.partition_point(|leaf| self.leaves[*leaf].item < *item);
        let count = self.by_item[first..].partition_point(|leaf| self.leaves[*leaf].item == *item);
        &self.by_item[first..first + count]
    }
}

/// A [`Tree`] with the importances of one query: a choice among its leaves.
///
/// A leaf or a part without weight is never chosen.
#[derive(Clone, Copy, Debug)]
pub struct TreeView<'t, T, N, I, R = f64> {
    tree: &'t Tree<T, N>,
    importance: I,
    number: PhantomData<fn() -> R>,
}

impl<'t, T: Ord, N, R: Scalar, I: Importance<N, R>> TreeView<'t, T, N, I, R> {
    /// Probability of a leaf, in time proportional to its depth; zero if there is no such leaf.
    pub fn probability(&self, leaf: usize) -> R {
        let Some(leaf) = self.tree.leaves.get(leaf) else { return R::ZERO };
        let (mut node, mut p) = (leaf.node, 1.0);
        loop {
            let parent = self.tree.nodes[node as usize].parent;
            if parent == NO_PARENT {
                break;
            }
            if let Kind::Branch(children) = self.tree.nodes[parent as usize].kind {
                let left = self.left(children);
                p *= if node == children[0] { left } else { 1.0 - left };
            }
            node = parent;
        }
        R::of(p)
    }

    /// Probability that the item chosen equals `item`: the sum over all leaves that hold it.
    pub fn pdf(&self, item: &T) -> Density<Counting, R> {
        let leaves = self.tree.leaves_of(item);
        Density::new(leaves.iter().map(|leaf| self.probability(*leaf)).sum())
    }

    /// Probability of the left one of two branches. Of two branches that are both important each has
    /// at least the probability that uniforms resolve, so that none is lost to rounding.
    fn left(&self, children: [u32; 2]) -> f64 {
        let [left, right] = children.map(|child| child as usize);
        let nodes = &self.tree.nodes;
        let weights = [nodes[left].weight, nodes[right].weight];
        if weights[0] == 0.0 || weights[1] == 0.0 {
            return if weights[1] == 0.0 { 1.0 } else { 0.0 };
        }
        let importance = |k: usize| {
            let weight = R::of(nodes[k].weight);
            self.importance.importance(&nodes[k].data, weight).to_f64()
        };
        let found = [importance(left), importance(right)];
        let usable = found.iter().all(|i| *i >= 0.0 && i.is_finite()) && found != [0.0, 0.0];
        let [a, b] = if usable { found } else { weights };
        let least = 0.5 * R::EPSILON.to_f64();
        match (a > 0.0, b > 0.0) {
            (true, true) if a > b => (1.0 / (1.0 + b / a)).min(1.0 - least),
            // Ratios do not overflow as a sum may.
            (true, true) => (a / b / (1.0 + a / b)).max(least),
            (left_only, _) => f64::from(u8::from(left_only)),
        }
    }
}

impl<'t, T: Ord, N, R: Scalar, I: Importance<N, R>> Discrete<R> for TreeView<'t, T, N, I, R> {
    type Item<'a>
        = &'t T
    where
        Self: 'a;

    fn len(&self) -> usize {
        self.tree.leaves.len()
    }

    fn sample_reuse(&self, u: R) -> (Choice<&'t T, R>, R) {
        // In `f64`, so that the rest of a uniform in `f32` loses nothing more at each branch.
        let mut rest = u.to_f64().clamp(0.0, below_one());
        let (mut node, mut p) = (0, 1.0);
        loop {
            match self.tree.nodes[node].kind {
                Kind::Leaf(index) => {
                    let index = index as usize;
                    let item = &self.tree.leaves[index].item;
                    let choice = Choice { index, item, probability: R::of(p) };
                    return (choice, R::of(rest).min(below_one()));
                }
                Kind::Branch(children) => {
                    let left = self.left(children);
                    let (branch, low, width) =
                        if rest < left { (0, 0.0, left) } else { (1, left, 1.0 - left) };
                    rest = ((rest - low) / width).min(below_one());
                    p *= width;
                    node = children[branch] as usize;
                }
            }
        }
    }

    /// In time proportional to the number of leaves that are possible: parts of probability zero are
    /// not entered.
    fn possible<'a>(
        &'a self,
        _: impl Fn(Self::Item<'a>) -> bool,
    ) -> impl Iterator<Item = Choice<Self::Item<'a>, R>>
    where
        Self: 'a,
    {
        let mut waiting = vec![(0, 1.0)];
        core::iter::from_fn(move || {
            while let Some((node, p)) = waiting.pop() {
                match self.tree.nodes[node].kind {
                    Kind::Leaf(index) => {
                        let index = index as usize;
                        let item = &self.tree.leaves[index].item;
                        return Some(Choice { index, item, probability: R::of(p) });
                    }
                    Kind::Branch([left, right]) => {
                        let share = self.left([left, right]);
                        let parts =
                            [(right as usize, p * (1.0 - share)), (left as usize, p * share)];
                        waiting.extend(parts.into_iter().filter(|(_, p)| R::of(*p) > R::ZERO));
                    }
                }
            }
            None
        })
    }

    fn get(&self, index: usize) -> Option<Choice<&'t T, R>> {
        let leaf = self.tree.leaves.get(index)?;
        Some(Choice { index, item: &leaf.item, probability: self.probability(index) })
    }
}
