//! The density in the form that is measured to be best.

use super::by_inverse::by_the_inverse;
use super::cases::{Case, exact_values};
use super::factored::factored;
use super::occurring::recovers;
use super::one_root::by_one_root;
use super::opened::opened;
use super::pick::pick;
use super::recognised::recognised;
use super::regimes::best_forms;
use super::sums::Sums;
use super::valued::merged;
use super::{Problem, Target};
use crate::derivative::derivative;
use crate::expr::{Fun, Graph, Id, Leaf, Node, UNKNOWNS, children};
use crate::jacobian::{cost, simplify};
use crate::measure::Measure;
use crate::overflow::guard;
use crate::solve::Solution;
use crate::sorted;
use crate::stabilise::stabilise;

/// The density in terms of the outputs, in its most accurate form.
pub(super) fn density(
    problem: &mut Problem,
    s: &Solution,
    (volumes, sums): (&[Id], &Sums),
    cases: &[Case],
    measure: &mut Measure,
    injective: bool,
) -> Id {
    let candidates = candidates(problem, s, (volumes, sums), cases);
    let truth = truth(problem, s, (candidates[0], sums), cases, measure, injective);
    let (best, error) = most_accurate(problem, s, (candidates, sums), &truth, measure);
    let g = &mut problem.graph;
    let best =
        if error > ACCURATE { best_forms(g, best, &sums.units, &truth, measure) } else { best };
    guard(g, best)
}

/// The forms that follow from those of the volume without measuring any, the cheapest first.
fn candidates(
    problem: &mut Problem,
    s: &Solution,
    (volumes, sums): (&[Id], &Sums),
    cases: &[Case],
) -> Vec<Id> {
    // Most have no part that is a length, and are taken once.
    let mut forms = by_lengths(problem, volumes);
    forms.retain(|v| !volumes.contains(v));
    forms.extend(volumes);
    let g = &mut problem.graph;
    let mut candidates = of_the_point(g, s, &forms);
    if let Some(&first) = candidates.first() {
        candidates.extend(through_its_square(g, first));
    }
    // What is known of a part may be in terms of auxiliary unknowns that were never settled.
    candidates.retain(|&c| !g.has(c, UNKNOWNS));
    let open: Vec<Id> = candidates.iter().filter_map(|&form| opened(g, form)).collect();
    let tidied: Vec<Id> = open.iter().map(|&form| simplify(g, form, None)).collect();
    candidates.extend(open.into_iter().chain(tidied));
    let short = factored(g, &candidates);
    candidates.extend(short);
    candidates.extend(candidates.clone().into_iter().flat_map(|c| sums.put_into(g, c)));
    let mut targets = problem.parts.iter().map(|part| part.target);
    if targets.any(|target| matches!(target, Target::Identified | Target::Embedded)) {
        let merged = candidates.clone().into_iter().filter_map(|c| merged(g, c, cases));
        candidates.extend(merged.collect::<Vec<Id>>());
    }
    sorted::sort_by_key(&mut candidates, |c| cost(g, *c));
    candidates.dedup();
    candidates
}

/// Volumes with the parts whose sizes are lengths in terms of the point.
fn by_lengths(Problem { graph: g, lengths, .. }: &mut Problem, volumes: &[Id]) -> Vec<Id> {
    let mut by_length = |v: Id, (part, length): (Id, Id)| {
        let minus = g.neg(length);
        let [short, other] = [length, minus].map(|l| g.replace_part(v, part, l));
        // Of the part only the size is known: the sign must not matter.
        if short == other { short } else { v }
    };
    let all = |v: Id| lengths.iter().fold(v, |v, &length| by_length(v, length));
    volumes.iter().copied().map(all).collect()
}

/// Densities in terms of the point, as they are written and tidied.
fn of_the_point(g: &mut Graph, s: &Solution, volumes: &[Id]) -> Vec<Id> {
    let only = sorted::map(s.short.iter().map(|(l, v)| (g.get_leaf(*l), *v)));
    let mut names: Vec<(Id, Id)> = s.names.iter().map(|(name, value)| (*name, *value)).collect();
    sorted::sort_by_key(&mut names, |(_, value)| std::cmp::Reverse(cost(g, *value)));
    let mut forms = Vec::new();
    for &v in volumes {
        let p = g.powi(v, -1);
        let p = names.iter().fold(p, |p, &(name, value)| g.replace_part(p, value, name));
        for map in [&s.known, &only] {
            for known in recognised(g, p, map) {
                let mut direct = g.substitute(known, map);
                direct = g.substitute(direct, &only);
                let tidy = simplify(g, direct, None);
                forms.push(s.spell_out(g, direct));
                forms.push(s.spell_out(g, tidy));
            }
        }
    }
    forms
}

/// The density at each point that is tried: from the derivatives of the map where they tell it.
fn truth(
    problem: &mut Problem,
    s: &Solution,
    (form, sums): (Id, &Sums),
    cases: &[Case],
    measure: &mut Measure,
    injective: bool,
) -> Vec<f64> {
    // Among several preimages this one's share is known only where it is the one that was sampled.
    let known: Vec<bool> = match sums.pairs[..] {
        [] => vec![injective; cases.len()],
        _ => cases.iter().map(|case| injective || recovers(problem, s, case)).collect(),
    };
    let g = &mut problem.graph;
    let mut truth: Vec<f64> = match sums.pairs[..] {
        [] => measure.truths(g, form),
        // The length of a rounded direction is no news of it.
        _ => exact_values(g, form, cases),
    };
    let free = matches!(problem.parts[..], [part] if part.target == Target::Free);
    for ((t, c), _) in truth.iter_mut().zip(cases).zip(&known).filter(|(_, known)| **known) {
        let own = if c.volume > 0.0 { 1.0 / c.volume } else { f64::NAN };
        // What rounding the point does to its density is no error of a form, if any point is legal.
        if !(free && (*t - own).abs() <= ROUNDED * own) {
            *t = own;
        }
    }
    truth
}

/// The most accurate form and its worst error. Those that are dearer to find are looked for where none is accurate yet, or
/// the best is long.
fn most_accurate(
    problem: &mut Problem,
    s: &Solution,
    (candidates, sums): (Vec<Id>, &Sums),
    truth: &[f64],
    measure: &mut Measure,
) -> (Id, f64) {
    let g = &mut problem.graph;
    let mut all = candidates.clone();
    if pick(g, &candidates, truth, measure).1 > ACCURATE {
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
    sums.extend(g, &mut all);
    let (mut best, mut error) = pick(g, &all, truth, measure);
    if cost(g, best) > LONG || error > ACCURATE {
        crate::poly::refill_budget(8);
        let inverse = by_the_inverse(problem, s);
        all.extend(inverse);
        all.extend(inverse.into_iter().flat_map(|form| sums.by_one(&mut problem.graph, form)));
        sums.extend(&mut problem.graph, &mut all);
        (best, error) = pick(&mut problem.graph, &all, truth, measure);
    }
    let g = &mut problem.graph;
    match by_one_root(g, best) {
        Some(form) => pick(g, &[best, form], truth, measure),
        None => (best, error),
    }
}

/// The error up to which a form is accurate enough.
const ACCURATE: f64 = 64.0 * f64::EPSILON;

/// How much the rounding of a point may change its density, relatively.
const ROUNDED: f64 = 1e-3;

/// The cost of a density from which on the derivatives of the inverse are tried as well.
const LONG: usize = 40;

/// √(p²), where the square is free of roots that the expression has: products of several roots
/// simplify only together.
fn through_its_square(g: &mut Graph, p: Id) -> Option<Id> {
    let squared = g.powi(p, 2);
    let tidy = simplify(g, squared, None);
    (cost(g, tidy) < cost(g, squared)).then(|| g.sqrt(tidy))
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
