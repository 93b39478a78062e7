//! Replacing subexpressions.

use std::collections::{BTreeMap, HashMap};

use super::{Graph, Id, Node, Root};
use crate::rational::Q;

impl Graph {
    /// Rebuilds an expression with some subexpressions replaced (the largest match wins).
    pub fn substitute(&mut self, id: Id, map: &BTreeMap<Id, Id>) -> Id {
        let mut memo = HashMap::new();
        self.substitute_memo(id, map, &mut memo)
    }

    fn substitute_memo(
        &mut self,
        id: Id,
        map: &BTreeMap<Id, Id>,
        memo: &mut HashMap<Id, Id>,
    ) -> Id {
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
