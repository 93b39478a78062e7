//! Building a [`Tree`] from its leaves up.

use core::fmt;

use super::{Kind, Leaf, NO_PARENT, Node, Tree};
use crate::discrete::WeightError;
use crate::discrete::weights::relative;

/// A node of the tree that a [`TreeBuilder`] is building.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeId(usize);

/// Builds a [`Tree`]: add leaves, join nodes until one is left, then [`TreeBuilder::build`].
#[derive(Clone, Debug)]
pub struct TreeBuilder<T, N = ()> {
    nodes: Vec<Node<N>>,
    leaves: Vec<Leaf<T>>,
    weights: Vec<f64>,
}

/// Why there is no tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TreeError {
    /// The weights of the leaves, by the number of the leaf.
    Weights(WeightError),
    /// A node is to have two parents, or to be joined with itself.
    Joined(NodeId),
    /// No node of this builder.
    Unknown(NodeId),
    /// Not all nodes are joined: this many have no parent.
    Roots(usize),
    /// More nodes than can be numbered.
    TooMany(usize),
}

impl fmt::Display for TreeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TreeError::Weights(error) => write!(f, "leaves of a tree: {error}"),
            TreeError::Joined(NodeId(k)) => {
                write!(f, "node {k} is joined already: a node has one parent")
            }
            TreeError::Unknown(NodeId(k)) => {
                write!(f, "node {k} is not of this tree: join nodes that its builder returned")
            }
            TreeError::Roots(count) => write!(
                f,
                "{count} nodes have no parent: join them until one is left, or call `pair_up`"
            ),
            TreeError::TooMany(count) => {
                write!(f, "{count} nodes: a tree has less than {NO_PARENT}")
            }
        }
    }
}

impl std::error::Error for TreeError {}

impl<T, N> Default for TreeBuilder<T, N> {
    fn default() -> Self {
        TreeBuilder { nodes: Vec::new(), leaves: Vec::new(), weights: Vec::new() }
    }
}

impl<T, N> TreeBuilder<T, N> {
    /// A tree without nodes.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a leaf. Leaves are numbered from zero; several may hold equal items.
    pub fn leaf(&mut self, item: T, weight: f64, data: N) -> NodeId {
        let node = self.nodes.len();
        let kind = Kind::Leaf(number(self.leaves.len()));
        self.nodes.push(Node { data, weight, parent: NO_PARENT, kind });
        self.leaves.push(Leaf { item, node: number(node) });
        self.weights.push(weight);
        NodeId(node)
    }

    /// Adds the parent of two nodes.
    ///
    /// # Errors
    /// A node that has a parent already or is not of this tree; a node and itself.
    pub fn join(&mut self, left: NodeId, right: NodeId, data: N) -> Result<NodeId, TreeError> {
        for id in [left, right] {
            match self.nodes.get(id.0) {
                None => return Err(TreeError::Unknown(id)),
                Some(node) if node.parent != NO_PARENT => return Err(TreeError::Joined(id)),
                Some(_) => {}
            }
        }
        if left == right {
            return Err(TreeError::Joined(left));
        }
        let parent = self.nodes.len();
        self.nodes[left.0].parent = number(parent);
        self.nodes[right.0].parent = number(parent);
        let kind = Kind::Branch([number(left.0), number(right.0)]);
        self.nodes.push(Node { data, weight: 0.0, parent: NO_PARENT, kind });
        Ok(NodeId(parent))
    }

    /// Joins neighbours among the nodes without a parent, in the order in which they were added, until
    /// one is left: a tree as shallow as can be. `merge` makes the data of a node from its children's.
    pub fn pair_up(&mut self, merge: impl Fn(&N, &N) -> N) {
        let mut roots: Vec<NodeId> = self.roots().map(NodeId).collect();
        while roots.len() > 1 {
            let pair = |pair: &[NodeId]| match *pair {
                [a, b] => {
                    let data = merge(&self.nodes[a.0].data, &self.nodes[b.0].data);
                    self.join(a, b, data).unwrap_or(a)
                }
                _ => pair[0],
            };
            roots = roots.chunks(2).map(pair).collect();
        }
    }

    /// The tree.
    ///
    /// # Errors
    /// No leaves, or not one root; a weight that is negative, NaN or infinite; no positive weight; more than
    /// four billion nodes.
    pub fn build(mut self) -> Result<Tree<T, N>, TreeError>
    where
        T: Ord,
    {
        if self.nodes.len() >= NO_PARENT as usize {
            return Err(TreeError::TooMany(self.nodes.len()));
        }
        let weights = relative(&self.weights).map_err(TreeError::Weights)?;
        let roots: Vec<usize> = self.roots().collect();
        let [root] = roots[..] else { return Err(TreeError::Roots(roots.len())) };
        // Children come before their parents.
        for k in 0..self.nodes.len() {
            self.nodes[k].weight = match self.nodes[k].kind {
                Kind::Leaf(leaf) => weights[leaf as usize],
                Kind::Branch([a, b]) => {
                    self.nodes[a as usize].weight + self.nodes[b as usize].weight
                }
            };
        }
        let mut by_item: Vec<usize> = (0..self.leaves.len()).collect();
        by_item.sort_by(|a, b| self.leaves[*a].item.cmp(&self.leaves[*b].item));
        let nodes = by_level(self.nodes, root, &mut self.leaves).into();
        Ok(Tree { nodes, leaves: self.leaves.into(), by_item: by_item.into() })
    }

    fn roots(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.nodes.len()).filter(|k| self.nodes[*k].parent == NO_PARENT)
    }
}

/// The nodes in the order of their levels, the root first and siblings side by side, because a walk looks at
/// two siblings at a time.
fn by_level<T, N>(nodes: Vec<Node<N>>, root: usize, leaves: &mut [Leaf<T>]) -> Vec<Node<N>> {
    let mut waiting: Vec<Option<Node<N>>> = nodes.into_iter().map(Some).collect();
    let mut ordered: Vec<Node<N>> = waiting[root].take().into_iter().collect();
    let mut next = 0;
    while next < ordered.len() {
        match ordered[next].kind {
            Kind::Leaf(leaf) => leaves[leaf as usize].node = number(next),
            Kind::Branch(children) => {
                let first = number(ordered.len());
                for child in children {
                    // A child has one parent, so it waits until it is asked for.
                    let child = waiting[child as usize].take();
                    ordered.extend(child.map(|child| Node { parent: number(next), ..child }));
                }
                ordered[next].kind = Kind::Branch([first, first + 1]);
            }
        }
        next += 1;
    }
    ordered
}

/// The number of a node or leaf; [`TreeBuilder::build`] refuses trees in which it does not fit.
fn number(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(NO_PARENT)
}
