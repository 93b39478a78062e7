//! What need not be asked of a point, because ranges tell it.

use super::signs::find_signs;
use super::{Preimage, Problem, holding};
use crate::expr::{Id, OUTS};
use crate::interval::Interval;
use crate::solve::Solution;

/// Finds out what need not be asked of a point, where nothing but the ends of unknowns limits a sampler's piece.
pub(super) fn shorten_tests(problem: &mut Problem, preimage: &mut Preimage) {
    if problem.argument.is_some() || !problem.guards.is_empty() {
        return;
    }
    let g = &mut problem.graph;
    // An unknown that is in its range whatever the point is needs no test: its border is one if no point lies beyond.
    for (border, &tested) in preimage.borders.iter_mut().zip(&preimage.tested) {
        border.take_if(|border| g.range(tested).within_one() && !border.contains_all(g));
    }
    // What depends on coordinates between their borders alone holds there.
    let told = preimage.borders.iter().flatten();
    let told = told.fold(0, |told, border| told | g.deps(border.coordinate));
    let open = |c: &Id| told == 0 || g.deps(*c) & OUTS == 0 || g.has(*c, OUTS & !told);
    preimage.open.retain(open);
    let sides = preimage.tested.iter().zip(&preimage.borders).map(|(&u, border)| {
        let (range, open) = (g.range(u), border.is_none());
        (u, [open && !range.nonnegative(), open && !range.at_most_one()])
    });
    let sides: Vec<(Id, [bool; 2])> = sides.collect();
    (preimage.signs, preimage.asked) = find_signs(g, &sides, &preimage.open);
}

/// Makes known which ranges unknowns have, as because a coordinate is no longer than its point, whatever form they are
/// emitted in.
pub(super) fn keep_ranges(problem: &mut Problem, s: &Solution, unknowns: &[Id]) {
    let g = &mut problem.graph;
    for (leaf, &value) in problem.unknowns.iter().zip(unknowns) {
        let Some(&found) = s.unknowns.get(leaf) else { continue };
        let (range, known) = (g.range(found), g.range(value));
        if range.intersection(known) != known {
            g.assume(value, range);
        }
    }
}

/// Makes known which unknowns lie in [0, 1] whatever the direction is.
pub(super) fn always_inside(problem: &mut Problem, forward: &[Id], unknowns: &[Id]) {
    if !problem.is_direction() || problem.argument.is_some() {
        return;
    }
    let g = &mut problem.graph;
    for (leaf, &value) in problem.unknowns.iter().zip(unknowns) {
        if holding::from_pole_to_pole(g, &problem.outputs, forward, *leaf) {
            g.assume(value, Interval::new(0.0, 1.0));
        }
    }
}
