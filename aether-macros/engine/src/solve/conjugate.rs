//! A number and a root that are conjugate: L(t) + √R(t) with R = L² + linear, as in sinh t + √(1 + sinh² t).
//!
//! With the root alone on one side, squaring cancels the squares of the unknown.

use super::{Condition, Equation, State};
use crate::derivative::derivative;
use crate::display::show;
use crate::expr::{Graph, Id, Leaf, Node, UNKNOWNS, leaf_bit};
use crate::jacobian::simplify;
use crate::rational::Q;

/// Solves the first equation of this kind for its unknown.
pub(super) fn rationalised(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    for (i, equation) in state.equations.iter().enumerate() {
        let unknowns = g.deps(equation.rhs) & UNKNOWNS;
        if equation.modulo_turn || unknowns.count_ones() != 1 {
            continue;
        }
        let unknown = Leaf::Unknown(unknowns.trailing_zeros() as u8);
        debug_assert!(leaf_bit(unknown) == unknowns);
        let Some((value, condition)) = solved(g, equation, unknown) else { continue };
        let mut next = state.clone();
        let rhs = g.get_leaf(unknown);
        next.solution.steps.push(format!("squared: {} = {}", show(g, rhs), show(g, value)));
        next.equations[i] = Equation { known: value, rhs, modulo_turn: false };
        if !g.range(condition).nonnegative() {
            next.solution.conditions.push(Condition(condition));
        }
        return Some(vec![next]);
    }
    None
}

/// The unknown, and what must not be negative: the root.
fn solved(g: &mut Graph, equation: &Equation, unknown: Leaf) -> Option<(Id, Id)> {
    let Node::Sum(constant, terms) = g.node(equation.rhs).clone() else { return None };
    let (roots, others): (Vec<_>, Vec<_>) = terms.into_iter().partition(|(_, t)| is_root(g, *t));
    let [(q, root)] = roots[..] else { return None };
    let rest = g.sum(constant, &others);
    let left = g.sub(equation.known, rest);
    let (left2, root2) = (g.powi(left, 2), g.powi(root, 2));
    let minus = g.number(q.mul(q)?.neg());
    let right2 = g.mul(minus, root2);
    let difference = g.add(left2, right2);
    let slope = derivative(g, difference, unknown);
    let slope = simplify(g, slope, None);
    if g.has(slope, UNKNOWNS) || g.as_number(slope).is_some_and(Q::is_zero) {
        return None;
    }
    let (variable, zero) = (g.get_leaf(unknown), g.int(0));
    let start = g.substitute(difference, &[(variable, zero)].into());
    let ratio = g.div(start, slope);
    let value = g.neg(ratio);
    let value = simplify(g, value, None);
    let left = g.substitute(left, &[(variable, value)].into());
    Some((value, if q.is_negative() { g.neg(left) } else { left }))
}

/// Whether a term is a square root of something unknown, and known otherwise.
fn is_root(g: &Graph, term: Id) -> bool {
    let Node::Product(factors) = g.node(term) else { return false };
    let mut open = factors.iter().filter(|(b, e)| g.has(*b, UNKNOWNS) || g.has(*e, UNKNOWNS));
    matches!((open.next(), open.next()), (Some((_, e)), None) if g.as_number(*e) == Some(Q::HALF))
}
