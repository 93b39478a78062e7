//! The map of a preimage in terms of the point: by it a point is seen to lie on the manifold of images
//! without the angles that its unknowns are.

use std::collections::BTreeMap;

use super::Problem;
use super::cases::Case;
use super::density::pick;
use crate::expr::{Id, Leaf};
use crate::jacobian::{cost_together, simplify};
use crate::measure::Measure;
use crate::solve::Solution;

/// Each coordinate of the image of the unknowns that a point has; `None` where that costs as much as to compute
/// the unknowns and to map them.
pub(super) fn back(
    problem: &mut Problem,
    (forward, unknowns): (&[Id], &[Id]),
    solution: &Solution,
    cases: &[Case],
    measure: &mut Measure,
) -> Option<Vec<Id>> {
    let g = &mut problem.graph;
    let values: BTreeMap<Id, Id> =
        problem.unknowns.iter().map(|leaf| (g.get_leaf(*leaf), solution.unknowns[leaf])).collect();
    let mut images = Vec::new();
    for (i, (&written, &stable)) in problem.outputs.iter().zip(forward).enumerate() {
        let truth: Vec<f64> = cases.iter().map(|c| c.outs[i]).collect();
        let mut forms = Vec::new();
        for form in [written, stable] {
            let image = g.substitute(form, &values);
            let image = solution.spell_out(g, image);
            forms.extend([image, simplify(g, image, None)]);
        }
        forms.sort_unstable();
        forms.dedup();
        images.push(pick(g, &forms, &truth, measure).0);
    }
    let trivial = |(i, id): (usize, &Id)| *id == g.get_leaf(Leaf::Out(i as u8));
    let identity = images.iter().enumerate().all(trivial);
    let otherwise: Vec<Id> = forward.iter().chain(unknowns).copied().collect();
    let shorter = cost_together(g, &images) < cost_together(g, &otherwise);
    (!identity && shorter).then_some(images)
}
