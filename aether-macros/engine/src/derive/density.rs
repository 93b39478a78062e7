//! The density and the volume in the form that is measured to be best.

use std::collections::BTreeMap;

use super::cases::{Case, exact_values, recovers};
use super::factored::factored;
use super::holding::never_negative;
use super::near_one::by_the_rest;
use super::one_root::by_one_root;
use super::opened::opened;
use super::opposed::{Pair, without_length};
use super::parts::Whole;
use super::regimes::{best_coordinates, best_forms};
use super::units::{Stretched, by_one, by_the_other_side, by_the_others};
use super::valued::merged;
use super::{Preimage, Problem, Target};
use crate::derivative::derivative;
use crate::expr::{Fun, Graph, Id, Leaf, Node, OUTS, UNKNOWNS, children};
use crate::jacobian::{cost, cost_together, simplify};
use crate::measure::{Errors, Loss, Measure, Part};
use crate::number::Number;
use crate::overflow::guard;
use crate::points::Kind;
use crate::poly::Expander;
use crate::rational::Q;
use crate::solve::Solution;
use crate::solve::linear::determinant;
use crate::sorted;
use crate::stabilise::{over_sum, stabilise};

/// The cheapest among the most accurate expressions.
pub(super) fn pick(
    g: &mut Graph,
    candidates: &[Id],
    truth: &[f64],
    measure: &mut Measure,
) -> (Id, f64) {
    let errors: Vec<Errors> = candidates.iter().map(|&c| measure.errors(g, c, truth)).collect();
    // Points at which no form has a value say nothing of which is better.
    let told: Vec<bool> =
        (0..truth.len()).map(|k| errors.iter().any(|e| !e.is_unknown(k))).collect();
    let losses = errors.iter().map(|e| e.loss_where(&told, true));
    let mut scored: Vec<(Id, Loss, usize)> =
        candidates.iter().zip(losses).map(|(&c, loss)| (c, loss, cost(g, c))).collect();
    // What counts first is double precision; single tells those apart that are as good in it.
    for part in 0..2 {
        let least = |f: &dyn Fn(Part) -> f64| {
            scored.iter().map(|s| f(s.1.parts()[part])).fold(f64::INFINITY, f64::min)
        };
        let (bits, worst) = (least(&|l| l.bits), least(&|l| l.worst).max(16.0 * f64::EPSILON));
        let good = |l: Part| l.bits <= bits + 1.0 && l.worst <= 4.0 * worst;
        if scored.iter().any(|s| good(s.1.parts()[part])) {
            scored.retain(|s| good(s.1.parts()[part]));
        }
    }
    // Of those that cost the same, one that multiplies by fewer numbers.
    let least = scored.iter().map(|s| s.2).min();
    scored.retain(|s| Some(s.2) == least);
    let best = scored.iter().min_by_key(|s| coefficients(g, s.0));
    best.map_or((candidates[0], f64::INFINITY), |s| (s.0, s.1.worst()))
}

/// How many terms of sums are multiplied by a number.
fn coefficients(g: &Graph, id: Id) -> usize {
    let multiplied = |id: Id| match g.node(id) {
        Node::Sum(_, terms) => terms.iter().filter(|(q, _)| q.abs() != Q::ONE).count(),
        _ => 0,
    };
    g.within(&[id]).into_iter().map(multiplied).sum()
}

/// Coordinates one by one in their most accurate form: as written, tidied or stabilised.
pub(super) fn accurate(
    g: &mut Graph,
    written: &[Id],
    tidied: &[Id],
    measure: &mut Measure,
) -> Vec<Id> {
    let mut best = |(&written, &tidied): (&Id, &Id)| {
        let truth = measure.truths(g, written);
        let forms = [written, tidied, stabilise(g, tidied, measure)];
        pick(g, &forms, &truth, measure).0
    };
    written.iter().zip(tidied).map(&mut best).collect()
}

/// What is known of sums of the coordinates and of their squares.
pub(super) struct Sums<'a> {
    /// The combination of coordinates that is one.
    pub whole: Option<&'a Whole>,
    /// The places of coordinates that are together a unit vector.
    pub units: Vec<Vec<u8>>,
    /// Coordinates that are together a unit vector over known lengths.
    pub stretched: Vec<Stretched>,
    /// The point with each of the parameters that are unit vectors.
    pub pairs: Vec<Pair>,
    /// Directions are simplified by their length wherever that pays, before forms are chosen.
    pub is_direction: bool,
}

impl Sums<'_> {
    /// Adds to some forms those in which sums of two unit vectors are free of the errors of their lengths.
    fn extend(&self, g: &mut Graph, forms: &mut Vec<Id>) {
        let freed: Vec<Id> =
            forms.iter().filter_map(|&form| without_length(g, form, &self.pairs)).collect();
        forms.extend(freed);
    }

    /// Forms of an expression of the point in which constants are what coordinates, or their squares, add up to, or parts of
    /// lengths are told by the rest.
    fn put_into(&self, g: &mut Graph, id: Id) -> Vec<Id> {
        let mut forms = vec![];
        if let Some(whole) = self.whole {
            let normal = Expander::new(g).normal_form(id);
            let both = [Some(id), normal].into_iter().flatten();
            forms.extend(both.map(|form| whole.put_into(g, form)));
        }
        if !self.is_direction {
            forms.extend(by_the_others(g, id, &self.units));
            forms.extend(by_the_other_side(g, id, &self.units));
            forms.extend(self.stretched.iter().filter_map(|s| s.by_the_others(g, id)));
        }
        forms.extend(by_the_rest(g, id));
        forms
    }

    /// Forms of an expression of a direction in which the squares of two coordinates are told by the third.
    fn by_one(&self, g: &mut Graph, id: Id) -> Vec<Id> {
        let units = self.units.iter().filter(|_| self.is_direction);
        let each = units.flat_map(|unit| unit.iter().map(move |&x| (unit, x)));
        each.filter_map(|(unit, x)| by_one(g, id, unit, x)).collect()
    }
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

/// The density in terms of the outputs, in its most accurate form.
pub(super) fn density(
    problem: &mut Problem,
    s: &Solution,
    (volumes, sums): (&[Id], &Sums),
    cases: &[Case],
    measure: &mut Measure,
    injective: bool,
) -> Id {
    // Among several preimages this one's share is known only where it is the one that was sampled.
    let known: Vec<bool> = match sums.pairs[..] {
        [] => vec![injective; cases.len()],
        _ => cases.iter().map(|case| injective || recovers(problem, s, case)).collect(),
    };
    let g = &mut problem.graph;
    let only = sorted::map(s.short.iter().map(|(l, v)| (g.get_leaf(*l), *v)));
    let mut candidates = Vec::new();
    let mut names: Vec<(Id, Id)> = s.names.iter().map(|(name, value)| (*name, *value)).collect();
    sorted::sort_by_key(&mut names, |(_, value)| std::cmp::Reverse(cost(g, *value)));
    let by_lengths = volumes.iter().map(|&v| {
        problem.lengths.iter().fold(v, |v, &(part, length)| {
            let minus = g.neg(length);
            let [short, other] = [length, minus].map(|l| g.replace_part(v, part, l));
            // Of the part only the size is known: the sign must not matter.
            if short == other { short } else { v }
        })
    });
    // Most have no such part, and are taken once.
    let mut forms: Vec<Id> = by_lengths.filter(|v| !volumes.contains(v)).collect();
    forms.extend(volumes);
    for v in forms {
        let p = g.powi(v, -1);
        let p = names.iter().fold(p, |p, &(name, value)| g.replace_part(p, value, name));
        for map in [&s.known, &only] {
            for known in recognised(g, p, map) {
                let mut direct = g.substitute(known, map);
                direct = g.substitute(direct, &only);
                let tidy = simplify(g, direct, None);
                candidates.push(s.spell_out(g, direct));
                candidates.push(s.spell_out(g, tidy));
            }
        }
    }
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
    let mut truth: Vec<f64> = match sums.pairs[..] {
        [] => measure.truths(g, candidates[0]),
        // The length of a rounded direction is no news of it.
        _ => exact_values(g, candidates[0], cases),
    };
    {
        let free = matches!(problem.parts[..], [part] if part.target == Target::Free);
        for ((t, c), _) in truth.iter_mut().zip(cases).zip(&known).filter(|(_, known)| **known) {
            let own = if c.volume > 0.0 { 1.0 / c.volume } else { f64::NAN };
            // What rounding the point does to its density is no error of a form, if any point is legal.
            if !(free && (*t - own).abs() <= ROUNDED * own) {
                *t = own;
            }
        }
    }
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
    sums.extend(g, &mut all);
    let (mut best, mut error) = pick(g, &all, &truth, measure);
    if cost(g, best) > LONG || error > 64.0 * f64::EPSILON {
        crate::poly::refill_budget(8);
        let inverse = by_the_inverse(problem, s);
        all.extend(inverse);
        all.extend(inverse.into_iter().flat_map(|form| sums.by_one(&mut problem.graph, form)));
        sums.extend(&mut problem.graph, &mut all);
        (best, error) = pick(&mut problem.graph, &all, &truth, measure);
    }
    let g = &mut problem.graph;
    if let Some(form) = by_one_root(g, best) {
        (best, error) = pick(g, &[best, form], &truth, measure);
    }
    if error > 64.0 * f64::EPSILON {
        best = best_forms(g, best, &sums.units, &truth, measure);
    }
    guard(g, best)
}

/// How much the rounding of a point may change its density, relatively.
const ROUNDED: f64 = 1e-3;

/// The cost of a density from which on the derivatives of the inverse are tried as well.
const LONG: usize = 40;

/// The density as the determinant of the derivatives of the inverse; on a sphere, the volume that their
/// gradients span with the normal.
fn by_the_inverse(problem: &mut Problem, s: &Solution) -> Option<Id> {
    let n = problem.unknowns.len();
    let direction = problem.is_direction() && n == 2;
    let free = matches!(problem.parts[..], [part] if part.target == Target::Free);
    if problem.argument.is_some() || !(direction || free && problem.outputs.len() == n && n < 4) {
        return None;
    }
    let g = &mut problem.graph;
    let outs: Vec<Leaf> = (0..problem.outputs.len() as u8).map(Leaf::Out).collect();
    let mut rows = Vec::new();
    for unknown in &problem.unknowns {
        let value = *s.unknowns.get(unknown)?;
        rows.push(outs.iter().map(|&x| derivative(g, value, x)).collect::<Vec<Id>>());
    }
    let unit = if direction { Some([0, 1, 2].map(|k| g.get_leaf(outs[k]))) } else { None };
    rows.extend(unit.map(|w| w.to_vec()));
    let spanned = determinant(g, &rows);
    let spanned = simplify(g, spanned, unit);
    let widths: Vec<Id> = problem.segments.iter().flatten().map(|s| s.width).collect();
    let density = widths.into_iter().fold(spanned, |product, w| g.mul(product, w));
    (!divides_by_zero(g, density)).then(|| g.call(Fun::Abs, &[density]))
}

/// Whether a divisor depends on the point and may vanish.
fn divides_by_zero(g: &Graph, id: Id) -> bool {
    let divisor = |&(b, e): &(Id, Id)| {
        let range = g.range(b);
        let vanishes = range.lo <= 0.0 && range.hi >= 0.0;
        vanishes && g.has(b, OUTS) && g.as_number(e).is_none_or(|q| q.is_negative())
    };
    match g.node(id) {
        Node::Product(f) if f.iter().any(divisor) => true,
        node => children(node).into_iter().any(|c| divides_by_zero(g, c)),
    }
}

/// An expression with what a solution knows of more than single unknowns put in, the longest first:
/// it must be done while the unknowns that it is recognised by are there. It may also be recognised by its powers, which
/// is another form if there are any.
pub(super) fn recognised(g: &mut Graph, written: Id, known: &BTreeMap<Id, Id>) -> Vec<Id> {
    let mut composed = known.clone();
    composed.retain(|id, _| !matches!(g.node(*id), Node::Leaf(_)));
    let mut longest: Vec<(Id, Id)> = composed.iter().map(|(part, value)| (*part, *value)).collect();
    sorted::sort_by_key(&mut longest, |(part, _)| std::cmp::Reverse(cost(g, *part)));
    let mut forms = Vec::new();
    for by in [Graph::replace_part, Graph::replace_powers] {
        let mut id = written;
        // What one replacement uncovers another may know.
        for _ in 0..2 {
            for &(part, value) in &longest {
                id = by(g, id, part, value);
            }
            id = g.substitute(id, &composed);
        }
        forms.push(id);
    }
    forms.dedup();
    forms
}

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
    (density, sums): (Id, &Sums),
    cases: &[Case],
    measure: &mut Measure,
    conditions: &[Id],
) -> Preimage {
    let g = &mut problem.graph;
    let picked: Vec<[Id; 2]> = problem
        .unknowns
        .iter()
        .enumerate()
        .map(|(i, l)| {
            let best = stabilise(g, s.unknowns[l], measure);
            let mut forms = sums.put_into(g, s.unknowns[l]);
            forms.extend(opened(g, s.unknowns[l]));
            let truth: Vec<f64> = cases.iter().map(|c| c.point.unknowns[i].to_f64()).collect();
            forms.push(best);
            let without = pick(g, &forms, &truth, measure).0;
            sums.extend(g, &mut forms);
            [without, pick(g, &forms, &truth, measure).0]
        })
        .collect();
    // What sums of unit vectors tell is free of the errors of their lengths in all unknowns, or in none: where two vectors
    // are nearly opposite, each unknown may be off along a direction of its own.
    let together = picked.iter().any(|[without, best]| without != best);
    let is_map = problem.argument == Some(Kind::Direction);
    let mut stable: Vec<Id> = Vec::new();
    for [without, best] in picked {
        // The coordinates of a direction have its length in common as well, so that they need the same form.
        let is_to_be_freed = together && (is_map || without == best);
        let freed = is_to_be_freed.then(|| without_length(g, without, &sums.pairs)).flatten();
        stable.push(freed.unwrap_or(best));
    }
    let found: Vec<Id> = problem.unknowns.iter().map(|l| s.unknowns[l]).collect();
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
            let truth: Vec<f64> = cases.iter().map(|c| c.point.unknowns[i].to_f64()).collect();
            *value = telling(g, (*value, unknowns[i]), &truth, measure);
        }
    }
    let map =
        sorted::map(problem.unknowns.iter().zip(&unknowns).map(|(l, v)| (g.get_leaf(*l), *v)));
    // The unknowns themselves as accurate as they can be had: a short form may say nothing of how far they are from zero.
    let composed = {
        let is_composed = |id: Id| !matches!(g.node(id), Node::Leaf(_));
        sorted::map(s.known.iter().filter(|(id, _)| is_composed(**id)).map(|(id, v)| (*id, *v)))
    };
    let requirements = problem
        .requirements
        .iter()
        .map(|&r| {
            let known = g.substitute(r, &composed);
            let known = s.spell_out(g, known);
            let known = g.substitute(known, &map);
            let known = shares(g, known);
            if g.has(known, UNKNOWNS) { g.substitute(r, &map) } else { known }
        })
        .chain(s.pieces.iter().flat_map(|p| p.widths.iter().copied()))
        .collect();
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
        let truth: Vec<f64> = cases.iter().map(|c| c.point.unknowns[i].to_f64()).collect();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpret::Item;
    use crate::interval::Interval;
    use crate::measure::Inputs;

    #[test]
    fn points_that_no_form_tells_do_not_hide_which_is_accurate() {
        let mut g = Graph::new();
        let x = g.leaf(Leaf::Out(0), "x", Interval::new(0.0, 1.0));
        let one = g.int(1);
        let more = g.add(one, x);
        // ln(1 + x) / x, and the same without cancellation: both are 0/0 at zero.
        let [short, accurate] = [(Fun::Ln, more), (Fun::Ln1p, x)].map(|(f, argument)| {
            let log = g.call(f, &[argument]);
            g.div(log, x)
        });
        let points: Vec<Inputs> =
            [0.0, 1e-12].map(|x| Inputs::from_iter([(Leaf::Out(0), x)])).to_vec();
        let mut measure = Measure::new(points, vec![]);
        let picked = pick(&mut g, &[short, accurate], &[1.0, 1.0 - 5e-13], &mut measure);
        assert_eq!(picked.0, accurate);
    }

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
