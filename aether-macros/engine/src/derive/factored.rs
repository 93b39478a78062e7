//! What the terms of sums have in common, taken out of them: lengths of stretched vectors then cancel against
//! divisors, and what is left of unit vectors is one.

use crate::expr::{Graph, Id, Node};
use crate::hash::Map;
use crate::rational::Q;

/// The expressions with the common factors of all their sums outside of them.
pub(super) fn factored(g: &mut Graph, ids: &[Id]) -> Vec<Id> {
    // Forms of one density share most of their parts.
    let mut memo = Map::default();
    ids.iter().map(|&id| rebuilt(g, id, &mut memo)).collect()
}

fn rebuilt(g: &mut Graph, id: Id, memo: &mut Map<Id, Id>) -> Id {
    if let Some(&known) = memo.get(&id) {
        return known;
    }
    let made = match g.node(id).clone() {
        Node::Sum(c, terms) => {
            let terms: Vec<_> = terms.iter().map(|&(q, t)| (q, rebuilt(g, t, memo))).collect();
            let sum = g.sum(c, &terms);
            let sum = without_content(g, sum);
            length_of_unit(g, sum).unwrap_or(sum)
        }
        Node::Product(factors) => {
            let factors: Vec<_> = factors.iter().map(|&(b, e)| (rebuilt(g, b, memo), e)).collect();
            g.product(&factors)
        }
        Node::Call(f, args) => {
            let args: Vec<_> = args.iter().map(|&a| rebuilt(g, a, memo)).collect();
            g.call(f, &args)
        }
        _ => id,
    };
    memo.insert(id, made);
    made
}

/// The factors that all these terms have, each with the power nearest to one of those that it has in them.
fn common(g: &mut Graph, terms: &[(Q, Id)]) -> Vec<(Id, Id)> {
    let mut all = g.factors(terms[0].1);
    for &(_, term) in &terms[1..] {
        let factors = g.factors(term);
        all.retain_mut(|(base, e)| {
            let Some((_, other)) = factors.iter().find(|(b, _)| b == base) else { return false };
            let powers = [*e, *other].map(|e| g.as_number(e));
            match powers {
                [Some(p), Some(q)] if p.is_negative() == q.is_negative() => {
                    *e = if q.abs() < p.abs() { *other } else { *e };
                    true
                }
                _ => e == other,
            }
        });
    }
    all
}

/// A sum as a product with the factors that all its terms have, and a number that their coefficients have.
fn without_content(g: &mut Graph, sum: Id) -> Id {
    let product = match g.node(sum).clone() {
        Node::Sum(c, terms) if c.is_zero() && terms.len() > 1 => {
            let outside = common(g, &terms);
            let outside = g.product(&outside);
            let rest: Vec<_> = terms.iter().map(|&(q, t)| (q, g.div(t, outside))).collect();
            let inside = g.sum(Q::ZERO, &rest);
            g.mul(outside, inside)
        }
        _ => sum,
    };
    let (q, body) = g.split(product);
    let mut parts = Vec::new();
    for (base, e) in g.factors(body) {
        let scale = match g.node(base) {
            Node::Sum(c, terms) if c.is_zero() && !terms[0].0.is_negative() => terms[0].0,
            _ => Q::ONE,
        };
        let inner = scale.recip().map(|scale| g.sum(Q::ZERO, &[(scale, base)]));
        let inner = inner.unwrap_or(base);
        parts.extend([(g.number(scale), e), (length_of_unit(g, inner).unwrap_or(inner), e)]);
    }
    let whole = g.product(&parts);
    g.sum(Q::ZERO, &[(q, whole)])
}

/// One, if the sum is that of the squares of a unit vector's coordinates.
fn length_of_unit(g: &mut Graph, sum: Id) -> Option<Id> {
    let squares = |g: &mut Graph, unit: [Id; 3]| unit.map(|x| (Q::ONE, g.powi(x, 2)));
    let of_unit = g.units().to_vec().into_iter().any(|unit| {
        let squares = squares(g, unit);
        g.plain_sum(&squares) == sum
    });
    of_unit.then(|| g.int(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Leaf;
    use crate::interval::Interval;

    #[test]
    fn a_vector_over_its_stretched_length() {
        let mut g = Graph::new();
        let unit = [0, 1, 2].map(|k| g.leaf(Leaf::Out(k), "x", Interval::new(-1.0, 1.0)));
        g.declare_unit(unit);
        let a = g.leaf(Leaf::Param(0), "a", Interval::new(0.1, 1.0));
        let squares = |g: &mut Graph, scales: [Id; 3]| {
            let scaled = [0, 1, 2].map(|k| g.mul(scales[k], unit[k]));
            scaled.map(|x| g.powi(x, 2))
        };
        let one = g.int(1);
        let stretched = squares(&mut g, [one, one, a]);
        let length = g.plain_sum(&stretched.map(|s| (Q::ONE, s)));
        // 4 a² x²/s² + 4 a² y²/s² + 4 a⁴ z²/s² with s = x² + y² + a² z² is 4 a²/s.
        let scale = g.div(a, length);
        let scale = g.powi(scale, 2);
        let terms = stretched.map(|t| (Q::int(4), g.mul(t, scale)));
        let sum = g.plain_sum(&terms);
        let square = g.powi(a, 2);
        let expected = g.div(square, length);
        let expected = g.sum(Q::ZERO, &[(Q::int(4), expected)]);
        assert_eq!(factored(&mut g, &[sum]), [expected]);
        let whole = squares(&mut g, [a, a, a]);
        let whole = g.plain_sum(&whole.map(|s| (Q::ONE, s)));
        let square = g.powi(a, 2);
        assert_eq!(factored(&mut g, &[whole]), [square]);
    }
}
