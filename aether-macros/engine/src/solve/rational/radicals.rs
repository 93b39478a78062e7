//! Equations with roots of the unknown, which are squared away.

use std::collections::BTreeMap;

use super::polynomial::polynomial_roots;
use super::{Root, roots};
use crate::expr::{Deps, Graph, Id, Leaf, Node, UNKNOWNS, leaf_bit};
use crate::interval::Interval;
use crate::poly::{Expander, Poly};
use crate::rational::Q;

/// The roots of known = √… times something rational: of both sides squared. Which of them have the sign of the known side
/// shows when they are tried.
pub(super) fn squared(g: &mut Graph, known: Id, rhs: Id) -> Option<Vec<Root>> {
    let (_, body) = g.split(rhs);
    let root = |e: Id, g: &Graph| g.as_number(e).is_some_and(|q| q.den() == 2);
    if !g.factors(body).into_iter().any(|(_, e)| root(e, g)) {
        return None;
    }
    let (known, rhs) = (g.powi(known, 2), g.powi(rhs, 2));
    roots(g, known, rhs)
}

/// Whether a square root of something open occurs in an expression.
pub(super) fn mentions_root(g: &Graph, id: Id) -> bool {
    match g.node(id) {
        Node::Product(f) => f
            .iter()
            .any(|(b, e)| g.as_number(*e).is_some_and(|q| q.den() == 2) || mentions_root(g, *b)),
        Node::Sum(_, t) => t.iter().any(|(_, t)| mentions_root(g, *t)),
        _ => false,
    }
}

pub(super) fn roots_in(g: &mut Graph, known: Id, rhs: Id, open: Deps) -> Option<Vec<Root>> {
    let polynomial = clear(g, known, rhs, open)?;
    let atoms: Vec<Id> = polynomial.atoms().into_iter().filter(|a| g.has(*a, UNKNOWNS)).collect();
    match atoms[..] {
        [atom] => {
            let values = polynomial_roots(g, &polynomial, atom)?;
            Some(values.into_iter().map(|value| Root { atom, value, also: None }).collect())
        }
        [a, b] => radical(g, known, rhs, [a, b], open)
            .or_else(|| radical(g, known, rhs, [b, a], open))
            .or_else(|| isolated(g, &polynomial, &atoms, open)),
        [_, _, _] => isolated(g, &polynomial, &atoms, open),
        _ => None,
    }
}

/// The numerator of rhs - known, as a polynomial.
pub(in crate::solve) fn clear(g: &mut Graph, known: Id, rhs: Id, open: Deps) -> Option<Poly> {
    let difference = g.sub(rhs, known);
    Some(Expander::new(g).only(open).expand(difference)?.num)
}

/// Atoms u and t = √(α + β u): substitutes u = (t² - α) / β and solves for t.
pub(super) fn radical(
    g: &mut Graph,
    known: Id,
    rhs: Id,
    [u, t]: [Id; 2],
    open: Deps,
) -> Option<Vec<Root>> {
    let Node::Product(f) = g.node(t).clone() else { return None };
    if f.len() != 1 || g.as_number(f[0].1) != Some(Q::HALF) {
        return None;
    }
    let radicand = Expander::new(g).only(open).expand(f[0].0)?;
    if !radicand.den.is_empty() {
        return None;
    }
    let c = radicand.num.by_powers_of(u)?;
    let [alpha, beta] = &c[..] else { return None };
    let (alpha, beta) = (alpha.to_expr(g), beta.to_expr(g));
    if g.has(alpha, UNKNOWNS) || g.has(beta, UNKNOWNS) {
        return None;
    }
    let fresh = g.leaf(Leaf::Unknown(23), "t", Interval::POSITIVE);
    let t2 = g.powi(fresh, 2);
    let top = g.sub(t2, alpha);
    let inner = g.div(top, beta);
    let substituted = g.substitute(rhs, &BTreeMap::from([(t, fresh), (u, inner)]));
    let polynomial = clear(g, known, substituted, open)?;
    let values = polynomial_roots(g, &polynomial, fresh)?;
    Some(
        values
            .into_iter()
            .map(|v| {
                let exact = g.substitute(inner, &BTreeMap::from([(fresh, v)]));
                let simple = Expander::new(g).only(open).normal_form(exact).unwrap_or(exact);
                Root { atom: u, value: simple, also: Some((t, v)) }
            })
            .collect(),
    )
}

/// Atoms u and roots of polynomials of it, of which the equation has one product: A + B √R = 0 as A² - B² R = 0, where that has
/// a low degree.
fn isolated(g: &mut Graph, equation: &Poly, atoms: &[Id], open: Deps) -> Option<Vec<Root>> {
    let radicand = |g: &Graph, atom: Id| match g.node(atom) {
        Node::Product(f) if f.len() == 1 && g.as_number(f[0].1) == Some(Q::HALF) => Some(f[0].0),
        _ => None,
    };
    let (roots, plain): (Vec<Id>, Vec<Id>) =
        atoms.iter().partition(|&&atom| radicand(g, atom).is_some());
    let [u] = plain[..] else { return None };
    let (mut alone, mut times) = (None, equation.clone());
    let (mut above, mut below) = (Poly::constant(Q::ONE), Poly::constant(Q::ONE));
    for &root in &roots {
        let c = times.by_powers_of(root)?;
        let [rest, with] = &c[..] else { return None };
        // Besides the first of them the others stand by themselves nowhere.
        match &alone {
            None => alone = Some(rest.clone()),
            Some(_) if rest.is_zero() => {}
            Some(_) => return None,
        }
        let under = radicand(g, root)?;
        let under = Expander::new(g).only(open).expand(under)?;
        let mut factors = under.den.iter();
        let den = factors
            .try_fold(Poly::constant(Q::ONE), |all, (factor, e)| all.mul(&factor.powi(*e)?))?;
        (above, below, times) = (above.mul(&under.num)?, below.mul(&den)?, with.clone());
    }
    let alone = alone?;
    let is_free =
        |g: &Graph, p: &Poly| p.atoms().into_iter().all(|atom| atom == u || !g.has(atom, UNKNOWNS));
    if ![&alone, &times, &above, &below].into_iter().all(|p| is_free(g, p)) {
        return None;
    }
    let squared = alone.mul(&alone)?.mul(&below)?.sub(&times.mul(&times)?.mul(&above)?)?;
    let values = polynomial_roots(g, &squared, u)?;
    Some(values.into_iter().map(|value| Root { atom: u, value, also: None }).collect())
}

/// (unknown, atom) pairs such that the equation is linear in the atom and the atom holds only that unknown.
pub(super) fn isolatable(g: &mut Graph, known: Id, rhs: Id) -> Vec<(Leaf, Id)> {
    let Some(p) = clear(g, known, rhs, UNKNOWNS) else { return vec![] };
    let mut found = Vec::new();
    for atom in p.atoms() {
        for i in 0..24 {
            if g.deps(atom) & UNKNOWNS == leaf_bit(Leaf::Unknown(i)) {
                found.push((Leaf::Unknown(i), atom));
            }
        }
    }
    found
}
