//! Means of exponentials: 1 + r (e^t - 1) = (1 - r) + r e^t, which lies between 1 and e^t.
//!
//! A truncated exponential is written ln(1 + r (e^t - 1)). That is accurate near its one end, where r is
//! small; near the other, 1 - r is, and t + ln(1 + (1 - r)(e^-t - 1)) is the same.

use crate::expr::{Fun, Graph, Id, Node};
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
