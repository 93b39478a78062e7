//! Circle pairs: A f and A h with f² + h² = 1 determine A, f and h together.
//!
//! The cosine and sine of one angle are such a pair that is known by name ([`super::polar`]); z and
//! √(1 - z²), or √u and √(1 - u), are pairs as well. So are f and h with α f² + β h² = 1: known
//! factors may have been moved over before.

use super::polar::apart;
use super::{Condition, Equation, State};
use crate::derivative::derivative;
use crate::display::show;
use crate::expr::{Graph, Id, Leaf, UNKNOWNS};
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
                let range = g.range(split.amplitude);
                let mut signs = Vec::new();
                if !range.nonpositive() {
                    signs.push(1);
                }
                if !range.nonnegative() {
                    signs.push(-1);
                }
                return Some(signs.iter().map(|s| replace(g, state, i, j, &split, *s)).collect());
            }
        }
    }
    None
}

/// Two expressions A f / √α and A h / √β with f² + h² = 1.
struct Pair {
    amplitude: Id,
    f: Id,
    h: Id,
    /// √α and √β.
    weights: (Id, Id),
}

fn pair(g: &mut Graph, left: Id, right: Id) -> Option<Pair> {
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
    if g.as_number(sum) == Some(Q::ONE) {
        let one = g.int(1);
        return Some(Pair { amplitude, f, h, weights: (one, one) });
    }
    let (alpha, beta) = weights(g, f2, h2)?;
    let weights = (g.sqrt(alpha), g.sqrt(beta));
    let (f, h) = (g.mul(f, weights.0), g.mul(h, weights.1));
    Some(Pair { amplitude, f, h, weights })
}

/// Known α, β >= 0 with α a + β b = 1: what a and b depend on they must depend on in proportion.
fn weights(g: &mut Graph, a: Id, b: Id) -> Option<(Id, Id)> {
    let open = g.deps(a) & UNKNOWNS;
    if open.count_ones() != 1 || g.deps(b) & UNKNOWNS != open {
        return None;
    }
    let unknown = Leaf::Unknown(open.trailing_zeros() as u8);
    let mut slope = |x| {
        let slope = derivative(g, x, unknown);
        Expander::new(g).normal_form(slope)
    };
    let (da, db) = (slope(a)?, slope(b)?);
    // What the unknown only seems to occur in says nothing of it.
    if [da, db].iter().any(|d| g.as_number(*d).is_some_and(Q::is_zero)) {
        return None;
    }
    let ratio = g.div(db, da);
    let ratio = g.neg(ratio);
    let ratio = Expander::new(g).normal_form(ratio)?;
    let scaled = g.mul(ratio, a);
    let total = g.add(scaled, b);
    let total = Expander::new(g).normal_form(total)?;
    if g.has(ratio, UNKNOWNS) || g.has(total, UNKNOWNS) {
        return None;
    }
    let (alpha, beta) = (g.div(ratio, total), g.powi(total, -1));
    (g.range(alpha).nonnegative() && g.range(beta).nonnegative()).then_some((alpha, beta))
}

/// The factors that two expressions share.
fn common(g: &mut Graph, left: Id, right: Id) -> Option<Id> {
    let (_, left) = g.split(left);
    let (_, right) = g.split(right);
    let other = g.factors(right);
    let shared: Vec<(Id, Id)> = g.factors(left).into_iter().filter(|f| other.contains(f)).collect();
    (!shared.is_empty()).then(|| g.product(&shared))
}

fn replace(g: &mut Graph, state: &State, i: usize, j: usize, pair: &Pair, sign: i64) -> State {
    let mut s = state.clone();
    let Pair { amplitude, f, h, weights } = *pair;
    let p = g.mul(state.equations[i].known, weights.0);
    let q = g.mul(state.equations[j].known, weights.1);
    // A negative amplitude is the positive one of the opposite point.
    let (p, q) = if sign < 0 { (g.neg(p), g.neg(q)) } else { (p, q) };
    let (radius, _) = apart(g, p, q);
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
