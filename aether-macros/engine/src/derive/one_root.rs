//! Roots of a length and of a sum that is its square over something else's: of facets, 1 + (x² + y²) / z² is the square of a
//! length over z², so that √(1 + (x² + y²) / z²) / √(x² + y² + z²) is 1 / |z|.

use crate::expr::{Fun, Graph, Id, Node};
use crate::rational::Q;

/// A product in which the root of what stands above the line of a sum is that of the sum, if both have roots there: what
/// is of the size of one stays so.
pub(super) fn by_one_root(g: &mut Graph, id: Id) -> Option<Id> {
    let (coefficient, body) = g.split(id);
    let mut factors = g.factors(body);
    let half = |g: &Graph, e: Id| g.as_number(e).filter(|q| q.den() == 2);
    let roots: Vec<(Id, Q)> =
        factors.iter().filter_map(|&(base, e)| Some((base, half(g, e)?))).collect();
    let (sum, above, power, divisors) = roots.iter().find_map(|&(sum, _)| {
        let (above, divisors) = over_one_line(g, sum)?;
        let (_, power) = roots.iter().find(|(base, _)| *base == above)?;
        Some((sum, above, *power, divisors))
    })?;
    factors.retain(|(base, _)| *base != above);
    // (above / line)^power times line^power, of which all are even powers.
    factors.push((sum, g.number(power)));
    for (divisor, even) in divisors {
        let size = g.call(Fun::Abs, &[divisor]);
        factors.push((size, g.number(even.mul(power)?)));
    }
    let body = g.product(&factors);
    Some(g.sum(Q::ZERO, &[(coefficient, body)]))
}

/// What stands above the line of a sum in which something is divided by even powers, if all of it is put over these, and
/// these.
fn over_one_line(g: &mut Graph, sum: Id) -> Option<(Id, Vec<(Id, Q)>)> {
    let Node::Sum(c, terms) = g.node(sum).clone() else { return None };
    let divisors = terms.iter().find_map(|&(_, term)| {
        let powers: Vec<(Id, Q)> = g
            .factors(term)
            .into_iter()
            .filter_map(|(base, e)| Some((base, g.as_number(e)?.neg())))
            .filter(|(_, power)| power.is_even() && !power.is_negative())
            .collect();
        (!powers.is_empty()).then_some(powers)
    })?;
    let powers: Vec<(Id, Id)> = divisors.iter().map(|&(d, power)| (d, g.number(power))).collect();
    let line = g.product(&powers);
    let mut above: Vec<(Q, Id)> = terms.iter().map(|&(q, term)| (q, g.mul(term, line))).collect();
    above.push((c, line));
    Some((g.sum(Q::ZERO, &above), divisors))
}

/// A product with a root √s above a sum of s and multiples of √s, which has the root as a factor: √s / (s + a √s) is
/// 1 / (√s + a).
pub(super) fn over_its_root(g: &mut Graph, id: Id) -> Option<Id> {
    let (q, body) = g.split(id);
    let factors = g.factors(body);
    let is = |g: &Graph, e: Id, q: Q| g.as_number(e) == Some(q);
    let roots: Vec<Id> = factors.iter().filter(|f| is(g, f.1, Q::HALF)).map(|f| f.0).collect();
    let divisors: Vec<Id> =
        factors.iter().filter(|f| is(g, f.1, Q::int(-1))).map(|f| f.0).collect();
    for (s, divisor) in roots.into_iter().flat_map(|s| divisors.iter().map(move |d| (s, *d))) {
        let (Node::Sum(c, parts), Node::Sum(d, terms)) =
            (g.node(s).clone(), g.node(divisor).clone())
        else {
            continue;
        };
        let rest: Vec<(Q, Id)> = terms.iter().filter(|t| !parts.contains(t)).copied().collect();
        let has_root = |g: &mut Graph, term: Id| g.factors(term).contains(&(s, g.number(Q::HALF)));
        let whole = c == d && rest.len() + parts.len() == terms.len();
        if !whole || !rest.iter().all(|(_, term)| has_root(g, *term)) {
            continue;
        }
        let root = g.sqrt(s);
        let rest: Vec<(Q, Id)> = rest.into_iter().map(|(q, t)| (q, g.div(t, root))).collect();
        let rest = g.sum(Q::ZERO, &rest);
        let sum = g.add(root, rest);
        let (half, minus) = (g.number(Q::HALF), g.int(-1));
        let kept = factors.iter().filter(|f| **f != (s, half) && **f != (divisor, minus));
        let kept: Vec<(Id, Id)> = kept.copied().chain([(sum, minus)]).collect();
        let product = g.product(&kept);
        return Some(g.sum(Q::ZERO, &[(q, product)]));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Leaf;
    use crate::interval::Interval;

    #[test]
    fn a_root_of_a_quotient_cancels_that_of_what_stands_above_its_line() {
        let mut g = Graph::new();
        let [x, y, z] = [0, 1, 2].map(|k| g.leaf(Leaf::Out(k), "x", Interval::new(-9.0, 9.0)));
        let squares = [x, y, z].map(|x| (Q::ONE, g.powi(x, 2)));
        let (across, length) = (g.sum(Q::ZERO, &squares[..2]), g.sum(Q::ZERO, &squares));
        let slope = g.div(across, squares[2].1);
        let more = g.sum(Q::ONE, &[(Q::ONE, slope)]);
        let (half, below) = (Q::HALF, Q::HALF.neg());
        let product = |g: &mut Graph, of: [(Id, Q); 2]| {
            let factors = of.map(|(base, q)| (base, g.number(q)));
            g.product(&factors)
        };
        let size = g.call(Fun::Abs, &[z]);
        let expected = g.powi(size, -1);
        let density = product(&mut g, [(more, half), (length, below)]);
        assert_eq!(by_one_root(&mut g, density), Some(expected));
        // With a further power, that of the sum is left.
        let three = Q::ONE.add(Q::HALF).unwrap();
        let density = product(&mut g, [(more, three), (length, below)]);
        let expected = g.mul(more, expected);
        assert_eq!(by_one_root(&mut g, density), Some(expected));
        // Those of something else do not cancel, and powers without roots have no need to.
        for of in [[(more, half), (across, below)], [(more, Q::ONE), (length, below)]] {
            let density = product(&mut g, of);
            assert_eq!(by_one_root(&mut g, density), None);
        }
    }

    #[test]
    fn a_root_cancels_against_a_sum_of_its_square_and_multiples_of_it() {
        let mut g = Graph::new();
        let [x, y, z] = [0, 1, 2].map(|k| g.leaf(Leaf::Out(k), "x", Interval::new(-9.0, 9.0)));
        let squares = [x, y].map(|x| (Q::ONE, g.powi(x, 2)));
        let s = g.sum(Q::ZERO, &squares);
        let root = g.sqrt(s);
        let multiple = g.mul(z, root);
        let (sum, other) = (g.add(s, multiple), g.add(s, z));
        let density = g.div(root, sum);
        let shorter = g.add(root, z);
        let expected = g.powi(shorter, -1);
        assert_eq!(over_its_root(&mut g, density), Some(expected));
        let density = g.div(root, other);
        assert_eq!(over_its_root(&mut g, density), None);
    }
}
