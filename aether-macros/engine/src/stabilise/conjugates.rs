//! Differences of squares and of roots as products and quotients.

use crate::expr::{Fun, Graph, Id, Node};
use crate::jacobian::cost;
use crate::poly::Expander;
use crate::rational::Q;

/// a² - b² as (a - b)(a + b).
pub(super) fn squares(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let mut pair: Vec<(Q, Id)> = terms.to_vec();
    if !c.is_zero() {
        pair.push((c, g.int(1)));
    }
    let [(p, s), (q, t)] = pair[..] else { return None };
    if p.is_negative() == q.is_negative() {
        return None;
    }
    let (pos, neg) = if p.is_negative() { ((q, t), (p.neg(), s)) } else { ((p, s), (q.neg(), t)) };
    let mut root = |(q, t): (Q, Id)| {
        let k = g.number(q.sqrt()?);
        let t = root_of_square(g, t)?;
        Some(g.mul(k, t))
    };
    let (a, b) = (root(pos)?, root(neg)?);
    let d = g.sub(a, b);
    let s = g.add(a, b);
    Some(g.mul(d, s))
}

/// What a product is the square of. Beside other squares an exponential is one too: a² e^(2t) is (a e^t)².
fn root_of_square(g: &mut Graph, t: Id) -> Option<Id> {
    let factors = g.factors(t);
    let alone = factors.len() == 1;
    let mut halves = Vec::new();
    for (b, e) in factors {
        let h = g.as_number(e)?.mul(Q::HALF)?;
        match g.node(b).clone() {
            Node::Call(Fun::Exp, args) if !alone => {
                let half = g.sum(Q::ZERO, &[(h, args[0])]);
                halves.push((g.call(Fun::Exp, &[half]), g.int(1)));
            }
            _ if h.is_int() => halves.push((b, g.number(h))),
            _ => return None,
        }
    }
    Some(g.product(&halves))
}

/// A - √b as (A² - b) / (A + √b), where A may be a root or a sum without one. Only where both have the same sign:
/// elsewhere the sum below would cancel, next to a zero that no point that is tried may show.
pub(super) fn conjugate(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let mut all: Vec<(Q, Id)> = terms.to_vec();
    if !c.is_zero() {
        all.push((c, g.int(1)));
    }
    let last = all.iter().rposition(|&(_, t)| is_root(g, t))?;
    let (q, root) = all.remove(last);
    if all.len() > 1 && all.iter().any(|&(_, t)| is_root(g, t)) {
        return None;
    }
    let rest = g.sum(Q::ZERO, &all);
    let a2 = g.powi(rest, 2);
    let b2 = g.powi(root, 2);
    let top = g.sum(Q::ZERO, &[(Q::ONE, a2), (q.mul(q)?.neg(), b2)]);
    let top = Expander::new(g).normal_form(top).unwrap_or(top);
    let bottom = g.sum(Q::ZERO, &[(Q::ONE, rest), (q.neg(), root)]);
    let plain = g.sum(c, terms);
    // What is long has terms that cancel in other places, which no point that is tried may show.
    if cost(g, top) > LONGER * cost(g, plain) {
        return None;
    }
    let form = g.div(top, bottom);
    let other = g.sum(Q::ZERO, &[(q, root)]);
    let opposed = g.mul(rest, other);
    if g.range(opposed).nonpositive() {
        return Some(form);
    }
    if g.range(opposed).nonnegative() {
        return None;
    }
    Some(g.if_positive(opposed, plain, form))
}

/// How many times as long as a difference that of its squares may be.
const LONGER: usize = 3;

/// 1 - a / (1 + a) as 1 / (1 + a): over a sum that divides one of the terms, without multiplying anything out.
pub(crate) fn over_sum(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let minus = g.int(-1);
    let bottom = terms.iter().find_map(|&(_, t)| {
        let factors = g.factors(t);
        let is_sum = |&(b, e): &(Id, Id)| e == minus && matches!(g.node(b), Node::Sum(..));
        factors.into_iter().find(is_sum).map(|(b, _)| b)
    })?;
    let mut tops = vec![(c, bottom)];
    for &(q, t) in terms {
        tops.push((q, g.mul(t, bottom)));
    }
    let top = g.sum(Q::ZERO, &tops);
    Some(g.div(top, bottom))
}

fn is_root(g: &mut Graph, id: Id) -> bool {
    g.factors(id).iter().any(|(_, e)| g.as_number(*e).is_some_and(|e| e.den() == 2))
}
