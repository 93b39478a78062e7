//! Ruled surfaces in space: three coordinates that are linear in one unknown and, with it fixed, in the
//! other, as those of a bilinear patch are.
//!
//! c(v) u + d(v) = 0 in three coordinates says that c and d are parallel. The component of c × d along
//! the surface's normal in the middle is one quadratic equation for v that degenerates nowhere before the
//! patch does; then u = -(c · d) / (c · c). Single coordinates would not do: a patch may be flat, and
//! parallel to an axis.

use super::scale::named;
use super::{Equation, State};
use crate::display::show;
use crate::expr::{Graph, Id, Leaf, UNKNOWNS, leaf_bit};
use crate::matrix::{cross, dot};
use crate::poly::{Expander, Poly};
use crate::rational::Q;

/// p + q v, the coefficients known.
type Linear = (Id, Id);

/// Takes three equations for two unknowns apart.
pub(super) fn ruled(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    let open: Vec<&Equation> =
        state.equations.iter().filter(|e| !e.modulo_turn && g.has(e.rhs, UNKNOWNS)).collect();
    let [first, ..] = open[..] else { return None };
    let both = g.deps(first.rhs) & UNKNOWNS;
    let same = open.iter().all(|e| g.deps(e.rhs) & UNKNOWNS == both);
    if open.len() != 3 || both.count_ones() != 2 || !same {
        return None;
    }
    let equations: Vec<(Id, Id)> = open.iter().map(|e| (e.known, e.rhs)).collect();
    let leaves: Vec<Leaf> =
        (0..24).map(Leaf::Unknown).filter(|l| leaf_bit(*l) & both != 0).collect();
    let [u, v] = [leaves[0], leaves[1]].map(|l| g.get_leaf(l));
    patch(g, state, &equations, u, v).map(|s| vec![s])
}

fn patch(g: &mut Graph, state: &State, equations: &[(Id, Id)], u: Id, v: Id) -> Option<State> {
    let (mut slopes, mut starts): (Vec<Linear>, Vec<Linear>) = (Vec::new(), Vec::new());
    for &(known, rhs) in equations {
        let (slope, start) = coefficients(g, known, rhs, u, v)?;
        slopes.push(slope);
        starts.push(start);
    }
    let half = g.number(Q::HALF);
    let line = |g: &mut Graph, (p, q): Linear, v: Id| {
        let scaled = g.mul(q, v);
        g.add(p, scaled)
    };
    // ∂/∂u and ∂/∂v in the middle.
    let along: Vec<Id> = slopes.iter().map(|&c| line(g, c, half)).collect();
    let turned: Vec<Linear> = slopes.iter().zip(&starts).map(|(c, d)| (d.1, c.1)).collect();
    let across: Vec<Id> = turned.into_iter().map(|t| line(g, t, half)).collect();
    let normal = cross(g, &along, &across);

    let part = |of: &[Linear], k: usize| -> Vec<Id> {
        of.iter().map(|c| if k == 0 { c.0 } else { c.1 }).collect()
    };
    let mut triple = |i: usize, j: usize| {
        let product = cross(g, &part(&slopes, i), &part(&starts, j));
        dot(g, &normal, &product)
    };
    let [k0, k01, k10, k2] = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(i, j)| triple(i, j));
    let k1 = g.add(k01, k10);
    let mut s = state.clone();
    let [k0, k1, k2] = [k0, k1, k2].map(|k| named(g, &mut s, k));
    let (first, square) = (g.mul(k1, v), g.powi(v, 2));
    let second = g.mul(k2, square);
    let quadratic = g.add(first, second);
    let known = g.neg(k0);

    let c: Vec<Id> = slopes.iter().map(|&c| line(g, c, v)).collect();
    let d: Vec<Id> = starts.iter().map(|&d| line(g, d, v)).collect();
    let (top, bottom) = (dot(g, &c, &d), dot(g, &c, &c));
    let ratio = g.div(top, bottom);
    let found = g.add(u, ratio);
    s.solution.steps.push(format!("ruled surface: {} = {}", show(g, known), show(g, quadratic)));
    let zero = g.int(0);
    let taken = [(known, quadratic), (zero, found)];
    s.equations.retain(|e| !equations.contains(&(e.known, e.rhs)));
    s.equations.extend(taken.map(|(known, rhs)| Equation { known, rhs, modulo_turn: false }));
    s.solution.unused.extend_from_slice(equations);
    Some(s)
}

/// rhs - known as (c₀ + c₁ v) u + (d₀ + d₁ v).
fn coefficients(g: &mut Graph, known: Id, rhs: Id, u: Id, v: Id) -> Option<(Linear, Linear)> {
    let difference = g.sub(rhs, known);
    let polynomial = Expander::new(g).only(UNKNOWNS).expand(difference)?;
    if !polynomial.den.is_empty() {
        return None;
    }
    let zero = g.int(0);
    let linear = |g: &mut Graph, p: Option<&Poly>| -> Option<Linear> {
        let Some(p) = p else { return Some((zero, zero)) };
        let c = p.by_powers_of(v)?;
        let mut at = |i: usize| c.get(i).map_or(zero, |p| p.to_expr(g));
        let (first, second) = (at(0), at(1));
        let known = ![first, second].iter().any(|c| g.has(*c, UNKNOWNS));
        (c.len() <= 2 && known).then_some((first, second))
    };
    let powers = polynomial.num.by_powers_of(u)?;
    if powers.len() > 2 {
        return None;
    }
    let (start, slope) = (linear(g, powers.first())?, linear(g, powers.get(1))?);
    Some((slope, start))
}
