//! Polar pairs: A cos t and A sin t determine A and t together.

use super::{Equation, State};
use crate::display::show;
use crate::expr::{Fun, Graph, Id, Node, UNKNOWNS};

/// Replaces two equations P = A cos t, Q = A sin t by A = √(P² + Q²) and t = atan2(Q, P) mod 2π.
pub(super) fn polar_pair(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    let n = state.equations.len();
    for i in 0..n {
        for (angle, rest) in with_factor(g, state.equations[i].rhs, Fun::Cos) {
            for j in (0..n).filter(|j| *j != i) {
                let partner = with_factor(g, state.equations[j].rhs, Fun::Sin)
                    .into_iter()
                    .any(|p| p == (angle, rest));
                if partner && g.has(angle, UNKNOWNS) {
                    return Some(split(g, state, i, j, angle, rest));
                }
            }
        }
    }
    None
}

/// All ways to write an expression as f(angle) · rest.
pub(crate) fn with_factor(g: &mut Graph, id: Id, f: Fun) -> Vec<(Id, Id)> {
    let one = g.int(1);
    let factors = g.factors(id);
    let mut found = Vec::new();
    for (k, &(base, exp)) in factors.iter().enumerate() {
        let Node::Call(h, args) = g.node(base).clone() else { continue };
        if h == f && exp == one {
            let rest: Vec<_> =
                factors.iter().enumerate().filter(|(m, _)| *m != k).map(|(_, x)| *x).collect();
            found.push((args[0], g.product(&rest)));
        }
    }
    found
}

fn split(g: &mut Graph, state: &State, i: usize, j: usize, angle: Id, amplitude: Id) -> Vec<State> {
    let (p, q) = (state.equations[i].known, state.equations[j].known);
    let p2 = g.powi(p, 2);
    let q2 = g.powi(q, 2);
    let sum = g.add(p2, q2);
    let radius = g.sqrt(sum);
    let range = g.range(amplitude);
    let mut signs = Vec::new();
    if !range.nonpositive() {
        signs.push(1);
    }
    if !range.nonnegative() {
        signs.push(-1);
    }
    signs
        .into_iter()
        .map(|sign| {
            let mut s = state.clone();
            let (y, x) = if sign > 0 { (q, p) } else { (g.neg(q), g.neg(p)) };
            let radius = if sign > 0 { radius } else { g.neg(radius) };
            let t = g.call(Fun::Atan2, &[y, x]);
            s.equations[i] = Equation { known: radius, rhs: amplitude, modulo_turn: false };
            s.equations[j] = Equation { known: t, rhs: angle, modulo_turn: true };
            // A known amplitude can be negative; then the angle turns by half a turn.
            if !g.has(amplitude, UNKNOWNS) && !range.nonnegative() && !range.nonpositive() {
                let sign = g.call(Fun::Sign, &[amplitude]);
                let (y, x) = (g.mul(sign, q), g.mul(sign, p));
                s.equations[j].known = g.call(Fun::Atan2, &[y, x]);
            }
            let cos = g.call(Fun::Cos, &[angle]);
            let sin = g.call(Fun::Sin, &[angle]);
            let c = g.div(p, radius);
            let n = g.div(q, radius);
            s.solution.known.entry(cos).or_insert(c);
            s.solution.known.entry(sin).or_insert(n);
            s.solution.known.entry(amplitude).or_insert(radius);
            s.solution.steps.push(format!(
                "polar pair: {} = {}, {} = {} (mod 2π)",
                show(g, amplitude),
                show(g, radius),
                show(g, angle),
                show(g, s.equations[j].known)
            ));
            s
        })
        .collect()
}
