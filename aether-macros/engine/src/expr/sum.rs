//! Sums in canonical form, and the identities between their terms.

use super::{Fun, Graph, Id, Node};
use crate::rational::Q;

impl Graph {
    /// constant + Σ coefficient · term, in canonical form.
    pub fn sum(&mut self, constant: Q, terms: &[(Q, Id)]) -> Id {
        let mut total = constant;
        let mut collected = Terms::default();
        let mut overflow = false;
        for &(q, t) in terms {
            match self.node(t) {
                Node::Number(n) => match q.mul(*n).and_then(|p| total.add(p)) {
                    Some(s) => total = s,
                    None => overflow |= collected.add(q, t).is_none(),
                },
                Node::Sum(c, inner) => {
                    let scaled = scaled(inner, q);
                    match (scaled, q.mul(*c).and_then(|p| total.add(p))) {
                        (Some(scaled), Some(s)) => {
                            total = s;
                            for (p, x) in scaled {
                                overflow |= collected.add(p, x).is_none();
                            }
                        }
                        _ => overflow |= collected.add(q, t).is_none(),
                    }
                }
                _ => overflow |= collected.add(q, t).is_none(),
            }
        }
        if overflow {
            // Too large for exact coefficients: keep the sum as it was written.
            let kept = terms.iter().copied().filter(|(q, _)| !q.is_zero()).collect();
            return self.intern(Node::Sum(constant, kept));
        }
        collected.0.retain(|(q, _)| !q.is_zero());
        self.sum_rules(total, collected)
    }

    /// Identities between terms of a sum: sin² + cos² = 1, 1 + expm1(x) = exp(x).
    fn sum_rules(&mut self, mut total: Q, mut terms: Terms) -> Id {
        let one = self.int(1);
        for k in 0..terms.0.len() {
            let (q, t) = terms.0[k];
            for (other, merged, sign) in self.partners(t) {
                let found = if other == one { total } else { terms.of(other) };
                if found.is_zero() || found != if sign { q } else { q.neg() } {
                    continue;
                }
                if other == one {
                    total = Q::ZERO;
                }
                terms.0.retain(|(_, id)| *id != t && *id != other);
                terms.0.push((found, merged));
                return self.sum(total, &terms.0);
            }
        }
        let list = terms.0;
        match (list.len(), total.is_zero()) {
            (0, _) => self.number(total),
            (1, true) if list[0].0 == Q::ONE => list[0].1,
            _ => self.intern(Node::Sum(total, list)),
        }
    }

    /// For a term t: triples (s, m, same) such that q·t + q·s = q·m (same) or s·q' + t·q = m·q' with q' = -q.
    fn partners(&mut self, t: Id) -> Vec<(Id, Id, bool)> {
        let mut found = Vec::new();
        let merges =
            |base: Id| matches!(self.node(base), Node::Call(Fun::Sin | Fun::Cos | Fun::ExpM1, _));
        let any = match self.node(t) {
            Node::Product(factors) => factors.iter().any(|f| merges(f.0)),
            _ => merges(t),
        };
        if !any {
            return found;
        }
        let factors = self.factors(t);
        let two = self.int(2);
        let one = self.int(1);
        for (i, &(base, exp)) in factors.iter().enumerate() {
            let rest: Vec<(Id, Id)> =
                factors.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, f)| *f).collect();
            match self.node(base).clone() {
                Node::Call(Fun::Sin | Fun::Cos, args) if exp == two => {
                    let is_sin = matches!(self.node(base), Node::Call(Fun::Sin, _));
                    let other = self.call(if is_sin { Fun::Cos } else { Fun::Sin }, &args);
                    let merged = self.product(&rest);
                    let mut swapped = rest.clone();
                    swapped.push((other, two));
                    let swapped = self.product(&swapped);
                    found.push((swapped, merged, true));
                    // P - P·sin² = P·cos²
                    found.push((merged, swapped, false));
                }
                Node::Call(Fun::ExpM1, args) if exp == one => {
                    let without = self.product(&rest);
                    let e = self.call(Fun::Exp, &args);
                    let mut with = rest.clone();
                    with.push((e, one));
                    let with = self.product(&with);
                    found.push((without, with, true));
                }
                _ => {}
            }
        }
        found
    }
}

/// Terms in the order of their ids, which is the canonical one. They are few, and lists cheap.
#[derive(Default)]
struct Terms(Vec<(Q, Id)>);

impl Terms {
    /// The place of a term, or where it belongs.
    fn place(&self, id: Id) -> Result<usize, usize> {
        self.0.binary_search_by_key(&id.0, |(_, t)| t.0)
    }

    /// Adds to a coefficient; `None` if the sum does not fit.
    fn add(&mut self, q: Q, id: Id) -> Option<()> {
        match self.place(id) {
            Ok(k) => self.0[k].0 = self.0[k].0.add(q)?,
            Err(k) => self.0.insert(k, (q, id)),
        }
        Some(())
    }

    /// The coefficient of a term.
    fn of(&self, id: Id) -> Q {
        self.place(id).map_or(Q::ZERO, |k| self.0[k].0)
    }
}

/// Terms times a number, if they fit.
fn scaled(terms: &[(Q, Id)], q: Q) -> Option<Vec<(Q, Id)>> {
    let mut out = Vec::with_capacity(terms.len());
    for &(p, t) in terms {
        out.push((q.mul(p)?, t));
    }
    Some(out)
}
