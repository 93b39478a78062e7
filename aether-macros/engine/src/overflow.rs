//! What measuring cannot show: quotients of exponentials that stay finite where their parts overflow, and
//! differences of squares of parameters that are nearly equal, which random parameters are not.
//!
//! e^a - 1 overflows long before a quotient of two of them does. With e^b - 1 = -e^b (e^-b - 1) the
//! quotient becomes a single exponential of a difference, for positive b; and likewise
//! ln(1 + r (e^t - 1)) = t + ln(1 + (1 - r)(e^-t - 1)). Nothing can be measured here, because
//! double-double has the exponents of a double: the choice follows from the sign.

mod tails;

use std::collections::HashMap;

use crate::expr::{Fun, Graph, Id, Leaf, Node};
use crate::hash::Set;
use crate::rational::Q;
use crate::stabilise::by_size;

/// Exponents up to this one overflow neither in double nor in single precision.
pub(crate) const SAFE: f64 = 80.0;

/// The expression with its quotients of exponentials guarded; itself if there is none.
pub fn guard(g: &mut Graph, id: Id) -> Id {
    let parts = g.within(&[id]).into_iter().collect();
    rebuild(g, id, &mut HashMap::new(), &parts)
}

/// The same of one of the `parts` of an expression.
fn rebuild(g: &mut Graph, id: Id, memo: &mut HashMap<Id, Id>, parts: &Set<Id>) -> Id {
    if let Some(&known) = memo.get(&id) {
        return known;
    }
    let guarded = match g.node(id).clone() {
        Node::Sum(c, terms) => {
            let terms: Vec<_> =
                terms.iter().map(|&(q, t)| (q, rebuild(g, t, memo, parts))).collect();
            squares_of_parameters(g, c, &terms).unwrap_or_else(|| g.sum(c, &terms))
        }
        Node::Product(factors) => {
            let whole = together(g, factors.clone());
            let plain = quotient(g, id, &whole).unwrap_or_else(|| {
                let factors: Vec<_> =
                    factors.iter().map(|&(b, e)| (rebuild(g, b, memo, parts), e)).collect();
                g.product(&factors)
            });
            match tails::quotient(g, &factors) {
                Some((small, other)) => {
                    let factors = g.factors(other);
                    let other = quotient(g, other, &factors).unwrap_or(other);
                    tails::unless_vanishing(g, small, plain, other)
                }
                None => plain,
            }
        }
        Node::If(test, yes, no) => {
            let [first, no] = [yes, no].map(|side| rebuild(g, side, memo, parts));
            let before = g.if_positive(test, yes, no);
            match *g.node(first) {
                // What was guarded by this test asks first whether it takes the other side anyway.
                Node::If(_, other, rest) if other == no && rest == before => first,
                _ => g.if_positive(test, first, no),
            }
        }
        Node::Call(Fun::Ln1p, args) => logarithm(g, id, args[0], parts).unwrap_or(id),
        Node::Call(Fun::ErfcInv, args) => tails::quantile(g, id, args[0]).unwrap_or(id),
        Node::Call(f, args) => {
            let args: Vec<_> = args.iter().map(|&a| rebuild(g, a, memo, parts)).collect();
            g.call(f, &args)
        }
        _ => id,
    };
    memo.insert(id, guarded);
    guarded
}

/// a² - b² for two parameters as (a - b) (a + b).
fn squares_of_parameters(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let [(p, s), (q, t)] = *terms else { return None };
    let opposite = p == Q::ONE && q == Q::int(-1) || p == Q::int(-1) && q == Q::ONE;
    if !c.is_zero() || !opposite {
        return None;
    }
    let parameter = |g: &Graph, square: Id| match g.node(square) {
        Node::Product(f) => match f[..] {
            [(base, e)] if g.as_number(e) == Some(Q::int(2)) => {
                matches!(g.node(base), Node::Leaf(Leaf::Param(_))).then_some(base)
            }
            _ => None,
        },
        _ => None,
    };
    let (a, b) = (parameter(g, s)?, parameter(g, t)?);
    let (difference, sum) = (g.sum(Q::ZERO, &[(p, a), (q, b)]), g.add(a, b));
    Some(g.mul(difference, sum))
}

/// The argument of `exp_m1`, if that (or its absolute value) is what the expression is.
fn power(g: &Graph, id: Id) -> Option<Id> {
    match g.node(id) {
        Node::Call(Fun::ExpM1, args) => Some(args[0]),
        Node::Call(Fun::Abs, args) => power(g, args[0]),
        _ => None,
    }
}

/// The same, if the argument may be large.
fn large(g: &Graph, id: Id) -> Option<Id> {
    power(g, id).filter(|&argument| g.range(argument).hi > SAFE)
}

/// e^-a - 1 (its absolute value) in place of e^a - 1, which has the other sign.
fn reversed(g: &mut Graph, id: Id, a: Id, sign: &mut Q) -> Id {
    let negated = g.neg(a);
    let flipped = g.call(Fun::ExpM1, &[negated]);
    if matches!(g.node(id), Node::Call(Fun::Abs, _)) {
        return g.call(Fun::Abs, &[flipped]);
    }
    *sign = sign.neg();
    flipped
}

/// Divisors (e^b + 1)(e^b - 1), which had been taken apart, as e^2b - 1.
fn together(g: &mut Graph, mut factors: Vec<(Id, Id)>) -> Vec<(Id, Id)> {
    let minus_one = g.int(-1);
    let one = g.int(1);
    let divisors = factors.clone().into_iter().filter(|(_, e)| *e == minus_one);
    for (less, _) in divisors {
        let Node::Call(Fun::ExpM1, args) = g.node(less).clone() else { continue };
        let exp = g.call(Fun::Exp, &args);
        let more = g.add(one, exp);
        if factors.contains(&(more, minus_one)) {
            factors.retain(|&(b, e)| e != minus_one || (b != less && b != more));
            let twice = g.sum(Q::ZERO, &[(Q::int(2), args[0])]);
            factors.push((g.call(Fun::ExpM1, &[twice]), minus_one));
        }
    }
    factors
}

/// … / (e^b - 1), with exponentials in the numerator.
fn quotient(g: &mut Graph, id: Id, factors: &[(Id, Id)]) -> Option<Id> {
    let minus_one = g.int(-1);
    let one = g.int(1);
    let b = factors.iter().find(|(_, e)| *e == minus_one).and_then(|&(f, _)| large(g, f))?;
    let mut exponent = vec![(Q::int(-1), b)];
    let mut rest = Vec::new();
    let mut sign = Q::ONE;
    for &(base, e) in factors {
        match g.node(base).clone() {
            _ if e == minus_one && power(g, base) == Some(b) => {
                let flipped = reversed(g, base, b, &mut sign);
                rest.push((flipped, minus_one));
            }
            _ if e == one && power(g, base).is_some() => {
                let a = power(g, base)?;
                exponent.push((Q::ONE, a));
                let flipped = reversed(g, base, a, &mut sign);
                rest.push((flipped, one));
            }
            Node::Call(Fun::Exp, args) if e == one => exponent.push((Q::ONE, args[0])),
            _ => rest.push((base, e)),
        }
    }
    let exponent = g.sum(Q::ZERO, &exponent);
    rest.push((g.call(Fun::Exp, &[exponent]), one));
    let product = g.product(&rest);
    let other = g.sum(Q::ZERO, &[(sign, product)]);
    Some(g.if_positive(b, other, id))
}

/// ln(1 + r (e^t - 1)), one of the `parts` of an expression.
fn logarithm(g: &mut Graph, id: Id, argument: Id, parts: &Set<Id>) -> Option<Id> {
    let (_, product) = g.split(argument);
    let one = g.int(1);
    let (power, t) = g.factors(product).into_iter().find_map(|(b, e)| {
        let t = if e == one { large(g, b) } else { None };
        t.map(|t| (b, t))
    })?;
    let r = g.div(argument, power);
    let rest = g.sub(one, r);
    let negated = g.neg(t);
    let small = g.call(Fun::ExpM1, &[negated]);
    let inner = g.mul(rest, small);
    let log = g.call(Fun::Ln1p, &[inner]);
    let log = by_size(g, log, inner).unwrap_or(log);
    let other = g.add(t, log);
    // For small r the other form cancels: it is for where the power is infinite, and 1/∞ = 0.
    let size = g.call(Fun::Abs, &[power]);
    let finite = g.powi(size, -1);
    let guarded = g.if_positive(finite, id, other);
    if !parts.contains(&log) || !g.range(t).nonnegative() {
        return Some(guarded);
    }
    // If its logarithm is there anyway, that form takes no second one where half of t or more is left.
    let left = g.sum(Q::ZERO, &[(Q::ONE, t), (Q::int(2), log)]);
    Some(g.if_positive(left, other, guarded))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::evaluate;
    use crate::expr::Leaf;
    use crate::interval::Interval;

    #[test]
    fn truncated_exponential_on_both_sides_of_overflow() {
        let mut g = Graph::new();
        let s = g.leaf(Leaf::Param(0), "s", Interval::ALL);
        let u = g.leaf(Leaf::Unknown(0), "u", Interval::new(0.0, 1.0));
        let top = g.call(Fun::ExpM1, &[s]);
        let inner = g.mul(u, top);
        let log = g.call(Fun::Ln1p, &[inner]);
        let at = |g: &Graph, id: Id, s: f64, u: f64| {
            evaluate::<f64>(g, id, &|l| if l == Leaf::Param(0) { s } else { u })
        };
        let guarded = guard(&mut g, log);
        // ln(1 + u (e^s - 1)) is s + ln u for large s.
        assert_eq!(at(&g, guarded, 800.0, 0.5), 800.0 + 0.5f64.ln());
        assert_eq!(at(&g, guarded, -2.0, 0.5), at(&g, log, -2.0, 0.5));
        // Also where 1 - u is one.
        assert_eq!(at(&g, guarded, 800.0, 1e-32), 800.0 + 1e-32f64.ln());
        let part = g.mul(u, s);
        let small = g.call(Fun::ExpM1, &[part]);
        let ratio = g.div(small, top);
        let guarded = guard(&mut g, ratio);
        assert!((at(&g, guarded, 800.0, 0.75) / (-200.0f64).exp() - 1.0).abs() < 1e-13);
        for s in [-900.0, -3.0, 1e-9, 5.0] {
            let (a, b) = (at(&g, guarded, s, 0.3), at(&g, ratio, s, 0.3));
            assert!((a / b - 1.0).abs() < 1e-14, "{s}: {a} {b}");
        }
    }

    #[test]
    fn a_logarithm_that_is_there_tells_the_other_one() {
        let mut g = Graph::new();
        let k = g.leaf(Leaf::Param(0), "k", Interval::new(1e-12, f64::INFINITY));
        let u = g.leaf(Leaf::Unknown(0), "u", Interval::new(0.0, 1.0));
        let (one, minus) = (g.int(1), g.neg(k));
        let [growth, decay] = [k, minus].map(|x| g.call(Fun::ExpM1, &[x]));
        let rest = g.sub(one, u);
        let [far, near] = [(u, growth), (rest, decay)].map(|(r, power)| {
            let inner = g.mul(r, power);
            g.call(Fun::Ln1p, &[inner])
        });
        let inner = g.mul(rest, decay);
        let near = by_size(&mut g, near, inner).unwrap_or(near);
        let product = g.mul(far, near);
        let at = |g: &Graph, id: Id, k: f64, u: f64| {
            evaluate::<f64>(g, id, &|l| if l == Leaf::Param(0) { k } else { u })
        };
        let guarded = guard(&mut g, product);
        // Again it is the same.
        assert_eq!(guard(&mut g, guarded), guarded);
        let logarithms = |g: &Graph, id: Id| {
            let nodes = g.within(&[id]);
            nodes.iter().filter(|id| matches!(g.node(**id), Node::If(..))).count()
        };
        let alone = guard(&mut g, far);
        assert!(logarithms(&g, guarded) > logarithms(&g, alone));
        for k in [1e-9, 0.5, 6.0, 40.0, 1500.0] {
            for u in [1e-30, 1e-3, 0.2, 0.7, 1.0 - 1e-9] {
                let exact = at(&g, alone, k, u) * at(&g, near, k, u);
                let found = at(&g, guarded, k, u);
                assert!((found / exact - 1.0).abs() < 1e-14, "{k} {u}: {found} {exact}");
            }
        }
    }

    #[test]
    fn nothing_is_guarded_that_cannot_overflow() {
        let mut g = Graph::new();
        let s = g.leaf(Leaf::Param(0), "s", Interval::new(0.0, 50.0));
        let power = g.call(Fun::ExpM1, &[s]);
        let ratio = g.div(s, power);
        assert_eq!(guard(&mut g, ratio), ratio);
    }
}
