//! Borders of the support in terms of coordinates: where a coordinate goes from one value to another while an unknown
//! goes from 0 to 1, the coordinate itself tells whether that unknown lies in between, without any inverse.
//!
//! A coordinate that is continuous in an unknown takes all values between those at both ends; and none beyond if the
//! unknown is a function of it, for such a value would be taken twice.

use crate::eval::Evaluator;
use crate::expr::{Deps, Graph, Id, Leaf, Node, OUTS, UNKNOWNS, leaf_bit};
use crate::interval::Interval;
use crate::jacobian::cost;
use crate::number::{Dd, Number};
use crate::solve::Solution;

use super::cases::Case;
use super::continuity::{Approach, Limit, continuous, limit};
use super::{Preimage, Problem};

/// The values of a coordinate for which an unknown lies in [0, 1].
#[derive(Clone, Debug)]
pub struct Border {
    /// The coordinate.
    pub coordinate: Id,
    /// Where it goes as the unknown goes to 0, and to 1.
    pub ends: [Limit; 2],
    /// Whether it rises with the unknown; `None` where parameters decide.
    pub rising: Option<bool>,
}

impl Border {
    /// Whether no point has its coordinate beyond.
    pub(super) fn contains_all(&self, g: &Graph) -> bool {
        let (all, [a, b]) = (g.range(self.coordinate), self.ends.map(|end| range(g, end)));
        let lies = |low: Interval, high: Interval| low.hi <= all.lo && all.hi <= high.lo;
        lies(a, b) || lies(b, a)
    }

    /// All that is computed to see on which side of it a point lies.
    pub(super) fn expressions(&mut self) -> impl Iterator<Item = &mut Id> {
        let ends = self.ends.iter_mut().filter_map(|end| match end {
            Limit::At(id) => Some(id),
            Limit::Below | Limit::Above => None,
        });
        ends.chain([&mut self.coordinate])
    }
}

/// Finds the borders of the unknowns of a sampler's only preimage, which is that of the solution `s`; `forward` are the
/// coordinates in another form. Where parameters decide which end is the lower one, the place between them is what is
/// tested of a point next to them.
pub(super) fn find_borders(
    problem: &mut Problem,
    forward: &[Id],
    s: &Solution,
    cases: &[Case],
    preimage: &mut Preimage,
) {
    let n = problem.unknowns.len();
    // Given the coordinates that have been told, another one may depend on the unknowns behind them, too.
    let mut told: Vec<Told> = Vec::new();
    loop {
        let tries = (0..n).flat_map(|i| (0..forward.len()).map(move |k| (i, k)));
        let open =
            |(i, k): &(usize, usize)| told.iter().all(|t| *i != t.unknown && *k != t.coordinate);
        let mut tries = tries.filter(open);
        let next = tries.find_map(|(i, k)| {
            let forms = alone(problem, forward, s, (i, k), &told)?;
            let g = &mut problem.graph;
            let coordinate = g.get_leaf(Leaf::Out(k as u8));
            let (ends, rising) = ends(g, (coordinate, forms), problem.unknowns[i])?;
            let border = Border { coordinate, ends, rising };
            let held = cases.iter().all(|case| holds(g, &border, case));
            held.then_some(((i, k), border))
        });
        let Some(((i, k), border)) = next else { return };
        told.push(Told { unknown: i, coordinate: k, values: values(&problem.graph, &border) });
        if border.rising.is_some() {
            preimage.borders[i] = Some(border);
        } else if let Some(place) = place(&mut problem.graph, &border)
            && cost(&problem.graph, place) < cost(&problem.graph, preimage.tested[i])
        {
            preimage.tested[i] = place;
            preimage.borders[i] = Some(border);
        }
    }
}

/// The forms of coordinate `k`, if it depends on unknown `i`, and that on it, and else only on what has been told.
fn alone(
    problem: &mut Problem,
    forward: &[Id],
    s: &Solution,
    (i, k): (usize, usize),
    told: &[Told],
) -> Option<[Id; 2]> {
    let leaf = problem.unknowns[i];
    let both = |i: usize, k: usize| leaf_bit(problem.unknowns[i]) | leaf_bit(Leaf::Out(k as u8));
    let known = told.iter().fold(both(i, k), |known, t| known | both(t.unknown, t.coordinate));
    let g = &mut problem.graph;
    let inverse = *s.unknowns.get(&leaf)?;
    let only = |id: Id, of: Deps| g.has(id, of & known) && !g.has(id, of & !known);
    if !only(problem.outputs[k], UNKNOWNS) || !only(inverse, OUTS) {
        return None;
    }
    // A coordinate that has been told is as good as any number between its ends.
    let mut forms = [problem.outputs[k], forward[k]];
    for t in told {
        let stand_in = Leaf::Unknown(STAND_INS + t.coordinate as u8);
        let stand_in = g.leaf(stand_in, "told", t.values);
        for form in &mut forms {
            *form = g.replace_part(*form, problem.outputs[t.coordinate], stand_in);
        }
    }
    Some(forms)
}

/// The first of the unknowns that stand for coordinates.
const STAND_INS: u8 = 16;

/// A coordinate that tells whether an unknown lies in [0, 1], and what values it has then.
struct Told {
    unknown: usize,
    coordinate: usize,
    values: Interval,
}

/// The values between two ends.
fn values(g: &Graph, border: &Border) -> Interval {
    range(g, border.ends[0]).hull(range(g, border.ends[1]))
}

/// Where an end lies.
fn range(g: &Graph, end: Limit) -> Interval {
    match end {
        Limit::At(id) => g.range(id),
        Limit::Below => Interval::point(f64::NEG_INFINITY),
        Limit::Above => Interval::point(f64::INFINITY),
    }
}

/// Where a `coordinate`, which is equal to these `forms`, goes as an unknown goes to 0 and to 1, and whether it rises, if
/// that is known.
fn ends(
    g: &mut Graph,
    (coordinate, forms): (Id, [Id; 2]),
    unknown: Leaf,
) -> Option<([Limit; 2], Option<bool>)> {
    let form = forms.into_iter().find(|&form| continuous(g, form, unknown))?;
    let bounded = g.range(coordinate).width().is_finite();
    let mut to = |end| limit(g, form, Approach { unknown, end, bounded });
    let ends = [to(0)?, to(1)?];
    let short = |end: Limit| match end {
        Limit::At(id) => !g.has(id, UNKNOWNS | OUTS) && is_short(g, id),
        _ => true,
    };
    if !ends.into_iter().all(short) {
        return None;
    }
    let rising = match ends {
        [Limit::Below, _] | [_, Limit::Above] => Some(true),
        [Limit::Above, _] | [_, Limit::Below] => Some(false),
        [Limit::At(a), Limit::At(b)] => {
            let width = g.sub(b, a);
            let range = g.range(width);
            (range.nonnegative() || range.nonpositive()).then_some(range.nonnegative())
        }
    };
    Some((ends, rising))
}

/// Where a coordinate lies between its ends, from 0 to 1.
fn place(g: &mut Graph, border: &Border) -> Option<Id> {
    let [Limit::At(a), Limit::At(b)] = border.ends else { return None };
    let (from, width) = (g.sub(border.coordinate, a), g.sub(b, a));
    Some(g.div(from, width))
}

/// Whether an expression is a parameter, a number or one times the other.
fn is_short(g: &Graph, id: Id) -> bool {
    match g.node(id) {
        Node::Leaf(_) | Node::Number(_) | Node::Float(_) | Node::Pi => true,
        Node::Sum(c, terms) => c.is_zero() && terms.len() == 1 && is_short(g, terms[0].1),
        _ => false,
    }
}

/// Whether a coordinate of a point that was tried lies between the ends, but for rounding.
fn holds(g: &Graph, border: &Border, case: &Case) -> bool {
    let at = |l: Leaf| match l {
        Leaf::Out(i) => case.exact_outs[i as usize],
        _ => case.point.input(l, &[]),
    };
    let mut e = Evaluator::<Dd>::new(g, &at);
    let x = e.value(border.coordinate).to_f64();
    let [a, b] = border.ends.map(|end| match end {
        Limit::At(id) => e.value(id).to_f64(),
        Limit::Below => f64::NEG_INFINITY,
        Limit::Above => f64::INFINITY,
    });
    let slack = 1e-9 * x.abs();
    a != b && x >= a.min(b) - slack && x <= a.max(b) + slack
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Fun;
    use crate::rational::Q;

    #[test]
    fn a_line_between_two_parameters() {
        let mut g = Graph::new();
        let leaf = Leaf::Unknown(0);
        let u = g.leaf(leaf, "u", Interval::new(0.0, 1.0));
        let [a, b] = [0, 1].map(|i| g.leaf(Leaf::Param(i), "p", Interval::ALL));
        let x = g.leaf(Leaf::Out(0), "x", Interval::ALL);
        let rest = g.sum(Q::ONE, &[(Q::int(-1), u)]);
        let (from, to) = (g.mul(a, rest), g.mul(b, u));
        let line = g.add(from, to);
        let expected = Some(([Limit::At(a), Limit::At(b)], None));
        assert_eq!(ends(&mut g, (x, [line; 2]), leaf), expected);
        let width = g.sub(b, a);
        g.assume(width, Interval::POSITIVE);
        let expected = Some(([Limit::At(a), Limit::At(b)], Some(true)));
        assert_eq!(ends(&mut g, (x, [line; 2]), leaf), expected);
        // The cosine of an angle in between depends on the parameters in a longer way.
        let cosine = g.call(Fun::Cos, &[line]);
        assert_eq!(ends(&mut g, (x, [cosine; 2]), leaf), None);
    }
}
