//! A length and its angle: √(a² + b²) and atan2(b, a) determine a and b together. The way back from a polar pair.

use super::{Condition, Equation, State};
use crate::display::show;
use crate::expr::{Fun, Graph, Id, Node, UNKNOWNS};
use crate::poly::Expander;
use crate::rational::Q;

/// Replaces two equations L = √(a² + b²), t = atan2(b, a) by a = L cos t, b = L sin t.
pub(super) fn length_and_angle(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    for (j, angle) in state.equations.iter().enumerate() {
        let Node::Call(Fun::Atan2, args) = g.node(angle.rhs).clone() else { continue };
        let [b, a] = args[..] else { continue };
        if angle.modulo_turn || ![a, b].iter().all(|side| g.has(*side, UNKNOWNS)) {
            continue;
        }
        let squares = [a, b].map(|side| g.powi(side, 2));
        let sum = g.add(squares[0], squares[1]);
        let sum = expanded(g, sum);
        for i in (0..state.equations.len()).filter(|i| *i != j) {
            let Equation { known, rhs, .. } = state.equations[i];
            let square = g.powi(rhs, 2);
            let length = if expanded(g, square) == sum && g.range(rhs).nonnegative() {
                known
            } else if expanded(g, rhs) == sum {
                g.sqrt(known)
            } else {
                continue;
            };
            return Some(vec![turned(g, state, [i, j], length, [a, b])]);
        }
    }
    None
}

fn expanded(g: &mut Graph, id: Id) -> Id {
    Expander::new(g).normal_form(id).unwrap_or(id)
}

fn turned(g: &mut Graph, state: &State, [i, j]: [usize; 2], length: Id, sides: [Id; 2]) -> State {
    let mut s = state.clone();
    let (angle, known) = (s.equations[j].known, s.equations[i].known);
    let parts = [Fun::Cos, Fun::Sin].map(|f| {
        let part = g.call(f, &[angle]);
        g.mul(length, part)
    });
    for (place, (side, part)) in [i, j].into_iter().zip(sides.into_iter().zip(parts)) {
        s.equations[place] = Equation { known: part, rhs: side, modulo_turn: false };
        s.solution.steps.push(format!(
            "a length and its angle: {} = {}",
            show(g, side),
            show(g, part)
        ));
    }
    // Other angles, and negative lengths, are those of no point.
    let pi = g.pi();
    let ends = [1, -1].map(|side| g.sum(Q::ZERO, &[(Q::ONE, pi), (Q::int(side), angle)]));
    for test in [known].into_iter().chain(ends) {
        if !g.range(test).nonnegative() && !s.solution.conditions.contains(&Condition(test)) {
            s.solution.conditions.push(Condition(test));
        }
    }
    s
}
