//! Polynomials in the unknowns with coefficients that are known.

use super::{Expander, Mono, Poly};
use crate::expr::{Graph, Id, Node, UNKNOWNS};
use crate::rational::Q;

/// (product of unknown atoms, its coefficient) pairs, for an expression that is a polynomial in what is
/// unknown.
pub fn coefficients(g: &mut Graph, id: Id) -> Option<Vec<(Id, Id)>> {
    let function = Expander::new(g).expand(id).filter(|f| f.den.is_empty())?;
    let mut groups: Vec<(Mono, Vec<(Mono, Q)>)> = Vec::new();
    for (m, q) in function.num.0 {
        let (open, known): (Vec<_>, Vec<_>) = m.iter().partition(|(a, _)| g.has(*a, UNKNOWNS));
        let (open, known): (Mono, Mono) = (open.into(), known.into());
        match groups.iter_mut().find(|(o, _)| *o == open) {
            Some((_, terms)) => terms.push((known, q)),
            None => groups.push((open, vec![(known, q)])),
        }
    }
    let mut expression = |(open, known): (Mono, Vec<(Mono, Q)>)| {
        let factors: Vec<(Id, Id)> = open.iter().map(|(a, e)| (*a, g.int(i64::from(*e)))).collect();
        let terms = Poly(known).terms(g);
        (g.product(&factors), g.sum(Q::ZERO, &terms))
    };
    Some(groups.into_iter().map(&mut expression).collect())
}

/// A sum with terms of equal unknown factors gathered: b (1 - u) - a (1 - u) as (b - a) (1 - u), where a
/// large common part of a and b is gone before anything is multiplied.
pub fn gathered(g: &mut Graph, id: Id) -> Id {
    let Node::Sum(c, terms) = g.node(id).clone() else { return id };
    let mut groups: Vec<(Id, Vec<(Q, Id)>)> = Vec::new();
    for (q, t) in terms {
        let (open, known): (Vec<_>, Vec<_>) =
            g.factors(t).into_iter().partition(|(b, e)| g.has(*b, UNKNOWNS) || g.has(*e, UNKNOWNS));
        let (open, known) = (g.product(&open), g.product(&known));
        match groups.iter_mut().find(|(o, _)| *o == open) {
            Some((_, terms)) => terms.push((q, known)),
            None => groups.push((open, vec![(q, known)])),
        }
    }
    let mut term = |(open, known): (Id, Vec<(Q, Id)>)| {
        let known = g.sum(Q::ZERO, &known);
        (Q::ONE, g.mul(known, open))
    };
    let terms: Vec<(Q, Id)> = groups.into_iter().map(&mut term).collect();
    g.sum(c, &terms)
}
