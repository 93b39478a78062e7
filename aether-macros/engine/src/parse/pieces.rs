//! From the ways through a body to maps on unit cubes.

use std::collections::BTreeMap;

use crate::derivative::derivative;
use crate::expr::{Graph, Id, Leaf, Node, UNKNOWNS};
use crate::rational::Q;

/// A condition: `difference > 0` if strict, else `difference >= 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Test {
    /// What is compared with zero.
    pub difference: Id,
    /// Whether zero itself is outside.
    pub strict: bool,
}

/// An interval of a uniform, by expressions of the parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Lower end.
    pub low: Id,
    /// Distance to the upper end.
    pub width: Id,
    /// Whether the upper end itself belongs to it.
    pub closed: bool,
}

/// What of some tests says only that uniforms lie in intervals: a segment for each uniform that is
/// cut, in terms of the parameters, and the places of the tests that are nothing else.
///
/// Only ends that lie in [0, 1] for all parameters are taken: of others it is not known whether they
/// cut the domain.
pub(super) fn segments(
    g: &mut Graph,
    tests: &[(usize, Test)],
    unknowns: &[Leaf],
) -> (Vec<Option<Segment>>, Vec<usize>) {
    let mut implied = Vec::new();
    let found = unknowns
        .iter()
        .map(|&u| {
            let (mut low, mut high) = (g.int(0), g.int(1));
            let (mut cut, mut closed) = (false, false);
            for &(place, test) in tests {
                let Some((end, is_low)) = end_of(g, test.difference, u) else { continue };
                let side = if is_low { &mut low } else { &mut high };
                // Of two ends on one side the tighter counts, if it is known which that is.
                let gap = g.sub(end, *side);
                let (tighter, looser) = if is_low {
                    (g.range(gap).nonnegative(), g.range(gap).nonpositive())
                } else {
                    (g.range(gap).nonpositive(), g.range(gap).nonnegative())
                };
                if !is_low && tighter {
                    closed = !test.strict && (closed || end != *side);
                }
                if tighter {
                    *side = end;
                }
                if tighter || looser {
                    cut = true;
                    implied.push(place);
                }
            }
            cut.then(|| Segment { low, width: g.sub(high, low), closed })
        })
        .collect();
    (found, implied)
}

/// An expression without the factors that are positive wherever it has a value, which do not change its sign.
fn without_positive(g: &mut Graph, id: Id) -> Id {
    let (q, body) = g.split(id);
    if !matches!(g.node(body), Node::Product(_)) {
        return id;
    }
    let mut factors = g.factors(body);
    factors.retain(|(base, _)| g.range(*base).lo <= 0.0);
    let rest = g.product(&factors);
    g.sum(Q::ZERO, &[(q, rest)])
}

/// The end of an interval of `u` that `difference >= 0` is, and whether it is the lower one.
fn end_of(g: &mut Graph, difference: Id, u: Leaf) -> Option<(Id, bool)> {
    let bit = crate::expr::leaf_bit(u);
    let difference = without_positive(g, difference);
    if g.deps(difference) & UNKNOWNS != bit {
        return None;
    }
    let slope = derivative(g, difference, u);
    if g.has(slope, UNKNOWNS) {
        return None;
    }
    let range = g.range(slope);
    if !(range.lo > 0.0 || range.hi < 0.0 || range.nonnegative() || range.nonpositive()) {
        return None;
    }
    let (leaf, zero) = (g.get_leaf(u), g.int(0));
    let constant = g.substitute(difference, &BTreeMap::from([(leaf, zero)]));
    let end = g.div(constant, slope);
    let end = g.sum(Q::ZERO, &[(Q::int(-1), end)]);
    let inside = g.range(end);
    if g.is_numerical(end) {
        return None;
    }
    (inside.lo >= 0.0 && inside.hi <= 1.0).then_some((end, range.nonnegative()))
}
