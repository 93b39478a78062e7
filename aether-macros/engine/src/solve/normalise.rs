//! Normalised vectors: every output is T_i / |T|, and only the direction of T is known.

use super::{Condition, Equation, State};
use crate::display::show;
use crate::expr::{Graph, Id, Leaf, Node, UNKNOWNS};
use crate::interval::Interval;
use crate::rational::Q;

/// Outputs that are divided by a common length, √(a sum): before anything else takes the root apart.
pub(super) fn unit_vector(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    let (factors, members) = common_factor(g, state)?;
    factors
        .iter()
        .any(|&(b, e)| is_length(g, b, e))
        .then(|| name_factor(g, state, &factors, &members))
}

/// The lengths √(a sum) that outputs are divided by, each with the equations of these.
pub(super) fn common_lengths(g: &mut Graph, state: &State) -> Vec<(Id, Vec<usize>)> {
    let mut found = Vec::new();
    for (base, exponent, members) in common_factors(g, state) {
        if is_length(g, base, exponent) {
            found.push((g.sqrt(base), members));
        }
    }
    found
}

/// What three outputs have in common as a factor, and their equations, where it is more than a length: of a reflected
/// viewer, 2 (w · h) / |T|² for a half vector h = T / |T|.
pub(super) fn common_multiple(g: &mut Graph, state: &State) -> Option<(Id, Vec<usize>)> {
    let (factors, members) = common_factor(g, state)?;
    let more = members.len() == 3 && factors.iter().any(|&(b, e)| !is_length(g, b, e));
    more.then(|| (g.product(&factors), members))
}

fn is_length(g: &Graph, base: Id, exponent: Id) -> bool {
    g.as_number(exponent) == Some(Q::HALF.neg()) && matches!(g.node(base), Node::Sum(..))
}

/// Any common factor of several equations.
pub(super) fn common(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    let (factors, members) = common_factor(g, state)?;
    // Equations that say the same of the factor, and nothing else, have no use for a name of it.
    let plain = g.product(&factors);
    let mut rests = members.iter().map(|&i| {
        let rest = g.div(state.equations[i].rhs, plain);
        super::affine_parts(g, rest).2
    });
    let first = rests.next()?;
    let differ = rests.any(|rest| rest != first);
    differ.then(|| name_factor(g, state, &factors, &members))
}

/// Gives a common factor a name of its own.
///
/// X_i = T_i · F with the same F everywhere becomes X_i · λ = T_i with the new unknown λ = 1 / F:
/// linear in λ and in the atoms of T. F = 1 / |T| is the normalised vector, F = t(w) the ray w · t(w).
fn name_factor(
    g: &mut Graph,
    state: &State,
    factors: &[(Id, Id)],
    members: &[usize],
) -> Vec<State> {
    let mut s = state.clone();
    let leaf = Leaf::Unknown(s.next_unknown);
    s.next_unknown += 1;
    let plain = g.product(factors);
    // A known multiple of the factor may be required to be positive: then that is the better name.
    let required = state.positive.iter().find_map(|&r| {
        let multiple = g.div(r, plain);
        (!g.has(multiple, UNKNOWNS)).then_some(r)
    });
    let factor = required.unwrap_or(plain);
    let multiple = g.div(factor, plain);
    let positive = required.is_some() || g.range(plain).nonnegative();
    let lambda = g.leaf(leaf, "λ", if positive { Interval::POSITIVE } else { Interval::ALL });
    for &i in members {
        let e = &mut s.equations[i];
        let t = g.div(e.rhs, plain);
        let known = g.mul(e.known, multiple);
        let scaled = g.mul(lambda, known);
        let (constant, _, _) = super::affine_parts(g, t);
        let zero = g.int(0);
        let constant = match constant {
            Some(c) => c,
            None if g.has(t, UNKNOWNS) => zero,
            None => t,
        };
        let open = g.sub(t, constant);
        // λ X_i - (T_i - constant) = constant
        let rhs = g.sub(scaled, open);
        *e = Equation { known: constant, rhs, modulo_turn: false };
    }
    if positive {
        s.solution.conditions.push(Condition(lambda));
    }
    // An unknown that is in the factor alone is found from it: 1 = λ · factor.
    let elsewhere = s.equations.iter().fold(0, |deps, e| deps | g.deps(e.rhs));
    if g.deps(factor) & UNKNOWNS & !elsewhere != 0 {
        let (known, rhs) = (g.int(1), g.mul(lambda, factor));
        s.equations.push(Equation { known, rhs, modulo_turn: false });
    }
    let inverse = g.powi(lambda, -1);
    s.solution.known.insert(factor, inverse);
    s.solution.steps.push(format!("common factor: 1/λ = {}", show(g, factor)));
    vec![s]
}

/// Factors, base and exponent, and the equations that share them.
type Shared = (Vec<(Id, Id)>, Vec<usize>);

/// The factor that most equations share, with all others that the same equations share.
fn common_factor(g: &mut Graph, state: &State) -> Option<Shared> {
    let all = common_factors(g, state);
    let most = all.iter().map(|(_, _, m)| m.len()).max()?;
    let members = all.iter().find(|(_, _, m)| m.len() == most)?.2.clone();
    let shared = all.into_iter().filter(|(_, _, m)| *m == members);
    Some((shared.map(|(b, e, _)| (b, e)).collect(), members))
}

/// Factors that at least two equations share, each with the equations that have it.
fn common_factors(g: &mut Graph, state: &State) -> Vec<(Id, Id, Vec<usize>)> {
    let among: Vec<usize> =
        (0..state.equations.len()).filter(|&i| !state.equations[i].modulo_turn).collect();
    let mut found: Vec<(Id, Id, Vec<usize>)> = Vec::new();
    // A rational factor makes a sum of an expression: what it is a factor of is looked at.
    let factors: Vec<Vec<(Id, Id)>> = (0..state.equations.len())
        .map(|i| {
            let (_, body) = g.split(state.equations[i].rhs);
            g.factors(body)
        })
        .collect();
    for &i in &among {
        for &(b, e) in &factors[i] {
            let known = found.iter().any(|(base, exponent, _)| (*base, *exponent) == (b, e));
            // A lone unknown is an atom of its own, not a factor to take out.
            if known || !g.has(b, UNKNOWNS) || matches!(g.node(b), Node::Leaf(_)) {
                continue;
            }
            let members: Vec<usize> =
                among.iter().copied().filter(|&j| factors[j].contains(&(b, e))).collect();
            if members.len() >= 2 {
                found.push((b, e, members));
            }
        }
    }
    found
}
