//! A scale that two equations have, times known numbers of which either may vanish: λ x = f and λ y = h, of a point that is seen
//! in some direction.
//!
//! One of them would give λ as f / x, which says nothing where x is zero. Without λ they say f y = h x, and λ is
//! (x f + y h) / (x² + y²).

use super::rational::clear;
use super::{Equation, FIRST_OWN, State};
use crate::display::show;
use crate::expr::{Deps, Graph, Id, Leaf, OUTS, UNKNOWNS, leaf_bit};
use crate::matrix::{determinant, dot};

/// An equation of which a scale is a factor: scale · factor + rest = 0.
struct Scaled {
    number: usize,
    factor: Id,
    rest: Id,
    /// The unknowns in the rest.
    others: Deps,
}

/// Takes two equations apart that have a scale of the solver's own and the same other unknowns.
pub(super) fn scaled_pair(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    for leaf in (FIRST_OWN..24).map(Leaf::Unknown) {
        let numbers = 0..state.equations.len();
        let scaled: Vec<Scaled> = numbers.filter_map(|i| scaled(g, state, i, leaf)).collect();
        for (k, first) in scaled.iter().enumerate() {
            let alike = |second: &&Scaled| second.others == first.others;
            let Some(second) = scaled[k + 1..].iter().find(alike) else { continue };
            let (factors, rests) = ([first.factor, second.factor], [first.rest, second.rest]);
            let without = determinant(g, &[factors.to_vec(), rests.to_vec()]);
            if !g.has(without, UNKNOWNS) {
                continue;
            }
            let (above, below) = (dot(g, &factors, &rests), dot(g, &factors, &factors));
            let ratio = g.div(above, below);
            let (scale, zero) = (g.get_leaf(leaf), g.int(0));
            let told = g.add(scale, ratio);
            let mut s = state.clone();
            let opposite = g.neg(ratio);
            let step = format!("two of one scale: {} = {}", show(g, scale), show(g, opposite));
            s.solution.steps.push(step);
            let equation = |rhs| Equation { known: zero, rhs, modulo_turn: false };
            s.equations[first.number] = equation(without);
            s.equations[second.number] = equation(told);
            return Some(vec![s]);
        }
    }
    None
}

/// An equation as one of a scale, if its factor is known and may vanish, as coordinates of a direction do.
fn scaled(g: &mut Graph, state: &State, number: usize, leaf: Leaf) -> Option<Scaled> {
    let equation = &state.equations[number];
    if equation.modulo_turn || !g.has(equation.rhs, leaf_bit(leaf)) {
        return None;
    }
    let polynomial = clear(g, equation.known, equation.rhs, UNKNOWNS)?;
    let scale = g.get_leaf(leaf);
    let powers = polynomial.by_powers_of(scale)?;
    let [rest, factor] = &powers[..] else { return None };
    let (rest, factor) = (rest.to_expr(g), factor.to_expr(g));
    let range = g.range(factor);
    let may_vanish = range.lo <= 0.0 && range.hi >= 0.0 && g.has(factor, OUTS);
    let others = g.deps(rest) & UNKNOWNS;
    let is_known = !g.has(factor, UNKNOWNS) && others & leaf_bit(leaf) == 0 && others != 0;
    (may_vanish && is_known).then_some(Scaled { number, factor, rest, others })
}
