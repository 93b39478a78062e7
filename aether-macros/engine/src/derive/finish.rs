//! What is emitted of a preimage: its unknowns in their best forms, and what they are tested by.

use super::cases::{Case, unknown_of};
use super::holding::never_negative;
use super::opened::opened;
use super::opposed::without_length;
use super::pick::pick;
use super::regimes::best_coordinates;
use super::sums::Sums;
use super::{Preimage, Problem};
use crate::expr::{Graph, Id, Leaf, Node, UNKNOWNS};
use crate::jacobian::{cost, cost_together};
use crate::measure::Measure;
use crate::overflow::guard;
use crate::points::Kind;
use crate::rational::Q;
use crate::solve::Solution;
use crate::sorted;
use crate::stabilise::{over_sum, stabilise};

/// A preimage with a density, its unknowns and what is required of them in their best forms.
pub(super) fn finish(
    problem: &mut Problem,
    s: &Solution,
    (density, sums): (Id, &Sums),
    cases: &[Case],
    measure: &mut Measure,
    conditions: &[Id],
) -> Preimage {
    let mut stable = stable(problem, s, sums, cases, measure);
    let found: Vec<Id> = problem.unknowns.iter().map(|l| s.unknowns[l]).collect();
    let g = &mut problem.graph;
    keep_what_is_shared(g, (&found, conditions), &mut stable, (cases, measure));
    let mut tested: Vec<Id> = stable.iter().map(|&value| guard(g, value)).collect();
    let mut unknowns = tested.clone();
    for (i, value) in unknowns.iter_mut().enumerate() {
        let best = best_coordinates(problem, (i, stable[i]), &sums.units, cases, measure);
        if best != stable[i] {
            *value = guard(&mut problem.graph, best);
        }
    }
    let g = &mut problem.graph;
    for (i, value) in tested.iter_mut().enumerate() {
        if unknowns[i] != *value {
            let truth = unknown_of(cases, i);
            *value = telling(g, (*value, unknowns[i]), &truth, measure);
        }
    }
    let requirements = requirements(problem, s, &unknowns);
    let g = &mut problem.graph;
    let conditions: Vec<Id> =
        conditions.iter().copied().filter(|&c| !never_negative(g, c)).collect();
    let n = unknowns.len();
    Preimage {
        unknowns,
        tested,
        open: conditions.clone(),
        asked: conditions.clone(),
        conditions,
        requirements,
        density,
        back: None,
        borders: vec![None; n],
        signs: vec![None; n],
    }
}

/// The unknowns, each in its most accurate form.
fn stable(
    problem: &mut Problem,
    s: &Solution,
    sums: &Sums,
    cases: &[Case],
    measure: &mut Measure,
) -> Vec<Id> {
    let g = &mut problem.graph;
    let mut best_of = |(i, l): (usize, &Leaf)| {
        let best = stabilise(g, s.unknowns[l], measure);
        let mut forms = sums.put_into(g, s.unknowns[l]);
        forms.extend(opened(g, s.unknowns[l]));
        let truth = unknown_of(cases, i);
        forms.push(best);
        let without = pick(g, &forms, &truth, measure).0;
        sums.extend(g, &mut forms);
        [without, pick(g, &forms, &truth, measure).0]
    };
    let picked: Vec<[Id; 2]> = problem.unknowns.iter().enumerate().map(&mut best_of).collect();
    // What sums of unit vectors tell is free of the errors of their lengths in all unknowns, or in none: where two vectors
    // are nearly opposite, each unknown may be off along a direction of its own.
    let together = picked.iter().any(|[without, best]| without != best);
    let is_map = problem.argument == Some(Kind::Direction);
    let mut free_of_length = |[without, best]: [Id; 2]| {
        // The coordinates of a direction have its length in common as well, so that they need the same form.
        let is_to_be_freed = together && (is_map || without == best);
        let freed = is_to_be_freed.then(|| without_length(g, without, &sums.pairs)).flatten();
        freed.unwrap_or(best)
    };
    picked.into_iter().map(&mut free_of_length).collect()
}

/// What is required of the unknowns, in terms of the point.
fn requirements(problem: &mut Problem, s: &Solution, unknowns: &[Id]) -> Vec<Id> {
    let g = &mut problem.graph;
    let map = sorted::map(problem.unknowns.iter().zip(unknowns).map(|(l, v)| (g.get_leaf(*l), *v)));
    // The unknowns themselves as accurate as they can be had: a short form may say nothing of how far they are from zero.
    let composed = {
        let is_composed = |id: Id| !matches!(g.node(id), Node::Leaf(_));
        sorted::map(s.known.iter().filter(|(id, _)| is_composed(**id)).map(|(id, v)| (*id, *v)))
    };
    let in_the_point = |&r: &Id| {
        let known = g.substitute(r, &composed);
        let known = s.spell_out(g, known);
        let known = g.substitute(known, &map);
        let known = shares(g, known);
        if g.has(known, UNKNOWNS) { g.substitute(r, &map) } else { known }
    };
    let widths = s.pieces.iter().flat_map(|p| p.widths.iter().copied());
    problem.requirements.iter().map(in_the_point).chain(widths).collect()
}

/// Unknowns as they were found, where they are as accurate as in another form, and share more with each other and with
/// the conditions.
fn keep_what_is_shared(
    g: &mut Graph,
    (found, conditions): (&[Id], &[Id]),
    stable: &mut [Id],
    (cases, measure): (&[Case], &mut Measure),
) {
    let together = |g: &Graph, unknowns: &[Id]| cost_together(g, &[unknowns, conditions].concat());
    for (i, &found) in found.iter().enumerate() {
        let form = stable[i];
        if found == form {
            continue;
        }
        let truth = unknown_of(cases, i);
        let [as_found, other] = [found, form].map(|f| measure.loss(g, f, &truth));
        let alike = (0..2).all(|part| {
            let [a, b] = [as_found, other].map(|loss| loss.parts()[part]);
            a.bits <= b.bits + ALIKE && a.worst <= (1.0 + ALIKE) * b.worst
        });
        let before = together(g, stable);
        stable[i] = found;
        if !alike || together(g, stable) >= before {
            stable[i] = form;
        }
    }
}

/// How many bits more a form may lose on average, and by which part of it its worst error may be larger, that is as good as
/// another one.
const ALIKE: f64 = 0.05;

/// The short form of an unknown where it tells, in both precisions, whether that lies in [0, 1), and else the long one.
fn telling(g: &Graph, (short, long): (Id, Id), truth: &[f64], measure: &mut Measure) -> Id {
    let mut off = |form: Id| {
        let values = measure.values(g, form);
        // What is no number tells nothing.
        let near = |(v, t): &(&f64, &f64)| (*v - *t).abs() <= TELLING;
        values.len() - values.iter().zip(truth).filter(near).count()
    };
    if off(short) > off(long) { long } else { short }
}

/// How far off an unknown may be by which a point is told to lie outside: less than the slack of such tests.
const TELLING: f64 = 1.0 / 16.0;

/// A product with the differences between one and shares of a whole, a / (a + b) - 1, as shares.
fn shares(g: &mut Graph, id: Id) -> Id {
    let (coefficient, body) = g.split(id);
    let share = |g: &mut Graph, b: Id| {
        let Node::Sum(c, terms) = g.node(b).clone() else { return b };
        let form = over_sum(g, c, &terms).filter(|&form| cost(g, form) < cost(g, b));
        form.unwrap_or(b)
    };
    let factors: Vec<(Id, Id)> =
        g.factors(body).into_iter().map(|(b, e)| (share(g, b), e)).collect();
    let body = g.product(&factors);
    g.sum(Q::ZERO, &[(coefficient, body)])
}

#[cfg(test)]
mod tests {
    use crate::interpret::Item;

    #[test]
    fn what_is_required_of_an_unknown_is_tested_by_what_tells_it() {
        // Next to the pole 1 - z is zero, and x and y say how far it is.
        let text = "fn cap(u: [Uniform; 2], depth: f64) -> Direction {
            require(u[0] > 1e-18);
            let h = depth * u[0];
            let r = (h * (2.0 - h)).sqrt();
            let phi = TAU * u[1];
            Direction::new(r * phi.cos(), r * phi.sin(), 1.0 - h)
        }";
        let domain = "depth in 1e-3..=2.0".parse().unwrap();
        let item = Item::new(domain, text.parse().unwrap(), true).unwrap();
        let x = item.forward(&[1e-3], &[1e-16, 0.3]).unwrap();
        assert_eq!(x[2], 1.0);
        assert!(item.pdf(&[1e-3], &x) > 0.0);
        assert_eq!(item.pdf(&[1e-3], &[1e-12, 0.0, 1.0]), 0.0);
    }
}
