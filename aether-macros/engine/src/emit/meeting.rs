//! Pieces of the real line that meet: one goes on where the other ends.

use super::pieces::Place;
use crate::eval::evaluate;
use crate::expr::Leaf;
use crate::number::{Dd, Number};
use crate::points::sampler_points;

/// How far the ends of two pieces may be apart in double-double, relative to them.
const CLOSE: f64 = 1e-20;

/// Whether two pieces of a map of one uniform to the line both rise or both fall, and one starts where the other ends: then
/// no point has both preimages, but the one where they meet.
pub(super) fn meet(one: &Place, other: &Place) -> bool {
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
    let kinds = &one.problem.kinds;
    let points = sampler_points(1, kinds, false, &|_| true);
    let ends = |end: f64, place: &Place| -> Vec<Dd> {
        let g = &place.problem.graph;
        let at = |point: &crate::points::Point| {
            evaluate::<Dd>(g, place.problem.outputs[0], &|leaf| match leaf {
                Leaf::Unknown(_) => Dd::from_f64(end),
                leaf => point.input(leaf, &[]),
            })
        };
        points.iter().filter(|p| !p.stress).map(at).collect()
    };
    let joined = |first: &Place, second: &Place| {
        let (ends, starts) = (ends(1.0, first), ends(0.0, second));
        let close = |(a, b): (&Dd, &Dd)| {
            let gap = (*a - *b).abs().to_f64();
            gap <= CLOSE * b.abs().to_f64()
        };
        ends.iter().zip(&starts).all(close)
    };
    joined(one, other) || joined(other, one)
}
