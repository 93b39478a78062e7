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
    /// Between which numbers the unknowns lie, and whether what is infinite there has a value; or all uniforms, and it has none.
    part: Option<Vec<Interval>>,
    known: HashMap<Id, Option<Reach>>,
}

/// The values of an expression.
#[derive(Clone, Copy)]
struct Reach {
    range: Interval,
    /// Whether it may be infinite.
    pole: bool,
}

impl Reach {
    fn finite(range: Interval) -> Self {
        Reach { range, pole: false }
    }

    /// The product, unless it may be zero times infinite.
    fn times(self, other: Reach) -> Option<Reach> {
        let has_zero = |range: Interval| range.lo <= 0.0 && range.hi >= 0.0;
        let lost = self.pole && has_zero(other.range) || other.pole && has_zero(self.range);
        let range = self.range.mul(other.range);
        (!lost).then_some(Reach { range, pole: self.pole || other.pole })
    }
}

/// Into how many parts the range of each uniform is divided, to see where one expression is zero and another infinite.
const PARTS: u32 = 4;

/// Whether the coordinates of a map have values at all uniforms, numbers or infinite.
pub fn has_values(graph: &Graph, unknowns: u32, ids: &[Id]) -> bool {
    let part = |i: u32| {
        let end = |k: u32| f64::from(k) / f64::from(PARTS);
        Interval::new(end(i), end(i + 1).min(LARGEST))
    };
    let all = (0..PARTS.pow(unknowns))
        .map(|k| (0..unknowns).map(|i| part(k / PARTS.pow(i) % PARTS)).collect::<Vec<Interval>>());
    all.into_iter().all(|part| {
        let mut tame = Tame { part: Some(part), ..Tame::new(graph, true, true) };
        tame.all(ids)
    })
}

impl<'a> Tame<'a> {
    /// For the expressions of a graph.
    pub fn new(graph: &'a Graph, uniforms: bool, lenient: bool) -> Self {
        Tame { graph, uniforms, lenient, part: None, known: HashMap::new() }
    }

    /// Whether none of the expressions is ever NaN, for numbers as parameters that do not overflow.
    pub fn all(&mut self, ids: &[Id]) -> bool {
        ids.iter().all(|&id| self.range(id).is_some())
    }

    /// The values of an expression; `None` if there may be a place where it has none.
    fn range(&mut self, id: Id) -> Option<Reach> {
        if let Some(known) = self.known.get(&id) {
            return *known;
        }
        let within =
            |reach: Reach| Reach { range: reach.range.intersection(self.graph.range(id)), ..reach };
        let range = self.of_node(id).map(within);
        self.known.insert(id, range);
        range
    }

    fn of_node(&mut self, id: Id) -> Option<Reach> {
        match self.graph.node(id) {
            Node::Leaf(Leaf::Unknown(i)) if self.uniforms => {
                let part = self.part.as_ref().map(|part| part[usize::from(*i)]);
                Some(Reach::finite(part.unwrap_or(Interval::new(0.0, LARGEST))))
            }
            Node::Leaf(_) | Node::Number(_) | Node::Float(_) | Node::Pi => {
                Some(Reach::finite(self.graph.range(id)))
            }
            Node::Sum(c, terms) => {
                let start = Reach::finite(Interval::point(c.to_f64()));
                terms.iter().try_fold(start, |sum, (q, t)| {
                    let term = self.range(*t)?;
                    let range = sum.range.add(term.range.scale(q.to_f64()));
                    // Two that are infinite may leave nothing.
                    let both = sum.pole && term.pole;
                    (!both).then_some(Reach { range, pole: sum.pole || term.pole })
                })
            }
            Node::Product(factors) => {
                let start = Reach::finite(Interval::point(1.0));
                factors.iter().try_fold(start, |product, (base, exponent)| {
                    product.times(self.power(*base, *exponent)?)
                })
            }
            Node::Call(f, args) => self.call(*f, args).map(Reach::finite),
            Node::If(test, yes, no) => {
                self.range(*test)?;
                let (yes, no) = (self.range(*yes)?, self.range(*no)?);
                Some(Reach { range: yes.range.hull(no.range), pole: yes.pole || no.pole })
            }
            Node::Root(_) => None,
        }
    }

    fn power(&mut self, base: Id, exponent: Id) -> Option<Reach> {
        let Reach { range, pole } = self.range(base)?;
        if pole {
            return None;
        }
        let divides = self.graph.as_number(exponent).filter(|q| q.is_negative());
        if let Some(q) = divides.filter(|_| range.lo == 0.0 && self.part.is_some()) {
            // A root of a sum that comes out below zero is no number.
            let is_sum = matches!(self.graph.node(base), Node::Sum(..));
            let least = libm::pow(range.hi, q.to_f64());
            let range = Interval::new(least, f64::INFINITY);
            return (q.is_int() || !is_sum).then_some(Reach { range, pole: true });
        }
        self.finite_power(range, base, exponent).map(Reach::finite)
    }

    fn finite_power(&mut self, b: Interval, base: Id, exponent: Id) -> Option<Interval> {
        let Some(q) = self.graph.as_number(exponent) else {
            let e = self.finite(exponent)?;
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

    /// The values of an expression that is nowhere infinite.
    fn finite(&mut self, id: Id) -> Option<Interval> {
        self.range(id).filter(|reach| !reach.pole).map(|reach| reach.range)
    }

    fn call(&mut self, f: Fun, args: &[Id]) -> Option<Interval> {
        let ranges: Vec<Interval> = args.iter().map(|&a| self.finite(a)).collect::<Option<_>>()?;
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
        // Infinite at zero, where what is above the line is not; and zero over zero there.
        let other = g.add(rest, by_parameter);
        let (infinite, undefined) = (g.div(rest, u), g.div(by_parameter, other));
        let tame = |id, uniforms| Tame::new(&g, uniforms, false).all(&[id]);
        assert!(tame(pole_at_one, true) && !tame(pole_at_one, false));
        assert!(!tame(pole_at_zero, true) && !tame(by_parameter, true) && tame(times, true));
        assert!(has_values(&g, 1, &[infinite, times]) && !tame(infinite, true));
        assert!(!has_values(&g, 1, &[by_parameter]) && !has_values(&g, 1, &[undefined]));
    }
}
