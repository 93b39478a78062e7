//! What one equation says of an expression holds wherever else that expression occurs.

use super::{State, sign_test};
use crate::display::show;
use crate::expr::{Graph, Node, UNKNOWNS};

/// Replaces the whole right side of one equation in all others by what is known of it.
pub(super) fn substitute(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    for i in 0..state.equations.len() {
        let e = &state.equations[i];
        if e.modulo_turn || matches!(g.node(e.rhs), Node::Leaf(_)) || !g.has(e.rhs, UNKNOWNS) {
            continue;
        }
        let (part, value) = (e.rhs, e.known);
        let others = (0..state.equations.len()).filter(|&j| j != i);
        let replaced: Vec<_> = others
            .map(|j| (j, g.replace_part(state.equations[j].rhs, part, value)))
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
