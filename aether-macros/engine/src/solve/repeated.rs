//! What one equation says of an expression holds wherever else that expression occurs.

use super::{State, sign_test};
use crate::display::show;
use crate::expr::{Graph, Id, Node, UNKNOWNS};

/// Replaces the whole right side of one equation in all others by what is known of it; where that is a coordinate, and it does
/// not occur itself, in its integer powers.
pub(super) fn substitute(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    substitute_by(g, state, (Graph::replace_part, false))
        .or_else(|| substitute_by(g, state, (Graph::replace_powers, true)))
}

/// Replaces a part of an expression by another one.
type Replace = fn(&mut Graph, Id, Id, Id) -> Id;

fn substitute_by(
    g: &mut Graph,
    state: &State,
    (replace, coordinates): (Replace, bool),
) -> Option<Vec<State>> {
    for i in 0..state.equations.len() {
        let e = &state.equations[i];
        if coordinates && !matches!(g.node(e.known), Node::Leaf(_)) {
            continue;
        }
        if e.modulo_turn || matches!(g.node(e.rhs), Node::Leaf(_)) || !g.has(e.rhs, UNKNOWNS) {
            continue;
        }
        let (part, value) = (e.rhs, e.known);
        let others = (0..state.equations.len()).filter(|&j| j != i);
        let replaced: Vec<_> = others
            .map(|j| (j, replace(g, state.equations[j].rhs, part, value)))
            .filter(|(j, rhs)| *rhs != state.equations[*j].rhs)
            .collect();
        if replaced.is_empty() {
            continue;
        }
        let mut s = state.clone();
        s.solution.steps.push(format!("{} = {} everywhere", show(g, e.rhs), show(g, e.known)));
        for (j, rhs) in replaced {
            sign_test(g, &mut s.solution.conditions, &s.equations[j]);
            // The window of an angle does not follow from what is put in its place.
            if s.equations[j].modulo_turn && g.has(rhs, UNKNOWNS) {
                let range = g.range(s.equations[j].rhs);
                g.assume(rhs, range);
            }
            s.equations[j].rhs = rhs;
        }
        return Some(vec![s]);
    }
    None
}
