//! Means of exponentials: 1 + r (e^t - 1) = (1 - r) + r e^t, which lies between 1 and e^t.
//!
//! A truncated exponential is written ln(1 + r (e^t - 1)). That is accurate near its one end, where r is
//! small; near the other, 1 - r is, and t + ln(1 + (1 - r)(e^-t - 1)) is the same.

use crate::expr::{Fun, Graph, Id, Node};
use crate::overflow::SAFE;
use crate::rational::Q;

/// r and t of an expression r (e^t - 1).
fn excess(g: &mut Graph, id: Id) -> Option<(Id, Id)> {
    let one = g.int(1);
    let factors = g.factors(id);
    let (power, t) = factors.into_iter().find_map(|(b, e)| match g.node(b) {
        Node::Call(Fun::ExpM1, args) if e == one => Some((b, args[0])),
        _ => None,
    })?;
    Some((g.div(id, power), t))
}

/// c + c r (e^t - 1) as c (1 - r) + c r e^t: two terms of one sign, where r is a fraction.
pub(super) fn weighted_mean(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let [(q, term)] = *terms else { return None };
    if c.is_zero() {
        return None;
    }
    let (r, t) = excess(g, term)?;
    let r = g.sum(Q::ZERO, &[(q.mul(c.recip()?)?, r)]);
    let one = g.int(1);
    let rest = g.sub(one, r);
    let power = g.call(Fun::Exp, &[t]);
    let weighted = g.mul(r, power);
    Some(g.sum(Q::ZERO, &[(c, rest), (c, weighted)]))
}

/// ln(1 + a) where a is close to -1: the logarithm of the mean of exponentials that 1 + a is.
pub(crate) fn by_size(g: &mut Graph, log: Id, a: Id) -> Option<Id> {
    let (q, body) = g.split(a);
    let mean = weighted_mean(g, Q::ONE, &[(q, body)])?;
    let other = g.call(Fun::Ln, &[mean]);
    let test = g.sum(Q::HALF, &[(Q::ONE, a)]);
    Some(g.if_positive(test, log, other))
}

/// q ln(1 + r (e^t - 1)) - q t as q ln(1 + (1 - r)(e^-t - 1)).
pub(super) fn other_end(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    terms.iter().find_map(|&(q, log)| {
        let Node::Call(Fun::Ln1p, args) = g.node(log).clone() else { return None };
        let (p, body) = g.split(args[0]);
        let (r, t) = excess(g, body)?;
        let r = g.sum(Q::ZERO, &[(p, r)]);
        let (k, part) = g.split(t);
        let taken = q.mul(k)?.neg();
        if !terms.contains(&(taken, part)) {
            return None;
        }
        let one = g.int(1);
        let rest = g.sub(one, r);
        let back = g.neg(t);
        let back = g.call(Fun::ExpM1, &[back]);
        let inner = g.mul(rest, back);
        let other = g.call(Fun::Ln1p, &[inner]);
        // Where e^-t is infinite: 1/∞ = 0.
        let size = g.call(Fun::Abs, &[back]);
        let finite = g.powi(size, -1);
        let plain = by_size(g, log, args[0]).unwrap_or(log);
        let plain = g.sub(plain, t);
        let other = g.if_positive(finite, other, plain);
        let others = terms.iter().filter(|x| **x != (q, log) && **x != (taken, part));
        let kept: Vec<(Q, Id)> = others.copied().chain([(q, other)]).collect();
        Some(g.sum(c, &kept))
    })
}

/// A product of sums several of which have a term e^t, or of one and e^t itself, each over it: (e^a - e^t) / (e^t - 1) as
/// (e^(a - t) - 1) / (1 - e^-t), of which nothing is out of range where e^t is, and x e^t / (e^t - x) as x / (1 - x e^-t).
pub(super) fn over_largest(g: &mut Graph, factors: &[(Id, Id)]) -> Vec<Id> {
    let sums: Vec<Vec<Id>> = factors.iter().map(|(base, _)| exponentials(g, *base)).collect();
    let mut found: Vec<Id> = Vec::new();
    for power in sums.iter().flatten() {
        let often = sums.iter().filter(|powers| powers.contains(power)).count();
        if often > 1 && !found.contains(power) {
            found.push(*power);
        }
    }
    found.into_iter().map(|power| over(g, factors, power)).collect()
}

/// The exponentials among the terms of a sum that may be out of range, or the one that it is.
fn exponentials(g: &Graph, sum: Id) -> Vec<Id> {
    let terms = match g.node(sum) {
        Node::Sum(_, terms) => &terms[..],
        _ => &[(Q::ONE, sum)],
    };
    let is_large = |t: &Id| match g.node(*t) {
        Node::Call(Fun::Exp, args) => g.range(args[0]).hi > SAFE,
        _ => false,
    };
    terms.iter().map(|(_, t)| *t).filter(is_large).collect()
}

/// The product with all of its sums that have an exponential for a term divided by it, which is multiplied in again.
fn over(g: &mut Graph, factors: &[(Id, Id)], power: Id) -> Id {
    let Node::Call(_, args) = g.node(power).clone() else { return power };
    let mut changed = Vec::new();
    for &(base, exponent) in factors {
        match g.node(base).clone() {
            Node::Sum(c, terms) if terms.iter().any(|(_, t)| *t == power) => {
                let minus = g.neg(args[0]);
                let back = g.call(Fun::Exp, &[minus]);
                let mut divided = vec![(c, back)];
                for (q, t) in terms {
                    divided.push((q, quotient(g, t, args[0])));
                }
                changed.push((g.sum(Q::ZERO, &divided), exponent));
                changed.push((power, exponent));
            }
            _ => changed.push((base, exponent)),
        }
    }
    g.product(&changed)
}

/// A term over e^t.
fn quotient(g: &mut Graph, term: Id, t: Id) -> Id {
    let minus = g.neg(t);
    let (mut left, mut exponent) = (Vec::new(), minus);
    for (base, e) in g.factors(term) {
        match g.node(base).clone() {
            Node::Call(Fun::Exp, args) => {
                let part = g.mul(args[0], e);
                exponent = g.add(exponent, part);
            }
            _ => left.push((base, e)),
        }
    }
    let (power, one) = (g.call(Fun::Exp, &[exponent]), g.int(1));
    left.push((power, one));
    g.product(&left)
}
