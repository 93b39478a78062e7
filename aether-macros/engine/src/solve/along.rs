//! Several coordinates that are linear in one expression, as those of a point on a line are.
//!
//! Each of x_i = o_i + d_i t says what t is, but one that does not vary says nothing, and which that is depends on
//! parameters. t = Σ d_i (x_i - o_i) / Σ d_i² is as good as the best of them.

use super::{Equation, State, affine_parts};
use crate::display::show;
use crate::expr::{Graph, Id, Node, OUTS, UNKNOWNS};
use crate::matrix::dot;
use crate::rational::Q;

/// An equation with the known parts of its right side moved over.
pub(super) struct Stripped {
    /// What it has become: `numerator / factor` is known of the rest.
    pub equation: Equation,
    numerator: Id,
    factor: Id,
    /// What it says of parts of its right side.
    pub told: Vec<(Id, Id)>,
}

/// Brings `known = a + b·rhs` (a, b known) to `(known - a) / b = rhs`, as often as it applies.
pub(super) fn strip(g: &mut Graph, eq: &Equation) -> Stripped {
    let (mut equation, one) = (eq.clone(), g.int(1));
    let (mut numerator, mut divisor, mut told) = (eq.known, one, Vec::new());
    loop {
        let (constant, factor, rest) = affine_parts(g, equation.rhs);
        // Shifts keep a period; a factor does not.
        let is_done = rest == equation.rhs || !g.has(rest, UNKNOWNS);
        if is_done || (equation.modulo_turn && factor != one) {
            return Stripped { equation, numerator, factor: divisor, told };
        }
        if let Some(c) = constant {
            equation.known = g.sub(equation.known, c);
            let scaled = g.mul(c, divisor);
            numerator = g.sub(numerator, scaled);
        }
        equation.known = g.div(equation.known, factor);
        divisor = g.mul(divisor, factor);
        equation.rhs = rest;
        if !equation.modulo_turn {
            told.push((rest, equation.known));
        }
    }
}

/// Replaces equations that tell the same expression, each divided by a parameter that may be zero, by one that is divided by
/// the sum of the squares of these.
pub(super) fn merge(g: &mut Graph, state: &mut State, stripped: &mut Vec<Stripped>) {
    let mut first = 0;
    while first < stripped.len() {
        let rest = stripped[first].equation.rhs;
        let tells = |s: &Stripped| !s.equation.modulo_turn && s.equation.rhs == rest;
        let alike: Vec<usize> = (first..stripped.len()).filter(|&i| tells(&stripped[i])).collect();
        let factors: Vec<Id> = alike.iter().map(|&i| stripped[i].factor).collect();
        let may_vanish = |&factor: &Id| {
            let range = g.range(factor);
            range.lo <= 0.0 && range.hi >= 0.0 && g.deps(factor) & (OUTS | UNKNOWNS) == 0
        };
        if alike.len() > 1 && g.has(rest, UNKNOWNS) && factors.iter().all(may_vanish) {
            let numerators: Vec<Id> = alike.iter().map(|&i| stripped[i].numerator).collect();
            let (shared, factors) = without_shared(g, &factors);
            let (above, below) = (dot(g, &factors, &numerators), dot(g, &factors, &factors));
            let ratio = g.div(above, below);
            let known = g.div(ratio, shared);
            state.solution.steps.push(format!(
                "along a line: {} = {}",
                show(g, rest),
                show(g, known)
            ));
            let unused = alike.iter().map(|&i| &state.equations[i]).map(|e| (e.known, e.rhs));
            state.solution.unused.extend(unused);
            let (equation, one) = (Equation { known, rhs: rest, modulo_turn: false }, g.int(1));
            stripped[first] =
                Stripped { equation, numerator: known, factor: one, told: vec![(rest, known)] };
            for &i in alike[1..].iter().rev() {
                stripped.remove(i);
                state.equations.remove(i);
            }
        }
        first += 1;
    }
}

/// What all expressions are multiplied with, numbers aside, and the rest of each.
fn without_shared(g: &mut Graph, factors: &[Id]) -> (Id, Vec<Id>) {
    let each: Vec<_> = factors
        .iter()
        .map(|&factor| match g.node(factor).clone() {
            Node::Sum(c, terms) if c.is_zero() && terms.len() == 1 => {
                (terms[0].0, g.factors(terms[0].1))
            }
            _ => (Q::ONE, g.factors(factor)),
        })
        .collect();
    let is_shared = |part: &(Id, Id)| each.iter().all(|(_, parts)| parts.contains(part));
    let shared: Vec<_> = each[0].1.iter().filter(|part| is_shared(part)).copied().collect();
    let rest = each.iter().map(|(q, parts)| {
        let rest: Vec<_> = parts.iter().filter(|part| !shared.contains(part)).copied().collect();
        let rest = g.product(&rest);
        g.sum(Q::ZERO, &[(*q, rest)])
    });
    let rest = rest.collect();
    (g.product(&shared), rest)
}
