//! Equations that are rational in one unknown or in one root of it.

mod polynomial;
mod radicals;

use std::collections::BTreeMap;

use super::scale::named;
use super::{Condition, Equation, State};
use crate::derivative::derivative;
use crate::display::show;
use crate::expr::{Deps, Fun, Graph, Id, Leaf, Node, UNKNOWNS, children, leaf_bit};
use crate::interval::Interval;
use crate::jacobian::cost;
use crate::overflow::SAFE;
use crate::poly::{Expander, within_part_of_budget};
use crate::sorted;
pub(super) use polynomial::name_coefficients;
pub(super) use radicals::clear;
use radicals::{isolatable, mentions_root, roots_in, squared};

/// Solves an equation with a single unknown that occurs several times, if it is rational of degree
/// one or two in some subexpression.
pub(super) fn single_unknown(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    // Of several equations for one unknown, the one whose known side takes the least computing: it
    // has lost the least to rounding.
    let mut order: Vec<usize> = (0..state.equations.len()).collect();
    sorted::sort_by_key(&mut order, |&i| cost(g, state.equations[i].known));
    for i in order {
        let eq = state.equations[i].clone();
        let deps = g.deps(eq.rhs) & UNKNOWNS;
        if deps.count_ones() != 1 || eq.modulo_turn {
            continue;
        }
        let Some((state, roots)) = answers(g, state, &eq) else { continue };
        let next = roots.into_iter().map(|Root { atom, value, also }| {
            let mut s = state.clone();
            s.equations[i] = Equation { known: value, rhs: atom, modulo_turn: false };
            s.solution.known.entry(atom).or_insert(value);
            if let Some((radical, value)) = also {
                s.solution.known.entry(radical).or_insert(value);
                if !g.range(value).nonnegative() {
                    s.solution.conditions.push(Condition(value));
                }
            }
            s.solution.steps.push(format!(
                "rational equation: {} = {}",
                show(g, atom),
                show(g, value)
            ));
            // The range of a uniform is tested anyhow.
            let uniform = matches!(g.node(atom), Node::Leaf(Leaf::Unknown(i)) if *i < 16);
            if !uniform && g.range(atom).nonnegative() && !g.range(value).nonnegative() {
                s.solution.conditions.push(Condition(value));
            }
            s
        });
        return Some(next.collect());
    }
    None
}

/// One way to satisfy an equation: atom = value, and the radical that was solved for on the way.
struct Root {
    atom: Id,
    value: Id,
    also: Option<(Id, Id)>,
}

/// How many times as much answers have to take for what is known to go by a name, which hides it from all that follows.
const MUCH_LONGER: usize = 4;

/// All ways to satisfy an equation. Where they are much shorter so, what is known goes by a name in them: a place along a side
/// in space, multiplied out, is the squares and products of all coordinates.
fn answers(g: &mut Graph, state: &State, eq: &Equation) -> Option<(State, Vec<Root>)> {
    let plain = whole_or_part(g, eq.known, eq.rhs);
    let mut with_name = state.clone();
    let name = named(g, &mut with_name, eq.known);
    if name == eq.known {
        return Some((with_name, plain?));
    }
    let by_name = whole_or_part(g, name, eq.rhs);
    let is_shorter = |by_name: &[Root]| {
        let by_name = work(g, by_name) + cost(g, eq.known);
        plain.as_ref().is_none_or(|plain| MUCH_LONGER * by_name < work(g, plain))
    };
    match by_name.filter(|by_name| is_shorter(by_name)) {
        Some(by_name) => Some((with_name, by_name)),
        None => Some((state.clone(), plain?)),
    }
}

/// All ways to satisfy known = rhs. Known sums stay together unless multiplying them out shows a
/// discriminant to be a square.
fn roots(g: &mut Graph, known: Id, rhs: Id) -> Option<Vec<Root>> {
    let together = roots_in(g, known, rhs, UNKNOWNS);
    let has_root = |g: &Graph, r: &Root| {
        matches!(g.node(r.value), Node::Product(_) | Node::Sum(..)) && mentions_root(g, r.value)
    };
    match together {
        Some(r) if !r.iter().any(|r| has_root(g, r)) => Some(r),
        other => match roots_in(g, known, rhs, Deps::MAX) {
            Some(r) if other.as_ref().is_none_or(|o| shorter(g, &r, o)) => Some(r),
            Some(r) if !r.iter().any(|r| has_root(g, r)) => Some(r),
            _ => other,
        },
    }
}

/// All ways to satisfy known = rhs, as it stands or squared.
fn solved(g: &mut Graph, known: Id, rhs: Id) -> Option<Vec<Root>> {
    roots(g, known, rhs).or_else(|| squared(g, known, rhs))
}

/// The same, or all ways for a part of `rhs` to satisfy it, where those are fewer or shorter: what is in a part that
/// comes out plainly is not squared.
fn whole_or_part(g: &mut Graph, known: Id, rhs: Id) -> Option<Vec<Root>> {
    if let Some(root) = by_slope(g, known, rhs) {
        return Some(vec![root]);
    }
    // Multiplied out, a long equation could use up what finding a part in it takes.
    let whole = within_part_of_budget(2, || solved(g, known, rhs));
    let plain = |g: &Graph, roots: &[Root]| !roots.iter().any(|r| mentions_root(g, r.value));
    match whole {
        Some(whole) if plain(g, &whole) => Some(whole),
        Some(whole) => match within_part_of_budget(2, || through_a_part(g, known, rhs)) {
            Some(part) if part.len() <= whole.len() && shorter(g, &part, &whole) => Some(part),
            _ => Some(whole),
        },
        None => through_a_part(g, known, rhs),
    }
}

/// What an equation says that is linear in its unknown and has exponentials of parameters: as it is written, since clearing
/// divisors may lead out of the range of numbers, e^-k being one.
fn by_slope(g: &mut Graph, known: Id, rhs: Id) -> Option<Root> {
    let bits = g.deps(rhs) & UNKNOWNS;
    let leaf = Leaf::Unknown(bits.trailing_zeros() as u8);
    let is_large = |g: &Graph, id: Id| match g.node(id) {
        Node::Call(Fun::Exp | Fun::ExpM1, args) => {
            let range = g.range(args[0]);
            !g.has(id, UNKNOWNS) && (range.hi > SAFE || range.lo < -SAFE)
        }
        _ => false,
    };
    if bits.count_ones() != 1 || !g.within(&[rhs]).into_iter().any(|id| is_large(g, id)) {
        return None;
    }
    let slope = derivative(g, rhs, leaf);
    if g.has(slope, UNKNOWNS) {
        return None;
    }
    let (atom, zero) = (g.get_leaf(leaf), g.int(0));
    let start = g.substitute(rhs, &BTreeMap::from([(atom, zero)]));
    let gap = g.sub(known, start);
    Some(Root { atom, value: g.div(gap, slope), also: None })
}

/// The same for the largest part of `rhs` through which alone the unknowns enter: q of q / √(1 - q²),
/// whatever q is.
fn through_a_part(g: &mut Graph, known: Id, rhs: Id) -> Option<Vec<Root>> {
    let mut parts = Vec::new();
    let mut open = children(g.node(rhs));
    while let Some(part) = open.pop() {
        let composed = matches!(g.node(part), Node::Sum(..) | Node::Product(_) | Node::Call(..));
        if composed && g.has(part, UNKNOWNS) && !parts.contains(&part) {
            parts.push(part);
            open.extend(children(g.node(part)));
        }
    }
    sorted::sort_by_key(&mut parts, |&part| std::cmp::Reverse(cost(g, part)));
    parts.into_iter().find_map(|part| {
        let (leaf, range) = match g.range(part).nonnegative() {
            true => (Leaf::Unknown(21), Interval::POSITIVE),
            false => (Leaf::Unknown(22), Interval::ALL),
        };
        let fresh = g.leaf(leaf, "q", range);
        let rest = g.substitute(rhs, &BTreeMap::from([(part, fresh)]));
        if g.deps(rest) & UNKNOWNS != leaf_bit(leaf) {
            return None;
        }
        let roots = solved(g, known, rest)?;
        let found = roots.into_iter().map(|Root { atom, value, .. }| {
            (atom == fresh).then_some(Root { atom: part, value, also: None })
        });
        found.collect()
    })
}

/// Whether the first answers take less computing than the second.
fn shorter(g: &Graph, first: &[Root], second: &[Root]) -> bool {
    work(g, first) < work(g, second)
}

/// How much computing answers take.
fn work(g: &Graph, roots: &[Root]) -> usize {
    roots.iter().map(|r| cost(g, r.value)).sum()
}

/// Isolates one unknown of an equation with several and substitutes it into the others: if there is one that is divided by a
/// number alone, that one, since anything else may be zero somewhere.
pub(super) fn eliminate(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    eliminate_by(g, state, true).or_else(|| eliminate_by(g, state, false))
}

fn eliminate_by(g: &mut Graph, state: &State, by_number: bool) -> Option<Vec<State>> {
    for i in 0..state.equations.len() {
        let eq = state.equations[i].clone();
        // What an equation gave another one holds already: doing it again leads round in circles.
        if eq.modulo_turn || state.eliminated.contains(&eq.rhs) {
            continue;
        }
        for (leaf, atom) in isolatable(g, eq.known, eq.rhs) {
            let used = state
                .equations
                .iter()
                .enumerate()
                .any(|(j, e)| j != i && !e.modulo_turn && g.has(e.rhs, leaf_bit(leaf)));
            if !used {
                continue;
            }
            let Some(polynomial) = clear(g, eq.known, eq.rhs, UNKNOWNS) else { continue };
            let Some(c) = polynomial.by_powers_of(atom) else { continue };
            let [c0, c1] = &c[..] else { continue };
            let (c0, c1) = (c0.to_expr(g), c1.to_expr(g));
            if g.has(c1, leaf_bit(leaf)) || g.has(c0, leaf_bit(leaf)) {
                continue;
            }
            if by_number && g.as_number(c1).is_none() {
                continue;
            }
            let value = g.div(c0, c1);
            let value = g.neg(value);
            let mut s = state.clone();
            let map = BTreeMap::from([(atom, value)]);
            let mut gone = true;
            for (j, e) in s.equations.iter_mut().enumerate() {
                if j != i {
                    e.rhs = g.substitute(e.rhs, &map);
                    gone &= !g.has(e.rhs, leaf_bit(leaf));
                    // Unknowns may have moved to both sides of nothing: bring the equation up to date.
                    if let Some(n) = Expander::new(g).only(UNKNOWNS).normal_form(e.rhs) {
                        e.rhs = n;
                    }
                }
            }
            if !gone {
                continue;
            }
            s.solution.steps.push(format!("elimination: {} = {}", show(g, atom), show(g, value)));
            // The eliminated equation comes last: it is solved once the others are.
            let last = s.equations.remove(i);
            s.eliminated.push(last.rhs);
            s.equations.push(last);
            return Some(vec![s]);
        }
    }
    None
}
