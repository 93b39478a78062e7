//! Pieces that meet: one goes on where the other ends; and pieces that no parameters leave both.

use super::pieces::Place;
use crate::derive::Problem;
use crate::eval::evaluate;
use crate::expr::Leaf;
use crate::number::{Dd, Number};
use crate::parse::Test;
use crate::points::{Point, sampler_points};

/// How far the ends of two pieces may be apart in double-double, relative to them.
const CLOSE: f64 = 1e-20;
/// How far rounding may put the end of a range.
const ROUNDED: f64 = 8.0 * f64::EPSILON;

/// Which pieces meet or have no parameters in common, by their numbers.
pub type Known = core::cell::RefCell<crate::hash::Map<(usize, usize), bool>>;

/// Whether two pieces [meet](meet) or have no parameters in common, found out once.
pub(super) fn known(known: &Known, one: &Place, other: &Place) -> bool {
    let pair = (one.piece, other.piece);
    let found = known.borrow().get(&pair).copied();
    found.unwrap_or_else(|| {
        let found = opposed(one, other) || meet(one, other);
        known.borrow_mut().extend([(pair, found), ((pair.1, pair.0), found)]);
        found
    })
}

/// Whether the parameters that leave one piece any points are none that leave the other one any: one asks for what the other
/// one denies.
fn opposed(one: &Place, other: &Place) -> bool {
    let [asked, denied] = [one, other].map(|place| &place.problem.existence);
    if asked.is_empty() || denied.is_empty() {
        return false;
    }
    let mut g = one.problem.graph.clone();
    // Roots are no expressions of another graph.
    let plain = |test: &&Test| !other.problem.graph.is_numerical(test.difference);
    denied.iter().filter(plain).any(|test| {
        let difference = g.import(&other.problem.graph, test.difference);
        let opposite = Test { difference: g.neg(difference), strict: !test.strict };
        asked.contains(&opposite)
    })
}

/// Points of different parameters.
fn parameters(place: &Place) -> Vec<Point> {
    let Problem { kinds, made, graph, .. } = place.problem;
    sampler_points(1, kinds, !made.is_empty(), &|point| made.complete(graph, point))
}

/// Whether two pieces have a border in common, as one of them takes a uniform from where the other one leaves it.
pub(super) fn adjacent(one: &Place, other: &Place) -> bool {
    let points = parameters(one);
    let points: Vec<&Point> = points.iter().filter(|p| !p.stress).collect();
    let end = |place: &Place, i: usize, share: f64, point: &Point| {
        let segment = place.problem.segments[i]?;
        let at = |id| evaluate::<Dd>(&place.problem.graph, id, &|leaf| point.input(leaf, &[]));
        Some(at(segment.low) + at(segment.width) * Dd::from_f64(share))
    };
    let joined = |first: &Place, second: &Place, i: usize| {
        points.iter().all(|p| match (end(first, i, 1.0, p), end(second, i, 0.0, p)) {
            (Some(end), Some(start)) => {
                let gap = (end - start).abs().to_f64();
                gap <= CLOSE * start.abs().to_f64()
            }
            _ => false,
        })
    };
    let both = one.problem.segments.len().min(other.problem.segments.len());
    one.piece != other.piece && (0..both).any(|i| joined(one, other, i) || joined(other, one, i))
}

/// Whether one of two pieces takes a uniform from zero and the other one may take it to one, where both are turned alike: if
/// their images have that border in common, as the first and the last slice of a cake have, they lie on two sides of it.
pub(super) fn around(one: &Place, other: &Place) -> bool {
    let alike =
        one.derived.orientation.is_some() && one.derived.orientation == other.derived.orientation;
    let closes = |first: &Place, last: &Place, i: usize| {
        let ends = [first, last].map(|place| {
            let g = &place.problem.graph;
            place.problem.segments[i].map(|s| (g.range(s.low), g.range(s.width)))
        });
        let [Some((low, _)), Some((start, width))] = ends else { return false };
        // Ranges are rounded: five sixths and a sixth are less than one.
        low.hi <= 0.0 && start.add(width).hi >= 1.0 - ROUNDED
    };
    let both = one.problem.segments.len().min(other.problem.segments.len());
    one.piece != other.piece
        && alike
        && (0..both).any(|i| closes(one, other, i) || closes(other, one, i))
}

/// Whether two pieces of a map of one uniform to the line both rise or both fall, and one starts where the other ends: then
/// no point has both preimages, but the one where they meet.
fn meet(one: &Place, other: &Place) -> bool {
    let simple = |place: &&Place| {
        let p = place.problem;
        let line = (p.unknowns.len(), p.outputs.len()) == (1, 1) && p.argument.is_none();
        line && p.guards.is_empty() && p.segments.iter().all(Option::is_some)
    };
    let alike =
        one.derived.orientation.is_some() && one.derived.orientation == other.derived.orientation;
    if !alike || ![one, other].iter().all(simple) {
        return false;
    }
    let points = parameters(one);
    let image = |end: f64, place: &Place, point: &Point| {
        let g = &place.problem.graph;
        evaluate::<Dd>(g, place.problem.outputs[0], &|leaf| match leaf {
            Leaf::Unknown(_) => Dd::from_f64(end),
            leaf => point.input(leaf, &[]),
        })
    };
    let joined = |first: &Place, second: &Place| {
        points.iter().filter(|p| !p.stress).all(|p| {
            let (end, start) = (image(1.0, first, p), image(0.0, second, p));
            let gap = (end - start).abs().to_f64();
            // An infinite end meets nothing: what goes on from the other infinity comes by all points again.
            gap.is_finite() && gap <= CLOSE * start.abs().to_f64()
        })
    };
    joined(one, other) || joined(other, one)
}
