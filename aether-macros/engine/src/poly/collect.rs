//! Polynomials in the unknowns with coefficients that are known.

use super::{Expander, Mono, Poly};
use crate::expr::{Graph, Id, UNKNOWNS};
use crate::rational::Q;

/// (product of unknown atoms, its coefficient) pairs, for an expression that is a polynomial in what is
/// unknown.
pub fn coefficients(g: &mut Graph, id: Id) -> Option<Vec<(Id, Id)>> {
    let function = Expander::new(g).expand(id).filter(|f| f.den.is_empty())?;
    let mut groups: Vec<(Mono, Vec<(Mono, Q)>)> = Vec::new();
    for (m, q) in function.num.0 {
        let (open, known): (Mono, Mono) =
            m.into_iter().partition(|(a, _)| g.has(*a, UNKNOWNS));
        match groups.iter_mut().find(|(o, _)| *o == open) {
            Some((_, terms)) => terms.push((known, q)),
            None => groups.push((open, vec![(known, q)])),
        }
    }
    let mut expression = |(open, known): (Mono, Vec<(Mono, Q)>)| {
        let factors: Vec<(Id, Id)> =
            open.iter().map(|(a, e)| (*a, g.int(i64::from(*e)))).collect();
        let terms = Poly(known).terms(g);
        (g.product(&factors), g.sum(Q::ZERO, &terms))
    };
    Some(groups.into_iter().map(&mut expression).collect())
}

/// The expression with what is known collected: a (1 - u) + b u as a + (b - a) u, where a large common
/// part of a and b is gone before anything is multiplied.
pub fn collected(g: &mut Graph, id: Id) -> Option<Id> {
    let parts = coefficients(g, id)?;
    let terms: Vec<(Q, Id)> =
        parts.into_iter().map(|(open, known)| (Q::ONE, g.mul(known, open))).collect();
    Some(g.sum(Q::ZERO, &terms))
}
