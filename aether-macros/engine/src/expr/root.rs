//! Roots of equations without a closed form, as nodes of the graph.

use super::{Deps, Graph, Id, Leaf, Node, children, leaf_bit};
use crate::derivative::derivative;
use crate::interval::Interval;

/// The bits of all bound variables.
pub const BOUNDS: Deps = 0b1111 << 124;

/// The number t between `lo` and `hi` at which the increasing function `body` of t has the value
/// `target`.
///
/// `variable` is bound: it occurs in `body` and `slope` and means nothing outside.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Root {
    /// The bound variable, a [`Leaf::Bound`].
    pub variable: Leaf,
    /// A function of the variable that has been proven to increase from `lo` to `hi`.
    pub body: Id,
    /// Its derivative by the variable.
    pub slope: Id,
    /// The value that the body has at the root.
    pub target: Id,
    /// The lower end.
    pub lo: Id,
    /// The upper end.
    pub hi: Id,
    /// Whether the target is one of the body's values by construction. If not, a target beyond them
    /// has a root beyond the ends, by extrapolation, so that a test of the range fails.
    pub inside: bool,
    /// Whether the body may turn back at an end. There the root of a target beyond its values lies as far beyond as that
    /// of one within them lies within: by the square root of the difference.
    pub folds: bool,
}

impl Graph {
    /// A root; what is proven of `body` is the caller's business.
    pub fn root(&mut self, root: Root) -> Id {
        self.intern(Node::Root(root))
    }

    /// A variable to be bound, with the interval of its values, that differs from those in `taken`.
    /// `None` if there are too many.
    pub fn bound_variable(&mut self, taken: Deps, name: &str, range: Interval) -> Option<Leaf> {
        let suits = |g: &Graph, leaf: Leaf| {
            leaf_bit(leaf) & taken == 0
                && g.leaf_ranges.get(&leaf).is_none_or(|r| *r == range && g.name(leaf) == name)
        };
        let leaf = (0..=u8::MAX).map(Leaf::Bound).find(|leaf| suits(self, *leaf))?;
        self.leaf(leaf, name, range);
        Some(leaf)
    }

    /// The bits of all variables that are bound or free anywhere in an expression.
    pub fn bound_bits(&self, id: Id) -> Deps {
        let mut seen = std::collections::HashSet::new();
        let mut open = vec![id];
        let mut bits = 0;
        while let Some(id) = open.pop() {
            if !seen.insert(id) {
                continue;
            }
            bits |= self.deps(id) & BOUNDS;
            let node = self.node(id);
            if let Node::Root(r) = node {
                bits |= leaf_bit(r.variable);
                open.extend([r.body, r.slope]);
            }
            open.extend(children(node));
        }
        bits
    }

    /// Whether any part of an expression is a root without a closed form.
    pub fn is_numerical(&self, id: Id) -> bool {
        self.bound_bits(id) != 0
    }

    pub(super) fn deps_of_root(&self, r: &Root) -> Deps {
        let inner = (self.deps(r.body) | self.deps(r.slope)) & !leaf_bit(r.variable);
        inner | self.deps(r.target) | self.deps(r.lo) | self.deps(r.hi)
    }

    pub(super) fn range_of_root(&self, r: &Root) -> Interval {
        if r.inside {
            Interval::new(self.range(r.lo).lo, self.range(r.hi).hi)
        } else {
            Interval::ALL
        }
    }

    /// ∂ root / ∂ x by the implicit function: body(t, x) = target(x) gives
    /// (∂target - ∂body) / slope, at the root.
    pub fn derivative_of_root(&mut self, id: Id, root: &Root, x: Leaf) -> Id {
        let target = derivative(self, root.target, x);
        let body = derivative(self, root.body, x);
        let top = self.sub(target, body);
        let quotient = self.div(top, root.slope);
        let variable = self.get_leaf(root.variable);
        self.substitute(quotient, &[(variable, id)].into())
    }
}
