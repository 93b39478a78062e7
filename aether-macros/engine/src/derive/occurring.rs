//! Which of the solver's answers occur: those that lead back to the points that the map is tried at.

use super::cases::Case;
use super::{Problem, Target};
use crate::differences::evaluate;
use crate::eval::Evaluator;
use crate::expr::Leaf;
use crate::number::{Dd, Number};
use crate::solve::Solution;
use crate::sorted;

/// The values of a solution at a case, if its tests pass.
fn try_solution(problem: &Problem, s: &Solution, case: &Case) -> Option<Vec<f64>> {
    try_exactly(problem, s, case).map(|u| u.iter().map(|u| u.to_f64()).collect())
}

/// Whether a solution is the preimage that a case was made from.
pub(super) fn recovers(problem: &Problem, s: &Solution, case: &Case) -> bool {
    let near = |(a, b): (&f64, &Dd)| (a - b.to_f64()).abs() < 1e-9;
    try_solution(problem, s, case).is_some_and(|u| u.iter().zip(&case.point.unknowns).all(near))
}

/// The same in double-double.
pub(super) fn try_exactly(problem: &Problem, s: &Solution, case: &Case) -> Option<Vec<Dd>> {
    try_all(problem, &[s], case).pop().flatten()
}

/// The same for several solutions, what they have in common computed once.
pub(super) fn try_all(
    problem: &Problem,
    solutions: &[&Solution],
    case: &Case,
) -> Vec<Option<Vec<Dd>>> {
    let at = |l: Leaf| match l {
        Leaf::Out(i) => case.exact_outs[i as usize],
        // An answer in terms of the question is none.
        Leaf::Unknown(_) => Dd::from_f64(f64::NAN),
        _ => case.point.input(l, &[]),
    };
    let mut e = Evaluator::<Dd>::new(&problem.graph, &at);
    solutions.iter().map(|s| tried(problem, s, case, &mut e)).collect()
}

/// The values of a solution, if its tests pass, where `e` evaluates at the point of a case.
pub(super) fn tried(
    problem: &Problem,
    s: &Solution,
    case: &Case,
    e: &mut Evaluator<Dd>,
) -> Option<Vec<Dd>> {
    let u: Vec<Dd> = problem
        .unknowns
        .iter()
        .map(|l| s.unknowns.get(l).map_or(Dd::from_f64(f64::NAN), |v| e.value(*v)))
        .collect();
    let inside = problem.argument.is_some()
        || u.iter().all(|u| u.is_finite() && u.to_f64() > -1e-12 && u.to_f64() < 1.0 + 1e-12);
    let conditions = s.conditions.iter().all(|c| e.value(c.0).to_f64() >= -1e-20)
        && s.pieces.iter().flat_map(|p| &p.widths).all(|w| e.value(*w).to_f64() > 0.0);
    let at = |l: Leaf| match l {
        Leaf::Unknown(i) => u.get(i as usize).copied().unwrap_or(Dd::from_f64(f64::NAN)),
        _ => case.point.input(l, &[]),
    };
    let mut e = Evaluator::<Dd>::new(&problem.graph, &at);
    let required = problem.requirements.iter().all(|r| e.value(*r).to_f64() > 0.0)
        && problem.guards.iter().all(|t| e.value(t.difference).to_f64() >= -1e-20);
    (inside && conditions && required).then_some(u)
}

/// Keeps the solutions that occur, in a form without duplicates; every point must be recovered.
pub(super) fn prune(
    problem: &Problem,
    solutions: Vec<Solution>,
    cases: &[Case],
) -> Result<(Vec<Solution>, bool), String> {
    let all: Vec<&Solution> = solutions.iter().collect();
    let mut table: Vec<Vec<Option<Vec<f64>>>> = vec![vec![]; all.len()];
    for case in cases {
        for (row, u) in table.iter_mut().zip(try_all(problem, &all, case)) {
            row.push(u.map(|u| u.iter().map(|u| u.to_f64()).collect()));
        }
    }
    let mut check_forward = problem.parts.iter().any(|p| p.target == Target::Embedded);
    let mut kept = needed(problem, &table, cases);
    with_their_pieces(&solutions, &mut kept);
    for (i, case) in cases.iter().enumerate().filter(|(_, c)| !c.point.stress) {
        let mut found = false;
        for &k in &kept {
            let Some(u) = &table[k][i] else { continue };
            found |= u.iter().zip(&case.point.shown()).all(|(a, b)| (a - b).abs() <= 1e-9);
            check_forward |= !maps_back(problem, u, case);
        }
        if !found && !flat(problem, case) {
            return Err(format!(
                "the derived inverse does not recover its own input: u = {:?} with parameters {:?} maps to {:?}, which maps back to {:?}. If this point lies outside what the map is meant for, declare the domain of the parameters",
                case.point.shown(),
                case.point.params.iter().map(|p| p.to_f64()).collect::<Vec<_>>(),
                case.outs,
                kept.iter().filter_map(|&k| table[k][i].take()).collect::<Vec<_>>()
            ));
        }
    }
    let needed: Vec<&Solution> = kept.iter().map(|&k| &solutions[k]).collect();
    check_forward |= super::strays::accepted(problem, &needed, cases);
    let mut index = 0;
    let mut solutions = solutions;
    solutions.retain(|_| {
        index += 1;
        kept.contains(&(index - 1))
    });
    Ok((solutions, check_forward))
}

/// Whether the map is so flat at an extreme point that its image in `f64` does not determine the
/// unknowns to the accuracy asked for: at the border of a power, or where it folds.
fn flat(problem: &Problem, case: &Case) -> bool {
    const STEP: f64 = 1e-9;
    problem.argument.is_none()
        && (0..case.point.unknowns.len()).any(|i| {
            let mut u = case.point.unknowns.clone();
            let inwards = if u[i].to_f64() < 0.6 { STEP } else { -STEP };
            u[i] = u[i] + Dd::from_f64(inwards);
            let moved = evaluate(problem, &case.point, &u);
            moved
                .iter()
                .zip(&case.outs)
                .all(|(y, x)| (y.to_f64() - x).abs() <= 4.0 * f64::EPSILON * (x.abs().max(STEP)))
        })
}

/// The solutions without which some preimage would be missing. A root of a squared equation may lie
/// in the cube everywhere and lead back nowhere, or only where it meets another.
fn needed(problem: &Problem, table: &[Vec<Option<Vec<f64>>>], cases: &[Case]) -> Vec<usize> {
    let near = |a: &[f64], b: &[f64], tolerance: f64| {
        a.iter().zip(b).all(|(x, y)| (x - y).abs() <= tolerance * (1.0 + x.abs()))
    };
    let leads_back: Vec<Vec<bool>> = table
        .iter()
        .map(|row| {
            let tried = row.iter().zip(cases);
            tried
                .map(|(u, case)| {
                    u.as_ref().is_some_and(|u| {
                        let own = near(u, &case.point.shown(), 1e-9);
                        own || case.point.interior && maps_back(problem, u, case)
                    })
                })
                .collect()
        })
        .collect();
    let mut kept: Vec<usize> =
        (0..table.len()).filter(|&k| leads_back[k].contains(&true)).collect();
    for k in (0..table.len()).rev() {
        let covered = |i: usize| {
            let Some(u) = &table[k][i] else { return true };
            kept.iter().any(|&j| {
                let same = |v: &Vec<f64>| near(v, u, 1e-12);
                j != k && leads_back[j][i] && table[j][i].as_ref().is_some_and(same)
            })
        };
        if kept.contains(&k) && (0..cases.len()).all(|i| !leads_back[k][i] || covered(i)) {
            kept.retain(|j| *j != k);
        }
    }
    kept
}

/// Adds to the solutions that occur those that differ from one of them in the piece of a root alone: none of the points may
/// have hit a narrow piece.
fn with_their_pieces(solutions: &[Solution], kept: &mut Vec<usize>) {
    let alike = |a: &Solution, b: &Solution| !a.pieces.is_empty() && a.answers == b.answers;
    let occurs = |s: &Solution| kept.iter().any(|&k| alike(s, &solutions[k]));
    let more: Vec<usize> =
        (0..solutions.len()).filter(|k| !kept.contains(k) && occurs(&solutions[*k])).collect();
    kept.extend(more);
    sorted::sort(kept);
}

fn maps_back(problem: &Problem, u: &[f64], case: &Case) -> bool {
    if !case.point.interior {
        return true;
    }
    let u: Vec<Dd> = u.iter().map(|u| Dd::from_f64(*u)).collect();
    let image = evaluate(problem, &case.point, &u);
    image.iter().zip(&case.outs).all(|(y, x)| (y.to_f64() - x).abs() <= 1e-6 * (1.0 + x.abs()))
}
