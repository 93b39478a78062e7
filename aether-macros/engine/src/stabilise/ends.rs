//! Expressions next to the ends of [0, 1], by how far they are from each of them.

use super::conjugates::over_sum;
use crate::expr::{Fun, Graph, Id, Leaf, Node, UNKNOWNS, leaf_bit};
use crate::poly::Expander;
use crate::rational::Q;

/// (1 + a)^e (1 - a)^e in a product as (1 - a²)^e, where e is no whole number.
pub(super) fn both_sides_of_one(g: &mut Graph, factors: &[(Id, Id)]) -> Option<Id> {
    let beside_one = |g: &Graph, b: Id| match g.node(b) {
        Node::Sum(c, terms) if *c == Q::ONE => Some(terms.clone()),
        _ => None,
    };
    let power = |&(_, e): &&(Id, Id)| g.as_number(*e).is_none_or(|e| !e.is_int() && e.den() > 3);
    let (first, second, rest, e) = factors.iter().filter(power).find_map(|&(b, e)| {
        let rest = beside_one(g, b)?;
        let negated: Vec<(Q, Id)> = rest.iter().map(|&(q, t)| (q.neg(), t)).collect();
        let other = factors
            .iter()
            .position(|&(d, f)| f == e && beside_one(g, d).is_some_and(|terms| terms == negated))?;
        Some((factors.iter().position(|&f| f == (b, e))?, other, rest, e))
    })?;
    let rest = g.sum(Q::ZERO, &rest);
    let square = g.powi(rest, 2);
    let minus = g.neg(square);
    let mut factors = factors.to_vec();
    factors[first] = (g.call(Fun::Pow1p, &[minus, e]), g.int(1));
    factors.remove(second);
    Some(g.product(&factors))
}

/// A sum that is linear in a uniform u by its values at both ends, A (1 - u) + B u, where these have one sign.
pub(crate) fn between_ends(g: &mut Graph, id: Id) -> Option<Id> {
    let leaf = (0..8).map(Leaf::Unknown).find(|&l| g.deps(id) & UNKNOWNS == leaf_bit(l))?;
    let (u, zero, one) = (g.get_leaf(leaf), g.int(0), g.int(1));
    let [low, high] = [zero, one].map(|end| g.substitute(id, &[(u, end)].into()));
    let (a, b) = (g.range(low), g.range(high));
    if !(a.nonnegative() && b.nonnegative() || a.nonpositive() && b.nonpositive()) {
        return None;
    }
    let rest = g.sub(one, u);
    let terms = [g.mul(low, rest), g.mul(high, u)].map(|t| (Q::ONE, t));
    let form = g.sum(Q::ZERO, &terms);
    let gap = g.sub(id, form);
    let gap = Expander::new(g).normal_form(gap)?;
    (form != id && g.as_number(gap).is_some_and(Q::is_zero)).then_some(form)
}

/// A sum whose factors are sums that others divide, each over what divides it: in (1 - 1 / (1 + a)) (1 - u) + …, a / (1 + a).
pub(super) fn over_ends(g: &mut Graph, form: Id) -> Option<Id> {
    let Node::Sum(c, terms) = g.node(form).clone() else { return None };
    let mut over = |(q, term): (Q, Id)| {
        let factors = g.factors(term).into_iter().map(|(b, e)| match g.node(b).clone() {
            Node::Sum(c, inner) => (over_sum(g, c, &inner).unwrap_or(b), e),
            _ => (b, e),
        });
        let factors: Vec<(Id, Id)> = factors.collect();
        (q, g.product(&factors))
    };
    let terms: Vec<(Q, Id)> = terms.into_iter().map(&mut over).collect();
    let found = g.sum(c, &terms);
    (found != form).then_some(found)
}

/// 1 - I(x; a, b) as I(1 - x; b, a), for the incomplete beta function or its inverse.
pub(super) fn other_tail(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let [(q, t)] = *terms else { return None };
    let minus = q == Q::int(-1) && c == Q::ONE;
    minus.then(|| flipped(g, t)).flatten()
}

/// The angle with a given sine or cosine by the sine and cosine of half of it (from the quarter turn), which
/// tell it also where the given one is next to -1 or 1.
pub(super) fn by_halves(g: &mut Graph, f: Fun, a: Id) -> Id {
    let [less, more] = [Q::HALF.neg(), Q::HALF].map(|half| {
        let square = g.sum(Q::HALF, &[(half, a)]);
        g.sqrt(square)
    });
    match f {
        Fun::Acos => {
            let half = g.call(Fun::Atan2, &[less, more]);
            g.sum(Q::ZERO, &[(Q::int(2), half)])
        }
        _ => {
            let (half, pi) = (g.call(Fun::Atan2, &[more, less]), g.pi());
            g.sum(Q::ZERO, &[(Q::int(2), half), (Q::HALF.neg(), pi)])
        }
    }
}

/// What the incomplete beta function or its inverse leaves of one.
pub(super) fn flipped(g: &mut Graph, id: Id) -> Option<Id> {
    let Node::Call(f @ (Fun::BetaInc | Fun::BetaIncInv), args) = g.node(id).clone() else {
        return None;
    };
    Some(g.call(f, &[args[3], args[2], args[1], args[0]]))
}

/// c - c·T: through expm1 for powers and exponentials, through the half angle for cosines.
pub(super) fn one_minus(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let [(q, t)] = *terms else { return None };
    if c.is_zero() || q != c.neg() {
        return None;
    }
    // 1 - cos(a) = 2 sin²(a / 2), and 1 - cosh(a) = -2 sinh²(a / 2).
    if let Node::Call(f @ (Fun::Cos | Fun::Cosh), a) = g.node(t).clone() {
        let (sine, twice) = if f == Fun::Cos { (Fun::Sin, 2) } else { (Fun::Sinh, -2) };
        let half = g.sum(Q::ZERO, &[(Q::HALF, a[0])]);
        let s = g.call(sine, &[half]);
        let s2 = g.powi(s, 2);
        return Some(g.sum(Q::ZERO, &[(c.mul(Q::int(twice))?, s2)]));
    }
    let mut logs = Vec::new();
    for (b, e) in g.factors(t) {
        if let Node::Call(Fun::Exp, a) = g.node(b).clone() {
            logs.push((Q::ONE, g.mul(e, a[0])));
            continue;
        }
        if !g.range(b).nonnegative() {
            return None;
        }
        let l = g.call(Fun::Ln, &[b]);
        logs.push((Q::ONE, g.mul(e, l)));
    }
    let log = g.sum(Q::ZERO, &logs);
    let m = g.call(Fun::ExpM1, &[log]);
    Some(g.sum(Q::ZERO, &[(c.neg(), m)]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::Interval;

    #[test]
    fn powers_of_both_sides_of_one_are_one_power() {
        let mut g = Graph::new();
        let x = g.leaf(Leaf::Out(0), "x", Interval::new(-1.0, 1.0));
        let k = g.leaf(Leaf::Param(0), "k", Interval::new(0.0, 1e3));
        let [up, down] = [1, -1].map(|s| g.sum(Q::ONE, &[(Q::int(s), x)]));
        let factors = [(up, k), (x, g.int(1)), (down, k)];
        let square = g.powi(x, 2);
        let minus = g.neg(square);
        let power = g.call(Fun::Pow1p, &[minus, k]);
        let expected = g.mul(x, power);
        assert_eq!(both_sides_of_one(&mut g, &factors), Some(expected));
        // Different powers stay apart.
        let other = [(up, k), (down, x)];
        assert_eq!(both_sides_of_one(&mut g, &other), None);
    }
}
