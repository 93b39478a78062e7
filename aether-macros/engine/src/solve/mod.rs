//! Inverting a system of equations: from outputs back to unknowns.
//!
//! The system X_i = f_i(u) is taken apart step by step. Every step replaces equations by simpler
//! ones: known summands and factors move over, a pair (A cos t, A sin t) becomes A and t, a linear
//! system becomes its atoms, a function of a single subexpression is undone. Steps that have several
//! answers branch, so a map that is many-to-one gets every preimage.

mod along;
mod angles;
mod circle;
mod conjugate;
mod cubic;
mod decouple;
pub(crate) mod linear;
mod logarithm;
mod normalise;
mod numeric;
mod pair;
mod peel;
mod pieces;
mod pivot;
pub(crate) mod polar;
mod projective;
mod quadric;
mod rational;
mod repeated;
mod ruled;
mod scale;
mod sine;
mod squares;
mod turned;

use std::collections::BTreeMap;

use crate::display::show;
use crate::expr::{Graph, Id, Leaf, Node, UNKNOWNS, leaf_bit};

/// One equation: `known` (an expression in outputs and parameters) equals `rhs` (in unknowns too).
#[derive(Clone, Debug)]
pub struct Equation {
    /// The side without unknowns.
    pub known: Id,
    /// The side with unknowns.
    pub rhs: Id,
    /// The right side holds only up to a multiple of 2π.
    pub modulo_turn: bool,
}

/// A test that a preimage must pass: `expr >= 0`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Condition(pub Id);

/// One preimage.
#[derive(Clone, Debug, Default)]
pub struct Solution {
    /// The unknowns, as expressions of outputs and parameters.
    pub unknowns: BTreeMap<Leaf, Id>,
    /// The same in terms of `names`, as far as there are any.
    pub short: BTreeMap<Leaf, Id>,
    /// What must hold beside the unknowns' ranges.
    pub conditions: Vec<Condition>,
    /// What subexpressions of the unknowns are in terms of the outputs.
    pub known: BTreeMap<Id, Id>,
    /// Long expressions of the outputs that go by a name of their own (an output beyond the last) in
    /// all of the above.
    pub names: BTreeMap<Id, Id>,
    /// Equations that were not needed: (known, rhs in unknowns).
    pub unused: Vec<(Id, Id)>,
    /// The steps taken, for `explain`.
    pub steps: Vec<String>,
    /// Which answer was taken of each step with several; but for roots on several pieces, which all are answers.
    pub answers: Vec<usize>,
    /// What tells of each of those roots that it lies in its piece; the conditions are among the others too.
    pub pieces: Vec<Within>,
}

/// What holds of a root on one of several pieces.
#[derive(Clone, Debug, Default)]
pub struct Within {
    /// How many pieces there are.
    pub of: usize,
    /// By how far it lies within the ends of its piece: not negative.
    pub conditions: Vec<Id>,
    /// Positive if there is such a piece for the parameters.
    pub widths: Vec<Id>,
}

impl Solution {
    /// An expression with the names replaced by what they stand for.
    pub fn spell_out(&self, g: &mut Graph, id: Id) -> Id {
        // A name may stand for an expression with an earlier name in it.
        (0..self.names.len()).fold(id, |id, _| g.substitute(id, &self.names))
    }
}

/// Why no inverse was found.
#[derive(Clone, Debug)]
pub struct Stuck {
    /// The equation that no rule could take further, as text.
    pub equation: String,
    /// The unknowns in it.
    pub unknowns: Vec<String>,
    /// Why it could not be solved numerically either, and what to do.
    pub numerical: Option<String>,
}

/// The state of one branch of the search.
#[derive(Clone)]
pub(crate) struct State {
    equations: Vec<Equation>,
    solution: Solution,
    next_unknown: u8,
    /// Expressions of the unknowns that are positive wherever there is a result.
    positive: Vec<Id>,
    /// Right sides of equations by which an unknown was eliminated from the others.
    eliminated: Vec<Id>,
    /// Whether roots without a closed form are wanted.
    numerical: Numerical,
    /// Whether one known coordinate of a normalised vector may give its length before all else.
    lengths_first: bool,
}

/// Which roots without a closed form are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Numerical {
    /// None.
    No,
    /// Those of monotone functions.
    Monotone,
    /// Also those of functions that turn back, one for each piece.
    Pieces,
}

/// Upper bound on search steps and on preimages.
const MAX_STEPS: usize = 400;
const MAX_PREIMAGES: usize = 16;

/// The number of the first unknown that is not one of the map.
pub const FIRST_OWN: u8 = 16;

/// What is to be solved.
#[derive(Clone, Debug, Default)]
pub struct System {
    /// Known sides, and those with unknowns.
    pub equations: Vec<(Id, Id)>,
    /// Expressions in unknowns of the map, and what they are in terms of the equations.
    pub told: Vec<(Id, Id)>,
    /// How many unknowns from [`FIRST_OWN`] on the equations have beside those of the map.
    pub own: u8,
}

impl System {
    /// `outputs[i]` = `targets[i]`.
    pub fn new(targets: &[Id], outputs: &[Id]) -> System {
        let equations = targets.iter().copied().zip(outputs.iter().copied()).collect();
        System { equations, ..System::default() }
    }
}

/// Solves a system for the unknowns: all preimages, in closed form if there is one.
pub fn solve(
    g: &mut Graph,
    system: &System,
    unknowns: &[Leaf],
    frames: &[[[Id; 3]; 3]],
    positive: &[Id],
    numerical: Numerical,
) -> Result<Vec<Solution>, Stuck> {
    let equation = |&(known, rhs)| Equation { known, rhs, modulo_turn: false };
    let first = State {
        equations: system.equations.iter().map(equation).collect(),
        solution: Solution { known: system.told.iter().copied().collect(), ..Solution::default() },
        next_unknown: FIRST_OWN + system.own,
        positive: positive.to_vec(),
        eliminated: vec![],
        numerical,
        lengths_first: false,
    };
    let again = State { lengths_first: true, ..first.clone() };
    let sheared = decouple::decoupled(g, &first);
    search(g, first, unknowns, frames).or_else(|stuck| {
        search(g, again, unknowns, frames)
            .or_else(|_| search(g, sheared.ok_or(())?, unknowns, frames).map_err(|_| ()))
            .map_err(|()| stuck)
    })
}

/// Applies rules until every branch of the search has all unknowns.
fn search(
    g: &mut Graph,
    first: State,
    unknowns: &[Leaf],
    frames: &[[[Id; 3]; 3]],
) -> Result<Vec<Solution>, Stuck> {
    let mut open = vec![first];
    let mut done = Vec::new();
    let mut steps = 0;
    while let Some(mut state) = open.pop() {
        steps += 1;
        if steps > MAX_STEPS || done.len() >= MAX_PREIMAGES {
            return Err(stuck(g, &state, unknowns, None));
        }
        // A length must be seen before a pair takes part of the vector apart, and with all
        // known factors of its coordinates in their place.
        if let Some(next) = quadric::normalised(g, &state) {
            open.extend(numbered(&state, next).into_iter().rev());
            continue;
        }
        strip_all(g, &mut state);
        if let Some(next) = quadric::multiplied(g, &state) {
            open.extend(next);
            continue;
        }
        // A pair must be seen before one of its members is solved through another equation.
        if let Some(next) = polar::polar_pair(g, &state) {
            open.extend(numbered(&state, next).into_iter().rev());
            continue;
        }
        settle(g, &mut state);
        if unknowns.iter().all(|u| state.solution.unknowns.contains_key(u)) {
            finish(g, &mut state);
            done.push(state.solution);
            continue;
        }
        // What has been settled may have laid a pair bare.
        if let Some(next) = polar::polar_pair(g, &state) {
            open.extend(numbered(&state, next).into_iter().rev());
            continue;
        }
        let mut why = None;
        if let Some(next) = step(g, &state, frames, &mut why) {
            open.extend(numbered(&state, next).into_iter().rev());
            continue;
        }
        return Err(stuck(g, &state, unknowns, why));
    }
    Ok(done)
}

/// The answers of a step by their numbers, if there are several that need not all be answers.
fn numbered(state: &State, mut next: Vec<State>) -> Vec<State> {
    if next.len() > 1 {
        for (i, s) in next.iter_mut().enumerate() {
            if s.solution.pieces.len() == state.solution.pieces.len() {
                s.solution.answers.push(i);
            }
        }
    }
    next
}

/// The rules in order of preference: those with a single answer and good conditioning first.
///
/// What has no closed form comes just before elimination, which would only make it longer. `why` tells
/// what stood in the way of a numerical solution.
fn step(
    g: &mut Graph,
    state: &State,
    frames: &[[[Id; 3]; 3]],
    why: &mut Option<String>,
) -> Option<Vec<State>> {
    let closed = numeric::undo_root(g, state)
        .or_else(|| normalise::unit_vector(g, state))
        .or_else(|| repeated::substitute(g, state))
        .or_else(|| turned::length_and_angle(g, state))
        .or_else(|| peel::unique(g, state))
        .or_else(|| logarithm::combine(g, state))
        .or_else(|| linear::linear_system(g, state, frames))
        .or_else(|| projective::quotients(g, state, frames))
        .or_else(|| scale::up_to_scale(g, state, frames))
        .or_else(|| circle::circle_pair(g, state))
        .or_else(|| normalise::common(g, state))
        .or_else(|| angles::double(g, state))
        .or_else(|| squares::squares(g, state))
        .or_else(|| peel::branching(g, state))
        .or_else(|| conjugate::rationalised(g, state))
        .or_else(|| rational::single_unknown(g, state))
        .or_else(|| sine::single_angle(g, state));
    if closed.is_none() && state.numerical > Numerical::No {
        let next =
            numeric::coupled(g, state, frames).map_or_else(|| numeric::monotone(g, state), Ok);
        match next {
            Ok(next) => return Some(next),
            Err(reason) => match pair::system(g, state) {
                Ok(next) => return Some(vec![next]),
                Err(other) => *why = reason.or(other),
            },
        }
        // Where there is a single root it is better found than computed by Cardano's formula.
        if let Some(next) = cubic::single_unknown(g, state) {
            return Some(next);
        }
        if state.numerical == Numerical::Pieces {
            match pieces::by_pieces(g, state) {
                Ok(next) => return Some(next),
                Err(reason) => *why = reason.or(why.take()),
            }
        }
    }
    closed
        .or_else(|| ruled::ruled(g, state))
        .or_else(|| pivot::scaled_pair(g, state))
        .or_else(|| rational::name_coefficients(g, state))
        .or_else(|| rational::eliminate(g, state))
}

/// Moves known parts of all equations over.
fn strip_all(g: &mut Graph, state: &mut State) {
    let mut stripped: Vec<_> = state.equations.iter().map(|eq| along::strip(g, eq)).collect();
    along::merge(g, state, &mut stripped);
    for (equation, stripped) in state.equations.iter_mut().zip(stripped) {
        for (rest, known) in stripped.told {
            state.solution.known.entry(rest).or_insert(known);
        }
        *equation = stripped.equation;
    }
}

/// Reads off solved unknowns and drops equations without unknowns.
fn settle(g: &mut Graph, state: &mut State) {
    loop {
        strip_all(g, state);
        let Some(i) = state.equations.iter().position(|e| {
            !e.modulo_turn && matches!(g.node(e.rhs), Node::Leaf(l @ Leaf::Unknown(_)) if !state.solution.unknowns.contains_key(l))
        }) else {
            break;
        };
        let eq = state.equations.remove(i);
        let Node::Leaf(leaf) = *g.node(eq.rhs) else { break };
        state.solution.steps.push(format!("{} = {}", show(g, eq.rhs), show(g, eq.known)));
        assign(g, state, leaf, eq.known);
    }
    let (open, unused): (Vec<_>, Vec<_>) =
        state.equations.drain(..).partition(|e| g.has(e.rhs, UNKNOWNS));
    state.equations = open;
    state.solution.unused.extend(unused.into_iter().map(|e| (e.known, e.rhs)));
}

/// Records `leaf = value` and substitutes it everywhere.
fn assign(g: &mut Graph, state: &mut State, leaf: Leaf, value: Id) {
    let variable = g.get_leaf(leaf);
    let map = BTreeMap::from([(variable, value)]);
    for e in &mut state.equations {
        // An equation that only this unknown was left in is a test: keep what it says of the unknown.
        // What holds only up to whole turns says nothing of signs, or of what an expression is.
        if !e.modulo_turn && g.deps(e.rhs) & UNKNOWNS == leaf_bit(leaf) {
            state.solution.known.entry(e.rhs).or_insert(e.known);
            sign_test(g, &mut state.solution.conditions, e);
        }
        let range = g.range(e.rhs);
        e.rhs = g.substitute(e.rhs, &map);
        if e.modulo_turn && g.has(e.rhs, UNKNOWNS) {
            // What was known of an angle remains true of it, whatever it is written in.
            g.assume(e.rhs, range);
        }
    }
    state.solution.known.insert(variable, value);
    for (_, v) in state.solution.known.iter_mut() {
        *v = g.substitute(*v, &map);
    }
    for (_, v) in state.solution.unknowns.iter_mut() {
        *v = g.substitute(*v, &map);
    }
    for c in &mut state.solution.conditions {
        c.0 = g.substitute(c.0, &map);
    }
    for p in &mut state.positive {
        *p = g.substitute(*p, &map);
    }
    state.solution.unknowns.insert(leaf, value);
}

/// A redundant equation whose right side has a fixed sign still says which half the point lies in.
fn sign_test(g: &mut Graph, conditions: &mut Vec<Condition>, e: &Equation) {
    let (known, rhs) = (g.range(e.known), g.range(e.rhs));
    let test = if rhs.nonnegative() && !known.nonnegative() {
        e.known
    } else if rhs.nonpositive() && !known.nonpositive() {
        g.neg(e.known)
    } else {
        return;
    };
    let test = Condition(test);
    if !conditions.contains(&test) {
        conditions.push(test);
    }
}

/// Splits an expression into (known summand, known factor, part with unknowns).
fn affine_parts(g: &mut Graph, id: Id) -> (Option<Id>, Id, Id) {
    let one = g.int(1);
    match g.node(id).clone() {
        Node::Sum(c, terms) => {
            let (open, closed): (Vec<_>, Vec<_>) =
                terms.into_iter().partition(|(_, t)| g.has(*t, UNKNOWNS));
            let constant = (!closed.is_empty() || !c.is_zero()).then(|| g.sum(c, &closed));
            match open[..] {
                [(q, t)] => (constant, g.number(q), t),
                _ if constant.is_some() => {
                    let rest = g.sum(crate::rational::Q::ZERO, &open);
                    (constant, one, rest)
                }
                _ => (None, one, id),
            }
        }
        Node::Product(factors) => {
            let (open, closed): (Vec<_>, Vec<_>) =
                factors.into_iter().partition(|(b, e)| g.has(*b, UNKNOWNS) || g.has(*e, UNKNOWNS));
            if closed.is_empty() {
                return (None, one, id);
            }
            let factor = g.product(&closed);
            let rest = g.product(&open);
            (None, factor, rest)
        }
        _ => (None, one, id),
    }
}

/// Substitutes auxiliary unknowns away and records what is left as unused.
fn finish(g: &mut Graph, state: &mut State) {
    for e in std::mem::take(&mut state.equations) {
        if !e.modulo_turn {
            state.solution.known.entry(e.rhs).or_insert(e.known);
        }
        state.solution.unused.push((e.known, e.rhs));
    }
    // Auxiliary unknowns are no unknowns of the caller.
    state.solution.unknowns.retain(|l, _| matches!(l, Leaf::Unknown(i) if *i < FIRST_OWN));
    state.solution.conditions.retain(|c| !g.range(c.0).nonnegative());
}

fn stuck(g: &Graph, state: &State, unknowns: &[Leaf], numerical: Option<String>) -> Stuck {
    let open: Vec<String> = unknowns
        .iter()
        .filter(|u| !state.solution.unknowns.contains_key(u))
        .map(|u| g.name(*u).to_owned())
        .collect();
    let equation = match state.equations.first() {
        Some(e) => format!("{} = {}", show(g, e.known), show(g, e.rhs)),
        None => format!("nothing determines {}", open.join(", ")),
    };
    Stuck { equation, unknowns: open, numerical }
}

#[cfg(test)]
mod tests;
