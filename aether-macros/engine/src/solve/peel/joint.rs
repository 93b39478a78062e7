//! Equations whose right side is undone as a whole: several factors or summands that belong together.

use std::f64::consts::PI;

use super::super::{Condition, affine_parts};
use super::Inverse;
use crate::expr::{Fun, Graph, Id, Node, UNKNOWNS};
use crate::rational::Q;

/// 1 / tan(a) for an angle in [0, π], where the cotangent falls from one end to the other.
pub(super) fn undo_cotangent(
    g: &mut Graph,
    known: Id,
    base: Id,
    exp: Id,
) -> Option<(Id, Vec<Inverse>)> {
    let Node::Call(Fun::Tan, args) = g.node(base).clone() else { return None };
    let range = g.range(args[0]);
    if g.as_number(exp) != Some(Q::int(-1)) || range.lo < 0.0 || range.hi > PI + 1e-12 {
        return None;
    }
    let one = g.int(1);
    let known = g.call(Fun::Atan2, &[one, known]);
    Some((args[0], vec![Inverse { known, conditions: vec![] }]))
}

/// sin a / cos a or cos a / sin a: which one is on top, and the angle.
pub(super) fn ratio_of_sine_and_cosine(g: &Graph, factors: &[(Id, Id)]) -> Option<(Fun, Id)> {
    let [(p, d), (q, e)] = *factors else { return None };
    let (Node::Call(f, a), Node::Call(h, b)) = (g.node(p), g.node(q)) else { return None };
    let one = Some(Q::ONE);
    let minus = Some(Q::int(-1));
    let (top, bottom) = match (g.as_number(d), g.as_number(e)) {
        (d, e) if d == one && e == minus => (*f, *h),
        (d, e) if d == minus && e == one => (*h, *f),
        _ => return None,
    };
    let pair = matches!((top, bottom), (Fun::Sin, Fun::Cos) | (Fun::Cos, Fun::Sin));
    (pair && a == b).then_some((top, a[0]))
}

/// Π bᵢ^(cᵢ + dᵢ r) = known, with the same r in all exponents: (Π bᵢ^dᵢ)^r = known / Π bᵢ^cᵢ.
pub(super) fn undo_powers(
    g: &mut Graph,
    known: Id,
    factors: &[(Id, Id)],
) -> Option<(Id, Vec<Inverse>)> {
    let one = g.int(1);
    let (mut constants, mut slopes, mut common) = (Vec::new(), Vec::new(), None);
    for &(b, e) in factors {
        let (constant, factor, rest) = affine_parts(g, e);
        if *common.get_or_insert(rest) != rest {
            return None;
        }
        if let Some(c) = constant {
            constants.push((b, c));
        }
        slopes.push((b, factor));
    }
    let (constant, base) = (g.product(&constants), g.product(&slopes));
    let minus = g.int(-1);
    let ratio = g.product(&[(known, one), (constant, minus)]);
    let (top, bottom) = (g.call(Fun::Ln, &[ratio]), g.call(Fun::Ln, &[base]));
    Some((common?, vec![Inverse { known: g.div(top, bottom), conditions: vec![] }]))
}

/// Σ qᵢ ln aᵢ = known: Π aᵢ^qᵢ = exp(known).
pub(super) fn join_logarithms(
    g: &mut Graph,
    known: Id,
    terms: &[(Q, Id)],
) -> Option<(Id, Vec<Inverse>)> {
    let one = g.int(1);
    let factors = terms.iter().map(|&(q, t)| {
        let argument = match g.node(t).clone() {
            Node::Call(Fun::Ln, a) => a[0],
            Node::Call(Fun::Ln1p, a) => g.add(one, a[0]),
            _ => return None,
        };
        Some((argument, g.number(q)))
    });
    let factors: Vec<(Id, Id)> = factors.collect::<Option<_>>()?;
    let product = g.product(&factors);
    let known = g.call(Fun::Exp, &[known]);
    Some((product, vec![Inverse { known, conditions: vec![] }]))
}

/// Parts of z^m exp(c zⁿ), with c >= 0 known: z, m, c, n.
pub(super) fn lambert(g: &mut Graph, factors: &[(Id, Id)]) -> Option<(Id, Q, Id, Q)> {
    let [first, second] = *factors else { return None };
    let one = g.int(1);
    [(first, second), (second, first)].into_iter().find_map(|((z, m), (e, power))| {
        let Node::Call(Fun::Exp, args) = g.node(e).clone() else { return None };
        let m = g.as_number(m)?;
        let (mut c, mut rest) = (one, args[0]);
        loop {
            let (constant, factor, part) = affine_parts(g, rest);
            if constant.is_some() {
                return None;
            }
            if part == rest {
                break;
            }
            c = g.mul(c, factor);
            rest = part;
        }
        let (base, n) = match g.factors(rest)[..] {
            [(base, n)] => (base, g.as_number(n)?),
            _ => return None,
        };
        let right = power == one && base == z && g.range(c).nonnegative();
        right.then_some((z, m, c, n))
    })
}

/// x = z^m exp(c zⁿ) has (n c / m) zⁿ = W((n c / m) x^(n/m)).
pub(super) fn undo_lambert(g: &mut Graph, known: Id, f: &[(Id, Id)]) -> Option<(Id, Vec<Inverse>)> {
    let (z, m, c, n) = lambert(g, f)?;
    let range = g.range(z);
    let positive = range.nonnegative();
    // With a sign that changes, x must have the sign of z, and zⁿ must have none.
    let odd = m.is_int() && !m.is_even() && n.is_int() && n.is_even();
    if m.is_negative() || n.is_negative() || !(positive || odd) {
        return None;
    }
    let ratio = n.mul(m.recip()?)?;
    let scaled = {
        let k = g.number(ratio);
        g.mul(k, c)
    };
    let size = if positive { known } else { g.call(Fun::Abs, &[known]) };
    let e = g.number(ratio);
    let argument = g.pow(size, e);
    let argument = g.mul(scaled, argument);
    let w = g.call(Fun::LambertW, &[argument]);
    let power = g.div(w, scaled);
    let e = g.number(n.recip()?);
    let root = g.pow(power, e);
    if positive {
        return Some((z, vec![Inverse { known: root, conditions: vec![Condition(known)] }]));
    }
    let sign = g.call(Fun::Sign, &[known]);
    Some((z, vec![Inverse { known: g.mul(sign, root), conditions: vec![] }]))
}

/// known = atan2(y, x): the point lies on a known ray from the origin, which tells one coordinate
/// from the other.
pub(super) fn undo_atan2(g: &mut Graph, known: Id, y: Id, x: Id) -> Option<(Id, Vec<Inverse>)> {
    let (s, c) = (g.call(Fun::Sin, &[known]), g.call(Fun::Cos, &[known]));
    let (open, other, along, across) = match (g.has(y, UNKNOWNS), g.has(x, UNKNOWNS)) {
        (true, false) => (y, x, s, c),
        (false, true) => (x, y, c, s),
        _ => return None,
    };
    let ratio = g.div(along, across);
    let answer = g.mul(other, ratio);
    let forward = g.mul(other, across);
    let pi = g.pi();
    let above = g.add(known, pi);
    let below = g.sub(pi, known);
    let conditions = vec![Condition(forward), Condition(above), Condition(below)];
    Some((open, vec![Inverse { known: answer, conditions }]))
}
