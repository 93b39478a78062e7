//! Ways that lead through where parameters vanish: `if r2 > 0.0 { axis / r2.sqrt() } else { Vec3::X }` for r2 = x² + y².
//!
//! No point that is tried takes the second one, as it is taken where a sum of squares is zero. Then each of its terms
//! is, and the body is read with zeros in the place of the parameters.

use super::body::Body;
use super::{Param, ParamKind};
use super::{Reading, Value};
use crate::expr::{Graph, Id, Leaf, Node, UNKNOWNS};
use crate::points::Kind;
use crate::rational::Q;

/// The parameters that are zero where a reading's way leads, if its comparisons say so of any.
pub(super) fn vanishing(reading: &mut Reading) -> Option<Vec<Leaf>> {
    let Reading { way, graph, kinds, .. } = reading;
    // What a matrix is without some of its elements is not known.
    let mut numbers = 0..0;
    let matrices = kinds.iter().filter_map(|kind| {
        numbers = numbers.end..numbers.end + kind.scalars();
        matches!(kind, Kind::Matrix | Kind::Frame).then(|| numbers.clone())
    });
    let matrices: Vec<_> = matrices.collect();
    let leaves = way.zeros.iter().map(|&zero| zero_leaves(graph, zero));
    let leaves: Vec<Leaf> = leaves.collect::<Option<Vec<_>>>()?.concat();
    let is_of_matrix = |leaf: &Leaf| match leaf {
        Leaf::Param(i) => matrices.iter().any(|m| m.contains(&usize::from(*i))),
        _ => true,
    };
    (!leaves.is_empty() && !leaves.iter().any(is_of_matrix)).then_some(leaves)
}

/// The parameters that are zero where a sum is whose terms all have one sign.
fn zero_leaves(g: &mut Graph, sum: Id) -> Option<Vec<Leaf>> {
    if g.has(sum, UNKNOWNS) {
        return None;
    }
    let terms = match g.node(sum) {
        Node::Sum(c, terms) if c.is_zero() => terms.clone(),
        Node::Sum(..) => return None,
        _ => vec![(Q::ONE, sum)],
    };
    let signs = |positive: bool| {
        terms.iter().all(|&(q, t)| {
            let range = g.range(t);
            if q.is_negative() == positive { range.nonpositive() } else { range.nonnegative() }
        })
    };
    if !signs(true) && !signs(false) {
        return None;
    }
    let leaves = terms.iter().map(|&(_, term)| zero_leaves_of_product(g, term));
    Some(leaves.collect::<Option<Vec<_>>>()?.concat())
}

/// The parameters that are zero where a product is of which one factor alone may be.
fn zero_leaves_of_product(g: &mut Graph, product: Id) -> Option<Vec<Leaf>> {
    let may_vanish = |g: &Graph, &(base, e): &(Id, Id)| {
        let range = g.range(base);
        let is_power = g.as_number(e).is_some_and(|e| !e.is_negative());
        is_power && range.lo <= 0.0 && range.hi >= 0.0
    };
    let body = g.split(product).1;
    let factors = g.factors(body);
    match factors.into_iter().filter(|factor| may_vanish(g, factor)).collect::<Vec<_>>()[..] {
        [(base, _)] => match g.node(base) {
            Node::Leaf(leaf @ Leaf::Param(_)) => Some(vec![*leaf]),
            Node::Sum(..) => zero_leaves(g, base),
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
                Value::Scalar(id) | Value::Integer(id) => vec![id],
                Value::List(all) => all
                    .iter_mut()
                    .filter_map(|number| match number {
                        Value::Scalar(id) => Some(id),
                        _ => None,
                    })
                    .collect(),
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
                let mut left: Vec<&mut Id> =
                    coordinates.into_iter().filter(|id| **id != zero).collect();
                if let [last] = &mut left[..] {
                    let range = self.graph.range(**last);
                    if range.nonnegative() || range.nonpositive() {
                        **last = self.graph.int(if range.nonnegative() { 1 } else { -1 });
                    }
                }
                if let Value::Vector(v) = &value {
                    self.graph.declare_unit([v[0], v[1], v[2]]);
                }
            }
            self.names.insert(name, value);
        }
    }
}
