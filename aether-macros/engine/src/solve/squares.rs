//! Systems X_i = S_i T_i in which the unknowns enter the positive T_i only through squares of the S_i.

use std::collections::BTreeMap;

use super::{Equation, State};
use crate::display::show;
use crate::expr::{Fun, Graph, Id, Leaf, UNKNOWNS, leaf_bit};
use crate::interval::Interval;
use crate::rational::Q;

/// Replaces the equations by X_i² = A_i T_i², with A_i = S_i² for unknowns, and S_i = sign(X_i) √A_i:
/// roots in the T_i are gone, and no sign is lost.
pub(super) fn squares(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    if state.equations.len() < 2 || state.equations.iter().any(|e| e.modulo_turn) {
        return None;
    }
    let signed: Vec<Id> =
        state.equations.iter().map(|e| signed_factor(g, e.rhs)).collect::<Option<_>>()?;
    let covered = signed.iter().fold(0, |bits, s| bits | g.deps(*s));
    let all = state.equations.iter().fold(0, |bits, e| bits | (g.deps(e.rhs) & UNKNOWNS));
    if covered & UNKNOWNS != all || !state.equations.iter().any(|e| has_root(g, e.rhs)) {
        return None;
    }
    let mut s = state.clone();
    let mut map = BTreeMap::new();
    let mut roots = Vec::new();
    for &part in &signed {
        let leaf = Leaf::Unknown(s.next_unknown);
        s.next_unknown += 1;
        let largest = g.range(part).lo.abs().max(g.range(part).hi.abs());
        let name = ["A", "B", "C"].get(roots.len())?;
        let square = g.leaf(leaf, name, Interval::new(0.0, largest * largest));
        let root = g.sqrt(square);
        map.insert(part, root);
        roots.push((leaf, root));
    }
    let mut equations = Vec::new();
    for e in &state.equations {
        let known = g.powi(e.known, 2);
        let squared = g.powi(e.rhs, 2);
        let rhs = g.substitute(squared, &map);
        // Left over is an unknown that does not come as a square, or a root.
        let fresh = roots.iter().fold(0, |bits, (l, _)| bits | leaf_bit(*l));
        if g.deps(rhs) & UNKNOWNS & !fresh != 0 || has_root(g, rhs) {
            return None;
        }
        equations.push(Equation { known, rhs, modulo_turn: false });
    }
    for ((e, &part), (_, root)) in state.equations.iter().zip(&signed).zip(&roots) {
        let known = g.call(Fun::Sign, &[e.known]);
        let rhs = g.div(part, *root);
        s.solution.steps.push(format!(
            "squared: {} has the sign of {}",
            show(g, part),
            show(g, e.known)
        ));
        equations.push(Equation { known, rhs, modulo_turn: false });
    }
    s.equations = equations;
    Some(vec![s])
}

/// The only factor that can be negative; it stands in no power and holds a single unknown.
fn signed_factor(g: &mut Graph, rhs: Id) -> Option<Id> {
    let (_, body) = g.split(rhs);
    let factors = g.factors(body);
    let mut open = factors.iter().filter(|(b, e)| {
        let plain = g.as_number(*e) == Some(Q::ONE);
        plain && !g.range(*b).nonnegative()
    });
    let (part, _) = *open.next()?;
    let single = (g.deps(part) & UNKNOWNS).count_ones() == 1;
    if open.next().is_some() || !single {
        return None;
    }
    let positive = factors.iter().filter(|(b, _)| *b != part).all(|&(b, e)| {
        let whole = g.pow(b, e);
        g.range(whole).nonnegative()
    });
    positive.then_some(part)
}

/// Whether a square root of something open occurs among the factors.
fn has_root(g: &mut Graph, id: Id) -> bool {
    let (_, body) = g.split(id);
    let half = |e: Id, g: &Graph| g.as_number(e).is_some_and(|q| q.den() == 2);
    g.factors(body).into_iter().any(|(b, e)| g.has(b, UNKNOWNS) && half(e, g))
}
