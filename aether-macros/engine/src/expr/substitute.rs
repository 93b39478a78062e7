//! Replacing subexpressions.

use std::collections::BTreeMap;

use super::{Graph, Id, Node, Root, children};
use crate::hash::{Map, Set};
use crate::rational::Q;

impl Graph {
    /// Rebuilds an expression with some subexpressions replaced (the largest match wins).
    pub fn substitute(&mut self, id: Id, map: &BTreeMap<Id, Id>) -> Id {
        let mut memo = Map::default();
        self.substitute_memo(id, map, &mut memo)
    }

    /// An expression with other forms of its products, as far as one is found from a product's factors; `None` where none is.
    pub fn with_products(
        &mut self,
        written: Id,
        mut other: impl FnMut(&mut Graph, &[(Id, Id)]) -> Option<Id>,
    ) -> Option<Id> {
        let mut open = vec![written];
        let mut others = BTreeMap::new();
        let mut seen = Set::default();
        while let Some(id) = open.pop() {
            if !seen.insert(id) {
                continue;
            }
            open.extend(children(self.node(id)));
            if let Node::Product(factors) = self.node(id).clone() {
                others.extend(other(self, &factors).map(|other| (id, other)));
            }
        }
        (!others.is_empty()).then(|| self.substitute(written, &others))
    }

    fn substitute_memo(&mut self, id: Id, map: &BTreeMap<Id, Id>, memo: &mut Map<Id, Id>) -> Id {
        if let Some(&r) = map.get(&id) {
            return r;
        }
        if let Some(&r) = memo.get(&id) {
            return r;
        }
        let r = match self.node(id).clone() {
            Node::Sum(c, terms) => {
                let t: Vec<_> =
                    terms.iter().map(|&(q, t)| (q, self.substitute_memo(t, map, memo))).collect();
                self.sum(c, &t)
            }
            Node::Product(factors) => {
                let f: Vec<_> = factors
                    .iter()
                    .map(|&(b, e)| {
                        let whole = self.intern(Node::Product(vec![(b, e)]));
                        let one = self.int(1);
                        match map.get(&whole) {
                            Some(&r) => (r, one),
                            None => match self.inverse_power(b, e, map) {
                                Some(r) => r,
                                None => (
                                    self.substitute_memo(b, map, memo),
                                    self.substitute_memo(e, map, memo),
                                ),
                            },
                        }
                    })
                    .collect();
                self.product(&f)
            }
            Node::Call(f, args) => {
                let a: Vec<_> = args.iter().map(|&a| self.substitute_memo(a, map, memo)).collect();
                self.call(f, &a)
            }
            Node::If(test, yes, no) => {
                let [test, yes, no] =
                    [test, yes, no].map(|part| self.substitute_memo(part, map, memo));
                self.if_positive(test, yes, no)
            }
            // What is put in contains no bound variable, so none is captured.
            Node::Root(r) => {
                let [body, slope, target, lo, hi] = [r.body, r.slope, r.target, r.lo, r.hi]
                    .map(|part| self.substitute_memo(part, map, memo));
                self.root(Root { body, slope, target, lo, hi, ..r })
            }
            _ => id,
        };
        memo.insert(id, r);
        r
    }

    /// Replaces an expression wherever it occurs, also as some of the factors of a product or as a
    /// multiple of it among the terms of a sum.
    pub fn replace_part(&mut self, id: Id, part: Id, value: Id) -> Id {
        let mut memo = Map::from_iter([(part, value)]);
        self.replace_memo(id, (part, value, false), &mut memo)
    }

    /// The same also where integer powers of it are factors.
    pub fn replace_powers(&mut self, id: Id, part: Id, value: Id) -> Id {
        let mut memo = Map::from_iter([(part, value)]);
        self.replace_memo(id, (part, value, true), &mut memo)
    }

    fn replace_memo(&mut self, id: Id, what: (Id, Id, bool), memo: &mut Map<Id, Id>) -> Id {
        if let Some(&r) = memo.get(&id) {
            return r;
        }
        // What knows less than the part cannot contain it.
        if self.deps(what.0) & !self.deps(id) != 0 {
            return id;
        }
        let taken = self.take_part(id, what);
        let r = match self.node(taken.unwrap_or(id)).clone() {
            Node::Sum(c, terms) => {
                let t: Vec<_> =
                    terms.iter().map(|&(q, t)| (q, self.replace_memo(t, what, memo))).collect();
                self.sum(c, &t)
            }
            Node::Product(factors) => {
                let replaced = |g: &mut Graph, id, memo: &mut _| g.replace_memo(id, what, memo);
                let f: Vec<_> = factors
                    .iter()
                    .map(|&(b, e)| (replaced(self, b, memo), replaced(self, e, memo)))
                    .collect();
                self.product(&f)
            }
            Node::Call(f, args) => {
                let a: Vec<_> = args.iter().map(|&a| self.replace_memo(a, what, memo)).collect();
                self.call(f, &a)
            }
            _ => taken.unwrap_or(id),
        };
        memo.insert(id, r);
        r
    }

    /// The node with the part taken out of its factors or terms once.
    fn take_part(&mut self, id: Id, (part, value, powers): (Id, Id, bool)) -> Option<Id> {
        match (self.node(id).clone(), self.node(part).clone()) {
            (Node::Product(whole), Node::Product(p)) => {
                let power = self.power_in(&whole, &p).filter(|q| powers || *q == Q::ONE)?;
                let is_taken = |(base, _): &(Id, Id)| p.iter().any(|(b, _)| b == base);
                let mut rest: Vec<_> = whole.into_iter().filter(|f| !is_taken(f)).collect();
                rest.push((value, self.number(power)));
                Some(self.product(&rest))
            }
            (Node::Sum(c, whole), Node::Sum(d, p)) if d.is_zero() => {
                let (q, t) = *p.first()?;
                let ratio = whole.iter().find(|(_, w)| *w == t)?.0.mul(q.recip()?)?;
                let all = p
                    .iter()
                    .all(|(q, t)| whole.iter().any(|(r, w)| w == t && q.mul(ratio) == Some(*r)));
                let mut rest: Vec<_> =
                    whole.into_iter().filter(|(_, w)| !p.iter().any(|(_, t)| t == w)).collect();
                rest.push((ratio, value));
                all.then(|| self.sum(c, &rest))
            }
            _ => None,
        }
    }

    /// Which integer power of a product some factors have: u (2 - u) is the square of √u √(2 - u).
    fn power_in(&self, whole: &[(Id, Id)], part: &[(Id, Id)]) -> Option<Q> {
        if part.iter().all(|factor| whole.contains(factor)) {
            return Some(Q::ONE);
        }
        let power_of = |&(base, e): &(Id, Id)| {
            let (_, other) = whole.iter().find(|(b, _)| *b == base)?;
            self.as_number(*other)?.mul(self.as_number(e)?.recip()?).filter(|q| q.is_int())
        };
        let power = power_of(part.first()?)?;
        part.iter().all(|factor| power_of(factor) == Some(power)).then_some(power)
    }

    /// b^e where the map knows b^f for some other rational f: (b^f)^(e/f).
    fn inverse_power(&mut self, b: Id, e: Id, map: &BTreeMap<Id, Id>) -> Option<(Id, Id)> {
        let e = self.as_number(e)?;
        for f in [Q::HALF, Q::HALF.neg()] {
            let half = self.number(f);
            let known = self.intern(Node::Product(vec![(b, half)]));
            if let Some(&r) = map.get(&known) {
                let ratio = e.mul(f.recip()?)?;
                if ratio.is_int() {
                    return Some((r, self.number(ratio)));
                }
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Leaf;
    use crate::interval::Interval;

    #[test]
    fn powers_of_what_is_known_are_recognised() {
        let mut g = Graph::new();
        let [a, b, c] = [0, 1, 2].map(|i| g.leaf(Leaf::Out(i), "x", Interval::new(0.0, 9.0)));
        let s = g.leaf(Leaf::Param(0), "s", Interval::new(0.0, 9.0));
        let ab = g.mul(a, b);
        let part = g.sqrt(ab);
        let (whole, square) = (g.mul(ab, c), g.powi(s, 2));
        assert_eq!(g.replace_part(whole, part, s), whole);
        let expected = g.mul(square, c);
        assert_eq!(g.replace_powers(whole, part, s), expected);
        // No power of both is left alone.
        let (other, below) = (g.mul(ab, a), g.powi(ab, -1));
        assert_eq!(g.replace_powers(other, part, s), other);
        let expected = g.powi(square, -1);
        assert_eq!(g.replace_powers(below, part, s), expected);
    }
}
