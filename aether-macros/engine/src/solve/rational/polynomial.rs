//! Roots of polynomials in an expression of the unknown.

use crate::expr::{Fun, Graph, Id, Node, UNKNOWNS};
use crate::jacobian::cost;
use crate::poly::{Expander, Poly, RatFun, coefficients};
use crate::rational::Q;
use crate::solve::{Equation, State, scale};

/// The roots of a polynomial of degree one or two in `atom`.
pub(super) fn polynomial_roots(g: &mut Graph, p: &Poly, atom: Id) -> Option<Vec<Id>> {
    let mut c: Vec<Poly> = p.by_powers_of(atom)?.into_iter().map(|c| modulo_units(g, c)).collect();
    while c.last().is_some_and(Poly::is_zero) {
        c.pop();
    }
    match &c[..] {
        [c0, c1] => Some(vec![quotient(g, &c0.scale(Q::int(-1))?, c1)?]),
        [c0, c1, c2] if c0.is_zero() => {
            let other = quotient(g, &c1.scale(Q::int(-1))?, c2)?;
            Some(vec![g.int(0), other])
        }
        [c0, c1, c2] => {
            let discriminant = c1.mul(c1)?.sub(&c0.mul(c2)?.scale(Q::int(4))?)?;
            let discriminant = modulo_units(g, discriminant);
            let mut quotient = |num: &Poly, den: &Poly| quotient(g, num, den);
            if let Some(root) = discriminant.sqrt() {
                let minus = c1.scale(Q::int(-1))?;
                let twice = c2.scale(Q::int(2))?;
                let a = quotient(&minus.add(&root)?, &twice)?;
                let b = quotient(&minus.sub(&root)?, &twice)?;
                return Some(vec![a, b]);
            }
            Some(quadratic(g, c0, c1, c2, &discriminant))
        }
        _ => None,
    }
}

fn quotient(g: &mut Graph, num: &Poly, den: &Poly) -> Option<Id> {
    let mut e = Expander::new(g);
    let inverse = e.recip(&RatFun { num: den.clone(), den: vec![] })?;
    let r = e.mul(&RatFun { num: num.clone(), den: vec![] }, &inverse)?;
    Some(e.to_expr(&r))
}

/// A polynomial in known quantities, shorter by what the lengths of unit vectors say.
fn modulo_units(g: &mut Graph, p: Poly) -> Poly {
    let units = g.units().to_vec();
    let whole = p.to_expr(g);
    let expander = units.into_iter().fold(Expander::new(g), Expander::unit);
    let reduced = { expander }.expand(whole).filter(|r| r.den.is_empty());
    match reduced {
        Some(r) if r.num.terms(g).len() < p.terms(g).len() => r.num,
        _ => p,
    }
}

/// Both roots in the form 2c₀ / (-c₁ ∓ √D): the sum below does not cancel for one of the signs.
///
/// The discriminant is multiplied out only where that makes it shorter.
fn quadratic(g: &mut Graph, c0: &Poly, c1: &Poly, c2: &Poly, discriminant: &Poly) -> Vec<Id> {
    // √D = s √r, of which both signs are taken.
    let composed = composed(g, c0, c1, c2);
    let whole = || (Poly::constant(Q::ONE), discriminant.clone());
    // Of a product each factor may show what the whole of it does not.
    let parts = if c1.is_zero() { square_parts(c0, c2) } else { None };
    let (s, r) = parts.or_else(|| discriminant.square_part()).unwrap_or_else(whole);
    let (c0, c1, s) = without_common(c0, c1, &s);
    let halved = c1.exact_div(&r).filter(|_| r.as_constant().is_none());
    let (scale, r) = r.integral().unwrap_or((Q::ONE, r));
    let (c0, s, mut under) = (c0.to_expr(g), s.to_expr(g), r.to_expr(g));
    let plain = r == *discriminant && scale == Q::ONE;
    if plain && cost(g, composed) < cost(g, under) {
        under = composed;
    }
    let scale = g.number(scale);
    let scale = g.sqrt(scale);
    let root = g.sqrt(under);
    let root = g.mul(scale, root);
    let root = without_signs(g, root);
    let top = g.sum(Q::ZERO, &[(Q::int(2), c0)]);
    // -c₁ ∓ s √r, or √r times a sum where c₁ is a multiple of r.
    let (outside, c1, s) = match halved {
        Some(c) => {
            let c = c.to_expr(g);
            (root, g.mul(c, root), s)
        }
        None => (g.int(1), c1.to_expr(g), g.mul(s, root)),
    };
    [Q::ONE, Q::int(-1)]
        .into_iter()
        .map(|sign| {
            let bottom = g.sum(Q::ZERO, &[(Q::int(-1), c1), (sign, s)]);
            let bottom = g.mul(outside, bottom);
            g.div(top, bottom)
        })
        .collect()
}

/// -4 c₀ c₂ as s² r, with as much in s as each of the factors shows.
fn square_parts(c0: &Poly, c2: &Poly) -> Option<(Poly, Poly)> {
    let [(s0, r0), (s2, r2)] = [c0.square_part()?, c2.square_part()?];
    Some((s0.mul(&s2)?.scale(Q::int(2))?, r0.mul(&r2)?.scale(Q::int(-1))?))
}

/// c₁² - 4 c₀ c₂, not multiplied out.
pub(super) fn composed(g: &mut Graph, c0: &Poly, c1: &Poly, c2: &Poly) -> Id {
    let (c0, c1, c2) = (c0.to_expr(g), c1.to_expr(g), c2.to_expr(g));
    let (square, other) = (g.powi(c1, 2), g.mul(c0, c2));
    g.sum(Q::ZERO, &[(Q::ONE, square), (Q::int(-4), other)])
}

/// Three polynomials without the factors of the third that divide them all.
fn without_common(c0: &Poly, c1: &Poly, s: &Poly) -> (Poly, Poly, Poly) {
    let mut all = (c0.clone(), c1.clone(), s.clone());
    for (factor, e) in s.split() {
        for _ in 0..e {
            let divided =
                (all.0.exact_div(&factor), all.1.exact_div(&factor), all.2.exact_div(&factor));
            let (Some(a), Some(b), Some(c)) = divided else { break };
            all = (a, b, c);
        }
    }
    all
}

/// √(x² d) as x √d: where both signs of a root are taken, neither needs the size of x, and each of
/// the answers stays with one branch of the map.
fn without_signs(g: &mut Graph, root: Id) -> Id {
    let (q, body) = g.split(root);
    let factors: Vec<(Id, Id)> = g
        .factors(body)
        .into_iter()
        .map(|(b, e)| match g.node(b) {
            Node::Call(Fun::Abs, args) => (args[0], e),
            _ => (b, e),
        })
        .collect();
    let body = g.product(&factors);
    g.sum(Q::ZERO, &[(q, body)])
}

/// Gives the coefficients of polynomial equations in several unknowns names, where they are sums. Multiplied
/// out in all that follows, these would become long, and cancel: b - a and c - d of the corners a, b, c
/// and d are small where the corners are not.
pub(in crate::solve) fn name_coefficients(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    let mut next = state.clone();
    let mut sums = 0;
    for e in next.equations.iter_mut().filter(|e| !e.modulo_turn) {
        if (g.deps(e.rhs) & UNKNOWNS).count_ones() < 2 {
            continue;
        }
        let difference = g.sub(e.rhs, e.known);
        let mut terms = Vec::new();
        for (open, known) in coefficients(g, difference)? {
            let long =
                matches!(g.node(known), Node::Sum(c, t) if t.len() + usize::from(!c.is_zero()) > 1);
            let value = match (long, next.solution.names.iter().find(|(_, v)| **v == known)) {
                (true, Some((name, _))) => *name,
                (true, None) => {
                    sums += 1;
                    scale::next_name(g, &mut next.solution, known)?
                }
                (false, _) => known,
            };
            terms.push((Q::ONE, g.mul(value, open)));
        }
        *e = Equation { known: g.int(0), rhs: g.sum(Q::ZERO, &terms), modulo_turn: false };
    }
    (sums > 0).then(|| vec![next])
}
