//! Circle pairs: A f and A h with f² + h² = 1 determine A, f and h together.
//!
//! The cosine and sine of one angle are such a pair that is known by name ([`super::polar`]); z and
//! √(1 - z²), or √u and √(1 - u), are pairs as well.

use super::{Condition, Equation, State};
use crate::display::show;
use crate::expr::{Graph, Id, UNKNOWNS};
use crate::poly::Expander;
use crate::rational::Q;

/// Replaces two equations P = A f, Q = A h, where f² + h² = 1, by A = √(P² + Q²) and f = P / A;
/// h = Q / A is then known too. An A that can be negative may also be -√(P² + Q²).
pub(super) fn circle_pair(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    let n = state.equations.len();
    for i in 0..n {
        for j in (i + 1)..n {
            let (a, b) = (&state.equations[i], &state.equations[j]);
            if a.modulo_turn || b.modulo_turn || g.deps(a.rhs) & g.deps(b.rhs) & UNKNOWNS == 0 {
                continue;
            }
            if let Some(split) = pair(g, a.rhs, b.rhs) {
                let range = g.range(split.0);
                let mut signs = Vec::new();
                if !range.nonpositive() {
                    signs.push(1);
                }
                if !range.nonnegative() {
                    signs.push(-1);
                }
                return Some(signs.iter().map(|s| replace(g, state, i, j, split, *s)).collect());
            }
        }
    }
    None
}

/// Writes two expressions as (A, f, h): A f and A h with f² + h² = 1.
fn pair(g: &mut Graph, left: Id, right: Id) -> Option<(Id, Id, Id)> {
    let amplitude = common(g, left, right)?;
    if !g.has(amplitude, UNKNOWNS) {
        return None;
    }
    let (f, h) = (g.div(left, amplitude), g.div(right, amplitude));
    if !g.has(f, UNKNOWNS) || !g.has(h, UNKNOWNS) {
        return None;
    }
    let (f2, h2) = (g.powi(f, 2), g.powi(h, 2));
    let sum = g.add(f2, h2);
    let sum = Expander::new(g).normal_form(sum)?;
    (g.as_number(sum) == Some(Q::ONE)).then_some((amplitude, f, h))
}

/// The factors that two expressions share.
fn common(g: &mut Graph, left: Id, right: Id) -> Option<Id> {
    let (_, left) = g.split(left);
    let (_, right) = g.split(right);
    let other = g.factors(right);
    let shared: Vec<(Id, Id)> = g.factors(left).into_iter().filter(|f| other.contains(f)).collect();
    (!shared.is_empty()).then(|| g.product(&shared))
}

fn replace(
    g: &mut Graph,
    state: &State,
    i: usize,
    j: usize,
    (amplitude, f, h): (Id, Id, Id),
    sign: i64,
) -> State {
    let mut s = state.clone();
    let (p, q) = (state.equations[i].known, state.equations[j].known);
    // A negative amplitude is the positive one of the opposite point.
    let (p, q) = if sign < 0 { (g.neg(p), g.neg(q)) } else { (p, q) };
    let (p2, q2) = (g.powi(p, 2), g.powi(q, 2));
    let sum = g.add(p2, q2);
    let radius = g.sqrt(sum);
    let size = if sign < 0 { g.neg(radius) } else { radius };
    s.equations[i] = Equation { known: size, rhs: amplitude, modulo_turn: false };
    // The plainer of the two is solved for; the other keeps its sign.
    let (solved, value, test, other) =
        if has_root(g, f) && !has_root(g, h) { (h, q, p, f) } else { (f, p, q, h) };
    let ratio = g.div(value, radius);
    let rest = g.div(test, radius);
    s.equations[j] = Equation { known: ratio, rhs: solved, modulo_turn: false };
    for (part, value) in [(amplitude, size), (solved, ratio), (other, rest)] {
        s.solution.known.entry(part).or_insert(value);
    }
    if g.range(other).nonnegative() && !g.range(test).nonnegative() {
        s.solution.conditions.push(Condition(test));
    }
    s.solution.steps.push(format!(
        "circle pair: {} = {}, {} = {}",
        show(g, amplitude),
        show(g, size),
        show(g, solved),
        show(g, ratio)
    ));
    s
}

/// Whether an expression is a root of something open.
fn has_root(g: &mut Graph, id: Id) -> bool {
    let (_, id) = g.split(id);
    g.factors(id).into_iter().any(|(_, e)| g.as_number(e).is_some_and(|q| q.den() == 2))
}
