//! Where a body has no value: `x.sqrt().powi(2)` is x by the rules of the graph, and no number where x is negative.

use super::body::Body;
use crate::expr::{Fun, Graph, Id, Node, UNKNOWNS};
use crate::monotone::sign_at;
use crate::rational::Q;

/// At how many points it is looked whether a function is defined.
const POINTS: u32 = 512;

/// A function of the body that is not defined everywhere.
#[derive(Clone, Copy)]
pub(super) struct Partial {
    /// What it is taken of.
    of: Id,
    /// The call, if it is no power.
    call: Option<Id>,
    /// It has a value where 1 + side · x is not negative, or without a side x itself.
    side: Option<i64>,
}

impl Partial {
    /// Whether the range of what it is taken of leaves open if it has a value.
    fn is_open(&self, g: &Graph) -> bool {
        let range = g.range(self.of);
        let known = match self.side {
            None => range.nonnegative(),
            Some(1) => range.lo >= -1.0,
            Some(_) => range.hi <= 1.0,
        };
        !known && g.has(self.of, UNKNOWNS)
    }

    /// What must not be negative.
    fn margin(&self, g: &mut Graph) -> Id {
        match self.side {
            None => self.of,
            Some(side) => g.sum(Q::ONE, &[(Q::int(side), self.of)]),
        }
    }

    /// Whether some expressions have no value where it has none. A third power has a root on both sides of zero, which
    /// `powf` has not.
    fn shows(&self, g: &Graph, expressions: &[Id]) -> bool {
        let third = |e: Q| e.den() == 3;
        let root = |e: Id| g.as_number(e).is_none_or(|e| !e.is_int() && !third(e));
        let is_root = |id: &Id| match g.node(*id) {
            Node::Product(factors) => {
                factors.iter().any(|&(base, e)| base == self.of && self.side.is_none() && root(e))
            }
            _ => false,
        };
        self.call.is_some_and(|call| expressions.contains(&call)) || expressions.iter().any(is_root)
    }
}

impl Body<'_> {
    /// Notes the functions that the value of a function of the body consists of, if they are not defined everywhere.
    pub(super) fn note_partial(&mut self, value: Id) {
        // In what is solved for a root, ends tell where that is.
        if self.bound > 0 {
            return;
        }
        let g = &self.graph;
        let body = match g.node(value) {
            Node::Sum(c, terms) if c.is_zero() && terms.len() == 1 => terms[0].1,
            _ => value,
        };
        let Node::Product(factors) = g.node(body) else {
            return self.partial.extend(of_call(g, body));
        };
        for &(base, exponent) in factors {
            if g.as_number(exponent).is_none_or(|e| !e.is_int()) {
                self.partial.push(Partial { of: base, call: None, side: None });
            }
            self.partial.extend(of_call(g, base));
        }
    }

    /// Whether the functions of the body are defined on this way, as far as the coordinates that were made of them do not
    /// show it: where these have left a function away, that is a comparison like others.
    pub(super) fn is_defined(&mut self, outputs: &[Id]) -> bool {
        let partial = std::mem::take(&mut self.partial);
        if !partial.iter().any(|p| p.is_open(&self.graph)) {
            return true;
        }
        let expressions = self.graph.within(outputs);
        let first = self.comparisons();
        let mut known = self.known_here();
        known.extend(&self.requirements);
        for (k, p) in partial.iter().enumerate() {
            // Comparisons that were made tell of others.
            if !p.is_open(&self.graph) || p.shows(&self.graph, &expressions) {
                continue;
            }
            let margin = p.margin(&mut self.graph);
            let defined = sign_at(&self.graph, margin, POINTS, &known) == Some(1);
            if !defined && !self.decide_at(first + k, margin) {
                return false;
            }
        }
        true
    }
}

/// Where a call has a value, if that is not everywhere.
fn of_call(g: &Graph, call: Id) -> impl Iterator<Item = Partial> {
    let (of, sides): (Id, &[Option<i64>]) = match g.node(call) {
        Node::Call(Fun::Ln, args) => (args[0], &[None]),
        Node::Call(Fun::Ln1p, args) => (args[0], &[Some(1)]),
        Node::Call(Fun::Asin | Fun::Acos | Fun::Atanh, args) => (args[0], &[Some(1), Some(-1)]),
        _ => (call, &[]),
    };
    sides.iter().map(move |&side| Partial { of, call: Some(call), side })
}
