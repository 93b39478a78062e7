//! Sums of logarithms of one unknown: ln u - ln(1 - u) is the logarithm of a quotient.

use super::State;
use crate::display::show;
use crate::expr::{Fun, Graph, Id, Node, UNKNOWNS};
use crate::rational::Q;

/// known = q Σ ± ln A_i gives exp(known / q) = Π A_i^±1.
pub(super) fn combine(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    for (i, e) in state.equations.iter().enumerate() {
        let Node::Sum(c, terms) = g.node(e.rhs).clone() else { continue };
        let size = terms.first().map_or(Q::ONE, |(q, _)| q.abs());
        let alike = terms.iter().all(|(q, _)| q.abs() == size);
        if e.modulo_turn || !c.is_zero() || !alike || (g.deps(e.rhs) & UNKNOWNS).count_ones() != 1 {
            continue;
        }
        let Some(arguments) =
            terms.iter().map(|(_, t)| argument(g, *t)).collect::<Option<Vec<_>>>()
        else {
            continue;
        };
        let factors: Vec<(Id, Id)> = arguments
            .iter()
            .zip(&terms)
            .map(|(a, (q, _))| (*a, g.int(if q.is_negative() { -1 } else { 1 })))
            .collect();
        let quotient = g.product(&factors);
        let scale = size.recip()?;
        let exponent = g.sum(Q::ZERO, &[(scale, e.known)]);
        let mut s = state.clone();
        s.equations[i].known = g.call(Fun::Exp, &[exponent]);
        s.equations[i].rhs = quotient;
        s.solution.known.entry(e.rhs).or_insert(e.known);
        s.solution.known.entry(quotient).or_insert(s.equations[i].known);
        let step = (show(g, s.equations[i].known), show(g, quotient));
        s.solution.steps.push(format!("{} = {}", step.0, step.1));
        return Some(vec![s]);
    }
    None
}

/// What a logarithm is taken of.
fn argument(g: &mut Graph, t: Id) -> Option<Id> {
    match g.node(t).clone() {
        Node::Call(Fun::Ln, a) => Some(a[0]),
        Node::Call(Fun::Ln1p, a) => {
            let one = g.int(1);
            Some(g.add(one, a[0]))
        }
        _ => None,
    }
}
