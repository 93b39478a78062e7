//! The inputs of expressions, and numbers within their ranges.

use crate::expr::{Graph, Id, Leaf, Node, children};
use crate::interval::Interval;
use crate::sorted;

/// An input that an expression depends on.
pub(crate) fn any_input(g: &Graph, id: Id) -> Option<Leaf> {
    match g.node(id) {
        Node::Leaf(leaf) => Some(*leaf),
        node => children(node).into_iter().find_map(|part| any_input(g, part)),
    }
}

/// The inputs of an expression, if there are any.
pub(crate) fn inputs_of(g: &Graph, id: Id) -> Option<Vec<Leaf>> {
    Some(leaves_of(g, id, any_input(g, id)?))
}

/// The inputs of an expression, the variable first.
pub(crate) fn leaves_of(g: &Graph, id: Id, variable: Leaf) -> Vec<Leaf> {
    let mut seen = std::collections::HashSet::new();
    let mut open = vec![id];
    let mut leaves = vec![variable];
    while let Some(id) = open.pop() {
        if !seen.insert(id) {
            continue;
        }
        match g.node(id) {
            Node::Leaf(l) if !leaves.contains(l) => leaves.push(*l),
            // What it depends on is enclosed by its ends.
            node => open.extend(children(node)),
        }
    }
    sorted::sort(&mut leaves[1..]);
    leaves
}

/// A number in the middle of an interval, which may be infinite.
pub(crate) fn centre(i: Interval) -> f64 {
    match (i.lo.is_finite(), i.hi.is_finite()) {
        (true, true) => i.lo + 0.5 * (i.hi - i.lo),
        (true, false) => (2.0 * i.lo).max(i.lo + 1.0),
        (false, true) => (2.0 * i.hi).min(i.hi - 1.0),
        (false, false) => 0.0,
    }
}

/// The number that lies at a fraction t of an interval, which may be infinite.
pub(crate) fn inside(i: Interval, t: f64) -> f64 {
    let far = t / (1.0 - t);
    match (i.lo.is_finite(), i.hi.is_finite()) {
        (true, true) => i.lo + t * i.width(),
        (true, false) => i.lo + far,
        (false, true) => i.hi - 1.0 / far,
        (false, false) => far - 1.0 / far,
    }
}
