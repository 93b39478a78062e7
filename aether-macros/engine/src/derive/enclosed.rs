//! Ranges of unknowns in the form in which they were found, where a coordinate is known to be no longer than its point.

use crate::expr::{Graph, Id, Node};
use crate::interval::Interval;
use crate::rational::Q;

/// An interval that contains all values of an expression.
pub(super) fn enclosed(g: &Graph, id: Id) -> Interval {
    let range = match g.node(id) {
        Node::Sum(c, terms) => terms.iter().fold(Interval::point(c.to_f64()), |sum, &(q, t)| {
            sum.add(enclosed(g, t).scale(q.to_f64()))
        }),
        Node::Product(factors) if is_cosine(g, factors) => Interval::new(-1.0, 1.0),
        Node::Product(factors) => {
            let power =
                |&(base, e): &(Id, Id)| Some(enclosed(g, base).pow(g.as_number(e)?.to_f64()));
            let powers: Option<Vec<Interval>> = factors.iter().map(power).collect();
            powers.map_or(Interval::ALL, |powers| {
                powers.into_iter().fold(Interval::point(1.0), Interval::mul)
            })
        }
        _ => Interval::ALL,
    };
    range.intersection(g.range(id))
}

/// Whether factors are those of x / √(x² + y² + …).
fn is_cosine(g: &Graph, factors: &[(Id, Id)]) -> bool {
    let [a, b] = factors else { return false };
    let over_length = |length: &(Id, Id), x: &(Id, Id)| {
        let exponents = [length, x].map(|f| g.as_number(f.1));
        let Node::Sum(c, terms) = g.node(length.0) else { return false };
        let is_square = |id: Id| matches!(g.node(id), Node::Product(f) if f[..] == [(x.0, f[0].1)] && g.as_number(f[0].1) == Some(Q::int(2)));
        exponents == [Some(Q::HALF.neg()), Some(Q::ONE)]
            && !c.is_negative()
            && terms.iter().all(|&(q, t)| !q.is_negative() && g.range(t).nonnegative())
            && terms.iter().any(|&(q, t)| q == Q::ONE && is_square(t))
    };
    over_length(a, b) || over_length(b, a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Leaf;

    #[test]
    fn a_cosine_lies_between_minus_one_and_one() {
        let mut g = Graph::new();
        let [x, y] = [0, 1].map(|i| g.leaf(Leaf::Out(i), "x", Interval::ALL));
        let squares = [x, y].map(|x| (Q::ONE, g.powi(x, 2)));
        let sum = g.plain_sum(&squares);
        let length = g.sqrt(sum);
        let cosine = g.div(x, length);
        let height = g.sum(Q::HALF, &[(Q::HALF.neg(), cosine)]);
        assert_eq!(enclosed(&g, height), Interval::new(0.0, 1.0));
        // Twice that coordinate is longer.
        let other = g.sum(Q::ZERO, &[(Q::HALF, squares[0].1), (Q::ONE, squares[1].1)]);
        let length = g.sqrt(other);
        let ratio = g.div(x, length);
        assert_eq!(enclosed(&g, ratio), Interval::ALL);
    }
}
