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
    composition(g, f, x)
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

/// Whether the expression is printed with a leading minus sign.
fn leads_negative(g: &Graph, x: Id) -> bool {
    match g.node(x) {
        Node::Number(q) => q.is_negative(),
        Node::Sum(c, terms) => {
            if terms.len() == 1 && c.is_zero() {
                terms[0].0.is_negative()
            } else {
                terms.iter().all(|(q, _)| q.is_negative()) && *c <= Q::ZERO
            }
        }
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
        // exp(q ln a) = a^q, exp(q ln1p a) = (1 + a)^q, and products with symbolic factors alike.
        (Fun::Exp, _) => exp_of_log(g, q, t),
        (Fun::ExpM1, Node::Call(Fun::Ln1p, a)) if q == Q::ONE => Some(a[0]),
        (Fun::ExpM1, Node::Call(Fun::Ln, a)) if q == Q::ONE => Some(g.sub(a[0], one)),
        (Fun::Ln1p, Node::Call(Fun::ExpM1, a)) if q == Q::ONE => Some(a[0]),
        (Fun::Ln, Node::Call(Fun::Exp, a)) if q == Q::ONE => Some(a[0]),
        (Fun::Ln, Node::Product(factors)) if q == Q::ONE && factors.len() == 1 => {
            let (b, e) = factors[0];
            let l = g.call(Fun::Ln, &[b]);
            Some(g.mul(e, l))
        }
        (Fun::Sin, Node::Call(Fun::Asin, a)) | (Fun::Cos, Node::Call(Fun::Acos, a))
            if q == Q::ONE =>
        {
            Some(a[0])
        }
        (Fun::Sin, Node::Call(Fun::Acos, a)) | (Fun::Cos, Node::Call(Fun::Asin, a))
            if q == Q::ONE =>
        {
            Some(one_minus_square(g, a[0]))
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
        (Fun::Sin | Fun::Cos, Node::Call(Fun::Turn, a)) if q == Q::ONE => Some(g.call(f, &[a[0]])),
        (Fun::Sin, Node::Call(Fun::Atan2, a)) if q == Q::ONE => {
            let r = radius(g, a);
            Some(g.div(a[0], r))
        }
        (Fun::Cos, Node::Call(Fun::Atan2, a)) if q == Q::ONE => {
            let r = radius(g, a);
            Some(g.div(a[1], r))
        }
        (Fun::Tan, Node::Call(Fun::Atan2, a)) if q == Q::ONE => Some(g.div(a[0], a[1])),
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
            Node::Call(Fun::Ln1p, a) => g.add(one, a[0]),
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
