//! Identities of the functions of the language: compositions, symmetries, special values.

use crate::expr::{Fun, Graph, Id, Node};
use crate::rational::Q;

/// The canonical form of `f(args)`, if it is something simpler than the call itself.
pub fn simplify_call(g: &mut Graph, f: Fun, args: &[Id]) -> Option<Id> {
    let x = args[0];
    if let Some(r) = special_value(g, f, x, args) {
        return Some(r);
    }
    if let Some(r) = symmetry(g, f, x) {
        return Some(r);
    }
    inverse_beta(g, f, args).or_else(|| composition(g, f, x))
}

/// The incomplete beta function of its inverse, and the other way round, with the same parameters.
fn inverse_beta(g: &Graph, f: Fun, args: &[Id]) -> Option<Id> {
    let undone = match f {
        Fun::BetaInc => Fun::BetaIncInv,
        Fun::BetaIncInv => Fun::BetaInc,
        _ => return None,
    };
    match g.node(args[0]) {
        Node::Call(h, inner) if *h == undone && inner[1..3] == args[1..3] => Some(inner[0]),
        _ => None,
    }
}

fn special_value(g: &mut Graph, f: Fun, x: Id, args: &[Id]) -> Option<Id> {
    let q = g.as_number(x);
    let zero = q.is_some_and(Q::is_zero);
    match f {
        Fun::Exp | Fun::Cos | Fun::Cosh if zero => Some(g.int(1)),
        Fun::ExpM1
        | Fun::Ln1p
        | Fun::Sin
        | Fun::Tan
        | Fun::Asin
        | Fun::Atan
        | Fun::Sinh
        | Fun::Tanh
        | Fun::Asinh
        | Fun::Atanh
        | Fun::Cbrt
        | Fun::Erf
        | Fun::ErfInv
        | Fun::LambertW
            if zero =>
        {
            Some(g.int(0))
        }
        Fun::Ln | Fun::ErfcInv if q == Some(Q::ONE) => Some(g.int(0)),
        Fun::Erfc if zero => Some(g.int(1)),
        Fun::BetaInc | Fun::BetaIncInv if zero || q == Some(Q::ONE) => Some(x),
        Fun::LnGamma if q == Some(Q::ONE) || q == Some(Q::int(2)) => Some(g.int(0)),
        // A root of something that has a sign is a power, of which the other rules know more.
        Fun::Cbrt if g.range(x).nonnegative() => {
            let third = g.number(Q::new(1, 3)?);
            Some(g.pow(x, third))
        }
        Fun::Cbrt if g.range(x).nonpositive() => {
            let (size, third) = (g.neg(x), g.number(Q::new(1, 3)?));
            let root = g.pow(size, third);
            Some(g.neg(root))
        }
        Fun::Abs if q.is_some() => {
            let a = q?.abs();
            Some(g.number(a))
        }
        Fun::Abs if g.range(x).nonnegative() => Some(x),
        Fun::Abs if g.range(x).nonpositive() => Some(g.neg(x)),
        Fun::Sign if g.range(x).lo > 0.0 => Some(g.int(1)),
        Fun::Sign if g.range(x).hi < 0.0 => Some(g.int(-1)),
        Fun::Atan2
            if g.as_number(args[0]).is_some_and(Q::is_zero) && g.range(args[1]).nonnegative() =>
        {
            Some(g.int(0))
        }
        Fun::Turn if matches!(g.node(x), Node::Call(Fun::Turn, _)) => Some(x),
        _ => None,
    }
}

/// Whether the expression is printed with a leading minus sign: a negative number, or a sum of negative terms.
pub(crate) fn leads_negative(g: &Graph, x: Id) -> bool {
    match g.node(x) {
        Node::Number(q) => q.is_negative(),
        Node::Sum(c, terms) => *c <= Q::ZERO && terms.iter().all(|(q, _)| q.is_negative()),
        _ => false,
    }
}

fn symmetry(g: &mut Graph, f: Fun, x: Id) -> Option<Id> {
    let odd = matches!(
        f,
        Fun::Sin
            | Fun::Tan
            | Fun::Asin
            | Fun::Atan
            | Fun::Sinh
            | Fun::Tanh
            | Fun::Asinh
            | Fun::Atanh
            | Fun::Cbrt
            | Fun::Erf
            | Fun::ErfInv
    );
    let even = matches!(f, Fun::Cos | Fun::Cosh | Fun::Abs);
    if (odd || even) && leads_negative(g, x) {
        let n = g.neg(x);
        let r = g.call(f, &[n]);
        return Some(if odd { g.neg(r) } else { r });
    }
    None
}

fn composition(g: &mut Graph, f: Fun, x: Id) -> Option<Id> {
    let (q, t) = g.split(x);
    let node = g.node(t).clone();
    let one = g.int(1);
    match (f, &node) {
        // exp(q ln a) = a^q, also for symbolic q; exp(q ln1p a) = (1 + a)^q for small numbers q.
        (Fun::Exp, _) => exp_of_log(g, q, t),
        (Fun::ExpM1, Node::Call(Fun::Ln1p, a)) if q == Q::ONE => Some(a[0]),
        (Fun::ExpM1, Node::Call(Fun::Ln, a)) if q == Q::ONE => Some(g.sub(a[0], one)),
        (Fun::Ln1p, Node::Call(Fun::ExpM1, a)) if q == Q::ONE => Some(a[0]),
        (Fun::Ln, Node::Call(Fun::Exp, a)) if q == Q::ONE => Some(a[0]),
        (Fun::Ln, Node::Product(factors)) if q == Q::ONE && factors.len() == 1 => {
            let (b, e) = factors[0];
            // An even power has a logarithm on both sides of zero.
            let even = g.as_number(e).is_some_and(|e| e.num() % 2 == 0);
            let b = if even { g.call(Fun::Abs, &[b]) } else { b };
            let l = g.call(Fun::Ln, &[b]);
            Some(g.mul(e, l))
        }
        (Fun::Sin, Node::Call(Fun::Asin, a)) | (Fun::Cos, Node::Call(Fun::Acos, a))
            if q == Q::ONE =>
        {
            Some(a[0])
        }
        // Three times an angle whose sine or cosine is a: ±a (3 - 4 a²).
        (Fun::Sin, Node::Call(Fun::Asin, a)) | (Fun::Cos, Node::Call(Fun::Acos, a))
            if q == Q::int(3) =>
        {
            let square = g.powi(a[0], 2);
            let rest = g.sum(Q::int(3), &[(Q::int(-4), square)]);
            let sine = g.mul(a[0], rest);
            Some(if f == Fun::Sin { sine } else { g.neg(sine) })
        }
        (Fun::Erf, Node::Call(Fun::ErfInv, a))
        | (Fun::ErfInv, Node::Call(Fun::Erf, a))
        | (Fun::Erfc, Node::Call(Fun::ErfcInv, a))
        | (Fun::ErfcInv, Node::Call(Fun::Erfc, a))
            if q == Q::ONE =>
        {
            Some(a[0])
        }
        // erfc(-y) = 2 - erfc(y).
        (Fun::Erfc, Node::Call(Fun::ErfcInv, a)) if q == Q::int(-1) => {
            let two = g.int(2);
            Some(g.sub(two, a[0]))
        }
        (Fun::Cbrt, Node::Product(f)) if q == Q::ONE && f.len() == 1 => {
            (g.as_number(f[0].1) == Some(Q::int(3))).then_some(f[0].0)
        }
        (Fun::Tan, Node::Call(Fun::Atan, a)) | (Fun::Sinh, Node::Call(Fun::Asinh, a))
            if q == Q::ONE =>
        {
            Some(a[0])
        }
        (Fun::Tanh, Node::Call(Fun::Atanh, a)) | (Fun::Asinh, Node::Call(Fun::Sinh, a))
            if q == Q::ONE =>
        {
            Some(a[0])
        }
        (Fun::Atanh, Node::Call(Fun::Tanh, a)) if q == Q::ONE => Some(a[0]),
        (Fun::Sin | Fun::Cos, Node::Call(Fun::Turn | Fun::TurnTo, a)) if q == Q::ONE => {
            Some(g.call(f, &[a[0]]))
        }
        (Fun::Sin, Node::Call(Fun::Atan2, a)) if q == Q::ONE => {
            let r = radius(g, a);
            Some(g.div(a[0], r))
        }
        (Fun::Cos, Node::Call(Fun::Atan2, a)) if q == Q::ONE => {
            let r = radius(g, a);
            Some(g.div(a[1], r))
        }
        (Fun::Tan, Node::Call(Fun::Atan2, a)) if q == Q::ONE => Some(g.div(a[0], a[1])),
        (Fun::Sin | Fun::Cos | Fun::Tan, _) if has_quarter_turns(g, x) => quarter_turns(g, f, x),
        (Fun::Sin | Fun::Cos | Fun::Tan, Node::Pi) => fraction_of_turn(g, f, q),
        (Fun::Sin | Fun::Cos | Fun::Tan | Fun::Sinh | Fun::Cosh | Fun::Tanh, Node::Call(h, a))
            if q == Q::ONE && a.len() == 1 =>
        {
            of_an_inverse(g, f, *h, a[0])
        }
        (Fun::Sign, Node::Product(_)) => sign_of_product(g, q, t),
        (Fun::Abs, Node::Call(Fun::Sign, _)) => {
            let k = q.abs();
            Some(g.number(k))
        }
        (Fun::Abs, Node::Product(factors)) => {
            let parts: Vec<(Id, Id)> = factors
                .iter()
                .map(|&(b, e)| {
                    let whole = g.pow(b, e);
                    if g.range(whole).nonnegative() {
                        (whole, one)
                    } else {
                        (g.call(Fun::Abs, &[b]), e)
                    }
                })
                .collect();
            let body = g.product(&parts);
            let k = g.number(q.abs());
            let r = g.mul(k, body);
            let trivial = matches!(factors[..], [(_, e)] if e == one);
            (!trivial).then_some(r)
        }
        (Fun::Abs, Node::Call(Fun::Abs, _)) if q == Q::ONE => Some(x),
        (Fun::Abs, _) if q != Q::ONE && g.as_number(t).is_none() => {
            let inner = g.call(Fun::Abs, &[t]);
            let k = g.number(q.abs());
            Some(g.mul(k, inner))
        }
        _ => None,
    }
}

/// A circular or hyperbolic function of the inverse of another: an algebraic function.
fn of_an_inverse(g: &mut Graph, f: Fun, inverse: Fun, a: Id) -> Option<Id> {
    let one = g.int(1);
    let root = |g: &mut Graph, constant: i64| {
        let square = g.powi(a, 2);
        let c = g.int(constant);
        let s = g.add(square, c);
        g.sqrt(s)
    };
    Some(match (f, inverse) {
        (Fun::Sin, Fun::Acos) | (Fun::Cos, Fun::Asin) => one_minus_square(g, a),
        (Fun::Tan, Fun::Asin) => {
            let r = one_minus_square(g, a);
            g.div(a, r)
        }
        (Fun::Tan, Fun::Acos) => {
            let r = one_minus_square(g, a);
            g.div(r, a)
        }
        (Fun::Cos, Fun::Atan) => {
            let r = root(g, 1);
            g.div(one, r)
        }
        (Fun::Sin, Fun::Atan) | (Fun::Tanh, Fun::Asinh) => {
            let r = root(g, 1);
            g.div(a, r)
        }
        (Fun::Cosh, Fun::Asinh) => root(g, 1),
        (Fun::Sinh, Fun::Acosh) => {
            let (m, p) = (g.sub(a, one), g.add(a, one));
            let s = g.mul(m, p);
            g.sqrt(s)
        }
        (Fun::Cosh, Fun::Atanh) => {
            let r = one_minus_square(g, a);
            g.div(one, r)
        }
        (Fun::Sinh, Fun::Atanh) => {
            let r = one_minus_square(g, a);
            g.div(a, r)
        }
        (Fun::Cosh, Fun::Acosh) => a,
        _ => return None,
    })
}

/// Whether a multiple of π/2 is added to the angle.
fn has_quarter_turns(g: &Graph, x: Id) -> bool {
    let multiple =
        |(q, t): &(Q, Id)| *g.node(*t) == Node::Pi && q.mul(Q::int(2)).is_some_and(Q::is_int);
    match g.node(x) {
        Node::Sum(_, terms) => terms.iter().any(multiple),
        Node::Pi => true,
        _ => false,
    }
}

/// sin, cos or tan of an angle plus quarters of a turn.
fn quarter_turns(g: &mut Graph, f: Fun, x: Id) -> Option<Id> {
    let pi = g.pi();
    let (c, terms) = match g.node(x).clone() {
        Node::Sum(c, terms) => (c, terms),
        _ if x == pi => (Q::ZERO, vec![(Q::ONE, pi)]),
        _ => return None,
    };
    let quarters = terms.iter().find(|(_, t)| *t == pi)?.0.mul(Q::int(2))?;
    if !quarters.is_int() {
        return None;
    }
    let rest: Vec<(Q, Id)> = terms.into_iter().filter(|(_, t)| *t != pi).collect();
    let rest = g.sum(c, &rest);
    turned(g, f, rest, quarters.num().rem_euclid(4))
}

/// sin, cos or tan of q π, by an angle of at most an eighth of a turn: so that equal ones are seen to
/// be equal.
fn fraction_of_turn(g: &mut Graph, f: Fun, q: Q) -> Option<Id> {
    if q == Q::new(1, 4)? {
        let half = g.number(Q::HALF);
        return Some(if f == Fun::Tan { g.int(1) } else { g.sqrt(half) });
    }
    // The least number of quarters that leaves no more than an eighth.
    let excess = q.num().checked_mul(4)?.checked_sub(q.den())?;
    let quarters = -(-excess).div_euclid(q.den().checked_mul(2)?);
    let rest = q.add(Q::new(-quarters, 2)?)?;
    let pi = g.pi();
    let rest = g.sum(Q::ZERO, &[(rest, pi)]);
    if quarters == 0 { None } else { turned(g, f, rest, quarters.rem_euclid(4)) }
}

/// sin, cos or tan of an angle and k quarters of a turn, 0 <= k < 4.
fn turned(g: &mut Graph, f: Fun, rest: Id, k: i128) -> Option<Id> {
    if f == Fun::Tan {
        let t = g.call(Fun::Tan, &[rest]);
        if k % 2 == 0 {
            return Some(t);
        }
        // A pole stays as it is.
        let pole = g.as_number(t).is_some_and(Q::is_zero);
        let r = g.powi(t, -1);
        return (!pole).then(|| g.neg(r));
    }
    let k = if f == Fun::Sin { k } else { k + 1 };
    let value = g.call(if k % 2 == 0 { Fun::Sin } else { Fun::Cos }, &[rest]);
    Some(if k % 4 < 2 { value } else { g.neg(value) })
}

/// The sign of a product without the factors that are known to be positive.
fn sign_of_product(g: &mut Graph, q: Q, t: Id) -> Option<Id> {
    let factors = g.factors(t);
    let open: Vec<(Id, Id)> = factors
        .iter()
        .copied()
        .filter(|&(b, e)| {
            let whole = g.pow(b, e);
            g.range(whole).lo <= 0.0
        })
        .collect();
    if q.abs() == Q::ONE && open.len() == factors.len() {
        return None;
    }
    let rest = g.product(&open);
    let (inner, rest) = g.split(rest);
    let sign = g.call(Fun::Sign, &[rest]);
    Some(if q.is_negative() == inner.is_negative() { sign } else { g.neg(sign) })
}

fn radius(g: &mut Graph, a: &[Id]) -> Id {
    let y2 = g.powi(a[0], 2);
    let x2 = g.powi(a[1], 2);
    let s = g.add(x2, y2);
    g.sqrt(s)
}

/// √((1-a)(1+a)), the stable form of √(1-a²).
fn one_minus_square(g: &mut Graph, a: Id) -> Id {
    let one = g.int(1);
    let m = g.sub(one, a);
    let p = g.add(one, a);
    let s = g.mul(m, p);
    g.sqrt(s)
}

/// exp of a single term with one logarithm in it is a power.
fn exp_of_log(g: &mut Graph, q: Q, t: Id) -> Option<Id> {
    let factors = g.factors(t);
    let one = g.int(1);
    for (i, &(b, e)) in factors.iter().enumerate() {
        if e != one {
            continue;
        }
        let base = match g.node(b).clone() {
            Node::Call(Fun::Ln, a) => a[0],
            // A large or symbolic exponent would magnify the rounding of 1 + a.
            Node::Call(Fun::Ln1p, a) if factors.len() == 1 && q.num().abs() <= 4 => {
                g.add(one, a[0])
            }
            _ => continue,
        };
        let mut rest: Vec<(Id, Id)> =
            factors.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, f)| *f).collect();
        let k = g.number(q);
        rest.push((k, one));
        let exponent = g.product(&rest);
        return Some(g.pow(base, exponent));
    }
    None
}
