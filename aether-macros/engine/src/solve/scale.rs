//! Linear systems that are known up to a common scale: λ X = M a, with the atoms a and λ unknown.

use super::linear::{self, Row};
use super::{Equation, Solution, State};
use crate::display::show;
use crate::expr::{Graph, Id, Leaf, Node, UNKNOWNS};
use crate::interval::Interval;
use crate::jacobian::cost;
use crate::matrix::{dot, solve_matrix};
use crate::rational::Q;

/// Outputs from this number on are names for long expressions.
const FIRST_NAME: u8 = 16;

/// Solves a homogeneous system with one unknown too many, if that is a scale λ: every atom is λ
/// times a known number. With the unit length of a map's argument that settles λ; else the atoms
/// over λ are known, which leaves a system without the matrix.
pub(super) fn up_to_scale(
    g: &mut Graph,
    state: &State,
    frames: &[[[Id; 3]; 3]],
) -> Option<Vec<State>> {
    let rows: Vec<Option<Row>> = state
        .equations
        .iter()
        .map(|e| if e.modulo_turn { None } else { linear::row(g, e.rhs, false) })
        .collect();
    let zero = g.int(0);
    for start in 0..rows.len() {
        let Some((members, mut atoms)) = linear::component(&rows, start) else { continue };
        let homogeneous = members.iter().all(|&i| state.equations[i].known == zero);
        let scale = atoms.iter().position(|a| is_scale(g, *a));
        let Some(scale) = scale.filter(|_| homogeneous && atoms.len() == members.len() + 1) else {
            continue;
        };
        let lambda = atoms.remove(scale);
        let entry = |g: &mut Graph, i: usize, atom: Id| {
            linear::coefficient(g, rows[i].as_deref().unwrap_or(&[]), atom)
        };
        let mut matrix = Vec::new();
        let mut known = Vec::new();
        for &i in &members {
            matrix.push(atoms.iter().map(|a| entry(g, i, *a)).collect::<Vec<_>>());
            let k = entry(g, i, lambda);
            known.push(g.neg(k));
        }
        let Some((values, _)) = solve_matrix(g, &matrix, &known, frames) else { continue };
        if let Some(next) = replace(g, state, &members, lambda, &atoms, &values) {
            return Some(next);
        }
    }
    None
}

/// Whether an atom is an unknown that the solver introduced.
fn is_scale(g: &Graph, atom: Id) -> bool {
    matches!(g.node(atom), Node::Leaf(Leaf::Unknown(i)) if *i >= 16)
}

fn replace(
    g: &mut Graph,
    state: &State,
    members: &[usize],
    lambda: Id,
    atoms: &[Id],
    values: &[Id],
) -> Option<Vec<State>> {
    let positive = g.range(lambda).nonnegative();
    let mut s = state.clone();
    let mut k = 0;
    s.equations.retain(|_| {
        k += 1;
        !members.contains(&(k - 1))
    });
    let values: Vec<Id> = values.iter().map(|&v| named(g, &mut s, v)).collect();
    let values = &values[..];
    let length = s.equations.iter().position(|e| is_length(g, e, atoms));
    let equation = |s: &mut State, known: Id, rhs: Id| {
        s.solution.known.entry(rhs).or_insert(known);
        s.equations.push(Equation { known, rhs, modulo_turn: false });
    };
    if let Some(length) = length {
        s.equations.remove(length);
        let squared = dot(g, values, values);
        let minus_half = g.number(Q::HALF.neg());
        let scale = g.pow(squared, minus_half);
        let negative = g.neg(scale);
        let scales = if positive { vec![scale] } else { vec![scale, negative] };
        let solved = scales.into_iter().map(|scale| {
            let mut s = s.clone();
            equation(&mut s, scale, lambda);
            for (&atom, &value) in atoms.iter().zip(values) {
                let value = g.mul(value, scale);
                equation(&mut s, value, atom);
            }
            s.solution.steps.push(format!("unit vector: {} = {}", show(g, lambda), show(g, scale)));
            s
        });
        return Some(solved.collect());
    }
    if !positive {
        return None;
    }
    let leaf = Leaf::Unknown(s.next_unknown);
    s.next_unknown += 1;
    let positive = g.range(lambda).nonnegative();
    let inverse = g.leaf(leaf, "μ", if positive { Interval::POSITIVE } else { Interval::ALL });
    for (&atom, &value) in atoms.iter().zip(values) {
        let scaled = g.mul(atom, inverse);
        equation(&mut s, value, scaled);
        s.solution.steps.push(format!("up to scale: {} = {}", show(g, scaled), show(g, value)));
    }
    let reciprocal = g.powi(inverse, -1);
    for e in &mut s.equations {
        e.rhs = g.substitute(e.rhs, &[(lambda, reciprocal)].into());
    }
    s.solution.known.insert(lambda, reciprocal);
    Some(vec![s])
}

/// A short name for a long value, so that what follows stays as short as without the matrix.
pub(super) fn named(g: &mut Graph, s: &mut State, value: Id) -> Id {
    if cost(g, value) < 12 {
        return value;
    }
    next_name(g, &mut s.solution, value).unwrap_or(value)
}

/// The next name, for a value; `None` if none is left.
pub(super) fn next_name(g: &mut Graph, solution: &mut Solution, value: Id) -> Option<Id> {
    const NAMES: [&str; 8] = ["a", "b", "c", "d", "e", "f", "g", "h"];
    let k = solution.names.len();
    let letter = NAMES.get(k)?;
    let range = g.range(value);
    let name = g.leaf(Leaf::Out(FIRST_NAME + k as u8), letter, range);
    solution.steps.push(format!("{letter} = {}", show(g, value)));
    solution.names.insert(name, value);
    Some(name)
}

/// Whether an equation says that the squares of exactly these atoms add up to one.
fn is_length(g: &mut Graph, e: &Equation, atoms: &[Id]) -> bool {
    let one = g.int(1);
    let squares: Vec<(Q, Id)> = atoms.iter().map(|&a| (Q::ONE, g.powi(a, 2))).collect();
    e.known == one && atoms.iter().all(|a| g.has(*a, UNKNOWNS)) && e.rhs == g.plain_sum(&squares)
}
