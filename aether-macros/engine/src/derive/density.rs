//! The density and the volume in the form that is measured to be best.

use std::collections::BTreeMap;

use super::cases::Case;
use super::{Preimage, Problem};
use crate::derivative::derivative;
use crate::expr::{Fun, Graph, Id, Leaf, Node, children};
use crate::jacobian::{cost, simplify};
use crate::solve::Solution;
use crate::stabilise::{Inputs, stabilise, truths, worst_error};

/// The cheapest among the most accurate expressions.
fn pick(g: &mut Graph, candidates: &[Id], truth: &[f64], points: &[Inputs]) -> (Id, f64) {
    let scored: Vec<(Id, f64, usize)> =
        candidates.iter().map(|&c| (c, worst_error(g, c, truth, points), cost(g, c))).collect();
    let least = scored.iter().map(|s| s.1).fold(f64::INFINITY, f64::min).max(16.0 * f64::EPSILON);
    scored
        .iter()
        .filter(|s| s.1 <= 4.0 * least)
        .min_by_key(|s| s.2)
        .or(scored.first())
        .map_or((candidates[0], f64::INFINITY), |s| (s.0, s.1))
}

pub(super) fn pick_volume(problem: &mut Problem, volumes: &[Id], points: &[Inputs]) -> Id {
    let g = &mut problem.graph;
    let truth = truths(g, volumes[0], points);
    let stable: Vec<Id> = volumes.iter().map(|&v| stabilise(g, v, points)).collect();
    let mut all = stable;
    all.extend(volumes);
    pick(g, &all, &truth, points).0
}

/// Whether the coordinate itself is a divisor: x^k / x is 0/0 at zero, where x^(k - 1) has a value.
fn divides_by_the_point(g: &Graph, id: Id) -> bool {
    let divisor = |&(b, e): &(Id, Id)| {
        let inner = match g.node(b) {
            Node::Call(Fun::Abs, a) => a[0],
            _ => b,
        };
        matches!(g.node(inner), Node::Leaf(Leaf::Out(_)))
            && g.as_number(e).is_some_and(|q| q.is_negative())
    };
    match g.node(id) {
        Node::Product(f) if f.iter().any(divisor) => true,
        node => children(node).into_iter().any(|c| divides_by_the_point(g, c)),
    }
}

/// The density in terms of the outputs, in its most accurate form, and its worst error.
pub(super) fn density(
    problem: &mut Problem,
    s: &Solution,
    volumes: &[Id],
    cases: &[Case],
    points: &[Inputs],
    injective: bool,
) -> (Id, f64) {
    let g = &mut problem.graph;
    let only: BTreeMap<Id, Id> = s.unknowns.iter().map(|(l, v)| (g.get_leaf(*l), *v)).collect();
    let mut candidates = Vec::new();
    for &v in volumes {
        let p = g.powi(v, -1);
        for map in [&s.known, &only] {
            let mut direct = g.substitute(p, map);
            // What one substitution uncovers another may know.
            direct = g.substitute(direct, &only);
            candidates.push(direct);
            candidates.push(simplify(g, direct, None));
        }
    }
    candidates.sort_by_key(|c| cost(g, *c));
    candidates.dedup();
    // Among several preimages this one's share is known only where it is the one that was sampled.
    let truth: Vec<f64> = if injective {
        cases.iter().map(|c| if c.volume > 0.0 { 1.0 / c.volume } else { f64::NAN }).collect()
    } else {
        truths(g, candidates[0], points)
    };
    let mut all = candidates.clone();
    if pick(g, &candidates, &truth, points).1 > 64.0 * f64::EPSILON {
        for &c in candidates.iter().take(3) {
            all.push(stabilise(g, c, points));
        }
        if let ([unknown], 1) = (&problem.unknowns[..], problem.outputs.len()) {
            // On a line the derivative of the inverse itself is one more form.
            let slope = derivative(g, s.unknowns[unknown], Leaf::Out(0));
            let slope = g.call(Fun::Abs, &[slope]);
            let forms = [slope, simplify(g, slope, None)];
            all.extend(forms.into_iter().filter(|&f| !divides_by_the_point(g, f)));
        }
    }
    pick(g, &all, &truth, points)
}

pub(super) fn finish(
    problem: &mut Problem,
    s: &Solution,
    density: Id,
    points: &[Inputs],
    check_forward: bool,
) -> Preimage {
    let g = &mut problem.graph;
    let values: Vec<Id> =
        problem.unknowns.iter().map(|l| stabilise(g, s.unknowns[l], points)).collect();
    let map: BTreeMap<Id, Id> =
        problem.unknowns.iter().zip(&values).map(|(l, v)| (g.get_leaf(*l), *v)).collect();
    let requirements = problem
        .requirements
        .iter()
        .map(|&r| {
            let known = g.substitute(r, &s.known);
            g.substitute(known, &map)
        })
        .collect();
    Preimage {
        unknowns: values,
        // Mapping forward again is a test that contains all others.
        conditions: if check_forward { vec![] } else { s.conditions.iter().map(|c| c.0).collect() },
        requirements,
        density,
    }
}
