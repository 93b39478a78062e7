//! Intervals that contain every value of an expression, from those of its parts.

use super::{Fun, Graph, Id, Node};
use crate::interval::Interval;
use crate::rational::Q;
use crate::sorted;

impl Graph {
    /// The interval of a node that is not in the graph yet.
    pub(super) fn range_of_new(&self, node: &Node) -> Interval {
        self.part_of_unit(node).unwrap_or_else(|| self.range_of(node))
    }

    /// The interval of a node as far as those of its parts tell.
    pub(super) fn range_of(&self, node: &Node) -> Interval {
        match node {
            Node::Number(q) => Interval::point(q.to_f64()),
            Node::Float(bits) => Interval::point(f64::from_bits(*bits)),
            Node::Pi => Interval::point(std::f64::consts::PI),
            Node::Leaf(l) => self.leaf_ranges.get(l).copied().unwrap_or(Interval::ALL),
            Node::Sum(c, terms) => {
                let range = terms.iter().fold(Interval::point(c.to_f64()), |s, (q, t)| {
                    s.add(self.range(*t).scale(q.to_f64()))
                });
                let known = if c.is_zero() { self.difference_of_powers(terms) } else { None };
                known.map_or(range, |known| range.intersection(known))
            }
            Node::Product(factors) => self.range_of_product(factors),
            Node::Call(Fun::Pow1p, _) => Interval::POSITIVE,
            Node::Call(Fun::BetaInc | Fun::BetaIncInv, _) => Interval::new(0.0, 1.0),
            Node::Call(Fun::LnBeta, _) => Interval::ALL,
            Node::Call(Fun::TurnTo, args) => {
                let half = std::f64::consts::PI;
                self.range(args[1]).add(Interval::new(-half, half))
            }
            Node::Call(f, args) => match args[..] {
                [a] => self.range(a).call(*f),
                [y, x] if self.range(x).nonnegative() => {
                    Interval::quadrants(self.range(y), self.range(x))
                }
                [y, _] if self.range(y).nonnegative() => Interval::new(0.0, std::f64::consts::PI),
                _ => Interval::new(-std::f64::consts::PI, std::f64::consts::PI),
            },
            Node::If(_, yes, no) => self.range(*yes).hull(self.range(*no)),
            Node::Root(r) => self.range_of_root(r),
        }
    }

    /// Of a difference of equal powers, which increase with what they are powers of: the sign that the difference of
    /// these has, if it is known.
    fn difference_of_powers(&self, terms: &[(Q, Id)]) -> Option<Interval> {
        let [(q, a), (r, b)] = *terms else { return None };
        let ((x, n), (y, m)) = (self.power_of(a)?, self.power_of(b)?);
        let is_odd = n.is_int() && n.num() % 2 != 0;
        let increases = is_odd || [x, y].iter().all(|id| self.range(*id).nonnegative());
        if q != r.neg() || n != m || n.is_negative() || !increases {
            return None;
        }
        // What is negative throughout is known by its negative.
        [Q::ONE, Q::int(-1)].into_iter().find_map(|sign| {
            let mut difference = vec![(sign, x), (sign.neg(), y)];
            sorted::sort_by_key(&mut difference, |(_, id)| *id);
            let known = self.index.find(&self.nodes, &Node::Sum(Q::ZERO, difference)).ok()?;
            let range = self.range(known).scale((sign.to_f64() * q.to_f64()).signum());
            match (range.lo >= 0.0, range.hi <= 0.0) {
                (true, false) => Some(Interval::POSITIVE),
                (false, true) => Some(Interval::POSITIVE.scale(-1.0)),
                _ => None,
            }
        })
    }

    /// What an expression is a power of, and which, if that is a number.
    fn power_of(&self, id: Id) -> Option<(Id, Q)> {
        let Node::Product(factors) = self.node(id) else { return None };
        let [(base, exponent)] = factors[..] else { return None };
        Some((base, self.as_number(exponent)?))
    }

    /// What an expression is the square of.
    pub fn square_of(&self, id: Id) -> Option<Id> {
        self.power_of(id).filter(|(_, n)| *n == Q::int(2)).map(|(base, _)| base)
    }

    fn range_of_product(&self, factors: &[(Id, Id)]) -> Interval {
        let power = |b: Id| factors.iter().find(|f| f.0 == b).and_then(|f| self.as_number(f.1));
        let minus = Q::int(-1);
        let known = self
            .quotients
            .iter()
            .find(|(a, b, _)| power(*a) == Some(Q::ONE) && power(*b) == Some(minus));
        let (skipped, first) = match known {
            Some((a, b, range)) => (vec![*a, *b], *range),
            None => self
                .quotient_of_sums(factors)
                .or_else(|| self.part_of_length(factors))
                .unwrap_or((vec![], Interval::point(1.0))),
        };
        factors.iter().filter(|(b, _)| !skipped.contains(b)).fold(first, |p, (b, e)| {
            p.mul(match self.as_number(*e) {
                Some(q) => self.range(*b).pow(q.to_f64()),
                None => self.range(*b).powers(self.range(*e)),
            })
        })
    }

    /// A quotient of two sums of the same terms among the factors, with the range of their quotient.
    fn quotient_of_sums(&self, factors: &[(Id, Id)]) -> Option<(Vec<Id>, Interval)> {
        let sums = |power: i64| {
            factors
                .iter()
                .filter(move |(_, e)| self.as_number(*e) == Some(Q::int(power)))
                .filter_map(|(b, _)| match self.node(*b) {
                    Node::Sum(c, terms) => Some((*b, c, terms)),
                    _ => None,
                })
        };
        sums(1).find_map(|(top, c, above)| {
            sums(-1).find_map(|(bottom, d, below)| {
                let coefficient =
                    |t: Id| above.iter().find(|a| a.1 == t).map_or(0.0, |(q, _)| q.to_f64());
                if above.iter().any(|(_, t)| below.iter().all(|b| b.1 != *t)) {
                    return None;
                }
                let terms =
                    below.iter().map(|(q, t)| (coefficient(*t), q.to_f64(), self.range(*t)));
                let range = Interval::quotient_of_sums((c.to_f64(), d.to_f64()), terms.collect())?;
                Some((vec![top, bottom], range))
            })
        })
    }

    /// A length √(q a² + ...) among the divisors and an a that makes part of it, with the range of their quotient: that of a
    /// coordinate of a normalised vector.
    fn part_of_length(&self, factors: &[(Id, Id)]) -> Option<(Vec<Id>, Interval)> {
        let half = Some(Q::HALF.neg());
        let length = |(base, e): &(Id, Id)| match self.node(*base) {
            Node::Sum(c, terms) if self.as_number(*e) == half => Some((*base, c, terms)),
            _ => None,
        };
        factors.iter().filter_map(length).find_map(|(sum, c, terms)| {
            let adds = |(q, t): &(Q, Id)| !q.is_negative() && self.range(*t).nonnegative();
            if c.is_negative() || !terms.iter().all(adds) {
                return None;
            }
            terms.iter().find_map(|&(q, square)| {
                let Node::Product(square) = self.node(square) else { return None };
                let is_root = |(base, e): &(Id, Id)| {
                    let twice = self.as_number(*e)?.mul(Q::HALF)?;
                    let root = factors.iter().find(|f| f.0 == *base)?;
                    (self.as_number(root.1)? == twice).then_some(twice)
                };
                let exponents: Vec<Q> = square.iter().map(is_root).collect::<Option<_>>()?;
                let parts = square.iter().zip(exponents);
                let part = parts.fold(Interval::point(1.0), |p, ((base, _), e)| {
                    p.mul(self.range(*base).pow(e.to_f64()))
                });
                let most = 1.0 / q.to_f64().sqrt();
                let range = match (part.nonnegative(), part.nonpositive()) {
                    (true, _) => Interval::new(0.0, most),
                    (_, true) => Interval::new(-most, 0.0),
                    _ => Interval::new(-most, most),
                };
                Some((square.iter().map(|f| f.0).chain([sum]).collect(), range))
            })
        })
    }

    /// The squares of some coordinates of a unit vector add up to at most one.
    fn part_of_unit(&self, node: &Node) -> Option<Interval> {
        let Node::Sum(c, terms) = node else { return None };
        if !c.is_zero() || terms.len() != 2 || terms.iter().any(|(q, _)| *q != Q::ONE) {
            return None;
        }
        let (a, b) = (self.square_of(terms[0].1)?, self.square_of(terms[1].1)?);
        self.units
            .iter()
            .any(|u| u.contains(&a) && u.contains(&b))
            .then_some(Interval::new(0.0, 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Leaf;

    #[test]
    fn powers_are_in_the_order_of_what_they_are_powers_of() {
        let mut g = Graph::new();
        let [a, b] = [0, 1].map(|i| g.leaf(Leaf::Param(i), "p", Interval::ALL));
        let powers = |g: &mut Graph, n| [g.powi(a, n), g.powi(b, n)];
        let ([a2, b2], [a3, b3], [a0, b0]) =
            (powers(&mut g, 2), powers(&mut g, 3), powers(&mut g, -3));
        let difference = g.sub(b, a);
        let before = g.sub(b3, a3);
        assert_eq!(g.range(before), Interval::ALL);
        g.assume(difference, Interval::POSITIVE);
        assert_eq!(g.range(before), Interval::POSITIVE);
        let thrice = g.sum(Q::ZERO, &[(Q::int(3), b3), (Q::int(-3), a3)]);
        assert_eq!(g.range(thrice), Interval::POSITIVE);
        let negative = g.sub(a3, b3);
        assert_eq!((g.range(negative).lo, g.range(negative).hi), (f64::NEG_INFINITY, 0.0));
        // Squares and reciprocals of numbers of unknown sign are in any order.
        let others = [g.sub(b2, a2), g.sub(b0, a0)];
        assert!(others.iter().all(|id| g.range(*id) == Interval::ALL));
    }

    #[test]
    fn coordinates_of_normalised_vectors_are_at_most_one() {
        let mut g = Graph::new();
        let [a, x, y] = [0, 1, 2].map(|i| {
            let range = if i == 0 { Interval::new(0.1, 1.0) } else { Interval::ALL };
            g.leaf(Leaf::Param(i), "p", range)
        });
        let stretched = g.mul(a, x);
        let squares = [stretched, y].map(|part| (Q::ONE, g.powi(part, 2)));
        let sum = g.sum(Q::ZERO, &squares);
        let length = g.sqrt(sum);
        let [first, second, whole] = [stretched, y, x].map(|part| g.div(part, length));
        assert_eq!(g.range(first), Interval::new(-1.0, 1.0));
        assert_eq!(g.range(second), Interval::new(-1.0, 1.0));
        // What is stretched before it is measured may have been longer.
        assert_eq!(g.range(whole), Interval::ALL);
        let size = g.call(Fun::Abs, &[y]);
        let positive = g.div(size, length);
        assert!(g.range(positive).nonnegative());
    }

    #[test]
    fn squares_of_what_is_not_negative_are_in_its_order() {
        let mut g = Graph::new();
        let [a, b] = [0, 1].map(|i| g.leaf(Leaf::Param(i), "p", Interval::POSITIVE));
        let difference = g.sub(b, a);
        g.assume(difference, Interval::POSITIVE);
        let (a2, b2) = (g.powi(a, 2), g.powi(b, 2));
        let squares = g.sub(b2, a2);
        assert_eq!(g.range(squares), Interval::POSITIVE);
    }
}
