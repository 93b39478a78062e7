//! Sums without cancellation between a term and the same times a coordinate: a - a x as a (1 - x).
//!
//! What interpolates between corners is a sum of products of x and 1 - x with factors of one sign.
//! Multiplied out it has terms of both signs, which cancel where a coordinate is next to one.

use super::{Mono, Poly, merge, over};
use crate::expr::{Fun, Graph, Id, Leaf, Node};
use crate::jacobian::cost;
use crate::rational::Q;

use super::Expander;

/// The expression with its sums paired, where that leaves no term negative in them.
pub fn paired(g: &mut Graph, id: Id) -> Id {
    let (coefficient, body) = g.split(id);
    let factors = g.factors(body);
    let mut changed = false;
    let mut pair = |(b, e): (Id, Id)| {
        let form = match g.node(b) {
            Node::Sum(_, terms) if terms.len() > 2 => sum(g, b),
            Node::Call(Fun::Abs, args) => {
                let inner = args[0];
                let form = paired(g, inner);
                (form != inner).then(|| g.call(Fun::Abs, &[form]))
            }
            _ => None,
        };
        changed |= form.is_some();
        (form.unwrap_or(b), e)
    };
    let factors: Vec<(Id, Id)> = factors.into_iter().map(&mut pair).collect();
    if !changed {
        return id;
    }
    let body = g.product(&factors);
    g.sum(Q::ZERO, &[(coefficient, body)])
}

/// A sum of terms of both signs as one of terms of one sign.
fn sum(g: &mut Graph, id: Id) -> Option<Id> {
    let Node::Sum(_, terms) = g.node(id) else { return None };
    if terms.iter().all(|(q, _)| !q.is_negative()) {
        return None;
    }
    let function = Expander::new(g).expand(id).filter(|f| f.den.is_empty())?;
    let leaves: Vec<Id> = function.num.atoms().into_iter().filter(|a| coordinate(g, *a)).collect();
    let form = by_leaves(g, &function.num, &leaves)?;
    (cost(g, form) < cost(g, id)).then_some(form)
}

fn coordinate(g: &Graph, id: Id) -> bool {
    matches!(g.node(id), Node::Leaf(Leaf::Out(_) | Leaf::Unknown(_)))
}

/// The polynomial with its terms paired by the first leaf, and what that gives by the others.
fn by_leaves(g: &mut Graph, p: &Poly, leaves: &[Id]) -> Option<Id> {
    let Some((&x, others)) = leaves.split_first() else {
        let positive = p.0.iter().all(|(_, q)| !q.is_negative());
        return positive.then(|| p.to_expr(g));
    };
    let (with, without) = pairs(p, x)?;
    let (with, without) = (by_leaves(g, &with, others)?, by_leaves(g, &without, others)?);
    let one = g.int(1);
    let rest = g.sub(one, x);
    let with = g.mul(with, rest);
    Some(g.add(with, without))
}

/// p as P (1 - x) + R: P has the terms m for which p has both m and -m x, as far as their coefficients
/// agree.
fn pairs(p: &Poly, x: Id) -> Option<(Poly, Poly)> {
    let (mut with, mut rest) = (Vec::new(), p.0.clone());
    // From the highest power down, so that what is left of m x may pair with m x².
    for (m, _) in p.0.iter().rev() {
        let Some(lower) = over(m, &[(x, 1)]) else { continue };
        let of = |terms: &[(Mono, Q)], m: &Mono| terms.iter().find(|t| t.0 == *m).map(|t| t.1);
        let (Some(high), Some(low)) = (of(&rest, m), of(&rest, &lower)) else { continue };
        if high.is_negative() == low.is_negative() {
            continue;
        }
        let shared = if high.abs() < low.abs() { high.neg() } else { low };
        with = merge(&with, &[(lower.clone(), shared)])?;
        rest = merge(&rest, &[(m.clone(), shared)])?;
        rest = merge(&rest, &[(lower, shared.neg())])?;
    }
    Some((Poly(with), Poly(rest)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::Interval;

    #[test]
    fn an_interpolation_is_written_without_differences() {
        let mut g = Graph::new();
        let x = g.leaf(Leaf::Out(0), "x", Interval::ALL);
        let y = g.leaf(Leaf::Out(1), "y", Interval::ALL);
        let w = [0, 1, 2, 3].map(|i| g.leaf(Leaf::Param(i), "w", Interval::ALL));
        let one = g.int(1);
        let (s, t) = (g.sub(one, x), g.sub(one, y));
        let terms = [(w[0], s, t), (w[1], x, t), (w[2], s, y), (w[3], x, y)];
        let terms = terms.map(|(w, a, b)| {
            let area = g.mul(a, b);
            (Q::ONE, g.mul(w, area))
        });
        let whole = g.plain_sum(&terms);
        let open = Expander::new(&mut g).normal_form(whole).expect("a polynomial");
        let found = paired(&mut g, open);
        assert_ne!(found, open);
        let gap = g.sub(found, whole);
        let gap = Expander::new(&mut g).normal_form(gap).expect("a polynomial");
        assert_eq!(g.as_number(gap), Some(Q::ZERO));
        assert!(cost(&g, found) < 30, "{}", crate::display::show(&g, found));
    }
}
