//! Ways that lead through where parameters vanish: `if r2 > 0.0 { axis / r2.sqrt() } else { Vec3::X }` for r2 = x² + y².
//!
//! No point that is tried takes the second one, as it is taken where a sum of squares is zero. Then each of its terms
//! is, and the body is read with zeros in the place of the parameters.

use super::body::Body;
use super::signature::{Param, ParamKind};
use super::{Reading, Value};
use crate::expr::{Graph, Id, Leaf, Node, UNKNOWNS};
use crate::rational::Q;

/// The parameters that are zero where a reading's way leads, if its comparisons say so of any.
pub(super) fn vanishing(reading: &mut Reading) -> Option<Vec<Leaf>> {
    let Reading { way, graph, .. } = reading;
    let leaves = way.zeros.iter().map(|&zero| zero_leaves(graph, zero));
    let leaves: Vec<Leaf> = leaves.collect::<Option<Vec<_>>>()?.concat();
    (!leaves.is_empty()).then_some(leaves)
}

/// The parameters that are zero where a sum is none of whose terms is positive.
fn zero_leaves(g: &mut Graph, sum: Id) -> Option<Vec<Leaf>> {
    if g.has(sum, UNKNOWNS) {
        return None;
    }
    let terms = match g.node(sum) {
        Node::Sum(c, terms) if c.is_zero() => terms.clone(),
        Node::Sum(..) => return None,
        _ => vec![(Q::ONE, sum)],
    };
    let signed = |&(q, t): &(Q, Id)| {
        let range = g.range(t);
        if q.is_negative() { range.nonnegative() } else { range.nonpositive() }
    };
    if !terms.iter().all(signed) {
        return None;
    }
    terms.iter().map(|&(_, term)| zero_leaf(g, term)).collect()
}

/// The parameter without which a product has no factor that may be zero.
fn zero_leaf(g: &mut Graph, product: Id) -> Option<Leaf> {
    let may_vanish = |g: &Graph, &(base, e): &(Id, Id)| {
        let range = g.range(base);
        let is_power = g.as_number(e).is_some_and(|e| !e.is_negative());
        is_power && range.lo <= 0.0 && range.hi >= 0.0
    };
    let body = g.split(product).1;
    let factors = g.factors(body);
    match factors.into_iter().filter(|factor| may_vanish(g, factor)).collect::<Vec<_>>()[..] {
        [(base, _)] => match g.node(base) {
            Node::Leaf(leaf @ Leaf::Param(_)) => Some(*leaf),
            _ => None,
        },
        _ => None,
    }
}

impl Body<'_> {
    /// Puts zeros in the place of the parameters that vanish on this way. A direction of which one coordinate is left is along
    /// that axis.
    pub(super) fn vanish(&mut self, params: &[Param]) {
        if self.way.vanishing.is_empty() {
            return;
        }
        let zero = self.graph.int(0);
        for p in params {
            let name = p.name.to_string();
            let Some(mut value) = self.names.remove(&name) else { continue };
            let mut coordinates: Vec<&mut Id> = match &mut value {
                Value::Scalar(id) => vec![id],
                Value::Vector(ids) => ids.iter_mut().collect(),
                Value::Matrix(columns) => columns.iter_mut().flatten().collect(),
                _ => vec![],
            };
            for id in &mut coordinates {
                if self.way.vanishing.iter().any(|leaf| self.graph.is_leaf(**id, *leaf)) {
                    **id = zero;
                }
            }
            if p.kind == ParamKind::Direction {
                let mut left = coordinates.into_iter().filter(|id| **id != zero);
                if let (Some(last), None) = (left.next(), left.next()) {
                    let range = self.graph.range(*last);
                    if range.nonnegative() || range.nonpositive() {
                        *last = self.graph.int(if range.nonnegative() { 1 } else { -1 });
                    }
                }
            }
            self.names.insert(name, value);
        }
    }
}
