//! Which expressions have a value wherever they are evaluated, so that no check for one is emitted.

use std::collections::HashMap;

use crate::expr::{Fun, Graph, Id, Leaf, Node};
use crate::interval::Interval;
use crate::rational::Q;

/// The largest uniform that is asked for: that of single precision. Ends at one are open.
const LARGEST: f64 = 1.0 - 1.0 / (1 << 24) as f64;
/// Exponentials up to here are numbers in single precision.
const LARGEST_EXPONENT: f64 = 80.0;

/// Ranges of expressions that have a value everywhere.
pub struct Tame<'a> {
    graph: &'a Graph,
    /// Whether unknowns are uniforms.
    uniforms: bool,
    /// Whether roots are those of a map, which exist but for rounding.
    lenient: bool,
    known: HashMap<Id, Option<Interval>>,
}

impl<'a> Tame<'a> {
    /// For the expressions of a graph.
    pub fn new(graph: &'a Graph, uniforms: bool, lenient: bool) -> Self {
        Tame { graph, uniforms, lenient, known: HashMap::new() }
    }

    /// Whether none of the expressions is ever NaN, for numbers as parameters that do not overflow.
    pub fn all(&mut self, ids: &[Id]) -> bool {
        ids.iter().all(|&id| self.range(id).is_some())
    }

    /// The values of an expression; `None` if there may be a place where it has none.
    fn range(&mut self, id: Id) -> Option<Interval> {
        if let Some(known) = self.known.get(&id) {
            return *known;
        }
        let range = self.of_node(id).map(|range| range.intersection(self.graph.range(id)));
        self.known.insert(id, range);
        range
    }

    fn of_node(&mut self, id: Id) -> Option<Interval> {
        match self.graph.node(id) {
            Node::Leaf(Leaf::Unknown(_)) if self.uniforms => Some(Interval::new(0.0, LARGEST)),
            Node::Leaf(_) | Node::Number(_) | Node::Float(_) | Node::Pi => {
                Some(self.graph.range(id))
            }
            Node::Sum(c, terms) => {
                let start = Some(Interval::point(c.to_f64()));
                terms
                    .iter()
                    .fold(start, |sum, (q, t)| Some(sum?.add(self.range(*t)?.scale(q.to_f64()))))
            }
            Node::Product(factors) => {
                factors.iter().try_fold(Interval::point(1.0), |product, (base, exponent)| {
                    Some(product.mul(self.power(*base, *exponent)?))
                })
            }
            Node::Call(f, args) => self.call(*f, args),
            Node::If(test, yes, no) => {
                self.range(*test)?;
                Some(self.range(*yes)?.hull(self.range(*no)?))
            }
            Node::Root(_) => None,
        }
    }

    fn power(&mut self, base: Id, exponent: Id) -> Option<Interval> {
        let b = self.range(base)?;
        let Some(q) = self.graph.as_number(exponent) else {
            let e = self.range(exponent)?;
            let usual = b.lo > 0.0 || (b.lo == 0.0 && e.lo >= 0.0);
            return usual.then(|| b.powers(e));
        };
        if q.is_negative() && b.lo <= 0.0 && b.hi >= 0.0 {
            return None;
        }
        if q.is_int() {
            return Some(b.pow(q.to_f64()));
        }
        // A sum that may be zero may come out below.
        let is_sum = matches!(self.graph.node(base), Node::Sum(..));
        let root_exists = b.lo > 0.0 || (b.lo == 0.0 && !is_sum) || (self.lenient && q == Q::HALF);
        root_exists.then(|| b.pow(q.to_f64()))
    }

    fn call(&mut self, f: Fun, args: &[Id]) -> Option<Interval> {
        let ranges: Vec<Interval> = args.iter().map(|&a| self.range(a)).collect::<Option<_>>()?;
        let a = *ranges.first()?;
        let exists = match f {
            Fun::Sin | Fun::Cos | Fun::SinPi | Fun::CosPi => true,
            Fun::Atan | Fun::Atan2 | Fun::Turn | Fun::TurnTo => true,
            Fun::Abs | Fun::Sign | Fun::Tanh | Fun::Cbrt | Fun::Asinh | Fun::Erf | Fun::Erfc => {
                true
            }
            Fun::Exp | Fun::ExpM1 => a.hi <= LARGEST_EXPONENT,
            Fun::Ln => a.lo > 0.0,
            Fun::Ln1p => a.lo > -1.0,
            _ => false,
        };
        let range = if ranges.len() == 1 { a.call(f) } else { Interval::ALL };
        exists.then_some(range)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poles_and_roots_are_seen() {
        let mut g = Graph::new();
        let u = g.leaf(Leaf::Unknown(0), "u", Interval::new(0.0, 1.0));
        let p = g.leaf(Leaf::Param(0), "p", Interval::ALL);
        let (one, minus) = (g.int(1), g.int(-1));
        let neg = g.mul(minus, u);
        let rest = g.add(one, neg);
        let (pole_at_one, pole_at_zero) = (g.div(one, rest), g.div(one, u));
        let (by_parameter, times) = (g.div(u, p), g.mul(u, p));
        let tame = |id, uniforms| Tame::new(&g, uniforms, false).all(&[id]);
        assert!(tame(pole_at_one, true) && !tame(pole_at_one, false));
        assert!(!tame(pole_at_zero, true) && !tame(by_parameter, true) && tame(times, true));
    }
}
