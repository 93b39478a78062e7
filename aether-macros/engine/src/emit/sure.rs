//! Densities that are numbers and not negative at every finite point, so that no check for it is emitted.

use crate::expr::{Fun, Graph, Id, Leaf, Node};
use crate::hash::Set;
use crate::interval::Interval;
use crate::rational::Q;

/// Numbers below this may be rounded to zero and those above its inverse to infinity, in any precision.
const TINY: f64 = 1e-30;

/// Expressions at points with finite coordinates, where some that have been compared are finite numbers.
pub(super) struct Sure<'a> {
    graph: &'a Graph,
    /// What is a number, as something finite is computed from it. It may be infinite if that divides by it.
    numbers: Set<Id>,
    /// What is a number and not negative, and what is not zero either.
    told: [Set<Id>; 2],
    /// Between which numbers some coordinates lie.
    between: Vec<(Id, Interval)>,
}

impl<'a> Sure<'a> {
    /// Where each of `finite` has been found to be a finite number.
    pub fn new(graph: &'a Graph, finite: impl Iterator<Item = Id>) -> Self {
        let (mut numbers, mut open) = (Set::default(), finite.collect::<Vec<_>>());
        while let Some(id) = open.pop() {
            if !numbers.insert(id) {
                continue;
            }
            match graph.node(id) {
                // What is infinite on both sides of a difference leaves no number.
                Node::Sum(_, terms) => open.extend(terms.iter().map(|(_, term)| *term)),
                Node::Product(factors) => {
                    let is_power = |e: Id| graph.as_number(e).is_some_and(|e| !e.is_zero());
                    let bases = factors.iter().filter(|(_, e)| is_power(*e));
                    open.extend(bases.map(|(base, _)| *base));
                }
                Node::Call(Fun::Abs, args) => open.extend(args),
                _ => {}
            }
        }
        Sure { graph, numbers, told: Default::default(), between: Vec::new() }
    }

    /// Where, besides, these lie between numbers.
    pub fn between(mut self, coordinates: impl Iterator<Item = (Id, Interval)>) -> Self {
        self.between.extend(coordinates);
        self
    }

    /// Where, besides, these have been found not to be negative, some of them to be positive.
    pub fn told(mut self, signs: impl Iterator<Item = (Id, bool)>) -> Self {
        for (id, positive) in signs {
            self.told[usize::from(positive)].insert(id);
        }
        self
    }

    /// Whether an expression is a number and not negative, however it is rounded.
    pub fn is_positive(&self, id: Id) -> bool {
        self.positive(id).is_some()
    }

    /// Between which numbers an expression lies that is never negative; `None` if it may be, or no number.
    fn positive(&self, id: Id) -> Option<Interval> {
        let g = self.graph;
        if self.told.iter().any(|told| told.contains(&id)) {
            return Some(Interval::POSITIVE);
        }
        match g.node(id) {
            Node::Sum(c, terms) => {
                if let Some(range) = self.linear(*c, terms) {
                    return Some(range).filter(|range| range.nonnegative());
                }
                if c.is_negative() {
                    return None;
                }
                terms.iter().try_fold(Interval::point(c.to_f64()), |sum, &(q, term)| {
                    let term = self.positive(term).filter(|_| !q.is_negative())?;
                    Some(sum.add(term.scale(q.to_f64())))
                })
            }
            Node::Product(factors) => {
                factors.iter().try_fold(Interval::point(1.0), |product, &(base, exponent)| {
                    times(product, self.power(base, g.as_number(exponent)?)?)
                })
            }
            Node::Call(Fun::Abs, args) => self.number(args[0]),
            _ => Some(g.range(id)).filter(|range| g.deps(id) == 0 && range.nonnegative()),
        }
    }

    /// Between which numbers a sum of coordinates lies that lie between some.
    fn linear(&self, c: Q, terms: &[(Q, Id)]) -> Option<Interval> {
        let start = Interval::point(c.to_f64());
        terms.iter().try_fold(start, |sum, (q, term)| {
            let (_, range) = self.between.iter().find(|(id, _)| id == term)?;
            Some(sum.add(range.scale(q.to_f64())))
        })
    }

    /// A power whose exponent is a whole number of halves.
    fn power(&self, base: Id, exponent: Q) -> Option<Interval> {
        let size = if exponent.is_even() { self.number(base)? } else { self.positive(base)? };
        let e = exponent.to_f64();
        let end = |b: f64| libm::pow(b, e);
        let (a, b) = (end(size.lo), end(size.hi));
        matches!(exponent.den(), 1 | 2).then(|| Interval::new(a.min(b), a.max(b)))
    }

    /// Between which numbers the size of an expression lies that is a number of any sign.
    fn number(&self, id: Id) -> Option<Interval> {
        let is_number = match self.graph.node(id) {
            Node::Leaf(Leaf::Out(_)) => true,
            Node::Sum(_, terms) if terms.len() == 1 => self.number(terms[0].1).is_some(),
            _ => false,
        };
        if is_number || self.numbers.contains(&id) {
            return Some(Interval::POSITIVE);
        }
        self.positive(id)
    }
}

/// The product, unless it may be one of zero and infinity.
fn times(a: Interval, b: Interval) -> Option<Interval> {
    let lost = |a: Interval, b: Interval| a.lo < TINY && b.hi > 1.0 / TINY;
    (!lost(a, b) && !lost(b, a)).then(|| Interval::new(a.lo * b.lo, a.hi * b.hi))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_may_be_negative_or_no_number_is_not_sure() {
        let mut g = Graph::new();
        let [x, y] = [0, 1].map(|i| g.leaf(Leaf::Out(i), &format!("x{i}"), Interval::ALL));
        let p = g.leaf(Leaf::Param(0), "p", Interval::ALL);
        let (one, minus) = (g.int(1), g.int(-1));
        let square = g.powi(x, 2);
        let (more, other) = (g.add(one, square), g.powi(y, 2));
        let (negative, both) = (g.mul(minus, square), g.mul(square, other));
        let (less, share) = (g.add(one, negative), g.div(square, more));
        let root = g.sqrt(more);
        let density = g.div(one, root);
        let sure = |id| Sure::new(&g, std::iter::empty()).is_positive(id);
        assert!(sure(square) && sure(more) && sure(root) && sure(density) && sure(one));
        // 1 - x², x, p², x² / (1 + x²), which is infinite over infinite, and x² y², which is zero times infinite.
        assert!(![less, x, p, share, both].into_iter().any(sure));
    }

    #[test]
    fn what_a_finite_number_is_made_of_is_a_number() {
        let mut g = Graph::new();
        let x = g.leaf(Leaf::Out(0), "x", Interval::ALL);
        let [a, b] = [0, 1].map(|i| g.leaf(Leaf::Param(i), &format!("p{i}"), Interval::ALL));
        let (offset, width) = (g.sub(x, a), g.sub(b, a));
        let place = g.div(offset, width);
        let size = g.call(Fun::Abs, &[width]);
        let one = g.int(1);
        let density = g.div(one, size);
        assert!(!Sure::new(&g, std::iter::empty()).is_positive(density));
        assert!(Sure::new(&g, [place].into_iter()).is_positive(density));
        assert!(!Sure::new(&g, [place].into_iter()).is_positive(width));
    }
}
