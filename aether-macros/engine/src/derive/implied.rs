//! What the unknowns of any point imply of the map's parts: known of points beside the images too, where each
//! equation that was not needed to find the unknowns is wrong.

use std::collections::BTreeMap;

use super::cases::Case;
use super::{Problem, Target};
use crate::eval::Evaluator;
use crate::expr::{Id, Leaf, Node};
use crate::number::{Dd, Number};
use crate::points::Rng;
use crate::solve::Solution;
use crate::sorted;

/// How far beside an image points lie, relative to their coordinates.
const BESIDE: [f64; 3] = [0.1, 1e-4, 1e-8];
/// How far values may differ that are the same, relative to them: there are 31 digits, but for what cancels.
const SAME: f64 = 1e-14;
/// How often a coordinate has the other sign.
const FLIPPED: f64 = 0.125;
/// At how many points something must have been seen to hold.
const FEWEST: usize = 8;

/// Parts of the map with their values in terms of the point, as they follow from the unknowns where the conditions of
/// a solution hold; not the unknowns themselves.
pub(super) fn implied(
    problem: &mut Problem,
    solution: &Solution,
    cases: &[Case],
) -> BTreeMap<Id, Id> {
    // No direction lies beside the sphere. There the image tells which preimages rounding has made up, and has to be that
    // of the unknowns as they are.
    if problem.parts.iter().any(|part| part.target == Target::Direction) {
        return BTreeMap::new();
    }
    let g = &mut problem.graph;
    let spelled_out =
        |leaf: &Leaf| (g.get_leaf(*leaf), solution.spell_out(g, solution.unknowns[leaf]));
    let values = sorted::map(problem.unknowns.iter().map(spelled_out));
    let is_composed = |(part, _): &(&Id, &Id)| !matches!(g.node(**part), Node::Leaf(_));
    let parts: Vec<(Id, Id)> =
        solution.known.iter().filter(is_composed).map(|(part, value)| (*part, *value)).collect();
    let mut claims: Vec<Claim> = Vec::new();
    for (part, value) in parts {
        let image = g.substitute(part, &values);
        let sides = [image, value].map(|id| solution.spell_out(g, id));
        claims.push(Claim { part, value, sides, held: 0, failed: false });
    }
    let conditions: Vec<Id> =
        solution.conditions.iter().map(|c| solution.spell_out(g, c.0)).collect();
    for case in beside(cases) {
        let at = |leaf| case.point.input(leaf, &case.exact_outs);
        let mut e = Evaluator::<Dd>::new(&problem.graph, &at);
        let is_inside = values.values().all(|u| (0.0..1.0).contains(&e.value(*u).to_f64()));
        if !is_inside || !conditions.iter().all(|c| e.value(*c).to_f64() >= 0.0) {
            continue;
        }
        for claim in &mut claims {
            let holds = same(claim.sides.map(|side| e.value(side)));
            claim.held += usize::from(holds);
            claim.failed |= !holds;
        }
    }
    let holding = claims.into_iter().filter(|claim| !claim.failed && claim.held >= FEWEST);
    sorted::map(holding.map(|claim| (claim.part, claim.value)))
}

/// A part of the map with the value that a solution has for it.
struct Claim {
    part: Id,
    value: Id,
    /// The part by way of the unknowns, and the value.
    sides: [Id; 2],
    /// At how many points both are the same.
    held: usize,
    /// Whether they differ at some point.
    failed: bool,
}

/// Whether two values are the same; that there is none is one, too.
fn same([one, other]: [Dd; 2]) -> bool {
    let ([a, b], off) = ([one, other].map(|v| v.to_f64()), (one - other).abs().to_f64());
    (a.is_nan() && b.is_nan()) || a == b || off <= SAME * a.abs().max(b.abs())
}

/// Points of the space beside images, and what some of these are with other signs.
fn beside(cases: &[Case]) -> Vec<Case> {
    let mut rng = Rng::new(0xbe51de);
    let tried = cases.iter().filter(|c| c.point.interior && !c.point.stress);
    tried
        .flat_map(|case| BESIDE.map(|far| (case, far)))
        .map(|(case, far)| {
            let mut off = |x: &Dd| {
                let sign = if rng.uniform() < FLIPPED { -1.0 } else { 1.0 };
                *x * Dd::from_f64(sign * (1.0 + far * (2.0 * rng.uniform() - 1.0)))
            };
            case.moved_to(case.exact_outs.iter().map(&mut off).collect())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_value_is_the_same_as_no_value_only() {
        let [nan, one] = [f64::NAN, 1.0].map(Dd::from_f64);
        let next = one + Dd::from_f64(1e-15);
        assert!(same([nan, nan]) && same([one, next]));
        assert!(!same([nan, one]) && !same([one, nan]) && !same([one, -one]));
    }
}
