//! Sums in canonical form, and the identities between their terms.

use std::collections::BTreeMap;

use super::{Fun, Graph, Id, Node};
use crate::rational::Q;

impl Graph {
    /// constant + Σ coefficient · term, in canonical form.
    pub fn sum(&mut self, constant: Q, terms: &[(Q, Id)]) -> Id {
        let mut total = constant;
        let mut collected: BTreeMap<Id, Q> = BTreeMap::new();
        let mut overflow = false;
        let mut add = |map: &mut BTreeMap<Id, Q>, q: Q, t: Id| {
            let entry = map.entry(t).or_insert(Q::ZERO);
            match entry.add(q) {
                Some(s) => *entry = s,
                None => overflow = true,
            }
        };
        for &(q, t) in terms {
            match self.node(t).clone() {
                Node::Number(n) => match q.mul(n).and_then(|p| total.add(p)) {
                    Some(s) => total = s,
                    None => add(&mut collected, q, t),
                },
                Node::Sum(c, inner) => {
                    let scaled: Option<Vec<(Q, Id)>> =
                        inner.iter().map(|&(p, x)| Some((q.mul(p)?, x))).collect();
                    match (scaled, q.mul(c).and_then(|p| total.add(p))) {
                        (Some(scaled), Some(s)) => {
                            total = s;
                            for (p, x) in scaled {
                                add(&mut collected, p, x);
                            }
                        }
                        _ => add(&mut collected, q, t),
                    }
                }
                _ => add(&mut collected, q, t),
            }
        }
        if overflow {
            // Too large for exact coefficients: keep the sum as it was written.
            let kept = terms.iter().copied().filter(|(q, _)| !q.is_zero()).collect();
            return self.intern(Node::Sum(constant, kept));
        }
        collected.retain(|_, q| !q.is_zero());
        self.sum_rules(total, collected)
    }

    /// Identities between terms of a sum: sin² + cos² = 1, 1 + expm1(x) = exp(x).
    fn sum_rules(&mut self, mut total: Q, mut terms: BTreeMap<Id, Q>) -> Id {
        let one = self.int(1);
        let ids: Vec<Id> = terms.keys().copied().collect();
        for t in ids {
            let Some(&q) = terms.get(&t) else { continue };
            for (other, merged, sign) in self.partners(t) {
                let found = if other == one {
                    total
                } else {
                    terms.get(&other).copied().unwrap_or(Q::ZERO)
                };
                if found.is_zero() || found != if sign { q } else { q.neg() } {
                    continue;
                }
                terms.remove(&t);
                if other == one {
                    total = Q::ZERO;
                } else {
                    terms.remove(&other);
                }
                let mut rest: Vec<(Q, Id)> = terms.iter().map(|(&t, &q)| (q, t)).collect();
                rest.push((found, merged));
                return self.sum(total, &rest);
            }
        }
        // In the map's order, which is the canonical one.
        let list: Vec<(Q, Id)> = terms.into_iter().map(|(t, q)| (q, t)).collect();
        match (list.len(), total.is_zero()) {
            (0, _) => self.number(total),
            (1, true) if list[0].0 == Q::ONE => list[0].1,
            _ => self.intern(Node::Sum(total, list)),
        }
    }

    /// For a term t: triples (s, m, same) such that q·t + q·s = q·m (same) or s·q' + t·q = m·q' with q' = -q.
    fn partners(&mut self, t: Id) -> Vec<(Id, Id, bool)> {
        let mut found = Vec::new();
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
