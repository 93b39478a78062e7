//! The map of a preimage in terms of the point: by it a point is seen to lie on the manifold of images
//! without the angles that its unknowns are.

use std::collections::BTreeMap;

use super::Problem;
use super::cases::Case;
use super::density::pick;
use crate::expr::{Graph, Id, Leaf, Node};
use crate::jacobian::{cost_together, simplify};
use crate::measure::Measure;
use crate::rational::Q;
use crate::solve::Solution;

/// 1 - x, where x is a part of a whole, a / (a + b): the rest of it, b / (a + b).
fn complement(g: &mut Graph, x: Id) -> Option<Id> {
    let Node::Product(factors) = g.node(x).clone() else { return None };
    factors.into_iter().find_map(|(whole, _)| {
        let part = g.mul(x, whole);
        let rest = g.sub(whole, part);
        (terms(g, part) + terms(g, rest) == terms(g, whole)).then(|| g.div(rest, whole))
    })
}

/// How many terms a sum has; anything else is one.
fn terms(g: &Graph, id: Id) -> usize {
    match g.node(id) {
        Node::Sum(c, terms) => terms.len() + usize::from(!c.is_zero()),
        _ => 1,
    }
}

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
    let mut values: BTreeMap<Id, Id> =
        problem.unknowns.iter().map(|leaf| (g.get_leaf(*leaf), solution.unknowns[leaf])).collect();
    // Next to its end, an unknown does not tell how far it is from one.
    for (unknown, value) in values.clone() {
        let rest = g.sum(Q::ONE, &[(Q::int(-1), unknown)]);
        values.extend(complement(g, value).map(|known| (rest, known)));
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::Interval;

    #[test]
    fn what_an_unknown_lacks_to_one() {
        let mut g = Graph::new();
        let [a, b] = [0, 1].map(|i| g.leaf(Leaf::Out(i), "x", Interval::new(0.0, 9.0)));
        let c = g.div(a, b);
        let whole = g.sum(Q::ONE, &[(Q::ONE, c)]);
        let x = g.div(c, whole);
        let rest = g.powi(whole, -1);
        assert_eq!(complement(&mut g, x), Some(rest));
        let other = g.div(a, whole);
        assert_eq!(complement(&mut g, other), None);
        assert_eq!(complement(&mut g, a), None);
        // A part of a whole of several terms.
        let d = g.leaf(Leaf::Out(2), "z", Interval::new(0.0, 9.0));
        let part = g.add(a, b);
        let whole = g.add(part, d);
        let (x, rest) = (g.div(part, whole), g.div(d, whole));
        assert_eq!(complement(&mut g, x), Some(rest));
    }
}
