//! Sums collected by the powers of a coordinate, whose coefficients are squares: 1 - 2 w + w² - x + 2 w x as (w - 1)² + (2 w - 1) x.
//!
//! A discriminant is multiplied out before it is simplified. Where a coefficient of parameters was a square, what is left of
//! the sum next to its zero are the roundings of all terms.

use crate::expr::{Graph, Id, Node, OUTS};
use crate::rational::Q;
use crate::sorted::sort_by_key;

/// The forms of a sum, by each coordinate in it, that have a square for a coefficient.
pub(super) fn by_coordinate(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Vec<Id> {
    let mut variables: Vec<Id> = Vec::new();
    for (_, t) in terms {
        for (base, _) in g.factors(*t) {
            let is_leaf = matches!(g.node(base), Node::Leaf(_)) && g.has(base, OUTS);
            if is_leaf && !variables.contains(&base) {
                variables.push(base);
            }
        }
    }
    variables.into_iter().filter_map(|z| collected(g, c, terms, z)).collect()
}

/// The terms that have one power of a variable, over that.
struct Coefficient {
    power: i32,
    constant: Q,
    terms: Vec<(Q, Id)>,
}

/// Σ c_k z^k, if some c_k is a square of several terms.
fn collected(g: &mut Graph, c: Q, terms: &[(Q, Id)], z: Id) -> Option<Id> {
    let z_alone = g.deps(z);
    let mut all = vec![Coefficient { power: 0, constant: c, terms: Vec::new() }];
    for &(q, t) in terms {
        let (mut power, mut rest) = (0, Vec::new());
        for (base, e) in g.factors(t) {
            if base == z {
                power = g.as_number(e).filter(|e| e.is_int() && !e.is_negative())?.to_i32()?;
            } else if g.has(base, z_alone) || g.has(e, z_alone) {
                return None;
            } else {
                rest.push((base, e));
            }
        }
        let place = all.iter().position(|found| found.power == power);
        let place = place.unwrap_or_else(|| {
            all.push(Coefficient { power, constant: Q::ZERO, terms: Vec::new() });
            all.len() - 1
        });
        if rest.is_empty() {
            all[place].constant = all[place].constant.add(q)?;
        } else {
            all[place].terms.push((q, g.product(&rest)));
        }
    }
    sort_by_key(&mut all, |found| found.power);
    let (mut squares, mut sum) = (false, Vec::new());
    for Coefficient { power, constant, terms } in all {
        let square = square(g, constant, &terms);
        squares |= square.is_some();
        let coefficient = square.unwrap_or_else(|| g.sum(constant, &terms));
        let power = g.powi(z, i64::from(power));
        sum.push((Q::ONE, g.mul(coefficient, power)));
    }
    squares.then(|| g.sum(Q::ZERO, &sum))
}

/// A sum a s² + b s t + d t² with b² = 4 a d as a (s + b / (2 a) t)², where t may be one.
fn square(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let two = Q::int(2);
    let mut roots: Vec<(Q, Id)> = Vec::new();
    let mut cross = None;
    for &(q, t) in terms {
        match g.factors(t)[..] {
            [(base, e)] if g.as_number(e) == Some(two) => roots.push((q, base)),
            _ if cross.is_none() => cross = Some((q, t)),
            _ => return None,
        }
    }
    if !c.is_zero() {
        roots.push((c, g.int(1)));
    }
    let ([(a, s), (d, t)], Some((b, mixed))) = (&roots[..], cross) else { return None };
    let product = g.mul(*s, *t);
    let is_square = product == mixed && b.mul(b)? == Q::int(4).mul(*a)?.mul(*d)?;
    if !is_square || a.is_negative() {
        return None;
    }
    let ratio = b.mul(two.mul(*a)?.recip()?)?;
    let root = g.sum(Q::ZERO, &[(Q::ONE, *s), (ratio, *t)]);
    let square = g.powi(root, 2);
    Some(g.sum(Q::ZERO, &[(*a, square)]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::show;
    use crate::expr::Leaf;
    use crate::interval::Interval;

    #[test]
    fn coefficients_that_are_squares_are_found() {
        let mut g = Graph::new();
        let x = g.leaf(Leaf::Out(0), "x", Interval::new(0.0, 1.0));
        let [w, a] = [(0, "w"), (1, "a")].map(|(i, n)| g.leaf(Leaf::Param(i), n, Interval::ALL));
        let (wx, ax) = (g.mul(w, x), g.mul(a, x));
        let (w2, a2, wa) = (g.powi(w, 2), g.powi(a, 2), g.mul(w, a));
        let q = Q::int;
        let forms = |g: &mut Graph, c: i64, terms: &[(Q, Id)]| -> Vec<String> {
            let found = by_coordinate(g, q(c), terms);
            found.into_iter().map(|form| show(g, form)).collect()
        };
        let plain = [(q(-2), w), (q(1), w2), (q(-1), x), (q(2), wx)];
        assert_eq!(forms(&mut g, 1, &plain), ["(-1 + w)² + x (-1 + 2 w)"]);
        let two = [(q(4), w2), (q(-12), wa), (q(9), a2), (q(1), ax)];
        assert_eq!(forms(&mut g, 0, &two), ["x a + 4 (w - 3 a / 2)²"]);
        // No square, or nothing but one.
        assert!(forms(&mut g, 2, &plain).is_empty());
        assert!(forms(&mut g, 1, &plain[..2]).is_empty());
    }
}
