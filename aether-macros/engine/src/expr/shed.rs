//! Sums that shed a term when a product in them is taken apart.

use super::{Graph, Id, Node};
use crate::rational::Q;

/// The sum without what cancels: (1 - u) (1 + v) - v, as a height is drawn in a cap, is 1 - u (1 + v). Products are not
/// multiplied out otherwise, as they are evaluated the way they are written.
pub fn shed(g: &mut Graph, id: Id) -> Id {
    let Node::Sum(constant, terms) = g.node(id).clone() else { return id };
    for (k, &(q, product)) in terms.iter().enumerate() {
        let Node::Product(factors) = g.node(product).clone() else { continue };
        for (i, &(base, exponent)) in factors.iter().enumerate() {
            let Node::Sum(c, open) = g.node(base).clone() else { continue };
            if c.is_zero() || g.as_number(exponent) != Some(Q::ONE) {
                continue;
            }
            let others: Vec<_> = factors.iter().enumerate().filter(|(j, _)| *j != i).collect();
            let others: Vec<_> = others.into_iter().map(|(_, f)| *f).collect();
            let rest = g.product(&others);
            // q (c + open) rest = q c rest + q open rest.
            let (Some(share), open) = (q.mul(c), g.sum(Q::ZERO, &open)) else { continue };
            if !cancels(g, &terms, (share, rest)) {
                continue;
            }
            let left = g.mul(open, rest);
            let mut sum: Vec<(Q, Id)> =
                terms.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, t)| *t).collect();
            sum.extend([(share, rest), (q, left)]);
            return g.sum(constant, &sum);
        }
    }
    id
}

/// Whether all terms of a multiple of an expression occur with the other sign.
fn cancels(g: &Graph, terms: &[(Q, Id)], (share, rest): (Q, Id)) -> bool {
    let has = |p: Q, x: Id| {
        let opposite = share.mul(p).map(Q::neg);
        terms.iter().any(|&(q, t)| t == x && Some(q) == opposite)
    };
    match g.node(rest) {
        Node::Number(_) => false,
        Node::Sum(_, inner) => inner.iter().all(|&(p, x)| has(p, x)),
        _ => has(Q::ONE, rest),
    }
}
