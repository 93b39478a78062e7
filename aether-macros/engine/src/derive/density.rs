//! The density and the volume in the form that is measured to be best.

use std::collections::BTreeMap;

use super::cases::Case;
use super::regimes::{best_coordinates, best_forms};
use super::{Preimage, Problem};
use crate::derivative::derivative;
use crate::expr::{Fun, Graph, Id, Leaf, Node, UNKNOWNS, children};
use crate::jacobian::{cost, simplify};
use crate::measure::{Loss, Measure};
use crate::overflow::guard;
use crate::solve::Solution;
use crate::stabilise::stabilise;

/// The cheapest among the most accurate expressions.
fn pick(g: &mut Graph, candidates: &[Id], truth: &[f64], measure: &mut Measure) -> (Id, f64) {
    let scored: Vec<(Id, Loss, usize)> =
        candidates.iter().map(|&c| (c, measure.loss(g, c, truth), cost(g, c))).collect();
    let least =
        |f: &dyn Fn(&Loss) -> f64| scored.iter().map(|s| f(&s.1)).fold(f64::INFINITY, f64::min);
    let (bits, worst) = (least(&|l| l.bits), least(&|l| l.worst).max(16.0 * f64::EPSILON));
    scored
        .iter()
        .filter(|s| s.1.bits <= bits + 1.0 && s.1.worst <= 4.0 * worst)
        .min_by_key(|s| s.2)
        .or(scored.first())
        .map_or((candidates[0], f64::INFINITY), |s| (s.0, s.1.worst))
}

pub(super) fn pick_volume(problem: &mut Problem, volumes: &[Id], measure: &mut Measure) -> Id {
    let g = &mut problem.graph;
    let truth = measure.truths(g, volumes[0]);
    let stable: Vec<Id> = volumes.iter().map(|&v| stabilise(g, v, measure)).collect();
    let mut all = stable;
    all.extend(volumes);
    let best = pick(g, &all, &truth, measure).0;
    guard(g, best)
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
    measure: &mut Measure,
    injective: bool,
) -> (Id, f64) {
    let direction = problem.is_direction() && problem.argument.is_none();
    let g = &mut problem.graph;
    let only: BTreeMap<Id, Id> = s.short.iter().map(|(l, v)| (g.get_leaf(*l), *v)).collect();
    let mut candidates = Vec::new();
    for &v in volumes {
        let p = g.powi(v, -1);
        for map in [&s.known, &only] {
            let mut direct = g.substitute(p, map);
            // What one substitution uncovers another may know.
            direct = g.substitute(direct, &only);
            let tidy = simplify(g, direct, None);
            candidates.push(s.spell_out(g, direct));
            candidates.push(s.spell_out(g, tidy));
        }
    }
    if let Some(&first) = candidates.first() {
        candidates.extend(through_its_square(g, first));
    }
    // What is known of a part may be in terms of auxiliary unknowns that were never settled.
    candidates.retain(|&c| !g.has(c, UNKNOWNS));
    candidates.sort_by_key(|c| cost(g, *c));
    candidates.dedup();
    // Among several preimages this one's share is known only where it is the one that was sampled.
    let truth: Vec<f64> = if injective {
        cases.iter().map(|c| if c.volume > 0.0 { 1.0 / c.volume } else { f64::NAN }).collect()
    } else {
        measure.truths(g, candidates[0])
    };
    let mut all = candidates.clone();
    if pick(g, &candidates, &truth, measure).1 > 64.0 * f64::EPSILON {
        crate::poly::refill_budget(8);
        for &c in candidates.iter().take(3) {
            all.push(stabilise(g, c, measure));
        }
        if let ([unknown], 1) = (&problem.unknowns[..], problem.outputs.len()) {
            // On a line the derivative of the inverse itself is one more form.
            let slope = derivative(g, s.unknowns[unknown], Leaf::Out(0));
            let slope = g.call(Fun::Abs, &[slope]);
            let forms = [slope, simplify(g, slope, None)];
            all.extend(forms.into_iter().filter(|&f| !divides_by_the_point(g, f)));
        }
    }
    let (mut best, mut error) = pick(g, &all, &truth, measure);
    if direction && injective && error > 64.0 * f64::EPSILON {
        best = best_forms(g, best, &truth, measure);
        error = measure.loss(g, best, &truth).worst;
    }
    (guard(g, best), error)
}

/// √(p²), where the square is free of roots that the expression has: products of several roots
/// simplify only together.
fn through_its_square(g: &mut Graph, p: Id) -> Option<Id> {
    let squared = g.powi(p, 2);
    let tidy = simplify(g, squared, None);
    (cost(g, tidy) < cost(g, squared)).then(|| g.sqrt(tidy))
}

pub(super) fn finish(
    problem: &mut Problem,
    s: &Solution,
    density: Id,
    cases: &[Case],
    measure: &mut Measure,
    (injective, check_forward): (bool, bool),
) -> Preimage {
    let g = &mut problem.graph;
    let stable: Vec<Id> =
        problem.unknowns.iter().map(|l| stabilise(g, s.unknowns[l], measure)).collect();
    let tested: Vec<Id> = stable.iter().map(|&value| guard(g, value)).collect();
    let map: BTreeMap<Id, Id> =
        problem.unknowns.iter().zip(&tested).map(|(l, v)| (g.get_leaf(*l), *v)).collect();
    let requirements = problem
        .requirements
        .iter()
        .map(|&r| {
            let known = g.substitute(r, &s.known);
            let known = s.spell_out(g, known);
            let known = g.substitute(known, &map);
            if g.has(known, UNKNOWNS) { g.substitute(r, &map) } else { known }
        })
        .collect();
    let mut unknowns = tested.clone();
    if problem.is_direction() && problem.argument.is_none() && injective {
        for (i, value) in unknowns.iter_mut().enumerate() {
            let best = best_coordinates(problem, i, stable[i], cases, measure);
            *value = guard(&mut problem.graph, best);
        }
    }
    Preimage {
        unknowns,
        tested,
        // Mapping forward again is a test that contains all others.
        conditions: if check_forward { vec![] } else { s.conditions.iter().map(|c| c.0).collect() },
        requirements,
        density,
    }
}
