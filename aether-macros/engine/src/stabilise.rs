//! Choosing among equal forms of an expression by measured error.
//!
//! Every sum and logarithm is rewritten in the ways that experts use (expm1, ln_1p, conjugates,
//! multiplying out and factoring, half angles); each form is evaluated in double precision on the
//! test points and compared with double-double; a form is taken if it is clearly more accurate.
//! The graph bounds the number of forms, so the outcome is the same on every machine.

use std::collections::HashMap;

use crate::eval::Evaluator;
use crate::expr::{Fun, Graph, Id, Leaf, Node};
use crate::jacobian::{cost, factor_out};
use crate::number::{Dd, Number};
use crate::poly::Expander;
use crate::rational::Q;

/// An input assignment in double precision.
pub type Inputs = HashMap<Leaf, f64>;

/// The largest relative error of an expression in `f64` over the points, against double-double of
/// the same expression; non-finite truths are skipped.
pub fn worst_error(g: &Graph, form: Id, truth: &[f64], points: &[Inputs]) -> f64 {
    let mut worst = 0.0f64;
    for (inputs, &t) in points.iter().zip(truth) {
        if !t.is_finite() {
            continue;
        }
        let at = |l: Leaf| inputs.get(&l).copied().unwrap_or(f64::NAN);
        let v = Evaluator::<f64>::new(g, &at).value(form);
        let e = if v == t { 0.0 } else { ((v - t) / t).abs() };
        worst = worst.max(if e.is_nan() { f64::INFINITY } else { e });
    }
    worst
}

/// The values of an expression at the points, through double-double.
pub fn truths(g: &Graph, id: Id, points: &[Inputs]) -> Vec<f64> {
    points
        .iter()
        .map(|inputs| {
            let at = |l: Leaf| Dd::from_f64(inputs.get(&l).copied().unwrap_or(f64::NAN));
            Evaluator::<Dd>::new(g, &at).value(id).to_f64()
        })
        .collect()
}

/// Errors up to this many units in the last place are not worth a rewrite.
const GOOD: f64 = 64.0 * f64::EPSILON;

/// The expression with every part in its most accurate form.
pub fn stabilise(g: &mut Graph, id: Id, points: &[Inputs]) -> Id {
    // Most expressions are fine as they are: measure once before taking them apart.
    let truth = truths(g, id, points);
    if worst_error(g, id, &truth, points) <= GOOD {
        return id;
    }
    rebuild(g, id, points, &mut HashMap::new(), 3)
}

fn rebuild(g: &mut Graph, id: Id, points: &[Inputs], memo: &mut HashMap<Id, Id>, depth: u8) -> Id {
    if let Some(&r) = memo.get(&id) {
        return r;
    }
    let rebuilt = match g.node(id).clone() {
        Node::Sum(c, terms) => {
            let t: Vec<_> =
                terms.iter().map(|&(q, t)| (q, rebuild(g, t, points, memo, depth))).collect();
            g.sum(c, &t)
        }
        Node::Product(f) => {
            let f: Vec<_> =
                f.iter().map(|&(b, e)| (rebuild(g, b, points, memo, depth), e)).collect();
            g.product(&f)
        }
        Node::Call(f, args) => {
            let a: Vec<_> = args.iter().map(|&a| rebuild(g, a, points, memo, depth)).collect();
            g.call(f, &a)
        }
        _ => id,
    };
    let best = best_form(g, id, rebuilt, points, depth);
    memo.insert(id, best);
    best
}

fn best_form(g: &mut Graph, original: Id, rebuilt: Id, points: &[Inputs], depth: u8) -> Id {
    let truth = truths(g, original, points);
    let mut best = original;
    let mut error = worst_error(g, original, &truth, points);
    if rebuilt != original {
        let e = worst_error(g, rebuilt, &truth, points);
        if e < error {
            (best, error) = (rebuilt, e);
        }
    }
    if error <= GOOD || depth == 0 {
        return best;
    }
    for form in forms(g, original) {
        // The parts of a new form deserve a look of their own.
        let form = rebuild_children(g, form, points, depth - 1);
        let e = worst_error(g, form, &truth, points);
        if e < error / 4.0 || (e <= error && cost(g, form) < cost(g, best)) {
            (best, error) = (form, e);
        }
        if error <= GOOD {
            break;
        }
    }
    best
}

fn rebuild_children(g: &mut Graph, form: Id, points: &[Inputs], depth: u8) -> Id {
    let mut memo = HashMap::new();
    match g.node(form).clone() {
        Node::Product(f) => {
            let f: Vec<_> =
                f.iter().map(|&(b, e)| (rebuild(g, b, points, &mut memo, depth), e)).collect();
            g.product(&f)
        }
        Node::Call(f, args) => {
            let a: Vec<_> = args.iter().map(|&a| rebuild(g, a, points, &mut memo, depth)).collect();
            g.call(f, &a)
        }
        Node::Sum(c, terms) if c.is_zero() && terms.len() == 1 => {
            let t = rebuild_children(g, terms[0].1, points, depth);
            g.sum(c, &[(terms[0].0, t)])
        }
        _ => form,
    }
}

/// Other forms of a node that are equal in exact arithmetic.
fn forms(g: &mut Graph, id: Id) -> Vec<Id> {
    let mut out = Vec::new();
    match g.node(id).clone() {
        Node::Sum(c, terms) => {
            out.extend(one_minus(g, c, &terms));
            out.extend(squares(g, c, &terms));
            out.extend(conjugate(g, c, &terms));
            let f = factor_out(g, id);
            out.push(f);
            for open in [crate::expr::UNKNOWNS | crate::expr::OUTS, crate::expr::Deps::MAX] {
                out.extend(Expander::new(g).only(open).normal_form(id));
            }
        }
        Node::Call(Fun::Ln, args) => {
            if let Node::Sum(c, terms) = g.node(args[0]).clone()
                && c == Q::ONE
            {
                let rest = g.sum(Q::ZERO, &terms);
                out.push(g.call(Fun::Ln1p, &[rest]));
            }
        }
        _ => {}
    }
    out.retain(|f| *f != id);
    out
}

/// c - c·T: through expm1 for powers and exponentials, through the half angle for cosines.
fn one_minus(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let [(q, t)] = *terms else { return None };
    if c.is_zero() || q != c.neg() {
        return None;
    }
    if let Node::Call(Fun::Cos, a) = g.node(t).clone() {
        let half = g.sum(Q::ZERO, &[(Q::HALF, a[0])]);
        let s = g.call(Fun::Sin, &[half]);
        let s2 = g.powi(s, 2);
        return Some(g.sum(Q::ZERO, &[(c.mul(Q::int(2))?, s2)]));
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

/// a² - b² as (a - b)(a + b).
fn squares(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
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
        let half: Option<Vec<(Id, Id)>> = g
            .factors(t)
            .into_iter()
            .map(|(b, e)| {
                let e = g.as_number(e)?;
                let h = e.mul(Q::HALF)?;
                e.is_even().then(|| (b, g.number(h)))
            })
            .collect();
        let t = g.product(&half?);
        Some(g.mul(k, t))
    };
    let (a, b) = (root(pos)?, root(neg)?);
    let d = g.sub(a, b);
    let s = g.add(a, b);
    Some(g.mul(d, s))
}

/// a - √b as (a² - b) / (a + √b), and with two roots alike.
fn conjugate(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let mut pair: Vec<(Q, Id)> = terms.to_vec();
    if !c.is_zero() {
        pair.push((c, g.int(1)));
    }
    let [(p, s), (q, t)] = pair[..] else { return None };
    let is_root = |g: &mut Graph, id: Id| {
        g.factors(id).iter().any(|(_, e)| g.as_number(*e).is_some_and(|e| e.den() == 2))
    };
    if p.is_negative() == q.is_negative() || !(is_root(g, s) || is_root(g, t)) {
        return None;
    }
    let square = |g: &mut Graph, q: Q, t: Id| {
        let t2 = g.powi(t, 2);
        let q2 = g.number(q.mul(q)?);
        Some(g.mul(q2, t2))
    };
    let a2 = square(g, p, s)?;
    let b2 = square(g, q, t)?;
    let top = g.sub(a2, b2);
    let top = Expander::new(g).normal_form(top).unwrap_or(top);
    let bottom = g.sum(Q::ZERO, &[(p, s), (q.neg(), t)]);
    Some(g.div(top, bottom))
}
