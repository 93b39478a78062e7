//! Projective maps: coordinates (a u + b v + c) / (g u + h v + k), each of which is linear in the unknowns over another such
//! sum. Multiplied by what divides them they are a linear system, whose coefficients have the coordinates in them.

use std::collections::BTreeMap;

use super::{Equation, State};
use crate::derivative::derivative;
use crate::display::show;
use crate::expr::{Graph, Id, Leaf, Node, UNKNOWNS, leaf_bit};
use crate::matrix::solve_matrix;
use crate::rational::Q;

/// Solves as many quotients of linear sums as there are unknowns in them.
pub(super) fn quotients(
    g: &mut Graph,
    state: &State,
    frames: &[[[Id; 3]; 3]],
) -> Option<Vec<State>> {
    let equations = &state.equations;
    let used = |e: &Equation| g.deps(e.rhs) & UNKNOWNS;
    let all = equations.iter().fold(0, |all, e| all | used(e));
    let unknowns: Vec<Leaf> =
        (0..24).map(Leaf::Unknown).filter(|&u| leaf_bit(u) & all != 0).collect();
    // What has an unknown by itself is solved by itself.
    let several = equations.iter().all(|e| used(e).count_ones() > 1 && !e.modulo_turn);
    let solvable = equations.len() > 1 && equations.len() == unknowns.len();
    if !solvable || !several || !equations.iter().all(|e| is_quotient(g, e)) {
        return None;
    }
    let (mut matrix, mut right) = (Vec::new(), Vec::new());
    for e in equations {
        let (top, bottom) = over_sums(g, e.rhs);
        let (tops, top) = linear(g, top, &unknowns)?;
        let (bottoms, bottom) = linear(g, bottom, &unknowns)?;
        // known · (bottoms · u + bottom) = tops · u + top
        let entry = |g: &mut Graph, a: Id, b: Id| {
            let product = g.mul(e.known, b);
            g.sub(a, product)
        };
        let row = tops.iter().zip(&bottoms).map(|(&a, &b)| entry(g, a, b)).collect::<Vec<Id>>();
        let rest = entry(g, top, bottom);
        matrix.push(row);
        right.push(g.neg(rest));
    }
    let (values, _) = solve_matrix(g, &matrix, &right, frames)?;
    let mut next = state.clone();
    next.equations.clear();
    for (&u, &value) in unknowns.iter().zip(&values) {
        let u = g.get_leaf(u);
        next.solution.steps.push(format!("projective: {} = {}", show(g, u), show(g, value)));
        next.equations.push(Equation { known: value, rhs: u, modulo_turn: false });
    }
    Some(vec![next])
}

/// Whether something is divided by a sum with unknowns.
fn is_quotient(g: &Graph, e: &Equation) -> bool {
    match g.node(e.rhs) {
        Node::Product(factors) => factors.iter().any(|f| is_below(g, f)),
        _ => false,
    }
}

/// Whether a factor is a sum with unknowns that divides.
fn is_below(g: &Graph, &(base, exponent): &(Id, Id)) -> bool {
    let below = g.as_number(exponent) == Some(Q::int(-1));
    below && g.has(base, UNKNOWNS) && matches!(g.node(base), Node::Sum(..))
}

/// An expression as a product over the sums with unknowns that divide it.
fn over_sums(g: &mut Graph, id: Id) -> (Id, Id) {
    let (q, body) = g.split(id);
    let (below, mut above): (Vec<_>, Vec<_>) =
        g.factors(body).into_iter().partition(|f| is_below(g, f));
    let one = g.int(1);
    let k = g.number(q);
    above.push((k, one));
    let below: Vec<(Id, Id)> = below.into_iter().map(|(b, _)| (b, one)).collect();
    (g.product(&above), g.product(&below))
}

/// The coefficients of an expression that is linear in some unknowns, and what it is where these are zero.
fn linear(g: &mut Graph, id: Id, unknowns: &[Leaf]) -> Option<(Vec<Id>, Id)> {
    let mut coefficients = Vec::new();
    for &u in unknowns {
        let slope = derivative(g, id, u);
        if g.has(slope, UNKNOWNS) {
            return None;
        }
        coefficients.push(slope);
    }
    let zero = g.int(0);
    let zeros: BTreeMap<Id, Id> = unknowns.iter().map(|&u| (g.get_leaf(u), zero)).collect();
    Some((coefficients, g.substitute(id, &zeros)))
}
