//! Inverting a system of equations: from outputs back to unknowns.
//!
//! The system X_i = f_i(u) is taken apart step by step. Every step replaces equations by simpler
//! ones: known summands and factors move over, a pair (A cos t, A sin t) becomes A and t, a linear
//! system becomes its atoms, a function of a single subexpression is undone. Steps that have several
//! answers branch, so a map that is many-to-one gets every preimage.

pub(crate) mod linear;
mod normalise;
mod peel;
mod polar;
mod rational;

use std::collections::{BTreeMap, HashMap};

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
    /// What must hold beside the unknowns' ranges.
    pub conditions: Vec<Condition>,
    /// What subexpressions of the unknowns are in terms of the outputs.
    pub known: HashMap<Id, Id>,
    /// Equations that were not needed: (known, rhs in unknowns).
    pub unused: Vec<(Id, Id)>,
    /// The steps taken, for `explain`.
    pub steps: Vec<String>,
}

/// Why no inverse was found.
#[derive(Clone, Debug)]
pub struct Stuck {
    /// The equation that no rule could take further, as text.
    pub equation: String,
    /// The unknowns in it.
    pub unknowns: Vec<String>,
}

/// The state of one branch of the search.
#[derive(Clone)]
pub(crate) struct State {
    equations: Vec<Equation>,
    solution: Solution,
    next_unknown: u8,
    /// Expressions of the unknowns that are positive wherever there is a result.
    positive: Vec<Id>,
}

/// Upper bound on search steps and on preimages.
const MAX_STEPS: usize = 400;
const MAX_PREIMAGES: usize = 16;

/// Solves `targets[i] = outputs[i]` for the unknowns: all preimages.
pub fn solve(
    g: &mut Graph,
    outputs: &[Id],
    targets: &[Id],
    unknowns: &[Leaf],
    frames: &[[[Id; 3]; 3]],
    positive: &[Id],
) -> Result<Vec<Solution>, Stuck> {
    let equations = targets
        .iter()
        .zip(outputs)
        .map(|(&known, &rhs)| Equation { known, rhs, modulo_turn: false })
        .collect();
    let first = State {
        equations,
        solution: Solution::default(),
        next_unknown: 16,
        positive: positive.to_vec(),
    };
    let mut open = vec![first];
    let mut done = Vec::new();
    let mut steps = 0;
    while let Some(mut state) = open.pop() {
        steps += 1;
        if steps > MAX_STEPS || done.len() >= MAX_PREIMAGES {
            return Err(stuck(g, &state, unknowns));
        }
        strip_all(g, &mut state);
        // A pair must be seen before one of its members is solved through another equation.
        if let Some(next) = polar::polar_pair(g, &state) {
            open.extend(next.into_iter().rev());
            continue;
        }
        settle(g, &mut state);
        if unknowns.iter().all(|u| state.solution.unknowns.contains_key(u)) {
            finish(g, &mut state);
            done.push(state.solution);
            continue;
        }
        match step(g, &state, frames) {
            Some(next) => open.extend(next.into_iter().rev()),
            None => return Err(stuck(g, &state, unknowns)),
        }
    }
    Ok(done)
}

/// The rules in order of preference: those with a single answer and good conditioning first.
fn step(g: &mut Graph, state: &State, frames: &[[[Id; 3]; 3]]) -> Option<Vec<State>> {
    normalise::unit_vector(g, state)
        .or_else(|| peel::unique(g, state))
        .or_else(|| linear::linear_system(g, state, frames))
        .or_else(|| normalise::common(g, state))
        .or_else(|| peel::branching(g, state))
        .or_else(|| rational::single_unknown(g, state))
        .or_else(|| rational::eliminate(g, state))
}

/// Moves known parts of all equations over.
fn strip_all(g: &mut Graph, state: &mut State) {
    for i in 0..state.equations.len() {
        let eq = state.equations[i].clone();
        state.equations[i] = strip(g, &eq, &mut state.solution.known);
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
    let map = HashMap::from([(variable, value)]);
    for e in &mut state.equations {
        // An equation that only this unknown was left in is a test: keep what it says of the unknown.
        if g.deps(e.rhs) & UNKNOWNS == leaf_bit(leaf) {
            state.solution.known.entry(e.rhs).or_insert(e.known);
            sign_test(g, &mut state.solution.conditions, e);
        }
        e.rhs = g.substitute(e.rhs, &map);
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

/// Brings `known = a + b·rhs` (a, b known) to `(known - a) / b = rhs`, as often as it applies.
fn strip(g: &mut Graph, eq: &Equation, known: &mut HashMap<Id, Id>) -> Equation {
    let mut eq = eq.clone();
    loop {
        let (constant, factor, rest) = affine_parts(g, eq.rhs);
        let one = g.int(1);
        if rest == eq.rhs || !g.has(rest, UNKNOWNS) {
            return eq;
        }
        if eq.modulo_turn {
            // Shifts keep the period; a factor does not.
            if factor != one {
                return eq;
            }
        }
        if let Some(c) = constant {
            eq.known = g.sub(eq.known, c);
        }
        eq.known = g.div(eq.known, factor);
        eq.rhs = rest;
        if !eq.modulo_turn {
            known.entry(rest).or_insert(eq.known);
        }
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
        state.solution.known.entry(e.rhs).or_insert(e.known);
        state.solution.unused.push((e.known, e.rhs));
    }
    // Auxiliary unknowns are no unknowns of the caller.
    state.solution.unknowns.retain(|l, _| matches!(l, Leaf::Unknown(i) if *i < 16));
    state.solution.conditions.retain(|c| !g.range(c.0).nonnegative());
}

fn stuck(g: &Graph, state: &State, unknowns: &[Leaf]) -> Stuck {
    let open: Vec<String> = unknowns
        .iter()
        .filter(|u| !state.solution.unknowns.contains_key(u))
        .map(|u| g.name(*u).to_owned())
        .collect();
    let equation = match state.equations.first() {
        Some(e) => format!("{} = {}", show(g, e.known), show(g, e.rhs)),
        None => format!("nothing determines {}", open.join(", ")),
    };
    Stuck { equation, unknowns: open }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::Interval;
    use crate::jacobian::{Source, volume};
    use crate::rational::Q;

    struct Setup {
        g: Graph,
        u: Vec<Id>,
    }

    fn setup(n: u8) -> Setup {
        let mut g = Graph::new();
        let u = (0..n)
            .map(|i| g.leaf(Leaf::Unknown(i), &format!("u{i}"), Interval::new(0.0, 1.0)))
            .collect();
        Setup { g, u }
    }

    fn outs(g: &mut Graph, n: u8, unit: bool) -> Vec<Id> {
        let range = if unit { Interval::new(-1.0, 1.0) } else { Interval::ALL };
        (0..n).map(|i| g.leaf(Leaf::Out(i), ["x", "y", "z"][i as usize], range)).collect()
    }

    fn report(s: &mut Setup, f: &[Id], unit: bool) -> (String, String) {
        let targets = outs(&mut s.g, f.len() as u8, unit);
        let leaves: Vec<Leaf> = (0..s.u.len() as u8).map(Leaf::Unknown).collect();
        let solutions = solve(&mut s.g, f, &targets, &leaves, &[], &[]).unwrap();
        let inverse: Vec<String> = solutions
            .iter()
            .map(|x| x.unknowns.values().map(|v| show(&s.g, *v)).collect::<Vec<_>>().join("; "))
            .collect();
        let v = volume(&mut s.g, f, &leaves, Source::Free, &[]).unwrap();
        let best = *v.iter().min_by_key(|v| crate::jacobian::cost(&s.g, **v)).unwrap();
        let p = s.g.powi(best, -1);
        let p = s.g.substitute(p, &solutions[0].known);
        (inverse.join(" | "), show(&s.g, p))
    }

    fn spherical(g: &mut Graph, c: Id, v: Id) -> Vec<Id> {
        let one = g.int(1);
        let c2 = g.powi(c, 2);
        let s2 = g.sub(one, c2);
        let r = g.sqrt(s2);
        let pi = g.pi();
        let two = g.int(2);
        let tau = g.mul(two, pi);
        let phi = g.mul(tau, v);
        let cos = g.call(crate::expr::Fun::Cos, &[phi]);
        let sin = g.call(crate::expr::Fun::Sin, &[phi]);
        vec![g.mul(r, cos), g.mul(r, sin), c]
    }

    #[test]
    fn cosine_hemisphere() {
        let mut s = setup(2);
        let one = s.g.int(1);
        let q = s.g.sub(one, s.u[0]);
        let c = s.g.sqrt(q);
        let f = spherical(&mut s.g, c, s.u[1]);
        let (inverse, p) = report(&mut s, &f, true);
        assert_eq!(p, "z / π");
        assert_eq!(inverse, "x² + y²; turn(atan2(y, x)) / (2 π)");
    }

    #[test]
    fn uniform_sphere() {
        let mut s = setup(2);
        let c = s.g.sum(Q::ONE, &[(Q::int(-2), s.u[0])]);
        let f = spherical(&mut s.g, c, s.u[1]);
        let (inverse, p) = report(&mut s, &f, true);
        assert_eq!(p, "1 / (4 π)");
        assert_eq!(inverse, "1/2 - z / 2; turn(atan2(y, x)) / (2 π)");
    }

    #[test]
    fn linear_density() {
        // u(a+b)/(a+√((1-u)a²+u b²))
        let mut s = setup(1);
        let a = s.g.leaf(Leaf::Param(0), "a", Interval::POSITIVE);
        let b = s.g.leaf(Leaf::Param(1), "b", Interval::POSITIVE);
        let one = s.g.int(1);
        let q = s.g.sub(one, s.u[0]);
        let (a2, b2) = (s.g.powi(a, 2), s.g.powi(b, 2));
        let l = s.g.mul(q, a2);
        let r = s.g.mul(s.u[0], b2);
        let sum = s.g.add(l, r);
        let root = s.g.sqrt(sum);
        let bottom = s.g.add(a, root);
        let ab = s.g.add(a, b);
        let top = s.g.mul(s.u[0], ab);
        let f = s.g.div(top, bottom);
        let (inverse, p) = report(&mut s, &[f], false);
        eprintln!("{inverse}\n{p}");
        assert!(!inverse.contains('√'), "{inverse}");
    }

    #[test]
    fn triangle() {
        let mut s = setup(2);
        let r = s.g.sqrt(s.u[0]);
        let one = s.g.int(1);
        let v1 = s.g.sub(one, s.u[1]);
        let p = s.g.mul(r, v1);
        let q = s.g.mul(r, s.u[1]);
        let f: Vec<Id> = (0..3u8)
            .map(|i| {
                let mut leaf = |k: u8, n: &str| {
                    s.g.leaf(Leaf::Param(3 * k + i), &format!("{n}{i}"), Interval::ALL)
                };
                let (a, b, c) = (leaf(0, "a"), leaf(1, "b"), leaf(2, "c"));
                let e1 = s.g.sub(b, a);
                let e2 = s.g.sub(c, a);
                let x = s.g.mul(p, e1);
                let y = s.g.mul(q, e2);
                s.g.sum(Q::ZERO, &[(Q::ONE, a), (Q::ONE, x), (Q::ONE, y)])
            })
            .collect();
        let (_, p) = report(&mut s, &f, false);
        assert!(!p.contains('x') && !p.contains('z'), "the density is constant: {p}");
    }
}
